"""Base parameters of special geometry: named values, radicals, commensurable angles, couplings."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from oracles.numeric_rank import NoGapError, numeric_rank
from oracles.special_arms import FAMILIES, special_arm
from support import regrouping_error, sampled

import symgen


@pytest.mark.parametrize(
    ("family", "seeds"),
    [pytest.param(f, seeds, marks=marks) for f in FAMILIES
     for seeds, marks in ((range(6), []), (range(6, 20), [pytest.mark.slow]))],
)  # fmt: skip
def test_count_and_regrouping_equal_plain_numbers(family: str, seeds: range) -> None:
    unsure = 0
    for seed in seeds:
        special = special_arm(family, seed)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", symgen.SymgenWarning)
            robot = symgen.parse_robot(special.text)
        base = symgen.derive(robot).base
        column = special.columns(seed)
        W = np.stack(list(column.values()), axis=1)
        try:
            expected = numeric_rank(W)
        except NoGapError:
            unsure += 1
            continue
        state = [p for p in base.parameters if p.head in column]
        assert len(state) == expected, (family, seed)
        error = regrouping_error(state, column, robot.values())
        assert error < 1e-7 * max(1.0, np.abs(W).max()), (family, seed)
    assert unsure <= 1


@pytest.mark.parametrize("turn", sampled(["pi/8", "pi/24", "pi/5", "pi/7"], 2))
def test_a_named_fraction_of_pi_is_that_fraction(turn: str) -> None:
    # Turned forth and back by the same angle, the second axis is parallel to the first.
    text = """
    [robot]
    name = "arm"
    [geometry]
    a = "{turn}"
    [[joint]]
    [[joint]]
    sigma = 2
    alpha = "{forth}"
    [[joint]]
    alpha = "-{turn}"
    """
    counts = {
        forth: len(
            symgen.derive(symgen.parse_robot(text.format(turn=turn, forth=forth))).base.parameters
        )
        for forth in ("a", turn)
    }
    assert counts["a"] == counts[turn]


@pytest.mark.parametrize("tilt", sampled(["pi/7", "pi/9", "pi/11", "pi/15", "pi/25"], 2))
def test_square_roots_keep_their_sign_beside_fractions_of_pi(tilt: str) -> None:
    # 2 cos(pi/5) = (1 + sqrt(5))/2 closes the chain of fixed links: the axes coincide.
    joints = [
        f'sigma = 2\nalpha = "{tilt}"', f'alpha = "-{tilt}"', 'sigma = 2\ntheta = "pi/5"',
        'sigma = 2\nd = 1\ntheta = "-2*pi/5"', 'sigma = 2\nd = 1\ntheta = "pi/5"',
        'd = "-(1+sqrt(5))/2"',
    ]  # fmt: skip
    text = '[robot]\nname = "arm"\n' + "".join(f"[[joint]]\n{j}\n" for j in joints)
    assert len(symgen.derive(symgen.parse_robot(text)).base.parameters) == 7


def test_a_root_that_only_relations_need_is_found() -> None:
    text = '[robot]\nname = "arm"\n[[joint]]\nsigma = 1\n[[joint]]\nsigma = 2\nd = "sqrt(5)"\n'
    base = symgen.derive(symgen.parse_robot(text)).base
    assert "M1 + M2" in {p.expression for p in base.parameters}
