"""Total least squares: the regressor has errors too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.fold import summaries, triangle
from symgen.estimation.regression import (
    Solution,
    log_weights,
    require_rows,
    robust_covariance,
)
from symgen.estimation.system import LinearSystem

FloatArray = NDArray[np.float64]
_PASSES = 3


@dataclass(frozen=True, eq=False)
class TotalLeastSquares:
    """Total least squares: the smallest errors of [W y] that make W X = y exact.

        minimise sum of (y - w'X)^2 / (1 + X'C X),   C = diag(noise^2)

    by the smallest singular vector of [W y] in units of its errors (Golub and Van Loan 1980);
    columns without error are taken out by QR first (Van Huffel and Vandewalle 1991, ch. 3). It
    removes the bias of least squares where the errors of the columns are independent of each other
    and from row to row, and their ratio to those of y is known. Those of a robot's regressor are
    neither: instrumental variables ask for less. Precision by the sandwich of its estimating
    equations sum e (w + e C X/(1 + X'C X)) = 0.

    Attributes:
        noise: (p,) standard deviation of the error of each column over that of y; 0 where exact.
            None: in proportion to the norm of the column over that of y.
    """

    noise: FloatArray | None = None
    name: ClassVar[str] = "tls"
    excludes: ClassVar[str] = (
        "bias where the errors of the columns have other sizes than it takes them to have, or are "
        "correlated"
    )

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR and SVD of [W y], each log weighed as in weighted least squares."""
        require_rows(system)
        p = len(system.names)
        parts = summaries(system)
        weights, X, scale, _ = log_weights(parts, system.names, _PASSES)
        rows = [w * s.factor for w, s in zip(weights, parts, strict=True)]
        whole = triangle(np.concatenate(rows))
        noise = self._noise(scale, float(np.linalg.norm(whole[:, p])), p)
        X = _smallest(whole, noise)
        C = noise**2
        growth = 1 + float(C @ X**2)
        scores, rss = [], 0.0
        for w, e in zip(weights, system.logs, strict=True):
            error = w * (e.y - e.W @ X)
            scores.append(error[:, None] * (w * e.W + error[:, None] * (C * X / growth)))
            rss += float(error @ error)
        information = whole[:p, :p].T @ whole[:p, :p] - rss / growth * np.diag(C)
        unit = np.outer(scale, scale)
        bread = np.linalg.inv(information / unit) / unit
        values = np.linalg.eigvalsh(information / unit)
        if not values[0] > 0:
            raise IdentificationError(
                "total least squares has no solution here: the errors of the columns hide the "
                "least excited parameters; accepted: a richer motion, or method wls or iv"
            )
        covariance = robust_covariance(system, bread, scores)
        root = float(np.sqrt(values[-1] / values[0]))
        return Solution(X, covariance, root, tuple(map(float, weights)))

    def _noise(self, scale: FloatArray, y: float, p: int) -> FloatArray:
        if self.noise is None:
            return scale / y
        noise = np.asarray(self.noise, dtype=float)
        if noise.shape != (p,) or not (np.isfinite(noise).all() and (noise >= 0).all()):
            raise IdentificationError(f"the noise of the columns is not {p} numbers of 0 or above")
        return noise


def _smallest(whole: FloatArray, noise: FloatArray) -> FloatArray:
    """Solve the triangular [W y]: exact columns first, then the smallest singular vector."""
    p = len(noise)
    exact, noisy = np.flatnonzero(noise == 0), np.flatnonzero(noise > 0)
    R = triangle(whole[:, [*exact, *noisy, p]])
    k = len(exact)
    X = np.zeros(p)
    if len(noisy):
        lower = np.column_stack([R[k:, k:p] / noise[noisy], R[k:, p]])
        vector = np.linalg.svd(lower)[2][-1]
        if abs(vector[-1]) < 1e-12:
            raise IdentificationError("total least squares has no finite solution here")
        X[noisy] = -vector[:-1] / vector[-1] / noise[noisy]
    X[exact] = np.linalg.solve(R[:k, :k], R[:k, p] - R[:k, k:p] @ X[noisy])
    return X
