"""Torques that lack friction or weight of the robot, and a validation log that is a copy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm, X

import symgen

ROBOT = planar2r.robot_toml(
    "arm", 'friction = ["coulomb", "viscous"]\nrotor_inertia = false', "[0.0, -9.81, 0.0]"
)
ARM = Arm(X, MX1R=3.0, g=9.81, FS=np.array([3.0, 0.4]), FV=np.array([2.0, 0.2]))
WITHOUT_FRICTION = replace(ARM, FS=0.0, FV=0.0)


def motion(seed: int) -> tuple[np.ndarray, ...]:
    return tuple(x[::2] for x in planar2r.harmonic_motion(np.random.default_rng(seed), seed))


def file_with_values(folder: Path, arm: Arm = ARM) -> Path:
    """Write the robot file and, as `symgen import` does, its parameters."""
    values = (f"{name} = {value}" for name, value in arm.values.items() if name != "IA2")
    (folder / "arm_parameters.toml").write_text("\n".join(["[parameters]", "MY1 = 0.0", *values]))
    path = folder / "arm.toml"
    path.write_text(ROBOT)
    return path


def written(path: Path, seed: int, arm: Arm, noise: float, name: str = "tau", weight=1.0) -> Path:
    """Write a log whose torque columns have a name, with a part of the weight."""
    t, q, qd, qdd = motion(seed)
    tau = arm.torque(q, qd, qdd) - (1 - weight) * ARM.weight(q)
    rng = np.random.default_rng(seed)
    tau = tau + noise * tau.std(axis=0) * rng.normal(size=tau.shape)
    q = q + 1e-6 * rng.normal(size=q.shape)
    head = f"t,q1,q2,qd1,qd2,{name}_1,{name}_2" if name != "tau" else "t,q1,q2,qd1,qd2,tau1,tau2"
    np.savetxt(path, np.column_stack([t, q, qd, tau]), "%.9g", ",", header=head, comments="")
    return path


def identified(folder: Path, robot: Path, arm: Arm, noise: float, name="tau", weight=1.0):
    train, held = (
        written(folder / f"{seed}.csv", seed, arm, noise, name, weight) for seed in (3, 4)
    )
    columns = {} if name == "tau" else {"tau": f"{name}_*"}
    reading = symgen.Reading(columns=columns)
    found = symgen.identify(robot, train, validation=held, model="torque", reading=reading)
    return found.verdict, {r.kind for r in found.reasons}, {r.kind for r in found.suspected}


def test_a_feed_forward_is_a_fault_where_the_file_states_friction(tmp_path) -> None:
    robot = file_with_values(tmp_path)
    assert identified(tmp_path, robot, WITHOUT_FRICTION, 0.0) == (
        "doubtful", {"computed_torque"}, {"little_friction"},
    )  # fmt: skip


def test_diagnose_gives_the_reasons_of_identify(tmp_path) -> None:
    robot = file_with_values(tmp_path)
    train, held = (written(tmp_path / f"{k}.csv", k, WITHOUT_FRICTION, 0.0) for k in (3, 4))
    found = symgen.diagnose(robot, train, validation=held)
    assert not found.good
    assert any("they look computed" in line for line in found.advice)


@pytest.mark.parametrize(
    ("name", "arm", "noise", "verdict"),
    [
        ("target_torque", WITHOUT_FRICTION, 0.0, "doubtful"),
        ("torque", WITHOUT_FRICTION, 0.0, "trusted"),
        ("target_torque", WITHOUT_FRICTION, 1e-3, "trusted"),  # a frictionless robot, simulated
        ("target_torque", ARM, 0.0, "trusted"),
    ],
)
def test_the_name_of_a_command_decides_only_on_torques_without_friction_and_noise(
    tmp_path, name, arm, noise, verdict
) -> None:
    robot = tmp_path / "arm.toml"
    robot.write_text(ROBOT)
    found, reasons, suspected = identified(tmp_path, robot, arm, noise, name)
    assert found == verdict
    assert ("computed_torque" in reasons | suspected) == (arm is not ARM and noise == 0)


@pytest.mark.parametrize("part", [1.0, 0.0, 0.05])
def test_torques_without_the_weight_of_the_file_are_a_fault(tmp_path, part) -> None:
    robot = file_with_values(tmp_path)
    verdict, reasons, _ = identified(tmp_path, robot, ARM, 1e-3, weight=part)
    assert (verdict == "doubtful", "no_weight" in reasons) == (part < 1, part < 1)


@pytest.mark.parametrize("part", [1.0, 0.5, 0.1])
def test_torques_with_a_small_part_of_the_friction_of_the_file_are_suspected(
    tmp_path, part
) -> None:
    robot = file_with_values(tmp_path)
    arm = replace(ARM, FS=part * ARM.FS, FV=part * ARM.FV)
    verdict, _, suspected = identified(tmp_path, robot, arm, 1e-3)
    assert verdict == "trusted"
    assert ("little_friction" in suspected) == (part < 0.25)


def noisy(name: str, seed: int, noise: float) -> symgen.Log:
    t, q, qd, qdd = motion(3)
    tau, rng = ARM.torque(q, qd, qdd), np.random.default_rng(seed)
    tau = tau + noise * tau.std(axis=0) * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q + 1e-5 * rng.normal(size=q.shape), tau, qd)


def resampled(log: symgen.Log, begin: float, end: float, rate: float) -> symgen.Log:
    """Return a span of a log, linear between its samples at another rate, with its own clock."""
    t = np.arange(begin + 0.0017, end, 1 / rate)
    q, qd, tau = (
        np.column_stack([np.interp(t, log.t, x) for x in values.T])
        for values in (log.q, log.qd, log.tau)
    )
    return symgen.make_log("copy", t - t[0] + 100.0, q, tau, qd)


@pytest.mark.parametrize("verb", [symgen.identify, symgen.diagnose])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_validation_log_that_is_a_shifted_and_resampled_training_log_is_refused(
    verb, noise
) -> None:
    train = noisy("train", 5, noise)
    for copy in (resampled(train, 0, 11.9, 170.0), resampled(train, 4.0, 9.0, 130.0)):
        with pytest.raises(symgen.LogError, match="copy: holds the same data as the training log"):
            verb(symgen.parse_robot(ROBOT), train, validation=copy)


def test_another_recording_of_the_same_path_is_no_copy() -> None:
    """Noise at a hundredth and at a ten-thousandth of the torque; the clock begins elsewhere."""
    for noise in (1e-2, 2e-3):
        train, other = (noisy(f"log {seed}", seed, noise) for seed in (5, 6))
        again = replace(other, t=other.t + 50.0)
        found = symgen.identify(symgen.parse_robot(ROBOT), train, validation=again, model="torque")
        assert found.verdict == "trusted"


@pytest.mark.parametrize("verb", [symgen.identify, symgen.diagnose])
def test_a_validation_log_on_the_path_of_the_training_log_gets_a_note(verb) -> None:
    """The path is repeated backwards, with the torque of that motion; another path has no note."""
    train = noisy("train", 5, 0.01)
    rng = np.random.default_rng(6)
    logs = []
    for seed, step in ((3, -1), (4, 1)):
        t, *path = motion(seed)
        q, qd, qdd = (x[::step] * factor for x, factor in zip(path, (1, step, 1), strict=True))
        tau = ARM.torque(q, qd, qdd)
        tau = tau + 0.01 * tau.std(axis=0) * rng.normal(size=tau.shape)
        off = 0.02 * np.sin(3 * t)[:, None]
        logs.append(
            symgen.make_log(f"log {seed}", t, q + off, tau, qd + 0.06 * np.cos(3 * t)[:, None])
        )
    found = verb(symgen.parse_robot(ROBOT), train, validation=logs)
    said = [note for note in found.notes if "repeats the path" in note]
    assert len(said) == 1
    assert said[0].startswith("log 3: repeats the path of the training log train")
