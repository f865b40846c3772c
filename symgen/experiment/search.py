"""Search for motions from which noisy logs determine the parameters best.

With W_j the rows of joint j of the torque regressor, and s_j the standard deviation of the noise of
its torque, a log of N samples has the information

    torque, momentum   G = N mean(sum_j W_j' W_j / s_j^2)
    energy             G = N mean(w' w) / mean(sum_j s_j^2 qd_j^2),   w = sum_j qd_j W_j

and the parameters have the standard deviations sqrt(diag G^-1). The search minimises the mean of
their logarithms by a (1 + 1) evolution strategy (Rechenberg 1973). It changes the coefficients of
one joint at random and keeps the change if the motion is better.
"""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from symgen.data.raw import FloatArray
from symgen.experiment.bounds import CELL, Bounds, Cell, LimitUse, Space
from symgen.runtime.evaluator import Evaluator

_DRAWS = 10  # random motions from which a search starts with the best
_PER_PERIOD = 16  # samples in a period of the fastest term
_STEP, _SMALLEST = 0.3, 0.01  # relative, at the start and at the end
# Factors of the step after a success and after a failure. A factor of 0.985 ends in a sixth of the
# time, with standard deviations that are 15 % larger.
_GROW, _SHRINK = 1.3, 0.996
_TRIES = 3  # attempts to shrink a motion that exceeds torque limits or leaves the cell
# share of torque limits, and 1 cm to floor and boxes: a margin for the time between samples
_MARGIN = 0.99
#: Limits that are kept by shrinking the motion of all joints.
SHRUNK = ("torque", *CELL)


@dataclass
class Clock:
    """Stops a search after a time limit or on Ctrl-C."""

    end: float
    interrupted: bool = False
    begun: float = field(default_factory=time.perf_counter)

    @property
    def elapsed(self) -> float:
        """Seconds since the search began."""
        return time.perf_counter() - self.begun

    @property
    def remaining(self) -> float:
        """Remaining seconds; 0 after Ctrl-C."""
        return 0.0 if self.interrupted else self.end - self.elapsed

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Let Ctrl-C stop the search without an error; only the main thread receives it."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def stop(*_: object) -> None:
            self.interrupted = True

        before = signal.signal(signal.SIGINT, stop)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


@dataclass(frozen=True, eq=False)
class CandidateRun:
    """One run of a candidate: its coefficients, and the largest share of torque limits and cell.

    `information` is (p, p), and zero if the share is above 1.
    """

    z: FloatArray
    excess: float
    information: FloatArray


@dataclass(frozen=True, eq=False)
class MotionCandidate:
    """A motion of all runs.

    Attributes:
        runs: the runs.
        std: expected standard deviation of each parameter; infinite if it is not determined.
        rank: smaller is better. Motions within torque limits and cell come first, then precise
            ones.
    """

    runs: tuple[CandidateRun, ...]
    std: FloatArray
    rank: tuple[float, float]


def candidate(runs: Sequence[CandidateRun]) -> MotionCandidate:
    """Return the candidate motion of some runs."""
    std = expected_deviations(np.sum([run.information for run in runs], axis=0))
    excess = max(run.excess for run in runs)
    precision = float(np.mean(np.log(std))) if excess <= 1 else math.inf
    return MotionCandidate(tuple(runs), std, (max(excess, 1.0), precision))


def expected_deviations(G: FloatArray) -> FloatArray:
    """Return sqrt(diag G^-1) of the information G (p, p); infinite where G is singular."""
    size = np.sqrt(np.diag(G))
    size = np.where(size > 0, size, 1.0)
    try:
        L = np.linalg.cholesky(G / np.outer(size, size))
    except np.linalg.LinAlgError:
        return np.full(len(G), math.inf)
    return np.asarray(np.linalg.norm(np.linalg.inv(L), axis=0) / size)


class Fitted(NamedTuple):
    """A run within its limits: coefficients, q, qd, qdd and jerk (4, N, n), and its use of limits.

    `excess` is the largest used share of torque limits and cell.
    """

    z: FloatArray
    motion: FloatArray
    excess: float


