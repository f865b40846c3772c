"""Content of the example of Gautier and Khalil (1988): our errors and those of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from symgen.codegen.kernels import Kernel
from symgen.data.raw import FloatArray
from symgen.experiment import paper
from symgen.experiment.paper import Reproduction, Setup
from symgen.experiment.reference import SAMPLES, STEP
from symgen.report.content.parts import Banner, Content, Section, Table, frames_section
from symgen.report.plots import curves as plots
from symgen.robot.expressions import text

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_COLUMNS = (
    "5 %, median and 95 % are quantiles of the relative error after 100 samples; the paper reports "
    "the error of one run, and the last column but one tells how many of ours are below it."
)


def demo_content(found: Reproduction) -> Content:
    """Return the canonical model, the errors of both set-ups, and the open points."""
    model = found.evaluator.model
    pairs = zip(model.base.parameters, closed_form(model.kernels[0]), strict=True)
    canonical = Table(
        ("parameter", "formula", "column DL"),
        tuple((p.name, p.expression, column) for p, column in pairs),
    )
    spline, online = found.exact
    exact = (
        f"Without noise: X is returned to {spline:.1e} (spline integrals, 0.62 s windows) and "
        f"{online:.1e} (on line)"
    )
    told = (f"evaluated by: {found.evaluator.backend}", exact)
    kinds = zip(("without noise", "with noise"), found.hidden, strict=True)
    hidden = (f"{kind}: not determined: {', '.join(names) or 'nothing'}" for kind, names in kinds)
    still = ("Joint speeds proportional to each other, as the paper warns:", *hidden)
    sections = (
        Section("Canonical model", (exact,), canonical, told=told),
        *(section for s in found.setups for section in _sections(s)),
        Section("Proportional speeds", still, told=still),
        frames_section(model.robot),
    )
    lead = (
        "In 1988 M. Gautier and W. Khalil showed that a robot's energy gives its inertial "
        "parameters without any acceleration, on a simulated arm of two joints. This page does it "
        f"again: {found.count} seeded runs of each of their set-ups, {SAMPLES} samples of "
        f"{STEP} s, with the noise that they had.",
    )
    title = "The example of Gautier and Khalil (1988)"
    return Content(title, lead, sections, _banner(found))


def closed_form(kernel: Kernel) -> tuple[str, ...]:
    """Return the outputs of a small kernel as formulas: steps are substituted, not expanded."""
    known: dict[sp.Symbol, sp.Expr] = dict(kernel.tape.constants)
    for symbol, expr in kernel.tape.steps:
        known[symbol] = expr.subs(known)
    return tuple(text(sp.factor_terms(out.subs(known))) for out in kernel.tape.outputs)


def _errors(s: Setup) -> Table:
    """Compare the estimates of all runs with the paper's errors."""
    rows = []
    for name, case in s.summary().items():
        true, mean, error, ours, below = case.values()
        rows.append((
            *(name, f"{true:g}", f"{mean:.5f}"),
            *(f"{x:.1e}" for x in (error, *ours.values())),
            *(f"{100 * below:.0f} %", f"{mean / true - 1:+.1e}"),
        ))  # fmt: skip
    header = ("parameter", "true", "mean", "paper's error", "5 %", "median", "95 %")
    return Table((*header, "runs below the paper", "bias"), rows)


def _banner(found: Reproduction) -> Banner:
    """Return whether the paper's errors lie within 95 % of our runs."""
    cases = {
        f"{name} in set-up ({s.letter})": (
            case["paper_relative_error"],
            case["relative_error_quantiles"],
        )
        for s in found.setups
        for name, case in s.summary().items()
    }
    # The paper reports the run of set-up (b); an error above all of ours is a difference.
    beyond = [where for where, (error, ours) in cases.items() if error > ours["0.95"]]
    facts = (
        ("base parameters", f"{len(paper.NAMES)} of 20"),
        ("median error, at most", f"{100 * max(ours['0.5'] for _, ours in cases.values()):.2g} %"),
        ("runs of each set-up", str(found.count)),
    )
    if beyond:
        text = f"Beyond 95 % of our runs are the paper's errors of {', '.join(beyond)}."
        return Banner("warn", "differs", text, facts=facts)
    text = (
        f"The errors that the paper reports for its one run lie within 95 % of our {found.count}."
    )
    return Banner("good", "reproduced", text, facts=facts)


def _sections(s: Setup) -> list[Section]:
    runs, words = s.runs, s.words
    half = np.abs(s.history[:, 50 - paper.FIRST] / paper.X_TRUE - 1)
    inside = zip(paper.NAMES, 100 * np.mean(half < 0.1, axis=0), strict=True)
    listed = ", ".join(f"{name} {share:.0f} %" for name, share in inside)
    within = f"Within 10 % of the truth after 50 samples: {listed} of {len(half)} runs"
    return [
        Section(
            f"Set-up ({s.letter})",
            (f"{words[:1].upper()}{words[1:]}. Drawn is the first run. {_COLUMNS}",),
            _errors(s),
            partial(
                _motion, runs.t, {"q, rad": runs.q, "qd, rad/s": runs.qd, "tau, N m": runs.tau}
            ),
            told=(words, within),
        ),
        Section(
            f"Set-up ({s.letter}): convergence",
            (f"The recursive estimate of the first run; the band holds 90 % of them. {within}.",),
            figure=partial(_courses, s),
        ),
    ]


def _motion(t: FloatArray, shown: Mapping[str, FloatArray]) -> Figure:
    panels = [
        plots.Panel(label.split(",")[0], t, {f"joint {j + 1}": y[0, :, j] for j in range(2)}, label)
        for label, y in shown.items()
    ]
    return plots.line_grid(panels, title="Motion and torque")


def _courses(s: Setup) -> Figure:
    t, history = s.runs.t[paper.FIRST :], s.history / paper.X_TRUE
    low, high = np.quantile(history, [0.05, 0.95], axis=0)
    panels = [
        plots.Panel(
            name,
            t,
            {"first run": history[0, :, i]},
            f"{name} over its true value",
            level=1.0,
            band=(low[:, i], high[:, i]),
        )
        for i, name in enumerate(paper.NAMES)
    ]
    figure = plots.line_grid(panels, title="Recursive estimate", columns=2)
    return figure.update_yaxes(range=[0.5, 1.5])
