"""Split a long kernel into several functions, for compilers and code reviews.

Statements keep their order. A value that a later part needs is stored in an array of the caller, so
parts have no state.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

#: Largest number of statements of a function.
LIMIT = 2000
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*")
_DEFINED = re.compile(r"const (\w+) (\w+) = ")
_LOCAL = re.compile(r"(?:const )?\w+ (\w+)(?:\[\d+\])? = ")  # local unless also _DEFINED
_ANGLES = re.compile(r"\w+_angles(\d)")


@dataclass(frozen=True)
class Parts:
    """The lines of the functions of a kernel, and the number of values passed between them."""

    parts: tuple[tuple[str, ...], ...]
    handed: int


def in_parts(body: Sequence[str], arguments: Sequence[str]) -> Parts:
    """Split a body into functions of at most LIMIT statements; no parts if it is short enough.

    Args:
        body: lines of a kernel, one statement each.
        arguments: names of its inputs and outputs.
    """
    if len(body) <= LIMIT:
        return Parts((), 0)
    lines, size = [line for line in body if not line.startswith("(void)")], LIMIT
    while True:
        size = size * 3 // 4
        found = _cut(lines, arguments, size)
        if all(len(part) <= LIMIT for part in found.parts):
            return found


def _cut(lines: Sequence[str], arguments: Sequence[str], size: int) -> Parts:
    groups: list[list[str]] = [[]]
    depth, held = 0, -1
    last = {word: at for at, line in enumerate(lines) for word in _WORD.findall(line)}
    home: dict[str, tuple[int, str]] = {}  # value -> part that defines it, and type
    for at, line in enumerate(lines):
        if len(groups[-1]) >= size and depth == 0 and at > held:
            groups.append([])
        groups[-1].append(line)
        depth += line.count("{") - line.count("}")
        if (found := _DEFINED.match(line)) is not None:
            home[found[2]] = len(groups) - 1, found[1]
        elif (found := _LOCAL.match(line)) is not None:
            held = max(held, last[found[1]])
    used = [{word for line in group for word in _WORD.findall(line)} for group in groups]
    place: dict[str, dict[str, str]] = {}  # value -> places of its numbers in the array
    handed = 0
    for name, (number, kind) in home.items():
        if any(name in words for words in used[number + 1 :]):
            numbers = _numbers(name, kind)
            place[name] = {x: f"w[{handed + i}]" for i, x in enumerate(numbers)}
            handed += len(numbers)
    parts = []
    for number, group in enumerate(groups):
        body = [f"(void){a};" for a in arguments if a not in used[number]]
        for name, at_w in place.items():
            if home[name][0] < number and name in used[number]:
                body.append(f"const {home[name][1]} {name} = {_value(list(at_w.values()))};")
        if not any("w[" in line for line in body) and not any(home[n][0] == number for n in place):
            body.append("(void)w;")
        for line in group:
            body.append(line)
            if (found := _DEFINED.match(line)) is not None:
                body += [f"{w} = {x};" for x, w in place.get(found[2], {}).items()]
        parts.append(tuple(body))
    return Parts(tuple(parts), handed)


def _numbers(name: str, kind: str) -> list[str]:
    """Return the numbers of a value: cosines, then sines, of several angles; else the value."""
    angles = _ANGLES.fullmatch(kind)
    if angles is None:
        return [name]
    return [f"{name}.{member}[{k}]" for member in "cs" for k in range(int(angles[1]))]


def _value(numbers: list[str]) -> str:
    half = len(numbers) // 2
    both = (", ".join(part) for part in (numbers[:half], numbers[half:]))
    return f"{{ {', '.join(f'{{ {part} }}' for part in both)} }}" if half else numbers[0]
