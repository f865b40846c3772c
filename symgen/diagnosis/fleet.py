"""fleet: one estimate for each robot and day; which robot drifted, and which stands out.

    files --by robot and day--> identify, on any worker --> X, covariance, torque error
    --> contrasts of all robots, parameters and days --> steps --> names

If the parameters alone do not explain a change, `diagnose` is run with the parameters of before.
"""

from __future__ import annotations

import io
import math
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.dataset import constant_column, identity, listed_files
from symgen.data.raw import Reading
from symgen.data.signals import NORMAL
from symgen.diagnosis.drift import LEVEL, Course, Finding, Shift, named, steps
from symgen.diagnosis.workflow import diagnose
from symgen.distributed import Workers, WorkFolder, digest, executor, finished
from symgen.errors import LogError, ParameterError, SymgenError, plain
from symgen.estimation.equation_model import NEEDED, EquationModel
from symgen.estimation.values import FloatArray
from symgen.identification.out_of_core import load_model
from symgen.identification.parameters import link_columns, read_given, regrouping
from symgen.identification.workflow import identify
from symgen.robot.toml_io import parse_robot, read_robot
from symgen.robot.toml_text import parameters_toml, robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import BESIDE, OrInf, at, read_result, result_file, to_json
from symgen.views import Viewable

MARKER = "fleet.json"
SCHEMA = "symgen.fleet/1"
#: A torque error stands out if it exceeds that of the fleet by this factor, and by this many times
#: the scatter of its logarithm.
_TIMES, _BEYOND = 1.5, 6.0


@dataclass(frozen=True)
class Day:
    """The logs of a robot on a day."""

    robot: str
    day: str
    files: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class DayEstimate:
    """The estimate of one robot on one day.

    Attributes:
        robot, day: their names.
        torque: relative torque error on held-out motion.
        verdict: "trusted", "doubtful", or "failed: " with the reason.
        parameters: None if the logs do not determine them.
        covariance: (p, p) of the parameters; None if only their std is known.
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
    """The task of a worker for one day."""

    robot: str
    model: str
    cutoff: float | None
    reading: Reading

    @property
    def _model(self) -> Evaluator | Robot:
        """The compiled model; built once per process."""
        if self.model not in NEEDED:  # `auto` selects the model again every day
            return parse_robot(self.robot, "robot.toml")
        return load_model(self.robot, EquationModel(self.model, 0.0).all_kernels)

    def __call__(self, day: Day) -> bytes:
        """Identify the model from the logs of a day."""
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


@dataclass(frozen=True, eq=False)
class Fleet(Viewable):
    """Estimates by robot and day, and the conclusions from them.

    Attributes:
        robot: name of the model.
        estimates: of every robot and day, in order.
        changes: robots that changed, with the day.
        outliers: robots that differ from the fleet, or have a larger torque error.
        notes: texts for the user.
    """

    robot: str
    estimates: tuple[DayEstimate, ...]
    changes: tuple[Finding, ...]
    outliers: tuple[Finding, ...]
    notes: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters; empty if no day was identified."""
        return next(
            (tuple(p.name for p in e.parameters) for e in self.estimates if e.parameters), ()
        )

    def to_json(self) -> dict[str, Any]:
        """Return the content of fleet.json (schema symgen.fleet/1)."""
        return to_json(self, SCHEMA)


def read_fleet(path: str | Path) -> Fleet:
    """Read a fleet from fleet.json.

    fleet.json contains the variances of the covariances, and no logs.

    Args:
        path: the folder that `fleet` wrote, or the fleet.json in it.

    Raises:
        ParameterError: the file does not exist or is damaged.
    """
    file = result_file(path, MARKER)
    found = read_result(Fleet, file, SCHEMA)
    if len({tuple(p.name for p in e.parameters) for e in found.estimates if e.parameters}) > 1:
        raise ParameterError(
            f"{file}: damaged at estimates: days have other parameters; accepted: schema {SCHEMA} "
            "as fleet writes it"
        )
    variances = [p.std * p.std for e in found.estimates for p in e.parameters or ()]
    if any(map(math.isinf, variances)):
        raise ParameterError(
            f"{file}: damaged at estimates: the square of a std is no number; accepted: schema "
            f"{SCHEMA} as fleet writes it"
        )
    return found


