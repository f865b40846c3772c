"""The target rust: two crates in one program, against the check values of their packages."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import symgen
from symgen.codegen.values import Values

pytestmark = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in ("cargo", "cc", "ar")),
    reason="cargo, cc or ar is not on this machine",
)
#: Joints with names that are keywords of Rust, or no identifiers.
ARM = """
[robot]
name = "Arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
name = "self"
[[joint]]
name = "2nd axis"
d = 0.5
"""
#: Gravity is an input, and the package is in float.
LEANING = """
[robot]
name = "leaning"
gravity = "input"
[[joint]]
friction = []
[[joint]]
sigma = 1
alpha = "pi/2"
"""
FEW = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "link_jacobian", "add_body")
X = [1.25, -0.5, 3.14159, 1e-5]
CARGO = """
[package]
name = "program"
version = "0.1.0"
edition = "2021"

[dependencies]
arm_model = { path = "Arm" }
leaningf_model = { path = "leaningf" }
"""
MAIN = """
fn check(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (a, b) in found.iter().zip(expected) {
        let error = (a - b).abs();
        assert!(error <= tolerance * largest, "{name}: {a} is not {b}");
    }
}

fn main() {
    arm_model::warm();
    leaningf_model::warm();
    assert_eq!(arm_model::JOINTS, 2);
    assert_eq!(arm_model::joint::SELF, 0);
    assert_eq!(arm_model::joint::JOINT_2ND_AXIS, 1);
    assert_eq!(arm_model::parameter::ZZ1R, 0);
    assert_eq!(arm_model::VALUES[..4], VALUES);
    failures();
CALLS}

