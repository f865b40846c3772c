"""Trajectories: against sums written by hand."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.experiment.bounds import Bounds, Space, space
from symgen.experiment.trajectory import Trajectory, fourier_series

T = 3.7
t = np.linspace(0, T, 301)


def test_a_fourier_series_is_the_sum_that_it_claims_to_be() -> None:
    c = np.random.default_rng(0).normal(size=9)
    w = 2 * np.pi / T
    q, qd, qdd, qddd = np.full(len(t), c[0]), 0 * t, 0 * t, 0 * t
    for k in range(1, 5):
        a, b, v = c[2 * k - 1], c[2 * k], k * w
        q += a * np.cos(v * t) + b * np.sin(v * t)
        qd += v * (b * np.cos(v * t) - a * np.sin(v * t))
        qdd += v**2 * (-a * np.cos(v * t) - b * np.sin(v * t))
        qddd += v**3 * (a * np.sin(v * t) - b * np.cos(v * t))
    for order, expected in enumerate((q, qd, qdd, qddd)):
        np.testing.assert_allclose(
            fourier_series(T, 4).matrix(t, order) @ c, expected, rtol=1e-9, atol=1e-9
        )


@pytest.mark.parametrize("order", [0, 1, 2])
def test_derivatives_are_those_of_the_functions(order: int) -> None:
    own, e = fourier_series(T), 1e-5
    at = np.linspace(0.0137, T - 0.0141, 97)
    slope = (own.matrix(at + e, order) - own.matrix(at - e, order)) / (2 * e)
    np.testing.assert_allclose(own.matrix(at, order + 1), slope, atol=1e-7 * np.abs(slope).max())


def _limits(n: int) -> Bounds:
    rates = np.array([[2.0, 3.0], [9.0, 12.0], [80.0, 90.0]])[:, :n]
    return Bounds(
        np.array([-1.0, 0.5])[:n], np.array([2.0, 1.5])[:n], rates, np.full(n, np.inf), (1, 2)[:n]
    )


def random_motion(choices: Space, seed: int) -> Trajectory:
    sampled = choices.sampled(choices.series.times(T / 4000))
    z = choices.fitted(choices.draw(np.random.default_rng(seed)), sampled, True)
    return choices.trajectory(z, sampled)


@pytest.mark.parametrize("start", [None, [1.7, 0.6]])
def test_every_drawn_motion_keeps_its_limits_and_rests_at_both_ends(start) -> None:
    limits = _limits(2)
    begin = None if start is None else np.array(start)
    choices = space(fourier_series(T), limits, begin)
    dense = np.linspace(0, T, 20_011)
    for seed in (5, 6):
        run = random_motion(choices, seed)
        q = run.at(dense)
        assert (q >= limits.low).all()
        assert (q <= limits.high).all()
        for order in (1, 2, 3):
            peaks = np.abs(run.at(dense, order)).max(axis=0)
            assert (peaks <= limits.rates[order - 1]).all()
        ends = np.array([0.0, T])
        assert np.abs(run.at(ends, 1)).max() < 1e-12
        assert np.abs(run.at(ends, 2)).max() < 1e-10
        if start is not None:
            np.testing.assert_allclose(run.at(np.zeros(1))[0], start, atol=1e-12)


def test_a_drawn_motion_reaches_at_least_one_limit_of_every_joint() -> None:
    limits = _limits(2)
    choices = space(fourier_series(T), limits)
    run = random_motion(choices, 6)
    dense = np.linspace(0, T, 5000)
    middle, half = (limits.low + limits.high) / 2, (limits.high - limits.low) / 2
    shares = [np.abs(run.at(dense) - middle).max(axis=0) / half]
    shares += [np.abs(run.at(dense, k)).max(axis=0) / limits.rates[k - 1] for k in (1, 2, 3)]
    assert (np.max(shares, axis=0) > 0.99).all()


def test_too_few_terms_are_refused() -> None:
    with pytest.raises(symgen.ParameterError, match="3 or more"):
        fourier_series(T, 2)
