"""Where the gap is: which joints, and against what each joint's residual is organised.

Every pattern is a few functions of one joint's log. Its score is the share of the residual's square
that they explain once the model has taken its part, less a price for each function; the best one
names the pattern, where it explains enough to be one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.diagnosis import Gap, Place
from symgen.diagnosis.select import Score, quick_gain
from symgen.diagnosis.shapes import Torques
from symgen.diagnosis.whitened_system import WhitenedSystem, compared
from symgen.estimation.filtered import FilteredLog

FloatArray = NDArray[np.float64]
#: Functions (N, m) of a scene and the model's torques on it, for the joint at a position.
Functions = Callable[[FilteredLog, Torques, int], FloatArray]
_PRICE = 0.015  # of a function
_ORGANISED = 0.3  # least score of a pattern
_EXPLAINED = 0.5  # share of a joint's residual that effects close whose pattern is then its own
_LOUD = 1.5  # gap over floor from which a joint has an excess
_SLIGHT = 0.01  # share of the whole excess below which a joint is left out
_WINDOW, _MOST = 0.15, 0.7  # part of the log that is short, share of the square that is most
_SHAPES = 3  # half waves over the joint's range that are still a position, not a spectrum
_WAVES = 60
_AFTER = (0.02, 0.05, 0.1, 0.2)  # s after a reversal
_BLOCKS = 8


def _speed(s: FilteredLog, j: int) -> tuple[FloatArray, float]:
    return s.qd[:, j], float(np.sqrt(np.mean(s.qd[s.kept, j] ** 2))) or 1.0


def _range(s: FilteredLog, j: int) -> FloatArray:
    """Return the position, -1 to 1 over the log."""
    low, high = float(s.q[s.kept, j].min()), float(s.q[s.kept, j].max())
    return (2 * s.q[:, j] - low - high) / ((high - low) or 1.0)


def _steps(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    sign = np.sign(s.qd[:, j])
    return np.stack([sign, np.abs(sign), sign * np.cos(s.q[:, j]), sign * np.sin(s.q[:, j])], 1)


def _slow(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    v, size = _speed(s, j)
    return np.stack([np.sign(v) * np.exp(-((v / (a * size)) ** 2)) for a in (0.05, 0.15, 0.5)], 1)


def _slopes(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    v, size = _speed(s, j)
    return np.stack([v, np.abs(v), v * np.abs(v) / size, np.sign(v) * np.sqrt(np.abs(v))], 1)


def _shape(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    x = _range(s, j)
    waves = [f(np.pi / 2 * k * x) for k in range(1, _SHAPES + 1) for f in (np.sin, np.cos)]
    return np.stack([x, x**2, *waves], 1)


def _accelerations(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    return s.qdd[:, j : j + 1]


def _loads(s: FilteredLog, torques: Torques, j: int) -> FloatArray:
    load = torques.load[:, j]
    return np.stack([torques.model[:, j], load, np.abs(load) * np.sign(s.qd[:, j])], 1)


def _course(s: FilteredLog, torques: Torques, j: int) -> FloatArray:
    x = (s.t - s.t[0]) / ((s.t[-1] - s.t[0]) or 1.0)
    blocks = [(x >= i / _BLOCKS) & (x < (i + 1) / _BLOCKS) for i in range(_BLOCKS)]
    friction = torques.friction[:, j]
    return np.stack([*np.asarray(blocks, float), friction * x, friction * np.exp(-5 * x)], 1)


def _pulses(s: FilteredLog, torques: Torques, j: int) -> FloatArray:
    sign = np.sign(s.qd[:, j])
    turns = np.flatnonzero(sign[1:] * sign[:-1] < 0) + 1
    last = np.full(len(sign), -np.inf)
    last[turns] = s.t[turns]
    since = s.t - np.maximum.accumulate(last)
    pulses = [np.where(since < width, sign, 0.0) for width in _AFTER]
    return np.stack([*pulses, np.gradient(torques.model[:, j], s.step)], 1)


def _readings(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    error = np.gradient(s.q[:, j], s.step) - s.qd[:, j]
    return np.stack([error, np.gradient(error, s.step)], 1)


def _constant(s: FilteredLog, _: Torques, j: int) -> FloatArray:
    return np.ones_like(s.q[:, j : j + 1])


def _waves(count: int) -> Functions:
    def columns(s: FilteredLog, _: Torques, j: int) -> FloatArray:
        x = np.pi / 2 * count * _range(s, j)
        return np.stack([np.sin(x), np.cos(x)], 1)

    return columns


def _other(k: int) -> Functions:
    def columns(s: FilteredLog, _: Torques, j: int) -> FloatArray:
        v, own = s.qd[:, k], s.q[:, j]
        return np.stack([np.sign(v), v, s.qdd[:, k], v * own, v * s.qd[:, j]], 1)

    return columns


_PATTERNS: dict[str, Functions] = {
    "velocity-sign": _steps,
    "low-speed": _slow,
    "velocity": _slopes,
    "position": _shape,
    "acceleration": _accelerations,
    "load": _loads,
    "time": _course,
    "reversal": _pulses,
    "kinematic": _readings,
    "all": _constant,
}


def _groups(n: int, j: int) -> Iterator[tuple[str, Functions]]:
    yield from _PATTERNS.items()
    yield from (("spectrum", _waves(k)) for k in range(_SHAPES + 1, _WAVES + 1))
    yield from (("other-joint", _other(k)) for k in range(n) if k != j)


def portrait(evidence: WhitenedSystem, torques: Sequence[Torques], j: int) -> dict[str, float]:
    """Return the score of every pattern on the joint at position `j`, the best first."""
    scores: dict[str, float] = {}
    for pattern, functions in _groups(evidence.n, j):
        pairs = zip(evidence.logs, torques, strict=True)
        columns = np.concatenate([compared(s, functions(s, t, j)) for s, t in pairs])
        score = quick_gain(evidence, {j: columns}) - _PRICE * columns.shape[1]
        scores[pattern] = max(score, scores.get(pattern, -1.0))
    return dict(sorted(scores.items(), key=lambda entry: -entry[1]))


def window(evidence: WhitenedSystem, j: int) -> tuple[float, float] | None:
    """Return a short span of time, s, that holds most of a joint's residual; None without one."""
    first, found, most = 0, None, 0.0
    whole = float(np.sum(evidence.residual[:, j] ** 2))
    for s in evidence.logs:
        t = s.t[s.kept]
        square = np.concatenate(
            [[0.0], np.cumsum(evidence.residual[first : first + len(t), j] ** 2)]
        )
        first += len(t)
        length = max(1, int(_WINDOW * len(t)))
        for size in range(max(1, length // 8), length + 1, max(1, length // 8)):
            held = square[size:] - square[:-size]
            at = int(np.argmax(held)) if len(held) else 0
            if len(held) and held[at] > max(_MOST * whole, 1.02 * most):
                found, most = (float(t[at]), float(t[at + size - 1])), float(held[at])
    return found


def places(
    baseline: Baseline, accepted: Sequence[Score], before: Gap, floor: Gap
) -> tuple[Place, ...]:
    """Return the joints with a gap above the floor, the largest share first.

    The pattern is that of the effect that closes the joint's gap, where one with a name does; else
    that of the portrait.

    Args:
        baseline: the model before anything is added.
        accepted: what was found.
        before, floor: on the held-out data.
    """
    gap, noise = np.asarray(before.per_joint), np.asarray(floor.per_joint)
    excess = np.maximum(gap**2 - noise**2, 0)
    loud = (gap > _LOUD * noise) & (excess > _SLIGHT * excess.sum())
    if not loud.any():
        loud = excess == excess.max()
    excess = np.where(loud, excess, 0)
    if not excess.sum():
        return ()
    robot, base = baseline.robot, baseline.base
    left, torques = baseline.beside(accepted).sigma ** 2 / base.sigma**2, baseline.torques(base)
    out = []
    for j in map(int, np.argsort(-excess)[: int(np.count_nonzero(excess))]):
        named = [
            s.candidate.definition.pattern
            for s in accepted
            if not s.candidate.definition.own and j in (s.candidate.joints or range(robot.n))
        ]
        if named and left[j] < _EXPLAINED:
            pattern = named[0]
        else:
            best, score = next(iter(portrait(base, torques, j).items()))
            pattern = best if score > _ORGANISED else "all"
        share = float(excess[j] / excess.sum())
        out.append(Place(robot.movable[j].number, share, pattern, window(base, j)))
    return tuple(out)
