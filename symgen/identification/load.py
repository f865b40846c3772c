"""A load as a body: from ten link parameters with a covariance to what can be read off a drawing.

    s = (XX XY XZ YY YZ ZZ MX MY MZ M),   c = (MX, MY, MZ)/M,   I_c = J - M (c'c I - c c')

Standard deviations follow from those of s to first order. Where the logs do not determine some
direction of s, what depends on it has no value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symgen import names
from symgen.errors import ParameterError
from symgen.estimation.values import FloatArray
from symgen.identification.physical import IDENTITY, MATRIX, Cone, minimise, pseudo_inertia

COM = ("cx", "cy", "cz")
#: Names of mass, centre and inertia about it, in the order of `read_off`.
LABELS = ("mass", *COM, *names.INERTIA)
_LENGTH = 0.1  # m, the size of a load in whose units its parameters compare
_SEEN = 1e-6  # share of a parameter in directions that the logs do not determine
_MARGIN = 1e-6  # smallest eigenvalue of the pseudo-inertia of the nearest body, in its units
_FAINT = 1e-9
_PAIRS = [(i, k) for i in range(3) for k in range(i, 3)]
#: Places in s that mass, centre and inertia about it depend on: XX on MY, MZ and M, and so on.
_NEEDED = (
    (9,),
    *((6, 9), (7, 9), (8, 9)),
    *((0, 7, 8, 9), (1, 6, 7, 9), (2, 6, 8, 9), (3, 6, 8, 9), (4, 7, 8, 9), (5, 6, 7, 9)),
)


@dataclass(frozen=True, eq=False)
class LoadEstimate:
    """Ten link parameters of a load, as far as logs determine them.

    Attributes:
        s: (10,) XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame.
        covariance: of s, (10, 10), in the directions that are determined.
        null: (10, k) orthonormal directions, in units of 0.1 m and 1 kg, that are not.
    """

    s: FloatArray
    covariance: FloatArray
    null: FloatArray

    def known(self) -> tuple[bool, ...]:
        """Say which of mass, centre and inertia about it are determined, as `LABELS` has them."""
        hidden = np.linalg.norm(self.null, axis=1) > _SEEN
        return tuple(not hidden[list(needed)].any() for needed in _NEEDED)

    def std(self) -> FloatArray:
        """Return standard deviations of mass, centre and inertia about it, (10,)."""
        J = _jacobian(self.s)
        return np.sqrt(np.maximum(np.diag(J @ self.covariance @ J.T), 0.0))

    def nearest(self, mass: float | None = None) -> LoadEstimate:
        """Return the most likely load that exists: a body of positive density.

            minimise (s - s0)' C^-1 (s - s0)   with a pseudo-inertia that is positive definite

        Args:
            mass: kept, where it is known.

        Raises:
            ParameterError: the solver finds no solution.
        """
        scale = units() * max(abs(float(self.s[-1])), 1e-3)
        if not self.null.size and float(np.linalg.eigvalsh(pseudo_inertia(self.s / scale))[0]) > 0:
            return self
        x0 = self.s / scale
        C = self.covariance / np.outer(scale, scale)
        P = np.linalg.pinv(C, rcond=1e-12, hermitian=True)
        P = P / float(np.linalg.norm(P, 2)) + _FAINT * np.eye(10)
        cones = [Cone("semidefinite", MATRIX, -_MARGIN * IDENTITY)]
        if mass is not None:
            cones.append(Cone("zero", np.eye(10)[-1:], np.array([-mass / scale[-1]])))
        x, _ = minimise(P, -P @ x0, cones)
        return LoadEstimate(x * scale, self.covariance, self.null)


def units() -> FloatArray:
    """Return the units of ten link parameters for a length of 0.1 m and a mass of 1 kg."""
    return np.array([*[_LENGTH**2] * 6, *[_LENGTH] * 3, 1.0])


def read_off(s: FloatArray) -> FloatArray:
    """Return mass, centre of mass (3) and inertia XX XY XZ YY YZ ZZ about it, (10,).

    Raises:
        ParameterError: the mass is zero.
    """
    mass, c = s[-1], s[6:9] / (s[-1] or np.nan)
    if not np.isfinite(c).all():
        raise ParameterError("the load has no mass: the logs with and without it do not differ")
    steiner = mass * (c @ c * np.eye(3) - np.outer(c, c))
    inertia = [s[n] - steiner[pair] for n, pair in enumerate(_PAIRS)]
    return np.array([mass, *c, *inertia])


def _jacobian(s: FloatArray) -> FloatArray:
    """Return the derivative of `read_off`, (10, 10), by central differences."""
    step = 1e-6 * units() * max(abs(float(s[-1])), 1e-3)
    columns = [(read_off(s + h) - read_off(s - h)) / (2 * h.sum()) for h in np.diag(step)]
    return np.array(columns).T
