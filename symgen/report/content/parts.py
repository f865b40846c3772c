"""What is said of a result: a verdict, sections of words, tables and figures, before any look."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symgen.estimation.torque_error import MANY
from symgen.report.plots.robot import drawing
from symgen.robot.types import HEADER

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

    from symgen.data.raw import FloatArray
    from symgen.estimation.band import Band
    from symgen.estimation.playback import Horizon
    from symgen.faults.fault import Fault
    from symgen.identification.estimate import Joint
    from symgen.robot.types import Robot
#: Columns that a line names; of more it says how many.
_NAMED = 3


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        header: one text a column.
        rows: one text a column in each; one with a cell that begins with ▲ is pointed out.
    """

    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class Section:
    """A heading with paragraphs, then a figure or a picture (SVG of our own), then a table.

    Attributes:
        heading, text, table: words and numbers.
        figure: draws it, when a page is made; where there is nothing to draw it returns None. A
            section with neither a figure nor rows of a table is left out, unless it is text alone.
        picture: SVG.
        told: lines that a terminal prints below the table; None: it shows nothing of the section.
            Lines alone, without anything else, are not on a page.
        folded: whether a page shows the heading alone until it is clicked. Paper leaves the section
            out, and so does a terminal, but for `told`.
    """

    heading: str
    text: tuple[str, ...] = ()
    table: Table | None = None
    figure: Callable[[], Figure | None] | None = None
    picture: str = ""
    told: tuple[str, ...] | None = None
    folded: bool = False


