"""The target firmware: its manifests, and the package built as other tools build it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from documented import DOCS
from packages import STRICT, STRICT_CXX, c_files, run

import symgen
from symgen.errors import PackageError

#: Two joints with names that no variable of C can have, or that a board defines as a macro.
ARM = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
name = "A1"
[[joint]]
name = "float"
d = 0.5
"""
KERNELS = ("inverse_dynamics", "mass_matrix", "gravity_torque", "forward_dynamics")
MAINTAINER = "Ada O'Neill <ada@example.com>"
#: Keys of each format. library.properties: docs.arduino.cc/arduino-cli/library-specification;
#: required ones first.
ARDUINO = "name version author maintainer sentence paragraph category url architectures".split()
ARDUINO_MORE = {
    "depends",
    "dot_a_linkage",
    "includes",
    "precompiled",
    "ldflags",
    "email",
    "license",
}
#: docs.platformio.org/en/latest/manifests/library-json
PLATFORMIO = set(
    "name version description keywords homepage repository authors license frameworks platforms "
    "headers examples dependencies export scripts build".split()
)
#: docs.espressif.com/projects/idf-component-manager/en/latest/reference/manifest_file.html
ESP_IDF = set(
    "version maintainers description license license_file tags url issues documentation repository "
    "repository_info discussion examples files targets dependencies".split()
)
#: METADATA_SCHEMA in scripts/zephyr_module.py of Zephyr.
ZEPHYR = set("name build tests samples boards blobs security package-managers".split())
ZEPHYR_BUILD = set("cmake kconfig cmake-ext kconfig-ext depends settings".split())

#: What ESP-IDF and Zephyr define before they read the CMakeLists.txt of a package.
STUBS = """
cmake_minimum_required(VERSION 3.10)
project(stubs LANGUAGES C)
function(idf_component_register)
  cmake_parse_arguments(PARSE_ARGV 0 A "" "" "SRC_DIRS;INCLUDE_DIRS")
  file(GLOB sources ${CMAKE_CURRENT_SOURCE_DIR}/${A_SRC_DIRS}/*.c)
  add_library(component STATIC ${sources})
  target_include_directories(component PUBLIC ${A_INCLUDE_DIRS})
endfunction()
function(zephyr_library_named name)
  add_library(${name} STATIC)
endfunction()
function(zephyr_include_directories folder)
  include_directories(${folder})
  set_property(GLOBAL PROPERTY folder ${folder})
endfunction()
function(zephyr_library_sources)
  target_sources(arm_model PRIVATE ${ARGN})
endfunction()
"""
#: A sketch whose inputs no compiler knows.
SKETCH = """
#include <armf.h>
#include <armf_state.h>

static float X[armf_PARAMETERS];

void setup()
{
    Serial.begin(115200);
    armf_warm();
}

void loop()
{
    float q[armf_JOINTS], qd[armf_JOINTS], tau[armf_JOINTS], qdd[armf_JOINTS];
    for (int i = 0; i < armf_JOINTS; ++i) {
        q[i] = analogRead(i);
        qd[i] = analogRead(i);
        qdd[i] = analogRead(i);
    }
    X[0] = analogRead(0);
    armf_inverse_dynamics(q, qd, qdd, X, tau);
    Serial.println(armf_state_of(tau).a1);
    Serial.println(armf_forward_dynamics(q, qd, tau, X, qdd));
    Serial.println(qdd[1]);
}
"""
STATE = """
#include "arm_state.h"

int main(void)
{
    const double q[2] = {1.5, -2.5};
    double back[2] = {0.0, 0.0};
    arm_state state = arm_state_of(q);
    state.joint_float += 1.0;
    arm_state_to(&state, back);
    return !(state.a1 > 1.4 && back[0] > 1.4 && back[0] < 1.6 && back[1] > -1.6 && back[1] < -1.4);
}
"""


