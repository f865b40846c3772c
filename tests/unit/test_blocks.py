"""Summaries of blocks of time, row by row."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.estimation.summary import BLOCKS, FOLDS, block_summary
from symgen.estimation.system import Equations


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
