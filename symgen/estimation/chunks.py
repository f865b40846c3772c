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
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.features import with_features
from symgen.estimation.filtered_log import FilteredLog, stride_of
from symgen.estimation.summary import LAGS
from symgen.estimation.system import (
    SIDES,
    Equations,
    Model,
    compared_torques,
    equated,
    torque_sides,
)
from symgen.estimation.torque_error import TorqueFit, modelled_torque, squares
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import Windows, place_windows, windows
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class ChunkData:
    """What the equations and torques of a chunk without a mask need: little of what was read.

    Attributes:
        name: of the log.
        rows: low-pass of the comparison band on the nodes.
        windows: of the equations; None for torque.
        sides: joint, correlation and weight at rest of the equations, joint by joint.
        arrays: q, qd, qdd (nodes, n) at the nodes; window_q, window_qd at those of the windows,
            where they are others; end (K,) s, y and rest (joints, K) of the equations; t (k,) s,
            measured and resting (k, n) where torques are compared.
    """

    name: str
    rows: Decimation
    windows: Windows | None
    sides: tuple[Mapping[str, Any], ...]
    arrays: Mapping[str, NDArray[Any]]

    @property
    def compared_t(self) -> FloatArray:
        """Times at which torques are compared, (k,) s."""
        return self.arrays["t"]

    @property
    def measured(self) -> FloatArray:
        """Measured torque there, (k, n)."""
        return self.arrays["measured"]

    @property
    def resting(self) -> Bools | None:
        """Whether a rest of the joint concerns it, (k, n); None where no joint rests."""
        return self.arrays.get("resting")

    @property
    def free(self) -> Bools:
        """Whether it counts, (k, n): nothing is masked."""
        return np.ones(self.measured.shape, dtype=bool)

    def equations(self, evaluator: Evaluator, model: EquationModel) -> tuple[Equations, ...]:
        """Return the equations with their W."""
        a, none = self.arrays, np.zeros((len(self.arrays["end"]), 0))
        rests = a.get("rest", [None] * len(self.sides))
        sides = [
            Equations(self.name, none, y, a["end"], rest=rest, **own)
            for y, rest, own in zip(a["y"], rests, self.sides, strict=True)
        ]
        known = model.features
        if self.windows is None:
            W = compared_torques(evaluator, self.modelled).transpose(1, 0, 2)
            features = None if known is None else known.in_band(self.modelled)
        else:
            motion = (a.get("window_q", a["q"]), a.get("window_qd", a["qd"]))
            about = *motion, self.windows, self.rows.step
            _, rows = SIDES[model.name]
            W = rows(evaluator, *about)
            features = None if known is None else known.over_windows(model.name, *about)
        found = equated(sides, W)
        return found if features is None else with_features(found, features, a["end"])

    def modelled(self, model: Model) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate a model along the log, see `FilteredLog.modelled`."""
        motion = [self.arrays[key] for key in ("q", "qd", "qdd")]
        return self.rows.chunks(lambda first, last: model(*(x[first:last] for x in motion)))


def chunk_data(log: FilteredLog, model: EquationModel) -> ChunkData:
    """Keep of a log without a mask what its equations and torques need.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    q, qd = log.nodes(log.stride)
    arrays: dict[str, NDArray[Any]] = {
        "q": q,
        "qd": qd,
        "qdd": np.ascontiguousarray(log.qdd[:: log.stride]),
    }
    if model.name == "torque":
        w, sides = None, torque_sides(log)
    else:
        w = place_windows(log, model.window)
        sides = SIDES[model.name][0](log, w)
        if w.stride != log.stride:
            arrays["window_q"], arrays["window_qd"] = log.nodes(w.stride)
    arrays |= {"end": sides[0].t, "y": np.stack([e.y for e in sides])}
    arrays |= {"t": log.compared_t, "measured": log.measured}
    if any(e.rest is not None for e in sides):
        arrays["rest"] = np.stack([e.scale != 1 for e in sides])
    if log.resting is not None:
        arrays["resting"] = log.resting
    told = ("joint", "correlation", "rest_weight")
    about = tuple({key: getattr(e, key) for key in told} for e in sides)
    return ChunkData(log.name, log.rows, w, about, arrays)


def packed_arrays(arrays: Mapping[str, Any]) -> bytes:
    """Return arrays as the bytes of an NPZ file."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def unpacked_arrays(content: bytes, names: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
    """Return the arrays of an NPZ file, all of them or those of some names."""
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return {name: archive[name] for name in names or archive.files}


#: Own rows of a chunk, about; those of a partition, the unit of work, that is kept when finished.
CHUNK, PARTITION = 1 << 17, 1 << 20
_SPLINE = 128  # samples that a derivative reaches, twice over
_SLOPES_HZ = 10.0  # of the low-pass that derives a missing speed


@dataclass(frozen=True)
class LogSpan:
    """One log of the run: a stretch, or the part of it that trains or is held out.

    Attributes:
        stretch: its rows alone.
        kind: "train" or "validation".
        number: in the run.
    """

    stretch: Stretch
    kind: str
    number: int


@dataclass(frozen=True)
class Chunk:
    """Some rows of a log of the run.

    Attributes:
        part: the log.
        rows: that are read: first, and the one behind the last.
        before: rows of the part before these.
        own: first row of its own among these, and the one behind the last: equations at the times
            in between count.
        ended: whether the part ends with it.
    """

    part: LogSpan
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
        model: of the equations.
        delay: by which torques are late, s.
    """

    band: Band
    model: EquationModel
    delay: float = 0.0


