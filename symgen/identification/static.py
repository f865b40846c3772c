"""identify --model static: gravity, offsets, springs and friction bounds from still poses.

Poses are solved as torques are, weighed joint by joint. What friction
holds in a pose is anything within its bound, so it is the noise of these equations, and the bound
of a joint is read off its size:

    bound = m + sqrt(3) s,    s^2 = sum of e^2 / sum of (1 - h)

with m the part along the direction of approach, where the table tells it, e the residuals and h
their leverage. It is exact where friction is as likely anywhere in a range [a, bound] of the
direction, and [-bound, bound] where no direction is told. Its variance is that of the quadratic
form e'e for such a law, whose fourth moment is 9/5 s^4:

    var s^2 = s^4 [2 v - 6/5 sum of (1 - h)^2] / v^2,    v = sum of (1 - h)

Poses are rows of

    tau = W(q, 0, 0) X + FS d + f,    |f| within the friction that holds the joint

with d in {-1, 0, 1} the direction in which a joint moved last, where the table tells it. Of X these
rows show what gravity, offsets, springs and the like depend on; no inertia, no viscous friction.
Poses are no series: the friction that is left in one says nothing of that in the next.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

import symgen.identification.assessment as verdicts
from symgen import names
from symgen.codegen.model import derive
from symgen.data.raw import Reading, read_only
from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.equation_model import JUDGING
from symgen.estimation.estimators import Huber, Ols, Prior, Wls
from symgen.estimation.logs import Source, hold_out, open_log, require_other_data
from symgen.estimation.solve import (
    IdentifiableColumns,
    Solution,
    identifiable_columns,
    with_the_others_zero,
)
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.torque_error import TorqueFit, squares
from symgen.estimation.values import FloatArray, Trace
from symgen.identification.estimate import (
    Consistency,
    Estimate,
    Use,
)
from symgen.identification.parameters import read_prior
from symgen.identification.solving import Fit, Method
from symgen.parallel import Say
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.symbolic.near_angles import costly_angles


def open_poses(source: Source, robot: Robot, reading: Reading | None = None) -> Samples:
    """Open a table of still poses; t is the number of the pose, qd the direction of approach.

    Args:
        source: a path, or a log whose rows are poses.
        robot: whose poses they are.
        reading: how the table is read.

    Raises:
        LogError: it cannot be read, or is another robot's.
    """
    log = open_log(source, robot, replace(reading or Reading(), poses=True))
    assert log.tau is not None  # open_log has seen to it
    told = np.zeros_like(log.q) if log.qd is None else np.sign(log.qd)
    t = np.arange(1.0, len(log.q) + 1)
    q, qd, t = map(read_only, (log.q, told, t))
    return Samples(log.name, t, q, qd, log.tau, 1.0, None, log.notes, command=log.command)


def pose_columns(evaluator: Evaluator, q: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the torque regressor of standstill, (K, n, p).

    Args:
        evaluator: the compiled model, with torque_regressor.
        q: (K, n) poses.
        direction: (K, n) in which each joint moved last: -1, 0 (not known) or 1.
    """
    zero = np.zeros_like(q)
    W: FloatArray = evaluator["torque_regressor"](np.ascontiguousarray(q), zero, zero).copy()
    for j, column in coulomb_columns(evaluator).items():
        W[:, j, column] += direction[:, j]
    return W


def coulomb_columns(evaluator: Evaluator) -> dict[int, int]:
    """Return the place of FS in X, by the position of its joint."""
    place = {name: k for k, name in enumerate(evaluator.model.base.names)}
    named = [f"FS{joint.number}" for joint in evaluator.model.robot.movable]
    return {j: place[name] for j, name in enumerate(named) if name in place}


def pose_equations(evaluator: Evaluator, poses: Samples) -> tuple[Equations, ...]:
    """Build the torque equations of standstill of one table, joint by joint."""
    W = pose_columns(evaluator, poses.q, poses.qd)
    return tuple(
        Equations(
            f"{poses.name}, joint {j + 1}",
            np.ascontiguousarray(W[:, j]),
            poses.tau[:, j],
            poses.t,
            0,
            j,
        )
        for j in range(W.shape[1])
    )


