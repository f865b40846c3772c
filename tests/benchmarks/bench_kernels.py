"""Operation counts and ns per sample of every kernel, and the paper's claim of simplicity.

    python tests/benchmarks/bench_kernels.py

The paper holds the energy model to be simpler than the dynamic one: its regressor stands beside the
torque regressor, by operations and by time. ns are of the batch form in C, one core, medians of
repeats that take turns; generation times are of one derivation in this process.
"""

from __future__ import annotations

import random
import statistics
import time
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import symgen
from symgen.codegen.recipes import ALL
from symgen.codegen.verification import physical_parameters

ROBOTS = ("planar2r", "puma560", "tx40", "panda", "wam7")
SAMPLES = 1000
REPEATS = 31


def main() -> None:
    """Print one table a robot."""
    console = Console(width=110)
    draw = np.random.default_rng(0)
    for name in ROBOTS:
        robot = symgen.read_robot(name)
        seconds = {}
        for kernels in (("energy_regressor",), ALL):
            begun = time.perf_counter()
            model = symgen.derive(robot, kernels)
            seconds[len(kernels)] = time.perf_counter() - begun
        evaluator = symgen.load(model)
        calls = {k.name: call_of(evaluator, k.name, draw) for k in model.kernels if k.batch}
        times: dict[str, list[float]] = {k: [] for k in calls}
        for _ in range(REPEATS):
            for kernel, call in calls.items():
                begun = time.perf_counter()
                call()
                times[kernel].append((time.perf_counter() - begun) / SAMPLES * 1e9)
        energy = statistics.median(times["energy_regressor"])
        derived = f"{seconds[1]:.2f} s (energy regressor), {seconds[len(ALL)]:.2f} s (all kernels)"
        table = Table(title=f"{name}: derived in {derived}; {evaluator.backend}")
        for head in ("kernel", "mul", "add", "div", "sincos", "ns", "over energy regressor"):
            table.add_column(head)
        for k in (k for k in model.kernels if k.name in times):
            o, ns = k.tape.operations, statistics.median(times[k.name])
            row = (o.mul, o.add, o.div, o.sincos, round(ns), f"{ns / energy:.2f}")
            table.add_row(k.name, *map(str, row))
        console.print(table)


def call_of(evaluator: symgen.Evaluator, kernel: str, draw: np.random.Generator) -> Any:
    """Return a call of a kernel on a batch of random samples."""
    function = evaluator[kernel]
    X = draw.uniform(0.5, 1.0, len(evaluator.model.base.parameters))
    if function.kernel.guards:  # a mass matrix that is positive definite
        X = np.array(physical_parameters(evaluator.model, random.Random(1)))
    inputs = [
        X
        if name == "X"
        else len(symbols)
        if name == "link"
        else draw.uniform(-1, 1, (SAMPLES, len(symbols)))
        for name, symbols in function.kernel.tape.inputs
    ]
    return lambda: function(*inputs)


if __name__ == "__main__":
    main()
