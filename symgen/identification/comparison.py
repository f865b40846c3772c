"""Compare two estimates of one robot: which parameters moved, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symgen.errors import ParameterError
from symgen.estimation.opening import LATE
from symgen.identification.estimate import (
    LOG_DIGEST,
    ROBOT_DIGEST,
    Estimate,
    ParameterEstimate,
    read_estimate,
)
from symgen.policy import BEYOND
from symgen.schemas import as_json
from symgen.views import Viewable

SCHEMA = "symgen.comparison/1"


@dataclass(frozen=True)
class Compared:
    """One parameter in both estimates; the formula and the unit are the same."""

    a: ParameterEstimate
    b: ParameterEstimate

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self.a.name

    @property
    def difference(self) -> float:
        """Value of b minus value of a, in the parameter's unit."""
        return self.b.value - self.a.value

    @property
    def std(self) -> float:
        """Standard deviation of the difference, for independent estimates, in the same unit."""
        return math.hypot(self.a.std, self.b.std)

    @property
    def sigmas(self) -> float:
        """The difference over its standard deviation; NaN if that is unknown or zero."""
        return self.difference / self.std if 0 < self.std < math.inf else math.nan

    @property
    def moved(self) -> bool:
        """Whether the difference is above 3 of its standard deviations."""
        return abs(self.sigmas) > BEYOND


