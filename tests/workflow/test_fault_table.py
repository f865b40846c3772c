"""Faults of recorders and files, put into one sound log: what is undone, named or refused.

The log is `sound` of tests/logs: an arm of three joints by Pinocchio. A fault is a function of the
channels t, q, qd, tau; it is put into both logs, as one recorder wrote them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from stored_logs import Channels, made, stored

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
    spoil: Spoil


FAULTS = {n: Row(s) for n, s in {
    "none": lambda x: x,
    "held torque": over("tau", held, 2),
    "spikes": over("tau", spikes, 3),
    "spikes of positions": over("q", spikes, 1),
    "speed turned": over("qd", lambda x: -x, 2),
    "speed rpm": over("qd", lambda x: x * 30 / np.pi, 2),
    "speed moved": over("qd", lambda x: x + 0.3, 2),
    "speeds steps": over("qd", stepped(0.3), 2),
    "speeds zero": over("qd", lambda x: 0 * x),
    "speeds late": over("qd", later(6)),
    "speeds exchanged": exchanged("qd"),
    "wrapped": over("q", lambda x: np.angle(np.exp(2j * x)) / 2, 1),
    "jitter": jittered,
    "repeated": repeated,
    "lost": lost,
    "all torques late": over("tau", later(30)),
    "one torque late": over("tau", later(10), 2),
    "cut": over("tau", cut(0.7), 2),
    "torque steps": over("tau", stepped(30), 2),
    "position steps": over("q", stepped(0.2), 2),
    "torque turned": over("tau", lambda x: -x, 2),
    "all torques turned": over("tau", lambda x: -x),
    "motion turned": both(over("q", lambda x: -x, 2), over("qd", lambda x: -x, 2)),
    "torques exchanged": exchanged("tau"),
    "motions exchanged": exchanged("q", "qd"),
    "joints exchanged": exchanged("q", "qd", "tau"),
    "torque scaled": over("tau", lambda x: 1.6 * x, 2),
    "torque in N mm": over("tau", lambda x: 1e3 * x, 1),
    "all in N mm": over("tau", lambda x: 1e3 * x),
    "gear ratio": geared(1.6, 2),
    "position degrees": both(over("q", np.degrees, 2), over("qd", np.degrees, 2)),
    "reversed": reversed_in_time,
    "dead torque": over("tau", lambda x: 0 * x + 1.0, 2),
    "dead position": over("q", lambda x: 0 * x, 2),
    "zero": over("q", lambda x: x - 0.05, 2),
    "fast clock": lambda x: x | {"t": x["t"] * 0.9},
}.items()}


def sound_logs():
    log = stored("sound")
    return log.robot, log.train, log.test
