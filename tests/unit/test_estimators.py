"""Estimators beside plain NumPy: their precision, weights, words, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from oracles.precision import at_least_white, long_run, wider

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


def _log(seed: int, rows: int, noise: float, correlation: int = 1, weight: float = 1.0):
    draw = np.random.default_rng(seed)
    W = draw.normal(size=(rows, 3)) * np.array([1.0, 10.0, 0.1])
    y = W @ TRUE + noise * draw.normal(size=rows)
    return Equations(f"log {seed}", W, y, 0.01 * np.arange(rows), correlation, 0, weight)


def _system(*logs: Equations) -> LinearSystem:
    return LinearSystem(NAMES, logs)


LOGS = (_log(1, 200, 0.1), _log(2, 120, 1.0))


def _covariance(
    bread: np.ndarray, scores: list[np.ndarray], W: np.ndarray, y: np.ndarray, p: int = 3
) -> np.ndarray:
    """The robust covariance where no rows overlap: sums of scores over eight rows, or white."""
    meat = sum(long_run(s, 8) for s in scores)
    m = sum(map(len, scores))
    plain = wider(*((len(s), 8) for s in scores)) ** 2 * m / (m - p) * bread @ meat @ bread.T
    return at_least_white(plain, bread, W, y)


@pytest.mark.parametrize("passes", [0, 3])
def test_weighted_least_squares_and_its_precision(passes: int) -> None:
    found = (Wls() if passes else Ols()).solve(_system(*LOGS))
    w = np.ones(2)
    for k in range(passes + 1):
        W = np.concatenate([v * e.W for v, e in zip(w, LOGS, strict=True)])
        y = np.concatenate([v * e.y for v, e in zip(w, LOGS, strict=True)])
        X = np.linalg.lstsq(W, y, rcond=None)[0]
        if k < passes:
            w = np.array([1 / np.sqrt(np.mean((e.y - e.W @ X) ** 2)) for e in LOGS])
    np.testing.assert_allclose(found.X, X, rtol=1e-10)
    np.testing.assert_allclose(found.weights, w, rtol=1e-9)
    scores = [(v * v * (e.y - e.W @ X))[:, None] * e.W for v, e in zip(w, LOGS, strict=True)]
    expected = _covariance(np.linalg.inv(W.T @ W), scores, W, y)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-8)
    assert found.condition_number == pytest.approx(
        np.linalg.cond(W / np.linalg.norm(W, axis=0)), rel=1e-9
    )


def test_three_rows_for_three_parameters_are_refused_by_each() -> None:
    for estimator in (Ols(), Wls(), Huber(), Prior(TRUE, TRUE), TotalLeastSquares()):
        with pytest.raises(symgen.IdentificationError, match="3 equations for 3 parameters"):
            estimator.solve(_system(_log(3, 3, 0.1)))


def test_huber_is_where_its_clipped_scores_are_zero_and_says_how_many_are() -> None:
    one, other = _log(4, 300, 0.1), _log(5, 200, 0.5)
    for e in (one, other):
        e.y[::20] += 30.0
    found = Huber().solve(_system(one, other))
    logs, threshold = (one, other), 1.345
    errors = [e.y - e.W @ found.X for e in logs]
    s = [np.median(np.abs(e)) / scipy.stats.norm.ppf(0.75) for e in errors]
    clipped = [np.clip(e / v, -threshold, threshold) for e, v in zip(errors, s, strict=True)]
    scores = [(c / v)[:, None] * e.W for c, v, e in zip(clipped, s, logs, strict=True)]
    W = np.concatenate([e.W / v for e, v in zip(logs, s, strict=True)])
    slope = sum(x.sum(axis=0) for x in scores) / np.linalg.norm(W, axis=0)
    assert np.abs(slope).max() < 1e-8 * np.linalg.norm(W @ found.X)  # its tolerance
    np.testing.assert_allclose(found.weights, 1 / np.array(s), rtol=1e-9)
    beyond = np.concatenate([np.abs(e / v) > threshold for e, v in zip(errors, s, strict=True)])
    assert found.notes == (
        f"{100 * beyond.mean():.3g} % of the equations lie beyond the threshold and weigh less",
    )
    kept = [(e.W / v)[np.abs(x) <= threshold * v] for e, x, v in zip(logs, errors, s, strict=True)]
    bread = np.linalg.inv(sum(k.T @ k for k in kept))
    inside = np.concatenate([np.abs(x) <= threshold * v for x, v in zip(errors, s, strict=True)])
    y = np.concatenate([e.y / v for e, v in zip(logs, s, strict=True)])
    # a row beyond the threshold says nothing, and counts among the equations
    expected = _covariance(bread, scores, inside[:, None] * W, inside * y)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-6)
    # rows weigh as they did when X was found
    root = [np.sqrt(np.minimum(1, threshold * v / np.abs(x))) / v
            for x, v in zip(errors, s, strict=True)]  # fmt: skip
    W = np.concatenate([r[:, None] * e.W for r, e in zip(root, logs, strict=True)])
    assert found.condition_number == pytest.approx(
        np.linalg.cond(W / np.linalg.norm(W, axis=0)), rel=1e-4
    )


def test_huber_ends_where_it_is_told_to() -> None:
    e = _log(6, 300, 0.1)
    e.y[::15] += 20.0
    exact = Huber(tolerance=1e-14, passes=500).solve(_system(e)).X
    size = np.linalg.norm(e.W @ exact)

    def away(**options: float) -> float:
        X = Huber(**options).solve(_system(e)).X  # type: ignore[arg-type]
        return float(np.linalg.norm(e.W @ (X - exact)) / size)

    assert away(tolerance=1e-3) > away(tolerance=1e-8)
    assert away() < 1e-7
    assert away(passes=1) > away(passes=3) > 1e-8
    # with nothing beyond the threshold it is plain least squares
    np.testing.assert_allclose(
        Huber(threshold=1e3).solve(_system(e)).X, Ols().solve(_system(e)).X, rtol=1e-9
    )


def test_a_prior_and_its_precision_are_those_of_both_informations() -> None:
    logs = (_log(7, 200, 0.3, correlation=4), _log(8, 100, 2.0, correlation=0))
    mean, std = np.array([1.5, -1.0, 0.0]), np.array([0.05, 1.0, 0.02])
    found = Prior(mean, std).solve(_system(*logs))
    # each log by its residual, and by the rows that share samples
    w = [
        1 / np.sqrt(np.mean((e.y - e.W @ found.X) ** 2) * c)
        for e, c in zip(logs, (4, 1), strict=True)
    ]
    information = np.diag(1 / std**2)
    whole = information + sum(v * v * e.W.T @ e.W for v, e in zip(w, logs, strict=True))
    right = information @ mean + sum(v * v * e.W.T @ e.y for v, e in zip(w, logs, strict=True))
    np.testing.assert_allclose(found.X, np.linalg.solve(whole, right), rtol=1e-6)
    np.testing.assert_allclose(found.weights, w, rtol=1e-6)
    bread = np.linalg.inv(whole)
    first = (w[0] ** 2 * (logs[0].y - logs[0].W @ found.X))[:, None] * logs[0].W
    second = (w[1] ** 2 * (logs[1].y - logs[1].W @ found.X))[:, None] * logs[1].W
    meat = long_run(first, 32) + second.T @ second
    m = 200 / 4 + 100
    plain = wider((200, 32), (100, 1)) ** 2 * m / (m - 3) * bread @ meat @ bread
    W, y = (np.concatenate([v * x for v, x in zip(w, rows, strict=True)])
            for rows in ([e.W for e in logs], [e.y for e in logs]))  # fmt: skip
    data = at_least_white(plain, bread, W, y, m)
    np.testing.assert_allclose(found.covariance, data + bread @ information @ bread, rtol=1e-5)


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


def _orthogonal(logs, w, noise: np.ndarray) -> np.ndarray:
    """The X of smallest sum of (y - w'X)^2/(1 + X'CX), by Newton's steps on its slope."""
    W = np.concatenate([v * e.W for v, e in zip(w, logs, strict=True)])
    y = np.concatenate([v * e.y for v, e in zip(w, logs, strict=True)])
    X = np.linalg.lstsq(W, y, rcond=None)[0]
    for _ in range(200):
        ratio = np.sum((y - W @ X) ** 2) / (1 + np.sum((noise * X) ** 2))
        X = np.linalg.solve(W.T @ W - ratio * np.diag(noise**2), W.T @ y)
    return X


