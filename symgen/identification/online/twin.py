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
_LEAST_SHARE = float(np.finfo(np.float32).tiny)  # nothing is left of the past
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
    polynomial through six samples, two on each side of it, of sixth order on uneven steps too. The
    weight of a sample is known five samples later; it is added to the windows that it belongs to.

    Attributes:
        least_squares: the state of the least squares; read it or merge it into another.
        status: of the equations that a step looked at last, bits of OUTLIER and NOT_EXCITED.
    """

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
            mode: "start", every window starts at the first sample, as in the paper; "sliding", a
                window begins in the middle of the one before and weighs its samples by a triangle
                (std comes out too small, by up to a fifth); "consecutive", a window begins where
                the last one ended.
            window: length in samples, at least 1, in mode "sliding" the next even number of them;
                ignored in mode "start".
            forgetting: weight of the past per sample, in (0, 1].

        Raises:
            ValueError: an argument is out of range.
        """
        if mode not in get_args(Mode):
            raise ValueError(f"mode is {mode!r}; accepted: {', '.join(get_args(Mode))}")
        if mode != "start" and window < 1:
            raise ValueError(f"window is {window} samples; at least 1 is needed")
        if equations < 1:
            raise ValueError(f"equations is {equations}; at least 1 is needed")
        if not 0.0 < forgetting <= 1.0:
            raise ValueError(f"forgetting is {forgetting}; a number in (0, 1] is accepted")
        self._columns = columns
        self._mode = mode
        self._shape = (equations, parameters + 1)
        self._length = {"start": equations, "sliding": (window + 1) // 2}.get(mode, window)
        brief = mode != "sliding" or self._length < equations + 4
        self._patience = 2 * equations * (3 if not brief else NODES + (mode == "sliding"))
        self._rows_a_step = -(-equations // self._length)
        # Per equation: so many come every `length` samples.
        share = forgetting ** (self._length / equations)
        self.least_squares = LeastSquares(parameters, max(share, _LEAST_SHARE))
        self.status = OK
        self._refused, self._largest = 0, 0.0
        self.restart()

    def restart(self) -> None:
        """Forget the open windows, not what was learned: the next sample is a first one."""
        self._samples: list[tuple[Array, Array]] = []  # value and rate of the latest NODES
        self._weights: list[list[float]] = []  # theirs in the intervals around them
        self._steps: list[float] = []
        # Windows that are open, with what rounding put into them too much, and the one before the
        # first; the sum of all (start).
        self._open = [self._nothing(), self._nothing()]
        self._total = self._nothing()
        self._begun, self._whole = False, False
        self._left = self._length + REACH + 1
        self._pending: list[Array] = []

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
        if self._samples and not (dt > 0.0 and isfinite(dt)):
            return NOT_FINITE
        value, rate = self._evaluate(q, qd, tau)
        self._absorb(self._take(value, rate, dt))
        return OK

    def _absorb(self, rows: Array) -> None:
        """Take equations in, but for outliers and those that teach nothing."""
        if len(rows):
            self.status = OK
        for row in rows:
            status = self._judged(row[:-1], float(row[-1]))
            if status == OK:
                self.least_squares.update(row[:-1], float(row[-1]))
            self.status |= status
        if self._mode == "start" and len(rows) and self.status & OUTLIER:
            self.restart()

    def _judged(self, row: Array, y: float) -> int:
        """Return what is wrong with an equation, if anything: see identifier.c."""
        past = self.least_squares
        if not (isfinite(y) and bool(np.isfinite(row).all())):
            return OUTLIER
        seen = past.foresee(row[None], np.array([y]))
        freedom = past.count - row.size
        if seen is not None and seen[1][0] < LEAST_LEVERAGE * row.size * (1.0 - past.forgetting):
            return NOT_EXCITED
        if seen is not None and freedom > 0.0 and abs(seen[0][0]) > LEAST_WRONG * self._largest:
            gate = GATE * sqrt(past.rss / freedom * (1.0 + seen[1][0]))
            if abs(seen[0][0]) > gate:
                self._refused += 1
                if self._refused <= self._patience:
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
        """Take a sample in; return the equations [w, y] whose turn it is, (K, p + 1)."""
        if self._samples:
            self._steps = [*self._steps, dt][1 - NODES :]
        self._samples = [*self._samples, (value, rate)][-NODES:]
        self._weights = [*self._weights, [0.0] * NODES][-NODES:]
        left = len(self._samples) - REACH - 2
        if left >= 0:
            first, weights = _rule(tuple(self._steps), left)
            for node, weight in enumerate(weights, first):
                self._weights[node][left + REACH + 1 - node] = weight * self._steps[left]
        if len(self._samples) == NODES:
            self._look_at(*self._samples[0], self._weights[0])
        due = self._pending[: self._rows_a_step]
        self._pending = self._pending[self._rows_a_step :]
        return np.array(due) if due else np.zeros((0, self._shape[1]))

    def _nothing(self) -> tuple[Array, Array]:
        return np.zeros(self._shape), np.zeros(self._shape)

    def _look_at(self, value: Array, rate: Array, weights: Sequence[float]) -> None:
        """Add a sample to the windows that it belongs to: see `absorb` in identifier.c."""
        sliding, share = self._mode == "sliding", 1.0 / self._length
        at, left, rising, falling = 1, self._left, 0.0, 0.0
        if not self._begun and not sliding:
            self._add(at, value, -1.0)
        for j in range(NODES):
            left -= 1
            rest = share * left if sliding else 0.0
            rising += (1.0 - rest) * weights[j]
            falling += rest * weights[j]
            if sliding and j == REACH + 1:
                self._add(at, value, -share)
                self._add(at - 1, value, share)
            if left == 0 or j == NODES - 1:
                self._add(at, rate, rising)
                if sliding:
                    self._add(at - 1, rate, falling)
                rising, falling = 0.0, 0.0
            if left == 0 and j < NODES - 1:
                if at + 1 == len(self._open):
                    self._open.append(self._nothing())
                if not sliding and j == REACH:
                    self._add(at, value, 1.0)
                    self._add(at + 1, value, -1.0)
                at, left = at + 1, self._length
        self._begun = True
        self._left -= 1
        if self._left == 0:
            self._close()
            self._left = self._length

    def _add(self, at: int, x: Array, factor: float) -> None:
        """Add to an open window; one that is not among the newest has no carry any more."""
        total, carry = self._open[at]
        newest = len(self._open) - 1 - at
        with np.errstate(over="ignore", invalid="ignore"):
            if newest == 0 or (self._mode == "sliding" and newest == 1):
                self._open[at] = _compensated(total, carry, factor * x)
            else:
                self._open[at] = total + factor * x, carry

    def _close(self) -> None:
        """Pass the end of a window; its equations are to be taken."""
        before, ended = self._open[0], self._open[1]
        self._open.pop(0)
        if self._mode == "start":
            self._total = _compensated(*self._total, ended[0])
            self._pending = list(self._total[0])
        elif self._mode == "consecutive":
            self._pending = list(ended[0])
        elif self._whole:
            self._pending = list(before[0])
        self._whole = True

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


def _compensated(total: Array, carry: Array, x: Array) -> tuple[Array, Array]:
    """Return total + x, and what rounding put into it too much."""
    with np.errstate(over="ignore", invalid="ignore"):
        part = x - carry
        new = total + part
        return new, (new - total) - part


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
