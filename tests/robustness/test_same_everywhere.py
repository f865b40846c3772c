"""Same bytes, whatever hash seed and process; same numbers, whatever compiler and threads.

pytest -s -m slow tests/robustness/test_same_everywhere.py
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support import PROJECT
from support_commands import PARAMETERS

#: Everything that has an order: named lengths times roots, a tree, a coupling, effects, a payload.
ROBOT = """
[robot]
name = "rich"
gravity = [0.0, "fall/2", "-fall"]
[geometry]
L2 = 0.4
L1 = 0.3
fall = 9.81
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
sigma = 1
gamma = 0.3
d = "sqrt(2)*L1/2 + L2"
[[joint]]
antecedent = 1
d = "sqrt(3)*L2/3"
alpha = "pi/2"
[[coupling]]
joints = [1, 3]
ratio = "-1/3"
[payload]
joint = 3
[[effect]]
name = "hose"
joints = [1]
torque = "-A*tanh((q1-c)/w) - B*q3"
linear = { B = "N m/rad", A = "N m" }
nonlinear = { w = 0.5, c = 0.2 }
"""

# Digests of all files, of the estimate from a seeded log, and of the robot.
DIGESTS = """
import hashlib, json, sys
import numpy as np
import symgen
robot = symgen.parse_robot(sys.stdin.read())
model = symgen.derive(robot, "all")
files = dict(symgen.generate(model, tex=True).files)
files["robot"] = symgen.robot_toml(robot).encode()
draw = np.random.default_rng(3)
t = np.arange(0, 4, 0.004)
w = np.array([[2.1, 3.3, 4.7], [5.9, 7.1, 8.3]])
q = sum(a * np.sin(v * t[:, None] + np.arange(3)) for a, v in zip((0.8, 0.3), w, strict=True))
log = symgen.make_log("log", t, q, draw.normal(size=q.shape))
estimate = symgen.identify(robot, [log])
files["estimate"] = json.dumps(estimate.to_json()).encode()
print(json.dumps({k: hashlib.sha256(v).hexdigest() for k, v in files.items()}))
"""


@pytest.mark.slow
def test_bytes_and_estimates_are_the_same_across_hash_seeds_and_processes():
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    answers = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", DIGESTS],
            input=ROBOT,
            capture_output=True,
            text=True,
            env={**environment, "PYTHONHASHSEED": seed},
        )
        for seed in ("0", "4242")
    ]
    assert [a.returncode for a in answers] == [0, 0], answers[0].stderr
    first, second = (a.stdout for a in answers)
    assert '"rich_casadi.py"' in first
    assert '"rich.tex"' in first
    assert first == second


#: Compiler ("" for the machine's), and threads of the linear algebra.
MACHINES = [("", "1"), ("", "2"), ("gcc", "1"), ("clang", "1")]
COMMANDS = {
    "est": "identify planar2r log.csv --into est",
    "prediction": "predict planar2r log.csv --parameters p.toml --into prediction",
    "diagnosis": "diagnose planar2r log.csv --into diagnosis",
}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A simulated log with noise, as CSV."""
    folder = tmp_path_factory.mktemp("log")
    (folder / "p.toml").write_text(PARAMETERS)
    options = "--duration 4 --rate 250 --torque-noise-percent 2 --position-noise 1e-5"
    _run(folder, f"simulate planar2r --parameters p.toml {options} --into log.csv", {})
    return (folder / "log.csv").read_bytes()


@pytest.fixture(scope="module")
def first(log: bytes, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the commands write where there is no compiler: CasADi computes."""
    return _written(log, tmp_path_factory.mktemp("first"), {"SYMGEN_CC": "none"})


def _run(folder: Path, words: str, change: dict[str, str]) -> None:
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), **change}
    done = subprocess.run(
        [sys.executable, "-m", "symgen", *words.split()],
        cwd=folder, capture_output=True, text=True, env=environment,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr


def _written(log: bytes, folder: Path, change: dict[str, str]) -> Any:
    (folder / "log.csv").write_bytes(log)
    (folder / "p.toml").write_text(PARAMETERS)
    out = {}
    for kind, words in COMMANDS.items():
        _run(folder, words, change)
        (file,) = (folder / kind).glob("*.json")
        out[kind] = json.loads(file.read_text("utf-8"))
    return out


#: What names the machine, and digests of files with every digit of a number: of bytes, not values.
NOT_VALUES = ("backend", "digests")


def _apart(a: Any, b: Any, where: str = "") -> Iterator[str]:
    """Yield the places at which two contents differ; numbers, by more than 1e-8 of their size.

    What is simulated may differ by the tolerance of the integrator, whose steps are not the same.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted({*a, *b} - {*NOT_VALUES}):
            yield from _apart(a.get(key), b.get(key), f"{where}.{key}")
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _apart(x, y, f"{where}[{k}]")
    elif isinstance(a, float) and isinstance(b, float):
        close = 1e-6 if ".simulation." in where else 1e-8
        if not math.isclose(a, b, rel_tol=close, abs_tol=1e-12):
            yield f"{where}: {a!r} and {b!r}"
    elif a != b:
        yield f"{where}: {a!r} and {b!r}"


def test_numbers_apart_are_seen():
    assert list(_apart({"a": [1.0, {"b": 2.0}]}, {"a": [1.0 + 1e-10, {"b": 2.0}]})) == []
    assert list(_apart({"a": [1.0, {"b": 2.0}]}, {"a": [1.0, {"b": 2.0 + 1e-6}]})) == [
        ".a[1].b: 2.0 and 2.000001"
    ]
    assert len(list(_apart({"a": [1.0], "c": "x"}, {"a": [1.0, 2.0], "c": "y"}))) == 2


@pytest.mark.slow
@pytest.mark.parametrize(("cc", "threads"), MACHINES)
def test_results_are_the_same_numbers_whatever_compiler_and_threads(
    log, first, cc, threads, tmp_path
):
    if shutil.which(cc or "cc") is None:
        pytest.skip(f"{cc or 'cc'} is not on this machine")
    change = {"OPENBLAS_NUM_THREADS": threads, "SYMGEN_CACHE": str(tmp_path / "cache")}
    found = _written(log, tmp_path, change | ({"SYMGEN_CC": cc} if cc else {}))
    assert list(_apart(first, found)) == []
