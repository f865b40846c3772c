"""The mask of a log, its notes, and a check of the remaining samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.data.log import MIN_SAMPLES, Log
from symgen.data.mask import Bools, on_grid, resting, saturated
from symgen.data.signals import Samples
from symgen.errors import LogError
from symgen.estimation.band import rest_speeds
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import HALF
from symgen.estimation.system import Rows
from symgen.robot.types import Robot

#: Time before and after a change of contacts that is masked, s.
_BEFORE, _AFTER = 0.02, 0.05


def masked(samples: Samples, log: Log, robot: Robot, kinds: Sequence[str]) -> Samples:
    """Mask samples at rest or in saturation; the log itself keeps all samples.

    A masked joint has no momentum and torque equations. Energy equations are left out if all moving
    joints are at rest, or if any torque is saturated.

    Args:
        samples: the log on its uniform grid.
        log: the original log, for torques that are not resampled.
        robot: robot with types of joints, torque limits, and the drive.
        kinds: "rest", "saturation" or both.

    Raises:
        LogError: fewer than 10 samples of a joint remain.
    """
    joint = np.zeros(samples.q.shape, dtype=bool)
    all_joints = np.zeros(len(samples.t), dtype=bool)
    notes = []
    if "rest" in kinds:
        slow = rest_speeds([samples], robot.sigma)
        rest, still = resting(samples.q, samples.step, slow), slow < 0
        if not still.all():
            all_joints |= rest[:, ~still].all(axis=1)
        joint |= rest
        what = _shares(rest, robot, "at rest")
        if still.any():
            what += f"; {robot.listed(np.flatnonzero(still))} never moves and is not masked"
        notes.append(what)
    if "saturation" in kinds:
        assert log.tau is not None  # open_log guarantees it
        limits = None if robot.limits is None or log.drive_unit else robot.limits.torque
        ratio = None if robot.drive is None else robot.drive.ratio
        high = on_grid(saturated(log.tau, limits, ratio), log.t, samples.t)
        all_joints |= high.any(axis=1)
        joint |= high
        known = "at a limit of [limits] or stuck" if limits is not None else "stuck"
        notes.append(_shares(high, robot, f"in saturation ({known} at its extreme)"))
    for j, count in enumerate((~joint).sum(axis=0)):
        if count < MIN_SAMPLES:
            raise LogError(
                f"{samples.name}: --mask leaves {count} of {len(samples.t)} samples of "
                f"{robot.listed([j])}; accepted: at least {MIN_SAMPLES}"
            )
    texts = tuple(f"{samples.name}: masked {note}" for note in notes)
    return replace(samples.masked(joint, all_joints), notes=(*samples.notes, *texts))


def without_changes(samples: Samples) -> Samples:
    """Mask the samples around changes of contacts: impacts, and errors of the flags in time."""
    if samples.touches is None:
        return samples
    flags = samples.touches > HALF
    changes = np.diff(flags, axis=0, prepend=flags[:1]).any(axis=1)
    if not changes.any():
        return samples
    before, after = (math.ceil(span / samples.step) for span in (_BEFORE, _AFTER))
    near = np.convolve(changes, np.ones(before + after + 1))
    masks = np.asarray(near[before : before + len(flags)] > HALF)
    joints = np.repeat(masks[:, None], samples.q.shape[1], axis=1)
    note = f"{samples.name}: {changes.sum()} changes of contacts are masked"
    return replace(samples.masked(joints, masks), notes=(*samples.notes, note))


def _shares(flags: Bools, robot: Robot, what: str) -> str:
    """Return a text with the share of flagged samples of each joint."""
    counts = ", ".join(
        f"{robot.listed([j])} {count} ({100 * count / len(flags):.3g} %)"
        for j, count in enumerate(flags.sum(axis=0))
        if count
    )
    return f"{what}: {counts or 'none'} of {len(flags)} samples"


def require_equations(log: FilteredLog | Samples, rows: Rows, robot: Robot) -> None:
    """Refuse a mask that covers nearly all samples.

    Raises:
        LogError: fewer than 10 equations of a joint, or of the energy, remain.
    """
    counts = np.count_nonzero(rows.weight, axis=0)
    for j, count in enumerate(counts.tolist() if log.mask is not None else ()):
        if count < MIN_SAMPLES:
            j -= len(robot.free)
            whose = "" if rows.energy else f" of {robot.listed([j])}" if j >= 0 else " of the base"
            raise LogError(
                f"{log.name}: --mask leaves {count} equations{whose}; accepted: at least "
                f"{MIN_SAMPLES}, so a shorter window, a higher cutoff, or no mask"
            )
