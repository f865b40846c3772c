"""The result of an identification, as a frozen value that is written, compared and drawn."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symgen.errors import SymgenError
from symgen.estimation.band import Band
from symgen.estimation.values import (
    Balance,
    Contrast,
    Convergence,
    Endogeneity,
    Residual,
    Trace,
    Whiteness,
)
from symgen.faults.fault import Fault
from symgen.files import html_table

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]
SCHEMA = "symgen.estimate/2"
#: Schemas that are read.
READ = (SCHEMA, "symgen.estimate/1")
#: Labels of provenance: the robot, and what ends the label of a log.
ROBOT_DIGEST, LOG_DIGEST = "robot, sha256 of its canonical robot.toml", "sha256 of samples"


@dataclass(frozen=True)
class ParameterEstimate:
    """One identified parameter: value and standard deviation, in `unit`."""

    name: str
    expression: str
    value: float
    std: float
    unit: str

    @property
    def relative_std_percent(self) -> float:
        """100 std / |value|; infinite for a value of zero."""
        return 100 * self.std / abs(self.value) if self.value else float("inf")


@dataclass(frozen=True)
class Consistency:
    """Whether a robot that could exist has these base parameters.

    Attributes:
        feasible: None where it was not checked.
        distance_sigma: to the nearest base parameters that a robot can have, in standard deviations
            of the estimate; None where it is unknown.
        reason: in words.
    """

    feasible: bool | None
    distance_sigma: float | None
    reason: str


UNCHECKED = Consistency(None, None, "not checked")


@dataclass(frozen=True)
class Use:
    """Whether an estimate serves a purpose.

    Attributes:
        name: prediction, parameters or simulation.
        reasons: what speaks against it, in words; empty where it does.
        known: names of the parameters that are known, of parameters alone.
    """

    name: str
    reasons: tuple[str, ...] = ()
    known: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.reasons


@dataclass(frozen=True, eq=False)
class Alternative:
    """One model of an identification.

    Attributes:
        model: energy, momentum or torque.
        condition_number: of its regressor with columns scaled to unit norm.
        held_out: error in torque on folds left out of its fit, RMS over the joints.
        train, validation: its residual in torque; None where its logs do not determine it.
        chosen: whether it is the estimate.
        reason: in words.
        apart: parameters that differ from those of the chosen model beyond chance, in std.
    """

    model: str
    condition_number: float
    held_out: float
    train: Residual | None
    validation: Residual | None
    chosen: bool
    reason: str
    apart: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Estimate:
    """Identified parameters with their precision, the fit, and a verdict in words.

    Attributes:
        robot: name of the robot.
        joints: number in the file and unit of the torque of each movable joint.
        model: energy, momentum or torque.
        method: name of the estimator.
        parameters: in the order of X.
        condition_number: of the regressor with its columns scaled to unit norm.
        train: residual of the model's own equations on the training data.
        validation: the same on data that the estimate never saw.
        torque_train: residual in torque of the same parameters, per joint.
        torque_validation: the same on the validation data.
        cutoff_hz: of the zero-phase filter, None where none was used.
        window_s: length of the energy windows, s.
        verdict: "trusted" or "doubtful".
        reasons: why it is doubtful, in words; empty for "trusted".
        notes: what was done to the logs, in words.
        correlation: of the estimated parameters, shape (p, p).
        physical: whether a robot could have these parameters.
        excludes: what the standard deviations leave out, in words.
        endogeneity: tests of whether least squares is biased here, where instruments exist.
        comparison: the same parameters by other methods: wls beside iv and iv beside wls.
        prior: what was given as a prior, its std infinite where nothing was; None without one.
        balances: where the measured work went, log by log.
        whiteness: of the residuals, quantity by quantity and joint by joint.
        band: the filters of the run; None in an older file.
        repairs: what was mended in the logs before anything was estimated.
        alternatives: the models that were fitted, the chosen one first.
        uses: what the estimate may be used for.
        headline: the verdict in one line, with what stands beside it.
    """

    robot: str
    joints: tuple[tuple[int, str], ...]
    model: str
    method: str
    parameters: tuple[ParameterEstimate, ...]
    condition_number: float
    train: Residual
    validation: Residual
    torque_train: Residual | None
    torque_validation: Residual | None
    cutoff_hz: float | None
    window_s: float | None
    verdict: str
    reasons: tuple[str, ...]
    notes: tuple[str, ...]
    correlation: FloatArray
    traces: tuple[Trace, ...] = ()
    convergence: Convergence | None = None
    provenance: tuple[tuple[str, str], ...] = field(default=())
    physical: Consistency = UNCHECKED
    excludes: str = ""
    endogeneity: tuple[Endogeneity, ...] = ()
    comparison: tuple[Contrast, ...] = ()
    prior: Contrast | None = None
    balances: tuple[Balance, ...] = ()
    whiteness: tuple[Whiteness, ...] = ()
    band: Band | None = None
    repairs: tuple[Fault, ...] = ()
    alternatives: tuple[Alternative, ...] = ()
    uses: tuple[Use, ...] = ()
    headline: str = ""

    def __repr__(self) -> str:
        """Return robot, model, method and verdict."""
        return (
            f"<Estimate of {self.robot}: {len(self.parameters)} parameters by {self.model} and "
            f"{self.method}, {self.verdict}>"
        )

    def _repr_html_(self) -> str:
        rows = [
            (p.name, f"{p.value:.5g}", f"{p.std:.2g}", f"{p.relative_std_percent:.1f}", p.unit)
            for p in self.parameters
        ]
        return html_table(repr(self), ("parameter", "value", "std", "std %", "unit"), rows)

    @property
    def X(self) -> FloatArray:
        """The values, shape (p,), in the order of every kernel."""
        return np.array([p.value for p in self.parameters])

    @property
    def covariance(self) -> FloatArray:
        """Covariance of X, shape (p, p)."""
        std = np.array([p.std for p in self.parameters])
        return self.correlation * np.outer(std, std)

    def to_dataframe(self) -> DataFrame:
        """Return the parameters as a table of pandas, a row each.

        Returns:
            Columns name, expression, value, std, relative_std_percent, unit.

        Raises:
            SymgenError: pandas is not installed.
        """
        try:
            from pandas import DataFrame
        except ImportError as error:
            raise SymgenError("pandas is missing: pip install pandas") from error
        columns = ("name", "expression", "value", "std", "relative_std_percent", "unit")
        return DataFrame({key: [getattr(p, key) for p in self.parameters] for key in columns})

    def to_json(self) -> dict[str, Any]:
        """Return the content of estimate.json (schema symgen.estimate/2)."""
        from symgen.identification.reading import estimate_json

        return estimate_json(self)
