"""Logs of simulated arms of 2 to 7 joints, by inverse dynamics along motions that are prescribed.

Nothing here imports the package under test: rigid bodies are Pinocchio's; friction, effects that
the user's robot.toml leaves out, and instruments are written here. A run has a log to identify
from, one to judge by, and a clean motion with its exact torques, which nobody but a judge sees.
Everything is drawn from one seed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from oracles.faults import Fault, Log, light
from oracles.hidden.machines import body
from oracles.pinocchio_arm import PinocchioArm, load_pinocchio
from oracles.random_arms import to_toml
from oracles.transforms import Arm

HALF = np.pi / 2
_IN_PLANE = (0.0, -9.81, 0.0)
#: Geometry alone, so that each is derived and compiled once; bodies are drawn.
ARMS = {
    name: Arm.from_table({"sigma": (0,) * len(table["d"]), **table})
    for name, table in {
        "planar2r": {"d": (0, 0.5), "gravity": _IN_PLANE},
        "spatial2r": {"alpha": (0, HALF), "d": (0, 0)},
        "elbow3r": {"alpha": (0, HALF, 0), "d": (0, 0, 0.4)},
        "planar3r": {"d": (0, 0.4, 0.35), "gravity": _IN_PLANE},
        "arm4r": {"alpha": (0, HALF, 0, 0), "d": (0, 0, 0.4, 0.35)},
        "arm5r": {"alpha": (0, HALF, 0, 0, HALF), "d": (0, 0, 0.45, 0.4, 0)},
        "wrist6r": {
            "alpha": (0, -HALF, 0, HALF, -HALF, HALF),
            "d": (0, 0, 0.43, -0.02, 0, 0),
            "r": (0, 0.15, 0, 0.43, 0, 0),
        },
        "offset6r": {
            "alpha": (0, HALF, 0, 0, HALF, -HALF),
            "d": (0, 0, 0.6, 0.57, 0, 0),
            "r": (0, 0, 0, 0.17, 0.12, 0),
        },
        "arm7r": {
            "alpha": (0, -HALF, HALF, HALF, -HALF, HALF, HALF),
            "d": (0, 0, 0, 0.08, -0.08, 0, 0.09),
            "r": (0, 0, 0.32, 0, 0.38, 0, 0),
        },
        "straight7r": {
            "alpha": (0, -HALF, HALF, -HALF, HALF, -HALF, HALF),
            "d": (0,) * 7,
            "r": (0, 0, 0.42, 0, 0.4, 0, 0),
        },
    }.items()
}
RATES = (100, 125, 200, 250, 500, 1000)
MISSING = (
    "stribeck_friction",
    "gravity_spring",
    "load_dependent_friction",
    "torque_ripple",
    "nonlinear_viscous_friction",
    "position_dependent_friction",
    "torque_offset",
)
CLEAN_RATE = 250.0  # Hz, of the clean motion
_WAVES = 12


@dataclass(frozen=True, eq=False)
class Motion:
    """t (N,) s; q, qd, qdd (N, n), exact."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray


@dataclass(frozen=True, eq=False)
class Run:
    """One arm, what was recorded of it, and what is true.

    Attributes:
        robot_toml: what the user believes.
        train, validation: as the instruments gave them.
        clean, torque: a further motion, and its exact torque (N, n).
    exact: gives the torque (N, n) of a motion, without what is missing.
        missing: (effect, joint, share of the joint's torque) that robot.toml leaves out.
        drawn: arm, kind and speed of the motion, instruments, faults.
    """

    robot_toml: str
    train: Log
    validation: Log
    clean: Motion
    torque: np.ndarray
    exact: Callable[[Motion], np.ndarray]
    missing: tuple[tuple[str, int, float], ...]
    drawn: dict[str, Any]


