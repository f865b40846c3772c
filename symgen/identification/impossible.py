"""Parameters that no robot has, beyond doubt: why least squares gives way to possible ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.faults.scene import mean_friction_power
from symgen.identification.parameters import mass_matrices
from symgen.identification.physical import POSITIVE
from symgen.identification.simulation import STATES
from symgen.runtime.evaluator import Evaluator

#: How many standard deviations make a sign sure.
SIGNIFICANT = 3.0


def impossible(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, covariance: FloatArray
) -> tuple[str, ...]:
    """Say why no robot has some parameters, each reason beyond 3 standard deviations.

    Args:
        evaluator: the compiled model, with torque_regressor and inverse_dynamics.
        logs: the training logs.
        X, covariance: of the parameters, (p,) and (p, p).
    """
    base, std = evaluator.model.base.parameters, np.sqrt(np.diag(covariance))
    below = []
    for p, x, s in zip(base, X, std, strict=True):
        standard = p.expression == p.name and p.name.rstrip("0123456789") in POSITIVE
        if standard and x < -SIGNIFICANT * s:
            below.append(p.name)
    return (
        *driving_friction(evaluator, logs, X, covariance),
        *negative_mass(evaluator, logs, X, covariance),
        *(f"{name} must be positive but is negative" for name in below),
    )


def driving_friction(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, covariance: FloatArray
) -> tuple[str, ...]:
    """Name joints whose friction gives energy over the motion: no real one does.

        mean of qd_j (W_j X), W_j the columns of friction, below -3 of its standard deviations

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        X, covariance: of the parameters, (p,) and (p, p).
    """
    mean, _ = mean_friction_power(evaluator, logs, STATES)
    count = mean.shape[1]
    power = mean @ X[:count]
    std = np.sqrt(np.maximum(np.einsum("ja,ab,jb->j", mean, covariance[:count, :count], mean), 0))
    out = np.flatnonzero(power < -SIGNIFICANT * std)
    if not len(out):
        return ()
    taus, positions = (" and ".join(f"{key}{j + 1}" for j in out) for key in ("tau", "q"))
    return (
        f"friction would drive {evaluator.model.robot.listed(out)}: check the sign of {taus} and "
        f"of {positions}, and that time increases; if they are right, an effect is missing, and "
        "symgen diagnose searches for it",
    )


def negative_mass(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, covariance: FloatArray
) -> tuple[str, ...]:
    """Say that the mass matrix is negative where the robot was: no real one is.

        v' M(q) v < -3 of its standard deviations,    v the eigenvector of the least eigenvalue

    Args:
        evaluator: the compiled model, with torque_regressor and inverse_dynamics.
        logs: the training logs.
        X, covariance: of the parameters, (p,) and (p, p).
    """
    q = np.concatenate([log.q[log.kept] for log in logs])
    q = np.ascontiguousarray(q[:: max(1, len(q) // STATES)])
    values, vectors = np.linalg.eigh(mass_matrices(evaluator, q, X))
    v, zero = np.ascontiguousarray(vectors[:, :, 0]), np.zeros_like(q)
    regressor = evaluator["torque_regressor"]
    rows = np.einsum("kj,kja->ka", v, regressor(q, zero, v) - regressor(q, zero, zero))
    C = covariance[: rows.shape[1], : rows.shape[1]]
    std = np.sqrt(np.maximum(np.einsum("ka,ab,kb->k", rows, C, rows), 0.0))
    share = float(np.mean(values[:, 0] < -SIGNIFICANT * std))
    if not share:
        return ()
    return (
        f"the mass matrix has a negative eigenvalue, by more than {SIGNIFICANT:g} std, in "
        f"{100 * share:.3g} % of the positions of the log",
    )
