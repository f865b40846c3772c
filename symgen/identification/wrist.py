"""The tool behind a force/torque sensor at the wrist, from its wrench (one of the ways of payload).

With the motion of the sensor's frame from the joint positions, the wrench of each log is linear in
the ten parameters s of the tool, and in the offset o of each channel and its drift d over the log:

    w = A(a - g, w, dw) s + o + d (t - t_end)/T

Both sides pass the low-pass of the comparison band. Poses at rest show mass, first moments and
offset; motion shows the inertia. A direction of the parameters that does not exceed the noise of
the positions stays open.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symgen import names
from symgen.data.columns import fixing
from symgen.data.mask import Mask, rms
from symgen.data.raw import WRENCH, Bools, Reading
from symgen.data.signals import (
    MARGIN,
    OPEN,
    Samples,
    comparison_band,
    lowpass,
    require_cutoff,
    white_noise,
)
from symgen.errors import IdentificationError, RobotError, plain
from symgen.estimation.band import Band
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source, require_other_data
from symgen.estimation.solve import SINGULAR, column_norms, null_space
from symgen.estimation.summary import triangle
from symgen.estimation.system import Extent, Rows, join
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray, Trace
from symgen.faults.fault import Fault
from symgen.faults.repair import open_logs
from symgen.identification.load import (
    LABELS,
    SMALL,
    UNITS,
    UNKNOWN,
    Load,
    Quantity,
    require_weight,
)
from symgen.identification.solving import noise_columns
from symgen.parallel import Say
from symgen.policy import ACCEPT, BEYOND, NOISES
from symgen.robot.tables import Frame
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load_model
from symgen.symbolic.kinematics import path

_TOOL, _CHANNELS = len(names.LINK), len(WRENCH)
#: Offset and drift of a log, in its columns behind those of the tool.
_OF_LOG = 2 * _CHANNELS
#: Units of the offsets, for a body of 0.1 m: N and N m.
_UNITS_OF_OFFSET = np.repeat([1.0, 0.1], 3)
#: Quantities of the traces: the wrench of the model without the tool, and with it.
WITHOUT, WITH = "wrench without the tool", "wrench with the tool"
_TURNED = (
    "the sensor reports what the tool exerts on the arm, since the fit gave a negative mass: its "
    "wrench was multiplied by -1, and so is the offset"
)


@dataclass(frozen=True)
class Wrist:
    """What the sensor shows besides the tool, in the order wfx wfy wfz wnx wny wnz.

    Attributes:
        offset: offset of each channel at the end of the last log, N and N m.
        drift: change of each offset over the last log, N and N m; without a value where the logs
            show none, and the fit has none.
        errors: RMS error of each channel in the comparison band, N and N m.
        turned: whether the sensor reports what the tool exerts on the arm. Its wrench was
            multiplied by -1; so are the offsets.
        torques: mass, centre of mass and inertia from the joint torques of the same logs, in the
            order of `Payload.rows`; None without them.
        difference: the sensor's values minus these.
    """

    offset: tuple[Quantity, ...]
    drift: tuple[Quantity, ...]
    errors: tuple[float, ...]
    turned: bool
    torques: tuple[Quantity, ...] | None = None
    difference: tuple[Quantity, ...] | None = None

    def beside(self, sensor: Sequence[Quantity], torques: Sequence[Quantity]) -> Wrist:
        """Return the value with the load of the joint torques, and the difference of both."""
        pairs = zip(sensor, torques, strict=True)
        return replace(self, torques=tuple(torques), difference=tuple(a.minus(b) for a, b in pairs))


@dataclass(frozen=True, eq=False)
class WristFit:
    """The solution of the equations of the wrench.

    Attributes:
        frame: the frame of the sensor.
        tool: the tool in this frame.
        wrist: offset and drift.
        error: RMS error of the force over its RMS without the offset.
        noise: what noise of the channels alone would cause; NaN if unknown.
        band: the filters of the run.
        repairs: repairs of the logs.
        notes: texts about the run.
        traces: measured and modelled wrench without the offset, for the quantities WITHOUT and
            WITH.
    """

    frame: Frame
    tool: Load
    wrist: Wrist
    error: float
    noise: float
    band: Band
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...]
    traces: tuple[Trace, ...]


def fit_wrist(
    robot: Robot,
    sources: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    progress: Say,
) -> WristFit:
    """Fit the tool behind the sensor of a robot.

    Args:
        robot: the robot, with [sensor].
        sources: the logs, with the wrench.
        reading: options of reading and masking.
        cutoff: cutoff of the filter of positions, Hz; None for five comparison bands.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a log, or it has no wrench.
        RobotError: the robot has no sensor, or joints move behind it.
        IdentificationError: the logs do not show a tool, or it is no rigid body.
    """
    frame = _frame_of(robot)
    with_wrench = replace(reading or Reading(), wrench=True)
    (opened, _), repairs = open_logs((sources, ()), robot, with_wrench, progress)
    samples = [_of_wrench(s) for s in opened]
    require_other_data(samples, [])
    band = _band(samples, cutoff)
    logs = [filter_log(s, band) for s in samples]
    progress("deriving and compiling the model")
    equations = partial(_tool_rows, load_model(robot_toml(robot), ("tool_wrench",)))
    progress("solving")
    rows = _with_offsets(join([equations(log) for log in logs]), logs)
    solved = _solve(rows, noise_columns(equations, logs))
    notes = [note for s in samples for note in s.notes]
    notes += _open_notes(solved, frame)
    mass, std = solved.tool.s[-1], solved.tool.std()[0]
    turned = bool(mass < -BEYOND * std)
    if turned:
        rows, solved = replace(rows, y=-rows.y), solved.turned()
        notes.append(_TURNED)
    require_weight(solved.tool, f"behind the sensor at {plain(frame.name)}")
    traces = _traces(rows, logs, solved)
    error, floor = _force_errors(logs, traces)
    if error > max(ACCEPT, NOISES * np.nan_to_num(floor)):
        raise IdentificationError(
            f"the wrench is not that of a rigid tool: {percent(error)} of its force remains; "
            f"accepted: a [[frame]] {plain(frame.name)} with the axes of the sensor, the gravity "
            "of the robot file, and logs without contact"
        )
    wrist = _wrist(solved, traces, turned)
    return WristFit(
        frame, solved.tool, wrist, error, floor, band, tuple(repairs), tuple(notes), traces
    )


def _frame_of(robot: Robot) -> Frame:
    """Return the frame of the sensor.

    Raises:
        RobotError: there is none, gravity is no number, or joints move behind it.
    """
    listed = ", ".join(plain(f.name) for f in robot.frames[:24] if f.joint)
    if robot.sensor is None:
        raise RobotError(
            f"robot {robot.name!r} has no [sensor]; accepted: [sensor] with frame = the name of a "
            f"[[frame]]{f', one of {listed}' if listed else ''}, in robot.toml"
        )
    if robot.imu or robot.gravity_input:
        raise RobotError(
            f"robot {robot.name!r}: the wrench of a tool needs the direction of gravity; accepted: "
            "gravity as three numbers, and a base at rest"
        )
    frame = robot.frame(robot.sensor.frame)
    behind = [j for j in robot.movable if frame.joint in path(robot, j.number)[1:]]
    if behind:
        raise RobotError(
            f"{robot.label(behind[0].number)} moves behind the sensor at {plain(frame.name)}, so "
            "the tool is no rigid body; accepted: a robot in which it is held still: "
            f"{fixing(plain(j.name) or str(j.number) for j in behind)}"
        )
    return frame


def _of_wrench(s: Samples) -> Samples:
    """Return the samples with the wrench in place of the torques, and its mask."""
    assert s.wrench is not None  # of a log that was opened for it
    mask = s.mask
    if mask is not None:
        mask = Mask(np.repeat(mask.robot[:, None], _CHANNELS, axis=1), mask.robot)
    return replace(s, tau=s.wrench, mask=mask)


def _band(samples: Sequence[Samples], cutoff: float | None) -> Band:
    """Return the band of the logs, with speeds from positions."""
    rate, comparison = min(1 / s.step for s in samples), comparison_band(samples)
    for s in samples:
        if cutoff is not None:
            require_cutoff(s.name, cutoff, s.step, s.length)
    highest = MARGIN * comparison
    chosen = cutoff or (highest if highest < OPEN * rate else rate / 2)
    return Band(rate, chosen, comparison, "derived")


def _tool_rows(evaluator: Evaluator, log: FilteredLog) -> Rows:
    """Return the equations of the tool in one log, with the columns of its ten parameters."""
    kernel, none = evaluator["tool_wrench"], np.zeros(_CHANNELS)

    def columns(*motion: FloatArray) -> FloatArray:
        return np.stack([kernel(*motion, unit, none) for unit in np.eye(_TOOL)], axis=2)

    y = log.measured
    weight: FloatArray = np.ones(y.shape)
    if log.weight is not None:
        weight = weight * log.free
    correlation = 1 if log.rows.cutoff is None else PER_PERIOD // 2
    extents = (Extent(len(y), correlation),)
    return Rows(names.LINK, log.modelled(columns), y, log.compared_t, weight, extents)


def _with_offsets(rows: Rows, logs: Sequence[FilteredLog]) -> Rows:
    """Return equations of the tool with the columns of offset and drift of each channel and log."""
    of_logs = np.zeros((*rows.y.shape, len(logs), _OF_LOG))
    channel = np.arange(_CHANNELS)
    for k, (at, log) in enumerate(zip(rows.spans, logs, strict=True)):
        ones = np.ones((len(log.t), _CHANNELS))
        late = (log.t - log.t[-1]) / log.samples.length
        of_log = of_logs[at, :, k]
        of_log[:, channel, channel] = log.compared(ones)
        of_log[:, channel, _CHANNELS + channel] = log.compared(ones * late[:, None])
    return rows.with_regressor(np.concatenate([rows.W, of_logs.reshape(*rows.y.shape, -1)], axis=2))


@dataclass(frozen=True, eq=False)
class _Solved:
    """The parameters of tool, offset and drift.

    Attributes:
        tool: the tool.
        offsets, std: offsets and drifts of the logs, with their standard deviations; NaN if the
            logs leave an offset open, or show no drift.
    """

    tool: Load
    offsets: FloatArray
    std: FloatArray

    def turned(self) -> _Solved:
        """Return the solution for the opposite wrench."""
        return replace(self, tool=replace(self.tool, s=-self.tool.s), offsets=-self.offsets)


def _solve(rows: Rows, noise: FloatArray) -> _Solved:
    """Solve the equations. A drift is part of them if it is determined, and beyond chance.

    Args:
        rows: equations of tool, offset and drift.
        noise: (K, 10) noise of the columns of the tool.
    """
    count = rows.W.shape[2]
    logs = (count - _TOOL) // _OF_LOG
    of_log = np.repeat([False, True], _CHANNELS)
    drifts = np.append(np.zeros(_TOOL, dtype=bool), np.tile(of_log, logs))
    used = np.ones(count, dtype=bool)
    used &= ~drifts | ~_is_open(_open_directions(rows, noise, used))
    null = _open_directions(rows, noise, used)
    z, covariance = _least_squares(rows, used, null)
    used &= ~drifts | (np.abs(z) > BEYOND * np.sqrt(np.diag(covariance)))
    null = _open_directions(rows, noise, used)
    z, covariance = _least_squares(rows, used, null)
    unknown = _is_open(null) | ~used
    std = np.sqrt(np.diag(covariance))
    values, std = np.where(unknown, np.nan, [z, std])[:, _TOOL:]
    directions, sizes, _ = np.linalg.svd(null[:_TOOL], full_matrices=False)
    open_ = directions[:, sizes > SMALL]
    return _Solved(Load(z[:_TOOL], covariance[:_TOOL, :_TOOL], open_), values, std)


def _scale(count: int) -> FloatArray:
    """Return the units of the parameters, (p,)."""
    offsets = np.resize(_UNITS_OF_OFFSET, count - _TOOL)
    return np.append(UNITS, offsets)


def _is_open(null: FloatArray) -> Bools:
    """Return the parameters (p,) that take part in an open direction, (p, k)."""
    return np.asarray(np.abs(null).max(axis=1, initial=0.0) > SMALL)


def _open_directions(rows: Rows, noise: FloatArray, used: Bools) -> FloatArray:
    """Return the orthonormal directions that the logs leave open, (p, k), in units of `_scale`.

    Args:
        rows, noise: see `_solve`.
        used: (p,) parameters that are part of the equations.
    """
    count = len(used)
    scale = _scale(count)
    columns = np.concatenate([e.W for e in rows.parts]) * scale
    R = triangle(columns[:, used])
    norms = column_norms(R)
    shaken = np.pad(noise, ((0, 0), (0, count - _TOOL))) * scale
    rounding = SINGULAR * len(norms) * np.eye(len(norms))
    E = triangle(np.concatenate([shaken[:, used] / norms, rounding]))
    directions = null_space(R / norms, E)
    out = np.zeros((count, len(directions)))
    out[used] = (directions / norms).T
    return np.linalg.qr(out)[0]


def _least_squares(rows: Rows, used: Bools, null: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the parameters (p,) in the determined directions, and their covariance (p, p)."""
    from scipy.linalg import null_space as complement

    left_out = np.eye(len(used))[:, ~used]
    V = complement(np.hstack([null, left_out]).T)
    onto = _scale(len(used))[:, None] * V
    solution = Wls().solve(rows.with_regressor(rows.W @ onto))
    return onto @ solution.X, onto @ solution.covariance @ onto.T


