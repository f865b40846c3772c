"""The counts of fault_study.py, a sample of which comes out again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from oracles.pinocchio_arm import load_pinocchio

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

from workflow import fault_study

FIGURES = Path(__file__).with_name("fault_figures.json")
NAMED = 0.9
#: Robot and fault of rows that are taken again: quick ones, of kinds that differ.
SAMPLED = (
    ("elbow3r-7", "gear_ratio"),
    ("elbow3r-7", "clipped"),
)


def _rows() -> list[dict[str, Any]]:
    return list(json.loads(FIGURES.read_text("utf-8"))["rows"])


@pytest.fixture(scope="module")
def again() -> dict[tuple[str, str], dict[str, Any]]:
    """The sampled rows, as they come out today."""
    kept = {(r["robot"], r["fault"]): r for r in _rows()}
    return {key: fault_study.attempt(*key, kept[key]["seed"]) for key in SAMPLED}


@pytest.fixture(scope="module")
def sums(again: dict[tuple[str, str], dict[str, Any]]) -> dict[str, Any]:
    """What the study counts, with these rows in place of those that were kept."""
    return fault_study.summary([again.get((r["robot"], r["fault"]), r) for r in _rows()])


@pytest.mark.parametrize(("robot", "fault"), SAMPLED)
def test_a_fault_of_the_study_is_answered_again(
    again: dict[tuple[str, str], dict[str, Any]], robot: str, fault: str
) -> None:
    kept = next(r for r in _rows() if (r["robot"], r["fault"]) == (robot, fault))
    row = again[robot, fault]
    print(fault_study.line(row))
    for key in ("channels", "visible", "identify", "identify_named", "diagnose", "diagnose_named"):
        assert row[key] == kept[key], key
    assert row["wrong"] == pytest.approx(kept["wrong"], rel=0.1, abs=1e-3)


def test_no_visible_fault_is_trusted_with_a_wrong_model(sums: dict[str, Any]) -> None:
    assert sums["trusted_wrong"] == 0


def test_no_visible_fault_is_explained_away(sums: dict[str, Any]) -> None:
    assert sums["explained_away"] == 0


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_nine_in_ten_visible_faults_are_named_or_refused(
    sums: dict[str, Any], command: str
) -> None:
    assert sums[f"{command}_names_or_refuses"] >= NAMED * sums["visible"]
