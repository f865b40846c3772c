"""What keeps the user of a package from computing garbage without a word."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from packages import STRICT, c_files, casadi_functions, run

import symgen
from symgen.cli import cli

CC, GCC, CMAKE = (shutil.which(tool) for tool in ("cc", "gcc", "cmake"))
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
PLANE = """
[robot]
name = "plane"
gravity = [0.0, -9.81, 0.0]
[geometry]
L1 = {length}
[[joint]]
[[joint]]
d = "L1"
"""
KERNELS = ("gravity_torque", "forward_dynamics", "jacobian", "inverse_dynamics", "frames")
OF_LINKS = ("link_jacobian", "link_drift", "add_body")


def package(folder: Path, dtype: str = "double", length: float = 0.5, **options: Any) -> Path:
    """Write the package of a two-link arm into a folder."""
    kernels = options.get("kernels", KERNELS)
    derived = symgen.derive(symgen.parse_robot(PLANE.format(length=length)), kernels)
    symgen.write_package(symgen.generate(derived, dtype=dtype, **options), folder)
    return folder


def printed(folder: Path, program: str, *packages: Path) -> str:
    """Build a program over packages under strict warnings and return what it prints."""
    (folder / "main.c").write_text(program)
    sources = [f for p in packages for f in c_files(p)]
    include = [f"-I{p}" for p in packages]
    run(["cc", *STRICT, *include, "main.c", *sources, "-lm", "-o", "main"], folder)
    return run([folder / "main"], folder)


@needs_cc
def test_float_and_double_packages_of_one_robot_work_in_one_program(tmp_path) -> None:
    both = [package(tmp_path / dtype, dtype) for dtype in ("double", "float")]
    program = """
    #include "plane.h"
    #include "planef.h"
    #include <stdio.h>
    int main(void)
    {
        const double q[2] = {0.3, 0.4};
        const float qf[2] = {0.3f, 0.4f};
        double X[plane_PARAMETERS] = {0}, tau[2];
        float Xf[planef_PARAMETERS] = {0}, tauf[2];
        for (int i = 0; i < plane_PARAMETERS; i++) {
            X[i] = 1.0 + i;
            Xf[i] = 1.0f + (float)i;
        }
        plane_gravity_torque(q, X, tau);
        planef_gravity_torque(qf, Xf, tauf);
        printf("%.9g %.9g %.9g %.9g", tau[0], tau[1], (double)tauf[0], (double)tauf[1]);
        return plane_MODEL_DIGEST == planef_MODEL_DIGEST ? 0 : 1;
    }
    """
    a, b, c, d = map(float, printed(tmp_path, program, *both).split())
    np.testing.assert_allclose([c, d], [a, b], atol=1e-6 * abs(a))
    assert abs(a) > 1


@needs_cc
def test_a_prefix_names_every_file_and_symbol_and_the_package_checks(tmp_path) -> None:
    into = tmp_path / "any"
    options = ["--prefix", "left_arm", "--kernels", "jacobian,energy_regressor"]
    done = CliRunner().invoke(cli, ["generate", "planar2r", *options, "--into", str(into)])
    assert done.exit_code == 0, done.output
    plain = {".symgen.sha256", "README.md", "CMakeLists.txt", "manifest.json", "robot.toml", "mex"}
    plain.add("check")
    assert all(f.name.startswith("left_arm") for f in (into / "mex").iterdir())
    assert {f.name for f in into.iterdir() if not f.name.startswith("left_arm")} == plain
    assert "left_arm_jacobian(const double q[2]" in (into / "left_arm.h").read_text()
    run(["cc", *STRICT, *c_files(into, check=True), "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)


@pytest.mark.parametrize("prefix", ["", "2r", "math", "int", "a b", "../x"])
def test_a_prefix_that_c_does_not_accept_is_refused(prefix) -> None:
    derived = symgen.derive(symgen.read_robot("planar2r"), ("jacobian",))
    with pytest.raises(symgen.PackageError, match="prefix"):
        symgen.generate(derived, prefix=prefix)


@pytest.mark.skipif(GCC is None, reason="gcc is not on this machine")
def test_an_array_that_is_too_short_does_not_compile_strictly(tmp_path) -> None:
    folder = package(tmp_path / "plane")
    for size, built in (("plane_PARAMETERS", True), ("plane_PARAMETERS - 2", False)):
        (tmp_path / "main.c").write_text(
            '#include "plane.h"\nint main(void)\n{\n'
            "    const double q[2] = {0};\n    double tau[2];\n"
            f"    const double X[{size}] = {{0}};\n    plane_inverse_dynamics(q, q, q, X, tau);\n"
            "    return tau[0] > 0.0;\n}\n"
        )
        command = ["gcc", *STRICT, "-O1", f"-I{folder}", "-c", "main.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert (done.returncode == 0) == built, done.stderr


def test_casadi_functions_return_true_matrices(tmp_path) -> None:
    folder = package(tmp_path / "plane")
    functions = casadi_functions(folder, "plane")
    evaluator = symgen.load(symgen.derive(symgen.read_robot(folder), KERNELS), backend="casadi")
    q = [0.3, -0.8]
    for kernel, shape in (("jacobian", (6, 2)), ("frames", (8, 4)), ("gravity_torque", (2, 1))):
        function = functions[kernel]
        assert function.name() == f"plane_casadi_{kernel}"
        assert function.size_out(0) == shape
        inputs = [q, np.arange(1.0, 1 + function.size_in(1)[0])] if function.n_in() == 2 else [q]
        expected = np.reshape(evaluator[kernel](*inputs), shape)
        np.testing.assert_array_equal(np.array(function(*inputs)), expected)


@needs_cc
def test_forward_dynamics_has_a_status_for_each_reason(tmp_path) -> None:
    program = """
    #include "plane.h"
    #include <math.h>
    #include <stdio.h>
    static int status(double q, double tau, double inertia)
    {
        const double place[2] = {0.1, q}, speed[2] = {0}, torque[2] = {1.0, tau};
        double X[plane_PARAMETERS] = {0}, qdd[2];
        X[plane_ZZ1R] = 3.0;
        X[plane_ZZ2] = inertia;
        return plane_forward_dynamics(place, speed, torque, X, qdd);
    }
    int main(void)
    {
        double q[4] = {0}, tau[4] = {NAN, 0, 0, 0}, qdd[4];
        double X[plane_PARAMETERS] = {0};
        X[plane_ZZ1R] = X[plane_ZZ2] = 1.0;
        printf("%d %d %d %d %d %d %d ", status(0, 0, 1), status(0, (double)NAN, 1),
               status((double)INFINITY, 0, 1), status(0, 0, -1), status(0, 0, 0),
               status(0, 1e308 * 10, 1), status(0, 0, (double)NAN));
        printf("%d", plane_forward_dynamics_batch(2, q, q, tau, X, qdd));
        return plane_OK;
    }
    """
    folder = package(tmp_path / "plane")
    header = (folder / "plane.h").read_text()
    named = dict(re.findall(r"plane_(OK|NOT_POSITIVE_DEFINITE|NOT_FINITE) = (\d)", header))
    assert named == {"OK": "0", "NOT_POSITIVE_DEFINITE": "1", "NOT_FINITE": "2"}
    assert printed(tmp_path, program, folder).split() == list("02211222")


@needs_cc
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_a_link_that_the_robot_has_not_is_a_status_and_nothing_is_written(tmp_path, dtype) -> None:
    program = """
    #include "plane.h"
    #include <stdint.h>
    #include <stdio.h>
    enum { N = 2, SIZE = 12 * N };
    static plane_real out[SIZE];
    static void mark(void)
    {
        for (int i = 0; i < SIZE; ++i) {
            out[i] = 7;
        }
    }
    static void say(int status)
    {
        int written = 0;
        for (int i = 0; i < SIZE; ++i) {
            written += !(out[i] >= 7 && out[i] <= 7);
        }
        printf("%d:%d ", status, written > 0);
        mark();
    }
    int main(void)
    {
        const size_t links[] = { 0, 1, 2, 3, SIZE_MAX };
        const plane_real a[6 * N] = { 1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6 };
        mark();
        for (int i = 0; i < 5; ++i) {
            say(plane_link_jacobian(a, links[i], a, out));
            say(plane_link_jacobian_batch(N, a, links[i], a, out));
            say(plane_link_drift(a, a, links[i], a, out));
            say(plane_link_drift_batch(N, a, a, links[i], a, out));
            say(plane_add_body(out, links[i], 2, a, a));
        }
        return plane_OK;
    }
    """
    folder = package(tmp_path / "plane", dtype, kernels=OF_LINKS, prefix="plane")
    assert "plane_NO_SUCH_LINK = 16" in (folder / "plane.h").read_text()
    wrong, right = ["16:0"] * 5, ["0:1"] * 5
    expected = [*wrong, *right, *right, *wrong, *wrong]
    assert printed(tmp_path, program, folder).split() == expected


@pytest.mark.parametrize("link", [0, 3, -1, 1.5, float("nan"), float("inf"), "elbow", [1, 2], None])
def test_python_names_the_links_that_there_are(link) -> None:
    derived = symgen.derive(symgen.parse_robot(PLANE.format(length=0.5)), OF_LINKS)
    X = np.ones(len(derived.base.parameters))
    for backend in ("c", "casadi") if CC else ("casadi",):
        loaded = symgen.load(derived, backend=backend)
        for kernel, before, after in (
            ("link_jacobian", ([1.0, 2.0],), ([0.1, 0.2, 0.3],)),
            ("link_jacobian", ([[1.0, 2.0]] * 3,), ([[0.1, 0.2, 0.3]] * 3,)),
            ("link_drift", ([1.0, 2.0], [3.0, 4.0]), ([0.1, 0.2, 0.3],)),
            ("add_body", (X,), (2.0, [0.1, 0.2, 0.3], np.ones(6))),
        ):
            with pytest.raises(symgen.ParameterError, match=kernel):
                getattr(loaded, kernel)(*before, link, *after)


def test_a_casadi_function_of_a_link_that_the_robot_has_not_is_nan(tmp_path) -> None:
    folder = package(tmp_path / "plane", kernels=OF_LINKS, target="casadi")
    for kernel, function in casadi_functions(folder, "plane").items():
        for link, known in ((0, False), (1, True), (2, True), (3, False), (1.5, False)):
            inputs = [
                link if function.name_in(i) == "link" else np.ones(function.size_in(i))
                for i in range(function.n_in())
            ]
            found = np.array(function(*inputs))
            assert (np.isfinite(found) if known else np.isnan(found)).all(), (kernel, link)


@pytest.mark.parametrize("name", ["planar2r", "puma560"])
def test_no_line_of_a_header_is_long(name) -> None:
    folder = Path(__file__).parents[2] / "generated" / name
    lines = [line for f in folder.glob("*.h") for line in f.read_text().splitlines()]
    assert max(map(len, lines)) <= 110


@pytest.mark.skipif(CC is None or CMAKE is None, reason="cc or cmake is not on this machine")
def test_find_package_knows_the_version(tmp_path) -> None:
    folder = package(tmp_path / "plane")
    run(["cmake", "-S", folder, "-B", "build"], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
    run(["cmake", "--install", "build", "--prefix", tmp_path / "there"], tmp_path)
    for wanted, found in (("1.0", True), ("2.0", False)):
        head = "cmake_minimum_required(VERSION 3.10)\nproject(user C)\n"
        (tmp_path / "CMakeLists.txt").write_text(f"{head}find_package(plane {wanted} REQUIRED)\n")
        place = f"-DCMAKE_PREFIX_PATH={tmp_path}/there"
        command = ["cmake", "-S", ".", "-B", f"user{found}", place]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert (done.returncode == 0) == found, done.stderr


@needs_cc
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_limits_of_the_robot_file_are_constants(dtype, tmp_path) -> None:
    limits = "\n[limits]\nposition = [[-1.5, 2.25], [-0.5, 0.125]]\ntorque = [30.0, 7.5]\n"
    model = symgen.derive(symgen.parse_robot(PLANE.format(length=0.5) + limits), ("friction",))
    folder = tmp_path / "plane"
    symgen.write_package(symgen.generate(model, target="c", dtype=dtype, prefix="plane"), folder)
    (tmp_path / "main.c").write_text(
        '#include "plane_limits.h"\n#include <stdio.h>\nint main(void) {\n'
        'for (int j = 0; j < plane_JOINTS; j++) printf("%g %g %g ", '
        "(double)plane_POSITION_LIMITS[j][0], (double)plane_POSITION_LIMITS[j][1], "
        "(double)plane_TORQUE_LIMITS[j]);\nreturn 0; }\n"
    )
    run(["gcc", *STRICT, f"-I{folder}", "main.c", "-o", "main"], tmp_path)
    assert run([tmp_path / "main"], tmp_path).split() == "-1.5 2.25 30 -0.5 0.125 7.5".split()
    text = (folder / "plane_limits.h").read_text()
    assert "VELOCITY" not in text
    free = symgen.derive(symgen.parse_robot(PLANE.format(length=0.5)), ("friction",))
    assert "plane_limits.h" not in symgen.generate(free, target="c", prefix="plane").files


@pytest.mark.skipif(GCC is None, reason="gcc is not on this machine")
def test_a_double_of_32_bits_is_refused_with_the_option(tmp_path) -> None:
    folder = package(tmp_path / "plane", kernels=("jacobian",))
    short = ["gcc", "-U__DBL_MANT_DIG__", "-D__DBL_MANT_DIG__=24", "-fsyntax-only"]
    done = subprocess.run([*short, *c_files(folder)], capture_output=True, text=True)
    assert done.returncode != 0
    assert "--dtype float" in done.stderr
    single = package(tmp_path / "planef", "float", kernels=("jacobian",))
    run([*short, *c_files(single)], tmp_path)


@needs_cc
def test_functions_whose_status_needs_nan_refuse_fast_math(tmp_path) -> None:
    kernels = ("energy_regressor", "friction_power", "forward_dynamics", "gravity_torque")
    folder = package(tmp_path / "plane", kernels=kernels)
    refusing = set()
    for file in c_files(folder):
        command = ["cc", "-ffast-math", "-fsyntax-only", file]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            assert "needs NaN" in done.stderr
            refusing.add(file.stem.removeprefix("plane_"))
    assert refusing == {"forward_dynamics", "identifier", "least_squares"}