@pytest.mark.parametrize("noise", [[0.02, 0.1, 0.0], [0.0, 0.0, 0.01], [0.0, 0.0, 0.0], None])
def test_total_least_squares_and_its_precision(noise) -> None:
    found = TotalLeastSquares(None if noise is None else np.array(noise)).solve(_system(*LOGS))
    least = Wls().solve(_system(*LOGS))
    w = least.weights
    W = np.concatenate([v * e.W for v, e in zip(w, LOGS, strict=True)])
    y = np.concatenate([v * e.y for v, e in zip(w, LOGS, strict=True)])
    size = np.linalg.norm(W, axis=0) / np.linalg.norm(y) if noise is None else np.array(noise)
    X = _orthogonal(LOGS, w, size)
    np.testing.assert_allclose(found.X, X, rtol=1e-8)
    np.testing.assert_allclose(found.weights, w, rtol=1e-12)
    C, growth = size**2, 1 + np.sum((size * X) ** 2)
    errors = [v * (e.y - e.W @ X) for v, e in zip(w, LOGS, strict=True)]
    scores = [
        x[:, None] * (v * e.W + x[:, None] * (C * X / growth))
        for v, e, x in zip(w, LOGS, errors, strict=True)
    ]
    rss = sum(float(x @ x) for x in errors)
    information = W.T @ W - rss / growth * np.diag(C)
    expected = _covariance(np.linalg.inv(information), scores, W, y)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-6)
    unit = np.linalg.norm(W, axis=0)
    assert found.condition_number == pytest.approx(
        np.sqrt(np.linalg.cond(information / np.outer(unit, unit))), rel=1e-6
    )


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
