"""Channels in each other's place, counted the other way round, or scaled: said by both commands.

Logs are those of the two-link arm's closed form, written by hand in plain NumPy; the faults are
those of tests/oracles/faults.py. The long study is fault_study.py.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from oracles.planar2r import harmonic_motion, torque_regressor
from support import sampled

import symgen
from symgen.diagnosis.workflow import diagnose

X = np.array([1.7, 0.15, 0.3, 0.02])
Channels = dict[str, np.ndarray]


def _swap(*keys: str) -> Callable[[Channels], None]:
    def spoil(x: Channels) -> None:
        for key in keys:
            x[key] = x[key][:, ::-1].copy()

    return spoil


def _geared(ratio: float, j: int) -> Callable[[Channels], None]:
    def spoil(x: Channels) -> None:
        for key, factor in (("q", 1 / ratio), ("qd", 1 / ratio), ("tau", ratio)):
            _times(factor, j, key)(x)

    return spoil


def _times(factor: float, j: int, *keys: str) -> Callable[[Channels], None]:
    def spoil(x: Channels) -> None:
        for key in keys:
            x[key] = x[key].copy()
            x[key][:, j] *= factor

    return spoil


#: The fault, the channels that have to be named, and a word.
FAULTS = {
    "motions exchanged": (_swap("q", "qd"), ("q1", "qd2"), "are exchanged"),
    "joints exchanged": (_swap("q", "qd", "tau"), ("q1", "tau2"), "are exchanged"),
    "torques exchanged": (_swap("tau"), ("tau1", "tau2"), "are exchanged"),
    # Turned joints are links whose MX2 is negative: the two cannot be told apart on this arm.
    "a motion turned": (_times(-1.0, 1, "q", "qd"), ("2",), "the wrong sign"),
    "a torque turned": (_times(-1.0, 1, "tau"), ("2",), "the wrong sign"),
    "a torque scaled": (
        _times(1.6, 1, "tau"),
        ("tau2",),
        "as large as the other joints require",
    ),
    "a torque in N mm": (
        _times(1e3, 0, "tau"),
        ("tau1",),
        "as large as the other joints require",
    ),
    "another gear ratio": (_geared(1.6, 1), ("q2", "tau2"), "gear ratio of joint 2 is off by a"),
    "a motion in degrees": (_times(180 / np.pi, 1, "q", "qd"), ("q2", "qd2"), "degrees"),
}


def _logs(folder: Path, spoil: Callable[[Channels], None] | None) -> list[Path]:
    out = []
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        t, q, qd, qdd = harmonic_motion(rng, seed)
        tau = torque_regressor(q, qd, qdd, 0.5) @ X
        tau += 0.02 * tau.std(axis=0) * rng.normal(size=tau.shape)
        channels = {"q": q, "qd": qd, "tau": tau}
        if spoil is not None:
            spoil(channels)
        out.append(folder / f"log{seed}.npz")
        np.savez(out[-1], t=t, **channels)
    return out


@pytest.mark.parametrize(
    "fault", sampled(FAULTS, 2, always=["motions exchanged", "another gear ratio"])
)
def test_a_fault_of_channels_is_named_by_both_commands(fault: str, tmp_path: Path) -> None:
    spoil, channels, word = FAULTS[fault]
    train, test = _logs(tmp_path, spoil)
    try:
        estimate = symgen.identify("planar2r", train, validation=test)
    except symgen.LogError as refused:
        assert fault == "a motion in degrees"
        assert "degrees" in str(refused)
        return
    assert estimate.verdict == "doubtful"
    said = estimate.reasons[0]
    assert word in said
    assert all(channel in said for channel in channels)
    if "times" in word:
        # Of two joints, either can be meant, and both are said.
        factor = float(re.search(rf"{channels[0]}(?: is)? (\S+) times", said)[1])
        assert factor == pytest.approx({"tau1": 1e3, "tau2": 1.6}[channels[0]], rel=0.05)

    found = diagnose("planar2r", train, validation=test)
    assert found.verdict == "bad-measurement"
    assert found.after.total < 0.5 * found.before.total
    if fault == "a torque scaled":  # a spring may do as much: it is looked for beside the physics
        assert [e.name for e in found.effects] == ["drive_gain_error"]
        return
    told = " ".join([*found.advice, *found.notes, *(e.name for e in found.effects)])
    assert word in told
    assert all(channel in told for channel in channels)


def test_sound_channels_are_not_blamed(tmp_path: Path) -> None:
    train, test = _logs(tmp_path, None)
    estimate = symgen.identify("planar2r", train, validation=test)
    assert (estimate.verdict, estimate.repairs) == ("trusted", ())
    assert diagnose("planar2r", train, validation=test).verdict == "consistent"


@pytest.mark.parametrize(
    ("factor", "says"), [(1.0, ""), (1e3, "kg at least"), (1e-3, "kg at most")]
)
def test_what_no_robot_weighs_is_noted(factor: float, says: str, tmp_path: Path) -> None:
    def spoil(x: Channels) -> None:
        x["tau"] = factor * x["tau"]

    train, test = _logs(tmp_path, spoil)
    notes = symgen.identify("planar2r", train, validation=test).to_json()["notes"]
    found = [note for note in notes if "look at the units" in note]
    assert len(found) == bool(says)
    assert all(says in note for note in found)
