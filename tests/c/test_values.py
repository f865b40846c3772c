"""NAME_values.h as the engineer who includes it sees it: compilers, values, the wrong package."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from packages import STRICT, STRICT_CXX

import symgen
from symgen.cli import cli
from symgen.estimation.values import Reason, Residual
from symgen.identification.estimate import (
    ROBOT_DIGEST,
    Consistency,
    Estimate,
    JointLabel,
    ParameterEstimate,
)

CC = shutil.which("cc")
NAME = "scara"
HOSTILE = "*/ #error x /*/ \\\n???/"
Q, QD, QDD = [0.3, -0.7, 0.1, 1.1], [1.0, -0.5, 0.2, 2.0], [0.4, 3.0, -1.0, 0.5]
PROGRAM = """#include "scara_values.h"
#include <stdio.h>
static void row(const scara_real *x, int n) {{
    int k;
    for (k = 0; k < n; ++k) {{ printf("%.17g ", (double)x[k]); }}
    printf("\\n");
}}
int main(void)
{{
    const scara_real q[] = {{ {q} }}, qd[] = {{ {qd} }}, qdd[] = {{ {qdd} }};
    scara_real tau[scara_JOINTS];
    scara_inverse_dynamics(q, qd, qdd, scara_values, tau);
    row(scara_values, scara_PARAMETERS);
    row(tau, scara_JOINTS);
    return 0;
}}
"""


@pytest.fixture(scope="module")
def model() -> symgen.Model:
    return symgen.derive(symgen.read_robot(NAME), ("energy_regressor", "inverse_dynamics"))


@pytest.fixture(scope="module")
def estimate(model: symgen.Model) -> Estimate:
    """Values of many sizes and signs; names of logs that would end the comment."""
    draw = np.random.default_rng(4)
    parameters = tuple(
        ParameterEstimate(p.name, p.expression, float(x), float(abs(x) / 7), p.unit)
        for p, x in zip(
            model.base.parameters, draw.normal(size=99) * 10.0 ** draw.uniform(-6, 3, 99),
            strict=False,
        )
    )  # fmt: skip
    return Estimate(
        robot=NAME,
        joints=(JointLabel(1, "N m"),) * 4,
        model="torque",
        method="wls",
        parameters=replace_some(parameters),
        condition_number=10.0,
        train=Residual(0.1),
        validation=Residual(0.1),
        torque_train=None,
        torque_validation=None,
        cutoff_hz=None,
        window_s=None,
        verdict="doubtful",
        reasons=(Reason("error", text="10 % error"), Reason("fault", text=HOSTILE)),
        notes=(),
        correlation=np.eye(len(parameters)),
        provenance=((HOSTILE, "x"),),
        physical=Consistency(3.0, Reason("effect_missing", text=f"FV1 is -3 {HOSTILE}")),
    )


def replace_some(parameters: tuple[ParameterEstimate, ...]) -> tuple[ParameterEstimate, ...]:
    """A zero, a tiny number and an unknown deviation among them."""
    first, second, *rest = parameters
    changed = (replace(first, value=0.0, std=float("nan")), replace(second, value=-1e-12))
    return (*changed, *rest)


def folder_of(model: symgen.Model, estimate: Estimate, dtype: str, folder: Path) -> Path:
    """A package with the header and a program that uses it."""
    symgen.write_package(symgen.generate(model, target="c", dtype=dtype, prefix=NAME), folder)
    suffix = "f" if dtype == "float" else ""
    rows = {
        key: ", ".join(f"{x}{suffix}" for x in row)
        for key, row in (("q", Q), ("qd", QD), ("qdd", QDD))
    }
    (folder / "scara_values.h").write_text(symgen.values_header(estimate))
    (folder / "main.c").write_text(PROGRAM.format(**rows))
    return folder


def build(command: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    sources = [f"{NAME}_inverse_dynamics.c", "-lm", "-o", "program"]
    return subprocess.run([*command, *sources], cwd=folder, capture_output=True, text=True)


@pytest.mark.parametrize(
    "compiler", ["gcc", *(pytest.param(c, marks=pytest.mark.slow) for c in ("clang", "g++"))]
)
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_header_compiles_strictly_and_its_values_reach_the_package(
    compiler, dtype, model, estimate, tmp_path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")
    folder = folder_of(model, estimate, dtype, tmp_path / NAME)
    how = [compiler, *(STRICT if compiler != "g++" else STRICT_CXX)]
    done = build([*how, "main.c"], folder)
    assert done.returncode == 0, done.stderr
    printed = subprocess.run([folder / "program"], capture_output=True, text=True, check=True)
    X, tau = (np.array(list(map(float, line.split()))) for line in printed.stdout.splitlines())
    kind = np.float32 if dtype == "float" else np.float64
    assert (estimate.X.astype(kind) == X).all()
    expected = symgen.load(model)["inverse_dynamics"](Q, QD, QDD, estimate.X)
    error = np.abs(tau - expected).max() / np.abs(expected).max()
    assert error < (1e-5 if dtype == "float" else 1e-14)


@pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
@pytest.mark.parametrize("change", ["another order", "one fewer", "another name"])
def test_header_of_another_set_of_parameters_does_not_compile(
    change, model, estimate, tmp_path
) -> None:
    found = list(estimate.parameters)
    if change == "another order":
        found[2], found[3] = found[3], found[2]
    elif change == "one fewer":
        found.pop()
    else:
        found[2] = replace(found[2], name="QQ7")
    folder = folder_of(model, estimate, "double", tmp_path / NAME)
    correlation = np.eye(len(found))
    wrong = replace(estimate, parameters=tuple(found), correlation=correlation)
    assert build(["cc", "main.c"], folder).returncode == 0
    (folder / "scara_values.h").write_text(symgen.values_header(wrong))
    assert build(["cc", "main.c"], folder).returncode != 0


@pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
def test_values_of_another_geometry_do_not_compile(model, estimate, tmp_path) -> None:
    # Same parameters in the same order: the lengths alone differ.
    source = symgen.read_robot("scara")
    joints = (replace(source.joints[0], r=source.joints[0].r + 1), *source.joints[1:])
    other = symgen.derive(replace(source, joints=joints), ("energy_regressor",))
    assert other.base.names == model.base.names
    for name, derived in (("own", model), ("other", other)):
        folder = tmp_path / name
        tree = symgen.generate(derived, target="c")
        symgen.write_package(tree, folder)
        toml = tree.files["robot.toml"]
        if name == "own":
            digest = ((ROBOT_DIGEST, hashlib.sha256(toml).hexdigest()),)
            header = symgen.values_header(replace(estimate, provenance=digest))
        (folder / "scara_values.h").write_text(header)
        (folder / "main.c").write_text('#include "scara_values.h"\nint main(void) { return 0; }\n')
        command = ["cc", "-std=c99", "main.c", "-o", "main"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert (done.returncode == 0) == (name == "own"), done.stderr


def test_values_go_with_a_float_package_by_its_prefix(estimate) -> None:
    assert '#include "scaraf.h"' in symgen.values_header(estimate, prefix="scaraf")


def test_header_says_what_the_estimate_says(estimate) -> None:
    text = symgen.values_header(estimate)
    assert text == symgen.values_header(replace(estimate))
    for p in estimate.parameters:
        line = next(x for x in text.splitlines() if f"){p.value!r}" in x)
        assert p.expression in line
        assert f"[{p.unit}]" in line
    assert estimate.reasons[0].text in text
    assert len(re.findall(r"/\*", text)) == len(re.findall(r"\*/", text))


def test_a_value_that_is_no_number_is_refused(estimate) -> None:
    first, *rest = estimate.parameters
    bad = replace(estimate, parameters=(replace(first, value=float("nan")), *rest))
    with pytest.raises(symgen.ParameterError, match=first.name):
        symgen.values_header(bad)


URDF = """<robot name="pair">
  <link name="base"/>
  <joint name="lift" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="3"/>
    <dynamics damping="0.7" friction="0.3"/></joint>
  <link name="upper"><inertial><origin xyz="0.2 0.01 0.03"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.05" izz="0.06" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="20" velocity="3"/></joint>
  <link name="lower"><inertial><origin xyz="0.15 0 0"/><mass value="1.5"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>
