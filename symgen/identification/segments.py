"""identify on more samples than memory holds: symgen reads long logs segment by segment.

    files --columns of time--> stretches without gaps --last fifth held out--> logs
    logs --a sample of them--> in memory: band, delay, faults, model, tests, curves
    logs --segments--> summaries of the equations of each --added up--> weights, X
    logs --segments again--> sums of scores, squared errors of torque --added up--> covariance, fit

Each segment is opened as a separate log. Filters and windows lose less than a second at its edges,
of 2^18 samples. A worker gets the address of a segment and returns sums, whose size does not depend
on the number of samples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from symgen.codegen.model import derive
from symgen.data import long_logs
from symgen.data.long_logs import Source, Stretch, read_rows, stretches
from symgen.data.raw import Reading
from symgen.data.signals import Samples, sampled
from symgen.data.tables import reads_rows
from symgen.errors import LogError, first_of
from symgen.estimation.band import Band
from symgen.estimation.covariance import bartlett, scores
from symgen.estimation.equation_model import EquationModel, kernels_of
from symgen.estimation.estimators import Ols
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import first_held_out, open_log
from symgen.estimation.solve import (
    PASSES,
    least_squares_solution,
    log_weights,
)
from symgen.estimation.summary import Summary, merge_summaries, summarise
from symgen.estimation.torque_error import TorqueFit, modelled_torque, squares
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, Fault, merge_faults
from symgen.faults.repair import open_samples
from symgen.faults.speeds import mended_speeds
from symgen.faults.undo import with_earlier_torques
from symgen.identification.assessment import Outcome, outcome
from symgen.identification.model_choice import ChosenModel, OpenLogs
from symgen.identification.settle import settle
from symgen.identification.solving import Method
from symgen.identification.weak_prior import WeakPrior
from symgen.parallel import Say, in_order, thread_count
from symgen.robot.toml_io import parse_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

#: Samples of all training logs and of all validation logs that are read into memory, in so many
#: pieces.
SAMPLE, HELD_SAMPLE, PIECES = 80_000, 20_000, 4
#: Smallest length of a log, in windows and in samples.
_WINDOWS, _FEWEST = 2.0, 20
_LOOKED = 1 << 13  # samples of a segment that are first checked for wrong speeds
_KINDS = ("train", "validation")
Result = TypeVar("Result")


@lru_cache(maxsize=4)
def load_model(robot: str, kernels: tuple[str, ...]) -> Evaluator:
    """Compile and load a model once in each process.

    Args:
        robot: text of the robot.toml.
        kernels: names of the kernels.
    """
    return load(derive(parse_robot(robot, "robot.toml"), kernels))


@dataclass(frozen=True)
class Segment:
    """The address of some rows of a log, which are opened as a separate log.

    Attributes:
        rows: rows of the log.
        number: number of the log.
        clean: whether the segment is known to need no repair and no mask.
    """

    rows: Stretch
    number: int
    clean: bool = False


@dataclass(frozen=True, eq=False)
class Settings:
    """Options of reading and processing segments.

    Attributes:
        robot: text of the robot.toml.
        kernels: kernels of the model.
        reading: options of reading files.
        band: band of the run.
        model: model of the equations.
        delays: delays of torques to undo, see `symgen.identification.model_choice.Run`.
    """

    robot: str
    kernels: tuple[str, ...]
    reading: Reading
    band: Band
    model: EquationModel
    delays: tuple[tuple[tuple[int, ...], float], ...]

    @property
    def evaluator(self) -> Evaluator:
        """The compiled model."""
        return load_model(self.robot, self.kernels)


def segments_of(number: int, log: Stretch) -> list[Segment]:
    """Cut a log into segments; a file format without access to rows gives one segment."""
    if not reads_rows(log.file):
        return [Segment(log, number)]
    first, last = log.rows
    edges = [*range(first, max(last - long_logs.LIMIT // 2, first + 1), long_logs.LIMIT), last]
    return [Segment(log.between(*rows), number) for rows in pairwise(edges)]


def _open(segment: Segment, settings: Settings) -> tuple[FilteredLog, tuple[Fault, ...]]:
    """Read, repair, resample, mask and filter a segment in the band of the run.

    Returns:
        The filtered segment and its repairs.

    Raises:
        LogError: symgen cannot use the rows, for the same reasons as a log.
    """
    s, robot, reading = segment.rows, settings.evaluator.model.robot, settings.reading
    log, clock = read_rows(s, s.rows, robot, reading), (s.times[0], s.step)
    repairs: tuple[Fault, ...] = ()
    if segment.clean:
        samples = sampled(open_log(log, robot, reading), clock)
    else:
        samples, repairs = open_samples(log, robot, reading, clock=clock)
    middle = slice(max(len(samples.t) - _LOOKED, 0) // 2, None)
    looked, band = samples.cut(middle).cut(slice(_LOOKED)), settings.band.comparison_hz
    if not segment.clean and mended_speeds(looked, band)[1]:
        samples, more = mended_speeds(samples, band)
        repairs += more
    for joints, delay in settings.delays:
        samples = with_earlier_torques(samples, delay, joints or None)
    return filter_log(samples, settings.band), repairs


def fold_equations(settings: Settings, segment: Segment) -> tuple[list[Summary], tuple[Fault, ...]]:
    """Return the summaries of a segment's equations, joint by joint, and its repairs."""
    log, repairs = _open(segment, settings)
    return [summarise(e) for e in settings.model.equations(settings.evaluator, log)], repairs


