"""NAME.hpp: warnings, the same numbers as the C functions, templates over robots, Eigen's Maps."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from packages import STRICT, objects, run, with_probe

import symgen
from symgen.codegen.kernels import Output

CXX17 = [
    "-std=c++17",
    *(flag for flag in STRICT if flag not in ("-std=c99", "-Wstrict-prototypes")),
]
CXX17 += ["-Wold-style-cast", "-Wsign-conversion", "-Wnon-virtual-dtor"]
EIGEN = Path("/usr/include/eigen3")
Packages = Callable[[str, str], Path]

# One template, two robots: the work of a motion by two ways that share no kernel.
OVER_ROBOTS = """
#include "planar2r.hpp"
#include "rich.hpp"
#include <cmath>
#include <cstdio>
#include <vector>

template <class Robot> double gap()
{
    using real = typename Robot::real;
    static_assert(Robot::inertial <= Robot::parameters, "");
    std::array<real, Robot::joints> q{}, qd{}, qdd{};
    std::vector<real> X(Robot::parameters);
    for (std::size_t j = 0; j < Robot::joints; ++j) {
        q[j] = static_cast<real>(0.3) * static_cast<real>(j + 1);
        qd[j] = static_cast<real>(1) - q[j];
        qdd[j] = q[j] * qd[j];
    }
    for (std::size_t i = 0; i < Robot::parameters; ++i) {
        X[i] = static_cast<real>(1) / static_cast<real>(i + 1);
    }
    const auto tau = Robot::inverse_dynamics(q, qd, qdd, X);
    const auto columns = Robot::power_regressor(q, qd, qdd);
    static_assert(columns.size() == Robot::parameters, "");
    double difference = 0.0;
    for (std::size_t j = 0; j < Robot::joints; ++j) {
        difference += static_cast<double>(qd[j]) * static_cast<double>(tau[j]);
    }
    for (std::size_t i = 0; i < Robot::parameters; ++i) {
        difference -= static_cast<double>(columns[i]) * static_cast<double>(X[i]);
    }
    const auto [T, U] = Robot::energy(q, qd, X);
    return T.size() == U.size() ? std::fabs(difference) : 1.0;
}

int main()
{
    std::printf("%.17g %.17g\\n", gap<planar2r_robot>(), gap<rich_robot>());
    return 0;
}
"""


def needs(compiler: str) -> None:
    """Skip where there is no such compiler."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")


def plain_kernels(manifest: Any) -> list[Any]:
    """The kernels that take arrays alone and change none of them."""
    kept = []
    for kernel in manifest["kernels"]:
        given, written = ({a["name"] for a in kernel[key]} for key in ("inputs", "outputs"))
        if not given & ({"link", "mass"} | written):
            kept.append(kernel)
    return kept


