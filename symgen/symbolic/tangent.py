"""Derivatives along a tape: the chain rule, step by step (forward mode)."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symgen.errors import SymgenError
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.tape import TapeBuilder, Values


def tangents(
    expressions: ByJoint,
    seeds: Values,
    tape: TapeBuilder,
    tag: str,
) -> ByJoint:
    """Return the nonzero derivatives of some expressions with respect to one variable.

    sign(x) counts as constant, so that the derivative of |x| is sign(x). In derivatives,
    log(0) is 0 and has no slope, so that |x|^p, which is exp(p log |x|), has the slope 0 at 0 for
    every p > 0.

    Args:
        expressions: over symbols of the tape.
        seeds: known derivatives, 1 for the variable itself. Steps before these are not
            differentiated.
        tape: contains the steps, and receives those of the derivatives.
        tag: suffix of the names of new steps.
    """
    rule = _Rule(seeds, tape, tag)
    found = {key: rule.of(expr) for key, expr in expressions.items()}
    return {key: value for key, value in found.items() if value != 0}


class _Rule:
    def __init__(self, seeds: Values, tape: TapeBuilder, tag: str) -> None:
        self.tape, self.tag = tape, tag
        self.known: dict[sp.Expr, sp.Expr] = dict(seeds)
        self.steps = tape.definitions()

    def of(self, expr: sp.Expr) -> sp.Expr:
        """Return the derivative of an expression."""
        if expr.is_number:
            return sp.S.Zero
        if expr not in self.known:
            self.known[expr] = self._step(expr) if expr.is_Symbol else self._slope(expr, None)
        return self.known[expr]

    def _step(self, symbol: sp.Symbol) -> sp.Expr:
        # An input that is no variable here, or a constant, stands for no step.
        value = self._slope(self.steps.get(symbol, sp.S.Zero), symbol)
        return self.tape.name(f"d{self.tag}{symbol.name}", value)

    def _slope(self, expr: sp.Expr, value: sp.Symbol | None) -> sp.Expr:
        """Return the derivative of an operation; its value may have a name already."""
        if expr.is_number:
            return sp.S.Zero
        if expr.is_Add:
            return sp.Add(*map(self.of, expr.args))
        if expr.is_Mul:
            return sp.Add(*(self._but(i, expr.args) * self.of(f) for i, f in enumerate(expr.args)))
        if expr.is_Pow and expr.exp == -1:  # a tape divides once, by x
            value = value or self.tape.name(f"i{self.tag}", expr)
            return -value * value * self.of(expr.base)
        if expr.is_Pow and expr.exp.is_Integer:
            inner = self.of(expr.base)
            return sp.S.Zero if inner == 0 else expr.exp * expr.base ** (expr.exp - 1) * inner
        return self._function(expr, value or expr)

    def _but(self, i: int, parts: Sequence[sp.Expr]) -> sp.Expr:
        """Return the product of all factors but one, if that one has a derivative."""
        if self.of(parts[i]) == 0:
            return sp.S.Zero
        return sp.Mul(*map(self._finite, parts[:i]), *map(self._finite, parts[i + 1 :]))

    def _finite(self, factor: sp.Expr) -> sp.Expr:
        """Return a factor; 0 for the logarithm of 0."""
        meaning = self.steps.get(factor, factor)
        if meaning.func is not sp.log:
            return factor
        return self.tape.name(f"l{self.tag}", sp.log(self._nonzero(meaning.args[0])))

    def _nonzero(self, x: sp.Expr) -> sp.Expr:
        """Return x >= 0; 1 where it is 0."""
        one = self.tape.name(f"o{self.tag}", 1 - self.tape.name(f"s{self.tag}", sp.sign(x)))
        return self.tape.name(f"n{self.tag}", x + one)

    def _function(self, meaning: sp.Expr, value: sp.Expr) -> sp.Expr:
        """Return the derivative of f(x), whose value has a name already."""
        x = meaning.args[0]
        inner = self.of(x)
        if inner == 0 or meaning.func is sp.sign:
            return sp.S.Zero
        slopes = {
            sp.Abs: lambda: self.tape.name(f"s{self.tag}", sp.sign(x)),
            sp.tanh: lambda: 1 - value * value,
            sp.exp: lambda: value,
            sp.log: lambda: self.tape.name(f"i{self.tag}", 1 / self._nonzero(x)),
            sp.sin: lambda: self.tape.name(f"c{self.tag}", sp.cos(x)),
            sp.cos: lambda: -self.tape.name(f"c{self.tag}", sp.sin(x)),
        }
        if meaning.func not in slopes:
            raise SymgenError(f"{meaning} has no derivative here")
        return slopes[meaning.func]() * inner
