"""Arms with voltage servos in MuJoCo: errors and intervals of what their duty tells.

    python tests/studies/servo_study.py --seeds 20 --rate 200

Each case is an arm of random masses and drives, two training logs, one log that carries a known
mass, and a later log with another load. The tables have the largest and the RMS error of each kind
of number, and the share of true values inside the interval of 1.96 standard deviations.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracles import servos

import symgen
from symgen.identification.parameters import read_parameters

#: Mass of the known load, and of the later one, as parts of that of the last link; its place.
KNOWN, LATER = 1.0, 0.7


def truths(arm: servos.Arm) -> Iterator[tuple[str, str, float]]:
    """Yield kind, name of the parameter and true value of friction and rotor inertia."""
    for j in range(arm.n):
        yield "b + FV", f"FV{j + 1}", arm.b[j] + arm.viscous[j]
        yield "FS", f"FS{j + 1}", arm.coulomb[j]
        yield "rotor inertia", f"IA{j + 1}", arm.rotor[j]


def case(kind: str, seed: int, rate: float) -> Iterator[tuple[str, float, float, float, float]]:
    """Yield kind, value, deviation, true value, and size for errors, of the numbers of an arm."""
    rng = np.random.default_rng([seed, servos.ARMS.index(kind)])
    arm = servos.random_arm(kind, rng)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "arm.xml"
        file.write_text(servos.mjcf(arm))
        robot = replace(symgen.read_robot(file), payload=arm.n)
        true = read_parameters(file, symgen.derive(robot))
        place = 1.2 * arm.centre[-1] + [0.01, 0.01, 0.01]
        masses = float(KNOWN * arm.mass[-1]), float(LATER * arm.mass[-1])
        train = [servos.recorded(arm, f"train{k}", rng, 60.0, rate) for k in range(2)]
        test = servos.recorded(arm, "test", rng, 30.0, rate)
        carried = servos.recorded(arm, "carried", rng, 60.0, rate, (masses[0], place))
        later = servos.recorded(arm, "later", rng, 40.0, rate, (masses[1], place))
        fit = symgen.FitOptions(carried=[carried], mass=masses[0])
        estimate = symgen.identify(robot, train, validation=[test], fit=fit)
        symgen.write(estimate, Path(folder) / "known", robot=robot)
        load = symgen.payload(robot, later, parameters=Path(folder) / "known")
    for j, drive in enumerate(estimate.drives):
        stall = arm.a[j] - arm.coulomb[j]
        yield "a", drive.torque, drive.std, arm.a[j], arm.a[j]
        yield "stall torque", drive.stall, drive.stall_std, stall, stall
        speed = stall / (arm.b[j] + arm.viscous[j])
        yield "no-load speed", drive.no_load, drive.no_load_std, speed, speed
    named = {p.name: p for p in estimate.parameters}
    for what, name, value in truths(arm):
        if name in named:
            yield what, named[name].value, named[name].std, value, value
    moments = [x for p, x in zip(estimate.parameters, true, strict=True) if p.name.startswith("M")]
    largest = float(np.abs(moments).max())
    for p, value in zip(estimate.parameters, true, strict=True):
        if p.name.startswith("M"):
            yield "first moment", p.value, p.std, float(value), largest
    if load.mass.value is not None and load.mass.std is not None:
        yield "payload", load.mass.value, load.mass.std, masses[1], masses[1]


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--rate", type=float, default=200.0)
    parser.add_argument("--arms", nargs="*", default=servos.ARMS)
    args = parser.parse_args()
    found: dict[str, list[tuple[float, bool]]] = defaultdict(list)
    for kind in args.arms:
        for seed in range(args.seeds):
            for what, value, std, true, size in case(kind, seed, args.rate):
                inside = abs(value - true) <= 1.96 * std
                found[what].append((abs(value - true) / size, inside))
            print(kind, seed, flush=True)
    print("number            count  median %  95 % below   largest  inside %")
    for what, rows in found.items():
        errors = 100 * np.array([error for error, _ in rows])
        inside = 100 * np.mean([x for _, x in rows])
        middle, most = np.quantile(errors, [0.5, 0.95])
        print(
            f"{what:16} {len(rows):6} {middle:9.3g} {most:11.3g} {errors.max():9.3g} {inside:9.1f}"
        )


if __name__ == "__main__":
    main()