def shown_columns(equations: Sequence[Equations]) -> IdentifiableColumns:
    """Return which parameters some equations show.

    Raises:
        IdentificationError: they show nothing.
    """
    columns = identifiable_columns(np.concatenate([e.W for e in equations]))
    if not columns.kept:
        raise IdentificationError(
            "no parameter of the robot shows at standstill: no gravity acts on its joints"
        )
    return columns


STATIC = "static"
METHODS = (Wls.name, Ols.name, Huber.name)
_FEWEST = 3
_NORMAL = 1.96
#: Of the torques held out this share may lie outside the bounds; more, by chance, at this level.
_OUTSIDE, _LEVEL = 0.05, 0.01
_TO_FRICTION = 0.25  # of the torque held out: what the model misses may hide in so much
_EXCLUDES = (
    "what the model misses of position, which is taken for friction; friction bounds hold where it "
    "is as likely anywhere within them"
)


def identify_poses(
    robot: Robot,
    logs: tuple[Sequence[Source], Sequence[Source]],
    method: Method,
    asked: Fit,
    reading: Reading | None,
    progress: Say,
) -> Estimate:
    """Identify what still poses show.

    Args:
        robot: whose poses they are.
        logs: tables of poses, to identify from and to judge by; without any of these, the last
            fifth of each table is held out.
        method: one of METHODS.
        asked: a prior.
        reading: how tables are read.
        progress: is told what is being done.

    Raises:
        LogError: a table cannot be read, is another robot's, or too short.
        IdentificationError: the robot has effects that standstill does not separate, the method or
            weights have no meaning for poses, or these determine nothing.
    """
    known = method.given is not None or method.name in METHODS
    if not known or any(s != 1.0 for s in asked.weights or ()):
        raise IdentificationError(
            f"model static with method {method.name} or weights; accepted: "
            f"{', '.join(METHODS)}, without --weights"
        )
    evaluator = load(derive(robot, JUDGING))
    if asked.prior is not None:
        method = replace(method, prior=read_prior(asked.prior, evaluator.model))
    estimator, (tables, validation) = method.estimator(evaluator), logs
    if robot.loaded:
        raise IdentificationError(
            f"model static: {robot.name} has effects that hold the torque of its links; accepted: "
            "model torque"
        )
    progress(f"reading {', '.join(str(getattr(s, 'name', s)) for s in tables)}")
    train = [open_poses(s, robot, reading) for s in tables]
    held = [open_poses(s, robot, reading) for s in validation]
    require_other_data(train, held)
    given = bool(held)
    if not given:
        train, held = hold_out(train, _FEWEST)
    equations = [e for s in train for e in pose_equations(evaluator, s)]
    columns, every = shown_columns(equations), evaluator.model.base.names
    kept = columns.kept
    system = LinearSystem(every, tuple(equations)).columns(kept)
    progress(f"solving {len(system.y)} equations for {len(kept)} parameters")
    prior = getattr(estimator, "prior", estimator)
    if isinstance(prior, Prior):
        estimator = Prior(prior.mean[kept], prior.std[kept])
    solution = estimator.solve(system)
    bounds = friction_bounds(evaluator, system, solution, columns)
    return _judged(
        Standstill(evaluator, train, held, given, columns, solution, bounds), method.label
    )


class FrictionBounds(NamedTuple):
    """What holds joints: friction lies within -value to value, N m or N, (n,) each.

    Attributes:
        value, std: of the bound.
        toward: the part along the direction of approach, 0 where none is told.
        toward_std: of it.
    """

    value: FloatArray
    std: FloatArray
    toward: FloatArray
    toward_std: FloatArray


