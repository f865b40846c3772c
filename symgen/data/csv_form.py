"""The form of a CSV: where its samples begin, its separator, its decimal mark, and its columns."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

from symgen.data.raw import Reading, refuse
from symgen.data.times import FRACTION, durations
from symgen.data.units import is_unit, split_unit

#: Options for a table without names of its columns.
NO_HEADER = '--no-header --columns "t=1,q1=2,..", with the places of t, q1.., tau1..'
_PREAMBLE = 50  # lines before the header
_ROWS = 200 + _PREAMBLE  # lines that show the form
_SEPARATORS = ",;\t| "
_NUMBER = re.compile(r"[+-]?[0-9.,]*[0-9.]([eE][+-]?[0-9]+)?|[+-]?(nan|inf)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")
_COMMENT = re.compile(r"\s*(#+\s*|%+\s+)")
_BRACKETS = "[](){}<>"
_SHOWN = {"\t": "tabs", ";": "semicolons", " ": "blanks", ",": "commas"}
_DATE = re.compile("[0-9]{4}-[0-9]{2}-[0-9]{2}")
#: Accepted content of a time column.
_TIMES = "seconds, or dates such as 2026-01-31T13:00:00.250, or durations such as 00:00:01.250"
#: Arrays of a JointState, in the order of `ros2 topic echo --csv`, behind its stamp and frame.
_STAMPED = ("sec", "nanosec", "frame_id")
_ARRAYS = ("name", "position", "velocity", "effort")


@dataclass(frozen=True)
class CsvForm:
    """The form of a CSV.

    Attributes:
        separator: character between columns; a blank for any number of blanks and tabs.
        decimal: decimal mark.
        header: column names of the file; "" for a column without one.
        skipped: lines before the first sample.
        first: cells of the first rows.
        notes: what is not a table of one header and samples.
    """

    separator: str
    decimal: str
    header: tuple[str, ...]
    skipped: int
    first: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()

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

    def cells(self, place: int) -> list[str]:
        """Return the first cells of a column."""
        return [row[place] for row in self.first if len(row) > place]


@dataclass(frozen=True)
class _Row:
    """A line with text: its cells, and the number of lines up to its end."""

    cells: tuple[str, ...]
    end: int

    @property
    def texts(self) -> list[str]:
        """The cells that are not empty."""
        return [cell for cell in self.cells if cell]

    @property
    def numbers(self) -> float:
        """The share of numbers in the cells that are not empty."""
        texts = self.texts
        return sum(map(_is_number, texts)) / max(len(texts), 1)

    @property
    def is_sample(self) -> bool:
        """Whether it is a row of numbers, of which some cells may be texts."""
        return len(self.cells) > 1 and self.numbers > 0.5


def csv_form(path: Path, reading: Reading) -> CsvForm:
    """Find the form of a CSV from its first lines.

    The separator is the character that divides most lines into numbers. The decimal mark is a comma
    if numbers in the first rows contain commas. Options take precedence.

    Raises:
        LogError: no line has the names of the columns.
    """
    # utf-8-sig removes the byte order mark of spreadsheets.
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = list(islice(file, _ROWS))
    excel = re.match("sep=(.)", lines[0]) if lines else None
    if excel:
        lines[0] = "\n"
    separator = reading.separator or (excel[1] if excel else _separator(lines))
    rows = _rows(lines, separator)
    names, first = _places(rows)
    notes = []
    if not reading.header:
        names, header = first, tuple(str(k + 1) for k in range(len(rows[first].cells)))
    elif names is None:
        header = _joint_state(rows[first].cells)
        notes = ["columns as `ros2 topic echo --csv` writes them"]
    else:
        header, first = rows[names].cells, names + 1
        if first < len(rows) and _has_units(rows[first]):
            notes = [f"line {rows[first].end} has the units"]
            header = tuple(map(_with_unit, header, rows[first].cells))
            first += 1
    if names:
        notes.append(f"lines before the table, not read: {rows[names].end - 1}")
    for row in rows[first : first + 1]:  # the rows, or the header, end with a separator
        if len(row.cells) == len(header) + 1 and not row.cells[-1]:
            header = (*header, "")
        elif len(header) == len(row.cells) + 1 and not header[-1]:
            header = header[:-1]
    cells = tuple(row.cells for row in rows[first:])
    commas = any(_COMMA.fullmatch(cell) for row in cells for cell in row)
    decimal = reading.decimal or ("," if commas else ".")
    skipped = rows[first - 1].end if first else int(excel is not None)
    return CsvForm(separator, decimal, header, skipped, cells, tuple(notes))


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell) is not None


def _rows(lines: Sequence[str], separator: str) -> list[_Row]:
    """Return the lines that are not empty, without the mark of a comment."""
    texts = [_COMMENT.sub("", line, count=1) for line in lines]
    if separator == " ":
        texts = [" ".join(line.split()) for line in texts]
    reader = csv.reader(texts, delimiter=separator)
    rows = [_Row(tuple(map(str.strip, cells)), reader.line_num) for cells in reader if cells]
    return rows or [_Row((), 0)]


def _separator(lines: Sequence[str]) -> str:
    """Return the separator that divides most lines into numbers; if there are none, the most
    frequent one of the first line.
    """
    top = next((line for line in lines if line.strip()), "")
    header = re.sub(r"\d,\d", "", top)

    def score(separator: str) -> tuple[float, int]:
        numbers = sum(row.numbers for row in _rows(lines, separator) if row.is_sample)
        return numbers, header.count(separator) if separator != " " else 0

    return max(_SEPARATORS, key=score)


def _places(rows: Sequence[_Row]) -> tuple[int | None, int]:
    """Return the row of the names, or None if there is none, and the first row of numbers.

    The names are those above the numbers with a name for most columns.
    """
    widths = Counter(len(row.cells) for row in rows if row.is_sample)
    if not widths:
        return 0, 0
    width = widths.most_common(1)[0][0]
    alike = [row.is_sample and len(row.cells) == width for row in rows]
    first = next((k for k, pair in enumerate(pairwise(alike)) if all(pair)), alike.index(True))
    above = [row for row in rows[:first] if len(row.cells) > 1]
    if above:
        # the rows, or the header, may end with a separator
        fit = [(abs(len(r.cells) - width) < 2, not r.is_sample, len(r.texts)) for r in above]
        return rows.index(above[fit.index(max(fit))]), first
    if rows[first].numbers < rows[min(first + 1, len(rows) - 1)].numbers:
        return first, first + 1  # some names are numbers
    return None, first


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit.strip(_BRACKETS)}]" if unit and not split_unit(name)[1] else name


def _has_units(row: _Row) -> bool:
    """Return whether most cells of a row are units, in brackets or without."""
    units = [cell for cell in row.texts if is_unit(cell.strip(_BRACKETS))]
    return not row.numbers and 2 * len(units) > len(row.texts)


def _joint_state(cells: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns that `ros2 topic echo --csv` writes of joint states.

    Raises:
        LogError: it is a row of something else.
    """
    n = (len(cells) - len(_STAMPED)) // len(_ARRAYS)
    if [*map(_is_number, cells)] != [True, True, *[False] * (n + 1), *[True] * (3 * n)]:
        refuse(f"the first line, {cells[0]}.., has no names of columns", NO_HEADER)
    return *_STAMPED, *(f"{name}{k}" for name in _ARRAYS for k in range(n))


