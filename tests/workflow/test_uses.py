"""What an estimate may be used for: one line a use, and parameters that a robot can have."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles import clean_runs, planar2r
from oracles.arm import Arm
from oracles.faults import Log
from simulated_runs import identified as identified_run
from stored_logs import made, stored
from support import shared_file

import symgen
from symgen.report.store import result_page

ARM = Arm(np.array([3.7, 0.8, 1.2, 0.3]))
STOP = 0.054  # s
SCALE = np.array([20.0, 5.0])  # N m s/rad: that of the joints' torques over their speeds, about
ROBOT = planar2r.robot_toml("rubbing", 'friction = ["viscous"]\nrotor_inertia = false')

RUBBING = ROBOT.replace('["viscous"]', '["coulomb", "viscous"]')


def log(seed: int, viscous: float, noise: float = 1e-3, name: str = "log") -> symgen.Log:
    """A motion with viscous friction of about a share of each joint's torque."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = ARM.torque(q, qd, qdd)
    size = tau.std(axis=0)
    tau = tau + viscous * SCALE * qd + noise * size * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q, tau, qd)


def commands(
    viscous: float, noise: float, encoder: float, robot: str = ROBOT
) -> tuple[symgen.Robot, list[symgen.Log]]:
    """Two logs, and encoders that come in steps, rad."""
    logs = []
    for seed in (3, 4):
        true = log(seed, viscous, noise)
        q = np.round(true.q / encoder) * encoder if encoder else true.q
        logs.append(symgen.make_log(f"log {seed}", true.t, q, true.tau, true.qd))
    return symgen.parse_robot(robot, "rubbing.toml"), logs


def identified(viscous: float) -> symgen.Estimate:
    robot = symgen.parse_robot(ROBOT, "rubbing.toml")
    held = log(4, viscous, name="held")
    return symgen.identify(robot, log(3, viscous), validation=held)


TABLE = """
[robot]
name = "table"
gravity = [0.0, 0.0, 0.0]

[[joint]]
sigma = 1
rotor_inertia = false

[[joint]]
sigma = 1
alpha = "pi/2"
rotor_inertia = false

[limits]
position = [[-0.4, 0.4], [-0.4, 0.4]]
velocity = [1.0, 1.0]
"""


def test_a_force_with_the_wrong_sign_is_named_where_it_is_small() -> None:
    """Both axes move independently, so negative masses and friction fit the second force."""
    robot = symgen.parse_robot(TABLE)
    values = {"M1": 30.0, "M2": 1.5, "FS1": 40.0, "FV1": 60.0, "FS2": 1.0, "FV2": 2.0}
    sensors = symgen.Recording(symgen.Instruments(encoder_step=1e-6, torque_noise=0.05), rate=100.0)
    logs = []
    for seed in (1, 2):
        log = symgen.simulate(robot, values, recording=sensors, duration=5.0, seed=seed).log(0)
        logs.append(symgen.make_log(log.name, log.t, log.q, log.tau * [1.0, -1.0], log.qd))
    found = symgen.identify(robot, logs[0], validation=logs[1], model="torque")
    assert found.verdict == "doubtful"
    (reason,) = found.reasons
    assert (reason.kind, reason.joints) == ("no_robot", (2,))
    assert reason.value < 0.1


