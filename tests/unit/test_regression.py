"""What every estimator shares, beside plain NumPy: weights, precision, and what is refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from oracles.precision import at_least_white, long_run, wider

import symgen
from symgen.errors import IdentificationError
from symgen.estimation.covariance import robust_covariance, sandwich
from symgen.estimation.equation_model import require_model
from symgen.estimation.solve import (
    column_norms,
    condition,
    factors,
    inverse_deviation,
    log_weights,
    merged,
    require_rows,
    undetermined,
    weighed,
)
from symgen.estimation.summary import Blocks, Summary, deviation_of_difference, summaries
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
    (found,) = factors(_system(e), [w])
    rows = w[:, None] * np.column_stack([e.W, e.y])
    np.testing.assert_allclose(found.T @ found, rows.T @ rows, rtol=1e-10)


@pytest.mark.parametrize("passes", [0, 1, 2, 3])
def test_each_pass_weighs_logs_by_the_residual_of_the_one_before(passes: int) -> None:
    logs = [_log(4, 30, 0.1, weight=4.0), _log(5, 50, 2.0), _log(6, 20, 0.5, weight=0.25)]
    weights, X, *_ = log_weights(summaries(_system(*logs)), NAMES, passes)
    own = np.array([2.0, 1.0, 0.5])
    expected = own.copy()
    W, y = _stacked(logs, expected)
    best = np.linalg.lstsq(W, y, rcond=None)[0]
    for _ in range(passes):
        sigma = [np.sqrt(np.mean((e.y - e.W @ best) ** 2)) for e in logs]
        expected = own / np.array(sigma)
        W, y = _stacked(logs, expected)
        best = np.linalg.lstsq(W, y, rcond=None)[0]
    np.testing.assert_allclose(weights, expected, rtol=1e-9)
    np.testing.assert_allclose(X, best, rtol=1e-9)


def test_two_logs_are_enough_for_weights_and_one_keeps_its_own() -> None:
    one, other = _log(7, 30, 0.1, weight=9.0), _log(8, 30, 3.0)
    assert log_weights(summaries(_system(one)), NAMES, 3)[0] == pytest.approx([3.0])
    found = log_weights(summaries(_system(one, other)), NAMES, 3)[0]
    assert found[0] > 10 * found[1]


def test_no_deviation_counts_as_less_than_a_millionth_of_the_largest() -> None:
    np.testing.assert_allclose(
        inverse_deviation(np.array([2.0, 4e-6, 1e-9, 0.0])), [0.5, 2.5e5, 5e5, 5e5], rtol=1e-12
    )
    np.testing.assert_allclose(inverse_deviation(np.array([4e-300])), [2.5e299])
    np.testing.assert_allclose(inverse_deviation(np.zeros(2)), [1e300, 1e300])


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


def test_less_than_one_stretch_counts_as_one() -> None:
    found = sandwich(np.eye(1), np.eye(1), [Summary(np.zeros((0, 2)), 0, 1)])
    wider = (1.96 + 2.9694 + 0.4160 - 0.5324) / 1.96
    assert found[0, 0] == pytest.approx(0.0 * wider)
    few = sandwich(np.eye(3), np.eye(3), [_summary(3, 1)])
    b = 1 / 3
    wider = (1.96 + 2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    assert few[0, 0] == pytest.approx(wider**2 * 3 / 1)


def test_scores_of_each_log_are_summed_over_its_own_lag() -> None:
    logs = [_log(10, 200, 0.1, 2), _log(11, 40, 0.1, 3)]
    draw = np.random.default_rng(12)
    scores = [draw.normal(size=(len(e.y), 3)) for e in logs]
    bread = draw.normal(size=(3, 3))
    meat = long_run(scores[0], 16) + long_run(scores[1], 10)
    m = 200 / 2 + 40 / 3
    plain = wider((200, 16), (40, 10)) ** 2 * m / (m - 3) * bread @ meat @ bread.T
    # rows without a weight say nothing of white noise, and without random functions of a misfit
    system, none = _system(*logs), [0.0 * s for s in scores]
    for own, expected in ((none, 0.0 * plain), (scores, plain)):
        noise, misfit = robust_covariance(system, np.zeros(3), bread, own, [0.0, 0.0])
        np.testing.assert_allclose(noise, expected, rtol=1e-9)
        assert not misfit.any()


def test_rows_that_weigh_differently() -> None:
    logs = [_log(14, 200, 0.3), _log(15, 100, 0.2)]
    w = [np.full(200, 2.0), np.linspace(1, 2, 100)]
    found = weighed(_system(*logs), w)
    rows = [v[:, None] * np.column_stack([e.W, e.y]) for v, e in zip(w, logs, strict=True)]
    W, y = np.split(np.concatenate(rows), [3], axis=1)
    X = np.linalg.lstsq(W, y[:, 0], rcond=None)[0]
    inverse = np.linalg.inv(W.T @ W)
    s = (y[:, 0] - W @ X)[:, None] * W
    meat = long_run(s[:200], 8) + long_run(s[200:], 8)
    plain = wider((200, 8), (100, 8)) ** 2 * 300 / 297 * inverse @ meat @ inverse
    expected = at_least_white(plain, inverse, W, y[:, 0])
    np.testing.assert_allclose(found.X, X, rtol=1e-12)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-8)


def test_norms_of_columns_are_one_where_they_are_zero() -> None:
    np.testing.assert_allclose(
        column_norms(np.array([[3.0, 0.0, 1e-9], [4.0, 0, 0]])), [5, 1, 1e-9]
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


@pytest.mark.parametrize(("apart", "determined"), [(3e-8, True), (3e-9, False)])
def test_a_combination_counts_from_a_share_of_one_in_a_hundred_million(apart, determined) -> None:
    R = np.diag([1.0, 1.0, apart])
    assert (undetermined(R, NAMES) == "") is determined
    if not determined:
        assert "do not determine C (1 of 3" in undetermined(R, NAMES)


def test_every_parameter_of_a_combination_that_is_lost_is_named() -> None:
    # a + b/100 has no effect: b leads the combination, and a belongs to it.
    said = undetermined(np.array([[1.0, -0.01], [0.0, 0.0]]), ("a", "b"))
    assert "do not determine a, b (1 of 2" in said


def test_the_jackknife_of_a_difference_is_that_of_plain_fits() -> None:
    rng = np.random.default_rng(2)
    W, count = rng.normal(size=(2, 6, 40, 3)), 6
    y = W[0] @ [1.0, 2.0, 3.0] + 0.1 * rng.normal(size=(2, 6, 40))

    def summary(W: np.ndarray, y: np.ndarray) -> Blocks:
        rows = np.concatenate([W, y[:, :, None]], axis=2)
        return Blocks(np.einsum("bka,bkc->bac", rows, rows)[:, None], np.full((count, 1), 40.0))

    found = deviation_of_difference(summary(W[0], y[0]), summary(W[1], y[1]), range(count))
    d = []
    for k in range(count):
        left = [b for b in range(count) if b != k]
        fits = [
            np.linalg.lstsq(w[left].reshape(-1, 3), z[left].ravel(), rcond=None)[0]
            for w, z in zip(W, y, strict=True)
        ]
        d.append(fits[0] - fits[1])
    expected = np.sqrt((count - 1) * np.var(d, axis=0))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize(("loaded", "refused"), [(True, ("energy", "momentum")), (False, ())])
def test_effects_that_hold_torques_of_links_are_for_the_torque_model(loaded, refused) -> None:
    robot: Any = SimpleNamespace(loaded=loaded)
    for model in ("energy", "momentum", "torque"):
        if model in refused:
            with pytest.raises(IdentificationError, match=f"model {model}: .*accepted: model tor"):
                require_model(robot, model)
        else:
            require_model(robot, model)
