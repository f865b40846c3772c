"""What `study` finds: bias and precision of every parameter, and of predicted torque."""

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
    """How well a parameter is found.

    Attributes:
        name: of the parameter.
        unit: of value, bias and standard deviations.
        value: the true one.
        bias: mean of the estimates less the true value.
        bias_error: standard error of that mean.
        std: standard deviation of the estimates over the runs.
        estimated_std: what the estimates say of it, root mean square; None: nothing.
        coverage: share of the runs whose interval value +- 1.96 std holds the truth.
        std_by_length: with the motions recorded once, twice, four times.
        seconds: to be recorded until sqrt(bias^2 + std^2) is the target, std falling as the square
            root of it does; at least once the motions. None: no length is long enough.
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
        """Whether std is at most 30 % of the value, as an estimate calls a parameter known."""
        return 100 * self.relative_std <= KNOWN


@dataclass(frozen=True)
class Tried:
    """A model with a method.

    Attributes:
        model, method: by name.
        band: of the filters, chosen from the first run.
        failed: runs that did not determine the parameters.
        parameters: one by one; empty where fewer than three runs did.
        torque_error: ||tau of X - tau|| / ||tau|| along a motion without noise that no run had,
            root mean square over the runs.
        torque_error_per_joint: the same joint by joint.
        torque_error_by_length: with the motions recorded once, twice, four times.
        std_ratio_by_length: std over that of recording once, all parameters together; 0.71 and 0.5
            where errors at different times are independent.
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
        """Model and method in words."""
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
        """Return how many parameters reach the target in a time."""
        return sum(p.seconds is not None and p.seconds <= seconds for p in self.parameters)

    @property
    def slowest(self) -> Precision | None:
        """Of the parameters that are known and reach the target, the one that takes longest."""
        reach = [p for p in self.parameters if p.known and p.seconds is not None]
        return max(reach, key=lambda p: p.seconds or 0.0, default=None)


@dataclass(frozen=True)
class Settings:
    """What a study was made with.

    Attributes:
        runs: of every model and method.
        seed: of all noise.
        seconds: of the motions, recorded once.
        lengths: how many times they are recorded.
        rate_hz: of the logs.
        window_s: of energy and momentum.
        target_percent: of a parameter's value.
        trajectories: names of the motions.
        held_out: name of the motion along which torque is predicted.
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
        robot: its name.
        settings: what it was made with.
        results: models and methods, in the order in which they were asked for.
        notes: in words.
    """

    robot: str
    settings: Settings
    results: tuple[Tried, ...]
    notes: tuple[str, ...]

    @property
    def best(self) -> Tried | None:
        """The model and method that predict torque best; None where nothing could be solved."""
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
HEADER = ("model and method", "torque error", "at once", "in the end", "never", "coverage")
COLUMNS = ("name", "true", "bias", "std", "std says", "coverage", "record", "unit")


def read_study(path: str | Path) -> Study:
    """Read a study again.

    Args:
        path: the folder that `study` wrote, or the study.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
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
    """Say in a sentence how long must be recorded."""
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
    """Return a time in the unit that a person would use."""
    if seconds is None:
        return "never"
    for size, unit in ((86400.0, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
