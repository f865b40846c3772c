"""Read the text of a CSV: its separator, decimal mark, columns and numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from symgen.data.raw import Reading, refuse, shown
from symgen.data.units import are_times, durations, is_unit, joined

#: Options for a table without names of its columns.
NO_HEADER = (
    '--no-header --columns "t=1,q1=2,..", with the places of t (t=1+2 for s and ns), q1.., tau1..'
)
_PREAMBLE = 50  # lines before the header
_ROWS = 200 + _PREAMBLE  # lines that show the form
_SEPARATORS = ",;\t| "
_NUMBER = re.compile(r"[+-]?[0-9.,]*[0-9.]([eE][+-]?[0-9]+)?|[+-]?(nan|inf)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")
_COMMENT = re.compile(r"\s*(#+\s*|%+\s+)")
_BRACKETS = "[](){}<>"
_SHOWN = {"\t": "tabs", ";": "semicolons", " ": "blanks", ",": "commas"}
#: Accepted content of a time column.
_TIMES = "seconds, or dates such as 2026-01-31T13:00:00.250, or durations such as 00:00:01.250"


@dataclass(frozen=True)
class CsvForm:
    """The form of a CSV.

    Attributes:
        separator: character between columns; a blank for any number of blanks and tabs.
        decimal: decimal mark.
        header: column names of the file; "" for a column without one.
        units: unit of each column in a row below the header, " [rad]", or "".
        skipped: lines before the first sample.
        first: cells of the first rows.
        notes: lines that are neither header nor samples.
    """

    separator: str
    decimal: str
    header: tuple[str, ...]
    units: tuple[str, ...]
    skipped: int
    first: tuple[Sequence[str], ...]
    notes: tuple[str, ...]

    @property
    def shown(self) -> str:
        """The separator and the decimal mark as text."""
        mark = "commas" if self.decimal == "," else "points"
        between = _SHOWN.get(self.separator, repr(self.separator))
        return f"columns are separated by {between} and decimals have {mark}"

    @property
    def accepted(self) -> str:
        """The accepted forms, with the options to type."""
        separator = "," if self.separator == ";" else ";"
        decimal = "." if self.decimal == "," else ","
        return (
            f"rows of numbers ({self.shown}), or another form: --separator '{separator}', "
            f"--decimal '{decimal}'"
        )


class _Row(NamedTuple):
    """A line with text: its cells, the lines up to its end, and how many cells are numbers and
    words.
    """

    cells: Sequence[str]
    end: int
    numbers: int
    words: int


def csv_form(path: Path, reading: Reading) -> CsvForm:
    """Find the form of a CSV from its first lines.

    The separator is the character that divides the lines into most numbers. The decimal mark is a
    comma if numbers in the first rows contain commas. Options take precedence.

    Raises:
        LogError: no line has the names of the columns, or there are no samples.
    """
    # utf-8-sig removes the byte order mark of spreadsheets.
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = list(islice(file, _ROWS))
    excel = re.match("sep=(.)", lines[0]) if lines else None
    if excel:
        lines[0] = "\n"
    usual = max(_SEPARATORS, key=lambda mark: sum(row.numbers for row in _rows(lines, mark)))
    separator = reading.separator or (excel[1] if excel else usual)
    rows = _rows(lines, separator)
    first = _first_sample(rows)
    names = _names(rows, first) if reading.header else first
    header = [*rows[names].cells]
    first = names + 1
    units = [""] * len(header)
    notes = [f"lines before the table, not read: {rows[names].end - 1}"] if names else []
    if not reading.header:
        header = [str(k + 1) for k in range(len(header))]
        first = names
    elif first < len(rows) and _has_units(rows[first]):
        units = [f" [{unit.strip(_BRACKETS)}]" if unit else "" for unit in rows[first].cells]
        notes.append(f"line {rows[first].end} has the units")
        first += 1
    for row in rows[first : first + 1]:  # the rows, or the header, end with a separator
        if len(row.cells) == len(header) + 1 and not row.cells[-1]:
            header.append("")
        elif len(header) == len(row.cells) + 1 and not header[-1]:
            header.pop()
    cells = tuple(row.cells for row in rows[first:])
    commas = any(_COMMA.fullmatch(cell) for row in cells for cell in row)
    decimal = reading.decimal or ("," if commas else ".")
    skipped = rows[first - 1].end if first else int(excel is not None)
    form = CsvForm(
        separator, decimal, tuple(header), tuple(units), skipped, cells, tuple(notes)
    )  # fmt: skip
    if header and not form.first:
        refuse("has a header and no samples", form.accepted)
    return form


def _rows(lines: Sequence[str], separator: str) -> list[_Row]:
    """Return the lines that are not empty, without the mark of a comment."""
    texts = [_COMMENT.sub("", line, count=1) for line in lines]
    if separator == " ":
        texts = [" ".join(line.split()) for line in texts]
    reader = csv.reader(texts, delimiter=separator)
    rows = []
    for line in filter(None, reader):
        cells = [cell.strip() for cell in line]
        numbers = sum(_NUMBER.fullmatch(cell) is not None for cell in cells)
        words = len(cells) - cells.count("") - numbers
        rows.append(_Row(cells, reader.line_num, numbers, words))
    return rows or [_Row([], 0, 0, 0)]


def _first_sample(rows: Sequence[_Row]) -> int:
    """Return the first of two rows of numbers with as many cells as most of them."""
    widths = [len(row.cells) - 1 if row.numbers > row.words else 0 for row in rows]
    usual = max(filter(None, widths), key=widths.count, default=-1)
    pairs = [*pairwise(widths)]
    twice = (usual, usual)
    return pairs.index(twice) if twice in pairs else 0


def _names(rows: Sequence[_Row], first: int) -> int:
    """Return the row of the names: the last one of words above the first sample, but for units.

    Raises:
        LogError: there is none.
    """
    for k in reversed(range(first)):
        if rows[k].words > 1 and not _has_units(rows[k]):
            return k
    sample = rows[first]
    after = rows[first : first + 2][-1]
    if sample.numbers > sample.words and sample.numbers >= after.numbers:
        refuse(f"the first line, {sample.cells[0]}.., has no names of columns", NO_HEADER)
    return first  # some names are numbers


def _has_units(row: _Row) -> bool:
    """Return whether most cells of a row are units, in brackets or without."""
    units = sum(is_unit(cell.strip(_BRACKETS)) for cell in row.cells)
    return not row.numbers and 2 * units > row.words


def read_csv(path: Path, form: CsvForm, used: Mapping[str, str], rest: str = "") -> Any:
    """Return columns of a CSV as an Arrow table of numbers; t may be dates or durations.

    Args:
        path: the file.
        form: form of the CSV.
        used: number of a column, from 0 -> log column.
        rest: the column with the rest of the seconds in t, or "".

    Raises:
        LogError: a row has another number of cells than the header, or a cell is not a number.
    """
    import pyarrow as pa

    kinds = {k: None if name == "t" else pa.float64() for k, name in used.items()}
    if rest:
        kinds[str(form.header.index(rest))] = pa.float64()
    try:
        table = _table(path, form, kinds)
        for k in used:
            if used[k] == "t":
                place = table.schema.get_field_index(k)
                table = table.set_column(place, k, _times(table, k, rest))
        return table
    except ValueError as invalid:  # of Arrow too
        error = str(invalid)
    odd: list[Any] = []  # the first row with another number of cells
    with suppress(pa.ArrowInvalid):
        texts = _table(path, form, dict.fromkeys(used, pa.string()), odd)
        _require_numbers(texts.to_pydict(), form, used)
    if odd:
        sample = odd[0].number - form.skipped - 1
        cells = odd[0].actual_columns
        error = f"sample {sample}: {cells} values for {len(form.header)} columns"
    return refuse(error, form.accepted)


def texts_of(path: Path, form: CsvForm, place: int) -> list[str]:
    """Return the different texts of a column of a CSV."""
    import pyarrow as pa

    column = _table(path, form, {str(place): pa.string()}).column(0)
    return [text.strip() for text in column.unique().to_pylist()]


def _table(
    path: Path, form: CsvForm, kinds: Mapping[str, Any], odd: list[Any] | None = None
) -> Any:
    """Return columns of a CSV as an Arrow table.

    Args:
        path, form: the file and its form.
        kinds: number of a column, from 0 -> Arrow type, or None to find it from the cells.
        odd: receives the first row with another number of cells. The reader is then slow: it
            counts rows on one thread only.

    Raises:
        ArrowInvalid: a row has another number of cells, or a cell is not of the type.
    """
    import pyarrow as pa
    import pyarrow.csv as pacsv

    def refused(row: Any) -> str:
        if odd is not None:
            odd.append(row)
        return "error"

    file: Any = path
    if form.separator == " ":
        lines = [b" ".join(line.split()) for line in path.read_bytes().split(b"\n")]
        file = pa.BufferReader(b"\n".join(lines))
    names = [str(k) for k in range(len(form.header))]
    known = {k: kind for k, kind in kinds.items() if kind}
    return pacsv.read_csv(
        file,
        pacsv.ReadOptions(column_names=names, skip_rows=form.skipped, use_threads=odd is None),
        pacsv.ParseOptions(delimiter=form.separator, invalid_row_handler=refused),
        pacsv.ConvertOptions(
            include_columns=[*kinds], column_types=known, decimal_point=form.decimal
        ),
    )


def _times(table: Any, time: str, rest: str) -> Any:
    """Return the column of the time: numbers, dates or durations.

    Raises:
        ValueError: it holds something else.
    """
    import pyarrow as pa

    column = table.column(time)
    if rest:
        return pa.array(joined(column.to_numpy(), table.columns[-1].to_numpy(), rest))
    if pa.types.is_string(column.type):
        return pa.array(durations(column.to_pylist()))
    usual = (pa.types.is_integer, pa.types.is_floating, pa.types.is_timestamp)
    if not any(test(column.type) for test in usual):
        raise ValueError(f"column t holds {column.type}")
    return column


def _require_numbers(
    texts: Mapping[str, Sequence[str]], form: CsvForm, used: Mapping[str, str]
) -> None:
    """Refuse the first cell of a CSV that is not a number; t may be dates or durations."""
    swapped = str.maketrans(",.", ".,") if form.decimal == "," else {}
    for k, name in used.items():
        if name == "t" and are_times(texts[k]):
            continue
        for sample, cell in enumerate(texts[k]):
            try:
                float(cell.translate(swapped) or "nan")
            except ValueError:
                column = shown(name, {name: form.header[int(k)]})
                what = f"column {column}, sample {sample}: {cell[:40]!r} is not a number"
                refuse(what, f"{_TIMES}, in {form.accepted}" if name == "t" else form.accepted)
