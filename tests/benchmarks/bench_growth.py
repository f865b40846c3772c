"""How derivation, code and compilation grow with the number of joints, and what starting costs.

    python tests/benchmarks/bench_growth.py [--joints 2 6 7 12 24 50] [--into growth.json]
    python tests/benchmarks/bench_growth.py --package humanoid

Chains of revolute joints, axes at right angles in turn, with friction and rotors. Each row is a
process of its own with an empty cache: seconds of its processor for the derivation with the exact
rank, for generation and for the compiler; statements of the kernel; and ns of one call. Growth is
the power of n by which statements grow from the line above. The time of `import symgen` and of
`generate --kernels energy_regressor` stands over that of `import sympy`, medians that take turns.
The second form runs `symgen generate` for all kernels of a robot of large_arms.py with an
empty cache, and prints its processor time and the bytes of its files.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

from figures import keep
from rich.console import Console
from rich.table import Table

KERNELS = ("energy_regressor", "inverse_dynamics", "forward_dynamics")
JOINTS = (2, 6, 7, 12, 24, 50)
REPEATS = 5


def chain(joints: int) -> str:
    """Return the robot.toml of a chain."""
    lines = ["[robot]", f'name = "chain{joints}"', "gravity = [0.0, 0.0, -9.81]"]
    for j in range(joints):
        lines += ["[[joint]]", f'alpha = "{("0", "-pi/2", "pi/2")[0 if j == 0 else 1 + j % 2]}"']
        lines += [f"d = {0.1 * (j % 3)}", f"r = {0.2 * ((j + 1) % 3)}"]
    return "\n".join(lines) + "\n"


def one(joints: int, kernel: str) -> None:
    """Print what a kernel of a chain costs."""
    import numpy as np

    import symgen
    from symgen.robot.toml_io import parse_robot

    robot = parse_robot(chain(joints), "chain.toml")
    symgen.derive("planar2r")  # what is imported late is here
    begun = time.process_time()
    model = symgen.derive(robot, (kernel,))
    derived = time.process_time()
    symgen.generate(model, target="c")
    generated = time.process_time()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    evaluator = symgen.load(model, backend="c")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    (own,) = (k for k in model.kernels if k.name == kernel)
    draw = np.random.default_rng(0)
    function = evaluator[kernel]
    call = function.bind(64)
    for place in call.inputs:
        place[...] = draw.uniform(0.5, 1, place.shape)
    call.call()
    times = []
    for _ in range(9):
        start = time.perf_counter_ns()
        call.call()
        times.append((time.perf_counter_ns() - start) / 64)
    print(
        json.dumps(
            {
                "statements": len(own.tape.steps),
                "derive_s": derived - begun,
                "generate_s": generated - derived,
                "compile_s": after.ru_utime - before.ru_utime,
                "ns": statistics.median(times),
            }
        )
    )


def asked(command: list[str], cache: str) -> str:
    """Run a command with an empty cache of compiled models; return what it printed."""
    environment = {**os.environ, "SYMGEN_CACHE": cache}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def growth(joints: list[int]) -> list[dict[str, Any]]:
    """Measure every kernel of every chain."""
    rows = []
    for kernel in KERNELS:
        before: dict[str, Any] = {}
        for n in joints:
            with tempfile.TemporaryDirectory() as cache:
                command = [sys.executable, str(Path(__file__).resolve()), "--one", str(n), kernel]
                row = {"kernel": kernel, "joints": n, **json.loads(asked(command, cache))}
            if before:
                more = math.log(row["statements"] / before["statements"])
                row["power"] = more / math.log(n / before["joints"])
            rows.append(row)
            before = row
    return rows


def package(name: str) -> None:
    """Print what all kernels of a large robot cost: s of the processor, and bytes by file."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from large_arms import LARGE
    from oracles.random_arms import to_toml

    with tempfile.TemporaryDirectory() as folder:
        robot, into = Path(folder) / f"{name}.toml", Path(folder) / name
        robot.write_text(to_toml(LARGE[name], name, ("coulomb", "viscous")))
        spent = processor(["-m", "symgen", "generate", str(robot), "--into", str(into)], folder)
        sizes = {p.name: p.stat().st_size for p in into.rglob("*") if p.is_file()}
    print(f"{name}: {spent:.1f} s of the processor, {sum(sizes.values()):,} bytes")
    for file, size in sorted(sizes.items(), key=lambda item: -item[1])[:12]:
        print(f"{size:12,} {file}")


def processor(arguments: list[str], cache: str) -> float:
    """Return the seconds of the processor that Python takes with these arguments."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    asked([sys.executable, *arguments], cache)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start() -> dict[str, float]:
    """Return processor seconds of imports and of a cold generate, medians in turn."""
    with tempfile.TemporaryDirectory() as folder:
        into = str(Path(folder) / "panda")
        generate = ["generate", "panda", "--kernels", "energy_regressor", "--into", into]
        ways = {
            "python": ["-c", "pass"],
            "import numpy": ["-c", "import numpy"],
            "import symgen": ["-c", "import symgen"],
            "import sympy": ["-c", "import sympy"],
            "generate": ["-m", "symgen", *generate],
        }
        times: dict[str, list[float]] = {way: [] for way in ways}
        for _ in range(REPEATS):
            for way, arguments in ways.items():
                times[way].append(processor(arguments, folder))
    return {way: statistics.median(found) for way, found in times.items()}


def shown(rows: list[dict[str, Any]], started: dict[str, float]) -> list[Table]:
    """Return the tables."""
    heads = ("kernel", "joints", "statements", "power", "derive", "generate", "compiler", "ns")
    table = Table(*heads, title="growth over joints; s of the processor", box=None)
    for row in rows:
        table.add_row(
            row["kernel"], str(row["joints"]), f"{row['statements']:,}",
            f"{row['power']:.2f}" if "power" in row else "-", f"{row['derive_s']:.2f}",
            f"{row['generate_s']:.2f}", f"{row['compile_s']:.2f}", f"{row['ns']:,.0f}",
        )  # fmt: skip
    base = started["import sympy"]
    first = Table("start", "s of the processor", "over import sympy", box=None)
    for way, seconds in started.items():
        first.add_row(way, f"{seconds:.3f}", f"{seconds / base:.2f}")
    return [table, first]


def main() -> None:
    """Measure, print the tables and keep the figures."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--joints", nargs="+", type=int, default=JOINTS)
    parser.add_argument("--into", type=Path, default=Path("growth.json"))
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--package", help="a large robot whose whole package is measured")
    given = parser.parse_args()
    if given.package:
        package(given.package)
        return
    if given.one:
        one(int(given.one[0]), given.one[1])
        return
    rows, started = growth(given.joints), start()
    keep(given.into, {"rows": rows, "start_s": started})
    for table in shown(rows, started):
        Console(width=120).print(table)


if __name__ == "__main__":
    main()
