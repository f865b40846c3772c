"""identify on more samples than memory holds: the same estimate, by folds over chunks.

    files --columns of time--> stretches without gaps --last fifth held out--> parts
    parts --a sample of them--> in memory: band, delay, faults, model, scans, tests, curves
    parts --chunks of rows--> EQUATIONS of each, folded where they are read --> triangle and rows of
          every log and joint --merged--> weights, X
    parts --chunks again--> sums of scores, squared errors of torque --added up--> covariance, fit
    X, covariance, fit, and the sample --> `judged`, as in memory --> Estimate

What is read whole are summaries: their size does not depend on the number of samples. Where the
sample holds all there is, the estimate is that of `identify` in memory. The model travels to
workers as the text of its robot file and is compiled once a process, by its content; results travel
as the bytes of an NPZ.
"""

from __future__ import annotations

import io
import json
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
    WorkFolder,
    damaged_pieces,
    digest,
    finished,
    in_turn,
    keep,
    kept,
)
from symgen.errors import IdentificationError, LogError
from symgen.estimation.chunks import (
    Chunk,
    ChunkOfLog,
    Part,
    Partition,
    Settings,
    ThinLog,
    packed_arrays,
    partitions,
    unpacked_chunk,
)
from symgen.estimation.covariance import bartlett, sandwich, scores
from symgen.estimation.equation_model import Recipe
from symgen.estimation.estimators import PASSES, bias_of_least_squares
from symgen.estimation.logs import HELD_OUT, Source
from symgen.estimation.solve import Solution, condition, log_weights
from symgen.estimation.summary import Summary, merged_tree, summarised
from symgen.estimation.torque_error import TorqueFit, fit, relative_error
from symgen.estimation.values import FloatArray, Residual
from symgen.faults.fault import Fault, merged
from symgen.faults.logs import open_samples, treated
from symgen.identification.assessment import Outcome, judged, own_version
from symgen.identification.estimate import Estimate
from symgen.identification.model_choice import (
    Case,
    Run,
    checked_run,
    chosen_case,
    determined,
    looked_at,
    require_condition,
)
from symgen.identification.solving import FOLDED, Method
from symgen.robot.toml_io import parse_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.schemas import as_json

Progress = Callable[[str], None]
#: Samples, of all training and of all validation logs, that are looked at in memory; stretches.
SAMPLE, HELD_SAMPLE, PIECES = 80_000, 20_000, 4
#: Samples from which logs are read chunk by chunk, and bytes under which no file has so many.
LONG, _LIGHT = 250_000, 4 << 20
#: A log has so many windows and samples, at least.
_WINDOWS, _FEWEST = 2.0, 20


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
    if sum(p.stat().st_size for p in known) < _LIGHT:
        return False
    return sum(COUNTED[p.suffix.lower()](p) for p in known) > LONG


def paths_of(sources: Sequence[Source]) -> list[str | Path]:
    """Return logs as paths.

    Raises:
        LogError: one is in memory.
    """
    for source in sources:
        if isinstance(source, Log):
            raise LogError(f"{source.name}: is in memory; accepted: files for chunks and workers")
    return [source for source in sources if not isinstance(source, Log)]


def parts_of(
    data: DataSet,
    logs: Sequence[str | Path],
    validation: Sequence[str | Path],
    recipes: Sequence[Recipe],
    progress: Progress,
) -> tuple[list[Part], tuple[str, ...]]:
    """Find the stretches of all files and hold some of them out; say which are too short."""
    files, held_files = listed_files(logs), listed_files(validation)
    both = sorted(set(files) & set(held_files))
    if both:
        raise LogError(f"{both[0]}: trains and validates; accepted: another log to validate")
    progress(f"finding the stretches of {len(files) + len(held_files)} files")
    window = max(recipe.gap for recipe in recipes)
    out: list[Part] = []
    short: list[str] = []
    for name in (*files, *held_files):
        for s in data.stretches(name):
            kinds = _split(s) if not held_files else [(s, "train")]
            if name in held_files:
                kinds = [(s, "validation")]
            if all(_long(own, window) for own, _ in kinds):
                out += [Part(own, kind) for own, kind in kinds]
            else:
                short.append(s.name)
    for kind in ("train", "validation"):
        if not any(p.kind == kind for p in out):
            listed = ", ".join(short[:3])
            raise LogError(f"{listed}: too short a {kind} log; accepted: longer ones, without gaps")
    if not short:
        return out, ()
    listed = ", ".join(short[:3]) + (", ..." if len(short) > 3 else "")
    return out, (f"{len(short)} stretches are too short and left out: {listed}",)


