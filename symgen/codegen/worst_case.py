"""What a call of each kernel takes on a Cortex-M7 at most, as counted for robots of the library.

worst_case.toml is written by tests/benchmarks/bench_instructions.py: nothing here counts. A robot
is known by its robot.toml, so that another geometry has no figures.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

from symgen.codegen.kernels import Kernel
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot


def key(robot: Robot) -> str:
    """Return what tells a robot from another: the first 64 bits of the SHA-256 of robot.toml."""
    return hashlib.sha256(robot_toml(robot).encode()).hexdigest()[:16]


def worst_case(robot: Robot, kernels: Sequence[Kernel]) -> dict[str, Any]:
    """Return the compiler, and rows (kernel, instructions and bytes in double, then in float).

    Args:
        robot: whose kernels these are.
        kernels: those of the package; those that nobody has counted have no row.
    """
    known = _figures()
    counts = known["robots"].get(key(robot), {})
    rows = [(k.name, *counts[k.name]) for k in kernels if k.name in counts]
    return {"compiler": known["compiler"], "rows": rows}


@cache
def _figures() -> Any:
    return tomllib.loads((resources.files("symgen.codegen") / "worst_case.toml").read_text("utf-8"))
