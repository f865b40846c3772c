"""Gauss-Jordan elimination of relations whose coefficients are formulas.

Every coefficient has a formula, and residues modulo the primes of the proof. The residues decide
exactly whether it is zero, without simplification or rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from symgen.errors import SymgenError
from symgen.symbolic.modular import PrimeField

_DIGITS = 50


_LARGEST = 40  # terms of a product of two coefficients; a longer formula is unreadable


class NeedsValuesError(SymgenError):
    """A formula in named lengths and angles is too large; use the values of the file instead."""


class Coefficient(NamedTuple):
    """A formula (or 50 digits, see `readable_form`), and its residue modulo each prime."""

    value: sp.Expr
    residues: tuple[int, ...]


ExactRow = dict[str, Coefficient]


class Elimination:
    """Reduced relations X_d + sum of n_b X_b = 0, in terms of the parameters that stay.

    Args:
        column: names of the columns; the last one is eliminated first.
        fields: the primes, with the values of their residues.
    """

    def __init__(self, column: Sequence[str], fields: Sequence[PrimeField]) -> None:
        self.position = {name: k for k, name in enumerate(column)}
        self.fields = fields
        self.rows: dict[str, ExactRow] = {}

    def exact(self, relation: Mapping[str, sp.Expr]) -> ExactRow:
        """Return a relation with the residues of its coefficients."""
        row = {
            name: Coefficient(readable_form(c), tuple(int(f.constant(c)) for f in self.fields))
            for name, c in relation.items()
        }
        return {name: c for name, c in row.items() if any(c.residues)}

    def add(self, row: ExactRow) -> None:
        """Add a relation; it eliminates its last parameter."""
        for name in [n for n in row if n in self.rows]:
            row = self._substitute(row, name, self.rows[name])
        if not row:
            return
        pivot = max(row, key=self.position.__getitem__)
        row = self._divided(row, row[pivot])
        for name, other in self.rows.items():
            if pivot in other:
                self.rows[name] = self._substitute(other, pivot, row)
        self.rows[pivot] = row

    def _substitute(self, row: ExactRow, name: str, other: ExactRow) -> ExactRow:
        """Return row - row[name] * other."""
        factor = row[name]
        out = dict(row)
        zero = Coefficient(sp.S.Zero, (0,) * len(self.fields))
        for n, c in other.items():
            before = out.get(n, zero)
            residues = tuple(
                (a - b * x) % f.p
                for a, b, x, f in zip(
                    before.residues, factor.residues, c.residues, self.fields, strict=True
                )
            )
            if any(residues):
                _require_small(factor.value, c.value)
                out[n] = Coefficient(readable_form(before.value - factor.value * c.value), residues)
            else:
                out.pop(n, None)
        return out

    def _divided(self, row: ExactRow, lead: Coefficient) -> ExactRow:
        if lead.value == 1:
            return row
        inverses = [pow(r, -1, f.p) for r, f in zip(lead.residues, self.fields, strict=True)]
        return {
            n: Coefficient(
                readable_form(c.value / lead.value),
                tuple(
                    r * i % f.p for r, i, f in zip(c.residues, inverses, self.fields, strict=True)
                ),
            )
            for n, c in row.items()
        }


def _require_small(a: sp.Expr, b: sp.Expr) -> None:
    """Raise NeedsValuesError if the product of two formulas is too large to write out."""
    size = len(sp.Add.make_args(a)) * len(sp.Add.make_args(b))
    if size > _LARGEST and (a.free_symbols or b.free_symbols):
        raise NeedsValuesError("a regrouping formula is too large in named lengths and angles")


@lru_cache(maxsize=10_000)  # both sides of a robot, and its nominal geometry, have equal ones
def readable_form(expr: sp.Expr) -> sp.Expr:
    """Return a coefficient as a person would write it.

    Polynomials in lengths are expanded, and sin(a)^2 becomes 1 - cos(a)^2. A coefficient without
    symbols becomes a number with 50 digits if it contains cosines of angles that are not simple
    fractions of pi.
    """
    if expr.is_Rational:
        return expr
    trigonometric = expr.has(sp.sin, sp.cos, sp.tan)
    if (trigonometric or expr.has(sp.Float)) and not expr.free_symbols:
        return expr.evalf(_DIGITS)
    expanded = sp.expand(expr)
    if not trigonometric:
        return expanded
    squares = [
        p
        for p in expanded.atoms(sp.Pow)
        if p.base.func is sp.sin and p.exp.is_Integer and p.exp >= 2
    ]
    return (
        sp.expand(expanded.xreplace({p: _even_sine(p) for p in squares})) if squares else expanded
    )


def _even_sine(power: sp.Pow) -> sp.Expr:
    angle, half = power.base.args[0], int(power.exp) // 2
    return (1 - sp.cos(angle) ** 2) ** half * power.base ** (int(power.exp) % 2)
