"""Generated packages as the engineer who copies them sees them: compilers, CMake, names, memory."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import pytest
from packages import STRICT, STRICT_CXX, c_files, run, write

import symgen

CC, GXX = (shutil.which(tool) for tool in ("cc", "g++"))
CMAKE, CTEST, NM = (shutil.which(tool) for tool in ("cmake", "ctest", "nm"))
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
needs_gxx = pytest.mark.skipif(GXX is None, reason="no C++ compiler (g++) on this machine")
needs_nm = pytest.mark.skipif(CC is None or NM is None, reason="cc or nm is not on this machine")
needs_cmake = pytest.mark.skipif(
    CC is None or CMAKE is None or CTEST is None, reason="cc, cmake or ctest is not on this machine"
)

MATH = {"sin", "cos", "sincos", "fabs", "tanh", "sqrt", "pow"}
# Beyond libm, what compilers call on their own account for copies and protected stacks.
FROM_OUTSIDE = (
    MATH
    | {f"{name}f" for name in MATH}
    | {"memcpy", "memset", "memmove", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}
)


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The package of the energy model of a robot in a precision, as in planar2r-double."""
    root = tmp_path_factory.mktemp("packages")

    @cache
    def package(case: str) -> Path:
        name, dtype = case.split("-")
        return write(name, dtype, root / dtype / name)

    return package


@pytest.fixture(
    params=[
        "planar2r-double",
        *(pytest.param(c, marks=pytest.mark.slow) for c in ("rich-double", "rich-float")),
    ]
)
def package(request: pytest.FixtureRequest, packages: Callable[[str], Path]) -> Path:
    """One case."""
    return packages(request.param)


def uncommented(source: str) -> str:
    """C text without comments and strings."""
    return re.sub(r'/\*.*?\*/|"[^"\n]*"', " ", source, flags=re.DOTALL)


def objects(package: Path) -> list[Path]:
    """Compile the library part of a package, once, beside its folder."""
    into = package.parent / f"{package.name}-objects"
    if not into.is_dir():
        into.mkdir()
        run(["cc", "-std=c99", "-O1", "-fPIC", "-c", *c_files(package)], into)
    return sorted(into.glob("*.o"))


def symbols(files: Sequence[Path]) -> list[tuple[str, str]]:
    """Every (type letter, name) that nm lists."""
    out = []
    for line in run([str(NM), *files], files[0].parent).splitlines():
        if (found := re.match(r"[0-9a-f ]* ([A-Za-z?]) (\S+)$", line)) is not None:
            out.append((found[1], found[2]))
    return out