def _long(s: Stretch, window: float) -> bool:
    return s.count >= _FEWEST and s.times[1] - s.times[0] > _WINDOWS * window


def _split(s: Stretch) -> list[tuple[Stretch, str]]:
    """Hold out the last fifth of a stretch."""
    count = int(s.count * (1 - HELD_OUT))
    edge = s.rows[0] + count
    at = s.times[0] + s.step * count
    early = replace(s, rows=(s.rows[0], edge), times=(s.times[0], at - s.step))
    late = replace(s, name=f"{s.name} (last fifth)", rows=(edge, s.rows[1]), times=(at, s.times[1]))
    return [(early, "train"), (late, "validation")]


def sampled_spans(parts: Sequence[Part], kind: str, budget: int) -> list[tuple[Part, int, int]]:
    """Return rows of the parts of a kind that are looked at: all, or pieces evenly over them."""
    own = [p for p in parts if p.kind == kind]
    counts = np.array([p.stretch.count for p in own])
    total = int(counts.sum())
    if total <= budget:
        return [(p, *p.stretch.rows) for p in own]
    before, length = np.concatenate([[0], np.cumsum(counts)]), budget // PIECES
    out: dict[tuple[int, int], tuple[Part, int, int]] = {}
    for k in range(PIECES):
        place = (k * total) // PIECES
        number = int(np.searchsorted(before, place, side="right")) - 1
        first, last = own[number].stretch.rows
        begin = max(min(first + place - int(before[number]), last - length), first)
        out[number, begin] = (own[number], begin, min(begin + length, last))
    return list(out.values())


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
        for kind, found, own_meat in self.again(work, left, damaged):
            fits[kind] += found
            meat += own_meat
        sums = {
            f"{kind}.{key}": getattr(fit, key) for kind, fit in fits.items() for key in FIT_SUMS
        }
        return packed_arrays({"meat": meat, "damaged": np.array(len(damaged)), **sums})


def unpacked(folder: WorkFolder, key: str, *names: str) -> dict[str, Any]:
    """Return the arrays of a result: some of them, or all."""
    with np.load(io.BytesIO(folder.read(key)), allow_pickle=False) as archive:
        return {name: archive[name] for name in names or archive.files}


def _told(faults: Iterable[Fault]) -> str:
    return json.dumps([{**as_json(f), "kind": f.kind} for f in merged(faults)])


def read_repairs(arrays: Mapping[str, Any]) -> list[Fault]:
    """Return what was mended in a partition."""
    return [Fault(**told) for told in json.loads(str(arrays["repairs"]))]


@dataclass(frozen=True)
class Summaries(Sequence[Summary]):
    """The summaries of logs and joints in a work folder, read one at a time.

    Attributes:
        folder: that holds the results.
        places: number of the log, and of the joint, and the keys of the results that hold them.
    """

    folder: WorkFolder
    places: tuple[tuple[tuple[int, int], tuple[str, ...]], ...]

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, k: Any) -> Any:
        (number, j), keys = self.places[k]
        parts = []
        for key in keys:
            arrays = unpacked(self.folder, key, f"{number}.{j}", f"{number}.{j}.count")
            factor, count = arrays.values()
            parts.append(Summary(factor, *map(int, count)))
        return merged_tree(parts)

    def residual(self, X: FloatArray, by_joint: bool) -> Residual:
        """Return ||y - W X|| / ||y||, in all and by joint."""
        joints = [j for (_, j), _ in self.places]
        sums = np.zeros((2, 1 + max(joints)))
        for j, s in zip(joints, self, strict=True):
            sums[:, j] += s.rss(X), s.square
        return relative_error(sums[0], sums[1], by_joint)


def identify_data_set(
    robot: Robot,
    logs: Sequence[str | Path],
    validation: Sequence[str | Path],
    recipes: Sequence[Recipe],
    method: Method,
    *,
    by: Executor,
    cutoff: float | None = None,
    reading: Reading | None = None,
    work: Path | None = None,
    progress: Progress = lambda _: None,
) -> Estimate:
    """Identify from logs of which a chunk at a time is in memory.

    Args:
        robot: whose logs they are.
        logs: files, patterns, folders or URLs.
        validation: others to judge by; without any, the last fifth of every stretch.
        recipes: of the models: one, or more of which the sample chooses.
        method: wls or ols.
        by: who works.
        cutoff: of the filter, Hz, where it is given.
        reading: how files are read.
        work: where summaries are kept until the estimate is there, for runs that are interrupted;
            None for a folder that is removed.
        progress: is told what is being done.

    Raises:
        LogError: a file cannot be read, or nothing of it can be used.
        IdentificationError: the data do not determine the parameters, or another method is asked.
    """
    if not method.plain:
        raise IdentificationError(
            f"method {method.label} on a data set; accepted: {', '.join(FOLDED)}, or logs that "
            "fit into memory"
        )
    if robot.loaded:
        raise IdentificationError(
            "the robot has effects that hold the torque of its links; accepted: logs that fit into "
            "memory"
        )
    reading = reading or Reading()
    data = DataSet(robot, reading)
    parts, notes = parts_of(data, logs, validation, recipes, progress)
    folder = Path(tempfile.mkdtemp(prefix="symgen-")) if work is None else work
    try:
        run = _Streamed(data, parts, bool(validation), method, by, WorkFolder(folder), progress)
        return run.estimate(recipes, cutoff, notes)
    finally:
        if work is None:
            shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True, eq=False)
