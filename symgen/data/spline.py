"""Between samples: the cubic spline through them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symgen.data.raw import FloatArray


def interpolated(t: FloatArray, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return the cubic spline (not-a-knot) through samples x (N, ...) at t (N,), s.

    Returns:
        A function from times (T,) to values (T, ...), in the unit of x.
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, x)
    return lambda at: np.asarray(spline(at), dtype=np.float64)
