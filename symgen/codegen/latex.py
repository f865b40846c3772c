"""Closed forms of kernels as SymPy expressions, and the LaTeX document of a model."""

from __future__ import annotations

import re
from collections.abc import Sequence

import sympy as sp
from sympy.simplify.fu import fu

from symgen.codegen.kernel import Kernel
from symgen.files import rendered
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameter, BaseParameters
from symgen.symbolic.tape import Values

#: Maximum number of operations of an output in closed form; a longer formula is unreadable.
LONGEST = 200
#: Robots with more joints have regressors that do not fit on a page.
_JOINTS = 3
_REGRESSORS = ("energy_regressor", "torque_regressor")
_MOTION = {"q": "q", "qd": r"\dot q", "qdd": r"\ddot q"}
_NAME = re.compile(r"([A-Za-z]+)(\d+)(R?)")


def closed_form(kernel: Kernel) -> tuple[sp.Expr, ...] | None:
    """Return the output entries of a kernel as expressions in its inputs and named lengths.

    The steps of its tape are substituted into each other. Each entry is the shortest of its
    expanded, its factored and its trigonometrically simplified form (Fu, Zhong and Zeng 2006).

    Args:
        kernel: a kernel of `derive`.

    Returns:
        The entries of all outputs in row-major order; None if one has more than 200 operations.
    """
    tape = kernel.tape
    known: dict[sp.Symbol, sp.Expr] = dict(tape.constants)
    for symbol, step in tape.steps:
        value = _substituted(step, known)
        if value is None:
            return None
        known[symbol] = value
    entries = []
    for output in tape.outputs[: kernel.size]:
        entry = _shortest(_substituted(output, known))
        if entry is None:
            return None
        entries.append(entry)
    return tuple(entries)


def _substituted(expression: sp.Expr, known: Values) -> sp.Expr | None:
    """Return an expression with its symbols substituted; None if it grows too long."""
    value = sp.sympify(expression).xreplace(known)
    return value if value.count_ops() <= 10 * LONGEST else None


def _shortest(expression: sp.Expr | None) -> sp.Expr | None:
    """Return the shortest equal form of an expression; None if that is too long."""
    if expression is None:
        return None
    expanded = sp.expand(expression)
    forms = [expanded, sp.factor(expanded)]
    if min(form.count_ops() for form in forms) <= 4 * LONGEST:
        simplified = fu(expanded)
        forms += [simplified, sp.factor(simplified)]
    shortest = min(forms, key=sp.count_ops)
    return shortest if shortest.count_ops() <= LONGEST else None


def latex_document(robot: Robot, base: BaseParameters, kernels: Sequence[Kernel]) -> str:
    """Return the base parameters and, for small robots, the regressors as a LaTeX document.

    Args:
        robot: the robot.
        base: base parameters of the robot.
        kernels: kernels; energy and torque regressors are printed up to three joints.
    """
    regressors = []
    for kernel in kernels:
        printed = robot.n <= _JOINTS and kernel.name in _REGRESSORS
        entries = closed_form(kernel) if printed else None
        if entries:
            output = kernel.outputs[0]
            rows = output.size // output.shape[-1]
            matrix = sp.Matrix(rows, output.shape[-1], entries)
            regressors.append((kernel.name.replace("_", " "), _column_equations(matrix)))
    formulas = [_regrouping(p) for p in base.parameters]
    return rendered(
        "tex/model.tex",
        title=robot.name.replace("_", r"\_"),
        count=len(formulas),
        formulas=formulas,
        no_effect=[_written(sp.Symbol(name)) for name in base.no_effect],
        regressors=regressors,
    )


def regroupings(base: BaseParameters) -> str:
    """Return the formulas of the base parameters as LaTeX between dollar signs, for notebooks."""
    rows = [_regrouping(p) for p in base.parameters]
    return "$$\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}$$"


def _regrouping(parameter: BaseParameter) -> str:
    terms = [c * sp.Symbol(name) for c, name in parameter.terms]
    formula = sp.Add(sp.Symbol(parameter.head), *terms)
    return f"{_written(sp.Symbol(parameter.name))} &= {_written(formula)}"


def _column_equations(matrix: sp.Matrix) -> list[str]:
    """Return one line for each column of a regressor."""
    lines = []
    for k in range(matrix.cols):
        column = matrix[:, k]
        value = column[0] if matrix.rows == 1 else column
        lines.append(f"h_{{{k + 1}}} &= {_written(value)}")
    return lines


def _written(expression: sp.Expr | sp.Matrix) -> str:
    """Return LaTeX of an expression, with dots on speeds and joint numbers as subscripts."""
    words = {}
    for symbol in expression.free_symbols:
        parts = _NAME.fullmatch(symbol.name)
        if parts is not None:
            letters = _MOTION.get(parts[1], parts[1])
            index = parts[2] + (r"\mathrm{R}" if parts[3] else "")
            words[symbol] = f"{letters}_{{{index}}}"
    return str(sp.latex(expression, symbol_names=words))
