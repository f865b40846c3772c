"""Every reader on mutations of real files: one line or a finite valid result, and no trace.

A sample by default; all of it on purpose, 100,000 inputs for each reader:

    pytest -m slow tests/robustness/test_fuzz_readers.py

SYMGEN_FUZZ sets the number of inputs for each reader. The long run writes fuzz_figures.json.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from figures import FUZZING, figures, keep
from fuzz_seeds import ESTIMATE, write_seeds
from fuzzing import READERS, fault_of
from hypothesis import given, settings
from hypothesis import strategies as st
from support import PROJECT, sampled

import symgen
from symgen.robot import expressions

SAMPLE = int(os.environ.get("SYMGEN_FUZZ", "100"))
ALL = int(os.environ.get("SYMGEN_FUZZ", "100000"))
_PART = 5000  # inputs of one process


def _read(reader: str, folder: Path, count: int) -> dict[str, Any]:
    """Read `count` inputs, and see that nothing is written anywhere else.

    Returns:
        "inputs", "faults", how many were "refused", the "slowest" in s and the "memory" in MB.
    """
    write_seeds(reader, folder)
    places = ("empty", "home", "temporary", "cache")
    for place in places:
        (folder / place).mkdir()
    given = {p.relative_to(folder / "in") for p in (folder / "in").rglob("*") if p.is_file()}
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(PROJECT), str(PROJECT / "tests")]),
        "HOME": str(folder / "home"),
        "TMPDIR": str(folder / "temporary"),
        "SYMGEN_CACHE": str(folder / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    script = str(PROJECT / "tests" / "fuzzing.py")
    all_ = {"inputs": 0, "faults": [], "refused": 0, "slowest": 0.0, "memory": 0.0}
    begun = time.monotonic()
    while all_["inputs"] < count:
        first = all_["inputs"]
        part = min(_PART, count - first)
        command = [sys.executable, script, reader, str(folder), str(first), str(part)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        if done.returncode == 0:
            found = json.loads(done.stdout)
            all_["faults"] += found["faults"]
            all_["inputs"] += part
            all_["refused"] += found["refused"]
            for key in ("slowest", "memory"):
                all_[key] = max(all_[key], found[key])
        else:  # an input that ended the process
            last = int((folder / "last").read_text())
            all_["faults"].append([last, f"exit {done.returncode}: {done.stderr[-300:]}"])
            all_["inputs"] = last + 1
        rate = all_["inputs"] / (time.monotonic() - begun)
        print(f"{reader}: {all_['inputs']} inputs, {rate:.0f} a second,", end=" ")
        print(f"faults {all_['faults'][-9:]}", flush=True)
    written = [p for place in places for p in (folder / place).rglob("*") if p.is_file()]
    left = [p.relative_to(folder) for p in written]
    found = {p.relative_to(folder / "in") for p in (folder / "in").rglob("*") if p.is_file()}
    assert [p for p in left if p.suffix != ".pickle"] == []
    assert found - given == {Path(READERS[reader][0])}
    return all_


pytestmark = pytest.mark.skipif(os.name == "nt", reason="alarms and bounds of memory of POSIX")


@pytest.mark.parametrize("reader", sampled(READERS, 4))
def test_a_sample_of_spoiled_files_is_a_line_or_a_finite_result(reader, tmp_path):
    """And as many are refused as of all: a reader that refuses what is good shows, too."""
    done = _read(reader, tmp_path, SAMPLE)
    assert done["faults"] == []
    share = figures(FUZZING)["readers"][reader]["refused_share"]
    chance = 4 * (share * (1 - share) / SAMPLE) ** 0.5 + 2 / SAMPLE
    assert abs(done["refused"] / SAMPLE - share) <= chance


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_spoiled_files_are_a_line_or_a_finite_result(reader, tmp_path):
    done = _read(reader, tmp_path, ALL)
    readers = figures(FUZZING)["readers"]
    readers[reader] = {
        "date": str(date.today()),
        "inputs": done["inputs"],
        "faults": len(done["faults"]),
        "refused_share": round(done["refused"] / done["inputs"], 4),
        "slowest_s": round(done["slowest"], 2),
        "memory_mb": round(done["memory"]),
    }
    keep(FUZZING, {"readers": dict(sorted(readers.items()))})
    assert done["faults"] == []


@settings(max_examples=SAMPLE, deadline=2000)
@given(st.text(alphabet="0123456789.eE+-*/() piqrtsLdw1,\n\x00é", max_size=60))
def test_any_text_is_an_expression_of_the_grammar_or_refused_in_a_line(text):
    try:
        value = expressions.parse(text, ("L1",))
    except symgen.ExpressionError as error:
        assert "\n" not in str(error)
    else:
        assert expressions.parse(expressions.text(value), ("L1",)).equals(value)


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=5,
)


@settings(max_examples=SAMPLE, deadline=2000)
@given(st.data())
def test_any_value_at_any_place_of_an_estimate_is_read_or_refused(tmp_path_factory, data):
    spoiled = json.loads(json.dumps(ESTIMATE))
    node, parts = spoiled, []
    while isinstance(node, (dict, list)) and node:
        keys = sorted(node) if isinstance(node, dict) else range(len(node))
        parts.append((node, data.draw(st.sampled_from(list(keys)))))
        node = node[parts[-1][1]]
        if data.draw(st.booleans()):
            break
    parent, key = parts[-1]
    parent[key] = data.draw(json_values)
    path = tmp_path_factory.mktemp("estimate") / "estimate.json"
    path.write_text(json.dumps(spoiled))
    assert not fault_of(READERS["estimate"][1], path)
