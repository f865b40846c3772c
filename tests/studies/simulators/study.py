"""What simulators do to files of `symgen export`, beside the torques of symgen's model.

    python tests/studies/simulators/study.py DRAKE/bin/python:in_drake.py --robots tool_arm.urdf

Each argument is the Python in which a simulator is installed, and its script. Torques of a
simulator, from its inverse dynamics and from the accelerations that it computes, are fitted by

    torque = a links + b rotor inertia + c damping + d Coulomb friction + e friction as damping

with the torques of symgen's model for the written parameters. A share of 1 means that the
simulator has this part, 0 that it does not. What remains is a part of the largest torque.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from oracles.gripper_arm import urdf as panda_with_fingers
from oracles.random_urdf import random_urdf
from oracles.urdf_arm import shipped
from support_estimate import write_estimate
from workflow.test_export import URDF as SLIDING_FINGER
from workflow.test_export_simulators import ARM as MJCF_ARM

import symgen
from symgen import cli
from symgen.identification.export import export
from symgen.identification.parameters import base_values
from symgen.robot.toml_io import read_imported

HERE = Path(__file__).resolve().parent
STATES, SEED = 20, 6
#: Torques relative to the effort limits, for a look at what acts above them.
PUSHES = (0.0, 0.5, 3.0)
#: Error above which Coulomb friction is also tried as a viscous one, N m.
_FITS = 1e-2
PARTS = {"IA": "rotor", "FV": "damping", "FS": "friction"}
SHIPPED = ("ur5_robot", "xarm7", "z1", "so101")
TOOL = """<robot name="tool_arm"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0.25 0 0.02" rpy="0.2 0.1 0"/><mass value="3"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.08" iyz="0" izz="0.07"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.2 0 0.01"/><mass value="1.8"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0.001" izz="0.03"/></inertial></link>
  <link name="tool"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="120" velocity="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0" rpy="0.3 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="60" velocity="3"/></joint>
  <joint name="flange" type="fixed"><parent link="lower"/><child link="tool"/>
    <origin xyz="0.4 0 0"/></joint>
  <joint name="end" type="fixed"><parent link="tool"/><child link="tip"/>
    <origin xyz="0 0 0.1"/></joint>
  <transmission name="one"><type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"/><actuator name="motor1"/></transmission>
  <transmission name="two"><type>transmission_interface/SimpleTransmission</type>
    <joint name="elbow"/><actuator name="motor2"/></transmission></robot>"""
MOTORS = """<actuator><motor joint="a > b" gear="100" forcerange="-1 1"/>
  <motor joint="elbow" gear="50" forcerange="-1 1"/><motor joint="wrist" forcerange="-9 9"/>
  </actuator></mujoco>"""
GEARED = MOTORS.replace('gear="50"', 'gear="50" armature="4e-5" damping="1e-5"')
DRIVE = """<tendon><fixed name="drive" armature="0.05" damping="0.2">
  <joint joint="elbow" coef="1"/><joint joint="wrist" coef="-1.5"/></fixed></tendon></mujoco>"""


def robots() -> dict[str, str]:
    """Return the texts of robots by the names of their files, without geometry."""
    files = {path.stem: path for path in shipped()}
    texts = {"tool_arm.urdf": TOOL, "sliding_finger.urdf": SLIDING_FINGER}
    texts |= {"panda.urdf": panda_with_fingers(), "tree8.urdf": random_urdf(8, True)}
    texts |= {"tree4.urdf": random_urdf(4)}
    texts |= {f"{name}.urdf": files[name].read_text("utf-8") for name in SHIPPED}
    for name, text in texts.items():
        if name != "tool_arm.urdf":
            kinds = r"<(visual|collision|transmission)\b.*?</\1>"
            texts[name] = re.sub(kinds, "", text, flags=re.DOTALL)
    ends = {"arm": "</mujoco>", "motors": MOTORS, "geared": GEARED, "drive": DRIVE}
    return texts | {f"{k}.xml": MJCF_ARM.replace("</mujoco>", end) for k, end in ends.items()}


def exported(folder: Path, name: str, text: str) -> tuple[Path, dict[str, Any], dict[str, Any]]:
    """Export a robot with friction and rotor inertia; return its file, states and torques.

    Returns:
        The file; names of its joints with states and torques of all parts; qdd (K, n), ratios
        (J, n) of followers, and a function of qdd that returns the torques (K, n) of each part.
    """
    source, to = folder / name, folder / f"out_{name}"
    source.write_text(text, "utf-8")
    found = read_imported(source)
    robot, draw = found.robot, np.random.default_rng(SEED)
    model = symgen.derive(robot, "all")
    evaluator = symgen.load(model)
    ranges = (robot.limits and robot.limits.position) or [(-1.0, 1.0)] * robot.n
    low, high = np.clip(np.transpose(ranges), -3, 3)
    q = low + (high - low) * draw.random((STATES, robot.n))
    qd, qdd = draw.uniform(-2, 2, (2, STATES, robot.n))

    def torques(values: Mapping[str, float], qdd: np.ndarray) -> np.ndarray:
        return np.array(evaluator.inverse_dynamics(q, qd, qdd, base_values(values, model, name)))

    values = dict(found.parameters)
    size = np.abs(torques(values, qdd)).max(axis=0)
    for joint, own in zip(robot.movable, size, strict=True):
        for prefix, share in (("IA", 0.05), ("FV", 0.1), ("FS", 0.1)):
            key = f"{prefix}{joint.number}"
            values[key] = values[key] or share * own * (1 + draw.random())
    X = base_values(values, model, name)
    result = write_estimate(folder / f"{source.stem}_result", model, X)
    sys.argv = ["symgen", "export", str(result), "--from", str(source), "--to", str(to)]
    try:
        cli.main()
    except SystemExit as end:
        if end.code:
            raise RuntimeError(name) from end
    written = export(result, source).values
    none = dict.fromkeys(written, 0.0)

    def parts(qdd: np.ndarray) -> dict[str, np.ndarray]:
        kinds = {key: PARTS.get(key[:2], "links") for key in written}
        out = {
            part: torques({k: v * (kinds[k] == part) for k, v in written.items()}, qdd)
            for part in ("links", *PARTS.values())
        }
        viscous = {k.replace("FS", "FV"): v for k, v in written.items() if k.startswith("FS")}
        return {**out, "friction as damping": torques({**none, **viscous}, qdd)}

    moving = [joint for joint in robot.moving if joint.name in text]
    shares = [dict(joint.shares) for joint in moving]
    ratio = np.array([[float(own.get(k, 0)) for k in robot.numbers] for own in shares])
    offset = [float(joint.offset) for joint in moving]
    tau = sum(parts(qdd)[part] for part in ("links", *PARTS.values())) @ np.linalg.pinv(ratio)
    rows = zip(q @ ratio.T + offset, qd @ ratio.T, qdd @ ratio.T, tau, strict=True)
    keys = ("q", "qd", "qdd", "tau")
    states = [{k: x.tolist() for k, x in zip(keys, row, strict=True)} for row in rows]
    efforts = np.array((robot.limits and robot.limits.torque) or size) @ np.linalg.pinv(ratio)
    states += [{**states[0], "tau": (share * efforts).tolist()} for share in PUSHES]
    given = {"base": base(source), "joints": [joint.name for joint in moving], "states": states}
    return to, given, {"ratio": ratio, "qdd": qdd, "parts": parts}


def base(source: Path) -> str:
    """Return the root link of a URDF, or "" for an MJCF."""
    text = source.read_text("utf-8")
    children = re.findall(r"<child\s+link=.([^'\"]*)", text)
    links = re.findall(r"<link\s+name=.([^'\"]*)", text)
    return next((name for name in links if name not in children), "")


def compared(
    given: Mapping[str, Any], ours: Mapping[str, Any], found: Mapping[str, Any]
) -> Iterator[str]:
    """Yield the shares of all parts in the torques of a simulator, and what remains."""
    at = [found["joints"].index(name) for name in given["joints"]]
    states = given["states"][: -len(PUSHES)]
    ratio, wanted = ours["ratio"], np.array([state["tau"] for state in states])
    for way in sorted({"inverse", "forward", "friction"} & {*found}):
        rows = np.array(found[way])[:, at]
        rows, pushed = np.split(rows, [len(states)])
        if way == "forward":
            half, over = pushed[1:] - pushed[0]
            acts = np.linalg.norm(over) / np.linalg.norm(half) * PUSHES[1]
            yield f"of a torque of {PUSHES[2]} times the effort acts {acts:.3f}"
        tau, qdd = (wanted, rows) if way == "forward" else (rows, None)
        if way == "forward" and len(ratio) > len(ratio[0]):
            continue  # followers move by themselves
        tau, qdd = tau @ ratio, ours["qdd"] if qdd is None else np.linalg.solve(ratio, qdd.T).T
        parts = {key: x for key, x in ours["parts"](qdd).items() if np.any(x)}
        viscous = parts.pop("friction as damping")
        shares, error = fitted(parts, tau)
        if error > _FITS:
            shares, error = fitted({**parts, "friction as damping": viscous}, tau)
        text = ", ".join(f"{x:.3f} {key}" for key, x in shares.items())
        yield f"{way}: {text}; remains {error / np.abs(wanted).max():.1e}"


def fitted(parts: Mapping[str, np.ndarray], tau: np.ndarray) -> tuple[dict[str, float], float]:
    """Return the shares of parts (K, n) in a torque, and the error with shares of 0 and 1."""
    columns = np.column_stack([x.ravel() for x in parts.values()])
    weight = np.tile(1 / np.abs(sum(parts.values())).max(axis=0), len(tau))
    fit = np.linalg.lstsq(columns * weight[:, None], tau.ravel() * weight, rcond=None)[0]
    error = np.abs(columns @ np.round(fit) - tau.ravel()).max()
    return dict(zip(parts, map(float, fit), strict=True)), float(error)


def main() -> None:
    """Print the comparison of each robot in each simulator."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("simulators", nargs="+", metavar="PYTHON:SCRIPT")
    parser.add_argument("--robots", nargs="+", help="default: all")
    options = parser.parse_args()
    texts = robots()
    with TemporaryDirectory() as name:
        folder = Path(name)
        states, out = folder / "states.json", folder / "torques.json"
        for robot in options.robots or texts:
            to, given, ours = exported(folder, robot, texts[robot])
            states.write_text(json.dumps(given), "utf-8")
            for simulator in options.simulators:
                python, _, script = simulator.rpartition(":")
                out.unlink(missing_ok=True)
                line = [python, str(HERE / script), str(to), str(states), str(out)]
                run = subprocess.run(line, capture_output=True, text=True, cwd=folder)
                if not out.exists():
                    last = (run.stderr.strip() or "no output").splitlines()[-1]
                    print(f"{robot} {script}: {last}", flush=True)
                    continue
                found = json.loads(out.read_text("utf-8"))
                for line in compared(given, ours, found):
                    print(f"{robot} {found['version']}: {line}", flush=True)


if __name__ == "__main__":
    main()
