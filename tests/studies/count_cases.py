"""Cases with a known truth: what `diagnose` names of it, and what else.

    python tests/studies/count_cases.py CASES [CASES ...] --out cases

Each folder with truth.json below CASES is a case: robot.toml, train.npz and validation.npz. Its
truth is pairs of name and joints (no joints: any), `any_of` (one of them is enough), and `allow`
(names that may be adopted beside it). A case is right if every name of its truth is adopted, or is
one that the data cannot distinguish from an adopted one, or is a delay or a fault of speeds under
`repairs`. The truth "unnamed" is right where it is adopted, or where the verdict says that no name
explains the error. Everything else that is adopted is false. Where something is not found, the case
is wrong if something false is adopted, else it misses it. OUT.json has what was named, OUT.md the
tables; `--more` judges what OUT.json has, and runs the rest.
"""

from __future__ import annotations

import argparse
import json
import os
import time
import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import symgen

Row = dict[str, Any]
#: A name with a set of joints; no joints stand for any.
Place = tuple[str, frozenset[int]]
NAMELESS = "unnamed"
#: Today's names of what a truth calls otherwise.
RENAMED = {
    "link_length_error": "geometry_error",
    "tachometer_gain_error": "velocity_sensor_error",
}
#: What OUT.json keeps of a diagnosis.
KEPT = ("verdict", "gap", "effects", "repairs")
#: Verdicts that say that no known effect explains the error.
OPEN = ("unexplained", "partly-explained")


def label(name: str, joints: Iterable[int]) -> str:
    """Return the name of an effect and its joints."""
    return f"{name} {','.join(map(str, sorted(joints))) or 'all'}"


def places(effect: Row) -> list[Place]:
    """Return an effect, and those that the data cannot distinguish from it."""
    alike = [effect, *effect["indistinguishable_from"]]
    return [(e["name"], frozenset(e["joints"])) for e in alike]


def meets(place: Place, truth: Place) -> bool:
    """Whether an effect is that of the truth, or its part on some of the joints."""
    name, joints = place
    return name == truth[0] and (not truth[1] or (bool(joints) and joints <= truth[1]))


def repaired(repair: Row) -> tuple[str, str]:
    """Return the effect that a repair undoes, "" for others, and its channel."""
    kind = str(repair.get("name") or repair.get("kind") or "")
    if "delay" in kind or any(name.startswith("DT") for name, *_ in repair.get("values", ())):
        return "time_delay", ""
    if kind in ("speed", "velocity_sensor_error"):
        return "velocity_sensor_error", str(repair.get("channel", ""))
    return "", ""


def is_repaired(truth: Place, repairs: Sequence[Row]) -> bool:
    """Whether a repair undoes the truth, of all channels or of those of its joints."""
    name, joints = truth
    channels = [channel for undone, channel in map(repaired, repairs) if undone == name]
    return any(
        channel in ("", "qd") or all(f"qd{j}" in channel.split(", ") for j in joints)
        for channel in channels
    )


def is_adopted(truth: Place, met: Sequence[Place]) -> bool:
    """Whether the truth is adopted, on all its joints."""
    covered = [place[1] for place in met if meets(place, truth)]
    return bool(covered) and truth[1] <= frozenset().union(*covered)


def judge(truth: Row, diagnosis: Row) -> Row:
    """Compare a diagnosis with the truth of its case."""
    wanted = [(RENAMED.get(name, name), frozenset(joints)) for name, joints in truth["truth"]]
    repairs, is_open = diagnosis.get("repairs", ()), diagnosis["verdict"] in OPEN
    adopted = [e for e in diagnosis["effects"] if e["adopted"]]
    suspected = [e for e in diagnosis["effects"] if not e["adopted"]]

    def is_true(effect: Row) -> bool:
        known = places(effect)
        return any(meets(place, one) for place in known for one in wanted)

    met = [place for e in adopted for place in places(e)]
    undone = [one for one in wanted if is_repaired(one, repairs)]
    left = [one for one in wanted if one not in undone and not is_adopted(one, met)]
    missing = [one for one in left if not (one[0] == NAMELESS and is_open)]
    if truth["any_of"] and len(missing) < len(wanted):
        missing = []
    false = [e for e in adopted if not is_true(e) and e["name"] not in truth["allow"]]
    found = not missing and (wanted or not false)
    return {
        "truth": [label(name, joints) for name, joints in wanted],
        "result": "right" if found else "wrong" if false else "missing",
        "missing": [label(name, joints) for name, joints in missing],
        "false": [label(e["name"], e["joints"]) for e in false],
        "adopted": [label(e["name"], e["joints"]) for e in adopted],
        "suspected": [label(e["name"], e["joints"]) for e in suspected],
        "suspected_false": sum(not is_true(e) for e in suspected),
        "repaired": [label(name, joints) for name, joints in undone],
    }