def run(
    seed: int,
    *,
    arms: Sequence[str] = tuple(ARMS),
    rates: Sequence[int] = RATES,
    speeds: bool | None = None,
    effects: bool | None = None,
    faulty: float = 0.0,
    torque_noise: tuple[float, float] = (0.002, 0.05),
    misfit: float = 0.0,
) -> Run:
    """Draw a run.

    Args:
        seed: same seed and options, same run.
        arms: names of ARMS to draw from.
        rates: Hz, to draw from.
        speeds: whether speeds were measured; None draws it, 6 in 10.
        effects: whether robot.toml leaves effects out; None draws it, 4 in 10.
        faulty: share of the runs whose logs have some of the light faults of `faults`.
        torque_noise: smallest and largest noise of the torques, as shares of their RMS.
        misfit: RMS of a smooth torque of the whole motion that no effect has, over the joint's.
    """
    rng = np.random.default_rng([seed, 2026])
    name = str(rng.choice(list(arms)))
    arm = ARMS[name]
    rate = int(rng.choice(list(rates)))
    kind = str(rng.choice(["fourier", "points"]))
    # Highest frequency of the motion, Hz; how far a joint may swing, rad.
    top, reach = float(10 ** rng.uniform(-1, np.log10(3))), rng.uniform(0.5, 1.8, arm.n)
    seconds = float(rng.uniform(10, 20) if top > 0.3 else rng.uniform(20, 30))
    home = rng.uniform(-0.8, 0.8, arm.n)
    motions = [
        motion_of(rng, kind, top, reach, home, length, step)
        for length, step in (
            (seconds, 1 / rate),
            (seconds / 2, 1 / rate),
            (seconds / 2, 1 / CLEAN_RATE),
        )
    ]
    machine = machine_of(rng, arm, motions[0])
    wanted = rng.random() < 0.4 if effects is None else effects
    missing = _missing(rng, machine, motions[0]) if wanted else ()
    torques = [machine.torque(motion, missing) for motion in motions]
    if misfit:
        apart = np.random.default_rng([seed, 2027])  # what else is drawn stays
        smooth = _smooth(apart, motions[0], misfit * _rms(torques[0]))
        torques = [tau + smooth(m) for tau, m in zip(torques, motions, strict=True)]
    instruments = instruments_of(rng, speeds, torque_noise)
    logs = [recorded(rng, m, tau, instruments) for m, tau in zip(motions, torques, strict=True)]
    faults: list[tuple[Fault, ...]] = [(), ()]
    if rng.random() < faulty:
        for k in (0, 1):
            logs[k], faults[k] = light(logs[k], rng)
    friction = ("coulomb", "viscous", "offset") if machine.offset.any() else ("coulomb", "viscous")
    return Run(
        robot_toml=to_toml(arm, name, friction),
        train=logs[0],
        validation=logs[1],
        clean=motions[2],
        torque=torques[2],
        exact=machine.torque,
        missing=tuple((e.name, e.joint + 1, e.share) for e in missing),
        drawn={
            "arm": name,
            "rate_hz": rate,
            "motion": kind,
            "top_hz": top,
            "seconds": seconds,
            **instruments,
            "faults": [[f.name for f in each] for each in faults],
        },
    )


# Motions.


def motion_of(
    rng: np.random.Generator,
    kind: str,
    top: float,
    reach: np.ndarray,
    home: np.ndarray,
    seconds: float,
    step: float,
) -> Motion:
    """Sums of five sines up to `top` Hz, or moves of fifth order between points with dwells."""
    t = np.arange(round(seconds / step) + 1) * step
    make = _fourier if kind == "fourier" else _points
    q, qd, qdd = make(rng, t, top, len(reach))
    # No joint swings beyond its reach, nor faster than 3 rad/s or 20 rad/s2.
    limit = [np.abs(x).max(axis=0) + 1e-9 for x in (q, qd, qdd)]
    scale = np.minimum(reach / limit[0], np.minimum(3 / limit[1], 20 / limit[2]))
    return Motion(t, home + scale * q, scale * qd, scale * qdd)


def _fourier(rng: np.random.Generator, t: np.ndarray, top: float, n: int) -> list[np.ndarray]:
    w = 2 * np.pi * top * np.array([0.2, 0.4, 0.6, 0.8, 1.0])[:, None] * np.ones(n)
    w = w * rng.uniform(0.9, 1.0, w.shape)
    a, phase = rng.uniform(0.3, 1, w.shape) / w, rng.uniform(0, 2 * np.pi, w.shape)
    angle = t[:, None, None] * w + phase
    return [
        (a * np.sin(angle)).sum(1),
        (a * w * np.cos(angle)).sum(1),
        (-a * w**2 * np.sin(angle)).sum(1),
    ]


