"""Merge several tapes into one, which computes common steps once."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic.kinematics import builder
from symgen.symbolic.tape import Symbols, Tape, TapeBuilder


def joined(robot: Robot, tapes: Sequence[Tape], inputs: Sequence[str]) -> Tape:
    """Return one tape with the outputs of all, one after the other.

    Args:
        robot: the robot of all tapes.
        tapes: in the order of the outputs.
        inputs: order of the inputs. If tapes have an input of different lengths, the longest one
            is used.
    """
    whole, longest, outputs = merged(robot, tapes)
    return whole.tape([(name, longest[name]) for name in inputs], outputs)


def merged(
    robot: Robot, tapes: Sequence[Tape], reserved: Sequence[sp.Symbol] = ()
) -> tuple[TapeBuilder, dict[str, Symbols], list[sp.Expr]]:
    """Return a builder with the steps of all tapes, their inputs, and their outputs in order.

    Args:
        robot: the robot of all tapes.
        tapes: in the order of the outputs.
        reserved: further inputs, whose names no step may have.
    """
    longest: dict[str, Symbols] = {}
    for tape in tapes:
        for name, symbols in tape.inputs:
            longest[name] = max(longest.get(name, ()), symbols, key=len)
    whole = builder(robot, (*(s for symbols in longest.values() for s in symbols), *reserved))
    outputs: list[sp.Expr] = []
    for tape in tapes:
        known = {symbol: whole.constant(symbol.name, value) for symbol, value in tape.constants}
        for symbol, expr in tape.steps:
            known[symbol] = whole.name(symbol.name, expr.xreplace(known))
        outputs += [sp.sympify(output).xreplace(known) for output in tape.outputs]
    return whole, longest, outputs
