"""Errors and warnings of symgen. Each message is one line for the user."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

#: Number of characters to keep at the start and at the end of a long message.
_START, _END = 1500, 300
#: Unicode categories that a terminal interprets or cannot display: control characters, marks of
#: direction, lone surrogates, line and paragraph separators.
_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")


def plain(text: str) -> str:
    """Return an untrusted text as one line that is safe to print.

    Line breaks become spaces; other invisible characters become Python escapes.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        c if unicodedata.category(c) not in _UNSEEN else c.encode("unicode_escape").decode()
        for c in " ".join(text.splitlines()).replace("\t", " ")
    )


def message(text: str) -> str:
    """Return a message as one line of bounded length."""
    ends = 2 * _START  # two characters can be one line break
    if len(text) > 2 * ends:
        text = text[:ends] + text[-ends:]
    line = plain(text)
    return line if len(line) <= _START + _END else f"{line[:_START]} ... {line[-_END:]}"


def first_of(items: Sequence[str], most: int = 8) -> str:
    """List the first items, with dots if there are more."""
    return ", ".join(items[:most]) + (", ..." if len(items) > most else "")


def shortened(written: str, length: int = 60) -> str:
    """Shorten a text for a message."""
    return written if len(written) <= length else f"{written[: length - 3]}..."


def message_of(error: Exception) -> str:
    """Return the message of an exception as one line of at most 300 characters."""
    line = " ".join(str(getattr(error, "strerror", None) or error).split())
    return line if len(line) <= 300 else f"{line[:297]}..."


class SymgenError(Exception):
    """Root of every error that symgen raises on purpose.

    The message has one line: what is wrong, where, and what is accepted.
    """

    def __init__(self, text: str = "") -> None:
        super().__init__(message(text))


@contextmanager
def located(place: object) -> Iterator[None]:
    """Prefix the messages of errors raised inside with a place, such as a file or an entry."""
    try:
        yield
    except SymgenError as error:
        raise type(error)(f"{place}: {error}") from error


class RobotError(SymgenError):
    """A robot file, or a robot built in Python, is not a valid mechanism."""


class ExpressionError(RobotError):
    """A text in a robot file is not a valid expression."""


class LogError(SymgenError):
    """A measured log cannot be read, or does not belong to the robot."""


class ParameterError(SymgenError):
    """Parameter values are missing, unknown, or not finite."""


class PackageError(SymgenError):
    """A generated package cannot be written or read, or is not valid."""


class BuildError(SymgenError):
    """The C sources of a model could not be compiled or loaded."""


class IdentificationError(SymgenError):
    """The logs do not determine the requested parameters, or an option does not fit."""


class SymgenWarning(UserWarning):
    """The input is allowed but probably not intended."""

    def __init__(self, text: str = "") -> None:
        super().__init__(message(text))
