"""Every reader on mutations of real files: one line or a finite valid result, and no trace.

A sample by default; all of it on purpose, 100,000 inputs for each reader:

    pytest -m slow tests/robustness/test_fuzz_readers.py

SYMGEN_FUZZ sets the number of inputs for each reader.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fuzzing import READERS
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.bags import State, write_bag, write_mcap
from support import PROJECT

import symgen
from symgen.robot import expressions

SAMPLE = int(os.environ.get("SYMGEN_FUZZ", "150"))
ALL = int(os.environ.get("SYMGEN_FUZZ", "100000"))
_PART = 5000  # inputs of one process

URDF = """<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0.1 0 0" rpy="0 0 0.3"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="hand"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.2" rpy="1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/></joint>
  <joint name="b" type="prismatic"><parent link="arm"/><child link="hand"/>
    <origin xyz="0.5 0 0"/><axis xyz="1 0 0"/><mimic joint="a" multiplier="2" offset="0.1"/></joint>
</robot>
"""
PAR = """(* Robotname = 'two' *)
NL = 2
NJ = 2
NF = 2
Type = 0
is_mobile = 0
Ant = {0, 1}
sigma = {0, 1}
gamma = {0, 0}
B = {0, b2}
d = {0, L1*sqrt(2)/2}
r = {0.1, r2 + 0.3}
alpha = {0, Pi/2}
theta = {th1 + Pi/6, 0}
M = {1.5, M2}
FS = {FS1, 0}
G = {0, 0, G3}
"""
TOML = """[robot]
name = "arm"
convention = "modified-dh"
gravity = [0.0, "-fall", 0]

[geometry]
L1 = 0.5
fall = 9.81

[[joint]]
friction = ["coulomb", "offset"]
coulomb_width = 0.01
name = "shoulder"

[[joint]]
sigma = 1
gamma = 0.3
d = "sqrt(2)*L1/2"
alpha = "-pi/2"

[[joint]]
follows = "pi/2 - 2*q1"
antecedent = 1

[[joint]]
theta = 0.7853981633974483

[[coupling]]
joints = [1, 4]
ratio = "-1/3"

[limits]
position = [[-3.1, 3.1], [-2.0, 2.0], [-1, 1]]
velocity = [2.0, 3.0, 1]

[drive]
ratio = [100.0, 80.0, 50]

[payload]
joint = 2

