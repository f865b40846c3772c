"""Errors of the IMU of a base that moves: offsets in each log, and a delay of all logs.

    f(t) = f_imu(t + DT) - OF,   w(t) = w_imu(t + DT) - OW

An offset of 0.05 m/s2 changes the mass of a robot by 0.5 %. Offsets, delay and parameters are
therefore one problem of least squares. A Gauss-Newton step adds the columns d(torque)/d(OF, OW, DT)
to the torque equations. A prior holds the errors at the size that such sensors have, so that they
stay near zero where the logs do not show them, and they count as zero unless all of them together
are beyond chance. Each log has its offsets, because those of MEMS sensors differ from start to
start. Those of other logs are fitted with known parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.raw import read_only
from symgen.estimation.covariance import is_chance, robust_covariance
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import base_motion
from symgen.estimation.solve import (
    SINGULAR,
    Solution,
    column_norms,
    residual_weights,
    shortest_of,
    shortest_weights,
    sum_of_scores,
    weighted_triangle,
)
from symgen.estimation.summary import Summary, summaries
from symgen.estimation.system import Rows, join, torque_at, torque_equations
from symgen.estimation.torque_error import fit
from symgen.estimation.values import FloatArray
from symgen.faults.fault import IMU, Fault, shifted_imu
from symgen.faults.undo import with_imu
from symgen.policy import BEYOND, IMU_DELAY, IMU_OFFSETS
from symgen.runtime.evaluator import Evaluator

_SIZES = np.repeat(IMU_OFFSETS, 3)
_LABELS = ("OFX", "OFY", "OFZ", "OWX", "OWY", "OWZ")
_SIX = len(_LABELS)
#: Most Gauss-Newton steps, and the step in standard deviations that ends them.
_STEPS, _SETTLED = 8, 0.05
_APART = 1e-3  # step of a difference of torques, in units of the errors


@dataclass(frozen=True, eq=False)
class ImuErrors:
    """Errors of the IMU in some logs: none if together they are not beyond chance, or if one is
    larger than those of such sensors, because then something else is wrong.

    Attributes:
        logs: the logs without these errors.
        offsets: (L, 6) offsets of specific force, m/s2, and angular velocity, rad/s, of each log.
        delay: s by which the IMU is late; 0 if it is not fitted.
        std: (L 6,) standard deviations of the offsets, then that of a fitted delay.
        X: (p,) parameters of the fit.
        spread: (p, p) covariance of the parameters due to these errors.
    """

    logs: tuple[FilteredLog, ...]
    offsets: FloatArray
    delay: float
    std: FloatArray
    X: FloatArray
    spread: FloatArray

    @property
    def found(self) -> bool:
        """Whether there are errors."""
        return bool(self.offsets.any())

    @property
    def certain_delay(self) -> float:
        """The delay, s, if it differs from zero beyond chance, else zero."""
        std = self.std[self.offsets.size :]
        return self.delay if (abs(self.delay) > BEYOND * std).all() else 0.0

    @property
    def repairs(self) -> Iterator[Fault]:
        """The repairs of errors that differ from zero beyond chance."""
        of_logs, of_delay = np.split(self.std, [self.offsets.size])
        deviations = of_logs.reshape(self.offsets.shape)
        for log, offsets, std in zip(self.logs, self.offsets, deviations, strict=True):
            if (np.abs(offsets) > BEYOND * std).any():
                yield _removed(log, offsets, std)
        if self.certain_delay:
            samples = sum(len(log.t) for log in self.logs)
            yield replace(shifted_imu(self.delay, float(of_delay[0])), samples=samples)

    def with_uncertainty(self, solution: Solution) -> Solution:
        """Return a solution with the uncertainty of these errors."""
        return replace(solution, misfit=solution.misfit + self.spread)


def _removed(log: FilteredLog, offsets: FloatArray, std: FloatArray) -> Fault:
    """Return the repair of the offsets (6,) of a log, with their standard deviations."""
    texts = [f"{x:.3g} +- {s:.2g}" for x, s in zip(offsets, std, strict=True)]
    force, rate = ", ".join(texts[:3]), ", ".join(texts[3:])
    text = f"the IMU has offsets of {force} m/s2 and {rate} rad/s"
    values = tuple(zip(_LABELS, offsets.tolist(), std.tolist(), strict=True))
    return Fault(log.name, IMU, text, len(log.t), "removed", values, "offsets")


def has_imu(log: FilteredLog) -> bool:
    """Whether an IMU measures the motion of the base of a log."""
    return bool(log.base) and log.samples.imu is not None


def undone(log: FilteredLog, delay: float, offsets: FloatArray) -> FilteredLog:
    """Return a log without a delay and offsets (6,) of its IMU."""
    samples = with_imu(log.samples, delay, offsets)
    return replace(log, samples=samples, base=base_motion(samples, log.band))


def imu_errors(evaluator: Evaluator, logs: Sequence[FilteredLog]) -> ImuErrors:
    """Estimate the errors of the IMU in training logs, together with the parameters.

    Args:
        evaluator: the compiled model.
        logs: the logs in the band of the run.
    """
    return _fitted(evaluator, logs, None)


def offsets_with_known(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, delay: float = 0.0
) -> ImuErrors:
    """Estimate the offsets of the IMU in logs, for known parameters.

    Args:
        evaluator: the compiled model.
        logs: the logs in the band of the run.
        X: (p,) parameters.
        delay: s by which the IMU was late in other logs. A log is shifted only if this lowers its
            torque error, because another recorder may not be late.
    """
    if not delay:
        return _fitted(evaluator, logs, X)
    chosen = []
    for log in logs:
        both = [log, undone(log, delay, np.zeros(_SIX))]
        fits = [_fitted(evaluator, [each], X).logs for each in both]
        errors = [fit(evaluator, each, X).in_motion.residual.relative for each in fits]
        chosen.append(both[int(np.argmin(errors))])
    return _fitted(evaluator, chosen, X)


def _fitted(
    evaluator: Evaluator, logs: Sequence[FilteredLog], known: FloatArray | None
) -> ImuErrors:
    """Solve for the errors by the Gauss-Newton method, with weights of the model without errors.

    Args:
        evaluator, logs: see `imu_errors`.
        known: (p,) parameters; None to solve for them, and for a delay.
    """
    # The torque and its slope do not depend on the IMU.
    measured = [log.measured for log in logs]
    slopes = [_slope(log) for log in logs]
    now, rows = tuple(logs), _rows(evaluator, logs, measured)
    parts = summaries(rows.parts)
    X = shortest_of(parts, shortest_weights(parts)) if known is None else known
    first, shared = X, np.sqrt([part.correlation for part in parts])
    weights = residual_weights(parts, X) / shared
    sizes = np.tile(_SIZES, len(logs))
    if known is None:  # late torques are not undone here, and are no delay of the IMU
        sizes = np.append(sizes, [IMU_DELAY, IMU_DELAY])
    errors, free = np.zeros(len(sizes)), slice(0, len(X) if known is None else 0)
    offsets, delay = np.split(errors, [_SIX * len(logs)])
    for _ in range(_STEPS):
        derivatives = _columns(evaluator, now, X, slopes, len(errors))
        W = np.concatenate([derivatives, rows.W[..., free]], axis=2)
        unexplained = replace(rows, y=rows.y - rows.W @ X).with_regressor(W)
        prior = np.zeros((len(errors), W.shape[2] + 1))
        prior[:, : len(errors)] = np.diag(1 / sizes)
        prior[:, -1] = -errors / sizes
        both = [*summaries(unexplained.parts), Summary(prior, len(prior))]
        step, bread = _solved(weighted_triangle(both, np.append(weights, 1.0)))
        moved, of_X = np.split(step, [len(errors)])
        errors = errors + moved
        X = X + of_X if known is None else X
        offsets, delay = np.split(errors, [_SIX * len(logs)])
        each = zip(logs, offsets.reshape(-1, _SIX), strict=True)
        now = tuple(undone(log, float(delay[:1].sum()), of_log) for log, of_log in each)
        rows = _rows(evaluator, now, measured)
        std = np.sqrt(np.diag(bread))[: len(errors)]
        if (np.abs(moved) < _SETTLED * std).all():
            break
    last = replace(rows, y=rows.y - rows.W @ X).with_regressor(W)
    covariance = _covariance(evaluator, now, last, weights, bread)
    of_prior = bread[:, : len(errors)] / sizes
    covariance = covariance + of_prior @ of_prior.T
    of_errors, across = np.hsplit(covariance[: len(errors)], [len(errors)])
    spread = across.T @ np.linalg.solve(of_errors, across)
    count = len(errors) - len(delay) // 2  # of the IMU
    of_imu = of_errors[:count, :count]
    std = np.sqrt(np.diag(of_imu))
    possible = (np.abs(errors[:count]) <= BEYOND * sizes[:count]).all()
    if not possible or is_chance(errors[:count], of_imu):
        none = np.zeros((len(logs), _SIX))
        return ImuErrors(tuple(logs), none, 0.0, std, first, np.zeros_like(spread))
    return ImuErrors(now, offsets.reshape(-1, _SIX), float(delay[:1].sum()), std, X, spread)


def _solved(factor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shortest solution of the triangle of [W y], and (W'W)^-1."""
    W, y = factor[:, :-1], factor[:, -1]
    norms = column_norms(W)
    inverse = np.linalg.pinv(W / norms, SINGULAR) / norms[:, None]
    return inverse @ y, inverse @ inverse.T


