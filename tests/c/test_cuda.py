"""NAME.cu: as C++ it computes what the C does, bit for bit, and nvcc compiles it for GPUs."""

from __future__ import annotations

import ctypes
import random
import shutil
from pathlib import Path

import numpy as np
import pytest
from nvcc import ARCHITECTURES, compiled, nvcc
from packages import LEANING, RICH, c_files, run
from support import parsed

import symgen
from symgen.codegen.verification import physical_parameters

FEW = ("inverse_dynamics", "forward_dynamics", "torque_regressor", "link_jacobian")
#: Of the same text: without contraction each operation is rounded by itself.
FLAGS = ("-O2", "-fPIC", "-shared", "-ffp-contract=off")
N = 37
#: Kernels of a Panda whose values do not fit the registers.
SPILLING = {
    "float": {"forward_dynamics_derivatives"},
    "double": {
        "forward_dynamics_derivatives", "inverse_dynamics_derivatives",
        "coriolis", "momentum_regressor",
    },
}  # fmt: skip
NO_GXX = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++ on this machine")


def package(name: str, dtype: str, kernels: tuple[str, ...] | str, folder: Path) -> symgen.Model:
    """Write a package with NAME.cu; return its model."""
    text = {"rich": RICH, "leaning": LEANING}.get(name)
    model = symgen.derive(parsed(text) if text else name, kernels)
    tree = symgen.generate(model, target="cuda", dtype=dtype, prefix=name)
    symgen.write_package(tree, folder)
    return model


def states(model: symgen.Model, dtype: type) -> dict[str, dict[str, np.ndarray]]:
    """Inputs of every kernel with a batch: rows of states, and X for each state."""
    draw = np.random.default_rng(0)
    X = np.array([physical_parameters(model, random.Random(k)) for k in range(N)])
    found: dict[str, dict[str, np.ndarray]] = {}
    for kernel in model.kernels:
        if not kernel.batch:
            continue
        named = {a.name: draw.uniform(-2, 2, (N, a.size)) for a in kernel.inputs}
        named = {k: X[:, : v.shape[1]] if k == "X" else v for k, v in named.items()}
        shared = {a.name for a in kernel.inputs if a.shared and a.name != "X"}
        rows = {k: v[0] if k in shared else v for k, v in named.items()}
        found[kernel.name] = {k: np.ascontiguousarray(v, dtype) for k, v in rows.items()}
    return found


def pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    """The address of an array."""
    return ctypes.c_void_p(array.ctypes.data if array is not None else None)


@NO_GXX
@pytest.mark.parametrize(
    ("name", "dtype", "kernels"),
    [
        ("planar2r", "double", FEW),
        *(
            pytest.param(name, dtype, "all", marks=pytest.mark.slow)
            for name in ("rich", "leaning", "puma560")
            for dtype in ("double", "float")
        ),
    ],
)
def test_as_cxx_it_is_the_c_bit_for_bit(
    name: str, dtype: str, kernels: tuple[str, ...] | str, tmp_path: Path
) -> None:
    """With one X for all states, and with an X for each."""
    model = package(name, dtype, kernels, tmp_path)
    run(["gcc", *FLAGS, "-std=c99", *c_files(tmp_path), "-lm", "-o", "c.so"], tmp_path)
    warned = ("-Wall", "-Wextra", "-Werror", "-std=c++11")
    run(["g++", *FLAGS, *warned, "-x", "c++", f"{name}.cu", "-o", "cu.so"], tmp_path)
    in_c, in_cxx = (ctypes.CDLL(str(tmp_path / f"{x}.so")) for x in ("c", "cu"))
    real = {"double": np.float64, "float": np.float32}[dtype]
    inputs = states(model, real)
    assert inputs
    for kernel in model.kernels:
        if not kernel.batch:
            continue
        named = inputs[kernel.name]
        single = getattr(in_c, f"{name}_{kernel.name}")
        many = getattr(in_cxx, f"{name}_{kernel.name}_cuda")
        for each in (False, True) if "X" in named else (False,):
            given = {k: v[0] if k == "X" and not each else v for k, v in named.items()}
            link = {"link": ctypes.c_size_t(model.robot.numbers[-1])}
            wanted = [np.zeros((N, o.size), real) for o in kernel.outputs]
            statuses = np.zeros(N, np.intc)
            for k in range(N):
                row = [
                    link.get(a) or pointer(np.ascontiguousarray(v[k] if v.ndim == 2 else v))
                    for a, v in given.items()
                ]
                statuses[k] = single(*row, *(pointer(w[k]) for w in wanted))
            columns = {k: np.ascontiguousarray(v.T) for k, v in given.items()}
            found = [np.zeros((o.size, N), real) for o in kernel.outputs]
            status = np.full(N, -1, np.intc)
            head = [None, ctypes.c_size_t(N), *([int(each)] if "X" in named else [])]
            passed = [link.get(k) or pointer(v) for k, v in columns.items()]
            last = [pointer(status)] if kernel.fallible else []
            assert many(*head, *passed, *map(pointer, found), *last) == 0
            if kernel.fallible:
                np.testing.assert_array_equal(status, statuses)
            for a, b in zip(found, wanted, strict=True):
                assert a.T.tobytes() == b.tobytes(), kernel.name


@pytest.mark.slow
@pytest.mark.skipif(nvcc() is None, reason="no nvcc (pip install nvidia-cuda-nvcc)")
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_nvcc_compiles_it_and_what_spills_is_known(dtype: str, tmp_path: Path) -> None:
    """Prints registers and bytes of spills, by kernel and architecture."""
    package("panda", dtype, "all", tmp_path)
    for architecture in ARCHITECTURES:
        found = compiled(tmp_path / "panda.cu", architecture)
        for kernel, (registers, spills) in found.items():
            print(f"{dtype} {architecture} {kernel}: {registers} registers, {spills} bytes")
        spilling = {kernel.split()[0] for kernel, (_, spills) in found.items() if spills}
        assert spilling <= SPILLING[dtype]
        assert len(found) > 20
