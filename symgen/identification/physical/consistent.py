"""Physically consistent parameters: least squares over the robots that could exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

from symgen.codegen.model import Model
from symgen.estimation.estimators import NOISE_BIAS, Estimator, Wls
from symgen.estimation.solve import Solution
from symgen.estimation.system import LinearSystem
from symgen.estimation.values import Contrast
from symgen.identification.physical.links import nearest_consistent


@dataclass(frozen=True, eq=False)
class Consistent:
    """The most likely parameters with every link a body of positive mass (Sousa, Cortesao 2014).

    Of all link parameters whose pseudo-inertias are positive definite, with friction and rotor
    inertia not negative, those whose base parameters are nearest to another estimate in the metric
    of its covariance (Wensing, Kim, Slotine 2018): a semidefinite program, solved by Clarabel. With
    equal residuals in all rows this is least squares under these constraints.

    Attributes:
        model: of the robot.
        base: the estimate that it starts from.
        divergence: weight of a log-det prior on every pseudo-inertia (Lee, Wensing, Park 2020); it
            keeps them away from the edge of what is possible.
        towards: standard parameters by name that the log-det prior prefers, from CAD for example.
    """

    model: Model
    base: Estimator = field(default_factory=Wls)
    divergence: float = 0.0
    towards: Mapping[str, float] = field(default_factory=dict)
    name: ClassVar[str] = "consistent"
    excludes: ClassVar[str] = (
        NOISE_BIAS + "; the constraints (they are those of the estimate without them, and too wide "
        "where a constraint binds)"
    )

    def solve(self, system: LinearSystem) -> Solution:
        """Solve the base estimate, then the semidefinite program.

        Raises:
            ParameterError: no consistent parameters are found.
        """
        free = self.base.solve(system)
        near, sigmas = nearest_consistent(
            self.model, free.X, free.covariance, self.divergence, self.towards
        )
        moved = (
            f"parameters that a robot can have are {sigmas:.3g} sigmas from {self.base.name}"
            if sigmas
            else f"the estimate of {self.base.name} is one that a robot can have, and is kept"
        )
        return replace(
            free,
            X=near,
            notes=(*free.notes, moved),
            comparison=(Contrast(self.base.name, free.X, free.std), *free.comparison),
        )
