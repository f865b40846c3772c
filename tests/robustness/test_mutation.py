"""Faults put into the code, one at a time: quick tests see them.

    pytest -m slow tests/robustness/test_mutation.py

tries 60 mutants of each group and writes mutation_figures.json: how many were killed, by which
test, and who survived; "because" says why no test can kill one, where that is so. SYMGEN_MUTANTS
sets their number. The default test kills a few of them again.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from mutants import GROUPS, mutant, places
from support import PROJECT

FIGURES = Path(__file__).with_name("mutation_figures.json")
COUNT = int(os.environ.get("SYMGEN_MUTANTS", "60"))
SURVIVE = 0.15
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants run in forks")


def _tried(group: str, count: int, *wanted: int) -> list[dict[str, Any]]:
    script = [sys.executable, PROJECT / "tests" / "mutants.py", group, str(count), *wanted]
    done = subprocess.run([*map(str, script)], capture_output=True, text=True, cwd=PROJECT)
    assert done.returncode == 0, done.stderr[-2000:]
    return [json.loads(line) for line in done.stdout.splitlines()]


def _reasons(figures: dict[str, Any], found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return survivors with the reasons that were given before for those that compute the same."""
    known = {(m["place"], m["was"], m["now"]): m["because"] for m in figures.get("survivors", ())}
    return [
        m | {"because": known.get((m["place"], m["was"], m["now"]), "")}
        for m in found
        if not m["killed_by"]
    ]


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_few_faults_survive(group):
    found = _tried(group, COUNT)
    figures = json.loads(FIGURES.read_text("utf-8")) if FIGURES.exists() else {}
    alive = _reasons(figures.get(group, {}), found)
    figures[group] = {
        "places": len(places(group)),
        "tried": len(found),
        "survived": len(alive),
        "survivors": alive,
        "killed": [m for m in found if m["killed_by"]],
    }
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    assert sum(not m["because"] for m in alive) < SURVIVE * len(found)


def test_a_few_mutants_are_killed_again():
    """Of those that were killed, a few whose line is still there, wherever it stands now."""
    killed = json.loads(FIGURES.read_text("utf-8"))["select"]["killed"]
    every = [mutant(k, *place)[0] for k, place in enumerate(places("select"))]
    found = {(m.text, m.was, m.now): m.place for m in every}
    twice = Counter((m.text, m.was, m.now) for m in every)
    keys = [(m["text"], m["was"], m["now"]) for m in killed]
    sample = [found[key] for key in keys if twice[key] == 1][5::25]
    assert sample, "nothing of it is left: take the figures again"
    for again in _tried("select", 0, *sample):
        assert again["killed_by"], again
