"""The test of whiteness: beside statsmodels, its level, and where windows or filters correlate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from statsmodels.stats.diagnostic import acorr_ljungbox
from statsmodels.tsa.stattools import acf

from symgen.estimation.torque_error import MEMORY as _MEMORY
from symgen.estimation.values import Trace
from symgen.identification.assessment import in_words, lag_correlations, whiteness

STEP = 0.01


def judged(residual: np.ndarray, spacing: int = 1):
    """The test of one residual, as one log of energy."""
    t = STEP * np.arange(len(residual))
    zero = np.zeros((len(residual), 1))
    (found,) = whiteness([Trace("a", "train", "energy", t, residual[:, None], zero, spacing)])
    return found


def share(p_values) -> float:
    return float(np.mean(np.asarray(p_values) < 0.05))


def test_correlations_are_those_of_statsmodels() -> None:
    e = np.random.default_rng(1).normal(size=300).cumsum()
    r, _ = lag_correlations([e - e.mean()], 12)
    assert np.allclose(r, acf(e, nlags=12, fft=False)[1:], atol=1e-12)


def test_no_pair_spans_two_logs() -> None:
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=80), rng.normal(size=50)
    r, deviation = lag_correlations([a, b], 2)
    pairs = [a[i] * a[i + 2] for i in range(78)] + [b[i] * b[i + 2] for i in range(48)]
    power = np.sum(a**2) + np.sum(b**2)
    assert r[1] == pytest.approx(sum(pairs) / power)
    assert deviation[1] == pytest.approx(np.sqrt(np.sum(np.square(pairs))) / power)


def test_statistic_is_that_of_ljung_and_box_where_the_size_is_constant() -> None:
    signs = np.random.default_rng(3).choice([-1.0, 1.0], size=4000)  # e^2 is constant
    theirs = float(acorr_ljungbox(signs, lags=[20])["lb_stat"].iloc[0])
    assert judged(signs).statistic == pytest.approx(theirs, rel=0.01)


def test_level_is_kept_where_the_size_changes_and_plain_ljung_box_loses_it() -> None:
    rng = np.random.default_rng(4)
    size = 1 + 0.95 * np.sin(np.arange(400) / 15)
    constant, changing, plain = [], [], []
    for _ in range(400):
        e = rng.normal(size=400)
        constant.append(judged(e).p_value)
        changing.append(judged(size * e).p_value)
        plain.append(float(acorr_ljungbox(size * e, lags=[20])["lb_pvalue"].iloc[0]))
    print(
        f"rejected at 5 %: {share(constant):.3f}, {share(changing):.3f}, plain {share(plain):.3f}"
    )
    assert 0.02 < share(constant) < 0.08
    assert 0.02 < share(changing) < 0.08
    assert share(plain) > 0.3


def test_a_correlated_residual_is_told_with_its_size_and_lag() -> None:
    rng = np.random.default_rng(5)
    e = rng.normal(size=3000)
    for k in range(1, len(e)):
        e[k] += 0.4 * e[k - 1]
    found = judged(e)
    assert found.p_value < 1e-9
    words = in_words(found)
    assert words.startswith("not white: correlated by 0.4")
    assert words.endswith("after 0.01 s")
    assert in_words(judged(rng.normal(size=3000))).startswith("white")


@pytest.mark.parametrize("noise", ["torque", "tachometer"])
def test_sliding_windows_count_as_white_at_their_spacing_only(noise: str) -> None:
    rng, steps = np.random.default_rng(6), 20
    alone, overlapping, touching = [], [], []
    for _ in range(200):
        n = rng.normal(size=12_000)
        whole = np.cumsum(n) if noise == "torque" else n
        e = whole[steps:] - whole[:-steps]
        alone.append(judged(e, steps + 1).p_value)
        overlapping.append(judged(e).p_value)
        touching.append(judged(e, steps).p_value)
    assert share(alone) < 0.09
    assert share(overlapping) == 1.0
    # neighbours share the sample where they meet, which tachometers enter by
    assert (share(touching) > 0.9) == (noise == "tachometer")


def test_low_passed_noise_counts_as_white_at_the_spacing_of_its_filter() -> None:
    rng, band = np.random.default_rng(7), 8.0
    sections = butter(4, band, fs=1 / STEP, output="sos")
    spacing = int(np.ceil(_MEMORY / (band * STEP)))
    apart, close = [], []
    for _ in range(200):
        e = sosfiltfilt(sections, rng.normal(size=12_000))
        apart.append(judged(e, spacing).p_value)
        close.append(judged(e, spacing // 4).p_value)
    assert share(apart) < 0.09
    assert share(close) > 0.5


def test_no_pair_spans_a_pause_and_masked_logs_are_left_out() -> None:
    e = np.tile([1.0, -1.0], 60)
    t = STEP * np.arange(120)
    t[61:] += 5.0  # the signs alternate within both stretches, and again from one to the other
    trace = Trace("a", "train", "energy", t, e[:, None], np.zeros((120, 1)))
    (found,) = whiteness([trace])
    # 119 pairs, 1 of them across the pause
    assert found.correlations[0] == pytest.approx(-118 / 120)
    assert whiteness([replace(trace, spacing=0)]) == ()


def test_short_and_perfect_residuals_are_not_tested() -> None:
    t = STEP * np.arange(14)
    short = Trace("a", "train", "energy", t, np.sin(t)[:, None], np.zeros((14, 1)))
    t = STEP * np.arange(500)
    perfect = Trace("b", "train", "torque", t, np.ones((500, 1)), np.ones((500, 1)))
    assert whiteness([short, perfect]) == ()
