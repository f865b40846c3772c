"""How long `symgen diagnose` takes for a 7-joint arm that was recorded at 1 kHz.

    python tests/benchmarks/bench_diagnose.py [--seconds 60] [--runs 3] [--beside CHECKOUT]

The logs are those of `symgen demo` at 1 kHz: the arm has a spring that robot.toml lacks. A third as
many seconds are for validation, of another motion. The command runs once before it is
timed, so that caches are warm. With --beside, another checkout runs in turn. `cpu` is the time of
the processors, which other work on the machine changes less than that of the clock.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import symgen
from symgen.cli import demonstration
from symgen.identification.parameters import base_values

HERE = Path(__file__).resolve().parents[2]


def write_logs(folder: Path, seconds: float) -> list[str]:
    """Write the robot file and two logs; return the arguments of the command."""
    arm = symgen.parse_robot(demonstration.FILE + demonstration.SPRING)
    X = base_values(demonstration.true_parameters(), symgen.derive(arm), "arm")
    seen = symgen.Instruments(encoder_step=2e-5, torque_noise=0.3)
    made = symgen.Recording(seen, rate=1000.0)
    for name, seed, duration in (("train.csv", 11, seconds), ("test.csv", 12, seconds / 3)):
        run = symgen.simulate(arm, X, duration=duration, seed=seed, recording=made)
        (folder / name).write_bytes(run.file())
    (folder / "robot.toml").write_text(demonstration.FILE, "utf-8")
    return ["robot.toml", "train.csv", "--validation", "test.csv"]


def timed(checkout: Path, folder: Path, arguments: list[str]) -> tuple[float, float]:
    """Return seconds of the clock and of the processors of one run of a checkout."""
    command = [sys.executable, "-m", "symgen", "diagnose", *arguments, "--into", "result"]
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OPENBLAS_NUM_THREADS": "1"}
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=False)
    clock, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Time the command, in turn with that of another checkout."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--beside", type=Path)
    given = parser.parse_args()
    checkouts = [HERE, *([given.beside.resolve()] if given.beside else [])]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        arguments = write_logs(folder, given.seconds)
        for checkout in checkouts:
            timed(checkout, folder, arguments)
        for _ in range(given.runs):
            for checkout in checkouts:
                clock, cpu = timed(checkout, folder, arguments)
                print(f"{checkout.name}: {clock:.1f} s, cpu {cpu:.1f} s", flush=True)


if __name__ == "__main__":
    main()
