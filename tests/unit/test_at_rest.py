"""Where joints are at rest, and what equations there are worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symgen
from symgen import read_robot
from symgen.data.log import make_log
from symgen.data.mask import Mask, mean_speeds, resting, slow_speeds
from symgen.data.signals import Samples, prepare, sampled
from symgen.errors import LogError
from symgen.estimation.band import OPEN, Band, Rests
from symgen.estimation.cutoff import find_rests, weigh_rests
from symgen.estimation.filtered_log import filter_log, unfiltered
from symgen.estimation.masking import require_left, rests_in_words, seldom_moving
from symgen.estimation.system import (
    Equations,
    momentum_sides,
    torque_equations,
    torque_sides,
    window_equations,
)
from symgen.estimation.torque_error import fit
from symgen.estimation.windows import place_windows

STEP = 0.004
T = np.arange(0, 24, STEP)
ROBOT = """
[robot]
name = "pendulum"
gravity = [0.0, -9.81, 0.0]
[[joint]]
sigma = 0
rotor_inertia = false
"""
#: ZZ, MX, MY, FS, FV of the pendulum.
TRUE = np.array([0.8, 1.1, 0.3, 2.0, 0.7])


ELBOW = symgen.parse_robot(
    '[robot]\nname = "r"\n[[joint]]\n[[joint]]\nname = "elbow"\nd = 1\nalpha = 1.0\n'
)


def moved(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two seconds of motion, two of rest, again and again: position, and whether it rests."""
    phase, count = np.mod(t, 4.0), np.floor(t / 4.0)
    turned = np.minimum(phase, 2.0)
    ends = np.array([0.0, 1.3, -0.9, 0.6, -1.5, 1.1, -0.4, 0.8])
    k = count.astype(int)
    s = turned / 2
    return ends[k] + (ends[k + 1] - ends[k]) * s**3 * (10 - 15 * s + 6 * s**2), phase >= 2.0


def log(stiction: float, noise: float = 0.0, coulomb: float = TRUE[3]) -> Samples:
    q, rest = moved(T)
    qd = np.gradient(q, STEP)
    qdd = np.gradient(qd, STEP)
    ZZ, MX, MY, _, FV = TRUE
    gravity = 9.81 * (MX * np.cos(q) - MY * np.sin(q))
    held = stiction * coulomb * np.sin(0.9 * np.floor(T / 4.0) + 1.0)
    tau = ZZ * qdd + gravity + np.where(rest, held, coulomb * np.sign(qd) + FV * qd)
    tau = tau + noise * np.random.default_rng(3).normal(size=len(T))
    return sampled(
        symgen.make_log("log", T, q[:, None], tau[:, None], np.where(rest, 0, qd)[:, None])
    )


@pytest.fixture(scope="module")
def evaluator():
    kernels = ("torque_regressor", "momentum_regressor", "friction_torque", "inverse_dynamics")
    return symgen.load(symgen.derive(symgen.parse_robot(ROBOT, "pendulum"), kernels))


def test_speeds_are_those_of_the_mean_of_a_tenth_of_a_second():
    q = np.column_stack([3.0 * T, np.where(T < 10, 0.0, 1.0)])
    found = mean_speeds(q, STEP)
    np.testing.assert_allclose(found[:, 0], 3.0)
    jump = np.flatnonzero(found[:, 1])
    assert len(jump) * STEP == pytest.approx(0.1, abs=2 * STEP)
    assert found[jump, 1].max() == pytest.approx(1.0 / 0.1, rel=0.05)


def test_noise_of_an_encoder_hides_no_rest_and_a_reversal_is_none():
    q, rest = moved(T)
    noisy = q + 1e-4 * np.random.default_rng(0).normal(size=len(q))
    found = resting(noisy[:, None], STEP, np.array([0.03]))[:, 0]
    inside = rest & (np.mod(T, 4.0) > 2.1) & (np.mod(T, 4.0) < 3.9)
    assert found[inside].all()
    assert not found[(np.mod(T, 4.0) > 0.4) & (np.mod(T, 4.0) < 1.6)].any()
    waves = resting(np.sin(2 * T)[:, None], STEP, np.array([0.03]))
    assert not waves.any()


def test_a_joint_that_is_held_never_rests():
    slow, still = slow_speeds(np.array([2.0, 0.03, 0.5]), (0, 0, 1))
    np.testing.assert_allclose(slow, [0.04, 0.0006, 0.01])
    assert still.tolist() == [False, True, False]
    q, _ = moved(T)
    both = np.column_stack([q, 1e-3 * q])
    known = find_rests([sampled(symgen.make_log("l", T, both, both))], (0, 0))
    assert known is not None
    assert known.slow[0] > 0
    assert known.slow[1] < 0
    assert (
        find_rests([sampled(symgen.make_log("l", T, np.sin(T)[:, None], q[:, None]))], (0,)) is None
    )


@pytest.mark.parametrize(("coulomb", "low", "high"), [(0.0, 1.0, 1.0), (2.0, 1e-3, 0.1)])
def test_the_weight_is_the_deviation_in_motion_over_that_at_rest(evaluator, coulomb, low, high):
    samples = log(1.0, noise=0.05, coulomb=coulomb)
    band = Band(250.0, 30.0, 4.0, "measured", find_rests([samples], (0,)))
    found = weigh_rests(evaluator, [samples], band)
    assert low <= found.rests.weight[0] <= high
    assert weigh_rests(evaluator, [samples], Band(250.0, 30.0, 4.0, "measured")).rests is None


