"""How long identify takes for millions of samples of a 7R arm, and how much memory.

    python tests/benchmarks/bench_million.py [--samples 1000000] [--models momentum torque]
    python tests/benchmarks/bench_million.py --data-set 1 3 10 [--workers 2] [--into million.json]
    python tests/benchmarks/bench_million.py --day

Logs (Panda, 1 kHz, measured speeds) are made by NumPy with torques of the emitted
torque_regressor: one .npz, or with --data-set Parquet files of a million samples each, as many as
its numbers say. Each model is identified in a process of its own, from start to estimate, the model
compiled before; its peak of resident memory is that of the process. Beside it stands Pinocchio's
Python binding, which evaluates its torque regressor on a part of the same samples (--peer), as many
times as there are samples: all that a program does that only fills W.

Seconds of the clock depend on what else the machine does and on how many threads there are; `user`
is the time of the processors of this process. Between sizes of a data set, the growth of `user`
over that of the samples is what a sample costs; what is left is the start, the look at a sample of
the logs, and the verdict.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

import numpy as np
from figures import keep
from rich.console import Console
from rich.table import Table

MODELS = ("energy", "momentum", "torque", "auto")
RATE = 1000.0
CHUNK = 50_000
MILLION = 1_000_000
SHORT = 20_000  # samples of the log on which the model is compiled
DAY = 60_000  # samples: a minute
PEER = 20_000  # samples that Pinocchio evaluates
ROBOT = "panda"


def pieces(samples: int, seed: int = 0) -> Iterator[dict[str, np.ndarray]]:
    """Yield t, q, qd, tau of a log: encoders of 2e-5 rad, 2 mrad/s, 1 % noise of torque."""
    import symgen

    robot = symgen.read_robot(ROBOT)
    model = symgen.derive(robot, ("torque_regressor",))
    kernel, n, p = symgen.load(model)["torque_regressor"], len(robot.movable), len(model.base.names)
    rng = np.random.default_rng(0)
    # Positive definite for sure: every base parameter about 1, inertias of 5 on the diagonal.
    X = np.array([0.3 + rng.random() + 5 * name.startswith("ZZ") for name in model.base.names])
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.05, 0.6, (6, n))  # sines up to 0.6 Hz
    a, phase = rng.uniform(0.1, 0.4, (6, n)), rng.uniform(0, 2 * np.pi, (6, n))
    for begin in range(0, samples, CHUNK):
        t = np.arange(begin, min(begin + CHUNK, samples)) / RATE
        angle = t[:, None, None] * w + phase
        q, qd = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1)
        qdd = (-a * w**2 * np.sin(angle)).sum(1)
        tau = np.asarray(kernel(q, qd, qdd)).reshape(-1, n, p) @ X
        q = np.round(q / 2e-5) * 2e-5
        qd += 2e-3 * rng.normal(size=qd.shape)
        tau += 0.01 * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
        yield {"t": t, "q": q, "qd": qd, "tau": tau}


def make_log(path: Path, samples: int) -> None:
    """Write an .npz."""
    parts = list(pieces(samples))
    np.savez(path, **{key: np.concatenate([part[key] for part in parts]) for key in parts[0]})


def make_files(folder: Path, files: int) -> None:
    """Write Parquet files of a million samples each."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    folder.mkdir(parents=True)
    for k in range(files):
        writer = None
        for part in pieces(MILLION, seed=k):
            columns = {"t": part["t"]}
            for key in ("q", "qd", "tau"):
                columns |= {f"{key}{j + 1}": x for j, x in enumerate(part[key].T)}
            table = pa.table(columns)
            writer = writer or pq.ParquetWriter(folder / f"{k:03d}.parquet", table.schema)
            writer.write_table(table)
        assert writer is not None
        writer.close()


def one(source: str, model: str, workers: int | None) -> None:
    """Identify once in this process; print what it took and what came out, as JSON."""
    import symgen
    from symgen.parallel import executor_of

    begin = time.perf_counter()
    with executor_of(workers, None) as executor:
        estimate = symgen.identify(ROBOT, [source], model=model, executor=executor)
    seconds = time.perf_counter() - begin
    own = resource.getrusage(resource.RUSAGE_SELF)
    user = own.ru_utime + resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    said = estimate.torque_validation.relative
    print(
        json.dumps(
            {
                "s": seconds, "user": user, "GB": 1024 * own.ru_maxrss / 1e9, "said": said,
                "verdict": estimate.verdict,
            }
        )
    )  # fmt: skip


def peer() -> None:
    """Print the microseconds a sample of Pinocchio's torque regressor from Python."""
    from peers import PINOCCHIO, pinocchio_model

    import symgen

    found = pinocchio_model(symgen.read_robot(ROBOT))
    if found is None:
        print(json.dumps({}))
        return
    pin, model = found
    data, call = model.createData(), PINOCCHIO["torque_regressor"]
    part = next(pieces(PEER))
    rows = list(zip(part["q"], part["qd"], np.gradient(part["qd"], 1 / RATE, axis=0), strict=True))
    begin = time.process_time()
    for q, qd, qdd in rows:
        call(pin, model, data, q, qd, qdd)
    print(json.dumps({"us": (time.process_time() - begin) / len(rows) * 1e6}))


