"""simulate: move a robot by a controller or by given torques, and write its log."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from symgen.codegen.model import Model, derive
from symgen.data.drive import joint_side, motor_side
from symgen.data.log import Log, make_log, read_only
from symgen.data.raw import FloatArray
from symgen.distributed import Meter, Say, silent
from symgen.errors import LogError, ParameterError
from symgen.estimation.temperature_torque import torque_beside
from symgen.experiment.recording import (
    Controller,
    Instruments,
    Recording,
    replay,
    tracking,
    unseen_torque,
)
from symgen.experiment.reference import Reference, as_csv, from_log, reference_of, torques_of
from symgen.identification.parameters import base_values, read_parameters
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Drive, Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load
from symgen.runtime.integrator import Law, Motion, integrate
from symgen.runtime.plant import KERNELS, Plant, plant, without_dry


@dataclass(frozen=True, eq=False)
class Simulation:
    """True motions and logs of all runs. Arrays are read-only.

    Attributes:
        robot: name of the robot.
        t: (N,) stamps, s.
        q: (runs, N, n) true positions, rad or m.
        qd: (runs, N, n) true speeds, rad/s or m/s.
        tau: (runs, N, n) commanded torques, N m or N.
        q_log: (runs, N, n) positions in the logs.
        qd_log: (runs, N, n) speeds in the logs, None without tachometers.
        tau_log: (runs, N, n) torques in the logs.
        sigma: types of the joints.
        joints: their numbers in the robot file.
        notes: remarks as texts.
        drive: [drive] of the robot, which determines on which side (motor or joint) files are.
        temp: (N, n) temperatures in the logs, deg C, or None.
    """

    robot: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray
    q_log: FloatArray
    qd_log: FloatArray | None
    tau_log: FloatArray
    sigma: tuple[int, ...]
    joints: tuple[int, ...]
    notes: tuple[str, ...] = ()
    drive: Drive | None = None
    temp: FloatArray | None = None

    def __repr__(self) -> str:
        """Return robot, runs and duration."""
        span = f"{self.t[-1] - self.t[0]:.4g} s"
        return f"<Simulation of {self.robot}: {self.runs} runs of {span}, {len(self.t)} stamps>"

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.q_log)

    def seen_by(self, instruments: Instruments, runs: range, seed: int) -> Simulation:
        """Return the same motions, recorded by other instruments.

        Args:
            instruments: the sensors.
            runs: numbers of the runs, one for each motion, or any if there is one motion.
            seed: seed of all noise.
        """
        count = len(self.t)
        noise = instruments.motion_noise(runs, seed, (count, len(self.sigma)))
        q, qd = instruments.delayed(self.t, self.q, self.qd, slice(0, count))
        q, qd = instruments.read(q, qd, *noise)
        arrays = (self.q, self.qd, self.tau, q, qd, instruments.torque(self.tau, runs, seed))
        shape = (len(runs), count, len(self.sigma))
        true_q, true_qd, tau, q, qd, tau_log = (np.broadcast_to(x, shape) for x in arrays)
        return replace(
            self, q=true_q, qd=true_qd, tau=tau, q_log=q,
            qd_log=qd if instruments.velocity else None, tau_log=tau_log,
        )  # fmt: skip

    def log(self, run: int = 0) -> Log:
        """Return the log of a run, on the joint side.

        Raises:
            LogError: identification would refuse the log, for example with fewer than 10 samples.
        """
        qd = None if self.qd_log is None else self.qd_log[run]
        name = f"{self.robot} {run + 1}"
        q, tau = self.q_log[run], self.tau_log[run]
        log = make_log(name, self.t, q, tau, qd, sigma=self.sigma, temp=self.temp)
        return replace(log, mapped=self.drive is not None)

    def files(self, into: Path) -> Iterator[tuple[Path, bytes]]:
        """Yield path and content of each run's log: `into`, or NAME_1, NAME_2 for several runs."""
        for run, path in enumerate(log_paths(into, self.runs)):
            yield path, self.file(run, path.suffix)

    def file(self, run: int = 0, suffix: str = ".csv") -> bytes:
        """Return the log of a run as the content of a CSV or NPZ file.

        Raises:
            LogError: the suffix is neither .csv nor .npz.
        """
        qd = None if self.qd_log is None else self.qd_log[run]
        log = Log(self.robot, self.t, self.q_log[run], qd, self.tau_log[run])
        if self.drive is not None:
            log = motor_side(log, self.drive)
        every = {"q": log.q, "qd": log.qd, "tau": log.tau, "i": log.current, "temp": self.temp}
        groups: dict[str, Any] = {r: array for r, array in every.items() if array is not None}
        if suffix == ".npz":
            out = io.BytesIO()
            np.savez(out, t=self.t, **groups)
            return out.getvalue()
        _require_format(suffix)
        return as_csv(self.t, groups)


