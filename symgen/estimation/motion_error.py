"""The torque error and the noise floor of joints in motion, which results state first.

At rest, static friction can take any value between its limits, so a model cannot predict it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import noise_fit
from symgen.estimation.torque_error import TorqueFit
from symgen.estimation.values import FloatArray, Residual
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True)
class MotionError:
    """The torque error of joints in motion and its noise floor.

    Attributes:
        error: ||measured - modelled|| / ||measured||, total and of each joint.
        noise: the noise floor, at most the error.
    """

    error: Residual
    noise: Residual


def motion_error(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, fit: TorqueFit
) -> MotionError:
    """Return the torque error of joints in motion and its noise floor.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the logs in the band of the run.
        X: parameters, (p,).
        fit: torque fit of these parameters on these logs.
    """
    error = fit.in_motion.residual
    return MotionError(error, floor_below(noise_fit(evaluator, logs, X).residual, error))


def floor_below(noise: Residual, error: Residual) -> Residual:
    """Return a noise floor that is at most the error: noise in the band is not always white."""
    each = map(min, noise.per_joint or (), error.per_joint or ())
    return Residual(min(noise.relative, error.relative), tuple(each))
