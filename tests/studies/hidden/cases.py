"""The door: logs in which an effect is hidden, what is true of them, and the set of all cases.

`case` simulates, `cases` lists the calibration set, `write` makes files of a case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from oracles.hidden.machines import MACHINES, Machine
from oracles.hidden.motion import STEP, Motion, generator
from oracles.hidden.simulate import inverse, simulate
from studies.hidden.catalogue import misfit as draw_misfit
from studies.hidden.effects import Channels, Hidden
from studies.hidden.sizes import CUTOFF, lowpass, place, rms, scene, visible

EDGE = 0.5  # s at both ends that floors leave out: the filters' transients
MOTION = ("t", "q", "qd", "qdd", "turn")
Log = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Case:
    """One robot, two logs of it, and what is true.

    All per-joint figures are RMS over RMS of the joint's measured torque, below 10 Hz.

    Attributes:
        robot_toml: what the user believes.
        parameters: true standard parameters by name (XX1 .. FVn) of the robot WITHOUT the effect,
            what an earlier log of the healthy robot would give.
        train, validation: t (N,), q, qd, tau (N, n), as measured.
        truth: (name, joints, parameters) of each effect; joints are 1-based, () where global.
        alternatives: names that say exactly the same as the effect of the same rank.
        given: the effect is seen only with parameters that were identified without it.
        missed: RMS of what the believed model with true parameters misses on the validation log.
        gap: what remains of it on the training log once all declared parameters are fitted, noise
            apart; the same as missed, of the training log, where given. Says what can be detected.
        floor: gap of the true model on the validation log, from noise of torque and of positions.
        hidden: the missed torque itself, (N, n) of each log; a misfit is part of it.
        true: noise-free t, q, qd, qdd, tau of each log before the measuring chain.
    """

    robot_toml: str
    parameters: dict[str, float]
    train: Log
    validation: Log
    truth: tuple[tuple[str, tuple[int, ...], dict[str, float]], ...]
    alternatives: tuple[tuple[str, ...], ...]
    given: bool
    missed: np.ndarray
    gap: np.ndarray
    floor: np.ndarray
    hidden: dict[str, np.ndarray]
    true: dict[str, Log]

    @property
    def visible(self) -> bool:
        """Whether some joint shows at least 1.5 % of its torque and three times its floor.

        A wrong tachometer is no missing torque: it is as visible as it is large.
        """
        seen = (self.gap >= 0.015) & (self.gap >= 3 * self.floor)
        return bool(seen.any()) or any(n == "velocity_sensor_error" for n, *_ in self.truth)


@lru_cache(maxsize=24)
def case(
    robot: str,
    effect: str | tuple[str, ...] | None,
    size: str = "moderate",
    seed: int = 0,
    engine: str = "pinocchio",
    misfit: float = 0.0,
) -> Case:
    """Simulate a case; the same arguments give the same bytes.

    Args:
        robot: a name of MACHINES; its bodies do not depend on the seed.
        effect: a name of EFFECTS, several at once, or None for a clean control.
        size: "moderate" (at least 6 % of the torque's RMS and visible) or "small" (1.5 %).
        seed: of motion, joint, non-linear parameters and noise.
        engine: "pinocchio" or "mujoco".
        misfit: RMS share of a smooth torque outside any library, on every joint.
    """
    names = _names(effect)
    effects: list[Hidden] = []
    for name in names:
        taken = [j - 1 for other in effects for j in other.joints]
        effects.append(place(name, robot, size, seed, taken))
    believed = _through((e.believed for e in effects), MACHINES[robot])
    machine = _through((e.machine for e in effects), MACHINES[robot])
    if misfit:
        off = scene(robot, "misfit", seed=seed)
        torque = draw_misfit(off, misfit * rms(off.torque))
        machine = replace(machine, extra=(*machine.extra, torque))
    undeclared = tuple(item for e in effects for item in e.undeclared)
    runs = {}
    for kind in ("train", "validation"):
        noise = generator("noise", robot, names, size, seed, kind, engine)
        runs[kind] = _measure(machine, believed, effects, kind, seed, engine, noise)
    given = any(e.given for e in effects)
    return Case(
        robot_toml=MACHINES[robot].robot_toml(undeclared),
        parameters=believed.parameters(),
        train=runs["train"].log,
        validation=runs["validation"].log,
        truth=tuple((e.name, e.joints, dict(e.parameters)) for e in effects),
        alternatives=tuple(e.alternatives for e in effects),
        given=given,
        missed=runs["validation"].missed(),
        gap=runs["train"].missed() if given else runs["train"].gap(believed, undeclared),
        floor=runs["validation"].floor(believed),
        hidden={kind: run.hidden for kind, run in runs.items()},
        true={kind: run.true for kind, run in runs.items()},
    )


@dataclass(frozen=True, eq=False)
class _Measured:
    log: Log
    true: Log
    motion: Motion
    tau: np.ndarray
    hidden: np.ndarray
    step: float

    def _band(self, values: np.ndarray) -> np.ndarray:
        edge = round(EDGE / self.step)
        return lowpass(values, self.step)[edge:-edge]

    def missed(self) -> np.ndarray:
        return rms(self._band(self.hidden)) / rms(self._band(self.log["tau"]))

    def gap(self, believed: Machine, undeclared: Iterable[tuple[int, str]]) -> np.ndarray:
        edge, weight = round(EDGE / self.step), rms(self._band(self.log["tau"]))
        columns = {key: getattr(self.motion, key)[edge:-edge] for key in MOTION}
        return visible(self._band(self.hidden), believed, Motion(**columns), undeclared, weight)

    def floor(self, believed: Machine) -> np.ndarray:
        """Noise of the torque channel and of the model's torque along noisy positions.

        Positions alone are used, since tachometers may be what is wrong; both the measured and the
        true ones pass the same filter, so that the filter's own error is no part of the floor.
        """
        error = self.log["tau"] - self.tau
        for sign, q in ((-1, self.log["q"]), (1, self.true["q"])):
            q = lowpass(q, self.step, 2 * CUTOFF)
            qd = np.gradient(q, self.step, axis=0)
            motion = replace(self.motion, q=q, qd=qd, qdd=np.gradient(qd, self.step, axis=0))
            error = error + sign * inverse(believed, motion)
        return rms(self._band(error)) / rms(self._band(self.log["tau"]))


def _measure(
    machine: Machine,
    believed: Machine,
    effects: list[Hidden],
    kind: str,
    seed: int,
    engine: str,
    noise: np.random.Generator,
) -> _Measured:
    """Simulate one log and read it with the machine's instruments.

    Encoders are quantised, tachometers have white noise, the torque white noise of 1 % of its RMS
    and 0.3 % below 5 Hz.
    """
    run = simulate(machine, believed, kind, seed, engine)
    every = round(1 / (machine.rate * STEP))
    fine = Channels(run.motion.t, run.motion.q, run.motion.qd, run.tau)
    written = _through((e.log for e in effects), fine)
    motion = Motion(**{key: getattr(run.motion, key)[::every] for key in MOTION})
    tau, step, n = written.tau[::every], every * STEP, machine.n
    level = rms(tau)
    slow = lowpass(noise.normal(size=tau.shape), step, 5.0)
    q = np.round(written.q[::every] / machine.resolution) * machine.resolution
    log = {
        "t": motion.t,
        "q": q,
        "qd": written.qd[::every] + machine.tacho * noise.normal(size=q.shape),
        "tau": tau + level * (0.01 * noise.normal(size=(len(tau), n)) + 0.003 * slow / rms(slow)),
    }
    true = {key: getattr(motion, key) for key in MOTION[:4]}
    true["tau"] = run.tau[::every]
    for values in (*log.values(), *true.values()):
        values.setflags(write=False)
    return _Measured(log, true, motion, tau, tau - inverse(believed, motion), step)


def _names(effect: str | tuple[str, ...] | None) -> tuple[str, ...]:
    return (effect,) if isinstance(effect, str) else tuple(effect or ())


def _through(functions: Iterable[Callable], value):
    for function in functions:
        value = function(value)
    return value
