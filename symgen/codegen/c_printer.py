"""A tape as C99: one `const` for each step, in the order of the tape.

Terms and factors are written in the order in which the tape names them, literals by `repr`, so
that the text depends on the robot alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from symgen.codegen.kernels import Kernel
from symgen.errors import SymgenError
from symgen.symbolic.tape import Tape, terms

DTYPES = ("double", "float")
_FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tanh", "sign", "exp", "log")},
    "Abs": "fabs",
}


@dataclass(frozen=True)
class CFunction:
    """What a template needs to place one kernel: arguments, and the lines of its body."""

    arguments: tuple[str, ...]
    body: tuple[str, ...]
    needs_math: bool


def literal(value: sp.Expr, dtype: str) -> str:
    """Return a number as a C literal of the type: the shortest text that reads back the same."""
    number = float(value.evalf(50))
    if not math.isfinite(number):
        raise SymgenError(f"the constant {value} does not fit a {dtype}")
    if dtype == "float":
        import numpy as np

        return f"{_decimal(repr(float(str(np.float32(number)))))}f"
    return _decimal(repr(number))


def _decimal(digits: str) -> str:
    return digits if any(mark in digits for mark in ".en") else f"{digits}.0"


def print_kernel(
    kernel: Kernel,
    geometry: Mapping[sp.Symbol, str],
    values: Mapping[sp.Symbol, sp.Expr],
    dtype: str,
) -> CFunction:
    """Write the body of a kernel.

    Args:
        kernel: what to write.
        geometry: the macro that holds each named length.
        values: exact value of each named length, for constants derived from them.
        dtype: double or float.
    """
    return _Printer(kernel, geometry, values, dtype).function()


class _Printer:
    def __init__(
        self,
        kernel: Kernel,
        geometry: Mapping[sp.Symbol, str],
        values: Mapping[sp.Symbol, sp.Expr],
        dtype: str,
    ) -> None:
        tape = kernel.tape
        self.kernel, self.tape, self.values, self.dtype = kernel, tape, values, dtype
        self.word: dict[sp.Symbol, str] = {s: s.name for s in tape.order}
        for name, symbols in tape.inputs:
            self.word |= {s: f"{name}[{i}]" for i, s in enumerate(symbols)}
        self.word |= {s: m for s, m in geometry.items() if s in tape.order}
        self.geometry = geometry

    def function(self) -> CFunction:
        used = {s for _, e in self.tape.steps for s in e.free_symbols}
        used |= {s for e in self.tape.outputs for s in e.free_symbols}
        arguments = tuple(name for name, _ in self.tape.inputs)
        lines = [
            f"(void){name};" for name, symbols in self.tape.inputs if not used.intersection(symbols)
        ]
        lines += [
            f"const {self.dtype} {symbol.name} = {literal(value.subs(self.values), self.dtype)};"
            for symbol, value in self.tape.constants
            if symbol not in self.geometry
        ]
        lines += [
            f"const {self.dtype} {symbol.name} = {self.expression(expr)};"
            for symbol, expr in self.tape.steps
        ]
        places = [f"{o.name}[{i}]" for o in self.kernel.outputs for i in range(o.size)]
        results = [self.expression(e) for e in self.tape.outputs]
        lines += [f"{place} = {result};" for place, result in zip(places, results, strict=False)]
        if self.kernel.guards:
            zero = literal(sp.S.Zero, self.dtype)
            guards = results[len(places) :]
            lines.append(f"return {' && '.join(f'{g} > {zero}' for g in guards)} ? 0 : 1;")
        needs_math = any(e.is_Function and e.func is not sp.sign for _, e in self.tape.steps)
        return CFunction(arguments, tuple(lines), needs_math)

    def expression(self, expr: sp.Expr) -> str:
        if expr.is_Symbol:
            return self.word[expr]
        if expr.is_number:
            return literal(expr, self.dtype)
        if expr.is_Pow and expr.exp == -1:
            one = "1.0f" if self.dtype == "float" else "1.0"
            return f"{one} / {self.factor(expr.base)}"
        if expr.is_Function:
            name = _FUNCTIONS.get(expr.func.__name__)
            if name is None:
                raise SymgenError(f"{expr} cannot be written in C")
            if name == "sign":
                v, zero = self.expression(expr.args[0]), literal(sp.S.Zero, self.dtype)
                return f"({self.dtype})(({v} > {zero}) - ({v} < {zero}))"
            suffix = "f" if self.dtype == "float" else ""
            return f"{name}{suffix}({self.expression(expr.args[0])})"
        out = ""
        for negative, factors in terms(expr, self.tape.order):
            product = " * ".join(self.factor(f) for f in factors)
            if out:
                out += f" - {product}" if negative else f" + {product}"
            else:
                out = f"-{product}" if negative else product
        return out

    def factor(self, expr: sp.Expr) -> str:
        written = self.expression(expr)
        return f"({written})" if expr.is_Add else written


def operation_counts(tapes: Sequence[Tape]) -> dict[str, int]:
    """Return the summed operation counts of some tapes, as the manifest records them."""
    counts = [tape.operations for tape in tapes]
    return {
        key: sum(getattr(c, key) for c in counts)
        for key in ("mul", "add", "div", "sincos", "other")
    }
