"""Diagnoses of the logs in which an effect is hidden, what is right about them, and their sums.

A row is one diagnosis, as it is written into diagnose_figures.json.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from oracles.hidden.cases import Case, Log, Spec

import symgen
from symgen.diagnosis.diagnosis import Gap
from symgen.diagnosis.workflow import diagnose

Row = dict[str, Any]


def whole_gap(per_joint: Sequence[float]) -> Gap:
    """Return a gap of joints of equal torque."""
    return Gap(tuple(per_joint), float(np.sqrt(np.mean(np.square(per_joint)))))


def run(spec: Spec, case: Case | None = None) -> Row:
    """Diagnose one case; seconds are those of the diagnosis, compilation included."""
    case = case or spec.run()
    robot = symgen.parse_robot(case.robot_toml)
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        given = None
        if case.given:  # shows only against the parameters of the robot before
            given = Path(folder) / "parameters.toml"
            lines = (f"{name} = {value!r}" for name, value in case.parameters.items())
            given.write_text("\n".join(["[parameters]", *lines]), "utf-8")
        answer = diagnose(
            robot,
            [log_of("train", case.train)],
            validation=[log_of("v", case.validation)],
            parameters=given,
        )
    found = [
        {
            "name": e.name,
            "joints": list(e.joints),
            "like": [[name, list(joints)] for name, joints in e.indistinguishable_from],
        }
        for e in answer.effects
    ]
    names = (spec.effect,) if isinstance(spec.effect, str) else spec.effect or ()
    return {
        "id": spec.id,
        "robot": spec.robot,
        "effect": "+".join(names) or "clean",
        "size": spec.size,
        "misfit": spec.misfit,
        "truth": [[name, list(joints)] for name, joints, _ in case.truth],
        "alternatives": [list(a) for a in case.alternatives],
        "visible": case.visible,
        "faults": list(case.faults),
        "found": found,
        "verdict": answer.verdict,
        "before": round(answer.before.total, 5),
        "after": round(answer.after.total, 5),
        "floor": round(answer.floor.total, 5),
        # What noise alone leaves, by the simulator's own account.
        "true_floor": round(float(np.sqrt(np.mean(np.square(case.floor)))), 5),
        "seconds": round(time.perf_counter() - begin, 1),
    }


def log_of(name: str, log: Log) -> symgen.Log:
    return symgen.Log(name, log["t"], log["q"], log["qd"], log["tau"])


def says(effect: Row, truth: Sequence[Any], alternatives: Sequence[str]) -> bool:
    """Whether a found effect is the true one, by name or by the class it says it belongs to."""
    name, joints = truth
    names = {name, *alternatives}
    classes = [(effect["name"], effect["joints"]), *map(tuple, effect["like"])]
    return any(n in names and (not joints or not j or set(j) == set(joints)) for n, j in classes)


#: What a fault of the instruments is named, where it closes a part of the gap.
CHAIN = {"late_speeds": "velocity_sensor_error"}


def right_first(row: Row) -> bool:
    """Whether the effects that come first are the true ones, in any order.

    Faults of the instruments that are there may stand before them.
    """
    chain = {CHAIN.get(fault) for fault in row.get("faults", ())}
    found = [e for e in row["found"] if e["name"] not in chain]
    first = found[: len(row["truth"])]
    true = list(zip(row["truth"], row["alternatives"], strict=True))
    return all(any(says(e, t, a) for e in first) for t, a in true)


def false_effects(row: Row) -> int:
    """Number of effects that are not there; parts of an effect on the whole arm are no others."""
    true = list(zip(row["truth"], row["alternatives"], strict=True))
    true += [((CHAIN[f], []), ()) for f in row.get("faults", ()) if f in CHAIN]
    return sum(not any(says(e, t, a) for t, a in true) for e in row["found"])


def summary(rows: Iterable[Row]) -> dict[str, Any]:
    """Return the sums by effect and size, and those of the clean controls."""
    rows = list(rows)
    clean = [r for r in rows if not r["truth"]]
    quiet = {
        robot: float(
            np.median([r["after"] for r in clean if r["robot"] == robot and not r["misfit"]])
        )
        for robot in sorted({r["robot"] for r in clean if not r["misfit"]})
    }
    hidden = [r for r in rows if r["truth"]]
    out: dict[str, Any] = {"clean": {}, "effects": {}}
    for key, some in (("as declared", [r for r in clean if not r["misfit"]]),
                      ("1 % misfit", [r for r in clean if r["misfit"]])):  # fmt: skip
        if some:
            out["clean"][key] = {
                "runs": len(some),
                "false_per_run": _mean(false_effects(r) for r in some),
                "consistent": _mean(r["verdict"] == "consistent" for r in some),
            }
    for key in sorted({(r["effect"], r["size"]) for r in hidden}):
        some = [r for r in hidden if (r["effect"], r["size"]) == key]
        right = [r for r in some if right_first(r)]
        out["effects"][" ".join(key)] = {
            "runs": len(some),
            "right_first": len(right),
            "false": sum(map(false_effects, some)),
            "after_over_floor": _median(r["after"] / r["floor"] for r in right),
            "after_over_true_floor": _median(r["after"] / r["true_floor"] for r in right),
            "after_over_clean": _median(
                r["after"] / quiet[r["robot"]] for r in right if r["robot"] in quiet
            ),
            "seconds": _mean(r["seconds"] for r in some),
        }
    for size in ("moderate", "small"):
        some = [r for r in hidden if r["size"] == size]
        if some:
            out[size] = {
                "runs": len(some),
                "right_first": _mean(map(right_first, some)),
                "false_per_run": _mean(map(false_effects, some)),
            }
    seen = [r for r in hidden if r["visible"]]
    for key, some in (("visible", seen), ("with faults", [r for r in seen if r["faults"]])):
        right = [r for r in some if right_first(r)]
        if some:
            out[key] = {
                "runs": len(some),
                "right_first": _mean(map(right_first, some)),
                "false": sum(map(false_effects, some)),
                "after_over_true_floor": _median(r["after"] / r["true_floor"] for r in right),
            }
    out["clean_gap"] = quiet
    return out


def _mean(values: Iterable[float]) -> float:
    return round(float(np.mean(list(values))), 3)


def _median(values: Iterable[float]) -> float | None:
    listed = list(values)
    return round(float(np.median(listed)), 2) if listed else None