# Compilers.


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.slow)])
def test_every_source_is_free_of_strict_c99_warnings(compiler, package, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")
    # gcc finds some faults only when it optimizes, clang finds all by reading.
    how = ["-O1", "-c"] if compiler == "gcc" else ["-fsyntax-only"]
    run([compiler, *STRICT, *how, *c_files(package, check=True)], tmp_path)


@needs_gxx
def test_header_and_sources_are_also_cxx11(package, tmp_path):
    run([GXX, *STRICT_CXX, "-fsyntax-only", *c_files(package, check=True)], tmp_path)


@needs_gxx
@pytest.mark.parametrize("case", ["planar2r-double", "rich-float"])
def test_every_header_stands_alone_in_cxx_and_keeps_c_linkage(case, packages, tmp_path):
    package = packages(case)
    headers = sorted(package.glob("*.h"))
    for header in headers:
        alone = tmp_path / f"{header.stem}.cpp"
        alone.write_text(f'#include "{header.name}"\n#include "{header.name}"\n')
    run([GXX, *STRICT_CXX, f"-I{package}", "-fsyntax-only", *tmp_path.glob("*.cpp")], tmp_path)
    name = package.name
    caller = tmp_path / "caller.cpp"
    caller.write_text(
        "".join(f'#include "{h.name}"\n' for h in headers)
        + f"int main() {{ {name}_real q[{name}_JOINTS] = {{0}}, qd[{name}_JOINTS] = {{0}};\n"
        f"{name}_real out[{name}_INERTIAL]; {name}_energy_regressor(q, qd, out);\n"
        f"{name}_energy_regressor_batch(1, q, qd, out); return 0; }}\n"
    )
    run(
        [GXX, "-std=c++11", f"-I{package}", caller, *objects(package), "-lm", "-o", "caller"],
        tmp_path,
    )
    run([tmp_path / "caller"], tmp_path)


# By hand and with CMake.


@needs_cc
def test_bare_cc_builds_the_folder_and_its_check_passes(package, tmp_path):
    shutil.copytree(package, tmp_path / "copy")
    sources = c_files(tmp_path / "copy", check=True)
    run(["cc", *sources, "-lm", "-o", "checked"], tmp_path)
    printed = run([tmp_path / "checked"], tmp_path)
    assert "energy_regressor" in printed


@needs_cc
@pytest.mark.parametrize("case", ["puma560-double", "rich-float"])
def test_check_program_fails_on_a_spoiled_kernel(case, packages, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(packages(case), copy)
    kernel = copy / f"{packages(case).name}_energy_regressor.c"
    text = kernel.read_text()
    spoiled = text.replace("0.5", "0.5001", 1)
    assert spoiled != text
    kernel.write_text(spoiled)
    run(["cc", *c_files(copy, check=True), "-lm", "-o", "checked"], copy)
    assert subprocess.run([copy / "checked"], capture_output=True).returncode == 1


@needs_cc
def test_check_program_fails_on_what_is_not_a_number(packages, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(packages("planar2r-double"), copy)
    kernel = copy / "planar2r_energy_regressor.c"
    kernel.write_text(
        re.sub(r"out\[1\] = .+;", "out[1] = 0.0 / (q[0] - q[0]);", kernel.read_text())
    )
    run(["cc", *c_files(copy, check=True), "-lm", "-o", "checked"], copy)
    done = subprocess.run([copy / "checked"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "energy_regressor inf\n")


@needs_cc
@pytest.mark.parametrize("case", ["puma560-double", "planar2r-float"])
def test_readme_command_and_example_compile(case, packages, tmp_path):
    package = packages(case)
    text = (package / "README.md").read_text()
    command = re.search(r"By hand: `(.+?)`", text)
    example = re.search(r"```c\n(#include .+?\n)\n(.+?)```", text, re.DOTALL)
    assert command is not None
    assert example is not None
    copy = tmp_path / "copy"
    shutil.copytree(package, copy)
    run(command[1].split(), copy)
    program = f"{example[1]}\nint main(void)\n{{\n{example[2]}\nreturn h[0] != h[0];\n}}\n"
    (copy / "example.c").write_text(program)
    run(["cc", "example.c", *sorted(copy.glob("*.o")), "-lm", "-o", "example"], copy)
    run([copy / "example"], copy)


@needs_cmake
@pytest.mark.parametrize("case", ["planar2r-double", "rich-float"])
def test_cmake_builds_a_copy_and_ctest_passes(case, packages, tmp_path):
    shutil.copytree(packages(case), tmp_path / "copy")
    run(["cmake", "-S", "copy", "-B", "build", "-DCMAKE_C_FLAGS=-Wall -Wextra -Werror"], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
    assert "100% tests passed" in run(["ctest", "--test-dir", "build"], tmp_path)


BOTH = """#include "puma560_identifier.h"
#include "planar2r_identifier.h"

int main(void)
{
    double q[puma560_JOINTS] = {0};
    double h[puma560_INERTIAL];
    double k[planar2r_INERTIAL];
    double s[sizeof(planar2r_least_squares) / sizeof(double) + 1];
    double t[sizeof(puma560_least_squares) / sizeof(double) + 1];
    puma560_energy_regressor(q, q, h);
    planar2r_energy_regressor(q, q, k);
    return planar2r_least_squares_init((planar2r_least_squares *)(void *)s, 1.0)
        || puma560_least_squares_init((puma560_least_squares *)(void *)t, 1.0);
}
"""


@needs_cmake
def test_another_project_uses_two_packages_by_add_subdirectory(packages, tmp_path):
    for case in ("puma560-double", "planar2r-double"):
        shutil.copytree(packages(case), tmp_path / packages(case).name)
    (tmp_path / "main.c").write_text(BOTH)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.10)\nproject(user C)\nenable_testing()\n"
        "add_subdirectory(puma560)\nadd_subdirectory(planar2r)\nadd_executable(user main.c)\n"
        "target_link_libraries(user puma560::puma560 planar2r::planar2r)\nadd_test(user user)\n"
    )
    run(["cmake", "-S", ".", "-B", "build"], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
    assert "out of 1" in run(["ctest", "--test-dir", "build"], tmp_path)


# Names and memory.


@needs_nm
def test_symbols_have_the_prefix_and_no_data_is_mutable(package):
    found = symbols(objects(package))
    external = [(kind, name) for kind, name in found if kind.isupper() and kind != "U"]
    assert {name for _, name in external} >= {f"{package.name}_energy_regressor"}
    assert [name for _, name in external if not name.startswith(f"{package.name}_")] == []
    # T, t: code; R, r: constants. All else (b, d, C, ...) is memory that calls would share.
    assert [(kind, name) for kind, name in found if kind not in "TtRrU"] == []


@needs_nm
def test_nothing_but_libm_is_needed_so_that_nothing_allocates(package):
    found = symbols(objects(package))
    own = {name for kind, name in found if kind in "TR"}
    own |= {f"__{end}_{package.name}_code" for end in ("start", "stop")}  # from the linker
    assert {name for kind, name in found if kind == "U"} - own - FROM_OUTSIDE == set()


# Float.


def test_float_kernels_have_only_float_literals_and_functions(packages):
    package = packages("rich-float")
    name = package.name
    kernels = [*package.glob(f"{name}_energy_*.c"), *package.glob(f"{name}_friction_*.c")]
    assert kernels
    literals = 0
    for file in (*kernels, package / f"{name}.h"):
        text = uncommented(file.read_text())
        assert re.findall(r"\b(?:double|(?:sin|cos|fabs|tanh|sqrt)\s*\()", text) == []
        numbers = re.findall(r"(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d+)?\w*", text)
        assert [n for n in numbers if not n.endswith("f")] == []
        literals += len(numbers)
    assert literals > 0


# Awkward names.

HARMLESS = ["W32", "C2", "DXX2", "V31", "k", "N", "out", "gamma"]
TAKEN = [
    "real",
    "JOINTS",
    "PARAMETERS",
    "INERTIAL",
    "MODEL_H",
    "WINDOW_START",
    "energy_regressor",
    "friction_power",
    "least_squares",
]
ONE_LENGTH = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[geometry]
{length} = 0.5
[[joint]]
[[joint]]
d = "{length}"
theta = 0.3
[[joint]]
sigma = 1
alpha = "pi/3"
r = "{length}/2"
"""


def read_or_refuse(text: str, name: str) -> symgen.Robot | None:
    """Read a robot; None where the name is refused by an error that names it."""
    refused = None
    try:
        return symgen.parse_robot(text)
    except symgen.RobotError as error:
        refused = str(error)
    assert repr(name) in refused
    return None


@needs_cc
def test_lengths_named_as_variables_of_the_code_change_nothing(tmp_path):
    def text(lengths: list[str]) -> str:
        geometry = "".join(f"{g} = {0.1 + 0.07 * i:.2f}\n" for i, g in enumerate(lengths))
        joints = "".join(
            f'[[joint]]\nalpha = 0.4\nd = "{a}"\nr = "{b}"\ncoulomb_width = 0.1\n'
            for a, b in zip(lengths[::2], lengths[1::2], strict=True)
        )
        return f'[robot]\nname = "arm"\n[geometry]\n{geometry}{joints}'

    plain = [f"L{i}" for i in range(len(HARMLESS))]
    models = [symgen.derive(symgen.parse_robot(text(names))) for names in (HARMLESS, plain)]
    awkward, plainly = (symgen.generate(model, target="c") for model in models)
    # The check programs hold 50-digit values of the two: the names play no part in them.
    assert awkward.files["check/arm_check.c"] == plainly.files["check/arm_check.c"]
    symgen.write_package(awkward, tmp_path / "arm")
    files = c_files(tmp_path / "arm", check=True)
    run(["cc", *STRICT, *files, "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)


@needs_cc
@pytest.mark.parametrize("length", TAKEN)
def test_an_awkward_name_of_a_length_is_refused_or_compiles(length, tmp_path):
    robot = read_or_refuse(ONE_LENGTH.format(length=length), length)
    if robot is None:
        return
    symgen.write_package(symgen.generate(symgen.derive(robot), target="c"), tmp_path / "arm")
    run(["cc", *STRICT, "-fsyntax-only", *c_files(tmp_path / "arm", check=True)], tmp_path)


@needs_cmake
@pytest.mark.parametrize("name", ["test", "all", "m", "math", "limits"])
def test_an_awkward_name_of_a_robot_is_refused_or_builds_with_cmake(name, tmp_path):
    text = ONE_LENGTH.format(length="L1").replace('"arm"', f'"{name}"')
    robot = read_or_refuse(text, name)
    if robot is None:
        return
    symgen.write_package(symgen.generate(symgen.derive(robot), target="c"), tmp_path / name)
    run(["cmake", "-S", name, "-B", "build"], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
