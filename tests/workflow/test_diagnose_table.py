"""`diagnose` names what is hidden in a log, where it is, how large it is, and nothing else.

The logs are those of tests/logs, from simulators that share no code with the package; who wants
another one makes it with studies/make_logs.py. Effects that cannot be told apart may stand for
each other. A row is a case, what has to be named, a parameter with its true value and how far off
it may be, and the verdict.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.arm import HANGING, IN_PLANE, sines
from oracles.planar2r import robot_toml
from stored_logs import made, stored
from sympy import Rational, pi

import symgen

Effects = list[tuple[str, tuple[int, ...]]]
Values = dict[str, tuple[float, float]]
GOOD, SOME = 0.05, 0.15

#: Case: effects, parameters with their tolerance relative to the value, verdict.
TABLE: dict[str, tuple[Effects, Values, str]] = {
    "sound": ([], {}, "consistent"),
    "noise": ([], {}, "consistent"),
    "coulomb": ([("coulomb_friction", (2,))], {"FS2": (0.640, GOOD)}, "explained"),
    "viscous": ([("viscous_friction", (1,))], {"FV1": (2.90, GOOD)}, "explained"),
    "rotor": ([("rotor_inertia", (2,))], {"IA2": (0.0833, GOOD)}, "explained"),
    "offset": ([("torque_offset", (2,))], {"OF2": (0.639, GOOD)}, "explained"),
    "stribeck": (
        [("stribeck_friction", (2,))], {"FST2": (1.71, GOOD), "vs2": (0.419, GOOD)}, "explained"
    ),
    "load_friction": ([("load_dependent_friction", (1,))], {"FL1": (0.0756, GOOD)}, "explained"),
    "spring": ([("gravity_spring", (2,))], {"K2": (1.28, GOOD)}, "explained"),
    "ripple": (
        [("torque_ripple", (2,))], {"k2": (6.0, 0.01), "RC2": (0.868, GOOD)}, "explained"
    ),
    "coupled": (
        [("coupled_transmission", (1, 2))], {"ratio2": (-1.0, 0.01), "FSM2": (0.279, GOOD)},
        "explained",
    ),
    "elastic": ([("joint_elasticity", (2,))], {"CE2": (1 / 457, 0.3)}, "explained"),
    "contact": ([("external_contact", (1,))], {"start1": (3.42, GOOD)}, "explained"),
    "bump": (
        [("unnamed", (1,))], {"c1": (-0.440, 0.01), "w1": (0.269, GOOD)}, "explained"
    ),
    "tilt": ([("base_tilt", ())], {"TZ": (0.104, GOOD)}, "explained"),
    "length": ([("geometry_error", (3,))], {"delta_d3": (-0.111, GOOD)}, "explained"),
    "payload": (
        [("payload", (2,))], {"ML": (0.648, GOOD), "MXL": (0.0259, GOOD)}, "explained"
    ),
    "gain": ([("drive_gain_error", (1,))], {"G1": (0.863 - 1, GOOD)}, "explained"),
    "drifted": ([("coulomb_friction", (2,))], {"FS2": (0.667, GOOD)}, "explained"),
    "pair": (
        [("coulomb_friction", (2,)), ("gravity_spring", (1,))], {"FS2": (0.641, GOOD)}, "explained"
    ),
    "carried": ([("gravity_compensation", (2,))], {"GC2": (0.5, GOOD)}, "explained"),
    "smooth": (
        [("smooth_friction", (2,))], {"FSM2": (5.0, GOOD), "w2": (0.15, GOOD)}, "explained"
    ),
    "stuck_coulomb": ([("coulomb_friction", (2,))], {"FS2": (2.0, GOOD)}, "explained"),
    "play": ([("backlash", (2,))], {"width2": (0.01745, 0.2)}, "explained"),
    "hysteresis": (
        [("presliding_friction", (2,))], {"FD2": (0.5, GOOD), "xs2": (0.1, GOOD)}, "explained"
    ),
    "cogging": ([("motor_cogging", (2,))], {"k2": (240.0, 1e-3)}, "explained"),
    "bare": (
        [(f"{law}_friction", (j,)) for law in ("coulomb", "viscous") for j in (1, 2)],
        {"FS1": (1.0, GOOD), "FS2": (0.4, GOOD), "FV1": (0.6, GOOD), "FV2": (0.25, GOOD)},
        "explained",
    ),
    "two_encoders": ([("joint_elasticity", (1,))], {"K1": (900.0, GOOD)}, "explained"),
}  # fmt: skip
#: Simulated by the test itself.
SLOW: dict[str, tuple[Effects, Values, str]] = {
    "misfit": ([], {}, "consistent"),
    "stuck": ([], {}, "consistent"),
    "no_play": ([], {}, "consistent"),
    "asymmetric": ([("asymmetric_viscous_friction", (2,))], {"FVA2": (0.494, GOOD)}, "explained"),
    "nonlinear": ([("nonlinear_viscous_friction", (1,))], {"p1": (2.0, GOOD)}, "explained"),
    "place_friction": ([("position_dependent_friction", (1,))], {"FC1": (4.73, GOOD)}, "explained"),
    "cable": ([("cable_torque", (1,))], {}, "explained"),
    "thermal": (
        [("thermal_drift", (1,)), ("thermal_drift", (2,))], {"DR2": (0.45, SOME)}, "explained"
    ),
    "product": ([("unnamed", (2,))], {"U48J2": (0.933, GOOD)}, "explained"),
    "zero": ([("zero_offset", (2,))], {"DZ2": (0.05236, GOOD)}, "explained"),
    "rising": (
        [(f"{law}_friction", (j,)) for law in ("coulomb", "smooth") for j in (1, 2)],
        {"FS1": (1.0, GOOD), "FS2": (0.4, GOOD)},
        "explained",
    ),
}  # fmt: skip


def diagnosed(case: str, folder: Path) -> symgen.Diagnosis:
    """Return the diagnosis of a stored case."""
    log, parameters = stored(case), None
    if log.parameters:
        parameters = folder / "parameters.toml"
        parameters.write_text(log.parameters, "utf-8")
    return symgen.diagnose(
        log.robot,
        made("train", log.train),
        validation=made("test", log.test),
        parameters=parameters,
    )


def agrees(found: symgen.Diagnosis, effects: Effects, values: Values, verdict: str) -> None:
    """Every effect is one that is expected, and every expected one is there."""
    adopted = [e for e in found.effects if e.adopted]
    said = [{(e.name, e.joints), *map(tuple, e.indistinguishable_from)} for e in adopted]
    told = [(e.name, e.joints) for e in adopted]
    assert len(said) == len(effects), told
    assert all(any(effect in names for names in said) for effect in effects), told
    assert found.verdict == verdict
    own = {p.name: p.value for e in found.effects for p in e.parameters}
    for name, (value, off) in values.items():
        assert own[name] == pytest.approx(value, rel=off), name
    assert found.after.total <= found.before.total


@pytest.mark.parametrize("case", TABLE)
def test_what_is_hidden_is_named_with_its_size(case: str, tmp_path: Path) -> None:
    agrees(diagnosed(case, tmp_path), *TABLE[case])


def test_a_wrong_length_is_listed_with_the_command_that_looks_the_same(tmp_path: Path) -> None:
    """On an arm with one length, torques without a share of the dynamics are the same torques."""
    (length,) = diagnosed("length", tmp_path).effects
    assert ("commanded_torque", ()) in [tuple(a) for a in length.indistinguishable_from]


@pytest.mark.slow
@pytest.mark.parametrize("case", SLOW)
def test_what_else_is_hidden_is_named_with_its_size(case: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    agrees(diagnosed(case, tmp_path), *SLOW[case])


def loaded(robot: symgen.Robot) -> symgen.Robot:
    """Return the robot with the effect that `load_friction` hides, declared."""
    effect = '[[effect]]\nname = "load_dependent_friction"\njoints = [1]\n'
    return symgen.parse_robot(f"{symgen.robot_toml(robot)}\n{effect}")


def test_a_share_of_the_load_is_identified_where_it_is_declared() -> None:
    log = stored("load_friction")
    robot, logs = loaded(log.robot), (made("train", log.train), made("test", log.test))
    estimate = symgen.identify(robot, logs[0], validation=logs[1], model="torque")
    found = {p.name: p for p in estimate.parameters}["FL1"]
    assert estimate.verdict == "trusted"
    assert found.value == pytest.approx(0.0756, abs=4 * found.std)
    with pytest.raises(symgen.IdentificationError, match="model torque"):
        symgen.identify(robot, logs[0], validation=logs[1], model="energy")


@pytest.mark.parametrize("fault", ["delay", "external_contact"])
def test_a_declared_share_of_the_load_leaves_no_fault_of_the_recorder_in(fault: str) -> None:
    log = stored("load_friction")
    logs = [made("train", log.train), made("test", log.test)]
    for k, sound in enumerate(logs):
        tau = sound.tau.copy()
        if fault == "delay":  # of 10 ms
            tau[1:] = tau[:-1].copy()
        elif sound.name == "train":  # a push of half a second
            tau[800:850, 0] += np.std(tau[:, 0])
        logs[k] = replace(sound, tau=tau)
    estimate = symgen.identify(loaded(log.robot), logs[0], validation=logs[1], model="torque")
    assert [repair.kind for repair in estimate.repairs] == [fault]
    assert estimate.torque_validation.relative < 0.006
    found = {p.name: p for p in estimate.parameters}["FL1"]
    assert found.value == pytest.approx(0.0756, abs=4 * found.std)
    assert found.std < 0.002


def test_the_extended_robot_computes_what_the_diagnosis_says(tmp_path: Path) -> None:
    """The compiled code of the robot with an effect without a name gives its torque."""
    found = diagnosed("bump", tmp_path)
    values = {p.name: p.value for p in found.effects[0].parameters}
    again = symgen.parse_robot(symgen.robot_toml(found.extended))
    compiled = symgen.load(symgen.derive(again, ("torque_regressor",)))
    names = compiled.model.base.names
    X = np.array([values[name] if name in ("UA1", "UB1") else 0.0 for name in names])
    log = stored("bump").test
    q, qd = log["q"][::50], log["qd"][::50]
    tau = compiled["torque_regressor"](q, qd, 0 * q)[..., : len(X)] @ X
    off = q[:, 0] + 0.440
    truth = 42.87 * off * np.exp(-((off / 0.269) ** 2))
    assert np.abs(tau[:, 0] - truth).max() < 0.05 * np.abs(truth).max()
    assert not tau[:, 1].any()


def test_a_contact_in_the_validation_log_is_suspected_and_counts_in_both_numbers() -> None:
    log = stored("sound")
    train, test = made("train", log.train), made("test", log.test)
    tau = test.tau.copy()
    touched = (test.t > 3.0) & (test.t < 3.6)
    tau[touched, 1] += 0.5 * np.abs(tau[:, 1]).max()
    found = symgen.diagnose(log.robot, train, validation=replace(test, tau=tau))
    (contact,) = found.effects
    assert (contact.name, contact.joints, contact.adopted) == ("external_contact", (2,), False)
    assert contact.parameters[0].value == pytest.approx(3.0, abs=0.2)
    assert found.verdict == "unexplained"
    assert found.after == found.before


def test_torques_of_all_joints_turned_are_corrected_by_gains() -> None:
    """Negative masses explain them as well, and no robot has these."""
    log = stored("sound")
    turned = [replace(x, tau=-x.tau) for x in (made("train", log.train), made("test", log.test))]
    found = symgen.diagnose(log.robot, turned[0], validation=turned[1])
    assert [(e.name, e.joints, e.adopted) for e in found.effects] == [
        ("wrong_sign", (1, 2, 3), True)
    ]
    assert found.verdict == "explained"
    assert found.extended.drive is not None
    assert found.extended.drive.gain == (-1.0, -1.0, -1.0)


def test_two_turned_torques_are_told_from_the_third_by_their_work() -> None:
    log = stored("sound")
    signs = np.array([-1.0, 1.0, -1.0])
    turned = [
        replace(x, tau=x.tau * signs) for x in (made("train", log.train), made("test", log.test))
    ]
    found = symgen.diagnose(log.robot, turned[0], validation=turned[1])
    assert [(e.name, e.joints, e.shown) for e in found.effects] == [("wrong_sign", (1, 3), True)]


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("thermal_drift", lambda t, tau, qd: 0.4 * tau.std() * np.exp(-t / 6) * np.sign(qd)),
        ("torque_drift", lambda t, tau, _: 0.5 * tau.std() * t / t[-1]),
        ("gain_drift", lambda t, tau, _: -0.3 * tau * t / t[-1]),
        ("torque_creep", lambda t, tau, _: 0.4 * tau.std() * np.exp(-t / 4)),
    ],
)
def test_what_changes_in_the_training_log_alone_is_named(name, change) -> None:
    log = stored("sound")
    train, test = made("train", log.train), made("test", log.test)
    tau = train.tau.copy()
    tau[:, 1] += change(train.t, tau[:, 1], train.qd[:, 1])
    found = symgen.diagnose(log.robot, replace(train, tau=tau), validation=test)
    told = [(e.name, e.joints, e.shown) for e in found.effects if e.adopted]
    assert told == [(name, (2,), True)]


@pytest.mark.parametrize(
    ("name", "joints", "change", "value"),
    [
        ("torque_creep", (2,), lambda t, _: 4 * (1 - np.exp(-t / 3)), {"TC2": -4, "T2": 3}),
        ("crosstalk", (2, 1), lambda _, tau: 0.12 * tau[:, 0], {"CX1": 0.12}),
    ],
)
def test_errors_of_a_torque_sensor_in_all_logs_are_named(name, joints, change, value) -> None:
    log, logs = stored("sound"), []
    for given in (made("train", log.train), made("test", log.test)):
        tau = given.tau.copy()
        tau[:, 1] += change(given.t - given.t[0], given.tau)
        logs.append(replace(given, tau=tau))
    found = symgen.diagnose(log.robot, logs[0], validation=logs[1])
    assert [(e.name, e.joints) for e in found.effects if e.adopted] == [(name, joints)]
    values = {p.name: p.value for e in found.effects for p in e.parameters}
    assert values == pytest.approx(value, rel=SOME)
    assert found.verdict == "bad-measurement"


@pytest.mark.parametrize("gravity", [(0, 0, 1), (1, 0, 0), (0, 0, 0)])
def test_gravity_of_the_file_along_another_axis_is_named(gravity) -> None:
    """Least squares hide most of it in the masses: the torque error is below ten per cent."""
    log = stored("sound")
    robot = replace(log.robot, gravity=tuple(Rational(981, 100) * x for x in gravity))
    train, test = made("train", log.train), made("test", log.test)
    found = symgen.diagnose(robot, train, validation=test)
    told = [(e.name, e.shown) for e in found.effects if e.adopted]
    assert told == [("gravity_direction", True)]
    assert found.after.total < 0.007


@pytest.mark.parametrize("degrees", [35, 120])
def test_a_base_that_is_tilted_turns_gravity_and_keeps_its_norm(degrees: int) -> None:
    """In a frame 0 that is turned about x, the gravity of the logs is turned the other way."""
    log = stored("sound")
    first, *others = log.robot.joints
    tilted = replace(log.robot, joints=(replace(first, alpha=pi * degrees / 180), *others))
    train, test = made("train", log.train), made("test", log.test)
    found = symgen.diagnose(tilted, train, validation=test)
    told = [(e.name, e.joints, e.shown, e.declared) for e in found.effects if e.adopted]
    assert told == [("base_tilt", (), True, True)]
    gravity = np.array([float(g) for g in found.extended.gravity])
    assert np.linalg.norm(gravity) == pytest.approx(9.81, rel=1e-5)
    by_name = {p.name: p for p in found.effects[0].parameters}
    assert by_name["TX"].value == pytest.approx(-np.radians(degrees), abs=0.02)
    angle = np.radians(degrees)
    for name, true in zip(("gx", "gy", "gz"), (0, np.sin(angle), -np.cos(angle)), strict=True):
        assert abs(by_name[name].value - 9.81 * true) < 4 * by_name[name].std
    assert found.after.total < 0.007


def test_a_tilted_base_makes_the_estimate_doubtful_with_its_angle() -> None:
    log = stored("sound")
    first, *others = log.robot.joints
    tilted = replace(log.robot, joints=(replace(first, alpha=pi * 35 / 180), *others))
    found = symgen.identify(tilted, made("train", log.train), validation=made("test", log.test))
    assert found.verdict == "doubtful"
    assert found.reasons[0].kind == "base_tilt"
    assert "TX = -0.6" in found.reasons[0].text


TROLLEY = """[robot]
name = "trolley"
gravity = [-9.81, 0.0, 0.0]
[[joint]]
sigma = 1
[[joint]]
alpha = "pi/2"
"""


def trolley(name: str, seed: int, degrees: float) -> symgen.Log:
    """A pendulum on a rail that is tilted, by Lagrange's equations; g along -x and z of frame 0."""
    M, IA1, J, MX, MY = 30.0, 12.0, 1.4, 3.0, 0.4
    g = 9.81 * np.array([-np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    phase = rng.uniform(0, 6, (2, 2))
    q, qd, qdd = sines(t, [[0.3, 0.8], [0.1, 0.4]], [[1.1, 1.7], [2.9, 4.3]], phase)
    sine, cosine = np.sin(q[:, 1]), np.cos(q[:, 1])
    across, along = MX * cosine - MY * sine, MX * sine + MY * cosine
    force = (M + IA1) * qdd[:, 0] + across * qdd[:, 1] - along * qd[:, 1] ** 2 - M * g[1]
    torque = J * qdd[:, 1] + across * (qdd[:, 0] - g[1]) + along * g[0]
    tau = np.column_stack([force, torque]) + [5.0, 1.0] * np.sign(qd) + [8.0, 0.6] * qd
    tau += 0.01 * tau.std(axis=0) * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q + 1e-5 * rng.normal(size=q.shape), tau, qd)


def test_a_rail_that_is_tilted_by_a_degree_is_no_offset_and_tells_rotor_from_mass() -> None:
    train, test = trolley("train", 1, 1.0), trolley("test", 2, 1.0)
    found = symgen.diagnose(symgen.parse_robot(TROLLEY), train, validation=test)
    assert [(e.name, e.joints) for e in found.effects] == [("base_tilt", ())]
    across, along = (p for p in found.effects[0].parameters if p.name in ("gy", "gz"))
    assert np.isnan(across.std)  # no torque depends on gravity along the axis of the pendulum
    assert along.std < 0.02
    assert along.value == pytest.approx(9.81 * np.sin(np.radians(1.0)), abs=3 * along.std)
    values = {p.name: p.value for p in found.parameters}
    assert values["M1R"] == pytest.approx(30.0, rel=0.1)
    assert values["IA1"] == pytest.approx(12.0, rel=0.25)


def in_plane(name: str, seed: int, degrees: float) -> symgen.Log:
    """A log of an arm in a vertical plane, whose base is turned about the axes of its joints."""
    rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    motion = sines(t, [[0.8, 0.6], [0.3, 0.4]], [[1.1, 1.7], [2.9, 4.3]], rng.uniform(0, 6, (2, 2)))
    t, q, tau, qd = HANGING.recorded(t, motion, rng)
    return symgen.make_log(name, t, q - [np.radians(degrees), 0.0], tau, qd)


def test_a_tilt_is_exact_with_the_parameters_of_the_level_robot(tmp_path) -> None:
    robot = symgen.parse_robot(robot_toml("arm", gravity=IN_PLANE))
    symgen.write(
        symgen.identify(robot, in_plane("level", 1, 0.0), model="torque"), tmp_path / "level"
    )
    tilted = in_plane("tilted", 2, 20.0)
    known = tmp_path / "level"
    found = symgen.diagnose(robot, tilted, parameters=known, effects=["base_tilt"])
    (tilt,) = found.effects
    change = np.array([p.value for p in tilt.parameters])
    assert [p.name for p in tilt.parameters] == ["dgx", "dgy"]
    angle = np.radians(20.0)  # the noise of a torque is 1 %, and 100 rows are independent
    assert change == pytest.approx(-9.81 * np.array([np.sin(angle), np.cos(angle) - 1]), abs=0.06)
    assert found.after.total < 1.2 * found.floor.total
