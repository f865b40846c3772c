"""Link parameters of a possible robot, and a check of their plausibility.

Of all links that give X, the nearest to those of a file minimise the log-determinant divergence of
their pseudo-inertias. It has no units and is the same in every frame (Lee, Wensing, Park 2020).

    minimise sum over links of tr(C^-1 P) - log det(C^-1 P),   C the pseudo-inertia in the file

At the limit of the possible, almost no links give X, and they may weigh tonnes. X = X0 + L z may
then move slightly, with L L' its covariance, and |z / 0.01|^2 is added to the sum.

Torques in N mm or in kN m fit equally well, with parameters a thousand times too large or small.
The inertia M_jj of a joint, divided by the square of the robot's reach from the joint, is an
apparent mass. A note warns if this mass is tonnes for all joints, or a few grams for all joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen import names
from symgen.codegen.model import Model
from symgen.data.raw import Bools
from symgen.errors import ParameterError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.identification.interior import minimise
from symgen.identification.parameters import is_finite, mass_matrices
from symgen.identification.possible import (
    CERTAIN,
    Constraints,
    Margin,
    nearest_possible,
)
from symgen.identification.pseudo_inertia import (
    BASIS,
    LENGTH,
    about_centre,
    least_eigenvalues,
)
from symgen.identification.simulation import motion_states, some_states
from symgen.names import REVOLUTE
from symgen.robot.body import Body
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Weight of the size of parameters that are not in the prior.
_UNNAMED = 1e-3
#: Margin below which X is at the limit of the possible, and the standard deviations by which it may
#: move there.
_AT_LIMIT, _STRAY = 1e-6, 0.01


def bodies(robot: Robot, values: Mapping[str, float]) -> tuple[Body, ...]:
    """Return the link of every joint of the file, including fixed joints, and link 0 if it is free.

    With c = m/M, the inertia about the centre of mass is J - M (c'c I - c c'). A link whose
    parameters are all 0 is a frame without mass. A payload is part of its link.

    Args:
        robot: the mechanism.
        values: standard parameters by name, with all those of links (XX3 ... M3, XXL ... ML).
    """
    out = []
    for joint in robot.bodies:
        suffixes = [str(joint.number)] + ["L"] * (robot.payload == joint.number)
        rows = [[values[f"{prefix}{suffix}"] for prefix in names.LINK] for suffix in suffixes]
        link = np.sum(rows, axis=0)
        frame = 0.0, np.zeros(3), np.zeros((3, 3))
        out.append(Body(joint.number, *(about_centre(link) if link.any() else frame)))
    return tuple(out)


@dataclass(frozen=True, eq=False)
class LinkParameters:
    """Physically possible standard parameters of all links.

    Attributes:
        values: every standard parameter by name, in the order of the model.
        X: (p,) base parameters of these values.
        sigmas: distance sqrt(d' C^-1 d), with d the difference of X from the requested X; 0 if they
            are equal.
        bodies: mass, centre of mass and inertia of the link of each joint.
    """

    values: Mapping[str, float]
    X: FloatArray
    sigmas: float
    bodies: tuple[Body, ...]


def link_parameters(
    model: Model,
    X: Sequence[float] | FloatArray,
    *,
    prior: Mapping[str, float] | None = None,
    nearest: FloatArray | None = None,
) -> LinkParameters:
    """Find physically possible link parameters that give the base parameters X.

    Of all such sets, it returns the one whose links are closest to those of the prior, by the
    log-determinant divergence of their pseudo-inertias. Without a prior, it returns the smallest
    set, in units of a typical length and mass of the robot.

    Args:
        model: model from `derive`.
        X: base parameters (p,), for example `estimate.X`.
        prior: standard parameters by name, for example from CAD. Parameters without a prior become
            small, with a thousandth of the weight.
        nearest: covariance (p, p) of X, for example `estimate.covariance`. With it, the function
            replaces an impossible X by the nearest possible one. An X at the limit of the possible
            moves slightly. `sigmas` is the distance.

    Raises:
        ParameterError: no link parameters give X (the message has the reason), or X or the prior
            do not belong to this robot.
    """
    problem = Constraints.of(model, X)
    prior = prior or {}
    _require_standard(model, prior)
    L, X0 = None, problem.X
    if nearest is not None:
        covariance = np.asarray(nearest, dtype=float)
        problem = Constraints.of(model, nearest_possible(model, X0, covariance).X)
        if covariance.shape == (len(X0),) * 2 and np.isfinite(covariance).all():
            L = problem.axes(covariance)
    elif fault := problem.fault()[0]:
        raise ParameterError(
            f"{model.robot.name}: no link parameters of these base parameters are known: {fault}; "
            "accepted: nearest=covariance of X, for the nearest possible values"
        )
    s, X1 = _closest(problem, prior, L)
    sigmas = 0.0 if L is None else float(np.linalg.norm(np.linalg.solve(L, X1 - X0)))
    standard = [p.name for p in model.base.standard]
    values = dict(zip(standard, map(float, s), strict=True))
    return LinkParameters(values, X1, sigmas, bodies(model.robot, values))


def _require_standard(model: Model, prior: Mapping[str, float]) -> None:
    """Refuse a prior without finite standard parameters of this robot."""
    known = [p.name for p in model.base.standard]
    for name, value in prior.items():
        if name not in known:
            raise ParameterError(
                f"{model.robot.name}: the prior's {name} is no standard parameter; accepted: "
                f"{', '.join(known[:11])}, ..."
            )
        if not is_finite(value):
            raise ParameterError(
                f"{model.robot.name}: the prior's {name} is {value!r}; accepted: a finite number"
            )


def _closest(
    problem: Constraints, prior: Mapping[str, float], L: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Return the standard parameters s (s,) with the links closest to the prior, and their X (p,).

    X is that of the problem. At the limit of the possible, it is near that X in the metric L. A
    link without mass in the prior has no mass in the result, if that is possible. Other links that
    are not bodies of positive mass in the prior become as small as possible.
    """
    standard = [p.name for p in problem.model.base.standard]
    target = np.array([float(prior.get(name, 0.0)) for name in standard]) / problem.scale
    named = np.isin(standard, list(prior))
    is_body = named[problem.links].all(axis=1)
    is_body &= least_eigenvalues(target[problem.links]) > CERTAIN
    # A frame without mass can stay so only if it has no leading parameter of a base parameter.
    frames = named[problem.links].all(axis=1) & ~is_body
    frames &= ~np.isin(problem.links, problem.heads).any(axis=1)
    room, margin = problem, problem.margin()
    if frames.any():
        fixed = _fix(problem, frames, target)
        within = fixed.margin()
        if within.value > CERTAIN:
            room, margin, is_body = fixed, within, is_body[~frames]
    at_limit = margin.value < _AT_LIMIT
    if at_limit and L is not None:
        room = room.loosened(L)
    x = room.onto @ _nearest_links(room, target, named, is_body, margin) + room.at
    s: FloatArray = x * room.scale
    s[room.positive] = np.maximum(s[room.positive], 0.0)
    X = room.G @ s if at_limit and L is not None else room.X
    s[room.heads] = X - room.G[:, problem.free] @ s[problem.free]
    s[room.positive] = np.maximum(s[room.positive], 0.0)  # -1e-17, from the line above
    return s, X


def _fix(problem: Constraints, links: Bools, target: FloatArray) -> Constraints:
    """Return constraints in which some links have the parameters of the target (s,)."""
    held = np.isin(problem.free, problem.links[links])
    fixed = np.array(problem.free)[held]
    at = problem.at + problem.onto[:, held] @ target[fixed]
    free = np.array(problem.free)[~held].tolist()
    onto, others = problem.onto[:, ~held], problem.links[~links]
    return replace(problem, free=free, onto=onto, at=at, links=others)


def _nearest_links(
    room: Constraints,
    target: FloatArray,
    named: Bools,
    is_body: Bools,
    margin: Margin,
) -> FloatArray:
    """Return y (m,) of the x = onto y + at whose links are nearest to a target.

        minimise sum over bodies of tr Q - log det Q + 1/2 sum over the others of w (x - target)^2

    The eigenvalues of the other links are at least half of the margin.

    Args:
        room: constraints of y.
        target: (s,) target in the units of x.
        named: (s,) whether the prior has a parameter; others have a weight of a thousandth.
        is_body: (L,) whether a link is a body of positive mass in the target.
        margin: parameters with the largest lower bound of eigenvalues of all links.
    """
    weight = np.where(named | (not named.any()), 1.0, _UNNAMED)
    weight[room.links[is_body]] = 0.0
    weighted = room.onto.T * weight
    P, c = weighted @ room.onto, weighted @ (room.at - target)
    loose = len(c) - len(room.free)
    P[len(room.free) :, len(room.free) :] += np.eye(loose) / _STRAY**2
    for link in room.links[is_body]:
        inverse = np.linalg.inv(np.tensordot(target[link], BASIS, 1))
        c += np.tensordot(BASIS, inverse, 2) @ room.onto[link]  # the trace of Q
    floors = np.minimum(np.where(is_body, 0.0, margin.value / 2), margin.value - CERTAIN)
    constraints = [room.bodies(floors, is_body.astype(float)), room.signs()]
    return minimise(P, c, constraints, np.pad(margin.y, (0, loose))).y


#: Limits of a plausible apparent mass, kg: a few coins, and a lorry.
LIGHTEST, HEAVIEST = 0.02, 5000.0


def implausible(evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray) -> str:
    """Return a note if the robot is implausibly heavy or light, else "".

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the training logs.
        X: (p,) base parameters.
    """
    if logs[0].samples.drive_unit:  # of masses per unit of duty
        return ""
    robot = evaluator.model.robot
    (q,) = some_states(motion_states(logs)[0])
    inertia = np.mean(np.einsum("kjj->kj", mass_matrices(evaluator, q, X)), axis=0)
    masses = np.abs(inertia[:1] if robot.floating else inertia / _reach(robot.with_values()) ** 2)
    least, most = float(masses.min()), float(masses.max())
    if least <= HEAVIEST and most >= LIGHTEST:
        return ""
    mass = f"{least:.3g} kg at least" if least > HEAVIEST else f"{most:.3g} kg at most"
    what = f"every joint moves like {mass} at the end of the arm"
    if robot.floating:
        what = f"the robot weighs {mass}"
    return f"{what}: look at the units of the log (N m, not N mm; N; rad; m; s)"


def _reach(robot: Robot) -> FloatArray:
    """Return the reach of the robot from each joint, m (1 if prismatic), (n,)."""
    lengths = {}
    for j in robot.joints:
        lengths[j.number] = sum(abs(float(x)) for x in (j.b, j.d, j.r))
    out = [
        LENGTH + sum(x for number, x in lengths.items() if number > joint.number)
        if joint.sigma == REVOLUTE
        else 1.0
        for joint in robot.movable
    ]
    return np.array(out)
