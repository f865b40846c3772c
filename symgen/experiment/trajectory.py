"""Trajectories that are linear in their coefficients: a Fourier series for every joint.

    q = a0 + sum over k of a_k cos(k w t) + b_k sin(k w t),    w = 2 pi / duration

The position of a joint is q(t) = B(t) c with a fixed matrix B. Speed, acceleration and jerk are B'
c, B'' c and B''' c, so limits on all four are linear in c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError

#: Harmonics of the default series: its frequencies reach 0.8 Hz, if their number stays small enough
#: for the search. The last number is the minimum for a motion from rest to rest.
_HIGHEST, _USUAL, _FEWEST = 0.8, (6.0, 20.0), 3


@dataclass(frozen=True)
class Fourier:
    """The functions of a Fourier series, with coefficients a0, a_1, b_1, a_2, ...

    Attributes:
        duration: duration of a period, s.
        terms: number of harmonics.
    """

    duration: float
    terms: int

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the derivative of order `order` of all functions at t, (N, 2 terms + 1)."""
        w = 2 * np.pi / self.duration * np.arange(1, self.terms + 1)
        # each derivative shifts the phase by a quarter turn
        turned = np.outer(t, w) + order * np.pi / 2
        out = np.empty((len(t), 2 * self.terms + 1))
        out[:, 0] = float(order == 0)
        out[:, 1::2] = w**order * np.cos(turned)
        out[:, 2::2] = w**order * np.sin(turned)
        return out

    def times(self, step: float) -> FloatArray:
        """Return uniform times in s from 0 to the end, at most `step` apart."""
        count = math.ceil(self.duration / step - 1e-9) + 1
        return np.linspace(0.0, self.duration, count)


def fourier_series(duration: float, terms: int | None = None) -> Fourier:
    """Return a series with `terms` harmonics; by default as many as the duration allows.

    Raises:
        ParameterError: the series has too few harmonics to move from rest to rest.
    """
    if terms is None:
        fewest, most = _USUAL
        terms = round(min(most, max(fewest, _HIGHEST * duration)))
    if terms < _FEWEST:
        raise ParameterError(f"{terms} terms; accepted: {_FEWEST} or more")
    return Fourier(duration, terms)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One run.

    Attributes:
        series: functions of time, the same for all joints.
        coefficients: (n, 2 terms + 1) coefficients of every movable joint, rad or m.
    """

    series: Fourier
    coefficients: FloatArray

    @property
    def duration(self) -> float:
        """Length in s."""
        return self.series.duration

    def times(self, step: float) -> FloatArray:
        """Return uniform times in s from the start to the end, at least as dense as `step`."""
        return self.series.times(step)

    def at(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return q, or its derivative of order `order`, at times t in s, (N, n)."""
        return self.series.matrix(t, order) @ self.coefficients.T

    def to_dict(self) -> dict[str, Any]:
        """Return the trajectory as values for JSON."""
        terms = self.series.terms
        return {
            "duration": self.duration,
            "joints": [
                {"kind": "fourier", "terms": terms, "coefficients": c}
                for c in self.coefficients.tolist()
            ],
        }