@pytest.mark.slow
def test_a_load_in_the_validation_log_alone_is_suspected_and_the_command_finds_it(
    command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A load of 2 kg at 0.2 m, after an estimate without it."""
    (tmp_path / "arm.toml").write_text(ROBOT)
    for name, seed, arm in (("train", 3, ARM), ("held", 4, ARM.carrying(2.0, at=0.2))):
        rng = np.random.default_rng(seed)
        t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
        tau = arm.torque(q, qd, qdd)
        tau += 0.1 * SCALE * qd + 1e-3 * tau.std(axis=0) * rng.normal(size=tau.shape)
        columns = np.column_stack([t, q, qd, tau])
        head = "t,q1,q2,qd1,qd2,tau1,tau2"
        np.savetxt(tmp_path / f"{name}.csv", columns, delimiter=",", header=head, comments="")
    monkeypatch.chdir(tmp_path)
    typed = ["identify", "arm.toml", "train.csv", "--validation", "held.csv", "--into", "found"]
    code, printed, _ = command(*typed)
    assert code == 1
    advice = "symgen diagnose arm.toml held.csv --into found-why --parameters found"
    assert f"try: {advice}\n" in printed
    assert command(*advice.split()[1:])[0] in (0, 1)
    effects = json.loads((tmp_path / "found-why" / "diagnosis.json").read_text())["effects"]
    assert effects[0]["name"] == "payload"
    why = symgen.diagnose("arm.toml", "train.csv", validation="held.csv")
    assert any("compare load" in text for text in why.advice)


def test_a_headline_begins_with_the_error_and_has_a_sentence_for_each_use() -> None:
    found = identified(0.1)
    assert (found.verdict, found.reasons) == ("trusted", ())
    error, *uses = found.headline.split(" | ")
    relative = found.torque_validation.relative
    assert error.startswith(f"{100 * relative:#.3g} % torque error on motion it has not seen; ")
    assert str(found.uses).splitlines() == uses
    assert uses[:2] == ["Good for torque prediction.", "Parameters: 6 of 6 are known to 30 %."]
    assert uses[2].startswith("Good for simulation: position error after 1 s 0.0")


@pytest.mark.parametrize(
    ("accept", "grade", "kinds"),
    [(0.10, "usable", []), (0.05, "poor", ["error"]), (0.055, "usable", [])],
)
def test_the_grade_follows_the_error_and_what_is_accepted(accept, grade, kinds) -> None:
    found = lacking(0.3, accept=accept)
    assert 0.05 < found.torque_validation.relative < 0.055
    assert found.uses.prediction.grade == grade
    assert [reason.kind for reason in found.reasons] == kinds
    assert found.uses.prediction.ok == (not kinds)


def test_reasons_stand_in_the_file_as_values(tmp_path: Path) -> None:
    found = lacking(0.3, accept=0.05)
    symgen.write(found, tmp_path / "out")
    content = json.loads((tmp_path / "out" / "estimate.json").read_text("utf-8"))
    (reason,) = content["uses"]["prediction"]["reasons"]
    assert content["reasons"] == [reason]
    assert set(reason) == {"kind", "joints", "value", "limit", "text"}
    assert (reason["kind"], reason["joints"], reason["limit"]) == ("error", [], 0.05)
    again = symgen.read_estimate(tmp_path / "out")
    assert again.uses == found.uses
    assert again.reasons == found.reasons


def test_friction_that_drives_the_robot_a_little_is_bounded() -> None:
    found = identified(-0.004)
    values = {p.name: p.value for p in found.parameters}
    assert found.method == "consistent"
    assert min(values["FV1"], values["FV2"]) >= 0
    assert found.possible
    assert {"FV1", "FV2"} & set(found.at_bound)
    assert not set(found.at_bound) & set(found.uses.parameters.known)
    assert "at bound" in result_page(found)
    assert all(use.ok for use in found.uses if use.name != "parameters"), found.uses
    sound = identified(0.004)
    assert sound.method == "wls"


def test_friction_that_drives_the_robot_much_is_an_effect_that_is_missing() -> None:
    found = identified(-0.1)
    assert found.method == "wls"
    assert not found.possible
    reason = found.physical.reason
    assert reason.kind == "effect_missing"
    assert set(reason.joints) <= {1, 2}
    assert reason.value > reason.limit
    assert "negative_friction" in {r.kind for r in found.uses.simulation.reasons}


@pytest.mark.parametrize(
    ("viscous", "noise", "encoder", "robot"),
    [
        pytest.param(0.0, 1e-3, 1e-4, ROBOT, id="a robot without friction, measured"),
        pytest.param(0.05, 0.0, 1e-4, ROBOT, id="torques that hold friction"),
        pytest.param(0.05, 1e-3, 1e-4, RUBBING, id="drives without Coulomb friction"),
        pytest.param(0.0, 0.0, 0.0, ROBOT, id="a simulation without instruments"),
        pytest.param(
            0.0, 0.0, 1e-4, ROBOT.replace('["viscous"]', "[]"), id="a file without friction"
        ),
    ],
)
def test_what_may_have_been_measured_is_no_command(
    viscous: float, noise: float, encoder: float, robot: str
) -> None:
    parsed, logs = commands(viscous, noise, encoder, robot)
    found = symgen.identify(parsed, logs[:1], validation=logs[1:])
    assert found.verdict == "trusted", found.reasons


def lacking(part: float, noise: float = 1e-3, **options: float) -> symgen.Estimate:
    """What is identified where the model lacks a part of the torque of joint 2."""
    logs = []
    for seed in (3, 4):
        own = log(seed, 0.1, 0.0, f"log {seed}")
        tau, size = own.tau.copy(), own.tau.std(axis=0)
        tau[:, 1] += part * size[1] * np.sqrt(2) * np.cos(3 * own.q[:, 0] + own.qd[:, 1])
        tau[:, 1] += noise * size[1] * np.random.default_rng(seed).normal(size=len(tau))
        logs.append(replace(own, tau=tau))
    robot = symgen.parse_robot(ROBOT, "r.toml")
    return symgen.identify(robot, logs[0], validation=logs[1], **options)


def test_single_values_are_not_to_be_read_where_torque_is_unexplained() -> None:
    found = lacking(0.06)
    assert found.verdict == "trusted"
    assert 0 < found.unexplained < 0.05
    reason = found.uses.parameters.reasons[0]
    assert (reason.kind, reason.value) == ("unexplained", found.unexplained)


def test_joints_with_a_large_error_are_listed_with_their_torque() -> None:
    found = lacking(0.5)
    (large,) = found.uses.prediction.large
    assert (large.kind, large.joints, large.limit) == ("large_error", (2,), 0.1)
    assert large.value == pytest.approx(found.torque_validation.per_joint[1])
    assert "N m" in large.text


def test_the_largest_error_of_a_joint_is_in_the_headline_and_lowers_the_grade() -> None:
    found = lacking(0.2)
    assert found.moving.relative < 0.05
    assert (found.verdict, found.uses.prediction.grade) == ("trusted", "usable")
    (large,) = found.uses.prediction.large
    assert f", up to {large.text};" in found.sentences[0]


def test_a_joint_that_the_model_does_not_describe_is_doubtful_where_the_total_is_small() -> None:
    found = lacking(0.8, accept=0.2)
    (reason,) = found.reasons
    assert (found.verdict, reason.kind, reason.joints) == ("doubtful", "joint_error", (2,))
    assert found.moving.relative < 0.2 < reason.limit < reason.value


def test_a_large_error_that_is_noise_counts_for_no_joint() -> None:
    found = lacking(0.0, noise=0.9)
    assert found.moving.per_joint[1] > 0.1
    assert (found.uses.prediction.grade, found.uses.prediction.large) == ("good", ())


def test_no_noise_floor_is_stated_for_a_log_without_samples_above_the_band() -> None:
    """The torque is compared below 3 Hz, and the log has 5 samples in a second."""
    robot, logs = commands(0.1, 1e-3, 0.0)
    slow = [
        symgen.make_log(log.name, *(x[::40] for x in (log.t, log.q, log.tau, log.qd)))
        for log in logs
    ]
    found = symgen.identify(robot, slow[0], validation=slow[1])
    assert np.isnan(found.noise_floor.relative)
    assert "the noise floor is unknown" in found.sentences[0]


def _coupled(log: Log) -> Log:
    """What the motors of a wrist record of which the last one turns by half of the one before."""
    q, qd, tau = (np.array(x) for x in (log.q, log.qd, log.tau))
    q[:, -1] += 0.5 * q[:, -2]
    qd[:, -1] += 0.5 * qd[:, -2]
    tau[:, -2] -= 0.5 * tau[:, -1]
    return replace(log, q=q, qd=qd, tau=tau)


@pytest.mark.slow
@pytest.mark.parametrize("coupled", [False, True])
def test_a_coupled_wrist_is_doubtful_whose_torques_are_a_small_part_of_those_of_the_arm(
    coupled: bool,
) -> None:
    run = clean_runs.run(
        1, arms=["wrist6r"], effects=False, speeds=True, torque_noise=(0.005, 0.03), misfit=0.02
    )
    if coupled:
        run = replace(run, train=_coupled(run.train), validation=_coupled(run.validation))
    found = identified_run(run)
    assert found["torque_residual_in_motion"]["relative"] < 0.05
    assert [r["kind"] for r in found["reasons"]] == ["joint_error"] * coupled


def test_training_logs_that_move_one_joint_at_a_time_are_the_reason() -> None:
    folder = shared_file("cases/jointwise/robot.toml").parent
    logs = [folder / f"train_{k}.csv" for k in (1, 2, 3)]
    found = symgen.identify(folder / "robot.toml", logs, validation=folder / "test.csv")
    assert found.verdict == "doubtful"
    first, *others = found.reasons
    assert (first.kind, first.joints) == ("not_excited", (1, 2, 3))
    assert first.value > first.limit
    assert [reason.kind for reason in others] == ["error"]


def test_a_stop_between_two_moves_is_a_rest() -> None:
    """Moves of a fifth of a second with stops of 50 ms: friction at rest is none of the model's."""
    t, friction = np.arange(0, 12, 0.001), np.array([1.0, 0.5])
    robot = symgen.parse_robot(ROBOT.replace('"viscous"', '"coulomb", "viscous"'), "rubbing.toml")
    logs = []
    for seed in (5, 6):
        rng = np.random.default_rng(seed)
        q, qd, qdd = (np.zeros((len(t), 2)) for _ in range(3))
        at, begin = rng.uniform(-1, 1, 2), 0.0
        while begin < t[-1]:
            to, length = rng.uniform(-1, 1, 2), rng.uniform(0.18, 0.3)
            here = (t >= begin) & (t < begin + length + STOP)
            s, way = np.clip((t[here] - begin) / length, 0, 1)[:, None], to - at
            q[here] = at + way * s**3 * (10 - 15 * s + 6 * s**2)
            qd[here] = way / length * 30 * s**2 * (1 - s) ** 2
            qdd[here] = way / length**2 * 60 * s * (1 - s) * (1 - 2 * s)
            at, begin = to, begin + length + STOP
        tau = ARM.torque(q, qd, qdd)
        tau += friction * np.sign(qd) + 0.2 * qd + 0.02 * rng.normal(size=q.shape)
        q += 1e-5 * rng.normal(size=q.shape)
        logs.append(symgen.make_log(f"moves {seed}", t, q, tau))
    found = symgen.identify(robot, logs[0], validation=logs[1])
    values = {p.name: p for p in found.parameters}
    for name, true in zip(("FS1", "FS2"), friction, strict=True):
        assert abs(values[name].value / true - 1) < 0.01


@pytest.mark.parametrize(("least", "kinds"), [(0.008, ["stribeck_friction"]), (0.9, [])])
def test_what_matters_less_than_asked_for_is_not_suspected(least: float, kinds: list[str]) -> None:
    case = stored("stribeck")
    train, test = made("train", case.train), made("test", case.test)
    found = symgen.identify(case.robot, train, validation=test, model="torque", least=least)
    assert [reason.kind for reason in found.suspected] == kinds


@pytest.mark.parametrize("viscous", [0.0, 0.1])
def test_torques_without_the_friction_of_the_file_look_computed(viscous) -> None:
    logs = [log(seed, viscous, noise=0.0, name=f"log {seed}") for seed in (3, 4)]
    found = symgen.identify(symgen.parse_robot(ROBOT), logs[0], validation=logs[1])
    assert found.verdict == "trusted"
    kinds = {reason.kind for reason in found.suspected}
    assert ("computed_torque" in kinds) == (viscous == 0)
