"""Faults of the recorder, beside physics that the robot file lacks: both are named."""

from __future__ import annotations

import numpy as np
import pytest
from support import sampled

pytest.importorskip("pinocchio")

from oracles import planar2r
from oracles.hidden.engines import PinocchioEngine
from support_diagnose import log_of
from workflow.test_diagnose_kinds import (
    ARM,
    Edit,
    Log,
    diagnosed,
    named,
    on,
    recorded,
    turned,
    value,
)

import symgen

SPRUNG = on(ARM, 1, lambda q, _: -25 * (q[..., 1] - 0.6))


def late(seconds: float, *joints: int) -> Edit:
    """Torques of some joints that a recorder writes later."""

    def edit(log: Log) -> Log:
        n = round(seconds * ARM.rate)
        tau = log["tau"].copy()
        for j in joints:
            tau[:, j] = np.r_[np.repeat(tau[0, j], n), tau[:-n, j]]
        return log | {"tau": tau}

    return edit


def cut(j: int, part: float) -> Edit:
    """A torque that is cut at a part of its peak, before the noise of the channel."""

    def edit(log: Log) -> Log:
        tau, rng = log["tau"].copy(), np.random.default_rng(7)
        limit = part * np.abs(tau[:, j]).max()
        noise = 0.005 * np.std(tau[:, j]) * rng.normal(size=len(tau))
        tau[:, j] = np.clip(tau[:, j], -limit, limit) + noise
        return log | {"tau": tau}

    return edit


DELAYS = {
    "joint 2 by 0.2 s": (0.2, (1,), ((2,),)),
    "joint 3 by 0.05 s": (0.05, (2,), ((3,),)),
    "all by 0.3 s": (0.3, (0, 1, 2), ((),)),
}


@pytest.mark.parametrize("which", sampled(DELAYS, 1, always=["joint 2 by 0.2 s"]))
def test_a_delay_and_a_spring_are_both_named(which: str) -> None:
    seconds, joints, said = DELAYS[which]
    answer = diagnosed(SPRUNG, 51, believed=ARM, edit=late(seconds, *joints))
    assert set(named(answer)) == {("gravity_spring", (2,)), ("time_delay", *said)}
    assert value(answer, "DT") == pytest.approx(seconds, abs=1e-3)
    assert value(answer, "K2") == pytest.approx(25, rel=0.05)
    assert answer.after.total < 1.3 * answer.floor.total


def test_a_late_torque_alone_is_no_physics() -> None:
    answer = diagnosed(ARM, 52, edit=late(0.4, 0, 1, 2))
    assert named(answer) == [("time_delay", ())]
    assert answer.verdict == "bad-measurement"


CUTS: dict[str, tuple[int, float, tuple[int, str]]] = {
    "joint 2 without its Coulomb friction": (1, 0.7, (1, "coulomb")),
    "joint 2 without Coulomb friction of joint 3": (1, 0.6, (2, "coulomb")),
    "joint 3 without its Coulomb friction": (2, 0.8, (2, "coulomb")),
}


@pytest.mark.parametrize("which", sampled(CUTS, 1, always=["joint 2 without its Coulomb friction"]))
def test_a_cut_torque_and_friction_are_both_named(which: str) -> None:
    j, part, (k, word) = CUTS[which]
    answer = diagnosed(ARM, 53, undeclared=[(k, word)], edit=cut(j, part))
    assert set(named(answer)) == {("saturation", (j + 1,)), ("coulomb_friction", (k + 1,))}
    own = next(p for e in answer.effects for p in e.parameters if p.name == f"FS{k + 1}")
    assert abs(own.value - ARM.coulomb[k]) < 3 * own.std
    assert answer.after.total < 1.3 * answer.floor.total


def lacking(share: float) -> Edit:
    """Torques that lack a share of what the links weigh."""
    links = PinocchioEngine(ARM)
    return lambda log: (
        log | {"tau": log["tau"] - share * links.torque(log["q"], 0 * log["q"], 0 * log["q"])}
    )


