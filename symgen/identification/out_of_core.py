"""identify on more samples than memory holds: where chunks are worked on, and what is kept.

    files --columns of time--> stretches without gaps --last fifth held out--> parts
    parts --a sample of them--> in memory: band, delay, faults, model, scans, tests, curves
    parts --chunks of rows--> EQUATIONS of each, folded where they are read --> triangle and rows of
          every log and joint --merged--> weights, X
    parts --chunks again--> sums of scores, squared errors of torque --added up--> covariance, fit

What is read whole are summaries: their size does not depend on the number of samples. Where the
sample holds all there is, the estimate is that of logs in memory. The model travels to
workers as the text of its robot file and is compiled once a process, by its content; results travel
as the bytes of an NPZ.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from symgen.codegen.model import derive
from symgen.data.dataset import DataSet, identity, is_data_set, listed_files
from symgen.data.log import Log
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.data.stretch import Stretch
from symgen.data.tables import COUNTED
from symgen.distributed import (
    Executor,
    Say,
    Workers,
    WorkFolder,
    damaged_pieces,
    digest,
    executor,
    finished,
    in_turn,
    keep,
    kept,
)
from symgen.errors import LogError, first_of
from symgen.estimation.chunks import (
    Chunk,
    ChunkData,
    ChunkOfLog,
    LogSpan,
    Partition,
    Settings,
    packed_arrays,
    partitions,
    unpacked_arrays,
    unpacked_chunk,
)
from symgen.estimation.covariance import bartlett, sandwich, scores, widened
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import PASSES, Ols
from symgen.estimation.logs import Source, held_from
from symgen.estimation.misfit import Products, covariances
from symgen.estimation.solve import Solution, condition, log_weights, with_the_others_zero
from symgen.estimation.summary import Summary, merge_summaries, square, summarise_features
from symgen.estimation.torque_error import TorqueFit
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, Fault, merged
from symgen.faults.logs import open_samples, treat_chunk
from symgen.identification.assessment import Outcome, outcome, own_version
from symgen.identification.model_choice import ChosenModel, OpenLogs
from symgen.identification.physical import Consistent
from symgen.identification.solving import Method
from symgen.robot.toml_io import parse_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.schemas import as_json

#: Samples, of all training and of all validation logs, that are looked at in memory; stretches.
SAMPLE, HELD_SAMPLE, PIECES = 80_000, 20_000, 4
#: Samples above which logs are read chunk by chunk.
LONG = 250_000
#: A log has so many windows and samples, at least.
_WINDOWS, _FEWEST = 2.0, 20
#: Of a fit, what adds up over chunks; and the kinds of logs.
FIT_SUMS, KINDS = ("error", "size", "rest"), ("train", "validation")


def is_long(sources: Sequence[Source], plain: bool) -> bool:
    """Whether logs are read chunk by chunk: a data set, or Parquet and NPZ files of many samples.

    Args:
        sources: the logs.
        plain: whether least squares is asked for and nothing that needs all logs in memory.
    """
    if any(map(is_data_set, sources)):
        return True
    paths = [Path(s) for s in sources if isinstance(s, (str, Path))]
    known = [p for p in paths if p.suffix.lower() in COUNTED and p.is_file()]
    if not plain or not known or len(known) < len(sources):
        return False
    return sum(COUNTED[p.suffix.lower()](p) for p in known) > LONG


def _files(sources: Sequence[Source]) -> list[str]:
    """Return the files of some logs.

    Raises:
        LogError: one is in memory.
    """
    for source in sources:
        if isinstance(source, Log):
            raise LogError(f"{source.name}: is in memory; accepted: files for chunks and workers")
    return listed_files([source for source in sources if not isinstance(source, Log)])


def parts_of(
    data: DataSet,
    logs: Sequence[Source],
    validation: Sequence[Source],
    window: float,
    progress: Say,
) -> tuple[list[LogSpan], tuple[str, ...]]:
    """Find the stretches of all files and hold some of them out; say which are too short."""
    files, held_files = _files(logs), _files(validation)
    both = sorted(set(files) & set(held_files))
    if both:
        raise LogError(f"{both[0]}: trains and validates; accepted: another log to validate")
    progress(f"finding the stretches of {len(files) + len(held_files)} files")
    parts: list[LogSpan] = []
    short: list[str] = []
    for name in (*files, *held_files):
        for s in data.stretches(name):
            own = [s] if held_files else _split(s)
            kinds = ("validation",) if name in held_files else KINDS
            if all(x.count >= _FEWEST and x.times[1] - x.times[0] > _WINDOWS * window for x in own):
                parts += map(LogSpan, own, kinds, range(len(parts), len(parts) + 2))
            else:
                short.append(s.name)
    for kind in KINDS:
        if not any(p.kind == kind for p in parts):
            listed = ", ".join(short[:3])
            raise LogError(f"{listed}: too short a {kind} log; accepted: longer ones, without gaps")
    if not short:
        return parts, ()
    return parts, (f"{len(short)} stretches are too short and left out: {first_of(short, 3)}",)


def _split(s: Stretch) -> list[Stretch]:
    """Hold out the last fifth of a stretch."""
    edge = s.rows[0] + held_from(s.count)
    late = s.between(edge, s.rows[1])
    return [s.between(s.rows[0], edge), replace(late, name=f"{s.name} (last fifth)")]


def sampled_spans(parts: Sequence[LogSpan], budget: int) -> list[tuple[Stretch, int, int]]:
    """Return rows of parts that are looked at: all, or pieces evenly over them."""
    own = [p.stretch for p in parts]
    before = np.cumsum([0, *(s.count for s in own)])
    total, length = int(before[-1]), budget // PIECES
    if total <= budget:
        return [(s, *s.rows) for s in own]
    out: dict[tuple[int, int], tuple[Stretch, int, int]] = {}
    for k in range(PIECES):
        place = (k * total) // PIECES
        number = int(np.searchsorted(before, place, side="right")) - 1
        first, last = own[number].rows
        begin = max(min(first + place - int(before[number]), last - length), first)
        out[number, begin] = (own[number], begin, min(begin + length, last))
    return list(out.values())


Reduced = TypeVar("Reduced")


@lru_cache(maxsize=4)
def load_model(robot: str, kernels: tuple[str, ...]) -> Evaluator:
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
        weights: by log and joint the weight of the equations and the rows that scores are summed
            over; empty before X is known.
        clean: whether nothing had to be mended in the first pass.
        threads: that may work on its chunks at once.
        kept: begin of the paths at which the first pass keeps what it read and filtered, chunk by
            chunk; nothing is kept where that folder is not within reach.
    """

    partition: Partition
    weights: Mapping[tuple[int, int], tuple[float, int]]
    clean: bool
    threads: int
    kept: str

    def path(self, chunk: Chunk) -> Path | None:
        """Return where a chunk is kept."""
        path = Path(f"{self.kept}-{chunk.part.number}-{chunk.before + chunk.own[0]}.rows")
        return path if path.parent.is_dir() else None