#: (number of the log, joint) -> weight of the equations, and lag of the sums of scores in rows.
Weights = Mapping[tuple[int, int], tuple[float, int]]


def fold_errors(
    settings: Settings, X: FloatArray, weights: Weights, segment: Segment
) -> tuple[FloatArray, TorqueFit]:
    """Return the sums of scores (p, p) of a segment for X, and its torque errors."""
    evaluator, (log, _) = settings.evaluator, _open(segment, settings)
    torque = modelled_torque(evaluator, log, X)
    fit = squares(log.free, log.measured, torque, log.resting)
    meat = np.zeros((len(X), len(X)))
    if segment.rows.kind == "train":
        model = replace(settings.model, features=None)  # scores need no features
        for j, e in enumerate(model.equations(evaluator, log)):
            weight, lag = weights[segment.number, j]
            meat += bartlett(scores(e, X, weight), lag)
    return meat, fit


@dataclass(frozen=True, eq=False)
class SampledLogs:
    """Long logs, and the sample of them in memory.

    Attributes:
        logs: all logs.
        reading: options of reading rows.
        notes: notes on stretches that are not used.
        train, held: pieces of the training and of the validation logs.
        repairs: repairs of the pieces.
    """

    logs: Sequence[Stretch]
    reading: Reading
    notes: tuple[str, ...]
    train: Sequence[Samples]
    held: Sequence[Samples]
    repairs: tuple[Fault, ...]

    def in_words(self, what: str) -> tuple[str, ...]:
        """Return a note on the use of the sample; empty if it contains all samples.

        Args:
            what: text between the numbers of all samples and of those in the sample.
        """
        count = sum(len(s.t) for s in (*self.train, *self.held))
        total = sum(s.count for s in self.logs)
        return (f"{total:,} samples were {what} {count:,} of them",) if count < total else ()


def sample_logs(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    reading: Reading,
    window: float,
    progress: Say,
) -> SampledLogs:
    """Find the stretches of long logs without gaps, and open a sample of them.

    Args:
        robot: the robot of the logs.
        logs, validation: files or URLs; without validation, the last fifth of every stretch is
            held out.
        reading: options of reading files.
        window: window of the equations, s.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a file, a file stands twice in the lists, or the stretches are
            too short.
    """
    every = [str(source) for source in (*logs, *validation)]
    twice = [name for name in every if every.count(name) > 1]
    if twice:
        raise LogError(f"{twice[0]}: is given twice; accepted: each file once")
    progress(f"finding the stretches of {len(every)} files")
    parts: list[Stretch] = []
    short: list[str] = []
    for k, name in enumerate(every):
        for s in stretches(name, robot, reading):
            new = [replace(s, kind=_KINDS[k >= len(logs)])] if validation else _split(s)
            if all(x.count >= _FEWEST and x.times[1] - x.times[0] > _WINDOWS * window for x in new):
                parts += new
            else:
                short.append(s.name)
    listed = first_of(short, 3)
    for kind in _KINDS:
        if not any(s.kind == kind for s in parts):
            raise LogError(f"{listed}: too short a {kind} log; accepted: longer ones, without gaps")
    notes = (f"{len(short)} stretches are too short and left out: {listed}",) if short else ()
    repairs: list[Fault] = []
    plain, groups = replace(reading, start=None, until=None), list[list[Samples]]()
    for kind, budget in zip(_KINDS, (SAMPLE, HELD_SAMPLE), strict=True):
        progress(f"looking at {kind} samples")
        group = []
        for s, rows in sampled_rows([s for s in parts if s.kind == kind], budget):
            piece = rows != s.rows
            since = f" from {s.times[0] + (rows[0] - s.rows[0]) * s.step:.0f} s" if piece else ""
            log = read_rows(s, rows, robot, plain, s.name + since)
            samples, done = open_samples(log, robot, plain, clock=(s.times[0], s.step))
            repairs += done
            group.append(replace(samples, piece=piece))
        groups.append(group)
    return SampledLogs(parts, plain, notes, groups[0], groups[1], tuple(repairs))


def _split(s: Stretch) -> list[Stretch]:
    """Hold out the last fifth of a stretch."""
    edge = s.rows[0] + first_held_out(s.count)
    late = replace(s.between(edge, s.rows[1]), name=f"{s.name} (last fifth)", kind="validation")
    return [s.between(s.rows[0], edge), late]


