"""Spelling of symbols, order of parameters and units: the field's terms, in one place.

Khalil and Kleinfinger's modified Denavit-Hartenberg notation; the standard inertial parameters of
link j are expressed in frame j, about its origin.
"""

from __future__ import annotations

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2

INERTIA = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENT = ("MX", "MY", "MZ")
MASS = "M"
LINK = (*INERTIA, *MOMENT, MASS)
ROTOR = "IA"

#: The parameter that each word of a joint's `friction` list declares, in the order of X.
FRICTION = {"coulomb": "FS", "viscous": "FV", "offset": "OF"}

#: The parameters of a coupling: rotor inertia, then viscous and Coulomb friction of the drive.
COUPLING_INERTIA = "IAM"
COUPLING_FRICTION = ("FVM", "FSM")


def unit(prefix: str, sigma: int) -> str:
    """Return the SI unit of a standard parameter.

    Args:
        prefix: the parameter's name without its joint number, for example "XX" or "FS".
        sigma: type of the joint that carries it (0 revolute, 1 prismatic, 2 fixed).
    """
    linear = sigma == PRISMATIC
    if prefix in INERTIA:
        return "kg m2"
    if prefix in MOMENT:
        return "kg m"
    if prefix == MASS:
        return "kg"
    if prefix in (ROTOR, COUPLING_INERTIA):
        return "kg" if linear else "kg m2"
    if prefix in ("FS", "OF", "FSM"):
        return "N" if linear else "N m"
    if prefix in ("FV", "FVM"):
        return "N s/m" if linear else "N m s/rad"
    raise ValueError(f"no unit is known for {prefix!r}")