def read_csv(path: Path, form: CsvForm, used: Mapping[str, str]) -> Any:
    """Return columns of a CSV as an Arrow table of numbers; times may be dates or durations.

    Args:
        path: the file.
        form: form of the CSV.
        used: number of a column, from 0 -> log column.

    Raises:
        LogError: a row has another number of cells than the header, or a cell is not a number.
    """
    import pyarrow as pa

    if not form.first:
        refuse("has a header and no samples", form.accepted)
    rows: list[Any] = []  # rows with another number of cells
    table = partial(_table, path, form, list(used), rows)
    times = [k for k, name in used.items() if name in ("t", FRACTION)]
    numbers = {k: pa.float64() for k in used if k not in times}
    error = "column t holds no times"
    for types in (numbers, numbers | dict.fromkeys(times, pa.string())):
        try:
            found = _with_times(table(types), times)
        except pa.ArrowInvalid as invalid:
            error = str(invalid)
        else:
            if found is not None:
                return found
    rows.clear()
    # The reader counts rows on a single thread only.
    with suppress(pa.ArrowInvalid):
        texts = table(dict.fromkeys(used, pa.string()), threads=False)
        _require_numbers(texts.to_pydict(), form, used)
    if rows:
        sample, cells = rows[0].number - form.skipped - 1, rows[0].actual_columns
        error = f"sample {sample}: {cells} values for {len(form.header)} columns"
    return refuse(error, form.accepted)


