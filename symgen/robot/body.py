"""A link as a rigid body: mass, centre of mass and inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """One link in the frame of its joint (modified Denavit-Hartenberg).

    Attributes:
        joint: number of the joint in the file. A payload counts as part of its link.
        mass: kg.
        com: centre of mass (3,), m.
        inertia: inertia matrix (3, 3) about the centre of mass, kg m2. Entry (0, 1) is
            -integral of x y dm.
    """

    joint: int
    mass: float
    com: FloatArray
    inertia: FloatArray
