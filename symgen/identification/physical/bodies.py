"""Links as bodies: the pseudo-inertia of ten link parameters, and mass, centre and inertia."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.errors import ParameterError
from symgen.robot.body import Body
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]


def pseudo_inertia(link: Sequence[float] | FloatArray) -> FloatArray:
    """Return the pseudo-inertia [[S, m], [m', M]] (4, 4) of a link (Wensing, Kim, Slotine 2018).

        S = tr(J)/2 I - J = integral of r r' dm,   m = (MX, MY, MZ)

    A body of positive mass density in some volume has a positive definite one, and the reverse.

    Args:
        link: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, (10,).
    """
    J, m, M = _matrices(link)
    out = np.zeros((4, 4))
    out[:3, :3] = np.trace(J) / 2 * np.eye(3) - J
    out[:3, 3] = out[3, :3] = m
    out[3, 3] = M
    return out


def bodies(robot: Robot, values: Mapping[str, float]) -> tuple[Body, ...]:
    """Return the link behind every joint of the file, fixed ones included.

    With c = m/M, the inertia about the centre of mass is J - M (c'c I - c c').

    Args:
        robot: the mechanism.
        values: its standard parameters by name; those of links are used (XX3 ... M3, XXL ... ML).

    Raises:
        ParameterError: a link parameter is missing, or a mass is not positive.
    """
    out = []
    for joint in robot.joints:
        suffixes = [str(joint.number)] + ["L"] * (robot.payload == joint.number)
        wanted = [[f"{prefix}{suffix}" for prefix in names.LINK] for suffix in suffixes]
        missing = [name for link in wanted for name in link if name not in values]
        if missing:
            raise ParameterError(
                f"link {joint.number}: {', '.join(missing[:5])} missing; accepted: all of "
                f"{' '.join(names.LINK)}"
            )
        J, m, M = _matrices(np.sum([[values[name] for name in link] for link in wanted], axis=0))
        if not M > 0:
            raise ParameterError(f"link {joint.number}: its mass is {M:g}; accepted: above 0")
        com = m / M
        about = J - M * (com @ com * np.eye(3) - np.outer(com, com))
        out.append(Body(joint.number, M, com, about))
    return tuple(out)


def _matrices(link: Sequence[float] | FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return J (3, 3), m (3,) and M."""
    J = np.zeros((3, 3))
    J[np.triu_indices(3)] = link[:6]
    J += np.triu(J, 1).T
    return J, np.array(link[6:9], dtype=float), float(link[9])
