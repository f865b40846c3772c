"""A robot under torques, with dry friction that can hold a joint at rest.

    M(q) qdd + h(q, qd) + A' f = tau,     v = A qd

A has a row for every dry friction: a joint with Coulomb friction (or an effect with sign(qd)), and
the drive speed u = qd_j + ratio qd_k of a coupling. The force f is set-valued, as in Filippov's
convex extension of sign (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems,
2008):

    f = FS sign(v) where v is not 0,     f in [-FS, FS] where v = 0

Each friction has a mode: 1 or -1 while it slides that way, 0 while it sticks. In a given mode the
equations are smooth; a sticking friction has the f that keeps v at 0. Nothing is regularised: a
joint under less load than FS does not creep. Joints with coulomb_width have tanh(qd/width) in the
kernels and no mode.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.experiment.repeated import Repeated
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

KERNELS = ("forward_dynamics", "mass_matrix", "bias_torque", "inverse_dynamics", "friction_torque")
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
    """A robot with parameters, ready to be moved.

    Attributes:
        evaluator: its kernels.
        X: parameters (p,) with those of dry friction at 0: the kernels know the rest.
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
    forward: Repeated
    mass: Repeated
    bias: Repeated

    def speed(self, qd: FloatArray) -> FloatArray:
        """Return v = A qd, (runs, m)."""
        own = qd[:, self.joint]
        if len(self.joint) == len(self.A):
            return own
        return np.concatenate([own, (qd[:, None, :] * self.A[len(self.joint) :]).sum(-1)], axis=1)

    def pull(self, f: FloatArray) -> FloatArray:
        """Return A' f, the torques (runs, n) of friction forces (runs, m)."""
        out = np.zeros((len(f), self.A.shape[1]))
        out[:, self.joint] = f[:, : len(self.joint)]
        for i in range(len(self.joint), len(self.A)):
            out += f[:, i, None] * self.A[i]
        return out

    def limits(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the least and largest force (runs, m) that each friction holds with."""
        low, high = (np.tile(sign * self.force, (len(q), 1)) for sign in (-1.0, 1.0))
        for i in np.flatnonzero(self.shown):
            j = self.joint[i]
            still = self._friction(q, _with(qd, j, 0.0))[:, j]
            low[:, i] += self._friction(q, _with(qd, j, -_BARELY))[:, j] - still
            high[:, i] += self._friction(q, _with(qd, j, _BARELY))[:, j] - still
        middle = (low + high) / 2  # friction that drives has no hold
        return np.minimum(low, middle), np.maximum(high, middle)

    def _friction(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        columns = self.evaluator["friction_torque"](q, qd)
        base = self.evaluator.model.base
        return np.asarray((columns * self.X[base.inertial : base.linear]).sum(-1))

    def accelerate(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, mode: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return qdd (runs, n) and the friction forces f (runs, m) in given modes.

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
        applied = tau - self.pull(f)
        if self.shown.any():
            qd = self._seen(qd, mode)
        qdd = self.forward(q, qd, applied)
        if not mode.all():
            rows = np.flatnonzero((mode == 0).any(axis=1))
            qdd[rows], held = self._hold(q[rows], qd[rows], applied[rows], mode[rows] == 0)
            f[rows] += held
        return qdd, f

    def _seen(self, qd: FloatArray, mode: FloatArray) -> FloatArray:
        """Return the speeds that give sign(qd) in the kernels the value of the mode."""
        out = qd.copy()
        for i in np.flatnonzero(self.shown):
            j, s = self.joint[i], mode[:, i]
            out[:, j] = np.where(s == 0, 0.0, s * np.maximum(s * qd[:, j], _BARELY))
        return out

    def _hold(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, stuck: Mask
    ) -> tuple[FloatArray, FloatArray]:
        """Solve M qdd + A' f = tau - h with A qdd = 0 for the rows that stick."""
        if len(self.joint) == len(self.A):
            return self._hold_joints(q, qd, tau, stuck)
        runs, n, m = len(q), q.shape[1], len(self.A)
        M = self.mass(q)
        rows = stuck[:, :, None] * self.A
        system = np.zeros((runs, n + m, n + m))
        system[:, :n, :n] = M
        system[:, :n, n:] = rows.transpose(0, 2, 1)
        system[:, n:, :n] = rows
        mass = np.einsum("rij,ij->ri", rows @ M, self.A)
        give = _SHARE / np.where(stuck, mass, 1.0) if self.shared else np.zeros((runs, m))
        at = np.arange(n, n + m)
        system[:, at, at] = np.where(stuck, -give, 1.0)
        right = np.zeros((runs, n + m, 1))
        right[:, :n, 0] = tau - self.bias(q, qd)
        found = np.linalg.solve(system, right)[:, :, 0]
        return found[:, :n], np.where(stuck, found[:, n:], 0.0)

    def _hold_joints(
        self, q: FloatArray, qd: FloatArray, tau: FloatArray, stuck: Mask
    ) -> tuple[FloatArray, FloatArray]:
        """Do so where no coupling may stick: joints that stick leave the equations."""
        M, right = self.mass(q), tau - self.bias(q, qd)
        fixed = np.zeros(q.shape, dtype=bool)
        fixed[:, self.joint] = stuck
        system = np.where(fixed[:, :, None] | fixed[:, None, :], np.eye(q.shape[1]), M)
        qdd = np.linalg.solve(system, np.where(fixed, 0.0, right)[:, :, None])[:, :, 0]
        rest = right - (M * qdd[:, None, :]).sum(-1)
        return qdd, np.where(stuck, rest[:, self.joint], 0.0)

    def stopped(self, qd: FloatArray, mode: FloatArray) -> FloatArray:
        """Return qd with exactly 0 along the frictions that stick."""
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
    ) -> FloatArray:
        """Return the modes in which the frictions of mode 0 stick or begin to slide.

        One that sticks needs f within its limits, one that begins to slide accelerates that way:
        a linear complementarity problem with bounds, solved by principal pivots, of the least
        index after the first rounds (Murty 1974, Judice and Pires 1994). It has one solution where
        the rows of A are independent, as M is positive definite.

        Args:
            q: (runs, n) rad or m.
            qd: (runs, n) rad/s or m/s.
            tau: (runs, n) N m or N.
            mode: (runs, m) 0 at rest; the others keep their mode.

        Raises:
            ParameterError: no modes are consistent.
        """
        resting = mode == 0
        low, high = self.limits(q, qd)
        slack = SLACK * (high - low) + 1e-12
        for turn in range(_ROUNDS):
            qdd, f = self.accelerate(q, qd, tau, mode)
            onward = self.speed(qdd) * mode
            over = np.where(f > high + slack, 1.0, np.where(f < low - slack, -1.0, 0.0))
            wrong = resting & np.where(mode == 0, over != 0, onward < -1e-9 * (1 + abs(onward)))
            if not wrong.any():
                return mode
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
        evaluator: with the kernels of KERNELS.
        X: base parameters (p,).

    Raises:
        ParameterError: a Coulomb friction is negative: at rest its motion would not be determined;
            or dry friction stands beside effects of the load, whose hold at rest is not known.
    """
    model, robot = evaluator.model, evaluator.model.robot
    numbers = [j.number for j in robot.movable]
    rows: dict[tuple[str, int], tuple[FloatArray, float, int]] = {}
    rest = np.array(X, dtype=np.float64)
    for i, p in enumerate(model.base.parameters):
        standard = model.base.standard[p.index]
        if standard.prefix not in ("FS", "FSM") or p.inertial:
            continue
        a = np.zeros(robot.n)
        if standard.prefix == "FS":
            if robot.joint(standard.joint).coulomb_width:
                continue
            a[numbers.index(standard.joint)] = 1.0
        else:
            coupling = next(c for c in robot.couplings if c.second == standard.joint)
            a[numbers.index(coupling.first)] = 1.0
            a[numbers.index(coupling.second)] = float(coupling.ratio.subs(robot.values()))
        if X[i] < 0:
            raise ParameterError(
                f"{p.name} = {X[i]:.4g}: Coulomb friction that drives leaves the motion from rest "
                "open; accepted: 0 or more, or a coulomb_width in the robot file"
            )
        at = numbers.index(standard.joint) if standard.prefix == "FS" else -1
        rows[standard.prefix, standard.joint] = (a, float(X[i]), at)
        rest[i] = 0.0
    signs = _signs(robot)
    for number in sorted(signs):
        unit = np.eye(robot.n)[numbers.index(number)]
        rows.setdefault(("FS", number), (unit, 0.0, numbers.index(number)))
    # A friction of no force still has no mode: the joint is smooth there.
    rows = dict(sorted(rows.items()))  # FS before FSM
    kept = [(k, r) for k, r in rows.items() if r[1] > 0 or (k[1] in signs and k[0] == "FS")]
    if kept and robot.loaded:
        raise ParameterError(
            f"robot {robot.name!r}: Coulomb friction of width 0 and effects of the load (taur) are "
            "not simulated together; accepted: a coulomb_width on every joint with Coulomb friction"
        )
    A = np.array([r[0] for _, r in kept]).reshape(len(kept), robot.n)
    return Plant(
        evaluator,
        rest,
        A,
        np.array([r[1] for _, r in kept]),
        np.array([r[2] for _, r in kept if r[2] >= 0], dtype=np.intp),
        np.array([k[0] == "FS" and k[1] in signs for k, _ in kept], dtype=bool),
        len(kept) > 0 and bool(np.linalg.matrix_rank(A) < len(A)),
        *(Repeated(evaluator, name, rest) for name in KERNELS[:3]),
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
    """Return X (p,) with rigid body, rotors, viscous friction and offsets alone."""
    out = np.array(X, dtype=np.float64)
    for i, p in enumerate(model.base.parameters):
        if not p.inertial and model.base.standard[p.index].prefix not in ("FV", "FVM", "OF"):
            out[i] = 0.0
    return out
