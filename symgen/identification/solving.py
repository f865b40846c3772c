"""Solve a system of equations by the requested method."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.cutoff import channel_noise
from symgen.estimation.equation_model import EquationModel, require_model
from symgen.estimation.estimators import (
    ESTIMATORS,
    METHODS,
    NOISE_BIAS,
    Estimator,
    Ols,
    Prior,
    TotalLeastSquares,
    Wls,
)
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.instrumental import InstrumentalVariables
from symgen.estimation.opening import Source, listed_logs
from symgen.estimation.solve import Solution, weighted_least_squares
from symgen.estimation.system import Rows, join
from symgen.estimation.values import SEED, FloatArray
from symgen.identification.scales import Carried
from symgen.identification.weak_prior import WeakPrior
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True)
class FitOptions:
    """Options of a fit besides model and method.

    Attributes:
        prior: estimate.json, TOML with [parameters], or the .urdf from which the robot was
            imported. It pulls methods auto, wls and consistent towards its values (see
            `read_prior`).
        commanded: commanded motion of each log, as instruments of method iv. By default, the
            encoders are the instruments, which requires measured speeds.
        forgetting: weight of the past for each new sample, for method recursive, in (0, 1]. The
            memory is about 1 / (1 - forgetting) samples, for any model and window.
        carried: for servos that report their duty: logs in which the link of [payload] carries a
            body of known mass, which gives the torques of the drives.
        mass: mass of this body, kg.
        com: its centre of mass in the frame of the link, m; None if unknown.
        opened: for such servos: logs of a motion with open windings, which separate back-EMF from
            viscous friction.
    """

    prior: str | Path | None = None
    commanded: Sequence[Source] | Source = ()
    forgetting: float = 1.0
    carried: Sequence[Source] | Source = ()
    mass: float | None = None
    com: tuple[float, float, float] | None = None
    opened: Sequence[Source] | Source = ()

    @property
    def body(self) -> Carried | None:
        """The body in the logs `carried`; None if there are none.

        Raises:
            IdentificationError: mass or logs are missing, or the mass is not positive.
        """
        logs = listed_logs(self.carried)
        if not logs and self.mass is None and self.com is None:
            return None
        if not logs or self.mass is None:
            raise IdentificationError(
                "a known mass needs its log; accepted: --carried LOG with --mass KG, both of them"
            )
        if not (math.isfinite(self.mass) and self.mass > 0):
            raise IdentificationError(f"--mass {self.mass:g}; accepted: a mass above 0 kg")
        if self.com is not None and not np.isfinite(self.com).all():
            raise IdentificationError("--com; accepted: X,Y,Z in m")
        return Carried(self.mass, self.com)

    def motions(self, logs: int, method: str) -> list[Source]:
        """Return one commanded motion for each log, or none.

        Raises:
            IdentificationError: the method uses no commanded motion, or the number of motions is
                not that of the logs.
        """
        motions = listed_logs(self.commanded)
        if motions and (method != "iv" or len(motions) != logs):
            raise IdentificationError(
                f"{len(motions)} commanded motions for {logs} logs and method {method}; "
                "accepted: one for each log, with method iv"
            )
        return motions


#: Methods whose estimate is a possible robot: if that costs no held-out error, and always.
AUTO, CONSISTENT = "auto", "consistent"
ALL_METHODS = (AUTO, *METHODS, CONSISTENT, "recursive")
#: Methods that need only sums over parts of the logs.
FOLDED = (AUTO, Wls.name, Ols.name, CONSISTENT)
_WITH_PRIOR = (AUTO, Wls.name, CONSISTENT)
#: Methods that account for noise in the regressor.
UNBIASED = (InstrumentalVariables.name, TotalLeastSquares.name)
_CONSTRAINED = (
    NOISE_BIAS + "; the constraints (they are those of the estimate without them, and too wide "
    "where a constraint binds)"
)
#: Most rounds of an iteration of columns that depend on X; change of X, in standard deviations, at
#: which it has converged.
ROUNDS, SETTLED = 30, 1e-3


@dataclass(frozen=True, eq=False)
class EquatedLog:
    """A log in the band of the run with its equations; `kind` is "train" or "validation"."""

    kind: str
    log: FilteredLog
    equations: Rows


@dataclass(frozen=True, eq=False)
class Method:
    """A method with its options.

    Attributes:
        name: one of ALL_METHODS, or the name of the estimator object.
        forgetting: weight of the past for method recursive, in (0, 1].
        prior: prior for methods auto, wls and consistent.
        custom: the estimator object from the user, or None.
    """

    name: str
    forgetting: float = 1.0
    prior: Prior | None = None
    custom: Estimator | None = None

    @classmethod
    def of(cls, method: str | Estimator, forgetting: float = 1.0) -> Method:
        """Return the method for a name or an estimator object."""
        if isinstance(method, (Wls, Ols)):
            method = method.name
        if isinstance(method, str):
            return cls(method, forgetting)
        if isinstance(method, Prior):
            return cls(Wls.name, forgetting, method, method)
        return cls(method.name, forgetting, None, method)

    def __post_init__(self) -> None:
        if self.custom is None and self.name not in ALL_METHODS:
            raise IdentificationError(f"method {self.name!r}; accepted: {', '.join(ALL_METHODS)}")
        if not (math.isfinite(self.forgetting) and 0 < self.forgetting <= 1):
            raise IdentificationError(
                f"forgetting {self.forgetting:g}; accepted: above 0 and at most 1"
            )
        if self.forgetting < 1 and self.name != "recursive":
            raise IdentificationError(
                f"method {self.name} does not forget; accepted: method recursive with forgetting"
            )
        if self.prior is not None and self.name not in _WITH_PRIOR:
            raise IdentificationError(
                f"method {self.name} takes no prior; accepted: {', '.join(_WITH_PRIOR)}"
            )

    @property
    def plain(self) -> bool:
        """Whether sums over segments are enough to solve the method."""
        return self.name in FOLDED and self.prior is None and self.custom is None

    @property
    def is_bounded(self) -> bool:
        """Whether its estimate may be the nearest possible parameters."""
        return self.name in (AUTO, CONSISTENT)

    @property
    def unconstrained(self) -> Method:
        """The method without the constraints of a possible robot."""
        return replace(self, name=Wls.name) if self.is_bounded else self

    @property
    def is_wls(self) -> bool:
        """Whether it uses the weighted least squares that chooses the model."""
        return self.plain and self.name != Ols.name

    @property
    def label(self) -> str:
        """Name of the method in an estimate."""
        prior = " with prior" if self.prior is not None else ""
        return f"{self.name}{prior}"

    @property
    def excludes(self) -> str:
        """The errors that its standard deviations do not include."""
        if self.custom is not None and self.prior is None:
            return self.custom.excludes
        if self.name == "recursive":
            return NOISE_BIAS
        if self.is_bounded:
            return _CONSTRAINED
        return (self.prior or ESTIMATORS[self.name]).excludes

    def is_tested(self, log: FilteredLog) -> bool:
        """Whether a log can show a bias of least squares, which requires measured speeds."""
        return self.name not in UNBIASED and log.band.velocity == "measured"

    @property
    def estimator(self) -> Estimator:
        """The estimator, without constraints."""
        return self.custom or self.prior or ESTIMATORS[self.unconstrained.name]


def rows_of(logs: Sequence[EquatedLog]) -> Rows:
    """Return the equations of some logs as one value."""
    return join([part.equations for part in logs])


def solve_equations(
    train: Sequence[EquatedLog],
    method: Method,
    model: EquationModel,
    prior: WeakPrior | None = None,
) -> Solution:
    """Solve the equations of the training logs, without the constraints of a possible robot.

    Args:
        train: the logs.
        method: method of the solution.
        model: model of the equations.
        prior: prior of least squares for what the logs do not determine; None if they determine all
            parameters.

    Raises:
        IdentificationError: the logs do not determine the parameters, or the method does not work
            with this model.
    """
    rows = rows_of(train)
    if prior is not None and method.is_wls:
        return weighted_least_squares(rows, prior=prior.rows)
    if method.custom is not None or method.name != "recursive":
        return method.estimator.solve(rows)
    if model.name == "torque":
        raise IdentificationError("method recursive works on the models of energy and momentum")
    memory, used = _memory(train, method.forgetting), rows.weight.T > 0
    solution = weighted_least_squares(rows.weighed(memory[:, None]), 0)
    means = [float(np.mean(memory[at][joint[at]])) for at in rows.spans for joint in used]
    return replace(solution, weights=tuple(means))


def noise_columns(
    equations: Callable[[FilteredLog], Rows], logs: Sequence[FilteredLog]
) -> FloatArray:
    """Return the change of the regressor due to noise of positions and speeds, (K, p).

        E = W(q + noise, qd + noise) - W(q, qd)

    It uses one draw of white noise with the standard deviations of the channels.

    Args:
        equations: returns the equations of a log.
        logs: logs in the band of the run.
    """
    draw, out = np.random.default_rng(SEED), []
    for log in logs:
        s, band = log.samples, replace(log.band, rests=None)
        noisy = {}
        for key in ("q", "qd"):
            x = getattr(s, key)
            noisy[key] = x + channel_noise(x) * draw.normal(size=x.shape)
        pair = (equations(filter_log(x, band)) for x in (s, replace(s, **noisy)))
        a, b = pair
        out.append((b.W - a.W)[a.weight > 0])
    return np.concatenate(out)


def settle_load(
    evaluator: Evaluator, logs: Sequence[FilteredLog], model: EquationModel
) -> EquationModel:
    """Return the torque model with the columns of load-dependent effects at the converged X.

    These columns depend on the torque of the model. The first round solves weighted least squares
    without them. Each further round evaluates them at the previous X, until X converges.

    Args:
        evaluator: the compiled model.
        logs: the training logs in the band of the run.
        model: the torque model.

    Raises:
        IdentificationError: the model is not that of torque, or X does not converge.
    """
    require_model(evaluator.model.robot, model.name)
    base = evaluator.model.base
    for _ in range(ROUNDS):
        rows = join([model.equations(evaluator, log) for log in logs])
        solution = Wls().solve(rows)
        X = np.pad(solution.X, (0, len(base.names) - len(rows.names)))
        moved = np.inf if model.at is None else np.abs(X - np.array(model.at))
        model = replace(model, at=tuple(map(float, X)))
        if len(rows.names) == len(X) and np.all(
            moved <= SETTLED * solution.std + 1e-12 * np.abs(X)
        ):
            return model
    raise IdentificationError(
        "effects of the load do not settle: their share of the torque is too large"
    )


def _memory(train: Sequence[EquatedLog], forgetting: float) -> FloatArray:
    """Return the weight of every row in a recursion that forgets, (K,).

    The weight of its squared residual is forgetting^k, with k the samples from the end of its
    window to the last end of all. The memory is about 1 / (1 - forgetting) samples, for any window,
    overlap and number of joints. Masked time without equations does not count.
    """
    out: list[FloatArray] = []
    later = 0.0  # samples after this log
    for part in reversed(train):
        rows, log = part.equations, part.log
        ends = rows.t[rows.weight.any(axis=1)]
        length = log.samples.length
        hop = float(np.diff(ends).min(initial=length)) / log.step
        newer = len(ends) - 1 - np.searchsorted(ends, rows.t)
        ages = later + hop * newer
        out = [forgetting ** (ages / 2), *out]
        later += hop * len(ends)
    return np.concatenate(out)
