"""fleet: an estimate for each robot and day; which robot drifted since when, and which stands out.

    files --by robot and day--> identify, where a worker is free --> X, covariance, torque error
    --> contrasts of all robots, parameters and days --> steps --> names

What parameters alone do not name is put before diagnose, with the parameters that the robot had.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model, derive
from symgen.data.dataset import listed_files
from symgen.data.raw import Reading
from symgen.data.signals import NORMAL
from symgen.diagnosis.drift import LEVEL, Course, Named, Step, named, steps
from symgen.diagnosis.robot_days import (
    DayEstimate,
    IdentifyDay,
    Shift,
    courses_of,
    estimated,
    grouped,
)
from symgen.diagnosis.workflow import diagnose
from symgen.distributed import Workers
from symgen.errors import ParameterError, SymgenError
from symgen.identification.parameters import link_columns, read_given, regrouping
from symgen.identification.workflow import identify
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import parameters_toml, robot_toml
from symgen.robot.types import Robot
from symgen.schemas import OrNan, from_json, read_json, result_file, to_json

MARKER = "fleet.json"
SCHEMA = "symgen.fleet/1"
FloatArray = NDArray[np.float64]
#: A torque error stands out where it is so many times that of the fleet, and beyond so many times
#: the scatter of its logarithm.
_TIMES, _BEYOND = 1.5, 6.0


@dataclass(frozen=True)
class Finding:
    """A robot that changed or stands out.

    Attributes:
        robot: its name.
        since: first day of it.
        effect: its name, "" where nothing could be named.
        joints: numbers of the joints.
        parameters: name, value and standard deviation.
        p_value: corrected for the number of robots, parameters and days that were looked at.
        says: in words.
    """

    robot: str
    since: str
    effect: str
    joints: tuple[int, ...]
    parameters: tuple[Shift, ...]
    p_value: OrNan
    says: str


@dataclass(frozen=True, eq=False)
class Fleet:
    """Estimates by robot and day, and what they tell.

    Attributes:
        robot: name of the model.
        estimates: of every robot and day, in their order.
        changes: since a day.
        outliers: robots that are others than the fleet, or leave more torque unexplained.
        notes: in words.
    """

    robot: str
    estimates: tuple[DayEstimate, ...]
    changes: tuple[Finding, ...]
    outliers: tuple[Finding, ...]
    notes: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters; empty where no day has any."""
        return next(
            (tuple(p.name for p in e.parameters) for e in self.estimates if e.parameters), ()
        )

    def to_json(self) -> dict[str, Any]:
        """Return the content of fleet.json (schema symgen.fleet/1)."""
        return to_json(self, SCHEMA)


def read_fleet(path: str | Path) -> Fleet:
    """Read what is known of a fleet again.

    Of covariances fleet.json keeps the variances, and of logs none.

    Args:
        path: the folder that `fleet` wrote, or the fleet.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    found = from_json(Fleet, read_json(file, SCHEMA), file)
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
    """Identify every robot and day of a data set, and find what drifted and what stands out.

    Robot and day are those of the path, `robot=7/day=2026-03-01/x.parquet`; else the folder is the
    robot and the name of the file the day; else, where all files lie in one folder, the name is
    ROBOT_DAY.

    Args:
        robot: the model of all of them: a robot, a path or a library name.
        logs: files, patterns, folders or URLs.
        by: a column of the files that names the robot, one name a file.
        reference: parameters that every robot should have: the folder that `identify` wrote, its
            estimate.json, or TOML; by default the median of the robots' first days.
        model: energy, momentum or torque.
        cutoff: of the filters, Hz; by default that of the reference, or what suits the first day.
        reading: how logs are read.
        workers: as for `identify`.
        progress: is told what is being done.

    Raises:
        LogError: there is no log, or robot and day are not known.
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
    estimates = estimated(task, days, derived.base.names, workers, progress)
    X = None if given is None else given.X
    found = _findings(source, derived, estimates, X, cutoff, reading, progress)
    return Fleet(source.name, tuple(estimates), *found)


