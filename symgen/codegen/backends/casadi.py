"""CasADi: NAME_casadi.py, straight-line code of every kernel, the same bytes every time."""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import sympy as sp

from symgen.codegen import example
from symgen.codegen.backends import Package
from symgen.codegen.c_printer import Printer, literal
from symgen.codegen.kernel import LINK, SCALARS, Kernel
from symgen.files import rendered
from symgen.robot.types import Robot

_WIDTH = 96
#: Names that the generated text uses; steps must not have them.
_TAKEN = frozenset({"ca", *keyword.kwlist})


BUILDS_ON: tuple[str, ...] = ()


def files(package: Package) -> dict[str, str]:
    """Return NAME_casadi.py, and the optimal control if its kernels are in the package."""
    source = casadi_source(package.name, package.model.robot, package.kernels)
    return {f"{package.name}_casadi.py": source, **example.optimal_control(package)}


def casadi_source(name: str, robot: Robot, kernels: Sequence[Kernel]) -> str:
    """Return NAME_casadi.py: a function for each kernel that builds a casadi.Function.

    Arrays are columns and matrices with the shapes in NAME.h; 4x4 frames are stacked. An output is
    NaN if a guard is not positive: the mass matrix is not positive definite, or the robot has no
    such link.

    Args:
        name: prefix of the package.
        robot: the robot, with the values of the named lengths.
        kernels: kernels of the package.
    """
    return rendered(
        "casadi/kernels.py",
        name=name,
        robot=robot.name,
        kernels=[_described(name, robot, kernel) for kernel in kernels],
    )


def casadi_functions(
    name: str, robot: Robot, kernels: Sequence[Kernel]
) -> Mapping[str, Callable[[], Any]]:
    """Run NAME_casadi.py; return for each kernel the function that builds its casadi.Function."""
    content: dict[str, Any] = {"__name__": f"{name}_casadi"}
    exec(compile(casadi_source(name, robot, kernels), f"{name}_casadi.py", "exec"), content)
    functions: dict[str, Callable[[], Any]] = content["FUNCTIONS"]
    return functions


def function_name(name: str, kernel: str) -> str:
    """Return the name of a casadi.Function. CasADi does not accept double underscores."""
    return re.sub("_+", "_", f"{name}_casadi_{kernel}").strip("_")


class _Printer(Printer):
    """Writes the body of a kernel in Python."""

    def __init__(self, kernel: Kernel, robot: Robot) -> None:
        super().__init__(kernel, {}, robot.values(), "double")
        given = {name for name, _ in kernel.tape.inputs}
        for symbol, word in self.word.items():
            if word in _TAKEN:
                self.word[symbol] = f"{word}__"
        assert not given & _TAKEN

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        return f"{self.word[symbol]} = {self.expression(expr)}"

    def called(self, name: str, argument: sp.Expr) -> str:
        return f"ca.{name}({self.expression(argument)})"

    def lines(self) -> Iterator[str]:
        """Yield the statements between the inputs and the outputs."""
        tape = self.tape
        for name, symbols in tape.inputs:
            if name == LINK:
                yield from (
                    f"{self.word[s]} = link == {i}" for i, s in enumerate(symbols, self.first)
                )
        for symbol, value in tape.constants:
            yield f"{self.word[symbol]} = {literal(value.subs(self.values), self.dtype)}"
        for symbol, expr in tape.steps:
            yield self.step(symbol, expr)


def _described(name: str, robot: Robot, kernel: Kernel) -> dict[str, Any]:
    """Return the data of a kernel for the template."""
    printer = _Printer(kernel, robot)
    inputs = [(a.name, 1 if a.link or a.name in SCALARS else a.size) for a in kernel.inputs]
    read = {a for a, _ in inputs}
    outputs = []
    for output, entries in kernel.split(kernel.tape.outputs):
        text = ", ".join(printer.expression(e) for e in entries)
        width = output.shape[-1] if len(output.shape) > 1 and output.size else 0
        outputs.append(
            {
                "name": f"{output.name}_out" if output.name in read else output.name,
                "entries": textwrap.wrap(text, _WIDTH - 8),
                "width": width,
                "rows": output.size // width if width else 0,
                "empty": not output.size,
            }
        )
    guards = [printer.expression(e) for e in kernel.tape.outputs[kernel.size :]]
    if kernel.link is not None:
        first, last = kernel.link.first, kernel.link.last
        guards.append(f"(link >= {first}) * (link <= {last}) * (link == ca.floor(link))")
    return {
        "name": kernel.name,
        "doc": textwrap.wrap(kernel.doc.replace("\\", "/").replace('"""', "'''"), _WIDTH - 8),
        "function": function_name(name, kernel.name),
        "inputs": inputs,
        "outputs": outputs,
        "guards": guards,
        "lines": list(printer.lines()),
    }
