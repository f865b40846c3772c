"""A UR-like arm with a force/torque sensor at its wrist: logs by Newton's law for points of mass.

Transforms and their time derivatives are products of 4x4 matrices. The tool is some points of mass,
so its wrench needs neither an inertia nor an angular velocity. symgen's code has no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

G = 9.81
#: alpha, d, r of the joints of a UR5e, modified Denavit-Hartenberg.
TABLE = [
    (0.0, 0.0, 0.1625),
    (np.pi / 2, 0.0, 0.0),
    (0.0, -0.425, 0.0),
    (0.0, -0.3922, 0.1333),
    (np.pi / 2, 0.0, 0.0997),
    (-np.pi / 2, 0.0, 0.0996),
]
XYZ, RPY = (0.0, 0.01, 0.03), (0.1, -0.2, 0.7)
ROBOT = (
    '[robot]\nname = "ur"\ngravity = [0.0, 0.0, -9.81]\n'
    + "".join(f"[[joint]]\nalpha = {a!r}\nd = {d!r}\nr = {r!r}\n" for a, d, r in TABLE)
    + f'[[frame]]\nname = "wrist"\njoint = 6\nxyz = {list(XYZ)}\nrpy = {list(RPY)}\n'
    + '[sensor]\nframe = "wrist"\n'
)
NOISE = np.repeat([0.5, 0.02], 3)  # N, N m
ENCODER = 1e-5  # rad
#: Derivative of a turn about z, from the right.
_Z = np.zeros((4, 4))
_Z[0, 1], _Z[1, 0] = -1.0, 1.0


@dataclass(frozen=True)
class Points:
    """A tool: masses (k,) in kg at points (k, 3) in the frame of the sensor."""

    masses: np.ndarray
    at: np.ndarray

    @property
    def quantities(self) -> np.ndarray:
        """Mass, centre of mass, and XX XY XZ YY YZ ZZ about it."""
        mass = self.masses.sum()
        com = self.masses @ self.at / mass
        x = self.at - com
        inertia = np.zeros((3, 3))
        for m, r in zip(self.masses, x, strict=True):
            inertia += m * (r @ r * np.eye(3) - np.outer(r, r))
        return np.array([mass, *com, *inertia[np.triu_indices(3)]])

    @property
    def standard(self) -> np.ndarray:
        """XX XY XZ YY YZ ZZ MX MY MZ M about the origin."""
        about = self.quantities
        c, J = about[1:4], np.zeros((3, 3))
        J[np.triu_indices(3)] = about[4:]
        J += about[0] * (c @ c * np.eye(3) - np.outer(c, c))
        return np.array([*J[np.triu_indices(3)], *(about[0] * c), about[0]])


def tool(mass: float, seed: int = 0, size: float = 0.06) -> Points:
    """Eight random points around a centre of mass about 10 cm from the sensor."""
    rng = np.random.default_rng(seed)
    masses = rng.uniform(0.5, 1.5, 8)
    at = np.array([0.02, -0.03, 0.1]) + size * rng.uniform(-1, 1, (8, 3))
    return Points(mass * masses / masses.sum(), at)


def turned(rpy: tuple[float, float, float]) -> np.ndarray:
    """Rot(z, yaw) Rot(y, pitch) Rot(x, roll)."""
    (a, b, c), (s, u, v) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1, 0, 0], [0, a, -s], [0, s, a]])
    y = np.array([[b, 0, u], [0, 1, 0], [-u, 0, b]])
    z = np.array([[c, -v, 0], [v, c, 0], [0, 0, 1]])
    return z @ y @ x


def poses_of_joints(q, qd, qdd) -> list[list[np.ndarray]]:
    """The transform of each joint's frame in the base, and two derivatives, (N, 4, 4) each."""
    out = []
    T = np.tile(np.eye(4), (len(q), 1, 1))
    dT, ddT = np.zeros_like(T), np.zeros_like(T)
    for j, (alpha, d, r) in enumerate(TABLE):
        c, s = np.cos(q[:, j]), np.sin(q[:, j])
        ca, sa = np.cos(alpha), np.sin(alpha)
        A = np.zeros_like(T)
        A[:, 0] = np.stack([c, -s, 0 * c, 0 * c + d], 1)
        A[:, 1] = np.stack([s * ca, c * ca, 0 * c - sa, 0 * c - r * sa], 1)
        A[:, 2] = np.stack([s * sa, c * sa, 0 * c + ca, 0 * c + r * ca], 1)
        A[:, 3, 3] = 1.0
        v, a = (x[:, j, None, None] for x in (qd, qdd))
        AZ = A @ _Z
        ddT = ddT @ A + 2 * dT @ AZ * v + T @ (AZ @ _Z * v**2 + AZ * a)
        dT = dT @ A + T @ AZ * v
        T = T @ A
        out.append([T, dT, ddT])
    return out


