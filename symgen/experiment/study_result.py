"""Results of `study`: bias and precision of every parameter, and torque error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symgen.errors import first_of
from symgen.estimation.band import Band
from symgen.experiment.recording import Recording
from symgen.identification.assessment import KNOWN
from symgen.schemas import read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.study/1"
MARKER = "study.json"


@dataclass(frozen=True)
class Precision:
    """Bias and standard deviation of a parameter.

    Attributes:
        name: name of the parameter.
        unit: unit of value, bias and standard deviations.
        value: true value.
        bias: mean of the estimates minus the true value.
        bias_error: standard error of that mean.
        std: standard deviation of the estimates over the runs.
        estimated_std: root mean square of the stated standard deviations; None without any.
        coverage: share of the runs whose interval value +- 1.96 std contains the true value.
        std_by_length: std with the motions recorded once, twice and four times.
        seconds: recording time until sqrt(bias^2 + std^2) reaches the target, if std falls as
            1 / sqrt(time); at least the time of the motions. None if no time is long enough.
    """

    name: str
    unit: str
    value: float
    bias: float
    bias_error: float
    std: float
    estimated_std: float | None
    coverage: float
    std_by_length: tuple[float, ...]
    seconds: float | None

    @property
    def relative_std(self) -> float:
        """std / |value|."""
        return self.std / abs(self.value) if self.value else math.inf

    @property
    def known(self) -> bool:
        """Whether std is at most 30 % of the value, as for a known parameter of an estimate."""
        return 100 * self.relative_std <= KNOWN


@dataclass(frozen=True)
class Tried:
    """The result of a model with a method.

    Attributes:
        model, method: names of model and method.
        band: filter band, chosen from the first run.
        failed: number of runs that did not determine the parameters.
        parameters: result of each parameter; empty if fewer than three runs have an estimate.
        torque_error: ||tau of X - tau|| / ||tau|| on a motion without noise that no run has, root
            mean square over the runs.
        torque_error_per_joint: the same for each joint.
        torque_error_by_length: torque error with the motions recorded once, twice and four times.
        std_ratio_by_length: std relative to one recording, over all parameters; 0.71 and 0.5 if
            errors at different times are independent.
    """

    model: str
    method: str
    band: Band
    failed: int
    parameters: tuple[Precision, ...]
    torque_error: float | None
    torque_error_per_joint: tuple[float, ...]
    torque_error_by_length: tuple[float, ...]
    std_ratio_by_length: tuple[float, ...]

    @property
    def name(self) -> str:
        """Name of model and method."""
        return f"{self.model} by {self.method}"

    @property
    def coverage(self) -> float:
        """Mean coverage of the parameters; NaN without any."""
        if not self.parameters:
            return math.nan
        return sum(p.coverage for p in self.parameters) / len(self.parameters)

    @property
    def biased(self) -> tuple[Precision, ...]:
        """The parameters whose bias alone is above the target."""
        return tuple(p for p in self.parameters if p.seconds is None)

    def within(self, seconds: float) -> int:
        """Return the number of parameters that reach the target in a time."""
        return sum(p.seconds is not None and p.seconds <= seconds for p in self.parameters)

    @property
    def slowest(self) -> Precision | None:
        """The known parameter that reaches the target last."""
        reach = [p for p in self.parameters if p.known and p.seconds is not None]
        return max(reach, key=lambda p: p.seconds or 0.0, default=None)


@dataclass(frozen=True)
class Settings:
    """The settings of a study.

    Attributes:
        runs: number of runs of every model and method.
        seed: seed of all noise.
        seconds: duration of the motions, recorded once.
        lengths: how many times the motions are recorded.
        rate_hz: sampling rate of the logs.
        window_s: window of energy and momentum.
        target_percent: target, in percent of the value of a parameter.
        trajectories: names of the motions.
        held_out: name of the motion on which the torque error is measured.
        recording: instruments, controller, disturbance.
    """

    runs: int
    seed: int
    seconds: float
    lengths: tuple[int, ...]
    rate_hz: float
    window_s: float
    target_percent: float
    trajectories: tuple[str, ...]
    held_out: str
    recording: Recording


@dataclass(frozen=True)
class Study(Viewable):
    """Bias and precision of estimates of a robot, by simulation.

    Attributes:
        robot: name of the robot.
        settings: settings of the study.
        results: results of models and methods, in the requested order.
        notes: remarks as texts.
    """

    robot: str
    settings: Settings
    results: tuple[Tried, ...]
    notes: tuple[str, ...]

    @property
    def best(self) -> Tried | None:
        """The model and method with the smallest torque error; None if none has a solution."""
        found = [r for r in self.results if r.torque_error is not None]
        return min(found, key=lambda r: r.torque_error or 0.0, default=None)

    def __repr__(self) -> str:
        best = self.best
        told = "nothing determined" if best is None else f"{best.name}: {answer(self, best)}"
        ways, runs = len(self.results), self.settings.runs
        return f"<Study of {self.robot}: {ways} ways, {runs} runs; {told}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of study.json."""
        return to_json(self, SCHEMA)


