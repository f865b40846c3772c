"""What is wrong with a log or a robot file is named, and what is sound is not blamed.

Kinds of spoiling are those of tests/oracles/spoiled.py, on arms whose logs are Pinocchio's with
instruments of their own (tests/oracles/clean_runs.py), and on real robots. The long study
(-m slow -s) draws every kind on robots that no threshold was chosen on and writes
spoiled_figures.json; the default tests take a few of its cases again.
"""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.pinocchio_arm import load_pinocchio
from scipy.interpolate import CubicSpline
from scipy.signal import resample
from support import data_folder, sampled

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

from oracles import clean_runs, spoiled
from workflow import spoiled_study
from workflow.trust_study import identified

import symgen

FIGURES = Path(__file__).parent / "spoiled_figures.json"
#: Robots of the study: simulated ones with the number of their run, and real ones.
SIMULATED, REAL = ("planar2r-31", "arm4r-35", "arm5r-33", "offset6r-34"), ("ur10e",)
DRAW = 8
#: What is always named on a small arm, as it costs much and nothing else looks like it.
NAMED = (
    "gravity_down", "gravity_sideways", "tool_in_a_part", "tool_in_training", "collision",
    "brake_drags", "torque_drifts", "gravity_compensated", "two_signs", "constant",
    "newton_millimetres", "gear_ratio", "clock_runs_fast", "time_reversed",
)  # fmt: skip


@pytest.mark.parametrize("kind", sampled(NAMED, 4))
def test_a_cause_is_named_and_the_estimate_is_doubtful(kind: str) -> None:
    row = spoiled_study.attempt("elbow3r-21", kind, 3)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"
    assert row["named"]


