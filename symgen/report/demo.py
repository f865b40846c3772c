"""symgen demo: the example of Gautier and Khalil (1988), from its table to its figures.

Derives the canonical model, compiles it, simulates the noisy measurements, identifies recursively
and says where the paper's errors fall in the distribution of seeded runs.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen.codegen.casadi_model import dynamics
from symgen.codegen.kernels import Kernel
from symgen.codegen.model import derive
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.errors import IdentificationError
from symgen.estimation.batch import solve
from symgen.estimation.filtered import unfiltered
from symgen.estimation.system import LinearSystem, energy_equations
from symgen.experiment import paper
from symgen.files import check_replaceable, write_folder
from symgen.identification.online.identifier import Identifier
from symgen.identification.workflow import identify
from symgen.report.content.parts import Banner, Content, Section, Table, frames_section
from symgen.report.html import page
from symgen.report.plots import curves as plots
from symgen.robot.expressions import text
from symgen.robot.toml_io import read_robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
_SEED = 1988
_COLUMNS = (
    "5 %, median and 95 % are quantiles of the relative error after 100 samples; the paper reports "
    "the error of one run, and the last column but one tells how many of ours are below it."
)
_SHOWN = 16  # the first samples determine little: convergence is drawn from here on
# Runs whose way to the result is followed, sample by sample.
_DRAWN = {"c": 200, "casadi": 50}
#: Names of the files.
_MARKER, PAGE = "demo.json", "demo.html"


def run_demo(folder: Path, runs: int, say: Callable[[str], None]) -> Content:
    """Run the example, write its page, and return what is said of it.

    Args:
        folder: gets demo.html and demo.json, whole or not at all.
        runs: seeded runs of each set-up.
        say: is told what is being done.

    Raises:
        PackageError: the folder holds something else.
    """
    check_replaceable(folder, _MARKER)
    model = derive(read_robot("planar2r"))
    say("compiling the model")
    evaluator, simulated = load(model), dynamics(model)
    columns = closed_form(model.kernels[0])
    pairs = zip(model.base.parameters, columns, strict=True)
    canonical = Table(
        ("parameter", "formula", "column DL"),
        tuple((p.name, p.expression, column) for p, column in pairs),
    )
    exact = _exact_block(evaluator, paper.exact_run(simulated))
    told = (f"evaluated by: {evaluator.backend}", exact)
    sections = [Section("Canonical model", (exact,), canonical, told=told)]
    summary: dict[str, Any] = {"schema": "symgen.demo/1", "runs": runs, "seed": _SEED}
    logs: dict[str, bytes] = {}
    for letter, words, simulate in (
        ("a", "the robot follows the reference, the measurements are noisy", paper.setup_a),
        (
            "b",
            f"torques computed from X_d = {paper.WRONG:g} X, noise of "
            f"{100 * paper.TORQUE_NOISE:g} % of RMS torque, drive a simulated robot",
            paper.setup_b,
        ),
    ):
        say(f"({letter}) {runs} seeded runs of this set-up")
        measured = simulate(simulated, runs, _SEED)
        followed = min(runs, _DRAWN[evaluator.backend])
        history = np.array([_recursive(evaluator, measured, k) for k in range(followed)])
        final = [*history[:, -1], *(_last(evaluator, measured, k) for k in range(followed, runs))]
        finals = np.array(final)
        summary[letter] = _summary(finals)
        logs |= {f"setup_{letter}_{k + 1}.csv": _csv(measured, k) for k in range(2)}
        sections += _sections(letter, words, measured, history, _errors(finals))
    still = [paper.proportional_run(simulated, noise) for noise in (None, 1)]
    refused = tuple(map(partial(_refused, evaluator), still, ("without noise", "with noise")))
    text = ("Joint speeds proportional to each other, as the paper warns:", *refused)
    sections += [Section("Proportional speeds", text, told=text), frames_section(model.robot)]
    lead = (
        "In 1988 M. Gautier and W. Khalil showed that a robot's energy gives its inertial "
        "parameters without any acceleration, on a simulated arm of two joints. This page does it "
        f"again: {runs} seeded runs of each of their set-ups, {paper.SAMPLES} samples of "
        f"{paper.STEP} s, with the noise that they had.",
    )
    title = "The example of Gautier and Khalil (1988)"
    content = Content(title, lead, tuple(sections), _banner(summary, runs))
    files = {PAGE: page(content), _MARKER: json.dumps(summary, indent=1) + "\n"}
    write_folder(folder, {k: v.encode() for k, v in files.items()} | logs, _MARKER)
    return content


def closed_form(kernel: Kernel) -> tuple[str, ...]:
    """Return the outputs of a small kernel written out: steps put into each other, not expanded."""
    known: dict[sp.Symbol, sp.Expr] = {}
    for symbol, value in kernel.tape.constants:
        known[symbol] = value
    for symbol, expr in kernel.tape.steps:
        known[symbol] = expr.subs(known)
    return tuple(text(sp.factor_terms(out.subs(known))) for out in kernel.tape.outputs)


def _recursive(evaluator: Evaluator, runs: paper.Runs, k: int) -> FloatArray:
    """Return the estimate after each sample of run k, (N, 4); NaN while it is undetermined."""
    identifier = Identifier(evaluator, mode="start")
    out = np.full((len(runs.t), len(paper.X_TRUE)), np.nan)
    for i, t in enumerate(runs.t):
        identifier.step(runs.q[k, i], runs.qd[k, i], runs.tau[k, i], float(t))
        if i >= 5:
            try:
                out[i] = identifier.read()[0]
            except IdentificationError:
                continue
    return out


def _last(evaluator: Evaluator, runs: paper.Runs, k: int) -> FloatArray:
    """Return the recursive estimate after all samples of run k, (4,)."""
    identifier = Identifier(evaluator, mode="start")
    identifier.run(runs.t, runs.q[k], runs.qd[k], runs.tau[k])
    return identifier.read()[0]


def _exact_block(evaluator: Evaluator, exact: paper.Runs) -> str:
    log = make_log("exact", exact.t, exact.q[0], exact.tau[0], exact.qd[0])
    equations = energy_equations(evaluator, unfiltered(sampled(log)), 10 * paper.STEP)
    spline = solve(LinearSystem(evaluator.model.base.names, (equations,))).X
    online = _recursive(evaluator, exact, 0)[-1]
    worst = [float(np.abs(X / paper.X_TRUE - 1).max()) for X in (spline, online)]
    return (
        f"Without noise: X is returned to {worst[0]:.1e} (spline integrals, 0.62 s windows) and "
        f"{worst[1]:.1e} (on line)"
    )


def _errors(final: FloatArray) -> Table:
    """Compare the estimates of all runs, (runs, 4), with the paper's errors."""
    error = np.abs(final / paper.X_TRUE - 1)
    bias = final.mean(axis=0) / paper.X_TRUE - 1
    low, median, high = np.quantile(error, [0.05, 0.5, 0.95], axis=0)
    rows = tuple(
        (
            name,
            f"{paper.X_TRUE[i]:g}",
            f"{final[:, i].mean():.5f}",
            f"{paper.PAPER_ERRORS[i]:.1e}",
            f"{low[i]:.1e}",
            f"{median[i]:.1e}",
            f"{high[i]:.1e}",
            f"{100 * np.mean(error[:, i] < paper.PAPER_ERRORS[i]):.0f} %",
            f"{bias[i]:+.1e}",
        )
        for i, name in enumerate(paper.NAMES)
    )
    header = (
        "parameter",
        "true",
        "mean",
        "paper's error",
        "5 %",
        "median",
        "95 %",
        "runs below the paper",
        "bias",
    )
    return Table(header, rows)


