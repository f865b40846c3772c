"""NumPy twin of the C runtime: recursive least squares and the identifier on line.

The same algorithms as templates/c/runtime/least_squares.c and identifier.c, operation by operation,
in float64, for where no C compiler exists. Both give the same numbers to about 1e-12.

Sources:
    Gautier and Khalil, On the identification of the inertial parameters of robots, CDC 1988.
    Golub and Van Loan, Matrix Computations, 5.1 (Givens rotations) and 6.5 (appending a row).
    Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V (SRIF).
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, nan, sqrt
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.errors import IdentificationError

Array = NDArray[np.float64]
Kernel = Callable[[Array, Array], ArrayLike]
Mode = Literal["start", "sliding", "consecutive"]

#: A column is dependent when |R(j,j)| <= TOLERANCE ||R(:,j)||; see least_squares.c for the reason.
TOLERANCE = 1e-10

#: Steps whose ratio exceeds this are integrated by the trapezoid; see identifier.c.
LARGEST_RATIO = 10


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
        self.rss = 0.0
        self.count = 0.0
        self.forgetting = float(forgetting)
        self._root = sqrt(forgetting)

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
        rest = self._rotate(work, float(y), 0, self._root)
        self.rss = self.forgetting * self.rss + rest * rest
        self.count = self.forgetting * self.count + 1.0
        return 0

    def merge(self, other: LeastSquares) -> None:
        """Add all that another state holds, with the weights the rows have there.

        Args:
            other: a state with the same parameters; read only, and may be this one.
        """
        if other.z.shape != self.z.shape:
            raise ValueError(f"merged {other.z.size} parameters into {self.z.size}")
        rss, count = self.rss + other.rss, self.count + other.count
        for i in reversed(range(self.z.size)):
            rest = self._rotate(other.R[i].copy(), float(other.z[i]), i, 1.0)
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

    def _rotate(self, row: Array, y: float, first: int, root: float) -> float:
        """Rotate row'X = y into root [R z] from column `first` on; row is overwritten.

        Returns:
            what is left of y, orthogonal to all columns.
        """
        R, z = self.R, self.z
        for i in range(first, z.size):
            x, pivot = float(row[i]), root * float(R[i, i])
            sine, half = 0.0, 0.0
            if abs(x) > pivot:
                ratio, sign = pivot / abs(x), -1.0 if x < 0.0 else 1.0
                scale = sqrt(1.0 + ratio * ratio)
                sine, half = sign / scale, sign / (scale + ratio)
            elif pivot > 0.0:
                ratio = x / pivot
                scale = sqrt(1.0 + ratio * ratio)
                sine, half = ratio / scale, ratio / (scale + 1.0)
            # As a change by half = tan(angle / 2): small angles keep their digits.
            above, below = root * R[i, i:], row[i:].copy()
            R[i, i:] = above + sine * (below - half * above)
            row[i:] = below - sine * (above + half * below)
            top = root * float(z[i])
            z[i] = top + sine * (y - half * top)
            y = y - sine * (top + half * y)
        return y


class WindowIdentifier:
    """Identification on line by the energy model (Gautier and Khalil, 1988).

    Over a window (t1, t2) the work of the motors is the change of energy plus the work of friction,

        integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction,

    one row of a recursive least squares per window that closes. Power is integrated by three-point
    Adams-Moulton, of third order on uneven steps too.

    Attributes:
        least_squares: the state of the least squares; read it or merge it into another.
    """

    def __init__(
        self,
        energy_regressor: Kernel,
        friction_power: Kernel | None,
        *,
        parameters: int,
        inertial: int,
        mode: Mode = "sliding",
        window: int = 0,
        forgetting: float = 1.0,
    ) -> None:
        """Begin with no data.

        Args:
            energy_regressor: DL(q, qd), (p_inertial,), J per unit of X.
            friction_power: DF(q, qd), (p - p_inertial,), W per unit of X; None when
                parameters == inertial.
            parameters: p.
            inertial: p_inertial.
            mode: "start", every window starts at the first sample, as in the paper; "sliding",
                every sample closes a window that began `window` samples before (residuals are
                correlated: std comes out too small, by up to sqrt(window)); "consecutive", a
                window begins where the last one ended.
            window: length in samples, at least 1; ignored in mode "start".
            forgetting: weight of the past per row, in (0, 1].

        Raises:
            ValueError: an argument is out of range.
        """
        if mode not in get_args(Mode):
            raise ValueError(f"mode is {mode!r}; accepted: {', '.join(get_args(Mode))}")
        if mode != "start" and window < 1:
            raise ValueError(f"window is {window} samples; at least 1 is needed")
        if not 1 <= inertial <= parameters or (friction_power is None) != (inertial == parameters):
            raise ValueError(
                f"{inertial} inertial of {parameters} parameters; friction_power gives the others"
            )
        self.least_squares = LeastSquares(parameters, forgetting)
        self._energy_regressor = energy_regressor
        self._friction_power = friction_power
        self._inertial = inertial
        self._integrands = 1 + parameters - inertial
        self._mode = mode
        self._window = window
        # Ring of DL and the running integrals, one row per sample of the window.
        self._ring: Array = np.zeros((window if mode == "sliding" else 0, parameters + 1))
        self.restart()

    def restart(self) -> None:
        """Forget the open windows, not what was learned: the next sample is a first one."""
        self._samples = 0
        self._full = False
        self._dt = 0.0
        self._energy = self._start = np.zeros(self._inertial)
        self._before = self._latest = self._block = np.zeros(self._integrands)
        self._rebase()

    def step(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: float) -> int:
        """Take the next sample.

        Args:
            q: (n,) positions, rad or m.
            qd: (n,) velocities, rad/s or m/s.
            tau: (n,) torques, N m or N.
            dt: time since the sample before, s; ignored for the first sample.

        Returns:
            0; 1, and nothing changed, when a number is not finite or dt is not positive.
        """
        q, qd, tau = (np.asarray(x, dtype=np.float64) for x in (q, qd, tau))
        if not all(bool(np.isfinite(x).all()) for x in (q, qd, tau)):
            return 1
        if self._samples > 0 and not (dt > 0.0 and isfinite(dt)):
            return 1
        with np.errstate(over="ignore", invalid="ignore"):
            # Copied: a compiled kernel may hand out the same buffer every time.
            energy = np.array(self._energy_regressor(q, qd), dtype=np.float64)
            values = np.empty(self._integrands)
            values[0] = qd @ tau
            if self._friction_power is not None:
                values[1:] = self._friction_power(q, qd)
        if not (bool(np.isfinite(energy).all()) and bool(np.isfinite(values).all())):
            return 1
        if self._samples == 0:
            self._start = energy
            if self._mode == "sliding":
                self._ring[0, : self._inertial] = energy
                self._ring[0, self._inertial :] = 0.0
        elif self._samples == 1:
            self._energy = energy
        else:
            points = (self._before, self._latest, values)
            if self._samples == 2:
                # Only now can the first interval be integrated; a window that ended with it is
                # not used, so that no step takes in more than one row.
                self._advance(_integrate(*points, self._dt, dt, last=False), self._energy)
            equation = self._advance(_integrate(*points, self._dt, dt, last=True), energy)
            if equation is not None:
                self.least_squares.update(*equation)
        self._samples = min(self._samples + 1, 3)
        self._before, self._latest, self._dt = self._latest, values, dt
        return 0

    def run(self, t: ArrayLike, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> int:
        """Restart, then step through a whole log.

        Args:
            t: (N,) time, s.
            q: (N, n) positions, rad or m.
            qd: (N, n) velocities, rad/s or m/s.
            tau: (N, n) torques, N m or N.

        Returns:
            0, or the number (from 1) of the sample that was refused, where it stops.
        """
        self.restart()
        t, q, qd, tau = (np.asarray(x, dtype=np.float64) for x in (t, q, qd, tau))
        for k in range(t.size):
            dt = float(t[k] - t[k - 1]) if k else 0.0
            if (k == 0 and not isfinite(t[0])) or self.step(q[k], qd[k], tau[k], dt):
                return k + 1
        return 0

    def read(self) -> tuple[Array, Array]:
        """Return the parameters X (p,) and their standard deviations (p,).

        Raises:
            IdentificationError: the data leave a parameter open; the message has its number.
        """
        X, std, _ = self.least_squares.solve()
        return X, std

    def _rebase(self) -> None:
        self._sum = np.zeros(self._integrands)
        self._carry = np.zeros(self._integrands)
        self._position = 0

    def _advance(self, increment: Array, energy: Array) -> tuple[Array, float] | None:
        """Pass one interval, which ends where DL is energy; the equation of a window it closes."""
        part = increment - self._carry  # Kahan's compensated sum
        total = self._sum + part
        self._carry = (total - self._sum) - part
        self._sum = total
        self._position += 1
        if self._mode == "sliding":
            return self._slide(energy)
        if self._mode == "consecutive" and self._position < self._window:
            return None
        equation = _equation(energy - self._start, self._sum)
        if self._mode == "consecutive":
            self._start = energy
            self._rebase()
        return equation

    def _slide(self, energy: Array) -> tuple[Array, float] | None:
        """Close the window of the sample that leaves the ring; identifier.c says why in blocks."""
        if self._position == self._window:
            self._block = self._sum
            self._rebase()
            self._full = True
        slot = self._ring[self._position]
        equation = None
        if self._full:
            integral = (self._block - slot[self._inertial :]) + self._sum
            equation = _equation(energy - slot[: self._inertial], integral)
        slot[: self._inertial] = energy
        slot[self._inertial :] = self._sum
        return equation


def _equation(change: Array, integral: Array) -> tuple[Array, float]:
    """Row and right-hand side of a window: change of energy, work of friction; work of motors."""
    return np.concatenate((change, integral[1:])), float(integral[0])


def _integrate(a: Array, b: Array, c: Array, first: float, second: float, *, last: bool) -> Array:
    """Integrate the parabola through three samples over one of their two intervals.

    Three-point Adams-Moulton: the trapezoid minus h^3/6 times the second divided difference.

    Args:
        a, b, c: (m,) integrands at three samples.
        first, second: the two intervals, s.
        last: which of the two is integrated over.
    """
    h, other = (second, first) if last else (first, second)
    own, next_ = (c - b, b - a) if last else (b - a, c - b)
    trapezoid = h * ((b + c) if last else (a + b)) / 2.0
    if h > LARGEST_RATIO * other:
        return trapezoid
    bend = own - (h / other) * next_ if last else (h / other) * next_ - own
    return trapezoid - h * (h / (first + second)) / 6.0 * bend
