"""Content of a payload."""

from __future__ import annotations

from functools import partial

import numpy as np

from symgen.data.raw import WRENCH
from symgen.estimation.floor import noise_accounts
from symgen.identification.load_result import WITH, WITHOUT, Payload, Sensor
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    errors_in_units,
    notes_section,
    number,
    percent,
    repairs_section,
    run_lines,
    value_with_std,
)
from symgen.report.plots.figure import Figure, joint_panels

_LOAD = (
    "cx, cy and cz are in the frame of {}. The inertia is about the centre of mass, in the axes of "
    "this frame."
)
_ERROR = (
    "The error is the RMS of measured minus modelled torque of joints in motion, on the logs with "
    "the load. The percentage is its ratio to the RMS of the measured torque."
)
_RESIDUAL = (
    "Measured minus modelled torque of the logs with the load. Without the load in the model, the "
    "residual contains the torque of the load."
)


_SENSOR = (
    "The offset of each channel is that at the end of the last log; the drift is its change over "
    "this log, if it has any."
)
_BY_TORQUES = (
    "The load by the joint torques of the same logs, and the load by the sensor minus this one."
)
_CHANNELS = tuple(zip(WRENCH, ("N", "N", "N", "N m", "N m", "N m"), strict=True))


def payload_content(payload: Payload) -> Content:
    """Return the load with its precision, the error with and without it, and notes."""
    residual, sensor = payload.residual, payload.sensor
    rows = [(name, *value_with_std(q.value, q.std), unit) for name, q, unit in payload.rows()]
    table = Table(("", "value", "std", "unit"), rows)
    origin, text = _LOAD.format(payload.frame_label), f"Method: {payload.method}."
    load = Section("Load", (origin, text), table, printed=(origin,))
    noise = noise_accounts(residual.noise_floor, residual.after)
    if sensor is None:
        lead = f"The load that {payload.robot} carries on the link of {payload.link}."
        own: tuple[Section, ...] = (
            Section(
                "Residual with and without the load",
                (_RESIDUAL,),
                figure=partial(_residuals, payload),
            ),
            load,
            Section("Torque error by joint", (_ERROR,), _errors(payload), printed=()),
        )
        text = (
            f"Torque error: {percent(residual.before)} without the load in the model, "
            f"{percent(residual.after)} with it; {noise}."
        )
    else:
        lead = f"The tool of {payload.robot} behind the sensor at {payload.frame_label}."
        own = (load, *_sensor_sections(payload, sensor))
        text = f"{percent(residual.after)} of the force remains without offset and tool; {noise}."
    sections = (*own, repairs_section(payload.repairs), *notes_section(payload.notes))
    mass, (value, std) = payload.mass, value_with_std(payload.mass.value, payload.mass.std)
    headline = "The mass is not determined" if mass.value is None else f"Mass: {value} kg"
    if mass.value is not None and mass.std:
        headline += f", standard deviation {std} kg"
    banner, run = Banner("plain", headline, text), run_lines(payload.band, payload.repairs)
    return Content(f"Payload of {payload.robot}", (lead,), sections, banner, run)


def _sensor_sections(payload: Payload, sensor: Sensor) -> tuple[Section, ...]:
    """Return the load by the joint torques, offset and drift of the sensor, and its residual."""
    channels, torques = [], []
    for (name, unit), offset, drift in zip(_CHANNELS, sensor.offset, sensor.drift, strict=True):
        moved = value_with_std(drift.value, drift.std) if drift.std else ("none", "")
        channels.append((name, *value_with_std(offset.value, offset.std), *moved, unit))
    for (name, ours, unit), theirs in zip(payload.rows(), sensor.torques or (), strict=False):
        difference = ""
        if ours.value is not None and theirs.value is not None:
            difference = number(ours.value - theirs.value, 3)
        torques.append((name, *value_with_std(theirs.value, theirs.std), difference, unit))
    table = Table(("channel", "offset", "std", "drift", "std", "unit"), channels)
    beside = Table(("", "by joint torques", "std", "difference", "unit"), torques)
    return (
        Section("Load by the joint torques", (_BY_TORQUES,), beside, printed=()),
        Section("Sensor", (_SENSOR,), table, printed=()),
        Section("Residual of the wrench", figure=partial(_wrenches, payload)),
    )


def _wrenches(payload: Payload) -> Figure | None:
    """Return the wrench without the offset, with and without the tool."""
    panels, titles = [], [f"{name}, {unit}" for name, unit in _CHANNELS]
    for t in payload.traces:
        series = {"without the tool": t.measured, "with the tool": t.residual}
        panels += joint_panels(titles, t.t, series, (t.log, "with the tool"))
    return Figure(tuple(panels)) if panels else None


def _errors(payload: Payload) -> Table:
    """Return the torque error of each joint with and without the load."""
    residual, columns = payload.residual, []
    for ratios in (residual.joints_before, residual.joints_after):
        texts = [percent(ratio) for ratio in ratios]
        if payload.traces:
            measured = np.concatenate([t.measured for t in payload.traces if t.quantity == WITH])
            sizes = errors_in_units(payload.joints, measured, ratios)
            texts = [f"{error}, {text}" for (_, error), text in zip(sizes, texts, strict=True)]
        columns.append(texts)
    labels = [joint.label for joint in payload.joints]
    rows = [*zip(labels, *columns, strict=True)]
    rows.append(("all joints", percent(residual.before), percent(residual.after)))
    return Table(("joint", "error without the load", "error with it"), rows)


def _residuals(payload: Payload) -> Figure | None:
    panels, titles = [], [joint.torque for joint in payload.joints]
    bare, loaded = ([t for t in payload.traces if t.quantity == key] for key in (WITHOUT, WITH))
    for without, t in zip(bare, loaded, strict=False):
        series = {"without the load": without.residual, "with the load": t.residual}
        panels += joint_panels(titles, t.t, series, (t.log, "with the load"))
    return Figure(tuple(panels)) if panels else None
