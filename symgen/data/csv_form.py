"""The form of a CSV: its separator, its decimal mark, and its header."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import StringIO
from itertools import islice
from pathlib import Path

from symgen.data.raw import refuse

#: Separators that the header shows, the first one where it has none.
SEPARATORS = (",", ";", "\t")
_CHARACTERS = 1 << 20  # to look at
_ROWS = 200
_NUMBER = re.compile(r"[+-]?([0-9.,]+([eE][+-]?[0-9]+)?|nan|inf)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")
_POINT = re.compile(r"[+-]?[0-9]*\.[0-9]+([eE][+-]?[0-9]+)?")
_SHOWN = {"\t": "tabs", ";": "semicolons", " ": "blanks", ",": "commas"}


@dataclass(frozen=True)
class CsvForm:
    """The form of a CSV.

    Attributes:
        separator: character between columns.
        header: column names of the file; "" for a column without one.
        skipped: lines before the first sample.
        first: cells of the first rows.
    """

    separator: str
    header: tuple[str, ...]
    skipped: int
    first: tuple[tuple[str, ...], ...]

    @property
    def shown(self) -> str:
        """The separator in words."""
        return _SHOWN.get(self.separator, repr(self.separator))

    @property
    def accepted(self) -> str:
        """What is accepted where a row is not, with the option to type."""
        mark = "" if self.separator == "," else " or commas"
        other = ";" if self.separator != ";" else ","
        return (
            f"at least 10 rows of numbers with decimal points{mark}, separated by {self.shown}, or "
            f"by another character: --separator '{other}'"
        )

    def uneven(self, sample: int, cells: int) -> str:
        """Return the message for a row with another number of cells than the header."""
        own = len(self.header)
        # Commas that separate columns and decimals alike leave up to twice as many cells.
        commas = self.separator == "," and own < cells <= 2 * own
        why = ", as if decimals had commas too" if commas else ""
        return f"sample {sample}: {cells} values for {own} columns{why}"

    def cells(self, place: int) -> list[str]:
        """Return the first cells of a column."""
        return [row[place] for row in self.first if len(row) > place]

    def decimal(self, places: Sequence[int]) -> str:
        """Return the decimal mark of some columns.

        Raises:
            LogError: the numbers have both marks.
        """
        marks: dict[str, str] = {}
        for cell in (c.strip() for place in places for c in self.cells(place)):
            for mark, form in ((",", _COMMA), (".", _POINT)):
                if form.fullmatch(cell):
                    marks.setdefault(mark, cell)
        if len(marks) > 1:
            refuse(f"numbers are written {marks['.']} and {marks[',']}", "one decimal mark")
        return next(iter(marks), ".")

    def rows(self, path: Path) -> Iterator[list[str]]:
        """Yield the cells of all rows below the header."""
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            for _ in range(self.skipped):
                file.readline()
            yield from (row for row in csv.reader(file, delimiter=self.separator) if row)


def csv_form(path: Path, separator: str = "", headed: bool = True) -> CsvForm:
    """Find the form of a CSV from its first lines.

    A separator is right if header and first row have equal numbers of cells.

    Args:
        path: the file.
        separator: its separator; "" to find it.
        headed: whether it has a header; without one, its columns are 1, 2, ..

    Raises:
        LogError: the file is no text in UTF-8, has numbers as header, or two separators are
            possible.
    """
    try:
        # utf-8-sig removes the byte order mark of spreadsheets.
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = "".join(_lines(file))
        asked = re.match(r"sep=(.)\r?\n", text)  # a line that Excel writes
        candidates = (separator,) if separator else (asked[1],) if asked else SEPARATORS
    except UnicodeDecodeError:
        refuse("is not a text file", "CSV in UTF-8")
    forms = []
    for one in candidates:
        with suppress(csv.Error):  # a long header without this separator is a field too long
            forms.append(_parsed(text, one, asked is not None, headed))
    if not forms:
        refuse("is not a text file", "CSV in UTF-8")
    several = [f for f in forms if len(f.header) > 1]
    even = [f for f in several if f.first and len(f.first[0]) == len(f.header)]
    if len(even) > 1:
        shown = " or ".join(f.shown for f in even)
        refuse(f"columns may be separated by {shown}", f"--separator '{even[0].separator}'")
    form = (even or sorted(several, key=lambda f: -len(f.header)) or forms)[0]
    if headed and len(form.header) > 1 and all(map(_NUMBER.fullmatch, form.header)):
        what = f"the first line, {form.header[0]}.., has no names of columns"
        refuse(what, '--no-header --columns "t=1,q1=2,..", with the places of t, q1.., tau1..')
    if even or not form.first:
        return form
    if len(form.first[0]) > len(form.header):
        refuse(form.uneven(0, len(form.first[0])), form.accepted)
    return form


def _lines(file: Iterable[str]) -> Iterator[str]:
    """Yield the first lines: a header may be long, so that they are not counted in characters."""
    size = 0
    for k, line in enumerate(islice(file, _ROWS + 2)):
        yield line
        size += len(line)
        if k > 3 and size > _CHARACTERS:
            return


def _parsed(text: str, separator: str, hinted: bool, headed: bool) -> CsvForm:
    reader = csv.reader(StringIO(text), delimiter=separator)
    if hinted:
        next(reader)
    skipped = reader.line_num
    header = [name.strip() for name in next(filter(None, reader), [])]
    first = []
    if headed:
        skipped = reader.line_num
    else:
        first = [tuple(header)]
        header = [str(k + 1) for k in range(len(header))]
    first += [tuple(row) for row in islice(filter(None, reader), _ROWS + 1)]
    first = first[:-1] if len(first) > 1 else first  # the last one may be cut off
    if first:  # a separator at the end of lines, of the header or of the rows
        if len(first[0]) == len(header) + 1 and not first[0][-1].strip():
            header.append("")
        elif len(header) == len(first[0]) + 1 and not header[-1]:
            header.pop()
    return CsvForm(separator, tuple(header), skipped, tuple(first))
