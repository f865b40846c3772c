"""The verdict: what may these numbers be used for, and if not, why, in words.

    prediction  the torque error on held-out motion is small, not learned by heart, and what the
                covariance of X says of other motions in the same range is no larger
    parameters  which of them are known, and whether a robot can have them
    simulation  the mass matrix is positive definite over the range of the motion, and friction
                takes energy out

How often they are right is counted on simulated runs on which none of the thresholds was chosen
(tests/workflow/trust_study.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.data.mask import at_rest
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.fit import TorqueFit
from symgen.faults.samples import at_standstill
from symgen.identification.estimate import Consistency, ParameterEstimate, Use
from symgen.identification.parameters import mass_matrices
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Largest torque error on held-out motion that counts as explained: in all, and of one joint.
RESIDUAL, JOINT = 0.25, 0.6
#: Held-out torque error over that of the training logs above which the log was learned by heart.
OVERFIT = 3.0
#: Error of torque on other motions in the same range, as the covariance of X has it, over what is
#: said.
ELSEWHERE = 1.0
#: Torque errors below this are not worth a doubt.
NEGLIGIBLE = 0.01
#: Condition number of the scaled regressor above which small errors of the data become large.
CONDITION = 500.0
#: Independent windows that each parameter needs.
WINDOWS = 3.0
#: Speeds closer than this to a linear relation are proportional.
PROPORTIONAL = 0.03
#: Condition number from which a motion with proportional speeds is refused.
PROPORTIONAL_CONDITION = 10.0
#: Parameters that are positive by their nature, and how many standard deviations make a sign sure.
POSITIVE = ("FS", "FV", "IA", "M", "FSM", "FVM", "IAM")
SIGNIFICANT = 3.0
#: Relative standard deviation up to which a parameter is known, in percent.
KNOWN = 30.0
_BEYOND_DOUBT = 7.0  # standard deviations
#: States that are drawn to look at a model elsewhere, and their seed.
STATES, SEED = 500, 1988
_FARTHER = "symgen excite writes a motion that shows them"


@dataclass(frozen=True)
class Verdict:
    """What an estimate may be used for.

    Attributes:
        uses: prediction, parameters, simulation.
        reasons: why it is doubtful; empty where it is trusted.
        headline: in one line: what it is trusted for, and what stands beside that.
    """

    uses: tuple[Use, ...]
    reasons: tuple[str, ...]
    headline: str

    @property
    def word(self) -> str:
        """trusted or doubtful."""
        return "doubtful" if self.reasons else "trusted"


def prediction_use(
    train: TorqueFit,
    held: TorqueFit,
    elsewhere: float,
    faults: Sequence[str],
    suspects: Sequence[str] = (),
) -> Use:
    """Judge the torque on held-out motion: of joints that move, where any does.

    Args:
        train: torques of the training logs.
        held: of data that the estimate never saw.
        elsewhere: torque error on other motions in the same range, from `error_elsewhere`.
        faults: of the logs that matter and could not be mended.
        suspects: what was seen in the logs and left; the reason, where the torque is unexplained.
    """
    reasons = list(faults)
    train, held = (f.in_motion if f.in_motion.size.any() else f for f in (train, held))
    said, own = held.residual.relative, train.residual.relative
    if said > RESIDUAL:
        reasons.append(
            f"the model leaves {100 * said:.3g} % of the torque of held-out motion unexplained"
        )
    bad = [(j, r) for j, r in enumerate(held.ratios, 1) if r > JOINT and _counts(held, j - 1)]
    if bad:
        listed = ", ".join(f"{j} ({100 * r:.3g} %)" for j, r in bad)
        reasons.append(f"the torque of held-out motion is unexplained at movable joints {listed}")
    if said > RESIDUAL or bad:
        reasons += suspects
    if said > max(OVERFIT * own, NEGLIGIBLE):
        reasons.append(
            f"overfit: the torque error on held-out motion is {100 * said:.3g} %, "
            f"{said / max(own, 1e-300):.3g} times that on the training logs"
        )
    if elsewhere > max(ELSEWHERE * said, NEGLIGIBLE):
        reasons.append(
            f"the motion does not carry its parameters: other motions in the same range would have "
            f"{100 * elsewhere:.2g} % torque error from their uncertainty alone; record a richer "
            f"one, {_FARTHER}"
        )
    return Use("prediction", tuple(reasons))


def _counts(fit: TorqueFit, j: int) -> bool:
    """Whether a joint's torque is more than a hundredth of the whole."""
    return bool(fit.size[j] > 1e-4 * fit.size.sum())


