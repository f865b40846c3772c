"""Print kernels as NAME_casadi.py: straight-line CasADi code, the same bytes every time."""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer, literal
from symgen.codegen.kernels import LINK, SCALARS, Kernel
from symgen.codegen.loops import (
    BodyPrinter,
    PairPrinter,
    Places,
    base_rows,
    body_kernel,
    number,
    pair_kernel,
    pair_places,
    program,
    reads_antecedent,
)
from symgen.codegen.model import Model
from symgen.files import rendered
from symgen.robot.types import Robot
from symgen.symbolic.rolled import Pairs, Program, Solution, Sweep

_WIDTH = 96
#: Regressors that are derivatives by X of a kernel with loops, and its outputs: as many operations
#: as statements for each column.
_DERIVED = {
    "torque_regressor": ("inverse_dynamics", ("tau",)),
    "slotine_li_regressor": ("slotine_li_torque", ("tau",)),
    "momentum_regressor": ("generalized_momentum", ("p_out", "rate_out")),
}
#: What the text calls itself: no step may hide it.
_TAKEN = frozenset({"ca", *keyword.kwlist})


def casadi_source(name: str, model: Model, kernels: Sequence[Kernel], choice: str) -> str:
    """Return NAME_casadi.py: a function for each kernel that builds a casadi.Function.

    Arrays are columns and matrices of the shapes in NAME.h; 4x4 frames are stacked. An output is
    NaN if a guard is not positive: the mass matrix is not positive definite, or the robot has no
    such link.

    Args:
        name: prefix of the package.
        model: the derived model; its robot has the values of the named lengths.
        kernels: kernels of the package.
        choice: whether statements or loops build them, one of `loops.CHOICES`.
    """
    robot, base = model.robot, model.base
    programs = [program(_source(k), robot, base, choice) for k in kernels]
    looped = next(filter(None, programs), None)
    return rendered(
        "casadi/kernels.py",
        name=name,
        robot=robot.name,
        kernels=[_described(name, model, *both) for both in zip(kernels, programs, strict=True)],
        tables=looped and _tables(looped, robot),
    )


def _source(kernel: Kernel) -> str:
    """Return the name of the kernel whose loops build a kernel: itself, or see `_DERIVED`."""
    return _DERIVED.get(kernel.name, (kernel.name,))[0]


def function_name(name: str, kernel: str) -> str:
    """Return the name of a casadi.Function, which CasADi accepts: no double underscores."""
    return re.sub("_+", "_", f"{name}_casadi_{kernel}").strip("_")


class _InPython(Printer):
    """Writes statements of Python."""

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        return f"{self.word[symbol]} = {self.expression(expr)}"

    def stored(self, place: str, result: sp.Expr) -> str:
        return super().stored(place, result).removesuffix(";")

    def called(self, name: str, argument: sp.Expr) -> str:
        return f"ca.{name}({self.expression(argument)})"


class _Printer(_InPython):
    """Writes the body of a kernel in Python."""

    def __init__(self, kernel: Kernel, model: Model) -> None:
        super().__init__(kernel, {}, model.robot.values(), "double")
        given = {name for name, _ in kernel.tape.inputs}
        for symbol, word in self.word.items():
            if word in _TAKEN:
                self.word[symbol] = f"{word}__"
        assert not given & _TAKEN

    def lines(self) -> Iterator[str]:
        """Yield the statements between the inputs and the outputs."""
        tape = self.tape
        for name, symbols in tape.inputs:
            if name == LINK:
                yield from (f"{self.word[s]} = link == {i}" for i, s in enumerate(symbols, 1))
        for symbol, value in tape.constants:
            yield f"{self.word[symbol]} = {literal(value.subs(self.values), self.dtype)}"
        for symbol, expr in tape.steps:
            yield self.step(symbol, expr)


