"""What identify's verdict says of logs and robot files that are spoiled.

    python tests/studies/spoiled_study.py ur10e arm5r-3 --seed 1 [--kinds one_zero] [--out F]

Robots are folders of the shared data, or simulated arms of oracles/clean_runs.py with the number of
the run. Every kind of studies/spoiled.py is drawn at random. Harm is the torque error on the clean
validation motion of what identify makes of the spoiled case, over that of the clean one. A kind is
seeable where a fit of an engineer (oracles/engineer.py) to the spoiled case leaves more of its
validation torque than his fit to the clean one, by 0.8 % of a joint's torque in squares. Counted
are cases that cost more than 1.2 times and are called good for prediction, reasons that name what
was done, and reasons that name something else.
"""

from __future__ import annotations

import argparse
import itertools
import json
import re
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from figures import keep
from oracles import clean_runs, engineer
from oracles.faults import Log
from oracles.transforms import Arm, world_transforms
from studies import spoiled
from studies.spoiled import Case
from support import data_folder

LEAST, HARM = 0.008, 1.2
#: What the figure file keeps of a row.
KEPT = ("robot", "kind", "seed", "joints", "verdict", "error", "seeable", "harm", "named", "wrong")
KERNELS = ("torque_regressor",)
#: What a reason has to speak of for a kind; {j} stands for one of its joints.
RIGHT = {
    "gravity_down": "gravity", "gravity_sideways": "gravity", "gravity_tilted": "gravity",
    "one_zero": "zero of joint {j}|zeros? of joints?.*{j}", "three_zeros": "zeros? of joints?.*{j}",
    "zero_slips": "joint {j}|q{j}", "tool_in_a_part": "load|mass", "tool_in_training": "load|mass",
    "collision": "touched|collision", "leans": "touched|collision|joint {j}",
    "brake_drags": "friction of joint {j}", "friction_fades": "friction of joint {j}",
    "torque_drifts": r"(drift|creep) on .*{j}\b", "gain_drifts": r"drift on .*{j}\b|tau{j} is",
    "slow_torques": "late|filter", "slow_torque": "tau{j}.*(late|filter)",
    "gravity_compensated": "weight|gravity", "commanded": "command", "fed_forward": "command",
    "two_gains": "tau{j}", "two_signs": "tau{j}", "loud": "tau{j}", "constant": "tau{j}",
    "clock_runs_fast": r"\bt\b|stamps|clock", "leak": "holds the same data",
    "resampled_leak": "holds the same data", "friction_taken_off": "friction",
    "sensor_creeps": r"(drift|creep) on .*{j}\b",
    "sensor_creeps_with_load": r"(drift|creep) on .*{j}\b", "crosstalk": r"crosstalk on .*{j}\b",
    "two_millinewton_metres": r"tau{j}\b",
    "another_robot": "another robot",
    "swapped": r"(q|qd|tau){j}\b", "turned": r"(q|qd|tau){j}\b|joint {j}", "degrees": r"q{j}\b",
    "milliseconds": r"qd{j}|\bt\b", "newton_millimetres": r"tau{j}\b", "torque_gain": r"tau{j}\b",
    "gear_ratio": "ratio of joint {j}", "torque_delay": "late|tau{j}", "clipped": r"tau{j}\b|mask",
    "stuck": r"(q|tau){j}\b", "wrapped": r"q{j}\b", "repeated_rows_moved": r"\bt\b|rows|samples",
    "held": "held|new values|late", "coarse": r"(q|tau){j}\b", "spikes": r"(q|tau){j}\b",
    "time_reversed": "time|backwards", "speeds_scaled": "qd|speed", "speeds_delayed": "qd|speed",
}  # fmt: skip
#: Kinds that fit as well as the clean case.
UNSEEN = ("leak", "resampled_leak", "fed_forward", "friction_taken_off")
#: Kinds of reasons that name no cause.
OPEN = ("error", "joint_error", "varies", "noise", "not_excited")


@cache
def kernel(robot: str) -> Any:
    """torque_regressor of a robot file's text, with its number of inertial columns."""
    import symgen

    model = symgen.derive(symgen.parse_robot(robot, "case"), KERNELS)
    return symgen.load(model)["torque_regressor"], model.inertial


