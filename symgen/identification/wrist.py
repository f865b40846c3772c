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
from typing import Any

import numpy as np

from symgen.data.mask import Mask
from symgen.data.raw import WRENCH, Places, Reading
from symgen.data.signals import (
    MARGIN,
    OPEN,
    Samples,
    comparison_band,
    noise_of_differences,
)
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.band import Band
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source, require_other_data
from symgen.estimation.system import Extent, Rows, join
from symgen.estimation.torque_error import equation_residual, percent
from symgen.estimation.values import FloatArray
from symgen.faults.repair import open_logs
from symgen.identification.load import COM, LABELS, UNITS
from symgen.identification.load_problem import LoadSystem, Solved, shown_directions
from symgen.identification.load_result import (
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
_POSES = (
    "at least three poses at rest in which gravity has other directions in the frame of the "
    "sensor, so not poses about one vertical axis alone"
)
_TURNED = (
    "the sensor reports what the tool exerts on the arm, as the fit gave a negative mass: its "
    "wrench was multiplied by -1, and the offsets are those of the result"
)


def payload_by_wrench(
    robot: Robot,
    sources: Sequence[Source],
    reading: Reading | None,
    progress: Say,
) -> Payload:
    """Identify the tool behind the sensor of a robot.

    Args:
        robot: the robot, with [sensor].
        sources: the logs, with the wrench.
        reading: options of reading and masking.
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
    wanted = reading or Reading()
    with_wrench = replace(wanted, wrench=True)
    opened, repairs = open_logs((sources, ()), robot, with_wrench, progress)
    samples = [_of_wrench(s) for s in opened[0]]
    require_other_data(samples, [])
    rate = min(1 / s.step for s in samples)
    comparison = comparison_band(samples)
    cutoff = min(MARGIN * comparison, OPEN * rate)
    band = Band(rate, cutoff, comparison, "derived")
    logs = [filter_log(s, band) for s in samples]
    progress("deriving and compiling the model")
    text = robot_toml(robot)
    kernel = load_model(text, ("tool_wrench",))["tool_wrench"]
    progress("solving")
    places = np.eye(len(logs))
    equations = map(partial(_equations, kernel), places, logs)
    rows = join([*equations])
    alone = partial(_equations, kernel, np.ones(1))
    noise = noise_columns(alone, logs)[:, :_TOOL]
    solved = _with_drifts(rows, noise)
    tool = solved.load()
    deviation = math.sqrt(tool.covariance[-1, -1])
    turned = bool(tool.s[-1] < -BEYOND * deviation)
    if turned:
        solved = _with_drifts(replace(rows, y=-rows.y), noise)
        tool = solved.load()
    require_mass(tool, robot.label(frame.joint), _POSES)
    notes = [note for s in samples for note in s.notes]
    known = tool.determined()
    left = [name for name in LABELS if name not in known]
    if left:
        notes.append(
            f"{', '.join(left)} stay open: more poses show the centre, and motion the inertia"
        )
    if turned:
        notes.append(_TURNED)
    offset, drift = _offsets(solved)
    if not {*COM}.isdisjoint(left):
        offset[3:] = [Quantity()] * 3
    nearest = tool.nearest().s.tolist()
    return payload_of(
        tool,
        None,
        None,
        tuple(notes),
        robot=robot.name,
        frame=frame.name,
        residual=_errors(logs, solved),
        method="weighted least squares of the wrench of the sensor",
        band=band,
        repairs=tuple(repairs),
        joints=(),
        joint=frame.joint,
        sensor=Sensor(tuple(offset), tuple(drift), turned, tuple(nearest)),
    )


def _of_wrench(s: Samples) -> Samples:
    """Return the samples with the wrench in place of the torques, and one mask for its channels."""
    assert s.wrench is not None  # of a log that was opened for it
    mask = s.mask and Mask(s.mask.robot[:, None], s.mask.robot)
    return replace(s, tau=s.wrench, mask=mask)


def _equations(kernel: Any, place: FloatArray, log: FilteredLog) -> Rows:
    """Return the equations of a log: columns of the tool, then offsets and drifts of each log.

    Args:
        kernel: the kernel tool_wrench.
        place: (L,) 1 for this log, and 0 for the other ones.
        log: the log.
    """
    none = np.zeros(_CHANNELS)

    def columns(*motion: FloatArray) -> FloatArray:
        parts = [kernel(*motion, unit, none) for unit in np.eye(_TOOL)]
        return np.stack(parts, axis=2)

    one = np.ones((len(log.t), 1))
    late = (log.t[:, None] - log.t[-1]) / log.samples.length
    factors = [one, late, 1 + late, 1 + 2 * late]
    stacked = np.stack(factors, axis=2)
    shapes = log.compared(np.cumprod(stacked, axis=2))
    of_logs = np.kron(place, shapes)
    of_channels = np.kron(of_logs, np.eye(_CHANNELS))
    W = np.concatenate([log.at_nodes().modelled(columns), of_channels], axis=2)
    y, weight = log.measured, log.rest_weight(log.resting) * log.free
    extent = Extent(len(y), PER_PERIOD // 2)
    return Rows((), W, y, log.compared_t, weight, (extent,)).with_regressor(W)


def _with_drifts(rows: Rows, noise: FloatArray) -> Solved:
    """Fit tool and offsets, with the drifts that are beyond chance.

    Drifts are left out if they would leave more of the tool open.

    Args:
        rows: the equations.
        noise: (K, 10) noise of the columns of the tool.
    """
    count = rows.W.shape[2] - _TOOL
    shape = np.arange(count) // _CHANNELS % _SHAPES
    places, constant = _TOOL + np.arange(count), shape == 0
    still = _solved(rows, noise, places[constant])
    drifting = _solved(rows, noise, places)
    directions = len(drifting.a)
    if directions < len(still.a):
        return still
    std = drifting.solution.std[directions:]
    beyond = np.abs(drifting.X[places]) > BEYOND * std
    return _solved(rows, noise, places[constant | beyond])


def _solved(rows: Rows, noise: FloatArray, others: Places) -> Solved:
    """Fit the tool and some of the offsets and drifts.

    A direction of the tool stays open if its columns, without their part in those of the offsets,
    do not exceed the noise of the positions.
    """
    columns = rows.W[rows.weight > 0]
    of_tool = columns[:, :_TOOL] * UNITS
    of_others = columns[:, others]
    shares, *_ = np.linalg.lstsq(of_others, of_tool, rcond=None)
    V = shown_directions(of_tool - of_others @ shares, noise * UNITS)
    none = np.zeros(columns.shape[1])
    onto, known = np.eye(len(none), _TOOL), none[:_TOOL]
    loaded = np.ones((1, 1))
    system = LoadSystem(rows, loaded, onto, V, known, others.tolist())
    return system.step(none, np.zeros(len(V.T)))


def _offsets(solved: Solved) -> tuple[list[Quantity], list[Quantity]]:
    """Return offset and drift of each channel in the last log."""
    std, first = np.zeros(len(solved.X)), len(solved.a)
    std[solved.problem.free] = solved.solution.std[first:]
    pairs = zip(solved.X.tolist(), std.tolist(), strict=True)
    quantities = [Quantity(x, deviation) if deviation else Quantity() for x, deviation in pairs]
    last = quantities[-_SHAPES * _CHANNELS :]
    return last[:_CHANNELS], last[_CHANNELS : 2 * _CHANNELS]


def _errors(logs: Sequence[FilteredLog], solved: Solved) -> LoadErrors:
    """Return the RMS error of the force over the RMS of the force, and that of noise alone.

    Raises:
        IdentificationError: the tool is no rigid body.
    """
    rows, tool = solved.problem.rows, solved.problem.in_X(solved.a)
    of_logs = rows.W @ solved.X
    alone = replace(rows, y=rows.y - of_logs)
    forces = [part for part in alone.parts if part.joint in range(3)]
    relative = equation_residual(forces, tool).relative
    noise = 0.0
    for log in logs:
        white = noise_of_differences(log.tau[:, :3])
        passed = 2 * log.band.comparison_hz * log.step
        noise += len(log.kept) * passed * float(white @ white)
    size = sum(part.square for part in forces)
    floor = math.sqrt(noise / size)
    if relative > max(ACCEPT, NOISES * floor):
        raise IdentificationError(
            f"the wrench is not that of a rigid tool: {percent(relative)} of its force remains; "
            "accepted: a [[frame]] with the axes of the sensor, the gravity of the robot file, and "
            "logs without contact and without moving fingers"
        )
    return LoadErrors(1.0, relative, floor, (), ())
