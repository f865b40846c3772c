"""Bias, intervals and position errors of `--refine simulation` beside those of least squares.

    python tests/workflow/output_error_study.py --runs 20 --seed 500 --out FILE

Simulated arms with noise of 4 mrad in q, no tachometers, and 0.3 % of noise in the torque. 15 s are
identified; 10 s of another motion without noise are the held-out log.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support import figures_text

import symgen

#: An arm in a vertical plane, and one with a vertical first axis.
UPRIGHT = """
[robot]
name = "upright"
gravity = [0.0, 0.0, -9.81]
[[joint]]
alpha = 1.5707963267948966
friction = ["coulomb", "viscous"]
rotor_inertia = false
[[joint]]
d = 0.5
friction = ["coulomb", "viscous"]
rotor_inertia = false
"""
ELBOW = """
[robot]
name = "elbow"
gravity = [0.0, 0.0, -9.81]
[[joint]]
friction = ["viscous"]
rotor_inertia = false
[[joint]]
alpha = 1.5707963267948966
friction = ["coulomb", "viscous"]
rotor_inertia = false
"""
FRICTION = {"FS1": 1.5, "FV1": 2.0, "FS2": 0.6, "FV2": 0.5}
ARMS = {
    "upright": (UPRIGHT, {"ZZ1R": 1.65, "MX1R": 3.0, "MY1": 0.05, "ZZ2": 0.25, "MX2": 0.8,
                          "MY2": 0.02, **FRICTION}),
    "elbow": (ELBOW, {"ZZ1R": 1.2, "XX2R": -0.3, "XY2": 0.02, "XZ2": 0.01, "YZ2": -0.02,
                      "ZZ2": 0.4, "MX2": 1.0, "MY2": 0.1, "FV1": 2.0, "FS2": 0.6, "FV2": 0.5}),
}  # fmt: skip
NOISE, TORQUE_NOISE, RATE = 4e-3, 3e-3, 200.0
QUANTILE = 1.96
KEPT = ("arm", "seed", "refined", "errors", "stds", "position", "delay_ms")


def recorded(arm: str, seed: int, noise: float, torque: float, seconds: float) -> symgen.Log:
    """The log of an arm that follows a random motion."""
    robot, values = ARMS[arm]
    made = symgen.Instruments(position_noise=noise, torque_noise_relative=torque, velocity=False)
    return symgen.simulate(
        symgen.parse_robot(robot, arm), values, recording=symgen.Recording(made, rate=RATE),
        duration=seconds, seed=seed,
    ).log(0)  # fmt: skip


def run(arm: str, seed: int) -> dict[str, Any]:
    """Identify a log by least squares, and refined; each value is that of both."""
    robot, values = ARMS[arm]
    train, held = recorded(arm, seed, NOISE, TORQUE_NOISE, 15.0), recorded(arm, 999, 0, 0, 10.0)
    both = [
        symgen.identify(symgen.parse_robot(robot, arm), train, validation=held, refine=refine)
        for refine in (None, "simulation")
    ]
    return {
        "arm": arm,
        "seed": seed,
        "refined": both[1].method.endswith("simulation"),
        "errors": [[p.value - values[p.name] for p in e.parameters] for e in both],
        "stds": [[p.std for p in e.parameters] for e in both],
        "position": [[h.position_error for h in e.uses[2].horizons] for e in both],
        "delay_ms": [sum(1e3 * f.value for f in e.repairs if f.kind == "delay") for e in both],
    }


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """What is stated of the runs of one arm; pairs are of least squares and refined."""
    errors, stds = (np.array([r[key] for r in rows]) for key in ("errors", "stds"))
    bias = np.abs(errors.mean(axis=0))
    late = np.array([r["delay_ms"] for r in rows])
    sure = bias[0] > 4 * errors[:, 0].std(axis=0, ddof=1) / np.sqrt(len(rows))
    position, square = np.array([r["position"] for r in rows]), np.mean(errors**2, axis=0)
    return {
        "runs": len(rows),
        "refined": sum(r["refined"] for r in rows),
        "biased": int(sure.sum()),
        "bias_left": (bias[1] / bias[0])[sure].tolist(),
        "error_left": np.sqrt(square[1] / square[0]).tolist(),
        "held": np.mean(np.abs(errors) < QUANTILE * stds, axis=(0, 2)).tolist(),
        "position": np.sqrt(np.mean(position**2, axis=0)).tolist(),
        "ratio_median": np.median(position[:, 1] / position[:, 0], axis=0).tolist(),
        "ratio_largest": np.max(position[:, 1] / position[:, 0], axis=0).tolist(),
        "delay_rms_ms": np.sqrt(np.mean(late**2, axis=0)).tolist(),
    }  # fmt: skip


def main() -> None:
    """Print a summary of each arm, and write the runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=500)
    parser.add_argument("--arms", nargs="+", choices=ARMS, default=[*ARMS])
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    rows, head = [], {"seed": given.seed, "summary": {}}
    for arm in given.arms:
        own = []
        for seed in range(given.seed, given.seed + given.runs):
            own.append(run(arm, seed))
            print(arm, seed, own[-1]["refined"], own[-1]["position"], flush=True)
        head["summary"][arm] = summary(own)
        print(arm, head["summary"][arm], flush=True)
        rows += own
        if given.out:
            given.out.write_text(figures_text(head, rows, KEPT), "utf-8")


if __name__ == "__main__":
    main()
