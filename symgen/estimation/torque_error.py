"""The torque error: the one comparison of modelled and measured torque in all results.

    per_joint_j = ||tau_j - model_j|| / ||tau_j||,   relative = the same over all joints stacked

Forces and torques are not added: if a robot has prismatic and revolute joints, `relative` is the
larger of the errors of both kinds. A floating base adds two kinds: its forces, and its moments.

Positions and speeds are filtered at the cutoff of the run, both torques at the comparison band.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from symgen.data.mask import Bools
from symgen.data.raw import Places
from symgen.errors import LogError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.summary import Summary
from symgen.estimation.system import Equations, torque_at
from symgen.estimation.values import FloatArray, Residual, Trace
from symgen.names import BASE_FORCE, BASE_KINDS, BASE_MOMENT, REVOLUTE
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Errors above this ratio have no meaningful digits.
MANY = 10.0
#: Percentages from here on are whole numbers; smaller ones have three digits.
_WHOLE_PERCENT = 99.95
_NOTHING = 1e-300  # smallest sum of squares to divide by


@dataclass(frozen=True, eq=False)
class TorqueFit:
    """Measured and modelled torque of some logs in the comparison band.

    Attributes:
        error: (m,) sum of the squares of measured minus modelled torque.
        size: (m,) sum of the squares of the measured one.
        traces: both torques, log by log.
        rest: (2, m) the parts of error and size from joints at rest.
        sigma: (m,) kinds of the equations; empty for a fit that is added to another.
    """

    error: FloatArray
    size: FloatArray
    traces: tuple[Trace, ...]
    rest: FloatArray
    sigma: tuple[int, ...] = ()

    def __add__(self, other: TorqueFit) -> TorqueFit:
        return TorqueFit(
            self.error + other.error,
            self.size + other.size,
            self.traces + other.traces,
            self.rest + other.rest,
            self.sigma,
        )

    @classmethod
    def none(cls, robot: Robot) -> TorqueFit:
        """Return an empty fit for the equations of a robot."""
        m = len(robot.kinds)
        return cls(np.zeros(m), np.zeros(m), (), np.zeros((2, m)), robot.kinds)

    @property
    def in_motion(self) -> TorqueFit:
        """The fit of joints in motion; of all joints if none moves. Static friction can take any
        value.
        """
        error, size = self.error - self.rest[0], self.size - self.rest[1]
        if not size.any():
            return self
        return TorqueFit(error, size, (), np.zeros_like(self.rest), self.sigma)

    @property
    def residual(self) -> Residual:
        """The relative residual, total and of each joint, see `relative_error`."""
        return relative_error(self.error, self.size, self.sigma)

    @property
    def motion_note(self) -> tuple[str, ...]:
        """A text with the errors of joints in motion and at rest; empty if none rests."""
        if not self.rest.any():
            return ()
        moving, still = (
            self.in_motion.residual.relative,
            relative_error(self.rest[0], self.rest[1], self.sigma).relative,
        )
        return (
            f"the torque error is {percent(moving)} for joints in motion and "
            f"{percent(still)} for joints at rest",
        )


def percent(ratio: float) -> str:
    """Return a ratio in percent: three significant digits, whole numbers from 100 to 1000 %."""
    if not math.isfinite(ratio):
        return "unknown" if math.isnan(ratio) else "∞ %"
    if ratio > MANY:
        return "over 1000 %"
    value = 100 * ratio + 0.0
    return f"{value:.0f} %" if abs(value) >= _WHOLE_PERCENT else f"{value:#.3g} %"


def largest(
    ratios: Sequence[float], measured: FloatArray, labels: Sequence[str], units: Sequence[str]
) -> str:
    """Return the joint with the largest relative error and its RMS error, as a text.

    Args:
        ratios: RMS error over RMS torque, (n,); over that of all joints where it is 0.
        measured: torque, (N, n).
        labels, units: names of the joints and units of their torques, (n,).
    """
    j = int(np.argmax(ratios))
    rms = np.sqrt(np.mean(measured**2, axis=0))
    size = ratios[j] * float(rms[j] or np.linalg.norm(rms))
    return f"{labels[j]}: {percent(ratios[j])}, {size:.3g} {units[j]}"


def relative_error(
    error: FloatArray,
    size: FloatArray,
    sigma: Sequence[int] = (),
    *,
    by_joint: bool = True,
) -> Residual:
    """Return ||error|| / ||size||, total and by joint.

    A joint without torque, such as one without a motor, does not count in the total. Its error is
    compared with the torque of all joints of its kind, or of all joints if its kind has none.

    Args:
        error, size: (m,) sums of squares.
        sigma: (m,) kinds of the equations; the total is the largest of the errors of all kinds.
            Empty if all sums have one unit.
        by_joint: whether there is one sum for each joint.
    """
    kind_size, kinds = size_of_kind(size, sigma), _kinds(sigma, len(size))
    counted = (size > 0) | ~size.any()
    parts = np.where(counted, error / kind_size, 0.0)
    totals = {k: float(parts[kinds == k].sum()) for k in sorted({*kinds.tolist()})}
    # np.max keeps NaN, which is an unknown noise floor.
    total = math.sqrt(float(np.max([0.0, *totals.values()])))
    of_others = np.where(kind_size > _NOTHING, kind_size, max(float(size.sum()), _NOTHING))
    each = np.sqrt(error / np.where(size > 0, size, of_others))
    out = Residual(total, tuple(map(float, each)) if by_joint else None)
    if BASE_FORCE not in totals:
        return out
    flies = not size[: len(BASE_KINDS)].any()  # nothing to compare with
    of_base = totals.pop(BASE_FORCE), totals.pop(BASE_MOMENT)
    force, moment = (math.nan if flies else math.sqrt(part) for part in of_base)
    joints = math.sqrt(float(np.max([0.0, *totals.values()])))
    each = each[len(BASE_KINDS) :]
    return Residual(total, tuple(map(float, each)), force, moment, joints)


def _kinds(sigma: Sequence[int], count: int) -> Places:
    """Return the kinds of equations, (count,); all are revolute if `sigma` is empty."""
    return np.array(sigma or [REVOLUTE] * count, dtype=np.int64)


def size_of_kind(size: FloatArray, sigma: Sequence[int] = ()) -> FloatArray:
    """Return for each equation the sum of the sizes of all equations of its kind, (m,).

    Args:
        size: (m,) sums of squares of the torque.
        sigma: (m,) kinds of the equations; empty if all have one unit.
    """
    kinds = _kinds(sigma, len(size))
    sums = np.zeros(len(size))
    for kind in {*kinds.tolist()}:
        sums[kinds == kind] = size[kinds == kind].sum()
    return np.maximum(sums, _NOTHING)


def equation_residual(
    parts: Sequence[Equations | Summary], X: FloatArray, kinds: Sequence[int] = ()
) -> Residual:
    """Return ||y - W X|| / ||y|| of equations or their summaries, total and by joint.

    Args:
        parts: the equations.
        X: parameters, (p,).
        kinds: (m,) kinds of the equations of joints; those of a floating base have errors of the
            base.
    """
    # only once, since parts may be files
    residuals = [(part.joint, part.rss(X), part.square) for part in parts]
    sums = np.zeros((2, 1 + max(joint or 0 for joint, _, _ in residuals)))
    for joint, error, size in residuals:
        sums[:, joint or 0] += error, size
    by_joint = residuals[0][0] is not None
    of_base = kinds if by_joint and BASE_FORCE in kinds else ()
    return relative_error(sums[0], sums[1], of_base, by_joint=by_joint)


def modelled_torque(evaluator: Evaluator, log: FilteredLog, X: FloatArray) -> FloatArray:
    """Return the torque of a model along a log in the comparison band, (K, n)."""
    return log.at_nodes().modelled(partial(torque_at, evaluator, X))


def fit(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, kind: str = "validation"
) -> TorqueFit:
    """Compare the torque of a model with the measured one.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: logs in the band of the run.
        X: parameters, (p,).
        kind: kind of the logs, "train" or "validation".

    Raises:
        LogError: the mask covers all samples.
    """
    out = TorqueFit.none(evaluator.model.robot)
    for log in logs:
        torque = modelled_torque(evaluator, log, X)
        raw = log.tau[log.kept]
        trace = Trace(log.name, kind, "torque", log.compared_t, log.measured, torque, raw)
        out += squares(log.free, log.measured, torque, log.resting, (trace,))
    if logs and all(log.mask for log in logs) and not out.size.all():
        j = int(np.argmin(out.size)) + 1
        raise LogError(
            f"{logs[0].name}: --mask covers all samples of tau{j}; accepted: "
            "a log in which every joint moves, a higher cutoff, or no mask"
        )
    return out


def squares(
    free: Bools,
    measured: FloatArray,
    torque: FloatArray,
    resting: Bools | None = None,
    traces: tuple[Trace, ...] = (),
) -> TorqueFit:
    """Sum the squares of the residual and of the measured torque.

    Args:
        free: (K, n) whether a row counts.
        measured, torque: (K, n) torques in the comparison band.
        resting: (K, n) whether a rest of the joint affects the row; None without rests.
        traces: both torques, for plots.
    """
    both = np.stack([(measured - torque) ** 2, measured**2])
    rest = np.zeros((2, measured.shape[1]))
    if resting is not None:
        rest = np.sum((free & resting) * both, axis=1)
    error, size = np.sum(free * both, axis=1)
    return TorqueFit(error, size, traces, rest)