fn failures() {
    use arm_model::{Status, PARAMETERS};
    let (zeros, mut out) = ([0.0; 2], [7.0; 2]);
    let none = arm_model::forward_dynamics(&zeros, &zeros, &zeros, &[-1.0; PARAMETERS], &mut out);
    assert_eq!(none, Err(Status::NotPositiveDefinite));
    let nan = [f64::NAN; PARAMETERS];
    let unknown = arm_model::forward_dynamics(&zeros, &zeros, &zeros, &nan, &mut out);
    assert_eq!(unknown, Err(Status::NotFinite));
    let mut J = [7.0; 12];
    for link in [0, 3] {
        let nowhere = arm_model::link_jacobian(&zeros, link, &[0.0; 3], &mut J);
        assert_eq!(nowhere, Err(Status::NoSuchLink));
        assert_eq!(J, [7.0; 12]);
    }
}
"""


def array(values: Sequence[Any], size: int) -> str:
    """An array in Rust; entries that no function reads are not numbers."""
    entries = [f"{float(v)!r}" for v in values] + ["f64::NAN"] * (size - len(values))
    return f"[{', '.join(entries)}]"


def calls(package: Path, crate: str) -> str:
    """A block for each check value of the manifest: the call, and the comparison."""
    manifest = json.loads((package / "manifest.json").read_text())
    checks, p = manifest["verification"], len(manifest["base_parameters"])
    real = "f32" if manifest["options"]["dtype"] == "float" else "f64"
    blocks = []
    for kernel in manifest["kernels"]:
        name, outputs = kernel["name"], kernel["outputs"]
        changed = {o["name"] for o in outputs}
        for point, expected in zip(checks["points"][name], checks["expected"][name], strict=True):
            lines, words, begin = [], [], 0
            for key, values in point.items():
                if key == "link":
                    words.append(str(values[0]))
                elif key == "mass":
                    words.append(f"{values[0]!r}")
                else:
                    size = p if key == "X" else len(values)
                    typed = array(values, size).replace("f64::NAN", f"{real}::NAN")
                    lines.append(f"let mut {key}: [{real}; {size}] = {typed};")
                    words.append(f"&mut {key}" if key in changed else f"&{key}")
            for output in outputs:
                size = 1
                for length in output["shape"]:
                    size *= length
                key = output["name"]
                if key not in point:
                    lines.append(f"let mut {key} = [0.0 as {real}; {size}];")
                    words.append(f"&mut {key}")
                wanted = array(expected[begin : begin + size], size)
                begin += size
                compared = f"&{key}.map(f64::from), &{wanted}, {checks['tolerance']!r}"
                lines.append(f'check("{name}", {compared});')
            call = f"{crate}::{name}({', '.join(words)})"
            fallible = "link" in point or name in FALLIBLE
            place = next(i for i, line in enumerate(lines) if line.startswith("check"))
            lines.insert(place, f"{call}.unwrap();" if fallible else f"{call};")
            declared = [line for line in lines if line.startswith("let")]
            rest = [line for line in lines if not line.startswith("let")]
            blocks.append("{ " + " ".join([*declared, *rest]) + " }")
    return "".join(f"    {block}\n" for block in blocks)


#: Functions without a link that return a status.
FALLIBLE = (
    "forward_dynamics",
    "forward_dynamics_derivatives",
    "solve_mass_matrix",
    "mass_matrix_factor",
)


def cargo(folder: Path, *words: str) -> str:
    """Run cargo without a network; it must succeed without a warning."""
    done = subprocess.run(
        ["cargo", *words, "--offline"],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "RUSTFLAGS": "-D warnings"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def written(text: str, folder: Path, dtype: str, kernels: Any, known: bool) -> Path:
    """Write the crate of a robot."""
    model = symgen.derive(symgen.parse_robot(text), kernels)
    p = len(model.base.parameters)
    values = Values(tuple(X[k % 4] for k in range(p)), (None,) * p) if known else None
    tree = symgen.generate(model, target="rust", dtype=dtype, values=values)
    symgen.write_package(tree, folder / tree.name)
    return folder / tree.name


@pytest.mark.parametrize("kernels", [FEW, pytest.param("all", marks=pytest.mark.slow)])
def test_two_crates_in_one_program_give_the_check_values(kernels: Any, tmp_path: Path) -> None:
    arm = written(ARM, tmp_path, "double", kernels, known=True)
    leaning = written(LEANING, tmp_path, "float", kernels, known=False)
    (tmp_path / "Cargo.toml").write_text(CARGO)
    (tmp_path / "src").mkdir()
    text = calls(arm, "arm_model") + calls(leaning, "leaningf_model")
    head = "#![allow(unused_mut, non_snake_case)]\n"
    known = f"const VALUES: [f64; 4] = {array(X, 4)};\n"
    main = head + known + MAIN.replace("CALLS", text)
    (tmp_path / "src" / "main.rs").write_text(main)
    cargo(tmp_path, "run")


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_clippy_finds_nothing_in_a_crate(dtype: str, tmp_path: Path) -> None:
    if shutil.which("cargo-clippy") is None:
        pytest.skip("clippy is not on this machine")
    cargo(written(ARM, tmp_path, dtype, "all", known=True), "clippy", "--all-targets")


def test_a_crate_needs_neither_the_standard_library_nor_other_crates(tmp_path: Path) -> None:
    crate = written(ARM, tmp_path, "double", FEW, known=False)
    assert "#![no_std]" in (crate / "src" / "lib.rs").read_text()
    assert "std::" not in (crate / "src" / "lib.rs").read_text()
    listed = json.loads(cargo(crate, "metadata", "--format-version", "1"))
    assert [package["name"] for package in listed["packages"]] == ["arm_model"]
    assert "VALUES" not in (crate / "src" / "lib.rs").read_text()


def test_cc_and_ar_of_the_target_build_the_c(tmp_path: Path) -> None:
    crate = written(ARM, tmp_path, "double", FEW, known=False)
    host = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    target = next(line.split()[1] for line in host.splitlines() if line.startswith("host:"))
    called = tmp_path / "called"
    compiler = tmp_path / "compiler"
    compiler.write_text(f'#!/bin/sh\necho "$@" >> {called}\nexec cc "$@"\n')
    compiler.chmod(0o755)
    environment = {**os.environ, f"CC_{target.replace('-', '_')}": f"{compiler} -DCHOSEN"}
    environment |= {"CC": "no-such-compiler", "CFLAGS": "-DMORE"}
    command = ["cargo", "build", "--offline"]
    subprocess.run(command, cwd=crate, env=environment, check=True, capture_output=True)
    lines = called.read_text().splitlines()
    assert len(lines) == len(list(crate.glob("*.c")))
    flags = ("-DCHOSEN", "-DMORE", "-O2", "-std=c99", "-ffp-contract=fast", "-fPIC")
    assert all(flag in line for line in lines for flag in flags)
    failed = subprocess.run(
        command, cwd=crate, env={**os.environ, "CC": "no-such-compiler"}, capture_output=True
    )
    assert failed.returncode != 0
    assert b"no-such-compiler" in failed.stderr
