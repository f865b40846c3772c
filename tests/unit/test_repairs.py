"""Faults of recorders, sample by sample: on signals whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt, welch
from stored_logs import Channels, made, stored

import symgen
from symgen.faults.repair import open_samples

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


def _opened(q, qd, tau, t=T):
    log = symgen.make_log("log", t, q, tau, qd)
    return open_samples(log, symgen.parse_robot(ARM))


def _told(repairs) -> list[tuple[str, str]]:
    return [(r.channel, r.kind) for r in repairs]


@pytest.mark.parametrize("seed", range(6))
def test_outliers_are_replaced_and_a_clean_signal_has_none(seed: int) -> None:
    draw = np.random.default_rng(100 + seed)
    clean = _motion(seed)
    samples, repairs = _opened(*clean)
    assert repairs == ()
    for key, x in zip(("q", "qd", "tau"), clean, strict=True):
        at = np.flatnonzero(draw.random(len(x)) < 0.01)
        at = at[(at > 10) & (at < len(x) - 10) & (np.diff(at, prepend=0) > 1)]
        size = draw.uniform(1, 10, len(at)) * draw.choice([-1, 1], len(at))
        spoiled = x.copy()
        spoiled[at, 0] += size * x.std()
        channels = dict(zip(("q", "qd", "tau"), clean, strict=True)) | {key: spoiled}
        samples, repairs = _opened(**channels)
        assert _told(repairs)[:1] == [(f"{key}1", "jumps")]
        left = getattr(samples, key) - x
        assert np.sqrt(np.mean(left**2)) < 0.35 * np.sqrt(np.mean((spoiled - x) ** 2))


def test_a_torque_that_the_motion_follows_is_no_outlier() -> None:
    q, qd, tau = _motion(3)
    at = np.arange(300, 7800, 300)
    pulses = np.zeros((len(T), 1))
    pulses[at, 0] = 60.0 * np.where(np.arange(len(at)) % 2, 1, -1)
    samples, repairs = _opened(q, qd, tau + pulses)
    assert _told(repairs) == [("tau1", "jumps")]
    speed = np.cumsum(pulses, axis=0) * STEP / 0.8
    place = np.cumsum(speed, axis=0) * STEP
    samples, repairs = _opened(np.round(q + place, 5), qd + speed, tau + pulses)
    assert repairs == ()
    assert np.array_equal(samples.tau, tau + pulses)


@pytest.mark.parametrize("seed", range(3))
def test_the_end_of_braking_is_no_outlier(seed: int) -> None:
    draw = np.random.default_rng(seed)
    ramps = [np.linspace(0, draw.uniform(-9, 9), draw.integers(5, 60)) for _ in range(60)]
    rests = [np.zeros(draw.integers(40, 200)) for _ in range(60)]
    tau = np.concatenate([x for pair in zip(rests, ramps, strict=True) for x in pair])[: len(T)]
    tau += draw.normal(0, 0.01, len(tau))
    q, qd, _ = _motion(seed)
    _, repairs = _opened(q[: len(tau)], qd[: len(tau)], tau[:, None], T[: len(tau)])
    assert "jumps" not in [r.kind for r in repairs]


@pytest.mark.parametrize("k", [2, 5, 20])
def test_a_channel_that_is_held_is_interpolated(k: int) -> None:
    q, qd, tau = _motion(1)
    held = q[(np.arange(len(T)) // k) * k]
    samples, repairs = _opened(held, qd, tau)
    assert [(r.channel, r.why) for r in repairs] == [("q1", f"new values only every {k} samples")]
    inner = slice(2 * k, -2 * k)
    assert np.abs(samples.q - q)[inner].max() < 0.1 * np.abs(held - q)[inner].max()


def test_a_coarse_channel_is_neither_held_nor_clipped() -> None:
    q, qd, tau = _motion(2)
    for digit in (0.05, 1e-4):  # 1e-4 rad is an encoder of 16 bits
        assert _opened(np.round(q / digit) * digit, qd, tau)[1] == ()


def test_a_joint_whose_last_digit_flickers_is_not_accused() -> None:
    arm = symgen.parse_robot(ARM + '[[joint]]\nd = 0.4\nfriction = ["coulomb"]\n')
    draw = np.random.default_rng(7)
    q, qd, tau = _motion(5)
    flicker = (draw.random(len(T)).cumsum() // 50 % 3)[:, None]  # runs of many lengths
    still = np.hstack([q, 0.7 + 1e-4 * flicker])
    speed = np.hstack([qd, 0.01 * (flicker - 1)])
    torque = np.hstack([tau, 5.0 + 0.1 * flicker])
    log = symgen.make_log("log", T, still, torque, speed)
    assert open_samples(log, arm)[1] == ()


@pytest.mark.parametrize("seed", [1, 2])
def test_stamps_that_jitter_are_made_even_also_where_rows_are_lost(seed: int) -> None:
    """The clock goes on over each lost row, of which one in a hundred is."""
    draw = np.random.default_rng(seed)
    kept = np.sort(np.append(draw.choice(np.arange(1, len(T) - 1), len(T) - 80, False), [0]))
    stamps = T + draw.uniform(-0.2, 0.2, len(T)) * STEP
    q, qd, tau = _motion(seed)
    samples, repairs = _opened(*(x[kept] for x in (q, qd, tau)), stamps[kept])
    assert _told(repairs) == [("t", "jitter")]
    there = np.round((samples.t - T[0]) / STEP).astype(int)
    assert np.abs(samples.q - q[there]).max() < 0.1 * np.abs(np.diff(q, axis=0)).max()


def test_a_stall_is_masked_and_a_robot_at_rest_is_not() -> None:
    q, qd, tau = _motion(4)
    span = slice(3000, 4200)
    stalled = [x.copy() for x in (q, qd, tau)]
    for x in stalled:
        x[span] = x[span.start]
    samples, repairs = _opened(*stalled)
    assert [(r.channel, r.kind, r.samples) for r in repairs] == [("all", "stalled", 1199)]
    assert samples.mask is not None
    assert samples.mask.joint[3001:4200].all()
    # The position is drawn over the gap: no step is left that a derivative would blow up.
    assert np.abs(np.diff(samples.q, axis=0)).max() < 2 * np.abs(np.diff(q, axis=0)).max()
    rest = [np.concatenate([x[:4000], np.repeat(x[3999:4000], 4000, axis=0)]) for x in (q, qd, tau)]
    assert "stalled" not in [r.kind for r in _opened(*rest)[1]]


def test_stalls_of_20_ms_are_interpolated_as_other_gaps_in_time() -> None:
    q, qd, tau = _motion(4)
    rows = round(0.02 / STEP)
    index = np.arange(len(T))
    for start in (2000, 4000, 6000):
        index[start : start + rows] = start
    samples, repairs = _opened(q[index], qd[index], tau[index])
    assert _told(repairs) == [("all", "stalled")]
    assert samples.mask is None
    assert np.abs(samples.q - q).max() < 0.01 * np.abs(q[index] - q).max()


def test_single_held_rows_of_one_joint_are_interpolated() -> None:
    q, _, tau = _motion(6)
    at = np.flatnonzero(np.random.default_rng(6).random(len(T)) < 0.23)
    at = at[(at > 1) & (at < len(T) - 2)]
    held = [x.copy() for x in (q, tau)]
    for k in at:
        for x in held:
            x[k] = x[k - 1]
    samples, repairs = _opened(held[0], None, held[1])
    assert [r.channel for r in repairs] == ["all"]
    assert 0.9 * len(at) < repairs[0].samples <= len(at)
    assert np.abs(samples.q - q)[10:-10].max() < 0.01 * np.abs(held[0] - q).max()


def test_a_speed_that_is_stuck_with_its_position_goes_on() -> None:
    q, qd, tau = _motion(0)
    span = slice(3000, 3120)
    wrong = q.copy(), qd.copy()
    for x in wrong:
        x[span] = x[span.start]
    samples, repairs = _opened(*wrong, tau)
    assert [(r.channel, r.done) for r in repairs] == [
        ("q1", "masked, for all joints"),
        ("qd1", "replaced by dq/dt"),
    ]
    # As smooth as the motion: neither zero nor the peaks of a position that jumps.
    assert np.abs(samples.qd - qd)[span].max() < 0.1 * np.abs(qd).max()


@pytest.mark.parametrize("bits", [8, 15, 16, 32])
def test_negative_torques_of_unsigned_counts_are_subtracted(bits: int) -> None:
    q, qd, tau = _motion(8)
    tau -= tau[0]  # it begins at zero
    digit = np.ptp(tau) / (100 if bits == 8 else 3000)
    counts = np.round(tau / digit)
    samples, repairs = _opened(q, qd, digit * np.mod(counts, 2.0**bits))
    assert ("tau1", "unsigned") in _told(repairs)
    assert repairs[0].samples == np.sum(counts < 0)
    np.testing.assert_allclose(samples.tau, digit * counts, atol=1e-3 * digit)
    assert "unsigned" not in [r.kind for r in _opened(q, qd, tau - tau.min())[1]]


# By the commands: the arm of three joints without a fault.


def _stalls(x: Channels, seed: int) -> Channels:
    """The recorder holds every channel for 100 to 130 ms, six times."""
    draw = np.random.default_rng(seed)
    index = np.arange(len(x["t"]))
    for k in draw.choice(np.arange(2, len(index) // 100 - 2), 6, replace=False):
        index[100 * k : 100 * k + draw.integers(10, 14)] = 100 * k
    return {key: values if key == "t" else values[index] for key, values in x.items()}


def test_stalls_of_the_recorder_change_no_diagnosis() -> None:
    log = stored("sound")
    sound = {"validation": made("b", log.test), "effects": []}
    clean = symgen.diagnose(log.robot, made("a", log.train), **sound)
    train, test = made("a", _stalls(log.train, 1)), made("b", _stalls(log.test, 2))
    found = symgen.diagnose(log.robot, train, validation=test)
    assert _told(found.repairs) == [("all", "stalled")] * 2
    assert (found.verdict, found.effects) == ("consistent", ())
    assert found.before.total < 1.3 * clean.before.total


def test_the_noise_floor_is_the_noise_of_the_torque_whatever_the_model_lacks() -> None:
    """Welch's density of the measured torque in its highest octave, over the comparison band."""
    log = stored("ripple")  # 6 % of the torque of joint 2 are no part of the model
    found = symgen.identify(log.robot, made("a", log.train), validation=made("b", log.test))
    tau = log.test["tau"][:, 1]
    frequency, power = welch(tau, 1 / log.test["t"][1], nperseg=256)
    density = np.median(power[frequency > frequency[-1] / 2])
    white = np.sqrt(density * found.band.comparison_hz / np.mean(tau**2))
    assert 0.5 * white < found.noise_floor.per_joint[1] < 1.1 * white


