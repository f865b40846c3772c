"""Faults of recorders, sample by sample: on signals whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.data.log import make_log
from symgen.faults.logs import open_samples
from symgen.faults.samples import (
    cut_off,
    held_for,
    jumps,
    repaired,
    stuck_rows,
    unmended_faults,
)
from symgen.names import REVOLUTE

STEP = 1e-3
T = np.arange(8000) * STEP
ARM = '[robot]\nname = "arm"\n[[joint]]\nfriction = ["coulomb", "viscous"]\n'


def _motion(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, qd and a torque with steps of friction and noise, (N, 1) each."""
    draw = np.random.default_rng(seed)
    f, phase = draw.uniform(0.2, 1.5, 4), draw.uniform(0, 6, 4)
    q = sum(0.3 * np.sin(2 * np.pi * a * T + b) for a, b in zip(f, phase, strict=True))
    qd = np.gradient(q, STEP)
    tau = 0.8 * np.gradient(qd, STEP) + 2 * np.sign(qd) + 0.5 * qd + draw.normal(0, 0.1, len(T))
    return q[:, None], qd[:, None], tau[:, None]


def _log(q, qd, tau, t=T):
    return make_log("log", t, q, tau, qd)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("share", [0.001, 0.02])
def test_jumps_are_found_also_where_they_are_many_and_a_clean_signal_has_none(seed, share) -> None:
    draw = np.random.default_rng(100 + seed)
    for x in _motion(seed):
        x = x[:, 0]
        assert len(jumps(x)) == 0
        at = np.flatnonzero(draw.random(len(x)) < share)
        at = at[(at > 10) & (at < len(x) - 10)]
        spoiled = x.copy()
        size = draw.uniform(1, 10, len(at)) * draw.choice([-1, 1], len(at))
        spoiled[at] += size * x.std()
        found = jumps(spoiled)
        assert len(np.intersect1d(found, at)) >= 0.9 * len(at)
        # A sample beside a jump may go with it: what counts is what is left on the line between.
        good = np.setdiff1d(np.arange(len(x)), found)
        left = np.interp(np.arange(len(x)), good, spoiled[good]) - x
        assert np.abs(left[np.setdiff1d(found, at)]).max(initial=0.0) < x.std()
        assert np.sqrt(np.mean(left**2)) < 0.35 * np.sqrt(np.mean((spoiled - x) ** 2))


@pytest.mark.parametrize("seed", range(5))
def test_the_end_of_braking_is_no_jump(seed: int) -> None:
    draw = np.random.default_rng(seed)
    ramps = [np.linspace(0, draw.uniform(-9, 9), draw.integers(5, 60)) for _ in range(30)]
    rests = [np.zeros(draw.integers(40, 200)) for _ in range(30)]
    tau = np.concatenate([x for pair in zip(rests, ramps, strict=True) for x in pair])
    tau += draw.normal(0, 0.01, len(tau))
    assert jumps(tau).tolist() == []
    middle = len(rests[0]) + len(ramps[0]) + len(rests[1]) // 2
    spoiled = tau.copy()
    spoiled[middle] += 6.0
    assert jumps(spoiled).tolist() == [middle]