def unit(step: float, settings: Settings) -> int:
    """Return the samples of which chunks begin at multiples."""
    stride, every, own = _strides(step, settings)
    return math.lcm(stride, every, own.stride * own.hop if own else 1)


def _strides(step: float, settings: Settings) -> tuple[int, int, Windows | None]:
    """Return samples from node to node and from one kept to the next, and windows but of torque."""
    stride, model = stride_of(settings.band, step), settings.model
    every = decimation(1 << 30, step, stride, settings.band.comparison_hz).every
    return stride, every, None if model.name == "torque" else windows(step, stride, model.window)


def reach(step: float, settings: Settings, measured: bool) -> int:
    """Return the samples beyond its own that a chunk needs on either side.

    Args:
        step: of the log, s.
        settings: of the run.
        measured: whether the log has speeds.
    """
    band, (_, every, own) = settings.band, _strides(step, settings)

    def tail(hz: float) -> int:
        return math.ceil(TAIL / (hz * step))

    # one after the other: a missing speed, positions, slopes
    motion = tail(band.cutoff_hz) + 2 * _SPLINE + (0 if measured else tail(_SLOPES_HZ))
    compared = tail(band.comparison_hz)
    if own is None:
        return motion + compared + LAGS * 2 * every
    return motion + max(compared, own.stride * (2 * own.steps + LAGS * own.steps + own.hop))


def partitions(
    parts: Sequence[LogSpan], settings: Settings, chunk: int = CHUNK, most: int = PARTITION
) -> list[Partition]:
    """Cut the parts of a run into chunks, and gather these into partitions.

    Args:
        parts: in the order of their files.
        settings: that tell how far a chunk reaches.
        chunk: own rows of a chunk, about.
        most: own rows of a partition, about.
    """
    out: list[Partition] = []
    for part in parts:
        for piece in _chunks(part, settings, chunk):
            last = out[-1] if out else None
            if last is not None and last.file == part.stretch.file and last.samples < most:
                out[-1] = replace(last, chunks=(*last.chunks, piece))
            else:
                out.append(Partition(part.stretch.file, (piece,)))
    return out


def _chunks(part: LogSpan, settings: Settings, chunk: int) -> list[Chunk]:
    s = part.stretch
    multiple, beyond = unit(s.step, settings), reach(s.step, settings, s.measured)
    length = max(chunk // multiple, 1) * multiple
    edges = [*range(0, max(s.count - length // 2, 1), length), s.count]
    out = []
    for begin, end in pairwise(edges):
        low = max(begin - beyond, 0) // multiple * multiple
        high = min(end + beyond, s.count)
        rows = (s.rows[0] + low, s.rows[0] + high)
        out.append(Chunk(part, rows, low, (begin - low, end - low), end == s.count))
    return out


@dataclass(frozen=True, eq=False)
class ChunkOfLog:
    """A chunk in the band of the run.

    Attributes:
        log: all its rows, or where nothing is masked what their equations need.
        own: times of what counts, s.
        ended: whether the part ends with it.
    """

    log: FilteredLog | ChunkData
    own: tuple[float, float]
    ended: bool

    def all_equations(self, evaluator: Evaluator, model: EquationModel) -> tuple[Equations, ...]:
        """Return its equations, those of others that it reaches into with them."""
        if isinstance(self.log, ChunkData):
            return self.log.equations(evaluator, model)
        return model.equations(evaluator, self.log)

    def equations(self, e: Equations, lag: int = 1) -> tuple[Equations, int]:
        """Return its own equations and up to `lag` - 1 before them, and how many these are."""
        first, last = map(int, np.searchsorted(e.t, self.own))
        lead = min(lag - 1, first) if last > first else 0
        return e.where(slice(first - lead, last), e.name), lead

    def fit(self, evaluator: Evaluator, X: FloatArray) -> TorqueFit:
        """Compare its own torques with those of a model, without traces."""
        log = self.log
        own = (log.compared_t >= self.own[0]) & (log.compared_t < self.own[1])
        torque = modelled_torque(evaluator, log, X)
        return squares(log.free & own[:, None], log.measured, torque, log.resting)

    def packed(self) -> bytes:
        """Return the bytes of an NPZ file, of a chunk without a mask."""
        log = self.log
        assert isinstance(log, ChunkData)
        windows = log.windows and asdict(log.windows)
        about = json.dumps([log.name, asdict(log.rows), windows, log.sides, self.own, self.ended])
        return packed_arrays({**log.arrays, "about": np.array(about)})


def unpacked_chunk(content: bytes) -> ChunkOfLog:
    """Return the chunk whose `packed` some bytes are."""
    arrays = unpacked_arrays(content)
    name, rows, windows, sides, own, ended = json.loads(str(arrays.pop("about")))
    placed = windows and Windows(**windows)
    log = ChunkData(name, Decimation(**rows), placed, tuple(sides), arrays)
    return ChunkOfLog(log, tuple(own), ended)
