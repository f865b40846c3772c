"""Contacts: short spans of a log with a separate error variance on some joints.

The torque of a contact or a collision can have any course, and no other motion predicts it. A fit
without its rows predicts the other rows better. The log-odds of a contact contain this gain
(`symgen.hypotheses.score`) and a likelihood ratio for the sum of squares c of its m rows on a
joint. The numerator has a separate variance v:

    log of the integral of p(c | v) over log v, uniform from the misfit to the torque of the joint.

In the denominator, v is the variance of the joint times a factor that varies from span to span.
The factor is the inverse of chi-square over its degrees of freedom, so residuals have the heavy
tails of Student's t. A penalty counts the spans and the sets of joints that are tried.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.values import FloatArray
from symgen.faults.undo import left_out, touching_in
from symgen.hypotheses.judged import Hypothesis, Judged, Size
from symgen.hypotheses.score import (
    FREEDOM,
    TINY,
    Key,
    PredictiveScore,
    ScoreFit,
    worth_and_gain,
)
from symgen.policy import MISFIT
from symgen.robot.effect import definitions
from symgen.robot.types import Robot

NAME = "external_contact"
#: Longest contact as a part of its log; ratio of successive lengths; number of starts per length.
_LONGEST, _RATIO, _STARTS = 0.2, 1.25, 8
_RANGE = 2 * math.log(1 / MISFIT)  # width of the prior of the log variance of a joint in a contact


@dataclass(frozen=True, eq=False)
class Span(Hypothesis):
    """A span of a log in which some joints have a separate error variance.

    Attributes:
        log: name of the log.
        start, end: s, on the clock of the log, without half of the low-pass response at each end.
        first, last: samples of its first and last row. They contain the contact with a margin,
            because equations in another band reach other rows.
        rows: (K, m) rows of all logs that it contains: of its joints, or on a floating base all.
        price: penalty for the spans and sets of joints that are tried, nats.
        frame: declared contact of a floating base that touches in it, though its flag is 0; "" if
            a force acts elsewhere.
    """

    log: str
    start: float
    end: float
    first: int
    last: int
    rows: NDArray[np.bool_]
    price: float
    frame: str = ""

    @property
    def key(self) -> Key:
        """Name and log, first and last sample."""
        return f"{NAME} in {self.log}", (self.first, self.last)

    @property
    def extent(self) -> str:
        """Its log and its time."""
        return f" in {self.log}, {self.start:.3g} to {self.end:.3g} s"

    @property
    def sizes(self) -> Sequence[Size]:
        """Its time."""
        length = self.end - self.start
        return Size("start", self.start, "s"), Size("length", length, "s")

    def expression(self, robot: Robot) -> str:
        """Return what it is, and its log."""
        return f"{super().expression(robot)}, in {self.log}"

    @property
    def equations(self) -> list[int]:
        """Its equations."""
        return np.flatnonzero(self.rows.any(axis=0)).tolist()

    def fit(self, score: PredictiveScore) -> tuple[float, ScoreFit]:
        """Return the log-likelihood ratio of the span, less its price, and the fit without it."""
        gained, fit, variance = score.gained_without(self.rows)
        at = self.equations
        count = np.sum((score.weight * self.rows)[:, at] ** 2, axis=0) / score.temperature
        floor = score.misfit[at] ** 2
        separate, usual = variance[at] + floor, fit.variance[at] + floor
        live = count * np.minimum(separate, usual) > 0  # hidden forces may leave nothing of a row
        ratio = _variance_ratio(count[live], separate[live], usual[live])
        if not self.joints:  # all equations are left out, and the force acts in some of them
            ratio = np.maximum(ratio, 0.0)
        return gained + float(ratio.sum()) - self.price, fit

    def in_words(self, robot: Robot) -> str:
        """Return what acts, and when."""
        if not self.frame:
            return super().in_words(robot)
        times = f"from {self.start:.3g} to {self.end:.3g} s"
        return f"{self.frame} touches {times}, and {self.frame}.contact is 0"

    def undo(self, log: FilteredLog) -> FilteredLog:
        """Return the log with the samples of the span masked, or with its contact touching there.

        Logs of other names stay unchanged.
        """
        if log.name != self.log:
            return log
        if self.frame:
            return touching_in(log, slice(self.first, self.last + 1), self.frame)
        joints = self.joints or range(log.q.shape[1])
        return left_out(log, slice(self.first, self.last + 1), joints)


@dataclass(frozen=True, eq=False)
class Contact(Judged):
    """A contact and its score; `cause` has its rows, and `torque` is over all rows."""

    cause: Span


def judged_contact(score: PredictiveScore, span: Span, size: FloatArray) -> Contact:
    """Return the contact of a span, with its score.

    Args:
        score: the score of the model on the rows of the span.
        span: the span.
        size: (n,) RMS of the measured torque.
    """
    evidence, fit = span.fit(score)
    was, rows = score.alone.variance, span.equations
    now = was.copy()
    now[rows] = np.minimum(was, fit.variance)[rows]
    odds = evidence + math.log(span.definition.odds)
    torque = float(np.sqrt(np.max(was - now)))
    return Contact(span, odds, *worth_and_gain(was, now, size, rows), torque)


def likeliest_contact(
    score: PredictiveScore, logs: Sequence[FilteredLog], size: FloatArray
) -> Contact | None:
    """Return the most probable contact of some logs; None if no span has a larger error.

    The spans are compared by held-out residuals of fits that include their rows.

    Args:
        score: the score of the model; its first rows are those of the logs.
        logs: the logs.
        size: (n,) RMS of the measured torque.
    """
    span = _likeliest_span(score, logs)
    return None if span is None else judged_contact(score, span, size)


def _variance_ratio(m: FloatArray, variance: FloatArray, usual: FloatArray) -> FloatArray:
    """Return the log-likelihood ratio of a separate variance to the usual one, (n,).

    Args:
        m: number of independent rows.
        variance: mean square of these rows.
        usual: mean square of the other rows.
    """
    from scipy.special import gammaln

    half, c, scale = m / 2, m * variance / 2, FREEDOM * usual / 2
    separate = gammaln(half) - half * np.log(c) - math.log(_RANGE)
    free = FREEDOM / 2
    heavy = gammaln(half + free) - gammaln(free) + free * np.log(scale)
    return np.asarray(separate - heavy + (half + free) * np.log(c + scale))


def _likeliest_span(score: PredictiveScore, logs: Sequence[FilteredLog]) -> Span | None:
    """Return the span that most probably has a separate variance; None if there is none."""
    folds = np.arange(-1, len(score.counts[0]))
    of_fold = score.fold[:, None, None] == folds
    weighted = score.weight * score.held_out
    parts = np.stack([weighted, score.weight]) ** 2
    widths = (0, 0), (1, 0), (0, 0), (0, 0)
    padded = np.pad(parts[..., None] * of_fold, widths)
    sums = np.cumsum(padded, axis=1)  # of squares and counts of the rows before each row
    most, found, every = 0.0, None, []
    for log, rows in zip(logs, kept_spans(logs), strict=True):
        for m in _lengths(log):
            begins = np.arange(rows.start, rows.stop - m + 1, max(1, m // _STARTS))
            inside = sums[:, begins + m] - sums[:, begins]
            gains = _gains(inside, sums[:, -1], score.misfit**2, score.temperature)
            total = np.maximum(gains, 0.0).sum(axis=1)
            every.append(total)
            at = int(np.argmax(total))
            if total[at] > most:
                most = float(total[at])
                begin, acting = int(begins[at]), np.flatnonzero(gains[at] > 0)
                found = log, begin, begin - rows.start, m, acting
    if found is None:
        return None
    log, begin, at, m, acting = found
    floats = log.base_rows > 0  # a force acts in the equations of the base, and in others
    contained = np.zeros(score.weight.shape, dtype=bool)
    contained[begin : begin + m, slice(None) if floats else acting] = True
    totals = np.concatenate(every)
    price = math.log(len(totals)) - float(np.logaddexp.reduce(totals) - most)
    price += len(score.misfit) * math.log(2)
    margin = log.reach // 2
    first, last = log.kept[[at, at + m - 1]].tolist()
    inner = [first + margin, last - margin]
    start, end = log.t[inner].tolist()
    place = definitions()[NAME], () if floats else tuple(acting.tolist())
    return Span(*place, log.name, start, end, first, last, contained, price, measured=True)


def _lengths(log: FilteredLog) -> Iterator[int]:
    """Yield the lengths of contacts to try in a log, in kept samples."""
    t = log.compared_t
    reach = 0
    if len(t) > 1:
        reach = math.ceil(log.reach * log.step / (t[1] - t[0]))
    length = 2.0 * reach + 1
    while length <= _LONGEST * len(t):
        yield round(length)
        length *= _RATIO


def _gains(
    inside: FloatArray, all_rows: FloatArray, floor: FloatArray, temperature: float
) -> FloatArray:
    """Return the gain of a separate variance in each span, less its price, (P, n).

    Args:
        inside: squares and counts of rows in each span, (2, P, n, folds).
        all_rows: squares and counts of all rows, (2, n, folds).
        floor: (n,) variance of the misfit.
        temperature: number of correlated rows that count as one.
    """

    def cost(sums: FloatArray, floor: FloatArray) -> FloatArray:
        squares, counts = sums
        variance = np.maximum(squares, 0.0) / np.maximum(counts, TINY) + floor
        return np.asarray(counts * np.log(np.maximum(variance, TINY)))

    span, whole = inside.sum(axis=3), all_rows.sum(axis=2)
    by_fold = floor[:, None]
    fell = cost(all_rows, by_fold).sum(axis=1) - cost(span, floor)
    fell = fell - cost(all_rows[:, None] - inside, by_fold).sum(axis=2)
    larger = span[0] * whole[1] > whole[0] * span[1]
    # The price of a separate variance is the ratio of its prior width to its posterior width.
    count = np.maximum(span[1] / temperature / np.pi, 1)
    price = math.log(_RANGE) + 0.5 * np.log(count)
    return np.where(larger, 0.5 / temperature * fell - price, 0.0)
