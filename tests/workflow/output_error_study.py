"""Bias, intervals and position errors of `--refine simulation` beside those of least squares.

    python tests/workflow/output_error_study.py --runs 20 --seed 500 --out FILE

Simulated arms with noise of 4 mrad in q, no tachometers, and 0.3 % of noise in the torque. 15 s are
identified; 10 s of another motion without noise are the held-out log.

The arm "stribeck" is "upright" with a Stribeck friction, whose speed in the robot file is wrong by
a factor from 0.6 to 1.6, noise of 0.4 mrad in q, and torques that are early by up to 4 ms. The logs
of the arm "loop" have no torques: they have the reference and the gains of a controller.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from oracles import planar2r
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
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
LINKS = {"ZZ1R": 1.65, "MX1R": 3.0, "MY1": 0.05, "ZZ2": 0.25, "MX2": 0.8, "MY2": 0.02}
SPEED = 0.2  # of the Stribeck friction, rad/s
STRIBECK = """
[[effect]]
name = "stribeck_friction"
joints = [1]
nonlinear = { vs = %r }
"""
LENGTH, KP, KD = 0.5, np.array([400.0, 150.0]), np.array([40.0, 12.0])
GAINS = f"[controller]\nkp = {KP.tolist()}\nkd = {KD.tolist()}\n"
ARMS = {
    "upright": (UPRIGHT, {**LINKS, **FRICTION}),
    "stribeck": (UPRIGHT, {**LINKS, **FRICTION, "FST1": 1.2}),
    "loop": (planar2r.robot_toml("loop", 'friction = ["viscous"]\nrotor_inertia = false') + GAINS,
             {"ZZ1R": 3.7, "ZZ2": 0.8, "MX2": 1.2, "MY2": 0.3, "FV1": 2.0, "FV2": 0.5}),
    "elbow": (ELBOW, {"ZZ1R": 1.2, "XX2R": -0.3, "XY2": 0.02, "XZ2": 0.01, "YZ2": -0.02,
                      "ZZ2": 0.4, "MX2": 1.0, "MY2": 0.1, "FV1": 2.0, "FS2": 0.6, "FV2": 0.5}),
}  # fmt: skip
NOISE, FINE, TORQUE_NOISE, RATE = 4e-3, 4e-4, 3e-3, 200.0
HELD = 999  # seed of the motion of held-out logs
QUANTILE = 1.96
KEPT = ("arm", "seed", "refined", "errors", "stds", "position", "delay_ms", "constant", "late_ms")


def recorded(arm: str, seed: int, late: float = 0.0) -> symgen.Log:
    """The log of an arm that follows a random motion, without noise if it is held out."""
    if arm == "loop":
        return followed(seed, 10.0 if seed == HELD else 15.0, 1e-5 if seed == HELD else NOISE)
    held, fine = seed == HELD, arm == "stribeck"
    made = symgen.Instruments(
        position_noise=0.0 if held else FINE if fine else NOISE, delay=late, velocity=False,
        torque_noise_relative=0.0 if held else TORQUE_NOISE,
    )  # fmt: skip
    return symgen.simulate(
        symgen.parse_robot(robot_file(arm), arm), ARMS[arm][1], seed=seed,
        recording=symgen.Recording(made, rate=RATE), duration=10.0 if held else 15.0,
    ).log(0)  # fmt: skip


def followed(seed: int, seconds: float, noise: float) -> symgen.Log:
    """The log of an arm that a controller moves: encoders and reference, no torques."""
    values = np.array([*ARMS["loop"][1].values()])
    t, qr, qdr, _ = (
        x[: int(RATE * seconds) + 2]
        for x in planar2r.harmonic_motion(np.random.default_rng(seed), seed % 8)
    )
    reference = CubicSpline(t, np.concatenate([qr, qdr], axis=1))

    def slope(at: float, x: np.ndarray) -> np.ndarray:
        (q, qd), (aim, speed) = np.split(x, 2), np.split(reference(at), 2)
        tau = KP * (aim - q) + KD * (speed - qd) - values[4:] * qd
        return np.concatenate([qd, planar2r.forward_dynamics(q, qd, tau, values[:4], LENGTH)])

    begin = np.concatenate([qr[0], qdr[0]])
    moved = solve_ivp(slope, (0, t[-1]), begin, "DOP853", t, rtol=1e-8, atol=1e-9).y
    q = moved[:2].T + noise * np.random.default_rng([seed, 1]).normal(size=qr.shape)
    return symgen.make_log(f"log {seed}", t, q, None, qr=qr, qdr=qdr)


def robot_file(arm: str, factor: float = 1.0) -> str:
    """The robot file of an arm, with a Stribeck speed that is wrong by a factor."""
    text, _ = ARMS[arm]
    return text + STRIBECK % (SPEED * factor) if arm == "stribeck" else text


def run(arm: str, seed: int) -> dict[str, Any]:
    """Identify a log by least squares, and refined; each value is that of both."""
    values, rng = ARMS[arm][1], np.random.default_rng([seed, 2])
    late, factor = rng.uniform(0, 4e-3), rng.uniform(0.6, 1.6)
    late = late if arm == "stribeck" else 0.0
    robot = symgen.parse_robot(robot_file(arm, factor), arm)
    train, held = (recorded(arm, k, late) for k in (seed, HELD))
    both = [symgen.identify(robot, train, validation=held, refine=r) for r in (None, "simulation")]
    return {
        "arm": arm,
        "seed": seed,
        "refined": both[1].method.endswith("simulation"),
        "errors": [[p.value - values[p.name] for p in e.parameters] for e in both],
        "stds": [[p.std for p in e.parameters] for e in both],
        "position": [[h.position_error for h in e.uses[2].horizons] for e in both],
        "delay_ms": [
            sum((1e3 * f.value for f in e.repairs if f.kind == "delay"), 1e3 * late) for e in both
        ],
        "late_ms": [
            1e3 * std
            for f in both[1].repairs
            for n, _, std in f.values
            if n == "DT" and np.isfinite(std)
        ],
        "constant": [[c.value - SPEED, c.std] for c in both[1].constants or ()],
    }


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """What is stated of the runs of one arm; pairs are of least squares and refined.

    Of delays and constants: for each that was fitted, whether its 95 % interval holds the truth.
    """
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
        "delays_held": [
            abs(r["delay_ms"][1]) < QUANTILE * std for r in rows for std in r["late_ms"]
        ],
        "constants_held": [abs(x) < QUANTILE * std for r in rows for x, std in r["constant"]],
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
