"""Real logs whose robot file lacks a term that it had: what `diagnose` names in its place.

    python tests/studies/taken_out_study.py emps ur10e --out FILE

Each declared friction term, offset and rotor inertia of a robot of data/ is taken out, one at a
time. A term counts where its joint's held-out torque error grows at least GROWTH times. It is
found where the first effect that is named is the term on its joint, and answered where what is
named leaves no more of the joint's torque than the file's own model does. Effects of other joints
that come before it are counted apart: `first_of_its_joint`.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from figures import keep
from support import data_folder

import symgen

ROBOTS = ("emps", "dp_c0", "ur10", "ur10e", "tx40", "kr300")
GROWTH = 1.3
NAMES = {
    "coulomb": "coulomb_friction",
    "viscous": "viscous_friction",
    "offset": "torque_offset",
    "rotor_inertia": "rotor_inertia",
}


def without(robot: symgen.Robot) -> Iterator[tuple[str, int, symgen.Robot]]:
    """Name of each declared term, its joint's place, and the robot that lacks it."""
    for j, joint in enumerate(robot.joints):
        for term in joint.friction:
            if term in NAMES:
                left = replace(joint, friction=tuple(f for f in joint.friction if f != term))
                yield term, j, _with(robot, j, left)
        if joint.rotor_inertia:
            yield "rotor_inertia", j, _with(robot, j, replace(joint, rotor_inertia=False))


def _with(robot: symgen.Robot, j: int, joint: object) -> symgen.Robot:
    return replace(robot, joints=(*robot.joints[:j], joint, *robot.joints[j + 1 :]))


def attempt(name: str) -> Iterator[dict[str, Any]]:
    """One row for each term of one robot."""
    folder = data_folder() / name
    robot = symgen.read_robot(folder / "robot.toml")
    logs = sorted(p for p in folder.iterdir() if p.stem.startswith("train"))
    held = [next(p for p in folder.iterdir() if p.stem == "test")]
    whole = symgen.diagnose(robot, logs, validation=held, effects=[]).before.per_joint
    for term, j, lacking in without(robot):
        row: dict[str, Any] = {"robot": name, "term": term, "joint": j + 1, "declared": whole[j]}
        bare = symgen.diagnose(lacking, logs, validation=held, effects=[]).before.per_joint[j]
        row["lacking"] = bare
        if bare >= GROWTH * whole[j]:
            answer = symgen.diagnose(lacking, logs, validation=held)
            first = answer.effects[0] if answer.effects else None
            row |= {
                "named": [(e.name, e.joints, round(e.probability, 3)) for e in answer.effects],
                "verdict": answer.verdict,
                "after": answer.after.per_joint[j],
                "found": first is not None
                and (first.name, first.joints) == (NAMES[term], (j + 1,)),
                "answered": answer.after.per_joint[j] <= whole[j],
            }
        yield row


def first_of_its_joint(row: dict[str, Any]) -> bool:
    """Whether the term is the first of the effects that are named on its joint."""
    own = (name for name, joints, _ in row["named"] if row["joint"] in joints)
    return next(own, None) == NAMES[row["term"]]


def main() -> int:
    """Run, print, write and count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--out", type=Path, help="a JSON file of rows")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = []
    for name in options.robots:
        for row in attempt(name):
            rows.append(row)
            print(json.dumps(row), flush=True)
    counted = [r for r in rows if "named" in r]
    right = sum(bool(r["found"] or r["answered"]) for r in counted)
    first = sum(bool(r["found"]) for r in counted)
    print(f"{len(rows)} terms, {len(counted)} matter: {first} named first, {right} right in all")
    print(f"{sum(map(first_of_its_joint, counted))} are the first of their joint")
    if options.out:
        keep(options.out, {"growth": GROWTH, "cases": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