def poses_of_sensor(q, qd, qdd) -> list[np.ndarray]:
    """The transform of the sensor's frame in the base, and its two derivatives."""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turned(RPY), XYZ
    return [x @ frame for x in poses_of_joints(q, qd, qdd)[-1]]


def wrench(points: Points, q, qd, qdd, gravity=(0.0, 0.0, -G)) -> np.ndarray:
    """What the arm exerts on the tool, (N, 6): force, and moment about the sensor's origin."""
    T, _, ddT = poses_of_sensor(q, qd, qdd)
    R, out = T[:, :3, :3], np.zeros((len(q), 6))
    for m, r in zip(points.masses, points.at, strict=True):
        force = m * (ddT @ [*r, 1.0])[:, :3] - m * np.array(gravity)
        local = np.einsum("nji,nj->ni", R, force)
        out += np.hstack([local, np.cross(r, local)])
    return out


def torques(points: Points, q, qd, qdd) -> np.ndarray:
    """Torques of an arm without masses that carries the tool, (N, 6)."""
    T = poses_of_sensor(q, qd, qdd)[0]
    w = wrench(points, q, qd, qdd)
    force, moment = (np.einsum("nij,nj->ni", T[:, :3, :3], x) for x in np.hsplit(w, 2))
    out = []
    for joint, *_ in poses_of_joints(q, qd, qdd):
        arm = T[:, :3, 3] - joint[:, :3, 3]
        out.append(np.sum(joint[:, :3, 2] * (moment + np.cross(arm, force)), axis=1))
    return np.stack(out, axis=1)


def _moves(t, times, knots, length):
    """Rests at knots, with quintic moves of some length between them that start at given times."""
    q = np.tile(knots[0], (len(t), 1))
    qd, qdd = np.zeros_like(q), np.zeros_like(q)
    for start, a, b in zip(times, knots, knots[1:], strict=False):
        s = np.clip((t - start) / length, 0, 1)[:, None]
        q += (b - a) * (10 * s**3 - 15 * s**4 + 6 * s**5)
        qd += (b - a) * (30 * s**2 - 60 * s**3 + 30 * s**4) / length
        qdd += (b - a) * (60 * s - 180 * s**2 + 120 * s**3) / length**2
    return q, qd, qdd


def motion(seed: int, poses: int = 12, rest: float = 2.0, swing: float = 18.0, rate: float = 500.0):
    """Stamps, q, qd and qdd of a log: rests at poses, and then a motion of the wrist.

    A pose takes `rest` seconds and the move to it 1.5 s.
    """
    rng = np.random.default_rng(seed)
    start, size = np.array([0.0, -1.4, 1.6, -1.7, -1.5, 0.0]), np.array([1, 0.4, 0.5, 1.5, 1.3, 2])
    knots = start + size * rng.uniform(-1, 1, (poses, 6))
    length = 1.5
    period = rest + length
    total = poses * period + swing
    t = np.arange(round(total * rate)) / rate
    q, qd, qdd = _moves(t, rest + period * np.arange(poses - 1), knots, length)
    if swing:
        begin = poses * period - length
        s = np.clip(t - begin, 0, None)
        w = 2 * np.pi * rng.uniform(0.2, 0.8, 6)
        h = np.array([0.1, 0.1, 0.2, 0.5, 0.6, 0.8])
        e, de, dde = _ramp(s)
        for j in range(6):
            x, dx = np.sin(w[j] * s), w[j] * np.cos(w[j] * s)
            ddx = -(w[j] ** 2) * x
            q[:, j] += h[j] * e * x
            qd[:, j] += h[j] * (de * x + e * dx)
            qdd[:, j] += h[j] * (dde * x + 2 * de * dx + e * ddx)
    return t, q, qd, qdd


def _ramp(s):
    """A smooth step over one second, with its derivatives."""
    u = np.clip(s, 0, 1)
    return (
        10 * u**3 - 15 * u**4 + 6 * u**5,
        30 * u**2 - 60 * u**3 + 30 * u**4,
        60 * u - 180 * u**2 + 120 * u**3,
    )


def recorded(
    points: Points,
    seed: int,
    drift: np.ndarray | float = 0.0,
    sign: float = 1.0,
    offset: np.ndarray | None = None,
    move: tuple | None = None,
    **options: float,
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Arrays of a log: t, q, wrench with noise, offset and a drift over the log; and the offset."""
    t, q, qd, qdd = motion(seed, **options) if move is None else move
    rng = np.random.default_rng(1000 + seed)
    offset = rng.normal(size=6) * np.repeat([5.0, 0.3], 3) if offset is None else offset
    late = ((t - t[-1]) / (t[-1] - t[0]))[:, None]
    w = wrench(points, q, qd, qdd) + offset + late * drift
    w = sign * (w + NOISE * rng.normal(size=w.shape))
    return {"t": t, "q": q + ENCODER * rng.normal(size=q.shape), "wrench": w}, offset
