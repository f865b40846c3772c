"""How long identify takes for a million samples of a 7R arm, and how much memory.

    python tests/benchmarks/bench_million.py [--samples 1000000] [--models momentum torque]

The log (Panda, 1 kHz, measured speeds, .npz) is made by NumPy with torques of the emitted
torque_regressor. Each model is identified in a process of its own, from start to estimate, the
model compiled before; its peak of resident memory is that of the process.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

MODELS = ("energy", "momentum", "torque", "auto")
RATE = 1000.0
CHUNK = 50_000
SHORT = 20_000  # samples of the log on which the model is compiled
ROBOT = "panda"


def make_log(path: Path, samples: int, seed: int = 0) -> None:
    """Write a log of sines up to 0.6 Hz: encoders of 2e-5 rad, 2 mrad/s, 1 % noise of torque."""
    import symgen

    robot = symgen.read_robot(ROBOT)
    model = symgen.derive(robot, ("torque_regressor",))
    kernel, n, p = symgen.load(model)["torque_regressor"], len(robot.movable), len(model.base.names)
    rng = np.random.default_rng(seed)
    # Positive definite for sure: every base parameter about 1, inertias of 5 on the diagonal.
    X = np.array([0.3 + rng.random() + 5 * name.startswith("ZZ") for name in model.base.names])
    w = 2 * np.pi * rng.uniform(0.05, 0.6, (6, n))
    a, phase = rng.uniform(0.1, 0.4, (6, n)), rng.uniform(0, 2 * np.pi, (6, n))
    t = np.arange(samples) / RATE
    q, qd, tau = (np.empty((samples, n)) for _ in range(3))
    for begin in range(0, samples, CHUNK):
        part = slice(begin, begin + CHUNK)
        angle = t[part, None, None] * w + phase
        q[part], qd[part] = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1)
        qdd = (-a * w**2 * np.sin(angle)).sum(1)
        tau[part] = np.asarray(kernel(q[part], qd[part], qdd)).reshape(-1, n, p) @ X
    q = np.round(q / 2e-5) * 2e-5
    qd += 2e-3 * rng.normal(size=qd.shape)
    tau += 0.01 * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
    np.savez(path, t=t, q=q, qd=qd, tau=tau)


def one(path: Path, model: str) -> None:
    """Identify once in this process; print seconds, peak memory and what came out, as JSON."""
    import symgen

    begin = time.perf_counter()
    estimate = symgen.identify(ROBOT, [path], model=model)
    seconds = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2  # from kB
    content = estimate.to_json()
    content = json.loads(content) if isinstance(content, str) else content
    said = content["torque_residual"]["validation"]["relative"]
    print(json.dumps({"s": seconds, "GB": peak, "said": said, "verdict": content["verdict"]}))


def main() -> int:
    """Make the log, run each model, print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--models", nargs="+", default=MODELS)
    parser.add_argument("--make", nargs=2, metavar=("LOG", "SAMPLES"), help=argparse.SUPPRESS)
    parser.add_argument("--one", nargs=2, metavar=("LOG", "MODEL"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.make:
        make_log(Path(options.make[0]), int(options.make[1]))
        return 0
    if options.one:
        one(Path(options.one[0]), options.one[1])
        return 0
    table = Table(title=f"identify, {ROBOT}, {options.samples:,} samples at 1 kHz")
    for heading in ("model", "s", "peak GB", "torque residual said", "verdict"):
        table.add_column(heading, justify="right")
    here = Path(__file__).resolve()
    with tempfile.TemporaryDirectory() as folder:
        # Made in processes of their own: a child's peak begins with what its parent holds.
        long, short = (Path(folder) / name for name in ("million.npz", "short.npz"))
        for path, samples in ((short, SHORT), (long, options.samples)):
            command = [sys.executable, here, "--make", path, str(samples)]
            subprocess.run(command, check=True)
        for model in options.models:
            for log in (short, long):  # the first compiles
                done = subprocess.run(
                    [sys.executable, here, "--one", log, model], capture_output=True, text=True
                )
            if done.returncode:
                table.add_row(model, "-", "-", "-", done.stderr.strip().splitlines()[-1])
                continue
            row = json.loads(done.stdout.splitlines()[-1])
            table.add_row(
                model,
                f"{row['s']:.1f}",
                f"{row['GB']:.2f}",
                f"{100 * row['said']:.3g} %",
                row["verdict"],
            )
    Console().print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
