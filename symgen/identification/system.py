"""From samples to the linear system y = W X of the energy theorem (Gautier and Khalil, 1988).

Over a window (t1, t2):

    integral qd^T tau dt = [h(t2) - h(t1)]^T X_inertial + [integral f dt]^T X_friction

with h the energy regressor and f the columns of friction power: one equation a window, and no
accelerations. Integrals are those of the cubic spline through the samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import Samples, cumulative_integral
from symgen.errors import IdentificationError
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
WINDOWS = ("sliding", "consecutive", "start")


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of one log: W (K, p), y (K,) in J, t (K,) end of each window in s.

    `correlation` is the number of rows that share samples: overlapping windows.
    """

    name: str
    W: FloatArray
    y: FloatArray
    t: FloatArray
    correlation: int

    def rows(self, part: slice) -> Equations:
        """Return some of the equations."""
        return Equations(self.name, self.W[part], self.y[part], self.t[part], self.correlation)


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """What an estimator takes: the equations of every log, and the names of the columns."""

    names: tuple[str, ...]
    logs: tuple[Equations, ...]

    @property
    def W(self) -> FloatArray:
        """All regressor rows, (K, p)."""
        return np.concatenate([e.W for e in self.logs])

    @property
    def y(self) -> FloatArray:
        """All left-hand sides, (K,)."""
        return np.concatenate([e.y for e in self.logs])


def energy_equations(
    evaluator: Evaluator, samples: Samples, window: float, mode: str = "sliding"
) -> Equations:
    """Build the energy equations of one log.

    Args:
        evaluator: the compiled model.
        samples: the log on a uniform grid.
        window: length of the windows, s; without meaning in mode "start".
        mode: "sliding" (a window ends at every sample), "consecutive", or "start" (every window
            begins at the first sample, as in the original paper).

    Raises:
        IdentificationError: the window does not fit the log.
    """
    if mode not in WINDOWS:
        raise IdentificationError(f"windows {mode!r}; accepted: {', '.join(WINDOWS)}")
    length = samples.t[-1] - samples.t[0]
    if mode != "start" and not 0 < window < length:
        raise IdentificationError(
            f"{samples.name}: a window of {window:g} s does not fit a log of {length:.3g} s"
        )
    steps = max(1, round(window / samples.step))
    if mode != "start" and abs(steps * samples.step - window) > 0.5 * samples.step + 1e-12:
        raise IdentificationError(
            f"{samples.name}: a window of {window:g} s is shorter than half a sample "
            f"({samples.step:g} s)"
        )
    h = evaluator.energy_regressor(samples.q, samples.qd)
    f = evaluator.friction_power(samples.q, samples.qd)
    power = np.einsum("ij,ij->i", samples.qd, samples.tau)
    integrals = cumulative_integral(np.column_stack([f, power]), samples.step)
    whole = np.column_stack([h, integrals])
    if mode == "start":
        first, last = np.zeros(len(whole) - 1, dtype=int), np.arange(1, len(whole))
    else:
        hop = 1 if mode == "sliding" else steps
        last = np.arange(steps, len(whole), hop)
        first = last - steps
    difference = whole[last] - whole[first]
    correlation = {"sliding": steps, "consecutive": 1, "start": len(last) // 4}[mode]
    return Equations(
        samples.name, difference[:, :-1], difference[:, -1], samples.t[last], max(1, correlation)
    )