def _open_notes(solved: _Solved, frame: Frame) -> list[str]:
    """Return a note on what the logs leave open, if anything.

    Raises:
        IdentificationError: they leave the mass open.
    """
    known = solved.tool.determined()
    open_ = ", ".join(name for name in LABELS if name not in known)
    if "mass" in known:
        how = "more poses show the centre of mass, and motion the inertia"
        return [f"the logs leave {open_} open; {how}"] if open_ else []
    offsets = np.isnan(solved.offsets).reshape(-1, 2, _CHANNELS)[:, 0].any(axis=0)
    channels = ", ".join(np.array(WRENCH)[offsets])
    raise IdentificationError(
        f"the logs leave {open_} and the offsets of {channels} open; accepted: at least three "
        f"poses at rest in which gravity has different directions at {plain(frame.name)}, so not "
        "only poses about one vertical axis"
    )


def _traces(rows: Rows, logs: Sequence[FilteredLog], solved: _Solved) -> tuple[Trace, ...]:
    """Return the wrench of each log without its offset, beside 0 and beside that of the tool."""
    of_tool, of_logs = np.split(rows.W, [_TOOL], axis=2)
    measured = rows.y - of_logs @ np.nan_to_num(solved.offsets)
    model = of_tool @ solved.tool.s
    out = []
    for quantity, predicted in ((WITHOUT, np.zeros(model.shape)), (WITH, model)):
        for log, at in zip(logs, rows.spans, strict=True):
            curves = rows.t[at], measured[at], predicted[at]
            out.append(Trace(log.name, "train", quantity, *curves))
    return tuple(out)