def _points(rng: np.random.Generator, t: np.ndarray, top: float, n: int) -> list[np.ndarray]:
    # A move lasts about as long as half a period; joints start together and rest together.
    move, dwell = 0.5 / top, min(0.3, 0.15 / top)
    out = [np.zeros((len(t), n)) for _ in range(3)]
    at, begin = rng.uniform(-1, 1, n), 0.0
    while begin < t[-1]:
        to, length = rng.uniform(-1, 1, n), move * rng.uniform(0.8, 1.5)
        here = (t >= begin) & (t < begin + length + dwell)
        s, way = np.clip((t[here] - begin) / length, 0, 1)[:, None], to - at
        out[0][here] = at + way * s**3 * (10 - 15 * s + 6 * s**2)
        out[1][here] = way / length * 30 * s**2 * (1 - s) ** 2
        out[2][here] = way / length**2 * 60 * s * (1 - s) * (1 - 2 * s)
        at, begin = to, begin + length + dwell
    return out


# Machines.


@dataclass(frozen=True, eq=False)
class _Effect:
    """A torque of its own on one joint, as (q, qd, rigid torque) -> (N,)."""

    name: str
    joint: int
    share: float
    law: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class _Machine:
    """An arm with bodies (n, 10), rotors, Coulomb and viscous friction and offsets (n,)."""

    pinocchio: PinocchioArm
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    offset: np.ndarray

    def rigid(self, motion: Motion) -> np.ndarray:
        """Torque (N, n) of bodies and rotors."""
        model, data, rnea = self.pinocchio.model, self.pinocchio.data, load_pinocchio().rnea
        rows = zip(motion.q, motion.qd, motion.qdd, strict=True)
        return np.array([rnea(model, data, *row) for row in rows]) + self.rotor * motion.qdd

    def torque(self, motion: Motion, effects: Sequence[_Effect] = ()) -> np.ndarray:
        """Torque (N, n) of the motors."""
        tau = rigid = self.rigid(motion)
        tau = tau + self.coulomb * np.sign(motion.qd) + self.viscous * motion.qd
        tau = tau + self.offset
        for e in effects:
            tau[:, e.joint] += e.law(motion.q[:, e.joint], motion.qd[:, e.joint], rigid[:, e.joint])
        return tau


