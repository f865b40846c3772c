"""One diagnosis: the model, the logs, and the model's torques on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.evidence import Evidence, Scene, evidence, given_evidence, model_torque
from symgen.diagnosis.floor import noise_floor
from symgen.diagnosis.given_parameters import link_values
from symgen.diagnosis.select import Score
from symgen.diagnosis.shapes import Torques
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
KERNELS = ("torque_regressor", "inverse_dynamics")


@dataclass(frozen=True, eq=False)
class Study:
    """The model and the logs of a diagnosis.

    Attributes:
        evaluator: the model as it is declared.
        base: what it leaves of the training logs.
        held: the logs that show the gap.
        X: (p,) parameters of the model: fitted to the training logs, or given.
        given: whether they are given.
    """

    evaluator: Evaluator
    base: Evidence
    held: tuple[Scene, ...]
    X: FloatArray
    given: bool

    @property
    def robot(self) -> Robot:
        """The robot as it is declared."""
        return self.evaluator.model.robot

    def torques(self, found: Evidence) -> Sequence[Torques]:
        """Return the model's torque and its friction on every training log, beside what is found.

        Args:
            found: the evidence with the columns of what was accepted so far.
        """
        X = self.parameters(found)
        return [torques_of(self.evaluator, X, s) for s in self.base.scenes]

    def noise(self) -> FloatArray:
        """Return the standard deviation of the residual that noise alone leaves, (n,)."""
        model = partial(model_torque, self.evaluator, self.X)
        scenes = self.base.scenes
        parts = [noise_floor(s, s.tau - model(s), model, scenes) ** 2 for s in scenes]
        return np.asarray(np.sqrt(np.mean(parts, axis=0)))

    def parameters(self, found: Evidence) -> FloatArray:
        """Return X beside what is found, (p,)."""
        return self.X if self.given else found.X[: len(self.X)]

    def beside(self, accepted: Sequence[Score]) -> Evidence:
        """Return the evidence of the model with the columns of some effects."""
        return self.base.with_columns(s.columns for s in accepted)


def studied(
    evaluator: Evaluator,
    train: Sequence[Scene],
    held: Sequence[Scene],
    given: FloatArray | None = None,
) -> Study:
    """Fit a model to the training logs, or take given parameters (p,)."""
    if given is None:
        base = evidence(evaluator, train)
        X = base.X
    else:
        base = given_evidence(evaluator, train, given)
        X = given
    return Study(evaluator, base, tuple(held), X, given is not None)


def torques_of(
    evaluator: Evaluator, X: FloatArray, s: Scene, links: FloatArray | None = None
) -> Torques:
    """Return a model's torque and its friction along a log, beside its links' parameters.

    Args:
        evaluator: the compiled model.
        X: (p,) parameters.
        s: the log.
        links: parameters of the links, where they are others.
    """
    model = evaluator.model
    rigid = np.where(np.arange(len(X)) < model.inertial, X, 0.0)
    whole = model_torque(evaluator, X, s)
    friction = whole - model_torque(evaluator, rigid, s)
    return Torques(whole, friction, link_values(model, X) if links is None else links)