@dataclass(frozen=True)
class Banner:
    """What the reader must see first.

    Attributes:
        tone: "good", "warn", "bad", or "plain" where there is no verdict: the colour.
        verdict: one or two words.
        text: what it means, in a sentence.
        reasons: why.
        facts: label and value of the few numbers that matter.
    """

    tone: str
    verdict: str
    text: str
    reasons: tuple[str, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Content:
    """All that is said of a result, as a page and as the text of a terminal.

    Attributes:
        title: of the page.
        lead: paragraphs below the title.
        sections: in the order of page and terminal.
        banner: the verdict: on top of the page, at the end of the text.
        run: lines that a terminal prints first: what was done to the logs.
    """

    title: str
    lead: tuple[str, ...]
    sections: tuple[Section, ...]
    banner: Banner | None = None
    run: tuple[str, ...] = ()

    @property
    def good(self) -> bool:
        """Whether the answer is yes, or there was no question."""
        return self.banner is None or self.banner.tone in ("good", "plain")


def run_lines(band: Band | None, repairs: Sequence[Fault]) -> tuple[str, ...]:
    """Return what was done to the logs: a line of band, speeds and repairs; then one a kind."""
    said = "no band" if band is None else band.in_words()
    alike: dict[tuple[str, str], list[Fault]] = {}
    for r in repairs:  # figures differ from log to log
        alike.setdefault((re.sub(r"[0-9.]+", "", _short(r)), r.done), []).append(r)
    told = f"run: {said}; repaired: {_columns(repairs) or 'nothing'}"
    return (told, *(f"repair: {_together(own)}" for own in alike.values()))


def _short(repair: Fault) -> str:
    """Return a fault without the signs that show it."""
    return repair.fault.partition(" by ")[0]


def _columns(repairs: Sequence[Fault]) -> str:
    """Return the columns of repairs by name, or their number where they are many."""
    found = {(column, r.log): None for r in repairs for column in r.channel.split(", ")}
    if len(found) <= _NAMED:
        return ", ".join(f"{column} of {log}" for column, log in found)
    logs = list(dict.fromkeys(log for _, log in found))
    return f"{len(found)} columns of {logs[0] if len(logs) == 1 else f'{len(logs)} logs'}"


def _together(repairs: Sequence[Fault]) -> str:
    """Return repairs of one kind in one line."""
    first, *others = repairs
    columns = _columns(repairs)
    if columns == f"{first.channel} of {first.log}":
        return first.in_words
    short = _short(first)
    like = " and the like" if any(_short(r) != short for r in others) else ""
    return f"{columns}: {short}{like}: {first.done}"


def notes_section(notes: Sequence[str]) -> tuple[Section, ...]:
    """Return the section of notes where there are any; the band stands in the line of the run."""
    logs: dict[str, list[str]] = {}  # what is said -> of which logs
    for note in notes:
        name, colon, said = note.partition(": ")
        logs.setdefault(said if colon else note, []).append(name if colon else "")
    told = tuple(
        f"note: {', '.join(filter(None, dict.fromkeys(names)))}{': ' if any(names) else ''}{said}"
        for said, names in logs.items()
        if names != ["band"]
    )
    return (Section("Notes", tuple(notes), told=told),) if notes else ()


def repairs_section(repairs: Sequence[Fault]) -> Section:
    """Return what was mended in the logs."""
    rows = [(r.log, r.channel, r.fault, str(r.samples or "all"), r.done) for r in repairs]
    text = "symgen repaired these faults before all other steps."
    table = Table(("log", "channel", "fault", "samples", "what was done"), rows)
    return Section("Repairs", (text,), table)


def number(value: float, digits: int = 5) -> str:
    """Return a number with so many significant digits, in words where it is not finite."""
    if np.isnan(value):
        return "unknown"
    if np.isinf(value):
        return "∞" if value > 0 else "-∞"
    if 10.0**digits <= abs(value) < 1e6:  # no exponent for numbers that people read at a glance
        return f"{value:.0f}"
    return f"{value or 0.0:#.{digits}g}".removesuffix(".")


def value_with_std(value: float | None, std: float | None) -> tuple[str, str]:
    """Return a value and its standard deviation as texts.

    The value has three significant digits, or as many as the first digit of std reaches.
    """
    if value is None:
        return "not determined", ""
    digits = 3
    if std and value and np.isfinite([std, value]).all():
        places = np.floor(np.log10(abs(value))) - np.floor(np.log10(std)) + 1
        digits = int(np.clip(places, 3, 5))
    return number(value, digits), "" if std is None else number(std, 3)


def percent(ratio: float) -> str:
    """Return a ratio in percent, with three significant digits up to 1000 %."""
    return "over 1000 %" if MANY < ratio < np.inf else f"{number(100 * ratio, 3)} %"


def frames_section(robot: Robot) -> Section:
    """The frames of a robot as its Denavit-Hartenberg table has them."""
    text = (
        "The table with all joints at zero: axes z as lines, x dashed; revolute joints are "
        "circles, prismatic ones squares, each with the number of its frame."
    )
    columns = len(HEADER) - (not any(j.follows for j in robot.joints))
    table = Table(HEADER[:columns], [row[:columns] for row in robot.table()])
    return Section("The robot", (text,), table, picture=drawing(robot))


def errors_in_units(
    joints: Sequence[Joint], measured: FloatArray, ratios: Sequence[float]
) -> list[tuple[str, str]]:
    """Return the RMS torque of each joint and the RMS of its error, with their units.

    Args:
        joints: n movable joints.
        measured: torque, (N, n).
        ratios: RMS error over RMS torque, (n,).
    """
    rms = np.sqrt(np.mean(measured**2, axis=0))
    return [
        (f"{number(size, 3)} {joint.unit}", f"{number(size * ratio, 3)} {joint.unit}")
        for joint, size, ratio in zip(joints, rms, ratios, strict=False)
    ]


def counted(count: int, noun: str) -> str:
    """Return "1 pair", "2 pairs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


#: How the error of a simulated position is measured.
PLAYBACK = (
    "The error is the RMS of simulated minus measured position, over the RMS of the distance that "
    "the joints moved; ± is its standard deviation over the windows."
)


def horizon_table(
    first: str,
    models: Sequence[tuple[str, Sequence[Horizon]]],
    more: Mapping[str, Sequence[str]] | None = None,
) -> Table:
    """Return the position errors of simulated robots, a row each and a column for each horizon.

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
            *(f"{percent(h.position_error)} ± {percent(h.spread)}" for h in horizons),
            *(column[k] for column in others.values()),
        )
        for k, (name, horizons) in enumerate(models)
    ]
    return Table(header, rows)