#: Of `overview`, and of `precision_rows`.
HEADER = ("model and method", "torque error", "at first", "any time", "never", "coverage")
COLUMNS = ("name", "true", "bias", "std", "stated std", "coverage", "record", "unit")


def read_study(path: str | Path) -> Study:
    """Read a study again.

    Args:
        path: the folder that `study` wrote, or the study.json in it.

    Raises:
        ParameterError: there is no study, or it is damaged.
    """
    return read_result(Study, result_file(path, MARKER), SCHEMA)


def overview(study: Study) -> list[tuple[str, ...]]:
    """Return a row of HEADER for every model and method."""
    rows: list[tuple[str, ...]] = []
    for r in study.results:
        error = "-" if r.torque_error is None else f"{100 * r.torque_error:.2g} %"
        count = len(r.parameters)
        cover = "-" if math.isnan(r.coverage) else f"{100 * r.coverage:.0f} %"
        rows.append((
            r.name, error, f"{r.within(study.settings.seconds)} of {count}",
            f"{r.within(math.inf)} of {count}", str(len(r.biased)), cover,
        ))  # fmt: skip
    return rows


def precision_rows(found: Tried) -> list[tuple[str, ...]]:
    """Return a row of COLUMNS for every parameter; bias and std over the value."""

    def share(x: float | None, of: float) -> str:
        return "-" if x is None or not of else f"{100 * x / abs(of):.2g} %"

    return [
        (
            p.name, f"{p.value:.4g}", share(p.bias, p.value), share(p.std, p.value),
            share(p.estimated_std, p.value), f"{100 * p.coverage:.0f} %", duration(p.seconds),
            p.unit,
        )
        for p in found.parameters
    ]  # fmt: skip


def answer(study: Study, r: Tried) -> str:
    """Return a sentence about the necessary recording time."""
    s, target = study.settings, f"{study.settings.target_percent:g} %"
    slow = r.slowest
    out = f"{r.within(s.seconds)} of {len(r.parameters)} parameters within {target} "
    out += f"after {duration(s.seconds)}"
    if slow is not None and slow.seconds is not None and slow.seconds > s.seconds:
        known = sum(p.known and p.seconds is not None for p in r.parameters)
        out += f"; {known} after {duration(slow.seconds)}, the slowest of them is {slow.name}"
    late = [p.name for p in r.parameters if p.known and p.seconds is None]
    if late:
        out += f"; never {first_of(late, 6)}: the bias alone is larger"
    weak = sum(not p.known for p in r.parameters)
    if weak:
        out += f"; {weak} not known to {KNOWN:g} %"
    return out


def duration(seconds: float | None) -> str:
    """Return a time as a text in s, min, h or d, or "never"."""
    if seconds is None:
        return "never"
    for size, unit in ((86400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