def clean_case(name: str) -> Case:
    """A robot and its logs as they are."""
    if "-" in name:
        arm, number = name.split("-")
        run = clean_runs.run(int(number), arms=(arm,), effects=False)
        text, train, held = run.robot_toml, run.train, run.validation
    else:
        folder = data_folder() / name
        ends = ".npz" if (folder / "train.npz").exists() else ".csv"
        text = (folder / "robot.toml").read_text("utf-8")
        train, held = (
            _thinned(Log(*engineer.channels(folder / f"{log}{ends}"))) for log in ("train", "test")
        )
    regressor, inertial = kernel(text)
    X, _ = engineer.analyst(regressor, [engineer.even(*_channels(train))], _comparison(train))

    def weight(q: np.ndarray) -> np.ndarray:
        q, zero = np.ascontiguousarray(q), np.zeros_like(q)
        return np.asarray(regressor(q, zero, zero)[:, :, :inertial] @ X[:inertial])

    table = tomllib.loads(text)
    joints = table["joint"]
    keys = ("sigma", "alpha", "d", "theta", "r", "gamma", "b")
    columns = {k: [float(j.get(k, 0.0)) for j in joints] for k in keys}
    columns["ant"] = [int(j.get("ant", k)) for k, j in enumerate(joints)]
    arm = Arm.from_table({**columns, "gravity": table["robot"]["gravity"]})

    def load(t: np.ndarray, q: np.ndarray, point: np.ndarray) -> np.ndarray:
        """J'(a - g) of a kilogram; accelerations from positions below 10 Hz."""
        q = engineer.lowpass(q, 1 / float(np.median(np.diff(t))), 10.0)

        def place(q: np.ndarray) -> np.ndarray:
            return np.asarray((world_transforms(arm, q)[:, -1] @ np.append(point, 1.0))[:, :3])

        a = np.gradient(np.gradient(place(q), t, axis=0), t, axis=0)
        force = a - np.array(arm.gravity, dtype=float)
        step = 1e-5 * np.eye(q.shape[1])
        J = np.stack([(place(q + h) - place(q - h)) / 2e-5 for h in step], axis=-1)
        return np.einsum("kcj,kc->kj", J, force)

    def rigid(log: Log, rng: np.random.Generator) -> np.ndarray:
        """Parameters within 10 %, along the motion below 10 Hz, which the robot follows by 5 ms."""
        own = X[:inertial] * rng.uniform(0.9, 1.1, inertial)
        t, lead = np.linspace(log.t[0], log.t[-1], len(log.t)), rng.uniform(0, 0.005)
        rate = 1 / (t[1] - t[0])
        q = engineer.lowpass(np.column_stack([np.interp(t, log.t, c) for c in log.q.T]), rate, 10.0)
        qd = engineer.derivative(q, rate)
        motion = (np.ascontiguousarray(x) for x in (q, qd, engineer.derivative(qd, rate)))
        torque = np.asarray(regressor(*motion)[:, :, :inertial] @ own)
        return np.asarray(CubicSpline(t, torque)(log.t + lead))

    def friction(log: Log) -> np.ndarray:
        q, qd = (np.ascontiguousarray(x) for x in (log.q, spoiled.speed(log)))
        return np.asarray(regressor(q, qd, 0 * q)[:, :, inertial:] @ X[inertial:])

    return Case(text, train, held, weight, load, rigid, friction)


