"""What diagnose once got wrong, a simulated log of each kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from oracles.pinocchio_arm import load_pinocchio

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

from oracles import stiction
from oracles.hidden.cases import Case, case
from oracles.hidden.engines import PinocchioEngine
from oracles.hidden.machines import MACHINES, Machine
from oracles.hidden.motion import STEP, generator
from oracles.hidden.simulate import simulate
from oracles.hidden.sizes import rms
from support import sampled
from support_diagnose import log_of

import symgen

Log = dict[str, np.ndarray]
Edit = Callable[[Log], Log]
ARM, PLANAR, SIX = (MACHINES[name] for name in ("arm3r", "planar2r", "arm6r"))


@cache
def _run(machine: Machine, believed: Machine, kind: str, seed: int) -> Log:
    run = simulate(machine, believed, kind, seed)
    every, rng = round(1 / (machine.rate * STEP)), generator("kinds", machine.name, kind, seed)
    q, tau = run.motion.q[::every], run.tau[::every]
    return {
        "t": run.motion.t[::every],
        "q": np.round(q / machine.resolution) * machine.resolution,
        "qd": run.motion.qd[::every] + machine.tacho * rng.normal(size=q.shape),
        "tau": tau + 0.01 * rms(tau) * rng.normal(size=tau.shape),
    }


def recorded(machine: Machine, believed: Machine, kind: str, seed: int) -> Log:
    """A log of a machine that is taken for another, to be edited."""
    return dict(_run(machine, believed, kind, seed))


def diagnosed(
    machine: Machine,
    seed: int,
    *,
    believed: Machine | None = None,
    undeclared: Iterable[tuple[int, str]] = (),
    edit: Edit = lambda log: log,
    one: bool = False,
    **options: float,
) -> symgen.Diagnosis:
    """Diagnose a robot file of `believed` on logs of `machine`."""
    known = believed or machine
    robot = symgen.parse_robot(known.robot_toml(undeclared))
    logs = [log_of(k, edit(recorded(machine, known, k, seed))) for k in ("train", "validation")]
    return symgen.diagnose(robot, logs[:1], validation=[] if one else logs[1:], **options)


def stuck(
    believed: Machine, seed: int, points: str, undeclared: Iterable[tuple[int, str]] = (), **how
) -> symgen.Diagnosis:
    """Diagnose logs of joints that stick."""
    robot = symgen.parse_robot(believed.robot_toml(undeclared))
    logs = [
        log_of(kind, stiction.recorded(believed, believed, seed, kind, points=points, **how))
        for kind in ("train", "validation")
    ]
    return symgen.diagnose(robot, logs[:1], validation=logs[1:])


def named(answer: symgen.Diagnosis) -> list[tuple[str, tuple[int, ...]]]:
    return [(e.name, e.joints) for e in answer.effects]


def value(answer: symgen.Diagnosis, name: str) -> float:
    return next(p.value for e in answer.effects for p in e.parameters if p.name == name)


def on(machine: Machine, j: int, law: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Machine:
    """The machine with one more torque on a joint, from positions and speeds."""

    def torque(_: float, q: np.ndarray, qd: np.ndarray, __: np.ndarray) -> np.ndarray:
        out = np.zeros(q.shape)
        out[..., j] = law(q, qd)
        return out

    return replace(machine, extra=(*machine.extra, torque))


def test_coulomb_friction_that_is_not_declared_is_named_from_one_log() -> None:
    polar = MACHINES["polar3"]
    answer = diagnosed(polar, 1, undeclared=[(2, "coulomb")], one=True)
    assert named(answer) == [("coulomb_friction", (3,))]
    assert value(answer, "FS3") == pytest.approx(polar.coulomb[2], rel=0.02)
    assert answer.verdict == "explained"


@pytest.mark.parametrize(("K", "q0"), sampled([(60.0, 1.0), (120.0, 1.4)], 1))
def test_a_spring_that_carries_gravity_is_named(K: float, q0: float) -> None:
    machine = on(ARM, 1, lambda q, _: -K * (q[..., 1] - q0))
    answer = diagnosed(machine, 2, believed=ARM)
    assert named(answer) == [("gravity_spring", (2,))]
    assert value(answer, "K2") == pytest.approx(K, rel=0.05)
    assert answer.after.per_joint[1] < 0.1 * answer.before.per_joint[1]


def test_a_spring_like_gravity_is_no_ripple() -> None:
    machine = on(PLANAR, 1, lambda q, _: -8 * (q[..., 1] - 0.4))
    answer = diagnosed(machine, 5, believed=PLANAR)
    assert named(answer) == [("gravity_spring", (2,))]


def carried(machine: Machine, j: int, share: float) -> Machine:
    links = PinocchioEngine(machine)

    def weight(q: np.ndarray, _: np.ndarray) -> np.ndarray:
        rows = np.atleast_2d(q)
        return share * links.torque(rows, 0 * rows, 0 * rows)[:, j].reshape(q.shape[:-1])

    return on(machine, j, weight)


def test_gravity_compensation_is_named_with_its_share() -> None:
    answer = diagnosed(carried(ARM, 1, 0.5), 6, believed=ARM)
    assert named(answer) == [("gravity_compensation", (2,))]
    assert value(answer, "GC2") == pytest.approx(0.5, abs=0.01)
    lengths = [[float(j.d) for j in r.joints] for r in (answer.declared, answer.extended)]
    assert lengths[0] == lengths[1]


def test_a_zero_that_is_off_is_named_and_goes_into_the_robot() -> None:
    def off(log: Log) -> Log:
        q = log["q"].copy()
        q[:, 1] -= np.radians(3)
        return log | {"q": q}

    answer = diagnosed(SIX, 21, edit=off)
    assert named(answer) == [("zero_offset", (2,))]
    assert value(answer, "DZ2") == pytest.approx(np.radians(3), rel=0.05)
    theta = float(answer.extended.joint(2).theta - answer.declared.joint(2).theta)
    assert theta == pytest.approx(np.radians(3), rel=0.05)
    assert answer.after.total < 1.2 * answer.floor.total


def test_friction_that_turns_over_a_range_of_speeds_is_named() -> None:
    smooth = replace(ARM, width=np.array([4e-3, 0.15, 4e-3]))
    answer = diagnosed(smooth, 23, believed=ARM)
    assert named(answer) == [("smooth_friction", (2,))]
    assert value(answer, "FSM2") == pytest.approx(ARM.coulomb[1], rel=0.05)
    assert value(answer, "w2") == pytest.approx(0.15, rel=0.05)


def test_friction_of_two_laws_is_found_at_once() -> None:
    """One law alone explains less than another one of their shape (a power of the speed)."""
    smooth = replace(ARM, width=np.array([4e-3, 0.15, 4e-3]))
    answer = diagnosed(smooth, 23, believed=ARM, undeclared=[(1, "coulomb")])
    assert {*named(answer)} == {("coulomb_friction", (2,)), ("smooth_friction", (2,))}
    assert answer.after.total < 1.3 * answer.floor.total


def _case(effect: str, size: str, seed: int) -> tuple[Case, symgen.Diagnosis]:
    """Return a hidden case and what is said of it."""
    run = case("arm3r", effect, size, seed)
    train, validation = log_of("train", run.train), log_of("v", run.validation)
    robot = symgen.parse_robot(run.robot_toml)
    return run, symgen.diagnose(robot, [train], validation=[validation])


def test_small_backlash_is_not_a_part_of_the_whole_gap() -> None:
    run, answer = _case("backlash", "moderate", 7)
    assert answer.verdict != "consistent"
    assert {j for _, joints in named(answer) for j in joints} == set(run.truth[0][1])


def test_a_coupling_whose_inertia_the_links_have_as_well_is_named() -> None:
    run, answer = _case("coupled_transmission", "moderate", 40073)
    assert named(answer) == [("coupled_transmission", (2, 3))]
    assert (np.array(answer.after.per_joint) < 1.3 * run.floor).all()


def turned(*joints: int) -> Edit:
    def edit(log: Log) -> Log:
        tau = log["tau"].copy()
        tau[:, list(joints)] *= -1
        return log | {"tau": tau}

    return edit


@pytest.mark.parametrize(
    ("machine", "joints"), sampled([(SIX, (1, 2)), (SIX, (3,)), (ARM, (0, 2)), (ARM, ())], 1)
)
def test_turned_torques_are_told_apart_from_sound_ones(
    machine: Machine, joints: tuple[int, ...]
) -> None:
    answer = diagnosed(machine, 9, edit=turned(*joints))
    told = {(r.name, r.joints) for r in answer.rejected if r.name == "sign"}
    assert told == {("sign", (j + 1,)) for j in joints}
    assert answer.verdict == ("bad-measurement" if joints else "consistent")


@pytest.mark.parametrize("seconds", [0.06, 0.2])
def test_late_speeds_are_undone_on_all_joints(seconds: float) -> None:
    def late(log: Log) -> Log:
        n = round(seconds * ARM.rate)
        return log | {"qd": np.vstack([np.repeat(log["qd"][:1], n, axis=0), log["qd"][:-n]])}

    answer = diagnosed(ARM, 10, edit=late)
    assert {e.name for e in answer.effects} == {"velocity_sensor_error"}
    assert answer.after.total < 1.2 * answer.floor.total


def test_physics_is_looked_for_behind_slow_speeds() -> None:
    from scipy.signal import butter, sosfiltfilt

    def slow(log: Log) -> Log:
        sos = butter(1, 10, fs=ARM.rate, output="sos")
        return log | {"qd": sosfiltfilt(sos, log["qd"], axis=0)}

    machine = on(
        ARM, 2, lambda _, v: -1.2 * np.tanh(v[..., 2] / 4e-3) * np.exp(-((v[..., 2] / 0.12) ** 2))
    )
    answer = diagnosed(machine, 11, believed=ARM, edit=slow, cutoff=50.0)
    assert named(answer)[0] == ("stribeck_friction", (3,))
    assert answer.after.total < 0.3 * answer.before.total


@pytest.mark.parametrize("channel", ["tau2", "q3"])
def test_a_channel_of_zeros_is_said_at_once(channel: str) -> None:
    def dead(log: Log) -> Log:
        x = log[channel[:-1]].copy()
        x[:, int(channel[-1]) - 1] = 0.0
        return log | {channel[:-1]: x}

    answer = diagnosed(ARM, 12, edit=dead)
    assert answer.verdict == "bad-measurement"
    assert channel in answer.advice[0]


def test_speeds_of_zeros_are_derived() -> None:
    answer = diagnosed(ARM, 12, edit=lambda log: log | {"qd": 0 * log["qd"]})
    assert answer.verdict == "consistent"
    assert {r.channel for r in answer.repairs} == {"qd1", "qd2", "qd3"}


@pytest.mark.parametrize(
    ("name", "points"),
    sampled([("arm3r", "together"), ("scara", "apart"), ("arm5r", ""), ("polar3", "together")], 2),
)
def test_joints_that_stick_are_consistent(name: str, points: str) -> None:
    answer = stuck(MACHINES[name], 40, points)
    assert (answer.verdict, named(answer)) == ("consistent", [])


def _at(j: int, law: Callable[[np.ndarray], float]) -> stiction.Law:
    def torque(_: float, q: np.ndarray, __: np.ndarray) -> np.ndarray:
        return np.eye(3)[j] * law(q)

    return torque


def _loaded(_: np.ndarray, tau: np.ndarray) -> np.ndarray:
    return ARM.coulomb + np.array([0, 0.12 * abs(tau[1]), 0])


STUCK = {
    "coulomb": (("coulomb_friction", (3,)), "together", {"undeclared": [(2, "coulomb")]}),
    "offset": (("torque_offset", (2,)), "together", {"extra": _at(1, lambda _: 2.5)}),
    "ripple": (("torque_ripple", (3,)), "apart", {"extra": _at(2, lambda q: np.sin(12 * q[2]))}),
    "load": (("load_dependent_friction", (2,)), "together", {"limit": _loaded}),
}


@pytest.mark.parametrize("hidden", sampled(list(STUCK), 2))
def test_effects_are_named_between_rests_and_nothing_else(hidden: str) -> None:
    effect, points, how = STUCK[hidden]
    answer = stuck(ARM, 30, points, **how)
    assert named(answer) == [effect]
    assert answer.verdict == "explained"
    assert any("of joints in motion" in note for note in answer.notes)
