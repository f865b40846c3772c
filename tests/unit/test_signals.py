"""Integrals, derivatives and filters are exact where they claim it, and none shifts a signal."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.data.log import make_log, read_log
from symgen.data.signals import (
    Samples,
    differentiate,
    lowpass,
    prepare,
)
from symgen.errors import LogError
from symgen.estimation.integrals import window_weights
from symgen.estimation.windows import Windows, over_windows

DATA = Path(os.environ.get("SYMGEN_DATA", Path(__file__).parents[3] / "shared" / "data"))
TURN = 2 * np.pi
ENCODER = TURN / 14400

coefficient = st.floats(-2.0, 2.0)
# No deadline: the first example also pays for importing SciPy.
EXAMPLES = settings(max_examples=30, deadline=None)


def encoder(q: np.ndarray) -> np.ndarray:
    return np.round(q / ENCODER) * ENCODER


def sines(t: np.ndarray, highest: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return a motion of five harmonics up to `highest` Hz, and its exact velocity."""
    rng = np.random.default_rng(seed)
    q, qd = np.zeros((len(t), 2)), np.zeros((len(t), 2))
    for k in range(1, 6):
        omega, phase = TURN * highest * k / 5, rng.uniform(0, TURN, size=2)
        size = rng.uniform(0.5, 1.0, size=2) / k
        q += size * np.sin(omega * t[:, None] + phase)
        qd += size * omega * np.cos(omega * t[:, None] + phase)
    return q, qd


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


# --- integral and derivative ---------------------------------------------------------------------


def integral_from_the_first(y: np.ndarray, step: float, every: int = 1) -> np.ndarray:
    """The integral from the first sample to others: windows that all begin there."""
    weights = [window_weights(len(y), np.array([k]), k) for k in range(0, len(y), every)]
    return step * np.concatenate(weights) @ y


@given(st.lists(coefficient, min_size=6, max_size=6), st.floats(1e-3, 0.1), st.integers(10, 60))
@EXAMPLES
def test_the_integral_is_exact_up_to_degree_five(c, step, count):
    t = np.arange(count) * step
    exact = sum(a / (k + 1) * t ** (k + 1) for k, a in enumerate(c))
    got = integral_from_the_first(
        np.column_stack([sum(a * t**k for k, a in enumerate(c)), t]), step
    )
    scale = 1.0 + np.abs(exact).max()
    np.testing.assert_allclose(got[:, 0], exact, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(got[:, 1], t**2 / 2, rtol=0, atol=1e-12 * (1 + t[-1] ** 2))


@given(st.lists(coefficient, min_size=6, max_size=6), st.integers(6, 60))
@EXAMPLES
def test_the_derivative_is_exact_up_to_degree_five(c, count):
    t = np.arange(count) / count
    exact = sum(k * a * t ** (k - 1) for k, a in enumerate(c) if k)
    got = differentiate(sum(a * t**k for k, a in enumerate(c)), 1 / count)
    np.testing.assert_allclose(got, exact, rtol=0, atol=1e-8)


# --- filter --------------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.floats(5.0, 400.0))
@EXAMPLES
def test_the_filter_has_zero_phase(seed, cutoff):
    x = np.zeros(2001)
    x[900:1101] = np.random.default_rng(seed).normal(size=201)
    forth, back = lowpass(x, 1e-3, cutoff), lowpass(x[::-1], 1e-3, cutoff)[::-1]
    np.testing.assert_allclose(forth, back, rtol=0, atol=1e-6)
    pulse = np.zeros(2001)
    pulse[1000] = 1.0
    assert np.argmax(lowpass(pulse, 1e-3, cutoff)) == 1000


@pytest.mark.parametrize(("ratio", "gain"), [(0.2, 1.0), (0.5, 0.99611), (1.0, 0.5), (2.0, 0.0039)])
def test_the_filter_has_the_gain_of_two_butterworth_passes_and_no_delay(ratio, gain):
    t = np.arange(8000) * 1e-3
    x = np.sin(TURN * 10 * ratio * t)
    got = lowpass(x, 1e-3, 10.0)[3000:5000]
    along = got @ x[3000:5000] / 1000
    across = got @ np.cos(TURN * 10 * ratio * t[3000:5000]) / 1000
    assert along == pytest.approx(gain, abs=2e-4)
    assert across == pytest.approx(0.0, abs=1e-6)


@given(st.lists(coefficient, min_size=4, max_size=4))
@EXAMPLES
def test_the_filter_keeps_cubics_up_to_their_ends(c):
    t = np.arange(500) * 1e-3
    x = np.column_stack([sum(a * t**k for k, a in enumerate(c)), t])
    np.testing.assert_allclose(lowpass(x, 1e-3, 20.0), x, rtol=0, atol=2e-5)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 50.0, 1e3, np.nan, np.inf])
def test_a_cutoff_outside_the_band_is_refused_with_the_nyquist_frequency(cutoff):
    t = np.arange(100) * 0.01
    with pytest.raises(LogError, match="50 Hz"):
        lowpass(t, 0.01, cutoff)


# --- bandwidth -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("log", "least", "most"), [("emps/train.csv", 20, 100), ("tx40/train.csv", 10, 50)]
)
def test_real_logs_get_a_cutoff_in_the_range_of_the_published_analyses(log, least, most):
    if not DATA.is_dir():
        pytest.skip(f"no measured logs at {DATA}: set SYMGEN_DATA")
    samples = prepare(read_log(DATA / log))
    assert samples.cutoff_hz is not None
    assert least < samples.cutoff_hz < most
    assert "low-pass filter" in samples.notes[0]


