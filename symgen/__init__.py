"""symgen: dynamic models of robots in closed form, and their parameters from measured logs.

    robot = symgen.read_robot("planar2r")
    model = symgen.derive(robot)
    evaluator = symgen.load(model)
    estimate = symgen.identify(evaluator, ["train.csv"], validation=["test.csv"])

Names are imported when they are first used, so that `import symgen` costs nothing; which there are
stands once, in the stub beside this file that editors and type checkers read.
"""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from typing import Any

_WHERE = {
    name.name: str(line.module)
    for line in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(line, ast.ImportFrom)
    for name in line.names
}
__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'symgen' has no attribute {name!r}")
    return getattr(importlib.import_module(_WHERE[name]), name)


def __dir__() -> list[str]:
    return __all__
