"""What the command line prints: tables and verdicts on stdout."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from symgen.diagnosis.diagnosis import Diagnosis
    from symgen.estimation.band import Band
    from symgen.estimation.repairs import Repair
    from symgen.experiment.plan import Plan
    from symgen.experiment.simulation import Simulation
    from symgen.experiment.study_result import Study
    from symgen.identification.comparison import Comparison
    from symgen.identification.estimate import Estimate
    from symgen.identification.payload_result import Payload
    from symgen.identification.prediction import Prediction
    from symgen.report.store import Result
    from symgen.robot.types import Robot


def table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table; a file or a pipe gets it in full width."""
    from rich.console import Console
    from rich.table import Column, Table
    from rich.text import Text

    grid = Table(
        *(Column(Text(name)) for name in header), box=None, pad_edge=False, header_style="bold"
    )
    for row in rows:
        grid.add_row(*map(Text, row))  # as text: brackets in a name are no markup
    console = Console(highlight=False)
    if not console.is_terminal:  # never cut a value
        console.width = 1000
    with console.capture() as captured:
        console.print(grid)
    click.echo(captured.get(), nl=False)


def print_robot(robot: Robot) -> None:
    """Print the Denavit-Hartenberg table of a robot."""
    from symgen.robot.table import HEADER, table_rows

    table(HEADER, table_rows(robot))


def print_model(model: Any) -> None:
    """Print the base parameters with their formulas and proof, and the kernels."""
    from symgen.symbolic.base_parameters import bound

    base = model.base
    table(
        ("base parameter", "formula", "unit"),
        [(p.name, p.expression, p.unit) for p in base.parameters],
    )
    click.echo(f"no effect: {', '.join(base.no_effect) or 'none'}")
    click.echo(
        f"{len(base.parameters)} base parameters of {len(base.standard)} standard ones "
        f"({base.inertial} inertial, bound {bound(model.robot)}); exact rank {base.proof.rank} "
        f"modulo {' and '.join(map(str, base.proof.primes))}"
    )
    for kernel in model.kernels:
        o = kernel.tape.operations
        click.echo(f"{kernel.name}: {o.mul} mul, {o.add} add, {o.div} div, {o.sincos} sincos")


def print_simulation(done: Simulation) -> None:
    """Print how far, how fast and how hard each joint of a simulation moves, and what was done."""
    rows = [
        (
            str(number),
            f"{done.q[:, :, j].min():.4g} to {done.q[:, :, j].max():.4g}",
            f"{abs(done.qd[:, :, j]).max():.4g}",
            f"{abs(done.tau[:, :, j]).max():.4g}",
            f"{100 * float((done.qd[:, :, j] == 0).mean()):.3g} %",
        )
        for j, number in enumerate(done.joints)
    ]
    table(("joint", "position", "top speed", "top torque", "at rest"), rows)
    for note in done.notes:
        click.echo(f"note: {note}")


def _print_run(band: Band | None, repairs: Sequence[Repair]) -> None:
    """Print in a line what was done to the logs: band, cutoff, speeds, and repairs; then each."""
    said = "no band" if band is None else band.in_words()
    channels = ", ".join(dict.fromkeys(f"{r.channel} of {r.log}" for r in repairs))
    click.echo(f"run: {said}; repaired: {channels or 'nothing'}")
    for repair in repairs:
        click.echo(f"repair: {repair.in_words}")


def _print_notes(notes: Sequence[str]) -> None:
    for note in notes:
        if not note.startswith("band: "):  # that stands in the line of the run
            click.echo(f"note: {note}")


def print_estimate(estimate: Estimate) -> None:
    """Print the parameters, what they leave unexplained, and the verdict."""
    _print_run(estimate.band, estimate.repairs)
    _print_notes(estimate.notes)
    others = [(f"by {c.method}", [f"{x:.5g}" for x in c.X]) for c in estimate.comparison]
    if estimate.prior is not None:
        pairs = zip(estimate.prior.X, estimate.prior.std, strict=True)
        known = [f"{x:.5g}" if math.isfinite(std) else "-" for x, std in pairs]
        others.insert(0, ("prior", known))
    table(
        ("parameter", "value", "std", "std %", *(head for head, _ in others), "unit", "formula"),
        [
            (
                p.name,
                f"{p.value:.5g}",
                f"{p.std:.2g}" if math.isfinite(p.std) else "-",
                f"{p.relative_std_percent:.1f}" if math.isfinite(p.std) else "-",
                *(values[k] for _, values in others),
                p.unit,
                p.expression,
            )
            for k, p in enumerate(estimate.parameters)
        ],
    )
    click.echo(f"std excludes: {estimate.excludes}")
    click.echo(f"condition number (scaled): {estimate.condition_number:.4g}")
    click.echo(
        f"residual of {estimate.model}: train {100 * estimate.train.relative:.3g} %, "
        f"validation {100 * estimate.validation.relative:.3g} %"
    )
    torque = estimate.torque_validation
    if torque is not None and torque.per_joint is not None:
        joints = ", ".join(f"{100 * r:.3g}" for r in torque.per_joint)
        click.echo(
            f"torque error on held-out motion: {100 * torque.relative:.3g} %, per joint {joints} %"
        )
    if len(estimate.alternatives) > 1:
        _print_alternatives(estimate)
    click.echo(f"physical consistency: {estimate.physical.reason}")
    _print_whiteness(estimate)
    colour = "green" if estimate.verdict == "trusted" else "yellow"
    click.echo("verdict: " + click.style(estimate.verdict, fg=colour, bold=True))
    for reason in estimate.reasons:
        click.echo(f"  - {reason}")
    if estimate.headline and not estimate.reasons:
        click.echo(f"  {estimate.headline}")


