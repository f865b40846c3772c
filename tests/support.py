"""What several tests share: places of data, and random robots as symgen reads them."""

from __future__ import annotations

import os
import random
import signal
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.random_arms import to_toml
from oracles.transforms import Arm

import symgen
from symgen import Limits, Motion, Robot, Search, SymgenWarning, parse_robot
from symgen.estimation.equation_model import NEEDED, EquationModel, kernels_of
from symgen.estimation.system import Equations, Extent, Rows
from symgen.experiment.plan import Plan
from symgen.runtime import build
from symgen.symbolic.base_parameters import BaseParameter

PROJECT = Path(__file__).resolve().parents[1]
#: Draws which cases of a long table the default suite runs.
SAMPLE = "1"
#: Kernels of identification and simulation; a package with all takes seconds to compile.
MOVED = (*kernels_of(EquationModel(name, 0.2) for name in NEEDED), "mass_matrix")


def forget_compilers() -> None:
    """Forget the compilers that were found, so that the next search looks again."""
    build._first_working.cache_clear()
    build._probe.cache_clear()


def data_folder() -> Path:
    """Return the folder of the real logs, or skip the test where it is absent."""
    folder = Path(os.environ.get("SYMGEN_DATA", PROJECT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real logs: {folder} is absent (set SYMGEN_DATA)")
    return folder


def shared_file(name: str) -> Path:
    """Return a file beside the real logs, or skip the test where it is absent."""
    default = Path(os.environ.get("SYMGEN_DATA", PROJECT.parent / "shared" / "data")).parent
    path = Path(os.environ.get("SYMGEN_SHARED", default)) / name
    if not path.is_file():
        pytest.skip(f"{path} is absent (set SYMGEN_SHARED)")
    return path


def robot_of(
    arm: Arm, friction: tuple[str, ...] = (), rotor: bool = True, name: str = "arm"
) -> Robot:
    """Return an oracle's arm as a robot, read from the text of a robot.toml."""
    return parsed(to_toml(arm, name, friction, rotor), name)


def parsed(text: str, name: str = "arm") -> Robot:
    """Read a robot.toml; random angles may come near a fraction of pi."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymgenWarning)
        return parse_robot(text, name)


def regrouping_error(
    parameters: Iterable[BaseParameter], column: Mapping[str, np.ndarray], values: dict[Any, Any]
) -> float:
    """Return the largest error of columns as sums of those of the heads that they are joined to."""
    heads = {p.head for p in parameters}
    rebuilt = {name: 0 * x for name, x in column.items() if name not in heads}
    for p in parameters:
        for c, name in p.terms:
            if name in rebuilt:
                rebuilt[name] += float(c.subs(values).evalf(30)) * column[p.head]
    return max((np.abs(x - column[name]).max() for name, x in rebuilt.items()), default=0.0)


def excited(robot: Robot | str, **options: Any) -> Plan:
    """Excite by options of one dictionary, as figures keep them; the model is energy by default."""
    made = {
        name: kind(**{f.name: options.pop(f.name) for f in fields(kind) if f.name in options})
        for name, kind in (("limits", Limits), ("motion", Motion), ("search", Search))
    }
    return symgen.excite(robot, **made, **({"model": "energy"} | options))


def sampled(cases: Iterable[Any], count: int, always: Sequence[Any] = ()) -> list[Any]:
    """Return cases of a test: some drawn by the seed SAMPLE and `always`, the others marked slow.

    A case of several arguments is a tuple. `-m slow` runs what the default suite leaves out.
    """
    every = list(cases)
    drawn = random.Random(SAMPLE).sample([c for c in every if c not in always], count)
    slow = [c not in (*always, *drawn) for c in every]
    return [
        pytest.param(*(c if isinstance(c, tuple) else (c,)), marks=[pytest.mark.slow] * late)
        for c, late in zip(every, slow, strict=True)
    ]


def heeds_ctrl_c() -> None:
    """Have a process heed Ctrl-C: what a shell starts with `&` inherits that it is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def messages(err: str) -> list[str]:
    """Return the lines of stderr that are no progress, which is indented."""
    return [line for line in err.splitlines() if not line.startswith("  ")]


def rows_of(names: Sequence[str], *parts: Equations) -> Rows:
    """The equations of one joint in several logs as one value."""
    channels = {}
    for key in ("W", "y", "Z", "features"):
        if all(getattr(e, key) is not None for e in parts):
            channels[key] = np.concatenate([getattr(e, key)[:, None] for e in parts])
    extents = tuple(Extent(e.rows, e.correlation) for e in parts)
    weight = np.ones_like(channels["y"])
    energy = parts[0].joint is None
    t = 0.01 * np.arange(len(weight))
    return Rows(tuple(names), t=t, weight=weight, extents=extents, energy=energy, **channels)
