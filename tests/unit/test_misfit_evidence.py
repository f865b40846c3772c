"""Columns compete with a misfit of any shape."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.estimation.features import mixtures
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import TEMPERATURE

ROWS, NOISE, EXPECTED = 480, 0.003, 0.004


def scene(seed: int, y: np.ndarray, F: np.ndarray) -> MisfitEvidence:
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


@pytest.mark.parametrize("seed", range(3))
def test_a_smooth_misfit_is_no_evidence_for_a_column_that_looks_like_it(seed: int) -> None:
    rng, F, noise = drawn(seed)
    missed = F @ rng.normal(size=F.shape[1])
    missed *= 0.01 / missed.std()
    other = F @ rng.normal(size=F.shape[1])
    looks = missed / missed.std() + 0.5 * other / other.std()
    own = scene(seed, missed + noise, F).of({0: looks[:, None]}, np.array([0.3]))
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
    assert scene(seed, 0.015 * step + noise, F).of({0: step[:, None]}, np.array([0.3])) > 50
