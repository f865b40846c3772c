"""Real logs: does the line that `diagnose` prints deliver the error that it promises?

    python tests/studies/promise_study.py --out promise
    python tests/studies/promise_study.py --only ur10e --parts whole --twice --out ur10e
    python tests/studies/promise_study.py my/arm other/arm --only arm --out arms

A rig is a folder with robot.toml, training logs train* and validation logs test, test2 or ptp; the
rigs are those of data/ and the folders given. Each is a case whole, and by the first and by the
second half of its training logs, where a half has HALF_S. All commands run in a folder of copies:
identify with the declared robot, diagnose, and the line after `next:` word by word. Errors are
those of joints in motion. OUT.json has all figures, OUT.md the tables.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2, norm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support import data_folder

PARTS = ("whole", "first", "second")
HELD = ("test", "test2", "ptp")
HALF_S = 5.0
#: Units of the first column, which is the time, where its name says another one than s.
UNITS = {"t_us": 1e-6}
#: Largest deviation of three digits; of a promise that is nearly kept.
DIGITS, NEAR = 1e-3, 1.05
#: Smallest probability that a distance is given for; that of 37 deviations.
SMALLEST = 1e-300
#: Factor on the error of the simulation that is worse.
ROUGHER = 1.1
#: Share of the error that a bad measurement has to close; deviations of a coefficient.
CLOSES, DEVIATIONS = 0.1, 3.0

Row = dict[str, Any]


@dataclass(frozen=True)
class Run:
    """What a command ended with: exit code, output, and processor time with its children."""

    code: int
    text: str
    seconds: float


def symgen(words: Sequence[str], folder: Path) -> Run:
    """Run a command of symgen in a folder."""
    command = [sys.executable, "-m", "symgen", *words]
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command, cwd=folder, stdout=output, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        output.seek(0)
        text = output.read()
    return Run(os.waitstatus_to_exitcode(status), text, used.ru_utime + used.ru_stime)


def times(log: Path) -> np.ndarray:
    """Return the time stamps of a log, in s."""
    if log.suffix == ".npz":
        return np.asarray(np.load(log)["t"])
    with log.open() as lines:
        name = next(lines).split(",")[0].strip()
        return UNITS.get(name, 1.0) * np.array([float(line.split(",")[0]) for line in lines])


def halves(log: Path) -> bool:
    """Whether each half of a log has HALF_S, to one sample."""
    t = times(log)
    duration = t[-1] - t[0]
    return bool(duration / 2 > HALF_S - duration / len(t))


def copy_part(log: Path, part: str, target: Path) -> None:
    """Copy a log or one half of its rows."""
    if part == "whole":
        shutil.copyfile(log, target)
        return
    rows = len(times(log))
    kept = slice(0, rows // 2) if part == "first" else slice(rows // 2, rows)
    if log.suffix == ".npz":
        np.savez(target, **{name: column[kept] for name, column in np.load(log).items()})
        return
    header, *lines = log.read_text("utf-8").splitlines(keepends=True)
    target.write_text("".join([header, *lines[kept]]), "utf-8")


def prepare(rig: Path, part: str, folder: Path) -> list[str]:
    """Copy a case into a folder and return its arguments; empty if no half is long enough."""
    logs = [log for log in sorted(rig.iterdir()) if log.suffix in (".csv", ".npz")]
    train = [log for log in logs if log.stem.startswith("train")]
    if part != "whole":
        train = [log for log in train if halves(log)]
    if not train:
        return []
    held = [log for stem in HELD for log in logs if log.stem == stem]
    shutil.copyfile(rig / "robot.toml", folder / "robot.toml")
    for log in train:
        copy_part(log, part, folder / log.name)
    for log in held:
        shutil.copyfile(log, folder / log.name)
    options = [word for log in held for word in ("--validation", log.name)]
    return ["robot.toml", *(log.name for log in train), *options]


def estimated(run: Run, folder: Path) -> Row:
    """Return what identify ended with: exit code, errors, verdict, model and method.

    The error of the simulation is that of the longest horizon, which is 1 s.
    """
    file = folder / "estimate.json"
    if not file.exists():
        said = run.text.strip().splitlines()[-1:]
        about = {"model": "refused", "headline": "".join(said)}
        return about | {"exit": run.code, "error": None, "simulation": None}
    estimate = json.loads(file.read_text("utf-8"))
    moving = estimate.get("torque_residual_in_motion")
    horizons = estimate["uses"]["simulation"]["horizons"]
    return {
        "exit": run.code,
        "simulation": horizons[-1]["position_error"] if horizons else None,
        "error": (moving or estimate["torque_residual"]["validation"])["relative"],
        "verdict": estimate["verdict"],
        "model": f"{estimate['model']} {estimate['method']}",
        "headline": estimate["headline"].split(" | ")[0],
    }


def wald(names: Sequence[str], folder: Path) -> float | None:
    """Return how far coefficients are from zero together in an estimate, in deviations of one."""
    file = folder / "estimate.json"
    if not names or not file.exists():
        return None
    estimate = json.loads(file.read_text("utf-8"))
    parameters = {p["name"]: k for k, p in enumerate(estimate["parameters"])}
    if not parameters.keys() >= set(names):
        return None
    at = [parameters[name] for name in names]
    X = np.array([estimate["parameters"][k]["value"] for k in at])
    std = np.array([estimate["parameters"][k]["std"] for k in at], dtype=float)
    correlation = np.array(estimate["correlation"], dtype=float).reshape(len(parameters), -1)
    covariance = correlation[np.ix_(at, at)] * np.outer(std, std)
    if not np.isfinite(covariance).all():
        return None
    statistic = float(X @ np.linalg.pinv(covariance) @ X)
    probability = chi2.sf(statistic, len(at))
    return float(norm.isf(max(probability, SMALLEST) / 2))


def adopted(effect: Row, folder: Path) -> Row:
    """Return an adopted effect with its coefficients; those of constants are not tested."""
    known = {
        p["name"]: (p["value"], p["std"])
        for p in effect["parameters"]
        if p["name"][:1].isupper() and p["std"]
    }
    distances = [abs(value) / std for value, std in known.values()]
    return {
        "name": effect["name"],
        "joints": effect["joints"],
        "parameters": {p["name"]: (p["value"], p["std"]) for p in effect["parameters"]},
        "probability": effect["probability"],
        "closes": effect["gap_reduction"],
        "largest": max(distances, default=None),
        "wald": wald(list(known), folder) if effect["in_robot_toml"] else None,
    }


def label(effect: Row) -> str:
    """Return the name of an effect and its joints."""
    return f"{effect['name']} {','.join(map(str, effect['joints'])) or 'all'}"


def attempt(rig: Path, part: str, folder: Path, twice: bool) -> Row:
    """Run the three commands of a case."""
    words = prepare(rig, part, folder)
    row: Row = {"rig": rig.name, "part": part}
    if not words:
        return {}
    declared = symgen(["identify", *words, "--into", "declared"], folder)
    why = symgen(["diagnose", *words, "--into", "why"], folder)
    if twice:
        why = symgen(["diagnose", *words, "--into", "why"], folder)
    row |= {"declared": estimated(declared, folder / "declared"), "seconds": why.seconds}
    row["exit"] = why.code
    file = folder / "why" / "diagnosis.json"
    if not file.exists():
        return row | {"verdict": "refused", "line": "", "next": row["declared"], "effects": []}
    diagnosis = json.loads(file.read_text("utf-8"))
    gap = diagnosis["gap"].get("in_motion") or diagnosis["gap"]
    printed = re.search(r"^next: symgen (identify .*)$", why.text, re.MULTILINE)
    line = shlex.split(printed[1]) if printed else []
    if line and "--into" not in line:
        line += ["--into", "why-better"]
    into = folder / line[line.index("--into") + 1] if line else folder / "declared"
    then = estimated(symgen(line, folder), into) if line else row["declared"]
    named = diagnosis["effects"]
    row |= {
        "verdict": diagnosis["verdict"],
        "before": gap["before"]["total"],
        "promised": gap["after"]["total"],
        "with_log_effects": (diagnosis["gap"].get("after_with_log_effects") or {}).get("total"),
        "floor": gap["noise_floor"]["total"],
        "line": shlex.join(line),
        "next": then,
        "effects": [adopted(e, into) for e in named if e["adopted"]],
        "suspected": [label(e) for e in named if not e["adopted"]],
        "repairs": diagnosis.get("repairs", []),
    }
    return row


def percent(share: float | None) -> str:
    """Return a share in percent, with three digits."""
    return "-" if share is None else f"{100 * share:.3g}"


def described(effect: Row) -> str:
    """Return an adopted effect with its values, and its distance from zero in deviations."""
    values = ", ".join(
        f"{name} {value:.3g}" + (f" ± {std:.2g}" if std else "")
        for name, (value, std) in effect["parameters"].items()
    )
    far = effect["wald"] if effect["wald"] is not None else effect["largest"]
    return f"{label(effect)}: {values}" + ("" if far is None else f" [{far:.1f}]")


def ratio(a: float | None, b: float | None) -> float:
    """Return a / b; NaN where one is unknown."""
    return a / b if a is not None and b else math.nan


HEADER = (
    "case | before | identify | promised | delivered | ratio | simulation: identify, next | "
    "exit: diagnose, next, identify | verdict | adopted: values [deviations from zero] | "
    "suspected | s"
)


def line_of(row: Row) -> str:
    """Return the row of the table."""
    codes = f"{row['exit']}, {row['next']['exit'] if row['line'] else '-'}"
    kept = ratio(row["next"]["error"], row.get("promised"))
    simulated = percent(row["next"]["simulation"]) if row["line"] else "-"
    cells = [
        f"{row['rig']} {row['part']}",
        percent(row.get("before")),
        f"{percent(row['declared']['error'])} {row['declared']['model']}",
        percent(row.get("promised")),
        f"{percent(row['next']['error'])} {row['next']['model']}" if row["line"] else "no line",
        f"{kept:.3f}",
        f"{percent(row['declared']['simulation'])}, {simulated}",
        f"{codes}, {row['declared']['exit']}",
        row["verdict"],
        "; ".join(map(described, row["effects"])),
        ", ".join(row.get("suspected", ())),
        f"{row['seconds']:.1f}",
    ]
    return f"| {' | '.join(cells)} |"


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """Return the counts that the goals ask for, each with its cases."""

    def count(what: str, chosen: Sequence[Row], of: Sequence[Row] = rows) -> str:
        names = ", ".join(f"{row['rig']} {row['part']}" for row in chosen)
        return f"- {what}: {len(chosen)} of {len(of)}" + (f" ({names})" if names else "")

    judged = [row for row in rows if row["verdict"] != "refused"]
    kept = [(row, ratio(row["next"]["error"], row["promised"])) for row in judged]
    yield count("delivered as promised to 0.1 %", [r for r, x in kept if abs(x - 1) <= DIGITS])
    yield count(f"delivered within {NEAR}", [r for r, x in kept if x <= NEAR])
    lines = [row for row in judged if row["line"]]
    for name, error in (("before", "before"), ("identify of the declared robot", "declared")):
        base = [(row, row[error]["error"] if error == "declared" else row[error]) for row in lines]
        worse = [r for r, x in base if not ratio(r["next"]["error"], x) <= 1 + DIGITS]
        yield count(f"the printed line is worse than {name}", worse, lines)
    both = [(r, r["next"]["simulation"], r["declared"]["simulation"]) for r in lines]
    rougher = [r for r, then, now in both if now is not None and not ratio(then, now) <= ROUGHER]
    yield count(f"its simulation after 1 s is {ROUGHER} times as far off", rougher, lines)
    same = [r for r in judged if abs(ratio(r["declared"]["error"], r["before"]) - 1) <= DIGITS]
    yield count("before is the number of identify to 0.1 %", same, judged)
    bad = [row for row in judged if row["verdict"] == "bad-measurement"]
    little = [r for r in bad if ratio(r["promised"], r["before"]) > 1 - CLOSES]
    yield count("bad-measurement that closes less than a tenth", little, bad)
    contradict = [row for row in judged if (row["exit"] == 0) != (row["next"]["exit"] == 0)]
    yield count("exit codes that contradict", contradict, judged)
    yield count("refused", [row for row in rows if row["verdict"] == "refused"])
    effects = [(row, e) for row in judged for e in row["effects"]]
    for key, what in (("largest", "each coefficient"), ("wald", "all coefficients together")):
        known = [(row, e) for row, e in effects if e[key] is not None]
        near = [f"{r['rig']} {r['part']}: {label(e)}" for r, e in known if e[key] < DEVIATIONS]
        text = f"- adopted with {what} within {DEVIATIONS:g} deviations of zero"
        yield f"{text}: {len(near)} of {len(known)}" + (f" ({'; '.join(near)})" if near else "")
    suspected = sum(len(row.get("suspected", ())) for row in judged)
    yield f"- effects: {len(effects)} adopted, {suspected} suspected"
    yield f"- processor time of diagnose, s: {sum(row['seconds'] for row in rows):.0f}"


def write(rows: Sequence[Row], out: Path) -> None:
    """Write the figures and their tables."""
    out.with_suffix(".json").write_text(json.dumps(rows, indent=1), "utf-8")
    head = [f"| {HEADER} |", "|" + "---|" * (HEADER.count("|") + 1)]
    text = "\n".join([*head, *map(line_of, rows), "", *summary(rows), ""])
    out.with_suffix(".md").write_text(text, "utf-8")


def main() -> None:
    """Run the cases in one process, whole logs first, and write after each."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="*", type=Path, help="further rigs")
    parser.add_argument("--only", nargs="*", help="names of the rigs to run")
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=PARTS)
    parser.add_argument("--twice", action="store_true", help="time diagnose with compiled models")
    parser.add_argument("--more", action="store_true", help="keep the cases of OUT.json")
    parser.add_argument("--keep", type=Path, help="folder for the logs and results of the cases")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    os.nice(10)
    rigs = [folder.resolve() for folder in (*sorted(data_folder().iterdir()), *options.folders)]
    rigs = [r for r in rigs if (r / "robot.toml").exists() and r.name in (options.only or [r.name])]
    file = options.out.with_suffix(".json")
    rows = json.loads(file.read_text("utf-8")) if options.more and file.exists() else []
    done = {(row["rig"], row["part"]) for row in rows}
    for part in options.parts:
        for rig in rigs:
            if (rig.name, part) in done:
                continue
            with tempfile.TemporaryDirectory() as scratch:
                folder = (options.keep or Path(scratch)) / f"{rig.name}-{part}"
                shutil.rmtree(folder, ignore_errors=True)  # no result of an earlier run is read
                folder.mkdir(parents=True)
                row = attempt(rig, part, folder, options.twice)
            if row:
                rows.append(row)
                write(rows, options.out)
                print(line_of(row), flush=True)
    print("\n".join(summary(rows)))


if __name__ == "__main__":
    main()