@dataclass(frozen=True, eq=False)
class Objective:
    """The objective of the search, on a grid that is as fine as the terms of the motion need.

    Attributes:
        evaluator: the model, with its torque regressor.
        model: model to identify with: "energy", "momentum" or "torque".
        noise: standard deviation of the torque noise, (n,).
        rate: sampling rate of the logs, Hz.
        limits: limits of the joints.
        prior: parameters (p,) of the prior model, whose torque is limited; None without one.
        cell: floor and boxes; None without any.
        space: the motions of a run.
        sampled: see `Space.sampled`.
        runs: number of runs.
    """

    evaluator: Evaluator
    model: str
    noise: FloatArray
    rate: float
    limits: Bounds
    prior: FloatArray | None
    cell: Cell | None
    space: Space
    sampled: FloatArray
    runs: int

    def at_steps(self, step: float) -> Objective:
        """Return the same objective on a grid with another step in s."""
        return replace(self, sampled=self.space.sampled(self.space.series.times(step)))

    def uses(self, motion: FloatArray) -> Iterator[LimitUse]:
        """Yield the used share of the torque limits and of the cell, for q, qd, qdd, (3, N, n)."""
        q, qd, qdd = (np.ascontiguousarray(x) for x in motion[:3])
        if self.prior is not None:
            torque = self.evaluator["inverse_dynamics"](q, qd, qdd, self.prior)
            top = self.limits.torque
            yield from self.limits.used("torque", torque, -top, top)
        if self.cell is not None:
            yield from self.cell.uses(q)

    def regressor(self, motion: FloatArray) -> FloatArray:
        """Return the torque regressor along q, qd, qdd: (N, n, p)."""
        q, qd, qdd = (np.ascontiguousarray(x) for x in motion[:3])
        return np.asarray(self.evaluator["torque_regressor"](q, qd, qdd))

    def information(self, motion: FloatArray) -> FloatArray:
        """Return the information of a log of a motion, (p, p)."""
        W, qd = self.regressor(motion), motion[1]
        if self.model == "energy":
            rows = np.einsum("ij,ijk->ik", qd, W)
            rows /= np.sqrt(np.mean((qd**2) @ self.noise**2))
        else:
            rows = (W / self.noise[:, None]).reshape(-1, W.shape[2])
        samples = self.rate * self.space.series.duration
        return np.asarray(rows.T @ rows * (samples / len(W)))

    def fitted(self, z: FloatArray, grow: bool = False, allowed: float = 1.0) -> Fitted:
        """Return the run of coefficients z, scaled into its limits and shrunk to respect the
        others.

        Args:
            z: coefficients of the run.
            grow: also enlarge joints that do not reach their limits.
            allowed: largest share of torque limits and cell.
        """
        fitted = self._moved(self.space.fitted(z, self.sampled, grow))
        for _ in range(_TRIES):
            if fitted.excess <= allowed:
                break
            factor = max(0.5, _MARGIN * allowed / fitted.excess)
            fitted = self._moved(factor * fitted.z)
        return fitted

    def _moved(self, z: FloatArray) -> Fitted:
        """Return the run with coefficients z."""
        motion = self.space.motion(z, self.sampled)
        return Fitted(z, motion, largest_share(self.uses(motion)))

    def run(self, z: FloatArray, grow: bool = False) -> CandidateRun:
        """Return the run with coefficients z, within its limits if possible."""
        fitted = self.fitted(z, grow, _MARGIN)
        p = len(self.evaluator.model.base.parameters)
        information = np.zeros((p, p))
        if fitted.excess <= _MARGIN:
            information = self.information(fitted.motion)
        return CandidateRun(fitted.z, fitted.excess / _MARGIN, information)

    def torque(self, candidate: MotionCandidate) -> FloatArray:
        """Return the RMS torque of each parameter alone with a value of 1, (n, p)."""
        squares = []
        for run in candidate.runs:
            W = self.regressor(self.space.motion(run.z, self.sampled))
            squares.append(np.mean(W**2, axis=0))
        return np.asarray(np.sqrt(np.mean(squares, axis=0)))

    def drawn(self, draw: np.random.Generator) -> MotionCandidate:
        """Return the best of some random motions that reach their limits."""
        tried = []
        for _ in range(_DRAWS):
            runs = [self.run(self.space.draw(draw), True) for _ in range(self.runs)]
            tried.append(candidate(runs))
        return min(tried, key=lambda each: each.rank)

    def improved(
        self, best: MotionCandidate, draw: np.random.Generator, iterations: int, clock: Clock
    ) -> MotionCandidate:
        """Return the best motion that the search reaches from another one.

        The search ends after some iterations, when its step is small, or when the clock stops it.
        """
        step = _STEP
        for _ in range(iterations):
            if clock.remaining <= 0 or step < _SMALLEST:
                break
            k, runs = int(draw.integers(self.runs)), list(best.runs)
            z = runs[k].z.copy()
            j = int(draw.integers(len(z)))
            size = step * np.sqrt(np.mean(z[j] ** 2))
            z[j] += size * draw.normal(size=len(z[j]))
            runs[k] = self.run(z)
            tried = candidate(runs)
            if tried.rank < best.rank:
                best, step = tried, _GROW * step
            else:
                step *= _SHRINK
        return best


def largest_share(uses: Iterable[LimitUse]) -> float:
    """Return the largest used share of the limits that shrinking a motion keeps."""
    return max((u.share for u in uses if u.limit in SHRUNK), default=0.0)


def grid(space: Space, enough: float) -> FloatArray:
    """Return `Space.sampled` at the times of the search.

    Args:
        space: the motions of a run.
        enough: fewest samples.
    """
    series = space.series
    samples = max(_PER_PERIOD * series.terms, math.ceil(enough))
    return space.sampled(series.times(series.duration / samples))