def _summary(final: FloatArray) -> dict[str, Any]:
    """Return the table's numbers as numbers, for demo.json."""
    error = np.abs(final / paper.X_TRUE - 1)
    return {
        name: {
            "true": float(paper.X_TRUE[i]),
            "mean": float(final[:, i].mean()),
            "paper_relative_error": float(paper.PAPER_ERRORS[i]),
            "relative_error_quantiles": {
                str(level): float(np.quantile(error[:, i], level)) for level in (0.05, 0.5, 0.95)
            },
            "share_below_paper": float(np.mean(error[:, i] < paper.PAPER_ERRORS[i])),
        }
        for i, name in enumerate(paper.NAMES)
    }


def _banner(summary: dict[str, Any], runs: int) -> Banner:
    """Whether the paper's errors are ones that our runs have: none is beyond 95 % of them."""
    cases = [(letter, name, case) for letter in "ab" for name, case in summary[letter].items()]
    # the paper reports the run of set-up (b); an error that all of ours stay below is another one
    beyond = [
        f"{name} in set-up ({letter})"
        for letter, name, case in cases
        if case["paper_relative_error"] > case["relative_error_quantiles"]["0.95"]
    ]
    median = max(case["relative_error_quantiles"]["0.5"] for _, _, case in cases)
    return Banner(
        tone="warn" if beyond else "good",
        verdict="differs" if beyond else "reproduced",
        text=(
            f"Beyond 95 % of our runs are the paper's errors of {', '.join(beyond)}."
            if beyond
            else f"The errors that the paper reports for its one run lie within 95 % of our {runs}."
        ),
        facts=(
            ("base parameters", f"{len(paper.NAMES)} of 20"),
            ("median error, at most", f"{100 * median:.2g} %"),
            ("runs of each set-up", str(runs)),
        ),
    )


