"""Exact numbers from rounded decimals, and short forms of numbers with many digits.

Robot files of other programs contain rounded numbers: pi/2 as 1.5708, or inside a quaternion with
six digits. symgen therefore reads an angle near a multiple of pi/24 as that multiple, and computes
placements with 50 digits. It then recognises results that are a fraction of pi, a short decimal, or
a short decimal times a square root.
"""

from __future__ import annotations

import functools
from decimal import Decimal
from typing import Any

import sympy as sp

from symgen.robot import expressions

#: Angles are recognised in steps of pi/PARTS.
PARTS = 24
#: An angle closer than this to a multiple of pi/PARTS is read as that multiple, in every format.
TOLERANCE = 1e-4  # rad
_MAX_TURNS = 4
_LAST = 5e-16  # largest relative rounding error of an angle as a double
_SURE = 1e-30
_SHORT = 10  # decimals of a short decimal
LONG = 15  # decimals of any other number
_ANGLE = 1e-10  # rad


@functools.cache
def context() -> Any:
    """Return the mpmath context with 50 digits."""
    import mpmath

    digits = mpmath.mp.clone()
    digits.dps = 50
    return digits


def written_fraction(angle: sp.Expr) -> sp.Expr:
    """Return k pi/24 for a decimal that equals it to the last digit; otherwise the decimal."""
    if not angle.is_Rational:
        return angle
    k = fraction_of_pi(angle, _LAST * max(1.0, abs(float(angle))))
    return k * sp.pi if k else angle


def fraction_of_pi(value: Any, within: float = TOLERANCE) -> sp.Rational | None:
    """Return k/24 if the angle is within `within` of k pi/24, otherwise None."""
    digits = context()
    number = digits.mpf(int(value.p)) / int(value.q) if isinstance(value, sp.Rational) else value
    k = int(digits.nint(number * PARTS / digits.pi))
    near = abs(number - k * digits.pi / PARTS) <= within
    return sp.Rational(k, PARTS) if near and abs(k) <= _MAX_TURNS * PARTS else None


def last_digit(decimal: sp.Rational) -> float:
    """Return one unit of the last digit of a decimal."""
    unit = sp.S.One
    while not (decimal / unit).is_Integer:
        unit /= 10
    return float(unit)


def snapped(value: Any, within: float) -> Any:
    """Return the multiple of pi/24 within `within` of an angle, otherwise the angle; 50 digits."""
    k = fraction_of_pi(value, within)
    return value if k is None else context().pi * int(k.p) / int(k.q)


def angle(value: Any, decimals: int = LONG) -> sp.Expr:
    """Write an angle as k pi/24, as k pi/2 plus a short decimal, or as a decimal.

    With fewer decimals, angles that differ by right angles have the same decimal.
    """
    k = fraction_of_pi(value, _ANGLE)
    if k is not None:
        return k * sp.pi
    for quarters in (0, 1, -1, 2, -2):
        short = _short(value - quarters * context().pi / 2)
        if short is not None:
            return short + sp.Rational(quarters, 2) * sp.pi
    right = context().pi / 2
    quarters = int(context().nint(value / right)) if decimals < LONG else 0
    return _rounded(value - quarters * right, decimals) + sp.Rational(quarters, 2) * sp.pi


def length(value: Any, decimals: int = LONG) -> sp.Expr:
    """Write a length as a decimal, or as a short decimal times a square root over six."""
    rounded = _rounded(value, decimals)
    if abs(rounded) < _ANGLE / 100:
        return sp.S.Zero
    if (rounded * 10**_SHORT).is_Integer:
        return rounded
    digits = context()
    for root in (2, 3, 6):
        short = _short(value * 6 / digits.sqrt(root))
        if short is not None:
            return short * sp.sqrt(root) / 6
    return rounded


def to_double(value: Any) -> float:
    """Round a number with 50 digits to a double; rounding errors near zero become 0."""
    return float(value) if abs(value) > _SURE else 0.0


def _short(value: Any) -> sp.Rational | None:
    """Return the number as a short decimal if it is one, otherwise None."""
    rounded = _rounded(value, _SHORT)
    exact = context().mpf(int(rounded.p)) / int(rounded.q)
    return rounded if abs(value - exact) < _SURE else None


def _rounded(value: Any, decimals: int) -> sp.Rational:
    scaled = int(context().nint(value * 10**decimals))
    return expressions.exact(Decimal(scaled).scaleb(-decimals))
