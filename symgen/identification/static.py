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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import symgen.identification.assessment as verdicts
from symgen import names
from symgen.data.raw import Reading, read_only
from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.estimators import Estimator, Huber, Ols, Prior, Wls
from symgen.estimation.logs import Source, held_out, open_log, require_other_data
from symgen.estimation.solve import SINGULAR, Solution
from symgen.estimation.statistics import binomial_tail
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.torque_error import squares
from symgen.estimation.values import FloatArray, Residual, Trace
from symgen.identification.estimate import (
    Consistency,
    Estimate,
    Joint,
    ParameterEstimate,
    Use,
)
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.symbolic.near_angles import costly_angles

_SHARE = 1e-6  # of a parameter in what another one stands for


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
    return Samples(log.name, t, q, qd, log.tau, 1.0, None, log.notes)


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
    movable = enumerate(evaluator.model.robot.movable)
    named = {j: place.get(f"FS{joint.number}") for j, joint in movable}
    return {j: k for j, k in named.items() if k is not None}


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


@dataclass(frozen=True, eq=False)
class Shown:
    """Which parameters some equations show.

    Attributes:
        kept: places in X of columns that are independent of each other, those before going first.
        known: of `kept`, those with no part in a combination that the equations leave open.
    """

    kept: tuple[int, ...]
    known: tuple[int, ...]

    @staticmethod
    def by(equations: Sequence[Equations]) -> Shown:
        """Look at the columns of some equations.

        Raises:
            IdentificationError: they show nothing.
        """
        W = np.concatenate([e.W for e in equations])
        norms = np.linalg.norm(W, axis=0)
        seen = np.flatnonzero(norms > SINGULAR * max(float(norms.max()), 1e-300))
        if not len(seen):
            raise IdentificationError(
                "no parameter of the robot shows at standstill: no gravity acts on its joints"
            )
        basis = np.zeros((len(W), 0))
        kept: list[int] = []
        tied: set[int] = set()
        for k in seen:
            column = W[:, k] / norms[k]
            rest = column - basis @ (basis.T @ column)
            rest -= basis @ (basis.T @ rest)
            size = float(np.linalg.norm(rest))
            if size > SINGULAR:
                basis = np.column_stack([basis, rest / size])
                kept.append(int(k))
                continue
            share = np.linalg.lstsq(W[:, kept] / norms[kept], column, rcond=None)[0]
            tied |= {i for i, s in zip(kept, share, strict=True) if abs(s) > _SHARE}
        return Shown(tuple(kept), tuple(k for k in kept if k not in tied))

    def system(self, names: Sequence[str], equations: Sequence[Equations]) -> LinearSystem:
        """Return the equations of what is kept."""
        return LinearSystem(
            tuple(names[k] for k in self.kept), tuple(e.columns(self.kept) for e in equations)
        )


STATIC = "static"
METHODS = (Wls.name, Ols.name, Huber.name)
_FEWEST = 3
_NORMAL = 1.96
#: Of the torques held out this share may lie outside the bounds; more, by chance, at this level.
_OUTSIDE, _LEVEL = 0.05, 0.01
_EXCLUDES = (
    "what the model misses of position, which is taken for friction; friction bounds hold where it "
    "is as likely anywhere within them"
)