[[effect]]
name = "hose"
joints = [1]
torque = "-A*tanh((q1-c)/w) + B*min(q1, 2)*exp(-qd1**2)"
linear = { A = "N m", B = "N m/rad" }
nonlinear = { c = 0.2, w = [0.1, 0.5] }
"""
ESTIMATE = {
    "schema": "symgen.estimate/1",
    "robot": "planar2r",
    "model": "energy",
    "method": "wls",
    "parameters": [
        {"name": n, "expression": "ZZ1 + L1**2*M2", "value": v, "std": s, "unit": "kg m2"}
        for n, v, s in (("ZZ1R", 3.5, 0.1), ("ZZ2", 0.06, None), ("MX2", 0.124, 2e-3))
    ],
    "condition_number": 3.0,
    "residual": {
        "train": {"relative": 0.1, "per_joint": None},
        "validation": {"relative": 0.1, "per_joint": [0.1, 0.2]},
    },
    "torque_residual": {
        "train": {"relative": 0.1, "per_joint": [0.1, 0.2]},
        "validation": {"relative": 0.1, "per_joint": [0.1, 0.2]},
    },
    "joints": [{"number": 1, "unit": "N m"}, {"number": 2, "unit": "N m"}],
    "correlation": [[1, 0.1, 0], [0.1, 1, 0], [0, 0, 1]],
    "whiteness": [
        {
            "quantity": "energy",
            "component": 0,
            "kind": "validation",
            "rows": 100,
            "step_s": 0.1,
            "correlations": [0.5, 0.1, 0.1],
            "bands": [0.2, 0.2, 0.2],
            "statistic": 30.0,
            "p_value": 1e-6,
        }
    ],
    "physical": {"feasible": True, "distance_sigma": 0.1, "reason": "exists"},
    "provenance": {"robot": "abc"},
    "comparison": [{"method": "iv", "parameters": [{"name": "ZZ2", "value": 1, "std": 0.1}]}],
    "cutoff_hz": 8.5,
    "window_s": 0.2,
    "verdict": "trusted",
    "reasons": [],
    "notes": ["resampled"],
}


def _seeds(reader: str, folder: Path) -> None:
    """Write the real files of a reader."""
    folder.mkdir()
    t = np.arange(30) * 0.01
    q = np.column_stack([np.sin(5 * t), np.cos(3 * t)])
    if reader == "toml":
        (folder / "a").write_text(TOML)
        for path in sorted((PROJECT / "symgen" / "robot" / "library").glob("*.toml")):
            (folder / path.name).write_bytes(path.read_bytes())
    elif reader == "urdf":
        (folder / "a").write_text(URDF)
    elif reader == "par":
        (folder / "a").write_text(PAR)
    elif reader == "csv":
        columns = np.column_stack([t, q, q, q])
        header = "t,q1,q2,qd1,qd2,tau1,tau2"
        rows = "\n".join(",".join(f"{v:.6g}" for v in row) for row in columns)
        (folder / "a").write_text(f"{header}\n{rows}\n")
        (folder / "b").write_text(f"\ufeff{header}\r\n" + rows.replace("\n", "\r\n"))
    elif reader == "npz":
        np.savez(folder / "a.npz", t=t, q=q, tau=q)
        np.savez_compressed(folder / "b.npz", t=t, q=q.astype(np.float32), tau=q, qd=q, x=t)
    elif reader == "parquet":
        table = pa.table({"t": t, "q1": q[:, 0], "tau1": q[:, 1], "other": ["x"] * len(t)})
        for name in ("snappy", "zstd", "none"):
            pq.write_table(table, folder / name, compression=name)
    elif reader in ("mcap", "db3"):
        pytest.importorskip("rosbags", reason="rosbags is not installed")
        states = [State(int(1e9 * v) + 1, "ab", x, x, x) for v, x in zip(t, q, strict=True)]
        if reader == "mcap":
            pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
            write_mcap(folder / "a", {"/joint_states": states})
        else:
            bag = write_bag(folder.parent / "bag", {"/joint_states": states}, "sqlite3")
            (file,) = bag.glob("*.db3")
            (folder / "a").write_bytes(file.read_bytes())
            text = (bag / "metadata.yaml").read_text().replace(file.name, "bag.db3")
            (folder.parent / "in" / "bag").mkdir(parents=True)
            (folder.parent / "in" / "bag" / "metadata.yaml").write_text(text)
    elif reader == "estimate":
        (folder / "a").write_text(json.dumps(ESTIMATE, indent=1))
    else:
        (folder / "a").write_text("[parameters]\nZZ1R = 3.5\nZZ2 = 0.06\nMX2 = 0.1\nMY2 = -1e-3\n")
        (folder / "b").write_text("[parameters]\nZZ1 = 3.5\nM2 = 1\nZZ2 = 0.06\nMX2 = 1\nMY2 = 2\n")


def _faults(reader: str, folder: Path, count: int) -> list[list[object]]:
    """Read `count` inputs, and see that nothing is written anywhere else."""
    _seeds(reader, folder / "seeds")
    places = ("empty", "home", "temporary", "cache")
    for place in places:
        (folder / place).mkdir()
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(PROJECT), str(PROJECT / "tests")]),
        "HOME": str(folder / "home"),
        "TMPDIR": str(folder / "temporary"),
        "SYMGEN_CACHE": str(folder / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    script = str(PROJECT / "tests" / "fuzzing.py")
    faults: list[list[object]] = []
    first = 0
    while first < count:
        part = min(_PART, count - first)
        command = [sys.executable, script, reader, str(folder), str(first), str(part)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        if done.returncode == 0:
            faults += json.loads(done.stdout)
            first += part
        else:  # an input that ended the process
            last = int((folder / "last").read_text())
            faults.append([last, f"exit {done.returncode}: {done.stderr[-300:]}"])
            first = last + 1
    left = [p.relative_to(folder) for place in places for p in (folder / place).rglob("*")]
    found = {p.name for p in (folder / "in").rglob("*") if p.is_file()} - {"metadata.yaml"}
    assert left == []
    assert found == {Path(READERS[reader][0]).name}
    return faults


pytestmark = pytest.mark.skipif(os.name == "nt", reason="alarms and bounds of memory of POSIX")


@pytest.mark.parametrize("reader", READERS)
def test_a_sample_of_spoiled_files_is_a_line_or_a_finite_result(reader, tmp_path):
    assert _faults(reader, tmp_path, SAMPLE) == []


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_spoiled_files_are_a_line_or_a_finite_result(reader, tmp_path):
    faults = _faults(reader, tmp_path, ALL)
    print(f"{reader}: {ALL} inputs, {len(faults)} faults")
    assert faults == []


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
    from fuzzing import fault_of

    assert fault_of(READERS["estimate"][1], path) is None
