"""Symgen beside what a user would pick instead, in one run: a table, and a JSON with every figure.

    python tests/benchmarks/bench_speed.py [--into speed.json] [--robot panda] [--only PART]

Times are ns a sample, medians of repeats that take turns, so that a slow moment of the machine
meets all alike; figures of two runs do not compare, ratios do. Pinocchio in C++ is compiled here,
its headers with -march=native; CasADi's C with symgen's compiler and flags. "In cache": outputs
that stay in the second cache. "Panels in C": a program in C calls the functions of a package in a
loop, all with the same flags, by instruction set; over single calls, and as a share of the width of
a panel. "Large tree": kernels of a humanoid of 30 joints beside Pinocchio's C++, all with -O2
-march=native, in cache, out of it, and out of it after NAME_warm (trees.c says how). "Cold": the
same of the robot.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

import numpy as np
from figures import keep
from large_arms import LARGE
from oracles.random_arms import to_toml
from packages import run
from peers import (
    BUILD,
    PINOCCHIO,
    base_of,
    begin_cxx,
    casadi_c,
    pinocchio_model,
    pinocchio_objects,
    pointer,
)
from rich.console import Console
from rich.table import Table

import symgen
from symgen.codegen.backends.c import functions
from symgen.codegen.verification import physical_parameters
from symgen.runtime.build import find_compiler, native
from symgen.runtime.flags import kernel_flags
from symgen.runtime.panels import aligned
from symgen.symbolic.tape import Numbers

KERNELS = (
    "energy_regressor",
    "torque_regressor",
    "momentum_regressor",
    "inverse_dynamics",
    "mass_matrix",
    "forward_dynamics",
)
DERIVATIVES = ("inverse_dynamics_derivatives", "forward_dynamics_derivatives")
TREES = ("inverse_dynamics", "forward_dynamics", "mass_matrix", *DERIVATIVES)
#: Flags of panels in C, and what the processor must have.
SETS = {
    "SSE2": ("", "__SSE2__"),
    "AVX2": ("-mavx2 -mfma", "__AVX2__"),
    "AVX-512": ("-mavx512f -mavx512dq -mfma -mprefer-vector-width=512", "__AVX512DQ__"),
    "native": ("-march=native", ""),
}
STATES = 32  # of a large tree, as in trees.c
TREE_FLAGS = ("-O2", "-march=native", "-fPIC")
TIMES = Path(__file__).with_name("trees.c")
FRICTION = ("coulomb", "viscous")
IN_CACHE = 2**18  # bytes of output
REPEATS, AT_LEAST = 9, 5e-4
#: The loops of a program in C: single calls, the batch as rows, panels.
LOOPS = """
#include "NAME_panels.h"
void single(size_t R, size_t N, ARGUMENTS)
{
    while (R--) {
        for (size_t k = 0; k < N; ++k) {
            NAME_KERNEL(EACH);
        }
    }
}
void batch(size_t R, size_t N, ARGUMENTS)
{
    while (R--) {
        NAME_KERNEL_batch(N, ALL);
    }
}
void panels(size_t R, size_t N, ARGUMENTS)
{
    while (R--) {
        NAME_KERNEL_panels(0, N, NULL, ALL);
    }
}
"""
Call = Callable[[], Any]


def measure(ways: dict[str, tuple[Call, int]]) -> dict[str, float]:
    """Return the median ns a sample of each way; the ways take turns."""
    calls = {}
    for name, (call, _) in ways.items():
        call()  # the first one may load what it needs
        count, seconds = 1, 0.0
        while seconds < AT_LEAST:
            begun = time.perf_counter()
            for _ in range(count):
                call()
            seconds = time.perf_counter() - begun
            count *= 1 if seconds >= AT_LEAST else 2
        calls[name] = count
    times: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(REPEATS):
        for name, (call, samples) in ways.items():
            begun = time.perf_counter_ns()
            for _ in range(calls[name]):
                call()
            times[name].append((time.perf_counter_ns() - begun) / calls[name] / samples)
    return {name: statistics.median(found) for name, found in times.items()}


def bound(function: Any, inputs: list[np.ndarray]) -> Call:
    """Return a call on buffers that hold these inputs."""
    for place, given in zip(function.inputs, inputs, strict=True):
        place[...] = given
    function.call()  # pages are there
    return function.call


def kernel_ways(
    evaluator: symgen.Evaluator, name: str, folder: Path, cxx: Any, arm: Any
) -> dict[str, tuple[Call, int]]:
    """Every way of computing a kernel on a batch in the cache."""
    function = evaluator[name]
    kernel, model = function.kernel, evaluator.model
    count = max(16, IN_CACHE // (8 * kernel.size) // 8 * 8)
    draw = np.random.default_rng(1)
    X = np.array(physical_parameters(model, random.Random(1)))
    inputs = [
        X if n == "X" else draw.uniform(-1, 1, (count, len(s))) for n, s in kernel.tape.inputs
    ]
    if "X" in dict(kernel.tape.inputs):
        inputs = [
            a[: len(s)] if n == "X" else a
            for a, (n, s) in zip(inputs, kernel.tape.inputs, strict=True)
        ]
    ways: dict[str, tuple[Call, int]] = {"single": (bound(function.bind(count), inputs), count)}
    panels = function.panels()
    assert panels is not None
    ways["panels"] = (bound(panels.bind(count, rows=False), inputs), count)
    ways["rows"] = (bound(panels.bind(count), inputs), count)
    compiler = find_compiler()
    assert compiler is not None
    peer = (
        casadi_c(model, kernel, folder, compiler, kernel_flags(compiler))
        if len(kernel.outputs) == 1
        else None
    )
    if peer is not None:
        out = np.empty((count, kernel.size))
        arguments = (ctypes.c_size_t(count), *map(pointer, (*inputs, out)))
        ways["CasADi C"] = (lambda: peer.loop(*arguments), count)
    functions = {"sin": np.sin, "cos": np.cos, "abs": np.abs, "sign": np.sign, "tanh": np.tanh}
    numbers = Numbers(model.robot.values(), functions)
    columns = {
        n: list(a) if n == "X" else list(np.ascontiguousarray(a.T))
        for (n, _), a in zip(kernel.tape.inputs, inputs, strict=True)
    }
    ways["NumPy"] = (lambda: kernel.tape.run(numbers, columns), count)
    if arm is not None and name in PINOCCHIO:
        pin, body = arm
        data = body.createData()
        n = model.robot.n
        q, qd, third = draw.uniform(-1, 1, (3, count, n))
        one = (q[0].copy(), qd[0].copy(), third[0].copy())
        ways["Pinocchio Python"] = (lambda: PINOCCHIO[name](pin, body, data, *one), 1)
        if not isinstance(cxx, str):
            size = {
                "energy_regressor": 10 * n,
                "torque_regressor": 10 * n * n,
                "mass_matrix": n * n,
            }.get(name, n)
            given = np.empty((count, size))
            loop = getattr(cxx, name)
            passed = (ctypes.c_size_t(count), *map(pointer, (q, qd, third, given)))
            ways["Pinocchio C++"] = (lambda: loop(*passed), count)
    return ways


def panels_in_c(model: symgen.Model, name: str, flags: list[str], folder: Path) -> dict[str, float]:
    """Return ns a sample of single calls, batch and panels in C, and the width of a panel."""
    compiler, kernel = find_compiler(), model.kernel(name)
    assert compiler is not None
    for path, content in functions(model, (name,), panels=True).items():
        (folder / path).write_bytes(content)
    words = {
        "NAME": model.robot.name,
        "KERNEL": name,
        "ARGUMENTS": kernel.listed("double", batch=True),
        "EACH": ", ".join(
            a.name if a.shared else f"&{a.name}[k * {a.size}]" for a in kernel.arguments
        ),
        "ALL": ", ".join(a.name for a in kernel.arguments),
    }
    text = LOOPS
    for word, stands_for in words.items():
        text = text.replace(word, stands_for)
    (folder / "loops.c").write_text(text)
    sources = sorted(path.name for path in folder.glob("*.c"))
    command = [*compiler.command, *BUILD, *flags, *sources, "-o", "loops.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    loops = ctypes.CDLL(str(folder / "loops.so"))
    count = max(16, IN_CACHE // 2 // (8 * kernel.size) // 16 * 16)
    draw, X = np.random.default_rng(1), physical_parameters(model, random.Random(1))
    arrays = [aligned((count * a.size,)) for a in kernel.arguments]
    for place, argument in zip(arrays, kernel.arguments, strict=True):
        place[:] = draw.uniform(-1, 1, place.shape) if argument.read else 0.0
        if argument.name == "X":
            place[: argument.size] = X[: argument.size]
    repeats = -(-(2**14) // count)
    given = (ctypes.c_size_t(repeats), ctypes.c_size_t(count), *map(pointer, arrays))
    ways = {
        way: (partial(getattr(loops, way), *given), repeats * count)
        for way in ("single", "batch", "panels")
    }
    width = getattr(loops, f"{model.robot.name}_{name}_width")()
    return measure(ways) | {"width": width}


def tree(name: str, kernel: str, objects: list[Path], folder: Path) -> dict[str, float]:
    """Return ns of a call beside Pinocchio's, hot, cold and warm, and the largest difference.

    Args:
        name: of a large robot, or of one of symgen's with revolute joints.
        kernel: name of the kernel.
        objects: Pinocchio's, compiled.
        folder: where to compile.
    """
    large = name in LARGE
    robot = symgen.parse_robot(to_toml(LARGE[name], name, FRICTION)) if large else name
    model = symgen.derive(robot, (kernel,))
    (own,) = model.kernels
    symgen.write_package(symgen.generate(model, target="c"), folder / name)
    n, found = model.robot.n, pinocchio_model(model.robot)
    assert found is not None
    places, at = {"q": "q + i * n", "qd": "qd + i * n", "X": "X"}, 0
    for output in own.outputs:
        places[output.name] = f"ours + i * size + {at}"
        at += output.size
    call = ", ".join(places.get(a.name, "third + i * n") for a in own.arguments)
    marks = {"NAME": name, "KERNEL": kernel, "CALL": call, "JOINTS": str(n)}
    program = TIMES.read_text()
    for mark, content in (marks | {"HALF": str(int(kernel == "mass_matrix"))}).items():
        program = program.replace(mark, content)
    (folder / "main.c").write_text(program)
    sources = ("main.c", f"{name}/{name}_{kernel}.c", f"{name}/{name}_warm.c")
    run(["gcc", "-std=gnu11", *TREE_FLAGS, f"-I{name}", "-c", *sources], folder)
    compiled = sorted(folder.glob("*.o"))
    run(["g++", "-shared", *compiled, *objects, "-lm", "-o", "tree.so"], folder)
    library = ctypes.CDLL(str(folder / "tree.so"))
    begin_cxx(library, found[1])
    state = np.random.default_rng(3).uniform(-1, 1, (3, STATES, n))
    arrays = (*state, base_of(model, found[1]), *np.zeros((2, STATES * at)), np.zeros(7))
    library.measure(ctypes.c_size_t(at), *map(pointer, arrays))
    heads = ("hot", "Pinocchio hot", "cold", "Pinocchio cold", "warm", "warm-up", "difference")
    return dict(zip(heads, map(float, arrays[-1]), strict=True))


def beside_pinocchio(robot: str) -> dict[str, dict[str, float]]:
    """Return the rows of calls in cache and out of it, and print them."""
    objects = pinocchio_objects(TREES, TREE_FLAGS)
    if isinstance(objects, str):
        raise SystemExit(objects)
    head = [f"{robot}, ns"]
    for way in ("hot", "cold", "warm"):
        head += [way, "over Pinocchio"]
    table, rows = Table(*head, "warm-up", "difference", box=None), {}
    for kernel in TREES:
        with tempfile.TemporaryDirectory() as temporary:
            row = rows[kernel] = tree(robot, kernel, objects, Path(temporary))
        cells = [kernel]
        for way, theirs in (("hot", "hot"), ("cold", "cold"), ("warm", "cold")):
            cells += [f"{row[way]:,.0f}", f"{row[f'Pinocchio {theirs}'] / row[way]:.2f}"]
        table.add_row(*cells, f"{row['warm-up']:,.0f}", f"{row['difference']:.0e}")
    Console(highlight=False, width=120).print(table)
    return rows


def all_panels_in_c(robot: str, kernels: Iterable[str]) -> dict[str, dict[str, float]]:
    """Return the rows of panels in C by kernel and set of flags, and print them."""
    compiler = find_compiler()
    assert compiler is not None
    defined = {line.split()[1] for line in native(compiler).splitlines() if " " in line}
    model, rows = symgen.derive(symgen.read_robot(robot), (*kernels, *DERIVATIVES)), {}
    for kernel in model.kernels:
        for name, (flags, needed) in SETS.items():
            if not needed or needed in defined:
                with tempfile.TemporaryDirectory() as temporary:
                    row = panels_in_c(model, kernel.name, flags.split(), Path(temporary))
                rows[f"{kernel.name}, {name}"] = row
    Console(highlight=False, width=120).print(shares(rows))
    return rows


def in_cache(robot: str, kernels: tuple[str, ...]) -> dict[str, dict[str, float]]:
    """Return the rows of calls and batches in the cache, and print them."""
    rows = {}
    with tempfile.TemporaryDirectory() as temporary:
        cxx = pinocchio(Path(temporary), PINOCCHIO.keys() & kernels, ("-march=native",))
        if isinstance(cxx, str):
            print(f"without Pinocchio in C++: {cxx}", file=sys.stderr)
        evaluator = symgen.load(symgen.derive(symgen.read_robot(robot), kernels), backend="c")
        arm = pinocchio_model(evaluator.model.robot)
        if arm is not None and not isinstance(cxx, str):
            begin_cxx(cxx, arm[1])
        for kernel in kernels:
            folder = Path(temporary) / kernel
            folder.mkdir()
            rows[kernel] = measure(kernel_ways(evaluator, kernel, folder, cxx, arm))
    ways = list(dict.fromkeys(way for row in rows.values() for way in row))
    table = Table(f"{robot}, ns a sample", *ways, box=None, header_style="bold")
    for name, row in rows.items():
        table.add_row(name, *(f"{row[w]:,.1f}" if w in row else "-" for w in ways))
    Console(highlight=False, width=170).print(table)
    return rows


def pinocchio(folder: Path, kernels: Iterable[str], flags: tuple[str, ...]) -> Any:
    """Return the C++ loops for these kernels as a library, or in words why there is none."""
    objects = pinocchio_objects(kernels, flags)
    if isinstance(objects, str):
        return objects
    library = folder / "pinocchio.so"
    subprocess.run(["g++", "-shared", *objects, "-o", library], check=True)
    return ctypes.CDLL(str(library))


def shares(figures: dict[str, dict[str, float]]) -> Table:
    """Return a table of panels in C: ns, speed over a single call, share of the width."""
    head = ("panels in C, ns a sample (speed over single calls, share of the width)", "width")
    table = Table(*head, "single", "batch", "panels", box=None, header_style="bold")
    for name, row in figures.items():
        faster = {way: row["single"] / row[way] for way in ("batch", "panels")}
        cells = [f"{row[w]:,.1f} ({x:.2f}, {x / row['width']:.2f})" for w, x in faster.items()]
        table.add_row(name, str(row["width"]), f"{row['single']:,.1f}", *cells)
    return table


def main() -> None:
    """Measure, print the tables and keep the figures; of one part, only print them."""
    parts = ("in_cache", "panels_in_c", "large_tree", "cold")
    parser = argparse.ArgumentParser()
    parser.add_argument("--into", type=Path, default=Path("speed.json"))
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--only", choices=parts)
    asked = parser.parse_args()
    compiler = find_compiler()
    if compiler is None:
        raise SystemExit("no C compiler: nothing to compare")
    measures = {
        "in_cache": lambda: in_cache(asked.robot, KERNELS),
        "panels_in_c": lambda: all_panels_in_c(asked.robot, KERNELS),
        "large_tree": lambda: beside_pinocchio("humanoid"),
        "cold": lambda: beside_pinocchio(asked.robot),
    }
    if asked.only:
        measures[asked.only]()
        return
    keep(asked.into, {"compiler": compiler.version} | {part: measures[part]() for part in parts})


if __name__ == "__main__":
    main()
