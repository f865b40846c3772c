"""The same robots in Pinocchio, a second oracle with its own kinematics and dynamics."""

import warnings
from types import ModuleType

import numpy as np

from oracles.transforms import FIXED, REVOLUTE, Arm


def load_pinocchio() -> ModuleType:
    """Import Pinocchio.

    Raises:
        ImportError: it is not installed (an unrelated package has the same module name).
    """
    with warnings.catch_warnings():
        # Extension modules that register the same Boost.Python or SWIG types say so when imported.
        warnings.filterwarnings("ignore", "to-Python converter for .*", RuntimeWarning)
        warnings.filterwarnings("ignore", "builtin type .* has no __module__", DeprecationWarning)
        import pinocchio
    if not hasattr(pinocchio, "Model"):
        raise ImportError("the module pinocchio is not the rigid-body library (PyPI: pin)")
    return pinocchio


class PinocchioArm:
    """Energies, torques and mass matrix of an arm with given standard parameters.

    Arrays q, qd, qdd are (n,): movable joints in file order.

    Args:
        arm: the table.
        links: (links, 10) in the order XX XY XZ YY YZ ZZ MX MY MZ M, about the frames' origins.
        rotor_inertia: (n,) IA of the movable joints; none by default.
        floating: whether the base is free, for `on_moving_base`.
    """

    def __init__(
        self,
        arm: Arm,
        links: np.ndarray,
        rotor_inertia: np.ndarray | None = None,
        floating: bool = False,
    ) -> None:
        self._pin = pin = load_pinocchio()
        self.model = pin.Model()
        self.model.gravity.linear = np.array([float(g) for g in arm.gravity])
        self.rotor_inertia = np.zeros(arm.n) if rotor_inertia is None else np.array(rotor_inertia)
        # Where the link's frame is: a Pinocchio joint and a constant placement in its frame.
        root = 0
        if floating:
            free = pin.JointModelFreeFlyer()
            root = self.model.addJoint(0, free, pin.SE3.Identity(), "base")
        carrier: dict[int, tuple[int, object]] = {0: (root, pin.SE3.Identity())}
        velocity_index: dict[int, int] = {}
        for j in _depth_first(arm):
            parent, placement = carrier[arm.ant[j - 1]]
            placement = placement * self._offset(arm, j)
            if arm.sigma[j - 1] == FIXED:
                carrier[j] = (parent, placement)
            else:
                kind = pin.JointModelRZ() if arm.sigma[j - 1] == REVOLUTE else pin.JointModelPZ()
                number = self.model.addJoint(parent, kind, placement, f"joint{j}")
                carrier[j] = (number, pin.SE3.Identity())
                velocity_index[j] = self.model.joints[number].idx_v
            body, inside = carrier[j]
            self.model.appendBodyToJoint(body, self._inertia(links[j - 1]), inside)
        self.carriers = carrier
        self.data = self.model.createData()
        self._slots = np.array([velocity_index[j] for j in arm.movable])

    def kinetic_energy(self, q: np.ndarray, qd: np.ndarray) -> float:
        """Kinetic energy, rotors included [J]."""
        rigid = self._pin.computeKineticEnergy(
            self.model, self.data, self._to_model(q), self._to_model(qd)
        )
        return float(rigid + 0.5 * np.sum(self.rotor_inertia * np.square(qd)))

    def potential_energy(self, q: np.ndarray) -> float:
        """Potential energy of the links that can move; up to a constant [J]."""
        return float(self._pin.computePotentialEnergy(self.model, self.data, self._to_model(q)))

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Torques (n,) without friction [N m or N]."""
        states = (self._to_model(x) for x in (q, qd, qdd))
        rigid = self._pin.rnea(self.model, self.data, *states)
        return rigid[self._slots] + self.rotor_inertia * np.asarray(qdd)

    def inverse_dynamics_derivatives(
        self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
    ) -> np.ndarray:
        """Derivatives (2, n, n) of the torques by q, then by qd."""
        states = (self._to_model(x) for x in (q, qd, qdd))
        found = self._pin.computeRNEADerivatives(self.model, self.data, *states)
        return np.array([x[np.ix_(self._slots, self._slots)] for x in found[:2]])

    def on_moving_base(
        self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, base: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Torques (n,) and their derivatives by q and by qd, on a base that moves.

        Args:
            q, qd, qdd: as in `inverse_dynamics`.
            base: rows f, w, wd: specific force of the origin, angular velocity and acceleration,
                in the axes of the base. Its pose and its velocity are any.
        """
        pin, (f, w, wd) = self._pin, base
        turned = pin.Quaternion(np.array([0.3, -0.5, 0.7, 0.4])).normalized()
        V = np.array([0.9, -1.7, 0.4])
        weight = turned.matrix().T @ self.model.gravity.linear
        pose, twist = [1.0, 2.0, 3.0, *turned.coeffs()], [*V, *w]
        moved = [*(f + weight - np.cross(w, V)), *wd]
        at = np.zeros(self.model.nq)
        at[:7], at[self._slots + 1] = pose, q
        speed, rate = np.zeros((2, self.model.nv))
        speed[:6], speed[self._slots] = twist, qd
        rate[:6], rate[self._slots] = moved, qdd
        torque = pin.rnea(self.model, self.data, at, speed, rate)[self._slots]
        found = pin.computeRNEADerivatives(self.model, self.data, at, speed, rate)
        by_q, by_qd = (x[np.ix_(self._slots, self._slots)].copy() for x in found[:2])
        return torque + self.rotor_inertia * np.asarray(qdd), by_q, by_qd

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix (n, n), rotors included."""
        upper = np.triu(self._pin.crba(self.model, self.data, self._to_model(q)))
        full = upper + np.triu(upper, 1).T
        return full[np.ix_(self._slots, self._slots)] + np.diag(self.rotor_inertia)

    def frame_placements(self, q: np.ndarray) -> np.ndarray:
        """Placements (n, 4, 4) of the movable joints' frames in frame 0."""
        self._pin.forwardKinematics(self.model, self.data, self._to_model(q))
        # Every joint has one velocity, so that its number is its index plus one (the universe).
        return np.array([self.data.oMi[int(slot) + 1].homogeneous for slot in self._slots])

    def _to_model(self, values: np.ndarray) -> np.ndarray:
        out = np.empty(len(self._slots))
        out[self._slots] = values
        return out

    def _offset(self, arm: Arm, j: int) -> object:
        """Everything of the joint's transform but its variable, which acts last about or along z.

        Rot(z, theta) and Trans(z, r) commute with the rotation about and the translation along z.
        """
        pin = self._pin
        gamma, b, alpha, d, theta, r = (
            float(getattr(arm, key)[j - 1]) for key in ("gamma", "b", "alpha", "d", "theta", "r")
        )
        turn = pin.utils.rotate
        to_joint = pin.SE3(turn("z", gamma), np.array([0.0, 0.0, b]))
        across = pin.SE3(turn("x", alpha), np.zeros(3)) * pin.SE3(np.eye(3), np.array([d, 0, 0]))
        return to_joint * across * pin.SE3(turn("z", theta), np.array([0.0, 0.0, r]))

    def _inertia(self, link: np.ndarray) -> object:
        """Inertia about the origin of the frame -> mass, centre of mass, inertia about it."""
        xx, xy, xz, yy, yz, zz, *first_moment, mass = (float(x) for x in link)
        about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if mass == 0.0:
            if any(first_moment):
                raise ValueError("a link without mass has no centre of mass to give to Pinocchio")
            return self._pin.Inertia(0.0, np.zeros(3), about_origin)
        centre = np.array(first_moment) / mass
        steiner = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        return self._pin.Inertia(mass, centre, about_origin - steiner)


def _depth_first(arm: Arm) -> list[int]:
    """Joints so that each subtree is contiguous, which Pinocchio's mass matrix relies on."""
    children: dict[int, list[int]] = {j: [] for j in range(arm.links + 1)}
    for j, ant in enumerate(arm.ant, start=1):
        children[ant].append(j)
    order: list[int] = []
    stack = children[0][::-1]
    while stack:
        j = stack.pop()
        order.append(j)
        stack += children[j][::-1]
    return order