def _csv(runs: paper.Runs, k: int) -> bytes:
    """Return one run as a log that `symgen identify planar2r` reads."""
    rows = np.column_stack([runs.t, runs.q[k], runs.qd[k], runs.tau[k]])
    lines = ["t,q1,q2,qd1,qd2,tau1,tau2", *(",".join(f"{v:.9g}" for v in row) for row in rows)]
    return ("\n".join(lines) + "\n").encode()


def _convergence_line(history: FloatArray) -> str:
    half = np.abs(history[:, 50] / paper.X_TRUE - 1)
    inside = 100 * np.mean(half < 0.1, axis=0)
    words = ", ".join(f"{name} {v:.0f} %" for name, v in zip(paper.NAMES, inside, strict=True))
    return f"Within 10 % of the truth after 50 samples: {words} of {len(history)} runs"


def _refused(evaluator: Evaluator, runs: paper.Runs, kind: str) -> str:
    log = make_log("proportional", runs.t, runs.q[0], runs.tau[0], runs.qd[0])
    try:
        identify(evaluator, log, model="energy", window=10 * paper.STEP)
    except IdentificationError as error:
        return f"{kind}: refused: {error}"
    return f"{kind}: NOT refused"


def _sections(
    letter: str, words: str, runs: paper.Runs, history: FloatArray, table: Table
) -> list[Section]:
    shown = {"q": (runs.q[0], "rad"), "qd": (runs.qd[0], "rad/s"), "tau": (runs.tau[0], "N m")}
    motion = plots.line_grid(
        [
            plots.Panel(
                key, runs.t, {f"joint {j + 1}": y[:, j] for j in range(2)}, f"{key}, {unit}"
            )
            for key, (y, unit) in shown.items()
        ],
        title="Motion and torque",
    )
    low, high = np.nanquantile(history[:, _SHOWN:], [0.05, 0.95], axis=0)
    curves = plots.line_grid(
        [
            plots.Panel(
                name,
                runs.t[_SHOWN:],
                {"first run": history[0, _SHOWN:, i] / true},
                f"{name} over its true value",
                level=1.0,
                band=(low[:, i] / true, high[:, i] / true),
            )
            for i, (name, true) in enumerate(zip(paper.NAMES, paper.X_TRUE, strict=True))
        ],
        title="Recursive estimate",
        columns=2,
    )
    curves.update_yaxes(range=[0.5, 1.5])
    within = _convergence_line(history)
    return [
        Section(
            f"Set-up ({letter})",
            (f"{words[:1].upper()}{words[1:]}. Drawn is the first run. {_COLUMNS}",),
            table,
            lambda: motion,
            told=(words, within),
        ),
        Section(
            f"Set-up ({letter}): convergence",
            (f"The recursive estimate of the first run; the band holds 90 % of them. {within}.",),
            figure=lambda: curves,
        ),
    ]
