"""The low-pass that decimates: that of the whole signal, at the rows an engineer keeps."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.data.signals import lowpass
from symgen.estimation.decimation import decimation

CUTOFF, STEP = 2.05, 1 / 250


def _motion(t: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(2 * np.pi * 0.8 * t), 1 + 0.3 * t + np.cos(2 * np.pi * 1.7 * t)], 1)


@pytest.mark.parametrize("stride", [1, 2, 3, 5, 7])
@pytest.mark.parametrize("samples", [60, 400, 2501, 40_003])
def test_it_is_the_low_pass_at_the_kept_samples(stride: int, samples: int) -> None:
    x = _motion(np.arange(samples) * STEP)
    d = decimation(samples, STEP, stride, CUTOFF)
    nodes = x[::stride]
    found = d.filtered(lambda first, last: nodes[first:last])
    expected = lowpass(x, STEP, CUTOFF)[d.kept]
    inner = (d.kept > 5 / CUTOFF / STEP) & (d.kept < samples - 5 / CUTOFF / STEP)
    assert np.abs(found - expected)[inner].max(initial=0) < 1e-6
    # At the ends both continue the signal, the one from its nodes, the other from its samples.
    assert np.abs(found - expected).max() < (0.05 if samples > 100 else 0.2)


def test_the_kept_rows_do_not_depend_on_the_nodes_and_are_those_of_an_engineer() -> None:
    kept = [decimation(2501, STEP, stride, CUTOFF).kept for stride in (1, 3, 7)]
    for other in kept:
        np.testing.assert_array_equal(other, np.arange(2501)[75:-75:30])


@pytest.mark.parametrize("samples", [49, 56, 63, 64, 70, 350])
def test_a_log_of_hardly_more_than_the_filter_is_continued_on_both_sides(samples: int) -> None:
    """A line goes on as a line: what is kept of it is the line, up to what continues it."""
    t = np.arange(samples) * STEP
    x = np.column_stack([0.3 + 2.0 * t, np.full(samples, 1.7)])
    for stride in (1, 7):
        d = decimation(samples, STEP, stride, CUTOFF)
        found = d.filtered(lambda a, b, k=stride: x[::k][a:b])
        assert np.abs(found - x[d.kept]).max() < 0.01


def test_a_block_is_asked_for_what_is_near_it_alone() -> None:
    samples = 200_000
    d = decimation(samples, STEP, 3, CUTOFF)
    asked: list[int] = []

    def values(first: int, last: int) -> np.ndarray:
        assert 0 <= first < last <= d.nodes
        asked.append(last - first)
        return np.ones((last - first, 2, 3))

    assert d.filtered(values).shape == (len(d.kept), 2, 3)
    assert max(asked) < 1000
    assert sum(asked) == d.nodes


@pytest.mark.parametrize(
    ("samples", "cutoff", "every", "margin"),
    [
        (2501, 2.05, 30, 75),  # 250 Hz over four a period; 0.3 s
        (400, 2.05, 30, 40),  # a tenth of a short log
        (750, 2.05, 30, 75),
        (2501, 10.0, 6, 75),
        (2501, 50.0, 1, 75),  # no fewer than every sample
        (2501, 112.4, 1, 75),
        (2501, 112.6, 1, 0),  # above 0.45 of the rate nothing is filtered
    ],
)
def test_where_rows_are_kept(samples, cutoff, every, margin) -> None:
    d = decimation(samples, STEP, 1, cutoff)
    np.testing.assert_array_equal(d.kept, np.arange(samples)[margin : samples - margin : every])
    assert (d.cutoff is None) is (margin == 0)
    assert (d.stride, d.nodes) == (1, samples)


def test_without_a_low_pass_every_sample_is_kept_as_it_is() -> None:
    x = np.random.default_rng(1).normal(size=(1000, 2))
    found = decimation(1000, STEP, 1, 120.0).filtered(lambda a, b: x[a:b])
    np.testing.assert_array_equal(found, x)
