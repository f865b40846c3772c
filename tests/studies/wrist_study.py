"""How precise is the load of a tool by its wrist sensor? Simulated logs of a UR-like arm.

Each log has a tool of 0.5 to 3 kg, twelve poses and a motion in 60 s at 500 Hz, noise of 0.5 N and
0.02 N m, an offset, and a drift of the offset. The study prints the errors of mass and centre, how
many 95 % intervals contain the true value, and the force that remains of the compensated sensor in
30 other poses, below 2 Hz.

    python tests/studies/wrist_study.py --runs 100 --drift linear
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfiltfilt

sys.path.insert(0, str(Path(__file__).parents[1]))
from oracles import wrist

import symgen
from symgen.identification.load import LABELS

POSES = 30


def shape(kind: str, count: int, rng: np.random.Generator) -> np.ndarray:
    """The drift of each channel over a log, (N, 6): its RMS change is that of the noise."""
    s = np.linspace(-1, 0, count)[:, None]
    size = wrist.NOISE * rng.normal(size=6)
    if kind == "none":
        return 0 * s * size
    if kind == "linear":
        return s * size
    if kind == "warming":  # e-fold in a third of the log
        return (np.exp(-3 * (1 + s)) - np.exp(-3)) * -size
    steps = rng.normal(size=(count, 6)) * wrist.NOISE / np.sqrt(count)
    walk = np.cumsum(steps, axis=0)
    return walk - walk[-1]


def run(seed: int, kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """True and estimated values, their standard deviations, and the remaining force, N."""
    rng = np.random.default_rng(seed)
    points = wrist.tool(rng.uniform(0.5, 3.0), seed)
    data, offset = wrist.recorded(points, seed)
    data["wrench"] = data["wrench"] + shape(kind, len(data["t"]), rng)
    robot = symgen.parse_robot(wrist.ROBOT)
    log = symgen.make_log(f"log {seed}", data["t"], data["q"], None, wrench=data["wrench"])
    found = symgen.payload(robot, log, sensor=True)
    values, std = (
        np.array([np.nan if x is None else x for x in row])
        for row in zip(*((q.value, q.std) for _, q, _ in found.rows()), strict=True)
    )
    return points.quantities, values, std, remaining(robot, found, points, seed, offset)


def remaining(
    robot: symgen.Robot, found: symgen.Payload, points: wrist.Points, seed: int, offset: np.ndarray
) -> float:
    """RMS of the compensated force below 2 Hz, over rests in other poses right after the log."""
    data, _ = wrist.recorded(points, 50_000 + seed, offset=offset, poses=POSES, swing=0.0)
    tool = symgen.load(symgen.derive(robot, ("tool_wrench",)))["tool_wrench"]
    still = np.zeros_like(data["q"])
    shift = [q.value for q in found.sensor.offset]
    left = data["wrench"] - tool(data["q"], still, still, found.sensor.load, shift)
    smooth = sosfiltfilt(butter(2, 2.0, fs=500, output="sos"), left[:, :3], axis=0)
    phase = np.mod(data["t"], 3.5)
    return float(np.sqrt(np.mean(np.sum(smooth[(phase > 0.5) & (phase < 1.5)] ** 2, axis=1))))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--runs", type=int, default=100)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--drift", default="linear", help="none, linear, warming or walk (random)")
    chosen = options.parse_args()
    seeds = range(chosen.first, chosen.first + chosen.runs)
    true, values, std, left = map(
        np.array, zip(*(run(k, chosen.drift) for k in seeds), strict=True)
    )
    error = values - true
    mass, com = np.abs(error[:, 0]), np.linalg.norm(error[:, 1:4], axis=1)
    allowed = np.maximum(0.003 * true[:, 0], 0.003)
    print(f"{chosen.runs} logs, drift: {chosen.drift}")
    print(f"mass error: largest {1e3 * mass.max():.2f} g, {(mass / allowed).max():.2f} of allowed")
    print(f"centre of mass error: largest {1e3 * com.max():.3f} mm")
    known = np.isfinite(values)
    inside = np.abs(error) <= 1.96 * std
    for k, name in enumerate(LABELS):
        share = inside[known[:, k], k].mean()
        print(f"  {name:>4}: {100 * share:5.1f} % of 95 % intervals; open {(~known[:, k]).sum()}")
    print(f"all: {100 * inside[known].mean():.1f} % of {known.sum()} intervals")
    print(f"remaining force: RMS {np.sqrt(np.mean(left**2)):.4f} N, largest {left.max():.4f} N")


if __name__ == "__main__":
    main()
