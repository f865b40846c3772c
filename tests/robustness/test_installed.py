"""symgen as users get it: sdist and wheel built, installed with nothing else, every command run.

    pytest -m slow tests/robustness/test_installed.py

Takes what pip finds; without a registry the tests are skipped with the reason.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest
from support import PROJECT
from support_commands import LIMITS, PARAMETERS, URDF

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name == "nt", reason="paths of POSIX environments"),
]
BUILD = "import hatchling.build as b, sys; print(b.build_{kind}(sys.argv[1]))"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
#: What the wheel must bring beside modules.
DATA = ("symgen/py.typed", "symgen/robot/effects.toml", "symgen/robot/library/planar2r.toml",
        "symgen/templates/c/kernel.c", "symgen/templates/report/report.html")  # fmt: skip


def _pip(python: Path, *arguments: str | Path) -> None:
    """Install; skip where there is nothing to install from."""
    done = subprocess.run(
        [python, "-m", "pip", "install", "-q", "--disable-pip-version-check", *arguments],
        capture_output=True,
        text=True,
    )
    if done.returncode != 0 and "No matching distribution" in done.stderr:
        pytest.skip(f"pip finds nothing to install: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr


def _environment(folder: Path) -> dict[str, str]:
    """Return an environment in which no checkout and no other symgen is found."""
    kept = {
        k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "SYMGEN", "VIRTUAL"))
    }
    return {**kept, "HOME": str(folder), "PYTHONNOUSERSITE": "1"}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return an sdist of the checkout, and a wheel built from what is in the sdist."""
    root = tmp_path_factory.mktemp("built")
    venv.create(root / "env", with_pip=True)
    python = root / "env" / "bin" / "python"
    _pip(python, "hatchling>=1.24")

    def build(kind: str, source: Path) -> Path:
        command = [python, "-c", BUILD.format(kind=kind), root]
        done = subprocess.run(command, cwd=source, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return root / done.stdout.split()[-1]

    sdist = build("sdist", PROJECT)
    with tarfile.open(sdist) as archive:
        archive.extractall(root / "source", filter="data")
    (source,) = (root / "source").iterdir()
    return sdist, build("wheel", source)


def test_the_wheel_holds_modules_templates_and_tables_and_no_tests(built):
    sdist, wheel = built
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert set(DATA) <= set(names)
    modules = {p.relative_to(PROJECT).as_posix() for p in (PROJECT / "symgen").rglob("*.py")}
    assert {n for n in names if n.startswith("symgen/") and n.endswith(".py")} == modules
    assert {n.split("/")[0].split("-")[0] for n in names} == {"symgen"}
    with tarfile.open(sdist) as archive:
        inside = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    assert {"LICENSE", "README.md", "CHANGELOG.md", "pyproject.toml"} <= inside


@pytest.mark.parametrize("version", PYTHONS)
def test_every_command_runs_where_the_wheel_alone_is_installed(version, built, tmp_path):
    python = shutil.which(f"python{version}")
    if version == f"{sys.version_info.major}.{sys.version_info.minor}":
        python = sys.executable
    made = python and subprocess.run([python, "-m", "venv", tmp_path / "env"], capture_output=True)
    if not made or made.returncode != 0:
        pytest.skip(f"Python {version} is not on this machine")
    place = tmp_path / "env" / "bin"
    _pip(place / "python", built[1])
    (tmp_path / "p.toml").write_text(PARAMETERS)
    (tmp_path / "one.urdf").write_text(URDF)
    parameters = ["--parameters", "p.toml"]
    commands = [
        ["--version"],
        ["robots"],
        ["doctor"],
        ["explain"],
        ["explain", "gravity_spring"],
        ["generate", "planar2r", "--into", "package", "--tex"],
        ["check", "package"],
        ["import", "one.urdf", "--into", "one.toml"],
        ["excite", "planar2r", *LIMITS, *parameters, "--duration", "2", "--budget", "2"]
        + ["--into", "run.csv"],
        ["simulate", "planar2r", *parameters, "--duration", "4", "--into", "log.csv"],
        ["identify", "planar2r", "log.csv", "--into", "est"],
        ["predict", "planar2r", "log.csv", *parameters, "--into", "prediction"],
        ["diagnose", "planar2r", "log.csv", "--into", "diagnosis"],
        ["report", "est"],
        ["report", "est", "est"],
        ["demo", "--runs", "20"],
    ]
    for command in commands:
        done = subprocess.run(
            [place / "symgen", *command],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env=_environment(tmp_path),
        )
        # In 2 s of search excite may say that its runs are not good enough, by a 1; one estimate
        # beside itself shows no agreement.
        accepted = (0, 1) if command[0] == "excite" or command.count("est") == 2 else (0,)
        assert done.returncode in accepted, (command, done.stdout[-500:], done.stderr[-2000:])
        assert done.stdout.strip(), command