def sampled_rows(logs: Sequence[Stretch], budget: int) -> list[tuple[Stretch, tuple[int, int]]]:
    """Return the rows of logs to read into memory: all, or evenly spaced pieces."""
    if sum(s.count for s in logs) <= budget:
        return [(s, s.rows) for s in logs]
    pieces, length = [], budget // PIECES
    for s in logs:
        first, last = s.rows
        begins = range(first, max(last - length, first) + 1, length)
        pieces += [(s, (k, min(k + length, last))) for k in begins]
    chosen = np.linspace(0, len(pieces) - 1, min(PIECES, len(pieces))).astype(int)
    return [pieces[k] for k in chosen]


def open_long_logs(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    models: Sequence[EquationModel],
    reading: Reading | None,
    executor: Executor | None,
    progress: Say,
) -> LongLogs:
    """Open a sample of long logs; the arguments are those of `sample_logs` and `identify`."""
    window = max(model.gap for model in models)
    data = sample_logs(robot, logs, validation, reading or Reading(), window, progress)
    kernels, text = kernels_of(models), robot_toml(robot)
    progress("deriving and compiling the model")
    return LongLogs(
        load_model(text, kernels), data.train, data.held, data.repairs, bool(validation), progress,
        thread_count() if executor is None else 1,
        sampled=data, about=(text, kernels), executor=executor,
    )  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class LongLogs(OpenLogs):
    """A sample of long logs, and the executor that processes all of them.

    Attributes:
        sampled: the logs.
        about: text of the robot file, and the kernels of the model.
        executor: executor of the work on segments; None for threads of this process.
    """

    sampled: SampledLogs
    about: tuple[str, tuple[str, ...]]
    executor: Executor | None

    def of_robot(self, robot: Robot, models: Sequence[EquationModel]) -> LongLogs:
        """Return the logs with the model of another robot with the same drive."""
        kernels, text = kernels_of(models), robot_toml(robot)
        return replace(self, evaluator=load_model(text, kernels), about=(text, kernels))

    def solve(self, chosen: ChosenModel, method: Method) -> Outcome:
        """Solve least squares over all segments.

        It adds up the summaries of the equations, solves them, and adds up the errors of the
        solution.
        """
        run, logs = chosen.run, self.sampled.logs
        settings = Settings(
            *self.about, self.sampled.reading, run.band, chosen.best.model, run.delays
        )
        segments = [x for k, log in enumerate(logs) for x in segments_of(k, log)]
        summaries: dict[tuple[int, int], Summary] = {}
        mended: list[Fault] = []
        folded = self._each(partial(fold_equations, settings), segments, "equations")
        again: list[Segment] = []
        for segment, (joints, repairs) in zip(segments, folded, strict=True):
            mended += repairs
            again.append(replace(segment, clean=not (repairs or settings.reading.mask)))
            for j, s in enumerate(joints):
                key = segment.number, j
                summaries[key] = merge_summaries([summaries[key], s]) if key in summaries else s
        train, held = (
            {key: s for key, s in summaries.items() if logs[key[0]].kind == kind} for kind in _KINDS
        )
        names = run.evaluator.model.base.names
        self.progress(f"solving for {len(names)} parameters")
        parts = list(train.values())
        prior = WeakPrior.of(run.evaluator.model, parts)
        needed = None if chosen.best.known is None or not method.is_wls else prior.rows
        passes = 0 if method.name == Ols.name else PASSES
        weights, solved = log_weights(parts, names, passes, needed)
        X = solved[0]
        lags = [s.lag for s in parts]
        summed = dict(zip(train, zip(weights, lags, strict=True), strict=True))
        meat, fits = self._errors(settings, X, summed, again)
        solution = least_squares_solution(parts, weights, solved, meat, needed)
        settled = settle(chosen, method, solution, prior)
        X = settled.solution.X
        if X is not solution.X:
            _, fits = self._errors(settings, X, summed, again)
        sample_fits = run.torques(X)
        fits = [replace(a, traces=b.traces) for a, b in zip(fits, sample_fits, strict=True)]
        what = "folded; band, curves and tests of bias are those of"
        return outcome(
            settled,
            chosen.best.model,
            (parts, list(held.values())),
            fits,
            (*merge_faults(mended), *(r for r in run.repairs if r.log == EVERYWHERE)),
            (*self.sampled.notes, *self.sampled.in_words(what)),
        )

    def _errors(
        self, settings: Settings, X: FloatArray, weights: Weights, segments: Sequence[Segment]
    ) -> tuple[FloatArray, list[TorqueFit]]:
        """Return the sums of scores for X, and the torque errors of both kinds of logs."""
        fits = {kind: TorqueFit.none(self.evaluator.model.robot) for kind in _KINDS}
        meat = np.zeros((len(X), len(X)))
        results = self._each(partial(fold_errors, settings, X, weights), segments, "errors")
        for segment, (part, fit) in zip(segments, results, strict=True):
            meat += part
            fits[segment.rows.kind] += fit
        return meat, list(fits.values())

    def _each(
        self, fold: Callable[[Segment], Result], segments: Sequence[Segment], what: str
    ) -> Iterator[Result]:
        """Yield the result of each segment in order, and report the progress."""
        results = in_order(fold, segments, self.threads, self.executor)
        for k, result in enumerate(results, 1):
            yield result
            self.progress(f"{what}: {k} of {len(segments)} segments")
