"""identify on more samples than memory holds: symgen reads long logs segment by segment.

    files --columns of time--> stretches without gaps --last fifth held out--> logs
    logs --a sample of them--> in memory: band, delay, faults, model, tests, curves
    logs --segments--> summaries of the equations of each --added up--> weights, X
    segments --decimated--> sums of scores, squared errors of torque --added up--> covariance, fit

Each segment is opened as a separate log. Filters and windows lose less than a second at its edges,
of 2^18 samples. Its nodes are kept in memory for the errors; where they do not fit, it is opened
again. A worker gets the address of a segment and returns sums, whose size does not depend on the
number of samples.
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
from symgen.data.mask import Bools
from symgen.data.raw import Reading
from symgen.data.tables import has_segments
from symgen.estimation.band import Band
from symgen.estimation.covariance import long_run, scores
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Ols
from symgen.estimation.filtered_log import FilteredLog, Nodes, filter_log
from symgen.estimation.solve import (
    PASSES,
    least_squares_solution,
    log_weights,
)
from symgen.estimation.summary import Summary, merge_summaries, summaries
from symgen.estimation.system import Filling, torque_at
from symgen.estimation.torque_error import TorqueFit, squares
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, Fault, merge_faults
from symgen.faults.repair import open_samples
from symgen.faults.speeds import mended_speeds
from symgen.faults.undo import with_earlier_torques
from symgen.identification.assessment import Outcome, outcome
from symgen.identification.model_choice import ChosenModel
from symgen.identification.sampling import KINDS, LongLogs
from symgen.identification.settle import settle
from symgen.identification.solving import Method
from symgen.identification.weak_prior import WeakPrior
from symgen.parallel import in_order
from symgen.robot.toml_text import robot_toml
from symgen.runtime.evaluator import Evaluator, load_model

#: Bytes of filtered segments that are kept for their errors; further segments are read again.
_ROOM = 1 << 27
_LOOKED = 1 << 13  # samples of a segment that are first checked for wrong speeds
Result = TypeVar("Result")


@dataclass(frozen=True)
class Segment:
    """The address of some rows of a log, which are opened as a separate log.

    Attributes:
        rows: rows of the log.
        number: number of the log.
        reduced: what its errors need, if kept in memory.
    """

    rows: Stretch
    number: int
    reduced: Reduced | None = None


@dataclass(frozen=True, eq=False)
class Reduced:
    """What equations and errors need of a filtered segment.

    Attributes:
        filling: its equations without their columns.
        nodes: its motion, for the model's torque.
        measured: torque in the comparison band, (K, n).
        free, resting: as in `FilteredLog`, (K, n).
    """

    filling: Filling
    nodes: Nodes
    measured: FloatArray
    free: Bools
    resting: Bools | None

    @property
    def size(self) -> int:
        """Approximate size in bytes."""
        return 2 * sum(x.nbytes for x in self.nodes.motion)


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
        keeps: whether results contain what the errors of a segment need.
    """

    robot: str
    kernels: tuple[str, ...]
    reading: Reading
    band: Band
    model: EquationModel
    delays: tuple[tuple[tuple[int, ...], float], ...]
    keeps: bool

    @property
    def evaluator(self) -> Evaluator:
        """The compiled model."""
        return load_model(self.robot, self.kernels)


