"""Summaries of equations: triangles, sums of scores, and chunks that give what the whole gives."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from symgen.estimation.covariance import bartlett, scores
from symgen.estimation.summary import merge_summaries, summaries, triangle
from symgen.estimation.system import Equations, LinearSystem


def _draw(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape)


@pytest.mark.parametrize("rows", [3, 5, 20, 21, 22, 400])
def test_a_triangle_has_the_products_of_its_rows(rows: int) -> None:
    A = _draw(1, rows, 5) * np.array([1.0, 1e-6, 30.0, 1e4, 0.2])
    R = triangle(A)
    assert R.shape == (min(rows, 5), 5)
    np.testing.assert_array_equal(R, np.triu(R))
    unit = np.linalg.norm(A, axis=0)
    np.testing.assert_allclose(R.T @ R / np.outer(unit, unit), A.T @ A / np.outer(unit, unit),
                               atol=1e-13)  # fmt: skip


def test_columns_of_zeros_and_columns_that_depend_keep_their_products() -> None:
    A = _draw(2, 300, 4)
    for change in (0 * A[:, 1], A[:, 0], A[:, 0] + 1e-9 * A[:, 3]):
        B = A.copy()
        B[:, 2] = change
        R = triangle(B)
        np.testing.assert_allclose(R.T @ R, B.T @ B, atol=1e-11)
    np.testing.assert_array_equal(triangle(np.zeros((300, 3))), np.zeros((3, 3)))


def test_nearly_dependent_columns_are_as_exact_as_by_reflections() -> None:
    """The products of A lose half the digits, its triangle must not: R^-1 makes A orthogonal."""
    for apart in (1e-3, 1e-5, 3e-6, 1e-7, 1e-8):
        A = _draw(3, 500, 3)
        A[:, 2] = A[:, 0] + apart * A[:, 2]
        Q = A @ np.linalg.inv(triangle(A))
        assert np.abs(Q.T @ Q - np.eye(3)).max() < 1e-15 / apart


def _equations(seed: int, rows: int, correlation: int = 1) -> Equations:
    W, y = _draw(seed, rows, 3), _draw(seed + 100, rows)
    return Equations("a", W, y, np.arange(rows) * 0.01, correlation, 0)


def test_a_summary_knows_the_residual_of_any_parameters_and_what_it_is_of() -> None:
    first, second = _equations(4, 50, 3), _equations(5, 31, 7)
    found = summaries(LinearSystem(("A", "B", "C"), (first, second)))
    assert [(s.rows, s.correlation) for s in found] == [(50, 3), (31, 7)]
    for s, e in zip(found, (first, second), strict=True):
        X = np.array([0.3, -2.0, 5.0])
        assert s.rss(X) == pytest.approx(float(np.sum((e.y - e.W @ X) ** 2)), rel=1e-12)
        assert s.square == pytest.approx(float(e.y @ e.y), rel=1e-12)


def test_summaries_of_chunks_merge_to_that_of_the_whole() -> None:
    whole = _equations(6, 200, 5)
    X = np.array([1.0, 2.0, -1.0])
    edges = [0, 30, 90, 91, 150, 200]
    parts = []
    for a, b in pairwise(edges):
        chunk = Equations("a", whole.W[a:b], whole.y[a:b], whole.t[a:b], 5, 0)
        parts += summaries(LinearSystem(("A", "B", "C"), (chunk,)))
    (one,) = summaries(LinearSystem(("A", "B", "C"), (whole,)))
    for count in range(1, len(parts) + 1):
        found = merge_summaries(parts[:count])
        rows = edges[count]
        assert (found.rows, found.correlation) == (rows, 5)
        error = whole.y[:rows] - whole.W[:rows] @ X
        assert found.rss(X) == pytest.approx(float(error @ error), rel=1e-12)
    np.testing.assert_allclose(
        np.abs(merge_summaries(parts).factor), np.abs(one.factor), rtol=1e-10, atol=1e-12
    )


def test_scores_are_those_of_the_weighted_squares() -> None:
    """Minus half the slope of sum w^2 (y - W X)^2 in X, by differences."""
    e = _equations(7, 40)
    X, h, w = np.array([0.5, -1.0, 2.0]), 1e-5, 1.7
    found = scores(e, X, w)
    assert found.shape == (40, 3)
    for k, unit in enumerate(np.eye(3)):
        up, down = ((w * (e.y - e.W @ (X + s * h * unit))) ** 2 for s in (1, -1))
        np.testing.assert_allclose(found[:, k], -(up - down) / (4 * h), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("lag", [1, 2, 7, 30])
def test_sums_over_a_lag_are_bartletts_weights_on_lagged_products(lag: int) -> None:
    s = _draw(8, 60, 2)
    expected = s.T @ s
    for k in range(1, lag):
        product = s[k:].T @ s[:-k]
        expected += (1 - k / lag) * (product + product.T)
    np.testing.assert_allclose(bartlett(s, lag), expected, rtol=1e-10, atol=1e-10)