def identify_poses(
    evaluator: Evaluator,
    tables: Sequence[Source],
    validation: Sequence[Source],
    estimator: Estimator,
    label: str,
    reading: Reading | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Estimate:
    """Identify what still poses show.

    Args:
        evaluator: the compiled model, with `equation_model.JUDGING`.
        tables: of poses, to identify from.
        validation: to judge by; without any, the last fifth of each table is held out.
        estimator: one of METHODS.
        label: of the method.
        reading: how tables are read.
        progress: is told what is being done.

    Raises:
        LogError: a table cannot be read, is another robot's, or too short.
        IdentificationError: the robot has effects that standstill does not separate, or the poses
            determine nothing.
    """
    robot = evaluator.model.robot
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
        train, held = held_out(train, _FEWEST)
    equations = [e for s in train for e in pose_equations(evaluator, s)]
    shown = Shown.by(equations)
    system = shown.system(evaluator.model.base.names, equations)
    progress(f"solving {len(system.y)} equations for {len(system.names)} parameters")
    solution = _within(estimator, shown).solve(system)
    bounds = friction_bounds(evaluator, system, solution, shown)
    return _judged(evaluator, train, held, shown, solution, bounds, label, given)


def _within(estimator: Estimator, shown: Shown) -> Estimator:
    """Cut a prior down to the parameters that poses show."""
    prior = getattr(estimator, "prior", estimator)
    if not isinstance(prior, Prior):
        return estimator
    at = list(shown.kept)
    return Prior(prior.mean[at], prior.std[at])


@dataclass(frozen=True)
class FrictionBound:
    """What holds a joint: friction lies within -value to value, N m or N.

    Attributes:
        value, std: of the bound.
        toward: the part along the direction of approach, 0 where none is told.
        toward_std: of it.
    """

    value: float
    std: float
    toward: float = 0.0
    toward_std: float = 0.0


def friction_bounds(
    evaluator: Evaluator, system: LinearSystem, solution: Solution, shown: Shown
) -> tuple[FrictionBound, ...]:
    """Return the friction bound of every movable joint; see the head of this file."""
    pairs = list(zip(system.logs, solution.weights, strict=True))
    normal = sum(w * w * e.W.T @ e.W for e, w in pairs)
    A = np.linalg.pinv(np.asarray(normal), hermitian=True)
    columns = coulomb_columns(evaluator)
    out = []
    for j in range(evaluator.model.robot.n):
        own = [(e, w) for e, w in pairs if e.joint == j]
        left = np.concatenate([e.y - e.W @ solution.X for e, _ in own])
        free = np.concatenate([1 - w * w * np.einsum("ka,ab,kb->k", e.W, A, e.W) for e, w in own])
        v = max(float(free.sum()), 1.0)
        s = math.sqrt(float(left @ left) / v)
        relative = math.sqrt(max(2 * v - 1.2 * float(free @ free), 0.0)) / v / 2
        m = m_std = 0.0
        if columns.get(j) in shown.kept:
            k = shown.kept.index(columns[j])
            m, m_std = float(solution.X[k]), math.sqrt(max(float(solution.covariance[k, k]), 0.0))
        spread = math.sqrt(3) * s
        out.append(FrictionBound(m + spread, math.hypot(m_std, spread * relative), m, m_std))
    return tuple(out)


def _judged(
    evaluator: Evaluator,
    train: Sequence[Samples],
    held: Sequence[Samples],
    shown: Shown,
    solution: Solution,
    bounds: Sequence[FrictionBound],
    label: str,
    given: bool,
) -> Estimate:
    """Return the estimate with its fit and its verdict."""
    base, robot = evaluator.model.base, evaluator.model.robot
    p = len(base.parameters)
    X, std, C = np.zeros(p), np.full(p, math.nan), np.zeros((p, p))
    at = list(shown.kept)
    X[at], C[np.ix_(at, at)] = solution.X, solution.covariance
    known = list(shown.known)
    std[known] = np.sqrt(np.maximum(np.diag(C)[known], 0))
    for j, k in coulomb_columns(evaluator).items():
        X[k], std[k] = bounds[j].value, bounds[j].std
        C[k, k] = std[k] ** 2
    size = np.sqrt(np.maximum(np.diag(C), 0))
    outside = np.where(size > 0, size, 1)
    parameters = tuple(
        ParameterEstimate(b.name, b.expression, float(x), float(s), b.unit)
        for b, x, s in zip(base.parameters, X, std, strict=True)
    )
    found = tuple(p for p in parameters if math.isfinite(p.std))
    traces = [_trace(evaluator, s, X, kind) for kind, part in (("train", train),
              ("validation", held)) for s in part]  # fmt: skip
    own, seen = (_residual([t for t in traces if t.kind == kind]) for kind in
                 ("train", "validation"))  # fmt: skip
    prediction = Use("prediction", (
        *_beyond_bounds(evaluator, held, shown, solution, bounds),
        *_unexplained(seen, "poses held out"),
        *_elsewhere(evaluator, train, C, bounds),
        *_turned(bounds),
    ))  # fmt: skip
    use = verdicts.parameters_use(found, Consistency(None, None, ""), ())
    uses = (prediction, use, Use("simulation", ("standstill shows no inertia",)))
    beside = [f"{len(use.known)} of the {len(found)} parameters that standstill shows are known"]
    beside += use.reasons
    headline = f"trusted for torque at standstill, within friction; {'; '.join(beside)}"
    if not prediction.ok:
        headline = f"doubtful: {'; '.join(prediction.reasons)}"
    return Estimate(
        robot=robot.name,
        joints=tuple(Joint(j.number, names.unit("FS", j.sigma)) for j in robot.movable),
        model=STATIC,
        method=label,
        parameters=parameters,
        condition_number=solution.condition_number,
        train=own,
        validation=seen,
        torque_train=own,
        torque_validation=seen,
        cutoff_hz=None,
        window_s=None,
        verdict="trusted" if prediction.ok else "doubtful",
        reasons=prediction.reasons,
        notes=(*(n for s in (*train, *held) for n in s.notes),
               *_notes(evaluator, train, shown, bounds, given), *costly_angles(robot),
               *solution.notes),
        correlation=C / np.outer(outside, outside),
        traces=tuple(traces),
        provenance=verdicts.provenance(
            evaluator,
            [*(("train", s) for s in train), *(("validation", s) for s in held)],
        ),
        physical=Consistency(None, None, "not checked: standstill shows no inertia"),
        excludes=_EXCLUDES,
        uses=uses,
        headline=headline,
    )  # fmt: skip


def _trace(evaluator: Evaluator, poses: Samples, X: FloatArray, kind: str) -> Trace:
    """Return measured torque beside that of gravity, offsets and springs: kernels at rest."""
    zero = np.zeros_like(poses.q)
    torque = evaluator["inverse_dynamics"](np.ascontiguousarray(poses.q), zero, zero, X)
    return Trace(poses.name, kind, "torque", poses.t, poses.tau, torque, 0)


def _residual(traces: Sequence[Trace]) -> Residual:
    """Return ||tau - model|| / ||tau||, in all and by joint."""
    measured = np.concatenate([t.measured for t in traces])
    predicted = np.concatenate([t.predicted for t in traces])
    return squares(np.ones(measured.shape, dtype=bool), measured, predicted).residual


def _beyond_bounds(
    evaluator: Evaluator,
    held: Sequence[Samples],
    shown: Shown,
    solution: Solution,
    bounds: Sequence[FrictionBound],
) -> tuple[str, ...]:
    """Say where torques held out lie outside the friction that was found, beyond chance."""
    columns, at = coulomb_columns(evaluator), list(shown.kept)
    hidden = [at.index(k) for k in columns.values() if k in at]
    out = []
    for j, bound in enumerate(bounds):
        beyond = rows = 0
        for s in held:
            W = pose_columns(evaluator, s.q, s.qd)[:, j, at]
            W[:, hidden] = 0  # all that friction does is within the bound
            error = np.abs(s.tau[:, j] - W @ solution.X)
            spread = np.einsum("ka,ab,kb->k", W, solution.covariance, W)
            limit = bound.value + _NORMAL * np.sqrt(spread + bound.std**2)
            beyond, rows = beyond + int(np.sum(error > limit)), rows + len(error)
        if binomial_tail(beyond, rows, _OUTSIDE) < _LEVEL / len(bounds):
            number = evaluator.model.robot.movable[j].number
            out.append(
                f"joint {number}: {beyond} of {rows} torques held out lie outside the friction "
                f"bound of {bound.value:.3g}: the model misses something of position"
            )
    return tuple(out)


def _unexplained(seen: Residual, what: str) -> tuple[str, ...]:
    if seen.relative <= verdicts.RESIDUAL:
        return ()
    return (
        f"{100 * seen.relative:.3g} % of the torque of {what} is left to friction: what the model "
        "misses would hide in it",
    )


def _elsewhere(
    evaluator: Evaluator,
    train: Sequence[Samples],
    C: FloatArray,
    bounds: Sequence[FrictionBound],
) -> tuple[str, ...]:
    """Say where poses elsewhere in the same range would be predicted worse than friction leaves."""
    q = np.concatenate([s.q for s in train])
    draw = np.random.default_rng(verdicts.SEED)
    mixed = q[draw.integers(len(q), size=(verdicts.STATES, q.shape[1])), np.arange(q.shape[1])]
    W = pose_columns(evaluator, mixed, np.zeros_like(mixed))
    spread = np.sqrt(np.einsum("kja,ab,kjb->j", W, C, W) / len(W))
    bad = [j for j, b in enumerate(bounds) if spread[j] > max(b.value, 0.0) and spread[j] > 0]
    if not bad:
        return ()
    numbers = ", ".join(str(evaluator.model.robot.movable[j].number) for j in bad)
    return (
        f"the poses do not carry their parameters: poses elsewhere in the same range would have "
        f"larger errors than friction leaves at joints {numbers}; record more, farther apart",
    )


def _turned(bounds: Sequence[FrictionBound]) -> tuple[str, ...]:
    bad = [j for j, b in enumerate(bounds) if b.toward < -verdicts.SIGNIFICANT * b.toward_std < 0]
    if not bad:
        return ()
    numbers = ", ".join(str(j + 1) for j in bad)
    return (
        f"friction helps the last motion at movable joints {numbers}: the sign of tau, or of qd, "
        "is the other way",
    )


def _notes(
    evaluator: Evaluator,
    train: Sequence[Samples],
    shown: Shown,
    bounds: Sequence[FrictionBound],
    given: bool,
) -> tuple[str, ...]:
    """Say what was identified from what, and what standstill leaves open."""
    every = evaluator.model.base.names
    columns = coulomb_columns(evaluator)
    told = any((s.qd != 0).any() for s in train)
    out = [
        f"{sum(len(s.t) for s in train)} still poses; "
        + (
            "qd is taken as the direction of each joint's last motion"
            if told
            else "no direction of approach is told (columns qd1.., of which the sign counts)"
        )
    ]
    open_ = [n for k, n in enumerate(every) if k not in shown.known and k not in columns.values()]
    if open_:
        out.append(f"standstill does not determine {', '.join(open_)}")
    tied = [every[k] for k in shown.kept if k not in shown.known]
    if tied:
        out.append(f"{', '.join(tied)} stand for all that looks like them at standstill")
    rest = [
        f"{j.number} ({b.value:.3g})"
        for k, (j, b) in enumerate(zip(evaluator.model.robot.movable, bounds, strict=True))
        if k not in columns
    ]
    if rest:
        out.append(f"joints without declared friction hold torques within, N m: {', '.join(rest)}")
    if not given:
        out.append("no validation table is given: the last fifth of each table is held out")
    return tuple(out)
