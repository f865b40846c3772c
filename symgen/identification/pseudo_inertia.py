"""Pseudo-inertias: the ten parameters of a link as a symmetric matrix.

    P = [[S, m], [m', M]],   S = tr(J)/2 I - J = integral of r r' dm,   m = (MX, MY, MZ)

A pseudo-inertia is positive definite if and only if some body of positive mass density has it
(Wensing, Kim, Slotine 2018).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen import names
from symgen.estimation.values import FloatArray
from symgen.robot.body import link_matrices, pseudo_inertia, steiner

#: Default length of a body, m.
LENGTH = 0.1


def parameters_of(P: FloatArray) -> FloatArray:
    """Return XX XY XZ YY YZ ZZ MX MY MZ M (10,) of a pseudo-inertia (4, 4)."""
    J = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
    return np.array([*J[np.triu_indices(3)], *P[:3, 3], P[3, 3]])


def about_centre(link: Sequence[float] | FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre of mass (3,) and inertia (3, 3) about it; NaN if the mass is 0.

    Args:
        link: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, (10,).
    """
    J, m, mass = link_matrices(link)
    com = m / (mass or np.nan)
    return mass, com, J - steiner(mass, com)


#: Pseudo-inertias of unit parameters, (10, 4, 4).
BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(len(names.LINK))])
#: The link parameters whose pseudo-inertia is I.
UNIT = parameters_of(np.eye(4))


def least_eigenvalues(links: FloatArray) -> FloatArray:
    """Return the smallest eigenvalue of the pseudo-inertia of each link (L, 10)."""
    return np.linalg.eigvalsh(np.tensordot(links, BASIS, 1))[:, 0]