def friction_bounds(
    evaluator: Evaluator, system: LinearSystem, solution: Solution, columns: IdentifiableColumns
) -> FrictionBounds:
    """Return the friction bound of every movable joint; see the head of this file."""
    n, place = evaluator.model.robot.n, {k: at for at, k in enumerate(columns.kept)}
    weighed = [w * e.W for e, w in zip(system.logs, solution.weights, strict=True)]
    free = 1 - np.sum(np.linalg.qr(np.concatenate(weighed))[0] ** 2, axis=1)
    left = system.y - system.W @ solution.X
    joint = np.concatenate([np.full(len(e.y), e.joint) for e in system.logs])
    v, squares_left, fourth = (np.bincount(joint, x, n) for x in (free, left**2, free**2))
    v = np.maximum(v, 1.0)
    spread = np.sqrt(3 * squares_left / v)
    relative = np.sqrt(np.maximum(2 * v - 1.2 * fourth, 0.0)) / v / 2
    toward, toward_std = np.zeros((2, n))
    for j, k in coulomb_columns(evaluator).items():
        if k in place:
            toward[j], toward_std[j] = solution.X[place[k]], solution.std[place[k]]
    std = np.hypot(toward_std, spread * relative)
    return FrictionBounds(toward + spread, std, toward, toward_std)


@dataclass(frozen=True, eq=False)
class Standstill:
    """What was identified from still poses.

    Attributes:
        evaluator: the compiled model.
        train, held: the tables, to identify from and to judge by.
        given: whether a table was given to judge by.
        columns: which parameters the poses show.
        solution: of those that are kept.
        bounds: of friction.
    """

    evaluator: Evaluator
    train: Sequence[Samples]
    held: Sequence[Samples]
    given: bool
    columns: IdentifiableColumns
    solution: Solution
    bounds: FrictionBounds


def _judged(found: Standstill, label: str) -> Estimate:
    """Return the estimate with its fit and its verdict."""
    evaluator, solution, bounds = found.evaluator, found.solution, found.bounds
    base, robot = evaluator.model.base, evaluator.model.robot
    kept, coulomb = found.columns.kept, coulomb_columns(evaluator)
    p = len(base.parameters)
    whole = with_the_others_zero(solution, kept, p)
    X, std, C = whole.X, np.full(p, math.nan), whole.covariance
    for j, k in coulomb.items():
        X[k], C[k, k] = bounds.value[j], bounds.std[j] ** 2
    size = np.sqrt(np.maximum(np.diag(C), 0))
    known = [*found.columns.known, *coulomb.values()]
    std[known] = size[known]
    parameters = verdicts.parameter_estimates(evaluator, X, std)
    shown = tuple(p for p in parameters if math.isfinite(p.std))
    parts = (("train", found.train), ("validation", found.held))
    own, seen = (_fit(evaluator, tables, X, kind) for kind, tables in parts)
    scaled = verdicts.scale_unknown(robot, found.train)
    use = verdicts.parameters_use(shown, Consistency(None, None, ""), (), scaled=scaled)
    left = seen.residual.relative
    hidden = (
        f"the torque error on held-out poses is {100 * left:.3g} %, which is attributed to static "
        "friction: a model error of this size would not be seen",
    )
    reasons = (
        *_beyond_bounds(found),
        *(hidden if left > _TO_FRICTION else ()),
        *_elsewhere(found, C),
        *_turned(bounds, evaluator.model.robot),
    )
    prediction = Use("prediction", reasons)
    uses = (prediction, use, Use("simulation", ("standstill shows no inertia",)))
    errors = seen.residual.relative, own.residual.relative
    standstill = ("This holds at standstill, within friction",)
    return verdicts.make_estimate(
        evaluator,
        parameters,
        C,
        (own, seen),
        uses,
        model=STATIC,
        method=label,
        condition_number=solution.condition_number,
        train=own.residual,
        validation=seen.residual,
        cutoff_hz=None,
        window_s=None,
        notes=(*(n for s in (*found.train, *found.held) for n in s.notes), *_notes(found),
               *costly_angles(robot), *solution.notes),
        traces=own.traces + seen.traces,
        provenance=verdicts.provenance(evaluator, [(kind, s) for kind, tables in parts
                                                   for s in tables]),
        physical=Consistency(None, None, "not checked: standstill shows no inertia"),
        excludes=_EXCLUDES,
        headline=verdicts.headline(uses, len(shown), errors, standstill),
    )  # fmt: skip


def _fit(evaluator: Evaluator, tables: Sequence[Samples], X: FloatArray, kind: str) -> TorqueFit:
    """Compare measured torque with that of gravity, offsets and springs: kernels at rest."""
    out = TorqueFit.none(evaluator.model.robot.n)
    for s in tables:
        zero = np.zeros_like(s.q)
        torque = evaluator["inverse_dynamics"](np.ascontiguousarray(s.q), zero, zero, X)
        trace = Trace(s.name, kind, "torque", s.t, s.tau, torque)
        out += squares(np.ones(s.tau.shape, dtype=bool), s.tau, torque, traces=(trace,))
    return out


