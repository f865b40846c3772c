"""Faults put into the code, one at a time: quick tests see them.

    pytest -m slow tests/robustness/test_mutation.py

tries 40 mutants of each group (120 of estimation) and writes mutation_figures.json: how many were
killed, by which test, and who survived, with the 95 % interval of their share among all places;
"because" says why no test can kill one that computes the same, "" where a test is missing, and
names the test that was written since: `-k killed_by_a_new_test` shows it that mutant (the interval
is then that of what tests were written for). SYMGEN_MUTANTS sets their number, SYMGEN_SEED the word
that draws them. The default test kills one of each group again.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from mutants import GROUPS, key, now_at, places
from scipy.stats import binomtest
from support import PROJECT

FIGURES = Path(__file__).with_name("mutation_figures.json")
COUNT = {"estimation": 120}
MUTANTS = int(os.environ.get("SYMGEN_MUTANTS", "40"))
SEED = os.environ.get("SYMGEN_SEED", "1")
SURVIVE = 0.15
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants run in forks")


def _tried(*options: object) -> Iterator[dict[str, Any]]:
    """Yield mutants as they are tried."""
    script = [sys.executable, PROJECT / "tests" / "mutants.py", *options]
    with (
        tempfile.TemporaryFile("w+") as said,
        subprocess.Popen(
            [*map(str, script)], stdout=subprocess.PIPE, stderr=said, text=True, cwd=PROJECT
        ) as job,
    ):
        for line in job.stdout or ():
            print(line, end="", flush=True)
            yield json.loads(line)
        job.wait()
        said.seek(0)
        assert job.returncode == 0, said.read()[-2000:]


def _reasons(figures: dict[str, Any], found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return survivors with the reasons that were given before for those that compute the same."""
    known = {key(m): m["because"] for m in figures.get("survivors", ())}
    return [m | {"because": known.get(key(m), "")} for m in found if not m["killed_by"]]


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_few_faults_survive(group):
    before = json.loads(FIGURES.read_text("utf-8")).get(group, {}) if FIGURES.exists() else {}
    found, alive = [], []
    for m in _tried(group, COUNT.get(group, MUTANTS), "--seed", SEED):
        found.append(m)
        alive = _reasons(before, found)
        killed = [m for m in found if m["killed_by"]]
        _kept(group, alive, killed, seed=SEED)
    missing = [m for m in alive if not m["because"]]
    print(f"unanswered: {len(missing)}")
    assert len(missing) < SURVIVE * len(found)


def _kept(
    group: str, alive: list[dict[str, Any]], killed: list[dict[str, Any]], **more: object
) -> None:
    """Write who survived of a group and who did not, and print how many."""
    tried = len(alive) + len(killed)
    interval = binomtest(len(alive), tried).proportion_ci(method="wilson")
    of = {"tried": tried, "survived": len(alive), "interval": [round(x, 3) for x in interval],
          "survivors": alive, "killed": killed}  # fmt: skip
    figures = json.loads(FIGURES.read_text("utf-8")) if FIGURES.exists() else {}
    figures[group] = {**figures.get(group, {}), "places": len(places(group)), **more, **of}
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    low, high = (f"{100 * x:.0f} %" for x in of["interval"])
    print(f"{group}: {len(alive)} of {tried} survived, 95 % interval {low} to {high}")


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_survivors_are_killed_by_a_new_test(group):
    """Those whose "because" is a test."""
    of = json.loads(FIGURES.read_text("utf-8"))[group]
    tested = [m for m in of["survivors"] if m["because"].startswith("tests/")]
    if not tested:
        pytest.skip("no survivor names a test")
    places_now = (at[0] for at in now_at(group, tested))
    shown = _again(group, zip(places_now, (m["because"] for m in tested), strict=True))
    found = {key(m): m for m in _tried(*shown) if m["killed_by"]}
    alive = [m for m in of["survivors"] if key(m) not in found]
    _kept(group, alive, [*of["killed"], *found.values()])
    assert len(found) == len(tested)


def _again(group: str, shown: Iterable[tuple[int, str]]) -> list[object]:
    """Return options that show mutants of a group to one test each."""
    return [option for place, test in shown for option in ("--again", group, place, test)]


def test_a_few_mutants_are_killed_again():
    """Of those of each group that a quick test killed, one whose line is still there, by it."""
    figures, shown = json.loads(FIGURES.read_text("utf-8")), []
    for group in GROUPS:
        quick = [m for m in figures[group]["killed"]
                 if m["killed_by"].startswith("tests/") and m.get("seconds", 0) < 0.5]  # fmt: skip
        left = ((at[0], m["killed_by"]) for m in random.Random(SEED).sample(quick, len(quick))
                for at in now_at(group, [m]) if len(at) == 1)  # fmt: skip
        shown += _again(group, islice(left, 1))
    found = list(_tried(*shown))
    assert len(found) == len(GROUPS), "too few of a group are left: take the figures again"
    for again in found:
        assert again["killed_by"], again
