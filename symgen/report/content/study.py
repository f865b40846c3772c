"""What is said of a study."""

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

_DRAWN = 8  # parameters of the chart


def study_content(found: Study) -> Content:
    """Return the answer, models and methods beside each other, parameters, settings."""
    s, best = found.settings, found.best
    target, title = f"{s.target_percent:g} %", f"Study of {found.robot}"
    lead = (
        f"What logs of these motions and sensors tell of {found.robot}: {s.runs} simulated runs of "
        f"{duration(s.seconds)}, each identified by {len(found.results)} ways and compared with "
        "the parameters that it was made of.",
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
        "Torque error: along a motion without noise that no run had. At once, in the end: "
        f"parameters within {target} after {duration(s.seconds)}, and after any time; never: those "
        "whose bias alone is larger. Coverage: how often the interval of 95 % held the truth, mean "
        "over the parameters."
    )
    parameters = (
        "Bias and std over the true value; std says: what the estimates say of their own std. "
        f"Record: until the parameter is within {target}, since std falls as the square root of "
        f"the time.{_falls(found, best)}"
    )
    sections = (
        Section(
            "Models and methods",
            (ways,),
            Table(HEADER, overview(found)),
            told=(f"at once, in the end, never: parameters within {target}",),
        ),
        *_chart(found, best),
        Section(
            f"Parameters: {best.name}",
            (parameters,),
            Table(COLUMNS, precision_rows(best)),
            told=("bias and std over the true value",),
        ),
        *_lengths(found),
        _settings(found),
        *notes_section(found.notes),
    )
    return Content(title, lead, sections, banner)


def _falls(found: Study, best: Tried) -> str:
    """Say what was measured of std at other lengths."""
    pairs = zip(found.settings.lengths, best.std_ratio_by_length, strict=False)
    told = [f"{ratio:.2f} recorded {m} times ({m**-0.5:.2f})" for m, ratio in pairs if m > 1]
    if not told:
        return ""
    return f" Measured, with what is expected: of the std recorded once {', '.join(told)} is left."


def _chart(found: Study, best: Tried) -> list[Section]:
    """The error of the parameters that take longest over the time that is recorded."""
    s = found.settings
    known = sorted((p for p in best.parameters if p.known), key=_needed)[-_DRAWN:]
    if not known:
        return []
    text = (
        f"Of the known parameters the {len(known)} that take longest: root mean square error over "
        "the value, bias and std together. Dots are simulated, lines follow std / √time, the "
        f"dashed one is {s.target_percent:g} %."
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
    ticks = {"type": "log", "dtick": "D2", "tickformat": "~g"}  # 1, 2, 5: some on any range
    figure.update_xaxes(**ticks).update_yaxes(**ticks)
    return figure.add_hline(
        y=s.target_percent, line={"color": plots.INK, "width": 1, "dash": "dash"}
    )


def _floor(p: Precision) -> float:
    """Return the bias that stays; what recording takes away is no floor."""
    return p.bias if p.seconds is None else 0.0


def _error(p: Precision, times: FloatArray) -> FloatArray:
    return np.hypot(p.std / np.sqrt(times), _floor(p)) / abs(p.value)


def _needed(p: Precision) -> float:
    return np.inf if p.seconds is None else p.seconds


def _lengths(found: Study) -> list[Section]:
    """Return the time that every parameter needs, by every model and method."""
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
    """Return what the study was made with."""
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
