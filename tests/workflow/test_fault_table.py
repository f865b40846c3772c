"""Faults of recorders and files, put into one sound log: what is undone, named or refused.

The log is `sound` of tests/logs: an arm of three joints by Pinocchio. A fault is a function of the
channels t, q, qd, tau; it is put into both logs, as one recorder wrote them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from stored_logs import Channels, Stored, made, stored
from support import sampled

import symgen

Spoil = Callable[[Channels], Channels]


def over(key: str, change: Callable[[np.ndarray], np.ndarray], *joints: int) -> Spoil:
    """Change a channel of some joints (from 1), or of all."""

    def spoil(x: Channels) -> Channels:
        values = x[key].copy()
        for j in joints or range(1, 4):
            values[:, j - 1] = change(values[:, j - 1])
        return x | {key: values}

    return spoil


def both(*spoils: Spoil) -> Spoil:
    """Several faults, one after the other."""

    def spoil(x: Channels) -> Channels:
        for one in spoils:
            x = one(x)
        return x

    return spoil


def exchanged(*keys: str) -> Spoil:
    """Joints 1 and 2 in each other's place."""
    return lambda x: x | {key: x[key][:, [1, 0, 2]] for key in keys}


def later(n: int) -> Callable[[np.ndarray], np.ndarray]:
    """A channel n samples late."""
    return lambda x: np.r_[np.repeat(x[0], n), x[:-n]]


def held(x: np.ndarray) -> np.ndarray:
    """A channel that keeps its value for a fifth of the log."""
    begin, end = 2 * len(x) // 5, 3 * len(x) // 5
    return np.r_[x[:begin], np.full(end - begin, x[begin]), x[end:]]


