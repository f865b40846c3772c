"""Torque columns of effects on a tape, and their derivatives, for a robot or for one definition."""

from __future__ import annotations

import re
from collections.abc import Collection

import sympy as sp

from symgen.robot import expressions
from symgen.robot.effect import OWN, Definition
from symgen.robot.expressions import text
from symgen.robot.types import Robot
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.tape import Tape, TapeBuilder, real_symbol

_VARIABLE = re.compile(r"qd?\d+")
_EXPONENT = 2  # position of the exponent in the arguments of a power


class _Power(sp.Function):  # type: ignore[misc]  # SymPy has no types
    """base**exponent with base >= 0, for derivatives: its slope is 0 where the base is 0."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative with respect to the base (1) or to the exponent (2)."""
        base, exponent = self.args
        nonzero = base + 1 - sp.sign(base)
        return self * sp.log(nonzero) if argindex == _EXPONENT else exponent * self / nonzero

    def _eval_is_extended_real(self) -> bool:
        return True


def slope(expr: sp.Expr, by: sp.Symbol) -> sp.Expr:
    """Return the derivative of an expression of an effect.

    sign(x) counts as constant, so that the derivative of |x| is sign(x). |x|^p has the slope 0
    at 0 for every p > 0.
    """
    careful = expr.replace(
        lambda part: part.is_Pow and not part.exp.is_Integer, lambda part: _Power(*part.args)
    )
    derivative = sp.diff(careful, by)
    return derivative.replace(sp.DiracDelta, lambda *_: sp.S.Zero).replace(_Power, sp.Pow)


def effect_columns(
    robot: Robot, tape: TapeBuilder, load: ByJoint | None = None, by: sp.Symbol | None = None
) -> dict[str, ByJoint]:
    """Return the torque column of every coefficient of the robot's effects, by joint.

    Args:
        robot: the robot, with its effects.
        tape: the tape to write the columns on.
        load: rigid-body torque on each movable joint. If set, the result contains the columns of
            the coefficients whose torque depends on it, otherwise all other columns.
        by: if set, the result contains the derivatives of the columns by this variable instead.
    """
    torques = {real_symbol(f"taur{j}"): torque for j, torque in (load or {}).items()}
    loads = {s for torque in torques.values() for s in torque.free_symbols}
    out: dict[str, ByJoint] = {}
    for effect in robot.effects:
        for name, _ in effect.linear:
            if effect.loads(name) != (load is not None):
                continue
            column, label = _smooth(effect.column(name), robot), f"D{name}_{effect.joint}"
            if by is not None:
                column, label = slope(column, by), f"S{by.name}{name}_{effect.joint}"
            out[name] = {}
            if column != 0:
                column = column.subs(torques)
                used = column.free_symbols
                variables = {s for s in used if _VARIABLE.fullmatch(s.name)} | (used & loads)
                out[name][effect.joint] = _lowered(column, label, tape, variables)
    return out


def _smooth(column: sp.Expr, robot: Robot) -> sp.Expr:
    """Write tanh(qd/width) for sign(qd) of a joint with a declared width, as in its friction."""
    widths = {
        sp.sign(real_symbol(f"qd{j.number}")): sp.tanh(
            real_symbol(f"qd{j.number}") / sp.Rational(repr(j.coulomb_width))
        )
        for j in robot.movable
        if j.coulomb_width
    }
    return column.xreplace(widths)


def definition_tape(definition: Definition, robot: Robot | None = None) -> Tape:
    """Derive the columns of an effect on one joint.

    Args:
        definition: an effect of the library, or of a robot file.
        robot: the robot whose joints and lengths a torque from a file contains.

    Returns:
        A tape to minus the derivative of the torque by every coefficient. Its inputs are q, qd, qdd
        and taur of the joint (of all movable joints for an effect from a file), and c, the
        constants in the order of `nonlinear`.
    """
    numbers = [""] if robot is None else [str(j.number) for j in robot.movable]
    symbol = {
        name: real_symbol(name)
        for name in (
            *(f"{letter}{number}" for letter in OWN for number in numbers),
            *definition.linear,
            *definition.nonlinear,
        )
    }
    lengths = () if robot is None else tuple(name for name, _ in robot.geometry)
    known = (*symbol, *lengths)
    torque = expressions.parse(definition.torque, known, expressions.EFFECT_FUNCTIONS)
    if robot is not None:
        torque = _smooth(torque, robot)
    inputs = [(letter, [symbol[f"{letter}{number}"] for number in numbers]) for letter in OWN]
    inputs.append(("c", [symbol[name] for name in definition.nonlinear]))
    tape = TapeBuilder(known)
    variables = {s for _, group in inputs for s in group}
    outputs = [
        _lowered(-sp.diff(torque, symbol[name]), f"D{name}", tape, variables)
        for name in definition.linear
    ]
    return tape.tape(inputs, outputs)


def _lowered(
    expr: sp.Expr, name: str, tape: TapeBuilder, variables: Collection[sp.Symbol]
) -> sp.Expr:
    """Name every function and power of an expression from the inside out; constants become tape
    constants.
    """

    def inner(part: sp.Expr, letter: str) -> sp.Expr:
        return tape.name(f"{letter}{name}", _lowered(part, f"{letter}{name}", tape, variables))

    used = expr.free_symbols & set(variables)
    if expr.is_Rational or expr in variables:
        return expr
    if not used:
        return tape.constant(f"c{name}", expr)
    if expr.is_Pow and not expr.exp.is_Integer:
        logarithm = tape.name(f"l{name}", sp.log(inner(expr.base, "b")))
        return tape.name(
            f"p{name}", sp.exp(tape.name(f"x{name}", inner(expr.exp, "e") * logarithm))
        )
    if expr.is_Pow:
        whole = inner(expr.base, "b") ** abs(expr.exp)
        return tape.name(f"i{name}", 1 / tape.name(f"p{name}", whole)) if expr.exp < 0 else whole
    if expr.is_Function:
        return tape.name(f"f{name}", expr.func(inner(expr.args[0], "a")))
    fixed, rest = expr.as_independent(*used, as_Add=expr.is_Add)
    parts = [
        _lowered(part, f"{name}_{i}", tape, variables)
        for i, part in enumerate(sorted(expr.func.make_args(rest), key=text))
    ]
    if fixed != expr.identity:
        parts.append(fixed if fixed.is_Rational else tape.constant(f"k{name}", fixed))
    return tape.name(name, expr.func(*parts))
