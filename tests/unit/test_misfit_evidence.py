"""Columns compete with a misfit of any shape."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.estimation.features import mixtures
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import TEMPERATURE

ROWS, NOISE, EXPECTED = 480, 0.003, 0.004


def scene(y: np.ndarray, F: np.ndarray) -> MisfitEvidence:
    """The rows of one joint with a torque of RMS 1, whose model is a constant and a slope."""
    W = np.column_stack([np.ones(ROWS), np.linspace(-1, 1, ROWS)])
    X = np.linalg.lstsq(W, y, rcond=None)[0]
    left = y - W @ X
    return MisfitEvidence(
        W[:, None], left[:, None], np.ones((ROWS, 1)), np.array([left.std()]), F[:, None],
        np.array([EXPECTED]),
    )  # fmt: skip


def drawn(seed: int) -> tuple[np.random.Generator, np.ndarray, np.ndarray]:
    """Smooth functions of a path that passes the same states again and again, and noise."""
    rng = np.random.default_rng(seed)
    m = mixtures().shape[1]
    phase = np.cumsum(np.full(ROWS, 24 * np.pi / ROWS))
    x = np.column_stack([np.sin(phase), np.cos(0.37 * phase)])
    F = np.cos(x @ rng.normal(size=(2, m)) * 1.5 + rng.uniform(0, 2 * np.pi, m))
    return rng, F / np.sqrt(m), NOISE * rng.normal(size=ROWS)


def test_a_misfit_may_be_all_friction_or_none_and_is_one_as_much_as_the_other_beforehand() -> None:
    each = mixtures()
    np.testing.assert_allclose(each.mean(axis=0), 1.0)
    np.testing.assert_allclose(each.mean(axis=1), 1.0)
    assert (each.min(axis=0) == 0).all()


@pytest.mark.parametrize("seed", range(3))
def test_a_smooth_misfit_is_no_evidence_for_a_column_that_looks_like_it(seed: int) -> None:
    rng, F, noise = drawn(seed)
    missed = F @ rng.normal(size=F.shape[1])
    missed *= 0.01 / missed.std()
    other = F @ rng.normal(size=F.shape[1])
    looks = missed / missed.std() + 0.5 * other / other.std()
    own = scene(missed + noise, F).of({0: looks[:, None]}, np.array([0.3]))
    W = np.column_stack([np.ones(ROWS), np.linspace(-1, 1, ROWS)])
    rss = [
        np.sum((missed + noise - A @ np.linalg.lstsq(A, missed + noise, rcond=None)[0]) ** 2)
        for A in (W, np.column_stack([W, looks]))
    ]
    independent = 0.5 * ROWS / TEMPERATURE * np.log(rss[0] / rss[1])
    assert own < 0.2 * independent  # rows are not: a few functions give all of them


@pytest.mark.parametrize("seed", range(3))
def test_a_column_that_no_smooth_function_gives_is_shown(seed: int) -> None:
    _, F, noise = drawn(seed)
    step = np.sign(np.sin(np.arange(ROWS) * 0.9))
    assert scene(0.015 * step + noise, F).of({0: step[:, None]}, np.array([0.3])) > 50


def dense(W: np.ndarray, r: np.ndarray, F: np.ndarray, columns: int) -> float:
    """Log density of the rows by dense matrices, the last columns of W with their own prior.

    Restricted likelihood with rows that count as one in TEMPERATURE, a half-Cauchy law of the size
    of the misfit, equal shares of friction, and the most probable variance of the rows.
    """
    from scipy.optimize import minimize_scalar

    rows = np.sqrt(TEMPERATURE)
    W, r, F = W / rows, r / rows, F * EXPECTED / rows
    sizes = np.geomspace(0.03, 3000.0, 31)
    prior = np.log(sizes / (1 + sizes**2))

    def cost(log_v: float) -> float:
        v, found = np.exp(log_v), []
        for D in mixtures():
            K = (F * D) @ F.T
            for s, p in zip(sizes, prior, strict=True):
                S = np.eye(len(r)) + s**2 / v * K
                SW, Sr = np.linalg.solve(S, W), np.linalg.solve(S, r)
                G = W.T @ SW / v
                left = (r @ Sr - r @ SW @ np.linalg.solve(W.T @ SW, W.T @ Sr)) / v
                dets = np.linalg.slogdet(S)[1] + np.linalg.slogdet(G)[1]
                found.append(p - 0.5 * (dets + left + len(r) / TEMPERATURE * log_v))
        return -float(np.logaddexp.reduce(found))

    start = np.log(max(r.var() * TEMPERATURE, EXPECTED**2))
    best = minimize_scalar(cost, bounds=(np.log(EXPECTED**2), start), method="bounded")
    student = np.log(2 / (np.pi * np.sqrt(3)))  # density at zero, of each column
    return -float(best.fun) + columns * (student + np.log(2 * np.pi) / 2)


@pytest.mark.parametrize("step", [0.02, 0.0])
def test_the_evidence_is_that_of_dense_densities(step: float) -> None:
    rng, F, _ = drawn(7)
    few = slice(0, ROWS, 10)
    F, t = F[few], np.linspace(-1, 1, ROWS)[few]
    column = np.sign(np.sin(np.arange(ROWS) * 0.9))[few]
    W = np.column_stack([np.ones(len(t)), t])
    y = F @ rng.normal(size=F.shape[1]) * 0.01 + step * column + 0.01 * rng.normal(size=len(t))
    r = y - W @ np.linalg.lstsq(W, y, rcond=None)[0]
    unit = 0.3
    ones = np.ones((len(t), 1))
    own = MisfitEvidence(
        W[:, None], r[:, None], ones, np.array([r.std()]), F[:, None], np.array([EXPECTED])
    ).of({0: column[:, None]}, np.array([unit]))
    expected = dense(np.column_stack([W, unit * column]), r, F, 1) - dense(W, r, F, 0)
    assert own == pytest.approx(expected, abs=0.5)


@pytest.mark.parametrize("quiet", [0.0, 0.002])
def test_a_joint_that_a_column_does_not_move_adds_no_evidence(quiet: float) -> None:
    """One joint misses much, another little: each has a misfit of its own size."""
    rng, F, noise = drawn(3)
    column = np.sign(np.sin(np.arange(ROWS) * 0.9))
    missed = F @ rng.normal(size=(F.shape[1], 2)) * np.array([0.2, quiet])
    y = missed + np.column_stack([0.1 * column + noise, NOISE * rng.normal(size=ROWS)])
    W, none = np.ones((ROWS, 2, 2)), np.zeros((ROWS, 1))
    W[:, 0, 1] = W[:, 1, 0] = 0.0
    left = y - y.mean(axis=0)
    found = MisfitEvidence(
        W, left, np.ones((ROWS, 2)), left.std(axis=0), np.stack([F, F], axis=1),
        np.full(2, EXPECTED),
    )  # fmt: skip
    alone = found.of({0: column[:, None]}, np.array([0.3]))
    assert found.of({0: column[:, None], 1: none}, np.array([0.3])) == pytest.approx(alone, abs=0.1)
