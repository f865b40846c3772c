"""Faults put into the code, one at a time: quick tests see them.

    pytest -m slow tests/robustness/test_mutation.py

tries 40 mutants of each group (80 of estimation) and writes mutation_figures.json: how many were
killed, by which test, and who survived; "because" says why no test can kill one that computes the
same, "" where a test is missing. SYMGEN_MUTANTS sets their number, SYMGEN_SEED the word that draws
them. The default test kills two of each group again.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from mutants import GROUPS, mutant, places
from support import PROJECT

FIGURES = Path(__file__).with_name("mutation_figures.json")
COUNT = {"estimation": 80}
MUTANTS = int(os.environ.get("SYMGEN_MUTANTS", "40"))
SEED = os.environ.get("SYMGEN_SEED", "1")
SURVIVE = 0.15
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants run in forks")


def _tried(group: str, count: int, *options: object) -> list[dict[str, Any]]:
    script = [sys.executable, PROJECT / "tests" / "mutants.py", group, count, *options]
    done = subprocess.run([*map(str, script)], capture_output=True, text=True, cwd=PROJECT)
    assert done.returncode == 0, done.stderr[-2000:]
    return [json.loads(line) for line in done.stdout.splitlines()]


def _key(m: dict[str, Any]) -> tuple[str, ...]:
    """What a mutant is, wherever its line now stands."""
    return m["file"], m["text"], m["was"], m["now"]


def _reasons(figures: dict[str, Any], found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return survivors with the reasons that were given before for those that compute the same."""
    known = {_key(m): m["because"] for m in figures.get("survivors", ())}
    return [m | {"because": known.get(_key(m), "")} for m in found if not m["killed_by"]]


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_few_faults_survive(group):
    found = _tried(group, COUNT.get(group, MUTANTS), "--seed", SEED)
    figures = json.loads(FIGURES.read_text("utf-8")) if FIGURES.exists() else {}
    alive = _reasons(figures.get(group, {}), found)
    figures[group] = {
        "places": len(places(group)),
        "seed": SEED,
        "tried": len(found),
        "survived": len(alive),
        "survivors": alive,
        "killed": [m for m in found if m["killed_by"]],
    }
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    missing = [m for m in alive if not m["because"]]
    share = len(alive) / len(found)
    print(f"{group}: {len(alive)} of {len(found)} survived, {share:.0%}; unanswered {len(missing)}")
    assert len(missing) < SURVIVE * len(found)


@pytest.mark.parametrize("group", GROUPS)
def test_a_few_mutants_are_killed_again(group):
    """Of those that were killed by a quick test, two whose line is still there, by that test."""
    killed = json.loads(FIGURES.read_text("utf-8"))[group]["killed"]
    killed = [
        m for m in killed if m["killed_by"].startswith("tests/") and m.get("seconds", 0) < 0.5
    ]
    every = [vars(mutant(k, *place)[0]) for k, place in enumerate(places(group))]
    found = {_key(m): m["place"] for m in every}
    twice = Counter(_key(m) for m in every)
    left = [m for m in killed if twice[_key(m)] == 1]
    assert len(left) >= 2, "nothing of it is left: take the figures again"
    sample = random.Random(SEED).sample(left, 2)
    at = [found[_key(m)] for m in sample]
    for again in _tried(group, 0, "--at", *at, "--by", *(m["killed_by"] for m in sample)):
        assert again["killed_by"], again
