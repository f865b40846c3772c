"""The verdict: may these numbers be trusted, and if not, why, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.data.bandwidth import motion_bandwidth
from symgen.data.signals import Samples, can_filter, differentiate, lowpass
from symgen.identification.estimate import ParameterEstimate, Residual

#: Condition number of the scaled regressor above which small errors of the data become large.
CONDITION = 500.0
#: Validation residual over training residual above which the model has learned the log by heart.
OVERFIT = 3.0
#: Largest validation residual of energy, and of a joint's torque, that counts as explained.
RESIDUAL, TORQUE = 0.25, 0.6
#: Independent windows that each parameter needs.
WINDOWS = 3.0
#: Speeds closer than this to a linear relation are proportional.
PROPORTIONAL = 0.03
#: Condition number from which a motion with proportional speeds is refused.
PROPORTIONAL_CONDITION = 10.0
#: Parameters that are positive by their nature, and how many standard deviations make a sign sure.
POSITIVE = ("FS", "FV", "IA", "M", "FSM", "FVM", "IAM")
SIGNIFICANT = 3.0
#: Correlation of measured speeds with dq/dt, and deviation of their ratio from 1, in the band.
AGREEMENT, GAIN = 0.9, 0.05
#: Share of samples whose kinetic energy may come out negative.
NEGATIVE_ENERGY = 0.01


def reasons(
    *,
    condition: float,
    train: Residual,
    validation: Residual,
    torque: Residual | None,
    windows: float,
    parameters: int,
) -> tuple[str, ...]:
    """Return why an estimate of the energy model is doubtful; empty when it can be trusted.

    Args:
        condition: condition number of the scaled regressor.
        train: residual of the equations on training data.
        validation: the same on data that the estimate never saw.
        torque: residual of the torque there, per joint.
        windows: length of the training data in windows: the number of independent equations.
        parameters: number of parameters.
    """
    out = []
    if windows < WINDOWS * parameters:
        out.append(
            f"the logs hold {windows:.0f} independent windows for {parameters} parameters; "
            "record longer or several runs, or shorten the window"
        )
    if condition > CONDITION:
        out.append(
            f"the condition number of the scaled regressor is {condition:.3g}, above "
            f"{CONDITION:g}: the motion does not excite all parameters; record a richer one"
        )
    if validation.relative > OVERFIT * train.relative and validation.relative > 0.01:
        out.append(
            f"overfit: the residual on validation data is {100 * validation.relative:.3g} %, "
            f"{validation.relative / train.relative:.3g} times the one on training data"
        )
    if validation.relative > RESIDUAL:
        out.append(
            f"the model leaves {100 * validation.relative:.3g} % of the energy of the validation "
            "data unexplained"
        )
    if torque is not None and torque.per_joint is not None:
        bad = [(j, r) for j, r in enumerate(torque.per_joint, 1) if r > TORQUE]
        if bad:
            joints = ", ".join(f"{j} ({100 * r:.3g} %)" for j, r in bad)
            out.append(
                "the torque of the validation data is unexplained at movable joints " + joints
            )
    return tuple(out)


def unphysical(
    parameters: Sequence[ParameterEstimate], kinetic: NDArray[np.float64]
) -> tuple[str, ...]:
    """Return what no robot can have: negative friction, rotor inertia or kinetic energy.

    Args:
        parameters: the estimate.
        kinetic: kinetic energy of the identified model along the training data, (K,), J.
    """
    out = []
    negative = [
        p.name
        for p in parameters
        if p.expression == p.name
        and p.name.rstrip("0123456789") in POSITIVE
        and p.value < -SIGNIFICANT * p.std
    ]
    if negative:
        out.append(
            f"{', '.join(negative)} must be positive and came out negative; check signs and units "
            "of the torques"
        )
    share = float(np.mean(kinetic < -1e-3 * np.abs(kinetic).max(initial=0.0)))
    if share > NEGATIVE_ENERGY:
        out.append(
            f"the kinetic energy is negative at {100 * share:.3g} % of the samples: not a robot; "
            "check the signs of q and tau, or record a richer motion"
        )
    return tuple(out)


def velocity_faults(samples: Samples) -> tuple[str, ...]:
    """Return the joints whose measured qd does not belong to q: wrong unit, sign or channel.

    dq/dt of the spline through q is regressed on qd, both in the motion's band.
    """
    if samples.velocity_derived:
        return ()
    band = motion_bandwidth(samples.q, samples.step)
    rate = differentiate(samples.q, samples.step)
    qd = samples.qd
    if can_filter(band, samples.step):
        rate, qd = lowpass(rate, samples.step, band), lowpass(qd, samples.step, band)
    out = []
    for j in range(qd.shape[1]):
        size, own = float(qd[:, j] @ qd[:, j]), float(rate[:, j] @ rate[:, j])
        if size == 0.0 or own == 0.0:
            continue
        along = float(rate[:, j] @ qd[:, j])
        gain, agreement = along / size, along / np.sqrt(size * own)
        if abs(agreement) < AGREEMENT:
            out.append(
                f"{samples.name}: qd{j + 1} does not follow dq{j + 1}/dt (correlation "
                f"{agreement:.2f}); check channels, delay and stamps"
            )
        elif abs(gain - 1) > GAIN:
            out.append(
                f"{samples.name}: dq{j + 1}/dt is {gain:.4g} times qd{j + 1}; check units, "
                "gear ratio and sign"
            )
    return tuple(out)


def motion_fault(logs: Sequence[Samples]) -> str:
    """Return in words why a motion cannot excite a model, or ''.

    Gautier and Khalil warn of joint speeds that stay proportional: the arm then moves as one body
    with one degree of freedom, and the information matrix is singular.
    """
    qd = np.concatenate([s.qd for s in logs])
    if qd.shape[1] < 2:
        return ""
    norms = np.linalg.norm(qd, axis=0)
    still = [j for j, v in enumerate(norms, 1) if v == 0]
    if still:
        return f"movable joints {', '.join(map(str, still))} do not move"
    cosines = (qd / norms).T @ (qd / norms)
    pairs = [
        (j + 1, k + 1, float(np.sqrt(max(0.0, 1 - cosines[j, k] ** 2))))
        for j in range(qd.shape[1])
        for k in range(j)
    ]
    j, k, apart = min(pairs, key=lambda pair: pair[2])
    if apart < PROPORTIONAL:
        return (
            f"the speeds of movable joints {k} and {j} are proportional to each other throughout "
            f"(to {100 * apart:.2g} %); move the joints independently"
        )
    return ""
