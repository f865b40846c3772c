"""Elimination of relations in named lengths, beside SymPy's rational functions."""

from __future__ import annotations

import pytest
import sympy as sp

from symgen.symbolic.elimination import (
    Elimination,
    NeedsValuesError,
    readable_form,
)
from symgen.symbolic.modular import PrimeField, primes

L1, L2, A = sp.symbols("L1 L2 a", real=True)
COLUMNS = ("P", "Q", "R", "S", "T")
_PRIMES = [p for p, _ in zip(primes(48), range(2), strict=False)]


def _fields() -> list[PrimeField]:
    return [PrimeField(p, seed, [A], 48) for seed, p in enumerate(_PRIMES, 1)]


def _eliminated(relations, columns=COLUMNS) -> Elimination:
    out = Elimination(columns, _fields())
    for relation in relations:
        out.add(out.exact({k: sp.sympify(v) for k, v in relation.items()}))
    return out


def test_a_relation_that_says_nothing_new_adds_nothing() -> None:
    assert len(_eliminated([{"P": 1, "Q": L1}, {"P": 2, "Q": 2 * L1}]).rows) == 1


def _sum(letter: str, count: int) -> sp.Expr:
    return sp.Add(*sp.symbols(f"{letter}:{count}", real=True))


@pytest.mark.parametrize(("left", "right", "large"), [(8, 5, False), (41, 1, True), (7, 6, True)])
def test_products_of_more_than_forty_terms_ask_for_values(left, right, large) -> None:
    a, b = _sum("u", left), _sum("w", right)
    first, second = {"P": b, "Q": 1}, {"Q": a, "R": 1}
    if large:
        with pytest.raises(NeedsValuesError, match="too large in named lengths"):
            _eliminated([first, second])
    else:
        assert len(_eliminated([first, second]).rows) == 2


def test_plain_numbers_are_never_too_large() -> None:
    root, nested = sp.sqrt(2), sp.sqrt(2 + sp.sqrt(2))
    many = sp.Add(1, root, sp.sqrt(3), sp.sqrt(6), nested, sp.sqrt(3) * nested, root * nested)
    assert len(sp.Add.make_args(many)) ** 2 > 40
    found = _eliminated([{"P": many, "Q": 1}, {"Q": many + 1, "R": 1}])
    assert len(found.rows) == 2
    with pytest.raises(NeedsValuesError):
        _eliminated([{"P": sp.expand(L1 * many), "Q": 1}, {"Q": many, "R": 1}])


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (sp.Rational(2, 3), sp.Rational(2, 3)),
        (L1 * (L1 + 2), L1**2 + 2 * L1),
        (sp.sqrt(2) * (L1 + 1), sp.sqrt(2) * L1 + sp.sqrt(2)),
        (sp.sin(A) ** 2, 1 - sp.cos(A) ** 2),
        (sp.sin(A) ** 3, sp.sin(A) - sp.sin(A) * sp.cos(A) ** 2),
        (sp.sin(A) ** 4, 1 - 2 * sp.cos(A) ** 2 + sp.cos(A) ** 4),
        (sp.sin(A) ** 5, sp.sin(A) - 2 * sp.sin(A) * sp.cos(A) ** 2 + sp.sin(A) * sp.cos(A) ** 4),
        (sp.sin(A) * sp.cos(A), sp.sin(A) * sp.cos(A)),
        (sp.cos(A) ** 2, sp.cos(A) ** 2),
        (L1 / sp.sin(A), L1 / sp.sin(A)),
        (sp.sin(A) ** 2 + sp.cos(A) ** 2, sp.S.One),
        (sp.sin(A) ** -2, sp.sin(A) ** -2),
    ],
)
def test_coefficients_are_written_as_a_person_would(given, wanted) -> None:
    assert sp.expand(readable_form(given) - wanted) == 0
    assert readable_form(given) == wanted


def test_what_has_no_symbol_but_a_cosine_becomes_fifty_digits() -> None:
    found = readable_form(sp.cos(sp.Rational(3, 10)) * 2)
    assert isinstance(found, sp.Float)
    assert abs(found - 2 * sp.cos(sp.Rational(3, 10)).evalf(70)) < sp.Float("1e-48", 60)
    assert readable_form(sp.sqrt(2) * 2) == 2 * sp.sqrt(2)
    assert isinstance(readable_form(sp.sqrt(2) * sp.Float("0.5", 50)), sp.Float)