def attempt(folder: Path) -> Row:
    """Diagnose a case."""
    train, held = folder / "train.npz", folder / "validation.npz"
    row: Row = {"case": f"{folder.parent.name}/{folder.name}"}
    row["given"] = json.loads((folder / "truth.json").read_text("utf-8"))
    begin = time.process_time()
    try:
        found = symgen.diagnose(folder / "robot.toml", [train], validation=[held])
    except symgen.SymgenError as error:
        return row | {"refused": str(error)}
    row["seconds"] = time.process_time() - begin
    row["diagnosis"] = {key: found.to_json().get(key, ()) for key in KEPT}
    return row


def judged(row: Row) -> Row:
    """Return a row with its result."""
    if "refused" in row:
        return row | {"result": "refused", "truth": [], "verdict": row["refused"]}
    diagnosis = row["diagnosis"]
    gap = diagnosis["gap"]["in_motion"]
    errors = [gap["before"]["total"], gap["after"]["total"]]
    about = {"verdict": diagnosis["verdict"], "errors": errors}
    return row | about | judge(row["given"], diagnosis)


HEADER = (
    "case | truth | result | verdict | before, after | adopted | repaired | false | missing | "
    "suspected"
)


def line_of(row: Row) -> str:
    """Return the row of the table."""
    errors = ", ".join(f"{100 * error:.3g}" for error in row.get("errors", ()))
    lists = ("adopted", "repaired", "false", "missing", "suspected")
    names = [", ".join(row.get(key, ())) for key in lists]
    begin = [f"{row['case']} {row['given']['robot']}", ", ".join(row["truth"]), row["result"]]
    return f"| {' | '.join([*begin, row['verdict'], errors, *names])} |"


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """Return the totals."""
    for result in ("right", "wrong", "missing", "refused"):
        cases = [row["case"] for row in rows if row["result"] == result]
        names = "" if result == "right" or not cases else f" ({', '.join(cases)})"
        yield f"- {result}: {len(cases)} of {len(rows)}{names}"
    false = [f"{row['case']}: {name}" for row in rows for name in row.get("false", ())]
    yield f"- adopted false: {len(false)}" + (f" ({'; '.join(false)})" if false else "")
    suspected = sum(len(row.get("suspected", ())) for row in rows)
    others = sum(row.get("suspected_false", 0) for row in rows)
    yield f"- suspected: {suspected}, of which not in the truth: {others}"
    undone = [row["case"] for row in rows if row.get("repaired")]
    yield f"- with a truth under repairs: {len(undone)}" + (
        f" ({', '.join(undone)})" if undone else ""
    )
    clean = [row for row in rows if not row["given"]["truth"]]
    accused = [row["case"] for row in clean if row.get("adopted") or row.get("suspected")]
    yield f"- something adopted or suspected without an effect: {len(accused)} of {len(clean)}"
    yield f"- processor time, s: {sum(row.get('seconds', 0) for row in rows):.0f}"


def write(rows: Sequence[Row], out: Path) -> None:
    """Write what was named, and the tables."""
    out.with_suffix(".json").write_text(json.dumps(rows, indent=1), "utf-8")
    head = [f"| {HEADER} |", "|" + "---|" * (HEADER.count("|") + 1)]
    results = [judged(row) for row in rows]
    text = "\n".join([*head, *map(line_of, results), "", *summary(results), ""])
    out.with_suffix(".md").write_text(text, "utf-8")


def main() -> None:
    """Diagnose the cases in one process, and write after each."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path, help="folders of cases")
    parser.add_argument("--only", nargs="*", help="names of the cases to run")
    parser.add_argument("--more", action="store_true", help="keep the cases of OUT.json")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    os.nice(10)
    warnings.simplefilter("ignore")
    file = options.out.with_suffix(".json")
    rows = json.loads(file.read_text("utf-8")) if options.more and file.exists() else []
    done = {row["case"] for row in rows}
    found = {p.parent.resolve() for folder in options.folders for p in folder.rglob("truth.json")}
    for folder in sorted(found):
        chosen = not options.only or folder.name in options.only
        if not chosen or f"{folder.parent.name}/{folder.name}" in done:
            continue
        rows.append(attempt(folder))
        write(rows, options.out)
        print(line_of(judged(rows[-1])), flush=True)
    write(rows, options.out)
    print("\n".join(summary([judged(row) for row in rows])))


if __name__ == "__main__":
    main()