@dataclass(frozen=True, eq=False)
class Reduction:
    """How partitions are read and treated.

    Attributes:
        robot: text of its robot.toml.
        kernels: of the model.
        reading: how files are read.
        settings: of the run.
        solution: X (p,), and the norms of the weighted columns (p,); none before X is known.
    """

    robot: str
    kernels: tuple[str, ...]
    reading: Reading
    settings: Settings
    solution: tuple[FloatArray, ...] = ()

    @property
    def evaluator(self) -> Evaluator:
        """The compiled model."""
        return load_model(self.robot, self.kernels)

    def reduced(
        self,
        work: Work,
        reduce: Callable[[LogSpan, ChunkOfLog], Reduced],
        chunks: Sequence[Chunk],
    ) -> Iterator[tuple[Reduced, tuple[Fault, ...]]]:
        """Yield what chunks are reduced to, and their repairs."""
        robot = self.evaluator.model.robot

        def one(read: tuple[Chunk, Log]) -> tuple[Reduced, tuple[Fault, ...]]:
            chunk, log = read
            found, repairs = treat_chunk(log, chunk, robot, self.reading, self.settings, work.clean)
            path = work.path(chunk)
            if path is not None and isinstance(found.log, ChunkData):
                keep(path, found.packed())
            return reduce(chunk.part, found), repairs

        def read() -> Iterator[tuple[Chunk, Log]]:
            # A part begins anew where the one before was read to: rows in their order, by part.
            data = DataSet(robot, self.reading)
            for part in dict.fromkeys(chunk.part for chunk in chunks):
                own, s = [c for c in chunks if c.part == part], part.stretch
                yield from zip(own, data.logs(s, [c.rows for c in own]), strict=True)

        return in_turn(one, read(), work.threads)

    def again(
        self,
        work: Work,
        reduce: Callable[[LogSpan, ChunkOfLog], Reduced],
        damaged: list[Chunk],
    ) -> Iterator[Reduced]:
        """Yield what chunks are reduced to, as they were kept or else read anew.

        Args:
            work: the chunks.
            reduce: a chunk, with the log that it belongs to.
            damaged: gets the chunks that were kept, but are not as they were written.
        """
        there, left = list[tuple[Chunk, Path]](), list[Chunk]()
        for chunk in work.partition.chunks:
            path = work.path(chunk)
            if path is None or not path.exists():
                left.append(chunk)
            else:
                there.append((chunk, path))

        def one(item: tuple[Chunk, Path]) -> Reduced | None:
            chunk, path = item
            content = kept(path)
            if content is None:
                damaged.append(chunk)
                return None
            return reduce(chunk.part, unpacked_chunk(content))

        yield from (found for found in in_turn(one, there, work.threads) if found is not None)
        damaged.sort(key=work.partition.chunks.index)  # threads end in any order
        yield from (found for found, _ in self.reduced(work, reduce, [*left, *damaged]))


