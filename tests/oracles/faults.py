"""Faults of instruments and recorders, put into logs of arrays.

Every fault is a function of a log, a seeded generator and, where it has one, a size; it returns the
spoiled log and a record of what was done. `LIGHT` are those that identify repairs or bears,
`HEAVY` those that have to be named. Joints are drawn, channels are named q, qd, tau and t with a
1-based joint, as columns of a log are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

Generator = np.random.Generator


@dataclass(frozen=True, eq=False)
class Log:
    """t (N,) s; q, qd (None where not measured), tau (N, n)."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray | None
    tau: np.ndarray

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def step(self) -> float:
        """Median step of the stamps, s."""
        return float(np.median(np.diff(self.t)))

    def save(self, path: Path) -> Path:
        """Write it as .npz."""
        speeds = {} if self.qd is None else {"qd": self.qd}
        np.savez(path, t=self.t, q=self.q, tau=self.tau, **speeds)
        return path

    def rows(self, index: np.ndarray) -> Log:
        """Samples by their index."""
        return Log(*(None if x is None else x[index] for x in (self.t, self.q, self.qd, self.tau)))

    def over(self, key: str, change: Callable[[np.ndarray], np.ndarray], *joints: int) -> Log:
        """Change a channel of some joints, or of all; one that was not measured stays away."""
        x = getattr(self, key)
        if x is None:
            return self
        x = x.copy()
        j = list(joints) or list(range(self.n))
        x[:, j] = change(x[:, j])
        return replace(self, **{key: x})


@dataclass(frozen=True)
class Fault:
    """What was done: its name, the channels (q2, tau3, t; empty: all) and its size."""

    name: str
    channels: tuple[str, ...]
    value: Any


Spoiled = tuple[Log, Fault]


def _named(keys: str, *joints: int) -> tuple[str, ...]:
    return tuple(f"{key}{j + 1}" for j in joints for key in keys.split())


def _joint(log: Log, rng: Generator) -> int:
    return int(rng.integers(log.n))


def _pair(log: Log, rng: Generator) -> tuple[int, int]:
    if log.n < 2:
        raise ValueError("two joints are exchanged: the log has one")
    j, k = rng.choice(log.n, 2, replace=False)
    return int(j), int(k)


def _part(log: Log, rng: Generator, low: float = 0.05, high: float = 0.3) -> slice:
    """A stretch of the log of that share of its length."""
    length = int(len(log.t) * rng.uniform(low, high))
    begin = int(rng.integers(1, len(log.t) - length))
    return slice(begin, begin + length)


def _shifted(t: np.ndarray, x: np.ndarray, delay: float | np.ndarray) -> np.ndarray:
    """x as it was `delay` seconds before."""
    return np.column_stack([np.interp(t - delay, t, column) for column in x.T])


# What identify repairs or bears.


def host_jitter(log: Log, rng: Generator) -> Spoiled:
    """Stamps of a host around a fixed clock: steps of 0.5 to 10 ms where 1 ms was meant.

    Rows are stamped when the host wakes up: late, several at once 0.5 ms apart, never before the
    one before them.
    """
    step, N = log.step, len(log.t)
    late = np.minimum(rng.exponential(0.4 * step, N), 3 * step)
    held = rng.random(N) < 0.01
    late[held] += rng.uniform(0, max(9e-3 - 3 * step, step), held.sum())
    # Each stamp at least half a step after the one before.
    least = 0.5 * step * np.arange(N)
    t = np.maximum.accumulate(log.t + late - least) + least
    return replace(log, t=t), Fault("host_jitter", ("t",), float(np.std(t - log.t)))


def repeated_rows(log: Log, rng: Generator) -> Spoiled:
    """1 to 10 % of the rows say what the one before said, under their own stamp."""
    share = rng.uniform(0.01, 0.1)
    index = np.arange(len(log.t))
    again = rng.random(len(index)) < share
    again[0] = False
    index = np.maximum.accumulate(np.where(again, 0, index))
    return replace(log.rows(index), t=log.t), Fault("repeated_rows", (), float(share))


