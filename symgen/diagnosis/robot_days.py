"""An estimate for each robot and day of a data set."""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symgen.data.dataset import constant_column, identity
from symgen.data.raw import Reading
from symgen.diagnosis.drift import Course
from symgen.distributed import Workers, WorkFolder, digest, executor, finished
from symgen.errors import LogError, SymgenError, plain
from symgen.estimation.equation_model import NEEDED, EquationModel
from symgen.identification.out_of_core import loaded
from symgen.identification.workflow import identify
from symgen.robot.toml_io import parse_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import BESIDE, OrInf, OrNan, at

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Day:
    """The logs of a robot on a day."""

    robot: str
    day: str
    files: tuple[str, ...]


class Shift(NamedTuple):
    """By how much a parameter changed, or what it is, and its standard deviation."""

    name: str
    value: OrNan
    std: OrNan


@dataclass(frozen=True, eq=False)
class DayEstimate:
    """What was identified of a robot on a day.

    Attributes:
        robot, day: by name.
        torque: relative error of torque on held-out motion.
        verdict: "trusted" or "doubtful", or "failed: " and why.
        parameters: None where the logs do not determine them.
        covariance: (p, p) of them; None where it is not known, but for their std.
        files: the logs.
    """

    robot: str
    day: str
    torque: Annotated[OrInf, at("torque_residual")]
    verdict: str
    parameters: tuple[Shift, ...] | None
    covariance: Annotated[FloatArray | None, BESIDE] = None
    files: Annotated[tuple[str, ...], BESIDE] = ()


@dataclass(frozen=True)
class IdentifyDay:
    """What a worker does with a day."""

    robot: str
    model: str
    cutoff: float | None
    reading: Reading

    @property
    def _model(self) -> Evaluator | Robot:
        """The compiled model, once a process."""
        if self.model not in NEEDED:  # it is chosen anew every day
            return parse_robot(self.robot, "robot.toml")
        return loaded(self.robot, EquationModel(self.model, 0.0).all_kernels)

    def __call__(self, day: Day) -> bytes:
        """Identify the logs of a day."""
        told: dict[str, Any]
        try:
            found = identify(
                self._model, list(day.files), model=self.model, cutoff=self.cutoff,
                reading=self.reading,
            )  # fmt: skip
            torque = found.torque_validation
            told = {
                "X": found.X,
                "covariance": found.covariance,
                "torque": np.inf if torque is None else torque.relative,
                "verdict": found.verdict,
            }
        except SymgenError as error:
            told = {"torque": np.inf, "verdict": f"failed: {error}"}
        file = io.BytesIO()
        np.savez(file, **told)
        return file.getvalue()


def estimated(
    task: IdentifyDay,
    days: Sequence[Day],
    names: Sequence[str],
    workers: Workers | None,
    progress: Callable[[str], None],
) -> list[DayEstimate]:
    """Identify all days that are not kept; `names` are those of the parameters."""
    keys = [digest(repr(task), repr(day), *(identity(name) for name in day.files)) for day in days]
    with tempfile.TemporaryDirectory(prefix="symgen-") as fresh, executor(workers) as by:
        folder = WorkFolder(Path((workers and workers.work) or fresh))
        sizes = [1] * len(days)
        finished(by, task, days, keys, folder, sizes, progress, "days", "days")
        out = []
        for day, key in zip(days, keys, strict=True):
            with np.load(io.BytesIO(folder.read(key)), allow_pickle=False) as archive:
                torque, verdict = float(archive["torque"]), str(archive["verdict"])
                found = covariance = None
                if "X" in archive:
                    covariance = archive["covariance"]
                    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
                    rows = zip(names, archive["X"].tolist(), std.tolist(), strict=True)
                    found = tuple(Shift(*row) for row in rows)
                made = (torque, verdict, found, covariance, day.files)
                out.append(DayEstimate(day.robot, day.day, *made))
    return out


def grouped(files: Sequence[str], by: str | None) -> list[Day]:
    """Sort files by robot and day, days in the order of their numbers.

    Raises:
        LogError: a file does not tell its robot or its day.
    """
    folders = {name.rsplit("/", 1)[0] for name in files}
    out: dict[tuple[str, str], list[str]] = {}
    for name in files:
        parts = name.split("/")
        stem = parts[-1].rsplit(".", 1)[0]
        keys = dict(p.split("=", 1) for p in parts[:-1] if p.count("=") == 1)
        day = keys.get("day", keys.get("date"))
        robot = constant_column(name, by) if by is not None else keys.get("robot")
        if robot is None and day is None and len(folders) == 1:
            split = re.fullmatch(r"(.+?)[_-](.+)", stem)
            if split is None:
                raise LogError(
                    f"{name}: tells no robot and day; accepted: robot=NAME/day=DAY/FILE, "
                    "ROBOT/DAY.parquet, ROBOT_DAY.parquet, or --by COLUMN"
                )
            robot, day = split[1], split[2]
        if robot is None:
            above = [p for p in parts[:-1] if "=" not in p]
            robot = above[-1] if above else "robot"
        key = (plain(robot), plain(stem if day is None else day))
        out.setdefault(key, []).append(name)
    order = sorted(out, key=lambda k: (_natural(k[0]), _natural(k[1])))
    return [Day(robot, day, tuple(out[robot, day])) for robot, day in order]


def _natural(text: str) -> list[tuple[int, int, str]]:
    """Return a key that sorts day2 before day10: numbers by their length, then by their digits."""
    parts = ((p, p.lstrip("0")) for p in re.findall(r"[0-9]+|[^0-9]+", text))
    return [(0, len(n), n) if p[0] in "0123456789" else (1, 0, p) for p, n in parts]


def courses_of(estimates: Sequence[DayEstimate]) -> list[Course]:
    """Return the estimates robot by robot, without days that failed."""
    robots: dict[str, list[tuple[str, FloatArray, FloatArray]]] = {}
    for e in estimates:
        if e.parameters is not None:
            X, std = (np.array([p[k] for p in e.parameters]) for k in (1, 2))
            known = np.diag(std**2) if e.covariance is None else e.covariance
            robots.setdefault(e.robot, []).append((e.day, X, known))
    return [
        Course(
            name,
            tuple(d for d, _, _ in own),
            np.stack([X for _, X, _ in own]),
            np.stack([C for _, _, C in own]),
        )
        for name, own in robots.items()
    ]