def _print_alternatives(estimate: Estimate) -> None:
    """Print the models that were fitted, the chosen one first."""

    def share(value: float) -> str:
        return f"{100 * value:.3g} %" if math.isfinite(value) else "-"

    table(
        ("model", "folds left out", "held-out motion", "condition", ""),
        [
            (
                a.model + (" (chosen)" if a.chosen else ""),
                share(a.held_out),
                "-" if a.validation is None else share(a.validation.relative),
                f"{a.condition_number:.3g}" if math.isfinite(a.condition_number) else "-",
                a.reason,
            )
            for a in estimate.alternatives
        ],
    )


def _print_whiteness(estimate: Estimate) -> None:
    """Print in a line whether the residuals on data never seen are white."""
    from symgen.identification.whiteness import LEVEL, in_words

    held = [w for w in estimate.whiteness if w.kind == "validation"] or estimate.whiteness
    if held:
        off = [w for w in held if w.p_value < LEVEL]
        worst = min(off or held, key=lambda w: w.p_value)
        click.echo(f"residuals: {len(held) - len(off)} of {len(held)} white; {in_words(worst)}")


def print_diagnosis(diagnosis: Diagnosis, folder: Path) -> None:
    """Print the answer in one screen: verdict, effects, gap per joint, and what to do next."""
    from symgen.diagnosis.words import TONES, alike, percent, summary, undeclared

    colour = {"good": "green", "warn": "yellow", "bad": "red"}[TONES[diagnosis.verdict]]
    click.echo(f"{click.style(diagnosis.verdict, fg=colour, bold=True)}: {summary(diagnosis)}")
    rows = []
    for effect in diagnosis.effects:
        first = (effect.name, ", ".join(map(str, effect.joints)) or "all")
        for k, p in enumerate(effect.parameters):
            std = "searched" if p.std != p.std else f"{p.std:.2g}"
            closes = percent(effect.gap_reduction) if k == 0 else ""
            start = first if k == 0 else ("", "")
            rows.append((*start, p.name, f"{p.value:.5g}", std, p.unit, closes))
        if not effect.parameters:
            rows.append((*first, "", "", "", "", percent(effect.gap_reduction)))
    if rows:
        click.echo()
        table(("effect", "joint", "parameter", "value", "std", "unit", "closes"), rows)
    for effect in diagnosis.effects:
        if effect.indistinguishable_from and not effect.separate:
            click.echo(f"{effect.name}: not told from {alike(effect)}")
    gaps = (diagnosis.before, diagnosis.after, diagnosis.floor)
    joints = [f"joint {number}" for number in diagnosis.joints]
    columns = [(*gap.per_joint, gap.total) for gap in gaps]
    click.echo()
    table(
        ("gap", "before", "after", "noise floor"),
        [(name, *map(percent, row)) for name, *row in zip([*joints, "all"], *columns, strict=True)],
    )
    for line in (*diagnosis.advice, *undeclared(diagnosis)):
        click.echo(f"next: {line}")
    if any(effect.declared for effect in diagnosis.effects):
        click.echo(f"next: {folder / 'robot.toml'} declares what was found; use it from here on")
    for note in diagnosis.notes:
        click.echo(f"note: {note}")


def print_prediction(prediction: Prediction) -> None:
    """Print how far the predicted torque is from the measured one."""
    _print_run(prediction.band, prediction.repairs)
    _print_notes(prediction.notes)
    joints = ", ".join(f"{100 * r:.3g}" for r in prediction.error.per_joint or ())
    click.echo(
        f"error of torque per joint: {joints} %; in all {100 * prediction.error.relative:.3g} %"
    )


