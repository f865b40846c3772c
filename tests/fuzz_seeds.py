"""Real files of every reader, for mutations of them."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from oracles.bags import State, write_bag, write_mcap
from support import PROJECT

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
MJCF = """<mujoco model="two">
  <compiler angle="radian"/>
  <option gravity="0 0 -9.81"/>
  <default><joint damping="0.5" armature="0.01"/></default>
  <worldbody>
    <body name="arm" pos="0 0 0.2" quat="0.70710678 0.70710678 0 0">
      <inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.1 0.05"/>
      <joint name="a" type="hinge" axis="0 0 1" range="-1 1" limited="true" frictionloss="0.2"/>
      <body name="hand" pos="0.5 0 0">
        <inertial pos="0 0 0" mass="1" fullinertia="0.02 0.02 0.03 0 0.001 0"/>
        <joint name="b" type="slide" axis="1 0 0"/>
        <geom type="box" size="0.1 0.1 0.1" density="10"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
MAP = "t=time,q1=shoulder pos,q2=elbow pos,tau1=shoulder_\u03c4,tau2=elbow_effort"
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
    "physical": {"distance_sigma": 0.1, "reason": None, "held_out": [0.1, 0.11]},
    "provenance": {"robot": "abc"},
    "comparison": [{"method": "iv", "parameters": [{"name": "ZZ2", "value": 1, "std": 0.1}]}],
    "cutoff_hz": 8.5,
    "window_s": 0.2,
    "verdict": "trusted",
    "reasons": [],
    "notes": ["resampled"],
}
#: What older and newer commands wrote, one folder a kind.
WRITTEN = PROJECT / "tests" / "reference" / "schemas"


def json_text(kind: str) -> str:
    """Return the JSON of a kind of result, such as "estimate-1"."""
    return (WRITTEN / kind / f"{kind.split('-')[0]}.json").read_text("utf-8")


def write_seeds(reader: str, folder: Path) -> None:
    """Write the real files of a reader into folder/seeds, and what stands beside them."""
    seeds = folder / "seeds"
    seeds.mkdir()
    beside = folder / "in"
    beside.mkdir()
    t = np.arange(30) * 0.01
    q = np.column_stack([np.sin(5 * t), np.cos(3 * t)])
    if reader == "toml":
        (seeds / "a").write_text(TOML)
        for path in sorted((PROJECT / "symgen" / "robot" / "library").glob("*.toml")):
            (seeds / path.name).write_bytes(path.read_bytes())
    elif reader in ("urdf", "par", "mjcf"):
        (seeds / "a").write_text({"urdf": URDF, "par": PAR, "mjcf": MJCF}[reader])
    elif reader == "csv":
        rows = _rows(t, q, q, q)
        (seeds / "a").write_text(f"t,q1,q2,qd1,qd2,tau1,tau2\n{rows}\n")
        marked = f"\ufefft,q1,q2,qd1,qd2,tau1,tau2\n{rows}".replace("\n", "\r\n")
        (seeds / "b").write_text(marked, newline="")
        named = "time,a_position,b_position,a_velocity,b_velocity,a_effort,b_effort"
        (seeds / "c").write_text(f"{named}\n{rows}\n")
    elif reader == "npz":
        np.savez(seeds / "a.npz", t=t, q=q, tau=q)
        np.savez_compressed(seeds / "b.npz", t=t, q=q.astype(np.float32), tau=q, qd=q, x=t)
    elif reader == "parquet":
        table = pa.table({"t": t, "q1": q[:, 0], "tau1": q[:, 1], "other": ["x"] * len(t)})
        for name in ("snappy", "zstd", "none"):
            pq.write_table(table, seeds / name, compression=name)
    elif reader in ("mcap", "db3"):
        _write_bags(reader, folder, t, q)
    elif reader == "columns":
        (seeds / "a").write_text(MAP)
        head = "time,shoulder pos,elbow pos,shoulder_\u03c4,elbow_effort,t"
        (beside / "map").mkdir()
        (beside / "map" / "log.csv").write_text(f"{head}\n{_rows(t, q, q, t)}\n")
    elif reader == "motion":
        (seeds / "a").write_text(f"t,q1,q2,qd1,qd2\n{_rows(t, q, q)}\n")
    elif reader == "estimate":
        (seeds / "a").write_text(json.dumps(ESTIMATE, indent=1))
        for kind in ("estimate-1", "estimate-2"):
            (seeds / kind).write_text(json_text(kind))
    elif reader == "diagnosis":
        for kind in ("diagnosis-1", "diagnosis-1-effect"):
            (seeds / kind).write_text(json_text(kind))
        _copy("diagnosis-1", beside / "diagnosis", "robot.toml")
    elif reader in ("prediction", "predicted"):
        one, other = ("json", "csv") if reader == "prediction" else ("csv", "json")
        (seeds / "a").write_bytes((WRITTEN / "prediction-2" / f"prediction.{one}").read_bytes())
        _copy("prediction-2", beside / reader, f"prediction.{other}")
    elif reader == "payload":
        (seeds / "a").write_text(json_text("payload-1"))
    elif reader == "curves":
        _copy("estimate-2", beside / "estimate", "estimate.json")
        (seeds / "a").write_bytes(_curves(t, q))
    elif reader == "values":
        (seeds / "a").write_text(json_text("estimate-1"))
        (seeds / "b").write_text(json_text("estimate-2"))
    else:
        (seeds / "a").write_text("[parameters]\nZZ1R = 3.5\nZZ2 = 0.06\nMX2 = 0.1\nMY2 = -1e-3\n")
        (seeds / "b").write_text("[parameters]\nZZ1 = 3.5\nM2 = 1\nZZ2 = 0.06\nMX2 = 1\nMY2 = 2\n")


def _rows(*columns: np.ndarray) -> str:
    return "\n".join(",".join(f"{v:.6g}" for v in row) for row in np.column_stack(columns))


def _copy(kind: str, folder: Path, name: str) -> None:
    folder.mkdir()
    (folder / name).write_bytes((WRITTEN / kind / name).read_bytes())


def _curves(t: np.ndarray, q: np.ndarray) -> bytes:
    """Return a curves.npz as identify writes it beside estimate-2."""
    trace = {"log": "log.csv", "kind": "train", "quantity": "torque", "spacing": 1}
    index = json.dumps({"traces": [trace]}).encode()
    file = io.BytesIO()
    np.savez_compressed(
        file,
        index=np.frombuffer(index, dtype=np.uint8),
        trace0_t=t,
        trace0_measured=q.astype(np.float32),
        trace0_predicted=q.astype(np.float32),
    )
    return file.getvalue()


def _write_bags(reader: str, folder: Path, t: np.ndarray, q: np.ndarray) -> None:
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    states = [State(int(1e9 * v) + 1, "ab", x, x, x) for v, x in zip(t, q, strict=True)]
    if reader == "mcap":
        pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
        write_mcap(folder / "seeds" / "a", {"/joint_states": states})
        return
    bag = write_bag(folder / "bag", {"/joint_states": states}, "sqlite3")
    (file,) = bag.glob("*.db3")
    (folder / "seeds" / "a").write_bytes(file.read_bytes())
    text = (bag / "metadata.yaml").read_text().replace(file.name, "bag.db3")
    (folder / "in" / "bag").mkdir()
    (folder / "in" / "bag" / "metadata.yaml").write_text(text)
