"""The motion of a floating base in a frame that falls freely.

The frame does not turn, and weight has no part in it. Attitude R and speed u of the base in this
frame follow from its specific force f and angular velocity w, without a pose and without angular
accelerations:

    R' = R w^,   u' = R f,    from I, 0

With v = R' u, the kernels give the momentum p of base and joints, its rate, and the kinetic energy
T. For a window, with the measured force F and moment M on the base in its axes about its origin,

    p(t2) - p(t1) - integral rate dt = integral (F, M, tau - friction) dt
    T(t2) - T(t1) = integral (F . v + M . w + qd . (tau - friction)) dt

This holds for every such frame: u less a constant is the speed in another one. The frame of a
window is that in which the base rests at its end, so that speeds stay small.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import chained, touching
from symgen.estimation.integrals import POINTS
from symgen.estimation.values import FloatArray


class FreeFall(NamedTuple):
    """The motion of a floating base in a frame that falls freely.

    Attributes:
        rotation: (N, 3, 3) attitude R.
        u: (N, 3) speed in the axes of this frame, m/s.
        w: (N, 3) angular velocity in the axes of the base, rad/s.
    """

    rotation: FloatArray
    u: FloatArray
    w: FloatArray

    def speeds(self, at: slice) -> list[FloatArray]:
        """Return v and w, (k, 3) each, in a span of `window_rows`: the base rests at the end of its
        last window.
        """
        end = at.stop - POINTS - 1
        u = self.u[at] - self.u[end]
        v = u[:, None] @ self.rotation[at]
        return [v[:, 0], self.w[at]]


def free_fall(log: FilteredLog) -> FreeFall:
    """Return the motion of the base of a log in the frame that starts with the log.

    The turn of a step is the exponential of the integral of w and of half its commutator, to fourth
    order (Magnus).

    Raises:
        IdentificationError: the force at a contact is unknown.
    """
    from scipy.spatial.transform import Rotation

    flags, robot = touching(log.samples), log.samples.robot
    if flags is not None and robot is not None:
        used = np.flatnonzero(flags.any(axis=0))
        frames = [robot.contacts[k].frame for k in used]
        raise IdentificationError(
            f"{log.name}: the models of energy and momentum need the forces at "
            f"{', '.join(frames)}; accepted: model torque, or columns {frames[0]}.fx .. "
            f"{frames[0]}.nz"
        )
    force, w, *_ = log.base
    commutator = np.cross(w[:-1], w[1:])
    turns = np.diff(_integral(w, log.step), axis=0)
    turns += log.step**2 / 12 * commutator
    rotation = chained(Rotation.from_rotvec(np.vstack([np.zeros(3), turns]))).as_matrix()
    pulls = rotation @ force[:, :, None]
    return FreeFall(rotation, _integral(pulls[:, :, 0], log.step), w)


def _integral(x: FloatArray, step: float) -> FloatArray:
    """Return the integral of a signal (N, m) from its first sample to each, by a spline."""
    from scipy.interpolate import make_interp_spline

    at = np.arange(len(x))
    return np.asarray(step * make_interp_spline(at, x, 5).antiderivative()(at))
