"""Fits and summaries of blocks of time, against NumPy's own least squares and row by row."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.estimation.summary import BLOCKS, FOLDS, block_summary, solve_gram
from symgen.estimation.system import Equations


@pytest.mark.parametrize("apart", [1.0, 1e-2, 1e-4, 3e-5])
def test_columns_that_are_nearly_alike_are_told_apart(apart: float) -> None:
    rng = np.random.default_rng(1)
    W = rng.normal(size=(400, 6)) * np.array([1.0, 1e-3, 50.0, 1.0, 7.0, 1e4])
    W[:, 3] = W[:, 0] + apart * W[:, 3]
    y = rng.normal(size=400)
    size = np.linalg.norm(W, axis=0)
    expected = np.linalg.lstsq(W / size, y, rcond=None)[0]
    A = np.column_stack([W, y])
    error = size * solve_gram(A.T @ A) - expected
    # products have the square of the condition number
    assert np.abs(error).max() < 1e-14 / apart**2 * np.abs(expected).max()


def test_what_the_rows_do_not_determine_is_the_shortest_in_units_of_the_columns() -> None:
    rng = np.random.default_rng(2)
    W = rng.normal(size=(300, 5))
    W[:, 2] = 3 * W[:, 1]
    W[:, 4] = 0
    y = rng.normal(size=300)
    scale = np.linalg.norm(W, axis=0)
    scale[4] = 1
    expected = np.linalg.lstsq(W / scale, y, rcond=1e-10)[0] / scale
    A = np.column_stack([W, y])
    np.testing.assert_allclose(solve_gram(A.T @ A), expected, rtol=1e-9, atol=1e-13)
    np.testing.assert_array_equal(solve_gram(np.zeros((3, 3))), np.zeros(2))


@pytest.mark.parametrize("reach", [0.0, 0.3])
def test_a_row_counts_in_the_block_of_its_end_if_its_fold_holds_all_of_it(reach: float) -> None:
    rng = np.random.default_rng(3)
    logs = []
    for count in (90, 1, 40):
        t = np.sort(rng.uniform(0, count / 10, count))
        own = [
            Equations("log", rng.normal(size=(count, 2)), rng.normal(size=count), t, 1, j)
            for j in range(2)
        ]
        logs.append(tuple(own))
    found = block_summary(logs, reach)
    grams, count = np.zeros_like(found.grams), np.zeros_like(found.rows)
    spans = [(min(e.t[0] for e in log), max(e.t[-1] for e in log)) for log in logs]
    total, before = sum(end - start for start, end in spans), 0.0
    for log, (start, stop) in zip(logs, spans, strict=True):
        for e in log:
            for w, y, t in zip(e.W, e.y, e.t, strict=True):
                end = (before + t - start) / total
                first, last = (
                    min(max(int(x * BLOCKS), 0), BLOCKS - 1) for x in (end - reach / total, end)
                )
                if first * FOLDS // BLOCKS == last * FOLDS // BLOCKS:
                    row = np.append(w, y)
                    grams[last, e.joint] += np.outer(row, row)
                    count[last, e.joint] += 1
        before += stop - start
    np.testing.assert_array_equal(found.rows, count)
    np.testing.assert_allclose(found.grams, grams, rtol=1e-12, atol=1e-12)
    assert (count.sum() < 262) == (reach > 0)
