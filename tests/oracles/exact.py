"""Reference values to 50 digits: the oracle of `transforms` in 60-digit mpmath arithmetic.

The context is private to this module, so that the precision of ``mpmath.mp`` stays as it is.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np

from oracles.transforms import Arm, energy_regressor, kinetic_regressor
from oracles.transforms import mpmath_backend as _backend

MP = mpmath.MPContext()
MP.dps = 60
MP_BACKEND = _backend(MP)


def exact_angle(angle: float, fractions: bool = True) -> Any:
    """Exact value of an angle [rad].

    Args:
        angle: as read from a file.
        fractions: whether a float that is k pi/24 to double precision stands for that fraction;
            any other angle is the decimal its repr prints.
    """
    angle = float(angle)
    k = round(angle * 24 / math.pi)
    # Two units in the last place: k*pi/24, pi*k/24 and pi/(24/k) round differently.
    if fractions and abs(angle - k * math.pi / 24) <= 2 * math.ulp(angle):
        return MP.pi * k / 24
    return MP.mpf(repr(angle))


def exact_arm(arm: Arm, fractions: bool = True) -> Arm:
    """Read floats as what a file means: fractions of pi, and lengths as the printed decimals."""

    def decimals(values: Sequence[float]) -> tuple[Any, ...]:
        return tuple(MP.mpf(repr(float(value))) for value in values)

    angles = {
        key: tuple(exact_angle(a, fractions) for a in getattr(arm, key))
        for key in ("gamma", "alpha", "theta")
    }
    lengths = {key: decimals(getattr(arm, key)) for key in ("b", "d", "r", "gravity")}
    return replace(arm, **angles, **lengths)


def exact_energy_regressor(
    arm: Arm, q: Any, qd: Any, rotor: bool | Sequence[bool] = True, fractions: bool = True
) -> np.ndarray:
    """Standard energy regressor (..., columns) of mpmath numbers, at least 50 digits right.

    Args:
        arm: floats as read from a file.
        q: (..., n) [rad or m]; floats are taken as the doubles they are.
        qd: (..., n) [rad/s or m/s].
        rotor: one flag for all joints or one per joint of the file.
        fractions: see `exact_angle`.
    """
    return energy_regressor(exact_arm(arm, fractions), q, qd, rotor, MP_BACKEND)


def exact_torque_regressor(
    arm: Arm, q: Any, qd: Any, qdd: Any, rotor: bool | Sequence[bool] = True, fractions: bool = True
) -> np.ndarray:
    """Standard torque regressor without friction at one state, 30 digits right.

    Lagrange's equations d/dt dL/dqd - dL/dq of the energy columns. T is quadratic in qd, so that
    its central difference is exact; the others have the step 1e-20, hence errors near 1e-40.

    Returns:
        (n, columns) in the order of `column_names`, mpmath numbers.
    """
    exact = exact_arm(arm, fractions)
    q, qd, qdd = (MP_BACKEND.array(x) for x in (q, qd, qdd))
    step = MP.mpf(10) ** -20
    unit = MP_BACKEND.array(np.eye(arm.n))

    def kinetic(x: np.ndarray, xd: np.ndarray) -> np.ndarray:
        return kinetic_regressor(exact, x, xd, rotor, MP_BACKEND)

    def energy(x: np.ndarray, xd: np.ndarray) -> np.ndarray:
        return energy_regressor(exact, x, xd, rotor, MP_BACKEND)

    def momentum(x: np.ndarray, xd: np.ndarray) -> np.ndarray:
        return (kinetic(x, xd + unit) - kinetic(x, xd - unit)) / 2

    def lagrangian(x: np.ndarray) -> np.ndarray:
        return 2 * kinetic(x, qd) - energy(x, qd)  # L = T - U = 2 T - (T + U)

    ahead = momentum(q + step * qd, qd + step * qdd)
    behind = momentum(q - step * qd, qd - step * qdd)
    slope = lagrangian(q + step * unit) - lagrangian(q - step * unit)
    return (ahead - behind - slope) / (2 * step)
