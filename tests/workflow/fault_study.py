"""What identify and diagnose say of logs whose measuring chain is at fault.

    python tests/workflow/fault_study.py emps ur10 arm5r-3 --seed 1 --draws 1 [--faults swapped]

Robots are folders of the shared data, or simulated arms of oracles/clean_runs.py with the number of
the run, nothing missing in their robot.toml. Every fault of tests/oracles/faults.py, drawn at
random, is put into the training and the validation log of a robot, both alike. It is visible where
undoing it lowers the held-out error of an engineer (oracles/engineer.py, not the core) on some
joint by a tenth and by three standard deviations over blocks of time. Counted are: visible ones
that were named with a channel, repaired or refused; those that identify trusts with a torque model
that is off by more than 5 % of the torque from that of the logs without the fault; those that
diagnose calls consistent or explained without naming them.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracles import clean_runs, engineer, faults
from oracles.faults import Log
from support import data_folder, figures_text

WRONG, TENTH, STD, BLOCKS = 0.05, 0.9, 3.0, 20
#: What the figure file keeps of a row.
KEPT = ("robot", "fault", "seed", "channels", "visible", "identify", "identify_named", "wrong",
        "diagnose", "diagnose_named")  # fmt: skip


@cache
def logs_of(robot: str) -> tuple[Path, Log, Log]:
    """robot.toml, training and validation log."""
    if "-" in robot:
        arm, number = robot.split("-")
        run = clean_runs.run(int(number), arms=(arm,), effects=False)
        toml = Path(tempfile.mkdtemp()) / "robot.toml"
        toml.write_text(run.robot_toml, "utf-8")
        return toml, run.train, run.validation
    folder = data_folder() / robot
    ends = ".npz" if (folder / "train.npz").exists() else ".csv"
    train, test = (Log(*engineer.channels(folder / f"{name}{ends}")) for name in ("train", "test"))
    return folder / "robot.toml", train, test


def parameters(estimate: Any) -> np.ndarray:
    """X of an estimate."""
    return np.array([p.value for p in estimate.parameters])


@cache
def unspoiled(robot: str) -> np.ndarray:
    """X of the logs as they are."""
    import symgen

    toml, train, test = logs_of(robot)
    with tempfile.TemporaryDirectory() as folder:
        paths = [log.save(Path(folder) / f"{k}.npz") for k, log in enumerate((train, test))]
        return parameters(symgen.identify(toml, paths[:1], validation=paths[1:]))


@cache
def kernel(toml: Path) -> Any:
    """torque_regressor, all that the engineer is given."""
    import symgen

    return symgen.load(symgen.derive(symgen.read_robot(toml), ("torque_regressor",)))[
        "torque_regressor"
    ]


def equations(
    toml: Path, log: Log, cutoff: float, comparison: float
) -> tuple[np.ndarray, np.ndarray]:
    """The engineer's regressor and torque of a log."""
    even = engineer.even(log.t, log.q, log.qd, log.tau)
    return engineer.equations(kernel(toml), even, cutoff, comparison, False, 250.0)


def squares(toml: Path, train: Log, test: Log, comparison: float) -> np.ndarray:
    """Squared error of the engineer's own fit on the validation log, by block and joint."""
    X, cutoff = engineer.analyst(
        kernel(toml), [engineer.even(train.t, train.q, train.qd, train.tau)], comparison
    )
    W, y = equations(toml, test, cutoff, comparison)
    error = (y - W @ X) ** 2 / np.sum(y**2, axis=0)
    return np.array([block.sum(axis=0) for block in np.array_split(error, BLOCKS)])


def visible(clean: np.ndarray, spoiled: np.ndarray) -> bool:
    """Whether undoing the fault lowers the error of some joint by a tenth, and surely."""
    gained = spoiled - clean
    sure = gained.sum(axis=0) > STD * gained.std(axis=0, ddof=1) * np.sqrt(len(gained))
    ratio = np.sqrt(clean.sum(axis=0) / np.maximum(spoiled.sum(axis=0), 1e-300))
    return bool((sure & (ratio <= TENTH)).any())


def named(channels: tuple[str, ...], words: str) -> bool:
    """Whether some words speak of one of the channels, or of all."""
    if not channels:
        return bool(words)
    own = "|".join(rf"\b{c}\b" for c in channels)
    joints = {c.lstrip("qdtau") for c in channels}
    more = "|".join(rf"joints? {j}\b" for j in joints if j)
    return bool(re.search(rf"{own}|{more or 'all joints'}|all joints|\ball\b|\bstamps\b", words))


