"""A link as a body: mass, centre and inertia, as robot description files want it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """One link in frame `joint` (modified Denavit-Hartenberg).

    Attributes:
        joint: number of the joint in the file; a payload is part of the link that carries it.
        mass: kg.
        com: centre of mass (3,), m.
        inertia: inertia matrix (3, 3) about the centre of mass, kg m2; entry (0, 1) is the matrix
            entry, -integral of x y dm.
    """

    joint: int
    mass: float
    com: FloatArray
    inertia: FloatArray