def _force_errors(logs: Sequence[FilteredLog], traces: Sequence[Trace]) -> tuple[float, float]:
    """Return the RMS error of the force over the RMS of the force, and that of noise alone."""
    model = traces[len(logs) :]
    size, error, noise = 0.0, 0.0, 0.0
    for log, trace in zip(logs, model, strict=True):
        size += float(np.sum(trace.measured[:, :3] ** 2))
        error += float(np.sum(trace.residual[:, :3] ** 2))
        noise += len(trace.t) * float(np.sum(_noise(log)[:3] ** 2))
    return math.sqrt(error / size), math.sqrt(noise / size)


def _noise(log: FilteredLog) -> FloatArray:
    """Return the standard deviation of the noise of each channel in the comparison band, (6,)."""
    band = log.rows.cutoff
    if band is None:
        return np.full(_CHANNELS, np.nan)
    above = min(MARGIN * band, 0.25 / log.step)
    high = log.tau - lowpass(log.tau, log.step, above)
    return white_noise(high, log.step, above) * math.sqrt(2 * band * log.step)


def _wrist(solved: _Solved, traces: Sequence[Trace], turned: bool) -> Wrist:
    """Return offset and drift of the last log, and the errors of the channels."""
    pairs = zip(solved.offsets.tolist(), solved.std.tolist(), strict=True)
    quantities = [Quantity(*pair) if np.isfinite(pair[0]) else UNKNOWN for pair in pairs]
    last = quantities[-_OF_LOG:]
    offset, drift = tuple(last[:_CHANNELS]), tuple(last[_CHANNELS:])
    residual = np.concatenate([t.residual for t in traces if t.quantity == WITH])
    return Wrist(offset, drift, tuple(rms(residual).tolist()), turned)