def _tables(rolled: Program, robot: Robot) -> dict[str, Any]:
    """Return the tables that the loops of all kernels of a robot share, as lines."""

    def lines(*entries: Any) -> list[str]:
        texts = (number(x, robot) if isinstance(x, sp.Expr) else repr(x) for x in entries)
        return textwrap.wrap(", ".join(texts), _WIDTH - 4)

    present = list(dict.fromkeys(rolled.kinds))
    tables = {
        "ORDER": lines(*rolled.order),
        "ANTECEDENT": lines(*rolled.antecedents),
        "WAY": lines(0, *rolled.way),
        "KIND": lines(*(present.index(kind) for kind in rolled.kinds)),
        "ANGLES": lines(*rolled.angles),
        "TURNS": lines(*(int(joint.turns) for joint in robot.movable)),
        "GEOMETRY": [f"[{' '.join(lines(*row))}]," for row in rolled.geometry],
        "PLACES": lines(*map(list, rolled.places)),
    }
    return {
        "lines": tables,
        "joints": len(rolled.kinds),
        "n": robot.n,
        "columns": rolled.columns,
        "parameters": rolled.parameters,
        "kinds": ", ".join(f"{k} {kind.name}" for k, kind in enumerate(present)),
    }


class _Body(_InPython, BodyPrinter):
    """Writes the steps of one joint in Python."""


class _Pair(_InPython, PairPrinter):
    """Writes the steps of two joints in Python."""

    def stored(self, place: str, result: sp.Expr) -> str:
        return f"{place} = {self.expression(result)}"


def _loops(rolled: Program, model: Model, kernel: Kernel) -> dict[str, Any]:
    """Return the data of a kernel as loops in Python."""
    robot = model.robot
    state = tuple(name for name, _ in rolled.state)
    places = Places(state, robot.n - 1, unsigned="", geometry="GEOMETRY")
    steps: list[dict[str, Any]] = []
    for step in rolled.steps:
        data: dict[str, Any] = {"kind": type(step).__name__.lower(), "doc": step.doc}
        if isinstance(step, Sweep):
            bodies = [_Body(body_kernel(step, t), "double", places) for _, t in step.bodies]
            data |= {"order": step.order, "up": reads_antecedent(step)}
            data |= {"bodies": [b.function().body for b in bodies]}
        elif isinstance(step, Pairs):
            body = _Pair(pair_kernel(step), "double", unsigned="").function().body
            data |= {"body": body, "places": pair_places(step), "diagonal": step.diagonal}
            data |= {"matrices": step.matrices, "count": len(step.entries)}
        else:
            data |= vars(step)
            if isinstance(step, Solution) and step.single:
                data["into"], data["right"] = (
                    f"{name}[0][1:]" if name in state else name for name in (step.into, step.right)
                )
        steps.append(data)
    derived = _DERIVED.get(kernel.name, ("", ()))[1]
    outputs = [(o.name, o.size) for o in kernel.outputs]
    return {
        "state": base_rows(rolled, robot, "double", zeros=False),
        "steps": steps,
        "outputs": [(name, robot.n) for name in derived] or outputs,
        "columns": [(o.name, name) for o, name in zip(kernel.outputs, derived, strict=False)],
        "parameters": kernel.outputs[0].shape[-1],
        "matrices": rolled.matrices,
        "guards": len(kernel.guards),
    }


def _described(name: str, model: Model, kernel: Kernel, rolled: Program | None) -> dict[str, Any]:
    printer = _Printer(kernel, model)
    inputs = [(a.name, 1 if a.link or a.name in SCALARS else a.size) for a in kernel.inputs]
    read = {a for a, _ in inputs}
    outputs = []
    for output, entries in kernel.split(kernel.tape.outputs):
        written = f"{output.name}_out" if output.name in read else output.name
        text = "" if rolled else ", ".join(printer.expression(e) for e in entries)
        flat = len(output.shape) == 1 or not output.size or (rolled and kernel.name in _DERIVED)
        width = 0 if flat else output.shape[-1]
        outputs.append(
            {
                "name": written,
                "entries": textwrap.wrap(text, _WIDTH - 8),
                "width": width,
                "rows": output.size // width if width else 0,
                "empty": not output.size,
            }
        )
    guards = [printer.expression(e) for e in kernel.tape.outputs[kernel.size :]]
    if kernel.links:
        guards.append(f"(link >= 1) * (link <= {kernel.links}) * (link == ca.floor(link))")
    return {
        "name": kernel.name,
        "doc": textwrap.wrap(kernel.doc.replace("\\", "/").replace('"""', "'''"), _WIDTH - 8),
        "function": function_name(name, kernel.name),
        "inputs": inputs,
        "outputs": outputs,
        "guards": guards,
        "lines": [] if rolled else list(printer.lines()),
        "loops": rolled and _loops(rolled, model, kernel),
    }
