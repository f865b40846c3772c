"""Estimators beside plain NumPy: their precision, weights, words, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.estimation.estimators import (
    Huber,
    Ols,
    Prior,
    TotalLeastSquares,
    Wls,
)
from symgen.estimation.system import Equations, LinearSystem

NAMES = ("A", "B", "C")
TRUE = np.array([2.0, -1.0, 0.5])


def _log(seed: int, rows: int, noise: float, correlation: int = 1):
    draw = np.random.default_rng(seed)
    W = draw.normal(size=(rows, 3)) * np.array([1.0, 10.0, 0.1])
    y = W @ TRUE + noise * draw.normal(size=rows)
    return Equations(f"log {seed}", W, y, 0.01 * np.arange(rows), correlation, 0)


def _system(*logs: Equations) -> LinearSystem:
    return LinearSystem(NAMES, logs)


LOGS = (_log(1, 200, 0.1), _log(2, 120, 1.0))


def test_three_rows_for_three_parameters_are_refused_by_each() -> None:
    for estimator in (Ols(), Wls(), Huber(), Prior(TRUE, TRUE), TotalLeastSquares()):
        with pytest.raises(symgen.IdentificationError, match="3 equations for 3 parameters"):
            estimator.solve(_system(_log(3, 3, 0.1)))


@pytest.mark.parametrize(
    ("mean", "std", "said"),
    [
        (TRUE[:2], TRUE[:2], "the prior is not one of 3 parameters"),
        (TRUE, np.ones(2), "the prior is not one of 3 parameters"),
        (np.append(TRUE, 1), np.ones(4), "the prior is not one of 3 parameters"),
        (np.array([1, np.nan, 1]), np.ones(3), "means are not finite, or a std is not above 0"),
        (np.array([1, np.inf, 1]), np.ones(3), "means are not finite, or a std is not above 0"),
        (TRUE, np.array([1.0, 0.0, 1.0]), "means are not finite, or a std is not above 0"),
        (TRUE, np.array([1.0, -1.0, 1.0]), "means are not finite, or a std is not above 0"),
        (TRUE, np.array([1.0, np.nan, 1.0]), "means are not finite, or a std is not above 0"),
    ],
)
def test_a_prior_that_is_none_is_refused(mean, std, said: str) -> None:
    with pytest.raises(symgen.IdentificationError, match=said):
        Prior(mean, std).solve(_system(*LOGS))


# Errors in variables.


@pytest.mark.parametrize(
    "noise", [[0.1, 0.1], [0.1, -0.1, 0.1], [0.1, np.nan, 0], [0.1, np.inf, 0]]
)
def test_a_noise_that_is_none_is_refused(noise) -> None:
    with pytest.raises(symgen.IdentificationError, match="is not 3 numbers of 0 or above"):
        TotalLeastSquares(np.array(noise)).solve(_system(*LOGS))


def test_total_least_squares_without_an_answer_says_so() -> None:
    W = np.tile([1.0, -1.0], 50)[:, None]
    flat = LinearSystem(("A",), (Equations("a", 1e-3 * W, np.ones(100), np.arange(100.0), 1),))
    with pytest.raises(symgen.IdentificationError, match="total least squares has no"):
        TotalLeastSquares(np.ones(1)).solve(flat)