class EquationReduction(Reduction):
    """Chunks to triangles of their equations."""

    def __call__(self, work: Work) -> bytes:
        """Return summaries by log and joint, and what was mended."""
        found: dict[str, list[Summary]] = {}
        mended: list[Fault] = []

        def summaries(part: LogSpan, chunk: ChunkOfLog) -> list[tuple[str, Summary]]:
            equations = chunk.all_equations(self.evaluator, self.settings.model)
            return [
                (f"{part.number}.{j}", summarise_features(chunk.equations(e)[0]))
                for j, e in enumerate(equations)
            ]

        for own, repairs in self.reduced(work, summaries, work.partition.chunks):
            mended += repairs
            for key, summary in own:
                found.setdefault(key, []).append(summary)
        told = [{**as_json(f), "kind": f.kind} for f in merged(mended)]
        arrays: dict[str, Any] = {_REPAIRS: np.array(json.dumps(told))}
        for key, parts in found.items():
            s = merge_summaries(parts)
            arrays[key], arrays[f"{key}{_FEATURES}"] = square(s.factor), s.features
            joint = -1 if s.joint is None else s.joint
            arrays[f"{key}{_COUNTS}"] = np.array([s.rows, s.correlation, joint])
        return packed_arrays(arrays)


_FOLDED = "folded; band, curves and tests of bias and whiteness are those of"
_REPAIRS, _COUNTS, _FEATURES = "repairs", " rows, correlation, joint", " features"