def segments_of(number: int, log: Stretch) -> list[Segment]:
    """Cut a log into segments; a file format without access to rows gives one segment."""
    if not has_segments(log.file):
        return [Segment(log, number)]
    first, last = log.rows
    length = long_logs.LIMIT
    end = max(last - length // 2, first + 1)
    edges = [*range(first, end, length), last]
    return [Segment(log.between(*rows), number) for rows in pairwise(edges)]


def _open(segment: Segment, folding: Folding) -> tuple[FilteredLog, tuple[Fault, ...]]:
    """Read, repair, resample, mask and filter a segment in the band of the run.

    Returns:
        The filtered segment and its repairs.

    Raises:
        LogError: symgen cannot use the rows, for the same reasons as a log.
    """
    s, reading = segment.rows, folding.reading
    robot = folding.evaluator.model.robot
    log = read_rows(s, s.rows, robot, reading)
    clock = s.times[0], s.step
    samples, repairs = open_samples(log, robot, reading, clock=clock)
    middle = slice(max(len(samples.t) - _LOOKED, 0) // 2, None)
    looked = samples.cut(middle).cut(slice(_LOOKED))
    band = folding.band.comparison_hz
    if mended_speeds(looked, band)[1]:
        samples, more = mended_speeds(samples, band)
        repairs += more
    for joints, delay in folding.delays:
        samples = with_earlier_torques(samples, delay, joints or None)
    return filter_log(samples, folding.band), repairs


def _reduced(segment: Segment, folding: Folding) -> tuple[Reduced, tuple[Fault, ...]]:
    """Open a segment and return what equations and errors need of it, and its repairs."""
    log, repairs = _open(segment, folding)
    filling, nodes = folding.model.filling(log), log.at_nodes()
    return Reduced(filling, nodes, log.measured, log.free, log.resting), repairs


def fold_equations(
    folding: Folding, segment: Segment
) -> tuple[list[Summary], tuple[Fault, ...], Reduced | None]:
    """Return the summaries of a segment's equations, joint by joint, its repairs, and what its
    errors need if this process is to keep it.
    """
    reduced, repairs = _reduced(segment, folding)
    rows = reduced.filling(folding.evaluator, folding.model.features)
    return summaries(rows.each_part()), repairs, reduced if folding.keeps else None


#: (number of the log, joint) -> weight of the equations, and lag of the sums of scores in rows.
Weights = Mapping[tuple[int, int], tuple[float, int]]


def fold_errors(
    folding: Folding, X: FloatArray, weights: Weights | None, segment: Segment
) -> tuple[FloatArray, TorqueFit]:
    """Return the sums of scores (p, p) of a segment for X, 0 without weights, and its torque
    errors.
    """
    evaluator, s = folding.evaluator, segment.reduced or _reduced(segment, folding)[0]
    torque = s.nodes.modelled(partial(torque_at, evaluator, X))
    fit = squares(s.free, s.measured, torque, s.resting)
    meat = np.zeros((len(X), len(X)))
    if segment.rows.kind == "train" and weights is not None:
        rows = s.filling(evaluator, None)  # scores need no features
        of_joints = (weights[segment.number, j] for j in range(rows.y.shape[1]))
        pairs = zip(rows.each_part(), of_joints, strict=True)
        parts = ((scores(e, X, weight), lag, e.shared) for e, (weight, lag) in pairs)
        for part in long_run(parts):
            meat += part
    return meat, fit


def solve_segments(chosen: ChosenModel, method: Method) -> Outcome:
    """Solve least squares over all segments of long logs.

    It adds up the summaries of the equations, solves them, and adds up the errors of the solution.

    Args:
        chosen: the model, chosen on a sample.
        method: a method that needs only sums over segments.
    """
    campaign, model, long = chosen.campaign, chosen.best.model, _long(chosen)
    folding = Folding(
        robot_toml(campaign.robot),
        long.kernels,
        long.reading,
        campaign.band,
        model,
        tuple((c.cause.joints, c.cause.delay) for c in campaign.answer.delays),
        long.executor is None,
    )
    summed, segments, mended = _summaries(chosen, folding)
    train, held = (
        {key: s for key, s in summed.items() if long.stretches[key[0]].kind == kind}
        for kind in KINDS
    )
    names = campaign.evaluator.model.base.names
    campaign.progress(f"solving for {len(names)} parameters")
    parts = list(train.values())
    prior = WeakPrior.of(campaign.evaluator.model, parts)
    needed = prior.rows if method.is_wls and chosen.best.known is not None else None
    passes = 0 if method.name == Ols.name else PASSES
    weights, solved = log_weights(parts, names, passes, needed)
    lags = [s.lag for s in parts]
    rows = dict(zip(train, zip(weights, lags, strict=True), strict=True))
    meat, fits = _errors(chosen, segments, partial(fold_errors, folding, solved[0], rows))
    solution = least_squares_solution(parts, weights, solved, meat, needed)
    settled = settle(chosen, method, solution, prior)
    X = settled.solution.X
    if X is not solution.X:
        _, fits = _errors(chosen, segments, partial(fold_errors, folding, X, None))
    curves = campaign.torques(X)
    fits = [replace(every, traces=some.traces) for every, some in zip(fits, curves, strict=True)]
    everywhere = (fault for fault in campaign.repairs if fault.log == EVERYWHERE)
    return outcome(
        settled,
        model,
        (parts, list(held.values())),
        fits,
        (*merge_faults(mended), *everywhere),
        long.in_words("folded; band, curves and tests of bias are those of"),
    )


def _long(chosen: ChosenModel) -> LongLogs:
    assert chosen.campaign.long is not None
    return chosen.campaign.long


def _summaries(
    chosen: ChosenModel, folding: Folding
) -> tuple[dict[tuple[int, int], Summary], list[Segment], list[Fault]]:
    """Return the summaries of all equations by log and joint, the segments, and their repairs."""
    long = _long(chosen)
    segments = [x for k, log in enumerate(long.stretches) for x in segments_of(k, log)]
    summed: dict[tuple[int, int], Summary] = {}
    read: list[Segment] = []
    mended: list[Fault] = []
    folded = _each(chosen, partial(fold_equations, folding), segments, "equations")
    room = _ROOM
    for segment, (joints, repairs, reduced) in zip(segments, folded, strict=True):
        mended += repairs
        if reduced is not None:
            room -= reduced.size
        read.append(replace(segment, reduced=reduced if room >= 0 else None))
        for j, s in enumerate(joints):
            key = segment.number, j
            before = [summed[key]] if key in summed else []
            summed[key] = merge_summaries([*before, s])
    return summed, read, mended


def _errors(
    chosen: ChosenModel,
    segments: Sequence[Segment],
    fold: Callable[[Segment], tuple[FloatArray, TorqueFit]],
) -> tuple[FloatArray, list[TorqueFit]]:
    """Return the sums of scores, and the torque errors of both kinds of logs."""
    fits = {kind: TorqueFit.none(chosen.campaign.robot) for kind in KINDS}
    count = len(chosen.campaign.evaluator.model.base.names)
    meat = np.zeros((count, count))
    results = _each(chosen, fold, segments, "errors")
    for segment, (part, fit) in zip(segments, results, strict=True):
        meat += part
        fits[segment.rows.kind] += fit
    return meat, list(fits.values())


def _each(
    chosen: ChosenModel, fold: Callable[[Segment], Result], segments: Sequence[Segment], what: str
) -> Iterator[Result]:
    """Yield the result of each segment in order, and report the progress."""
    long = _long(chosen)
    for k, result in enumerate(in_order(fold, segments, long.threads, long.executor), 1):
        yield result
        chosen.campaign.progress(f"{what}: {k} of {len(segments)} segments")
