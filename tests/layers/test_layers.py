"""The house keeps its shape: one door for each library, light commands, documented names."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from support import PROJECT

HOUSE = PROJECT / "symgen"
DOORS = {
    # An effect that was found becomes an exact declaration.
    "sympy": ("robot", "symbolic", "codegen", "diagnosis/extend"),
    "jinja2": ("files",),
    "casadi": (),
    "cffi": ("runtime/build",),
    "pyarrow": ("data/tables", "data/csv_text"),
    "fsspec": ("data/urls",),
    "rosbags": ("data/bags",),
    "mcap": ("data/bags",),
    "mujoco": ("robot/formats/mjcf", "experiment/mujoco_robot"),
    "pydantic": ("schemas",),
    "click": ("cli", "report/terminal"),
    "rich": ("cli/progress", "report/terminal"),
}
HEAVY = {"sympy", "numpy", "scipy", "casadi", "pyarrow", "jinja2", "cffi", "pydantic",
         "pandas", "rosbags", "mujoco", "dask", "distributed", "fsspec"}  # fmt: skip


def _imports(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def test_libraries_are_imported_behind_their_doors_only() -> None:
    open_doors = [
        (library, path.relative_to(HOUSE).as_posix())
        for path in sorted(HOUSE.rglob("*.py"))
        for library in _imports(path) & DOORS.keys()
    ]
    assert [found for found in open_doors if not found[1].startswith(DOORS[found[0]])] == []


def test_the_command_line_and_the_package_import_nothing_heavy() -> None:
    code = "import sys, symgen, symgen.cli; print(*sorted(m for m in sys.modules if '.' not in m))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True
    )
    assert HEAVY.isdisjoint(done.stdout.split())


def test_top_level_holds_what_it_should() -> None:
    done = subprocess.run(
        ["git", "ls-files"], cwd=PROJECT, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        pytest.skip("not a git checkout")
    top = {line.split("/")[0] for line in done.stdout.splitlines()}
    allowed = {"pyproject.toml", "symgen", "generated", "templates", "tests", "README.md",
               "LICENSE", "CHANGELOG.md", "docs", "findings"}  # fmt: skip
    assert {name for name in top if not name.startswith(".")} <= allowed


def test_public_names_exist_and_are_documented() -> None:
    import symgen

    for name in symgen.__all__:
        assert getattr(symgen, name).__doc__, name