def log_paths(into: Path, runs: int) -> list[Path]:
    """Return the paths of the logs of some runs.

    Raises:
        LogError: the suffix is neither .csv nor .npz.
    """
    _require_format(into.suffix)
    if runs == 1:
        return [into]
    return [into.with_name(f"{into.stem}_{run + 1}{into.suffix}") for run in range(runs)]


def _require_format(suffix: str) -> None:
    if suffix not in (".csv", ".npz"):
        raise LogError(f"log {suffix or 'without a suffix'}; accepted: .csv or .npz")


def warmed(
    done: Simulation,
    robot: Robot,
    temperature: tuple[float, float, float],
    instruments: Instruments,
    runs: range,
    seed: int,
) -> Simulation:
    """Return a simulation with temperatures, and with the torques that depend on them.

    Args:
        done: the motions.
        robot: robot with effects that depend on temperature.
        temperature: temperature at the start and at the end, deg C, and the time constant, s.
        instruments: the sensors.
        runs: numbers of the runs.
        seed: seed of all noise.

    Raises:
        ParameterError: the temperature is not valid.
    """
    start, end, constant = temperature
    if not all(map(math.isfinite, temperature)) or constant <= 0:
        listed = ",".join(f"{x:g}" for x in temperature)
        raise ParameterError(
            f"simulate: temperature {listed}; accepted: START,END in deg C and a time above 0 s"
        )
    t = done.t - done.t[0]
    course = end + (start - end) * np.exp(-t / constant)
    temp = np.repeat(course[:, None], len(done.sigma), axis=1)
    pairs = zip(done.q, done.qd, strict=True)
    more = [torque_beside(robot, q, qd, temp, done.robot) for q, qd in pairs]
    tau = read_only(done.tau + np.stack(more))
    shown = instruments.torque(tau, runs, seed)
    return replace(done, tau=tau, tau_log=read_only(shown), temp=read_only(temp))


Parameters = str | Path | Mapping[str, float] | ArrayLike
#: Numbers in one array of all runs, above which memory is likely to be short.
_MOST = 60_000_000
_MOST_RUNS = 100_000


def simulate(
    robot: Robot | str | Path | Evaluator,
    parameters: Parameters,
    *,
    trajectory: Reference | Log | str | Path | None = None,
    torque: Log | str | Path | None = None,
    hold: bool = False,
    recording: Recording | None = None,
    initial: tuple[ArrayLike, ArrayLike] | None = None,
    temperature: tuple[float, float, float] | None = None,
    duration: float = 20.0,
    runs: int | range = 1,
    seed: int = 0,
    tolerance: float = 1e-9,
    progress: Say = silent,
    meter: Meter = silent,
) -> Simulation:
    """Simulate a robot that follows a reference or given torques, and return its logs.

        M(q) qdd + h(q, qd) + A' f = tau + disturbance

    The model has friction, couplings and effects. Coulomb friction of width 0 holds a joint at rest
    under any smaller load (see `symgen.runtime.plant`). The integrator is the method of order 5
    of Dormand and Prince, for all runs together.

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        parameters: an estimate.json or TOML with [parameters], a mapping of their names, or X (p,).
        trajectory: motion that the controller follows: a CSV with t, q1.. and optionally qd1..,
            qdd1..; a log; "paper"; a `Reference`; by default a seeded Fourier series within
            [limits].
        torque: torques to apply instead of a controller: a log, or a CSV with t, tau1.., linear
            between its stamps.
        hold: hold each of these torques until the next stamp instead.
        recording: controller, instruments, disturbance and rate; by default computed torque, and
            exact logs.
        initial: initial q and qd (n,); by default those of the reference, those of the log with the
            torques, or rest at 0.
        temperature: temperature of all joints, (a, b, T): b + (a - b) exp(-t/T) deg C at t s. The
            logs contain it, and the torques of effects that depend on it. The controller
            compensates these torques.
        duration: duration of the Fourier series, s.
        runs: number of runs, or the numbers of some. They differ in noise and disturbance. Run k
            does not depend on the number of runs.
        seed: seed of all noise, and of the Fourier series.
        tolerance: largest error of an integration step, absolute (rad, m, rad/s, m/s) and relative.
        progress: called with a text about the current step.
        meter: called with the part of the motion that is done, from 0 to 1.

    Returns:
        The true motions and the logs.

    Raises:
        ParameterError: the parameters do not belong to this robot, or no robot can have them (M is
            not positive definite, or Coulomb friction is negative). Or the motion is not finite,
            or a torque exceeds [limits]; the message has time and joint.
        LogError: a file cannot be read, or has another number of joints.
    """
    evaluator, X = _loaded(robot, parameters, progress)
    source = evaluator.model.robot
    made = recording or Recording()
    if source.on_logs and (temperature is None or torque is not None):
        raise ParameterError(
            f"simulate: {source.name} has {source.on_logs[0].name}; accepted: a temperature "
            "(--temperature), and no torques to play"
        )
    follows = trajectory is not None or made.controller != Controller()
    if torque is not None and follows:
        raise ParameterError("simulate: torques and a trajectory; accepted: one of the two")
    if torque is not None and made.rate is not None:
        raise ParameterError("simulate: torques have stamps of their own; accepted: no rate")
    numbers = range(runs) if isinstance(runs, int) else runs
    if not 1 <= len(numbers) <= _MOST_RUNS or min(numbers) < 0 or seed < 0:
        raise ParameterError(
            f"simulate: {runs} runs, seed {seed}; accepted: 1 to {_MOST_RUNS} runs, seed 0 or more"
        )
    if torque is not None:
        t, tau, start = torques_of(torque, source)
        law = replay(t, tau, hold)
    else:
        aim = reference_of(
            trajectory, source, duration=duration, rate=made.rate or 1000.0, seed=seed
        )
        t = aim.t if made.rate is None else _stamps(aim.t, made.rate)
        start = aim.q[0], aim.qd[0]
        law = tracking(made.controller, aim, evaluator, without_dry(evaluator.model, X))
    done = _run(
        plant(evaluator, X), t, law, start if initial is None else initial, made, numbers, seed,
        tolerance, hold=hold, smooth=torque is None, progress=progress, meter=meter,
    )  # fmt: skip
    if temperature is None:
        return done
    return warmed(done, source, temperature, made.instruments, numbers, seed)