@pytest.mark.parametrize("make", ["torque", "momentum"])
def test_rows_that_a_rest_concerns_are_multiplied_and_no_others(evaluator, make):
    samples = log(1.0)
    slow = find_rests([samples], (0,)).slow

    def rows(rests: Rests | None) -> Equations:
        seen = filter_log(samples, Band(250.0, 30.0, 4.0, "measured", rests))
        if make == "torque":
            return torque_equations(evaluator, seen)[0]
        return window_equations(evaluator, seen, "momentum", 0.2)[0]

    plain, weighed = rows(None), rows(Rests(slow, (0.01,)))
    assert plain.rest is None
    share = np.where(weighed.rest, 0.01, 1.0)
    np.testing.assert_allclose(weighed.W, plain.W * share[:, None])
    np.testing.assert_allclose(weighed.y, plain.y * share)
    np.testing.assert_allclose(
        weighed.with_rest_weight(0.5).y, plain.y * np.where(weighed.rest, 0.5, 1.0)
    )
    reach = 0.125 if make == "torque" else 0.2  # half a period of 4 Hz; a window
    rests = np.mod(weighed.t, 4.0) > 2.2
    far = (np.mod(weighed.t, 4.0) > 0.3 + reach) & (np.mod(weighed.t, 4.0) < 1.7)
    assert weighed.rest[rests].all()
    assert not weighed.rest[far].any()
    some = weighed.where(weighed.rest, "rest")
    assert some.rest.all()
    other = plain.with_sides(weighed)
    np.testing.assert_allclose(other.y, plain.y)


def test_what_a_model_leaves_is_told_apart_in_motion_and_at_rest(evaluator):
    samples = log(1.0)
    rests = Rests(find_rests([samples], (0,)).slow, (0.01,))
    seen = filter_log(samples, Band(250.0, 30.0, 4.0, "measured", rests))
    plain = filter_log(samples, Band(250.0, 30.0, 4.0, "measured"))
    whole, all_alike = fit(evaluator, [seen], TRUE), fit(evaluator, [plain], TRUE)
    np.testing.assert_allclose(whole.error, all_alike.error)  # weights are for fits alone
    np.testing.assert_allclose(whole.size, all_alike.size)
    assert whole.residual.relative > 0.1
    assert whole.in_motion.residual.relative < 0.05
    assert 0.3 < whole.rest[1, 0] / whole.size[0] < 0.7
    assert not all_alike.rest.any()


def test_a_joint_that_moves_in_few_of_the_samples_is_said():
    q, _ = moved(T)
    late = np.where(T < 21, q[0], moved(T - 20)[0])
    seldom = sampled(
        symgen.make_log("seldom", T, np.column_stack([q, late]), np.zeros((len(T), 2)))
    )
    band = Band(250.0, 30.0, 4.0, "measured", find_rests([seldom], (0, 0)))
    (said,) = seldom_moving([filter_log(seldom, band)], ELBOW)
    assert said.startswith("seldom: elbow (2) moved in at most ")
    assert seldom_moving([filter_log(seldom, Band(250.0, 30.0, 4.0, "measured"))], ELBOW) == ()
    assert seldom_moving([filter_log(log(1.0), Band(250.0, 30.0, 4.0, "measured"))], ELBOW) == ()


def test_the_share_of_rests_is_that_of_the_joint_that_rests_most() -> None:
    t = 0.01 * np.arange(1200)
    # The joints take turns: each rests for half of the log, and one of them always does.
    move = np.where((t < 6)[:, None] == [True, False], 1.0, 0.0)
    qd = move * np.sin(2 * np.pi * 0.5 * t)[:, None]
    q = np.cumsum(qd, axis=0) * 0.01
    (said,) = rests_in_words([prepare(make_log("turns", t, q, 0 * q, qd))], read_robot("planar2r"))
    share = float(said.split(" in ")[1].split(" %")[0])
    assert 45 < share < 55


def test_what_a_mask_leaves_too_little_of_is_named_by_log_and_joint() -> None:
    few = Equations("log, joint 2", np.ones((3, 2)), np.ones(3), np.arange(3.0), 1, 1)
    log = prepare(make_log("log", 0.01 * np.arange(40), *np.ones((2, 40, 2))))
    require_left(log, [few], ELBOW)
    masked = replace(log, mask=Mask(np.zeros((40, 2), bool), np.zeros(40, bool)))
    with pytest.raises(LogError, match=r"log: --mask leaves 3 equations of elbow \(2\); accepted"):
        require_left(masked, [few], ELBOW)


def test_equations_are_named_by_joint_and_a_cutoff_that_filters_nothing_is_said() -> None:
    t = 0.01 * np.arange(400)
    q = np.column_stack([np.sin(2 * t), np.cos(3 * t)])
    log = unfiltered(prepare(make_log("log", t, q, q, np.gradient(q, t, axis=0))))
    found = torque_sides(log), momentum_sides(log, place_windows(log, 0.2))
    for sides in found:
        assert [(e.name, e.joint) for e in sides] == [("log, joint 1", 0), ("log, joint 2", 1)]
    band = Band(100.0, OPEN * 100.0, 5.0, "measured")
    assert not band.filters(0.01)
    assert "positions and speeds unfiltered" in band.in_words()
