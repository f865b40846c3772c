"""The effects that are hidden, each as what it does to the machine, its log and what is declared.

A builder gets the believed machine, the scene, a joint (0-based) and a size, and returns a `Hidden`
whose coefficients are proportional to the size; non-linear parameters and signs come from the
scene's random numbers and do not depend on the size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from oracles.hidden.machines import Machine
from oracles.hidden.motion import Motion


@dataclass(frozen=True, eq=False)
class Channels:
    """What the controller would write down if its instruments were perfect; arrays (N, n)."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    tau: np.ndarray


def _same(value: Any) -> Any:
    return value


@dataclass(frozen=True, eq=False)
class Hidden:
    """One hidden effect.

    Attributes:
        name: as in the library of effects, or "unnamed".
        joints: 1-based; () where the whole robot is concerned.
        parameters: true values, SI.
        machine: believed machine -> machine that is simulated.
        believed: machine -> machine without the effect, where it takes a declared term away.
        log: perfect channels -> those written down.
        undeclared: (0-based joint, term) that robot.toml must not declare.
        channel: the channel whose error is its size, "tau" or "qd".
        given: it is seen only with parameters that were identified without it.
        alternatives: names that say exactly the same on this robot.
    """

    name: str
    joints: tuple[int, ...]
    parameters: Mapping[str, float]
    machine: Callable[[Machine], Machine] = _same
    believed: Callable[[Machine], Machine] = _same
    log: Callable[[Channels], Channels] = _same
    undeclared: tuple[tuple[int, str], ...] = ()
    channel: str = "tau"
    given: bool = False
    alternatives: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Scene:
    """What effects are drawn from: a machine, its reference motion, the torque (N, n) of that."""

    machine: Machine
    motion: Motion
    torque: np.ndarray
    rng: np.random.Generator

    def speed(self, j: int) -> float:
        """RMS of a joint's speed."""
        return float(np.sqrt(np.mean(self.motion.qd[:, j] ** 2)))

    def spread(self, j: int) -> float:
        """Half the range of a joint."""
        return float(np.ptp(self.motion.q[:, j]) / 2)

    def middle(self, j: int) -> float:
        """Middle of a joint's range."""
        return float((self.motion.q[:, j].max() + self.motion.q[:, j].min()) / 2)


Builder = Callable[[Scene, int, float], Hidden]


class At(NamedTuple):
    """One joint: time, position, speed, smooth sign of the speed, position at the last reversal."""

    t: Any
    q: Any
    v: Any
    s: Any
    turn: Any


def added(
    name: str, joint: int, parameters: Mapping[str, float], law: Callable[[At], Any]
) -> Hidden:
    """An effect that is one more torque on a joint."""

    def change(machine: Machine) -> Machine:
        width, n = machine.width[joint], machine.n

        def torque(t: Any, q: np.ndarray, qd: np.ndarray, turn: np.ndarray) -> np.ndarray:
            v = qd[..., joint]
            out = np.zeros((*v.shape, n))
            out[..., joint] = law(At(t, q[..., joint], v, np.tanh(v / width), turn[..., joint]))
            return out

        return replace(machine, extra=(*machine.extra, torque))

    return Hidden(name, (joint + 1,), parameters, machine=change)


def forgotten(name: str, field: str, symbol: str, declared: str) -> Builder:
    """A declared term that robot.toml forgot on one joint."""

    def build(_: Scene, joint: int, size: float) -> Hidden:
        return Hidden(
            name,
            (joint + 1,),
            {symbol: size},
            machine=lambda machine: machine.with_entry(field, joint, size),
            believed=lambda machine: machine.with_entry(field, joint, 0.0),
            undeclared=((joint, declared),),
        )

    return build


def torque_offset(_: Scene, j: int, size: float) -> Hidden:
    hidden = added("torque_offset", j, {"OF": size}, lambda _: -size)
    return replace(hidden, alternatives=("asymmetric_coulomb_friction",))


def asymmetric_coulomb_friction(scene: Scene, j: int, size: float) -> Hidden:
    # Beside the declared symmetric part, (FSp - FSm)/2 in either direction is left.
    FS = float(scene.machine.coulomb[j])
    values = {"FSp": FS + size, "FSm": FS - size}
    hidden = added("asymmetric_coulomb_friction", j, values, lambda _: -size)
    return replace(hidden, alternatives=("torque_offset",))