class ErrorReduction(Reduction):
    """Chunks to what a solution leaves of them."""

    def __call__(self, work: Work) -> bytes:
        """Return the sums of scores, and by kind of log the squared error and size of torque."""
        (X, scale), n = self.solution, self.evaluator.model.robot.n
        model = replace(self.settings.model, features=None)  # scores need none
        meat = np.zeros((len(X), len(X)))
        fits = {kind: TorqueFit.none(n) for kind in KINDS}

        def left(part: LogSpan, chunk: ChunkOfLog) -> tuple[str, TorqueFit, FloatArray]:
            fit, own_meat = chunk.fit(self.evaluator, X), np.zeros_like(meat)
            if part.kind == "train":
                equations = chunk.all_equations(self.evaluator, model)
                for j, e in enumerate(equations):
                    weight, lag = work.weights[part.number, j]
                    rows, lead = chunk.equations(e, lag)
                    s = scores(rows, X, scale, weight)
                    own_meat += bartlett(s, lag, lead, chunk.ended)
            return part.kind, fit, own_meat

        damaged: list[Chunk] = []
        for kind, found, own_meat in self.again(work, left, damaged):
            fits[kind] += found
            meat += own_meat
        sums = {f"{kind}.{key}": getattr(fits[kind], key) for kind in KINDS for key in FIT_SUMS}
        return packed_arrays({"meat": meat, "damaged": np.array(len(damaged)), **sums})


@dataclass(frozen=True)
class Summaries(Sequence[Summary]):
    """The summaries of logs and joints in a work folder, read one at a time.

    Attributes:
        folder: that holds the results.
        places: number of the log, and of the joint, and the results, and arrays in them, that hold
            them.
        kept: places of the columns that are taken; None for all.
    """

    folder: WorkFolder
    places: tuple[tuple[tuple[int, int], tuple[tuple[str, str], ...]], ...]
    kept: Sequence[int] | None = None

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, k: Any) -> Any:
        return merge_summaries([self._read(*place) for place in self.places[k][1]])

    def _read(self, key: str, name: str) -> Summary:
        names = (name, f"{name}{_COUNTS}", f"{name}{_FEATURES}")
        factor, counts, features = unpacked_arrays(self.folder.read(key), names).values()
        rows, correlation, joint = counts.tolist()
        own = Summary(
            factor, rows, correlation, joint=None if joint < 0 else joint, features=features
        )
        return own.columns(self.kept)


@contextmanager
def open_data_set(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    models: Sequence[EquationModel],
    reading: Reading | None,
    workers: Workers | None,
    progress: Say,
) -> Iterator[ChunkedLogs]:
    """Look at a sample of logs of which a chunk at a time is in memory.

    Args:
        robot: whose logs they are.
        logs: files, patterns, folders or URLs.
        validation: others to judge by; without any, the last fifth of every stretch.
        models: one, or more of which the sample chooses.
        reading: how files are read.
        workers: who works, and where summaries are kept until the estimate is there, for runs that
            are interrupted; by default in a folder that is removed.
        progress: is told what is being done.

    Raises:
        LogError: a file cannot be read, or nothing of it can be used.
    """
    window = max(model.gap for model in models)
    sampled = sample_logs(robot, logs, validation, reading, window, progress)
    kernels = tuple(dict.fromkeys(k for model in models for k in model.all_kernels))
    text = robot_toml(robot)
    prefix = "symgen-"
    with tempfile.TemporaryDirectory(prefix=prefix) as fresh, executor(workers) as by:
        by.prepare(partial(load_model, text, kernels))
        folder = WorkFolder(Path((workers and workers.work) or fresh))
        progress("deriving and compiling the model")
        evaluator, given = load_model(text, kernels), bool(validation)
        seen = (evaluator, sampled.train, sampled.held, sampled.repairs, given, progress)
        yield ChunkedLogs(
            *seen, by.threads, sampled=sampled, about=(text, kernels), by=by, folder=folder
        )


@dataclass(frozen=True, eq=False)
class SampledLogs:
    """A data set, and what of it is looked at in memory.

    Attributes:
        data: how it is read.
        parts: all logs.
        notes: in words, on stretches that are left out.
        train, held: pieces of the logs of both kinds.
        repairs: what was mended in them.
    """

    data: DataSet
    parts: Sequence[LogSpan]
    notes: tuple[str, ...]
    train: Sequence[Samples]
    held: Sequence[Samples]
    repairs: tuple[Fault, ...]

    def in_words(self, what: str, logs: Iterable[Any]) -> tuple[str, ...]:
        """Say what rests on the sample; nothing where it is all there is."""
        total, own = sum(p.stretch.count for p in self.parts), [len(log.t) for log in logs]
        if sum(own) >= total:
            return ()
        return (
            f"{total:,} samples in {len(self.parts)} parts were {what} {sum(own):,} of them, in "
            f"{len(own)} pieces",
        )


