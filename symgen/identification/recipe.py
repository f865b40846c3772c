"""Which equations an identification uses: the model, its windows and its filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symgen.codegen.kernels import ENERGY
from symgen.codegen.model import Model
from symgen.data.bandwidth import DERIVED_WIDE, rigid_band
from symgen.data.signals import Samples, can_filter
from symgen.errors import IdentificationError
from symgen.identification.system import (
    Equations,
    energy_equations,
    momentum_equations,
    torque_equations,
)
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: The kernels that each model needs beside those of energy.
NEEDED: dict[str, tuple[str, ...]] = {
    "energy": (),
    "momentum": ("momentum_regressor", "friction_torque"),
    "torque": ("torque_regressor",),
}


def require_model(robot: Robot, model: str) -> None:
    """Raise IdentificationError where a robot's effects need accelerations and a model has none."""
    if robot.loaded and model != "torque":
        raise IdentificationError(
            f"model {model}: the robot has effects that hold the torque of its links, which needs "
            "accelerations; accepted: model torque"
        )


@dataclass(frozen=True)
class Recipe:
    """What equations are made of.

    Attributes:
        model: energy, momentum or torque.
        window: length of the windows, s.
        cutoff: of the filter, Hz; None for that of the motion.
        at: X at which effects take the model's torque, see `torque_columns`; None leaves their
            columns away.
    """

    model: str
    window: float
    cutoff: float | None
    at: tuple[float, ...] | None = None

    @property
    def all_kernels(self) -> tuple[str, ...]:
        """Names of the kernels to derive."""
        return (*ENERGY, *NEEDED[self.model], "inverse_dynamics")

    def kernels(self, model: Model) -> tuple[str, ...]:
        """Names of the kernels that exist for this robot: without friction some do not."""
        rubs = len(model.base.parameters) > model.inertial
        return tuple(k for k in self.all_kernels if rubs or not k.startswith("friction"))

    @property
    def wide(self) -> float:
        """Cutoff of the filter of positions over that of the equations."""
        return DERIVED_WIDE if self.model == "torque" else 1.0

    def band(self, samples: Samples) -> float | None:
        """Return the cutoff in Hz of the filter that the equations of a log pass; None for none."""
        if self.model == "torque":
            band = self.cutoff or rigid_band(samples)
            return band if can_filter(band, samples.step) else None
        return samples.cutoff_hz

    @property
    def gap(self) -> float:
        """Time in s that an equation reaches back."""
        return 0.0 if self.model == "torque" else self.window

    def equations(self, evaluator: Evaluator, samples: Samples) -> tuple[Equations, ...]:
        """Build the equations of one log."""
        if self.model == "energy":
            return (energy_equations(evaluator, samples, self.window),)
        if self.model == "momentum":
            return momentum_equations(evaluator, samples, self.window)
        at = None if self.at is None else np.array(self.at)
        return torque_equations(evaluator, samples, self.cutoff, at)