def asymmetric_viscous_friction(_: Scene, j: int, size: float) -> Hidden:
    return added("asymmetric_viscous_friction", j, {"a": size}, lambda x: -size * x.v * x.s)


def stribeck_friction(scene: Scene, j: int, size: float) -> Hidden:
    vs = scene.rng.uniform(0.15, 0.35) * scene.speed(j)
    return added(
        "stribeck_friction",
        j,
        {"a": size, "vs": vs},
        lambda x: -size * x.s * np.exp(-((x.v / vs) ** 2)),
    )


def nonlinear_viscous_friction(scene: Scene, j: int, size: float) -> Hidden:
    p = scene.rng.choice([1.8, 2.0, 2.4])
    return added(
        "nonlinear_viscous_friction",
        j,
        {"a": size, "p": p},
        lambda x: -size * x.s * np.abs(x.v) ** p,
    )


def load_dependent_friction(_: Scene, j: int, size: float) -> Hidden:
    return Hidden(
        "load_dependent_friction",
        (j + 1,),
        {"a": size},
        machine=lambda machine: machine.with_entry("load", j, size),
    )


def position_dependent_friction(scene: Scene, j: int, size: float) -> Hidden:
    angle = scene.rng.uniform(0, 2 * np.pi)
    a, b = size * np.cos(angle), size * np.sin(angle)
    return added(
        "position_dependent_friction",
        j,
        {"a": a, "b": b},
        lambda x: -x.s * (a * np.cos(x.q) + b * np.sin(x.q)),
    )


def gravity_spring(scene: Scene, j: int, size: float) -> Hidden:
    q0 = scene.middle(j) + scene.rng.uniform(-0.4, 0.4) * scene.spread(j)
    return added("gravity_spring", j, {"K": size, "q0": q0}, lambda x: -size * (x.q - q0))


def torque_ripple(scene: Scene, j: int, size: float) -> Hidden:
    # Whole numbers of periods per turn; on a slide, of a pinion of 20 mm radius.
    scale = 1.0 if scene.machine.arm.sigma[j] == 0 else 1 / 0.02
    k, angle = scale * scene.rng.integers(3, 9), scene.rng.uniform(0, 2 * np.pi)
    a, b = size * np.cos(angle), size * np.sin(angle)
    return added(
        "torque_ripple",
        j,
        {"a": a, "b": b, "k": k},
        lambda x: a * np.sin(k * x.q) + b * np.cos(k * x.q),
    )


def cable_torque(scene: Scene, j: int, size: float) -> Hidden:
    # A cubic in q whose quadratic and cubic parts are alike over the joint's range.
    c2 = -size * scene.rng.choice([-1, 1]) / scene.spread(j) ** 2
    c3 = -size / scene.spread(j) ** 3
    return added("cable_torque", j, {"c2": c2, "c3": c3}, lambda x: c2 * x.q**2 + c3 * x.q**3)


def external_contact(scene: Scene, j: int, size: float) -> Hidden:
    begin, length = scene.rng.uniform(0.25, 0.6) * scene.machine.seconds, scene.rng.uniform(0.5, 1)
    A = -size if scene.rng.random() < 0.5 else size

    def law(x: At) -> np.ndarray:
        rise, fall = (np.clip((x.t - at) / 0.03, 0, 1) for at in (begin, begin + length - 0.03))
        return A * (rise - fall)

    values = {"A": A, "begin": begin, "end": begin + length}
    return added("external_contact", j, values, law)


def unnamed_bump(scene: Scene, j: int, size: float) -> Hidden:
    w = 0.25 * scene.spread(j)
    c, A = scene.middle(j) + scene.rng.uniform(-0.3, 0.3) * scene.spread(j), size / w
    return added(
        "unnamed",
        j,
        {"A": A, "c": c, "w": w},
        lambda x: -A * (x.q - c) * np.exp(-(((x.q - c) / w) ** 2)),
    )


def unnamed_product(scene: Scene, j: int, size: float) -> Hidden:
    n = scene.machine.n
    k = (j + 1) % n
    a = size / (scene.spread(j) * scene.speed(k))

    def torque(_t: Any, q: np.ndarray, qd: np.ndarray, _turn: np.ndarray) -> np.ndarray:
        out = np.zeros(q.shape)
        out[..., j] = a * q[..., j] * qd[..., k]
        return out

    return Hidden(
        "unnamed",
        (j + 1,),
        {"a": a, "other": k + 1},
        machine=lambda machine: replace(machine, extra=(*machine.extra, torque)),
    )
