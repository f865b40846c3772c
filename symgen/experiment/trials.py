"""Trials: recordings of a robot whose parameters are known, and what is estimated from them.

    run k --instruments, seed--> logs --band--> equations of a model --method--> X, std
    runs k .. k + m - 1 together: the same motions, recorded m times as long

A task is some runs; it travels as values, and its result is the bytes of an NPZ.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.log import Log, make_log
from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.band import Band
from symgen.estimation.filtered import filtered
from symgen.estimation.logs import in_one_band, open_logs
from symgen.estimation.recipe import Recipe
from symgen.estimation.system import LinearSystem
from symgen.experiment.recording import Recording
from symgen.experiment.reference import Reference
from symgen.experiment.simulate import simulate
from symgen.experiment.simulation import Simulation
from symgen.identification.case import Run, checked_run
from symgen.identification.instruments import instrumented
from symgen.identification.out_of_core import loaded
from symgen.identification.solving import Method, Part, settled, solved
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: How many times the motions are recorded.
LENGTHS = (1, 2, 4)
#: Runs of a task: it is the same whoever works.
TOGETHER = 8


@dataclass(frozen=True, eq=False)
class Try:
    """A model with a method, in the band in which it is used."""

    recipe: Recipe
    method: Method
    band: Band


@dataclass(frozen=True, eq=False)
class Trials:
    """What a worker does with some runs.

    Attributes:
        robot: text of its robot.toml.
        kernels: that are needed of its model.
        X: its parameters, (p,).
        aims: the references, one a log; empty where nobody asks for them any more.
        recording: how logs come about.
        seed: of all noise.
        moved: the motion along every reference, where all runs have the same; else empty.
        tries: models and methods.
        late: whether torques are shifted where they come late, as `identify` does.
        held: q, qd, qdd (N, n) of a motion without noise, along which torques are predicted.
    """

    robot: str
    kernels: tuple[str, ...]
    X: FloatArray
    aims: tuple[Reference, ...]
    recording: Recording
    seed: int
    moved: tuple[Simulation, ...] = ()
    tries: tuple[Try, ...] = ()
    late: bool = False
    held: tuple[FloatArray, ...] = ()

    @property
    def evaluator(self) -> Evaluator:
        """The model, compiled once a process."""
        return loaded(self.robot, self.kernels)

    def samples(self, runs: range) -> Iterator[list[Samples]]:
        """Yield the logs of every run, opened and mended as `identify` does."""
        evaluator, r, count = self.evaluator, self.recording, len(self.moved or self.aims)
        made = []
        for k in range(count):
            numbers = range(runs.start * count + k, runs.stop * count, count)
            made.append(
                self.moved[k].seen_by(r.instruments, numbers, self.seed)
                if self.moved
                else simulate(
                    evaluator, self.X, trajectory=self.aims[k], recording=r, runs=numbers,
                    seed=self.seed,
                )
            )  # fmt: skip
        for run in range(len(runs)):
            logs = [done.log(run) for done in made]
            (opened,), _ = open_logs((logs,), evaluator.model.robot, None, lambda _: None)
            yield in_one_band(opened, ())[0]

    def __call__(self, runs: range) -> bytes:
        """Return X, std (tries, groups, p) and squared errors of torque (tries, groups, n), NPZ.

        A group is 1, 2 or 4 runs that are solved together: X1, X2, X4 and so on. What cannot be
        solved is NaN.
        """
        evaluator = self.evaluator
        parts = [self._parts(evaluator, samples) for samples in self.samples(runs)]
        q, qd, qdd = self.held
        torque = evaluator["inverse_dynamics"]
        true = torque(q, qd, qdd, self.X)
        out: dict[str, FloatArray] = {}
        for size in LENGTHS:
            groups = range(0, len(runs) - size + 1, size)
            X, std = np.full((2, len(self.tries), len(groups), len(self.X)), np.nan)
            error = np.full((len(self.tries), len(groups), q.shape[1]), np.nan)
            for i, tried in enumerate(self.tries):
                for j, first in enumerate(groups):
                    group = [part for run in parts[first : first + size] for part in run[i]]
                    try:
                        X[i, j], std[i, j] = _solved(evaluator, group, tried)
                    except (IdentificationError, np.linalg.LinAlgError):
                        continue
                    error[i, j] = np.sum((torque(q, qd, qdd, X[i, j]) - true) ** 2, axis=0)
            out |= {f"X{size}": X, f"std{size}": std, f"error{size}": error}
        file = io.BytesIO()
        np.savez(file, **out)  # type: ignore[arg-type]
        return file.getvalue()

    def _parts(self, evaluator: Evaluator, samples: Sequence[Samples]) -> list[list[Part]]:
        """Return the logs of a run with their equations, for every try."""
        seen = {}
        for band in {tried.band for tried in self.tries}:
            run = Run(evaluator, band, tuple(filtered(s, band) for s in samples), (), (), True)
            seen[band] = (checked_run(run)[0] if self.late else run).train
        built: dict[tuple[Recipe, Band, bool], list[Part]] = {}
        out = []
        for tried in self.tries:
            key = tried.recipe, tried.band, tried.method.name == "iv"
            if key not in built:
                built[key] = [
                    self._part(evaluator, Part("train", log, (), tried.recipe.model), k, *key)
                    for k, log in enumerate(seen[tried.band])
                ]
            out.append(built[key])
        return out

    def _part(
        self, evaluator: Evaluator, part: Part, log: int, recipe: Recipe, band: Band, iv: bool
    ) -> Part:
        part = replace(part, equations=recipe.equations(evaluator, part.log))
        if not iv:
            return part
        commanded = None if band.velocity == "measured" else self._commanded(part.samples.t, log)
        return instrumented(evaluator, part, recipe, commanded)

    def _commanded(self, t: FloatArray, log: int) -> Log:
        """Return the reference of a log at its stamps: instruments where no speed is measured."""
        aim, sigma = self.aims[log].at(t), self.evaluator.model.robot.sigma
        ones = np.ones_like(aim[:, 0])
        made = make_log("reference", t, aim[:, 0], ones, aim[:, 1], sigma=sigma)
        return replace(made, mapped=True)


def _solved(
    evaluator: Evaluator, parts: Sequence[Part], tried: Try
) -> tuple[FloatArray, FloatArray]:
    """Return X and its standard deviations, as `identify` finds them from these logs."""
    recipe = tried.recipe
    if evaluator.model.robot.loaded:
        recipe = settled(evaluator, [part.log for part in parts], recipe)
        parts = [replace(p, equations=recipe.equations(evaluator, p.log)) for p in parts]
    names = evaluator.model.base.names
    system = LinearSystem(names, tuple(e for part in parts for e in part.equations))
    found, _ = solved(evaluator, system, parts, tried.method, recipe)
    return found.X, found.std