"""

#: Prints X of the header, X from its standard parameters, and the torque of the first.
OWN = """
#include <stdio.h>
#include "pair_values.h"
int main(void)
{
    double X[pair_PARAMETERS], tau[2];
    const double q[2] = {0.3, -0.7}, qd[2] = {0.5, -1.0}, qdd[2] = {2.0, 1.0};
    pair_base_parameters(pair_standard_values, X);
    pair_inverse_dynamics(q, qd, qdd, pair_values, tau);
    for (int i = 0; i < pair_PARAMETERS; i++) printf("%.17g %.17g ", pair_values[i], X[i]);
    printf("\\n%.17g %.17g\\n", tau[0], tau[1]);
    return 0;
}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> Path:
    """A package with the inertias of the robot file itself."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "pair.urdf").write_text(URDF)
    command = [sys.executable, "-m", "symgen", "generate", "pair.urdf", "--parameters", "pair.urdf"]
    subprocess.run([*command, "--into", "pair"], cwd=folder, check=True, capture_output=True)
    return folder / "pair"


@pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
def test_a_robot_files_own_inertias_become_the_values(own, tmp_path) -> None:
    import pinocchio

    (tmp_path / "main.c").write_text(OWN)
    sources = [own / f"pair_{kernel}.c" for kernel in ("inverse_dynamics", "base_parameters")]
    command = ["cc", "-std=c99", f"-I{own}", "main.c", *map(str, sources), "-lm", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    X, tau = (np.array(list(map(float, line.split()))) for line in done.stdout.splitlines())
    np.testing.assert_allclose(X[::2], X[1::2], rtol=1e-12, atol=1e-15)
    model = pinocchio.buildModelFromXML(URDF)
    v = np.array([0.5, -1.0])
    q, qdd = np.array([0.3, -0.7]), np.array([2.0, 1.0])
    expected = pinocchio.rnea(model, model.createData(), q, v, qdd)
    expected += [0.3 * np.sign(v[0]) + 0.7 * v[0], 0.0]
    np.testing.assert_allclose(tau, expected, rtol=1e-12)
    standard = json.loads((own / "manifest.json").read_text())["standard_names"]
    header = " ".join((own / "pair.h").read_text().replace("*", " ").split())
    assert f"in this order: {', '.join(standard)} " in header


def test_octave_returns_the_values(own, tmp_path) -> None:
    if any(shutil.which(tool) is None for tool in ("octave", "mkoctfile")):
        pytest.skip("octave or mkoctfile is not on this machine")
    call = f"addpath('{own / 'mex'}'); pair_build(); printf('%.17g ', pair_mex('values'));"
    command = ["octave", "--no-gui", "--norc", "--quiet", "--eval", call]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    values = json.loads((own / "manifest.json").read_text())["options"]["values"]
    assert list(map(float, done.stdout.split())) == values["X"]


def test_values_of_an_estimate_say_what_it_is_good_for(estimate, tmp_path) -> None:
    (tmp_path / "estimate.json").write_text(json.dumps(estimate.to_json()))
    command = ["generate", NAME, "--kernels", "inverse_dynamics", "--target", "c"]
    options = ["--parameters", str(tmp_path), "--into", str(tmp_path / "package")]
    done = CliRunner().invoke(cli, [*command, *options])
    assert done.exit_code == 0, done.output
    header = (tmp_path / "package" / f"{NAME}_values.h").read_text()
    expected = symgen.values_header(estimate)
    assert HOSTILE not in header
    assert header.split("static const")[1] == expected.split("static const")[1]


def test_values_of_an_estimate_that_no_robot_can_have_are_refused(estimate, tmp_path) -> None:
    impossible = replace(estimate, method="consistent")
    (tmp_path / "estimate.json").write_text(json.dumps(impossible.to_json()))
    options = ["--parameters", str(tmp_path), "--into", str(tmp_path / "package")]
    done = CliRunner().invoke(cli, ["generate", NAME, "--target", "c", *options])
    assert isinstance(done.exception, symgen.ParameterError)
