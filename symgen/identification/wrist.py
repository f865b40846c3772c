"""The tool behind a force/torque sensor at the wrist, from its wrench.

With the motion of the sensor's frame from the joint positions, the wrench of a log is linear in the
ten parameters s of the tool, and in the offset o of each channel, which may drift:

    w = A(a - g, w, dw) s + o + d u + e u (1 + u) + f u (1 + u) (1 + 2 u),    u = (t - t_end)/T

Drift and bends (d, e and f) are part of the fit where they are beyond chance. Both sides pass the
low-pass of the comparison band. Poses at rest show mass, first moments and offsets; motion shows
the inertia.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from symgen.data.mask import Mask
from symgen.data.raw import WRENCH, Bools, Reading
from symgen.data.signals import (
    MARGIN,
    OPEN,
    Samples,
    comparison_band,
    noise_of_differences,
    require_cutoff,
)
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.band import Band
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source, require_other_data
from symgen.estimation.summary import triangle
from symgen.estimation.system import Extent, Rows, join
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray, Trace
from symgen.faults.repair import open_logs
from symgen.identification.load import COM, LABELS, SMALL, UNITS, Load
from symgen.identification.load_result import (
    WITH,
    LoadErrors,
    Payload,
    Quantity,
    Sensor,
    payload_of,
    require_mass,
)
from symgen.identification.solving import noise_columns
from symgen.parallel import Say
from symgen.policy import ACCEPT, BEYOND, NOISES
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import load_model

_TOOL, _CHANNELS = len(UNITS), len(WRENCH)
#: Shapes of an offset over a log: constant, a drift, and two bends of it.
_SHAPES = 4
_TURNED = (
    "the sensor reports what the tool exerts on the arm, as the fit gave a negative mass: its "
    "wrench was multiplied by -1, and the offsets are those of the result"
)


def payload_by_wrench(
    robot: Robot,
    sources: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    progress: Say,
) -> Payload:
    """Identify the tool behind the sensor of a robot.

    Args:
        robot: the robot, with [sensor].
        sources: the logs, with the wrench.
        reading: options of reading and masking.
        cutoff: cutoff of the filter of positions, Hz; None for five comparison bands.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a log, or it has no wrench.
        RobotError: the robot has no sensor, or its gravity is unknown.
        IdentificationError: the logs leave the mass open, or the tool is no rigid body.
    """
    if robot.sensor is None or robot.imu or robot.gravity_input:
        raise RobotError(
            f"robot {robot.name!r}: a load by its wrench needs the axes of the sensor and gravity; "
            "accepted: [sensor] with frame = the name of a [[frame]], and gravity as numbers"
        )
    frame = robot.frame(robot.sensor.frame)
    with_wrench = replace(reading or Reading(), wrench=True)
    (opened, _), repairs = open_logs((sources, ()), robot, with_wrench, progress)
    samples = [_of_wrench(s) for s in opened]
    require_other_data(samples, [])
    band = _band(samples, cutoff)
    logs = [filter_log(s, band) for s in samples]
    progress("deriving and compiling the model")
    kernel = load_model(robot_toml(robot), ("tool_wrench",))["tool_wrench"]
    progress("solving")
    places = np.eye(len(logs))
    rows = join([_equations(kernel, at, log) for at, log in zip(places, logs, strict=True)])
    noise = noise_columns(partial(_equations, kernel, np.ones(1)), logs)[:, :_TOOL]
    fitted = _with_drifts(rows, noise)
    known = _require_shown(fitted.tool)
    turned = bool(fitted.tool.s[-1] < -BEYOND * fitted.tool.std()[0])
    if turned:
        rows, fitted = replace(rows, y=-rows.y), fitted.turned()
    require_mass(fitted.tool, robot.label(frame.joint))
    traces = _traces(logs, rows, fitted)
    errors = _errors(logs, traces)
    notes = [note for s in samples for note in s.notes]
    left = ", ".join(name for name in LABELS if name not in known)
    if left:
        notes.append(f"{left} stay open: more poses show the centre, and motion the inertia")
    if turned:
        notes.append(_TURNED)
    return payload_of(
        fitted.tool,
        None,
        None,
        tuple(notes),
        robot=robot.name,
        frame=frame.name,
        residual=errors,
        method="weighted least squares of the wrench of the sensor",
        band=band,
        repairs=tuple(repairs),
        joints=(),
        joint=frame.joint,
        sensor=_sensor(fitted, known, turned),
        traces=traces,
    )


def _band(samples: Sequence[Samples], cutoff: float | None) -> Band:
    """Return the band of the logs, with speeds from positions.

    Raises:
        LogError: no filter can have this cutoff.
    """
    rate, comparison = min(1 / s.step for s in samples), comparison_band(samples)
    if cutoff is None:
        cutoff = min(MARGIN * comparison, OPEN * rate)
    for s in samples:
        require_cutoff(s.name, cutoff, s.step, s.length)
    return Band(rate, cutoff, comparison, "derived")


def _require_shown(tool: Load) -> set[str]:
    """Return the names of what the logs determine.

    Raises:
        IdentificationError: they leave the mass open.
    """
    known = {*tool.determined()}
    if "mass" not in known:
        left = ", ".join(name for name in LABELS if name not in known)
        raise IdentificationError(
            f"the logs leave {left} and the offsets of the sensor open; accepted: at least three "
            "poses at rest in which gravity has other directions in the frame of the sensor, so "
            "not poses about one vertical axis alone"
        )
    return known


def _sensor(fitted: _Fit, known: set[str], turned: bool) -> Sensor:
    """Return offset and drift of each channel in the last log.

    If the centre of the tool stays open, so do the offsets of the moments.
    """
    pairs = zip(fitted.others.tolist(), fitted.std.tolist(), strict=True)
    quantities = [Quantity(*pair) if pair[1] else Quantity(None, None) for pair in pairs]
    last = quantities[-_SHAPES * _CHANNELS :]
    offset, drift = tuple(last[:_CHANNELS]), tuple(last[_CHANNELS : 2 * _CHANNELS])
    if not {*COM} <= known:
        offset = (*offset[:3], *3 * [Quantity(None, None)])
    return Sensor(offset, drift, turned, tuple(fitted.tool.nearest().s.tolist()))


def _traces(logs: Sequence[FilteredLog], rows: Rows, fitted: _Fit) -> tuple[Trace, ...]:
    """Return the wrench of each log without the offset, and that of the tool."""
    of_tool, of_logs = np.split(rows.W, [_TOOL], axis=2)
    measured, model = rows.y - of_logs @ fitted.others, of_tool @ fitted.tool.s
    return tuple(
        Trace(log.name, "train", WITH, rows.t[at], measured[at], model[at])
        for log, at in zip(logs, rows.spans, strict=True)
    )


def _errors(logs: Sequence[FilteredLog], traces: Sequence[Trace]) -> LoadErrors:
    """Return the RMS error of the force over the RMS of the force, and that of noise alone.

    Raises:
        IdentificationError: the tool is no rigid body.
    """
    size, error, noise = 0.0, 0.0, 0.0
    for log, trace in zip(logs, traces, strict=True):
        size += float(np.sum(trace.measured[:, :3] ** 2))
        error += float(np.sum(trace.residual[:, :3] ** 2))
        white = noise_of_differences(log.tau[:, :3])
        passed = 2 * log.band.comparison_hz * log.step
        noise += len(trace.t) * passed * float(white @ white)
    relative, floor = math.sqrt(error / size), math.sqrt(noise / size)
    if relative > max(ACCEPT, NOISES * floor):
        raise IdentificationError(
            f"the wrench is not that of a rigid tool: {percent(relative)} of its force remains; "
            "accepted: a [[frame]] with the axes of the sensor, the gravity of the robot file, and "
            "logs without contact and without moving fingers"
        )
    return LoadErrors(1.0, relative, floor, (), ())


def _of_wrench(s: Samples) -> Samples:
    """Return the samples with the wrench in place of the torques, and one mask for its channels."""
    assert s.wrench is not None  # of a log that was opened for it
    return replace(s, tau=s.wrench, mask=s.mask and Mask(s.mask.robot[:, None], s.mask.robot))


def _equations(kernel: Any, place: FloatArray, log: FilteredLog) -> Rows:
    """Return the equations of a log: columns of the tool, then offsets and drifts of each log.

    Args:
        kernel: the kernel tool_wrench.
        place: (L,) 1 for this log, and 0 for the other ones.
        log: the log.
    """
    none, one = np.zeros(_CHANNELS), np.ones(log.tau.shape)

    def columns(*motion: FloatArray) -> FloatArray:
        return np.stack([kernel(*motion, unit, none) for unit in np.eye(_TOOL)], axis=2)

    late = (log.t - log.t[-1]) / log.samples.length
    bend = late * (1 + late)
    shapes = (np.ones(len(late)), late, bend, bend * (1 + 2 * late))
    parts = [log.compared(one * shape[:, None])[:, :, None] for shape in shapes]
    own = np.concatenate([part * np.eye(_CHANNELS) for part in parts], axis=2)
    W = np.concatenate([log.modelled(columns), np.kron(place, own)], axis=2)
    extents = (Extent(len(W), PER_PERIOD // 2),)
    return Rows((), W, log.measured, log.compared_t, np.where(log.free, one[log.kept], 0), extents)


class _Fit(NamedTuple):
    """The tool, and offsets and drifts (q,) with their deviations (q,), both 0 if not fitted."""

    tool: Load
    others: FloatArray
    std: FloatArray

    def turned(self) -> _Fit:
        """Return the fit of the opposite wrench."""
        return _Fit(replace(self.tool, s=-self.tool.s), -self.others, self.std)


def _with_drifts(rows: Rows, noise: FloatArray) -> _Fit:
    """Fit tool and offsets, with the drifts that are beyond chance.

    Drifts are left out if they would leave more of the tool open.

    Args:
        rows: the equations.
        noise: (K, 10) noise of the columns of the tool.
    """
    drifts = np.arange(rows.W.shape[2] - _TOOL) // _CHANNELS % _SHAPES > 0
    still = _fit(rows, noise, ~drifts)
    drifting = _fit(rows, noise, drifts | ~drifts)
    if drifting.tool.null.shape != still.tool.null.shape:
        return still
    return _fit(rows, noise, ~drifts | (np.abs(drifting.others) > BEYOND * drifting.std))


def _fit(rows: Rows, noise: FloatArray, used: Bools) -> _Fit:
    """Fit the tool with some of the offsets and drifts.

    A direction of the tool stays open if its columns, without their part in those of the offsets,
    do not exceed the noise of the positions.
    """
    from scipy.linalg import block_diag, null_space

    columns, others = np.split(rows.W[rows.weight > 0], [_TOOL], axis=1)
    columns, others = columns * UNITS, others[:, used]
    shared = others @ np.linalg.lstsq(others, columns, rcond=None)[0]
    _, sizes, directions = np.linalg.svd(triangle(columns - shared))
    lost = np.linalg.norm(noise * UNITS @ directions.T, axis=0)
    shown = directions[sizes > np.maximum(lost, SMALL * np.linalg.norm(columns))]
    onto = block_diag(UNITS[:, None] * shown.T, np.eye(len(used))[:, used])
    solution = Wls().solve(rows.with_regressor(rows.W @ onto))
    (s, values), covariance = (
        np.split(onto @ solution.X, [_TOOL]),
        onto @ solution.covariance @ onto.T,
    )
    tool = Load(s, covariance[:_TOOL, :_TOOL], null_space(shown))
    return _Fit(tool, values, np.sqrt(np.diag(covariance))[_TOOL:])
