"""Values that are parts of estimates, predictions and diagnoses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from symgen.data.raw import FloatArray as FloatArray
from symgen.schemas import BESIDE, OPTIONAL, OrNan, Size, SizeOrNan, at

#: Seed of all random draws.
SEED = 1988
#: Arrays that are not stored in estimate.json itself.
Curve = Annotated[FloatArray, BESIDE]


@dataclass(frozen=True)
class Reason:
    """A reason for a verdict or a note: programs read kind, people read text.

    Attributes:
        kind: a word from a fixed list, such as "drive_gain_error" or "overfit".
        joints: joint numbers of the robot file; empty for all, or if it concerns none.
        value: the measured value, NaN if there is none.
        limit: the limit of the value, NaN if there is none.
        text: one sentence, with the joints' names and what to do.
    """

    kind: str
    joints: tuple[int, ...] = ()
    value: OrNan = math.nan
    limit: OrNan = math.nan
    text: str = ""


@dataclass(frozen=True)
class Residual:
    """Relative residual ||y - W X|| / ||y||, total and for each joint if equations have one.

    Attributes:
        relative: total, the largest of those of unlike units.
        per_joint: of each joint, or None.
        base_force, base_moment, joints: of the forces on a floating base, of the moments on it, and
            of the joints; None for other bases.
    """

    relative: SizeOrNan
    per_joint: tuple[SizeOrNan, ...] | None = None
    base_force: Annotated[SizeOrNan | None, OPTIONAL] = None
    base_moment: Annotated[SizeOrNan | None, OPTIONAL] = None
    joints: Annotated[SizeOrNan | None, OPTIONAL] = None

    @property
    def parts(self) -> tuple[float, ...]:
        """Those of the joints, then those of the forces and of the moments on a floating base."""
        of_base = (x for x in (self.base_force, self.base_moment) if x is not None)
        return (*(self.per_joint or ()), *of_base)


@dataclass(frozen=True, eq=False)
class Trace:
    """Measured and modelled values of a quantity, for each window or sample.

    Attributes:
        log: name of the log.
        kind: "train" or "validation".
        quantity: "energy" (one column, J) or "torque" (one column a joint, N m or N).
        t: time of the row, s, shape (K,).
        measured: shape (K, m).
        predicted: shape (K, m).
        raw: unfiltered measured torque, shape (K, m); None for other quantities.
    """

    GONE: ClassVar = ("spacing",)

    log: str
    kind: str
    quantity: str
    t: Curve
    measured: Curve
    predicted: Curve
    raw: Annotated[FloatArray | None, BESIDE] = None

    @property
    def residual(self) -> FloatArray:
        """Measured minus predicted, (K, m)."""
        return np.subtract(self.measured, self.predicted)


@dataclass(frozen=True)
class Endogeneity:
    """A Durbin-Wu-Hausman test: are columns of the regressor correlated with the error?

    Attributes:
        columns: the tested columns: "all", "inertial" or "friction".
        statistic: F of the hypothesis that least squares is consistent.
        df: degrees of freedom of numerator and denominator.
        p_value: probability of a larger F if least squares is consistent.
    """

    columns: str
    statistic: Annotated[Size, at("F")]
    df: tuple[int, float]
    p_value: Size


class OtherValue(NamedTuple):
    """A parameter estimate of another method."""

    name: str
    value: float
    std: SizeOrNan


@dataclass(frozen=True)
class OtherEstimate:
    """Parameters from another method or a prior, as far as it determines them."""

    method: str
    parameters: tuple[OtherValue, ...]

    @classmethod
    def by(cls, method: str, names: Iterable[str], X: FloatArray, std: FloatArray) -> OtherEstimate:
        """Return X and std (p,) of a method or a prior, without entries that have no finite std."""
        rows = zip(names, X.tolist(), std.tolist(), strict=True)
        values = (OtherValue(*row) for row in rows)
        return cls(method, tuple(v for v in values if not math.isinf(v.std)))

    def of(self, name: str) -> tuple[float, float]:
        """Return value and std of a parameter; NaN and infinity if it is not known."""
        known = (p for p in self.parameters if p.name == name)
        return next(((p.value, p.std) for p in known), (math.nan, math.inf))

    @property
    def X(self) -> FloatArray:
        """The values, in the order of the names."""
        return np.array([p.value for p in self.parameters])

    @property
    def std(self) -> FloatArray:
        """Their standard deviations."""
        return np.array([p.std for p in self.parameters])