def day(path: Path) -> None:
    """Print the seconds of a minute of a robot whose model is loaded and whose cutoff is known."""
    import symgen
    from symgen.estimation.equation_model import EquationModel

    robot = symgen.derive(ROBOT, EquationModel("momentum", 0.2).all_kernels)
    evaluator = symgen.load(robot)
    for _ in range(2):  # the first imports what it needs
        begin = time.process_time()
        symgen.identify(evaluator, [path], model="momentum", cutoff=11.0)
        seconds = time.process_time() - begin
    print(json.dumps({"user": seconds}))


def asked(*given: Any) -> dict[str, Any]:
    """Run this file in a process of its own; return what it printed last, or what went wrong."""
    command = [sys.executable, str(Path(__file__).resolve()), *map(str, given)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        return {"error": (done.stderr.strip().splitlines() or ["failed"])[-1]}
    lines = done.stdout.splitlines()
    return dict(json.loads(lines[-1])) if lines else {}


def in_memory(folder: Path, samples: int, models: list[str]) -> list[dict[str, Any]]:
    """Identify each model from one .npz."""
    # Made in processes of their own: a child's peak begins with what its parent holds.
    long, short = (folder / name for name in ("million.npz", "short.npz"))
    for path, count in ((short, SHORT), (long, samples)):
        asked("--make", path, count)
    rows = []
    for model in models:
        for log in (short, long):  # the first compiles
            row = asked("--one", log, model)
        rows.append({"model": model, "samples": samples, **row})
    return rows


def out_of_core(
    folder: Path, sizes: list[int], models: list[str], workers: int | None
) -> list[dict[str, Any]]:
    """Identify each model from Parquet files, more and more of them."""
    logs, short = folder / "logs", folder / "short.npz"
    asked("--make", short, SHORT)
    asked("--make-files", logs, max(sizes))
    rows = []
    for model in models:
        asked("--one", short, model)
        before: dict[str, Any] = {}
        for size in sorted(sizes):
            chosen = folder / f"{size}"
            if not chosen.exists():
                chosen.mkdir()
                for k in range(size):
                    (chosen / f"{k:03d}.parquet").symlink_to(logs / f"{k:03d}.parquet")
            given = ["--workers", workers] if workers else []
            row = {"model": model, "samples": size * MILLION}
            row |= asked("--one", f"{chosen}/*.parquet", model, *given)
            if "user" in row and "user" in before:
                more = (row["samples"] - before["samples"]) / 1e6
                row["us"] = (row["user"] - before["user"]) / more
            rows.append(row)
            before = row
    return rows


def table_of(rows: list[dict[str, Any]], pinocchio: float | None) -> Table:
    """Return what is printed."""
    title = f"identify, {ROBOT}, 1 kHz; user: seconds of the processor"
    if pinocchio:
        title += f"; Pinocchio's regressor from Python: {pinocchio:.2f} us a sample"
    table = Table(title=title)
    names = ("model", "samples", "s", "user", "us a sample more", "s over Pinocchio", "peak MB")
    for heading in (*names, "torque residual said", "verdict"):
        table.add_column(heading, justify="right")
    for row in rows:
        if "error" in row:
            table.add_row(row["model"], f"{row['samples']:,}", *"-----", row["error"], "-")
            continue
        over = 1e6 * row["s"] / row["samples"] / pinocchio if pinocchio else None
        table.add_row(
            row["model"],
            f"{row['samples']:,}",
            f"{row['s']:.1f}",
            f"{row['user']:.1f}",
            f"{row['us']:.2f}" if "us" in row else "-",
            f"{over:.2f}" if over else "-",
            f"{1000 * row['GB']:.0f}",
            f"{100 * row['said']:.3g} %",
            row["verdict"],
        )
    return table


def main() -> int:
    """Make the logs, run each model, print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=MILLION)
    parser.add_argument("--models", nargs="+", choices=MODELS)
    parser.add_argument("--data-set", nargs="+", type=int, metavar="MILLIONS")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--day", action="store_true", help="a minute of a robot, as in a fleet")
    parser.add_argument("--folder", type=Path, help="where logs are made; by default a new one")
    parser.add_argument("--into", type=Path, help="JSON with every figure")
    for hidden in ("--make", "--make-files", "--one"):
        parser.add_argument(hidden, nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--peer", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.make:
        make_log(Path(given.make[0]), int(given.make[1]))
    elif given.make_files:
        make_files(Path(given.make_files[0]), int(given.make_files[1]))
    elif given.one:
        one(*given.one, given.workers)
    elif given.peer:
        peer()
    elif given.day:
        with tempfile.TemporaryDirectory(dir=given.folder) as name:
            make_log(Path(name) / "day.npz", DAY)
            day(Path(name) / "day.npz")
        return 0
    if given.make or given.make_files or given.one or given.peer:
        return 0
    pinocchio = asked("--peer").get("us")
    with tempfile.TemporaryDirectory(dir=given.folder) as name:
        folder = Path(name)
        if given.data_set:
            models = given.models or ["momentum"]
            rows = out_of_core(folder, given.data_set, models, given.workers)
        else:
            rows = in_memory(folder, given.samples, given.models or list(MODELS))
    Console().print(table_of(rows, pinocchio))
    if given.into:
        about = {"pinocchio_us": pinocchio, "workers": given.workers or 1}
        keep(given.into, {**about, "rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