def attempt(robot: str, fault: str, seed: int) -> dict[str, Any]:
    """One fault: what is visible, and what both commands say."""
    import symgen

    toml, train, test = logs_of(robot)
    spoil = getattr(faults, fault)
    if fault in {f.__name__ for f in faults.PAIRS} and train.n < 2:
        return {}
    if fault in {f.__name__ for f in faults.SPEEDS} and train.qd is None:
        return {}
    bad_train, done = spoil(train, np.random.default_rng(seed))
    bad_test, _ = spoil(test, np.random.default_rng(seed))
    row: dict[str, Any] = {
        "robot": robot,
        "fault": fault,
        "seed": seed,
        "channels": list(done.channels),
        "value": str(done.value)[:60],
    }
    begin = time.perf_counter()
    comparison = engineer.comparison_band([engineer.even(train.t, train.q, train.qd, train.tau)])
    try:
        row["visible"] = visible(
            squares(toml, train, test, comparison), squares(toml, bad_train, bad_test, comparison)
        )
    except (ValueError, np.linalg.LinAlgError):
        row["visible"] = True
    with tempfile.TemporaryDirectory() as folder:
        paths = [
            log.save(Path(folder) / f"{name}.npz")
            for name, log in (("train", bad_train), ("validation", bad_test))
        ]
        try:
            estimate = symgen.identify(toml, paths[:1], validation=paths[1:])
        except symgen.SymgenError as error:
            row |= {"identify": "refused", "says": str(error), "wrong": 0.0}
        else:
            content = estimate.to_json()
            words = [
                *content["reasons"],
                *(f"{r['channel']} {r['fault']}" for r in content["repairs"]),
            ]
            W, _ = equations(toml, test, min(content["band"]["cutoff_hz"], 30.0), comparison)
            clean = W @ unspoiled(robot)
            off = W @ parameters(estimate) - clean
            row |= {
                "identify": content["verdict"],
                "says": "; ".join(words),
                "wrong": float(np.linalg.norm(off) / np.linalg.norm(clean)),
            }
        row["identify_s"] = time.perf_counter() - begin
        begin = time.perf_counter()
        try:
            found = symgen.diagnose(toml, paths[:1], validation=paths[1:])
        except symgen.SymgenError as error:
            row |= {"diagnose": "refused", "tells": str(error)}
        else:
            effects = [f"{e.name} on joint {' '.join(map(str, e.joints))}" for e in found.effects]
            repairs = [f"{r.channel} {r.fault}" for r in found.repairs]
            row |= {
                "diagnose": found.verdict,
                "tells": "; ".join([*effects, *repairs, *found.advice]),
                "before": found.before.total,
                "after": found.after.total,
            }
        row["diagnose_s"] = time.perf_counter() - begin
    for command, words in (("identify", "says"), ("diagnose", "tells")):
        row[f"{command}_named"] = named(tuple(row["channels"]), row[words])
    return row


def line(row: dict[str, Any]) -> str:
    """A fault in one line."""
    marks = []
    if row["identify"] == "trusted" and row["wrong"] > WRONG and row["visible"]:
        marks.append("TRUSTED WRONG")
    if row["visible"] and not row["identify_named"] and row["identify"] != "refused":
        marks.append("NOT SAID by identify")
    if row["visible"] and not row["diagnose_named"] and row["diagnose"] != "refused":
        marks.append("NOT NAMED by diagnose")
        if row["diagnose"] in ("consistent", "explained"):
            marks.append("EXPLAINED AWAY")
    gap = f" {100 * row['before']:.3g} -> {100 * row['after']:.3g} %" if "before" in row else ""
    return (
        f"{row['robot']} {row['fault']} {row['channels']} {row['value']}: "
        f"{'visible' if row['visible'] else 'not visible'}; identify {row['identify']} "
        f"(wrong {100 * row['wrong']:.2g} %, {row['identify_s']:.0f} s): {row['says'][:160]} | "
        f"diagnose {row['diagnose']}{gap} ({row['diagnose_s']:.0f} s): {row['tells'][:200]} "
        f"{' '.join(marks)}"
    )


def summary(rows: list[dict[str, Any]]) -> dict[str, int]:
    """The counts."""
    seen = [row for row in rows if row["visible"]]
    return {
        "faults": len(rows),
        "visible": len(seen),
        "identify_names_or_refuses": sum(
            r["identify_named"] or r["identify"] == "refused" for r in seen
        ),
        "diagnose_names_or_refuses": sum(
            r["diagnose_named"] or r["diagnose"] == "refused" for r in seen
        ),
        "trusted_wrong": sum(r["identify"] == "trusted" and r["wrong"] > WRONG for r in seen),
        "explained_away": sum(
            r["diagnose"] in ("consistent", "explained") and not r["diagnose_named"] for r in seen
        ),
    }


def text(rows: list[dict[str, Any]]) -> str:
    """JSON with a line for each fault; three digits."""
    return figures_text({"summary": summary(rows)}, rows, KEPT)


def main() -> int:
    """Run, print and count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("robots", nargs="*", default=["emps"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--draws", type=int, default=1)
    parser.add_argument("--faults", nargs="*", default=[f.__name__ for f in faults.HEAVY])
    parser.add_argument("--out", type=Path, help="rows and counts, as JSON")
    options = parser.parse_args()
    rows = []
    for robot in options.robots:
        for fault in options.faults:
            for seed in range(options.seed, options.seed + options.draws):
                row = attempt(robot, fault, seed)
                if row:
                    rows.append(row)
                    print(line(row), flush=True)
    print(json.dumps(summary(rows), indent=1))
    if options.out:
        options.out.write_text(text(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
