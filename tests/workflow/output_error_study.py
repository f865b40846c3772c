"""Bias, spread and intervals of `--refine simulation` beside those of least squares.

python tests/workflow/output_error_study.py --runs 12
"""

from __future__ import annotations

import argparse

import numpy as np
from test_output_error import NOISE, UPRIGHT

import symgen

VALUES = {"ZZ1R": 1.65, "MX1R": 3.0, "MY1": 0.05, "ZZ2": 0.25, "MX2": 0.8, "MY2": 0.02,
          "FS1": 1.5, "FV1": 2.0, "FS2": 0.6, "FV2": 0.5}  # fmt: skip
QUANTILE = 1.96


def recording(noise: float, torque: float) -> symgen.Recording:
    """Encoders with noise in rad, no tachometers, torques with relative noise."""
    made = symgen.Instruments(position_noise=noise, torque_noise_relative=torque, velocity=False)
    return symgen.Recording(made, rate=200.0)


def main() -> None:
    """Print a table of the parameters, and the ratio of position errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", type=float, default=NOISE)
    parser.add_argument("--torque-noise", type=float, default=0.003)
    given = parser.parse_args()
    robot = symgen.parse_robot(UPRIGHT, "upright")
    held = symgen.simulate(robot, VALUES, recording=recording(0, 0), duration=10.0, seed=999).log(0)
    found: dict[str | None, list[symgen.Estimate]] = {None: [], "simulation": []}
    for seed in range(given.seed, given.seed + given.runs):
        made = recording(given.noise, given.torque_noise)
        train = symgen.simulate(robot, VALUES, recording=made, duration=15.0, seed=seed).log(0)
        for refine, estimates in found.items():
            estimates.append(symgen.identify(robot, train, validation=held, refine=refine))
    names = [p.name for p in found[None][0].parameters]
    true = np.array([VALUES[name] for name in names])
    X, std = ({key: np.array([[getattr(p, what) for p in e.parameters] for e in estimates])
               for key, estimates in found.items()} for what in ("value", "std"))  # fmt: skip
    print("parameter, then bias, spread and intervals that hold: least squares, refined")
    for k, name in enumerate(names):
        row = [name]
        for key in found:
            error = X[key][:, k] - true[k]
            held_by = np.mean(np.abs(error) < QUANTILE * std[key][:, k])
            row.append(f"{error.mean():.2g} {error.std(ddof=1):.2g} {held_by:.2f}")
        print(", ".join(row))
    errors = {key: np.array([[h.position_error for h in e.uses[2].horizons] for e in estimates])
              for key, estimates in found.items()}  # fmt: skip
    ratio = errors["simulation"] / errors[None]
    kept = sum(e.method.endswith("simulation") for e in found["simulation"])
    print(f"refined is kept in {kept} of {given.runs}; position error over that of least squares, "
          f"median by horizon: {np.round(np.median(ratio, axis=0), 2)}, "
          f"largest: {np.round(ratio.max(axis=0), 2)}")  # fmt: skip
    share = [np.mean(np.abs(X[key] - true) < QUANTILE * std[key]) for key in found]
    print(f"intervals that hold: {share[0]:.3f}, {share[1]:.3f}")


if __name__ == "__main__":
    main()
