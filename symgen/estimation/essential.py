"""Essential parameters: what the data cannot tell from zero is left out, one at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.estimators import NOISE_BIAS, Wls
from symgen.estimation.fold import LAGS, bartlett, triangle
from symgen.estimation.regression import (
    Solution,
    condition,
    factors,
    least_squares_solution,
    merged,
    require_rows,
)
from symgen.estimation.statistics import f_tail
from symgen.estimation.system import LinearSystem
from symgen.estimation.values import Contrast

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Essential:
    """Backward elimination with F tests on whitened residuals (Pham and Gautier 1991).

    Rows are divided by sigma_l sqrt(c_l): the deviation of the residual of the log and joint, and
    the factor by which its correlation in time makes rows fewer, c_l = long-run variance over
    variance (Bartlett weights), at least 1. The parameter with the smallest
    |X|/std goes, as long as both tests let it: against the model before, and against the full one,

        F = [(RSS_without - RSS_with) / r] / [RSS_full / (m - p)],   p_value above `level`

    with m = sum of rows over c_l. The others are estimated again each time.

    Attributes:
        level: p-value above which a parameter is not needed.
    """

    level: float = 0.05
    name: ClassVar[str] = "essential"
    excludes: ClassVar[str] = (
        NOISE_BIAS + "; that the data chose which parameters to keep (those left out are 0, "
        "with no std)"
    )

    def solve(self, system: LinearSystem) -> Solution:
        """Solve with the essential columns alone."""
        if not 0 < self.level < 1:
            raise IdentificationError(f"level {self.level:g}; accepted: between 0 and 1")
        require_rows(system)
        full = Wls().solve(system)
        weights, m = whitening(system, full.X)
        parts = factors(system)
        p = len(system.names)
        rows = np.concatenate([w * f for w, f in zip(weights, parts, strict=True)])
        kept = list(range(p))
        base = before = _rss(rows, kept)
        variance = base / (m - p)
        while len(kept) > 1:
            growth = [_rss(rows, [k for k in kept if k != i]) - before for i in kept]
            least = int(np.argmin(growth))
            without = before + growth[least]
            gone = p - len(kept) + 1
            single = f_tail(growth[least] / variance, 1, m - p)
            joint = f_tail((without - base) / gone / variance, gone, m - p)
            if min(single, joint) <= self.level:
                break
            before = without
            kept.pop(least)
        names = tuple(system.names[i] for i in kept)
        smaller = LinearSystem(names, tuple(e.columns(kept) for e in system.logs))
        X, scale, R = merged(
            [f[:, [*kept, p]] for f in parts], np.asarray(weights, dtype=float), names
        )
        part = least_squares_solution(smaller, X, scale, R, [float(w) for w in weights])
        whole, covariance = np.zeros(p), np.zeros((p, p))
        whole[kept] = part.X
        covariance[np.ix_(kept, kept)] = part.covariance
        out = [system.names[i] for i in range(p) if i not in kept]
        note = f"{len(kept)} of {p} parameters are essential" + (
            f"; taken as 0, F test at {self.level:g}: {', '.join(out)}" if out else ""
        )
        std = np.sqrt(np.maximum(np.diag(full.covariance), 0))
        return Solution(
            whole,
            covariance,
            condition(R),
            part.weights,
            (note,),
            comparison=(Contrast("wls", full.X, std),),
        )


def whitening(system: LinearSystem, X: FloatArray) -> tuple[FloatArray, float]:
    """Return the factor that makes the rows of each log count once, and how many then count.

    Args:
        system: the equations.
        X: an estimate, whose residuals are looked at.
    """
    weights, m = [], 0.0
    for e in system.logs:
        error = (e.y - e.W @ X)[:, None]
        power = max(float(np.sum(error**2)), 1e-300)
        inflation = max(
            float(bartlett(error, max(1, min(LAGS * e.correlation, len(e.y) // 4)))[0, 0]) / power,
            1.0,
        )
        weights.append(np.sqrt(len(e.y) / power / inflation))
        m += len(e.y) / inflation
    if m <= len(X) + 1:
        raise IdentificationError(
            f"the logs hold {m:.0f} independent equations for {len(X)} parameters: too few to test"
        )
    return np.array(weights), m


def _rss(rows: FloatArray, columns: list[int]) -> float:
    """Return the residual sum of squares of rows [W y] with some of the columns."""
    R = triangle(rows[:, [*columns, rows.shape[1] - 1]])
    return float(R[-1, -1] ** 2)
