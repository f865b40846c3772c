"""Kernels on panels: a panel has as many samples as a vector register.

A panel has the steps of the single call in the same order, on vectors instead of numbers. The
compiler flags determine the width. Without the vector extensions of gcc and clang, it is 1, and the
sources are loops of single calls.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer
from symgen.codegen.kernel import Kernel
from symgen.symbolic.tape import Steps, Values, symbols_in

#: Largest number of output entries of a sample, and of steps. Larger panels need much stack, and
#: compile slowly.
LARGEST, LONGEST = 1024, 2000


def panelled(kernel: Kernel) -> bool:
    """Return whether a kernel has panels: array inputs, separate outputs, and a limited number of
    entries and steps.

    Larger kernels have a loop of single calls.
    """
    arrays = not any(a.plain or (a.read and a.written) for a in kernel.arguments)
    short = len(kernel.tape.steps) + kernel.size <= LONGEST and kernel.size <= LARGEST
    return arrays and kernel.batch and short


def panel_data(
    kernel: Kernel, geometry: Mapping[sp.Symbol, str], values: Values, dtype: str, prefix: str
) -> dict[str, Any]:
    """Return the data of a kernel on panels for the template.

    Args:
        kernel: a kernel that is `panelled`.
        geometry: named length -> its macro.
        values: named length -> exact value.
        dtype: double or float.
        prefix: prefix of the names in the package.
    """
    printer = _PanelPrinter(kernel, geometry, values, dtype, prefix)
    empty = [o for o, places in zip(kernel.outputs, kernel.filled, strict=True) if not places]
    return {
        "body": [*(f"(void){o.name};" for o in empty), *printer.function().body],
        "guards": [printer.spread(g) for g in kernel.tape.outputs[kernel.size :]],
        "results": [printer.spread(r) for r in kernel.tape.outputs[: kernel.size]],
    }


class _PanelPrinter(Printer):
    value = own = "lanes"

    @cached_property
    def sampled(self) -> set[sp.Symbol]:
        """The symbols whose values depend on the sample."""
        out = {s for _, symbols in self.tape.inputs for s in symbols}
        for symbol, expr in self.tape.steps:
            if symbols_in(expr) & out:
                out.add(symbol)
        return out

    def of_sample(self, expr: sp.Expr) -> bool:
        """Return whether a value depends on the sample."""
        return bool(symbols_in(expr) & self.sampled)

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        kind = self.value if symbol in self.sampled else self.dtype
        return f"const {kind} {symbol.name} = {self.expression(expr)};"

    def spread(self, expr: sp.Expr) -> str:
        """Return a value as a vector."""
        written = self.expression(expr)
        return written if self.of_sample(expr) else f"lanes_all({written})"

    def stored(self, place: str, result: sp.Expr) -> str:
        return f"lanes_put(&{place}, {self.spread(result)}, stream);"

    def cleared(self, *_: Any) -> Iterator[str]:
        """Store no zeros, because the buffers already contain them."""
        return iter(())

    def verdict(self) -> list[str]:
        """Return nothing: the template makes the status of all samples."""
        return []

    def angles(self, prefix: str) -> tuple[Steps, list[str]]:
        self.turns: list[tuple[str, str]] = []
        first, lines = super().angles(prefix)
        if self.turns:
            reach = " + ".join(f"lanes_abs({angle})" for angle, _ in self.turns)
            lines.append(f"if (lanes_any(~(mask)({reach} <= NEAR))) {{")
            lines += [f"    {r} = lanes_far({angle}, {r});" for angle, r in self.turns]
            lines.append("}")
        return first, lines

    def turned(
        self, prefix: str, angles: Sequence[sp.Expr], name: str, start: int
    ) -> Iterator[str]:
        for k, angle in enumerate(angles, start):
            result, place = f"{name}_{k}", f"{name}[{k}]"
            yield f"turned {result} = {prefix}_turn({place});"
            self.word[sp.cos(angle)] = f"{result}.c"
            self.word[sp.sin(angle)] = f"{result}.s"
            self.turns.append((place, result))

    def called(self, name: str, argument: sp.Expr) -> str:
        if not self.of_sample(argument):
            return super().called(name, argument)
        name = "abs" if name == "fabs" else name
        return f"lanes_{name}({self.expression(argument)})"