def torque_quanta(log: Log, rng: Generator) -> Spoiled:
    """Torques in steps of up to 2 % of their RMS."""
    quantum = rng.uniform(0.002, 0.02, log.n) * np.sqrt(np.mean(log.tau**2, axis=0))
    spoiled = log.over("tau", lambda x: np.round(x / quantum) * quantum)
    return spoiled, Fault("torque_quanta", _named("tau", *range(log.n)), quantum.tolist())


def position_quanta(log: Log, rng: Generator) -> Spoiled:
    """Positions in steps of 1e-5 to 4e-4 rad."""
    quantum = float(10 ** rng.uniform(-5, np.log10(4e-4)))
    spoiled = log.over("q", lambda x: np.round(x / quantum) * quantum)
    return spoiled, Fault("position_quanta", _named("q", *range(log.n)), quantum)


def late_speeds(log: Log, rng: Generator) -> Spoiled:
    """All speeds 1 to 5 samples late."""
    k = int(rng.integers(1, 6))
    spoiled = log.over("qd", lambda x: np.concatenate([np.repeat(x[:1], k, axis=0), x[:-k]]))
    return spoiled, Fault("late_speeds", _named("qd", *range(log.n)), k * log.step)


def jumps(log: Log, rng: Generator) -> Spoiled:
    """1 to 20 single samples of q, qd or tau jump by 0.5 to 5 times the channel's spread."""
    keys = ["q", "tau"] if log.qd is None else ["q", "qd", "tau"]
    where = []
    for _ in range(int(rng.integers(1, 21))):
        key, j, k = str(rng.choice(keys)), _joint(log, rng), int(rng.integers(1, len(log.t) - 1))
        size = rng.choice([-1, 1]) * rng.uniform(0.5, 5) * np.std(getattr(log, key)[:, j])
        log = log.over(
            key, lambda x, k=k, size=size: x + size * (np.arange(len(x)) == k)[:, None], j
        )
        where.append((f"{key}{j + 1}", k))
    return log, Fault("jumps", tuple(sorted({channel for channel, _ in where})), where)


# What has to be named. Each also says on which channels.

TOGETHER = {"motion": "q qd", "torque": "tau", "all": "q qd tau"}


def swapped(log: Log, rng: Generator) -> Spoiled:
    """Two joints exchanged: q and qd, tau, or all three."""
    j, k = _pair(log, rng)
    kind = str(rng.choice(list(TOGETHER)))
    for key in TOGETHER[kind].split():
        log = log.over(key, lambda x: x[:, ::-1], j, k)
    return log, Fault("swapped", _named(TOGETHER[kind], *sorted((j, k))), kind)


def turned(log: Log, rng: Generator) -> Spoiled:
    """The sign of one joint's q and qd, of its qd, of its tau, or of all three."""
    j = _joint(log, rng)
    keys = str(rng.choice([*TOGETHER.values(), *([] if log.qd is None else ["qd"])]))
    for key in keys.split():
        log = log.over(key, np.negative, j)
    return log, Fault("turned", _named(keys, j), -1.0)


def degrees(log: Log, rng: Generator) -> Spoiled:
    """One joint's q and qd, or its q alone, in degrees."""
    j = _joint(log, rng)
    keys = str(rng.choice(["q", "q qd"]))
    for key in keys.split():
        log = log.over(key, np.rad2deg, j)
    return log, Fault("degrees", _named(keys, j), float(np.rad2deg(1)))


def milliseconds(log: Log, rng: Generator) -> Spoiled:
    """The stamps in ms, or one joint's speed per ms."""
    if log.qd is None or rng.random() < 0.5:
        return replace(log, t=1e3 * log.t), Fault("milliseconds", ("t",), 1e3)
    j = _joint(log, rng)
    return log.over("qd", lambda x: x / 1e3, j), Fault("milliseconds", _named("qd", j), 1e-3)


