"""Operation counts and ns per sample of every kernel, and the paper's claim of simplicity.

    python tests/benchmarks/bench_kernels.py

The paper holds the energy model to be simpler than the dynamic one: its regressor stands beside the
torque regressor, by operations and by time. ns are of the batch form in C, one core, medians of
repeats that take turns; generation times are of one derivation in this process.

    python tests/benchmarks/bench_kernels.py --restrict panda

What it costs that a load may alias a store: the sources of a package compiled as they are and with
`restrict` at every output, with gcc and clang where they are here, ns of the batch form as above.

    python tests/benchmarks/bench_kernels.py --flags panda

What the flags of a build do to single calls: a program in C calls six kernels of a package, as each
compiler builds it with each set of flags, and overwrites their outputs; ns a call, and that over
the first set's.
"""

from __future__ import annotations

import argparse
import ctypes
import random
import re
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from peers import BUILD, pointer
from rich.console import Console
from rich.table import Table

import symgen
from symgen.codegen.backends.c import functions
from symgen.codegen.kernel import Kernel
from symgen.codegen.kernels import ALL
from symgen.codegen.model import Model
from symgen.codegen.verification import physical_parameters

ROBOTS = ("planar2r", "puma560", "tx40", "panda", "wam7")
SAMPLES = 1000
REPEATS = 31
#: Whose time `--flags` takes, and the flags that a user may build a package with.
SIX = (
    "energy_regressor",
    "momentum_regressor",
    "torque_regressor",
    "inverse_dynamics",
    "mass_matrix",
    "forward_dynamics",
)
BUILDS = ("-O2", "-O2 -march=native", "-O2 -mfma -fno-tree-slp-vectorize")
SINGLE = """
#include "NAME.h"
void single(size_t N, ARGUMENTS)
{
    for (size_t k = 0; k < N; ++k) {
        NAME_KERNEL(EACH);
    }
}
"""
OUTPUT = re.compile(r"(?<!const )\bdouble(\s+)(\w+)\[(\d+)\]")  # in a prototype


