"""Packages on other machines: built for a Cortex-M7, and run as ARM programs under QEMU."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest
from packages import STRICT, c_files, run

M7 = ["arm-none-eabi-gcc", "-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"]


pytestmark = pytest.mark.slow


def needs(*tools: str) -> None:
    """Skip where one of the tools is missing."""
    for tool in tools:
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not on this machine")


def m7_objects(package: Path, into: Path) -> Sequence[Path]:
    """Compile the library part for a Cortex-M7, without a warning."""
    run([*M7, *STRICT, "-O2", "-c", *c_files(package)], into)
    return sorted(into.glob("*.o"))


@pytest.mark.parametrize("name", ["planar2r", "puma560", "rich"])
def test_a_float_package_builds_for_cortex_m7_without_data(name, complete, tmp_path) -> None:
    needs(M7[0], "arm-none-eabi-size")
    package = complete(name, "float")
    try:
        objects = m7_objects(package, tmp_path)
    except AssertionError as error:
        if "math.h: No such file" in str(error):
            pytest.skip("libnewlib-arm-none-eabi is not on this machine")
        raise
    table = run(["arm-none-eabi-size", *objects], tmp_path).splitlines()[1:]
    sizes = {Path(row.split()[5]).stem: [int(x) for x in row.split()[:3]] for row in table}
    assert len(sizes) == len(c_files(package))
    for text, data, bss in sizes.values():
        assert text > 0
        assert (data, bss) == (0, 0)


def test_a_float_package_calls_no_double_arithmetic_on_a_single_precision_fpu(
    complete, tmp_path
) -> None:
    needs(M7[0], "arm-none-eabi-nm")
    package = complete("puma560", "float")
    single = [part.replace("d16", "sp-d16") for part in M7]
    run([*single, *STRICT, "-O2", "-c", *c_files(package)], tmp_path)
    listed = run(["arm-none-eabi-nm", "-u", *sorted(tmp_path.glob("*.o"))], tmp_path)
    called = set(re.findall(r"U (\w+)", listed))
    allowed = {"sinf", "cosf", "sqrtf", "memcpy", "memmove", "memset"}
    assert {name for name in called if not name.startswith("puma560_")} <= allowed


@pytest.mark.parametrize(
    ("compiler", "machine"),
    [("aarch64-linux-gnu-gcc", "qemu-aarch64"), ("arm-linux-gnueabihf-gcc", "qemu-arm")],
)
@pytest.mark.parametrize(("name", "dtype"), [("puma560", "double"), ("rich", "float")])
def test_check_and_example_pass_on_arm_under_qemu(
    compiler, machine, name, dtype, complete, tmp_path
) -> None:
    needs(compiler, machine)
    package = complete(name, dtype)
    check = c_files(package, check=True)
    run([compiler, *STRICT, "-O2", "-static", *check, "-lm", "-o", "check"], tmp_path)
    printed = run([machine, tmp_path / "check"], tmp_path)
    assert "forward_dynamics" in printed
    if dtype == "float":
        example = [package / "example" / f"{name}_controller.c", *c_files(package)]
        build = [compiler, *STRICT, "-O2", "-static", f"-I{package}", *example]
        run([*build, "-lm", "-o", "controller"], tmp_path)
        assert "ratio" in run([machine, tmp_path / "controller"], tmp_path)
