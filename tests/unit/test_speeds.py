"""Measured speeds beside dq/dt: late, scaled, off, joint by joint, in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.data.log import make_log
from symgen.data.signals import prepare
from symgen.faults.samples import mended_speeds

STEP, BAND = 1e-3, 5.0
T = STEP * np.arange(8000)
W = 2 * np.pi * np.array([0.5, 0.9, 1.3])
PHASE = np.array([0.3, 1.1, 2.0])


def _speed(t: np.ndarray) -> np.ndarray:
    """(N, 3) of joints that swing."""
    return W * np.cos(np.outer(t, W) + PHASE)


def _mended(qd: np.ndarray):
    q = np.sin(np.outer(T, W) + PHASE)
    return mended_speeds(prepare(make_log("arm", T, q, 0 * q, qd)), BAND)


def _values(repair) -> dict[str, float]:
    return {name: value for name, value, _ in repair.values}


def test_sound_speeds_are_left_alone() -> None:
    noise = 1e-3 * np.random.default_rng(1).normal(size=(len(T), 3))
    assert _mended(_speed(T) + noise)[1] == ()


@pytest.mark.parametrize("late", [0.002, 0.004])
def test_speeds_that_are_all_late_are_late_by_one_cause(late: float) -> None:
    samples, (repair,) = _mended(_speed(T - late))
    assert (repair.channel, repair.done) == ("qd", "shifted")
    assert _values(repair) == {"LV": pytest.approx(late, rel=1e-3)}
    inside = slice(100, -100)
    left = 1e-3 * late * np.max(W**2)  # what a thousandth of the delay makes of them
    np.testing.assert_allclose(samples.qd[inside], _speed(T)[inside], atol=left)


def test_each_fault_of_a_joint_is_told_by_itself() -> None:
    qd = _speed(T)
    qd[:, 0] = _speed(T - 0.003)[:, 0]
    qd[:, 1] *= 1.25
    qd[:, 2] += 0.4
    samples, repairs = _mended(qd)
    assert [r.channel for r in repairs] == ["qd1", "qd2", "qd3"]
    assert [r.done for r in repairs] == ["shifted", "rescaled", "moved to zero"]
    late, scaled, off = map(_values, repairs)
    assert late == {"LV": pytest.approx(0.003, rel=1e-3)}
    assert scaled == {"GV": pytest.approx(0.25, rel=1e-3)}
    assert off == {"OV": pytest.approx(0.4, rel=1e-3)}
    inside = slice(100, -100)
    np.testing.assert_allclose(samples.qd[inside], _speed(T)[inside], atol=1e-3)


def test_speeds_that_are_late_and_off_are_not_one_cause_of_all() -> None:
    qd = _speed(T - 0.003)
    qd[:, 1] += 0.05  # less than what the delay makes of it
    _, repairs = _mended(qd)
    assert [r.channel for r in repairs] == ["qd1", "qd2", "qd3"]
    assert set(_values(repairs[1])) == {"LV", "OV"}


def test_a_gain_and_an_offset_together_are_both_told() -> None:
    qd = _speed(T)
    qd[:, 1] = 1.25 * qd[:, 1] + 0.4
    _, (repair,) = _mended(qd)
    assert _values(repair) == {
        "GV": pytest.approx(0.25, rel=1e-2),
        "OV": pytest.approx(0.4, rel=1e-2),
    }


def test_a_speed_that_is_another_one_is_replaced() -> None:
    qd = _speed(T) + 1e-2 * np.random.default_rng(2).normal(size=(len(T), 3))
    qd[:, 1] = qd[:, 2]
    samples, (repair,) = _mended(qd)
    assert (repair.channel, repair.kind) == ("qd2", "unrelated")
    inside = slice(100, -100)
    np.testing.assert_allclose(samples.qd[inside, 1], _speed(T)[inside, 1], atol=1e-2)


@pytest.mark.parametrize(("hz", "seen"), [(15.0, True), (40.0, False)])
def test_speeds_are_judged_below_five_comparison_bands(hz: float, seen: bool) -> None:
    ripple = 2.0 * W * np.sin(2 * np.pi * hz * T)[:, None]
    samples, repairs = _mended(_speed(T) + ripple)
    assert [r.kind for r in repairs] == (["unrelated"] * 3 if seen else [])
    inside = slice(100, -100)
    left = samples.qd - _speed(T) - (0 if seen else 1) * ripple
    np.testing.assert_allclose(left[inside], 0, atol=1e-3)
