"""Excitation of the TX40 within limits: condition numbers reached, by model, window and family.

    python tests/benchmarks/bench_excite.py

The robot is the library's tx40: 58 columns (40 of inertia and rotors; Coulomb, viscous and offset
of every joint). The limits are ours, and so is the prior model: slender links, and friction as
below. Coefficients and figures go to tests/workflow/excite_figures.json, which the default tests
compute again.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support import excited

FIGURES = Path(__file__).resolve().parents[1] / "workflow" / "excite_figures.json"
LIMITS: dict[str, Any] = {
    "position": [(-2.5, 2.5), (-2.0, 2.0), (-2.2, 2.2), (-3.0, 3.0), (-2.0, 2.0), (-3.0, 3.0)],
    "velocity": [3.0] * 6,
    "acceleration": [12.0] * 6,
}
TORQUE = [30.0, 40.0, 20.0, 7.0, 7.0, 4.0]
# Ended by counts, not by time: the same figures on a slow machine.
SEARCH: dict[str, Any] = {"searches": 1, "budget": 3600.0}
ONE: dict[str, Any] = {"duration": 10, "terms": 12, "iterations": 600}
FOUR: dict[str, Any] = {"runs": 4, "duration": 10, "terms": 8, "iterations": 250}
CASES: dict[str, dict[str, Any]] = {
    "torque, one run": ONE | {"model": "torque"},
    "torque, one run, B-splines": ONE | {"model": "torque", "kind": "bspline", "terms": 28},
    "momentum, one run": ONE | {"model": "momentum"},
    "energy, one run": ONE,
    "energy, four runs, 0.1 s windows": FOUR | {"window": 0.1, "iterations": 600},
    "energy, four runs, 0.2 s windows": FOUR,
    "energy, four runs, 0.3 s windows": FOUR | {"window": 0.3},
    "energy, four runs, torque and jerk limited, one start": FOUR
    | {"torque": TORQUE, "jerk": [40.0] * 6, "start": [0.0, 0.0, 1.5, 0.0, 0.0, 0.0]},
    "energy, four runs, B-splines": FOUR | {"kind": "bspline", "terms": 20},
}


def prior() -> str:
    """Return [parameters] of a made-up arm: slender links, friction, rotors."""
    lines = ["[parameters]"]
    for j, (mass, length) in enumerate(
        [(8, 0.0), (6, 0.22), (4, 0.1), (2.5, 0.1), (0.6, 0.02), (0.3, 0.02)], start=1
    ):
        c, thick = length / 2, mass * 0.05**2
        x, z = (c, 0.0) if j == 2 else (0.0, c)
        values = {
            "XX": thick + mass * z * z * 4 / 3,
            "YY": thick + mass * c * c * 4 / 3,
            "ZZ": thick + mass * x * x * 4 / 3,
            "MX": mass * x,
            "MZ": mass * z,
            "M": mass,
            "IA": [0.36, 0.36, 0.1, 0.03, 0.05, 0.01][j - 1],
            "FS": [7.0, 8.0, 6.0, 2.5, 3.0, 0.3][j - 1],
            "FV": [8.0, 5.5, 2.0, 1.1, 1.9, 0.65][j - 1],
        }
        zeros = dict.fromkeys(("XY", "XZ", "YZ", "MY", "OF"), 0.0)
        lines += [f"{name}{j} = {value:.6g}" for name, value in (zeros | values).items()]
    return "\n".join(lines) + "\n"


def rounded(run: dict[str, Any]) -> dict[str, Any]:
    """Return a run with coefficients of 7 decimals, which change no figure that is shown."""
    for joint in run["joints"]:
        joint["coefficients"] = [round(c, 7) for c in joint["coefficients"]]
    return run


def main() -> None:
    """Search, print the table, and write the figures."""
    table = Table(title="tx40, runs of 10 s, one search of 600 or 250 iterations, seed 0")
    for head in (
        "case",
        "random start",
        "reached",
        "energy",
        "momentum",
        "torque",
        "binds",
        "s of CPU",
    ):
        table.add_column(head)
    figures: dict[str, Any] = {"limits": LIMITS, "prior": prior(), "cases": {}}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "prior.toml"
        path.write_text(prior())
        for name, case in CASES.items():
            given = {"parameters": path} if "torque" in case else {}
            begun = time.process_time()
            plan = excited("tx40", **LIMITS, **case, **given, **SEARCH)
            seconds = time.process_time() - begun
            binds = ", ".join(dict.fromkeys(u.limit for u in plan.binding))
            row = [name, f"{plan.start:.3g}", f"{plan.condition:.3g}"]
            row += [f"{plan.conditions[m]:.3g}" for m in ("energy", "momentum", "torque")]
            table.add_row(*row, binds, f"{seconds:.0f}")
            print(*row, binds, f"{seconds:.0f}", file=sys.stderr, flush=True)
            figures["cases"][name] = {
                "case": case,
                "start": plan.start,
                "condition": plan.conditions,
                "share": max(u.share for u in plan.uses),
                "runs": [rounded(run.to_dict()) for run in plan.runs],
            }
            FIGURES.write_text(json.dumps(figures) + "\n")
    Console(width=150).print(table)


if __name__ == "__main__":
    main()