def main() -> None:
    """Print one table a robot, or the table of `restrict`."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--restrict", metavar="ROBOT")
    parser.add_argument("--flags", metavar="ROBOT")
    asked = parser.parse_args()
    console = Console(width=110)
    if asked.restrict:
        restrict(asked.restrict, console)
    elif asked.flags:
        flags(asked.flags, console)
    else:
        kernels(console)


def kernels(console: Console) -> None:
    """Print one table a robot."""
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
        times = taking_turns(calls)
        energy = times["energy_regressor"]
        derived = f"{seconds[1]:.2f} s (energy regressor), {seconds[len(ALL)]:.2f} s (all kernels)"
        table = Table(title=f"{name}: derived in {derived}; {evaluator.backend}")
        for head in ("kernel", "mul", "add", "div", "sincos", "ns", "over energy regressor"):
            table.add_column(head)
        for k in (k for k in model.kernels if k.name in times):
            o, ns = k.tape.operations, times[k.name]
            row = (o.mul, o.add, o.div, o.sincos, round(ns), f"{ns / energy:.2f}")
            table.add_row(k.name, *map(str, row))
        console.print(table)


def call_of(evaluator: symgen.Evaluator, kernel: str, draw: np.random.Generator) -> Any:
    """Return a call of a kernel on a batch of random samples."""
    function = evaluator[kernel]
    inputs = inputs_of(evaluator.model, function.kernel, draw)
    return lambda: function(*inputs)


def inputs_of(model: Model, kernel: Kernel, draw: np.random.Generator) -> list[Any]:
    """Return a batch of random samples, for a robot whose mass matrix is positive definite."""
    X = np.array(physical_parameters(model, random.Random(1)))
    return [
        X
        if name == "X"
        else len(symbols)
        if name == "link"
        else draw.uniform(-1, 1, (SAMPLES, len(symbols)))
        for name, symbols in kernel.tape.inputs
    ]


def taking_turns(calls: Mapping[Any, Callable[[], Any]]) -> dict[Any, float]:
    """Return the median ns a sample of each call."""
    times: dict[Any, list[float]] = {key: [] for key in calls}
    for _ in range(REPEATS):
        for key, call in calls.items():
            begun = time.perf_counter()
            call()
            times[key].append((time.perf_counter() - begun) / SAMPLES * 1e9)
    return {key: statistics.median(found) for key, found in times.items()}


def restrict(name: str, console: Console) -> None:
    """Print the ns of every kernel without and with `restrict` at its outputs, and their ratio."""
    model = symgen.derive(symgen.read_robot(name), ALL)
    files = symgen.generate(model, target="c").files
    compilers = [c for c in ("gcc", "clang") if shutil.which(c)]
    table = Table(title=f"{name}: ns without `restrict`, with it, and with over without")
    for head in ("kernel", "operations", *compilers):
        table.add_column(head)
    with tempfile.TemporaryDirectory() as folder:
        loaded = {
            (compiler, word): built(files, Path(folder) / f"{compiler}{word}", compiler, word)
            for compiler in compilers
            for word in ("", "restrict")
        }
        for kernel in (k for k in model.kernels if k.batch):
            given = inputs_of(model, kernel, np.random.default_rng(0))
            given += [np.zeros((SAMPLES, output.size)) for output in kernel.outputs]
            passed = [
                pointer(a) if isinstance(a, np.ndarray) else ctypes.c_size_t(a) for a in given
            ]
            function = f"{name}_{kernel.name}_batch"
            calls = {
                key: partial(library[function], ctypes.c_size_t(SAMPLES), *passed)
                for key, library in loaded.items()
            }
            ns, o = taking_turns(calls), kernel.tape.operations
            pairs = [(ns[c, ""], ns[c, "restrict"]) for c in compilers]
            cells = [f"{without:,.0f} {word:,.0f} {word / without:.2f}" for without, word in pairs]
            table.add_row(kernel.name, str(o.mul + o.add + o.div), *cells)
    console.print(table)


def flags(name: str, console: Console) -> None:
    """Print the ns of single calls of six kernels by the flags of the build, and their ratios."""
    model = symgen.derive(symgen.read_robot(name), SIX)
    for compiler in (c for c in ("gcc", "clang") if shutil.which(c)):
        title = f"{name}, {compiler}: ns a call, and over that of {BUILDS[0]}"
        table = Table("kernel", *BUILDS, title=title)
        for kernel in model.kernels:
            with tempfile.TemporaryDirectory() as folder:
                given = inputs_of(model, kernel, np.random.default_rng(0))
                given += [np.zeros((SAMPLES, output.size)) for output in kernel.outputs]
                calls = {
                    build: partial(
                        single(model, kernel, f"{compiler} {build}", Path(folder) / str(k)).single,
                        ctypes.c_size_t(SAMPLES), *map(pointer, given),
                    )
                    for k, build in enumerate(BUILDS)
                }  # fmt: skip
                ns = taking_turns(calls)
            first = ns[BUILDS[0]]
            table.add_row(kernel.name, *(f"{ns[b]:,.0f} {ns[b] / first:.2f}" for b in BUILDS))
        console.print(table)


def single(model: Model, kernel: Kernel, build: str, folder: Path) -> ctypes.CDLL:
    """Compile a loop of single calls of a kernel with a compiler and its flags."""
    folder.mkdir()
    for path, content in functions(model, (kernel.name,)).items():
        (folder / path).write_bytes(content)
    words = {
        "NAME": model.robot.name,
        "KERNEL": kernel.name,
        "ARGUMENTS": kernel.listed("double", batch=True),
        "EACH": ", ".join(
            a.name if a.shared or not a.read else f"&{a.name}[k * {a.size}]"
            for a in kernel.arguments
        ),
    }
    text = SINGLE
    for word, stands_for in words.items():
        text = text.replace(word, stands_for)
    (folder / "loop.c").write_text(text)
    sources = sorted(path.name for path in folder.glob("*.c"))
    command = [*build.split(), "-fPIC", "-shared", *sources, "-o", "loop.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "loop.so"))


def built(files: Mapping[str, bytes], folder: Path, compiler: str, word: str) -> ctypes.CDLL:
    """Compile the kernels of a package, with a word in the brackets of every output."""
    folder.mkdir()
    for path in (p for p in files if "/" not in p and p.endswith((".c", ".h"))):
        head, brace, body = files[path].decode().partition("\n{\n")
        if path.endswith(".c"):
            head = OUTPUT.sub(rf"double\1\2[{word} \3]", head)
        (folder / path).write_text(head + brace + body)
    sources = [p.name for p in folder.glob("*.c")]
    command = [compiler, *BUILD, "-march=native", *sources, "-o", "kernels.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "kernels.so"))


if __name__ == "__main__":
    main()
