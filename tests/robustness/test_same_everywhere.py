"""Same input, same bytes and same numbers, whatever the hash seed and the process."""

from __future__ import annotations

import os
import subprocess
import sys

from support import PROJECT

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

# Digests of all files, .casadi among them, of the estimate from a seeded log, and of the robot.
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
    assert '"rich_energy.casadi"' in first
    assert '"rich.tex"' in first
    assert first == second
