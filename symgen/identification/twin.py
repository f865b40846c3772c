"""NumPy twin of identifier.c: the identifier on line, for where no C compiler exists.

The same algorithm operation by operation, in float64; both give the same numbers to about 1e-12.

Source:
    Gautier and Khalil, On the identification of the inertial parameters of robots, CDC 1988.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.identification.least_squares import LeastSquares

Array = NDArray[np.float64]
Kernel = Callable[[Array, Array], ArrayLike]
Mode = Literal["start", "sliding", "consecutive"]

#: Steps whose ratio exceeds this are integrated by the trapezoid; see identifier.c.
LARGEST_RATIO = 10


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
            energy_regressor: DL(q, qd), (p_inertial,), J per unit of X; for q, qd of (N, n) it
                gives (N, p_inertial).
            friction_power: DF(q, qd), (p - p_inertial,), W per unit of X, and (N, ...) likewise;
                None when parameters == inertial.
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
        energy, values = self._columns(q, qd, tau)
        if not (bool(np.isfinite(energy).all()) and bool(np.isfinite(values).all())):
            return 1
        equation = self._take(energy, values, dt)
        if equation is not None:
            self.least_squares.update(*equation)
        return 0

    def _columns(self, q: Array, qd: Array, tau: Array) -> tuple[Array, Array]:
        """Evaluate DL and the integrands, of one sample or of many."""
        with np.errstate(over="ignore", invalid="ignore"):
            # Copied: a compiled kernel may hand out the same buffer every time.
            energy = np.array(self._energy_regressor(q, qd), dtype=np.float64)
            values = np.empty((*q.shape[:-1], self._integrands))
            values[..., 0] = np.einsum("...i,...i->...", qd, tau)
            if self._friction_power is not None:
                values[..., 1:] = self._friction_power(q, qd)
        return energy, values

    def _take(self, energy: Array, values: Array, dt: float) -> tuple[Array, float] | None:
        """Integrate up to a sample; return the equation of the window it closes, if any."""
        equation = None
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
        self._samples = min(self._samples + 1, 3)
        self._before, self._latest, self._dt = self._latest, values, dt
        return equation

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
        steps = np.diff(t, prepend=t[:1])
        energy, values = self._columns(q, qd, tau)
        good = np.isfinite(t) & np.isfinite(steps) & ((steps > 0) | (np.arange(t.size) == 0))
        for array in (q, qd, tau, energy, values):
            good &= np.isfinite(array).all(axis=1)
        count = t.size if good.all() else int(np.argmin(good))
        taken = (self._take(energy[k], values[k], float(steps[k])) for k in range(count))
        equations = [equation for equation in taken if equation is not None]
        if equations:
            rows, right = zip(*equations, strict=True)
            self.least_squares.extend(np.array(rows), np.array(right))
        return 0 if count == t.size else count + 1

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
