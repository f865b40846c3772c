"""What every estimator shares, beside plain NumPy: weights, precision, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.estimation.covariance import sandwich
from symgen.estimation.solve import (
    column_norms,
    condition,
    log_weights,
    merged,
    require_rows,
    undetermined,
)
from symgen.estimation.summary import Summary, summaries
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


def _stacked(logs, weights) -> tuple[np.ndarray, np.ndarray]:
    W = np.concatenate([w * e.W for w, e in zip(weights, logs, strict=True)])
    return W, np.concatenate([w * e.y for w, e in zip(weights, logs, strict=True)])


def test_there_must_be_more_equations_than_parameters() -> None:
    require_rows(_system(_log(1, 3, 0.0), _log(2, 1, 0.0)))
    with pytest.raises(symgen.IdentificationError, match="3 equations for 3 parameters: the log"):
        require_rows(_system(_log(1, 2, 0.0), _log(2, 1, 0.0)))


@pytest.mark.parametrize("count", [1, 3, 64, 65, 200])
def test_any_number_of_weighted_parts_is_solved_as_one(count: int) -> None:
    logs = [_log(k, 4 if k else 9, 0.3) for k in range(count)]
    weights = np.linspace(0.5, 2.0, count)
    X, scale, R = merged([s.factor for s in summaries(_system(*logs))], weights, NAMES)
    W, y = _stacked(logs, weights)
    np.testing.assert_allclose(X, np.linalg.lstsq(W, y, rcond=None)[0], rtol=1e-9)
    np.testing.assert_allclose(scale, np.linalg.norm(W, axis=0), rtol=1e-12)
    np.testing.assert_allclose((R.T @ R) * np.outer(scale, scale), W.T @ W, rtol=1e-9, atol=1e-9)
    assert condition(R) == pytest.approx(np.linalg.cond(W / np.linalg.norm(W, axis=0)), rel=1e-9)


def test_rows_are_weighed_one_by_one() -> None:
    e = _log(3, 20, 0.2)
    w = np.linspace(1, 3, 20)
    (found,) = [s.factor for s in summaries(_system(e).weighed([w]))]
    rows = w[:, None] * np.column_stack([e.W, e.y])
    np.testing.assert_allclose(found.T @ found, rows.T @ rows, rtol=1e-10)


@pytest.mark.parametrize("passes", [0, 1, 2, 3])
def test_each_pass_weighs_logs_by_the_residual_of_the_one_before(passes: int) -> None:
    logs = [_log(4, 30, 0.1), _log(5, 50, 2.0), _log(6, 20, 0.5)]
    weights, (X, *_) = log_weights(summaries(_system(*logs)), NAMES, passes)
    expected = np.ones(3)
    W, y = _stacked(logs, expected)
    best = np.linalg.lstsq(W, y, rcond=None)[0]
    for _ in range(passes):
        sigma = [np.sqrt(np.mean((e.y - e.W @ best) ** 2)) for e in logs]
        expected = 1 / np.array(sigma)
        W, y = _stacked(logs, expected)
        best = np.linalg.lstsq(W, y, rcond=None)[0]
    np.testing.assert_allclose(weights, expected, rtol=1e-9)
    np.testing.assert_allclose(X, best, rtol=1e-9)


def _summary(rows: int, correlation: int) -> Summary:
    return Summary(np.zeros((0, 4)), rows, correlation)


@pytest.mark.parametrize(
    ("parts", "m", "stretches"),
    [
        # rows over what overlaps, and over the lag of eight times that (a quarter of short logs)
        ([(400, 1)], 400, 50),
        ([(400, 10)], 40, 5),
        ([(400, 10), (80, 10)], 48, 5 + 4),
        ([(400, 0)], 400, 400),
        ([(4, 0)], 4, 4),
    ],
)
def test_the_sandwich_is_wider_where_few_stretches_are_summed(parts, m, stretches) -> None:
    draw = np.random.default_rng(9)
    bread, meat = draw.normal(size=(3, 3)), np.diag([1.0, 2.0, 3.0])
    b = 1 / stretches
    # critical values of Kiefer and Vogelsang (2005), table 1, of a two-sided test at 5 %
    wider = (1.96 + 2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    found = sandwich(bread, meat, [_summary(*part) for part in parts])
    np.testing.assert_allclose(
        found, wider**2 * m / max(m - 3, 1) * bread @ meat @ bread.T, rtol=1e-12
    )


def test_what_is_not_determined_is_named_and_counted() -> None:
    names = tuple("ABCDEFGHIJ")
    W = np.random.default_rng(16).normal(size=(50, 10))
    R = np.linalg.qr(W / np.linalg.norm(W, axis=0), mode="r")
    assert undetermined(R, names) == ""
    W[:, 2] = W[:, 5]
    R = np.linalg.qr(W / np.linalg.norm(W, axis=0), mode="r")
    assert "do not determine C, F (1 of 10 combinations" in undetermined(R, names)
    W[:, 8] = 0.0
    R = np.linalg.qr(W / column_norms(W), mode="r")
    assert "do not determine C, F, I (2 of 10 combinations" in undetermined(R, names)
    for count, words in ((8, "A, B, C, D, E, F, G, H (7 of 10"), (9, "F, G, H, ... (8 of 10")):
        W = np.random.default_rng(17).normal(size=(50, 10))
        W[:, :count] = W[:, :1]
        R = np.linalg.qr(W / column_norms(W), mode="r")
        assert words in undetermined(R, names)
