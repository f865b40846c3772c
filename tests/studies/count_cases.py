"""Cases with a known truth: what `diagnose` names of it, and what else.

    python tests/studies/count_cases.py CASES [CASES ...] --out cases

Each folder with truth.json below CASES is a case: robot.toml, train.npz and validation.npz. Its
truth is pairs of name and joints (no joints: any), `any_of` (one of them is enough), and `allow`
(names that may be adopted beside it). A case is right if every name of its truth is adopted, or is
one that the data cannot distinguish from an adopted one, or is a delay under `repairs`. The truth
"unnamed" is right where it is adopted, or where the verdict says that no name explains the error.
Everything else that is adopted is false. Where something is not found, the case is wrong if
something false is adopted, else it misses it. OUT.json has all figures, OUT.md the tables.
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


def is_delay(repair: Row) -> bool:
    """Whether a repair shifted the torques."""
    kind = str(repair.get("name") or repair.get("kind") or "")
    return "delay" in kind or any(name.startswith("DT") for name, *_ in repair.get("values", ()))


def is_met(truth: Place, met: Sequence[Place], diagnosis: Row) -> bool:
    """Whether the truth is found, on all its joints."""
    name, joints = truth
    if name == "time_delay" and any(map(is_delay, diagnosis.get("repairs", ()))):
        return True
    if name == NAMELESS and diagnosis["verdict"] in OPEN:
        return True
    covered = [place[1] for place in met if meets(place, truth)]
    return bool(covered) and joints <= frozenset().union(*covered)


def judge(truth: Row, diagnosis: Row) -> Row:
    """Compare a diagnosis with the truth of its case."""
    wanted = [(name, frozenset(joints)) for name, joints in truth["truth"]]
    adopted = [e for e in diagnosis["effects"] if e["adopted"]]
    suspected = [e for e in diagnosis["effects"] if not e["adopted"]]

    def is_true(effect: Row) -> bool:
        known = places(effect)
        return any(meets(place, one) for place in known for one in wanted)

    met = [place for e in adopted for place in places(e)]
    missing = [one for one in wanted if not is_met(one, met, diagnosis)]
    if truth["any_of"] and len(missing) < len(wanted):
        missing = []
    false = [e for e in adopted if not is_true(e) and e["name"] not in truth["allow"]]
    found = not missing and (wanted or not false)
    return {
        "result": "right" if found else "wrong" if false else "missing",
        "missing": [label(name, joints) for name, joints in missing],
        "false": [label(e["name"], e["joints"]) for e in false],
        "adopted": [label(e["name"], e["joints"]) for e in adopted],
        "suspected": [label(e["name"], e["joints"]) for e in suspected],
        "suspected_false": sum(not is_true(e) for e in suspected),
        "delay_repaired": any(map(is_delay, diagnosis.get("repairs", ()))),
    }


def attempt(folder: Path) -> Row:
    """Diagnose a case."""
    truth = json.loads((folder / "truth.json").read_text("utf-8"))
    train, held = folder / "train.npz", folder / "validation.npz"
    about = {"case": f"{folder.parent.name}/{folder.name}", "robot": truth["robot"]}
    about["truth"] = [label(name, joints) for name, joints in truth["truth"]]
    begin = time.process_time()
    try:
        found = symgen.diagnose(folder / "robot.toml", [train], validation=[held])
    except symgen.SymgenError as error:
        return about | {"result": "refused", "verdict": str(error)}
    diagnosis = found.to_json()
    gap = diagnosis["gap"]["in_motion"]
    about |= {"before": gap["before"]["total"], "after": gap["after"]["total"]}
    about |= {"verdict": diagnosis["verdict"], "seconds": time.process_time() - begin}
    return about | judge(truth, diagnosis)


HEADER = "case | truth | result | verdict | before, after | adopted | false | missing | suspected"


def line_of(row: Row) -> str:
    """Return the row of the table."""
    errors = [f"{100 * row[key]:.3g}" for key in ("before", "after") if key in row]
    names = [", ".join(row.get(key, ())) for key in ("adopted", "false", "missing", "suspected")]
    begin = [f"{row['case']} {row['robot']}", ", ".join(row["truth"]), row["result"]]
    return f"| {' | '.join([*begin, row['verdict'], ', '.join(errors), *names])} |"


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
    accused = [r["case"] for r in rows if not r["truth"] and (r["adopted"] or r["suspected"])]
    yield f"- cases without an effect that are accused: {len(accused)}"
    yield f"- processor time, s: {sum(row.get('seconds', 0) for row in rows):.0f}"


def write(rows: Sequence[Row], out: Path) -> None:
    """Write the figures and their tables."""
    out.with_suffix(".json").write_text(json.dumps(rows, indent=1), "utf-8")
    head = [f"| {HEADER} |", "|" + "---|" * (HEADER.count("|") + 1)]
    out.with_suffix(".md").write_text(
        "\n".join([*head, *map(line_of, rows), "", *summary(rows), ""]), "utf-8"
    )


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
        if f"{folder.parent.name}/{folder.name}" in done:
            continue
        if options.only and folder.name not in options.only:
            continue
        rows.append(attempt(folder))
        write(rows, options.out)
        print(line_of(rows[-1]), flush=True)
    print("\n".join(summary(rows)))


if __name__ == "__main__":
    main()