def error_elsewhere(
    evaluator: Evaluator, logs: Sequence[FilteredLog], covariance: FloatArray
) -> float:
    """Return the torque error on other motions of the same range, from the covariance of X alone.

        sqrt(sum over states of tr(W C W')) / sqrt(sum over states of tau' tau)

    with W at states whose joints are drawn from the logs independently of each other: each joint
    as it was, but in company that it did not keep; and tau those of the logs.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        covariance: of X, (p, p).
    """
    draw = np.random.default_rng(SEED)
    q, qd, qdd, tau = (
        np.concatenate([getattr(log, key)[log.kept] for log in logs])
        if key != "measured"
        else np.concatenate([log.measured for log in logs])
        for key in ("q", "qd", "qdd", "measured")
    )
    rows = draw.integers(len(q), size=(STATES, q.shape[1]))
    joints = np.arange(q.shape[1])
    W = evaluator["torque_regressor"](
        *(np.ascontiguousarray(x[rows, joints]) for x in (q, qd, qdd))
    )
    linear = W.shape[2]
    spread = np.einsum("kja,ab,kjb->", W, covariance[:linear, :linear], W) / STATES
    size = float(np.mean(np.sum(tau**2, axis=1)))
    return float(np.sqrt(max(spread, 0.0) / max(size, 1e-300)))


def parameters_use(
    parameters: Sequence[ParameterEstimate],
    physical: Consistency,
    doubts: Sequence[str],
) -> Use:
    """Say which parameters are known, and what speaks against them as those of a robot."""
    known = tuple(p.name for p in parameters if p.relative_std_percent <= KNOWN)
    reasons = list(doubts)
    weak = [p.name for p in parameters if p.name not in known]
    if weak:
        listed = ", ".join(weak[:8]) + (", ..." if len(weak) > 8 else "")
        reasons.append(
            f"{len(weak)} of {len(parameters)} are weak (std above {KNOWN:g} %): {listed}"
        )
    negative = negative_parameters(parameters)
    if negative:
        reasons.append(f"{', '.join(negative)} must be positive and came out negative")
    if physical.feasible is False:
        reasons.append(f"no robot can have them: {physical.reason}")
    return Use("parameters", tuple(reasons), known)


def driving_friction(parameters: Sequence[ParameterEstimate]) -> tuple[str, ...]:
    """Name joints whose friction would drive them beyond doubt: a sign of a channel, or of time."""
    out = []
    values = {p.name: p for p in parameters}
    for name, p in values.items():
        other = values.get(f"{'FV' if name.startswith('FS') else 'FS'}{name[2:]}")
        if name[:2] not in ("FS", "FV") or not name[2:].isdigit():
            continue
        helps = other is not None and other.value > SIGNIFICANT * other.std
        if p.value < -_BEYOND_DOUBT * p.std and not helps:
            out.append(name)
    if not out:
        return ()
    return (
        f"friction would drive the robot at {_joints(out)}: {', '.join(out)} negative beyond "
        "doubt; the sign of tau or of q of these joints, or time itself, runs the other way",
    )


def _joints(names: Sequence[str]) -> str:
    numbers = list(dict.fromkeys(name[2:] for name in names))
    return f"joint{'s' if len(numbers) > 1 else ''} {', '.join(numbers)}"


def negative_parameters(parameters: Sequence[ParameterEstimate]) -> list[str]:
    """Return what must be positive and is negative beyond doubt."""
    return [
        p.name
        for p in parameters
        if p.expression == p.name
        and p.name.rstrip("0123456789") in POSITIVE
        and p.value < -SIGNIFICANT * p.std
    ]


