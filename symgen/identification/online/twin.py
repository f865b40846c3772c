"""NumPy twin of identifier.c: the identifier on line, for where no C compiler exists.

The same algorithm operation by operation, in float64; both give the same numbers to about 1e-12.

Source:
    Gautier and Khalil, On the identification of the inertial parameters of robots, CDC 1988.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import isfinite, sqrt
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.identification.online.least_squares import LeastSquares

Array = NDArray[np.float64]
Kernel = Callable[[Array, Array], Any]
Columns = Callable[[Array, Array, Array], tuple[Array, Array]]
Mode = Literal["start", "sliding", "consecutive"]

#: Samples on each side of an interval that its integral uses, as far as there are any.
REACH = 2
NODES = 2 * REACH + 2
#: Where the weights would enlarge errors by more, fewer samples are used; see identifier.c.
LARGEST_GAIN = 2.0
#: The guard of identifier.c, which says what they are.
LARGEST_SAMPLE, GATE, LEAST_WRONG, LEAST_LEVERAGE = 1e9, 10.0, 0.1, 0.01
OK, NOT_FINITE, OUTLIER, NOT_EXCITED = 0, 2, 4, 8  # as NAME.h numbers them
_BLOCK = 256  # equations that are looked at together, where no past is forgotten
_AT = np.array([0.11270166537925831, 0.5, 0.8872983346207417])
_SHARE = np.array([5.0, 8.0, 5.0]) / 18.0


def energy_columns(energy_regressor: Kernel, friction_power: Kernel | None) -> Columns:
    """Return the energy model: one equation a window (Gautier and Khalil, 1988).

        integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction

    Args:
        energy_regressor: DL(q, qd), (p_inertial,), J per unit of X; for q, qd of (N, n) it gives
            (N, p_inertial).
        friction_power: DF(q, qd), (p - p_inertial,), W per unit of X, and (N, ...) likewise; None
            for a robot without friction.
    """

    def columns(q: Array, qd: Array, tau: Array) -> tuple[Array, Array]:
        inertial = np.asarray(energy_regressor(q, qd))[..., None, :]
        blocks = [np.zeros_like(inertial)]
        if friction_power is not None:
            blocks.append(np.asarray(friction_power(q, qd))[..., None, :])
        blocks.append(np.einsum("...i,...i->...", qd, tau)[..., None, None])
        return _padded(inertial, np.concatenate(blocks, axis=-1))

    return columns


def momentum_columns(momentum_regressor: Kernel, friction_torque: Kernel | None) -> Columns:
    """Return the momentum model: n equations a window.

        integral tau dt = {P(t2) - P(t1) - integral DL dt} X_inertial + integral F dt X_friction

    Args:
        momentum_regressor: P = dT/dqd and DL = dL/dq of (q, qd), (n, p_inertial) each; for q, qd of
            (N, n) they are (N, n, p_inertial).
        friction_torque: F(q, qd), (n, p - p_inertial), and (N, ...) likewise; None for a robot
            without friction.
    """

    def columns(q: Array, qd: Array, tau: Array) -> tuple[Array, Array]:
        momentum, slope = momentum_regressor(q, qd)
        blocks = [-np.asarray(slope)]
        if friction_torque is not None:
            blocks.append(np.asarray(friction_torque(q, qd)))
        blocks.append(tau[..., None])
        return _padded(np.asarray(momentum), np.concatenate(blocks, axis=-1))

    return columns


def _padded(inertial: Array, rate: Array) -> tuple[Array, Array]:
    """Return value and rate, where only the inertial columns have a value."""
    value = np.zeros_like(rate)
    value[..., : inertial.shape[-1]] = inertial
    return value, rate


class WindowIdentifier:
    """Identification on line: equations that are integrals over windows.

    For each equation of a window, [w, y] = change of value + integral of rate and w'X = y; every
    one is a row of a recursive least squares. The integral over an interval is that of the
    polynomial through six samples, two on each side of it, of sixth order on uneven steps too: it
    is known two samples later.

    Attributes:
        least_squares: the state of the least squares; read it or merge it into another.
        status: of the equations of the latest step, bits of OUTLIER and NOT_EXCITED.
    """

    # Integrals since the base, what rounding put into them, those of the block before (sliding),
    # and the value where the window began (start, consecutive).
    _sum: Array
    _carry: Array
    _block: Array
    _start: Array

    def __init__(
        self,
        columns: Columns,
        parameters: int,
        equations: int = 1,
        *,
        mode: Mode = "sliding",
        window: int = 0,
        forgetting: float = 1.0,
    ) -> None:
        """Begin with no data.

        Args:
            columns: of q, qd, tau, (n,) or (N, n) each, gives value and rate: (equations, p + 1)
                or (N, equations, p + 1), the right-hand side last.
            parameters: p.
            equations: of a window: 1 for energy, n for momentum.
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
        if equations < 1:
            raise ValueError(f"equations is {equations}; at least 1 is needed")
        self.least_squares = LeastSquares(parameters, forgetting)
        self._columns = columns
        self._mode = mode
        self._window = window
        self._shape = (equations, parameters + 1)
        # Ring of value + integral, one entry per sample of the window.
        self._ring: Array = np.zeros((window if mode == "sliding" else 0, *self._shape))
        self.status = OK
        self._refused, self._largest = 0, 0.0
        self.restart()

    def restart(self) -> None:
        """Forget the open windows, not what was learned: the next sample is a first one."""
        self._full = False
        self._values: list[Array] = []
        self._rates: list[Array] = []
        self._steps: list[float] = []
        self._block = np.zeros(self._shape)
        self._start = self._block
        self._rebase()

    def step(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: float) -> int:
        """Take the next sample.

        Args:
            q: (n,) positions, rad or m.
            qd: (n,) velocities, rad/s or m/s.
            tau: (n,) torques, N m or N.
            dt: time since the sample before, s; ignored for the first sample.

        Returns:
            0; NOT_FINITE, and nothing changed, when a number is not finite or larger than 1e9, or
            dt is not positive.
        """
        q, qd, tau = (np.asarray(x, dtype=np.float64) for x in (q, qd, tau))
        if not all(bool((np.abs(x) <= LARGEST_SAMPLE).all()) for x in (q, qd, tau)):
            return NOT_FINITE
        if self._rates and not (dt > 0.0 and isfinite(dt)):
            return NOT_FINITE
        value, rate = self._evaluate(q, qd, tau)
        if not (bool(np.isfinite(value).all()) and bool(np.isfinite(rate).all())):
            return NOT_FINITE
        self._absorb(self._take(value, rate, dt))
        return OK

    def _absorb(self, rows: Array) -> None:
        """Take in the equations that closed, but for outliers and those that teach nothing."""
        self.status = OK
        for row in rows:
            status = self._judged(row[:-1], float(row[-1]))
            if status == OK:
                self.least_squares.update(row[:-1], float(row[-1]))
            self.status |= status
        if self._mode == "start" and self.status & OUTLIER:
            self.restart()

    def _judged(self, row: Array, y: float) -> int:
        """Return what is wrong with an equation, if anything: see identifier.c."""
        past = self.least_squares
        seen = past.foresee(row[None], np.array([y]))
        freedom = past.count - row.size
        if seen is not None and seen[1][0] < LEAST_LEVERAGE * row.size * (1.0 - past.forgetting):
            return NOT_EXCITED
        if seen is not None and freedom > 0.0 and abs(seen[0][0]) > LEAST_WRONG * self._largest:
            gate = GATE * sqrt(past.rss / freedom * (1.0 + seen[1][0]))
            if abs(seen[0][0]) > gate:
                self._refused += 1
                longest = self._window if self._mode == "sliding" else 0
                if self._refused <= 2 * self._shape[0] * (longest + NODES):
                    return OUTLIER
        else:
            self._refused = 0
        self._largest = max(self._largest, abs(y))
        return OK

    def _absorb_all(self, rows: Array) -> None:
        """Do as `_absorb` does one by one; blocks without an outlier are taken at once."""
        past, p, at = self.least_squares, self._shape[1] - 1, 0
        while at < len(rows):
            block = rows[at : at + (_BLOCK if past.forgetting == 1 and past.count > 2 * p else 1)]
            seen = past.foresee(block[:, :-1], block[:, -1]) if len(block) > 1 else None
            if seen is not None and bool((np.abs(seen[0]) <= LEAST_WRONG * self._largest).all()):
                self._largest = max(self._largest, float(np.abs(block[:, -1]).max()))
                past.extend(block[:, :-1], block[:, -1])
            else:
                for row in block:
                    self._absorb(row[None])
            at += len(block)

    def _evaluate(self, q: Array, qd: Array, tau: Array) -> tuple[Array, Array]:
        with np.errstate(over="ignore", invalid="ignore"):
            return self._columns(q, qd, tau)

    def _take(self, value: Array, rate: Array, dt: float) -> Array:
        """Take a sample in; return the rows [w, y] of the window that closes, if any."""
        if self._rates:
            self._steps = [*self._steps, dt][1 - NODES :]
        self._rates = [*self._rates, rate][-NODES:]
        self._values = [*self._values, value][-REACH - 1 :]
        count = len(self._rates)
        if count == 1:
            self._start = value
            if self._mode == "sliding":
                self._ring[0] = value
        if count < REACH + 2:
            return np.zeros((0, self._shape[1]))
        left = count - REACH - 2
        first, weights = _rule(tuple(self._steps), left)
        increment = np.zeros(self._shape)
        for weight, node in zip(weights, self._rates[first:], strict=False):
            increment += weight * self._steps[left] * node
        part = increment - self._carry  # Kahan's compensated sum
        total = self._sum + part
        self._carry, self._sum = (total - self._sum) - part, total
        return self._advance(self._values[0])

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
        value, rate = self._evaluate(q, qd, tau)
        good = np.isfinite(t) & np.isfinite(steps) & ((steps > 0) | (np.arange(t.size) == 0))
        for array in (q, qd, tau):
            good &= (np.abs(array) <= LARGEST_SAMPLE).all(axis=1)
        for array in (value, rate):
            good &= np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
        count = t.size if good.all() else int(np.argmin(good))
        if self._mode == "start":  # an outlier begins windows anew
            for k in range(count):
                self._absorb(self._take(value[k], rate[k], float(steps[k])))
        elif count:
            taken = [self._take(value[k], rate[k], float(steps[k])) for k in range(count)]
            self._absorb_all(np.concatenate(taken))
        return 0 if count == t.size else count + 1

    def read(self) -> tuple[Array, Array]:
        """Return the parameters X (p,) and their standard deviations (p,).

        Raises:
            IdentificationError: the data leave a parameter open; the message has its number.
        """
        X, std, _ = self.least_squares.solve()
        return X, std

    def _rebase(self) -> None:
        self._sum = np.zeros(self._shape)
        self._carry = np.zeros(self._shape)
        self._position = 0

    def _advance(self, end: Array) -> Array:
        """Pass one interval, which ends where the value is `end`; the rows of a closing window."""
        nothing: Array = np.zeros((0, self._shape[1]))
        self._position += 1
        closes = self._position == self._window
        if self._mode != "sliding":
            rows: Array = end + self._sum - self._start
            if self._mode == "consecutive" and closes:
                self._start = end
                self._rebase()
            return rows if closes or self._mode == "start" else nothing
        # Sliding: identifier.c says why in blocks.
        if closes:
            self._block = self._sum
            self._rebase()
            self._full = True
        here = end + self._sum
        rows = here - self._ring[self._position] + self._block if self._full else nothing
        self._ring[self._position] = here
        return rows