def newton_millimetres(log: Log, rng: Generator) -> Spoiled:
    """One joint's torque in N mm."""
    j = _joint(log, rng)
    return log.over("tau", lambda x: 1e3 * x, j), Fault("newton_millimetres", _named("tau", j), 1e3)


def _factor(rng: Generator) -> float:
    factor = rng.uniform(1.05, 2.0)
    return float(factor if rng.random() < 0.5 else 1 / factor)


def torque_gain(log: Log, rng: Generator) -> Spoiled:
    """One joint's torque constant is wrong by 1.05 to 2."""
    j, factor = _joint(log, rng), _factor(rng)
    return log.over("tau", lambda x: factor * x, j), Fault("torque_gain", _named("tau", j), factor)


def gear_ratio(log: Log, rng: Generator) -> Spoiled:
    """One joint's gear ratio is wrong by 1.05 to 2: q and qd too small, tau too large by it."""
    j, factor = _joint(log, rng), _factor(rng)
    for key, gain in (("q", 1 / factor), ("qd", 1 / factor), ("tau", factor)):
        log = log.over(key, lambda x, gain=gain: gain * x, j)
    return log, Fault("gear_ratio", _named("q qd tau", j), factor)


def torque_delay(log: Log, rng: Generator) -> Spoiled:
    """Torques 1 to 100 ms behind the motion: one joint's, all, or all by a delay that grows."""
    delay = float(10 ** rng.uniform(-3, -1))
    kind = str(rng.choice(["joint", "common", "drifting"]))
    j = [_joint(log, rng)] if kind == "joint" else list(range(log.n))
    by = delay * np.linspace(0, 1, len(log.t)) if kind == "drifting" else delay
    spoiled = log.over("tau", lambda x: _shifted(log.t, x, by), *j)
    return spoiled, Fault(f"torque_delay_{kind}", _named("tau", *j), delay)


def clipped(log: Log, rng: Generator) -> Spoiled:
    """Torques of one joint or of all limited at 40 to 90 % of their peak."""
    share = float(rng.uniform(0.4, 0.9))
    j = [_joint(log, rng)] if rng.random() < 0.5 else list(range(log.n))
    limit = share * np.abs(log.tau[:, j]).max(axis=0)
    return log.over("tau", lambda x: np.clip(x, -limit, limit), *j), Fault(
        "clipped", _named("tau", *j), share
    )


def stuck(log: Log, rng: Generator) -> Spoiled:
    """One joint's q, its tau, or all its channels stand still for 5 to 30 % of the log."""
    j, part = _joint(log, rng), _part(log, rng)
    keys = str(rng.choice(["q", "tau", "q qd tau"]))

    def hold(x: np.ndarray) -> np.ndarray:
        x[part] = x[part.start]
        return x

    for key in keys.split():
        log = log.over(key, hold, j)
    return log, Fault(
        "stuck", _named(keys, j), [float(log.t[part.start]), float(log.t[part.stop - 1])]
    )


def wrapped(log: Log, rng: Generator) -> Spoiled:
    """One joint's position jumps by a turn where it crosses a place of its range."""
    j = _joint(log, rng)
    at = float(np.quantile(log.q[:, j], rng.uniform(0.2, 0.8)))
    spoiled = log.over("q", lambda x: (x - at) % (2 * np.pi) + at, j)
    return spoiled, Fault("wrapped", _named("q", j), at)


def repeated_rows_moved(log: Log, rng: Generator) -> Spoiled:
    """5 to 30 % of the rows come twice, and all are stamped anew by an even clock."""
    share = rng.uniform(0.05, 0.3)
    counts = 1 + (rng.random(len(log.t)) < share)
    index = np.repeat(np.arange(len(log.t)), counts)
    t = np.linspace(log.t[0], log.t[-1], len(index))
    return replace(log.rows(index), t=t), Fault("repeated_rows_moved", (), float(share))


def held(log: Log, rng: Generator) -> Spoiled:
    """One kind of channel, or all, is read anew only every k-th sample, k from 2 to 20."""
    k = int(rng.integers(2, 21))
    keys = str(rng.choice(["q", "tau", "q qd tau"]))
    index = np.arange(len(log.t)) // k * k
    for key in keys.split():
        log = log.over(key, lambda x: x[index])
    return log, Fault("held", _named(keys, *range(log.n)), k)


