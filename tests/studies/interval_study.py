"""How often the 95 % intervals of `symgen identify` hold the truth: simulated runs.

    python tests/studies/interval_study.py --runs 100 --seed 60000 --out figures.json --workers 2

Runs are those of tests/oracles/clean_runs.py. Each is drawn three times from its seed: as
robot.toml has it ("noise"), with a smooth torque of 1 % that no model has ("misfit"), and with
effects of 2 to 25 % that robot.toml leaves out ("effects"). True base parameters are the
solution of the machine's exact torques in random states, without these effects. For each kind of
parameter stands how many intervals, X - 1.96 std to X + 1.96 std, hold the truth; the interval of
95 % of that number, by a bootstrap of whole runs; and by which factor the intervals would have to
be longer, or could be shorter, to hold 95 % ("noise") or 90 % (the others).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from figures import keep
from oracles import clean_runs
from simulated_runs import evaluator, identified

GOALS = {"noise": 0.95, "misfit": 0.90, "effects": 0.90}
MISFIT = 0.01
_DRAWS, _SEED = 1000, 7
_STATES = 300
#: What the figure file keeps of a run.
KEPT = ("seed", "family", "model", "parameters", "held")
#: Kinds of parameters by their first letters.
KINDS = {"FS": "Coulomb", "FV": "viscous", "OF": "offset", "IA": "inertia", "M": "moment"}


def kind(name: str) -> str:
    """The kind of a base parameter."""
    letters = re.match("[A-Z]+", name)
    assert letters is not None
    return next((word for key, word in KINDS.items() if letters[0].startswith(key)), "inertia")


def true_parameters(run: clean_runs.Run) -> np.ndarray:
    """Base parameters of a run's machine, exact: from its torques in random states."""
    kernels = evaluator(run.robot_toml)
    states = np.random.default_rng(_SEED).normal(size=(3, _STATES, run.clean.q.shape[1]))
    motion = clean_runs.Motion(np.arange(_STATES), *states)
    W = np.asarray(kernels["torque_regressor"](*states))
    W, y = W.reshape(-1, W.shape[2]), run.exact(motion).ravel()
    scale = np.linalg.norm(W, axis=0)
    X = np.linalg.lstsq(W / scale, y, rcond=None)[0] / scale
    left = np.linalg.norm(y - W @ X) / np.linalg.norm(y)
    assert left < 1e-9, left  # the model is the machine
    return np.asarray(X)


def attempt(job: tuple[int, str]) -> dict[str, Any]:
    """The errors of one run in standard deviations, by parameter."""
    import symgen

    seed, family = job
    misfit = MISFIT if family == "misfit" else 0.0
    run = clean_runs.run(seed, effects=family == "effects", misfit=misfit)
    try:
        estimate = identified(run)
    except symgen.SymgenError as error:
        return {"seed": seed, "family": family, "refused": str(error)}
    told, X = estimate["parameters"], true_parameters(run)
    errors = {
        p["name"]: (p["value"] - x) / max(p["std"], 1e-300) for p, x in zip(told, X, strict=True)
    }
    return {"seed": seed, "family": family, "model": estimate["model"],
            "verdict": estimate["verdict"], "errors": errors}  # fmt: skip


def summary(rows: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Coverage by family and kind."""
    out: dict[str, Any] = {}
    for family, goal in GOALS.items():
        runs = [r["errors"] for r in rows if r["family"] == family and "errors" in r]
        by_kind = {"all": [np.abs(list(r.values())) for r in runs]}
        for word in sorted({kind(name) for r in runs for name in r}):
            by_kind[word] = [np.abs([x for n, x in r.items() if kind(n) == word]) for r in runs]
        out[family] = {word: _coverage(parts, goal) for word, parts in by_kind.items()}
    return out


def _coverage(runs: list[np.ndarray], goal: float) -> dict[str, Any]:
    held, count = (np.array([f(r) for r in runs]) for f in (lambda r: np.sum(r <= 1.96), len))
    rng = np.random.default_rng(_SEED)
    drawn = rng.integers(len(runs), size=(_DRAWS, len(runs)))
    shares = held[drawn].sum(axis=1) / np.maximum(count[drawn].sum(axis=1), 1)
    needed = float(np.quantile(np.concatenate(runs), goal)) / 1.96
    return {
        "parameters": int(count.sum()), "held": float(held.sum() / count.sum()),
        "low": float(np.quantile(shares, 0.025)), "high": float(np.quantile(shares, 0.975)),
        "factor": needed,
    }  # fmt: skip


def short(row: dict[str, Any]) -> dict[str, Any]:
    """What the figure file keeps of a run: how many intervals, and how many hold the truth."""
    errors = np.abs(list(row.get("errors", {}).values()))
    row = row | {"parameters": len(errors), "held": int(np.sum(errors <= 1.96))}
    return {key: row[key] for key in KEPT if key in row}


def study(runs: int, seed: int, workers: int = 1) -> list[dict[str, Any]]:
    """Rows of so many runs of each family from a seed on."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    jobs = [(k, family) for k in range(seed, seed + runs) for family in GOALS]
    rows = []
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for row in pool.map(attempt, jobs):
            rows.append(row)
            worst = max((abs(x) for x in row.get("errors", {}).values()), default=0.0)
            print(row["seed"], row["family"], row.get("model"), row.get("verdict"),
                  f"{worst:.3g}", file=sys.stderr, flush=True)  # fmt: skip
    return rows


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=100, help="of each family")
    parser.add_argument("--seed", type=int, default=60_000, help="of the first run")
    parser.add_argument("--out", type=Path, help="figures, as JSON")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    rows = study(options.runs, options.seed, options.workers)
    print(json.dumps(summary(rows), indent=1))
    if options.out:
        head = {"runs": options.runs, "seed": options.seed, "summary": summary(rows)}
        keep(options.out, {**head, "rows": list(map(short, rows))})


if __name__ == "__main__":
    main()
