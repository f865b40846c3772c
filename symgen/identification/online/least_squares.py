"""NumPy twin of least_squares.c: recursive least squares in square-root information form.

The same algorithm operation by operation, in float64; both give the same numbers to about 1e-12.

Sources:
    Golub and Van Loan, Matrix Computations, 5.1 (Givens rotations) and 6.5 (appending a row).
    Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V (SRIF).
"""

from __future__ import annotations

from math import isfinite, nan, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.errors import IdentificationError

Array = NDArray[np.float64]

#: A column is dependent when |R(j,j)| <= TOLERANCE ||R(:,j)||; see least_squares.c for the reason.
TOLERANCE = 1e-10


class LeastSquares:
    """Recursive least squares in square-root information form.

    The rows w'X = y seen so far are kept as [W y] = Q [R z; 0 e] (Bierman's SRIF), updated by
    Givens rotations (Golub and Van Loan, 5.1 and 6.5).

    Attributes:
        R: (p, p) upper triangle, diagonal >= 0; column j in units of y over units of X_j.
        z: (p,) Q'y, in units of y.
        rss: weighted sum of squared residuals, in units of y squared.
        count: weighted number of rows.
        forgetting: weight of the past per row, in (0, 1].
    """

    def __init__(self, parameters: int, forgetting: float = 1.0) -> None:
        """Begin with no data.

        Args:
            parameters: p, the length of X.
            forgetting: a row that is k rows old weighs forgetting**k; 1 keeps everything.

        Raises:
            ValueError: parameters is below 1, or forgetting outside (0, 1].
        """
        if parameters < 1:
            raise ValueError(f"parameters is {parameters}; at least 1 is needed")
        if not 0.0 < forgetting <= 1.0:
            raise ValueError(f"forgetting is {forgetting}; a number in (0, 1] is accepted")
        self.R: Array = np.zeros((parameters, parameters))
        self.z: Array = np.zeros(parameters)
        self._carry: Array = np.zeros((parameters, parameters + 1))  # of R and z
        self.rss = 0.0
        self.count = 0.0
        self.forgetting = float(forgetting)
        self._fade = (1.0 - forgetting) / (1.0 + sqrt(forgetting))  # 1 - root

    def update(self, row: ArrayLike, y: float) -> int:
        """Add the equation row'X = y.

        Args:
            row: (p,) coefficients.
            y: right-hand side.

        Returns:
            0; 1, and nothing changed, when a number is not finite.
        """
        work = np.array(row, dtype=np.float64)
        if work.shape != self.z.shape:
            raise ValueError(f"row has shape {work.shape}; {self.z.shape} is accepted")
        if not (isfinite(y) and bool(np.isfinite(work).all())):
            return 1
        rest = self._rotate(work, float(y), 0, self._fade)
        self.rss = self.forgetting * self.rss + rest * rest
        self.count = self.forgetting * self.count + 1.0
        return 0

    def extend(self, rows: Array, y: Array) -> None:
        """Add the equations rows X = y at once: what `update` gives one by one, to rounding.

        Args:
            rows: (K, p) coefficients, finite.
            y: (K,) right-hand sides, finite.
        """
        if self.forgetting < 1.0:
            for row, right in zip(rows, y, strict=True):
                self.update(row, float(right))
            return
        p = self.z.size
        old = np.column_stack([self.R, self.z])
        stacked = np.concatenate([old, np.column_stack([rows, y]), np.zeros((1, p + 1))])
        factor = np.asarray(np.linalg.qr(stacked, mode="r"))
        signs = np.where(np.diag(factor) < 0, -1.0, 1.0)
        factor = np.triu(signs[:, None] * factor)
        self.R, self.z = factor[:p, :p].copy(), factor[:p, p].copy()
        self._carry[:] = 0.0
        self.rss += float(factor[p, p] ** 2)
        self.count += len(y)

    def foresee(self, rows: Array, y: Array) -> tuple[Array, Array] | None:
        """Return what the equations rows X = y would bring, each alone.

        Args:
            rows: (K, p) coefficients.
            y: (K,) right-hand sides.

        Returns:
            innovation y - rows X and leverage row' (R'R)^-1 row, (K,) each; None while X is not
            determined.
        """
        if not (np.diag(self.R) > 0.0).all():
            return None
        u = np.linalg.solve(self.R.T, rows.T)
        return y - self.z @ u, np.einsum("pk,pk->k", u, u)

    def merge(self, other: LeastSquares) -> None:
        """Add all that another state holds, with the weights the rows have there.

        Args:
            other: a state with the same parameters; read only, and may be this one.
        """
        if other.z.shape != self.z.shape:
            raise ValueError(f"merged {other.z.size} parameters into {self.z.size}")
        rss, count = self.rss + other.rss, self.count + other.count
        for i in reversed(range(self.z.size)):
            rest = self._rotate(other.R[i].copy(), float(other.z[i]), i, 0.0)
            rss += rest * rest
        self.rss, self.count = rss, count

    def undetermined(self) -> int:
        """Return the number (from 1) of the first parameter that the data leave open, or 0."""
        for j in range(self.z.size):
            column = self.R[: j + 1, j]
            largest = float(np.abs(column).max())
            if not largest > 0.0:
                return j + 1
            norm = largest * float(np.linalg.norm(column / largest))
            if not column[j] > TOLERANCE * norm:
                return j + 1
        return 0

    def solve(self) -> tuple[Array, Array, float]:
        """Solve for the parameters.

        Returns:
            X: (p,) parameters.
            std: (p,) sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p), for
                residuals that are independent from row to row; NaN when count <= p.
            rss: sum of squared residuals.

        Raises:
            IdentificationError: a column depends on those before it; the message has its number.
        """
        culprit = self.undetermined()
        if culprit:
            raise IdentificationError(
                f"parameter {culprit} of {self.z.size} is not determined by the data: its column "
                "depends on the columns before it; a motion that excites it is needed"
            )
        p = self.z.size
        freedom = self.count - p
        sigma = sqrt(self.rss / freedom) if freedom > 0.0 else nan
        std = np.linalg.norm(self._back_substitute(sigma * np.eye(p)), axis=1)
        return self._back_substitute(self.z), np.asarray(std, dtype=np.float64), self.rss

    def _back_substitute(self, right: Array) -> Array:
        x = right.copy()
        for i in reversed(range(self.z.size)):
            x[i] = (x[i] - self.R[i, i + 1 :] @ x[i + 1 :]) / self.R[i, i]
        return x

    def _rotate(self, row: Array, y: float, first: int, fade: float) -> float:
        """Rotate row'X = y into (1 - fade) [R z] from column `first` on.

        Returns:
            what is left of y, orthogonal to all columns.
        """
        p = self.z.size
        work = np.append(row, y)
        for i in range(first, p):
            whole = np.append(self.R[i, i:], self.z[i])
            above, below = whole - fade * whole, work[i:]
            x, pivot = float(below[0]), float(above[0])
            sine, half = 0.0, 0.0
            if abs(x) > pivot:
                ratio, sign = pivot / abs(x), -1.0 if x < 0.0 else 1.0
                scale = sqrt(1.0 + ratio * ratio)
                sine, half = sign / scale, sign / (scale + ratio)
            elif pivot > 0.0:
                ratio = x / pivot
                scale = sqrt(1.0 + ratio * ratio)
                sine, half = ratio / scale, ratio / (scale + 1.0)
            # As a change by half = tan(angle / 2), in a compensated sum: see least_squares.c.
            change = sine * (below - half * above) - fade * whole
            work[i:] = below - sine * (above + half * below)
            part = change - self._carry[i, i:]
            total = whole + part
            self._carry[i, i:] = (total - whole) - part
            self.R[i, i:], self.z[i] = total[:-1], total[-1]
        return float(work[p])
