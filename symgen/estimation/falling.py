"""Windows of a floating base, in a frame that falls freely.

At the start t1 of each window, a frame has the place, the attitude and the speed of the base. From
there it falls freely and does not turn. Weight has no part in this frame. Attitude R, speed u and
place r of the base in it follow from the specific force f and the angular velocity w of the base:

    R' = R w^,   u' = R f,   r' = u,    from I, 0, 0 at t1

With v = R' u and w, the kernels give the momentum p of the base (linear, angular) and of the joints,
its rate, and the kinetic energy T. F and M are the measured force and moment on the base, in its
axes about its origin, and t1 to t2 is the window:

    [R p_linear] = integral R F dt
    [R p_angular + r x R p_linear] = integral (R M + r x R F) dt
    [p_joints] - integral rate dt = integral (tau - friction) dt
    [T] = integral (F . v + M . w + qd . (tau - friction)) dt

[..] is the change from t1 to t2. The kernels are evaluated for each window, since v depends on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symgen.data.raw import Places
from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import touching
from symgen.estimation.integrals import running_integral, window_weights
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import Windows
from symgen.runtime.evaluator import Evaluator

#: Samples or nodes of windows that are evaluated at once.
_SAMPLES, _NODES = 1 << 15, 1 << 10
_FORCE, _MOMENT, _JOINTS = slice(3), slice(3, 6), slice(6, None)


@dataclass(frozen=True, eq=False)
class FallingFrames:
    """The motion of a floating base at the nodes of K windows, in their falling frames.

    Attributes:
        q, qd: (nodes, n) positions and speeds of the joints.
        w: (nodes, 3) angular velocity of the base.
        nodes: (s + 1, K) numbers of the nodes of each window.
        step: s from node to node.
        v: (s + 1, K, 3) speed of the base in its axes, m/s.
        rotation, place: (K, 3, 3) and (K, 3) attitude and place of the base at the ends, m.
    """

    q: FloatArray
    qd: FloatArray
    w: FloatArray
    nodes: Places
    step: float
    v: FloatArray
    rotation: FloatArray
    place: FloatArray

    def energy(self, evaluator: Evaluator) -> FloatArray:
        """Return the changes of the columns of kinetic energy, (K, 1, p_inertial)."""
        ends = [0, -1]
        h = evaluator["energy_regressor"](*self._states(self.nodes[ends], self.v[ends]))
        first, last = np.split(h, 2)
        return np.asarray((last - first)[:, None])

    def momentum(self, evaluator: Evaluator) -> FloatArray:
        """Return the changes of the columns of momentum that forces cause, (K, m, p_inertial)."""
        kernel, length = evaluator["momentum_regressor"], len(self.nodes)
        weights = self.step * window_weights(length, np.array([length - 1]), length - 1)[0]
        out = []
        for some in _parts(self.nodes.shape[1], max(1, _NODES // length)):
            nodes = self.nodes[:, some]
            p, rates = (
                x.reshape(*nodes.shape, *x.shape[1:])
                for x in kernel(*self._states(nodes, self.v[:, some]))
            )
            last = p[-1]
            linear = self.rotation[some] @ last[:, _FORCE]
            angular = self.rotation[some] @ last[:, _MOMENT]
            angular += np.cross(self.place[some, :, None], linear, axis=1)
            joints = last[:, _JOINTS] - np.tensordot(weights, rates[:, :, _JOINTS], 1)
            out.append(np.concatenate([linear, angular, joints], axis=1) - p[0])
        return np.concatenate(out)

    def _states(self, nodes: Places, v: FloatArray) -> list[FloatArray]:
        """Return the inputs of a kernel at nodes; a robot without joints has no q."""
        at = nodes.ravel()
        states = [self.q[at], self.qd[at], v.reshape(-1, 3), self.w[at]]
        return [x for x in states if x.shape[1]]


def falling_frames(log: FilteredLog, windows: Windows) -> tuple[FallingFrames, FloatArray]:
    """Return the falling frames of the windows of a log, and the integrals of what is measured.

    The latter are those of R F, R M + r x R F and tau, then of power, (K, m + 1).

    Args:
        log: the log of a robot with a floating base.
        windows: its windows.

    Raises:
        IdentificationError: the force at a contact is unknown.
    """
    _require_forces(log)
    stride, steps = windows.stride, windows.steps
    first, _ = windows.spans(len(log.t))
    inside = np.arange(steps * stride + 1)[:, None]
    force, w, *_ = log.base
    v, rotation, place, y = [], [], [], []
    for some in _parts(len(first), max(1, _SAMPLES // len(inside))):
        at = first[some] + inside
        R, u, r = _fallen(force[at], w[at], log.step)
        speed = _turned(R.swapaxes(2, 3), u)
        signals = _signals(log.tau[at], R, r, np.concatenate([speed, w[at], log.qd[at]], axis=2))
        y.append(log.step * running_integral(signals)[-1])
        v.append(speed[::stride])
        rotation.append(R[-1])
        place.append(r[-1])
    q, qd = log.nodes(stride)
    frames = FallingFrames(
        q,
        qd,
        np.ascontiguousarray(w[::stride]),
        first // stride + np.arange(steps + 1)[:, None],
        stride * log.step,
        np.concatenate(v, axis=1),
        np.concatenate(rotation),
        np.concatenate(place),
    )
    return frames, np.concatenate(y)


def _require_forces(log: FilteredLog) -> None:
    """Refuse a log with a contact whose force is unknown."""
    flags, robot = touching(log.samples), log.samples.robot
    if flags is None or robot is None:
        return
    names = [c.frame for c, used in zip(robot.contacts, flags.any(axis=0), strict=True) if used]
    raise IdentificationError(
        f"{log.name}: the models of energy and momentum need all forces on a floating base, and "
        f"those at {', '.join(names)} are unknown; accepted: model torque, or columns "
        f"{names[0]}.fx .. {names[0]}.nz"
    )


def _fallen(
    force: FloatArray, w: FloatArray, step: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return R (S + 1, k, 3, 3), u and r (S + 1, k, 3) of k windows of S steps.

    The turn of a step is the exponential of the integral of w and of half its commutator, to fourth
    order (Magnus).
    """
    from scipy.spatial.transform import Rotation

    turns = step * np.diff(running_integral(w), axis=0)
    turns += step**2 / 12 * np.cross(w[:-1], w[1:])
    each = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix()
    R = np.empty((*w.shape, 3))
    R[0] = np.eye(3)
    for k, turn in enumerate(each.reshape(*turns.shape, 3)):
        R[k + 1] = R[k] @ turn
    u = step * running_integral(_turned(R, force))
    return R, u, step * running_integral(u)


def _signals(tau: FloatArray, R: FloatArray, r: FloatArray, speed: FloatArray) -> FloatArray:
    """Return the measured signals in falling frames and their power, (S + 1, k, m + 1)."""
    push = _turned(R, tau[:, :, _FORCE])
    moment = _turned(R, tau[:, :, _MOMENT]) + np.cross(r, push)
    power = np.sum(tau * speed, axis=2, keepdims=True)
    return np.concatenate([push, moment, tau[:, :, _JOINTS], power], axis=2)


def _turned(R: FloatArray, x: FloatArray) -> FloatArray:
    """Return R x for vectors (..., 3)."""
    return np.asarray((R @ x[..., None])[..., 0])


def _parts(count: int, size: int) -> Iterator[slice]:
    """Yield slices of at most `size` of a number of windows."""
    for first in range(0, count, size):
        yield slice(first, first + size)