def texts_of(path: Path, form: CsvForm, place: int) -> list[str]:
    """Return the different texts of a column of a CSV; those of its first rows if a row is odd."""
    import pyarrow as pa

    with suppress(pa.ArrowInvalid):
        table = _table(path, form, [str(place)], [], {str(place): pa.string()})
        return list(map(str.strip, table.column(0).unique().to_pylist()))
    return list(dict.fromkeys(form.cells(place)))


def _table(
    path: Path,
    form: CsvForm,
    used: Sequence[str],
    odd: list[Any],
    types: Mapping[str, Any],
    threads: bool = True,
) -> Any:
    """Return columns of a CSV as an Arrow table.

    Args:
        path, form: the file and its form.
        used: numbers of the columns, from 0.
        odd: receives the first row with another number of cells.
        types: number of a column -> Arrow type; other types follow from the cells.
        threads: whether to read by several threads.

    Raises:
        ArrowInvalid: a row has another number of cells, or a cell is not of the type.
    """
    import pyarrow.csv as pacsv

    def refused(row: Any) -> str:
        odd.append(row)
        return "error"

    names = [str(k) for k in range(len(form.header))]
    return pacsv.read_csv(
        _content(path) if form.separator == " " else path,
        pacsv.ReadOptions(column_names=names, skip_rows=form.skipped, use_threads=threads),
        pacsv.ParseOptions(delimiter=form.separator, invalid_row_handler=refused),
        pacsv.ConvertOptions(include_columns=used, column_types=types, decimal_point=form.decimal),
    )


def _content(path: Path) -> Any:
    """Return a CSV with a single blank between its columns."""
    import pyarrow as pa

    lines = path.read_bytes().split(b"\n")
    return pa.BufferReader(b"\n".join(b" ".join(line.split()) for line in lines))


def _with_times(table: Any, columns: Sequence[str]) -> Any:
    """Return a table with texts of durations converted; None if a column holds no times."""
    import pyarrow as pa

    tests = (pa.types.is_integer, pa.types.is_floating, pa.types.is_timestamp)
    for k in columns:
        column = table.column(k)
        if any(test(column.type) for test in tests):
            continue
        found = durations(column.to_pylist()) if pa.types.is_string(column.type) else None
        if found is None:
            return None
        table = table.set_column(table.schema.get_field_index(k), k, pa.array(found))
    return table


def _require_numbers(
    texts: Mapping[str, Sequence[str]], form: CsvForm, used: Mapping[str, str]
) -> None:
    """Refuse the first cell of a CSV that is not a number."""
    swapped = str.maketrans(",.", ".,") if form.decimal == "," else {}
    for k, name in used.items():
        if name == "t" and (all(map(_DATE.match, texts[k])) or durations(texts[k]) is not None):
            continue
        for sample, cell in enumerate(texts[k]):
            try:
                float(cell.translate(swapped) or "nan")
            except ValueError:
                header = form.header[int(k)]
                shown = name if header == name else f"{header} ({name})"
                what = f"column {shown}, sample {sample}: {cell[:40]!r} is not a number"
                refuse(what, f"{_TIMES}, in {form.accepted}" if name == "t" else form.accepted)
