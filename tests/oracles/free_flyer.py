"""A robot on Pinocchio's free flyer, with its base as link 0.

Arrays over equations have the six of the base first: linear, then angular, in base axes about the
origin of frame 0. Pinocchio's acceleration of a free flyer is the derivative of its local velocity,
v' = f + g - w x v.
"""

from __future__ import annotations

import numpy as np

from oracles.pinocchio_arm import PinocchioArm
from oracles.transforms import Arm

#: Any attitude of the base, and its velocity.
ATTITUDE = np.array([0.3, -0.5, 0.7, 0.4])
VELOCITY = np.array([0.9, -1.7, 0.4])


class FreeFlyer(PinocchioArm):
    """Dynamics of a robot whose base moves freely.

    Args:
        arm: the table.
        links: (links + 1, 10), the base first.
        rotor_inertia: (n,).
    """

    def __init__(self, arm: Arm, links: np.ndarray, rotor_inertia: np.ndarray) -> None:
        super().__init__(arm, links[1:], rotor_inertia, floating=True)
        pin = self._pin
        self.model.appendBodyToJoint(1, self._inertia(links[0]), pin.SE3.Identity())
        self.data = self.model.createData()
        self.rotation = pin.Quaternion(ATTITUDE).normalized().matrix()
        self.weight = self.rotation.T @ self.model.gravity.linear
        self.order = np.array([*range(6), *self._slots])
        self.rotors = np.diag([*np.zeros(6), *self.rotor_inertia])

    def place(self, q: np.ndarray) -> np.ndarray:
        out = np.zeros(self.model.nq)
        out[3:7] = self._pin.Quaternion(self.rotation).coeffs()
        out[self._slots + 1] = q
        return out

    def _rates(self, base: np.ndarray, joints: np.ndarray) -> np.ndarray:
        out = np.zeros(self.model.nv)
        out[:6], out[self._slots] = base, joints
        return out

    def _moving(self, q, qd, qdd, f, w, wd, v=VELOCITY):
        speed = self._rates([*v, *w], qd)
        rate = self._rates([*(f + self.weight - np.cross(w, v)), *wd], qdd)
        return self.place(q), speed, rate

    def dynamics(self, q, qd, qdd, f, w, wd) -> np.ndarray:
        """Wrench on the base and torques, (n + 6,)."""
        tau = self._pin.rnea(self.model, self.data, *self._moving(q, qd, qdd, f, w, wd))
        return tau[self.order] + self.rotors @ [*f, *wd, *qdd]

    def masses(self, q) -> np.ndarray:
        """Mass matrix, (n + 6, n + 6)."""
        upper = np.triu(self._pin.crba(self.model, self.data, self.place(q)))
        full = upper + np.triu(upper, 1).T
        return full[np.ix_(self.order, self.order)] + self.rotors

    def slopes(self, q, qd, qdd, f, w, wd) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives of `dynamics` by q, qd and w, at rest of the origin."""
        state = self._moving(q, qd, qdd, f, w, wd, v=np.zeros(3))
        found = self._pin.computeRNEADerivatives(self.model, self.data, *state)
        by_q, by_speed = (x[np.ix_(self.order, self.order)] for x in found[:2])
        return by_q[:, 6:].copy(), by_speed[:, 6:].copy(), by_speed[:, 3:6].copy()

    def momentum(self, q, qd, v, w) -> tuple[np.ndarray, np.ndarray]:
        """Momentum M u, and the part of its rate that no wrench and no torque causes, C' u."""
        u = np.array([*v, *w, *qd])
        matrix = self._pin.computeCoriolisMatrix(
            self.model, self.data, self.place(q), self._rates(u[:6], qd)
        )
        return self.masses(q) @ u, matrix[np.ix_(self.order, self.order)].T @ u

    def kinetic(self, q, qd, v, w) -> float:
        """Kinetic energy of links and rotors."""
        speed = self._rates([*v, *w], qd)
        rigid = self._pin.computeKineticEnergy(self.model, self.data, self.place(q), speed)
        return rigid + 0.5 * float(self.rotor_inertia @ np.square(qd))

    def centroidal(self, q, qd, v, w) -> tuple[np.ndarray, np.ndarray]:
        """Momentum about the centre of mass, and that centre, in base axes."""
        found = self._pin.computeCentroidalMomentum(
            self.model, self.data, self.place(q), self._rates([*v, *w], qd)
        )
        turn = self.rotation.T
        return np.array([*turn @ found.linear, *turn @ found.angular]), turn @ self.data.com[0]

    def centroidal_rate(self, q, qd, qdd, v, w, vd, wd) -> np.ndarray:
        """Rate of that momentum in a frame that does not turn, in base axes; vd is dv/dt."""
        found = self._pin.computeCentroidalMomentumTimeVariation(
            self.model, self.data, self.place(q), self._rates([*v, *w], qd),
            self._rates([*vd, *wd], qdd),
        )  # fmt: skip
        turn = self.rotation.T
        return np.array([*turn @ found.linear, *turn @ found.angular])

    def point(self, j: int, at: np.ndarray, state) -> tuple[np.ndarray, np.ndarray]:
        """Velocity, and specific force and angular acceleration of a point of link j."""
        q, qd, qdd, f, w, wd = state
        place, speed, rate = self._moving(q, qd, qdd, f, w, wd)
        self._pin.forwardKinematics(self.model, self.data, place, speed, rate)
        joint, inside = self.carriers[j]
        x = inside.act(at)
        turn = self.rotation.T @ self.data.oMi[joint].rotation
        twist, spatial = self.data.v[joint], self.data.a[joint]
        moved = twist.linear + np.cross(twist.angular, x)
        faster = spatial.linear + np.cross(spatial.angular, x) + np.cross(twist.angular, moved)
        velocity = np.array([*turn @ moved, *turn @ twist.angular])
        return velocity, np.array([*(turn @ faster - self.weight), *turn @ spatial.angular])
