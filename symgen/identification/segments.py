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
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from symgen.data import long_logs
from symgen.data.long_logs import Stretch, read_rows
from symgen.data.raw import Reading
from symgen.data.signals import sampled
from symgen.data.tables import reads_rows
from symgen.estimation.band import Band
from symgen.estimation.covariance import bartlett, scores
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Ols
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import open_log
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
from symgen.identification.campaign import Campaign, load_model
from symgen.identification.model_choice import ChosenModel
from symgen.identification.sampling import KINDS
from symgen.identification.settle import settle
from symgen.identification.solving import Method
from symgen.identification.weak_prior import WeakPrior
from symgen.parallel import in_order
from symgen.robot.toml_text import robot_toml
from symgen.runtime.evaluator import Evaluator

_LOOKED = 1 << 13  # samples of a segment that are first checked for wrong speeds
Result = TypeVar("Result")


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
class Folding:
    """Options of reading and processing segments.

    Attributes:
        robot: text of the robot.toml.
        kernels: kernels of the model.
        reading: options of reading files.
        band: band of the run.
        model: model of the equations.
        delays: delays of torques to undo: positions of the joints, empty for all, and s.
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


def _open(segment: Segment, folding: Folding) -> tuple[FilteredLog, tuple[Fault, ...]]:
    """Read, repair, resample, mask and filter a segment in the band of the run.

    Returns:
        The filtered segment and its repairs.

    Raises:
        LogError: symgen cannot use the rows, for the same reasons as a log.
    """
    s, robot, reading = segment.rows, folding.evaluator.model.robot, folding.reading
    log, clock = read_rows(s, s.rows, robot, reading), (s.times[0], s.step)
    repairs: tuple[Fault, ...] = ()
    if segment.clean:
        samples = sampled(open_log(log, robot, reading), clock)
    else:
        samples, repairs = open_samples(log, robot, reading, clock=clock)
    middle = slice(max(len(samples.t) - _LOOKED, 0) // 2, None)
    looked, band = samples.cut(middle).cut(slice(_LOOKED)), folding.band.comparison_hz
    if not segment.clean and mended_speeds(looked, band)[1]:
        samples, more = mended_speeds(samples, band)
        repairs += more
    for joints, delay in folding.delays:
        samples = with_earlier_torques(samples, delay, joints or None)
    return filter_log(samples, folding.band), repairs


def fold_equations(folding: Folding, segment: Segment) -> tuple[list[Summary], tuple[Fault, ...]]:
    """Return the summaries of a segment's equations, joint by joint, and its repairs."""
    log, repairs = _open(segment, folding)
    return [summarise(e) for e in folding.model.equations(folding.evaluator, log)], repairs


#: (number of the log, joint) -> weight of the equations, and lag of the sums of scores in rows.
Weights = Mapping[tuple[int, int], tuple[float, int]]


def fold_errors(
    folding: Folding, X: FloatArray, weights: Weights, segment: Segment
) -> tuple[FloatArray, TorqueFit]:
    """Return the sums of scores (p, p) of a segment for X, and its torque errors."""
    evaluator, (log, _) = folding.evaluator, _open(segment, folding)
    torque = modelled_torque(evaluator, log, X)
    fit = squares(log.free, log.measured, torque, log.resting)
    meat = np.zeros((len(X), len(X)))
    if segment.rows.kind == "train":
        model = replace(folding.model, features=None)  # scores need no features
        for j, e in enumerate(model.equations(evaluator, log)):
            weight, lag = weights[segment.number, j]
            meat += bartlett(scores(e, X, weight), lag)
    return meat, fit


def solve_segments(chosen: ChosenModel, method: Method) -> Outcome:
    """Solve least squares over all segments of long logs.

    It adds up the summaries of the equations, solves them, and adds up the errors of the solution.

    Args:
        chosen: the model, chosen on a sample.
        method: a method that needs only sums over segments.
    """
    campaign, model = chosen.campaign, chosen.best.model
    long = campaign.long
    assert long is not None
    folding = Folding(
        robot_toml(campaign.robot),
        long.kernels,
        long.reading,
        campaign.band,
        model,
        tuple((c.cause.joints, c.cause.delay) for c in campaign.answer.delays),
    )
    segments = [x for k, log in enumerate(long.stretches) for x in segments_of(k, log)]
    each = partial(_each, campaign)
    summaries: dict[tuple[int, int], Summary] = {}
    mended: list[Fault] = []
    again: list[Segment] = []
    folded = each(partial(fold_equations, folding), segments, "equations")
    for segment, (joints, repairs) in zip(segments, folded, strict=True):
        mended += repairs
        again.append(replace(segment, clean=not (repairs or long.reading.mask)))
        for j, s in enumerate(joints):
            key = segment.number, j
            summaries[key] = merge_summaries([summaries[key], s]) if key in summaries else s
    train, held = (
        {key: s for key, s in summaries.items() if long.stretches[key[0]].kind == kind}
        for kind in KINDS
    )
    names = campaign.evaluator.model.base.names
    campaign.progress(f"solving for {len(names)} parameters")
    parts = list(train.values())
    prior = WeakPrior.of(campaign.evaluator.model, parts)
    needed = None if chosen.best.known is None or not method.is_wls else prior.rows
    passes = 0 if method.name == Ols.name else PASSES
    weights, solved = log_weights(parts, names, passes, needed)
    lags = [s.lag for s in parts]
    weighted = dict(zip(train, zip(weights, lags, strict=True), strict=True))

    def errors(X: FloatArray) -> tuple[FloatArray, list[TorqueFit]]:
        """Return the sums of scores for X, and the torque errors of both kinds of logs."""
        fits = {kind: TorqueFit.none(campaign.robot) for kind in KINDS}
        meat = np.zeros((len(X), len(X)))
        results = each(partial(fold_errors, folding, X, weighted), again, "errors")
        for segment, (part, fit) in zip(again, results, strict=True):
            meat += part
            fits[segment.rows.kind] += fit
        return meat, list(fits.values())

    meat, fits = errors(solved[0])
    solution = least_squares_solution(parts, weights, solved, meat, needed)
    settled = settle(chosen, method, solution, prior)
    X = settled.solution.X
    if X is not solution.X:
        _, fits = errors(X)
    drawn = campaign.torques(X)
    fits = [replace(a, traces=b.traces) for a, b in zip(fits, drawn, strict=True)]
    everywhere = (fault for fault in campaign.repairs if fault.log == EVERYWHERE)
    return outcome(
        settled,
        model,
        (parts, list(held.values())),
        fits,
        (*merge_faults(mended), *everywhere),
        long.in_words("folded; band, curves and tests of bias are those of"),
    )


def _each(
    campaign: Campaign,
    fold: Callable[[Segment], Result],
    segments: Sequence[Segment],
    what: str,
) -> Iterator[Result]:
    """Yield the result of each segment in order, and report the progress."""
    long = campaign.long
    assert long is not None
    for k, result in enumerate(in_order(fold, segments, long.threads, long.executor), 1):
        yield result
        campaign.progress(f"{what}: {k} of {len(segments)} segments")
