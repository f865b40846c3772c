"""Constants that a search would move to where the logs tell them no more: there is a report."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.arm import save_planar2r
from support import sampled

import symgen

HIDDEN = {
    "quadratic drag": lambda _, qd: -0.4 * qd * np.abs(qd),
    "spring": lambda q, _: -3 * (q - 0.1),
    "power of speed": lambda _, qd: -0.3 * np.sign(qd) * np.abs(qd) ** 1.15,
    "root": lambda q, _: -4 * np.sqrt(np.maximum(q + 1.3, 0)),
    "ripple": lambda q, _: 0.8 * np.sin(7.3 * q),
}
# The hidden torque is the limit of the effect as v or w grows, or close to it.
LIMITS = [
    ("quadratic drag", "-F*tanh(qd1/v)", "v = [0.0001, 50]", "v"),
    ("power of speed", "-F*tanh(qd1/v)", "v = [0.0001, 50]", "v"),
    ("power of speed", "-F*sign(qd1)*exp(-(qd1/v)**2)", "v = [0.1, 50]", "v"),
    ("spring", "-F*(q1-c)*exp(-((q1-c)/w)**2)", "c = [-5, 5], w = [0.06, 40]", "w"),
]
# G is viscous friction once more, which no log tells from it; the root is not finite beyond the
# positions of these logs.
REFUSED = {
    "a combination of the model's other columns": (
        *("ripple", "-F*sin(k*q1) - G*qd1", 'F = "N m", G = ""', "k = [6, 9]"),
    ),
    "not a finite number": ("root", "-F*sqrt(q1-c)", 'F = "N m"', "c = [-8, -1.7]"),
}


def _diagnosed(command, folder: Path, hidden: str, torque: str, linear: str, ranges: str) -> dict:
    """Return diagnosis.json of the command line on logs with a hidden torque."""
    plain = symgen.read_robot("planar2r")
    friction = ("viscous",) if hidden == "ripple" else ()
    joints = tuple(replace(joint, friction=friction) for joint in plain.joints)
    text = symgen.robot_toml(replace(plain, joints=joints))
    effect = (
        f'\n[[effect]]\nname = "own"\njoints = [1]\ntorque = "{torque}"\n'
        f"linear = {{ {linear} }}\nnonlinear = {{ {ranges} }}\n"
    )
    robot = folder / "robot.toml"
    robot.write_text(text + effect)
    rubbing = 0.2 if hidden == "ripple" else 0.0

    def more(q: np.ndarray, qd: np.ndarray, _: np.ndarray) -> np.ndarray:
        return rubbing * qd - np.outer(HIDDEN[hidden](q[:, 0], qd[:, 0]), [1, 0])

    paths = folder / "train.npz", folder / "test.npz"
    train, test = (save_planar2r(path, seed, more) for seed, path in enumerate(paths, 1))
    into = folder / "out"
    code, out, err = command(
        "diagnose", robot, train, "--validation", test, "--effects", "own", "--into", into
    )
    assert code in (0, 1), err
    assert (into / "report.html").exists()
    assert (into / "robot.toml").exists()
    found = json.loads((into / "diagnosis.json").read_text())
    assert found["verdict"] in out
    return found


@pytest.mark.parametrize(("hidden", "torque", "ranges", "moving"), sampled(LIMITS, 2))
def test_a_constant_stays_where_the_logs_determine_the_model(
    command, tmp_path: Path, hidden: str, torque: str, ranges: str, moving: str
) -> None:
    found = _diagnosed(command, tmp_path, hidden, torque, 'F = "N m"', ranges)
    (effect,) = found["effects"]
    values = {p["name"]: p for p in effect["parameters"]}
    if effect["adopted"]:  # else the constant is not known within its range
        assert math.isfinite(values[moving]["value"])
        assert math.isfinite(values[moving]["std"])
    symgen.derive(symgen.read_robot(tmp_path / "out" / "robot.toml"), ())


@pytest.mark.parametrize("why", sampled(REFUSED, 1))
def test_an_effect_with_which_there_is_no_model_is_rejected_in_a_report(
    command, tmp_path: Path, why: str
) -> None:
    found = _diagnosed(command, tmp_path, *REFUSED[why])
    assert found["effects"] == []
    (rejected,) = [r for r in found["rejected"] if r["name"] == "own"]
    assert "the model with it cannot be identified" in json.dumps(rejected)
    assert why in json.dumps(rejected)
