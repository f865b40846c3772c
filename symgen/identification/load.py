"""The parameters of a load, and the mass, centre of mass and inertia that follow from them.

    s = (XX XY XZ YY YZ ZZ MX MY MZ M),   c = (MX, MY, MZ)/M,   I_c = J - M (c'c I - c c')

Standard deviations are first-order approximations. A quantity has no value if it depends on a
direction of s that the logs do not determine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symgen import names
from symgen.errors import ParameterError
from symgen.estimation.values import FloatArray
from symgen.identification.interior import Positive, minimise
from symgen.identification.possible import deviation_axes
from symgen.identification.pseudo_inertia import (
    BASIS,
    LENGTH,
    UNIT,
    about_centre,
    least_eigenvalues,
    parameters_of,
)
from symgen.robot.tables import Frame

COM = ("cx", "cy", "cz")
#: Names of mass, centre of mass and inertia about it, in the order of `read_off`.
LABELS = ("mass", *COM, *names.INERTIA)
#: Units of ten link parameters, for a body of LENGTH and 1 kg.
UNITS = np.array([*[LENGTH**2] * 6, *[LENGTH] * 3, 1.0])
#: Small number in these units: step of derivatives, smallest eigenvalue of the pseudo-inertia of a
#: possible load, and largest share of an undetermined direction in a determined quantity.
SMALL = 1e-6
#: Weight of the squared size of undetermined directions.
_FAINT = 1e-6


@dataclass(frozen=True, eq=False)
class Load:
    """Ten link parameters of a load, and the directions that the logs determine.

    Attributes:
        s: (10,) XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame.
        covariance: (10, 10) covariance of s in the determined directions.
        null: (10, k) orthonormal undetermined directions, in units of 0.1 m and 1 kg.
    """

    s: FloatArray
    covariance: FloatArray
    null: FloatArray

    def in_frame(self, frame: Frame) -> Load:
        """Return the load in another frame of the same link.

            P' = A P A',  A = T^-1,  with the pseudo-inertia P of the load

        Args:
            frame: a frame that is fixed in the frame of the load.
        """
        A = np.linalg.inv(np.array(frame.transform))
        T = np.array([parameters_of(A @ P @ A.T) for P in BASIS]).T
        null = np.linalg.qr((T * UNITS / UNITS[:, None]) @ self.null)[0]
        return Load(T @ self.s, T @ self.covariance @ T.T, null)

    def determined(self) -> tuple[str, ...]:
        """Return the LABELS of the quantities that no undetermined direction changes."""
        slopes = _slopes(UNITS * np.arange(1.0, 11.0)) * UNITS  # of a load without symmetries
        open_ = np.linalg.norm(slopes @ self.null, axis=1)
        norms = np.linalg.norm(slopes, axis=1)
        return tuple(name for name, x in zip(LABELS, open_ / norms, strict=True) if x < SMALL)

    def std(self) -> FloatArray:
        """Return the standard deviations of mass, centre of mass and inertia about it, (10,)."""
        J = _slopes(self.s)
        return np.sqrt(np.maximum(np.diag(J @ self.covariance @ J.T), 0.0))

    def nearest(self, mass: float | None = None) -> Load:
        """Return the most probable physically possible load: a body of positive density.

            minimise |z|^2   with   s = s0 + L z,  L L' = C,  and a positive definite pseudo-inertia

        Directions that the logs do not determine are free.

        Args:
            mass: known mass of the load, kg, which is kept; None if unknown.
        """
        from scipy.linalg import null_space

        scale = UNITS * abs(float(self.s[-1]) if mass is None else mass)
        x0 = self.s / scale
        if not self.null.size and least_eigenvalues(x0[None])[0] > 0:
            return self
        L = deviation_axes(self.covariance) / scale[:, None]
        onto = np.hstack([self.null, L])
        free = self.null.shape[1]
        weights = np.append(np.full(free, _FAINT), np.ones(len(L)))
        start = np.append(np.zeros(free), np.linalg.solve(L, UNIT - x0))
        ways = null_space(onto[-1:] * (mass is not None))  # they keep a known mass
        slopes = np.einsum("pn,pab->abn", onto @ ways, BASIS)
        body = Positive(slopes[None], ((1 - SMALL) * np.eye(4))[None])
        weighted = ways.T * weights
        w = minimise(weighted @ ways, weighted @ start, [body], np.zeros(ways.shape[1])).y
        x = x0 + onto @ (start + ways @ w)
        return Load(x * scale, self.covariance, self.null)


def read_off(s: FloatArray) -> FloatArray:
    """Return mass, centre of mass (3) and inertia XX XY XZ YY YZ ZZ about it, (10,).

    Raises:
        ParameterError: the mass is zero.
    """
    mass, com, inertia = about_centre(s)
    if not np.isfinite(com).all():
        raise ParameterError("the load has no mass: the logs with and without it do not differ")
    return np.array([mass, *com, *inertia[np.triu_indices(3)]])


def _slopes(s: FloatArray) -> FloatArray:
    """Return the derivative of `read_off`, (10, 10), by central differences."""
    step = SMALL * UNITS
    changes = [read_off(s + h) - read_off(s - h) for h in np.diag(step)]
    return np.array(changes).T / (2 * step)
