"""The place of a gap: which joints, and on what each joint's residual depends.

Each pattern is a small set of functions of one joint's log. Its score is the share of the squared
residual that they explain beside the model, minus a penalty for each function. The best score names
the pattern, if it is large enough.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

import numpy as np

from symgen.data.mask import rms
from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.contacts import NAME as CONTACT
from symgen.diagnosis.contacts import Contact
from symgen.diagnosis.diagnosis import Gap, Place
from symgen.diagnosis.effects import Score, Torques
from symgen.diagnosis.whitened_system import WhitenedSystem, gain_of, in_band
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.robot.effect import definitions

_PRICE = 0.015  # penalty of a function
_ORGANISED = 0.3  # smallest score of a pattern
#: Part of a joint's squared residual that what explains it may leave.
EXPLAINED = 0.5
_LOUD = 1.5  # gap over noise floor from which a joint counts
_SLIGHT = 0.01  # share of the whole excess below which a joint is left out
_SHAPES = 3  # half waves over the joint's range up to which the pattern is position, not spectrum
_WAVES = 60
_AFTER = (0.02, 0.05, 0.1, 0.2)  # s after a reversal
_BLOCKS = 8


class _View:
    """One joint of a log: q, v, a, torque `model` with its rigid-body part `load`, (N,) each.

    The position x is scaled to -1 .. 1, `part` is the elapsed part of the time, and `size` the RMS
    of the speed.
    """

    def __init__(self, log: FilteredLog, torques: Torques, j: int) -> None:
        every = (log.q, log.qd, log.qdd, torques.model, torques.load)
        self.q, self.v, self.a, self.model, self.load = (column[:, j] for column in every)
        kept, t = self.q[log.kept], log.t - log.t[0]
        low, high = float(kept.min()), float(kept.max())
        self.log, self.part = log, t / (t[-1] or 1.0)
        self.x = (2 * self.q - low - high) / ((high - low) or 1.0)
        self.size = float(rms(self.v[log.kept])) or 1.0


#: Functions (N,) of a view.
Functions = Callable[[_View], list[FloatArray]]


def _steps(s: _View) -> list[FloatArray]:
    sign = np.sign(s.v)
    return [sign, np.abs(sign), sign * np.cos(s.q), sign * np.sin(s.q)]


def _course(s: _View) -> list[FloatArray]:
    edges, friction = np.arange(_BLOCKS) / _BLOCKS, s.model - s.load
    blocks = [((s.part >= e) & (s.part < e + 1 / _BLOCKS)).astype(float) for e in edges]
    return [*blocks, friction * s.part, friction * np.exp(-5 * s.part)]


def _pulses(s: _View) -> list[FloatArray]:
    sign, t = np.sign(s.v), s.log.t
    turns = np.flatnonzero(sign[1:] * sign[:-1] < 0) + 1
    last = np.full(len(sign), -np.inf)
    last[turns] = t[turns]
    since = t - np.maximum.accumulate(last)
    pulses = [np.where(since < width, sign, 0.0) for width in _AFTER]
    return [*pulses, np.gradient(s.model, s.log.step)]


def _readings(s: _View) -> list[FloatArray]:
    error = np.gradient(s.q, s.log.step) - s.v
    return [error, np.gradient(error, s.log.step)]


def _waves(s: _View, counts: Iterable[int]) -> list[FloatArray]:
    return [f(np.pi / 2 * k * s.x) for k in counts for f in (np.sin, np.cos)]


_PATTERNS: dict[str, Functions] = {
    "velocity-sign": _steps,
    "low-speed": lambda s: [
        np.sign(s.v) * np.exp(-((s.v / (a * s.size)) ** 2)) for a in (0.05, 0.15, 0.5)
    ],
    "velocity": lambda s: [
        s.v, np.abs(s.v), s.v * np.abs(s.v) / s.size, np.sign(s.v) * np.sqrt(np.abs(s.v))
    ],
    "position": lambda s: [s.x, s.x**2, *_waves(s, range(1, _SHAPES + 1))],
    "acceleration": lambda s: [s.a],
    "load": lambda s: [s.model, s.load, np.abs(s.load) * np.sign(s.v)],
    "time": _course,
    "reversal": _pulses,
    "kinematic": _readings,
    "all": lambda s: [np.ones_like(s.q)],
}  # fmt: skip


def _groups(n: int, j: int) -> Iterator[tuple[str, Functions]]:
    yield from _PATTERNS.items()
    for k in range(_SHAPES + 1, _WAVES + 1):
        yield "spectrum", partial(_waves, counts=[k])
    for k in (k for k in range(n) if k != j):
        yield "other-joint", partial(_beside, k=k)


def _beside(s: _View, k: int) -> list[FloatArray]:
    v = s.log.qd[:, k]
    return [np.sign(v), v, s.log.qdd[:, k], v * s.q, v * s.v]


def portrait(evidence: WhitenedSystem, torques: Sequence[Torques], j: int) -> dict[str, float]:
    """Return the score of every pattern on the joint at index `j`, the best first."""
    scores: dict[str, float] = {}
    views = [_View(log.thinned, t, j) for log, t in zip(evidence.logs, torques, strict=True)]
    groups = [*_groups(evidence.n, j)]
    found = in_band(
        evidence.logs, groups, lambda group, k: {j: np.stack(group[1](views[k]), axis=1)}
    )
    for (pattern, _), columns in zip(groups, found, strict=True):
        score = gain_of(evidence, columns) - _PRICE * columns[j].shape[1]
        scores[pattern] = max(score, scores.get(pattern, -1.0))
    return dict(sorted(scores.items(), key=lambda entry: -entry[1]))


def places(
    baseline: Baseline,
    accepted: Sequence[Score],
    contacts: Sequence[Contact],
    before: Gap,
    floor: Gap,
) -> tuple[Place, ...]:
    """Return the joints with a gap above the noise floor, the largest share first.

    The pattern is that of the named effect that closes the joint's gap, if there is one. Otherwise
    it is the pattern with the best score.

    Args:
        baseline: the declared model.
        accepted: the effects that were found.
        contacts: the contacts; the first one on a joint gives the time of its gap.
        before, floor: gap and noise floor on the held-out data.
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
    pushed = {j: c for c in reversed(contacts) for j in c.event.joints}
    out = []
    for j in map(int, np.argsort(-excess)[: int(np.count_nonzero(excess))]):
        named = [
            s.candidate.definition.pattern
            for s in accepted
            if not s.candidate.definition.own and j in (s.candidate.joints or range(robot.n))
        ]
        contact, time = pushed.get(j), None
        if contact is not None:
            time = contact.event.start, contact.event.end
        if contact is not None and contact.gain > 1 - EXPLAINED:
            pattern = definitions()[CONTACT].pattern
        elif named and left[j] < EXPLAINED:
            pattern = named[0]
        else:
            best, score = next(iter(portrait(base, torques, j).items()))
            pattern = best if score > _ORGANISED else "all"
        share = float(excess[j] / excess.sum())
        out.append(Place(robot.movable[j].number, share, pattern, time))
    return tuple(out)
