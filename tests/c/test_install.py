"""An installed package is found by CMake and by pkg-config, wherever its prefix stands."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from packages import c_files, run

CMAKE, CC, PKG_CONFIG = (shutil.which(tool) for tool in ("cmake", "cc", "pkg-config"))
pytestmark = pytest.mark.skipif(
    CC is None or CMAKE is None, reason="cc or cmake is not on this machine"
)
PROGRAM = """#include <planar2r.h>
#include <planar2r_identifier.h>

int main(void)
{
    const double q[planar2r_JOINTS] = {0.3, 0.4};
    double h[planar2r_INERTIAL];
    planar2r_energy_regressor(q, q, h);
    return h[0] > 0.0 && planar2r_identifier_size(0) > 0 ? 0 : 1;
}
"""
PROJECT = """cmake_minimum_required(VERSION 3.10)
project(user C)
find_package(planar2r REQUIRED)
add_executable(user main.c)
target_link_libraries(user planar2r::planar2r)
"""


@pytest.fixture(scope="module", params=["lib", "lib/by-machine"])
def prefix(request, complete, tmp_path_factory) -> Path:
    """Where a package was installed to, and then moved to; its sources and build are gone."""
    tmp_path = tmp_path_factory.mktemp("install")
    shutil.copytree(complete("planar2r", "double"), tmp_path / "copy")
    layout = f"-DCMAKE_INSTALL_LIBDIR={request.param}"
    run(["cmake", "-S", "copy", "-B", "build", "-DCMAKE_C_FLAGS=-O0", layout], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
    run(["cmake", "--install", "build", "--prefix", tmp_path / "first"], tmp_path)
    shutil.rmtree(tmp_path / "copy")
    shutil.rmtree(tmp_path / "build")
    (tmp_path / "first").rename(tmp_path / "moved")
    library = tmp_path / "moved" / request.param
    assert (library / "libplanar2r_model.a").is_file()
    for text in (*library.rglob("*.cmake"), *library.rglob("*.pc")):
        assert str(tmp_path) not in text.read_text()
    return library


def test_find_package_gives_the_target(prefix, tmp_path):
    (tmp_path / "main.c").write_text(PROGRAM)
    (tmp_path / "CMakeLists.txt").write_text(PROJECT)
    place = f"-Dplanar2r_DIR={prefix}/cmake/planar2r"
    if prefix.name == "lib":
        place = f"-DCMAKE_PREFIX_PATH={prefix.parent}"
    run(["cmake", "-S", ".", "-B", "user", place], tmp_path)
    run(["cmake", "--build", "user"], tmp_path)
    run([tmp_path / "user" / "user"], tmp_path)


@pytest.mark.skipif(PKG_CONFIG is None, reason="pkg-config is not on this machine")
def test_pkg_config_gives_the_flags(prefix, tmp_path, monkeypatch):
    monkeypatch.setenv("PKG_CONFIG_PATH", str(prefix / "pkgconfig"))
    flags = run(["pkg-config", "--cflags", "--libs", "planar2r"], tmp_path).split()
    (tmp_path / "main.c").write_text(PROGRAM)
    run(["cc", "main.c", *flags, "-o", "program"], tmp_path)
    run([tmp_path / "program"], tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ctest") is None, reason="ctest is not on this machine")
def test_cmake_builds_the_examples_on_request_and_ctest_runs_all(complete, tmp_path):
    package = complete("planar2r", "double")
    flags = ["-DCMAKE_C_FLAGS=-O0", "-Dplanar2r_EXAMPLE=ON"]
    run(["cmake", "-S", package, "-B", "build", *flags], tmp_path)
    run(["cmake", "--build", "build"], tmp_path)
    printed = run(["ctest", "--test-dir", "build"], tmp_path)
    for program in ("controller", "check"):
        assert f"planar2r_{program}" in printed
    assert re.search(r"100% tests passed.* out of 2\b", printed), printed
    assert {f.name for f in package.glob("*_controller.c")}.isdisjoint(
        f.name for f in c_files(package)
    )


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not on this machine")
def test_the_package_is_optimised_and_the_users_targets_keep_their_build_type(complete, tmp_path):
    shutil.copytree(complete("planar2r", "double"), tmp_path / "planar2r")
    (tmp_path / "main.c").write_text(PROGRAM)
    found = PROJECT.replace("find_package(planar2r REQUIRED)", "add_subdirectory(planar2r)")
    (tmp_path / "CMakeLists.txt").write_text(found)
    for build_type, optimised in ((None, "-O3"), ("Debug", "-g")):
        build = f"build-{build_type}"
        flags = ["-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DCMAKE_C_COMPILER=gcc"]
        flags += [f"-DCMAKE_BUILD_TYPE={build_type}"] if build_type else []
        run(["cmake", "-S", ".", "-B", build, *flags], tmp_path)
        commands = json.loads((tmp_path / build / "compile_commands.json").read_text())
        for command in commands:
            words = command["command"].split()
            own = command["file"].endswith("main.c")
            assert (optimised in words) == (build_type is not None or not own)
            assert ("-ffp-contract=fast" in words) == (not own)
