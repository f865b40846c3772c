"""The score that effects compete by, against a fit of every fold by itself."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.data.signals import Samples
from symgen.estimation.filtered_log import FilteredLog, unfiltered
from symgen.hypotheses.event import likeliest_contact
from symgen.hypotheses.score import FOLDS, PredictiveScore, motion_folds
from symgen.policy import TEMPERATURE

K, N, P = 240, 2, 5


def rows(seed: int = 0) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    W = rng.normal(size=(K, N, P)) * [1, 10, 0.1, 3, 1]
    C = rng.normal(size=(K, 2)) + W[:, 0, :2]
    y = W @ rng.normal(size=P) + rng.normal(size=(K, N)) * [0.3, 2.0]
    y[:, 0] += C @ [0.5, -0.2]
    weight = np.where(rng.random((K, N)) < 0.1, 0.0, 1.0)
    fold = np.repeat(np.arange(FOLDS), K // FOLDS)
    fold[:: K // FOLDS] = -1
    return W, C, y, weight, fold


def scored(seed: int) -> tuple[PredictiveScore, np.ndarray, tuple[np.ndarray, ...]]:
    W, C, y, weight, fold = data = rows(seed)
    sigma, misfit = np.array([0.5, 2.5]), np.array([0.01, 0.02])
    A = (W * (weight / sigma)[:, :, None]).reshape(-1, P)
    X = np.linalg.lstsq(A, (y * weight / sigma).ravel(), rcond=None)[0]
    score = PredictiveScore(W, y - W @ X, weight, sigma, fold, misfit)
    return score, C, data


def by_hand(W: np.ndarray, y: np.ndarray, weight: np.ndarray, fold: np.ndarray) -> tuple:
    """Fit all other folds anew, with plain least squares, and sum up what is left on each."""
    sigma, misfit = np.array([0.5, 2.5]), np.array([0.01, 0.02])
    total, left, count = 0.0, np.zeros(N), np.zeros(N)
    for f in range(FOLDS):
        rest, here = (fold != f) & (fold >= 0), fold == f
        A = (W * (weight / sigma)[:, :, None])[rest].reshape(-1, W.shape[2])
        b = np.linalg.lstsq(A, (y * weight / sigma)[rest].ravel(), rcond=None)[0]
        square = np.sum((weight * (y - W @ b))[here] ** 2, axis=0)
        m = np.sum(weight[here] ** 2, axis=0)
        total -= 0.5 * np.sum(m / TEMPERATURE * np.log(square / m + misfit**2))
        left, count = left + square, count + m
    return total, left / count


@pytest.mark.parametrize("seed", range(3))
def test_the_score_is_that_of_fits_to_the_other_folds(seed: int) -> None:
    score, C, (W, _, y, weight, fold) = scored(seed)
    total, left = by_hand(W, y, weight, fold)
    assert score.alone.score == pytest.approx(total, rel=1e-7)
    assert score.alone.variance == pytest.approx(left, rel=1e-6)
    more = np.zeros((K, N, 2))
    more[:, 0] = C
    total, left = by_hand(np.concatenate([W, more], axis=2), y, weight, fold)
    fit = score.fit_with({0: C})
    assert fit.score == pytest.approx(total, rel=1e-7)
    assert fit.variance == pytest.approx(left, rel=1e-6)
    assert fit.coefficients == pytest.approx([0.5, -0.2], abs=0.1)


def test_what_the_model_says_already_predicts_nothing_more() -> None:
    score, _, (W, *_) = scored(0)
    same = score.fit_with({0: W[:, 0, :1], 1: W[:, 1, :1]}, 1.0)
    assert same.score == pytest.approx(score.alone.score, abs=1e-3)
    assert same.torque == pytest.approx([0, 0], abs=1e-8)


def test_a_column_of_noise_does_not_predict_other_folds() -> None:
    gains = []
    for seed in range(20):
        score, _, _ = scored(seed)
        noise = np.random.default_rng(seed + 100).normal(size=(K, 1))
        gains.append(score.fit_with({1: noise}).score - score.alone.score)
    assert np.mean(gains) < 0
    assert max(gains) < 3


def moved(seed: int, start: float = 0.0) -> FilteredLog:
    """Return 20 s of two sums of sines, of a period of 10 s, from some time on."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 20, 0.01)
    w = 2 * np.pi * np.arange(1, 5) / 10
    a, phase = rng.normal(size=(4, 2)), rng.uniform(0, 6, (4, 2))
    angle = np.multiply.outer(t + start, w)[:, :, None] + phase
    q, qd = np.sum(a * np.sin(angle), axis=1), np.sum(a * w[:, None] * np.cos(angle), axis=1)
    return unfiltered(Samples(f"log{seed}", t, q, qd, 0 * q, 0.01, None, ()))


@pytest.mark.parametrize("size", [1.0, 8.0])
def test_noise_has_no_event_and_a_span_of_other_size_is_one(size: float) -> None:
    logs, rng = [moved(1), moved(2)], np.random.default_rng(5)
    fold = motion_folds(logs)
    begin = len(logs[0].kept) + 60
    e = rng.normal(size=(len(fold), N))
    e[begin : begin + 20, 1] *= size
    score = PredictiveScore(
        rng.normal(size=(len(fold), N, 3)), e, np.ones_like(e), np.ones(N), fold, np.full(N, 0.01)
    )
    found = likeliest_contact(score, logs, np.ones(N))
    if size == 1:
        assert found is None
    else:
        assert found is not None
        assert (found.cause.log, found.joints) == ("log2", (1,))
        assert np.mean(found.cause.rows[begin : begin + 20, 1]) > 0.8


def test_folds_are_blocks_of_time_of_like_size_that_do_not_touch() -> None:
    logs = [moved(1), moved(2)]
    fold = motion_folds(logs)
    assert len(fold) == sum(len(log.kept) for log in logs)
    sizes = np.bincount(fold[fold >= 0])
    assert len(sizes) == FOLDS
    assert sizes.min() > 0.4 * sizes.max()
    assert np.mean(fold < 0) < 0.3
    known = fold[fold >= 0]
    assert np.count_nonzero(np.diff(known)) < 60
    inside = np.diff(fold)[(fold[:-1] >= 0) & (fold[1:] >= 0)]
    between = len(logs[0].kept) - 1
    assert np.count_nonzero(inside) <= (fold[between] >= 0)  # where two logs meet