@pytest.mark.parametrize("robot", ["planar2r-51", pytest.param("arm4r-52", marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", ["commanded", "fed_forward"])
def test_a_command_is_named_and_nothing_else(robot: str, kind: str) -> None:
    row = spoiled_study.attempt(robot, kind, 90)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"
    assert row["named"]
    assert not row["wrong"]


@pytest.mark.parametrize("kind", sampled(("zero_slips", "slow_torque", "friction_fades"), 2))
def test_what_one_joint_alone_does_is_named_on_a_short_log(kind: str) -> None:
    row = spoiled_study.attempt("planar2r-31", kind, 8)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"
    assert row["named"]
    assert not row["wrong"]


def test_a_wrong_length_is_named() -> None:
    case = spoiled_study.clean_case("arm4r-52")
    found = spoiled_study.identify(replace(case, robot=case.robot.replace("d = 0.4", "d = 0.46")))
    print(found.uses[0].reasons)
    assert found.verdict != "trusted"
    assert found.uses[0].reasons[0].startswith("the length d of joint 3 is off by about ")


@pytest.mark.parametrize(("seed", "wrong"), [(620_036, 0.437), (700_041, 0.448)])
def test_a_wrong_length_competes_with_a_command_and_a_gain_at_its_size(
    seed: int, wrong: float
) -> None:
    """On these motions they are hardly different; to first order, the length would lose."""
    arms = ("planar2r", "elbow3r", "planar3r", "arm4r")
    run = clean_runs.run(seed, arms=arms, effects=False, torque_noise=(0.002, 0.01))
    assert "d = 0.4\n" in run.robot_toml
    said = identified(
        replace(run, robot_toml=run.robot_toml.replace("d = 0.4\n", f"d = {wrong}\n"))
    )
    (reason,) = said["reasons"]
    found = re.search(r"the length d of joint 3 is off by about (\S+) mm", reason)
    assert found
    assert float(found[1]) == pytest.approx(1e3 * abs(wrong - 0.4), rel=0.1)


def test_a_joint_whose_torque_is_little_beside_a_wrong_one_is_judged_by_its_error() -> None:
    row = spoiled_study.attempt("planar2r-31", "newton_millimetres", 8)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"


@pytest.mark.parametrize("kind", sampled(("turned", "gravity_compensated"), 1))
def test_parameters_of_no_robot_are_not_trusted_where_possible_ones_explain_less(kind: str) -> None:
    row = spoiled_study.attempt("planar2r-31", kind, 8)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"
    assert "no robot moves like this" in row["says"]


def test_a_command_without_coulomb_friction_is_named_whatever_else_is_in_it() -> None:
    row = spoiled_study.attempt("planar2r-31", "commanded", 8)
    print(spoiled_study.line(row))
    assert row["verdict"] != "trusted"
    assert row["named"]


def test_a_sound_log_is_not_blamed() -> None:
    row = spoiled_study.attempt("elbow3r-21", "clean", 0)
    assert row["verdict"] == "trusted", row["says"]


def test_what_a_sound_model_misses_is_not_taken_for_a_fault() -> None:
    """A smooth torque of 5 % of each joint, which is also as if a zero were another on one log."""
    arms = ("planar2r", "spatial2r", "elbow3r")
    run = clean_runs.run(98_007, arms=arms, effects=False, misfit=0.05)
    assert identified(run)["reasons"] == []


def _piece(log: Any, begin: float, end: float) -> Any:
    return log.rows(np.flatnonzero((log.t >= begin) & (log.t <= end)))


@pytest.mark.parametrize("finer", [1.0, 1.25])
def test_a_validation_log_from_the_training_log_is_refused_with_the_ranges(
    tmp_path: Path, finer: float
) -> None:
    """As it is, or resampled at a higher rate."""
    case = spoiled_study.clean_case("elbow3r-21")
    (tmp_path / "robot.toml").write_text(case.robot, "utf-8")
    piece = _piece(case.train, 3.0, 7.0)
    count = round(finer * len(piece.t))
    t = piece.t[0] + (piece.t[1] - piece.t[0]) / finer * np.arange(count)
    inside = t <= piece.t[-1]
    q, qd = (CubicSpline(piece.t, x)(t[inside]) for x in (piece.q, piece.qd))
    held = spoiled_study.Log(t[inside] - 3.0, q, qd, resample(piece.tau, count)[inside])
    train, held = (
        log.save(tmp_path / f"{name}.npz") for log, name in ((case.train, "train"), (held, "held"))
    )
    with pytest.raises(symgen.LogError, match="the validation log holds") as refused:
        symgen.identify(tmp_path / "robot.toml", [train], validation=[held])
    spans = np.array(re.findall(r"from (\S+) to (\S+) s", str(refused.value)), dtype=float)
    # Filters and resampling spoil the ends.
    assert np.abs(spans - [[0.0, 4.0], [3.0, 7.0]]).max() < 0.7
    assert spans[1] - spans[0] == pytest.approx(3.0, abs=0.01)


@pytest.mark.slow
def test_of_spoiled_logs_few_are_called_good_and_most_are_named() -> None:
    """Takes ten minutes; that 3 % of what costs is called good, the goal, is not reached."""
    robots = [*SIMULATED, *(REAL if data_folder().is_dir() else ())]
    rows = spoiled_study.study(robots, [*spoiled.KINDS, "clean"], [DRAW], os.cpu_count() or 1)
    sums = spoiled_study.summary(rows)
    print(json.dumps(sums, indent=1))
    FIGURES.write_text(spoiled_study.text(rows), "utf-8")
    assert sums["costly_named"] >= 0.8 * sums["costly"]
    assert sums["wrong_reason"] <= 0.05 * sums["spoiled"]


def _rows() -> list[dict[str, Any]]:
    if not FIGURES.is_file():
        return []
    return [
        row
        for row in json.loads(FIGURES.read_text("utf-8"))["rows"]
        if row["robot"] in ("planar2r-31", "arm4r-35")
    ]


@pytest.mark.parametrize(
    ("robot", "kind"), sampled([(r["robot"], r["kind"]) for r in _rows()], min(len(_rows()), 3))
)
def test_a_case_of_the_study_is_answered_again(robot: str, kind: str) -> None:
    kept = next(r for r in _rows() if (r["robot"], r["kind"]) == (robot, kind))
    row = spoiled_study.attempt(robot, kind, DRAW)
    print(spoiled_study.line(row))
    assert {key: row[key] for key in ("verdict", "named", "wrong")} == {
        key: kept[key] for key in ("verdict", "named", "wrong")
    }