@dataclass(frozen=True, eq=False)
class Comparison(Viewable):
    """Two estimates of one robot.

    Attributes:
        names: names of the estimates: their paths, or "a" and "b".
        a, b: the estimates.
        parameters: parameters with the same formula and unit in both, in the order of a.
        left_out: name of every other parameter, and the reason why it is not compared.
        notes: limits of the comparison, as texts.
        shared: labels of the training logs that both estimates used.
        alike: names that training logs of both have. The logs may be one file, or parts of it.
    """

    names: tuple[str, str]
    a: Estimate
    b: Estimate
    parameters: tuple[Compared, ...]
    left_out: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    shared: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return the robot and the verdict."""
        moved, count = len(self.moved), len(self.parameters)
        return f"<Comparison of {self.a.robot}: {self.verdict}, {moved} of {count} moved>"

    @property
    def moved(self) -> tuple[Compared, ...]:
        """The parameters that moved, the largest number of standard deviations first."""
        return tuple(sorted((p for p in self.parameters if p.moved), key=lambda p: -abs(p.sigmas)))

    @property
    def verdict(self) -> str:
        """The result: "differ" (a parameter moved), "agree", or "unknown".

        It is unknown if there are no standard deviations. It is also unknown if no parameter moved,
        but both estimates used one log or logs with the same name. Such estimates share the errors
        of the log, so that wrong values agree too.
        """
        if self.moved:
            return "differ"
        judged = any(not math.isnan(p.sigmas) for p in self.parameters)
        return "agree" if judged and not (self.shared or self.alike) else "unknown"

    @property
    def summary(self) -> str:
        """The verdict in a sentence."""
        count = len(self.parameters)
        judged = sum(not math.isnan(p.sigmas) for p in self.parameters)
        if not judged:
            return f"No standard deviation of the {count} common parameters is known."
        # expected number beyond 3 standard deviations of a normal distribution
        chance = f"{judged * math.erfc(BEYOND / math.sqrt(2)):.2g}"
        text = (
            f"{len(self.moved)} of {judged} parameters moved by more than {BEYOND:g} combined "
            f"standard deviations; chance alone would move {chance} of them on average."
        )
        if self.verdict == "unknown" and self.shared:
            text += " Both used the same training data, so that this shows no agreement."
        elif self.verdict == "unknown":
            text += (
                f" Both used a training log named {', '.join(self.alike)}: if that is one file, "
                "this shows no agreement; give different files different names."
            )
        return text

    def to_json(self) -> dict[str, Any]:
        """Return the comparison as JSON values (schema symgen.comparison/1)."""
        content = {
            "schema": SCHEMA,
            "robot": self.a.robot,
            "verdict": self.verdict,
            "summary": self.summary,
            "estimates": [
                {
                    "name": name,
                    "model": e.model,
                    "method": e.method,
                    "verdict": e.verdict,
                    "residual": {"train": e.train.relative, "validation": e.validation.relative},
                }
                for name, e in zip(self.names, (self.a, self.b), strict=True)
            ],
            "parameters": [
                {
                    "name": p.name,
                    "expression": p.a.expression,
                    "unit": p.a.unit,
                    "a": {"value": p.a.value, "std": p.a.std},
                    "b": {"value": p.b.value, "std": p.b.std},
                    "difference": p.difference,
                    "sigmas": p.sigmas,
                    "moved": p.moved,
                }
                for p in self.parameters
            ],
            "shared_training_logs": self.shared,
            "left_out": [{"name": name, "reason": reason} for name, reason in self.left_out],
            "notes": self.notes,
        }
        return dict(as_json(content))


def compare(a: Estimate | str | Path, b: Estimate | str | Path) -> Comparison:
    """Compare two estimates of one robot, parameter by parameter.

        sigmas = (b - a) / sqrt(std_a^2 + std_b^2)

    The standard deviation of the difference is valid for independent data. A parameter is compared
    only if both estimates have it with the same formula and unit. ZZ1R of two sets may regroup
    different standard parameters, and is then a different quantity.

    Args:
        a: an estimate, the folder that `identify` wrote, or its estimate.json.
        b: the other estimate.

    Raises:
        ParameterError: symgen cannot read a file, the names of the robots differ, or the estimates
            have no common parameter.
    """
    pairs = ("a", a), ("b", b)
    names = tuple(k if isinstance(x, Estimate) else str(x) for k, x in pairs)
    first, second = (x if isinstance(x, Estimate) else read_estimate(x) for x in (a, b))
    where = " and ".join(names)
    if first.robot != second.robot:
        raise ParameterError(
            f"{where}: they are of the robots {first.robot} and {second.robot}; accepted: two "
            "estimates of one robot"
        )
    theirs = {p.name: p for p in second.parameters}
    common, left_out = [], []
    for p in first.parameters:
        q = theirs.pop(p.name, None)
        if q is None:
            left_out.append((p.name, f"only in {names[0]}"))
        elif q.expression != p.expression:
            left_out.append((p.name, f"it is {p.expression} in one, {q.expression} in the other"))
        elif q.unit != p.unit:
            left_out.append((p.name, f"its unit is {p.unit} in one, {q.unit} in the other"))
        else:
            common.append(Compared(p, q))
    left_out += [(name, f"only in {names[1]}") for name in theirs]
    if not common:
        raise ParameterError(
            f"{where}: no parameter has the same name and formula in both; accepted: two estimates "
            "of one robot"
        )
    logs = _logs(second)
    shared = tuple(label for digest, label in _logs(first).items() if digest in logs)
    files = [{name.removesuffix(LATE) for name in _logs(e).values()}
             for e in (first, second)]  # fmt: skip
    alike = tuple(sorted(set.intersection(*files) - set(shared)))
    notes = _notes(first, second, shared, alike)
    pair = (names[0], names[1])
    return Comparison(pair, first, second, tuple(common), tuple(left_out), notes, shared, alike)


def _notes(
    a: Estimate, b: Estimate, shared: tuple[str, ...], alike: tuple[str, ...]
) -> tuple[str, ...]:
    """Return the limits of a comparison: common data, other robot files, excluded errors."""
    notes = ["the difference in standard deviations assumes that the two used independent data"]
    if alike:
        notes.append(
            f"both used a log named {', '.join(alike)}, or a part of it: if it is one file, they "
            "are not independent"
        )
    if shared:
        notes.append(
            f"they are not independent: both used {', '.join(shared)}; the standard deviation of a "
            "difference is not the one shown, and usually smaller"
        )
    robots = [dict(e.provenance).get(ROBOT_DIGEST) for e in (a, b)]
    if None not in robots and robots[0] != robots[1]:
        notes.append(
            "their robot files differ (another digest): formulas are the same, lengths and angles "
            "may not be"
        )
    if a.excludes == b.excludes and a.excludes:
        notes.append(f"standard deviations exclude: {a.excludes}")
    else:
        notes += [
            f"standard deviations of {name} exclude: {e.excludes}"
            for name, e in (("a", a), ("b", b))
            if e.excludes
        ]
    return tuple(notes)


def _logs(estimate: Estimate) -> dict[str, str]:
    """Return digest and name of the training logs of an estimate."""
    start, end = "train ", f", {LOG_DIGEST}"
    return {
        value: key.removeprefix(start).removesuffix(end)
        for key, value in estimate.provenance
        if key.startswith(start) and key.endswith(end)
    }
