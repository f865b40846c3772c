"""How large an effect is: the torque that the believed model misses, and what of it can be seen."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

import numpy as np
from oracles.hidden.engines import PinocchioEngine
from oracles.hidden.machines import MACHINES, Machine
from oracles.hidden.motion import Motion, generator, reference
from oracles.hidden.simulate import inverse
from scipy.signal import butter, sosfiltfilt
from studies.hidden.catalogue import EFFECTS, GLOBAL, joints_of
from studies.hidden.effects import Channels, Hidden, Scene

CUTOFF = 10.0  # Hz, of the band in which gaps and floors are compared
SMALL = 0.015  # RMS of the small effects over that of their joint's torque
MODERATE = 0.06  # and of the moderate ones, at least
SOFTEST = 0.03  # the moderate elasticity: softer joints are no longer first order in 1/K
VISIBLE = 0.015  # RMS of what no declared parameter can take up, at least, where moderate
LARGEST = 0.25  # but never more than this share of the torque


def rms(values: np.ndarray) -> np.ndarray:
    """Root mean square over samples, per joint."""
    return np.sqrt(np.mean(np.square(values), axis=0))


def lowpass(values: np.ndarray, step: float, cutoff: float = CUTOFF) -> np.ndarray:
    """Zero-phase Butterworth filter of an (N, n) array."""
    return sosfiltfilt(butter(2, cutoff * 2 * step, output="sos"), values, axis=0)


@cache
def aim(robot: str, seed: int) -> tuple[Motion, np.ndarray]:
    """The training reference on a coarse grid, and the believed torque along it."""
    motion = reference(MACHINES[robot], "train", seed, step=4e-3)
    return motion, inverse(MACHINES[robot], motion)


def scene(robot: str, *words: object, seed: int) -> Scene:
    """A scene whose random numbers depend on the robot, the words and the seed."""
    return Scene(MACHINES[robot], *aim(robot, seed), generator(robot, *words, seed))


def missed(hidden: Hidden, where: Scene) -> np.ndarray:
    """Estimate (N, n) of the torque (or speed) that the believed model misses on the reference."""
    motion = where.motion

    def torque(machine: Machine) -> np.ndarray:
        return where.torque if machine is where.machine else inverse(machine, motion)

    tau = torque(hidden.machine(where.machine))
    log = hidden.log(Channels(motion.t, motion.q, motion.qd, tau))
    if hidden.channel == "qd":
        return log.qd - motion.qd
    return log.tau - torque(hidden.believed(where.machine))


def unseen(
    machine: Machine, motion: Motion, undeclared: Iterable[tuple[int, str]], weight: np.ndarray
) -> tuple[np.ndarray, slice]:
    """Orthonormal basis of what the declared parameters can explain on a motion.

    Rows are every so many samples (the slice) of all joints, each joint over its weight.
    """
    missing, n = set(undeclared), machine.n
    pick = slice(0, None, max(1, len(motion.t) // 400))
    q, qd, qdd = motion.q[pick], motion.qd[pick], motion.qdd[pick]
    columns = [PinocchioEngine(machine).regressor(q, qd, qdd)]
    terms = {"rotor": qdd, "coulomb": np.tanh(qd / machine.width), "viscous": qd}
    for term, values in terms.items():
        for j in range(n):
            if (j, term) not in missing:
                columns.append((values[:, j, None] * np.eye(n)[j])[..., None])
    Y = np.concatenate(columns, axis=2) / weight[:, None]
    Y = Y.reshape(-1, Y.shape[2])
    norm = np.linalg.norm(Y, axis=0)
    left, values, _ = np.linalg.svd(Y[:, norm > 0] / norm[norm > 0], full_matrices=False)
    return left[:, values > 1e-9 * values[0]], pick


def visible(
    gap: np.ndarray,
    machine: Machine,
    motion: Motion,
    undeclared: Iterable[tuple[int, str]],
    weight: np.ndarray,
) -> np.ndarray:
    """RMS (n,) over the weight of what is left of a gap when the declared parameters are fitted."""
    basis, pick = unseen(machine, motion, undeclared, weight)
    flat = (gap[pick] / weight).ravel()
    return rms((flat - basis @ (basis.T @ flat)).reshape(-1, machine.n))


def share(hidden: Hidden, where: Scene) -> np.ndarray:
    """RMS (n,) of the missed channel over that of the channel itself, on the reference."""
    channel = where.motion.qd if hidden.channel == "qd" else where.torque
    return rms(missed(hidden, where)) / rms(channel)


def sized(name: str, robot: str, seed: int, joint: int, target: float) -> Hidden:
    """Build an effect whose share, on the joint where it is largest, is the target."""
    size, power, last = 0.1, 1.0, None
    for _ in range(30):
        where = scene(robot, name, joint, seed=seed)
        hidden = EFFECTS[name](where, joint, size)
        shares = share(hidden, where)
        named = [k - 1 for k in hidden.joints]
        everywhere = name in GLOBAL or name == "geometry_error"
        here = max(float(shares.max() if everywhere else shares[named].max()), 1e-12)
        if abs(here / target - 1) < 0.01:
            break
        # Shares grow about as a power of the size: a secant in logarithms, kept from wild steps.
        if last:
            slope = np.log(here / last[1]) / np.log(size / last[0])
            power = float(np.clip(slope, 0.5, 5.0)) if np.isfinite(slope) else 1.0
        last = size, here
        size *= float(np.clip((target / here) ** (1 / power), 1e-2, 1e2))
    return hidden


def place(name: str, robot: str, size: str, seed: int, taken: Iterable[int] = ()) -> Hidden:
    """Choose a joint by the seed, and the size: small or moderate.

    A joint on which the declared parameters could take up nearly all of the effect is passed over
    as long as there is another one.
    """
    machine = MACHINES[robot]
    joints = joints_of(name, machine)
    joints = [j for j in joints if j not in set(taken)] or joints
    order = generator(robot, name, "joint", seed).permutation(joints)
    best: tuple[float, Hidden, int] | None = None
    for joint in map(int, order):
        hidden = sized(name, robot, seed, joint, SMALL)
        left = _left(hidden, robot, seed)
        if best is None or left > best[0]:
            best = (left, hidden, joint)
        if left > 0.3 * SMALL:
            break
    left, hidden, joint = best
    if size == "small" or not left:
        return hidden
    least = SOFTEST if name == "joint_elasticity" else MODERATE
    target = float(np.clip(SMALL * VISIBLE / left, least, LARGEST))
    return sized(name, robot, seed, joint, target)


def _left(hidden: Hidden, robot: str, seed: int) -> float:
    """Largest share of the torque that a hidden effect leaves after a fit of what is declared."""
    where = scene(robot, seed=seed)
    if hidden.given or hidden.channel == "qd":
        return float(share(hidden, where).max())
    gap = missed(hidden, where)
    machine, weight = hidden.believed(where.machine), rms(where.torque)
    return float(visible(gap, machine, where.motion, hidden.undeclared, weight).max())
