"""Chunks of long logs: which rows are read, and which of what they give counts.

A chunk has rows of its own, and on either side as many more as filters, windows and sums of scores
reach: what a filter leaves of a sample beyond them is below 1e-10. It begins at a multiple of every
stride, so that nodes, windows and kept samples are those of the whole log; each of them lies in the
own time of exactly one chunk. Chunks never span a gap.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.log import Log
from symgen.data.raw import Reading
from symgen.data.signals import TAIL, Samples, sampled
from symgen.data.stretch import Stretch
from symgen.estimation.band import Band
from symgen.estimation.decimation import decimation
from symgen.estimation.filtered import FilteredLog, filtered, stride_of
from symgen.estimation.logs import open_samples
from symgen.estimation.recipe import Recipe
from symgen.estimation.repairs import Repair
from symgen.estimation.speeds import mended_speeds, shifted
from symgen.estimation.summary import LAGS
from symgen.estimation.system import Equations
from symgen.estimation.thin import ThinLog, packed_arrays, thin_log, thinned
from symgen.estimation.torque_error import TorqueFit, of_torque, squares
from symgen.estimation.windows import windows
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Own rows of a chunk, about; those of a partition, the unit of work, that is kept when finished.
CHUNK, PARTITION = 1 << 17, 1 << 20
_LOOKED = 1 << 13  # samples of a chunk in which wrong speeds are looked for first
_SPLINE = 128  # samples that a derivative reaches, twice over
_SLOPES_HZ = 10.0  # of the low-pass that derives a missing speed


@dataclass(frozen=True)
class Part:
    """One log of the run: a stretch, or the part of it that trains or is held out.

    Attributes:
        stretch: its rows alone.
        kind: "train" or "validation".
    """

    stretch: Stretch
    kind: str


@dataclass(frozen=True)
class Chunk:
    """Some rows of a part.

    Attributes:
        part: number of the part in the run.
        rows: that are read: first, and the one behind the last.
        before: rows of the part before these.
        own: first row of its own among these, and the one behind the last: equations at the times
            in between count.
        ended: whether the part ends with it.
    """

    part: int
    rows: tuple[int, int]
    before: int
    own: tuple[int, int]
    ended: bool


@dataclass(frozen=True)
class Partition:
    """Chunks of one file, in its order: what a worker reduces to a summary."""

    file: str
    chunks: tuple[Chunk, ...]

    @property
    def samples(self) -> int:
        """Own rows."""
        return sum(chunk.own[1] - chunk.own[0] for chunk in self.chunks)


@dataclass(frozen=True)
class Settings:
    """How every chunk is treated.

    Attributes:
        band: of the run.
        recipe: of the equations.
        delay: by which torques are late, s.
    """

    band: Band
    recipe: Recipe
    delay: float = 0.0


def unit(step: float, settings: Settings) -> int:
    """Return the samples of which chunks begin at multiples."""
    band, recipe = settings.band, settings.recipe
    stride = stride_of(band, step)
    every = decimation(1 << 30, step, stride, band.comparison_hz).every
    if recipe.model == "torque":
        return math.lcm(stride, every)
    own = windows(step, stride, recipe.window)
    return math.lcm(stride, every, own.stride * own.hop)


def reach(step: float, settings: Settings, measured: bool) -> int:
    """Return the samples beyond its own that a chunk needs on either side.

    Args:
        step: of the log, s.
        settings: of the run.
        measured: whether the log has speeds.
    """
    band, recipe = settings.band, settings.recipe

    def tail(hz: float) -> int:
        return math.ceil(TAIL / (hz * step))

    # one after the other: a missing speed, positions, slopes
    motion = tail(band.cutoff_hz) + 2 * _SPLINE + (0 if measured else tail(_SLOPES_HZ))
    compared = tail(band.comparison_hz)
    if recipe.model == "torque":
        every = decimation(1 << 30, step, stride_of(band, step), band.comparison_hz).every
        return motion + compared + LAGS * 2 * every
    own = windows(step, stride_of(band, step), recipe.window)
    summed = own.stride * (2 * own.steps + LAGS * own.steps + own.hop)
    return motion + max(compared, summed)


def partitions(
    parts: Sequence[Part], settings: Settings, chunk: int = CHUNK, most: int = PARTITION
) -> list[Partition]:
    """Cut the parts of a run into chunks, and gather these into partitions.

    Args:
        parts: in the order of their files.
        settings: that tell how far a chunk reaches.
        chunk: own rows of a chunk, about.
        most: own rows of a partition, about.
    """
    out: list[Partition] = []
    for number, part in enumerate(parts):
        for piece in _chunks(number, part, settings, chunk):
            last = out[-1] if out else None
            if last is not None and last.file == part.stretch.file and last.samples < most:
                out[-1] = replace(last, chunks=(*last.chunks, piece))
            else:
                out.append(Partition(part.stretch.file, (piece,)))
    return out


def _chunks(number: int, part: Part, settings: Settings, chunk: int) -> list[Chunk]:
    s = part.stretch
    multiple, beyond = unit(s.step, settings), reach(s.step, settings, s.measured)
    length = max(chunk // multiple, 1) * multiple
    edges = [*range(0, max(s.count - length // 2, 1), length), s.count]
    out = []
    for begin, end in pairwise(edges):
        low = max(begin - beyond, 0) // multiple * multiple
        high = min(end + beyond, s.count)
        rows = (s.rows[0] + low, s.rows[0] + high)
        out.append(Chunk(number, rows, low, (begin - low, end - low), end == s.count))
    return out


@dataclass(frozen=True, eq=False)
class ChunkOfLog:
    """A chunk in the band of the run.

    Attributes:
        log: all its rows, or where nothing is masked what their equations need.
        own: times of what counts, s.
        ended: whether the part ends with it.
    """

    log: FilteredLog | ThinLog
    own: tuple[float, float]
    ended: bool

    def inside(self, t: FloatArray) -> NDArray[np.bool_]:
        """Return which times are its own."""
        return np.asarray((t >= self.own[0]) & (t < self.own[1]))

    def all_equations(self, evaluator: Evaluator, recipe: Recipe) -> tuple[Equations, ...]:
        """Return its equations, those of others that it reaches into with them."""
        if isinstance(self.log, ThinLog):
            return self.log.equations(evaluator, recipe)
        return recipe.equations(evaluator, self.log)

    def equations(self, e: Equations) -> Equations:
        """Return its own equations."""
        return e.where(self._span(e), e.name)

    def with_lead(self, e: Equations, lag: int) -> tuple[Equations, int]:
        """Return its own equations and up to `lag` - 1 before them, and how many these are."""
        own = self._span(e)
        lead = min(lag - 1, own.start) if own.stop > own.start else 0
        return e.where(slice(own.start - lead, own.stop), e.name), lead

    def _span(self, e: Equations) -> slice:
        """Return which equations, in their order in time, are its own."""
        return slice(*map(int, np.searchsorted(e.t, self.own)))

    def packed(self) -> bytes:
        """Return the bytes of an NPZ file, of a chunk without a mask."""
        assert isinstance(self.log, ThinLog)
        own = np.array([*self.own, float(self.ended)])
        return packed_arrays({**self.log.arrays(), "own": own})

    def fit(self, evaluator: Evaluator, X: FloatArray) -> TorqueFit:
        """Compare its own torques with those of a model, without traces."""
        log = self.log
        if isinstance(log, ThinLog):
            own = self.inside(log.t)
            return squares(own[:, None], log.measured, log.torque(evaluator, X), log.resting)
        inverse = evaluator["inverse_dynamics"]
        chunks = log.modelled(lambda q, qd, qdd: inverse(q, qd, qdd, X))
        torque = np.concatenate([found for _, found in chunks])
        own = self.inside(log.t[log.kept])
        return replace(of_torque(log, torque, own=own), traces=())


def unpacked_chunk(arrays: Mapping[str, NDArray[Any]]) -> ChunkOfLog:
    """Return the chunk whose `packed` holds some arrays."""
    first, last, ended = map(float, arrays["own"])
    return ChunkOfLog(thin_log(arrays), (first, last), bool(ended))


def treated(
    log: Log,
    chunk: Chunk,
    stretch: Stretch,
    robot: Robot,
    reading: Reading,
    settings: Settings,
    clean: bool = False,
) -> tuple[ChunkOfLog, tuple[Repair, ...]]:
    """Put the rows of a chunk into the band of the run: repaired, sampled, masked and filtered.

    Args:
        log: the rows.
        chunk: which they are.
        stretch: of the part that they belong to.
        robot: the log's robot.
        reading: what is masked.
        settings: of the run.
        clean: whether an earlier pass found nothing to mend.

    Raises:
        LogError: the rows are refused as those of a log.
    """
    rows, clock = len(log.t), (stretch.times[0], stretch.step)
    begin, end = chunk.own
    first = log.t[begin] - stretch.step / 2 if chunk.before + begin else -math.inf
    last = math.inf if chunk.ended else log.t[end] - stretch.step / 2
    plain = replace(reading, start=None, until=None)
    samples, repairs = (
        (sampled(log, clock), ())
        if clean and not reading.mask
        else open_samples(log, robot, plain, clock=clock)
    )
    before = chunk.before
    if len(samples.t) != rows or samples.t[0] != log.t[0]:  # on the ticks of the stretch
        before = round((samples.t[0] - clock[0]) / clock[1])
    skip = -before % unit(stretch.step, settings)
    samples = samples.cut(slice(skip, None)) if skip else samples
    samples, more = (samples, ()) if clean else _mended(samples, settings.band.comparison_hz)
    if settings.delay:
        samples = shifted(samples, settings.delay)
    whole = filtered(samples, settings.band)
    found = whole if whole.mask is not None else thinned(whole, settings.recipe)
    return ChunkOfLog(found, (first, last), chunk.ended), (*repairs, *more)


def _mended(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Repair, ...]]:
    """Mend speeds, where a part of the chunk shows that they ask for it: a look at all is dear."""
    if len(samples.t) > 2 * _LOOKED:
        middle = len(samples.t) // 2
        part = samples.cut(slice(middle - _LOOKED // 2, middle + _LOOKED // 2))
        if not mended_speeds(part, comparison_hz)[1]:
            return samples, ()
    return mended_speeds(samples, comparison_hz)
