"""How often 95 % intervals hold the truth, on simulated arms with known parameters.

The long study (-m slow -s) writes interval_figures.json; the default test takes a run of it again.
"""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
from oracles.pinocchio_arm import load_pinocchio
from support import SAMPLE, sampled

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

from workflow import interval_study

FIGURES = Path(__file__).with_name("interval_figures.json")
RUNS, SEED = 60, 64_100
#: Goals: with noise of instruments alone, 92 to 98 of 100 intervals hold the truth; with a misfit
#: 90 and more, and they are at most twice as long as the shortest of which as many do.
LOW, HIGH, MISFIT, LONGER = 0.92, 0.98, 0.90, 2.0


def _figures() -> dict[str, Any]:
    return dict(json.loads(FIGURES.read_text("utf-8")))


@pytest.mark.slow
def test_the_study() -> None:
    """Takes about six minutes on two cores."""
    rows = interval_study.study(RUNS, SEED, 2)
    print(json.dumps(interval_study.summary(rows), indent=1))
    FIGURES.write_text(interval_study.text(rows, RUNS, SEED), "utf-8")


def test_with_noise_alone_as_many_intervals_hold_the_truth_as_they_say() -> None:
    noise = _figures()["summary"]["noise"]["all"]
    assert noise["parameters"] >= 500
    assert LOW < noise["held"] < HIGH


@pytest.mark.parametrize("family", ["misfit", "effects"])
def test_with_a_misfit_nine_of_ten_hold_it_and_are_no_longer_than_they_must(family: str) -> None:
    found = _figures()["summary"][family]["all"]
    assert found["parameters"] >= 500
    assert found["held"] >= MISFIT
    assert found["factor"] >= 1 / LONGER


@pytest.mark.parametrize("family", sampled(tuple(interval_study.GOALS), 1))
def test_a_run_of_the_study_comes_out_again(family: str) -> None:
    rows = [r for r in _figures()["rows"] if r["family"] == family and "model" in r]
    kept = random.Random(SAMPLE).choice(rows)
    row = interval_study.short(interval_study.attempt((kept["seed"], family)))
    assert (row["model"], row["parameters"]) == (kept["model"], kept["parameters"])
    assert abs(row["held"] - kept["held"]) <= 1
