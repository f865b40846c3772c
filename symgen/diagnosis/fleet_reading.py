"""What is known of a fleet as JSON, and from the folder that fleet wrote."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symgen.diagnosis.fleet import Finding, Fleet, Shift
from symgen.diagnosis.robot_days import Day, DayEstimate
from symgen.errors import ParameterError
from symgen.schemas import OrNan, from_json, read_json, result_file, to_json

MARKER = "fleet.json"
SCHEMA = "symgen.fleet/1"


@dataclass(frozen=True)
class _Day:
    robot: str
    day: str
    torque_residual: OrNan
    verdict: str
    parameters: tuple[Shift, ...] | None


@dataclass(frozen=True)
class _File:
    robot: str
    estimates: tuple[_Day, ...]
    changes: tuple[Finding, ...]
    outliers: tuple[Finding, ...]
    notes: tuple[str, ...]


def fleet_json(fleet: Fleet) -> dict[str, Any]:
    """Return the content of fleet.json."""
    days = []
    for e in fleet.estimates:
        known = None
        if e.X is not None and e.covariance is not None:
            std = np.sqrt(np.maximum(np.diag(e.covariance), 0.0))
            rows = zip(fleet.names, e.X.tolist(), std.tolist(), strict=True)
            known = tuple(Shift(*row) for row in rows)
        days.append(_Day(e.day.robot, e.day.day, e.torque, e.verdict, known))
    file = _File(fleet.robot, tuple(days), fleet.changes, fleet.outliers, fleet.notes)
    return to_json(file, SCHEMA)


def read_fleet(path: str | Path) -> Fleet:
    """Read what is known of a fleet again.

    Of covariances fleet.json keeps the variances, and of logs none.

    Args:
        path: the folder that `fleet` wrote, or the fleet.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    f = from_json(_File, read_json(file, SCHEMA), file)
    names = {tuple(p.name for p in day.parameters) for day in f.estimates if day.parameters}
    if len(names) > 1:
        raise ParameterError(
            f"{file}: damaged at estimates: days have other parameters; accepted: schema {SCHEMA} "
            "as fleet writes it"
        )
    known = names.pop() if names else ()
    days = tuple(map(_estimate, f.estimates))
    if any(day.covariance is not None and np.isinf(day.covariance).any() for day in days):
        raise ParameterError(
            f"{file}: damaged at estimates: the square of a std is no number; accepted: schema "
            f"{SCHEMA} as fleet writes it"
        )
    return Fleet(f.robot, known, days, f.changes, f.outliers, f.notes)


def _estimate(day: _Day) -> DayEstimate:
    X = covariance = None
    if day.parameters is not None:
        X = np.array([p.value for p in day.parameters])
        with np.errstate(over="ignore"):  # `read_fleet` refuses what is not finite
            covariance = np.diag(np.square([p.std for p in day.parameters]))
    error = day.torque_residual if math.isfinite(day.torque_residual) else math.inf
    return DayEstimate(Day(day.robot, day.day, ()), X, covariance, error, day.verdict)
