"""The machines that are simulated: table, bodies, rotors, friction, instruments, working range."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from oracles.random_arms import to_toml
from oracles.transforms import LINK_PARAMETERS, Arm

HALF = np.pi / 2
# (t, q, qd, q at the last reversal) -> torque on the joints; (..., n) from (..., n).
Torque = Callable[[Any, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Coupling:
    """A drive that moves joints j and k (0-based): F = IAM u' + FVM u + FSM sign u."""

    j: int
    k: int
    ratio: float
    IAM: float
    FVM: float
    FSM: float

    def direction(self, n: int) -> np.ndarray:
        """du/dqd, (n,)."""
        out = np.zeros(n)
        out[self.j], out[self.k] = 1.0, self.ratio
        return out


@dataclass(frozen=True, eq=False)
class Machine:
    """What a simulator is given. Arrays are (n,), units m, kg, s, rad (m where prismatic).

    Attributes:
        arm: the table; links: (n, 10) standard parameters XX .. M about the frames' origins.
        rotor, coulomb, viscous: IA, FS, FV; width: speed at which Coulomb friction is tanh(1).
        home, reach, speed: centre and half range of the motion, RMS of its speed.
        resolution, tacho: step of the encoders, noise of the tachometers.
        rate, seconds: of the logs, Hz and s.
        load: share of the transmitted torque that is lost in friction.
        drift: (a, T), friction times 1 + a exp(-t/T).
        couplings: drives that move two joints.
        elastic: (joint, K, D) of one joint whose encoder is on the motor's side, or None.
        play: width of the gap that this joint has before its spring is met on either side.
        extra: further torques on the joints.
    """

    name: str
    arm: Arm
    links: np.ndarray
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    width: np.ndarray
    home: np.ndarray
    reach: np.ndarray
    speed: np.ndarray
    resolution: np.ndarray
    tacho: np.ndarray
    rate: int
    seconds: float
    load: np.ndarray
    drift: tuple[float, float] = (0.0, 1.0)
    couplings: tuple[Coupling, ...] = ()
    elastic: tuple[int, float, float] | None = None
    play: float = 0.0
    extra: tuple[Torque, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints, all of which move."""
        return self.arm.n

    def sign(self, qd: np.ndarray) -> np.ndarray:
        """Direction of motion, smooth across zero."""
        return np.tanh(qd / self.width)

    def friction(self, t: Any, qd: np.ndarray) -> np.ndarray:
        """Torque of Coulomb and viscous friction and of coupled drives on the joints."""
        out = -(self.coulomb * np.tanh(qd / self.width) + self.viscous * qd)
        a, T = self.drift
        if a:
            out = out * (1.0 + a * np.exp(-np.asarray(t)[..., None] / T))
        for c in self.couplings:
            u = qd[..., c.j] + c.ratio * qd[..., c.k]
            force = c.FVM * u + c.FSM * np.tanh(u / self.width[c.j])
            out = out - force[..., None] * c.direction(self.n)
        return out

    def with_entry(self, field: str, joint: int, value: float) -> Machine:
        """The same machine with one entry of an array changed."""
        array = getattr(self, field).copy()
        array[joint] = value
        return replace(self, **{field: array})

    def robot_toml(self, undeclared: Iterable[tuple[int, str]] = ()) -> str:
        """What the user believes: all joints have Coulomb, viscous and IA but what is undeclared.

        Args:
            undeclared: pairs of a 0-based joint and "coulomb", "viscous" or "rotor".
        """
        missing = set(undeclared)
        friction = [
            [f for f in ("coulomb", "viscous") if (j, f) not in missing] for j in range(self.n)
        ]
        rotor = [(j, "rotor") not in missing for j in range(self.n)]
        head, *joints = to_toml(self.arm, self.name, friction, rotor).split("[[joint]]\n")
        widths = (f"coulomb_width = {float(width)!r}\n" for width in self.width)
        blocks = (block.rstrip("\n") + "\n" + w for block, w in zip(joints, widths, strict=True))
        return head + "\n[[joint]]\n".join(["", *blocks]).removeprefix("\n")

    def parameters(self) -> dict[str, float]:
        """Standard parameters by name, XX1 .. FVn."""
        out: dict[str, float] = {}
        for j in range(self.n):
            values = zip(LINK_PARAMETERS, self.links[j], strict=True)
            out |= {f"{name}{j + 1}": float(value) for name, value in values}
            for name, field in (("IA", "rotor"), ("FS", "coulomb"), ("FV", "viscous")):
                out[f"{name}{j + 1}"] = float(getattr(self, field)[j])
        return out


def body(mass: float, centre: tuple[float, ...], gyration: tuple[float, ...]) -> np.ndarray:
    """Standard parameters (10,) of a body from its radii of gyration about its centre [m]."""
    c = np.array(centre)
    inertia = mass * (np.diag(np.square(gyration)) + c @ c * np.eye(3) - np.outer(c, c))
    return np.array([*inertia[np.triu_indices(3)], *(mass * c), mass])


def _machine(name: str, table: dict, bodies: list[np.ndarray], **columns: Any) -> Machine:
    arm = Arm.from_table(table)
    rate, seconds = columns.pop("rate"), columns.pop("seconds")
    revolute = np.array(arm.sigma) == 0
    arrays = {key: np.array(values, dtype=float) for key, values in columns.items()}
    return Machine(
        name=name,
        arm=arm,
        links=np.array(bodies),
        resolution=np.where(revolute, 2e-5, 2e-6),
        tacho=np.where(revolute, 2e-3, 2e-4),
        load=np.zeros(arm.n),
        rate=rate,
        seconds=seconds,
        **arrays,
    )


MACHINES = {
    machine.name: machine
    for machine in (
        _machine(
            "planar2r",
            {"sigma": (0, 0), "d": (0, 0.5), "gravity": (0, -9.81, 0)},
            [
                body(8, (0.24, 0.01, 0), (0.05, 0.16, 0.16)),
                body(5, (0.2, -0.01, 0), (0.04, 0.14, 0.14)),
            ],
            rotor=(0.5, 0.2),
            coulomb=(5, 2),
            viscous=(4, 1.6),
            width=(4e-3, 4e-3),
            home=(-0.6, 0.4),
            reach=(1.3, 1.6),
            speed=(1.0, 1.3),
            rate=1000,
            seconds=12.0,
        ),
        _machine(
            "arm3r",
            {"sigma": (0, 0, 0), "alpha": (0, HALF, 0), "d": (0, 0, 0.4)},
            [
                body(6, (0.01, 0.02, -0.1), (0.1, 0.1, 0.08)),
                body(6, (0.19, 0.01, 0.03), (0.05, 0.13, 0.13)),
                body(3.5, (0.17, -0.02, 0.02), (0.04, 0.12, 0.12)),
            ],
            rotor=(0.5, 0.6, 0.15),
            coulomb=(4, 5, 1.8),
            viscous=(3, 4, 1.4),
            width=(4e-3,) * 3,
            home=(0.2, 0.5, -0.8),
            reach=(1.6, 1.1, 1.4),
            speed=(1.1, 0.9, 1.2),
            rate=500,
            seconds=16.0,
        ),
        _machine(
            "scara",
            {"sigma": (0, 0, 1, 0), "d": (0, 0.35, 0.3, 0)},
            [
                body(9, (0.16, 0.01, 0.05), (0.06, 0.13, 0.13)),
                body(6, (0.13, -0.01, 0.03), (0.05, 0.11, 0.11)),
                body(2, (0, 0.005, 0.1), (0.1, 0.1, 0.02)),
                body(1.6, (0.06, 0.03, 0.04), (0.04, 0.05, 0.05)),
            ],
            rotor=(0.6, 0.3, 6.0, 0.02),
            coulomb=(4, 2.5, 12, 0.2),
            viscous=(3, 2, 40, 0.12),
            width=(4e-3, 4e-3, 1.2e-3, 6e-3),
            home=(0.1, 0.7, -0.15, 0.3),
            reach=(1.5, 1.5, 0.13, 2.0),
            speed=(1.3, 1.5, 0.16, 2.0),
            rate=1000,
            seconds=10.0,
        ),
        _machine(
            "arm6r",
            {
                "sigma": (0,) * 6,
                "alpha": (0, -HALF, 0, HALF, -HALF, HALF),
                "d": (0, 0, 0.43, -0.02, 0, 0),
                "r": (0, 0.15, 0, 0.43, 0, 0),
            },
            [
                body(12, (0, 0.03, -0.1), (0.12, 0.12, 0.1)),
                body(15, (0.12, 0.006, 0.05), (0.08, 0.17, 0.17)),
                body(6, (0.01, -0.09, 0.014), (0.11, 0.06, 0.11)),
                body(1.8, (0, 0.005, -0.05), (0.06, 0.06, 0.04)),
                body(1.2, (0, -0.02, 0.004), (0.04, 0.04, 0.04)),
                body(1.4, (0.02, 0.01, 0.11), (0.06, 0.06, 0.04)),
            ],
            rotor=(1.1, 2.4, 0.8, 0.12, 0.1, 0.08),
            coulomb=(7, 9, 5, 0.7, 0.6, 0.4),
            viscous=(5, 7, 3.5, 0.6, 0.5, 0.3),
            width=(4e-3, 4e-3, 4e-3, 5e-3, 5e-3, 5e-3),
            home=(0.2, -0.8, 0.4, 0.3, 0.5, 0.1),
            reach=(1.6, 1.0, 1.2, 1.8, 1.4, 2.2),
            speed=(1.0, 0.8, 1.0, 1.6, 1.4, 2.0),
            rate=500,
            seconds=10.0,
        ),
        _machine(
            "polar3",
            {"sigma": (0, 0, 1), "alpha": (0, HALF, -HALF), "r": (0, 0.12, 0)},
            [
                body(11, (0.01, 0.02, -0.15), (0.14, 0.14, 0.1)),
                body(7, (0.02, 0.01, 0.05), (0.09, 0.09, 0.07)),
                body(3, (0.01, -0.005, -0.2), (0.15, 0.15, 0.03)),
            ],
            rotor=(0.7, 0.5, 5.0),
            coulomb=(5, 4, 10),
            viscous=(4, 3, 30),
            width=(4e-3, 4e-3, 1.2e-3),
            home=(0.3, 0.9, 0.45),
            reach=(1.6, 0.6, 0.2),
            speed=(1.1, 0.7, 0.25),
            rate=1000,
            seconds=12.0,
        ),
        _machine(
            "arm5r",
            {
                "sigma": (0,) * 5,
                "alpha": (0, HALF, 0, 0, HALF),
                "d": (0, 0.03, 0.3, 0.26, 0),
                "r": (0, 0, 0, 0, 0.1),
            },
            [
                body(5, (0.02, 0.01, -0.08), (0.09, 0.09, 0.07)),
                body(4, (0.14, 0.01, 0.02), (0.04, 0.11, 0.11)),
                body(2.8, (0.12, -0.01, -0.02), (0.03, 0.09, 0.09)),
                body(1.3, (0.01, -0.03, 0.02), (0.05, 0.04, 0.05)),
                body(0.9, (0.015, 0.01, 0.05), (0.04, 0.04, 0.03)),
            ],
            rotor=(0.35, 0.45, 0.25, 0.06, 0.03),
            coulomb=(3, 3.5, 2.2, 0.8, 0.4),
            viscous=(2, 2.4, 1.5, 0.5, 0.25),
            width=(4e-3, 4e-3, 4e-3, 5e-3, 5e-3),
            home=(0.0, 0.8, -0.9, -0.5, 0.2),
            reach=(1.7, 0.8, 1.1, 1.2, 2.0),
            speed=(1.1, 0.8, 1.0, 1.3, 1.8),
            rate=500,
            seconds=14.0,
        ),
    )
}
