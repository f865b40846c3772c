"""Logs of robots with a floating base, from Pinocchio's free flyer.

Base and joints follow smooth functions of time. Forces of the world on the feet make the equations
of the base hold, and joint torques those of the joints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from oracles.free_flyer import FreeFlyer
from oracles.random_arms import random_parameters
from oracles.shaken import turned, waves
from oracles.transforms import Arm, world_transforms

GRAVITY = np.array([0.0, 0.0, -9.81])
#: Half the distances of the hips, and length of the legs, m.
LONG, WIDE, LEG = 0.3, 0.2, 0.5
_STEP, _NEAR = 0.004, 1e-3  # s: of a log, and of differences of functions of time
#: Weights of central differences over four steps, of the first and the second derivative.
_FIRST = np.array([1, -8, 0, 8, -1]) / 12
_SECOND = np.array([-1, 16, -30, 16, -1]) / 12
VISCOUS = 0.3


def table(legs: int, joints: int) -> Arm:
    """A body with legs of two revolute joints and, with three joints, a prismatic one."""
    hips = [(x * LONG, y * WIDE) for x in (1, -1) for y in (1, -1)][:legs]
    half = np.pi / 2
    columns = {key: [] for key in ("sigma", "ant", "gamma", "alpha", "d", "r")}
    for k, (x, y) in enumerate(hips):
        for j in range(joints):
            row = (0, k * joints + j, 0.0, half, 0.0, 0.0)
            if j == 0:
                row = (0, 0, half, half, y, x)
            if j == 2:
                row = (1, *row[1:])
            for key, value in zip(columns, row, strict=True):
                columns[key].append(value)
    none = (0.0,) * (legs * joints)
    return Arm(
        **{k: tuple(v) for k, v in columns.items()}, b=none, theta=none, gravity=tuple(GRAVITY)
    )


def text_of(arm: Arm, more: str = "", base: str = "floating") -> str:
    """The robot file, with `more` tables."""
    out = [f'[robot]\nname = "legged"\nbase = "{base}"\n']
    for j in range(arm.links):
        keys = ("sigma", "gamma", "alpha", "d", "r")
        row = {key: getattr(arm, key)[j] for key in keys}
        lines = [f"{key} = {value}" for key, value in row.items() if value]
        joint = [f"antecedent = {arm.ant[j]}", *lines, 'friction = ["viscous"]']
        out.append("[[joint]]\n" + "\n".join([*joint, "rotor_inertia = false\n"]))
    return "\n".join([*out, more])


@dataclass(frozen=True)
class Foot:
    """A foot: its link, its place and axes in the frame of this link, and the radius of a ball."""

    link: int
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axes: np.ndarray = field(default_factory=partial(np.eye, 3))
    radius: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Motion of base and joints at times t: place, quaternion, their rates, and q to qdd."""

    t: np.ndarray
    place: np.ndarray
    angles: np.ndarray
    q: np.ndarray  # (3, N, n)

    @property
    def rotation(self) -> np.ndarray:
        Q, *_ = turned(self.angles)
        w, v = Q[:, :1], Q[:, 1:]
        cross = np.zeros((len(w), 3, 3))
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            cross[:, i, j], cross[:, j, i] = -v[:, k], v[:, k]
        return np.eye(3) + 2 * w[:, :, None] * cross + 2 * cross @ cross

    @property
    def base(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """f, w and wd of the base."""
        _, w, wd = turned(self.angles)
        f = np.einsum("tji,tj->ti", self.rotation, self.place[2] - GRAVITY)
        return f, w, wd


def base_waves(t: np.ndarray, seed: int, size: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Place and angles of a base that moves by decimetres, with two derivatives."""
    draw = np.random.default_rng(seed)
    place = size * waves(t, np.array([0.12, 0.1, 0.08]), 1.5, draw)
    return place, size * waves(t, np.array([0.25, 0.2, 0.3]), 1.5, draw)


class Legged:
    """A robot with legs in Pinocchio.

    Args:
        arm: the table.
        seed: of masses and inertias.
        feet: its feet.
        loads: ten numbers of a load on a link, by its number.
    """

    def __init__(
        self, arm: Arm, seed: int, feet: list[Foot], loads: dict[int, np.ndarray] | None = None
    ) -> None:
        links, _ = random_parameters(arm, seed)
        links = np.vstack([3 * links[0], links])
        for link, load in (loads or {}).items():
            links[link] += load
        self.arm, self.links, self.feet = arm, links, feet
        self.flyer = FreeFlyer(arm, links, np.zeros(arm.n))
        self.flyer.weight = np.zeros(3)  # f is the acceleration minus gravity
        self.flyer.model.gravity.linear = np.zeros(3)

    @property
    def standard(self) -> dict[str, float]:
        """Values of the standard parameters."""
        names = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
        out = {}
        for k, link in enumerate(self.links):
            out |= {f"{name}{k}": float(x) for name, x in zip(names, link, strict=True)}
        return out | {f"FV{j}": VISCOUS for j in range(1, self.arm.links + 1)}

    def torques(self, motion: Motion) -> np.ndarray:
        """Wrench on the base, and torques, (N, n + 6)."""
        state = zip(*motion.q, *motion.base, strict=True)
        out = np.array([self.flyer.dynamics(*row) for row in state])
        out[:, 6:] += VISCOUS * motion.q[1]
        return out

    def jacobian(self, q: np.ndarray, foot: Foot, up: np.ndarray | None = None) -> np.ndarray:
        """Velocity of a foot, then its angular velocity, in the axes of the foot, (6, n + 6).

        The point of a ball is the lowest one, with `up` in the axes of the base.
        """
        flyer, pin = self.flyer, self.flyer._pin
        joint, inside = flyer.carriers[foot.link]
        J = pin.computeJointJacobian(flyer.model, flyer.data, flyer.place(q), joint)
        axes = (inside.rotation @ foot.axes).T
        point = inside.act(np.array(foot.at))
        if up is not None and foot.radius:
            pin.forwardKinematics(flyer.model, flyer.data, flyer.place(q))
            in_joint = flyer.data.oMi[joint].rotation.T @ flyer.rotation @ up
            point = point - foot.radius * in_joint
        linear = J[:3] - np.cross(point, J[3:], axisb=0, axisc=0)
        return np.vstack([axes @ linear, axes @ J[3:]])[:, flyer.order]

    def supported(
        self, motion: Motion, touches: np.ndarray, rows: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Joint torques (N, n), and forces on the feet (N, feet, rows) that hold the base.

        Args:
            motion: the motion.
            touches: (N, feet) whether a foot has a force.
            rows: 3 for a force, 6 for a force and a moment.
        """
        every, up = self.torques(motion), motion.rotation[:, 2]
        forces = np.zeros((*touches.shape, rows))
        for k, (q, down) in enumerate(zip(motion.q[0], touches, strict=True)):
            at = np.flatnonzero(down)
            J = [self.jacobian(q, self.feet[i], up[k])[:rows] for i in at]
            if J:
                across = np.vstack(J).T
                found = np.linalg.lstsq(across[:6], every[k, :6], rcond=None)[0]
                every[k] -= across @ found
                forces[k, at] = found.reshape(len(at), rows)
        return every, forces


def times(seconds: float) -> np.ndarray:
    return np.arange(round(seconds / _STEP)) * _STEP


def with_derivatives(of: Callable[[np.ndarray], np.ndarray], t: np.ndarray) -> np.ndarray:
    """A function of time with two derivatives, (3, N, ...)."""
    near = np.array([of(t + k * _NEAR) for k in range(-2, 3)])
    rate = np.tensordot(_FIRST, near, 1) / _NEAR
    return np.array([near[2], rate, np.tensordot(_SECOND, near, 1) / _NEAR**2])


def reaching(leg: np.ndarray) -> list[np.ndarray]:
    """Positions of the first three joints of a leg; its end from the hip, in base axes, (N, 3)."""
    length = np.linalg.norm(leg, axis=1)
    x, y, z = leg.T / length
    return [np.arctan2(z, y), np.arccos(-x), length]


#: Hips of four legs with a prismatic joint, whose feet are the origins of their last links.
HIPS = np.array([(x * LONG, y * WIDE, 0.0) for x in (1, -1) for y in (1, -1)])
#: Times at which a foot lifts and comes down, as parts of a period of s.
_LIFTS, _LANDS, PERIOD = 0.03, 0.22, 4.0


def crawl(seed: int, seconds: float, *, lifts: bool = True) -> tuple[Motion, np.ndarray]:
    """A robot with four legs, whose feet lift in turn, and which feet touch the ground, (N, 4)."""

    def swung(t: np.ndarray) -> np.ndarray:
        """Part of the swing of each foot, 0 or 1 on the ground."""
        phase = (t[:, None] / PERIOD - np.arange(4) / 4) % 1.0
        return lifts * np.clip((phase - _LIFTS) / (_LANDS - _LIFTS), 0, 1)

    def positions(t: np.ndarray) -> np.ndarray:
        """Positions of the joints whose feet are where they should be."""
        place, angles = base_waves(t, seed, 0.6)
        rotation, parts = Motion(t, place, angles, place).rotation, swung(t)
        out = []
        for k, hip in enumerate(HIPS):
            height = (4 * parts[:, k] * (1 - parts[:, k])) ** 3
            step = np.outer(height, [0.12 * (-1) ** k, 0.08, 0.15])
            foot = hip - [0, 0, LEG] + step - place[0]
            leg = np.einsum("tji,tj->ti", rotation, foot) - hip
            out += reaching(leg)
        return np.array(out).T

    t = times(seconds)
    parts = swung(t)
    motion = Motion(t, *base_waves(t, seed, 0.6), with_derivatives(positions, t))
    return motion, (parts <= 0) | (parts >= 1)


#: Axes of a foot on the ground, for which the last joints of a leg of six are at 0, pi/2 and 0.
FLAT = world_transforms(table(1, 6), [-np.pi / 2, np.pi / 2, LEG, 0, np.pi / 2, 0])[5, :3, :3]


def stride(seed: int, seconds: float, lifts: tuple[bool, bool]) -> tuple[Motion, np.ndarray]:
    """A robot with two legs of six joints, whose feet lift and turn, and which are flat, (N, 2).

    The last three axes of a leg meet in the origin of its foot.

    Args:
        seed: of the motion.
        seconds: its time.
        lifts: which feet ever lift.
    """
    arm, up, down = table(2, 6), 0.03, 0.45

    def swung(t: np.ndarray) -> np.ndarray:
        """Part of the swing of each foot, 0 or 1 on the ground."""
        phase = (t[:, None] / PERIOD - np.arange(2) / 2) % 1.0
        return np.array(lifts) * np.clip((phase - up) / (down - up), 0, 1)

    def positions(t: np.ndarray) -> np.ndarray:
        """Positions of the joints whose feet are where and as they should be."""
        place, angles = base_waves(t, seed, 0.6)
        to_base = Motion(t, place, angles, place).rotation.swapaxes(1, 2)
        parts, draw = swung(t), np.random.default_rng(seed + 50)
        q, still = np.zeros((len(t), 12)), np.zeros((3, len(t), 3))
        for k, hip in enumerate(HIPS[:2]):
            first = 6 * k
            height = (4 * parts[:, k] * (1 - parts[:, k])) ** 3
            moved = waves(t, np.repeat([0.15, 0.8], 3), 1.5, draw)[0] * height[:, None]
            foot = hip - [0, 0, LEG] + moved[:, :3] - place[0]
            leg = np.einsum("tij,tj->ti", to_base, foot) - hip
            q[:, first : first + 3] = np.transpose(reaching(leg))
            shin = world_transforms(arm, q)[:, first + 2, :3, :3]
            turns = Motion(t, still, still + moved[:, 3:], still).rotation
            R = shin.swapaxes(1, 2) @ to_base @ turns @ FLAT
            q[:, first + 3] = np.arctan2(R[:, 2, 2], R[:, 0, 2])
            q[:, first + 4] = np.arccos(R[:, 1, 2])
            q[:, first + 5] = np.arctan2(R[:, 1, 1], -R[:, 1, 0])
        return q

    t = times(seconds)
    parts = swung(t)
    motion = Motion(t, *base_waves(t, seed, 0.6), with_derivatives(positions, t))
    return motion, (parts <= 0) | (parts >= 1)