def every_kernel(package: Path) -> str:
    """Write a program that calls both forms of every kernel and C, and counts differing bits."""
    name = package.name
    lines = [f'#include "{name}.hpp"', "#include <cstdio>", "#include <cstring>", "int main() {"]
    lines += ["    int differ = 0;"]
    manifest = json.loads((package / "manifest.json").read_text())
    for kernel in plain_kernels(manifest):
        points = manifest["verification"]["points"][kernel["name"]][0]
        given = [i["name"] for i in kernel["inputs"]]
        sizes = {}
        for output in kernel["outputs"]:
            sizes[output["name"]] = 1
            for extent in output["shape"]:
                sizes[output["name"]] *= extent
        lines.append("    {")
        for key in given:
            values = ", ".join(f"static_cast<{name}_real>({v!r})" for v in points[key])
            length = f"{name}_PARAMETERS" if key == "X" else str(len(points[key]))
            lines.append(f"        const {name}_real {key}[{length}] = {{ {values} }};")
        for key, size in sizes.items():
            lines.append(f"        {name}_real {key}_c[{size}];")
            lines.append(f"        std::array<{name}_real, {size}> {key}_a{{}};")
        inputs = ", ".join(given)
        guarded = kernel["name"].startswith(("forward_dynamics", "solve", "mass_matrix_factor"))
        add = "differ += " if guarded else ""
        for suffix, owner in (("_c", f"{name}_"), ("_a", f"{name}_robot::")):
            written = ", ".join(f"{key}{suffix}" for key in sizes)
            lines.append(f"        {add}{owner}{kernel['name']}({inputs}, {written});")
        star = "*" if guarded else ""
        for index, (key, size) in enumerate(sizes.items()):
            call = f"{star}{name}_robot::{kernel['name']}({inputs})"
            value = f"std::get<{index}>({call})" if len(sizes) > 1 else call
            lines.append(f"        const auto {key}_v = {value};")
            for other in ("_a", "_v"):
                lines.append(
                    f"        differ += std::memcmp({key}_c, {key}{other}.data(), "
                    f"{size} * sizeof({name}_real)) != 0;"
                )
            lines.append(
                f'        std::printf("%.9g\\n", static_cast<double>({key}_v[{size} - 1]));'
            )
        lines.append("    }")
    return "\n".join([*lines, "    return differ;", "}", ""])


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
@pytest.mark.parametrize(("name", "dtype"), [("planar2r", "double"), ("rich", "float")])
def test_both_forms_of_every_kernel_are_the_c_functions_bit_by_bit(
    compiler: str, name: str, dtype: str, complete: Packages, tmp_path: Path
) -> None:
    needs(compiler)
    package = complete(name, dtype)
    (tmp_path / "main.cpp").write_text(every_kernel(package))
    command = [compiler, *CXX17, "-O1", f"-I{package}", "main.cpp"]
    run([*command, *objects(package), "-lm", "-o", "main"], tmp_path)
    kernels = plain_kernels(json.loads((package / "manifest.json").read_text()))
    printed = run([tmp_path / "main"], tmp_path).split()
    assert len(printed) == sum(len(k["outputs"]) for k in kernels)
    assert any(float(x) != 0 for x in printed)


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_a_program_is_a_template_over_robots_of_different_precision(
    compiler: str, complete: Packages, tmp_path: Path
) -> None:
    needs(compiler)
    packages = [complete("planar2r", "double"), complete("rich", "float")]
    (tmp_path / "main.cpp").write_text(OVER_ROBOTS)
    include = [f"-I{p}" for p in packages]
    command = [compiler, *CXX17, "-O1", *include, "main.cpp"]
    run([*command, *(o for p in packages for o in objects(p)), "-lm", "-o", "main"], tmp_path)
    planar, rich = map(float, run([tmp_path / "main"], tmp_path).split())
    assert planar < 1e-12
    assert rich < 1e-3


PROBE = """
#include "planar2r.hpp"
int main()
{
    const std::array<double, 2> q{ { 3.0, 5.0 } };
    std::array<double, 4> X{ { 1.0, 2.0, 3.0, 4.0 } };
    double out[6];
    planar2r_robot::probe(q, 2, 10.0, X, out);
    const double expected[] = { 30.0, 50.0, 2.0, 0.0, 1.0, 1.0 };
    int wrong = X[3] != 40.0;
    for (int i = 0; i < 6; ++i) {
        wrong += out[i] < expected[i] || out[i] > expected[i];
    }
    return wrong;
}
"""


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_links_plain_numbers_and_what_is_changed_in_place(compiler: str, tmp_path: Path) -> None:
    needs(compiler)
    model = with_probe(symgen.derive(symgen.read_robot("planar2r"), ("jacobian",)))
    package = tmp_path / "planar2r"
    symgen.write_package(symgen.generate(model, target="c"), package)
    (tmp_path / "main.cpp").write_text(PROBE)
    command = [compiler, *CXX17, f"-I{package}", "main.cpp", *objects(package)]
    run([*command, "-lm", "-o", "main"], tmp_path)
    run([tmp_path / "main"], tmp_path)


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_several_outputs_that_may_have_no_meaning(compiler: str, tmp_path: Path) -> None:
    needs(compiler)
    model = symgen.derive(symgen.read_robot("planar2r"), ("frames",))
    outputs = (Output("first", (16,)), Output("second", (15,)))
    kernel = replace(model.kernels[0], outputs=outputs, guards=("M",))
    package = tmp_path / "planar2r"
    tree = symgen.generate(replace(model, kernels=(kernel,)), target="c")
    symgen.write_package(tree, package)
    (tmp_path / "main.cpp").write_text(
        '#include "planar2r.hpp"\nint main()\n{\n    const std::array<double, 2> q{};\n'
        "    const auto found = planar2r_robot::frames(q);\n"
        "    return found && std::get<1>(*found).size() == 15 ? 0 : 1;\n}\n"
    )
    command = [compiler, *CXX17, f"-I{package}", "main.cpp", *objects(package)]
    run([*command, "-lm", "-o", "main"], tmp_path)
    run([tmp_path / "main"], tmp_path)


