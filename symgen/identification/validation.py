"""How an estimate does on data: residuals of its equations, torque in the motion's band."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symgen.data.bandwidth import motion_bandwidth
from symgen.data.drive import joint_side
from symgen.data.log import Log, cut, read_log
from symgen.data.raw import Reading, refuse
from symgen.data.signals import (
    Samples,
    can_filter,
    cumulative_integral,
    filter_reach,
    lowpass,
    prepare,
)
from symgen.errors import LogError
from symgen.identification.estimate import Balance, Residual, Trace
from symgen.identification.masking import masked
from symgen.identification.system import Equations
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_TORQUES = (1e-9, 1e9)  # N m or N
_BEYOND = 1.0  # of the range of a joint; gears make more of it
Source = str | Path | Log
#: Periods of a low-pass's cutoff after which white noise that passed it is uncorrelated to 2 %.
_MEMORY = 2.0
_CHECKED = 2000  # samples of each log at which the kinetic energy is looked at


@dataclass(frozen=True, eq=False)
class Part:
    """One log prepared for one purpose: "train" or "validation"."""

    kind: str
    samples: Samples
    equations: tuple[Equations, ...]
    quantity: str = "energy"


def listed_logs(logs: Sequence[Source] | Source) -> list[Source]:
    """Return one log or several as a list."""
    return [logs] if isinstance(logs, (str, Path, Log)) else list(logs)


def require_logs(logs: Sequence[Source]) -> None:
    """Raise LogError where there is no log."""
    if not logs:
        raise LogError(
            "no log is given; accepted: one or more CSV, Parquet, NPZ or MCAP files, or ROS 2 bags"
        )


def open_log(source: Source, robot: Robot, reading: Reading | None = None) -> Log:
    """Read a log where a path is given, and map it to the joint side; refuse another robot's.

    Args:
        source: a path, or a log as it was recorded.
        robot: whose [drive] says on which side that is.
        reading: how files are read, and the span of time that is used.

    Raises:
        LogError: it cannot be read, has another number of joints, or torques that no robot has.
    """
    reading = reading or Reading()
    if isinstance(source, Log):
        log = source
        if log.q.shape[1] != robot.n:
            raise LogError(
                f"{log.name}: the log has {log.q.shape[1]} joints, the robot has {robot.n}"
            )
        log = log if robot.drive is None else joint_side(log, robot.drive)
    else:
        names = [joint.name for joint in robot.movable]
        log = read_log(source, sigma=robot.sigma, drive=robot.drive, reading=reading, names=names)
    _require_within(log, robot)
    log = cut(log, reading.start, reading.until)
    if log.tau is None:
        what = "has currents and no torques"
        refuse(log.name, what, "with torque_constant in [drive] of the robot file")
    largest = float(np.abs(log.tau).max())
    if not _TORQUES[0] < largest < _TORQUES[1]:  # nothing can be learned from such torques
        raise LogError(
            f"{log.name}: the largest torque is {largest:.3g}; accepted: N m or N, between "
            f"{_TORQUES[0]:g} and {_TORQUES[1]:g}"
        )
    return log


def _require_within(log: Log, robot: Robot) -> None:
    """Refuse a log far beyond the joints' limits: in degrees, say, or of the drive's other side."""
    limits = None if robot.limits is None else robot.limits.position
    for j, (low, high) in enumerate(limits or ()):
        least, most = float(log.q[:, j].min()), float(log.q[:, j].max())
        if max(low - least, most - high) > _BEYOND * (high - low):
            what = (
                f"q{j + 1} runs from {least:.4g} to {most:.4g} on the joint side, and its limits "
                f"are {low:g} and {high:g}"
            )
            drive = "a log that [drive] maps into [limits]; see position_side"
            refuse(log.name, what, drive if log.mapped else "rad or m, within [limits]")


def open_samples(
    source: Source,
    robot: Robot,
    reading: Reading | None = None,
    cutoff: float | None = None,
    *,
    wide: float = 1.0,
) -> Samples:
    """Open a log and give it uniform steps, a velocity, and the mask that is asked for.

    Args:
        source: a path, or a log as it was recorded.
        robot: the log's robot, with its drive and its limits of torque.
        reading: how the log is read, and what is masked.
        cutoff: of the zero-phase filter where speeds were not measured, Hz.
        wide: by how much positions are filtered above the cutoff, see `prepare`.

    Raises:
        LogError: `open_log` or `prepare` refuse the log, or a joint has next to nothing left.
    """
    reading = reading or Reading()
    log = open_log(source, robot, reading)
    samples = prepare(log, cutoff, wide=wide)
    return masked(samples, log, robot, reading.mask) if reading.mask else samples


def require_other_data(train: Sequence[Samples], held: Sequence[Samples]) -> None:
    """Raise LogError where a log is given twice: it would judge nothing, or count double."""
    known: dict[str, str] = {}
    for samples in train:
        key = digest(samples)
        if key in known:
            raise LogError(
                f"{samples.name}: the training log holds the same data as the training log "
                f"{known[key]}; accepted: each log once, with --weights where it is to count more"
            )
        known[key] = samples.name
    for samples in held:
        same = known.get(digest(samples))
        if same is not None:
            raise LogError(
                f"{samples.name}: the validation log holds the same data as the training log "
                f"{same}; accepted: another log, or none (the last fifth is held out then)"
            )


def digest(samples: Samples) -> str:
    """Return the SHA-256 of a log's samples."""
    sha = hashlib.sha256()
    for array in (samples.t, samples.q, samples.qd, samples.tau):
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()


