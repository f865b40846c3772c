"""The pair of Dormand and Prince (1980), of orders 5 and 4, and what lies within its steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Nodes (7,); weights of the stages, (i, 1, 1) for stage i + 1; those of the error, (7, 1, 1).
C = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
A = [
    np.array(row)[:, None, None]
    for row in (
        [1 / 5],
        [3 / 40, 9 / 40],
        [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    )
]
E = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
E = E[:, None, None]
# By powers 1 to 4 of the part of the step.
_INSIDE = np.array(
    [
        [1, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0, 0, 0, 0],
        [0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ]
)


def inside(part: FloatArray) -> FloatArray:
    """Return the weights b (7, P) of the slopes at parts (P,) of a step: x + h sum of b k.

    Shampine's interpolant of order 4 (1986).
    """
    a, b, c, d = (_INSIDE[:, i, None] for i in range(4))
    return np.asarray(part * (a + part * (b + part * (c + part * d))))


def crossing(
    before: FloatArray, slope: FloatArray, after: FloatArray, last: FloatArray
) -> FloatArray:
    """Return where the cubic through both ends, with their slopes, comes to zero, from 0 to 1.

    Newton's method, kept between ends of different sign.
    """
    before = np.maximum(before, 0.0)
    low, high = np.zeros_like(before), np.ones_like(before)
    rise = after - before
    c2, c3 = 3 * rise - 2 * slope - last, slope + last - 2 * rise
    part = np.where(before > 0, before / (before - after), 0.5)
    for _ in range(8):
        value = before + part * (slope + part * (c2 + part * c3))
        low, high = np.where(value > 0, part, low), np.where(value > 0, high, part)
        rate = slope + part * (2 * c2 + 3 * part * c3)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = part - value / rate
        inside = (newton > low) & (newton < high)
        part = np.where(inside, newton, (low + high) / 2)
    return np.asarray(np.minimum(np.maximum(part, 1e-3), 0.999))
