"""Test whether noise of positions explains an effect, by the two halves of the samples.

Noise of q enters the columns of the model, and therefore their residual. The column of an effect
contains the same noise, so least squares can find the effect even if it is absent. Columns Z from
the even samples and columns W from the odd ones have independent noise. Let c be the part of an
effect's columns in Z for which c' W = 0 for all other columns. Then

    m = c' (y - W_own theta)

is zero except for noise if theta is the coefficient. The estimate by instruments is
IV = (c' W_own)^-1 c' y. Each half is once Z and once W. The test compares m with its covariance
along the least-squares fit, which also holds for weak instruments (Anderson and Rubin 1949).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.effects import Score, Seen
from symgen.diagnosis.whitened_system import WhitenedSystem, estimated, fitted_system
from symgen.estimation.covariance import long_run_covariance
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.predictive_score import dense
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray
from symgen.identification.instruments import halves
from symgen.parallel import in_order, own_threads

_LEVEL = math.erfc(3 / math.sqrt(2))  # two-sided probability of 3 standard deviations
_MATERIAL = 0.05  # of a coefficient: a smaller bias is harmless, even if it is significant


class Shown(NamedTuple):
    """What the instruments say about an effect.

    Attributes:
        evidence: log of the likelihood ratio of the effect against none, nats.
        biased: whether noise of q biases its coefficients.
    """

    evidence: float = math.inf
    biased: bool = False


def shown_by_instruments(baseline: Baseline, effects: Sequence[Score]) -> list[Shown]:
    """Return for each effect what the instruments say about it.

    A coefficient is biased if instruments and least squares differ by 3 standard deviations and by
    5 % of the coefficient. There is no test for given parameters, for logs with too few samples, or
    if not all coefficients are determined.

    Args:
        baseline: the model as it is declared, and its training logs.
        effects: all that were found.
    """
    unknown = [Shown()] * len(effects)
    if baseline.given or not effects:
        return unknown
    pairs = [halves(log) for log in baseline.base.logs]
    system = estimated(baseline.beside(effects))
    if system.rank < system.W.shape[2]:
        return unknown
    even, odd = ([pair[k] for pair in pairs if pair is not None] for k in (0, 1))
    if len(even) < len(pairs):
        return unknown
    weight = (system.moves / system.sigma)[:, :, None]
    norms = np.sqrt(np.sum((system.W * weight) ** 2, axis=(0, 1)))
    own = in_order(lambda h: _columns(baseline, effects, h, system), (even, odd), own_threads())
    whole, *parts = ((W * weight / norms).reshape(system.y.size, -1) for W in (system.W, *own))
    y = (system.y * weight[:, :, 0]).ravel()
    rows = _Rows(system, whole, (parts[0], parts[1]), y, system.X * norms)
    out: list[Shown] = []
    at = baseline.base.W.shape[2]
    for s in effects:
        columns = np.arange(at, at + s.candidate.size)
        at += len(columns)
        out.append(Shown() if s.candidate.measured else rows.shown(columns))
    return out


def _columns(
    baseline: Baseline,
    effects: Sequence[Score],
    logs: Sequence[FilteredLog],
    system: WhitenedSystem,
) -> FloatArray:
    """Return the columns of the model and of the effects, evaluated along `logs`, (K, n, p)."""
    X = baseline.parameters(system)
    seen = Seen(logs, [baseline.torques_along(log.thinned, X) for log in logs])
    more = seen.each(s.candidate for s in effects)
    shape = system.y.shape
    W = fitted_system(baseline.evaluator, logs).W
    return np.concatenate([W, *(dense(c, shape) for c in more)], axis=2)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Whitened rows of all joints, (K n, p), and of the two halves.

    Attributes:
        system: the whitened equations.
        whole: columns along all samples.
        halves: columns along the even samples and along the odd ones.
        y: (K n,) torque.
        X: (p,) least-squares parameters.
    """

    system: WhitenedSystem
    whole: FloatArray
    halves: tuple[FloatArray, FloatArray]
    y: FloatArray
    X: FloatArray

    def shown(self, own: FloatArray) -> Shown:
        """Return what the instruments say about the columns with these indices."""
        from scipy.special import chdtri

        rest, theta = np.setdiff1d(np.arange(self.whole.shape[1]), own), self.X[own]
        m, slope = np.zeros(len(own)), np.zeros((len(own), len(own)))
        scores = np.zeros((len(self.y), len(own)))
        for W, Z in (self.halves, self.halves[::-1]):
            product = Z[:, rest].T @ W[:, rest]
            c = Z[:, own] - Z[:, rest] @ np.linalg.solve(product.T, W[:, rest].T @ Z[:, own])
            y = self.y - W[:, own] @ theta
            left = y - W[:, rest] @ np.linalg.solve(product, Z[:, rest].T @ y)
            m, slope, scores = m + c.T @ y, slope + c.T @ W[:, own], scores + c * left[:, None]
        # The least-squares estimate varies with the same torque noise.
        residual = (self.y - self.whole @ self.X)[:, None] * self.whole
        least = np.linalg.solve(self.whole.T @ self.whole, residual.T)[own]
        limit = float(chdtri(len(own), _LEVEL))
        shown = m + slope @ theta
        bias = np.linalg.solve(slope, m)
        differ = self._squares(m, scores - least.T @ slope.T) > limit
        material = bool((np.abs(bias) > _MATERIAL * np.abs(theta)).any())
        return Shown(self._squares(shown, scores) / 2, differ and material)

    def _squares(self, m: FloatArray, scores: FloatArray) -> float:
        """Return m' C^-1 m, with the long-run covariance C of the sums of `scores` (K n, k)."""
        n, parts, found = self.system.n, [], []
        by_joint = scores.reshape(-1, n, len(m))
        for log, span in zip(self.system.logs, kept_spans(self.system.logs), strict=True):
            t = log.t[log.kept]
            for j in range(n):
                at = np.flatnonzero(self.system.moves[span, j])
                none = np.zeros((len(at), 0))
                parts.append(Equations(log.name, none, np.zeros(len(at)), t[at], 2, j))
                found.append(by_joint[span][at, j])
        whole = LinearSystem((), tuple(parts))
        C = long_run_covariance(whole, np.eye(len(m)), found)
        return float(m @ np.linalg.solve(C, m))
