"""Registers and spills of NAME.cu for a Panda, and evaluations a second where a GPU is.

    python tests/benchmarks/bench_gpu.py [--into tests/benchmarks/gpu.json]

Needs nvcc. Without a GPU, rates are not measured. Rates are those of the program gpu.cu, for 256 to
4 million states, warm, without transfers.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from figures import keep
from nvcc import ARCHITECTURES, compiled, nvcc

import symgen


def rates(folder: Path, dtype: str, compiler: str) -> list[dict[str, Any]]:
    """Return what gpu.cu prints; nothing without a GPU."""
    if shutil.which("nvidia-smi") is None:
        return []
    program = Path(__file__).with_name("gpu.cu")
    sources = ["panda.cu", str(program)]
    built = [compiler, "-O3", "-std=c++17", "-arch=native", "-I.", *sources, "-o", "gpu"]
    subprocess.run(built, cwd=folder, check=True)
    printed = subprocess.run(["./gpu"], cwd=folder, check=True, capture_output=True, text=True)
    rows = map(json.loads, printed.stdout.splitlines())
    return [{"tool": "symgen", "dtype": dtype, **row} for row in rows]


def main() -> None:
    """Compile, measure and keep the figures."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--into", type=Path, default=Path("gpu.json"))
    into = parser.parse_args().into
    compiler = nvcc()
    if compiler is None:
        raise SystemExit("no nvcc: pip install nvidia-cuda-nvcc nvidia-cuda-runtime")
    model = symgen.derive("panda", "all")
    registers: dict[str, dict[str, tuple[int, int]]] = {}
    measured: list[dict[str, Any]] = []
    for dtype in ("float", "double"):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "panda"
            tree = symgen.generate(model, target="cuda", dtype=dtype, prefix="panda")
            symgen.write_package(tree, folder)
            for architecture in ARCHITECTURES:
                registers[f"{dtype}, {architecture}"] = compiled(folder / "panda.cu", architecture)
            measured += rates(folder, dtype, compiler)
    kernels = [k.name for k in model.kernels if k.batch]
    keep(into, {"kernels": kernels, "compiled": registers, "rates": measured})


if __name__ == "__main__":
    main()
