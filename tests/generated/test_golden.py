"""The golden set: generating again gives the same bytes; literals are their numbers."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given
from hypothesis import strategies as st
from support import PROJECT

from symgen.codegen.c_printer import literal

GOLDEN = PROJECT / "generated"
PACKAGES = ("planar2r", "puma560")

# Generates in a fresh interpreter.
DIGESTS = """
import hashlib, json, sys, symgen
for name in sys.argv[1:]:
    files = symgen.generate(symgen.derive(symgen.read_robot(name))).files
digests = {k: hashlib.sha256(v).hexdigest() for k, v in files.items()}
print(json.dumps([list(files), digests]))
"""


@pytest.mark.parametrize("name", PACKAGES)
def test_generating_again_gives_the_golden_package(name, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = command("generate", name, "--check", GOLDEN / name)
    assert (code, out) == (0, "")
    assert list(tmp_path.iterdir()) == []


def test_files_that_differ_or_are_missing_or_extra_are_named(command, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(GOLDEN / "planar2r", copy)
    spoiled = ["README.md", "manifest.json", "mex/planar2r_mex.c", "planar2r.h"]
    spoiled += ["planar2r_casadi.py", "planar2r_energy_regressor.c"]
    for name in spoiled:
        content = bytearray((copy / name).read_bytes())
        content[len(content) // 2] ^= 1
        (copy / name).write_bytes(content)
    (copy / "planar2r_least_squares.c").unlink()
    (copy / "notes.c").write_text("int x;\n")
    before = {p: p.read_bytes() for p in copy.rglob("*") if p.is_file()}
    code, out, _ = command("generate", "planar2r", "--check", copy)
    assert code == 1
    found = [tuple(line.split(": ")) for line in out.splitlines()]
    changed = [("missing", "planar2r_least_squares.c"), ("extra", "notes.c")]
    assert found == [*(("differs", name) for name in spoiled), *changed]
    assert {p: p.read_bytes() for p in copy.rglob("*") if p.is_file()} == before


def test_a_folder_that_is_none_is_refused(command, tmp_path):
    assert command("generate", "planar2r", "--check", tmp_path / "nowhere")[0] == 2


def test_bytes_do_not_depend_on_the_hash_seed_or_on_what_was_derived_before():
    jobs = [
        subprocess.Popen(
            [sys.executable, "-c", DIGESTS, *names],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(PROJECT), "PYTHONHASHSEED": seed},
        )
        for seed, names in (("0", ["scara"]), ("31337", ["stanford", "planar2r", "scara"]))
    ]
    first, other = (job.communicate(timeout=120)[0] for job in jobs)
    assert "scara_friction_power.c" in first
    assert other == first


# Literals.


def read_back(text: str, suffix: str) -> str:
    """Look at a literal: no binary or hexadecimal digits, and no integer."""
    assert re.fullmatch(rf"-?\d+(\.\d+)?(e[+-]?\d+)?{suffix}", text)
    assert "." in text or "e" in text
    return text.removesuffix("f")


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(5e-324)
@example(1.7976931348623157e308)
@example(1e16)
@example(0.1)
def test_a_double_literal_reads_back_as_the_same_number(x):
    assert float(read_back(literal(sp.Rational(*x.as_integer_ratio()), "double"), "")) == x


@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
@example(float(np.float32(1e-45)))
@example(float(np.finfo(np.float32).max))
def test_a_float_literal_reads_back_as_the_same_number(x):
    text = read_back(literal(sp.Rational(*x.as_integer_ratio()), "float"), "f")
    assert np.float32(text) == np.float32(x)


def test_an_exact_number_is_rounded_once():
    for number in (sp.sqrt(2) / 2, sp.cos(sp.pi / 8), sp.Rational(1, 3), sp.pi * 10**5):
        exact = Fraction(str(number.evalf(60)))
        near = float(literal(number, "double"))
        for other in (math.nextafter(near, -math.inf), math.nextafter(near, math.inf)):
            assert abs(Fraction(near) - exact) < abs(Fraction(other) - exact)


@pytest.mark.parametrize("name", PACKAGES)
def test_every_literal_of_the_golden_kernels_is_its_own_repr(name):
    literals = [
        number
        for file in [*(GOLDEN / name).glob("*_energy_*.c"), GOLDEN / name / f"{name}.h"]
        for number in re.findall(r"(?<![\w.])\d+\.\d+(?:e[+-]\d+)?", file.read_text())
    ]
    assert literals
    assert [n for n in literals if repr(float(n)) != n] == []
