"""A long kernel in several functions: what compilers and code reviews bear in one piece.

Statements keep their order. A value that a later part needs is stored in an array of the caller's
and read there again, so that a part stays plain C with no state.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

#: Statements of one function at most.
LIMIT = 2000
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*")
_DEFINED = re.compile(r"const (\w+) (\w+) = ")
_LOCAL = re.compile(r"(?:const )?\w+ (\w+)(?:\[\d+\])? = ")  # not handed on where no _DEFINED
_ANGLES = re.compile(r"\w+_angles(\d)")


@dataclass(frozen=True)
class Part:
    """One function of a kernel: its number, and the lines of its body."""

    number: int
    body: tuple[str, ...]


@dataclass(frozen=True)
class Parts:
    """A kernel's functions in order, and how many values they hand on."""

    parts: tuple[Part, ...]
    handed: int


def in_parts(
    body: Sequence[str], arguments: Sequence[str], dtype: str, limit: int = LIMIT
) -> Parts:
    """Cut a body into functions of at most `limit` statements; no parts where it is short enough.

    Args:
        body: the lines of a kernel, one statement each.
        arguments: the names of its inputs and outputs.
        dtype: double or float.
        limit: statements of one function.
    """
    if len(body) <= limit:
        return Parts((), 0)
    size = limit
    while True:
        size = size * 3 // 4
        found = _cut(
            [line for line in body if not line.startswith("(void)")], arguments, dtype, size
        )
        if all(len(part.body) <= limit for part in found.parts):
            return found


def _cut(lines: Sequence[str], arguments: Sequence[str], dtype: str, size: int) -> Parts:
    groups: list[list[str]] = [[]]
    depth, held = 0, -1
    last = {word: at for at, line in enumerate(lines) for word in _WORD.findall(line)}
    for at, line in enumerate(lines):
        if len(groups[-1]) >= size and depth == 0 and at > held:
            groups.append([])
        groups[-1].append(line)
        depth += line.count("{") - line.count("}")
        if _DEFINED.match(line) is None and (found := _LOCAL.match(line)) is not None:
            held = max(held, last[found[1]])
    home: dict[str, int] = {}
    kind: dict[str, str] = {}
    for number, group in enumerate(groups):
        for line in group:
            if (found := _DEFINED.match(line)) is not None:
                home[found[2]], kind[found[2]] = number, found[1]
    used = [{word for line in group for word in _WORD.findall(line)} for group in groups]
    place: dict[str, int] = {}
    values = 0
    for name, number in home.items():
        if any(name in words for words in used[number + 1 :]):
            place[name] = values
            values += _count(kind[name], dtype)
    parts = []
    for number, group in enumerate(groups):
        taken = [n for n in place if home[n] < number and n in used[number]]
        read = [_read(n, kind[n], place[n], dtype) for n in taken]
        kept = {n: _kept(n, kind[n], place[n], dtype) for n in place if home[n] == number}
        body = []
        for line in group:
            body.append(line)
            if (found := _DEFINED.match(line)) is not None:
                body += kept.get(found[2], [])
        if not taken and not kept:
            body.insert(0, "(void)w;")
        unused = [f"(void){a};" for a in arguments if a not in used[number]]
        parts.append(Part(number + 1, (*unused, *read, *body)))
    return Parts(tuple(parts), values)


def _count(kind: str, dtype: str) -> int:
    return 1 if kind == dtype else 2 * _several(kind)


def _several(kind: str) -> int:
    found = _ANGLES.fullmatch(kind)
    assert found is not None, kind
    return int(found[1])


def _read(name: str, kind: str, at: int, dtype: str) -> str:
    if kind == dtype:
        return f"const {dtype} {name} = w[{at}];"
    count = _several(kind)
    halves = (", ".join(f"w[{at + half * count + k}]" for k in range(count)) for half in (0, 1))
    return f"const {kind} {name} = {{ {', '.join(f'{{ {h} }}' for h in halves)} }};"


def _kept(name: str, kind: str, at: int, dtype: str) -> list[str]:
    if kind == dtype:
        return [f"w[{at}] = {name};"]
    count = _several(kind)
    return [
        f"w[{at + half * count + k}] = {name}.{member}[{k}];"
        for half, member in enumerate("cs")
        for k in range(count)
    ]
