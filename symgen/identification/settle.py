"""Choose between least squares and the nearest possible base parameters.

If a robot can have the parameters of least squares, they are the estimate. Else symgen fits both to
folds of the training logs, with a weak prior, and compares their torque errors on the held-out
folds. The possible parameters are the estimate unless their error is larger by a part that matters.
In that case an effect is missing, because no robot of this model moves like the logs.

The possible parameters are those of the smallest weighted squared error and weak prior. If an
effect is missing, the estimate has the weak prior, too: least squares alone extrapolates where the
logs do not determine its parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.estimation.solve import Solution
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray, OtherEstimate, Reason, Residual
from symgen.identification.estimate import Consistency
from symgen.identification.model_choice import ChosenModel
from symgen.identification.possible import Possible, nearest_possible
from symgen.identification.solving import CONSISTENT, Method
from symgen.identification.weak_prior import WeakPrior
from symgen.policy import BEYOND, LEAST, POSSIBLE, VARIES
from symgen.robot.types import Robot

#: Prefixes of friction parameters that are positive for every robot.
_FRICTION = ("FS", "FV", "FSM", "FVM")
#: Kind of the reason that the nearest possible robot predicts worse than least squares.
EFFECT_MISSING = "effect_missing"
#: Kind of the reason that only impossible parameters explain the logs.
NO_ROBOT = "no_robot"
_SHRUNK = "a weak prior holds what the logs do not determine"
_MISSING = "an effect, a wrench or a contact is missing"
_DIAGNOSE = "an effect is missing from the model: symgen diagnose searches for it"


@dataclass(frozen=True, eq=False)
class Settled:
    """The solution of the estimate, and whether a robot can have its parameters.

    Attributes:
        solution: X is that of least squares, or the nearest possible one.
        method: method of the estimate.
        physical: distance and torque errors of both, and why X is not possible.
        at_bound: names of the parameters at a bound of possible robots.
    """

    solution: Solution
    method: Method
    physical: Consistency
    at_bound: tuple[str, ...] = ()


def settle(chosen: ChosenModel, method: Method, least: Solution, prior: WeakPrior) -> Settled:
    """Return the solution without constraints or the nearest possible one, as the method requires.

    Args:
        chosen: the model with the folds of its equations.
        method: "auto" compares both, "consistent" takes the possible one, and other methods take
            the solution without constraints.
        least: the solution without constraints.
        prior: weak prior for what the equations do not determine.
    """
    model = chosen.campaign.evaluator.model
    base = method.unconstrained
    reason: Reason | None = None
    try:
        near = nearest_possible(model, least.X, least.covariance)
        if not near.fault:
            return Settled(least, method if method.name == CONSISTENT else base, Consistency(0.0))
        free = chosen.best.prior.held_out(chosen.best.blocks)
        bounded = chosen.best.prior.held_out(
            chosen.best.blocks, lambda X, C: nearest_possible(model, X, C).X
        )
    except ParameterError as error:  # the covariance is not that of all parameters
        text = f"it could not be decided whether a robot can have these parameters: {error}"
        return Settled(least, base, Consistency(None, Reason("undecided", text=text)))
    held_out = free.relative, bounded.relative
    if not method.is_bounded:
        reason = _not_possible(near)
    elif method.name != CONSISTENT and bounded.relative > largest_error(free.relative):
        reason = _missing(near, free, bounded, model.robot)
    if reason is not None:
        if method.is_bounded and method.plain:
            least = replace(least, X=prior.fit()[0], notes=(*least.notes, _SHRUNK))
        distance = near.distance if near.is_decided else None
        return Settled(least, base, Consistency(distance, reason, held_out))
    if method.plain:
        within = nearest_possible(model, *prior.fit())
        near = replace(near, X=within.X, at_bound=within.at_bound)
    moved = _moved(model, least, near, base.name)
    taken = replace(method, name=CONSISTENT)
    return Settled(moved, taken, Consistency(near.distance, None, held_out), near.at_bound)


def largest_error(least: float) -> float:
    """Return the largest acceptable held-out error of a possible robot.

    The limit is e + max(LEAST, POSSIBLE e), with e the error of least squares. LEAST is a part of
    the torque, and POSSIBLE is a part of the error.
    """
    return least + max(LEAST, POSSIBLE * least)


def like_no_robot(
    model: Model, X: FloatArray, covariance: FloatArray, errors: tuple[float, float], accept: float
) -> list[Reason]:
    """Return a reason if only impossible parameters explain the logs, as signs or time are wrong.

    Torques or positions with the wrong sign, or reversed time, fit well with friction that drives.
    An effect that the model lacks can make links impossible, but friction still brakes.

    Args:
        model: model of the robot.
        X, covariance: base parameters (p,) and their covariance (p, p).
        errors: torque errors of least squares and of the nearest possible robot.
        accept: largest torque error of a usable model. It is the limit if no friction is certain.
    """
    free, bounded = errors
    drives = _driven_by_friction(model.base.names, X, covariance)
    limit = max(accept, VARIES * free) if drives is None else largest_error(free)
    if bounded <= limit or drives == []:
        return []
    robot = model.robot
    places = [k for k, joint in enumerate(robot.movable) if joint.number in (drives or ())]
    of = f" of {robot.listed(places)}" if 0 < len(places) < robot.n else ""
    text = (
        f"no possible robot moves like this: the nearest one has {percent(bounded)} torque error; "
        f"check the signs of torques and positions{of}, and that time increases"
    )
    return [Reason(NO_ROBOT, tuple(drives or ()), bounded, limit, text)]


def joint_of_friction(name: str) -> int | None:
    """Return the joint of a friction parameter that is never negative; None for other names."""
    kind = name.rstrip("0123456789")
    return int(name.removeprefix(kind)) if kind in _FRICTION else None


def _driven_by_friction(
    names: Sequence[str], X: FloatArray, covariance: FloatArray
) -> list[int] | None:
    """Return the numbers of joints whose friction surely drives; None if no friction is certain.

    A coefficient is certain if it differs from zero by more than BEYOND standard deviations. All
    certain coefficients of the joint are negative.
    """
    certain: dict[int, list[bool]] = {}
    for name, x, variance in zip(names, X, np.diag(covariance), strict=True):
        joint = joint_of_friction(name)
        if joint is not None and x**2 > BEYOND**2 * variance:
            certain.setdefault(joint, []).append(x > 0)
    if not certain:
        return None
    return [joint for joint, signs in certain.items() if not any(signs)]


def _not_possible(near: Possible) -> Reason:
    """Return the reason for parameters that are not possible, by a method without constraints."""
    text = (
        f"{near.fault}; the nearest possible robot is {near.distance:.3g} standard deviations "
        "away: symgen identify --method auto or consistent gives it"
    )
    return Reason("not_possible", value=near.distance, text=text)


def _missing(near: Possible, free: Residual, bounded: Residual, robot: Robot) -> Reason:
    """Return the reason that the nearest possible robot predicts worse than least squares."""
    rise = np.array(bounded.per_joint) - np.array(free.per_joint)
    joints = np.flatnonzero(rise > min(LEAST, rise.max(initial=0.0)) * (1 - 1e-9))
    at = f", at {robot.listed(joints)}" if robot.n else ""
    limit = largest_error(free.relative)
    text = (
        f"{near.fault}; the nearest possible robot raises the torque error on held-out folds from "
        f"{percent(free.relative)} to {percent(bounded.relative)}{at}: "
        f"{_MISSING if robot.floating else _DIAGNOSE}"
    )
    numbers = tuple(robot.movable[j].number for j in joints)
    return Reason(EFFECT_MISSING, numbers, bounded.relative, limit, text)


def _moved(model: Model, least: Solution, near: Possible, method: str) -> Solution:
    """Return the solution with the nearest possible X, and least squares in its comparison."""
    note = (
        f"least squares is not physically possible ({near.fault}): the nearest possible "
        f"parameters are {near.distance:.3g} standard deviations away"
    )
    other = OtherEstimate.by(method, model.base.names, least.X, least.std)
    comparison = (other, *least.comparison)
    return replace(least, X=near.X, notes=(*least.notes, note), comparison=comparison)
