"""The house keeps its shape: layers, one door per library, types, style."""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from support import PROJECT

SOURCES = sorted((PROJECT / "symgen").rglob("*.py"))
DOORS = {
    # An effect that was found becomes an exact declaration.
    "sympy": ("robot", "symbolic", "codegen", "report/content/demo", "diagnosis/extend"),
    "jinja2": ("files",),
    "casadi": ("codegen/casadi_model", "experiment/search"),
    "cffi": ("runtime/build",),
    "pyarrow": ("data/tables",),
    "fsspec": ("data/urls",),
    "rosbags": ("data/bags",),
    "mujoco": ("robot/formats/mjcf", "experiment/mujoco_robot"),
    # Clarabel takes its matrices as SciPy's.
    "scipy": (
        "estimation/predictive_score",
        "diagnosis/refine",
        "data/bandwidth",
        "data/convolution",
        "data/signals",
        "estimation/filtered_log",
        "estimation/statistics",
        "experiment/recording",
        "experiment/reference",
        "experiment/trajectory",
        "identification/assessment",
        "identification/model_choice",
        "identification/payload",
        "identification/physical",
        "identification/static",
        "report/plots/residuals",
    ),
    "pandas": ("identification/estimate",),
    "clarabel": ("identification/physical",),
    "plotly": ("report/content", "report/html", "report/plots"),
    "pydantic": ("robot/schema", "robot/toml_io", "schemas"),
    "click": ("cli", "report/terminal"),
    "rich": ("cli/progress", "report/terminal"),
}
HEAVY = {"sympy", "numpy", "scipy", "casadi", "plotly", "pyarrow", "jinja2", "cffi", "pydantic",
         "clarabel", "pandas", "rosbags", "mujoco", "dask", "distributed", "fsspec"}  # fmt: skip


def _run(*command: str) -> None:
    done = subprocess.run([sys.executable, "-m", *command], cwd=PROJECT, capture_output=True,
                          text=True)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def _needs(module: str) -> None:
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")


def _imports(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def test_imports_go_downwards_only() -> None:
    _needs("importlinter")
    code = "import sys; from importlinter.cli import lint_imports_command as c; sys.exit(c())"
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("library", DOORS)
def test_a_library_is_imported_behind_its_doors_only(library: str) -> None:
    for path in SOURCES:
        place = path.relative_to(PROJECT / "symgen").as_posix()
        if library in _imports(path):
            assert place.startswith(DOORS[library]), place


def test_types_are_strict() -> None:
    _needs("mypy")
    _run("mypy", "symgen")


def test_style_is_clean() -> None:
    _needs("ruff")
    _run("ruff", "check", "symgen", "tests")
    _run("ruff", "format", "--check", "symgen", "tests")


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
               "LICENSE", "CHANGELOG.md", "docs"}  # fmt: skip
    assert {name for name in top if not name.startswith(".")} <= allowed


def test_public_names_exist_and_are_documented() -> None:
    import symgen

    for name in symgen.__all__:
        assert getattr(symgen, name).__doc__, name
