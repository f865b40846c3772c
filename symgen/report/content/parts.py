"""Content of a result: verdict, sections of text, tables and figures, without layout."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symgen.estimation.torque_error import MANY
from symgen.estimation.torque_error import percent as percent
from symgen.faults.fault import CONVERTED
from symgen.report.plots.robot import drawing
from symgen.robot.types import HEADER

if TYPE_CHECKING:
    from symgen.data.raw import FloatArray
    from symgen.diagnosis.diagnosis import Gap
    from symgen.estimation.band import Band
    from symgen.estimation.playback import Horizon
    from symgen.estimation.values import Residual
    from symgen.faults.fault import Fault
    from symgen.identification.estimate import JointLabel
    from symgen.report.plots.figure import Figure
    from symgen.robot.types import Robot
#: Largest number of columns that a line lists; for more it gives their number.
_NAMED = 3


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        header: one text per column.
        rows: one text per column each; a cell that begins with ▲ highlights its row.
    """

    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class Section:
    """A heading, a figure or a picture (SVG), paragraphs, and a table.

    Attributes:
        heading, text, table: text and numbers.
        figure: draws the figure when a page is made; returns None if there is nothing to draw. A
            section without figure and rows is left out, unless it is text alone.
        picture: SVG.
        printed: lines that a terminal prints below the table; with None it prints nothing of the
            section. A section with such lines alone is not on a page.
        folded: whether a page shows only the heading until it is clicked. Print and terminal omit a
            folded section, except for `printed`.
    """

    heading: str
    text: tuple[str, ...] = ()
    table: Table | None = None
    figure: Callable[[], Figure | None] | None = None
    picture: str = ""
    printed: tuple[str, ...] | None = None
    folded: bool = False


