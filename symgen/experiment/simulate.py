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
from symgen.data.drive import motor_side
from symgen.data.log import Log, make_log, read_only
from symgen.data.raw import FloatArray
from symgen.errors import LogError, ParameterError
from symgen.experiment.recording import (
    Controller,
    Instruments,
    Recording,
    disturbance_torque,
    replay,
    tracking,
)
from symgen.experiment.reference import Reference, as_csv, reference_of, torques_of
from symgen.identification.parameters import base_values, read_parameters
from symgen.parallel import Meter, Say, silent
from symgen.robot.tables import Drive
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load
from symgen.runtime.simulate import WIDTH, Law, SimulatedMotion, simulate_motion, without_dry


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
        drive: [drive] of the robot, which determines on which side (motor or joint) files are.
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
    drive: Drive | None = None

    def __repr__(self) -> str:
        """Return robot, runs and duration."""
        span = f"{self.t[-1] - self.t[0]:.4g} s"
        return f"<Simulation of {self.robot}: {self.runs} runs of {span}, {len(self.t)} stamps>"

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.q_log)

    def recorded_by(self, instruments: Instruments, runs: range, seed: int) -> Simulation:
        """Return the same motions, recorded by other instruments.

        Args:
            instruments: the sensors.
            runs: numbers of the runs, one for each motion, or any if there is one motion.
            seed: seed of all noise.
        """
        motions = range(len(runs)) if len(self.q) > 1 else [0] * len(runs)
        true = [(self.q[k], self.qd[k], self.tau[k]) for k in motions]
        logs = [
            instruments.recorded(self.t, *motion, run, seed)
            for motion, run in zip(true, runs, strict=True)
        ]
        q, qd, tau = (np.stack(x) for x in zip(*true, strict=True))
        q_log, qd_log, tau_log = (np.stack(x) for x in zip(*logs, strict=True))
        return replace(
            self, q=q, qd=qd, tau=tau, q_log=q_log,
            qd_log=qd_log if instruments.velocity else None, tau_log=tau_log,
        )  # fmt: skip

    def log(self, run: int = 0) -> Log:
        """Return the log of a run, on the joint side.

        Raises:
            LogError: identification would refuse the log, for example with fewer than 10 samples.
        """
        qd = None if self.qd_log is None else self.qd_log[run]
        name = f"{self.robot} {run + 1}"
        q, tau = self.q_log[run], self.tau_log[run]
        log = make_log(name, self.t, q, tau, qd, sigma=self.sigma)
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
        every = {"q": log.q, "qd": log.qd, "tau": log.tau, "i": log.current}
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


Parameters = str | Path | Mapping[str, float] | ArrayLike
#: Number of values in one array of all runs, above which memory is likely to be short.
_MOST = 60_000_000
#: Limits of the width of Coulomb friction in an integration, rad/s or m/s.
_WIDTHS = (1e-9, 1.0)
#: Of an integration step. Where dry friction makes the equations stiff, speeds are off by a hundred
#: times this. Parameters from a log without noise are exact to 1e-4, but for the reversals between
#: samples.
_TOLERANCE = 1e-9
#: Kernels that the controllers call.
KERNELS = ("inverse_dynamics", "mass_matrix")


