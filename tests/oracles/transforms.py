"""Energy of a robot from plain 4x4 homogeneous transforms and geometric Jacobians.

Independent of the package under test: nothing is recursed in link frames. Every frame is a product
of 4x4 matrices in frame 0, every velocity is a sum over the joints on the path to the base of
``z_j x (p - p_j) qd_j`` (revolute) or ``z_j qd_j`` (prismatic).

The same code runs on float64 arrays and on object arrays of mpmath numbers: a `Backend` says how a
number is made and how its sine and cosine are taken. All functions broadcast over leading axes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2
LINK_PARAMETERS = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
GEOMETRY = ("gamma", "b", "alpha", "d", "theta", "r")


@dataclass(frozen=True)
class Arm:
    """A modified Denavit-Hartenberg table; one tuple entry per joint, in file order.

    ``T(antecedent -> j) = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta)
    Trans(z, r)``, with q_j added to theta (sigma 0) or to r (sigma 1).

    Attributes:
        sigma: 0 revolute, 1 prismatic, 2 fixed.
        ant: number of the antecedent joint, 1-based; 0 is the base.
        gamma, b, alpha, d, theta, r: angles [rad] and lengths [m], floats or mpmath numbers.
        gravity: acceleration of gravity in frame 0 [m/s2].
    """

    sigma: tuple[int, ...]
    ant: tuple[int, ...]
    gamma: tuple[Any, ...]
    b: tuple[Any, ...]
    alpha: tuple[Any, ...]
    d: tuple[Any, ...]
    theta: tuple[Any, ...]
    r: tuple[Any, ...]
    gravity: tuple[Any, ...]

    def __post_init__(self) -> None:
        lengths = {key: len(getattr(self, key)) for key in ("sigma", "ant", *GEOMETRY)}
        if len(set(lengths.values())) != 1 or len(self.gravity) != 3:
            raise ValueError(f"an Arm needs equally long columns and 3 gravity entries: {lengths}")
        for j, (sigma, ant) in enumerate(zip(self.sigma, self.ant, strict=True), start=1):
            if sigma not in (REVOLUTE, PRISMATIC, FIXED) or not 0 <= ant < j:
                raise ValueError(f"joint {j}: sigma {sigma}, antecedent {ant}")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "Arm":
        """Build an arm from a mapping of columns; ant defaults to a chain, geometry to zeros."""
        sigma = tuple(int(s) for s in table["sigma"])
        zeros = (0.0,) * len(sigma)
        return cls(
            sigma=sigma,
            ant=tuple(int(a) for a in table.get("ant", range(len(sigma)))),
            gravity=tuple(table.get("gravity", (0.0, 0.0, -9.81))),
            **{key: tuple(table.get(key, zeros)) for key in GEOMETRY},
        )

    @property
    def links(self) -> int:
        """Number of links, fixed ones included."""
        return len(self.sigma)

    @property
    def movable(self) -> tuple[int, ...]:
        """File numbers (1-based) of the joints that have a variable, in file order."""
        return tuple(j for j, sigma in enumerate(self.sigma, start=1) if sigma != FIXED)

    @property
    def n(self) -> int:
        """Number of joint variables."""
        return len(self.movable)

    def path(self, j: int) -> tuple[int, ...]:
        """File numbers of the joints from joint j (included) down to the base."""
        numbers = []
        while j:
            numbers.append(j)
            j = self.ant[j - 1]
        return tuple(numbers)


@dataclass(frozen=True)
class Backend:
    """How numbers are made: `array` converts anything to an array, `cos` and `sin` act on it."""

    array: Callable[[Any], np.ndarray]
    cos: Callable[[np.ndarray], np.ndarray]
    sin: Callable[[np.ndarray], np.ndarray]


FLOAT = Backend(lambda values: np.asarray(values, dtype=np.float64), np.cos, np.sin)


def mpmath_backend(context: Any) -> Backend:
    """Arithmetic of an mpmath context on object arrays; every number is brought into it first."""
    convert = np.frompyfunc(context.mpf, 1, 1)
    cos = np.frompyfunc(context.cos, 1, 1)
    sin = np.frompyfunc(context.sin, 1, 1)

    def on_objects(function: Callable[[Any], Any]) -> Callable[[Any], np.ndarray]:
        # A universal function returns a bare scalar for a 0-d array: wrap it again.
        def apply(values: Any) -> np.ndarray:
            return np.asarray(function(np.asarray(values, dtype=object)), dtype=object)

        return apply

    return Backend(on_objects(convert), on_objects(cos), on_objects(sin))


def rotor_flags(arm: Arm, rotor: bool | Sequence[bool]) -> tuple[bool, ...]:
    """One flag per joint in file order; a fixed joint never has a rotor."""
    flags = (rotor,) * arm.links if isinstance(rotor, bool) else tuple(rotor)
    if len(flags) != arm.links:
        raise ValueError(f"{len(flags)} rotor flags for {arm.links} joints")
    return tuple(bool(f) and s != FIXED for f, s in zip(flags, arm.sigma, strict=True))


def column_names(arm: Arm, rotor: bool | Sequence[bool] = True) -> tuple[str, ...]:
    """Names of the columns of `energy_regressor`: link by link XX .. M, then IA where declared."""
    names: list[str] = []
    for j, has_rotor in enumerate(rotor_flags(arm, rotor), start=1):
        names += [f"{name}{j}" for name in LINK_PARAMETERS]
        names += [f"IA{j}"] if has_rotor else []
    return tuple(names)


def parameter_vector(
    arm: Arm,
    links: np.ndarray,
    rotor_inertia: np.ndarray,
    rotor: bool | Sequence[bool] = True,
) -> np.ndarray:
    """Order link parameters (links, 10) and rotor inertias (n,) as `column_names` does."""
    inertia = dict(zip(arm.movable, rotor_inertia, strict=True))
    values: list[Any] = []
    for j, has_rotor in enumerate(rotor_flags(arm, rotor), start=1):
        values += list(links[j - 1])
        values += [inertia[j]] if has_rotor else []
    return np.asarray(values)


def rotation(axis: str, angle: np.ndarray, backend: Backend = FLOAT) -> np.ndarray:
    """Homogeneous rotation about x or z by `angle` (...): (..., 4, 4)."""
    first, second = {"x": (1, 2), "z": (0, 1)}[axis]
    out = _identity(angle, backend)
    cosine, sine = backend.cos(angle), backend.sin(angle)
    out[..., first, first] = cosine
    out[..., second, second] = cosine
    out[..., second, first] = sine
    out[..., first, second] = -sine
    return out


def translation(axis: str, length: np.ndarray, backend: Backend = FLOAT) -> np.ndarray:
    """Homogeneous translation along x or z by `length` (...): (..., 4, 4)."""
    out = _identity(length, backend)
    out[..., {"x": 0, "z": 2}[axis], 3] = length
    return out


def world_transforms(arm: Arm, q: Any, backend: Backend = FLOAT) -> np.ndarray:
    """Frames of all links in frame 0.

    Args:
        arm: the table.
        q: joint variables (..., n) [rad or m].
        backend: float64 or mpmath arithmetic.

    Returns:
        (..., links, 4, 4).
    """
    q = backend.array(q)
    if q.shape[-1] != arm.n:
        raise ValueError(f"q has {q.shape[-1]} columns, the arm has {arm.n} variables")
    variable = {j: q[..., i] for i, j in enumerate(arm.movable)}
    still = backend.array(np.zeros(q.shape[:-1]))
    frames = [_identity(still, backend)]
    for j, (sigma, ant) in enumerate(zip(arm.sigma, arm.ant, strict=True), start=1):
        gamma, b, alpha, d, theta, r = (
            backend.array(getattr(arm, key)[j - 1]) + still for key in GEOMETRY
        )
        theta = theta + variable[j] if sigma == REVOLUTE else theta
        r = r + variable[j] if sigma == PRISMATIC else r
        frame = frames[ant]
        for factor in (
            rotation("z", gamma, backend),
            translation("z", b, backend),
            rotation("x", alpha, backend),
            translation("x", d, backend),
            rotation("z", theta, backend),
            translation("z", r, backend),
        ):
            frame = frame @ factor
        frames.append(frame)
    return np.stack(frames[1:], axis=-3)


def jacobians(arm: Arm, frames: np.ndarray) -> np.ndarray:
    """Geometric Jacobian of every link frame, in frame 0.

    Args:
        arm: the table.
        frames: (..., links, 4, 4) from `world_transforms`.

    Returns:
        (..., links, 6, n): rows 0-2 the velocity of the frame's origin, rows 3-5 the angular
        velocity, per unit joint velocity.
    """
    out = np.zeros((*frames.shape[:-2], 6, arm.n), dtype=frames.dtype)
    column = {j: i for i, j in enumerate(arm.movable)}
    for link in range(1, arm.links + 1):
        origin = frames[..., link - 1, :3, 3]
        for j in arm.path(link):
            axis = frames[..., j - 1, :3, 2]
            if arm.sigma[j - 1] == REVOLUTE:
                lever = origin - frames[..., j - 1, :3, 3]
                out[..., link - 1, :3, column[j]] = _cross(axis, lever)
                out[..., link - 1, 3:, column[j]] = axis
            elif arm.sigma[j - 1] == PRISMATIC:
                out[..., link - 1, :3, column[j]] = axis
    return out


def kinetic_regressor(
    arm: Arm, q: Any, qd: Any, rotor: bool | Sequence[bool] = True, backend: Backend = FLOAT
) -> np.ndarray:
    """Columns of the kinetic energy; see `energy_regressor`."""
    q, qd = np.broadcast_arrays(backend.array(q), backend.array(qd))
    frames = world_transforms(arm, q, backend)
    twists = (jacobians(arm, frames) @ qd[..., None, :, None])[..., 0]
    speed = {j: qd[..., i] for i, j in enumerate(arm.movable)}
    columns: list[np.ndarray] = []
    for link, has_rotor in enumerate(rotor_flags(arm, rotor), start=1):
        to_link = np.swapaxes(frames[..., link - 1, :3, :3], -1, -2)
        v = (to_link @ twists[..., link - 1, :3, None])[..., 0]
        w = (to_link @ twists[..., link - 1, 3:, None])[..., 0]
        x, y, z = w[..., 0], w[..., 1], w[..., 2]
        # T = (w.J w)/2 + MS.(v x w) + M (v.v)/2, all about the origin of the link's frame.
        first_moments = _cross(v, w)
        columns += [x * x / 2, x * y, x * z, y * y / 2, y * z, z * z / 2]
        columns += [first_moments[..., i] for i in range(3)]
        columns += [(v * v).sum(axis=-1) / 2]
        columns += [speed[link] * speed[link] / 2] if has_rotor else []
    return np.stack(columns, axis=-1)


def potential_regressor(
    arm: Arm, q: Any, rotor: bool | Sequence[bool] = True, backend: Backend = FLOAT
) -> np.ndarray:
    """Columns of the potential energy; see `energy_regressor`."""
    frames = world_transforms(arm, q, backend)
    gravity = backend.array(arm.gravity)
    zero = frames[..., 0, 0, 0] * 0
    columns: list[np.ndarray] = []
    for link, has_rotor in enumerate(rotor_flags(arm, rotor), start=1):
        # U = -g.(M P + A MS).
        columns += [zero] * 6
        columns += [-(gravity * frames[..., link - 1, :3, i]).sum(axis=-1) for i in range(4)]
        columns += [zero] if has_rotor else []
    return np.stack(columns, axis=-1)


def energy_regressor(
    arm: Arm, q: Any, qd: Any, rotor: bool | Sequence[bool] = True, backend: Backend = FLOAT
) -> np.ndarray:
    """Row h(q, qd) of the total energy T + U in the standard parameters.

    Args:
        arm: the table.
        q: joint variables (..., n) [rad or m].
        qd: joint velocities (..., n) [rad/s or m/s].
        rotor: which joints have a rotor inertia IA; one flag for all or one per joint of the file.
        backend: float64 or mpmath arithmetic.

    Returns:
        (..., columns) in the order of `column_names`.
    """
    kinetic = kinetic_regressor(arm, q, qd, rotor, backend)
    return kinetic + potential_regressor(arm, q, rotor, backend)


def _identity(like: np.ndarray, backend: Backend) -> np.ndarray:
    out = np.zeros((*np.shape(like), 4, 4))
    out[..., range(4), range(4)] = 1.0
    return backend.array(out)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    (ax, ay, az), (bx, by, bz) = (np.moveaxis(v, -1, 0) for v in (a, b))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
