"""What a worker does with a partition of a data set: the chunks of it, folded into a few matrices.

First the equations, into triangles by log and joint; then, once X is known, the sums of scores that
its covariance is made of, and the squared error of torque. The model travels as the text of its
robot file and is compiled once a process, by its content; results travel as the bytes of an NPZ.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import derive
from symgen.data.dataset import DataSet
from symgen.data.log import Log
from symgen.data.raw import Reading
from symgen.distributed import WorkFolder, in_turn, keep, kept
from symgen.estimation.covariance import bartlett, scores
from symgen.estimation.fit import TorqueFit
from symgen.estimation.partition import (
    Chunk,
    ChunkOfLog,
    Part,
    Partition,
    Settings,
    unpacked_chunk,
)
from symgen.estimation.summary import Summary, merged_tree, summarised
from symgen.estimation.thin import ThinLog, packed_arrays
from symgen.estimation.values import Residual
from symgen.faults.fault import Fault, merged
from symgen.faults.logs import treated
from symgen.robot.toml_io import parse_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.schemas import as_json

FloatArray = NDArray[np.float64]
Reduced = TypeVar("Reduced")
#: Of a fit, what adds up over chunks.
FIT_SUMS = ("error", "size", "rest")


@lru_cache(maxsize=4)
def loaded(robot: str, kernels: tuple[str, ...]) -> Evaluator:
    """Compile and load a model, once a process.

    Args:
        robot: text of its robot.toml.
        kernels: names of its kernels.
    """
    return load(derive(parse_robot(robot, "robot.toml"), kernels))


@dataclass(frozen=True)
class Work:
    """A partition with what is to be known of it.

    Attributes:
        partition: the chunks.
        parts: the logs that they belong to, by number.
        weights: by log and joint the weight of the equations and the rows that scores are summed
            over; empty before X is known.
        clean: whether nothing had to be mended in the first pass.
        threads: that may work on its chunks at once.
        kept: begin of the paths at which the first pass keeps what it read and filtered, chunk by
            chunk; nothing is kept where that folder is not within reach.
    """

    partition: Partition
    parts: Mapping[int, Part]
    weights: Mapping[tuple[int, int], tuple[float, int]]
    clean: bool = False
    threads: int = 1
    kept: str = ""

    def path(self, chunk: Chunk) -> Path | None:
        """Return where a chunk is kept."""
        folder = Path(self.kept).parent
        if not self.kept or not folder.is_dir():
            return None
        return Path(f"{self.kept}-{chunk.part}-{chunk.before + chunk.own[0]}.rows")


@dataclass(frozen=True)
class Reduction:
    """How partitions are read and treated.

    Attributes:
        robot: text of its robot.toml.
        kernels: of the model.
        reading: how files are read.
        settings: of the run.
    """

    robot: str
    kernels: tuple[str, ...]
    reading: Reading
    settings: Settings

    @property
    def evaluator(self) -> Evaluator:
        """The compiled model."""
        return loaded(self.robot, self.kernels)

    def reduced(
        self, work: Work, reduce: Callable[[int, str, ChunkOfLog], Reduced]
    ) -> Iterator[tuple[Reduced, tuple[Fault, ...]]]:
        """Yield what each chunk is reduced to (by number and kind of its log), and its repairs."""
        robot = self.evaluator.model.robot

        def one(read: tuple[Chunk, Log]) -> tuple[Reduced, tuple[Fault, ...]]:
            chunk, log = read
            part = work.parts[chunk.part]
            found, repairs = treated(
                log, chunk, part.stretch, robot, self.reading, self.settings, work.clean
            )
            path = work.path(chunk)
            if path is not None and isinstance(found.log, ThinLog):
                keep(path, found.packed())
            return reduce(chunk.part, part.kind, found), repairs

        return in_turn(one, self._read(robot, work), work.threads)

    def _read(self, robot: Robot, work: Work) -> Iterator[tuple[Chunk, Log]]:
        data, chunks = DataSet(robot, self.reading), work.partition.chunks
        # A part begins anew where the one before was read to: rows in their order, part by part.
        for number in dict.fromkeys(chunk.part for chunk in chunks):
            own, part = [c for c in chunks if c.part == number], work.parts[number]
            logs = data.logs(part.stretch.file, [c.rows for c in own], part.stretch.name)
            yield from zip(own, logs, strict=True)

    def again(
        self,
        work: Work,
        reduce: Callable[[int, str, ChunkOfLog], Reduced],
        damaged: list[Chunk],
    ) -> Iterator[Reduced]:
        """Yield what chunks are reduced to, as they were kept or else read anew.

        Args:
            work: the chunks.
            reduce: a chunk, by number and kind of its log.
            damaged: gets the chunks that were kept, but are not as they were written.
        """
        there, left = list[tuple[Chunk, Path]](), list[Chunk]()
        for chunk in work.partition.chunks:
            path = work.path(chunk)
            if path is None or not path.exists():
                left.append(chunk)
            else:
                there.append((chunk, path))

        def one(item: tuple[Chunk, Path]) -> tuple[Chunk, Reduced | None]:
            chunk, path = item
            content = kept(path)
            if content is None:
                return chunk, None
            with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                found = unpacked_chunk(arrays)
            return chunk, reduce(chunk.part, work.parts[chunk.part].kind, found)

        for chunk, reduced in in_turn(one, there, work.threads):
            if reduced is None:
                damaged.append(chunk)
            else:
                yield reduced
        left += damaged
        partition = replace(work.partition, chunks=tuple(left))
        for part, _ in self.reduced(replace(work, partition=partition), reduce):
            yield part


@dataclass(frozen=True)
class EquationReduction(Reduction):
    """Chunks to triangles of their equations."""

    def __call__(self, work: Work) -> bytes:
        """Return summaries by log and joint."""
        found: dict[tuple[int, int], list[Summary]] = {}
        mended: list[Fault] = []

        def summaries(number: int, _: str, chunk: ChunkOfLog) -> dict[tuple[int, int], Summary]:
            equations = chunk.all_equations(self.evaluator, self.settings.recipe)
            return {(number, j): summarised(chunk.equations(e)) for j, e in enumerate(equations)}

        for own, repairs in self.reduced(work, summaries):
            mended += repairs
            for key, summary in own.items():
                found.setdefault(key, []).append(summary)
        arrays: dict[str, Any] = {"repairs": np.array(_told(mended))}
        for (number, j), parts in found.items():
            whole = merged_tree(parts)
            arrays[f"{number}.{j}"] = whole.factor
            arrays[f"{number}.{j}.count"] = np.array([whole.rows, whole.correlation])
        return packed_arrays(arrays)


@dataclass(frozen=True, eq=False)
class ErrorReduction(Reduction):
    """Chunks to what a solution leaves of them.

    Attributes:
        X: the solution.
        scale: norms of the weighted columns.
    """

    X: FloatArray
    scale: FloatArray

    def __call__(self, work: Work) -> bytes:
        """Return the sums of scores, and by kind of log the squared error and size of torque."""
        p, n = len(self.X), self.evaluator.model.robot.n
        meat = np.zeros((p, p))
        fits = {kind: TorqueFit.none(n) for kind in ("train", "validation")}

        def left(number: int, kind: str, chunk: ChunkOfLog) -> tuple[str, TorqueFit, FloatArray]:
            fit, own_meat = chunk.fit(self.evaluator, self.X), np.zeros((p, p))
            if kind == "train":
                equations = chunk.all_equations(self.evaluator, self.settings.recipe)
                for j, e in enumerate(equations):
                    weight, lag = work.weights[number, j]
                    rows, lead = chunk.with_lead(e, lag)
                    s = scores(rows, self.X, self.scale, weight)
                    own_meat += bartlett(s, lag, lead, chunk.ended)
            return kind, fit, own_meat

        damaged: list[Chunk] = []
        for kind, fit, own_meat in self.again(work, left, damaged):
            fits[kind] += fit
            meat += own_meat
        sums = {
            f"{kind}.{key}": getattr(fit, key) for kind, fit in fits.items() for key in FIT_SUMS
        }
        return packed_arrays({"meat": meat, "damaged": np.array(len(damaged)), **sums})


def unpacked(folder: WorkFolder, key: str) -> dict[str, Any]:
    """Return the arrays of a result."""
    with np.load(io.BytesIO(folder.read(key)), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def _told(faults: Iterable[Fault]) -> str:
    return json.dumps([{**as_json(f), "kind": f.kind} for f in merged(faults)])


def read_repairs(arrays: Mapping[str, Any]) -> list[Fault]:
    """Return what was mended in a partition."""
    return [Fault(**told) for told in json.loads(str(arrays["repairs"]))]


class Summaries(Sequence[Summary]):
    """The summaries of logs and joints in a work folder, read one at a time."""

    def __init__(self, folder: WorkFolder, places: Mapping[tuple[int, int], Sequence[str]]) -> None:
        """Take the keys of the results that hold each log and joint."""
        self._folder = folder
        self.names = tuple(places)
        self._places = tuple(places.values())

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, k: Any) -> Any:
        number, j = self.names[k]
        parts = []
        for key in self._places[k]:
            content = io.BytesIO(self._folder.read(key))
            with np.load(content, allow_pickle=False) as archive:
                rows, correlation = archive[f"{number}.{j}.count"]
                parts.append(Summary(archive[f"{number}.{j}"], int(rows), int(correlation)))
        return merged_tree(parts)


class Chosen(Sequence[Summary]):
    """Some of the summaries."""

    def __init__(self, whole: Summaries, chosen: Sequence[int]) -> None:
        """Take the numbers of those that count."""
        self._whole, self._chosen = whole, list(chosen)

    def __len__(self) -> int:
        return len(self._chosen)

    def __getitem__(self, k: int) -> Summary:  # type: ignore[override]
        found: Summary = self._whole[self._chosen[k]]
        return found

    def residual(self, X: FloatArray, by_joint: bool) -> Residual:
        """Return ||y - W X|| / ||y||, in all and by joint."""
        errors: dict[int, float] = {}
        sizes: dict[int, float] = {}
        for k in self._chosen:
            s, j = self._whole[k], self._whole.names[k][1]
            errors[j] = errors.get(j, 0.0) + s.rss(X)
            sizes[j] = sizes.get(j, 0.0) + s.square
        each = tuple(float(np.sqrt(errors[j] / max(sizes[j], 1e-300))) for j in sorted(sizes))
        whole = float(np.sqrt(sum(errors.values()) / max(sum(sizes.values()), 1e-300)))
        return Residual(whole, each if by_joint else None)
