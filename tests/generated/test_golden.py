"""The golden set: generating again gives the same bytes, and a spoiled file never passes."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given
from hypothesis import strategies as st
from support import sampled

import symgen
from symgen.codegen.c_printer import literal
from symgen.codegen.verification import TOLERANCE

PROJECT = Path(__file__).resolve().parents[2]
GOLDEN = PROJECT / "generated"
PACKAGES = sorted(p.parent.name for p in GOLDEN.glob("*/manifest.json"))

# Generates in a fresh interpreter.
DIGESTS = """
import hashlib, json, sys, symgen
for name in sys.argv[1:]:
    files = symgen.generate(symgen.derive(symgen.read_robot(name))).files
digests = {k: hashlib.sha256(v).hexdigest() for k, v in files.items()}
print(json.dumps([list(files), digests]))
"""


def python(*arguments: str, **environment: str) -> subprocess.Popen[str]:
    """Start a Python that finds this checkout."""
    return subprocess.Popen(
        [sys.executable, *arguments],
        cwd=PROJECT,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the golden planar2r to be spoiled; compiling plays no part in comparing."""
    monkeypatch.setattr("symgen.runtime.check.find_compiler", lambda: None)
    return Path(shutil.copytree(GOLDEN / "planar2r", tmp_path / "planar2r"))


def files(folder: Path) -> set[str]:
    """The paths of all files of a package, relative to it."""
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def differences(folder: Path) -> tuple[str, ...]:
    (result,) = symgen.check(folder)
    return result.differences


# Equal.


def test_golden_set_is_what_generating_again_gives_and_agrees_with_50_digits(monkeypatch):
    # What a compiler says of stacks is looked at by tests of its own.
    monkeypatch.setattr("symgen.runtime.check.worst_case_stack", lambda *_: None)
    results = symgen.check(GOLDEN)
    assert [r.folder.name for r in results] == PACKAGES
    assert {"panda", "planar2r", "puma560"} <= set(PACKAGES)
    assert {r.folder.name: r.differences for r in results if r.differences} == {}
    for result in results:
        manifest = json.loads((result.folder / "manifest.json").read_text())
        assert result.rank == len(manifest["base_parameters"])
        assert {k for _, k, _ in result.errors} == set(manifest["verification"]["points"])
        assert max(e for _, _, e in result.errors) <= manifest["verification"]["tolerance"]


@pytest.mark.parametrize("name", PACKAGES)
def test_manifest_digests_are_those_of_the_files(name):
    folder = GOLDEN / name
    digests = json.loads((folder / "manifest.json").read_text())["digests"]
    names = files(folder) - {"manifest.json"}
    assert set(digests) == names
    found = {n: hashlib.sha256((folder / n).read_bytes()).hexdigest() for n in names}
    assert found == digests


def test_bytes_do_not_depend_on_the_hash_seed_or_on_what_was_derived_before():
    jobs = [
        python("-c", DIGESTS, "tx40", PYTHONHASHSEED="0"),
        python("-c", DIGESTS, "stanford", "planar2r", "tx40", PYTHONHASHSEED="31337"),
    ]
    answers = [job.communicate(timeout=120) for job in jobs]
    assert [job.returncode for job in jobs] == [0, 0], [err for _, err in answers]
    first, other = (out for out, _ in answers)
    assert "tx40_friction_power.c" in first
    assert other == first


def test_a_package_generates_itself():
    model = symgen.derive(symgen.read_robot(GOLDEN / "planar2r"), "all")
    again = symgen.generate(model)
    assert files(GOLDEN / "planar2r") == set(again.files)


# Different.


def test_every_byte_counts_in_each_text_file(copy):
    names = sorted(
        n
        for n in files(copy)
        if n.endswith((".c", ".h", ".hpp", ".txt", ".md", ".in", ".xml", ".m", ".py"))
    )
    assert len(names) == 80
    for name in names:
        content = (copy / name).read_bytes()
        (copy / name).write_bytes(content + b"\n")
    assert {d.split(":")[0] for d in differences(copy)} == set(names)


def test_a_spoiled_constant_in_a_kernel_is_found_with_its_line(copy):
    kernel = copy / "planar2r_energy_regressor.c"
    text = kernel.read_text()
    assert "= 0.5 * W32;" in text
    kernel.write_text(text.replace("= 0.5 * W32;", "= 0.50000000000000011 * W32;"))
    line = 1 + text[: text.index("= 0.5 * W32;")].count("\n")
    assert differences(copy) == (f"planar2r_energy_regressor.c: line {line} differs",)


def test_changed_casadi_code_is_found_and_never_run(copy, tmp_path):
    file, marker = copy / "planar2r_casadi.py", tmp_path / "ran"
    text = file.read_text()
    file.write_text(f"open({str(marker)!r}, 'w').close()\n{text}")
    assert differences(copy) == ("planar2r_casadi.py: line 1 differs",)
    assert not marker.exists()
    # The file is no dud: whoever imports it runs what it says.
    subprocess.run([sys.executable, "-B", str(file), "--save", str(tmp_path / "saved")], check=True)
    assert marker.exists()
    assert len(list((tmp_path / "saved").glob("*.casadi"))) > 20


