"""Open and repair logs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from symgen.data.columns import fixing
from symgen.data.mask import slow_speeds
from symgen.data.raw import Reading
from symgen.data.signals import (
    LOWEST,
    Samples,
    comparison_band,
    sampled,
)
from symgen.data.units import plausible_units
from symgen.errors import IdentificationError, LogError, plain
from symgen.estimation.masking import masked, without_changes
from symgen.estimation.opening import Groups, Source, Sources, open_log
from symgen.faults.fault import Fault
from symgen.faults.rules import apply
from symgen.faults.samples import MASKED, repaired
from symgen.faults.speeds import mended_speeds, silenced_torques, standing
from symgen.policy import POSES
from symgen.robot.types import Robot

_AT_REST = 0.05  # rad or m: spread of positions of a robot that may rest


def open_samples(
    source: Source,
    robot: Robot,
    reading: Reading | None = None,
    *,
    clock: tuple[float, float] | None = None,
) -> tuple[Samples, tuple[Fault, ...]]:
    """Open a log, repair single samples, and return it at uniform steps, with speeds and a mask.

    Args:
        source: a path, or a log as recorded.
        robot: the robot of the log, with its drive and its torque limits.
        reading: how to read the log, and what to mask.
        clock: clock of the longer log if this one is a segment, see `sampled`.

    Raises:
        LogError: `open_log` or `sampled` refuse the log, its rate is below 4 Hz, or a joint
            has almost no unmasked samples.
    """
    reading = reading or Reading()
    log, repairs = repaired(open_log(source, robot, reading), robot.sigma)
    step = float(np.median(np.diff(log.t)))
    steps = np.linalg.norm(np.diff(log.q, axis=0), axis=1)
    if np.median(steps) > POSES * np.linalg.norm(log.q.std(axis=0)) > _AT_REST:
        raise LogError(
            f"{log.name}: the rows are poses, without the motion between them; accepted: a log of "
            "the motion, in which the robot holds each pose for 2 s and moves on quickly"
        )
    if step > 0.5 / LOWEST:  # the steps are too long for the motion
        raise LogError(
            f"{log.name}: a sample every {step:.4g} s; accepted: t in seconds, at "
            f"{2 * LOWEST:g} Hz and more{_time_unit(step)}"
        )
    samples = without_changes(sampled(log, clock))
    samples, masks = apply(MASKED, samples, log)
    if reading.mask:
        samples = masked(samples, log, robot, reading.mask)
    return samples, (*repairs, *masks)


def _time_unit(step: float) -> str:
    """Return the options that make a time step plausible."""
    units = [f"--time-unit {unit}" for unit in plausible_units(step)]
    return f", or {' or '.join(units)}" if units else ""


def open_logs(
    sources: Sources, robot: Robot, reading: Reading | None, progress: Callable[[str], None]
) -> tuple[Groups, list[Fault]]:
    """Open the training and the validation logs, see `open_samples`.

    Raises:
        LogError: as `open_samples`.
    """
    done: list[Fault] = []

    def opened(source: Source) -> Samples:
        progress(f"reading {getattr(source, 'name', source)}")
        samples, repairs = open_samples(source, robot, reading)
        done.extend(repairs)
        return samples

    train, held = sources
    return ([opened(source) for source in train], [opened(source) for source in held]), done


def require_motion(train: Sequence[Samples], robot: Robot) -> None:
    """Refuse logs if a joint moves in none of them.

    Raises:
        IdentificationError: a joint never moves; the message contains the command that fixes it.
    """
    comparison = comparison_band(train)
    stands = np.all([standing(s, comparison) for s in train], axis=0)
    if stands.any():
        ranges = np.ptp(np.concatenate([s.q for s in train]), axis=0)
        still = np.flatnonzero(stands | slow_speeds(ranges, robot.sigma)[1])  # or hardly moves
        fixes = [
            f"{plain(robot.movable[j].name) or j + 1}={round(train[0].q[:, j].mean(), 5) + 0.0:g}"
            for j in still
        ]
        raise IdentificationError(
            f"{robot.listed(still)} did not move: no log shows its friction and inertia; accepted: "
            f"logs in which it moves, or a robot in which it is fixed: {fixing(fixes)} (or "
            "sigma = 2 in its robot.toml, with the position added to theta or r)"
        )


def with_mended_speeds(groups: Groups, comparison: float | None) -> tuple[Groups, list[Fault]]:
    """Repair measured speeds that are delayed or scaled, and torques that contain only noise.

    Args:
        groups: the training and the validation logs.
        comparison: their comparison band, Hz; None for that of the training logs.
    """
    train, held = groups
    comparison = comparison or comparison_band(train)
    done: list[Fault] = []

    def mended(s: Samples) -> Samples:
        samples, repairs = mended_speeds(s, comparison)
        samples, silent = silenced_torques(samples, comparison)
        done.extend((*repairs, *silent))
        return samples

    return ([mended(s) for s in train], [mended(s) for s in held]), done
