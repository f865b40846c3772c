"""The errors that symgen raises: one tree, one line each, written for the person who reads them."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

#: Of a message that quotes a long file: the characters kept at its start, and at its end.
_START, _END = 1500, 300
#: Categories of what a terminal obeys or cannot show: controls, marks of direction, lone
#: surrogates, breaks of lines and paragraphs.
_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")


def plain(text: str) -> str:
    """Return a text of unknown origin as one line that a terminal only shows.

    Breaks of lines become spaces; other characters that are not seen are written as in Python.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        c if unicodedata.category(c) not in _UNSEEN else c.encode("unicode_escape").decode()
        for c in " ".join(text.splitlines()).replace("\t", " ")
    )


def message(text: str) -> str:
    """Return a message in one line of at most 2,000 characters."""
    if len(text) > 2 * (_START + _END):
        text = f"{text[: _START + _END]} ... {text[-_START - _END :]}"
    line = plain(text)
    return line if len(line) <= _START + _END else f"{line[:_START]} ... {line[-_END:]}"


def first_of(items: Sequence[str], most: int) -> str:
    """Return the first of some items in one line, with dots where there are more."""
    return ", ".join(items[:most]) + (", ..." if len(items) > most else "")


def told_by(error: Exception) -> str:
    """Return what the system or a library says of an error, in one line of 300 characters."""
    line = " ".join(str(getattr(error, "strerror", None) or error).split())
    return line if len(line) <= 300 else f"{line[:297]}..."


class SymgenError(Exception):
    """Root of every error that symgen raises on purpose.

    The message says in one line what went wrong, where, and what is accepted.
    """

    def __init__(self, text: str = "") -> None:
        super().__init__(message(text))


@contextmanager
def located(place: object) -> Iterator[None]:
    """Put a place, as a file or an entry of it, before what errors say that are raised inside."""
    try:
        yield
    except SymgenError as error:
        raise type(error)(f"{place}: {error}") from error


class RobotError(SymgenError):
    """A robot file, or a robot built in Python, is not a valid mechanism."""


class ExpressionError(RobotError):
    """A text in a robot file is not an expression of the safe grammar."""


class LogError(SymgenError):
    """A measured log cannot be read, or does not belong to the robot."""


class ParameterError(SymgenError):
    """Parameter values are missing, unknown, or not finite."""


class PackageError(SymgenError):
    """A generated package cannot be written, read, or is not what it should be."""


class BuildError(SymgenError):
    """The C sources of a model could not be compiled or loaded."""


class IdentificationError(SymgenError):
    """The data cannot determine the parameters that were asked for."""


class SymgenWarning(UserWarning):
    """Something in the input is allowed but probably not meant."""

    def __init__(self, text: str = "") -> None:
        super().__init__(message(text))
