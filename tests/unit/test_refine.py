"""Constants of effects between the values of their grid: on a log whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.planar2r import harmonic_motion, torque_regressor

import symgen
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.diagnosis.baseline import baseline, model_of
from symgen.diagnosis.effects import Score, candidates
from symgen.diagnosis.refine import settled_constants
from symgen.estimation.band import Band
from symgen.estimation.filtered_log import filter_log

DETENT = """
[[effect]]
name = "detent"
joints = [1]
torque = "A*exp(-((q1-c)/w)**2)"
linear = { A = "N m" }
nonlinear = { c = [-0.5, 0.9], w = [0.06, 0.4] }
"""


@pytest.fixture(scope="module")
def detent():
    """The two-link arm with a detent of joint 1 at 0.3 rad, 0.18 rad wide, and its columns."""
    t, q, qd, qdd = harmonic_motion(np.random.default_rng(1), 1)
    tau = torque_regressor(q, qd, qdd, 0.5) @ [1.7, 0.15, 0.3, 0.02]
    tau[:, 0] += 3.0 * np.exp(-(((q[:, 0] - 0.3) / 0.18) ** 2))
    samples = sampled(make_log("log", t, q, tau, qd))
    log = filter_log(samples, Band(1 / samples.step, 20.0, 8.0, "measured"))
    robot = symgen.read_robot("planar2r")
    start = baseline(model_of(robot), [log], [])
    sought = symgen.parse_robot(symgen.robot_toml(robot) + DETENT)
    candidate, *_ = candidates(sought, [log], ["detent"])
    return start, candidate, start.seen(start.base)


@pytest.mark.parametrize(("c", "w"), [(0.0, 0.5), (0.9, 0.06), (0.9, 0.5)])
def test_constants_settle_at_the_truth_also_where_whole_steps_go_too_far(detent, c, w) -> None:
    start, candidate, seen = detent
    first = candidate.moved({"c": c, "w": w})
    [found] = settled_constants(start, [Score(first, seen(first))], seen)
    assert found.candidate.constants == pytest.approx({"c": 0.3, "w": 0.18}, rel=0.02)