def _thinned(log: Log) -> Log:
    """Logs of many samples at a part of their rate: what is asked here is in the motion."""
    every = max(1, len(log.t) // 20_000)
    return log.rows(np.arange(0, len(log.t), every))


def _channels(log: Log) -> tuple[Any, ...]:
    return log.t, log.q, log.qd, log.tau


def _comparison(log: Log) -> float:
    return engineer.comparison_band([engineer.even(*_channels(log))])


def _squares(robot: str, train: Log, held: Log) -> np.ndarray:
    """Squared error of an engineer's fit on the validation log, of each joint's torque."""
    regressor, _ = kernel(robot)
    comparison = _comparison(train)
    X, cutoff = engineer.analyst(regressor, [engineer.even(*_channels(train))], comparison)
    W, y = engineer.equations(regressor, engineer.even(*_channels(held)), cutoff, comparison)
    return np.asarray(np.sum((y - W @ X) ** 2, axis=0) / np.sum(y**2, axis=0))


def _clean_error(estimate: Any, robot: str, case: Case) -> float:
    """Torque error of an estimate on the clean validation motion."""
    X = np.array([p.value for p in estimate.parameters])
    cutoff, comparison = estimate.band.cutoff_hz, _comparison(case.train)
    even = engineer.even(*_channels(case.held))
    W, y = engineer.equations(kernel(robot)[0], even, min(cutoff, 30.0), comparison)
    return float(np.linalg.norm(y - W @ X) / np.linalg.norm(y))


def identify(case: Case) -> Any:
    """The estimate that a user gets, or the refusal."""
    import symgen

    with tempfile.TemporaryDirectory() as folder:
        robot = Path(folder) / "robot.toml"
        robot.write_text(case.robot, "utf-8")
        train = case.train.save(Path(folder) / "train.npz")
        held = case.held.save(Path(folder) / "held.npz")
        try:
            return symgen.identify(robot, [train], validation=[held])
        except symgen.SymgenError as error:
            return error


_CLEAN: dict[str, tuple[Case, np.ndarray, Any]] = {}


def attempt(name: str, kind: str, seed: int) -> dict[str, Any]:
    """One spoiled case, or a clean one for the kind "clean"."""
    if name not in _CLEAN:
        case = clean_case(name)
        _CLEAN[name] = case, _squares(case.robot, case.train, case.held), identify(case)
    case, left, estimate = _CLEAN[name]
    row: dict[str, Any] = {"robot": name, "kind": kind, "seed": seed}
    if kind == "clean":
        return row | _said(estimate, "", ())
    try:
        bad, joints = spoiled.KINDS[kind](case, np.random.default_rng([seed, len(name)]))
    except (ValueError, TypeError, AttributeError):
        return {}  # it needs two joints, or measured speeds
    begin = time.perf_counter()
    found = identify(bad)
    row["seconds"] = round(time.perf_counter() - begin, 1)
    try:
        more = _squares(bad.robot, bad.train, bad.held) - left
        row["seeable"] = bool((more > LEAST**2).any()) or kind in UNSEEN
    except (ValueError, np.linalg.LinAlgError):
        row["seeable"] = True
    row |= _said(found, RIGHT[kind], joints)
    row["harm"] = harm_of(found, estimate, bad, case)
    return row


def harm_of(found: Any, estimate: Any, bad: Case, case: Case) -> float:
    """Harm, 0 of a refusal."""
    if isinstance(found, Exception) or isinstance(estimate, Exception):
        return 0.0
    return _clean_error(found, bad.robot, case) / _clean_error(estimate, case.robot, case)


def _said(found: Any, right: str, joints: tuple[int, ...]) -> dict[str, Any]:
    """The verdict with its reasons, and whether they are right or wrong."""
    if isinstance(found, Exception):
        reasons, verdict, repairs, error = [str(found)], "refused", [], 0.0
        causes = reasons
    else:
        content = found.to_json()
        reasons, verdict = [r.text for r in found.reasons], content["verdict"]
        causes = [r.text for r in found.reasons if r.kind not in OPEN]
        repairs = [f"{r['channel']} {r['fault']}" for r in content["repairs"]]
        error = content["torque_residual"]["validation"]["relative"]
    pattern = "|".join(right.replace("{j}", str(j + 1)) for j in joints or (0,)) or "^$"
    named = any(re.search(pattern, r) for r in causes + (repairs if right else []))
    wrong = bool(causes) and not any(re.search(pattern, r) for r in causes)
    return {
        "joints": [j + 1 for j in joints],
        "verdict": verdict,
        "error": round(error, 4),
        "named": named,
        "wrong": wrong,
        "says": "; ".join(reasons)[:300],
        "repairs": "; ".join(repairs)[:200],
    }


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The counts."""
    clean = [r for r in rows if r["kind"] == "clean"]
    bad = [r for r in rows if r["kind"] != "clean"]
    seen = [r for r in bad if r["seeable"]]
    costly = [r for r in seen if r["harm"] > HARM]
    return {
        "spoiled": len(bad),
        "seeable": len(seen),
        "costly": len(costly),
        "costly_good": sum(r["verdict"] == "trusted" for r in costly),
        "costly_named": sum(r["named"] for r in costly),
        "wrong_reason": sum(r["wrong"] for r in bad),
        "clean": len(clean),
        "clean_good": sum(r["verdict"] == "trusted" for r in clean),
    }


def line(r: dict[str, Any]) -> str:
    """A case in one line."""
    marks = ["GOOD" if r["verdict"] == "trusted" else r["verdict"]]
    if r["kind"] != "clean":
        marks += [f"harm {r['harm']:.2f}", "" if r["seeable"] else "unseeable"]
    marks += ["NAMED" * r["named"], "WRONG REASON" * r["wrong"]]
    return (
        f"{r['robot']} {r['kind']} {r['joints']} {100 * r['error']:.2f} % "
        f"{' '.join(filter(None, marks))}: {r['says']} | {r['repairs']}"
    )


def _attempt(job: tuple[str, str, int]) -> dict[str, Any]:
    return attempt(*job)


def study(
    robots: Iterable[str], kinds: Iterable[str], seeds: Iterable[int], workers: int = 1
) -> list[dict[str, Any]]:
    """All kinds on all robots, printed as they come."""
    jobs = list(itertools.product(robots, kinds, seeds))
    rows = []
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for row in pool.map(_attempt, jobs) if workers > 1 else map(_attempt, jobs):
            if row:
                rows.append(row)
                print(line(row), flush=True)
    return rows


def main() -> int:
    """Run, print and count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("robots", nargs="*", default=["ur10"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--draws", type=int, default=1)
    parser.add_argument("--kinds", nargs="*", default=["clean", *spoiled.KINDS])
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, help="rows and counts, as JSON")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.draws)
    rows = study(options.robots, options.kinds, seeds, options.workers)
    print(json.dumps(summary(rows), indent=1))
    if options.out:
        kept = [{key: row[key] for key in KEPT if key in row} for row in rows]
        keep(options.out, {"summary": summary(rows), "rows": kept})
    return 0


if __name__ == "__main__":
    sys.exit(main())