def tool(name: str) -> str:
    """The path of a program; the test is skipped where there is none."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not on this machine")
    return found


def written(into: Path, dtype: str = "double", **options: Any) -> Path:
    """The package of the arm for firmware."""
    model = symgen.derive(symgen.parse_robot(ARM), KERNELS)
    tree = symgen.generate(model, target="firmware", dtype=dtype, **options)
    symgen.write_package(tree, into)
    return into


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("firmware") / "arm", maintainer=MAINTAINER)


def properties(package: Path) -> dict[str, str]:
    """The keys and values of library.properties."""
    lines = (package / "library.properties").read_text().splitlines()
    return dict(line.split("=", 1) for line in lines)


def test_manifests_have_the_keys_of_their_formats(package: Path) -> None:
    arduino = properties(package)
    assert list(arduino)[:9] == ARDUINO
    assert set(arduino) <= {*ARDUINO, *ARDUINO_MORE}
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,62}", arduino["name"])
    assert arduino["category"] == "Device Control"
    assert arduino["maintainer"] == MAINTAINER
    platformio = json.loads((package / "library.json").read_text())
    assert set(platformio) <= PLATFORMIO
    assert platformio["authors"][0]["email"] == "ada@example.com"
    esp = yaml.safe_load((package / "idf_component.yml").read_text())
    assert set(esp) <= ESP_IDF
    assert esp["maintainers"] == [MAINTAINER]
    zephyr = yaml.safe_load((package / "zephyr" / "module.yml").read_text())
    assert set(zephyr) <= ZEPHYR
    assert set(zephyr["build"]) <= ZEPHYR_BUILD
    assert (package / zephyr["build"]["cmake"] / "CMakeLists.txt").is_file()
    assert (package / zephyr["build"]["kconfig"]).is_file()
    declared = re.search(r'arm_VERSION "(.*)"', (package / "arm.h").read_text())
    assert declared is not None
    versions = {arduino["version"], platformio["version"], esp["version"]}
    assert versions == {declared[1]}


def test_manifests_have_a_license_only_where_one_is_named(package: Path, tmp_path: Path) -> None:
    licensed = written(tmp_path / "arm", license="MIT OR Apache-2.0")
    for folder, known in ((package, None), (licensed, "MIT OR Apache-2.0")):
        assert json.loads((folder / "library.json").read_text()).get("license") == known
        assert yaml.safe_load((folder / "idf_component.yml").read_text()).get("license") == known
        assert json.loads((folder / "manifest.json").read_text())["options"].get("license") == known


@pytest.mark.parametrize(
    "option",
    [
        {"license": 'MIT"'},
        {"license": ""},
        {"maintainer": "Ada"},
        {"maintainer": "Ada <ada@example.com>\nname=x"},
        {"maintainer": 'A"da <ada@example.com>'},
    ],
)
def test_what_a_manifest_cannot_hold_is_refused(option: dict[str, str], tmp_path: Path) -> None:
    with pytest.raises(PackageError, match="accepted"):
        written(tmp_path / "arm", **option)


def test_platformio_packs_the_folder(package: Path, tmp_path: Path) -> None:
    run([tool("pio"), "pkg", "pack", "-o", tmp_path / "arm.tar.gz", package], tmp_path)
    assert (tmp_path / "arm.tar.gz").is_file()


def test_the_component_manager_of_esp_idf_accepts_the_manifest(package: Path) -> None:
    run([tool("compote"), "manifest", "lint", package], package)


def test_kconfig_of_zephyr_turns_the_model_on(package: Path, tmp_path: Path) -> None:
    kconfiglib = pytest.importorskip("kconfiglib", reason="kconfiglib is not installed")
    top = tmp_path / "Kconfig"
    top.write_text(f'config REQUIRES_FULL_LIBC\n\tbool\nsource "{package}/zephyr/Kconfig"\n')
    symbols = kconfiglib.Kconfig(str(top), warn_to_stderr=False)
    assert symbols.warnings == []
    symbols.syms["ARM_MODEL"].set_value("y")
    assert symbols.syms["REQUIRES_FULL_LIBC"].str_value == "y"


@pytest.mark.parametrize(
    ("folder", "switch", "library"),
    [
        ("", "ESP_PLATFORM", "component"),
        ("zephyr", "CONFIG_ARM_MODEL", "arm_model"),
        ("", "", "arm_model"),
    ],
)
def test_cmake_builds_each_source_of_the_folder(
    folder: str, switch: str, library: str, package: Path, tmp_path: Path
) -> None:
    cmake = tool("cmake")
    setting = f"set({switch} 1)\n" if switch else ""
    adding = f"add_subdirectory({package / folder} built)\n"
    (tmp_path / "CMakeLists.txt").write_text(STUBS + setting + adding)
    run([cmake, "-B", "build", "."], tmp_path)
    run([cmake, "--build", "build", "--target", library], tmp_path)
    built = {path.name.removesuffix(".o") for path in (tmp_path / "build").rglob("*.c.o")}
    assert built == {path.name for path in c_files(package)}


@pytest.mark.parametrize("language", ["c", "c++"])
def test_named_fields_are_the_array(language: str, package: Path, tmp_path: Path) -> None:
    flags = STRICT if language == "c" else STRICT_CXX
    (tmp_path / "state.c").write_text(STATE)
    compiler = "cc" if language == "c" else "c++"
    run([tool(compiler), *flags, f"-I{package}", "state.c", "-o", "state"], tmp_path)
    run([tmp_path / "state"], tmp_path)


@pytest.mark.parametrize("processor", ["cortex-m0plus", "cortex-m4", "cortex-m7"])
def test_a_float_package_builds_for_arm_without_a_warning(processor: str, tmp_path: Path) -> None:
    compiler = tool("arm-none-eabi-gcc")
    folder = written(tmp_path / "arm", "float")
    flags = [f"-mcpu={processor}", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror"]
    run([compiler, *flags, "-c", *c_files(folder)], tmp_path)
    assert len(list(tmp_path.glob("*.o"))) == len(c_files(folder))


@pytest.fixture
def arduino(tmp_path: Path) -> Callable[[str, str], None]:
    """Build a sketch with the libraries in the folder `libraries`, for a board.

    Debian's cores lack DECIMAL_DIG, which float.h of avr-gcc 5 defines for C alone.
    """
    builder = tool("arduino-builder")
    tool("avr-gcc")
    cores = Path("/usr/share/arduino/hardware")
    if not (cores / "arduino" / "avr").is_dir():
        pytest.skip("arduino-core-avr is not on this machine")
    build = tmp_path / "build"
    settings = [
        "runtime.tools.avr-gcc.path=/usr",
        "runtime.tools.ctags.path=/usr/bin",
        "compiler.cpp.extra_flags=-DDECIMAL_DIG=__DECIMAL_DIG__",
    ]
    chosen = [word for setting in settings for word in ("-prefs", setting)]
    folders = ["-hardware", cores, "-hardware", "/usr/share/arduino-builder", "-tools", "/usr/bin"]
    folders += ["-libraries", tmp_path / "libraries", "-build-path", build]

    def built(board: str, sketch: str) -> None:
        build.mkdir()
        (tmp_path / "sketch").mkdir()
        (tmp_path / "sketch" / "sketch.ino").write_text(sketch)
        (library,) = (tmp_path / "libraries").iterdir()
        command = [builder, "-compile", *folders, *chosen, "-fqbn", f"arduino:avr:{board}"]
        done = subprocess.run(
            [*map(str, command), "-warnings", "all", "sketch/sketch.ino"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env={**os.environ, "HOME": str(tmp_path)},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        warned = set(re.findall(r"libraries/\w+/(\w+\.\w+):\d+", done.stderr))
        assert warned <= {"armf_identifier.c"}, done.stderr  # a constant beyond 16 bits
        compiled = {path.name for path in (build / "libraries").rglob("*.c.o")}
        assert compiled == {f"{path.name}.o" for path in c_files(library)}
        assert (build / "sketch.ino.hex").is_file()

    return built


@pytest.mark.slow
def test_arduino_builds_a_sketch_with_the_library(arduino: Any, tmp_path: Path) -> None:
    written(tmp_path / "libraries" / "armf", "float")
    arduino("mega:cpu=atmega2560", SKETCH)


@pytest.mark.slow
def test_arduino_builds_the_sketch_of_the_page(command: Any, arduino: Any, tmp_path: Path) -> None:
    robot, values = DOCS / "files" / "arm.toml", DOCS / "files" / "true.toml"
    options = ["--target", "firmware", "--dtype", "float", "--parameters", values]
    assert command("generate", robot, *options, "--into", tmp_path / "libraries" / "armf")[0] == 0
    arduino("uno", (DOCS / "files" / "gravity.ino").read_text())