@dataclass(frozen=True)
class Banner:
    """The result in brief.

    Attributes:
        tone: colour: "good", "warn" or "bad", or "plain" without a verdict.
        headline: the most important number, in a sentence, before the verdict.
        verdict: one or two words.
        text: its meaning, in a sentence.
        reasons: the reasons for it.
        facts: labels and values of the most important numbers.
    """

    tone: str
    verdict: str
    text: str
    reasons: tuple[str, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    headline: str = ""


@dataclass(frozen=True)
class Content:
    """The content of a result, for a page and for a terminal.

    Attributes:
        title: title of the page.
        lead: paragraphs below the title.
        sections: the sections, in the order of page and terminal.
        banner: the verdict.
        run: lines for the terminal on the band and the repairs of the logs.
    """

    title: str
    lead: tuple[str, ...]
    sections: tuple[Section, ...]
    banner: Banner | None = None
    run: tuple[str, ...] = ()

    @property
    def good(self) -> bool:
        """Whether the verdict is positive, or there is none."""
        return self.banner is None or self.banner.tone in ("good", "plain")


def run_lines(band: Band | None, repairs: Sequence[Fault]) -> tuple[str, ...]:
    """Return lines on the logs: band, speeds and repairs, then one line for each kind of repair."""
    text = "no band" if band is None else band.in_words()
    alike: dict[tuple[str, str], list[Fault]] = {}
    for r in repairs:  # numbers differ between logs
        alike.setdefault((re.sub(r"[0-9.]+", "", _short(r)), r.done), []).append(r)
    mended = [r for r in repairs if r.kind != CONVERTED]
    lines = [f"run: {text}; repaired: {_columns(mended) or 'nothing'}"]
    for group in alike.values():
        label = "note" if group[0].kind == CONVERTED else "repair"
        lines.append(f"{label}: {_one_line(group)}")
    return tuple(lines)


def _short(repair: Fault) -> str:
    """Return the text of a fault without its evidence."""
    return repair.why.partition(" by ")[0]


def _columns(repairs: Sequence[Fault]) -> str:
    """Return the names of the repaired columns, or their number if there are many."""
    columns = {(column, r.log): None for r in repairs for column in r.channel.split(", ")}
    if len(columns) <= _NAMED:
        return ", ".join(f"{column} of {log}" for column, log in columns)
    logs = list(dict.fromkeys(log for _, log in columns))
    return f"{len(columns)} columns of {logs[0] if len(logs) == 1 else f'{len(logs)} logs'}"


def _one_line(repairs: Sequence[Fault]) -> str:
    """Return one line for the repairs of one kind."""
    first, *others = repairs
    columns = _columns(repairs)
    if columns == f"{first.channel} of {first.log}":
        return first.in_words
    short = _short(first)
    like = " and the like" if any(_short(r) != short for r in others) else ""
    return f"{columns}: {short}{like}: {first.done}"


def notes_section(notes: Sequence[str]) -> tuple[Section, ...]:
    """Return the section of notes, if there are any; the band is in `run_lines`."""
    logs: dict[str, list[str]] = {}  # note -> its logs
    for note in notes:
        name, colon, text = note.partition(": ")
        logs.setdefault(text if colon else note, []).append(name if colon else "")
    lines = tuple(
        f"note: {', '.join(filter(None, dict.fromkeys(names)))}{': ' if any(names) else ''}{text}"
        for text, names in logs.items()
        if names != ["band"]
    )
    return (Section("Notes", tuple(notes), printed=lines),) if notes else ()


def repairs_section(repairs: Sequence[Fault]) -> Section:
    """Return the repairs of the logs."""
    rows = [(r.log, r.channel, r.why, str(r.samples or "all"), r.done) for r in repairs]
    text = "symgen repaired these faults before all other steps."
    table = Table(("log", "channel", "fault", "samples", "what was done"), rows)
    return Section("Repairs", (text,), table)


def number(value: float, digits: int = 5) -> str:
    """Return a number with `digits` significant digits; "unknown" or ∞ if not finite."""
    if np.isnan(value):
        return "unknown"
    if np.isinf(value):
        return "∞" if value > 0 else "-∞"
    if 10.0**digits - 0.5 <= abs(value) < 1e6:  # no exponent for numbers of common size
        return f"{value:.0f}"
    return f"{value or 0.0:#.{digits}g}".removesuffix(".")


def value_with_std(value: float | None, std: float | None) -> tuple[str, str]:
    """Return a value and its standard deviation as texts.

    The value has three significant digits, or digits up to the first one of std.
    """
    if value is None:
        return "not determined", ""
    digits = 3
    if std and value and np.isfinite([std, value]).all():
        places = np.floor(np.log10(abs(value))) - np.floor(np.log10(std)) + 1
        digits = int(np.clip(places, 3, 5))
    return number(value, digits), "" if std is None else number(std, 3)


def frames_section(robot: Robot) -> Section:
    """Return the drawing of a robot's frames with its Denavit-Hartenberg table."""
    text = (
        "The table with all joints at zero: axes z as lines, x dashed; revolute joints are "
        "circles, prismatic ones squares, each with the number of its frame."
    )
    columns = len(HEADER) - (not any(j.follows for j in robot.joints))
    table = Table(HEADER[:columns], [row[:columns] for row in robot.table()])
    return Section("The robot", (text,), table, picture=drawing(robot))


def errors_in_units(
    joints: Sequence[JointLabel], measured: FloatArray, ratios: Sequence[float]
) -> list[tuple[str, str]]:
    """Return the RMS torque of each joint and the RMS of its error, with their units.

    Args:
        joints: n movable joints.
        measured: torque, (N, n).
        ratios: RMS error over RMS torque, (n,); over that of all joints where it is 0.
    """
    rms = np.sqrt(np.mean(measured**2, axis=0))
    errors = ratios * np.where(rms > 0, rms, np.linalg.norm(rms))
    return [
        (f"{number(size, 3)} {joint.unit}", f"{number(error, 3)} {joint.unit}")
        for joint, size, error in zip(joints, rms, errors, strict=False)
    ]


def error_table(
    joints: Sequence[JointLabel], measured: FloatArray | None, errors: Mapping[str, Residual]
) -> Table:
    """Return the torque errors of each joint, in percent, and of the first in units.

    Args:
        joints: n movable joints.
        measured: torque, (N, n); None if it is unknown.
        errors: the errors by name.
    """
    first_error = next(iter(errors.values()))
    first = first_error.per_joint
    sizes = [("", "")] * len(joints)
    if measured is not None and first:
        sizes = errors_in_units(joints, measured[:, -len(joints) :], first)
    each = zip(*(r.per_joint or () for r in errors.values()), strict=False)
    rows = [
        (joint.label, *size, *map(percent, shares))
        for joint, size, shares in zip(joints, sizes, each, strict=False)
    ]
    rows = [(name, "", "", *x) for name, *x in base_rows([*errors.values()])] + rows
    every = "all joints" if first_error.base_force is None else "all"
    rows.append((every, "", "", *(percent(r.relative) for r in errors.values())))
    return Table(("joint", "RMS torque", "RMS error", *errors), rows)


def base_rows(errors: Sequence[Residual | Gap]) -> list[tuple[str, ...]]:
    """Return the errors of force and moment on a floating base; nothing for other bases."""
    out = []
    for name, key in (("base force", "base_force"), ("base moment", "base_moment")):
        shares = [getattr(error, key) for error in errors]
        if errors and None not in shares:
            out.append((name, *map(percent, shares)))
    return out


def counted(count: int, noun: str) -> str:
    """Return "1 pair", "2 pairs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


#: The definition of the error of a simulated position.
PLAYBACK = (
    "The error is the RMS of simulated minus measured position, over the RMS of the distance that "
    "the joints moved; ± is its standard deviation over the windows."
)


def _position_error(horizon: Horizon) -> str:
    """Return the position error with its spread; without the spread if the error has no meaningful
    digits.
    """
    error = percent(horizon.position_error)
    return error if horizon.position_error > MANY else f"{error} ± {percent(horizon.spread)}"


def horizon_table(
    first: str,
    models: Sequence[tuple[str, Sequence[Horizon]]],
    more: Mapping[str, Sequence[str]] | None = None,
) -> Table:
    """Return the position errors of simulated robots: one row a robot, one column a horizon.

    Args:
        first: heading of the names.
        models: names and errors.
        more: further columns.
    """
    others = more or {}
    header = (first, *(f"{h.seconds:g} s" for h in models[0][1]), *others)
    rows = [
        (
            name,
            *map(_position_error, horizons),
            *(column[k] for column in others.values()),
        )
        for k, (name, horizons) in enumerate(models)
    ]
    return Table(header, rows)


def horizon_by_joint(
    joints: Sequence[JointLabel], models: Sequence[tuple[str, Sequence[Horizon]]]
) -> Section:
    """Return the position errors of simulated robots at the last horizon, one column a robot."""
    rows = [
        (joint.label, *(f"{h[-1].per_joint[j]:.3g} {joint.place_unit}" for _, h in models))
        for j, joint in enumerate(joints)
    ]
    heading = f"by joint after {models[0][1][-1].seconds:g} s"
    return Section(heading, (), Table(("joint", *(name for name, _ in models)), rows), printed=())