def fleet(
    robot: Robot | str | Path,
    logs: Sequence[str | Path] | str | Path,
    *,
    by: str | None = None,
    reference: str | Path | None = None,
    model: str = "momentum",
    cutoff: float | None = None,
    reading: Reading | None = None,
    workers: Workers | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Fleet:
    """Identify every robot and day of a data set, and find drift and outliers.

    Robot and day come from the path, `robot=7/day=2026-03-01/x.parquet`. Otherwise the folder is
    the robot and the file name the day. If all files are in one folder, the file name is ROBOT_DAY.

    Args:
        robot: the model of all robots: a robot, a path or a library name.
        logs: files, patterns, folders or URLs.
        by: a column of the files that contains the robot's name, one name per file.
        reference: expected parameters of every robot: the folder that `identify` wrote, its
            estimate.json, or TOML; by default the median of the robots' first days.
        model: energy, momentum or torque.
        cutoff: of the filters, Hz; by default that of the reference, or one that suits the first
            day.
        reading: how logs are read.
        workers: as for `identify`.
        progress: called with a text about each step.

    Raises:
        LogError: there is no log, or robot and day cannot be found.
        SymgenError: no day can be identified.
    """
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    sources = [logs] if isinstance(logs, (str, Path)) else list(logs)
    days = grouped(listed_files(sources), by)
    derived = derive(source, ())
    given = None if reference is None else read_given(reference, derived)
    if cutoff is None and given is not None and given.band is not None:
        cutoff = given.band.cutoff_hz
    reading = reading or Reading()
    task = IdentifyDay(robot_toml(source), model, cutoff, reading)
    if cutoff is None:
        progress("choosing the cutoff from the first day")
        first = identify(source, list(days[0].files), model=model, reading=reading)
        cutoff = first.band.cutoff_hz if first.band is not None else None
        task = replace(task, cutoff=cutoff)
    names = derived.base.names
    estimates = _estimates(task, days, names, workers, progress)
    ask = partial(_diagnosed, source, names, cutoff, reading, progress)
    X = None if given is None else given.X
    return Fleet(source.name, tuple(estimates), *_findings(source, derived, estimates, X, ask))


def grouped(files: Sequence[str], by: str | None) -> list[Day]:
    """Sort files by robot and day, with days in numerical order.

    Raises:
        LogError: robot or day of a file cannot be found.
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
    """Return a sort key that puts day2 before day10: numbers by length, then by digits."""
    parts = ((p, p.lstrip("0")) for p in re.findall(r"[0-9]+|[^0-9]+", text))
    return [(0, len(n), n) if p[0] in "0123456789" else (1, 0, p) for p, n in parts]


def _estimates(
    task: IdentifyDay,
    days: Sequence[Day],
    names: Sequence[str],
    workers: Workers | None,
    progress: Callable[[str], None],
) -> list[DayEstimate]:
    """Identify the days without a stored result; `names` are those of the parameters."""
    keys = [digest(repr(task), repr(day), *(identity(name) for name in day.files)) for day in days]
    with tempfile.TemporaryDirectory(prefix="symgen-") as fresh, executor(workers) as by:
        folder = WorkFolder(Path((workers and workers.work) or fresh))
        finished(by, task, days, keys, folder, [1] * len(days), progress, "days", "days")
        kept = [folder.read(key) for key in keys]
    return [_estimate(day, content, names) for day, content in zip(days, kept, strict=True)]


def _estimate(day: Day, content: bytes, names: Sequence[str]) -> DayEstimate:
    """Return the estimate that a worker wrote."""
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        found = covariance = None
        if "X" in archive:
            covariance = archive["covariance"]
            std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
            rows = zip(names, archive["X"].tolist(), std.tolist(), strict=True)
            found = tuple(Shift(*row) for row in rows)
        torque, verdict = float(archive["torque"]), str(archive["verdict"])
    return DayEstimate(day.robot, day.day, torque, verdict, found, covariance, day.files)


def courses_of(estimates: Sequence[DayEstimate]) -> list[Course]:
    """Return the estimates of each robot, without days that failed."""
    out = []
    for name, own in _by_robot(estimates).items():
        X, std = (np.array([[p[k] for p in e.parameters or ()] for e in own]) for k in (1, 2))
        covariance = np.stack([
            np.diag(s**2) if e.covariance is None else e.covariance
            for e, s in zip(own, std, strict=True)
        ])  # fmt: skip
        out.append(Course(name, tuple(e.day for e in own), X, covariance))
    return out


def _by_robot(estimates: Sequence[DayEstimate]) -> dict[str, list[DayEstimate]]:
    """Return the identified days of each robot."""
    out: dict[str, list[DayEstimate]] = {}
    for e in estimates:
        if e.parameters is not None:
            out.setdefault(e.robot, []).append(e)
    return out


def _findings(
    robot: Robot,
    model: Model,
    estimates: Sequence[DayEstimate],
    reference: FloatArray | None,
    ask: Callable[[list[Finding], FloatArray, Sequence[str]], list[Finding]],
) -> tuple[tuple[Finding, ...], tuple[Finding, ...], tuple[str, ...]]:
    """Return changes, outliers and notes.

    Args:
        robot: the robot of all estimates.
        model: its symbolic model.
        estimates: of every robot and day.
        reference: (p,) expected parameters of every robot, or None.
        ask: runs `diagnose` on the logs of a day with the parameters (p,) of before.
    """
    courses = courses_of(estimates)
    if not courses:
        raise SymgenError(f"no day could be identified: {estimates[0].verdict}")
    names, link = model.base.names, robot.payload or robot.movable[-1].number
    load = regrouping(model)[:, link_columns(model, link)]
    middle = np.median([c.X[0] for c in courses], axis=0)
    known, files = {c.robot: c for c in courses}, {(e.robot, e.day): e.files for e in estimates}

    def asked(plain: list[Finding]) -> list[Finding]:
        """Run `diagnose` on the first day of each change."""
        name, since = plain[0].robot, plain[0].since
        k = known[name].days.index(since)
        before = known[name].mean(slice(0, k)).X if k else middle
        return ask(plain, before, files[name, since])

    changes: list[Finding] = []
    outliers: list[Finding] = []
    found = steps(courses, names, reference)
    for step in found:
        findings = named(step, names, load, link)
        if any(not f.effect for f in findings):
            findings = asked(findings)
        changes += findings if not step.first or reference is not None else []
        outliers += findings if step.first else []
    changed = {step.robot for step in found}
    for loud in _loud(estimates):
        if loud.robot not in changed:
            outliers += asked([loud])
    looks = len(names) * sum(len(c.X) for c in courses)
    notes: tuple[str, ...] = (
        f"{len(courses)} robots, {len(estimates)} days, {looks:,} looks: a p value is corrected "
        f"for all of them, and {LEVEL:g} is the chance of one false alarm in the fleet",
    )
    failed = sum(e.parameters is None for e in estimates)
    notes += (f"{failed} days could not be identified",) if failed else ()
    return tuple(changes), tuple(outliers), notes


def _loud(estimates: Sequence[DayEstimate]) -> Iterator[Finding]:
    """Yield the robots whose torque error stands out up to the last day."""
    logs = {
        name: np.array([math.log(max(e.torque, 1e-12)) for e in own])
        for name, own in _by_robot(estimates).items()
    }
    every = np.concatenate(list(logs.values()))
    if len(every) < 5:
        return
    centre = float(np.median(every))
    spread = max(NORMAL * float(np.median(np.abs(every - centre))), 0.02)
    for name, own in _by_robot(estimates).items():
        away = logs[name] - centre
        quiet = np.flatnonzero(away <= max(_BEYOND * spread, math.log(_TIMES)))
        last = away[quiet[-1] + 1 :] if len(quiet) else away
        if len(last):
            p = min(len(every) * math.erfc(float(last.min()) / spread / math.sqrt(2)), 1.0)
            says = f"torque error {math.exp(float(np.median(last))):.2g} times that of the fleet"
            yield Finding(name, own[-len(last)].day, "", (), (), p, says)


def _diagnosed(
    robot: Robot,
    names: Sequence[str],
    cutoff: float | None,
    reading: Reading,
    progress: Callable[[str], None],
    plain: list[Finding],
    before: FloatArray,
    files: Sequence[str],
) -> list[Finding]:
    """Run `diagnose` on some logs with the parameters (p,) of before, and name the changes."""
    first = plain[0]
    progress(f"diagnosing {first.robot} since {first.since}")
    try:
        with tempfile.TemporaryDirectory(prefix="symgen-") as folder:
            file = Path(folder) / "before.toml"
            file.write_text(parameters_toml(zip(names, map(float, before), strict=True)), "utf-8")
            told = diagnose(robot, list(files), parameters=file, cutoff=cutoff, reading=reading)
    except SymgenError as error:
        return [replace(f, says=f"{f.says}; not diagnosed: {error}") for f in plain]
    out = []
    for e in told.effects:
        values = tuple(Shift(p.name, p.value, p.std) for p in e.parameters)
        says = f"{e.name} of joint {', '.join(map(str, e.joints))}" if e.joints else e.name
        own = (e.name, e.joints, values, first.p_value, says)
        out.append(Finding(first.robot, first.since, *own))
    return out or plain