def track(
    robot: Robot | str | Path | Evaluator,
    parameters: Parameters,
    log: Log,
    controller: Controller | None = None,
    *,
    cutoff: float | None = None,
    clip: bool = False,
    tolerance: float = 1e-9,
) -> Simulation:
    """Simulate a robot that a controller moves along the measured motion of a log.

    The reference is q of the log after a zero-phase low-pass filter, with its derivatives. If the
    model is right, the simulated torque equals the measured one. The motion then differs only by
    the Coulomb friction that the feedback does not compensate.

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        parameters: as in `simulate`.
        log: the measured log.
        controller: computed torque by default.
        cutoff: cutoff of the low-pass, Hz; by default from the bandwidth of the motion.
        clip: as in `simulate`.
        tolerance: as in `simulate`.

    Returns:
        One run over the stamps of the log: `t` is log.t, and `q[0]`, `qd[0]`, `tau[0]` (N, n) are
        the simulated motion and torque, without noise.

    Raises:
        ParameterError: as `simulate`.
        LogError: the log has another number of joints, or a gap.
    """
    evaluator, X = _loaded(robot, parameters, silent)
    source = evaluator.model.robot
    log = log if source.drive is None else joint_side(log, source.drive)
    aim = reference_of(from_log(log, cutoff), source)
    made = Recording(controller=controller or Controller(), clip=clip)
    law = tracking(made.controller, aim, evaluator, without_dry(evaluator.model, X))
    return _run(
        plant(evaluator, X), log.t, law, (aim.q[0], aim.qd[0]), made, range(1), 0, tolerance
    )