def stepped(size: float) -> Callable[[np.ndarray], np.ndarray]:
    """A channel that is moved from the middle on."""
    return lambda x: x + size * (np.arange(len(x)) > len(x) // 2)


def spikes(x: np.ndarray) -> np.ndarray:
    """A channel with twelve samples of something else."""
    x = x.copy()
    x[100::130] += 5 * x.std()
    return x


def geared(ratio: float, j: int) -> Spoil:
    """Another gear ratio of a joint than was meant."""
    return both(
        over("q", lambda x: x / ratio, j),
        over("qd", lambda x: x / ratio, j),
        over("tau", lambda x: x * ratio, j),
    )


def reversed_in_time(x: Channels) -> Channels:
    return x | {"q": x["q"][::-1], "qd": -x["qd"][::-1], "tau": x["tau"][::-1]}


def jittered(x: Channels) -> Channels:
    """Stamps of a host that wakes up late."""
    rng = np.random.default_rng(5)
    step = x["t"][1] - x["t"][0]
    return x | {"t": x["t"] + np.minimum(rng.exponential(0.2 * step, len(x["t"])), 0.9 * step)}


def repeated(x: Channels) -> Channels:
    """One row of twenty says what the one before said."""
    index = np.arange(len(x["t"]))
    index[19::20] -= 1
    return {key: value if key == "t" else value[index] for key, value in x.items()}


def lost(x: Channels) -> Channels:
    """A second of the log is missing."""
    keep = np.ones(len(x["t"]), bool)
    keep[700:800] = False
    return {key: value[keep] for key, value in x.items()}


def cut(part: float) -> Callable[[np.ndarray], np.ndarray]:
    """A torque that is cut at a part of its peak."""
    return lambda x: np.clip(x, -part * np.abs(x).max(), part * np.abs(x).max())


@dataclass(frozen=True)
class Row:
    """A fault, what `identify` repairs and says of it, and what `diagnose` says.

    Attributes:
        spoil: puts it into the channels of a log.
        repairs: channel and kind of every repair.
        values: what the repairs measured, and how far off it may be.
        blames: kind of the first reason; "" where the estimate is trusted.
        verdict: of `diagnose`.
        effects: of `diagnose`.
        left: most of the torque error that `diagnose` leaves.
    """

    spoil: Spoil
    repairs: tuple[tuple[str, str], ...] = ()
    values: dict[str, tuple[float, float]] = field(default_factory=dict)
    blames: str = ""
    verdict: str = "consistent"
    effects: tuple[tuple[str, tuple[int, ...]], ...] = ()
    left: float = 0.007


BAD, MENDED = "bad-measurement", "explained"
EXCHANGED = ("exchanged_channels", (1, 2))
FAULTS = {
    "none": Row(lambda x: x),
    # What is repaired.
    "torque held": Row(over("tau", held, 2), (("tau2", "stuck"),)),
    "torque with spikes": Row(over("tau", spikes, 3), (("tau3", "jumps"),)),
    "position with spikes": Row(over("q", spikes, 1), (("q1", "jumps"),)),
    "torque cut": Row(
        over("tau", cut(0.7), 2), (("tau2", "saturated"),), verdict=BAD,
        effects=(("saturation", (2,)),),
    ),
    "torques late": Row(
        over("tau", later(30)),
        (("tau", "stuck"), ("tau", "delay")), {"DT": (0.3, 0.01)},
        left=0.03,
    ),
    "speed turned": Row(
        over("qd", lambda x: -x, 2), (("qd2", "speed"),)
    ),
    "speed in rpm": Row(
        over("qd", lambda x: x * 30 / np.pi, 2), (("qd2", "speed"),), {"GV": (8.549, 0.01)}
    ),
    "speed moved": Row(
        over("qd", lambda x: x + 0.3, 2), (("qd2", "speed"),), {"OV": (0.3, 0.001)}
    ),
    "speeds late": Row(
        over("qd", later(6)), (("qd", "speed"),), {"LV": (0.06, 0.001)}
    ),
    "speeds exchanged": Row(
        exchanged("qd"), (("qd1, qd2", "speed"),)
    ),
    "speeds of zeros": Row(
        over("qd", lambda x: 0 * x), (("qd", "speed"),)
    ),
    "stamps of a host": Row(jittered, (("t", "jitter"),)),
    "rows repeated": Row(repeated, (("all", "stalled"),)),
    "a second lost": Row(lost),
    # What only a new record mends, or [drive] in the robot file.
    "torque late": Row(
        over("tau", later(10), 2), (("tau2", "delay"),), {"DT": (0.1, 0.003)},
    ),
    "torque turned": Row(
        over("tau", lambda x: -x, 2), blames="wrong_sign", verdict=MENDED,
        effects=(("wrong_sign", (2,)),),
    ),
    "torques turned": Row(
        over("tau", lambda x: -x), blames="no_robot", verdict=MENDED,
        effects=(("wrong_sign", (1, 2, 3)),),
    ),
    "motion turned": Row(
        both(over("q", lambda x: -x, 2), over("qd", lambda x: -x, 2)), blames="wrong_sign",
        verdict=MENDED, effects=(("wrong_sign", (2,)),), left=0.025,
    ),
    "torques exchanged": Row(
        exchanged("tau"), blames="exchanged_channels", verdict=BAD, effects=(EXCHANGED,)
    ),
    "motions exchanged": Row(
        exchanged("q", "qd"), blames="exchanged_channels", verdict=BAD, effects=(EXCHANGED,),
        left=0.02,
    ),
    "joints exchanged": Row(
        exchanged("q", "qd", "tau"), blames="exchanged_channels", verdict=BAD, effects=(EXCHANGED,)
    ),
    "torque scaled": Row(
        over("tau", lambda x: 1.6 * x, 2), blames="drive_gain_error", verdict=MENDED,
        effects=(("drive_gain_error", (2,)),),
    ),
    "torque in N mm": Row(
        over("tau", lambda x: 1e3 * x, 1), blames="error", verdict="unexplained", left=0.2,
    ),
    "gear ratio": Row(
        geared(1.6, 2), blames="gear_ratio", verdict=MENDED, effects=(("gear_ratio", (2,)),),
    ),
    "position steps": Row(
        over("q", stepped(0.2), 2), blames="broken_channel", verdict=BAD, left=0.06,
    ),
    "torque steps": Row(
        over("tau", stepped(30), 2), blames="error", verdict="unexplained", left=0.5
    ),
    "time reversed": Row(
        reversed_in_time, blames="no_robot", verdict=BAD,
    ),
    "torque dead": Row(
        over("tau", lambda x: 0 * x + 1.0, 2), blames="broken_channel", verdict=BAD, left=0.5,
    ),
}  # fmt: skip
#: What the default suite leaves out.
RARE = (
    "position with spikes", "speed moved", "speeds exchanged", "a second lost", "torques turned",
    "motion turned", "motions exchanged", "torque in N mm", "torque with spikes", "torque steps",
    "gear ratio", "torques late",
)  # fmt: skip


@pytest.fixture(scope="module")
def sound() -> Stored:
    """The arm and its logs without a fault; its model is compiled here."""
    log = stored("sound")
    symgen.identify(log.robot, made("train", log.train), validation=made("test", log.test))
    return log


def spoiled(log: Stored, spoil: Spoil) -> tuple[symgen.Log, symgen.Log]:
    """Both logs with a fault."""
    return made("train", spoil(log.train)), made("test", spoil(log.test))


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("what", sampled(FAULTS, 0, always=[k for k in FAULTS if k not in RARE]))
def test_a_fault_is_repaired_or_named(sound: Stored, what: str) -> None:
    row = FAULTS[what]
    train, test = spoiled(sound, row.spoil)
    estimate = symgen.identify(sound.robot, train, validation=test)
    assert {(r.channel, r.kind) for r in estimate.repairs} == set(row.repairs)
    measured = {name: value for r in estimate.repairs for name, value, _ in r.values}
    for name, (value, off) in row.values.items():
        assert measured[name] == pytest.approx(value, abs=off)
    assert estimate.verdict == ("doubtful" if row.blames else "trusted"), estimate.reasons
    if row.blames:
        assert estimate.reasons[0].kind == row.blames
    if not row.blames:
        assert estimate.torque_validation.relative < row.left

    found = symgen.diagnose(sound.robot, train, validation=test)
    assert {(e.name, e.joints) for e in found.effects if e.shown} == {*row.effects}
    assert found.verdict == row.verdict
    assert {(r.channel, r.kind) for r in found.repairs} == set(row.repairs)
    assert (found.corrected or found.after).total < row.left


#: A fault beside physics that the robot file lacks: case, fault, effect.
BOTH = {
    "late and a spring": ("sprung", over("tau", later(20), 2), None),
    "cut and friction": ("no_coulomb", over("tau", cut(0.7), 2), ("saturation", (2,))),
    "turned and a spring": ("sprung", over("tau", lambda x: -x, 2), ("wrong_sign", (2,))),
}
PHYSICS = {"sprung": ("gravity_spring", (2,)), "no_coulomb": ("coulomb_friction", (2,))}


@pytest.mark.parametrize("what", sampled(BOTH, 0, always=["late and a spring", "cut and friction"]))
def test_a_fault_does_not_hide_what_the_robot_file_lacks(what: str) -> None:
    case, spoil, effect = BOTH[what]
    log = stored(case)
    train, test = spoiled(log, spoil)
    found = symgen.diagnose(log.robot, train, validation=test)
    named = {PHYSICS[case]} | ({effect} if effect else set())
    assert {(e.name, e.joints) for e in found.effects if e.adopted} == named
    values = {p.name: p.value for e in found.effects for p in e.parameters}
    values |= {name: value for r in found.repairs for name, value, _ in r.values}
    assert values.get("K2", 25.0) == pytest.approx(25.0, rel=0.1)
    assert values.get("FS2", 5.0) == pytest.approx(5.0, rel=0.05)
    assert values.get("DT", 0.2) == pytest.approx(0.2, abs=0.01)


def test_positions_in_degrees_are_refused_with_the_option(sound: Stored) -> None:
    turned = both(over("q", np.degrees, 2), over("qd", np.degrees, 2))
    with pytest.raises(symgen.LogError, match=r"q2.*--unit"):
        spoiled(sound, turned)


def test_a_joint_that_does_not_move_is_refused_with_the_command(sound: Stored) -> None:
    logs = spoiled(sound, over("q", lambda x: 0 * x, 2))
    for verb in (symgen.identify, symgen.diagnose):
        with pytest.raises(symgen.IdentificationError, match=r"joint 2 .*--fix 2=0"):
            verb(sound.robot, logs[0], validation=logs[1])


def test_what_no_robot_weighs_is_noted(sound: Stored) -> None:
    logs = spoiled(sound, over("tau", lambda x: 1e3 * x))
    estimate = symgen.identify(sound.robot, logs[0], validation=logs[1])
    assert any("N mm" in note for note in estimate.to_json()["notes"])


@pytest.mark.parametrize(("ratio", "joint"), [("100, 80, 50", 0), ("100, -80, 50", 2)])
def test_a_gear_that_turns_the_other_way_is_named(
    sound: Stored, tmp_path: Path, ratio: str, joint: int
) -> None:
    text = symgen.robot_toml(sound.robot)
    robot = symgen.parse_robot(f"{text}\n[drive]\nratio = [{ratio}]\n")
    gears = np.array([100.0, 80.0, 50.0])
    for name, x in (("train", sound.train), ("test", sound.test)):
        motors = {"q": x["q"] * gears, "qd": x["qd"] * gears, "tau": x["tau"] / gears}
        motors = {key: values[:800] for key, values in (x | motors).items()}
        np.savez(tmp_path / f"{name}.npz", **motors)
    estimate = symgen.identify(
        robot, tmp_path / "train.npz", validation=tmp_path / "test.npz", model="torque"
    )
    assert estimate.verdict == ("doubtful" if joint else "trusted"), estimate.reasons
    assert not joint or f"joint {joint}" in " ".join(reason.text for reason in estimate.reasons)
