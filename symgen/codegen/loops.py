"""Print a program of sweeps as C99: tables, one function for each kind of joint, and loops."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer, literal
from symgen.codegen.kernels import Kernel, Output
from symgen.robot.types import Robot
from symgen.symbolic import rolled
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.rolled import UP, Kind, Program, Sweep
from symgen.symbolic.tape import Tape

_LINE, _ANGLES = 96, 4
#: Kernels with loops.
LOOPS: dict[str, Callable[[Robot, BaseParameters], Program]] = {
    "inverse_dynamics": rolled.inverse_dynamics,
    "gravity_torque": partial(rolled.inverse_dynamics, accelerating=False, moving=False),
    "bias_torque": partial(rolled.inverse_dynamics, accelerating=False, out="h"),
}


def loops(kernel: Kernel, robot: Robot, program: Program, dtype: str, prefix: str) -> dict[str, Any]:
    """Return the data of a kernel as loops, for the template.

    Args:
        kernel: the kernel.
        robot: the robot.
        program: its program.
        dtype: double or float.
        prefix: prefix of the package's names.
    """
    values = robot.values()

    def number(value: sp.Expr) -> str:
        return literal(sp.sympify(value).subs(values), dtype)

    known = {symbol: f"g[{i}]" for i, symbol in enumerate(robot.gravity)} if robot.gravity_input else {}

    def base(value: sp.Expr) -> str:
        if value in known:
            return known[value]
        return f"-{known[-value]}" if -value in known else number(value)

    present = list(dict.fromkeys(program.kinds))
    variables = {joint.number: place for place, joint in enumerate(robot.movable)}
    joints = len(robot.joints)
    padding = [sp.S.Zero] * (-joints % _ANGLES)
    given = next(a.size for a in kernel.inputs if a.name == "X")
    sweeps = [
        [_function(sweep, kind, tape, dtype, "j" if robot.n == joints else "variable[j]") for kind, tape in sweep.bodies]
        for sweep in program.sweeps
    ]
    return {
        "joints": joints,
        "angles": joints + len(padding),
        "theta": _lines(map(number, (*program.angles, *padding))),
        "revolute": all(joint.turns for joint in robot.joints),
        "turns": _lines(number(sp.Integer(int(joint.turns))) for joint in robot.joints),
        "antecedents": _lines(f"{joint.antecedent}u" for joint in robot.joints),
        "variables": _lines(f"{variables.get(joint.number, 0)}u" for joint in robot.joints),
        "columns": program.columns,
        "geometry": [[number(x) for x in row] for row in program.geometry],
        "parameters": program.parameters,
        "given": given,
        "rows": _lines(f"{row}u" for row, _ in program.places[:given]),
        "places": _lines(f"{column}u" for _, column in program.places[:given]),
        "called": ", ".join(f"{k} {kind.name}" for k, kind in enumerate(present)),
        "kinds": _lines(f"{present.index(kind)}u" for kind in program.kinds),
        "zero": number(sp.S.Zero),
        "state": [(name, [base(x) for x in row]) for name, row in program.state],
        "needs_math": any(f["needs_math"] for functions in sweeps for f in functions),
        "sweeps": [
            {"inward": sweep.inward, "functions": functions}
            for sweep, functions in zip(program.sweeps, sweeps, strict=True)
        ],
    }


def _lines(entries: Iterable[str]) -> list[str]:
    """Return the entries of a table as lines."""
    return textwrap.wrap(", ".join(entries), _LINE)


def _function(sweep: Sweep, kind: Kind, tape: Tape, dtype: str, variable: str) -> dict[str, Any]:
    """Return the statements of a sweep for one kind of joint."""
    outputs, at = [], 0
    for name, count in sweep.written:
        if at < len(tape.outputs):
            outputs.append(Output(name, (count,)))
        at += count
    kernel = Kernel(sweep.name, "", tape, tuple(outputs))
    function = _BodyPrinter(kernel, dtype, variable).function()
    return {"kind": kind.name, "body": function.body, "needs_math": function.needs_math}


class _BodyPrinter(Printer):
    """Writes the body of joint j, whose antecedent has row `up`."""

    def __init__(self, kernel: Kernel, dtype: str, variable: str) -> None:
        super().__init__(kernel, {}, {}, dtype)
        self.variable = variable
        for name, symbols in kernel.tape.inputs:
            self.word |= {symbol: self.place(name, i) for i, symbol in enumerate(symbols)}

    def place(self, name: str, entry: int) -> str:
        """Return an entry of the row of an array."""
        if name in ("geometry", "body"):
            return f"{name}[j][{entry}]"
        if name in ("c", "s"):
            return f"{name}[j]"
        if name.endswith(UP):
            return f"{name.removesuffix(UP)}[{entry}][up]"
        if name in ("motion", "wrench"):
            return f"{name}[{entry}][j + 1u]"
        return f"{name}[{self.variable}]"

    def stored(self, place: str, result: sp.Expr) -> str:
        name, _, entry = place.rstrip("]").partition("[")
        sign = "+=" if name.endswith(UP) else "="
        return f"{self.place(name, int(entry))} {sign} {self.expression(result)};"

    def cleared(self, name: str, places: Sequence[int]) -> Iterator[str]:
        if not name.endswith(UP):
            yield from (self.stored(f"{name}[{k}]", sp.S.Zero) for k in places)