def print_payload(found: Payload) -> None:
    """Print a load with its precision, and how well it explains the logs."""
    _print_run(found.band, found.repairs)
    _print_notes(found.notes)
    rows = [
        (name, "not determined" if q.value is None else f"{q.value:.5g}",
         "" if q.std is None else f"{q.std:.2g}", unit)
        for name, q, unit in found.rows()
    ]  # fmt: skip
    table(("load", "value", "std", "unit"), rows)
    click.echo(f"in the frame of joint {found.frame}, inertia about the centre of mass")
    click.echo(
        f"error of torque: {100 * found.residual.before:.3g} % without the load, "
        f"{100 * found.residual.after:.3g} % with it"
    )


def print_study(found: Study) -> None:
    """Print models and methods beside each other, and the parameters by the best of them."""
    from symgen.experiment.study_result import COLUMNS, HEADER, answer, overview, precision_rows

    table(HEADER, overview(found))
    best, target = found.best, f"{found.settings.target_percent:g} %"
    click.echo(
        f"at once, in the end, never: parameters within {target}; {found.settings.runs} runs"
    )
    if best is not None:
        click.echo()
        click.echo(f"{best.name}, bias and std over the value:")
        table(COLUMNS, precision_rows(best))
        click.echo(f"{best.name}: {answer(found, best)}")
    for note in found.notes:
        click.echo(f"note: {note}")


def print_comparison(comparison: Comparison) -> None:
    """Print two estimates side by side, and which parameters moved."""
    from symgen.report.content.comparison import side_by_side

    for label, name in zip("ab", comparison.names, strict=True):
        click.echo(f"{label}: {name}")
    table(
        ("parameter", "a", "std", "b", "std", "apart, std", "", "unit", "formula"),
        [
            (
                p.name,
                f"{p.a.value:.5g}",
                f"{p.a.std:.2g}",
                f"{p.b.value:.5g}",
                f"{p.b.std:.2g}",
                f"{p.sigmas:.2f}",
                "moved" if p.moved else "",
                p.a.unit,
                p.a.expression,
            )
            for p in comparison.parameters
        ],
    )
    for name, reason in comparison.left_out:
        click.echo(f"not compared: {name}: {reason}")
    click.echo()
    table(("", "a", "b"), side_by_side(comparison))
    for note in comparison.notes:
        click.echo(f"note: {note}")
    colour = "green" if comparison.verdict == "agree" else "yellow"
    verdict = click.style(comparison.verdict, fg=colour, bold=True)
    click.echo(f"verdict: {verdict}: {comparison.summary}")
    for p in comparison.moved:
        click.echo(f"  - {p.name} moved by {p.difference:.3g} {p.a.unit}, {p.sigmas:.3g} std")


def print_result(result: Result, path: Path) -> bool:
    """Print what identify, diagnose, predict, payload or study found.

    Returns:
        Whether the answer is yes: trusted, consistent or explained; of others it is no question.
    """
    from symgen.diagnosis.diagnosis import Diagnosis
    from symgen.experiment.study_result import Study
    from symgen.identification.estimate import Estimate
    from symgen.identification.payload_result import Payload

    if isinstance(result, Estimate):
        print_estimate(result)
        return result.verdict == "trusted"
    if isinstance(result, Diagnosis):
        print_diagnosis(result, path if path.is_dir() else path.parent)
        return result.verdict in ("consistent", "explained")
    if isinstance(result, Study):
        print_study(result)
    elif isinstance(result, Payload):
        print_payload(result)
    else:
        print_prediction(result)
    return True


def print_plan(plan: Plan) -> None:
    """Print how much of every limit the runs take, and the condition numbers that they give."""
    keys = list(dict.fromkeys(u.limit for u in plan.uses))
    joints = sorted({u.joint for u in plan.uses})
    used = {(u.limit, u.joint): f"{100 * u.share:.1f} %" for u in plan.uses}
    table(
        ("share of the limit", *keys),
        [(f"joint {j}", *(used.get((key, j), "") for key in keys)) for j in joints],
    )
    lengths = ", ".join(f"{run.duration:g}" for run in plan.runs)
    click.echo(f"runs of {lengths} s; no limit is exceeded (looked at every millisecond)")
    for name, condition in plan.conditions.items():
        mark = f" (random start: {plan.start:.4g})" if name == plan.model else ""
        click.echo(f"condition number (scaled), {name}: {condition:.4g}{mark}")
    click.echo(f"log det (scaled), {plan.model}: {plan.log_det:.4g}")
    done, asked = plan.searches
    click.echo(f"searches: {done} of {asked} went to their end; stopped: {plan.stopped}")
    for note in plan.notes:
        click.echo(f"note: {note}")
    for line in (*plan.warnings, *plan.other_models):
        click.echo(f"{click.style('warning', fg='yellow')}: {line}")


def print_text(text: str) -> None:
    """Print a text that may hold dots of Braille; a terminal without them gets stars."""
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        text = "".join("*" if ord(c) > 0x2800 else c if ord(c) < 128 else "-" for c in text)
    click.echo(text)