def _beyond_bounds(found: Standstill) -> tuple[str, ...]:
    """Say where torques held out lie outside the friction that was found, beyond chance."""
    from scipy.special import bdtrc

    evaluator, solution, kept = found.evaluator, found.solution, found.columns.kept
    W = np.concatenate([pose_columns(evaluator, s.q, s.qd) for s in found.held])[:, :, kept]
    W[:, :, np.isin(kept, list(coulomb_columns(evaluator).values()))] = 0  # within the bound
    error = np.abs(np.concatenate([s.tau for s in found.held]) - W @ solution.X)
    spread = np.einsum("kja,ab,kjb->kj", W, solution.covariance, W)
    value, std = found.bounds.value, found.bounds.std
    beyond = np.sum(error > value + _NORMAL * np.sqrt(spread + std**2), axis=0).tolist()
    rows, movable = len(error), evaluator.model.robot.movable
    return tuple(
        f"{evaluator.model.robot.label(joint.number)}: {count} of {rows} held-out torques exceed "
        f"the friction bound of {bound:.3g} {names.unit('OF', joint.sigma)}: the model lacks a "
        "torque that depends on the position; symgen diagnose searches for it in a log with motion"
        for joint, count, bound in zip(movable, beyond, value, strict=True)
        if bdtrc(count - 1, rows, _OUTSIDE) < _LEVEL / len(value)
    )


def _elsewhere(found: Standstill, C: FloatArray) -> tuple[str, ...]:
    """Say where poses elsewhere in the same range would be predicted worse than friction leaves."""
    q = np.concatenate([s.q for s in found.train])
    (mixed,) = verdicts.mixed_states(q)
    W = pose_columns(found.evaluator, mixed, np.zeros_like(mixed))
    spread = np.sqrt(np.einsum("kja,ab,kjb->j", W, C, W) / len(W))
    bad = np.flatnonzero(spread > np.maximum(found.bounds.value, 0.0))
    if not len(bad):
        return ()
    return (
        "the poses do not determine the parameters well enough: other poses in the same range "
        "would have larger torque errors than static friction at "
        f"{found.evaluator.model.robot.listed(bad)}; record more poses, farther apart",
    )


def _turned(bounds: FrictionBounds, robot: Robot) -> tuple[str, ...]:
    against = (bounds.toward < -verdicts.SIGNIFICANT * bounds.toward_std) & (bounds.toward_std > 0)
    if not against.any():
        return ()
    return (
        f"friction helps the last motion at {robot.listed(np.flatnonzero(against))}, which is "
        "impossible: change the sign of tau or of qd there",
    )


def _notes(found: Standstill) -> tuple[str, ...]:
    """Say what was identified from what, and what standstill leaves open."""
    base, (kept, known) = found.evaluator.model.base.names, found.columns
    coulomb = coulomb_columns(found.evaluator)
    told = any((s.qd != 0).any() for s in found.train)
    out = [
        f"{sum(len(s.t) for s in found.train)} still poses; "
        + (
            "qd is taken as the direction of each joint's last motion"
            if told
            else "the table has no direction of approach (columns qd1.., whose sign counts)"
        )
    ]
    seen = {*known, *coulomb.values()}
    open_ = ", ".join(name for k, name in enumerate(base) if k not in seen)
    if open_:
        out.append(f"standstill does not determine {open_}")
    tied = ", ".join(base[k] for k in kept if k not in known)
    if tied:
        out.append(f"{tied} include all parameters with the same torque at standstill")
    joints = zip(found.evaluator.model.robot.movable, found.bounds.value, strict=True)
    held = [f"{j.number} ({b:.3g})" for k, (j, b) in enumerate(joints) if k not in coulomb]
    if held:
        out.append(f"static friction of joints without declared friction, N m: {', '.join(held)}")
    if not found.given:
        out.append("no validation table is given: the last fifth of each table is held out")
    return tuple(out)
