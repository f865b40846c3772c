"""Joints at rest: static friction is anything between its limits, and must not become gravity."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracles.pinocchio_arm import load_pinocchio

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

import simulated_runs
from oracles import clean_runs, engineer, resting
from oracles.planar2r import harmonic_motion
from support import sampled

import symgen
from symgen.estimation.band import Band, Rests
from symgen.schemas import as_json, from_json

ARMS = ("planar3r", "arm4r", "wrist6r")


@cache
def drawn(arm: str) -> clean_runs.Run:
    run = resting.run(11, arm)
    assert 0.4 < run.drawn["resting"] < 0.9
    return run


@cache
def estimated(arm: str, model: str = "auto") -> dict:
    return simulated_runs.identified(drawn(arm), model=model)


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    """The estimate that most tests look at."""
    estimated("planar3r")


def true_error(run: clean_runs.Run, estimate: dict) -> float:
    truth = simulated_runs.Truth(run, estimate["band"]["comparison_hz"])
    return truth.error(np.array([p["value"] for p in estimate["parameters"]]))


@pytest.mark.parametrize("arm", sampled(ARMS, 0, always=["planar3r"]))
def test_rests_do_not_become_gravity(arm: str) -> None:
    run, estimate = drawn(arm), estimated(arm)
    log = run.train
    even = engineer.even(log.t, log.q, log.qd, log.tau)
    kernel = simulated_runs.evaluator(run.robot_toml)["torque_regressor"]
    band = estimate["band"]["comparison_hz"]
    truth = simulated_runs.Truth(run, band)
    plain = min(
        truth.error(engineer.least_squares(*engineer.equations(kernel, even, hz, band)))
        for hz in (3.0, 5.0, 10.0)
    )
    assert plain > 0.015  # what least squares makes of rests
    assert true_error(run, estimate) < 0.3 * plain
    assert estimate["verdict"] == "trusted", estimate["reasons"]


@pytest.mark.parametrize("model", ["momentum", "torque"])
def test_each_model_weighs_rests(model: str) -> None:
    assert true_error(drawn("planar3r"), estimated("planar3r", model)) < 0.01


def test_what_is_said_counts_all_samples_and_tells_those_in_motion_apart() -> None:
    run, estimate = drawn("planar3r"), estimated("planar3r")
    X = np.array([p["value"] for p in estimate["parameters"]])
    log, band = run.validation, estimate["band"]
    kernel = simulated_runs.evaluator(run.robot_toml)["torque_regressor"]
    even = engineer.even(log.t, log.q, log.qd, log.tau)
    W, y = engineer.equations(
        kernel, even, band["cutoff_hz"], band["comparison_hz"], band["velocity"] == "derived"
    )
    by_hand = engineer.residual(W, y, X)[1]
    said = estimate["torque_residual"]["validation"]["relative"]
    assert said == pytest.approx(by_hand, rel=0.1)
    (note,) = [n for n in estimate["notes"] if "stand still at times" in n]
    moving, still = map(
        float, re.findall(r"is ([\d.]+) % .* and ([\d.]+) % for joints at rest", note)[0]
    )
    assert moving < 100 * said / 5
    assert still > 100 * said


@pytest.mark.slow  # the nearest possible robot is light, and noise throws it about
def test_no_channel_is_blamed_where_the_model_explains_nothing() -> None:
    rng = np.random.default_rng(1)
    t, q, qd, _ = harmonic_motion(rng, 1)
    noise = (symgen.make_log(name, t, q, rng.normal(size=q.shape), qd) for name in ("a", "b"))
    estimate = symgen.identify("planar2r", next(noise), validation=next(noise))
    assert estimate.verdict == "doubtful"
    assert "fault" not in {reason.kind for reason in estimate.reasons}
    assert estimate.repairs == ()


@pytest.mark.rounding
def test_static_friction_is_no_effect_that_is_missing(tmp_path: Path) -> None:
    run = drawn("planar3r")
    robot = tmp_path / "robot.toml"
    robot.write_text(run.robot_toml, "utf-8")
    paths = [
        log.save(tmp_path / f"{name}.npz")
        for name, log in (("a", run.train), ("b", run.validation))
    ]
    found = symgen.diagnose(robot, [paths[0]], validation=[paths[1]])
    assert not found.effects, [e.name for e in found.effects]
    assert found.before.total > 0.05  # of all samples


@pytest.mark.rounding
def test_the_sign_of_a_rounding_at_a_rest_is_no_direction_of_motion() -> None:
    """Positions that differ by 1e-12 of themselves give the same band, and X far within its std."""
    run, exact = drawn("planar3r"), estimated("planar3r", "torque")
    noise = 1 + 1e-12 * np.random.default_rng(1).normal(size=run.train.q.shape)
    rounded = replace(run, train=replace(run.train, q=run.train.q * noise))
    again = simulated_runs.identified(rounded, model="torque")
    for key in ("cutoff_hz", "comparison_hz", "velocity"):
        assert again["band"][key] == exact["band"][key]
    for p, other in zip(exact["parameters"], again["parameters"], strict=True):
        assert abs(p["value"] - other["value"]) < 0.01 * p["std"], p["name"]


def test_weights_travel_with_the_band() -> None:
    band = Band(250.0, 8.0, 3.0, "measured", Rests((0.02, -1.0), (0.05, 1.0)))
    content, file = as_json(band), Path("estimate.json")
    assert from_json(Band, json.loads(json.dumps(content)), file) == band
    older = {k: v for k, v in content.items() if k != "rests"}
    assert from_json(Band, older, file).rests is None
    for weight in (0.0, 1.5):
        with pytest.raises(symgen.ParameterError, match="rests"):
            from_json(Band, content | {"rests": {"slow": [0.1], "weight": [weight]}}, file)
