"""Merge several tapes into one, which computes common steps once."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic.kinematics import builder
from symgen.symbolic.tape import Symbols, Tape


def joined(robot: Robot, tapes: Sequence[Tape], inputs: Sequence[str]) -> Tape:
    """Return one tape with the outputs of all, one after the other.

    Args:
        robot: the robot of all tapes.
        tapes: in the order of the outputs.
        inputs: order of the inputs. If tapes have an input of different lengths, the longest one
            is used.
    """
    longest: dict[str, Symbols] = {}
    for tape in tapes:
        for name, symbols in tape.inputs:
            longest[name] = max(longest.get(name, ()), symbols, key=len)
    whole = builder(robot, (s for symbols in longest.values() for s in symbols))
    outputs: list[sp.Expr] = []
    for tape in tapes:
        known = {symbol: whole.constant(symbol.name, value) for symbol, value in tape.constants}
        for symbol, expr in tape.steps:
            known[symbol] = whole.name(symbol.name, expr.xreplace(known))
        outputs += [sp.sympify(output).xreplace(known) for output in tape.outputs]
    return whole.tape([(name, longest[name]) for name in inputs], outputs)
