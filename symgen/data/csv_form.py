"""The form of a CSV: its separator, its decimal mark, and the names of its columns."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from symgen.data.raw import Reading, refuse

_ROWS = 200  # rows that show the decimal mark
_NUMBER = re.compile(r"[+-]?[0-9.,]+([eE][+-]?[0-9]+)?|nan|inf", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")
_SHOWN = {"\t": "tabs", ";": "semicolons", " ": "blanks", ",": "commas"}


@dataclass(frozen=True)
class CsvForm:
    """The form of a CSV.

    Attributes:
        separator: character between columns.
        decimal: decimal mark.
        header: column names of the file; "" for a column without one.
        skipped: lines before the first sample.
        first: cells of the first rows.
    """

    separator: str
    decimal: str
    header: tuple[str, ...]
    skipped: int
    first: tuple[tuple[str, ...], ...]

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


def csv_form(path: Path, reading: Reading) -> CsvForm:
    """Find the form of a CSV from its first lines.

    The separator is the most frequent of commas, semicolons and tabs in the header. The decimal
    mark is a comma if numbers in the first rows contain commas. Options take precedence.

    Raises:
        LogError: the header is a row of numbers.
    """
    # utf-8-sig removes the byte order mark of spreadsheets.
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = list(islice(file, _ROWS))
    excel = re.match("sep=(.)", lines[0]) if lines else None
    top = next((line for line in lines[excel is not None :] if line.strip()), "")
    usual = max(",;\t", key=re.sub(r"\d,\d", "", top).count)
    found = excel[1] if excel else usual
    separator = reading.separator or found
    reader = csv.reader(lines, delimiter=separator)
    if excel:
        next(reader)
    skipped = reader.line_num
    rows = [next(filter(None, reader), [])]
    if reading.header:
        skipped = reader.line_num
    rows += filter(None, reader)
    header = [name.strip() for name in rows[0]]
    if not reading.header:
        header = [str(k + 1) for k in range(len(header))]
    elif len(header) > 1 and all(map(_NUMBER.fullmatch, header)):
        what = f"the first line, {header[0]}.., has no names of columns"
        refuse(what, '--no-header --columns "t=1,q1=2,..", with the places of t, q1.., tau1..')
    first = rows[1:] if reading.header else rows
    for row in first[:1]:  # the rows, or the header, end with a separator
        if len(row) == len(header) + 1 and not row[-1].strip():
            header.append("")
        elif len(header) == len(row) + 1 and not header[-1]:
            header.pop()
    commas = any(_COMMA.fullmatch(cell.strip()) for row in first for cell in row)
    decimal = reading.decimal or ("," if commas else ".")
    return CsvForm(separator, decimal, tuple(header), skipped, tuple(map(tuple, first)))
