"""identify, predict with its estimate, and diagnose given it say one number of one log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm
from support import data_folder, sampled

import symgen
from symgen.identification.estimate import Estimate
from symgen.identification.prediction import torque_errors
from symgen.report.store import result_files

ROBOTS = {"emps": ".csv", "ur10": ".csv", "dp_c0": ".npz"}


@pytest.fixture(scope="module", params=sampled(ROBOTS, 0, always=["emps"]))
def found(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Estimate, Path]:
    """The folder of a robot's logs, its default estimate, and the file that identify writes."""
    folder, suffix = data_folder() / request.param, ROBOTS[request.param]
    estimate = symgen.identify(
        folder / "robot.toml", folder / f"train{suffix}", validation=folder / f"test{suffix}"
    )
    into = tmp_path_factory.mktemp(request.param)
    for name, content in result_files(estimate).items():
        (into / name).write_bytes(content)
    return folder, estimate, into / "estimate.json"


def test_the_estimate_says_it_of_its_own_torques(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, _ = found
    said = estimate.torque_validation
    assert said is not None
    assert said.per_joint is not None
    (trace,) = [t for t in estimate.traces if t.quantity == "torque" and t.kind == "validation"]
    left, size = (
        np.linalg.norm(x, axis=0) for x in (trace.measured - trace.predicted, trace.measured)
    )
    print(f"{folder.name}: {said.relative:.4f}, {np.round(said.per_joint, 4)}")
    np.testing.assert_allclose(said.per_joint, left / size, rtol=0, atol=1e-9)
    stacked = np.linalg.norm(left) / np.linalg.norm(size)
    assert said.relative == pytest.approx(stacked, rel=0, abs=1e-9)


def test_predict_says_what_identify_says(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, file = found
    prediction = symgen.predict(folder / "robot.toml", folder / f"test{ROBOTS[folder.name]}", file)
    said = estimate.torque_validation
    assert said is not None
    assert prediction.band == estimate.band
    np.testing.assert_allclose(prediction.error.per_joint, said.per_joint, rtol=0, atol=1e-9)
    assert prediction.error.relative == pytest.approx(said.relative, rel=0, abs=1e-9)


def test_diagnose_says_what_identify_says(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, file = found
    suffix = ROBOTS[folder.name]
    diagnosis = symgen.diagnose(
        folder / "robot.toml",
        folder / f"train{suffix}",
        validation=[folder / f"test{suffix}"],
        parameters=file,
        effects=["gravity_spring"],
    )
    said = estimate.torque_validation
    assert said is not None
    assert said.per_joint is not None
    np.testing.assert_allclose(diagnosis.before.per_joint, said.per_joint, rtol=0, atol=1e-9)
    assert diagnosis.before.total == pytest.approx(said.relative, rel=0, abs=1e-9)


@pytest.mark.slow
def test_other_commands_shift_the_torques_as_the_estimate_did(tmp_path: Path) -> None:
    robot = symgen.parse_robot(planar2r.robot_toml("late", 'friction = ["viscous"]'), "late.toml")
    logs, mass = [], 1.5
    for seed, load in ((3, 0.0), (4, 0.0), (5, mass)):
        rng = np.random.default_rng(seed)
        t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
        arm = Arm(np.array([3.7, 0.8, 1.2, 0.3]), FV=np.array([8.0, 2.0]))
        tau = arm.carrying(load, at=0.2).torque(q, qd, qdd)
        late = np.column_stack([np.interp(t - 0.02, t, x) for x in tau.T])
        late += 1e-3 * tau.std(axis=0) * rng.normal(size=tau.shape)
        logs.append(symgen.make_log(f"log {seed}", t, q, late, qd))
    *logs, carries = logs
    found = symgen.identify(robot, logs[0], validation=logs[1])
    assert found.torque_validation is not None
    symgen.write(found, tmp_path / "result", robot=robot)
    again = symgen.predict(robot, logs[1], tmp_path / "result")
    assert again.error.relative == pytest.approx(found.torque_validation.relative, rel=0.02)
    assert [(r.log, r.channel, r.done) for r in again.repairs] == [("log 4", "tau", "shifted")]
    (same,) = torque_errors(robot, logs[1], [found.X], found.band, found.shifts)
    assert same == pytest.approx(again.moving.relative, rel=1e-9)
    load = symgen.payload(robot, carries, parameters=tmp_path / "result")
    assert load.mass.value is not None
    assert load.mass.std is not None
    assert load.mass.value == pytest.approx(mass, abs=3 * load.mass.std)
    assert load.mass.std < 0.01 * mass
    assert load.residual.after < 0.01
    assert [(r.log, r.channel, r.done) for r in load.repairs] == [("log 5", "tau", "shifted")]


LIFT = """
[robot]
name = "lift"
gravity = [0.0, 0.0, -9.81]

[[joint]]
sigma = 1

[[joint]]
alpha = "pi/2"

[limits]
position = [[0.0, 0.4], [-2.0, 2.0]]
velocity = [0.5, 3.0]
"""


def test_the_force_of_a_lift_does_not_hide_the_torque_error_of_its_arm(tmp_path: Path) -> None:
    """The lift carries 600 N and is known well; the friction of joint 2 is not."""
    robot = symgen.parse_robot(LIFT)
    X = {"M1R": 60.0, "IA1": 5.0, "FS1": 20.0, "FV1": 30.0, "ZZ2R": 0.9, "MX2": 0.9, "MY2": 0.04,
         "FS2": 1.0, "FV2": 2.0}  # fmt: skip
    recording = symgen.Recording(rate=100.0)
    log = symgen.simulate(robot, X, recording=recording, duration=6.0, seed=1).log(0)
    known = X | {"FV2": 0.0, "FS1": 19.0}
    rows = "\n".join(f"{name} = {value}" for name, value in known.items())
    (tmp_path / "known.toml").write_text(f"[parameters]\n{rows}\n")
    found = symgen.predict(robot, log, tmp_path / "known.toml")
    error = np.sum((found.torque.measured - found.torque.predicted) ** 2, axis=0)
    size = np.sum(found.torque.measured**2, axis=0)
    print(
        f"N and N m added: {np.sqrt(error.sum() / size.sum()):.4f}, by joint", found.error.per_joint
    )
    assert np.sqrt(error.sum() / size.sum()) < 0.01
    assert found.error.per_joint[1] > 0.2
    assert found.error.relative == found.error.per_joint[1]
    assert found.moving.relative == found.moving.per_joint[1]