@lru_cache(maxsize=256)
def _rule(steps: tuple[float, ...], left: int) -> tuple[int, tuple[float, ...]]:
    """Weights of the nodes, per unit of step, for the integral over step `left`.

    Args:
        steps: times between the nodes, s.
        left: the interval.

    Returns:
        the first node that is used, and the weights from it on.
    """
    x = [0.0, 1.0]
    for step in reversed(steps[:left]):
        x.insert(0, x[0] - step / steps[left])
    for step in steps[left + 1 :]:
        x.append(x[-1] + step / steps[left])
    for reach in range(REACH, 0, -1):
        first = max(0, left - reach)
        weights = _weights(x[first : left + 2 + reach])
        if float(np.abs(weights).sum()) <= LARGEST_GAIN:
            return first, tuple(weights.tolist())
    return left, (0.5, 0.5)


def _weights(x: Sequence[float]) -> Array:
    """Integrate Lagrange's polynomials on the nodes x over (0, 1), by Gauss and Legendre."""
    out = np.empty(len(x))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for i, own in enumerate(x):
            above, below = _SHARE.copy(), np.float64(1.0)
            for other in (*x[:i], *x[i + 1 :]):
                above *= _AT - other
                below *= own - other
            out[i] = (above[0] + above[1] + above[2]) / below
    return out
