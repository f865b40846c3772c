"""Intervals of payloads over many runs, by `pytest -s -m slow` on this file.

SYMGEN_RUNS sets their number.
"""

from __future__ import annotations

import json
import math
import os

import numpy as np
import pytest
from workflow.test_payload import (
    FS,
    FV,
    LINKS,
    MASS,
    TABLE,
    TRUE,
    N,
    parameters,
    quantities,
    recorded,
    robot,
)

import symgen
from symgen.identification.load_result import LABELS

__all__ = ["parameters", "robot"]  # fixtures


@pytest.mark.slow
@pytest.mark.parametrize("way", ["against parameters", "beside logs without it"])
def test_intervals_over_300_runs(robot, parameters, tmp_path, way) -> None:
    runs = int(os.environ.get("SYMGEN_RUNS", "300"))
    inside, mass = _coverage(robot, parameters, tmp_path, runs, way)
    shares = inside.mean(axis=0)
    print(way, dict(zip(LABELS, np.round(100 * shares, 1), strict=True)), "%")
    print("worst error of the mass:", f"{100 * np.abs(mass / MASS - 1).max():.2f} %")
    assert (np.abs(mass / MASS - 1) < 0.015).all()
    assert 0.92 <= shares.mean() <= 0.98
    # Each of the ten within 92 to 98 %, beside what chance does to counts of so many runs.
    beside = [1.96 * math.sqrt(p * (1 - p) / runs) for p in (0.92, 0.98)]
    assert (shares > 0.92 - beside[0]).all(), shares
    assert (shares < 0.98 + beside[1]).all(), shares


def _coverage(robot, parameters, folder, runs: int, way: str):
    """Of every run whether intervals hold the truth, (runs, 10), and the mass.

    Given parameters err in every run as their covariance says: about the truth, which an estimate
    without noise in its logs has.
    """
    estimate = json.loads(parameters.read_text())
    std = np.array([p["std"] for p in estimate["parameters"]])
    factor = np.linalg.cholesky(np.array(estimate["correlation"]) * np.outer(std, std))
    truth = _truth(robot)
    inside, mass = [], []
    for k in range(runs):
        known: dict[str, object] = {"without": [recorded(5000 + k, False, k % 7)]}
        if way == "against parameters":
            drawn = truth + factor @ np.random.default_rng(9000 + k).standard_normal(len(std))
            for p, x in zip(estimate["parameters"], drawn, strict=True):
                p["value"] = float(x)
            (folder / "drawn.json").write_text(json.dumps(estimate))
            known = {"parameters": folder / "drawn.json"}
        found = symgen.payload(robot, recorded(1000 + k, True, k % 7), **known)
        values, deviation = quantities(found)
        inside.append(np.abs(values - TRUE) <= 1.96 * deviation)
        mass.append(values[0])
    return np.array(inside), np.array(mass)


def _truth(robot) -> np.ndarray:
    """The arm's base parameters: least squares of Pinocchio's torques in random states."""
    from oracles.pinocchio_arm import PinocchioArm
    from oracles.transforms import Arm

    model = symgen.derive(robot, ("torque_regressor",))
    arm = PinocchioArm(Arm.from_table(TABLE), LINKS)
    q, qd, qdd = np.random.default_rng(7).uniform(-2, 2, (3, 400, N))
    tau = np.array([arm.inverse_dynamics(*x) for x in zip(q, qd, qdd, strict=True)])
    tau += FS * np.sign(qd) + FV * qd
    W = symgen.load(model)["torque_regressor"](q, qd, qdd)
    return np.linalg.lstsq(W.reshape(400 * N, -1), tau.ravel(), rcond=None)[0]