def simulation_use(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    X: FloatArray,
    parameters: Sequence[ParameterEstimate],
) -> Use:
    """Judge whether the model can be simulated over the range of the motion.

    The mass matrix has to be positive definite at positions of the logs, and at positions whose
    joints are drawn from them independently; coefficients of friction must not be negative.
    """
    draw = np.random.default_rng(SEED)
    q = np.concatenate([log.q[log.kept] for log in logs])
    rows = draw.integers(len(q), size=(STATES, q.shape[1]))
    mixed = q[rows, np.arange(q.shape[1])]
    seen = q[:: max(1, len(q) // STATES)]
    at = np.ascontiguousarray(np.concatenate([seen, mixed]))
    M = mass_matrices(evaluator, at, X)
    least = np.linalg.eigvalsh((M + M.transpose(0, 2, 1)) / 2)[:, 0]
    reasons = []
    if (least <= 0).any():
        share = 100 * float(np.mean(least <= 0))
        reasons.append(
            f"the mass matrix is not positive definite at {share:.3g} % of the positions of the "
            "motion's range"
        )
    rubs = [
        p.name
        for p in parameters
        if p.name.rstrip("0123456789") in ("FS", "FV", "FSM", "FVM") and p.value < 0
    ]
    if rubs:
        reasons.append(f"{', '.join(rubs)} is negative: friction would drive the joint")
    return Use("simulation", tuple(reasons))


def verdict(
    prediction: Use, parameters: Use, simulation: Use, count: int, rests: Sequence[str] = ()
) -> Verdict:
    """Put the uses together.

    Args:
        prediction, parameters, simulation: as judged.
        count: number of parameters.
        rests: what is said of joints at rest.
    """
    uses = (prediction, parameters, simulation)
    if not prediction.ok:
        return Verdict(uses, prediction.reasons, f"doubtful: {'; '.join(prediction.reasons)}")
    known = f"{len(parameters.known)} of {count} parameters known"
    beside = [*rests, known, *parameters.reasons]
    beside += [f"not for simulation: {reason}" for reason in simulation.reasons]
    mend = []
    if unphysical(parameters) or not simulation.ok:
        mend.append("--method consistent")
    if len(parameters.known) < count:
        mend.append("a richer motion (symgen excite)")
    said = f"; mended by {' and '.join(mend)}" if mend else ""
    return Verdict(uses, (), f"trusted for prediction; {'; '.join(beside)}{said}")


def unphysical(parameters: Use) -> bool:
    """Whether parameters were judged to be those of no robot."""
    return any("must be positive" in r or "no robot" in r for r in parameters.reasons)


def standing(logs: Sequence[FilteredLog]) -> list[int]:
    """Return the joints that stand still in all logs: what they seem to move is noise."""
    n = logs[0].q.shape[1]
    still = np.ones(n, dtype=bool)
    for log in logs:
        same = np.ptp(log.samples.q, axis=0) == 0
        if log.band.filters(log.step):
            same |= at_standstill(log.samples.q, log.q, log.step, log.band.cutoff_hz)
        still &= same
    return [int(j) for j in np.flatnonzero(still)]


def hardly_moving(logs: Sequence[FilteredLog], sigma: Sequence[int]) -> tuple[str, ...]:
    """Say which joints stay slower than 2 % of the fastest one of their kind in all logs.

    What is fitted there carries over to faster motions of these joints by chance only, whatever
    its standard deviation.
    """
    qd = np.concatenate([log.qd for log in logs])
    q = np.concatenate([log.q for log in logs])
    _, still = at_rest(qd, logs[0].step, sigma)
    out = []
    for j in map(int, np.flatnonzero(still)):
        length = "m" if sigma[j] == names.PRISMATIC else "rad"
        out.append(
            f"movable joint {j + 1} hardly moves ({np.ptp(q[:, j]):.2g} {length} in all): its "
            "friction and inertia hold for no larger motion; move it too, or fix it in the robot "
            "(sigma = 2; symgen import --fix)"
        )
    return tuple(out)


def motion_fault(logs: Sequence[FilteredLog], still: Sequence[int]) -> str:
    """Return in words why a motion cannot excite a model, or ''.

    Gautier and Khalil warn of joint speeds that stay proportional: the arm then moves as one body
    with one degree of freedom, and the information matrix is singular.

    Args:
        logs: in the band of the run.
        still: the joints that stand still in all of them.
    """
    qd = np.concatenate([log.samples.qd for log in logs])
    if still:
        return (
            f"movable joints {', '.join(str(j + 1) for j in still)} do not move: move them too, or "
            "fix them in the robot (sigma = 2; symgen import --fix)"
        )
    if qd.shape[1] < 2:
        return ""
    norms = np.linalg.norm(qd, axis=0)
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