def kinetic_energy(evaluator: Evaluator, parts: Sequence[Part], X: FloatArray) -> FloatArray:
    """Return the kinetic energy of the identified model along the logs: h(q, qd) - h(q, 0)."""
    inertial = X[: evaluator.model.inertial]
    out = []
    for s in (p.samples for p in parts):
        stride = max(1, len(s.t) // _CHECKED)
        q, qd = s.q[::stride], s.qd[::stride]
        h = evaluator.energy_regressor(q, qd) - evaluator.energy_regressor(q, np.zeros_like(qd))
        out.append(h @ inertial)
    return np.concatenate(out)


def residual(parts: Sequence[Part], X: FloatArray) -> Residual:
    """Return ||y - W X|| / ||y|| of some equations, in all and by joint."""
    errors: dict[int | None, float] = {}
    sizes: dict[int | None, float] = {}
    for e in (e for p in parts for e in p.equations):
        errors[e.joint] = errors.get(e.joint, 0.0) + float(np.sum((e.y - e.W @ X) ** 2))
        sizes[e.joint] = sizes.get(e.joint, 0.0) + float(np.sum(e.y**2))
    total = math.sqrt(sum(errors.values()) / max(sum(sizes.values()), 1e-300))
    if None in errors:
        return Residual(total)
    return Residual(
        total,
        tuple(
            math.sqrt(errors[j] / max(sizes[j], 1e-300))
            for j in sorted(j for j in sizes if j is not None)
        ),
    )


def model_traces(part: Part, X: FloatArray) -> tuple[Trace, ...]:
    """Return what the model's own equations measure and predict, for drawing."""
    first = part.equations[0]
    quantity = "energy" if first.joint is None else part.quantity
    if quantity == "torque":  # drawn from the samples, see TorqueComparison
        return ()
    t = reduce(np.intersect1d, [e.t for e in part.equations])  # a mask is by joint
    kept = [(e, np.isin(e.t, t)) for e in part.equations]
    measured = np.stack([e.y[k] for e, k in kept], axis=1)
    predicted = np.stack([e.W[k] @ X for e, k in kept], axis=1)
    samples = part.samples
    apart = first.correlation + 1  # neighbouring windows share the sample where they meet
    if samples.cutoff_hz is not None and len(first.t) > 1:
        row = float(np.median(np.diff(first.t)))
        apart += math.ceil(_MEMORY / (samples.cutoff_hz * row))
    return (Trace(samples.name, part.kind, quantity, t, measured, predicted, apart),)


def energy_balances(
    evaluator: Evaluator, parts: Sequence[Part], X: FloatArray
) -> tuple[Balance, ...]:
    """Return where the measured work went, log by log.

    Masked logs, whose torque is not to be believed throughout, are left out; and all are where the
    model has effects that hold its own torque.

    Args:
        evaluator: the compiled model, with the kernels of energy.
        parts: the logs.
        X: the parameters, (p,).
    """
    model = evaluator.model
    if model.base.linear < len(model.base.parameters):
        return ()
    out = []
    for part in parts:
        s = part.samples
        if s.mask is not None:
            continue
        h = evaluator.energy_regressor(s.q, s.qd) @ X[: model.inertial]
        lost = evaluator.friction_power(s.q, s.qd) @ X[model.inertial :]
        power = np.einsum("ij,ij->i", s.qd, s.tau)
        work = cumulative_integral(np.column_stack([power, lost]), s.step)
        out.append(Balance(s.name, part.kind, s.t, work[:, 0], h - h[0], work[:, 1]))
    return tuple(out)


class TorqueComparison:
    """Torque of the identified model beside the measured one, in the motion's band."""

    def __init__(self, evaluator: Evaluator, X: FloatArray) -> None:
        self._inverse = evaluator["inverse_dynamics"]
        self._X = X
        self.band = math.inf  # Hz, of the low-pass that both torques pass

    def residual(self, parts: Sequence[Part]) -> tuple[Residual, tuple[Trace, ...]]:
        """Return RMS of measured minus modelled over RMS of measured torque, and what is drawn."""
        traces, errors, sizes = [], [], []
        for part in parts:
            s = part.samples
            measured, predicted, reach, apart = self._compared(s)
            apart = apart if s.mask is None else 0
            traces.append(Trace(s.name, part.kind, "torque", s.t, measured, predicted, apart))
            free = 1.0 if s.mask is None else ~s.mask.near(reach)
            errors.append(np.sum(free * (measured - predicted) ** 2, axis=0))
            sizes.append(np.sum(free * measured**2, axis=0))
        error, size = np.sum(errors, axis=0), np.sum(sizes, axis=0)
        masks = [p.samples.mask for p in parts]
        if all(masks) and not size.all():
            j = int(np.argmin(size)) + 1
            raise LogError(
                f"{parts[0].samples.name}: --mask leaves nothing of tau{j} to compare; accepted: "
                "a log in which every joint moves, a higher cutoff, or no mask"
            )
        joint = np.sqrt(error / np.where(size > 0, size, np.inf))
        total = math.sqrt(float(np.mean(joint**2)))  # of ratios: N and N m do not add up
        return Residual(total, tuple(map(float, joint))), tuple(traces)

    def _compared(self, s: Samples) -> tuple[FloatArray, FloatArray, int, int]:
        """Return both torques, how many samples the filter reaches, and how many it ties."""
        band = motion_bandwidth(s.q, s.step) if s.cutoff_hz is None else s.cutoff_hz
        filtered = can_filter(band, s.step)
        self.band = min(self.band, band) if filtered else self.band

        def smooth(x: FloatArray) -> FloatArray:
            return lowpass(x, s.step, band) if filtered else x

        qdd = np.gradient(smooth(s.qd), s.step, axis=0, edge_order=2)
        reach = filter_reach(band, s.step) if filtered else 0
        apart = math.ceil(_MEMORY / (band * s.step)) if filtered else 1
        return smooth(s.tau), smooth(self._inverse(s.q, s.qd, qdd, self._X)), reach, apart
