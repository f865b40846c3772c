"""Kernels on panels: as many samples at once as a vector register of this machine holds.

A panel has the steps of the single call in the same order, on vectors instead of numbers. Values
that depend only on X stay numbers. gcc or clang compile panels with the flags of `runtime.flags`;
packages use a plain loop.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer
from symgen.codegen.kernels import SHARED, Kernel
from symgen.codegen.model import Model
from symgen.files import rendered, templates
from symgen.symbolic.tape import Steps, Values, real_symbol

#: Largest number of output entries of a sample; larger panels need too much stack.
LARGEST = 1024


def panelled(kernel: Kernel) -> bool:
    """Whether a kernel has panels: array inputs, separate outputs, and not too many entries."""
    arrays = not any(a.plain or (a.read and a.written) for a in kernel.arguments)
    return arrays and kernel.batch and kernel.size <= LARGEST


def panel_sources(model: Model, kernel: Kernel) -> dict[str, bytes]:
    """Return C source and header of a kernel on panels, and other files that they need."""
    name = model.robot.name
    geometry = {real_symbol(g): f"{name}_geometry_{g}" for g, _ in model.robot.geometry}
    printer = _PanelPrinter(kernel, geometry, model.robot.values())
    body = printer.function().body
    read, written = kernel.inputs, kernel.outputs
    lanes = [f"const {'double' if a.shared else 'lanes'} *{a.name}" for a in read]
    passed = [a.name if a.shared else f"lanes_{a.name}" for a in read]
    described = {
        "name": kernel.name,
        "arguments": read,
        "outputs": written,
        "largest": max(o.size for o in written),
        "parameters": ", ".join([*lanes, *(f"lanes *{o.name}" for o in written)]),
        "plain": kernel.listed("double", batch=True),
        "call": ", ".join([*passed, *(f"lanes_{o.name}" for o in written)]),
        "body": body,
        "names": ", ".join(a.name for a in kernel.arguments),
        "status": printer.status,
    }
    files = {
        f"{name}_{kernel.name}_panels{suffix}": rendered(
            f"c/panels{suffix}", name=name, k=described
        ).encode()
        for suffix in (".h", ".c")
    }
    plain = (templates() / "c" / "runtime" / "lanes.inc").read_text("utf-8")
    return files | {f"{name}_lanes.inc": plain.replace("NAME", name).encode()}


class _PanelPrinter(Printer):
    def __init__(
        self,
        kernel: Kernel,
        geometry: Mapping[sp.Symbol, str],
        values: Values,
    ) -> None:
        super().__init__(kernel, geometry, values, "double", "lanes")
        self.value = "lanes"
        self.status = "0"
        sampled = {s for name, symbols in self.tape.inputs if name not in SHARED for s in symbols}
        for symbol, expr in self.tape.steps:
            if expr.free_symbols & sampled:
                sampled.add(symbol)
        self.sampled = sampled

    def of_sample(self, expr: sp.Expr) -> bool:
        """Whether a value depends on the sample."""
        return bool(sp.sympify(expr).free_symbols & self.sampled)

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
        """Store no zeros: the buffers already contain them."""
        return iter(())

    def verdict(self) -> list[str]:
        """Return the status of all samples, as bits numbered by NAME.h."""
        if not self.kernel.guards:
            return []
        results = self.tape.outputs[: self.kernel.size]
        guards = [self.spread(g) for g in self.tape.outputs[self.kernel.size :]]
        singular = " | ".join(f"({g} <= 0.0)" for g in guards)
        odd = [f"(~({g} > 0.0) & ~({g} <= 0.0))" for g in guards]
        odd += [f"~({self.spread(r)} - {self.spread(r)} == 0.0)" for r in results]
        self.status = "status"
        return [
            f"const int status = (lanes_any({singular}) ? 1 : 0)",
            f"    | (lanes_any(({' | '.join(odd)}) & ~({singular})) ? 2 : 0);",
        ]

    def angles(self, own: str) -> tuple[Steps, list[str]]:
        self.turns: list[tuple[str, str]] = []
        first, lines = super().angles(own)
        if self.turns:
            reach = " + ".join(f"lanes_abs({angle})" for angle, _ in self.turns)
            lines.append(f"if (lanes_any(~({reach} <= NEAR))) {{")
            lines += [f"    {r} = lanes_far({angle}, {r});" for angle, r in self.turns]
            lines.append("}")
        return first, lines

    def turned(self, own: str, angles: Sequence[sp.Expr], name: str, start: int) -> Iterator[str]:
        for k, angle in enumerate(angles, start):
            result, place = f"{name}_{k}", f"{name}[{k}]"
            yield f"turned {result} = {own}_turn({place});"
            self.word[sp.cos(angle)] = f"{result}.c"
            self.word[sp.sin(angle)] = f"{result}.s"
            self.turns.append((place, result))

    def called(self, name: str, argument: sp.Expr) -> str:
        if not self.of_sample(argument):
            return super().called(name, argument)
        name = "abs" if name == "fabs" else name
        return f"lanes_{name}({self.expression(argument)})"