def sample_logs(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    reading: Reading | None,
    window: float,
    progress: Say,
) -> SampledLogs:
    """Find the stretches of a data set, and open a sample of them.

    Args:
        robot: whose logs they are.
        logs, validation: files, patterns, folders or URLs; without validation, the last fifth of
            every stretch is held out.
        reading: how files are read.
        window: of the equations, s.
        progress: is told what is being done.

    Raises:
        LogError: a file cannot be read, or nothing of it can be used.
    """
    data = DataSet(robot, reading or Reading())
    parts, notes = parts_of(data, logs, validation, window, progress)
    repairs: list[Fault] = []
    train, held = (
        _sample(data, [p for p in parts if p.kind == kind], budget, repairs, progress)
        for kind, budget in zip(KINDS, (SAMPLE, HELD_SAMPLE), strict=True)
    )
    return SampledLogs(data, parts, notes, train, held, tuple(repairs))


def _sample(
    data: DataSet,
    parts: Sequence[LogSpan],
    budget: int,
    repairs: list[Fault],
    progress: Say,
) -> list[Samples]:
    """Open what is looked at in memory of parts of a kind."""
    spans, out = sampled_spans(parts, budget), []
    total = sum(last - first for _, first, last in spans)
    progress(f"looking at {total:,} {parts[0].kind} samples")
    plain = replace(data.reading, start=None, until=None)
    for s, first, last in spans:
        piece = (first, last) != s.rows
        since = f" from {s.times[0] + (first - s.rows[0]) * s.step:.0f} s" if piece else ""
        (log,) = data.logs(s, [(first, last)], s.name + since)
        samples, done = open_samples(log, data.robot, plain, clock=(s.times[0], s.step))
        repairs.extend(done)
        out.append(replace(samples, piece=piece))
    return out