def _covariance(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    rows: Rows,
    weights: FloatArray,
    bread: FloatArray,
) -> FloatArray:
    """Return the covariance of the solution, with that from model misfit.

    Args:
        evaluator: the compiled model.
        logs: the logs without the errors.
        rows: the equations at the solution, with their residual as y.
        weights: one for each log and joint.
        bread: inverse of the information of the equations and the prior.
    """
    robot = evaluator.model.robot
    if robot.n:
        features = features_of(logs, robot.sigma)
        waves = [features.in_band(log.at_nodes()) for log in logs]
        rows = replace(rows, features=np.concatenate(waves))
    equations = rows.parts
    parts = summaries(equations)
    at = np.zeros(len(bread))
    meat = sum_of_scores(equations, parts, weights, at)
    noise, misfit = robust_covariance(at, bread, meat, parts, weights)
    return noise + misfit


def _rows(
    evaluator: Evaluator, logs: Sequence[FilteredLog], measured: Sequence[FloatArray]
) -> Rows:
    """Return the torque equations of logs with known `FilteredLog.measured`."""
    pairs = zip(logs, measured, strict=True)
    return join([torque_equations(evaluator, log, measured=y) for log, y in pairs])


def _slope(log: FilteredLog) -> FloatArray:
    """Return the derivative of the torque of the joints by time, in the band, (K, m)."""
    slope = read_only(np.gradient(log.samples.tau, log.step, axis=0))
    samples = replace(log.samples, tau=slope, forces=None)
    return replace(log, samples=samples).measured