def coarse(log: Log, rng: Generator) -> Spoiled:
    """One joint's q in steps of 2 to 20 mrad, or its tau in steps of 5 to 50 % of its RMS."""
    j, key = _joint(log, rng), str(rng.choice(["q", "tau"]))
    size = np.sqrt(np.mean(log.tau[:, j] ** 2))
    step = float(10 ** rng.uniform(-2.7, -1.7) if key == "q" else size * rng.uniform(0.05, 0.5))
    return log.over(key, lambda x: np.round(x / step) * step, j), Fault(
        "coarse", _named(key, j), step
    )


def spikes(log: Log, rng: Generator) -> Spoiled:
    """0.1 to 2 % of one channel's samples are off by 1 to 10 times its spread."""
    j, key, share = _joint(log, rng), str(rng.choice(["q", "tau"])), float(rng.uniform(1e-3, 0.02))
    hit = (rng.random(len(log.t)) < share)[:, None]
    size = np.std(getattr(log, key)[:, j]) * rng.uniform(1, 10, hit.shape)
    sign = rng.choice([-1, 1], hit.shape)
    return log.over(key, lambda x: x + hit * sign * size, j), Fault("spikes", _named(key, j), share)


def time_reversed(log: Log, _: Generator) -> Spoiled:
    """All channels backwards under the same stamps; speeds keep their sign."""
    return replace(log.rows(np.arange(len(log.t))[::-1]), t=log.t), Fault("time_reversed", (), -1.0)


def speeds_scaled(log: Log, rng: Generator) -> Spoiled:
    """One joint's speeds, or all, are wrong by 1.05 to 2."""
    factor = _factor(rng)
    j = [_joint(log, rng)] if rng.random() < 0.5 else list(range(log.n))
    return log.over("qd", lambda x: factor * x, *j), Fault(
        "speeds_scaled", _named("qd", *j), factor
    )


def speeds_delayed(log: Log, rng: Generator) -> Spoiled:
    """One joint's speeds, or all, are 1 to 50 ms late."""
    delay = float(10 ** rng.uniform(-3, np.log10(0.05)))
    j = [_joint(log, rng)] if rng.random() < 0.5 else list(range(log.n))
    spoiled = log.over("qd", lambda x: _shifted(log.t, x, delay), *j)
    return spoiled, Fault("speeds_delayed", _named("qd", *j), delay)


def another_robot(log: Log, _: Generator, other: Log) -> Spoiled:
    """The log of another robot with as many joints, under this one's name."""
    if other.n != log.n:
        raise ValueError(f"a log of {other.n} joints in the place of one of {log.n}")
    return other, Fault("another_robot", (), None)


LIGHT = (host_jitter, repeated_rows, torque_quanta, position_quanta, late_speeds, jumps)
HEAVY = (
    swapped, turned, degrees, milliseconds, newton_millimetres, torque_gain, gear_ratio,
    torque_delay, clipped, stuck, wrapped, repeated_rows_moved, held, coarse, spikes,
    time_reversed, speeds_scaled, speeds_delayed,
)  # fmt: skip
#: Concern measured speeds alone.
SPEEDS = (late_speeds, speeds_scaled, speeds_delayed)


def light(log: Log, rng: Generator) -> tuple[Log, tuple[Fault, ...]]:
    """Put one to all of LIGHT into a log, in the order in which they arise; rows come last."""
    fitting = [f for f in LIGHT if log.qd is not None or f not in SPEEDS]
    chosen = rng.permutation(len(fitting))[: int(rng.integers(1, len(fitting) + 1))]
    order = (late_speeds, position_quanta, torque_quanta, jumps, repeated_rows, host_jitter)
    faults = []
    for spoil in order:
        if spoil in [fitting[k] for k in chosen]:
            log, fault = spoil(log, rng)
            faults.append(fault)
    return log, tuple(faults)
