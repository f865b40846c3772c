"""Formulas for printing: sums of products in a fixed order that SymPy does not change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby

import sympy as sp

from symgen.robot.expressions import text
from symgen.symbolic.tape import terms


@dataclass(frozen=True)
class Call:
    """A function of one argument: sin, cos, sign, abs, tanh, sqrt or exp."""

    name: str
    argument: Formula


@dataclass(frozen=True)
class Factor:
    """A base to an integer power."""

    base: sp.Symbol | Call | Formula
    power: int = 1


@dataclass(frozen=True)
class Product:
    """A number times factors; the number may be negative."""

    number: sp.Expr
    factors: tuple[Factor, ...] = ()


@dataclass(frozen=True)
class Formula:
    """A sum of products; the empty sum is 0."""

    products: tuple[Product, ...]

    @property
    def size(self) -> int:
        """Number of products, including those in parentheses."""
        return sum(
            max(1, sum(f.base.size for f in p.factors if isinstance(f.base, Formula)))
            for p in self.products
        )

    @property
    def depth(self) -> int:
        """Nesting depth of parentheses."""
        inner = [f.base.depth + 1 for p in self.products for f in p.factors
                 if isinstance(f.base, Formula)]  # fmt: skip
        return max(inner, default=0)


def step(expr: sp.Expr, order: Mapping[sp.Symbol, int]) -> Formula:
    """Convert an expression of a tape, in the order of the tape."""
    if expr.is_number:
        return geometric(expr)
    if expr.is_Pow and expr.exp == -1:
        return Formula((Product(sp.S.One, (Factor(_inner(expr.base, order), -1),)),))
    products = []
    for negative, factors in [(False, [expr])] if expr.is_Function else terms(expr, order):
        number: sp.Expr = sp.S.NegativeOne if negative else sp.S.One
        found: list[Factor] = []
        for factor, repeated in groupby(factors):
            count = len(list(repeated))
            if factor.is_number:
                number *= factor**count
            elif factor.is_Pow:
                found.append(Factor(_inner(factor.base, order), -count))
            else:
                found.append(Factor(_inner(factor, order), count))
        products.append(Product(number, tuple(found)))
    return Formula(tuple(products))


def _inner(expr: sp.Expr, order: Mapping[sp.Symbol, int]) -> sp.Symbol | Call | Formula:
    if expr.is_Symbol:
        return expr
    if expr.is_Function:
        return Call(expr.func.__name__.lower(), step(expr.args[0], order))
    return step(expr, order)


def geometric(expr: sp.Expr) -> Formula:
    """Convert an expression of lengths and angles, in the order of robot files."""
    parts = sorted(sp.Add.make_args(expr), key=lambda e: _signed(text(e)))
    return Formula(tuple(_product(part) for part in parts if part != 0))


def _signed(written: str) -> tuple[bool, str]:
    return written.startswith("-"), written


def _product(expr: sp.Expr) -> Product:
    number, rest = expr.as_coeff_Mul()
    parts = [] if rest is sp.S.One else list(sp.Mul.make_args(rest))
    parts.sort(key=lambda part: (not part.is_number, text(part)))
    return Product(number, tuple(constant_factor(part) for part in parts))


def constant_factor(expr: sp.Expr) -> Factor:
    """Convert one factor of a geometric expression."""
    if expr.is_Pow and expr.exp.is_Rational:
        power = expr.exp
        if power.q == 2:
            root = Call("sqrt", geometric(expr.base ** abs(power.p)))
            return Factor(root, 1 if power > 0 else -1)
        return Factor(constant_factor(expr.base).base, int(power))
    if expr.is_Function:
        return Factor(Call(expr.func.__name__.lower(), geometric(expr.args[0])))
    return Factor(expr if expr.is_Symbol or expr is sp.pi else geometric(expr))
