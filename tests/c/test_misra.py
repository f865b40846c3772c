"""MISRA C:2012 as cppcheck reads it: a package deviates from the rules it lists, from no other."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from packages import c_files, write

CPPCHECK = shutil.which("cppcheck")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CPPCHECK is None, reason="cppcheck is not on this machine"),
]

# Small, with every kind of friction and a drive of two joints: all that the printer writes.
SMALL = "rich"


def listed(package: Path) -> dict[str, str]:
    """The rules that the README lists as deviated from, and where."""
    table = (package / "README.md").read_text().split("## MISRA C:2012")[1]
    return dict(re.findall(r"^\| (\d+\.\d+) \| ([\w ]+) \| \S.+ \|$", table, re.MULTILINE))


def cppcheck(package: Path, *options: str) -> str:
    """Read the library part of a package; what is printed, empty where nothing is found."""
    command = ["--addon=misra", "--std=c99", "--enable=warning,portability,performance", "-q"]
    command += ["-DDBL_MANT_DIG=53", "--force"]  # of float.h, which it does not read
    template = "--template={id} {file}:{line} {message}"
    # All panels are alike: one of a kernel that can fail, one of a kernel that cannot.
    files = [
        str(f)
        for f in c_files(package)
        if not f.stem.endswith("_panels")
        or f.stem.endswith(("forward_dynamics_panels", "_energy_panels"))
    ]
    done = subprocess.run(
        [str(CPPCHECK), *command, "-j2", template, *options, *files], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    if "Bailing out" in done.stderr or "Failed to execute" in done.stderr + done.stdout:
        pytest.skip("cppcheck has no misra addon here")
    return done.stderr


@pytest.mark.parametrize("dtype", ["double", "float"])
def test_a_package_deviates_from_the_rules_it_lists_and_from_no_other(complete, dtype) -> None:
    package = complete(SMALL, dtype)
    rules = listed(package)
    assert rules
    found = cppcheck(package)
    lines = [line for line in found.splitlines() if not line.startswith("misra-c2012-")]
    assert lines == []
    runtime = (f"{package.name}_identifier", f"{package.name}_least_squares")
    seen: dict[str, set[str]] = {}
    for rule, file in re.findall(r"^misra-c2012-(\S+) (\S+):\d+", found, re.MULTILINE):
        part = "identifier" if Path(file).name.startswith(runtime) else "kernels"
        seen.setdefault(rule, set()).add("headers" if file.endswith(".h") else part)
    # "all" stands for sources of both kinds; a rule that is listed and kept is a false statement.
    told = {
        rule: set(where.replace("all", "kernels and identifier").split(" and "))
        for rule, where in rules.items()
    }
    assert seen == told


def test_a_goto_in_a_kernel_is_seen(tmp_path: Path) -> None:
    package = write("planar2r", "double", tmp_path / "planar2r", ("gravity_torque",))
    kernel = package / "planar2r_gravity_torque.c"
    kernel.write_text(
        kernel.read_text() + "int f(int a)\n{\n    if (a > 0) goto end;\nend:\n    return 0;\n}\n"
    )
    suppressions = [f"--suppress=misra-c2012-{rule}" for rule in listed(package)]
    assert "misra-c2012-15.1 " in cppcheck(package, *suppressions)