class _Streamed:
    """A data set, who folds it, and where."""

    data: DataSet
    parts: list[Part]
    given: bool
    method: Method
    by: Executor
    folder: WorkFolder
    progress: Progress

    def estimate(
        self, recipes: Sequence[Recipe], cutoff: float | None, notes: tuple[str, ...]
    ) -> Estimate:
        """Look, fold, solve, fold again, and judge."""
        kernels = tuple(dict.fromkeys(k for recipe in recipes for k in recipe.all_kernels))
        text = robot_toml(self.data.robot)
        self.by.prepare(partial(loaded, text, kernels))
        run, faults, delay = self._look(text, kernels, cutoff)
        case = chosen_case(run, recipes, self.method, [1.0] * len(run.train), (), self.progress)
        settings = Settings(run.band, case.recipe, delay)
        cover = partitions(self.parts, settings)
        shared = (text, kernels, self.data.reading, settings)
        first = EquationReduction(*shared)
        keys = self._fold(first, cover, {}, "equations", "")
        own, held, repairs, clean = self._merged(cover, keys)
        names = run.evaluator.model.base.names
        self.progress(f"solving for {len(names)} parameters")
        passes = PASSES if self.method.name == "wls" else 0
        with determined(case.fault):
            weights, X, scale, R = log_weights(own, names, passes)
        weighed = {
            key: (float(w), s.lag) for (key, _), s, w in zip(own.places, own, weights, strict=True)
        }
        second = ErrorReduction(*shared, X, scale)
        solved = digest(X.tobytes(), scale.tobytes(), repr(sorted(weighed.items())))
        errors = self._fold(second, cover, weighed, "errors", solved, clean, keys)
        meat, fits = self._added(errors)
        inverse = np.linalg.inv(R)
        covariance = sandwich(inverse @ inverse.T, meat, own) / np.outer(scale, scale)
        solution = Solution(X, covariance, condition(R), tuple(map(float, weights)))
        require_condition(solution, case.fault)
        solution, bias = bias_of_least_squares(case.system, solution)
        self.progress("judging")
        known = self._outcome(case, X, own, held, fits)
        whole = (*repairs, *(r for r in run.repairs if r.log == "all logs"))  # found in the sample
        found = tuple(
            replace(
                a,
                condition_number=solution.condition_number,
                train=known.own.residual,
                validation=known.seen.residual,
            )
            if a.chosen and self.method.name == "wls"
            else a
            for a in case.found
        )
        case = replace(case, run=replace(run, repairs=whole), found=found)
        estimate = judged(case, self.method, solution, bias, faults, known)
        data = ("data set, sha256 of its files and settings", digest(*keys))
        return replace(
            estimate,
            notes=(*estimate.notes, *notes, *self._said(run)),
            provenance=(*estimate.provenance, data),
        )

    def _said(self, run: Run) -> tuple[str, ...]:
        """Say what rests on a sample."""
        total = sum(p.stretch.count for p in self.parts)
        seen = sum(len(log.t) for log in run.logs)
        if seen >= total:
            return ()
        return (
            f"{total:,} samples in {len(self.parts)} parts were folded; band, curves, scans of "
            f"windows and tests of bias and whiteness are those of {seen:,} of them, in "
            f"{len(run.logs)} pieces",
        )

    def _look(
        self, text: str, kernels: tuple[str, ...], cutoff: float | None
    ) -> tuple[Run, tuple[str, ...], float]:
        """Choose the band from a sample of the logs, in memory; find faults of channels in it."""
        robot, repairs = self.data.robot, list[Fault]()

        def read(kind: str, budget: int) -> list[Samples]:
            out = []
            spans = sampled_spans(self.parts, kind, budget)
            self.progress(f"looking at {sum(b - a for _, a, b in spans):,} {kind} samples")
            for part, first, last in spans:
                s = part.stretch
                label = s.name
                if (first, last) != s.rows:
                    label += f" from {s.times[0] + (first - s.rows[0]) * s.step:.0f} s"
                (log,) = self.data.logs(s.file, [(first, last)], label)
                plain = replace(self.data.reading, start=None, until=None)
                samples, done = open_samples(log, robot, plain, clock=(s.times[0], s.step))
                repairs.extend(done)
                out.append(replace(samples, piece=(first, last) != s.rows))
            return out

        train, held = read("train", SAMPLE), read("validation", HELD_SAMPLE)
        self.progress("deriving and compiling the model")
        evaluator = loaded(text, kernels)
        about = (evaluator, train, held, repairs, self.given, cutoff, self.progress)
        return checked_run(looked_at(*about, threads=self.by.threads))

    def _fold(
        self,
        task: EquationReduction | ErrorReduction,
        cover: Sequence[Partition],
        weights: Mapping[tuple[int, int], tuple[float, int]],
        what: str,
        solved: str,
        clean: Sequence[bool] = (),
        kept: Sequence[str] = (),
    ) -> list[str]:
        """Have every partition reduced, and return the keys of the results."""
        items, keys = [], []
        settings = digest(task.robot, repr((task.kernels, task.reading, task.settings)), solved)
        files = {p.file: identity(p.file) for p in cover}
        for k, partition in enumerate(cover):
            numbers = dict.fromkeys(chunk.part for chunk in partition.chunks)
            own = {number: self.parts[number] for number in numbers}
            mine = {key: w for key, w in weights.items() if key[0] in own}
            about = repr((partition, sorted(own.items()), own_version()))
            keys.append(digest(what, settings, files[partition.file], about))
            begin = str(self.folder.folder.resolve() / (kept[k] if kept else keys[k]))
            once = bool(clean) and clean[k]
            items.append(Work(partition, own, mine, once, self.by.threads, begin))
        sizes = [partition.samples for partition in cover]
        finished(self.by, task, items, keys, self.folder, sizes, self.progress, what)
        return keys

    def _merged(
        self, cover: Sequence[Partition], keys: Sequence[str]
    ) -> tuple[Summaries, Summaries, list[Fault], list[bool]]:
        """Return summaries of training and validation logs, repairs, and where there were none."""
        places: dict[tuple[int, int], tuple[str, ...]] = {}
        repairs: list[Fault] = []
        clean = []
        for partition, key in zip(cover, keys, strict=True):
            arrays = unpacked(self.folder, key)
            mended = read_repairs(arrays)
            repairs += mended
            clean.append(not mended)
            for number in dict.fromkeys(chunk.part for chunk in partition.chunks):
                j = 0
                while f"{number}.{j}" in arrays:
                    places[number, j] = (*places.get((number, j), ()), key)
                    j += 1
        train, held = (
            Summaries(
                self.folder,
                tuple(p for p in places.items() if self.parts[p[0][0]].kind == kind),
            )
            for kind in ("train", "validation")
        )
        return train, held, merged(repairs), clean

    def _added(self, keys: Sequence[str]) -> tuple[FloatArray, dict[str, TorqueFit]]:
        """Add up sums of scores and errors of torque."""
        first = unpacked(self.folder, keys[0])
        total = {name: np.zeros_like(array) for name, array in first.items()}
        for key in keys:
            for name, array in unpacked(self.folder, key).items():
                total[name] += array
        if total["damaged"]:
            self.progress(damaged_pieces("errors", int(total["damaged"])))
        return total["meat"], {
            kind: TorqueFit(traces=(), **{key: total[f"{kind}.{key}"] for key in FIT_SUMS})
            for kind in ("train", "validation")
        }

    def _outcome(
        self,
        case: Case,
        X: FloatArray,
        own: Summaries,
        held: Summaries,
        fits: Mapping[str, TorqueFit],
    ) -> Outcome:
        """Return how X fits all equations and torques; curves are those of the sample."""
        run = case.run
        traces = [fit(run.evaluator, run.train, X, "train").traces]
        traces += [fit(run.evaluator, run.held, X).traces]
        train, seen = (
            replace(fits[kind], traces=drawn)
            for kind, drawn in zip(("train", "validation"), traces, strict=True)
        )
        windows, model = sum(s.rows / s.correlation for s in own), case.recipe.model
        if model == "torque":
            return Outcome(train.residual, seen.residual, train, seen, windows)
        by_joint = model != "energy"
        residuals = (own.residual(X, by_joint), held.residual(X, by_joint))
        return Outcome(*residuals, train, seen, windows)
