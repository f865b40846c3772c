"""Spelling of symbols, order of parameters and units: the terms of the field, in one place.

The notation is Khalil and Kleinfinger's modified Denavit-Hartenberg notation. The standard inertial
parameters of link j are expressed in frame j, about its origin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2

INERTIA = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENT = ("MX", "MY", "MZ")
MASS = "M"
LINK = (*INERTIA, *MOMENT, MASS)
ROTOR = "IA"

#: Letters of a joint's name that a result shows.
NAME = 60
#: The parameter that each word of a joint's `friction` list declares, in the order of X.
FRICTION = {"coulomb": "FS", "viscous": "FV", "offset": "OF"}

#: The parameters of a coupling: rotor inertia, then viscous and Coulomb friction of the drive.
COUPLING_INERTIA = "IAM"
COUPLING_FRICTION = ("FVM", "FSM")

#: Bases of a robot: at rest, with an IMU that measures their motion, or such a one that is free to
#: move, so that it has parameters and equations too.
BASES = ("fixed", "imu", "floating")
#: Measurements of the IMU in the axes of the base: specific force a - g, m/s2, and angular
#: velocity, rad/s, with its derivative. They are inputs of kernels and, except for wd, columns of
#: logs.
BASE = ("f", "w", "wd")
#: Inputs that describe a free base, in their order, with their sizes: those of the IMU, the
#: velocity of its origin, m/s, and the force and moment on it, N and N m, about the origin in its
#: axes.
FREE_BASE = {"f": 3, "v": 3, "w": 3, "wd": 3, "wrench": 6}

#: License and maintainer of a package, in the manifests of other tools, if its user names none.
LICENSE = "Proprietary"
MAINTAINER = "Unknown <unknown@example.com>"

#: Kinds of the equations of a free base, in their order; those of joints are types of joints.
BASE_FORCE, BASE_MOMENT = 3, 4
BASE_KINDS = (BASE_FORCE,) * 3 + (BASE_MOMENT,) * 3
#: Names of these equations in messages and tables, and their units.
BASE_ROWS = tuple(f"base {what} {axis}" for what in ("force", "moment") for axis in "xyz")
BASE_UNITS = ("N",) * 3 + ("N m",) * 3
#: Endings of the columns FRAME.fx to FRAME.nz of a log: the wrench of the world on the robot.
WRENCH_ENDS = ("fx", "fy", "fz", "nx", "ny", "nz")

_UNITS = {
    **dict.fromkeys((*INERTIA, ROTOR, COUPLING_INERTIA), "kg m2"),
    **dict.fromkeys(MOMENT, "kg m"),
    MASS: "kg",
    **dict.fromkeys(("FS", "OF", "FSM"), "N m"),
    **dict.fromkeys(("FV", "FVM"), "N m s/rad"),
}
#: Units that differ for a prismatic joint.
_SLIDING = {ROTOR: "kg", COUPLING_INERTIA: "kg", "FV": "N s/m", "FVM": "N s/m"}
_SLIDING |= dict.fromkeys(("FS", "OF", "FSM"), "N")


def unit(prefix: str, sigma: int) -> str:
    """Return the SI unit of a standard parameter.

    Args:
        prefix: name of the parameter without its joint number, for example "XX" or "FS".
        sigma: type of its joint (0 revolute, 1 prismatic, 2 fixed).
    """
    return (_UNITS | _SLIDING if sigma == PRISMATIC else _UNITS)[prefix]


def joints_in_words(numbers: Sequence[int], labels: Mapping[int, str]) -> str:
    """Return joints for a message: "joint 2", "joints 2 and 3", "elbow (2) and wrist (3)".

    Args:
        numbers: joint numbers in the robot file.
        labels: number -> label, from `joint_label`.
    """
    known = [labels.get(number, f"joint {number}") for number in numbers]
    if all(label == f"joint {number}" for label, number in zip(known, numbers, strict=True)):
        known = list(map(str, numbers))
        known[:1] = [f"joint{'s' if len(known) > 1 else ''} {known[0]}"] if known else []
    *before, last = known or ["no joint"]
    return f"{', '.join(before)} and {last}" if before else last


def joint_label(number: int, name: str) -> str:
    """Return the label of a joint in results: its name, if the file has one, and its number."""
    short = name if len(name) <= NAME else f"{name[: NAME - 3]}..."
    return f"{short} ({number})" if name else f"joint {number}"
