"""The equations that an identification uses: the model and its windows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from symgen.codegen.definition import NOT_FOR
from symgen.codegen.kernels import ENERGY, KERNELS
from symgen.codegen.model import Model
from symgen.errors import IdentificationError
from symgen.estimation.features import Features
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.system import (
    Filling,
    Rows,
    torque_filling,
    window_filling,
)
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Kernels that the equations of each model need.
NEEDED: dict[str, tuple[str, ...]] = {
    "energy": ENERGY,
    "momentum": ("momentum_regressor", "friction_torque"),
    "torque": ("torque_regressor",),
}
#: Kernels that choose the band and compare torques, for every model.
JUDGING = ("torque_regressor", "inverse_dynamics")


def require_model(robot: Robot, model: str) -> None:
    """Raise IdentificationError if a robot supports only the torque model and `model` is another
    one.
    """
    if model in models_of(robot):
        return
    why = f"it {NOT_FOR[robot.base].format(robot.name)}"
    if robot.loaded:
        why = "the robot has effects that hold the torque of its links, which needs accelerations"
    raise IdentificationError(f"model {model}: {why}; accepted: model torque")


def models_of(robot: Robot) -> tuple[str, ...]:
    """Return the models that a robot supports."""
    only_torque = robot.loaded or (robot.imu and not robot.floating)
    return ("torque",) if only_torque else tuple(NEEDED)


@dataclass(frozen=True)
class EquationModel:
    """The equations to solve.

    Attributes:
        name: energy, momentum or torque.
        window: length of the windows of energy and momentum, s.
        at: X at which effects use the model's torque, see `torque_columns`; None leaves out their
            columns.
        features: random functions of the state for the model misfit; None for none.
    """

    name: str
    window: float
    at: tuple[float, ...] | None = None
    features: Features | None = None

    @property
    def all_kernels(self) -> tuple[str, ...]:
        """Names of the kernels to derive, for the model and for the torque comparison."""
        return tuple(dict.fromkeys((*ENERGY, *NEEDED[self.name], *JUDGING)))

    def kernels(self, model: Model) -> tuple[str, ...]:
        """Return the kernels that exist for this robot: some need friction."""
        rubs = len(model.base.parameters) > model.inertial
        kernels = (k for k in self.all_kernels if rubs or not k.startswith("friction"))
        return tuple(k for k in kernels if model.robot.base in KERNELS[k].bases)

    def runs_on(self, evaluator: Evaluator) -> bool:
        """Return whether a loaded model has all kernels."""
        return all(evaluator.has(kernel) for kernel in self.kernels(evaluator.model))

    @property
    def gap(self) -> float:
        """Time in s that an equation reaches back."""
        return 0.0 if self.name == "torque" else self.window

    def filling(self, log: FilteredLog) -> Filling:
        """Return the equations of one log without their columns."""
        if self.name == "torque":
            return torque_filling(log, None if self.at is None else np.array(self.at))
        return window_filling(log, self.name, self.window)

    def equations(self, evaluator: Evaluator, log: FilteredLog) -> Rows:
        """Build the equations of one log."""
        return self.filling(log)(evaluator, self.features)


def kernels_of(models: Iterable[EquationModel]) -> tuple[str, ...]:
    """Return the kernels that some models need, each once."""
    return tuple(dict.fromkeys(kernel for model in models for kernel in model.all_kernels))