def test_a_noise_floor_above_the_error_is_an_upper_bound() -> None:
    """The torque has noise above 20 Hz alone, so none is in the comparison band of 2 Hz."""
    log = stored("sound")

    def recorded(name: str, x: Channels) -> symgen.Log:
        noise = np.random.default_rng(1).normal(0, 0.2 * x["tau"].std(axis=0), x["tau"].shape)
        sections = butter(4, 20.0, "high", fs=1 / (x["t"][1] - x["t"][0]), output="sos")
        return made(name, x | {"tau": x["tau"] + sosfiltfilt(sections, noise, axis=0)})

    train, test = recorded("a", log.train), recorded("b", log.test)
    found = symgen.identify(log.robot, train, validation=test)
    assert found.noise_floor.relative > 2 * found.moving.relative
    assert "; noise accounts for at most " in found.sentences[0]
    diagnosis = symgen.diagnose(log.robot, train, validation=test, effects=[])
    floors = diagnosis.gaps.noise_floor.per_joint
    assert floors == pytest.approx(found.noise_floor.per_joint, rel=0.05)


@pytest.mark.parametrize("cutoff", [None, 5.0, 20.0])
def test_no_noise_floor_is_stated_for_torques_that_were_filtered(cutoff: float | None) -> None:
    log = stored("sound")

    def recorded(name: str, x: Channels) -> symgen.Log:
        tau = x["tau"] + np.random.default_rng(1).normal(0, 0.02 * x["tau"].std(axis=0))
        if cutoff is not None:
            sections = butter(2, cutoff, fs=1 / (x["t"][1] - x["t"][0]), output="sos")
            tau = sosfiltfilt(sections, tau, axis=0)
        return made(name, x | {"tau": tau})

    found = symgen.identify(log.robot, recorded("a", log.train), validation=recorded("b", log.test))
    assert found.noise_floor is not None
    assert np.isnan(found.noise_floor.relative) == (cutoff is not None)
    assert not any("computed" in note for note in found.to_json()["notes"])
