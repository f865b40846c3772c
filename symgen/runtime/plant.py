"""Forward dynamics with dry friction that can hold a joint at rest.

    M(q) qdd + h(q, qd) + A' f = tau,     v = A qd

A has a row for every dry friction: a joint with Coulomb friction (or an effect with sign(qd)), and
the drive speed u = qd_j + ratio qd_k of a coupling. The force f is set-valued, as in Filippov's
convex extension of sign (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems,
2008):

    f = FS sign(v) where v is not 0,     f in [-FS, FS] where v = 0

Each friction has a mode: 1 or -1 while it slides in that direction, 0 while it sticks. The
equations of a mode are smooth; a sticking friction has the f that keeps v at 0. There is no
regularisation: a joint with a load below FS does not creep. Joints with coulomb_width have
tanh(qd/width) in the kernels, and no mode.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model
from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Sizes of batches that have buffers of their own.
_SIZES = 64


class Repeated:
    """A kernel with its parameters on fixed buffers, which saves a few microseconds in each call.

    Args:
        evaluator: model with the kernel.
        name: name of the kernel.
        X: parameters (p,).
    """

    def __init__(self, evaluator: Evaluator, name: str, X: FloatArray) -> None:
        self._X = X
        self._bound = lru_cache(_SIZES)(evaluator[name].bind)

    def __call__(self, *inputs: FloatArray) -> FloatArray:
        """Return the first output (runs, ...) for inputs (runs, n); the last input can be (1, n).

        Raises:
            ParameterError: M is not positive definite.
        """
        bound = self._bound(len(inputs[0]))
        *motion, X = bound.inputs
        X[...] = self._X[: len(X)]
        for buffer, array in zip(motion, inputs, strict=True):
            buffer[...] = array
        if bound.call():
            raise ParameterError("forward_dynamics: the mass matrix is not positive definite")
        return bound.out.copy()


class _Inverse:
    """Mass matrix, bias torque and forward dynamics from inverse dynamics alone.

        h = ID(q, qd, 0),    M e_j = ID(q, 0, e_j) - ID(q, 0, 0),    M qdd = tau - h

    A robot whose other kernels are not compiled is so simulated without a compiler's run.
    """

    def __init__(self, evaluator: Evaluator, X: FloatArray) -> None:
        self._torque = Repeated(evaluator, "inverse_dynamics", X)

    def bias(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        return np.asarray(self._torque(q, qd, np.zeros_like(q)))

    def mass(self, q: FloatArray) -> FloatArray:
        runs, n = q.shape
        still, at = np.zeros(((n + 1) * runs, n)), np.tile(q, (n + 1, 1))
        unit = np.repeat(np.eye(n + 1, n, -1), runs, axis=0)
        columns = self._torque(at, still, unit).reshape(n + 1, runs, n)
        M = (columns[1:] - columns[0]).transpose(1, 2, 0)
        return np.asarray((M + M.transpose(0, 2, 1)) / 2)

    def forward(self, q: FloatArray, qd: FloatArray, tau: FloatArray) -> FloatArray:
        force = np.broadcast_to(tau, q.shape) - self.bias(q, qd)
        try:
            L = np.linalg.cholesky(self.mass(q))
        except np.linalg.LinAlgError as error:
            raise ParameterError("the mass matrix is not positive definite") from error
        half = np.linalg.solve(L, force[:, :, None])
        return np.asarray(np.linalg.solve(L.transpose(0, 2, 1), half)[:, :, 0])


Mask = NDArray[np.bool_]
#: A kernel of the plant's own parameters: arrays (runs, n) to (runs, ...).
Kernel = Callable[..., FloatArray]

KERNELS = ("forward_dynamics", "mass_matrix", "bias_torque", "inverse_dynamics")
#: The speed at which an effect with sign(qd) is evaluated where its joint begins to slide.
_BARELY = 1e-12
#: Compliance, relative to the mass, that shares a load among frictions that hold one motion twice.
_SHARE = 1e-10
#: Part of the range of f by which a sticking friction may be over it. Its impulse on the joint is
#: of the second order in this.
SLACK = 1e-6
_ROUNDS = 200


@dataclass(frozen=True, eq=False)
class Plant:
    """A robot with parameters, for simulation.

    Attributes:
        evaluator: kernels of the robot.
        X: parameters (p,) for the kernels, with those of dry friction set to 0.
        A: (m, n) rows of the dry frictions, those of joints before those of couplings.
        force: (m,) Coulomb force of each, N m or N.
        joint: positions of the joints of the first rows.
        shown: (m,) whether the kernels have effects with sign(qd) of that joint.
        shared: whether rows of A depend on each other.
    """

    evaluator: Evaluator
    X: FloatArray
    A: FloatArray
    force: FloatArray
    joint: NDArray[np.intp]
    shown: Mask
    shared: bool
    forward: Kernel
    mass: Kernel
    bias: Kernel

    def speed(self, qd: FloatArray) -> FloatArray:
        """Return v = A qd, (runs, m)."""
        return np.asarray(qd @ self.A.T)

    def limits(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the smallest and largest force of each friction at rest, (runs, m) or (m,)."""
        if not self.shown.any():
            return -self.force, self.force
        low, high = (np.tile(sign * self.force, (len(q), 1)) for sign in (-1.0, 1.0))
        for i in np.flatnonzero(self.shown):
            j = self.joint[i]
            still = self.bias(q, _with(qd, j, 0.0))[:, j]
            low[:, i] += self.bias(q, _with(qd, j, -_BARELY))[:, j] - still
            high[:, i] += self.bias(q, _with(qd, j, _BARELY))[:, j] - still
        middle = (low + high) / 2  # friction that drives has no hold
        return np.minimum(low, middle), np.maximum(high, middle)

    def accelerate(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, mode: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return qdd (runs, n) and the friction forces f (runs, m) for given modes.

        Args:
            q: (runs, n) rad or m.
            qd: (runs, n), 0 along the frictions that stick.
            tau: (runs, n) torques of the motors, N m or N.
            mode: (runs, m) 1, 0 or -1.

        Raises:
            ParameterError: M is not positive definite.
        """
        if not len(self.A):
            return self.forward(q, qd, tau), mode
        f = mode * self.force
        applied = tau - f @ self.A
        if self.shown.any():
            qd = self._seen(qd, mode)
        if mode.all():
            return self.forward(q, qd, applied), f
        sticks = ~mode.all(axis=1)
        if sticks.all():
            qdd, held = self._hold(q, qd, applied, mode)
            return qdd, f + held
        qdd, rows, others = np.empty_like(q), np.flatnonzero(sticks), np.flatnonzero(~sticks)
        qdd[rows], held = self._hold(q[rows], qd[rows], applied[rows], mode[rows])
        f[rows] += held
        qdd[others] = self.forward(q[others], qd[others], applied[others])
        return qdd, f

    def _seen(self, qd: FloatArray, mode: FloatArray) -> FloatArray:
        """Return the speeds that give sign(qd) in the kernels the value of the mode."""
        out = qd.copy()
        for i in np.flatnonzero(self.shown):
            j, s = self.joint[i], mode[:, i]
            out[:, j] = np.where(s == 0, 0.0, s * np.maximum(s * qd[:, j], _BARELY))
        return out

    def _hold(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, mode: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Solve M qdd + A' f = tau - h with A qdd = 0 for the rows that stick."""
        n, m, stuck = q.shape[1], len(self.A), mode == 0
        M = self.mass(q)
        rows = stuck[:, :, None] * self.A
        system = np.zeros((len(q), n + m, n + m))
        system[:, :n, :n] = M
        system[:, :n, n:] = rows.transpose(0, 2, 1)
        system[:, n:, :n] = rows
        at, give = np.arange(n, n + m), np.zeros(1)
        if self.shared:
            mass = np.einsum("rij,ij->ri", rows @ M, self.A)
            give = _SHARE / np.where(stuck, mass, 1.0)
        system[:, at, at] = np.where(stuck, -give, 1.0)
        right = np.zeros((len(q), n + m, 1))
        right[:, :n, 0] = tau - self.bias(q, qd)
        found = np.linalg.solve(system, right)[:, :, 0]
        return self.stopped(found[:, :n], mode), np.where(stuck, found[:, n:], 0.0)

    def stopped(self, qd: FloatArray, mode: FloatArray) -> FloatArray:
        """Return qd (or qdd) with exactly 0 along the frictions that stick."""
        if mode.all():
            return qd
        out = qd.copy()
        own = len(self.joint)
        for _ in range(4 if own < len(self.A) else 1):
            for i in range(own, len(self.A)):
                a = self.A[i]
                v = np.where(mode[:, i] == 0, (out * a).sum(-1), 0.0)
                out -= v[:, None] * a / (a * a).sum()
            out[:, self.joint] = np.where(mode[:, :own] == 0, 0.0, out[:, self.joint])
        return out

    def settle(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, mode: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return consistent modes of the frictions at rest (they stick or begin to slide), qdd, f.

        A sticking friction needs f within its limits; a friction that begins to slide accelerates
        in that direction. This is a linear complementarity problem with bounds, solved by principal
        pivots, of the least index after the first rounds (Murty 1974, Judice and Pires 1994). M is
        positive definite, so the solution is unique if the rows of A are independent.

        Args:
            q: (runs, n) rad or m.
            qd: (runs, n) rad/s or m/s.
            tau: (runs, n) N m or N.
            mode: (runs, m) 0 at rest; the others keep their mode.

        Raises:
            ParameterError: no modes are consistent.
        """
        resting = mode == 0
        low, high = self.limits(q, qd) if resting.any() else (mode, mode)
        slack = SLACK * (high - low) + 1e-12
        for turn in range(_ROUNDS):
            qdd, f = self.accelerate(q, qd, tau, mode)
            onward = self.speed(qdd) * mode
            over = np.where(f > high + slack, 1.0, np.where(f < low - slack, -1.0, 0.0))
            wrong = resting & np.where(mode == 0, over != 0, onward < -1e-9 * (1 + abs(onward)))
            if not wrong.any():
                return mode, qdd, f
            if turn > 5:
                wrong &= np.cumsum(wrong, axis=1) == 1
            mode = np.where(wrong, np.where(mode == 0, over, 0.0), mode)
        raise ParameterError(
            "simulate: no consistent friction was found at rest; accepted: parameters of a robot "
            "that can exist"
        )


def _with(qd: FloatArray, j: int, value: float) -> FloatArray:
    out = qd.copy()
    out[:, j] = value
    return out


def plant(evaluator: Evaluator, X: FloatArray) -> Plant:
    """Make a plant of a model and its parameters.

    Args:
        evaluator: model with the kernels of KERNELS, or with inverse_dynamics alone.
        X: base parameters (p,).

    Raises:
        ParameterError: a Coulomb friction is negative, so motion from rest is not determined. Or
            the robot has dry friction and effects of the load, whose force at rest is not defined.
    """
    model, robot = evaluator.model, evaluator.model.robot
    numbers = [j.number for j in robot.movable]
    standard = ((i, model.base.standard[p.index]) for i, p in enumerate(model.base.parameters))
    declared = {(s.prefix, s.joint): i for i, s in standard}
    signs, rest, one = _signs(robot), np.array(X, dtype=np.float64), np.eye(robot.n)
    rows: list[tuple[FloatArray, int | None, int]] = []
    for k, joint in enumerate(robot.movable):
        at = None if joint.coulomb_width else declared.get(("FS", joint.number))
        rows.append((one[k], at, k))
    for coupling in robot.couplings:
        first, second = (one[numbers.index(j)] for j in (coupling.first, coupling.second))
        a = first + float(coupling.ratio.subs(robot.values())) * second
        rows.append((a, declared.get(("FSM", coupling.second)), -1))
    kept: list[tuple[FloatArray, float, int, bool]] = []
    for a, at, k in rows:
        force = 0.0 if at is None else float(X[at])
        shown = k >= 0 and numbers[k] in signs
        if at is not None:
            rest[at] = 0.0
            if force < 0:
                raise ParameterError(
                    f"{model.base.names[at]} = {force:.4g}: negative Coulomb friction does not "
                    "determine the motion from rest; accepted: 0 or more, or a coulomb_width in "
                    "the robot file"
                )
        # A friction of no force still has no mode: the joint is smooth there.
        if force > 0 or shown:
            kept.append((a, force, k, shown))
    if kept and robot.loaded:
        raise ParameterError(
            f"robot {robot.name!r}: Coulomb friction of width 0 and effects of the load (taur) are "
            "not simulated together; accepted: a coulomb_width on every joint with Coulomb friction"
        )
    rows_of, forces, joints, jumps = zip(*kept, strict=True) if kept else ((),) * 4
    A = np.array(rows_of).reshape(len(kept), robot.n)
    terms: tuple[Kernel, ...]
    if all(map(evaluator.has, KERNELS)):
        terms = tuple(Repeated(evaluator, name, rest) for name in KERNELS[:3])
    else:
        inverse = _Inverse(evaluator, rest)
        terms = inverse.forward, inverse.mass, inverse.bias
    return Plant(
        evaluator,
        rest,
        A,
        np.array(forces),
        np.array([k for k in joints if k >= 0], dtype=np.intp),
        np.array(jumps, dtype=bool),
        bool(kept) and bool(np.linalg.matrix_rank(A) < len(A)),
        *terms,
    )


def _signs(robot: Robot) -> set[int]:
    """Return the numbers of joints whose effects jump with the sign of their own speed."""
    return {
        j
        for effect in robot.effects
        for j, torque in effect.torque
        if f"sign(qd{j})" in str(torque) and not robot.joint(j).coulomb_width
    }


def without_dry(model: Model, X: FloatArray) -> FloatArray:
    """Return X (p,) with rigid body, rotors, viscous friction and offsets only."""
    out = np.array(X, dtype=np.float64)
    for i, p in enumerate(model.base.parameters):
        if not p.inertial and model.base.standard[p.index].prefix not in ("FV", "FVM", "OF"):
            out[i] = 0.0
    return out
