"""Judge whether an estimate is good for prediction and for reading parameters.

    prediction  the torque error on held-out motion is at most `accept`, no fault of the recorder or
                of the robot file is shown, and no part of the motion has a much larger error
    parameters  which parameters are known, and whether a robot can have them

`symgen.identification.simulation` judges the third use.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen import names
from symgen.data.mask import moving_joints, rms
from symgen.errors import ParameterError, first_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import above_noise
from symgen.estimation.solve import Solution
from symgen.estimation.system import kernel_inputs, torque_at
from symgen.estimation.torque_error import TorqueFit, percent, relative_error
from symgen.estimation.values import FloatArray, Reason, Residual
from symgen.hypotheses.ask import Answer
from symgen.identification.campaign import Campaign
from symgen.identification.estimate import Estimate, ParameterEstimate
from symgen.identification.settle import Settled, like_no_robot
from symgen.identification.simulation import mixed_states, motion_states, some_states
from symgen.identification.uses import KNOWN, ParametersUse, PredictionUse
from symgen.policy import (
    FRICTION_LEFT,
    GOOD,
    JOINT,
    LEAST,
    VARIES,
    WEIGHT_LEFT,
)
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Kind of the suspicion that the validation logs are of another state of the robot.
CHANGED = "changed"
OPEN = "the motion does not determine all parameters"
#: Ending of a reason whose cause is unknown.
SEARCH = "symgen diagnose searches for the cause"
_SUPPORTS = (
    "check wrenches and contacts of the log, their frames and signs, and whether other forces act"
)
#: Note on columns of torques or currents with the name of a command.
_COMMAND = r"columns by name: .*\b(tau|i)\d* = [^,\n]*(target|desired|command|cmd|ref)"
_COMPUTED = (
    "the torques contain neither friction nor noise: they look computed, as a controller's "
    "feed-forward; log the measured torque or the motor current"
)
_NO_WEIGHT = (
    "the torques contain almost nothing of the weight of the masses in the robot file: the drive "
    "adds it by itself, or the masses are wrong; log the total torque or the motor current"
)
_LITTLE_FRICTION = (
    "the torques contain a small part of the friction in the robot file: the drive may add the "
    "rest by itself; log the total torque or the motor current"
)
#: Kind of the reason that torques are counted in the input of a drive.
_SCALE_UNKNOWN = "drive_scale_unknown"
_SCALED = (
    "the gains of [controller] are known up to a common factor, which scales all torques, masses, "
    "inertias and friction alike and which no such log determines: only ratios of parameters hold"
)


def prediction_use(
    campaign: Campaign,
    settled: Settled,
    held: TorqueFit,
    noise: Residual,
    accept: float,
    least: float,
) -> PredictionUse:
    """Judge the torque error on held-out motion, for joints in motion if any joint moves.

    Args:
        campaign: the logs, with the faults that are shown.
        settled: the solution, and whether a robot can have its parameters.
        held: torques of the validation logs.
        noise: torque error that noise alone causes on them.
        accept: largest torque error of a usable model, as a part of the torque.
        least: smallest torque that matters, as a part of the torque.
    """
    error, fold = held.in_motion.residual.relative, campaign.answer.largest_fold_error
    reasons = list(campaign.answer.shown)
    large = _large_errors(campaign, held, noise, accept)
    grade = "usable" if large or error > GOOD else "good"
    search = _SUPPORTS if campaign.robot.floating else SEARCH
    if error <= accept:
        if settled.physical.reason is not None and settled.physical.held_out is not None:
            model, fitted = campaign.evaluator.model, settled.solution
            errors = settled.physical.held_out
            reasons += like_no_robot(model, fitted.X, fitted.covariance, errors, accept)
        if large and large[0].value > JOINT and not reasons:
            text = f"the torque error of a joint is above {100 * JOINT:g} %; {search}"
            reasons.append(replace(large[0], kind="joint_error", limit=JOINT, text=text))
    else:
        grade = "poor"
        reasons += _not_excited(campaign, settled.solution, accept)
        reasons += _mostly_noise(min(noise.relative, error))
        text = f"the torque error is above {100 * accept:g} %"
        if not reasons:
            text += f"; {search}"
        reasons.append(Reason("error", value=error, limit=accept, text=text))
    if _much_larger(fold, error, least):
        text = (
            f"the error depends on the motion: {percent(fold)} on another part of the motion that "
            f"the fit did not use; {search}"
        )
        reasons.append(Reason("varies", value=fold, limit=VARIES * error, text=text))
    return PredictionUse(tuple(reasons), grade=grade, large=tuple(large))


def parameters_use(
    parameters: Sequence[ParameterEstimate],
    settled: Settled,
    unexplained: float | None,
    bias: str,
    *,
    scale: Reason | None,
    lift: Sequence[str] = (),
) -> ParametersUse:
    """Judge which parameters are known, and collect reasons against reading single values.

    Args:
        parameters: parameters of the estimate.
        settled: whether a robot can have them, and which of them are at a bound.
        unexplained: part of the torque that neither the model nor noise explains; None if it is
            not visible.
        bias: a text on the bias of least squares, or "".
        scale: reason that the scale of torques is unknown, or None.
        lift: contacts of a floating base that never lift.
    """
    reasons = []
    if scale is not None:
        reasons.append(scale)
    if unexplained is not None:
        text = f"do not read single values: {percent(unexplained)} of the torque is unexplained"
        reasons.append(Reason("unexplained", value=unexplained, text=text))
    if bias:
        reasons.append(Reason("biased", text=bias))
    hidden = [p.name for p in parameters if math.isnan(p.std)]
    bound, count = settled.at_bound, len(parameters)
    inside = [p for p in parameters if p.name not in bound]
    weak = [p.name for p in inside if p.relative_std_percent > KNOWN]
    known = [p.name for p in inside if p.relative_std_percent <= KNOWN]
    against = settled.physical.reason
    if against is not None and not hidden:
        prefix = "" if settled.physical.possible is None else "not physically possible: "
        reasons.append(replace(against, text=f"{prefix}{against.text}"))
    verbs = ("lifts", "it does") if len(lift) == 1 else ("lift", "they do")
    still = f" ({', '.join(lift)} never {verbs[0]}: log a motion in which {verbs[1]})"
    for kind, some, what in (
        ("not_determined", hidden, f"{OPEN}{still if lift else ''}"),
        ("weak", weak, f"{len(weak)} of {count} are weak (std above {KNOWN:g} %)"),
        ("at_bound", bound, f"{len(bound)} of {count} are at a bound of possible robots"),
    ):
        if some:
            text = f"{what}: {first_of(some)}"
            reasons.append(Reason(kind, value=float(len(some)), text=text))
    return ParametersUse(
        tuple(reasons),
        () if scale is not None and scale.kind == "scale_unknown" else tuple(known),
        count,
    )


def suspicions(
    campaign: Campaign, solution: Solution, torques: tuple[TorqueFit, TorqueFit], accept: float
) -> list[Reason]:
    """Return possible faults of the logs, and reasons against predicting other motions.

    Args:
        campaign: the logs.
        solution: the solution.
        torques: torques of the training and of the validation logs.
        accept: largest torque error of a usable model, as a part of the torque.
    """
    reasons = _hardly_moving(campaign.train, campaign.robot)
    if campaign.has_validation:
        errors = (fit.in_motion.residual.relative for fit in torques)
        reasons += changed_state(*errors, diagnosed=not campaign.robot.floating)
    other = uncertain_torque(
        campaign.evaluator, campaign.train, solution.noise, mixed=True
    ).relative
    if other > accept:
        text = (
            "on other motions in the same range the uncertainty of the parameters alone causes "
            f"{percent(other)} torque error; symgen excite plans a motion that determines them"
        )
        reasons.append(Reason("not_excited", value=other, limit=accept, text=text))
    return reasons


def _much_larger(error: float, other: float, least: float) -> bool:
    """Return whether an error is VARIES times another one, and explains `least` of the torque."""
    rise = math.sqrt(max(error**2 - other**2, 0.0))
    return error > VARIES * other and rise > least


def changed_state(train: float, held: float, *, diagnosed: bool = True) -> list[Reason]:
    """Return a reason if the torque error on the validation logs is much larger than on training.

    Args:
        train, held: torque errors of joints in motion on the training and on the validation logs.
        diagnosed: whether symgen diagnose takes the robot.
    """
    if not _much_larger(held, train, LEAST):
        return []
    advice = "compare load, temperature and motion"
    if diagnosed:
        advice = (
            "compare load (symgen payload), temperature and motion; symgen diagnose with the "
            "validation logs and --parameters searches for what changed"
        )
    text = (
        f"the torque error is {percent(train)} on the training logs and {percent(held)} on the "
        f"validation logs: {advice}"
    )
    return [Reason(CHANGED, value=held, limit=VARIES * train, text=text)]


def _not_excited(campaign: Campaign, solution: Solution, accept: float) -> list[Reason]:
    """Return a reason if the training logs leave the torque of the held-out motion uncertain."""
    train, held = (
        uncertain_torque(campaign.evaluator, logs, solution.covariance)
        for logs in (campaign.train, campaign.held)
    )
    limit = max(accept, VARIES * train.relative)
    if held.relative <= limit:
        return []
    robot = campaign.robot
    before, after = (np.array(x.per_joint) for x in (train, held))
    places = np.flatnonzero(after > np.maximum(accept, VARIES * before)).tolist()
    text = (
        "the training logs do not determine what this motion needs: the uncertainty of the "
        f"parameters alone causes {percent(held.relative)} torque error; move "
        f"{robot.listed(places)} together in one training log; symgen excite plans such a motion"
    )
    return [Reason("not_excited", _numbers(robot, places), held.relative, limit, text)]


def _mostly_noise(noise: float) -> list[Reason]:
    """Return a reason if more than half of the power of the measured torque is noise."""
    half = math.sqrt(1 / 2)
    if not noise > half:  # NaN if the noise is unknown
        return []
    text = f"the torque is mostly noise ({percent(noise)}): record larger torques"
    return [Reason("noise", value=noise, limit=half, text=text)]


def _large_errors(
    campaign: Campaign, held: TorqueFit, noise: Residual, accept: float
) -> list[Reason]:
    """Return the driven joints in motion with a large torque error, the largest first.

    It is above `accept` and above three times its noise floor.
    """
    robot = campaign.robot
    each = np.array(held.in_motion.residual.per_joint)
    above = above_noise(each, noise.per_joint or (), accept)
    above[robot.passive] = False
    moving = moving_joints([log.qd for log in campaign.held], robot.sigma)
    measured = np.concatenate([log.measured for log in campaign.held])
    size = each * rms(measured)[len(robot.free) :]
    reasons = []
    for j in sorted(moving, key=lambda j: -each[j]):
        if above[j]:
            unit = names.unit("OF", robot.sigma[j])
            joint = robot.listed([j])
            text = f"{percent(each[j])} on {joint}, {size[j]:.3g} {unit}"
            reasons.append(Reason("large_error", _numbers(robot, [j]), each[j], accept, text))
    return reasons


def _hardly_moving(logs: Sequence[FilteredLog], robot: Robot) -> list[Reason]:
    """Return a reason for each joint that stays slower than 2 % of the fastest one of its kind.

    Parameters that are fitted to such slow motion may be wrong for faster motion of the joint,
    whatever their standard deviation.
    """
    moving = moving_joints([log.qd for log in logs], robot.sigma)
    size = np.ptp(np.concatenate([log.q for log in logs]), axis=0)
    reasons = []
    for j, kind in enumerate(robot.sigma):
        if j in moving:
            continue
        unit = "m" if kind == names.PRISMATIC else "rad"
        text = (
            f"{robot.listed([j])} hardly moves ({size[j]:.2g} {unit} in all): its friction and "
            "inertia hold for no larger motion; move it too, or fix it in the robot (sigma = 2; "
            "symgen import --fix)"
        )
        reasons.append(Reason("hardly_moving", _numbers(robot, [j]), float(size[j]), text=text))
    return reasons


def restrictions(proportional: Sequence[Sequence[int]], robot: Robot) -> list[Reason]:
    """Return a reason for each group of joints that moved in proportion in all training logs."""
    text = (
        "this model holds only for motion in which {} move in proportion, as in the training logs"
    )
    return [
        Reason("in_proportion", _numbers(robot, group), text=text.format(robot.listed(group)))
        for group in proportional
    ]


def with_incomplete_torques(campaign: Campaign, X: FloatArray, noise: Residual) -> Answer:
    """Return what a search found, with a fault if the torques lack friction or weight of the robot.

    The feed-forward of a controller has neither friction nor noise. A drive that adds torque for
    weight or friction itself may log the rest. A simulated robot may have no friction either: this
    is a fault only if the robot file states friction, or the columns have the name of a command.

    Args:
        campaign: the logs.
        X: parameters, (p,).
        noise: torque error that noise alone causes on the validation logs.
    """
    answer, evaluator = campaign.answer, campaign.evaluator
    if campaign.train[0].samples.drive_unit:  # the file states torques
        return answer
    of_file = 0 * X if campaign.file_values is None else campaign.file_values
    rubs = np.arange(len(X)) >= evaluator.model.inertial
    q, qd, qdd, *base = some_states(*motion_states(campaign.train))

    def torque(values: FloatArray, rate: int) -> FloatArray:
        return rms(torque_at(evaluator, values, q, rate * qd, rate * qdd, *base))

    if rms(torque(X, 0)) < WEIGHT_LEFT * rms(torque(of_file, 0)):
        return replace(answer, shown=(Reason("no_weight", text=_NO_WEIGHT),))
    if rms(rubs * X) < FRICTION_LEFT * rms(rubs * of_file):
        little = Reason("little_friction", text=_LITTLE_FRICTION)
        answer = replace(answer, suspected=(*answer.suspected, little))
    if (
        rubs.any()
        and math.isnan(noise.relative)
        and (torque(rubs * X, 1) <= LEAST * torque(X, 1)).all()
    ):
        computed = (Reason("computed_torque", text=_COMPUTED),)
        named = re.search(_COMMAND, "\n".join(campaign.train[0].samples.notes))
        if named or campaign.robot.drive or (rubs * of_file).any():
            return replace(answer, shown=computed)
        answer = replace(answer, suspected=(*answer.suspected, *computed))
    return answer


def _numbers(robot: Robot, places: Sequence[int]) -> tuple[int, ...]:
    """Return the joint numbers in the robot file of some positions."""
    return tuple(robot.movable[j].number for j in places)


def uncertain_torque(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    covariance: FloatArray,
    *,
    mixed: bool = False,
) -> Residual:
    """Return the torque error that the uncertainty of X causes, total and by joint.

        sqrt(mean over states of diag(W C W')) over the RMS of the measured torque

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: logs with the motion.
        covariance: C of X, (p, p).
        mixed: whether the joints of a state are drawn from the logs independently.
    """
    chosen = mixed_states if mixed else some_states
    states = chosen(*motion_states(logs))
    W = evaluator["torque_regressor"](*kernel_inputs(states))
    C = covariance[: W.shape[2], : W.shape[2]]
    variance = np.maximum(np.einsum("kja,ab,kjb->j", W, C, W) / len(W), 0.0)
    robot = evaluator.model.robot
    variance[[len(robot.free) + j for j in robot.passive]] = 0.0
    tau = np.concatenate([log.measured for log in logs])
    return relative_error(variance, np.mean(tau**2, axis=0), robot.kinds)


def scale_unknown(campaign: Campaign) -> Reason | None:
    """Return the reason that the logs tell torques only up to a factor, or None."""
    scales, robot = campaign.scales, campaign.robot
    if scales is not None:
        joints = [j for j, reference in enumerate(scales.reference) if reference >= 0]
        if not joints:
            return None
        references = sorted({scales.reference[j] for j in joints})
        text = (
            f"torques of {robot.listed(joints)} are counted in the {scales.unit} of "
            f"{robot.listed(references)}, and with them masses, inertias and friction; accepted "
            "for N m: --carried LOG --mass KG, or torque_constant, resistance and supply in [drive]"
        )
        return Reason(_SCALE_UNKNOWN, tuple(robot.numbers[j] for j in joints), text=text)
    servo = robot.controller
    if servo is None or servo.scale != "unknown":
        return None
    of_gains = any(log.samples.command is not None for log in campaign.train)
    return Reason("scale_unknown", text=_SCALED) if of_gains else None


def require_scale(estimate: Estimate, refused: str) -> None:
    """Raise ParameterError if torques of an estimate are counted in the input of a drive.

    Args:
        estimate: the estimate.
        refused: what needs torques in N m, and is refused.
    """
    for reason in estimate.uses.parameters.reasons if estimate.uses else ():
        if reason.kind == _SCALE_UNKNOWN:
            raise ParameterError(f"{refused}, {reason.text}")
