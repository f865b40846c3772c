"""A kernel in several functions: the same numbers, and no function longer than it may be."""

from __future__ import annotations

import random
import re
import shutil
import subprocess

import numpy as np
import pytest

import symgen
from symgen.codegen import parts
from symgen.codegen.verification import physical_parameters

KERNELS = ("torque_regressor", "forward_dynamics", "energy_regressor")


def functions(text: str) -> dict[str, int]:
    """Statements of each function of a C file."""
    return {
        name: body.count(";")
        for name, body in re.findall(r"(\w+)\([^)]*\)\n\{\n(.*?)\n\}\n", text, re.DOTALL)
    }


@pytest.fixture
def model():
    """An arm with several kernels."""
    return symgen.derive(symgen.read_robot("puma560"), KERNELS)


@pytest.fixture
def short(monkeypatch):
    """Functions of 60 statements, as if that were the limit."""
    monkeypatch.setattr(parts, "LIMIT", 60)


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_every_function_keeps_to_the_limit(model, dtype):
    tree = symgen.generate(model, target="c", dtype=dtype)
    for kernel in KERNELS:
        found = functions(tree.files[f"{tree.name}_{kernel}.c"].decode())
        assert sum(name.startswith("part_") for name in found) > 1
        # a loop of zeros has two more semicolons
        assert max(found.values()) <= 60 + 8, (kernel, found)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
def test_parts_compute_what_the_whole_does(model, tmp_path, monkeypatch, request):
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("SYMGEN_FLAGS", "plain")
    whole = symgen.load(model, backend="c")
    request.getfixturevalue("short")
    cut = symgen.load(model, backend="c")
    draw = np.random.default_rng(0)
    X = np.array(physical_parameters(model, random.Random(1)))
    for kernel in KERNELS:
        inputs = [
            X if name == "X" else draw.uniform(-2, 2, len(symbols))
            for name, symbols in whole[kernel].kernel.tape.inputs
        ]
        np.testing.assert_allclose(
            cut[kernel](*inputs), whole[kernel](*inputs), rtol=1e-12, atol=1e-12
        )
    with pytest.raises(symgen.ParameterError, match="not positive definite"):
        cut["forward_dynamics"](*inputs[:1] * 3, -X)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_parts_are_c99_without_a_warning(model, dtype, tmp_path):
    sources = symgen.generate(model, target="c", dtype=dtype).library
    for name, content in sources.items():
        (tmp_path / name).write_bytes(content)
    command = ["cc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-c"]
    files = sorted(name for name in sources if name.endswith(".c"))
    done = subprocess.run([*command, *files], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_short_kernel_is_one_function(model):
    tree = symgen.generate(model, target="c")
    assert all(b"part_1" not in content for content in tree.files.values())
