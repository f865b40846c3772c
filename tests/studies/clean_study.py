"""How many logs of sound robots are good for prediction.

    python tests/studies/clean_study.py --runs 100 --seed 95000

Runs are those of oracles/clean_runs.py, no fault and no effect missing, but a smooth torque of
`--misfit` on each joint that no model has.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracles import clean_runs
from simulated_runs import identified

SEED, MISFIT = 95_000, 0.05


def attempt(seed: int, misfit: float) -> dict[str, object]:
    """Verdict and reasons of one run."""
    run = clean_runs.run(seed, effects=False, misfit=misfit)
    found = identified(run)
    reasons = found["reasons"]
    return {
        "seed": seed,
        "arm": run.drawn["arm"],
        "verdict": found["verdict"],
        "said": found["torque_residual"]["validation"]["relative"],
        "error": found["uses"]["prediction"]["grade"] == "poor",
        "reasons": [r["kind"] for r in reasons],
    }


def main() -> int:
    """Run, print and count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--misfit", type=float, default=MISFIT)
    options = parser.parse_args()
    rows = []
    for seed in range(options.seed, options.seed + options.runs):
        rows.append(attempt(seed, options.misfit))
        print(rows[-1], flush=True)
    poor = sum(bool(r["error"]) for r in rows)
    good = sum(r["verdict"] == "trusted" for r in rows)
    print(f"{len(rows)} runs: {poor} poor, {good} good for prediction")
    return 0


if __name__ == "__main__":
    sys.exit(main())
