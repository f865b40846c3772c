"""Folded formulas say the same as whole ones."""

from __future__ import annotations

import json
import re

import pytest
import sympy as sp
from support import PROJECT

from symgen.report.folded import folded

_RUN = re.compile(r"([A-Z]+)(\d+) ([+-]) \.\.\. [+-] [A-Z]+(\d+)")


def _written_out(formula: str) -> sp.Expr:
    """Undo runs, and let SymPy read the rest."""

    def members(found: re.Match[str]) -> str:
        kind, first, sign, last = found.groups()
        return f" {sign} ".join(f"{kind}{k}" for k in range(int(first), int(last) + 1))

    return sp.sympify(_RUN.sub(members, formula)).expand()


def test_folded_formulas_are_the_whole_ones() -> None:
    file = PROJECT / "generated" / "puma560" / "manifest.json"
    shorter = 0
    for parameter in json.loads(file.read_text())["base_parameters"]:
        whole = parameter["expression"]
        assert _written_out(folded(whole)) == sp.sympify(whole).expand(), whole
        shorter += len(folded(whole)) < len(whole)
    assert shorter


@pytest.mark.parametrize(
    ("whole", "short"),
    [
        ("M3 + 0.316*M4 + 0.316*M5 + 0.316*M6 + 0.316*M7", "M3 + 0.316*(M4 + ... + M7)"),
        ("-MZ3 - R3*M3 - R3*M4 + R3*M5", "-MZ3 - R3*(M3 + M4 - M5)"),
        ("(D4**2 + R3**2)*M4 + (D4**2 + R3**2)*M5", "(D4**2 + R3**2)*(M4 + M5)"),
        ("OF4 - 9.81*M4", "OF4 - 9.81*M4"),
        ("IA4 + M4", "IA4 + M4"),
        ("M4 + M5 + M6 + M7", "M4 + ... + M7"),
    ],
)
def test_equal_factors_are_written_once(whole: str, short: str) -> None:
    assert folded(whole) == short
