"""symgen demo: the example of Gautier and Khalil (1988), from its table to its figures.

Derives the canonical model, compiles it, simulates the noisy measurements, identifies recursively
and says where the paper's errors fall in the distribution of seeded runs.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
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
from symgen.report.html import Banner, Section, Table, drawn, frames_section, page
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
_MARKER, _PAGE = "demo.json", "demo.html"


def run_demo(folder: Path, runs: int, say: Callable[[str], None]) -> Iterator[str]:
    """Run the example and write its page; yields blocks of text as they are ready.

    Args:
        folder: gets demo.html and demo.json, whole or not at all.
        runs: seeded runs of each set-up.
        say: is told what is being done.

    Raises:
        PackageError: the folder holds something else.
    """
    check_replaceable(folder, _MARKER)
    begun = time.perf_counter()
    model = derive(read_robot("planar2r"))
    derived = time.perf_counter() - begun
    yield "Gautier and Khalil (1988), two revolute joints, gravity along z1\n"
    yield "Canonical model, derived and proved minimal in %.0f ms" % (1e3 * derived)
    columns = closed_form(model.kernels[0])
    for parameter, column in zip(model.base.parameters, columns, strict=True):
        yield f"  {parameter.name:5} = {parameter.expression:16} DL = {column}"
    canonical = Table(
        ("parameter", "formula", "column DL"),
        tuple(
            (p.name, p.expression, column)
            for p, column in zip(model.base.parameters, columns, strict=True)
        ),
    )
    say("compiling the model")
    evaluator = load(model)
    yield f"\nEvaluated by: {evaluator.backend}"
    simulated = dynamics(model)
    exact = _exact_block(evaluator, paper.exact_run(simulated))
    yield exact
    figures: list[Section] = []
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
        table = _errors(finals)
        summary[letter] = _summary(finals)
        logs |= {f"setup_{letter}_{k + 1}.csv": _csv(measured, k) for k in range(2)}
        yield f"\nSet-up ({letter}): {words}\n{_plain(table)}"
        yield _convergence_line(history)
        figures += _sections(letter, words, measured, history, table)
    yield "\nJoint speeds proportional to each other, as the paper warns:"
    for noisy in (False, True):
        yield "  " + _refused(
            evaluator, paper.proportional_run(simulated, 1 if noisy else None), noisy
        )
    figures.insert(0, Section("Canonical model", (exact,), table=canonical))
    figures.append(frames_section(model.robot))
    html = page(
        "The example of Gautier and Khalil (1988)",
        (
            "In 1988 M. Gautier and W. Khalil showed that a robot's energy gives its inertial "
            "parameters without any acceleration, on a simulated arm of two joints. This page does "
            f"it again: {runs} seeded runs of each of their set-ups, {paper.SAMPLES} samples of "
            f"{paper.STEP} s, with the noise that they had.",
        ),
        figures,
        _banner(summary, runs),
    )
    content = json.dumps(summary, indent=1) + "\n"
    write_folder(folder, {_PAGE: html.encode(), _MARKER: content.encode(), **logs}, _MARKER)
    yield f"\nwritten: {folder / _PAGE}   ({time.perf_counter() - begun:.1f} s in all)"


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
        verdict="Differs" if beyond else "Reproduced",
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


def _plain(table: Table) -> str:
    lines = (table.header, *table.rows)
    widths = [max(len(line[i]) for line in lines) for i in range(len(table.header))]
    return "\n".join(
        "  " + "  ".join(cell.rjust(w) for cell, w in zip(line, widths, strict=True))
        for line in lines
    )


def _convergence_line(history: FloatArray) -> str:
    half = np.abs(history[:, 50] / paper.X_TRUE - 1)
    inside = 100 * np.mean(half < 0.1, axis=0)
    words = ", ".join(f"{name} {v:.0f} %" for name, v in zip(paper.NAMES, inside, strict=True))
    return f"  Within 10 % of the truth after 50 samples: {words} of {len(history)} runs"


def _refused(evaluator: Evaluator, runs: paper.Runs, noisy: bool) -> str:
    log = make_log("proportional", runs.t, runs.q[0], runs.tau[0], runs.qd[0])
    kind = "with noise" if noisy else "without noise"
    try:
        identify(evaluator, log, model="energy", window=10 * paper.STEP)
    except IdentificationError as error:
        return f"{kind}: refused: {error}"
    return f"{kind}: NOT refused"


def _sections(
    letter: str, words: str, runs: paper.Runs, history: FloatArray, table: Table
) -> list[Section]:
    from symgen.report.plots import curves as plots

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
    return [
        drawn(
            f"Set-up ({letter})",
            f"{words[:1].upper()}{words[1:]}. Drawn is the first run. {_COLUMNS}",
            motion,
            table,
        ),
        drawn(
            f"Set-up ({letter}): convergence",
            "The recursive estimate of the first run; the band holds 90 % of the runs. "
            + _convergence_line(history).strip()
            + ".",
            curves,
        ),
    ]