def test_check_measures_every_casadi_function(copy):
    (checked,) = symgen.check(copy)
    kernels = json.loads((copy / "manifest.json").read_text())["options"]["kernels"]
    errors = {kernel: error for backend, kernel, error in checked.errors if backend == "casadi"}
    assert set(errors) == set(kernels)
    assert max(errors.values()) < TOLERANCE["double"]


@pytest.mark.parametrize("part", sampled(["points", "expected"], 1))
def test_a_spoiled_verification_value_is_found(copy, part):
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    entry = manifest["verification"][part]["energy_regressor"][0]
    if part == "points":
        entry["q"][1] += 1e-6
    else:
        entry[0] = f"{entry[0][:-1]}{(int(entry[0][-1]) + 1) % 10}"
    path.write_text(json.dumps(manifest, indent=1) + "\n")
    (found,) = differences(copy)
    assert re.fullmatch(r"manifest.json: line \d+ differs", found)


def test_errors_are_measured_at_fresh_points_whatever_the_manifest_says(copy):
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["verification"]["expected"]["energy_regressor"][0][0] = "1.0"
    path.write_text(json.dumps(manifest, indent=1) + "\n")
    (result,) = symgen.check(copy)
    assert result.differences != ()
    assert "energy_regressor" in [k for _, k, _ in result.errors]
    assert max(e for _, _, e in result.errors) <= 1e-13


SPOILED = {
    "empty": lambda m: m["verification"].clear(),
    "no-expected": lambda m: m["verification"]["expected"].clear(),
    "row": lambda m: m["verification"]["expected"]["energy_regressor"].pop(),
    "entry": lambda m: m["verification"]["expected"]["energy_regressor"][0].pop(),
    "word": lambda m: m["verification"]["expected"]["energy_regressor"][0].__setitem__(0, "many"),
    "no-q": lambda m: m["verification"]["points"]["energy_regressor"][0].pop("q"),
    "long-q": lambda m: m["verification"]["points"]["energy_regressor"][0]["q"].append(1.0),
    "kernels": lambda m: m["options"].__setitem__("kernels", 3),
    "dtype": lambda m: m["options"].__setitem__("dtype", ["double"]),
}


@pytest.mark.parametrize("spoil", sampled(SPOILED, 3))
def test_a_manifest_of_the_wrong_shape_is_different_or_refused_in_one_line(copy, spoil):
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    SPOILED[spoil](manifest)
    path.write_text(json.dumps(manifest, indent=1) + "\n")
    try:
        found = differences(copy)
    except symgen.SymgenError as error:
        found = (str(error),)
    assert found
    assert all("\n" not in line for line in found)


def test_an_extra_and_a_missing_file_are_found(copy):
    (copy / "planar2r_least_squares.c").unlink()
    (copy / "notes.c").write_text("int x;\n")
    assert set(differences(copy)) == {
        "planar2r_least_squares.c: missing",
        "notes.c: not part of the package",
    }


def test_a_changed_robot_is_found_in_what_follows_from_it(copy):
    robot = copy / "robot.toml"
    robot.write_text(robot.read_text().replace("L1 = 0.5", "L1 = 0.6"))
    found = {d.split(":")[0] for d in differences(copy)}
    assert {"planar2r.h", "planar2r_check.c", "planar2r_casadi.py"} <= found


def test_command_line_says_different_by_exit_code_1(tmp_path):
    for name in ("planar2r", "spoiled"):
        shutil.copytree(GOLDEN / "planar2r", tmp_path / name)
    kernel = tmp_path / "spoiled" / "planar2r_energy_regressor.c"
    kernel.write_text(kernel.read_text().replace("0.5", "0.51", 1))
    (tmp_path / "empty").mkdir()
    code = "import sys; sys.argv[0] = 'symgen'; from symgen.cli import main; main()"
    jobs = [
        python("-c", code, "check", str(folder), SYMGEN_CC="none")
        for folder in (tmp_path / "planar2r", tmp_path, tmp_path / "empty")
    ]
    answers = [job.communicate(timeout=120) for job in jobs]
    assert [job.returncode for job in jobs] == [0, 1, 2], answers
    assert "planar2r_energy_regressor.c: line" in answers[1][0]
    assert answers[2][1].splitlines()[-1].startswith("symgen: error: ")


# Literals.


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(5e-324)
@example(1.7976931348623157e308)
@example(1e16)
@example(0.1)
def test_a_double_literal_reads_back_as_the_same_number(x):
    text = literal(sp.Rational(*x.as_integer_ratio()), "double")
    assert float(text) == x
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", text)
    assert "." in text or "e" in text


@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
@example(float(np.float32(1e-45)))
@example(float(np.finfo(np.float32).max))
def test_a_float_literal_reads_back_as_the_same_number(x):
    text = literal(sp.Rational(*x.as_integer_ratio()), "float")
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?f", text)
    assert "." in text or "e" in text
    assert np.float32(text[:-1]) == np.float32(x)


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
