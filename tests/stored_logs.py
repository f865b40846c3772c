"""Logs of tests/logs, made by studies/make_logs.py, as arrays and as logs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import symgen

LOGS = Path(__file__).with_name("logs")
Channels = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Stored:
    """A robot file and what the logs hold; `parameters` are those of the robot before, or ""."""

    robot: symgen.Robot
    parameters: str
    train: Channels
    test: Channels


def stored(name: str) -> Stored:
    """Read a file of tests/logs; a case that is not kept is simulated."""
    path = LOGS / f"{name}.npz"
    if path.exists():
        kept = dict(np.load(path))
    else:
        from studies.make_logs import CASES

        kept = CASES[name]()
    logs = []
    for kind in ("train", "test"):
        log = {}
        for key in ("q", "qd", "qs", "tau"):
            if f"{kind}_{key}" in kept:
                counts = np.cumsum(np.cumsum(kept[f"{kind}_{key}"], axis=1), axis=1)
                log[key] = counts.T * float(kept[f"{kind}_{key}_step"])
        logs.append(log | {"t": np.arange(len(log["q"])) / float(kept["rate"])})
    return Stored(symgen.parse_robot(str(kept["robot"])), str(kept["parameters"]), *logs)


def made(name: str, log: Channels) -> symgen.Log:
    """Return arrays as a log."""
    return symgen.make_log(name, log["t"], log["q"], log["tau"], log.get("qd"), qs=log.get("qs"))


def save(name: str, folder: Path) -> list[str]:
    """Write the robot file and both logs of a case; return the arguments that name them."""
    (folder / "robot.toml").write_text(str(np.load(LOGS / f"{name}.npz")["robot"]), "utf-8")
    case = stored(name)
    for kind, log in (("train", case.train), ("test", case.test)):
        np.savez(folder / f"{kind}.npz", **log)
    return ["robot.toml", "train.npz", "--validation", "test.npz"]
