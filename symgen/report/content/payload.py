"""Content of a payload."""

from __future__ import annotations

from functools import partial

import numpy as np

from symgen.data.raw import WRENCH
from symgen.estimation.floor import noise_accounts
from symgen.identification.load_result import WITH, WITHOUT, Payload, Quantity, Sensor
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    base_rows,
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
    residual, sensor, rows = payload.residual, payload.sensor, []
    for name, q, unit in payload.rows():
        rows.append((name, *_texts(q), unit))
    table = Table(("", "value", "std", "unit"), rows)
    origin, text = _LOAD.format(payload.frame_label), f"Method: {payload.method}."
    load = Section("Load", (origin, text), table, printed=(origin,))
    if sensor is None:
        link = f"the link of {payload.link}" if payload.joint else "its base"
        error, place = "Torque error", f"on {link}"
        figure = partial(_residuals, payload)
        own = [
            Section("Residual with and without the load", (_RESIDUAL,), figure=figure),
            load,
            Section("Torque error by joint", (_ERROR,), _errors(payload), printed=()),
        ]
    else:
        error, place = "Force error", f"behind the sensor at {payload.frame_label}"
        own = [load, *_sensor_sections(payload, sensor)]
    sections = (*own, repairs_section(payload.repairs), *notes_section(payload.notes))
    mass, (value, std) = payload.mass, _texts(payload.mass)
    headline = "The mass is not determined" if mass.value is None else f"Mass: {value} kg"
    if mass.value is not None and mass.std:
        headline += f", standard deviation {std} kg"
    noise = noise_accounts(residual.noise_floor, residual.after)
    text = (
        f"{error}: {percent(residual.before)} without the load in the model, "
        f"{percent(residual.after)} with it; {noise}."
    )
    banner, run = Banner("plain", headline, text), run_lines(payload.band, payload.repairs)
    lead = (f"The load that {payload.robot} carries {place}.",)
    return Content(f"Payload of {payload.robot}", lead, sections, banner, run)


def _texts(q: Quantity) -> tuple[str, str]:
    return value_with_std(q.value, q.std)


def _sensor_sections(payload: Payload, sensor: Sensor) -> list[Section]:
    """Return offset and drift of the sensor, and the load by the joint torques."""
    rows = []
    for (name, unit), offset, drift in zip(_CHANNELS, sensor.offset, sensor.drift, strict=True):
        moved = ("none", "") if drift.value is None else _texts(drift)
        rows.append((name, *_texts(offset), *moved, unit))
    table = Table(("channel", "offset", "std", "drift", "std", "unit"), rows)
    sections = [Section("Sensor", (_SENSOR,), table, printed=())]
    if sensor.torques is not None:
        torques = []
        for (name, ours, unit), theirs in zip(payload.rows(), sensor.torques, strict=True):
            difference = ""
            if ours.value is not None and theirs.value is not None:
                difference = number(ours.value - theirs.value, 3)
            torques.append((name, *_texts(theirs), difference, unit))
        table = Table(("", "by joint torques", "std", "difference", "unit"), torques)
        sections.append(Section("Load by the joint torques", (_BY_TORQUES,), table, printed=()))
    return sections


def _errors(payload: Payload) -> Table:
    """Return the torque error of each joint with and without the load."""
    residual, columns = payload.residual, []
    for ratios in (residual.joints_before, residual.joints_after):
        texts = [percent(ratio) for ratio in ratios]
        if payload.traces:
            measured = np.concatenate([t.measured for t in payload.traces if t.quantity == WITH])
            of_joints = measured[:, measured.shape[1] - len(ratios) :]
            sizes = errors_in_units(payload.joints, of_joints, ratios)
            texts = [f"{error}, {text}" for (_, error), text in zip(sizes, texts, strict=True)]
        columns.append(texts)
    labels = [joint.label for joint in payload.joints]
    rows = [*zip(labels, *columns, strict=True)]
    rows = base_rows(residual.floating or ()) + rows
    rows.append(
        (
            "all" if residual.floating else "all joints",
            percent(residual.before),
            percent(residual.after),
        )
    )
    return Table(("joint", "error without the load", "error with it"), rows)


def _residuals(payload: Payload) -> Figure | None:
    panels = []
    bare, loaded = ([t for t in payload.traces if t.quantity == key] for key in (WITHOUT, WITH))
    for without, t in zip(bare, loaded, strict=False):
        series = {"without the load": without.residual, "with the load": t.residual}
        panels += joint_panels(payload.titles, t.t, series, (t.log, "with the load"))
    return Figure(tuple(panels)) if panels else None
