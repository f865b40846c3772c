"""Cuts of real logs: is the default as good as the best of torque and momentum by both methods?

    python tests/studies/choice_study.py [RIG ...] [--seconds 5 10 20] --out FILE

Each rig of data/ is identified from cuts of its training logs, at ten starts, and whole. The torque
error on the validation logs of the default is compared with the least of four: torque and momentum,
each by least squares and by the possible parameters. All five share the search of the default.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support import data_folder

import symgen
from symgen.data.log import Log, read_log
from symgen.identification import workflow

STARTS = 10
FOUR = [(model, method) for model in ("torque", "momentum") for method in ("wls", "consistent")]
KERNELS = "all"
#: Ratios to the least error that are listed, and that are far.
NEAR, FAR = 1.15, 1.5


def cut(log: Log, start: float, seconds: float) -> Log:
    """Return a part of a log."""
    inside = (log.t >= start) & (log.t < start + seconds)
    parts = {
        key: value[inside]
        for key, value in vars(log).items()
        if isinstance(value, np.ndarray) and len(value) == len(log.t)
    }
    return replace(log, **parts)


def cuts(logs: Sequence[Log], seconds: float) -> Iterator[Log]:
    """Return cuts at evenly spaced starts over all logs that are longer."""
    room = [(log, log.t[-1] - log.t[0] - seconds) for log in logs]
    room = [(log, left) for log, left in room if left > 0]
    for place in np.linspace(0, sum(left for _, left in room), STARTS) if room else ():
        rest = float(place)
        for log, left in room:
            if rest <= left or log is room[-1][0]:
                yield cut(log, float(log.t[0]) + min(rest, left), seconds)
                break
            rest -= left


def once(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that repeats its first result."""
    results: list[Any] = []

    def repeated(*arguments: Any, **options: Any) -> Any:
        if not results:
            results.append(function(*arguments, **options))
        return results[0]

    return repeated


def errors(evaluator: symgen.Evaluator, logs: Sequence[Log], held: Sequence[Log]) -> dict[str, Any]:
    """Return the validation errors of the default and of the four, and what the default is."""
    shared = {name: getattr(workflow, name) for name in ("ask_search", "filter_in_band")}
    try:
        for name, function in shared.items():
            setattr(workflow, name, once(function))
        row: dict[str, Any] = {}
        for model, method in (("auto", "auto"), *FOUR):
            try:
                found = symgen.identify(
                    evaluator, logs, validation=held, model=model, method=method
                )
            except symgen.SymgenError as error:
                row[f"{model} {method}"] = None
                row["refused"] = str(error)[:60]
                continue
            row[f"{model} {method}"] = found.torque_validation.relative
            if model == "auto":
                row["chosen"] = f"{found.model} {found.method}"
        return row
    finally:
        for name, function in shared.items():
            setattr(workflow, name, function)


def study(rig: str, seconds: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Return a row for each cut of a rig, and for its whole logs."""
    folder = data_folder() / rig
    robot = symgen.read_robot(folder / "robot.toml")
    evaluator = symgen.load(symgen.derive(robot, KERNELS))
    files = sorted(p for p in folder.iterdir() if p.suffix in (".csv", ".npz"))
    train = [read_log(p) for p in files if p.stem.startswith("train")]
    held = [read_log(p) for p in files if p.stem in ("test", "test2", "ptp")]
    for length in seconds:
        for log in cuts(train, length):
            about = {"rig": rig, "log": log.name, "seconds": length, "start": float(log.t[0])}
            yield about | errors(evaluator, [log], held)
    yield {"rig": rig, "log": "all", "seconds": math.inf, "start": 0.0} | errors(
        evaluator, train, held
    )


def ratio(row: dict[str, Any]) -> float:
    """Return the error of the default over the least of the four; NaN without any."""
    four = [row[f"{model} {method}"] for model, method in FOUR]
    least = min((x for x in four if x is not None), default=math.nan)
    default = row["auto auto"]
    return math.nan if default is None else default / least


def main() -> None:
    """Print a line for each case, and the share of near and of far ones."""
    parser = argparse.ArgumentParser()
    parser.add_argument("rigs", nargs="*")
    parser.add_argument("--seconds", nargs="*", type=float, default=[5.0, 10.0, 20.0])
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rigs = options.rigs or sorted(p.name for p in data_folder().iterdir() if p.is_dir())
    rows = []
    for rig in rigs:
        for row in study(rig, options.seconds):
            row["ratio"] = ratio(row)
            rows.append(row)
            numbers = " ".join(
                f"{model[0]}{method[0]} {100 * (row[f'{model} {method}'] or math.nan):.3g}"
                for model, method in (("auto", "auto"), *FOUR)
            )
            where = f"{rig} {row['log']} {row['seconds']:g} s from {row['start']:.2f}"
            print(f"{where}: {row['ratio']:.2f} {row.get('chosen')} | {numbers}", flush=True)
    ratios = np.array([row["ratio"] for row in rows if math.isfinite(row["ratio"])])
    near, far = np.mean(ratios <= NEAR), np.mean(ratios > FAR)
    print(f"{len(ratios)} cases: {near:.1%} within {NEAR}, {far:.1%} above {FAR}")
    if options.out:
        options.out.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
