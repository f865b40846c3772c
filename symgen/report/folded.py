"""Shorten formulas of base parameters: factor out common factors, abbreviate long sums."""

from __future__ import annotations

import re
from itertools import groupby

from symgen.robot.expressions import six_digits

_NAME = re.compile(r"([A-Z]+)(\d+)")


def folded(formula: str) -> str:
    """Return a sum with collected common factors, "0.1*(M3 + ... + M7)", and six digits.

    Groups keep the order of their first terms. Other formulas stay unchanged.

    Args:
        formula: such as "ZZ1 + IA1 + 0.1*M3 + 0.1*M4 + 0.1*M5".
    """
    sums: dict[str, list[tuple[str, str]]] = {}
    for sign, term in _terms(six_digits(formula)):
        factor, _, name = term.rpartition("*")
        if not factor or not _NAME.fullmatch(name):  # the term is not part of a group
            factor, name = term, ""
        sums.setdefault(factor, []).append((sign, name))
    parts = []
    for factor, members in sums.items():
        (first, name), *more = members
        if more and name:
            inner = [("+" if sign == first else "-", n) for sign, n in members]
            name = f"({_joined(inner)})"
        parts.append((first, f"{factor}*{name}" if name else factor))
    return _joined(parts)


def _terms(formula: str) -> list[tuple[str, str]]:
    """Return sign and text of the terms of a sum, outside parentheses."""
    first, *rest = re.split(r" ([+-]) ", formula.removeprefix("-"))
    out = [("-" if formula.startswith("-") else "+", first)]
    for sign, text in zip(rest[::2], rest[1::2], strict=True):
        begun, term = out[-1]
        if term.count("(") > term.count(")"):
            out[-1] = (begun, f"{term} {sign} {text}")
        else:
            out.append((sign, text))
    return out


def _run(members: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Shorten four or more consecutive terms with one sign: M3, M4, M5, M6 become M3, ..., M6."""
    out: list[tuple[str, str]] = []

    def key(entry: tuple[int, tuple[str, str]]) -> tuple[str, str, int]:
        place, (sign, name) = entry
        found = _NAME.fullmatch(name)
        return (sign, found[1], place - int(found[2])) if found else (sign, name, place)

    for (sign, _, _), group in groupby(enumerate(members), key):
        names = [name for _, (_, name) in group]
        if len(names) > 3:
            names = [names[0], "...", names[-1]]
        out += [(sign, name) for name in names]
    return out


def _joined(members: list[tuple[str, str]]) -> str:
    (first, name), *rest = _run(members)
    return ("-" if first == "-" else "") + name + "".join(f" {sign} {n}" for sign, n in rest)