def _columns(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    X: FloatArray,
    slopes: Sequence[FloatArray],
    count: int,
) -> FloatArray:
    """Return the derivatives of the torque by all errors, (K, m, count)."""
    parts = []
    for k, (log, slope) in enumerate(zip(logs, slopes, strict=True)):
        of_log = _of_log(evaluator, log, X, slope)
        out = np.zeros((*of_log.shape[:2], count))
        first = _SIX * k
        out[..., first : first + _SIX] = of_log[..., :_SIX]
        if count > _SIX * len(logs):
            out[..., -2:] = of_log[..., _SIX:]
        parts.append(out)
    return np.concatenate(parts)


def _of_log(evaluator: Evaluator, log: FilteredLog, X: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the derivatives of the torque by six offsets, the delay of the IMU and that of the
    torques, (K, m, 8). They are zero in a log with a pose.

    Args:
        evaluator: the compiled model.
        log: the log.
        X: (p,) parameters.
        slope: `_slope` of the log.
    """
    if not has_imu(log):
        return np.zeros((len(log.kept), log.width, _SIX + 2))
    base = np.concatenate(log.base, axis=1)
    changes = [-_of_unit(log, k) for k in range(_SIX)]
    changes.append(np.gradient(base, log.step, axis=0))
    nodes = log.at_nodes()
    change = np.ascontiguousarray(np.stack(changes)[:, :: log.stride].swapaxes(0, 1))

    def columns(*motion: FloatArray) -> FloatArray:
        *motion_of_joints, f, w, wd, along = motion
        base = np.concatenate([f, w, wd], axis=1)
        out = []
        for one in along.swapaxes(0, 1):
            ahead, behind = (
                torque_at(evaluator, X, *motion_of_joints, *_three(base + sign * _APART * one))
                for sign in (1, -1)
            )
            out.append((ahead - behind) / (2 * _APART))
        return np.stack(out, axis=-1)

    of_imu = replace(nodes, motion=(*nodes.motion, change)).modelled(columns)
    return np.concatenate([of_imu, -slope[..., None]], axis=2)


def _three(base: FloatArray) -> list[FloatArray]:
    """Return f, w and wd, (k, 3) each, from (k, 9)."""
    return [np.ascontiguousarray(x) for x in np.hsplit(base, 3)]


def _of_unit(log: FilteredLog, k: int) -> FloatArray:
    """Return the change of the base's motion by one unit of a reading of the IMU, (N, 9)."""
    unit = np.eye(_SIX)[k]
    ends = []
    for offsets in (-unit, unit):
        samples = with_imu(log.samples, 0.0, offsets)
        ends.append(np.concatenate(base_motion(samples, log.band), axis=1))
    return (ends[0] - ends[1]) / 2
