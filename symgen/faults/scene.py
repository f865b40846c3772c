"""The mean power of friction over a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.data.mask import rms
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.runtime.evaluator import Evaluator


def mean_friction_power(
    evaluator: Evaluator, logs: Sequence[FilteredLog], states: int
) -> tuple[FloatArray, FloatArray]:
    """Return the mean power that friction takes from each joint, and the RMS of its speed.

        mean of qd_j W_j, W_j the columns of friction

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the logs with the motion.
        states: smallest number of states for the mean.

    Returns:
        (n, p) by base parameter, 0.0 for others than friction; (n,) rad/s or m/s.
    """
    q, qd = (np.concatenate([getattr(log, key)[log.kept] for log in logs]) for key in ("q", "qd"))
    every = slice(None, None, max(1, len(q) // states))
    q, qd = (np.ascontiguousarray(x[every]) for x in (q, qd))
    W = np.array(evaluator["torque_regressor"](q, qd, np.zeros_like(q)))
    W[:, :, : evaluator.model.inertial] = 0.0
    offsets = [b.name.startswith("OF") for b in evaluator.model.base.parameters][: W.shape[2]]
    W[:, :, offsets] = 0.0  # an offset does not dissipate
    return np.mean(W * qd[:, :, None], axis=0), rms(qd)