# --- prepare -------------------------------------------------------------------------------------


def assert_sound(samples: Samples) -> None:
    for array in (samples.t, samples.q, samples.qd, samples.tau):
        assert array.flags.c_contiguous
        assert not array.flags.writeable
        assert np.isfinite(array).all()
    assert samples.q.shape == samples.qd.shape == samples.tau.shape


def test_a_uniform_log_with_velocities_passes_untouched():
    t = np.arange(300) * 0.01
    q, qd = sines(t, 2.0)
    log = make_log("arm", t, q, q**2, qd)
    samples = prepare(log)
    assert_sound(samples)
    for role in ("t", "q", "qd", "tau"):
        np.testing.assert_array_equal(getattr(samples, role), getattr(log, role))
    assert samples.notes == ()
    assert samples.cutoff_hz is None
    assert samples.step == pytest.approx(0.01)


@given(st.integers(0, 10**6))
@EXAMPLES
def test_resampling_follows_a_smooth_motion(seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.choice([0.008, 0.010, 0.012], size=1000))
    q, qd = sines(t, 1.0, seed)
    samples = prepare(make_log("arm", t, q, 10 * q, qd))
    assert_sound(samples)
    assert "between 0.008 s and 0.012 s were resampled to 0.0" in samples.notes[0]
    np.testing.assert_allclose(np.diff(samples.t), samples.step, rtol=1e-9)
    assert (samples.t[0], samples.t[-1]) == (t[0], t[-1])
    q, qd = sines(samples.t, 1.0, seed)
    assert rms(samples.q - q) < 1e-6 * rms(q)
    assert rms(samples.qd - qd) < 1e-5 * rms(qd)
    assert rms(samples.tau - 10 * q) < 1e-5 * rms(q)


def test_a_gap_that_is_longer_than_the_log_is_refused_with_its_place():
    t = np.arange(300) * 0.01
    t[200:] += 20
    with pytest.raises(LogError, match=r"arm: .*t = 1\.99 s and t = 22 s.* --until 1\.99"):
        prepare(make_log("arm", t, t, t, t))


def test_a_missing_velocity_is_derived_within_a_percent_from_an_encoder():
    t = np.arange(10000) * 1e-3
    q, qd = sines(t, 2.0)
    samples = prepare(make_log("arm", t, encoder(q), q**2))
    assert_sound(samples)
    assert samples.cutoff_hz is not None
    assert 9.8 < samples.cutoff_hz < 24
    assert f"low-pass filter at {samples.cutoff_hz:.4g} Hz" in samples.notes[0]
    assert rms(samples.qd - qd) < 1e-3 * rms(qd)
    np.testing.assert_array_equal(samples.tau, q**2)
    integral = integral_from_the_first(samples.qd, samples.step, 50)
    np.testing.assert_allclose((samples.q - samples.q[0])[::50], integral, atol=1e-9)


def test_positions_near_the_nyquist_frequency_are_differentiated_without_a_filter():
    t = np.arange(1000) * 1e-2
    q, qd = sines(t, 2.0)
    steady = np.column_stack([np.full(len(t), 0.4), 0.3 * t + 0.1])
    samples = prepare(make_log("arm", t, np.column_stack([q, steady]), np.zeros((len(t), 4))))
    assert samples.cutoff_hz is None
    assert "unfiltered, as the Nyquist frequency is" in samples.notes[0]
    assert rms(samples.qd[:, :2] - qd) < 1e-4 * rms(qd)
    np.testing.assert_allclose(samples.qd[:, 2:], [[0.0, 0.3]] * len(t), rtol=0, atol=1e-10)


def test_windows_take_the_integral_of_the_whole_log() -> None:
    y = np.random.default_rng(0).normal(size=(400, 3))
    whole = integral_from_the_first(y, 0.1)
    for length, last in (
        (3, np.arange(3, 400, 7)),
        (50, np.arange(50, 400)),
        (399, np.array([399])),
    ):
        expected = whole[last] - whole[last - length]
        found = 0.1 * window_weights(len(y), last, length) @ y
        np.testing.assert_allclose(found, expected, atol=1e-12)
    chunked = over_windows(lambda at: y[at], len(y), Windows(2, 12, 3), 0.1)
    last = np.arange(24, 400, 6)
    np.testing.assert_allclose(chunked, whole[last] - whole[last - 24], atol=1e-12)


def _late(at: int, by: float, of: float = 1e-3, count: int = 2000) -> np.ndarray:
    """Stamps of a clock; one comes late by some time, those after it half a step apart."""
    t = of * np.arange(count)
    t[at] += by
    return np.maximum.accumulate(t - of / 2 * np.arange(count)) + of / 2 * np.arange(count)


def test_stamps_that_come_late_and_are_made_good_are_no_hole() -> None:
    t = _late(700, 0.0121)
    assert np.diff(t).max() > 0.013
    q = np.column_stack([np.sin(3 * t)])
    assert len(prepare(make_log("host", t, q, 0 * q)).t) > 1900
    for count, masked in ((20, False), (60, True)):
        missing = np.delete(t, slice(1200, 1200 + count))
        q = np.column_stack([np.sin(40 * missing)])
        samples = prepare(make_log("host", missing, q, 0 * q))
        assert len(samples.t) > 1900
        assert (samples.mask is not None) == masked
