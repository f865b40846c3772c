"""The logs of a run: open them, map them to the joint side, and check that they differ."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.drive import joint_side, with_servo_torques
from symgen.data.log import (
    MIN_SAMPLES,
    Log,
    cut,
    of_movable_joints,
    read_wanted,
    reading_of,
)
from symgen.data.long_logs import Source as Source
from symgen.data.long_logs import only_log
from symgen.data.mask import rms
from symgen.data.raw import (
    CONTACT_END,
    IMU,
    POSE,
    WRENCH,
    Bools,
    Reading,
    read_only,
    refuse,
    roles_with_unit,
    wanted_by,
)
from symgen.data.signals import Samples, interpolated, noise_of_differences
from symgen.errors import LogError, located
from symgen.estimation.floating import upward
from symgen.estimation.values import FloatArray
from symgen.names import PRISMATIC, WRENCH_ENDS
from symgen.policy import COPIED, EQUAL
from symgen.robot.tables import Limits
from symgen.robot.types import Robot

_TORQUES = (1e-9, 1e9)  # N m or N
#: Usual specific force of a base, m/s2. It excludes readings in g, without gravity, or in mm/s2.
_WEIGHT = (3.0, 100.0)
#: Largest error of the norm of a quaternion.
_UNIT = 0.01
_SIX = len(WRENCH_ENDS)
_ABOVE = 1.05  # torque over its limit that gives a note
_USUALLY = 0.99  # quantile of the speed, without outliers
#: Share of each log that is held out without a validation log.
HELD_OUT = 0.2
#: Number of shifts in time, and of samples, for the comparison of the positions of two logs.
_SHIFTS = 512
#: The training and the validation logs of a run: as the user gives them, and opened.
Sources = tuple[Sequence[Source], Sequence[Source]]
Groups = tuple[list[Samples], list[Samples]]
#: Largest difference of positions on the same path, as a part of the RMS of the motion.
_SAME_PATH = 0.1
#: Ending of the name of a held-out part.
LATE = " (last fifth)"


def listed_logs(logs: Sequence[Source] | Source) -> list[Source]:
    """Return one log or several as a list."""
    return [logs] if isinstance(logs, (str, Path, Log)) else list(logs)


def require_logs(logs: Sequence[Source]) -> None:
    """Raise LogError if there is no log."""
    if not logs:
        raise LogError(
            "no log is given; accepted: one or more CSV, Parquet, NPZ or MCAP files, or ROS 2 bags"
        )


def open_log(source: Source, robot: Robot, reading: Reading | None = None) -> Log:
    """Read a log from a path, map it to the joint side, and refuse a log of another robot.

    Args:
        source: a path, or a log as recorded.
        robot: the robot; its [drive] section states the side of the recorded values.
        reading: options of reading files, and the span of time to use.

    Raises:
        LogError: the log cannot be read, or has another number of joints or impossible torques.
    """
    reading = reading or Reading()
    if isinstance(source, Log):
        with located(source.name):
            log = of_movable_joints(source, wanted_by(robot, reading))
            log = cut(joint_side(log, robot.drive), reading.start, reading.until)
    else:
        with located(source):
            source = only_log(source)
            reading = reading_of(str(source), reading, robot.log)
        log = read_wanted(source, wanted_by(robot, reading))
    with located(log.name):
        _require_within(log, robot, reading)
        log = with_servo_torques(log, robot.controller, robot.drive)
        log = with_base(log, robot)
        if reading.wrench and log.wrench is None:
            refuse("lacks the wrench of the sensor", f"columns {', '.join(WRENCH)}, N and N m")
        if reading.wrench or reading.open_windings:
            return replace(log, tau=read_only(0 * log.q), drive_unit="")
        if log.tau is None and log.current is None:
            refuse("has a wrench and no torques", "tau1.., or symgen payload --sensor")
        if log.tau is None:
            what = "has currents and no torques"
            refuse(what, "with torque_constant in [drive] of the robot file")
        tau = log.tau.copy()
        tau[:, robot.passive] = 0.0  # the joint has no drive
        largest = float(np.abs(tau).max(initial=0.0))
        # no parameter can be estimated from such torques
        if robot.n and not _TORQUES[0] < largest < _TORQUES[1]:
            refuse(
                f"the largest torque is {largest:.3g}",
                f"{log.drive_unit or 'N m or N'}, between {_TORQUES[0]:g} and {_TORQUES[1]:g}",
            )
    beyond = () if log.drive_unit or not robot.n else _beyond_torque(tau, robot, log.name)
    notes = dict.fromkeys((*log.notes, *beyond))
    return replace(log, tau=read_only(tau), notes=tuple(notes))


def with_base(log: Log, robot: Robot) -> Log:
    """Return a log with what its equations need of the base, and without other columns of it.

    Raises:
        LogError: a column is missing, or has other units.
    """
    if not robot.imu:
        return replace(log, imu=None, pose=None, forces=None, touches=None)
    log = replace(log, robot=robot)
    if log.imu is None and log.pose is not None:
        log = replace(log, pose=_steady(log.pose))
    else:
        log = replace(log, pose=None)
        _require_imu(log, robot)
    if not robot.floating:
        return replace(log, forces=None, touches=None)
    if any(contact.radius for contact in robot.contacts):
        log = replace(log, up=read_only(upward(log, robot)))
    return _with_forces(log, robot)


def _steady(pose: FloatArray) -> FloatArray:
    """Return a pose with quaternions of norm 1, whose sign does not jump.

    Raises:
        LogError: a norm differs from 1 by more than 1 %.
    """
    Q = pose[:, 3:]
    norm = np.linalg.norm(Q, axis=1)
    k = int(np.argmax(np.abs(norm - 1)))
    if abs(norm[k] - 1) > _UNIT:
        refuse(f"qw to qz have the norm {norm[k]:.4g} in sample {k}", "a norm within 1 % of 1")
    turns = np.sum(Q[1:] * Q[:-1], axis=1) < 0
    sign = np.cumprod(np.append(1.0, np.where(turns, -1.0, 1.0)))
    return read_only(np.hstack([pose[:, :3], Q * (sign / norm)[:, None]]))


def _with_forces(log: Log, robot: Robot) -> Log:
    """Return a log of a robot with a floating base, with flags of all of its contacts.

    A contact with a measured wrench has no unknown force.

    Raises:
        LogError: a contact has neither its wrench nor its column.
    """
    count, frames = len(log.t), [frame.name for frame in robot.frames]
    forces = np.full((count, 0), np.nan) if log.forces is None else log.forces
    touches = np.full((count, 0), np.nan) if log.touches is None else log.touches
    known = {*np.array(frames)[: forces.shape[1] // _SIX][_present(forces[:, ::_SIX])]}
    have = _present(touches)
    flags = np.zeros((count, len(robot.contacts)))
    for k, contact in enumerate(robot.contacts):
        name = contact.frame
        if k >= len(have) or not have[k]:
            if name in known:
                continue
            every = f"{name}.{', '.join(WRENCH_ENDS)}"
            what = f"lacks the column {name}.{CONTACT_END}, 1 where this contact touches and else 0"
            refuse(what, f"this column, or {every} of its force, or a robot file without it")
        flags[:, k] = touches[:, k]
    return replace(
        log,
        forces=log.forces if known else None,
        touches=read_only(flags) if flags.any() else None,
    )


def _present(columns: FloatArray) -> Bools:
    """Return which columns have values."""
    return np.asarray(~np.isnan(columns).all(axis=0))


def _require_imu(log: Log, robot: Robot) -> None:
    """Refuse a log that lacks the motion of the base, or has its specific force in other units."""
    if log.imu is None:
        refuse(
            "lacks the motion of the base, which moves according to the robot file",
            f"columns {', '.join(IMU)} in m/s2 and rad/s, in the axes of the base (imu (N, 6) "
            f"for NPZ), or {', '.join(POSE)}, or a robot file without base = {robot.base!r}",
        )
    usual = float(np.median(np.linalg.norm(log.imu[:, :3], axis=1)))
    flies = robot.floating and log.forces is None and log.touches is None
    if not (_WEIGHT[0] < usual or flies) or usual > _WEIGHT[1]:
        what = f"the specific force of the base, fx to fz, is {usual:.3g} for half of the log"
        refuse(what, "m/s2, gravity included: about 9.81 at rest, as an accelerometer shows")


def _require_within(log: Log, robot: Robot, reading: Reading) -> None:
    """Refuse a log far beyond the joint limits, for example in degrees or on the motor side.

    Far means beyond a position limit by more than the range, or a speed of more than twice its
    limit. Gears and offsets cause less. With `--unit` for speeds, the speed limits are not checked.
    """
    limits = robot.limits or Limits()
    side = "a log that [drive] maps into [limits]; see position_side"
    for j, (low, high) in enumerate(limits.position or ()):
        q = log.q[:, j]
        least, most = float(q.min()), float(q.max())
        if max(low - least, most - high) > high - low:
            what = (
                f"q{j + 1} runs from {least:.4g} to {most:.4g} on the joint side, and the limits "
                f"of {robot.listed([j])} in the robot file are {low:g} and {high:g}"
            )
            si, unit = ("m", f"q{j + 1}=mm") if robot.sigma[j] == PRISMATIC else ("rad", "deg")
            plain = f"{si}, or --unit {unit}; if it is {si}, wider limits in the robot file"
            refuse(what, side if log.mapped else plain)
    if log.qd is None or "qd" in roles_with_unit(reading):
        return
    for j, limit in enumerate(limits.velocity or ()):
        usual = float(np.quantile(np.abs(log.qd[:, j]), _USUALLY))
        if usual - limit > limit:
            foreign, si = ("mm/s", "m/s") if robot.sigma[j] == PRISMATIC else ("deg/s", "rad/s")
            what = (
                f"qd{j + 1} is up to {usual:.4g} on the joint side, and the limit of "
                f"{robot.listed([j])} in the robot file is {limit:g}"
            )
            plain = f"{si}, or --unit qd={foreign}; or --unit qd={si} if the limit is wrong"
            refuse(what, side if log.mapped else plain)


def _beyond_torque(tau: FloatArray, robot: Robot, name: str) -> Iterator[str]:
    """Yield a note on the torque that exceeds the limit of the robot file the most."""
    limits = robot.limits and robot.limits.torque
    times = np.abs(tau).max(axis=0) / (limits or np.inf)
    j = int(np.argmax(times))
    if times[j] > _ABOVE:
        yield (
            f"{name}: tau{j + 1} is up to {times[j]:.3g} times its limit in the robot file: check "
            "its unit (--unit) and the limit"
        )


def first_held_out(count: int) -> int:
    """Return the number of the first held-out sample of `count` samples."""
    return int(count * (1 - HELD_OUT))


def hold_out(logs: Sequence[Samples]) -> Groups:
    """Hold out the last fifth of every log.

    Raises:
        LogError: a log is too short.
    """
    train, held_out = [], []
    for s in logs:
        cut = first_held_out(len(s.t))
        if len(s.t) - cut < MIN_SAMPLES:
            raise LogError(
                f"{s.name}: {len(s.t)} samples are too few to hold out the last fifth; accepted: "
                f"{math.ceil(MIN_SAMPLES / HELD_OUT)} and more, or a second log for validation"
            )
        train.append(s.cut(slice(None, cut)))
        late = s.cut(slice(cut, None))
        held_out.append(replace(late, name=f"{s.name}{LATE}", notes=()))
    return train, held_out


def require_other_data(train: Sequence[Samples], held_out: Sequence[Samples]) -> list[Samples]:
    """Raise LogError if a log is a copy of a training log, shifted in time, resampled or reversed.

    It would validate nothing, or count double. The torques of a copy differ by less than those of
    two recordings with the same noise. A tenth of the samples may be near reversals of friction,
    which interpolation smooths.

    Returns:
        The held-out logs, each with a note if it repeats the path of a training log.
    """
    logs = [*train, *held_out]
    for k, other in enumerate((*train, *held_out)):
        for log in train[:k] if other.q.size else []:
            for direction in (1, -1):
                then = direction * other.t + _shift(log, other, direction)
                pairs = (log.tau, other.tau), (log.q, other.q)
                if all(_is_copy(log.t, x, then, y) for x, y in pairs):
                    what = f"{other.name}: holds the same data as the training log {log.name}"
                    refuse(what, "another log, or no validation log (the last fifth is held out)")
                centre = log.q.mean(axis=0)
                if _is_copy(log.t, log.q - centre, then, other.q - centre, _SAME_PATH):
                    note = (
                        f"{other.name}: repeats the path of the training log {log.name}; errors "
                        "on other motions may be larger"
                    )
                    logs[k] = replace(other, notes=(*other.notes, note))
    return logs[len(train) :]


def _is_copy(
    t: FloatArray, x: FloatArray, then: FloatArray, y: FloatArray, least: float = EQUAL
) -> bool:
    """Return whether channels y (K, n) at some times are channels x (N, n), interpolated.

    They may differ by the noise of x, or by a part `least` of the RMS of x.
    """
    apart = np.quantile(np.abs(interpolated(t, x)(then) - y), 0.9, axis=0)
    noise = np.maximum(COPIED * noise_of_differences(x), least * rms(x))
    return bool((apart <= noise).all())


def _shift(log: Samples, other: Samples, direction: int) -> Any:
    """Return the time, s, after which a log has positions nearest to those of another one.

    Args:
        log, other: the logs.
        direction: 1, or -1 if the other log runs backwards.
    """
    from scipy.optimize import brute

    some = other.cut(slice(None, None, 1 + len(other.t) // _SHIFTS))
    t = direction * some.t
    known = interpolated(log.t, log.q)
    shifts = log.t[[0, -1]] - np.sort(t)[[0, -1]]
    return brute(lambda s: np.std(known(t + s) - some.q), [shifts], Ns=_SHIFTS)


def samples_digest(samples: Samples) -> str:
    """Return the SHA-256 of a log's samples."""
    sha = hashlib.sha256()
    for array in (samples.t, samples.q, samples.qd, samples.tau):
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()