def _run(
    moved: Plant,
    t: FloatArray,
    law: Law,
    initial: tuple[ArrayLike, ArrayLike],
    made: Recording,
    runs: range,
    seed: int,
    tolerance: float,
    *,
    hold: bool = False,
    smooth: bool = True,
    progress: Say = silent,
    meter: Meter = silent,
) -> Simulation:
    """Simulate a plant along stamps t (N,), and return the logs.

    Args:
        moved: the robot.
        t: (N,) s.
        law: the torque that acts.
        initial: q and qd (n,).
        made: instruments, controller, disturbance and clipping.
        runs: their numbers.
        seed: of all noise.
        tolerance: of an integration step.
        hold: whether a torque is held until the next stamp.
        smooth: whether the law does not bend at the stamps.
        progress: is told what is being done.
        meter: is told which part is done.
    """
    robot, shown = moved.evaluator.model.robot, made.instruments
    limits = robot.limits.torque if robot.limits else None
    if made.clip and limits is None:
        raise ParameterError(f"simulate: clip, and {robot.name} has no torque in [limits]")
    if not 1e-13 <= tolerance <= 1e-3:
        raise ParameterError(f"simulate: tolerance {tolerance:g}; accepted: 1e-13 to 1e-3")
    if len(runs) * len(t) * robot.n > _MOST:
        raise ParameterError(
            f"simulate: {len(runs)} runs of {len(t)} samples and {robot.n} joints would fill "
            f"the memory; accepted: up to {_MOST // (len(t) * robot.n)} runs at a time"
        )
    start = [np.asarray(x, dtype=np.float64) for x in initial]
    for name, value in zip(("q", "qd"), start, strict=True):
        if value.shape != (robot.n,) or not np.isfinite(value).all():
            raise ParameterError(
                f"simulate: initial {name} has the shape {value.shape}, or is not finite; "
                f"accepted: ({robot.n},)"
            )
    noise = shown.motion_noise(runs, seed, (len(t), robot.n))
    top = np.array(limits or ())
    measured, pushed = made.controller.feedback == "measured", made.unseen(robot.n)
    # Runs that differ in nothing but what is read off them are one motion.
    apart = pushed.any() or (measured and any(e.size > 1 for e in noise))
    moving = runs if apart else runs[:1]

    def torque(at: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:
        tau = law(at, q, qd)
        return np.clip(tau, -top, top) if made.clip else tau

    def held(k: int, q: FloatArray, qd: FloatArray) -> FloatArray:
        now = slice(k, k + 1)
        errors = (e if e.size == 1 else e[: len(q), now] for e in noise)
        q, qd = shown.read(*shown.delayed(t, q, qd, now), *errors)
        return torque(np.full(len(q), t[k]), q[:, 0], qd[:, 0])

    progress(f"moving {robot.name} over {t[-1] - t[0]:.6g} s")
    motion = integrate(
        moved,
        torque,
        t,
        *(np.repeat(x[None], len(moving), axis=0) for x in start),
        held=held if hold or measured else None,
        unseen=unseen_torque(pushed, moving, seed, len(t)) if pushed.any() else None,
        smooth=smooth,
        tolerance=tolerance,
        progress=lambda k: meter((k + 1) / (len(t) - 1)),
    )
    true = Simulation(
        robot.name,
        read_only(t),
        *(motion.q, motion.qd, motion.tau) * 2,
        robot.sigma,
        tuple(j.number for j in robot.movable),
        _torque_notes(motion, robot, limits, made.clip),
        robot.drive,
    )
    return true.seen_by(shown, runs, seed)


def _torque_notes(
    motion: Motion, robot: Robot, limits: tuple[float, ...] | None, clip: bool
) -> tuple[str, ...]:
    """Return notes on how often a torque was clipped.

    Raises:
        ParameterError: a torque exceeds its limit, and clipping is off.
    """
    notes = []
    for j, limit in enumerate(limits or ()):
        size, joint = np.abs(motion.tau[:, :, j]), robot.listed([j])
        if clip and (share := float(np.mean(size >= limit))):
            notes.append(f"the torque of {joint} was clipped in {100 * share:.3g} % of samples")
        if size.max() > limit * (1 + 1e-12):
            k = int(np.argmax((size > limit).any(axis=0)))
            raise ParameterError(
                f"simulate: {joint} needs {size[:, k].max():.4g} at t = {motion.t[k]:.6g} "
                f"s, and [limits] allow {limit:g}; accepted: a slower motion, or clipping (--clip)"
            )
    return tuple(notes)


def _stamps(t: FloatArray, rate: float) -> FloatArray:
    count = math.floor((t[-1] - t[0]) * rate * (1 + 1e-12)) + 1
    if count < 2:
        raise ParameterError(
            f"simulate: rate {rate:g} Hz over {t[-1] - t[0]:.4g} s; accepted: more"
        )
    return np.asarray(t[0] + np.arange(count) / rate)


def _loaded(
    robot: Robot | str | Path | Evaluator, parameters: Parameters, progress: Say
) -> tuple[Evaluator, FloatArray]:
    """Return the evaluator with the necessary kernels, and X (p,)."""
    source = read_robot(robot.model.robot if isinstance(robot, Evaluator) else robot)
    require_gravity(source, "a simulation")
    if source.passive:
        raise ParameterError(
            f"robot {source.name!r}: {source.listed(source.passive)} has actuated = false; "
            "accepted: a simulation that drives every joint"
        )
    if isinstance(robot, Evaluator) and all(map(robot.has, KERNELS)):
        return robot, values_of(parameters, robot.model)
    progress("deriving and compiling the model")
    model = derive(source, KERNELS)
    X = values_of(parameters, model)
    return load(model), X


def values_of(parameters: Parameters, model: Model) -> FloatArray:
    """Return X (p,) from a file, from named values, or from numbers.

    Raises:
        ParameterError: the parameters do not belong to this robot.
    """
    if isinstance(parameters, (str, Path)):
        return read_parameters(parameters, model)
    if isinstance(parameters, Mapping):
        return base_values(parameters, model, "parameters")
    X = np.asarray(parameters, dtype=np.float64)
    if X.shape != (len(model.base.parameters),) or not np.isfinite(X).all():
        raise ParameterError(
            f"parameters of shape {X.shape}; accepted: X ({len(model.base.parameters)},) of finite "
            "numbers, a mapping of names, or a file"
        )
    return X