def _rms(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def machine_of(rng: np.random.Generator, arm: Arm, motion: Motion) -> _Machine:
    """Bodies that become lighter and smaller outwards; friction of 5 to 30 % of the torque."""
    n = arm.n
    mass = 12 * 0.65 ** np.arange(n) * rng.uniform(0.7, 1.3, n)
    size = 0.2 * 0.85 ** np.arange(n)
    links = np.array(
        [
            body(m, tuple(rng.uniform(-0.8, 0.8, 3) * s), tuple(rng.uniform(0.3, 0.8, 3) * s))
            for m, s in zip(mass, size, strict=True)
        ]
    )
    none = np.zeros(n)
    bodies = _Machine(PinocchioArm(arm, links), none, none, none, none)
    inertia = np.diag(bodies.pinocchio.mass_matrix(motion.q[0]))
    load = _rms(bodies.rigid(motion))
    load = load + 0.05 * load.max()
    return _Machine(
        pinocchio=bodies.pinocchio,
        rotor=inertia * rng.uniform(0.1, 0.6, n),
        coulomb=load * rng.uniform(0.05, 0.3, n),
        viscous=load * rng.uniform(0.05, 0.3, n) / _rms(motion.qd),
        offset=load * rng.uniform(-0.03, 0.03, n) * (rng.random() < 0.5),
    )


def _missing(rng: np.random.Generator, machine: _Machine, motion: Motion) -> tuple[_Effect, ...]:
    """One to three effects, each of 2 to 25 % of its joint's torque along the motion."""
    rigid = machine.rigid(motion)
    size, out = _rms(machine.torque(motion)), []
    for _ in range(int(rng.integers(1, 4))):
        name, j = str(rng.choice(MISSING)), int(rng.integers(motion.q.shape[1]))
        if name == "torque_offset" and machine.offset.any():
            continue  # robot.toml declares it
        share = float(10 ** rng.uniform(np.log10(0.02), np.log10(0.25)))
        v = _rms(motion.qd)[j]
        law = _law(rng, name, v, float(np.mean(motion.q[:, j])))
        unit = _rms(law(motion.q[:, j], motion.qd[:, j], rigid[:, j]))
        gain = share * float(size[j] / max(unit, 1e-12))
        out.append(_Effect(name, j, share, lambda q, v, r, f=law, g=gain: g * f(q, v, r)))
    return tuple(out)


def _smooth(
    rng: np.random.Generator, motion: Motion, size: np.ndarray
) -> Callable[[Motion], np.ndarray]:
    """A torque (N, n) of positions and speeds of all joints: waves over about their spread."""
    state = np.hstack([motion.q, motion.qd])
    middle, spread, n = state.mean(axis=0), state.std(axis=0), motion.q.shape[1]
    ways = rng.normal(size=(_WAVES, 2 * n)) / np.sqrt(n)
    phase = rng.uniform(0, 2 * np.pi, (_WAVES, n))

    def torque(motion: Motion) -> np.ndarray:
        at = (np.hstack([motion.q, motion.qd]) - middle) / spread @ ways.T
        return np.asarray(size * np.sqrt(2 / _WAVES) * np.cos(at[..., None] + phase).sum(axis=1))

    return torque


def _law(
    rng: np.random.Generator, name: str, speed: float, middle: float
) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    k, phase, width = float(rng.integers(3, 9)), rng.uniform(0, 2 * np.pi), rng.uniform(0.15, 0.4)
    centre, power = middle + rng.uniform(-0.4, 0.4), float(rng.choice([1.8, 2.0, 2.4]))
    return {
        "stribeck_friction": lambda _q, v, _r: np.sign(v) * np.exp(-((v / (width * speed)) ** 2)),
        "gravity_spring": lambda q, _v, _r: q - centre,
        "load_dependent_friction": lambda _q, v, r: np.abs(r) * np.sign(v),
        "torque_ripple": lambda q, _v, _r: np.sin(k * q + phase),
        "nonlinear_viscous_friction": lambda _q, v, _r: np.sign(v) * np.abs(v / speed) ** power,
        "position_dependent_friction": lambda q, v, _r: np.sign(v) * np.sin(q + phase),
        "torque_offset": lambda q, _v, _r: np.ones_like(q),
    }[name]


# Instruments.


def instruments_of(
    rng: np.random.Generator, speeds: bool | None, noise: tuple[float, float]
) -> dict[str, Any]:
    """Encoders' step [rad], tachometers' and torques' noise (shares of RMS), its colour [Hz]."""
    return {
        "encoder": float(10 ** rng.uniform(-6, -3.5)),
        "speeds": bool(rng.random() < 0.6) if speeds is None else speeds,
        "tachometer": float(10 ** rng.uniform(-3, -1.7)),
        "torque_noise": float(10 ** rng.uniform(*np.log10(noise))),
        "colour_hz": float(10 ** rng.uniform(0.7, 2.5)),
    }


def recorded(rng: np.random.Generator, motion: Motion, tau: np.ndarray, how: dict[str, Any]) -> Log:
    step = float(motion.t[1])
    q = np.round(motion.q / how["encoder"]) * how["encoder"]
    qd = motion.qd + how["tachometer"] * _rms(motion.qd) * rng.normal(size=q.shape)
    # Noise of first order, of the same RMS whatever its colour.
    a = np.exp(-2 * np.pi * how["colour_hz"] * step)
    noise = lfilter([np.sqrt(1 - a**2)], [1, -a], rng.normal(size=tau.shape), axis=0)
    measured = tau + how["torque_noise"] * _rms(tau) * noise
    return Log(motion.t, q, qd if how["speeds"] else None, measured)
