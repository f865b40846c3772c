"""Print a tape as C99: one `const` for each step.

Terms and factors keep the order of the tape, and literals come from `repr`, so the text depends
only on the robot. Each output is stored as soon as it is computed, because unstored values would
fill the registers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby

import sympy as sp

from symgen.codegen.kernel import LINK, SCALARS, Kernel
from symgen.errors import SymgenError
from symgen.symbolic.tape import Steps, Values, symbols_in

DTYPES = ("double", "float")
_ANGLES = (4, 2, 1)  # numbers of angles for which the package has a combined sincos
_ZEROS = 4  # zeros that one loop iteration stores
_FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tanh", "sign", "exp", "log")},
    "Abs": "fabs",
}


@dataclass(frozen=True)
class CFunction:
    """The lines of a kernel body and the functions that they need, for a template."""

    body: tuple[str, ...]
    needs_math: bool
    needs_sincos: bool = False


@lru_cache(maxsize=10_000)
def literal(value: sp.Expr, dtype: str) -> str:
    """Return a number as the shortest C literal that reads back to the same value."""
    number = float(value.evalf(50))
    if not math.isfinite(number):
        raise SymgenError(f"the constant {value} does not fit a {dtype}")
    if dtype == "float":
        import numpy as np

        return f"{_decimal(repr(float(str(np.float32(number)))))}f"
    return _decimal(repr(number))


def _decimal(digits: str) -> str:
    return digits if any(mark in digits for mark in ".en") else f"{digits}.0"


class Printer:
    """Writes the body of one kernel. Subclasses write other types of values.

    Args:
        kernel: the kernel.
        geometry: named length -> its macro.
        values: named length -> exact value, for derived constants.
        dtype: double or float.
        prefix: prefix of the names in the package. In double, its sincos then takes several angles
            at once. With None, the functions of libm take one angle each.
    """

    def __init__(
        self,
        kernel: Kernel,
        geometry: Mapping[sp.Symbol, str],
        values: Values,
        dtype: str,
        prefix: str | None = None,
    ) -> None:
        tape = kernel.tape
        self.prefix = prefix
        self.kernel, self.tape, self.values, self.dtype = kernel, tape, values, dtype
        self.first = kernel.first
        self.word: dict[sp.Expr, str] = {s: s.name for s in tape.order}
        for name, symbols in tape.inputs:
            if name in SCALARS:
                self.word |= dict.fromkeys(symbols, name)
            elif name != LINK:
                self.word |= {s: f"{name}[{i}]" for i, s in enumerate(symbols)}
        self.word |= {s: m for s, m in geometry.items() if s in tape.order}
        self.geometry = geometry

    @property
    def value(self) -> str:
        """Type of values that depend on the sample."""
        return self.dtype

    @property
    def own(self) -> str | None:
        """Prefix of the sincos of several angles; None without one."""
        return self.prefix if self.dtype == "double" else None

    def function(self) -> CFunction:
        read = (*(e for _, e in self.tape.steps), *self.tape.outputs)
        used = set().union(*map(symbols_in, read))
        lines = [
            f"(void){name};" for name, symbols in self.tape.inputs if not used.intersection(symbols)
        ]
        lines += [
            f"const {self.dtype} {symbol.name} = ({self.dtype})(link == {i}u);"
            for name, symbols in self.tape.inputs
            for i, symbol in enumerate(symbols, self.first)
            if name == LINK and symbol in used
        ]
        lines += [
            f"const {self.dtype} {symbol.name} = {literal(value.subs(self.values), self.dtype)};"
            for symbol, value in self.tape.constants
            if symbol not in self.geometry
        ]
        first, calls = self.angles(self.own) if self.own else ((), [])
        stores = self.stores()
        lines += stores.pop(None, [])
        done = {symbol for symbol, _ in first}
        for symbol, expr in first:
            lines += [self.step(symbol, expr), *stores.pop(symbol, [])]
        lines += calls
        for symbol, expr in (s for s in self.tape.steps if s[0] not in done):
            lines += [self.step(symbol, expr), *stores.pop(symbol, [])]
        lines += self.verdict()
        needs_math = any(
            e.is_Function and e.func is not sp.sign and e not in self.word
            for _, e in self.tape.steps
        )
        return CFunction(tuple(lines), needs_math, bool(calls))

    def verdict(self) -> list[str]:
        """Return the array of the guards of a kernel; the template derives its status from them."""
        count = len(self.kernel.guards)
        guards = [self.expression(e) for e in self.tape.outputs[self.kernel.size :]]
        return [f"const {self.dtype} guard[{count}] = {{ {', '.join(guards)} }};"] if count else []

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        return f"const {self.dtype} {symbol.name} = {self.expression(expr)};"

    def stored(self, place: str, result: sp.Expr) -> str:
        return f"{place} = {self.expression(result)};"

    def stores(self) -> dict[sp.Symbol | None, list[str]]:
        """Return step -> stores that follow it; None -> stores that need no step."""
        steps = {s for s, _ in self.tape.steps}
        at: dict[sp.Symbol | None, list[str]] = {}
        for output, results in self.kernel.split(self.tape.outputs):
            zeros = [i for i, result in enumerate(results) if result == 0]
            at.setdefault(None, []).extend(self.cleared(output.name, zeros))
            for i, result in enumerate(results):
                place = f"{output.name}[{i}]"
                if result != 0 and self.word.get(result) != place:  # leave out unchanged entries
                    (symbol,) = symbols_in(result) & steps or {None}
                    line = self.stored(place, result)
                    at.setdefault(symbol, []).append(line)
        return at

    def cleared(self, name: str, places: Sequence[int]) -> Iterator[str]:
        """Yield stores of zeros, four in each loop iteration, which compilers vectorise."""
        zero = literal(sp.S.Zero, self.dtype)
        for _, group in groupby(enumerate(places), key=lambda pair: pair[1] - pair[0]):
            run = [place for _, place in group]
            multiple = len(run) // _ZEROS * _ZEROS if len(run) >= 2 * _ZEROS else 0
            if multiple:
                end = run[0] + multiple
                yield f"for (size_t i = {run[0]}u; i < {end}u; i += {_ZEROS}u) {{"
                yield from (f"    {name}[i + {k}u] = {zero};" for k in range(_ZEROS))
                yield "}"
            yield from (f"{name}[{i}] = {zero};" for i in run[multiple:])

    def angles(self, prefix: str) -> tuple[Steps, list[str]]:
        """Return the steps that joint angles need, and the sincos calls for all angles.

        Neighbours in an input array are read in place; other angles are gathered. Angles that
        depend on the cosine of another angle use libm.
        """
        known = {s: (name, i) for name, group in self.tape.inputs for i, s in enumerate(group)}
        dependent: set[sp.Symbol] = set()
        wanted: list[sp.Expr] = []
        for symbol, expr in self.tape.steps:
            on_angle = expr.func in (sp.sin, sp.cos)
            free = dependent.isdisjoint(symbols_in(expr))
            if on_angle or not free:
                dependent.add(symbol)
            if on_angle and free and expr.args[0] not in wanted:
                wanted.append(expr.args[0])
        needed = {s for angle in wanted for s in symbols_in(angle)}
        first = []
        for symbol, expr in reversed(self.tape.steps):
            if symbol in needed:
                needed |= symbols_in(expr)
                first.append((symbol, expr))
        lines: list[str] = []
        plain = sorted((a for a in wanted if a in known), key=lambda a: known[a])
        for _, group in groupby(
            enumerate(plain), key=lambda pair: (known[pair[1]][0], known[pair[1]][1] - pair[0])
        ):
            run = [angle for _, angle in group]
            name, start = known[run[0]]
            lines += self.turned(prefix, run, name, start)
        others = [a for a in wanted if a not in known]
        if others:
            gathered = ", ".join(self.expression(a) for a in others)
            lines.append(f"const {self.value} angle[{len(others)}] = {{ {gathered} }};")
            lines += self.turned(prefix, others, "angle", 0)
        return tuple(reversed(first)), lines

    def turned(
        self, prefix: str, angles: Sequence[sp.Expr], name: str, start: int
    ) -> Iterator[str]:
        """Yield the sincos calls for consecutive angles of an array."""
        at = 0
        while at < len(angles):
            count = next(c for c in _ANGLES if c <= len(angles) - at)
            result = f"{name}_{start + at}"
            place = f"&{name}[{start + at}]" if start + at else name
            yield f"const {prefix}_angles{count} {result} = {prefix}_sincos{count}({place});"
            for k, angle in enumerate(angles[at : at + count]):
                self.word[sp.cos(angle)] = f"{result}.c[{k}]"
                self.word[sp.sin(angle)] = f"{result}.s[{k}]"
            at += count

    def expression(self, expr: sp.Expr) -> str:
        word = self.word.get(expr)
        if word is not None:
            return word
        if expr.is_number:
            return literal(expr, self.dtype)
        if expr.is_Pow and expr.exp == -1:
            one = "1.0f" if self.dtype == "float" else "1.0"
            return f"{one} / {self.factor(expr.base)}"
        if expr.is_Function:
            return self.called(_FUNCTIONS[expr.func.__name__], expr.args[0])
        out = ""
        for negative, factors in self.tape.terms(expr):
            product = " * ".join(self.factor(f) for f in factors)
            if out:
                out += f" - {product}" if negative else f" + {product}"
            else:
                out = f"-{product}" if negative else product
        return out

    def called(self, name: str, argument: sp.Expr) -> str:
        """Return the C text of a function call: a function of libm, or the sign."""
        v = self.expression(argument)
        if name == "sign":
            zero = literal(sp.S.Zero, self.dtype)
            return f"({self.dtype})(({v} > {zero}) - ({v} < {zero}))"
        suffix = "f" if self.dtype == "float" else ""
        return f"{name}{suffix}({v})"

    def factor(self, expr: sp.Expr) -> str:
        written = self.expression(expr)
        return f"({written})" if expr.is_Add else written
