"""Content of a study."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.raw import FloatArray
from symgen.experiment.study_result import (
    COLUMNS,
    HEADER,
    Precision,
    Study,
    Tried,
    answer,
    duration,
    overview,
    precision_rows,
)
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    notes_section,
    percent,
)
from symgen.report.plots import curves as plots

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_DRAWN = 8  # largest number of parameters in the chart


def study_content(found: Study) -> Content:
    """Return the result, models and methods, parameters, and settings."""
    s, best = found.settings, found.best
    target, title = f"{s.target_percent:g} %", f"Study of {found.robot}"
    lead = (
        f"Accuracy of the parameters of {found.robot}, from {s.runs} simulated runs of "
        f"{duration(s.seconds)}. Each run is identified with {len(found.results)} combinations of "
        "model and method, and compared with the true parameters.",
    )
    if best is None or best.torque_error is None:
        banner = Banner("bad", "not determined", "No run determines the parameters.", found.notes)
        return Content(title, lead, (_settings(found),), banner)
    facts = (
        ("torque error of held-out motion", percent(best.torque_error)),
        ("coverage of 95 % intervals", percent(best.coverage)),
    )
    banner = Banner("plain", best.name, f"{answer(found, best)}.", facts=facts)
    ways = (
        "The torque error is that on a motion without noise that no run has. The next columns "
        f"count the parameters within {target} of the true value: after {duration(s.seconds)}, "
        "after any time, and never, because the bias alone is larger. Coverage is how often the "
        "95 % interval contains the true value, mean over the parameters."
    )
    parameters = (
        "Bias and std are relative to the true value. Stated std is the mean that the estimates "
        f"state. Record is the time until the parameter is within {target}, if std falls as "
        f"1 / √time.{_falls(found, best)}"
    )
    sections = (
        Section(
            "Models and methods",
            (ways,),
            Table(HEADER, overview(found)),
            told=(f"parameters within {target} of the true value",),
        ),
        *_chart(found, best),
        Section(
            f"Parameters: {best.name}",
            (parameters,),
            Table(COLUMNS, precision_rows(best)),
            told=("bias and std are relative to the true value",),
        ),
        *_lengths(found),
        _settings(found),
        *notes_section(found.notes),
    )
    return Content(title, lead, sections, banner)


def _falls(found: Study, best: Tried) -> str:
    """Return a text on how std falls with the recorded time."""
    pairs = zip(found.settings.lengths, best.std_ratio_by_length, strict=False)
    told = [f"{ratio:.2f} for {m} times ({m**-0.5:.2f})" for m, ratio in pairs if m > 1]
    if not told:
        return ""
    return f" Measured std of longer recordings over that of one (expected): {', '.join(told)}."


def _chart(found: Study, best: Tried) -> list[Section]:
    """Draw the error of the slowest parameters over the recorded time."""
    s = found.settings
    known = sorted((p for p in best.parameters if p.known), key=_needed)[-_DRAWN:]
    if not known:
        return []
    text = (
        f"The {len(known)} known parameters that take longest. The error is the root mean square "
        "of bias and std, relative to the value. Dots are simulated. Lines follow std / √time. The "
        f"dashed line is {s.target_percent:g} %."
    )
    return [Section("How long to record", (text,), figure=partial(_courses, found, known))]


def _courses(found: Study, known: list[Precision]) -> Figure:
    s, shown = found.settings, known[::-1]
    longest = max([4 * s.seconds, *(1.5 * (p.seconds or 0.0) for p in known)])
    T = np.geomspace(s.seconds, longest, 60)
    series = {p.name: 100 * _error(p, T / s.seconds) for p in shown}
    figure = plots.lines(
        T, series, title="Error", xlabel="recorded, s", ylabel="error, %", height=460
    )
    for k, p in enumerate(shown):
        std = np.array(p.std_by_length)
        figure.add_scatter(
            x=s.seconds * np.array(s.lengths[: len(std)]),
            y=100 * np.hypot(std, _floor(p)) / abs(p.value),
            mode="markers",
            marker={"color": plots.line_style(k)["color"], "size": 7},
            name=plots.plain(p.name),
            showlegend=False,
        )
    ticks = {"type": "log", "dtick": "D2", "tickformat": "~g"}  # ticks at 1, 2, 5
    figure.update_xaxes(**ticks).update_yaxes(**ticks)
    return figure.add_hline(
        y=s.target_percent, line={"color": plots.INK, "width": 1, "dash": "dash"}
    )


def _floor(p: Precision) -> float:
    """Return the bias that does not fall with the recorded time."""
    return p.bias if p.seconds is None else 0.0


def _error(p: Precision, times: FloatArray) -> FloatArray:
    return np.hypot(p.std / np.sqrt(times), _floor(p)) / abs(p.value)


def _needed(p: Precision) -> float:
    return np.inf if p.seconds is None else p.seconds


def _lengths(found: Study) -> list[Section]:
    """Return the time that each parameter needs, by model and method."""
    text = (
        f"How long must be recorded until a parameter is within "
        f"{found.settings.target_percent:g} %."
    )
    models: dict[str, list[Tried]] = {}
    for r in found.results:
        models.setdefault(r.model, []).append(r)
    out = []
    for model, ways in models.items():
        shown = [r for r in ways if r.parameters]
        rows = [
            (own[0].name, *(duration(p.seconds) for p in own))
            for own in zip(*(r.parameters for r in shown), strict=True)
        ]
        table = Table(("name", *(r.method for r in shown)), rows)
        out.append(Section(f"By the model of {model}", (text,), table))
    return out


def _settings(found: Study) -> Section:
    """Return the settings of the study."""
    s, shown = found.settings, found.settings.recording
    instruments = {k.replace("_", " "): v for k, v in vars(shown.instruments).items()}
    rows = [
        ("motions", ", ".join(s.trajectories)),
        ("held-out motion", s.held_out),
        ("rate of the logs", f"{s.rate_hz:.4g} Hz"),
        ("windows", f"{s.window_s:g} s"),
        *((name, f"{float(value):g}") for name, value in instruments.items()),
        ("controller", f"{shown.controller.kind}, {shown.controller.bandwidth:g} rad/s"),
        ("disturbance", str(shown.disturbance)),
        *((f"band of {r.name}", r.band.in_words()) for r in found.results),
        ("seed", str(s.seed)),
    ]
    return Section("Settings", (), Table(("", ""), rows))
