"""A Python that finds what the wheel declares, and nothing else of what is installed here."""

from __future__ import annotations

import os
import sys
import tomllib
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from support import PROJECT


def declared(folder: Path) -> tuple[list[str], dict[str, str]]:
    """Return command and environment of a symgen that has its declared dependencies alone.

    Links to their distributions, resolved from pyproject.toml as pip does, fill the folder. That
    takes no second, where an installation takes a minute. The interpreter reads no site-packages.
    """
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))["project"]
    waiting, seen = [*project["dependencies"]], set[tuple[str, str]]()
    while waiting:
        wanted = Requirement(waiting.pop())
        for extra in ("", *wanted.extras):
            if (wanted.name, extra) in seen:
                continue
            seen.add((wanted.name, extra))
            found = distribution(wanted.name)
            _link(found, folder)
            for line in found.requires or ():
                marker = Requirement(line).marker
                if marker is None or marker.evaluate({"extra": extra}):
                    waiting.append(line)
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL"))}
    path = os.pathsep.join(map(str, (PROJECT, folder)))
    return [sys.executable, "-S", "-m", "symgen"], {**kept, "PYTHONPATH": path}


def _link(found: Distribution, folder: Path) -> None:
    """Link what a distribution has in site-packages; its scripts lie elsewhere."""
    for top in {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}:
        if not (folder / top).exists():
            (folder / top).symlink_to(str(found.locate_file(top)))
