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
    found = np.full((len(d.kept), 2), np.nan)
    for part, values in d.chunks(lambda first, last: nodes[first:last]):
        found[part] = values
    expected = lowpass(x, STEP, CUTOFF)[d.kept]
    inner = (d.kept > 5 / CUTOFF / STEP) & (d.kept < samples - 5 / CUTOFF / STEP)
    assert np.abs(found - expected)[inner].max(initial=0) < 1e-6
    # At the ends both continue the signal, the one from its nodes, the other from its samples.
    assert np.abs(found - expected).max() < (0.05 if samples > 100 else 0.2)


@pytest.mark.parametrize("stride", [1, 7])
def test_a_constant_passes_as_it_is(stride: int) -> None:
    d = decimation(3000, STEP, stride, CUTOFF)
    for _, values in d.chunks(lambda first, last: np.full((last - first, 3), 1.7)):
        assert np.abs(values - 1.7).max() < 1e-12


def test_the_kept_rows_do_not_depend_on_the_nodes_and_are_those_of_an_engineer() -> None:
    kept = [decimation(2501, STEP, stride, CUTOFF).kept for stride in (1, 3, 7)]
    for other in kept:
        np.testing.assert_array_equal(other, np.arange(2501)[75:-75:30])


def test_without_a_low_pass_every_sample_is_kept() -> None:
    d = decimation(100, STEP, 1, 120.0)
    x = np.random.default_rng(0).normal(size=(100, 2))
    found = np.concatenate([values for _, values in d.chunks(lambda a, b: x[a:b])])
    np.testing.assert_array_equal(found, x)