def simulate(
    robot: Robot | str | Path | Evaluator,
    parameters: Parameters,
    *,
    trajectory: Reference | Log | str | Path | None = None,
    torque: Log | str | Path | None = None,
    hold: bool = False,
    recording: Recording | None = None,
    initial: tuple[ArrayLike, ArrayLike] | None = None,
    duration: float = 20.0,
    runs: int | range = 1,
    seed: int = 0,
    width: float = WIDTH,
    progress: Say = silent,
    meter: Meter = silent,
) -> Simulation:
    """Simulate a robot that follows a reference or given torques, and return its logs.

        M(q) qdd + h(q, qd) = tau + disturbance

    The model has friction, couplings and effects. Coulomb friction changes its sign over a small
    width of the speed. A joint that friction holds therefore creeps by about the width times the
    time (see `symgen.runtime.simulate`).

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        parameters: an estimate.json or TOML with [parameters], a mapping of their names, or X (p,).
        trajectory: motion that the controller follows: a CSV with t, q1.. and optionally qd1..,
            qdd1..; a log; a `Reference`; by default a seeded Fourier series within
            [limits].
        torque: torques to apply instead of a controller: a log, or a CSV with t, tau1.., linear
            between its stamps.
        hold: hold each of these torques until the next stamp instead.
        recording: controller, instruments, disturbance and rate; by default computed torque, and
            exact logs.
        initial: initial q and qd (n,); by default those of the reference, those of the log with the
            torques, or rest at 0.
        duration: duration of the Fourier series, s.
        runs: number of runs, or the numbers of some. They differ in noise and disturbance. Run k
            does not depend on the number of runs.
        seed: seed of all noise, and of the Fourier series.
        width: width of the Coulomb friction of joints without coulomb_width, rad/s or m/s.
        progress: called with a text about the current step.
        meter: called with the finished part of the motion, from 0 to 1.

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
    follows = trajectory is not None or made.controller != Controller()
    if torque is not None and follows:
        raise ParameterError("simulate: torques and a trajectory; accepted: one of the two")
    if torque is not None and made.rate is not None:
        raise ParameterError("simulate: torques already have stamps; accepted: no rate")
    numbers = range(runs) if isinstance(runs, int) else runs
    if not numbers or min(numbers) < 0 or seed < 0:
        raise ParameterError(
            f"simulate: {runs} runs, seed {seed}; accepted: 1 run or more, seed 0 or more"
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
    least, largest = _WIDTHS
    if not least <= width <= largest:
        raise ParameterError(f"simulate: width {width:g}; accepted: {least:g} to {largest:g}")
    if len(numbers) * len(t) * source.n > _MOST:
        raise ParameterError(
            f"simulate: {len(numbers)} runs of {len(t)} samples and {source.n} joints would fill "
            f"the memory; accepted: up to {_MOST // (len(t) * source.n)} runs at a time"
        )
    measured, pushed = made.controller.feedback == "measured", made.disturbance_std(source.n)
    # Runs that differ only in measurement noise share one motion.
    moving = numbers[:1] if made.moves_alike else numbers
    progress(f"moving {source.name} over {t[-1] - t[0]:.6g} s")
    motions = []
    for k, run in enumerate(moving):
        acting = law
        if measured:
            acting = _on_measurements(acting, made.instruments, t, run, seed, source.n)
        motions.append(
            simulate_motion(
                evaluator.model,
                X,
                acting,
                t,
                _state(start if initial is None else initial, source.n),
                width=width,
                hold=hold or measured,
                pushed=disturbance_torque(pushed, run, seed, len(t)) if pushed.any() else None,
                tolerance=_TOLERANCE,
                progress=lambda part, k=k: meter((k + part) / len(moving)),  # type: ignore[misc]
            )
        )
        _require_torque(motions[-1], source)
    q, qd, tau = (np.stack([getattr(m, name) for m in motions]) for name in ("q", "qd", "tau"))
    true = Simulation(
        source.name,
        read_only(t),
        q,
        qd,
        tau,
        q,
        qd,
        tau,
        source.sigma,
        tuple(j.number for j in source.movable),
        source.drive,
    )
    return true.recorded_by(made.instruments, numbers, seed)


def _state(initial: tuple[ArrayLike, ArrayLike], n: int) -> tuple[FloatArray, FloatArray]:
    """Return the initial q and qd, (n,) each.

    Raises:
        ParameterError: the shape is another one, or a number is not finite.
    """
    q, qd = (np.asarray(x, dtype=np.float64) for x in initial)
    for name, value in (("q", q), ("qd", qd)):
        if value.shape != (n,) or not np.isfinite(value).all():
            raise ParameterError(
                f"simulate: initial {name} has the shape {value.shape}, or is not finite; "
                f"accepted: ({n},)"
            )
    return q, qd


def _on_measurements(
    law: Law, instruments: Instruments, t: FloatArray, run: int, seed: int, n: int
) -> Law:
    """Return a law that acts on the measured motion at the stamps."""
    shape = len(t), n
    q_error, qd_error = (np.broadcast_to(e, shape) for e in instruments.errors(run, seed, shape))
    past_q, past_qd = np.zeros((2, *shape))

    def measured(at: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        k = int(np.argmin(np.abs(t - at)))
        past_q[k], past_qd[k] = q, qd
        (q,), (qd,) = instruments.delayed(t, past_q, past_qd, slice(k, k + 1))
        return law(at, *instruments.read(q, qd, q_error[k], qd_error[k]))

    return measured


def _loaded(
    robot: Robot | str | Path | Evaluator, parameters: Parameters, progress: Say
) -> tuple[Evaluator, FloatArray]:
    """Return the evaluator with the kernels of the controller, and X (p,)."""
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


def _require_torque(motion: SimulatedMotion, robot: Robot) -> None:
    """Raise ParameterError, with joint and time, if a motion exceeds the torque [limits]."""
    limits = robot.limits.torque if robot.limits else None
    for j, limit in enumerate(limits or ()):
        size = np.abs(motion.tau[:, j])
        beyond = size > limit * (1 + 1e-12)
        if beyond.any():
            k = int(np.argmax(beyond))
            raise ParameterError(
                f"simulate: {robot.listed([j])} needs {size[k]:.4g} at t = {motion.t[k]:.6g} s, "
                f"and [limits] allow {limit:g}; accepted: a slower motion"
            )


def _stamps(t: FloatArray, rate: float) -> FloatArray:
    count = math.floor((t[-1] - t[0]) * rate * (1 + 1e-12)) + 1
    if count <= 1:
        raise ParameterError(
            f"simulate: rate {rate:g} Hz over {t[-1] - t[0]:.4g} s; accepted: more"
        )
    return np.asarray(t[0] + np.arange(count) / rate)


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
