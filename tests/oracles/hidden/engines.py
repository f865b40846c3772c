"""Rigid-body engines behind one function: accelerations from torques."""

from __future__ import annotations

import numpy as np

from oracles.hidden.machines import Machine
from oracles.pinocchio_arm import PinocchioArm, load_pinocchio
from oracles.transforms import PRISMATIC


class PinocchioEngine:
    """Articulated-body algorithm of Pinocchio; rotors are its armature."""

    def __init__(self, machine: Machine) -> None:
        self._pin = load_pinocchio()
        self.model = PinocchioArm(machine.arm, machine.links).model
        self.model.armature = _armature(machine)
        self.data = self.model.createData()

    def acceleration(self, q: np.ndarray, qd: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Joint accelerations (n,)."""
        return self._pin.aba(self.model, self.data, q, qd, torque)

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Torques (N, n) of bodies and rotors along a motion (N, n)."""
        rnea, model, data = self._pin.rnea, self.model, self.data
        return np.array([rnea(model, data, *row).copy() for row in zip(q, qd, qdd, strict=True)])

    def regressor(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Columns (N, n, 10 n) of the links' standard parameters; rotors have none here."""
        rows = zip(q, qd, qdd, strict=True)
        columns = self._pin.computeJointTorqueRegressor
        return np.array([columns(self.model, self.data, *row).copy() for row in rows])

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """Diagonal (n,) of the mass matrix."""
        return np.diag(self._pin.crba(self.model, self.data, q)).copy()


class MujocoEngine:
    """MuJoCo's own smooth dynamics; nothing collides, nothing is constrained."""

    def __init__(self, machine: Machine) -> None:
        import mujoco

        self._forward, self._inverse = mujoco.mj_forward, mujoco.mj_inverse
        self.model = mujoco.MjModel.from_xml_string(_mjcf(machine))
        self.data = mujoco.MjData(self.model)

    def acceleration(self, q: np.ndarray, qd: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Joint accelerations (n,)."""
        data = self.data
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, qd, torque
        self._forward(self.model, data)
        return data.qacc.copy()

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Torques (N, n) of bodies and rotors along a motion (N, n)."""
        data, out = self.data, np.empty_like(q)
        for i in range(len(q)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[i], qd[i], qdd[i]
            self._inverse(self.model, data)
            out[i] = data.qfrc_inverse
        return out


ENGINES = {"pinocchio": PinocchioEngine, "mujoco": MujocoEngine}


def _armature(machine: Machine) -> np.ndarray:
    """Rotors that move with their links: that of an elastic joint has a motion of its own."""
    rotor = machine.rotor.copy()
    if machine.elastic:
        rotor[machine.elastic[0]] = 0.0
    return rotor


def _mjcf(machine: Machine) -> str:
    """A chain of bodies; joint j turns about or slides along z of its body."""
    arm, rotor = machine.arm, _armature(machine)
    opening, closing = [], []
    for j in range(machine.n):
        cos, sin = np.cos(arm.theta[j]), np.sin(arm.theta[j])
        ca, sa = np.cos(arm.alpha[j]), np.sin(arm.alpha[j])
        # Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r), of which MJCF reads x and y axes.
        place = (arm.d[j], -sa * arm.r[j], ca * arm.r[j])
        axes = (cos, ca * sin, sa * sin, -sin, ca * cos, sa * cos)
        *inertia, mass = machine.links[j]
        centre = np.array(inertia[6:]) / mass
        steiner = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        xx, xy, xz, yy, yz, zz = np.array(inertia[:6]) - steiner[np.triu_indices(3)]
        kind = "slide" if arm.sigma[j] == PRISMATIC else "hinge"
        opening.append(
            f'<body pos="{_row(place)}" xyaxes="{_row(axes)}">'
            f'<inertial mass="{float(mass)!r}" pos="{_row(centre)}" '
            f'fullinertia="{_row((xx, yy, zz, xy, xz, yz))}"/>'
            f'<joint type="{kind}" axis="0 0 1" armature="{float(rotor[j])!r}"/>'
        )
        closing.append("</body>")
    return (
        '<mujoco><compiler angle="radian"/>'
        f'<option gravity="{_row(arm.gravity)}"><flag contact="disable" constraint="disable"/>'
        f"</option><worldbody>{''.join(opening + closing)}</worldbody></mujoco>"
    )


def _row(values: tuple[float, ...] | np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
