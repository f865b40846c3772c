"""Events: short spans of a log in which the torque of some joints has an error of its own.

A contact or a collision gives a torque of any course, which no other motion predicts. Without its
rows, the fit predicts other rows better. Beside this gain (`symgen.estimation.predictive_score`),
the squares c of its m rows of a joint are those of a variance of their own,

    log of the integral of p(c | v) over log v, uniform from the misfit to the torque of the joint,

where those of any other span would have the variance of the joint times a factor that varies from
span to span: the inverse of chi-square over its degrees of freedom, so that its residuals have the
heavy tails of Student's t. An event pays for the spans and for the sets of joints that are tried.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.predictive_score import FREEDOM, TEMPERATURE, Fit, PredictiveScore
from symgen.estimation.values import FloatArray
from symgen.policy import MISFIT

#: Longest event, as a part of its log; ratio of the lengths that are tried; starts in a length.
_LONGEST, _RATIO, _STARTS = 0.2, 1.25, 8
_RANGE = 2 * math.log(1 / MISFIT)  # of the logarithm of the variance of a joint in an event


@dataclass(frozen=True, eq=False)
class Event:
    """A span of a log in which some joints have an error of their own.

    Attributes:
        log: index of the log.
        start, end: s, on the clock of the log; half of the low-pass's response lies outside.
        first, last: samples without which the equations do not contain the event.
        joints: their positions.
        rows: (K, n) rows of all logs that it reaches.
        price: nats, for the spans and sets of joints that are tried.
    """

    log: int
    start: float
    end: float
    first: int
    last: int
    joints: tuple[int, ...]
    rows: NDArray[np.bool_]
    price: float

    def fit(self, score: PredictiveScore) -> tuple[float, Fit]:
        """Return the log-likelihood ratio of the event, less its price, and the fit without it."""
        gained, fit, variance = score.gained_without(self.rows)
        own = np.array(self.joints)
        count = np.sum((score.weight * self.rows)[:, own] ** 2, axis=0) / TEMPERATURE
        floor = score.misfit[own] ** 2
        told = _of_its_own(count, variance[own] + floor, fit.left[own] + floor)
        return gained + float(told.sum()) - self.price, fit


def _of_its_own(m: FloatArray, variance: FloatArray, usual: FloatArray) -> FloatArray:
    """Return the log-likelihood ratio of a variance of its own to a usual one, (n,).

    Args:
        m: number of independent rows.
        variance: their mean square.
        usual: that of other rows.
    """
    from scipy.special import gammaln

    half, c, scale = m / 2, m * variance / 2, FREEDOM * usual / 2
    own = gammaln(half) - half * np.log(c) - math.log(_RANGE)
    heavy = gammaln(half + FREEDOM / 2) - gammaln(FREEDOM / 2) + FREEDOM / 2 * np.log(scale)
    return np.asarray(own - heavy + (half + FREEDOM / 2) * np.log(c + scale))


def likeliest_event(score: PredictiveScore, logs: Sequence[FilteredLog]) -> Event | None:
    """Return the most probable event of some logs; None if no span has a larger error.

    Spans are compared by the residuals of the fits that contain them.

    Args:
        score: the model on the rows of these logs and of any further ones.
        logs: the logs.
    """
    folds = np.arange(-1, len(score.counts[0]))
    own = (score.fold[:, None] == folds)[:, None]
    squares, counts = (
        np.cumsum(np.pad((x**2)[:, :, None] * own, ((1, 0), (0, 0), (0, 0))), axis=0)
        for x in (score.weight * score.held_out, score.weight)
    )
    best: tuple[float, int, int, int, NDArray[np.intp]] | None = None
    every = []
    for k, (log, span) in enumerate(zip(logs, kept_spans(logs), strict=True)):
        rows, t = span.stop - span.start, log.compared_t
        reach = math.ceil(log.reach * log.step / (t[1] - t[0])) if rows > 1 else 0
        length = 2.0 * reach + 1
        while length <= _LONGEST * rows:
            m = round(length)
            begins = np.arange(span.start, span.stop - m + 1, max(1, m // _STARTS))
            gains = _gains(
                (squares[begins + m] - squares[begins], counts[begins + m] - counts[begins]),
                (squares[-1], counts[-1]),
                score.misfit**2,
            )
            total = np.maximum(gains, 0.0).sum(axis=1)
            every.append(total)
            at = int(np.argmax(total))
            if best is None or total[at] > best[0]:
                joints = np.flatnonzero(gains[at] > 0)
                best = float(total[at]), k, int(begins[at]), m, joints
            length *= _RATIO
    if best is None or best[0] <= 0:
        return None
    most, k, at, m, joints = best
    span = kept_spans(logs)[k]
    contained = np.zeros(score.weight.shape, dtype=bool)
    contained[at : at + m, joints] = True
    whole = np.concatenate(every)
    price = math.log(len(whole)) - float(np.logaddexp.reduce(whole) - most)
    price += len(score.misfit) * math.log(2)
    log = logs[k]
    first, last = int(log.kept[at - span.start]), int(log.kept[at - span.start + m - 1])
    half = log.t[[first + log.reach // 2, last - log.reach // 2]]
    return Event(
        k, float(half[0]), float(half[1]), first + log.reach, last - log.reach,
        tuple(map(int, joints)), contained, price,
    )  # fmt: skip


def _gains(
    inside: tuple[FloatArray, FloatArray], whole: tuple[FloatArray, FloatArray], floor: FloatArray
) -> FloatArray:
    """Return what a variance of its own gains in spans, less what it costs, (P, n).

    Args:
        inside: squares and counts of rows in each span, (P, n, folds).
        whole: squares and counts of all rows, (n, folds).
        floor: (n,) variance of the misfit.
    """

    def cost(squares: FloatArray, counts: FloatArray, floor: FloatArray) -> FloatArray:
        variance = np.maximum(squares, 0.0) / np.maximum(counts, 1e-300) + floor
        return np.asarray(counts * np.log(np.maximum(variance, 1e-300)))

    squares, counts = (x.sum(axis=2) for x in inside)
    by_fold = floor[:, None]
    fell = cost(*whole, by_fold).sum(axis=1) - cost(squares, counts, floor)
    fell = fell - cost(whole[0] - inside[0], whole[1] - inside[1], by_fold).sum(axis=2)
    larger = squares * whole[1].sum(axis=1) > whole[0].sum(axis=1) * counts
    return np.where(larger, 0.5 / TEMPERATURE * fell - _price(counts), 0.0)


def _price(counts: FloatArray) -> FloatArray:
    """Return what a variance of some rows costs, nats: its prior over its posterior width."""
    return np.asarray(math.log(_RANGE) + 0.5 * np.log(np.maximum(counts / TEMPERATURE / np.pi, 1)))