def moved(log: Log) -> Log:
    """A position that steps while the robot moves."""
    q = log["q"].copy()
    q[:, 1] += 0.2 * (log["t"] > 5)
    return log | {"q": q}


def dead(log: Log) -> Log:
    """A torque that keeps one value for the last part of a log."""
    tau, t = log["tau"].copy(), log["t"]
    at = t > 0.45 * t[-1]
    tau[at, 2] = tau[at, 2][0]
    return log | {"tau": tau}


def reversed_in_time(log: Log) -> Log:
    return log | {"q": log["q"][::-1], "qd": -log["qd"][::-1], "tau": log["tau"][::-1]}


#: What only a new record mends, by its kind, and the joints.
LASTING: dict[str, tuple[tuple[int, ...], Edit]] = {
    "sign": ((2,), turned(1)),
    "time": ((), reversed_in_time),
    "step": ((2,), moved),
    "stuck": ((3,), dead),
    "weightless": ((), lacking(1.0)),
    "upside down": ((), lacking(2.0)),
}


@pytest.mark.parametrize("kind", sampled(LASTING, 1, always=["weightless"]))
def test_no_fault_ends_the_search(kind: str) -> None:
    joints, edit = LASTING[kind]
    answer = diagnosed(SPRUNG, 51, believed=ARM, edit=edit)
    assert named(answer) == [("gravity_spring", (2,))]
    assert value(answer, "K2") == pytest.approx(25, rel=0.05)
    assert (kind, joints) in {(r.name, r.joints) for r in answer.rejected}
    assert answer.verdict == "bad-measurement"
    assert answer.after.total < 0.1 * answer.before.total or kind == "time"


def identified(edit: Edit) -> symgen.Estimate:
    logs = [log_of(kind, edit(recorded(ARM, ARM, kind, 52))) for kind in ("train", "validation")]
    robot = symgen.parse_robot(ARM.robot_toml())
    return symgen.identify(robot, logs[:1], validation=logs[1:])


def test_identify_undoes_a_long_delay_and_chooses_its_band_behind_it() -> None:
    estimate = identified(late(0.3, 0, 1, 2))
    assert estimate.verdict == "trusted"
    assert estimate.torque_validation.relative < 0.003
    assert any("300 ms late" in r.fault for r in estimate.repairs)


@pytest.mark.parametrize(
    ("edit", "says"),
    [(late(0.1, 1), "tau2 is about 100 ms late"), (cut(1, 0.7), "tau2 is clipped at")],
)
def test_identify_does_not_trust_a_late_or_cut_torque(edit: Edit, says: str) -> None:
    estimate = identified(edit)
    assert estimate.verdict == "doubtful"
    assert says in estimate.reasons[0]


def with_late_speeds(seed: int) -> symgen.Log:
    """A planar arm with much friction, whose measured speeds have noise and are 0.5 ms late."""
    rng, X = np.random.default_rng(seed), np.array([3.7, 0.8, 1.2, 0.3])
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, 0.5) for s in zip(q, qd, qdd, strict=True)])
    tau += np.array([25.0, 8.0]) * np.sign(qd) + 0.5 * qd + 0.005 * rng.normal(size=tau.shape)
    noise = 0.003 * np.std(qd, axis=0) * rng.normal(size=q.shape)
    return symgen.make_log(f"log {seed}", t, q, tau, qd - 5e-4 * qdd + noise)


def test_a_repair_is_not_credited_with_what_derived_speeds_do() -> None:
    """The torque error falls where the band has derived speeds, with the repair or without it."""
    robot = symgen.parse_robot(planar2r.robot_toml("late"), "late.toml")
    found = symgen.diagnose(
        robot, with_late_speeds(2), validation=with_late_speeds(3), effects=["viscous_friction"]
    )
    assert any("0.51 ms late" in r.fault for r in found.repairs)
    assert (found.verdict, found.effects) == ("consistent", ())
