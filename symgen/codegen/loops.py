"""Print a program of sweeps as C99: tables, and loops with one body for each kind of joint."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer, literal, status
from symgen.codegen.kernels import Kernel, Output
from symgen.robot.types import Robot
from symgen.symbolic import rolled
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.rolled import UP, Elimination, Kind, Pairs, Part, Program, Solution, Sweep
from symgen.symbolic.tape import Tape

#: Whether kernels that have a program are loops.
CHOICES = ("auto", "always", "never")
#: Number of joints from which "auto" takes loops, and that of some kernels: there, they gain as
#: much out of the cache as they lose in it (docs/scaling.md, "Large trees").
MANY = 15
MANY_OF = {
    **dict.fromkeys(("mass_matrix", "solve_mass_matrix", "mass_matrix_factor"), 40),
    **dict.fromkeys(("slotine_li_torque", "generalized_momentum"), 50),
}
_LINE, _ANGLES = 92, 4
#: Places of the entries of pairs, as row and column in C: joint j and joint u, and the other way.
_PAIRED = ("j", "u"), ("u", "j")
#: Kernels that have a program.
PROGRAMS: dict[str, Callable[[Robot, BaseParameters], Program]] = {
    "inverse_dynamics": rolled.inverse_dynamics,
    "gravity_torque": partial(rolled.inverse_dynamics, accelerating=False, moving=False),
    "forward_dynamics": rolled.forward_dynamics,
    "mass_matrix": rolled.mass_matrix,
    "coriolis": rolled.coriolis,
    "bias_torque": partial(rolled.inverse_dynamics, accelerating=False, out="h"),
    "inverse_dynamics_derivatives": rolled.inverse_dynamics_derivatives,
    "forward_dynamics_derivatives": rolled.forward_dynamics_derivatives,
    "slotine_li_torque": rolled.slotine_li_torque,
    "generalized_momentum": rolled.generalized_momentum,
    "solve_mass_matrix": rolled.solve_mass_matrix,
    "mass_matrix_factor": rolled.mass_matrix_factor,
}


def program(
    kernel: str, robot: Robot, base: BaseParameters, choice: str, many: int = MANY
) -> Program | None:
    """Return the program of a kernel, or None if it stays single statements.

    Args:
        kernel: name of the kernel.
        robot: the robot.
        base: its base parameters.
        choice: one of CHOICES.
        many: number of joints from which "auto" takes loops.
    """
    wanted = choice == "always" or (choice == "auto" and robot.n >= many)
    if not wanted or kernel not in PROGRAMS or not rolled.rollable(robot):
        return None
    return _derive(kernel, robot, base)


@lru_cache(maxsize=32)  # C and CasADi print the same programs
def _derive(kernel: str, robot: Robot, base: BaseParameters) -> Program:
    return PROGRAMS[kernel](robot, base)


def number(value: sp.Expr, robot: Robot, dtype: str = "double") -> str:
    """Return a constant of a robot as a literal."""
    return literal(sp.sympify(value).subs(robot.values()), dtype)


def loop_data(
    kernel: Kernel, robot: Robot, program: Program, dtype: str, prefix: str
) -> dict[str, Any]:
    """Return the data of a kernel as loops, for the template.

    Args:
        kernel: the kernel.
        robot: the robot.
        program: the program of the kernel.
        dtype: double or float.
        prefix: prefix of the package's names.
    """
    literal_of = partial(number, robot=robot, dtype=dtype)
    present = list(dict.fromkeys(program.kinds))
    joints, n = len(program.kinds), robot.n
    width = program.width
    padding = [sp.S.Zero] * (-joints % _ANGLES)
    given = next(a.size for a in kernel.inputs if a.name == "X")
    one = not program.paired  # pairs put zeros into several rows
    places = Places(tuple(name for name, _ in program.state), n - 1)
    steps = [_step(step, n, dtype, places) for step in program.steps]
    first: list[int] = []  # row of the first joint of the run of neighbours that ends at each joint
    for row, before in enumerate(program.way, 1):
        first.append(first[-1] if first and before == row - 1 else row)
    return {
        "joints": joints,
        "n": n,
        "angles": joints + len(padding),
        "theta": _lines(map(literal_of, (*program.angles, *padding))),
        "revolute": all(joint.turns for joint in robot.movable),
        "turns": _lines(literal_of(sp.Integer(int(joint.turns))) for joint in robot.movable),
        "antecedents": _lines(f"{row}u" for row in program.antecedents),
        "way": _lines(f"{row}u" for row in program.way),
        "order": _lines(f"{row}u" for row in program.order),
        "columns": program.columns,
        "geometry": [[literal_of(x) for x in row] for row in program.geometry],
        "parameters": program.parameters,
        "given": given,
        "rows": _lines(f"{row}u" for row, _ in program.places[:given]),
        "places": _lines(f"{column}u" for _, column in program.places[:given]),
        "called": ", ".join(f"{k} {kind.name}" for k, kind in enumerate(present)),
        "kinds": _lines(f"{present.index(kind)}u" for kind in program.kinds),
        "several": any(len(step.get("bodies", ())) > 1 for step in steps),
        "zero": literal_of(sp.S.Zero),
        "one": literal_of(sp.S.One),
        "state": base_rows(program, robot, dtype, zeros=one),
        "paired": program.paired,
        "first": _lines(f"{row}u" for row in first),
        "whole": len(set(first)) == 1,
        "matrices": program.matrices,
        "width": width,
        "row": min(rolled.COLUMNS, n),
        "reads_body": any("body" in _read(s) for s in program.steps if isinstance(s, Sweep)),
        "blocks": -(-n // width),
        "left": -n % width,
        "factored": any(isinstance(step, Elimination) for step in program.steps),
        "solved": any(isinstance(step, Solution) for step in program.steps),
        "guards": len(kernel.guards),
        "status": status(kernel, dtype, prefix, many=True) if kernel.guards else [],
        "needs_math": any(body["needs_math"] for step in steps for body in step.get("bodies", ())),
        "steps": steps,
    }


def base_rows(
    program: Program, robot: Robot, dtype: str, *, zeros: bool
) -> list[tuple[str, int, list[tuple[int, str]]]]:
    """Return the arrays of the state: name, entries of a row, and those of the base as text.

    Args:
        program: the program.
        robot: its robot.
        dtype: double or float.
        zeros: whether entries of the base that are 0 are wanted.
    """
    word = {g: f"g[{i}]" for i, g in enumerate(robot.gravity)} if robot.gravity_input else {}
    word |= {-symbol: f"-{text}" for symbol, text in word.items()}

    def text(x: sp.Expr) -> str:
        return word.get(x) or number(x, robot, dtype)

    return [
        (name, len(row), [(i, text(x)) for i, x in enumerate(row) if x or zeros])
        for name, row in program.state
    ]


def reads_antecedent(sweep: Sweep) -> bool:
    """Whether a sweep uses rows of the body before a joint."""
    return any(name.endswith(UP) for name in (*_read(sweep), *dict(sweep.written)))


def _read(sweep: Sweep) -> set[str]:
    """Return the arrays and tables of which a sweep reads rows."""
    return {name for _, tape in sweep.bodies for name, _ in tape.inputs}


def _step(step: Part, n: int, dtype: str, places: Places) -> dict[str, Any]:
    """Return the data of a step, for the template."""
    kind = type(step).__name__.lower()
    if isinstance(step, Sweep):
        bodies = [_body(step, kind, tape, dtype, places) for kind, tape in step.bodies]
        up = reads_antecedent(step)
        return {"kind": kind, "doc": step.doc, "order": step.order, "up": up, "bodies": bodies}
    if isinstance(step, Pairs):
        return {"kind": kind, **_pairs(step, dtype)}
    if isinstance(step, Elimination):
        return {"kind": kind, **vars(step)}
    if step.single:
        value, into = (
            f"{name}[0][k + 1u]" if name in places.state else f"{name}[k]"
            for name in (step.right, step.into)
        )
        return {"kind": kind, **vars(step), "value": value, "into": into}
    names = f"-{step.right}", step.into
    value, into = (f"{name}[(k * {n}u) + (begin + i)]" for name in names)
    if not step.right:
        one, zero = (literal(x, dtype) for x in (sp.S.One, sp.S.Zero))
        value = f"((begin + i) == k) ? {one} : {zero}"
    mirrored = f"{step.into}[((begin + i) * {n}u) + k]"
    return {"kind": kind, **vars(step), "value": value, "into": into, "mirrored": mirrored}


def _lines(entries: Iterable[str]) -> list[str]:
    """Return the entries of a table as lines."""
    return textwrap.wrap(", ".join(entries), _LINE)


@dataclass(frozen=True)
class Places:
    """Where the rows of joint j are.

    Attributes:
        state: names of the arrays of the program's state.
        last: place of the last variable.
        unsigned: suffix of literals.
        geometry: name of the table of constants.
    """

    state: tuple[str, ...]
    last: int
    unsigned: str = "u"
    geometry: str = "geometry"

    def of(self, name: str, entry: int) -> str:
        """Return an entry of the row of an array or a table."""
        if name in ("geometry", "body"):
            return f"{self.geometry if name == 'geometry' else name}[j][{entry}]"
        if name in ("c", "s"):
            return f"{name}[j]"
        if name.endswith(UP):
            return f"{name.removesuffix(UP)}[{entry}][up]"
        if name == "guard":  # from the tips
            return f"guard[{self.last}{self.unsigned} - j]"
        if name in self.state:
            return f"{name}[{entry}][j + 1{self.unsigned}]"
        return f"{name}[j]"


def _body(sweep: Sweep, kind: Kind, tape: Tape, dtype: str, places: Places) -> dict[str, Any]:
    """Return the statements of a sweep for one kind of joint."""
    function = BodyPrinter(body_kernel(sweep, tape), dtype, places).function()
    return {"kind": kind.name, "body": function.body, "needs_math": function.needs_math}


def body_kernel(sweep: Sweep, tape: Tape) -> Kernel:
    """Return the template of a kind of joint as a kernel."""
    outputs, at = [], 0
    for name, count in sweep.written:  # fixed joints lack the last ones
        if at < len(tape.outputs):
            outputs.append(Output(name, (count,)))
        at += count
    return Kernel("", sweep.doc, tape, tuple(outputs))


def pair_kernel(pairs: Pairs) -> Kernel:
    """Return the template of two bodies as a kernel."""
    return Kernel("", pairs.doc, pairs.body, (Output("entry", (len(pairs.entries),)),))


def pair_places(pairs: Pairs) -> list[tuple[str, tuple[str, str], int]]:
    """Return each entry that pairs write: its matrix, its row and column, and its number."""
    return [
        (matrix, place, k)
        for k, both in enumerate(pairs.entries)
        for matrices, place in zip(both, _PAIRED, strict=True)
        for matrix in matrices
    ]


def _pairs(pairs: Pairs, dtype: str) -> dict[str, Any]:
    """Return the data of a template of two bodies."""
    return {
        "doc": pairs.doc,
        "matrices": pairs.matrices,
        "count": len(pairs.entries),
        "places": pair_places(pairs),
        "diagonal": pairs.diagonal,
        "body": PairPrinter(pair_kernel(pairs), dtype).function().body,
    }


class PairPrinter(Printer):
    """Writes the entry of joint j and of the joint with row u of the state."""

    def __init__(self, kernel: Kernel, dtype: str, unsigned: str = "u") -> None:
        super().__init__(kernel, {}, {}, dtype)
        own = f"j + 1{unsigned}"
        for name, symbols in kernel.tape.inputs:
            array, row = (name.removesuffix(UP), "u" if name.endswith(UP) else own)
            self.word |= {symbol: f"{array}[{i}][{row}]" for i, symbol in enumerate(symbols)}

    def stored(self, place: str, result: sp.Expr) -> str:
        return super().stored(f"{place}[i]", result)


class BodyPrinter(Printer):
    """Writes the statements of joint j, whose antecedent has row `up` of the state."""

    def __init__(self, kernel: Kernel, dtype: str, places: Places) -> None:
        super().__init__(kernel, {}, {}, dtype)
        self.places = places
        for name, symbols in kernel.tape.inputs:
            self.word |= {symbol: places.of(name, i) for i, symbol in enumerate(symbols)}

    def stored(self, place: str, result: sp.Expr) -> str:
        name, _, entry = place.rstrip("]").partition("[")
        sign = "+=" if name.endswith(UP) else "="
        return f"{self.places.of(name, int(entry))} {sign} {self.expression(result)};"

    def cleared(self, name: str, places: Sequence[int]) -> Iterator[str]:
        if not name.endswith(UP):
            yield from (self.stored(f"{name}[{k}]", sp.S.Zero) for k in places)
