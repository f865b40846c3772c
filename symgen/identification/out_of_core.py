"""identify on more samples than memory holds: the same estimate, by folds over chunks.

    files --columns of time--> stretches without gaps --last fifth held out--> parts
    parts --a sample of them--> in memory: band, delay, faults, model, scans, tests, curves
    parts --chunks of rows--> EQUATIONS of each, folded where they are read --> triangle and rows of
          every log and joint --merged--> weights, X
    parts --chunks again--> sums of scores, squared errors of torque --added up--> covariance, fit
    X, covariance, fit, and the sample --> `judged`, as in memory --> Estimate

What is read whole are summaries: their size does not depend on the number of samples. Where the
sample holds all there is, the estimate is that of `identify` in memory.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symgen.data.dataset import DataSet, identity
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.distributed import Executor, WorkFolder, damaged_pieces, digest, finished
from symgen.errors import IdentificationError
from symgen.estimation.covariance import sandwich
from symgen.estimation.estimators import PASSES, bias_of_least_squares
from symgen.estimation.logs import open_samples
from symgen.estimation.partition import Part, Partition, Settings, partitions
from symgen.estimation.recipe import Recipe
from symgen.estimation.repairs import Repair
from symgen.estimation.solve import Solution, condition, log_weights
from symgen.estimation.torque_error import TorqueFit, fit
from symgen.identification.assessment import Outcome, judged, own_version
from symgen.identification.case import (
    Case,
    Run,
    checked_run,
    chosen_case,
    determined,
    looked_at,
    require_condition,
)
from symgen.identification.estimate import Estimate
from symgen.identification.parts import HELD_SAMPLE, SAMPLE, parts_of, sampled_spans
from symgen.identification.reduction import (
    FIT_SUMS,
    Chosen,
    EquationReduction,
    ErrorReduction,
    Summaries,
    Work,
    loaded,
    merged_repairs,
    read_repairs,
    unpacked,
)
from symgen.identification.solving import FOLDED, Method
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]


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
        summaries, repairs, clean = self._merged(cover, keys)
        train = [k for k, (number, _) in enumerate(summaries.names) if self._trains(number)]
        own, names = Chosen(summaries, train), run.evaluator.model.base.names
        self.progress(f"solving for {len(names)} parameters")
        passes = PASSES if self.method.name == "wls" else 0
        with determined(case.fault):
            weights, X, scale, R = log_weights(own, names, passes)
        weighed = {
            summaries.names[k]: (float(w), own[i].lag)
            for i, (k, w) in enumerate(zip(train, weights, strict=True))
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
        held = Chosen(summaries, [k for k in range(len(summaries)) if k not in set(train)])
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

    def _trains(self, number: int) -> bool:
        return self.parts[number].kind == "train"

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
        robot, repairs = self.data.robot, list[Repair]()

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
    ) -> tuple[Summaries, list[Repair], list[bool]]:
        """Return the summaries by log and joint, what was mended, and where nothing was."""
        places: dict[tuple[int, int], list[str]] = {}
        repairs: list[Repair] = []
        clean = []
        for partition, key in zip(cover, keys, strict=True):
            arrays = unpacked(self.folder, key)
            mended = read_repairs(arrays)
            repairs += mended
            clean.append(not mended)
            for number in dict.fromkeys(chunk.part for chunk in partition.chunks):
                j = 0
                while f"{number}.{j}" in arrays:
                    places.setdefault((number, j), []).append(key)
                    j += 1
        return Summaries(self.folder, places), merged_repairs(repairs), clean

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
        self, case: Case, X: FloatArray, own: Chosen, held: Chosen, fits: Mapping[str, TorqueFit]
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
