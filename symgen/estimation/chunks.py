"""Chunks of long logs: which rows are read, which of what they give counts, and what is kept.

A chunk has rows of its own, and on either side as many more as filters, windows and sums of scores
reach: what a filter leaves of a sample beyond them is below 1e-10. It begins at a multiple of every
stride, so that nodes, windows and kept samples are those of the whole log; each of them lies in the
own time of exactly one chunk. Chunks never span a gap.

The motion is smooth between nodes, and torques are compared some tens of times a second: a chunk
that was read, mended and filtered once is kept as a quarter of its samples or less, from which a
later pass goes on. W is not kept: it is larger than the motion that it is made of, and quickly
evaluated.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools
from symgen.data.signals import TAIL
from symgen.data.stretch import Stretch
from symgen.estimation.band import Band
from symgen.estimation.decimation import Decimation, decimation
from symgen.estimation.equation_model import Recipe
from symgen.estimation.filtered import FilteredLog, stride_of
from symgen.estimation.summary import LAGS
from symgen.estimation.system import (
    Equations,
    Model,
    compared_torques,
    energy_rows,
    energy_sides,
    equated,
    momentum_rows,
    momentum_sides,
    torque_sides,
)
from symgen.estimation.torque_error import TorqueFit, of_torque, squares
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import Windows, placed_windows, windows
from symgen.runtime.evaluator import Evaluator

_MOTION = ("q", "qd", "qdd")
_SIDES = ("joint", "correlation", "rest_weight")  # of equations, beside arrays


@dataclass(frozen=True, eq=False)
class ThinLog:
    """A chunk of a log without a mask.

    Attributes:
        name: of the log.
        rows: low-pass of the comparison band on the nodes.
        motion: q, qd, qdd at the nodes, (nodes, n) each.
        windows: of the equations; None for torque.
        window_motion: q, qd at the nodes of the windows.
        sides: the equations without W, joint by joint.
        t: of the samples at which torques are compared, (K,) s.
        measured: torque there, (K, n).
        resting: whether a rest of the joint concerns it, (K, n); None where no joint rests.
    """

    name: str
    rows: Decimation
    motion: tuple[FloatArray, FloatArray, FloatArray]
    windows: Windows | None
    window_motion: tuple[FloatArray, FloatArray]
    sides: tuple[Equations, ...]
    t: FloatArray
    measured: FloatArray
    resting: Bools | None = None

    def equations(self, evaluator: Evaluator, recipe: Recipe) -> tuple[Equations, ...]:
        """Return the equations with their W."""
        if self.windows is None:
            rows = compared_torques(evaluator, self.modelled).transpose(1, 0, 2)
        else:
            built = energy_rows if recipe.model == "energy" else momentum_rows
            rows = built(evaluator, *self.window_motion, self.windows, self.rows.step)
        return equated(self.sides, rows)

    def torque(self, evaluator: Evaluator, X: FloatArray) -> FloatArray:
        """Return the torque of a model in the comparison band, (K, n)."""
        inverse = evaluator["inverse_dynamics"]
        found = self.modelled(lambda q, qd, qdd: inverse(q, qd, qdd, X))
        return np.concatenate([torque for _, torque in found])

    def modelled(self, model: Model) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate a model along the log, see `FilteredLog.modelled`."""

        def at(first: int, last: int) -> FloatArray:
            return np.asarray(model(*(x[first:last] for x in self.motion)))

        return self.rows.chunks(at)

    def arrays(self) -> dict[str, Any]:
        """Return all of it as arrays, for `packed_arrays` and `thin_log`."""
        about = {
            "name": self.name,
            "rows": asdict(self.rows),
            "windows": None if self.windows is None else asdict(self.windows),
            "sides": [{key: getattr(e, key) for key in _SIDES} for e in self.sides],
        }
        arrays: dict[str, Any] = {"about": np.array(json.dumps(about))}
        arrays |= {"t": self.t, "measured": self.measured}
        arrays |= dict(zip(_MOTION, self.motion, strict=True))
        if self.windows is not None and self.windows.stride != self.rows.stride:
            arrays |= dict(zip(("wq", "wqd"), self.window_motion, strict=True))
        arrays |= {"sides_t": self.sides[0].t, "y": np.stack([e.y for e in self.sides])}
        if any(e.rest is not None for e in self.sides):
            arrays["rest"] = np.stack([e.scale != 1 for e in self.sides])
        if self.resting is not None:
            arrays["resting"] = self.resting
        return arrays


def packed_arrays(arrays: Mapping[str, Any]) -> bytes:
    """Return arrays as the bytes of an NPZ file."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def thinned(log: FilteredLog, recipe: Recipe) -> ThinLog:
    """Keep of a log without a mask what its equations and torques need.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    stride = log.rows.stride
    motion = (*log.nodes(stride), np.ascontiguousarray(log.qdd[::stride]))
    if recipe.model == "torque":
        w, own, sides = None, motion[:2], torque_sides(log)
    else:
        w = placed_windows(log, recipe.window)
        own = motion[:2] if w.stride == stride else log.nodes(w.stride)
        sides = [energy_sides(log, w)] if recipe.model == "energy" else momentum_sides(log, w)
    t = log.t[log.kept]
    return ThinLog(log.name, log.rows, motion, w, own, tuple(sides), t, log.measured, log.resting)


def thin_log(arrays: Mapping[str, NDArray[Any]]) -> ThinLog:
    """Return the log whose `arrays` these are."""
    about = json.loads(str(arrays["about"]))
    motion = (arrays["q"], arrays["qd"], arrays["qdd"])
    t, name = arrays["sides_t"], about["name"]
    rests = arrays.get("rest", [None] * len(about["sides"]))
    sides = tuple(
        Equations(name, np.zeros((len(t), 0)), y, t, rest=rest, **own)
        for y, rest, own in zip(arrays["y"], rests, about["sides"], strict=True)
    )
    return ThinLog(
        name,
        Decimation(**about["rows"]),
        motion,
        about["windows"] and Windows(**about["windows"]),
        (arrays["wq"], arrays["wqd"]) if "wq" in arrays else motion[:2],
        sides,
        arrays["t"],
        arrays["measured"],
        arrays.get("resting"),
    )


#: Own rows of a chunk, about; those of a partition, the unit of work, that is kept when finished.
CHUNK, PARTITION = 1 << 17, 1 << 20
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
