"""Trajectories that are linear in their coefficients: Fourier series, B-splines, the paper's two.

The position of a joint is q(t) = B(t) c with a fixed matrix B. Speed, acceleration and jerk are B'
c, B'' c and B''' c, so limits on all four are linear in c. Each joint can have its own basis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError

_DEGREE = 5


@dataclass(frozen=True)
class Basis:
    """One joint's functions of time, on 0 <= t <= duration.

    Attributes:
        duration: duration in s.
        terms: determines the number of coefficients.
        kind: name of the family.
        ends: conditions for rest at the ends: shares of the duration, and derivative orders.
    """

    duration: float
    terms: int
    kind: ClassVar[str]
    ends: ClassVar[tuple[tuple[float, int], ...]] = ()

    @property
    def constant(self) -> FloatArray:
        """Coefficients of q(t) = 1, (size,): the first function is 1."""
        return np.asarray(np.eye(1, self.matrix(np.zeros(1)).shape[1])[0])

    @property
    def periods(self) -> int:
        """Number of periods of the fastest function."""
        return self.terms

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the derivative of this order of all functions at t, (N, size)."""
        raise NotImplementedError

    def rest(self) -> FloatArray:
        """Return E (conditions, size): the joint is at rest at both ends if E c = 0."""
        rows = [self.matrix(np.array([end * self.duration]), order) for end, order in self.ends]
        return np.concatenate([np.zeros((0, len(self.constant))), *rows])


class Fourier(Basis):
    """q = a0 + sum over k of a_k cos(k w t) + b_k sin(k w t), w = 2 pi / duration.

    Coefficients a0, a_1, b_1, a_2, ... (Swevers et al. 1997); speed and acceleration are zero at
    both ends, which are at the same place.
    """

    kind = "fourier"
    ends = ((0.0, 1), (0.0, 2))

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the functions' derivatives, (N, 2 terms + 1)."""
        w = 2 * np.pi / self.duration * np.arange(1, self.terms + 1)
        turned = np.outer(t, w) + order * np.pi / 2  # each derivative turns by a quarter
        out = np.empty((len(t), 2 * self.terms + 1))
        out[:, 0] = float(order == 0)
        out[:, 1::2] = w**order * np.cos(turned)
        out[:, 2::2] = w**order * np.sin(turned)
        return out


class Spline(Basis):
    """Functions whose sum is 1."""

    @property
    def constant(self) -> FloatArray:
        """Coefficients of q(t) = 1, (size,)."""
        return np.ones_like(super().constant)

    @property
    def periods(self) -> int:
        """Number of periods of the fastest function."""
        return math.ceil(self.terms / 2)


class BSpline(Spline):
    """q = sum of c_i N_i(t): B-splines of degree 5 on uniform knots, clamped at both ends.

    `terms` is the number of coefficients; speed and acceleration are zero at both ends.
    """

    kind = "bspline"
    ends = ((0.0, 1), (0.0, 2), (1.0, 1), (1.0, 2))

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the functions' derivatives, (N, terms)."""
        inner = np.linspace(0, self.duration, self.terms - _DEGREE + 1)
        knots = np.pad(inner, _DEGREE, mode="edge")
        from scipy import interpolate

        return np.asarray(interpolate.BSpline(knots, np.eye(self.terms), _DEGREE)(t, nu=order))


class Cubic(Spline):
    """The paper's first generator: q = q0 + D (3 s^2 - 2 s^3), s = t/T, from stop to stop.

    Coefficients are the `terms` + 1 positions of the stops, at equal times. One term gives the
    motion of Gautier and Khalil (1988). Accelerations jump at the stops.
    """

    kind = "cubic"

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the functions' derivatives, (N, terms + 1)."""
        stops, values = np.linspace(0, self.duration, self.terms + 1), np.eye(self.terms + 1)
        from scipy import interpolate

        return np.asarray(interpolate.CubicHermiteSpline(stops, values, 0 * values)(t, nu=order))


class Cosine(Basis):
    """The paper's second generator: q = q0 + sum of A_k (1 - cos(k w t)), w = 2 pi / duration.

    Coefficients q0, A_1, A_2, ...; speeds are zero at both ends, accelerations are not.
    """

    kind = "cosine"

    def matrix(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the functions' derivatives, (N, terms + 1)."""
        waves = Fourier(self.duration, self.terms).matrix(t, order)
        return np.column_stack([waves[:, 0], waves[:, :1] - waves[:, 1::2]])


KINDS = {b.kind: b for b in (Fourier, BSpline, Cubic, Cosine)}
#: The fewest terms that can move.
_FEWEST = {"fourier": 3, "bspline": 8, "cubic": 1, "cosine": 1}
#: Families whose acceleration is continuous and zero at both ends.
SMOOTH = ("fourier", "bspline")


def basis(kind: str, duration: float, terms: int | None = None) -> Basis:
    """Return a basis by the name of its family.

    Raises:
        ParameterError: there is no such family, or it has too few terms to move.
    """
    if kind not in KINDS:
        raise ParameterError(f"kind of trajectory {kind!r}; accepted: {', '.join(KINDS)}")
    # Up to 0.8 Hz, as far as this is not too many to search in.
    harmonics = round(min(20.0, max(6.0, 0.8 * duration)))
    usual = 2 * harmonics + 4 if kind == "bspline" else harmonics
    count = usual if terms is None else terms
    if count < _FEWEST[kind]:
        raise ParameterError(f"{count} terms of kind {kind}; accepted: {_FEWEST[kind]} or more")
    return KINDS[kind](duration, count)


def times(duration: float, step: float) -> FloatArray:
    """Return uniform times in s from 0 to the end, at most `step` apart."""
    return np.linspace(0.0, duration, math.ceil(duration / step - 1e-9) + 1)


def fine(own: Basis, step: float) -> FloatArray:
    """Return times in s over a run, at most `step` apart, and both sides of its jumps."""
    t = times(own.duration, step)
    if not isinstance(own, Cubic):
        return t
    stops = np.linspace(0.0, own.duration, own.terms + 1)
    return np.unique(np.concatenate([t, stops, np.nextafter(stops[1:-1] * (1 - 1e-12), 0.0)]))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One run: a basis and its coefficients for every movable joint, rad or m."""

    bases: tuple[Basis, ...]
    coefficients: tuple[FloatArray, ...]

    @property
    def duration(self) -> float:
        """Length in s."""
        return self.bases[0].duration

    def times(self, step: float) -> FloatArray:
        """Return uniform times in s from the start to the end, at least as dense as `step`."""
        return times(self.duration, step)

    def at(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return q, or its derivative of this order, at times t in s, (N, n)."""
        pairs = zip(self.bases, self.coefficients, strict=True)
        return np.stack([b.matrix(t, order) @ c for b, c in pairs], axis=1)

    def to_dict(self) -> dict[str, Any]:
        """Return the trajectory as values of JSON."""
        return {
            "duration": self.duration,
            "joints": [
                {"kind": b.kind, "terms": b.terms, "coefficients": c.tolist()}
                for b, c in zip(self.bases, self.coefficients, strict=True)
            ],
        }