@pytest.mark.parametrize("k", [2, 5, 20])
def test_a_channel_that_is_held_is_drawn_through_its_readings(k: int) -> None:
    q, qd, tau = _motion(1)
    held = q[(np.arange(len(T)) // k) * k]
    assert held_for(held[:, 0]) == k
    assert held_for(q[:, 0]) == 1
    log, repairs = repaired(_log(held, qd, tau), (REVOLUTE,))
    assert [(r.channel, r.fault) for r in repairs] == [("q1", f"new values only every {k} samples")]
    inner = slice(2 * k, -2 * k)
    assert np.abs(log.q - q)[inner].max() < 0.01 * np.abs(held - q)[inner].max()


def test_a_coarse_channel_is_not_held_and_is_told() -> None:
    q, qd, tau = _motion(2)
    coarse = np.round(q / 0.05) * 0.05
    assert held_for(coarse[:, 0]) == 1
    assert not cut_off(coarse[:, 0]).any()
    _, repairs = repaired(_log(coarse, qd, tau), (REVOLUTE,))
    assert [(r.channel, r.done) for r in repairs] == [("q1", "left as it is")]
    assert "steps of 0.05" in repairs[0].fault
    fine = np.round(q / 1e-4) * 1e-4  # an encoder of 16 bits
    assert repaired(_log(fine, qd, tau), (REVOLUTE,))[1] == ()


def test_a_torque_that_never_changes_is_not_cut_off() -> None:
    assert not cut_off(np.full(len(T), 3.0)).any()


@pytest.mark.parametrize("seed", [1, 2])
def test_stamps_that_jitter_are_made_even_also_where_rows_are_lost(seed: int) -> None:
    """The clock goes on over each lost row, of which one in a hundred is."""
    draw = np.random.default_rng(seed)
    kept = np.sort(np.append(draw.choice(np.arange(1, len(T) - 1), len(T) - 80, False), [0]))
    stamps = T + draw.uniform(-0.2, 0.2, len(T)) * STEP
    q, qd, tau = (x[kept] for x in _motion(seed))
    log, repairs = repaired(_log(q, qd, tau, stamps[kept]), (REVOLUTE,))
    assert [r.kind for r in repairs] == ["jitter"]
    assert np.abs(log.t - T[kept]).max() < 0.05 * STEP


def test_a_recorder_that_is_stuck_is_masked_and_a_robot_at_rest_is_not() -> None:
    q, qd, tau = _motion(4)
    span = slice(3000, 4200)
    stuck = [x.copy() for x in (q, qd, tau)]
    for x in stuck:
        x[span] = x[span.start]
    assert np.flatnonzero(stuck_rows(_log(*stuck)))[[0, -1]].tolist() == [3000, 4199]
    samples, repairs = open_samples(_log(*stuck), symgen.parse_robot(ARM))
    assert [(r.channel, r.fault, r.samples) for r in repairs] == [("all", "stuck", 1200)]
    assert samples.mask is not None
    assert samples.mask.joint[span].all()
    # The position is drawn over the gap: no step is left that a derivative would blow up.
    assert np.abs(np.diff(samples.q, axis=0)).max() < 2 * np.abs(np.diff(q, axis=0)).max()
    rest = [np.concatenate([x[:4000], np.repeat(x[3999:4000], 4000, axis=0)]) for x in (q, qd, tau)]
    assert not stuck_rows(_log(*rest)).any()


@pytest.mark.parametrize("seed", [0, 2])
def test_a_speed_that_is_stuck_with_its_position_goes_on(seed: int) -> None:
    q, qd, tau = _motion(seed)
    span = slice(3000, 3120)
    wrong = q.copy(), qd.copy()
    for x in wrong:
        x[span] = x[span.start]
    samples, repairs = open_samples(_log(*wrong, tau), symgen.parse_robot(ARM))
    assert [(r.channel, r.done) for r in repairs] == [
        ("q1", "masked, for all joints"),
        ("qd1", "replaced by dq/dt"),
    ]
    # As smooth as the motion: neither zero nor the peaks of a position that jumps.
    assert np.abs(samples.qd - qd)[span].max() < 0.1 * np.abs(qd).max()


def test_a_torque_that_is_stuck_for_most_of_the_log_is_named_and_not_masked() -> None:
    q, qd, tau = _motion(4)
    tau[1000:6000] = tau[1000]
    samples, repairs = open_samples(_log(q, qd, tau), symgen.parse_robot(ARM))
    assert "stuck" not in [r.kind for r in repairs]
    named = [(f.channel, f.kind) for f in unmended_faults(samples, (REVOLUTE,))]
    assert ("tau1", "stuck") in named