def _findings(
    robot: Robot,
    model: Model,
    estimates: Sequence[DayEstimate],
    reference: FloatArray | None,
    cutoff: float | None,
    reading: Reading,
    progress: Callable[[str], None],
) -> tuple[tuple[Finding, ...], tuple[Finding, ...], tuple[str, ...]]:
    """Return changes, outliers and notes."""
    courses = courses_of(estimates)
    if not courses:
        raise SymgenError(f"no day could be identified: {estimates[0].verdict}")
    names = model.base.names
    found = steps(courses, names, reference)
    link = robot.payload or robot.movable[-1].number
    load = regrouping(model)[:, link_columns(model, link)]
    ask = partial(_diagnosed, robot, names, estimates, courses, cutoff, reading)
    changes: list[Finding] = []
    outliers: list[Finding] = []
    for step in found:
        findings = [_finding(step, n) for n in named(step, names, load, link)]
        if any(not f.effect for f in findings):
            progress(f"diagnosing {step.robot} since {step.since}")
            findings = ask(step.robot, step.since, step.p_value, findings)
        changes += findings if not step.first or reference is not None else []
        outliers += findings if step.first else []
    known = {step.robot for step in found}
    for name, since, times, p in _loud(estimates):
        if name in known:
            continue
        says = f"torque error {times:.2g} times that of the fleet"
        plain = [Finding(name, since, "", (), (), p, says)]
        progress(f"diagnosing {name} since {since}")
        outliers += ask(name, since, p, plain)
    looks = len(names) * sum(len(c.X) for c in courses)
    notes: tuple[str, ...] = (
        f"{len(courses)} robots, {len(estimates)} days, {looks:,} looks: a p value is corrected "
        f"for all of them, and {LEVEL:g} is the chance of one false alarm in the fleet",
    )
    failed = sum(e.parameters is None for e in estimates)
    notes += (f"{failed} days could not be identified",) if failed else ()
    return tuple(changes), tuple(outliers), notes


def _finding(step: Step, n: Named) -> Finding:
    values = tuple(Shift(*v) for v in n.values)
    return Finding(step.robot, step.since, n.effect, n.joints, values, step.p_value, n.says)


def _loud(estimates: Sequence[DayEstimate]) -> list[tuple[str, str, float, float]]:
    """Return robot, first day, ratio and p value where the torque error stands out to the end."""
    logs = np.array([math.log(max(e.torque, 1e-12)) for e in estimates if e.parameters is not None])
    if len(logs) < 5:
        return []
    centre = float(np.median(logs))
    spread = max(NORMAL * float(np.median(np.abs(logs - centre))), 0.02)
    robots: dict[str, list[DayEstimate]] = {}
    for e in estimates:
        if e.parameters is not None:
            robots.setdefault(e.robot, []).append(e)
    out = []
    for name, own in robots.items():
        away = [math.log(max(e.torque, 1e-12)) - centre for e in own]
        loud = [a > max(_BEYOND * spread, math.log(_TIMES)) for a in away]
        if loud[-1]:
            k = len(loud) - next((i for i, x in enumerate(reversed(loud)) if not x), len(loud))
            least = min(away[k:])
            p = min(len(logs) * math.erfc(least / spread / math.sqrt(2)), 1.0)
            out.append((name, own[k].day, math.exp(float(np.median(away[k:]))), p))
    return out


def _diagnosed(
    robot: Robot,
    names: Sequence[str],
    estimates: Sequence[DayEstimate],
    courses: Sequence[Course],
    cutoff: float | None,
    reading: Reading,
    name: str,
    since: str,
    p_value: float,
    plain: list[Finding],
) -> list[Finding]:
    """Ask diagnose what changed, with the parameters of before, on the first day of the change."""
    course = next(c for c in courses if c.robot == name)
    k = course.days.index(since)
    before = course.mean(slice(0, k))[0] if k else np.median([c.X[0] for c in courses], axis=0)
    (day,) = (e for e in estimates if (e.robot, e.day) == (name, since))
    try:
        with tempfile.TemporaryDirectory(prefix="symgen-") as folder:
            file = Path(folder) / "before.toml"
            file.write_text(parameters_toml(zip(names, map(float, before), strict=True)), "utf-8")
            told = diagnose(robot, list(day.files), parameters=file, cutoff=cutoff, reading=reading)
    except SymgenError as error:
        return [replace(f, says=f"{f.says}; not diagnosed: {error}") for f in plain]
    out = [
        Finding(
            name, since, e.name, e.joints,
            tuple(Shift(p.name, p.value, p.std) for p in e.parameters), p_value,
            f"{e.name} of joint {', '.join(map(str, e.joints))}" if e.joints else e.name,
        )
        for e in told.effects
    ]  # fmt: skip
    return out or plain