@dataclass(frozen=True, eq=False, kw_only=True)
class ChunkedLogs(OpenLogs):
    """A sample of a data set, with who folds all of it, and where.

    Attributes:
        sampled: the data set.
        about: text of the robot file, and the kernels of the model.
        by: who works on chunks.
        folder: where what is finished is kept.
    """

    sampled: SampledLogs
    about: tuple[str, tuple[str, ...]]
    by: Executor
    folder: WorkFolder

    def solve(self, chosen: ChosenModel, method: Method) -> Outcome:
        """Solve least squares of all chunks: fold, solve, and fold what the solution leaves."""
        run = chosen.run
        settings = Settings(run.band, chosen.model, run.delay)
        cover = partitions(self.sampled.parts, settings)
        shared = (*self.about, self.sampled.data.reading, settings)
        keys = self._fold(EquationReduction(*shared), cover, "equations")
        own, held, repairs, clean = self._merged(keys)
        names = run.evaluator.model.base.names
        kept = list(range(len(names)) if chosen.kept is None else chosen.kept)
        self.progress(f"solving for {len(kept)} parameters")
        whole, own = own, replace(own, kept=chosen.kept)
        shown = tuple(names[k] for k in kept)
        weights, X, scale, R = log_weights(own, shown, 0 if method.name == Ols.name else PASSES)
        weighed = {
            key: (float(w), s.lag) for (key, _), s, w in zip(own.places, own, weights, strict=True)
        }
        every = np.zeros(len(names)), np.ones(len(names))
        every[0][kept], every[1][kept] = X, scale
        total = self._errors(ErrorReduction(*shared, every), cover, weighed, clean, keys)
        inverse = np.linalg.inv(R)
        bread = inverse @ inverse.T / np.outer(scale, scale)
        meat = total["meat"][np.ix_(kept, kept)] * np.outer(scale, scale)
        products = (Products.of_summary(s, w) for s, w in zip(own, weights, strict=True))
        white, misfit = covariances(X, bread, products)
        noise = widened(sandwich(bread, meat, own), white)
        part = Solution(X, noise, misfit, condition(R), tuple(map(float, weights)))
        solution = with_the_others_zero(part, kept, len(names))
        if method.name == Consistent.name:
            solution = Consistent(run.evaluator.model).bounded(solution, names)
            bounded = ErrorReduction(*shared, (solution.X, every[1]))
            total = self._errors(bounded, cover, weighed, clean, keys)
        fits = (
            replace(fit, **{key: total[f"{kind}.{key}"] for key in FIT_SUMS})
            for kind, fit in zip(KINDS, run.torques(solution.X), strict=True)
        )
        return outcome(
            solution,
            chosen.model,
            (whole, held),
            tuple(fits),
            (*repairs, *(r for r in run.repairs if r.log == EVERYWHERE)),
            (*self.sampled.notes, *self.sampled.in_words(_FOLDED, run.logs)),
            (("data set, sha256 of its files and settings", digest(*keys)),),
        )

    def _fold(
        self,
        task: EquationReduction | ErrorReduction,
        cover: Sequence[Partition],
        what: str,
        weights: Mapping[tuple[int, int], tuple[float, int]] | None = None,
        clean: Sequence[bool] = (),
        kept: Sequence[str] = (),
    ) -> list[str]:
        """Have every partition reduced, and return the keys of the results."""
        items, keys = [], []
        solved = [x.tobytes() for x in task.solution]
        settings = digest(task.robot, repr((task.kernels, task.reading, task.settings)), *solved)
        files = {p.file: identity(p.file) for p in cover}
        for k, partition in enumerate(cover):
            own = {chunk.part.number for chunk in partition.chunks}
            mine = {key: w for key, w in (weights or {}).items() if key[0] in own}
            about = repr((partition, mine, own_version()))
            keys.append(digest(what, settings, files[partition.file], about))
            begin = str(self.folder.folder.resolve() / (kept[k] if kept else keys[k]))
            items.append(Work(partition, mine, any(clean[k : k + 1]), self.threads, begin))
        sizes = [partition.samples for partition in cover]
        finished(self.by, task, items, keys, self.folder, sizes, self.progress, what)
        return keys

    def _merged(self, keys: Sequence[str]) -> tuple[Summaries, Summaries, list[Fault], list[bool]]:
        """Return summaries of training and validation logs, repairs, and where there were none."""
        places: dict[tuple[int, int], tuple[tuple[str, str], ...]] = {}
        repairs: list[Fault] = []
        clean = []
        for key in keys:
            arrays = unpacked_arrays(self.folder.read(key))
            mended = [Fault(**told) for told in json.loads(str(arrays.pop(_REPAIRS)))]
            repairs += mended
            clean.append(all(fault.kind == "converted" for fault in mended))
            for name in arrays:
                if not name.endswith((_COUNTS, _FEATURES)):
                    number, j = map(int, name.split("."))
                    places[number, j] = (*places.get((number, j), ()), (key, name))
        train, held = (
            Summaries(
                self.folder,
                tuple(p for p in places.items() if self.sampled.parts[p[0][0]].kind == kind),
            )
            for kind in KINDS
        )
        return train, held, merged(repairs), clean

    def _errors(
        self,
        task: ErrorReduction,
        cover: Sequence[Partition],
        weights: Mapping[tuple[int, int], tuple[float, int]],
        clean: Sequence[bool],
        kept: Sequence[str],
    ) -> dict[str, Any]:
        """Return the sums of scores and errors of torque that a solution leaves."""
        total: dict[str, Any] = {}
        for key in self._fold(task, cover, "errors", weights, clean, kept):
            for name, array in unpacked_arrays(self.folder.read(key)).items():
                total[name] = total.get(name, 0.0) + array
        if total["damaged"]:
            self.progress(damaged_pieces("errors", int(total["damaged"])))
        return total