BODY = """
    std::array<double, 2> q{}, two{};
    std::array<double, 4> X{}, M{};
"""


@pytest.mark.parametrize(
    ("use", "reason"),
    [
        ("planar2r_robot::mass_matrix(q, X, M);", None),
        ("double raw[4]; planar2r_robot::mass_matrix(q, X, raw);", None),
        ("planar2r_robot::output<4> m(M.data()); planar2r_robot::mass_matrix(q, X, m);", None),
        ("planar2r_robot::mass_matrix(q, X, two);", "another number of entries"),
        ("planar2r_robot::mass_matrix(X, X, M);", "another number of entries"),
        ("double raw[3]; planar2r_robot::mass_matrix(q, X, raw);", "output"),
        ("std::array<float, 2> f{}; planar2r_robot::mass_matrix(f, X, M);", "input"),
        ("const std::array<double, 4> c{}; planar2r_robot::mass_matrix(q, X, c);", "output"),
        ("double *p = M.data(); planar2r_robot::mass_matrix(q, X, p);", "output"),
        ("planar2r_robot::mass_matrix(q, X);", "nodiscard"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_what_does_not_fit_does_not_compile(
    compiler: str, use: str, reason: str | None, complete: Packages, tmp_path: Path
) -> None:
    needs(compiler)
    (tmp_path / "main.cpp").write_text(f'#include "planar2r.hpp"\nint main() {{{BODY}{use}}}\n')
    command = [compiler, "-std=c++17", "-Werror", "-fsyntax-only"]
    command += [f"-I{complete('planar2r', 'double')}", "main.cpp"]
    if reason is None:
        run(command, tmp_path)
    else:
        with pytest.raises(AssertionError, match=reason):
            run(command, tmp_path)


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_a_length_that_only_the_run_knows_is_asserted(
    compiler: str, complete: Packages, tmp_path: Path
) -> None:
    needs(compiler)
    package = complete("planar2r", "double")
    linked = objects(package)
    for length, good in ((4, True), (3, False)):
        (tmp_path / "main.cpp").write_text(
            '#include "planar2r.hpp"\n#include <vector>\n'
            f"int main() {{{BODY} std::vector<double> v({length}); (void)two; (void)M;"
            "return planar2r_robot::mass_matrix(q, X, v), 0; }\n"
        )
        run([compiler, *CXX17, f"-I{package}", "main.cpp", *linked, "-lm", "-o", "m"], tmp_path)
        if good:
            run([tmp_path / "m"], tmp_path)
        else:
            with pytest.raises(AssertionError, match="Assertion"):
                run([tmp_path / "m"], tmp_path)


WITH_EIGEN = """
#include <Eigen/Dense>
#include <cstdio>
#include "puma560.hpp"
using robot = puma560_robot;
using vector = Eigen::Matrix<double, robot::joints, 1>;
template <int R> using rows = Eigen::Matrix<double, R, robot::joints, Eigen::RowMajor>;
int main()
{
    vector q = vector::LinSpaced(0.2, 1.4), qd = vector::Ones(), before, after;
    Eigen::VectorXd X = Eigen::VectorXd::Zero(robot::parameters);
    Eigen::Matrix<double, robot::joints, 2> both; /* columns of it are without gaps */
    const double step = 1e-6;
    rows<6> J;
    robot::jacobian(q, J);
    const auto kept = robot::jacobian(both.col(0) = q);
    const Eigen::Map<const rows<6>> map(kept.data());
    const auto origin = [](const vector &at) {
        const auto T = robot::frames(at);
        const auto last = T.size() - 16;
        return Eigen::Vector3d(T[last + 3], T[last + 7], T[last + 11]);
    };
    const vector ahead = q + step * qd, behind = q - step * qd;
    const Eigen::Vector3d speed = (origin(ahead) - origin(behind)) / (2 * step);
    std::printf("%.3e %.3e\\n", (J - map).norm(), ((J * qd).head<3>() - speed).norm());
    USE
    return 0;
}
"""


@pytest.mark.parametrize(
    ("use", "good"),
    [
        ("", True),
        ("robot::mass_matrix(q, Eigen::Map<const Eigen::VectorXd>(X.data(), X.size()));", False),
        ("Eigen::Matrix<double, 6, 6> M; robot::mass_matrix(q, X, M);", False),
        ("rows<9> big; robot::jacobian(q, big.topRows<6>());", True),
        ("rows<6> M; robot::mass_matrix(q, X, M.leftCols<3>());", False),
        ("Eigen::Matrix<double, 6, 6> M; robot::mass_matrix(q, X, M.transpose());", True),
        ("rows<6> square; robot::mass_matrix(square.col(2), X, J);", False),
    ],
    ids=["maps", "discarded", "column-major", "rows", "gaps", "transposed", "strided"],
)
def test_eigen_goes_in_and_out_and_its_other_orders_are_refused(
    use: str, good: bool, complete: Packages, tmp_path: Path
) -> None:
    needs("g++")
    if not EIGEN.is_dir():
        pytest.skip("Eigen (libeigen3-dev) is not on this machine")
    package = complete("puma560", "double")
    (tmp_path / "main.cpp").write_text(WITH_EIGEN.replace("USE", use))
    command = ["g++", "-std=c++17", "-O0", "-Wall", "-Wextra", "-Werror", f"-isystem{EIGEN}"]
    command += [f"-I{package}", "main.cpp"]
    if not good:
        with pytest.raises(AssertionError, match=r"row-major matrix|nodiscard"):
            run([*command, "-fsyntax-only"], tmp_path)
        return
    if use:
        run([*command, "-fsyntax-only"], tmp_path)
        return
    run([*command, *objects(package), "-lm", "-o", "main"], tmp_path)
    same, derivative = map(float, run([tmp_path / "main"], tmp_path).split())
    assert same == 0
    assert derivative < 1e-8


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_a_link_that_the_robot_has_not_gives_an_empty_optional(compiler: str, tmp_path) -> None:
    needs(compiler)
    model = symgen.derive(symgen.read_robot("planar2r"), ("link_jacobian", "add_body"))
    package = tmp_path / "planar2r"
    symgen.write_package(symgen.generate(model, target="c"), package)
    (tmp_path / "main.cpp").write_text(
        """
#include "planar2r.hpp"
#include <cstdio>
int main()
{
    const std::array<double, 2> q{ 1, 2 };
    const std::array<double, 3> point{ 1, 2, 3 };
    std::array<double, 4> X{ 1, 2, 3, 4 };
    using robot = planar2r_robot;
    for (std::size_t link = 0; link < 4; ++link) {
        std::printf("%d %d ", robot::link_jacobian(q, link, point).has_value(),
                    robot::add_body(X, link, 0.0, point, std::array<double, 6>{}));
    }
}
"""
    )
    command = [compiler, *CXX17, f"-I{package}", "main.cpp", *objects(package), "-lm"]
    run([*command, "-o", "main"], tmp_path)
    assert run([tmp_path / "main"], tmp_path).split() == "0 16 1 0 1 0 0 16".split()
