"""What an estimate is worth: its fit, what it may be used for, and all that is said of it.

    prediction  the torque error on held-out motion is small, not learned by heart, and what the
                noise of X says of other motions in the same range is no larger
    parameters  which of them are known, and whether they are physically possible
    simulation  the mass matrix is positive definite over the range of the motion, and friction
                takes energy out

How often they are right is counted on simulated runs on which none of the thresholds was chosen
(tests/workflow/trust_study.py).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np

from symgen import names
from symgen.data.mask import moving_joints
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, ParameterError, first_of
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls, bias_of_least_squares
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import noise_fit, quiet, unexplained_from
from symgen.estimation.logs import digest
from symgen.estimation.masking import seldom_moving
from symgen.estimation.playback import (
    HORIZONS,
    Gains,
    Horizon,
    Window,
    model_mover,
    play,
    position_errors,
    windows_of,
)
from symgen.estimation.solve import Solution
from symgen.estimation.summary import Summary
from symgen.estimation.system import Equations
from symgen.estimation.torque_error import TorqueFit, equation_residual, largest, percent
from symgen.estimation.values import FloatArray, OtherEstimate, Residual, Trace
from symgen.faults.fault import Fault
from symgen.faults.scene import mean_friction_power
from symgen.faults.undo import multiplied
from symgen.identification.estimate import (
    BETWEEN_USES,
    LOG_DIGEST,
    ROBOT_DIGEST,
    Alternative,
    Consistency,
    Estimate,
    ParameterEstimate,
    Use,
    joints_of,
)
from symgen.identification.model_choice import ChosenModel
from symgen.identification.parameters import mass_matrices
from symgen.identification.physical import POSITIVE, consistency, implausible
from symgen.identification.solving import (
    UNBIASED,
    EquatedLog,
    Method,
    equate,
    system_of,
)
from symgen.policy import LEAST
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

_PLENTY = 10  # independent equations for each parameter
_LOUD = 0.03  # relative residual above which signs are tried
_BETTER = 0.5  # of the residual that another sign has to leave at most
#: Held-out torque error over that of the training logs above which the log was learned by heart.
OVERFIT = 3.0
#: Error of torque on other motions in the same range, as the noise of X has it, over what is said.
ELSEWHERE = 1.0
#: Torque error on one part of the motion over that on held-out data from which it depends on it.
VARIES = 2.5
#: Torque errors below this are not worth a doubt.
NEGLIGIBLE = 0.01
#: Condition number of the scaled regressor above which small errors of the data become large.
CONDITION = 500.0
#: Independent windows that each parameter needs.
WINDOWS = 3.0
#: How many standard deviations make a sign sure.
SIGNIFICANT = 3.0
#: Relative standard deviation up to which a parameter is known, in percent.
KNOWN = 30.0
#: Windows of held-out motion that are simulated, about: their RMS is then known to a fifth.
WINDOWS_PLAYED = 24
#: States that are drawn to look at a model elsewhere, and their seed.
STATES, SEED = 500, 1988
_OPEN = "the motion does not determine all parameters"
_UNREAD = "do not use single values"
_RICHER = "symgen excite plans a motion that determines them better"
_SEARCH = "symgen diagnose searches for the cause"
_WEAK = "are weak"
_SCALED = (
    "the gains of [controller] are known up to a common factor, which scales all torques, masses, "
    "inertias and friction alike and which no such log determines: only ratios of parameters hold"
)
#: Most lags that are looked at, fewest, and rows that each needs.
LAGS, _LEAST, _ROWS = 20, 3, 5


@dataclass(frozen=True, eq=False)
class Outcome:
    """A solution, and how it fits all equations and torques.

    Attributes:
        solution: of the equations of the training logs.
        train: residual of these equations.
        held: of those of the validation logs.
        own: torques of the training logs.
        seen: of the validation logs.
        windows: number of independent equations.
        repairs: what was mended in the logs.
        notes, provenance: of the logs, beside those of every run.
        faults: reasons why the model is not good for prediction.
    """

    solution: Solution
    train: Residual
    held: Residual
    own: TorqueFit
    seen: TorqueFit
    windows: float
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...] = ()
    provenance: tuple[tuple[str, str], ...] = ()
    faults: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Trials:
    """What is simulated on held-out motion beside the estimate.

    Attributes:
        own_values: parameters (p,) of the robot's own file, None where it has none.
        gains: of a controller that holds the robot to the measured motion, None without one.
    """

    own_values: FloatArray | None = None
    gains: Gains | None = None


NO_TRIALS = Trials()


def outcome(
    solution: Solution,
    model: EquationModel,
    equations: tuple[Sequence[Equations | Summary], Sequence[Equations | Summary]],
    torques: Sequence[TorqueFit],
    repairs: tuple[Fault, ...],
    notes: tuple[str, ...] = (),
    provenance: tuple[tuple[str, str], ...] = (),
) -> Outcome:
    """Return how a solution fits the logs.

    Args:
        solution: of the equations.
        model: of the equations.
        equations: of the training and of the validation logs, or their summaries.
        torques: of both, at X.
        repairs, notes, provenance: see `Outcome`.
    """
    own, seen = torques
    if model.name == "torque":
        residuals = own.residual, seen.residual
    else:
        train, held = (equation_residual(parts, solution.X) for parts in equations)
        residuals = train, held
    windows = sum(part.rows / part.correlation for part in equations[0])
    return Outcome(solution, *residuals, own, seen, windows, repairs, notes, provenance)


def assess(
    chosen: ChosenModel, method: Method, found: Outcome, trials: Trials = NO_TRIALS
) -> Estimate:
    """Return the estimate that a solution is, with its fit, its verdict, and what is drawn of it.

    Args:
        chosen: the run with the equations that were solved, or with those of a sample.
        method: that solved them.
        found: the solution, and how it fits all logs.
        trials: what is simulated beside the estimate.
    """
    run, model, train, held = chosen.run, chosen.model, chosen.train, chosen.held
    evaluator, own, seen = run.evaluator, found.own, found.seen
    solution, bias = found.solution, ""
    if method.name not in UNBIASED and chosen.columns is None:
        system = system_of(evaluator, train)
        solution, bias = bias_of_least_squares(system, solution, chosen.plain)
    X, std = solution.X, solution.std
    names = evaluator.model.base.names
    physical = consistency(evaluator.model, X, solution.covariance, trials.own_values)
    if chosen.columns is not None:
        known = chosen.columns.known
        std = np.full(len(X), math.nan)
        std[known] = solution.std[known]
        physical = Consistency(None, None, f"not checked: {_OPEN}")
    parameters = parameter_estimates(evaluator, X, std)
    driven = driving_friction(evaluator, run.train, X, solution.covariance)
    faults = (
        *run.causes,
        *hardly_moving(run.train, evaluator.model.robot),
        *(driven or found.faults),
        *wrong_sign(evaluator, train, model, found.train.relative),
    )
    noise = noise_fit(evaluator, run.held, X)
    floor = _noise_of(noise.residual, moving := in_motion(seen).residual)
    unexplained = _beyond(moving, floor)
    elsewhere = error_elsewhere(evaluator, run.train, solution.noise, chosen.together)
    limits = _in_proportion(chosen.together, evaluator.model.robot)
    uses = (
        prediction_use(
            own,
            seen,
            floor,
            elsewhere,
            faults,
            evaluator.model.robot,
            seldom_moving(run.train, evaluator.model.robot),
            run.worst,
        ),
        parameters_use(
            parameters,
            physical,
            (*_unread(unexplained), *filter(None, [bias]), *disagreement(chosen.found)),
            scaled=scale_unknown(evaluator.model.robot, [log.samples for log in run.train]),
        ),
        simulation_use(evaluator, (run.train, run.held), X, parameters, limits, trials),
    )
    traces = tuple(trace for p in (*train, *held) for trace in model_traces(p, model, X))
    traces += own.traces + seen.traces
    prior = method.prior
    data = [(p.kind, p.log.samples) for p in (*train, *held)]
    return make_estimate(
        evaluator,
        parameters,
        solution.covariance,
        (own, seen),
        uses,
        model=model.name,
        method=method.label,
        condition_number=solution.condition_number,
        train=found.train,
        validation=found.held,
        cutoff_hz=run.band.cutoff_hz,
        window_s=None if model.name == "torque" else model.window,
        notes=(*_notes(chosen, solution, found), *found.notes, *limits),
        traces=traces,
        provenance=(*provenance(evaluator, data, _settings(method)), *found.provenance),
        physical=physical,
        excludes=method.excludes,
        endogeneity=solution.endogeneity,
        comparison=solution.comparison,
        prior=prior and OtherEstimate.by("prior", names, prior.mean, prior.std),
        band=run.band,
        repairs=found.repairs,
        alternatives=tuple(
            # the chosen one with the fit of all logs, of which it was chosen on a sample
            replace(
                a,
                condition_number=solution.condition_number,
                train=own.residual,
                validation=seen.residual,
            )
            if a.chosen and method.is_wls
            else a
            for a in chosen.found
        ),
        headline=headline(
            uses,
            len(parameters),
            (seen.residual.relative, own.residual.relative),
            (
                *_largest(seen, evaluator.model.robot),
                *limits,
                *seen.told_apart,
                *_told_of(unexplained, floor),
            ),
        ),
        noise_floor=floor,
        unexplained=unexplained,
    )


def parameter_estimates(
    evaluator: Evaluator, X: FloatArray, std: FloatArray
) -> tuple[ParameterEstimate, ...]:
    """Return the base parameters with values and standard deviations, (p,) each."""
    return tuple(
        ParameterEstimate(b.name, b.expression, float(x), float(s), b.unit)
        for b, x, s in zip(evaluator.model.base.parameters, X, std, strict=True)
    )


def make_estimate(
    evaluator: Evaluator,
    parameters: tuple[ParameterEstimate, ...],
    covariance: FloatArray,
    torques: tuple[TorqueFit, TorqueFit],
    uses: tuple[Use, ...],
    **more: Any,
) -> Estimate:
    """Return the estimate of a robot, with the verdict that its use for prediction is.

    Args:
        evaluator: the compiled model.
        parameters: identified ones.
        covariance: of them, (p, p).
        torques: of the training and of the validation logs.
        uses: prediction first.
        more: the other fields of the estimate.
    """
    robot, (own, seen) = evaluator.model.robot, torques
    size = np.sqrt(np.maximum(np.diag(covariance), 0))
    outside = np.where(size > 0, size, 1)
    return Estimate(
        robot=robot.name,
        joints=joints_of(robot),
        parameters=parameters,
        torque_train=own.residual,
        torque_validation=seen.residual,
        verdict="trusted" if uses[0].ok else "doubtful",
        reasons=uses[0].reasons,
        correlation=covariance / np.outer(outside, outside),
        uses=uses,
        **more,
    )


def _notes(chosen: ChosenModel, solution: Solution, found: Outcome) -> tuple[str, ...]:
    """Say what was done to the logs, and what the intervals do not tell."""
    run, count = chosen.run, len(solution.X)
    out = [note for log in run.logs for note in log.samples.notes]
    out += [f"band: {run.band.in_words()}", *_of_rests(run.band, found.seen)]
    if not run.given:
        out.append("no validation log is given: the last fifth of each log is held out")
    if found.windows < _PLENTY * count:
        out.append(
            f"{found.windows:.0f} independent equations for {count} parameters: under "
            f"{_PLENTY} each, the standard deviations tend to be too small"
        )
    out += solution.notes
    if len(set(solution.weights)) > 1:
        ratio = max(solution.weights) / min(solution.weights)
        out.append(
            f"equations are weighted by log and joint; largest over smallest weight: {ratio:.3g}"
        )
    shares = [p.equations[0].weight for p in chosen.train]
    if any(w != 1.0 for w in shares):
        listed = ", ".join(f"{w:g}" for w in shares)
        out.append(f"squared residuals of the logs are weighted by {listed}")
    out.append(implausible(run.evaluator, run.train, solution.X))
    return tuple(filter(None, out))


def _in_proportion(together: Sequence[Sequence[int]], robot: Robot) -> tuple[str, ...]:
    """Say for which motion a model holds whose joints moved in proportion."""
    return tuple(
        f"this model holds only for motion in which {robot.listed(group)} move in "
        "proportion, as in the training logs"
        for group in together
    )


def scale_unknown(robot: Robot, logs: Sequence[Samples]) -> bool:
    """Whether gains that are known up to a common factor gave the torques of a log."""
    servo = robot.controller
    torques = any(samples.command is not None for samples in logs)
    return torques and servo is not None and servo.scale == "unknown"


def _of_rests(band: Band, seen: TorqueFit) -> tuple[str, ...]:
    """Say what rests do, where the logs that judge have any."""
    if band.rests is None:
        return ()
    weights = band.rests.weight
    return tuple(
        "joints stand still at times, where static friction can take any value between its limits: "
        f"{told}; rows at rest have {min(weights):.2g} to {max(weights):.2g} times the weight of "
        "rows in motion"
        for told in seen.told_apart
    )


def own_version() -> str:
    """Return symgen's version; "unknown" where it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("symgen")
    except PackageNotFoundError:
        return "unknown"


def provenance(
    evaluator: Evaluator,
    logs: Iterable[tuple[str, Samples]],
    more: Iterable[tuple[str, str]] = (),
) -> tuple[tuple[str, str], ...]:
    """Return what made an estimate: symgen's version, the backend, the robot, and the logs.

    Args:
        evaluator: the compiled model.
        logs: with their kind.
        more: what else has to be told, before the logs.
    """
    robot = hashlib.sha256(robot_toml(evaluator.model.robot).encode()).hexdigest()
    own = (("symgen", own_version()), ("backend", evaluator.backend), (ROBOT_DIGEST, robot))
    data = ((f"{kind} {s.name}, {LOG_DIGEST}", digest(s)) for kind, s in logs)
    return (*own, *more, *data)


def _settings(method: Method) -> list[tuple[str, str]]:
    """Return what the provenance of an estimate says of its method."""
    out = []
    if method.name == "recursive":
        out.append(("forgetting", f"{method.forgetting:g}"))
    if method.prior is not None:
        given = np.concatenate([method.prior.mean, method.prior.std]).tobytes()
        out.append(("prior, sha256 of its means and std", hashlib.sha256(given).hexdigest()))
    return out


def prediction_use(
    train: TorqueFit,
    held: TorqueFit,
    noise: Residual,
    elsewhere: float,
    faults: Sequence[str],
    robot: Robot,
    suspects: Sequence[str] = (),
    worst: float = 0.0,
) -> Use:
    """Judge the torque on held-out motion: of joints that move, where any does.

    Args:
        train: torques of the training logs.
        held: of data that the estimate never saw.
        noise: what noise alone leaves of it.
        elsewhere: torque error on other motions in the same range, from `error_elsewhere`.
        faults: of the logs that matter and could not be mended.
        robot: for the names of joints.
        suspects: what was seen in the logs and left; the reason, where the torque is unexplained.
        worst: torque error on the fold of motion where it is largest, of fits to the others, as a
            part of the torque of all motion.
    """
    reasons = list(faults)
    where = " in motion" if held.rest.any() else ""
    train, held = in_motion(train), in_motion(held)
    said, own = held.residual.relative, train.residual.relative
    unexplained = tuple(_unexplained(held, noise, robot, not faults, where))
    reasons += unexplained
    if unexplained:
        reasons += suspects
    if said > max(OVERFIT * own, NEGLIGIBLE):
        reasons.append(
            f"overfit: the torque error on held-out motion is {percent(said)}, "
            f"{said / max(own, 1e-300):.3g} times that on the training logs; record a longer log"
        )
    if worst > VARIES * said and worst**2 - said**2 > LEAST**2:
        reasons.append(
            f"the torque error depends on the motion: {percent(said)} on held-out data, "
            f"{percent(worst)} on another part of the motion that the fit did not use; {_SEARCH}"
        )
    if elsewhere > max(ELSEWHERE * said, NEGLIGIBLE):
        reasons.append(
            "the motion does not determine the parameters well enough: their uncertainty alone "
            f"causes {percent(elsewhere)} torque error on other motions in the same range; "
            f"{_RICHER}"
        )
    return Use("prediction", tuple(reasons))


def in_motion(fit: TorqueFit) -> TorqueFit:
    """Return the fit of joints that move, where any does."""
    return fit.in_motion if fit.in_motion.size.any() else fit


def _noise_of(noise: Residual, left: Residual) -> Residual:
    """Return what noise leaves: in the band no more than is left, as it is not always white."""
    each = map(min, noise.per_joint or (), left.per_joint or ())
    return Residual(min(noise.relative, left.relative), tuple(each))


def _beyond(held: Residual, noise: Residual) -> float | None:
    """Return the part of a torque that noise does not explain; None where no joint shows any."""
    if quiet(held.per_joint or (), noise.per_joint or (), LEAST):
        return None
    floor = float(np.nan_to_num(noise.relative))
    return math.sqrt(max(held.relative**2 - floor**2, 0.0))


def _unexplained(
    held: TorqueFit, noise: Residual, robot: Robot, unknown: bool, where: str
) -> Iterator[str]:
    """Yield texts on joints with an unexplained held-out torque, or with too much noise.

    Args:
        held: torque of joints in motion.
        noise: its noise floor.
        robot: for the names of joints.
        unknown: whether no cause is known.
        where: " in motion" if some joints are at rest, else "".
    """
    said, each, floor = (
        held.residual.relative,
        *(np.array(r.per_joint) for r in (held.residual, noise)),
    )
    whole, level = unexplained_from(noise)
    # What is little beside the torque of all joints concerns nobody.
    counts, wrong = (x > LEAST**2 * held.size.sum() for x in (held.size, held.error))
    lost = np.flatnonzero((counts | wrong) & (each > level))
    cause = ", cause unknown" if unknown else ""
    if said > whole:
        yield (
            f"the torque error on held-out data is {percent(said)}{where} (noise floor: "
            f"{percent(noise.relative)}){cause}"
        )
    if len(lost):
        told = ", ".join(
            f"{robot.listed([int(j)])} {percent(each[j])} (noise floor: {percent(floor[j])})"
            for j in lost
        )
        yield f"the torque of single joints is unexplained: {told}{cause}"
    drowned = np.flatnonzero(counts & (each <= level) & (level >= 1))
    if len(drowned):
        told = ", ".join(f"{robot.listed([int(j)])} ({percent(floor[j])})" for j in drowned)
        yield (
            f"the torque is mostly noise at {told}: no model of it can be assessed; record a "
            "motion with larger torques"
        )


def _largest(seen: TorqueFit, robot: Robot) -> tuple[str, ...]:
    """Return the joint with the largest relative torque error, in percent and in N m or N."""
    each = seen.residual.per_joint or ()
    if len(each) < 2 or not seen.traces:
        return ()
    torque = np.concatenate([trace.measured for trace in seen.traces])
    labels = [robot.listed([j]) for j in range(robot.n)]
    units = [names.unit("OF", sigma) for sigma in robot.sigma]
    return (f"largest on {largest(each, torque, labels, units)}",)


def _unread(unexplained: float | None) -> tuple[str, ...]:
    """Say that single values take up what the model lacks, where it lacks a part of the torque."""
    if unexplained is None:
        return ()
    return (f"{_UNREAD}: {percent(unexplained)} of the torque is unexplained",)


def _told_of(unexplained: float | None, noise: Residual) -> tuple[str, ...]:
    """Say how much of the torque nothing explains, beside what noise leaves."""
    if unexplained is None:
        return ()
    return (
        f"{percent(unexplained)} of the torque is unexplained, cause unknown (noise floor: "
        f"{percent(noise.relative)}): {_SEARCH}",
    )


def error_elsewhere(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    covariance: FloatArray,
    together: Sequence[Sequence[int]] = (),
) -> float:
    """Return the torque error on other motions of the same range, from the noise of X alone.

        sqrt(sum over states of tr(W C W')) / sqrt(sum over states of tau' tau)

    of the joints that motors drive, with W at states whose joints are drawn from the logs
    independently of each other: each joint as it was, but in company that it did not keep; and tau
    those of the logs. Joints that moved in proportion are drawn together: the model is said to hold
    for such motion alone. What the model misses is no part of C: the held-out error shows it.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        covariance: C of X, from noise, (p, p).
        together: joints that moved in proportion, in groups.
    """
    motion = [
        np.concatenate([getattr(log, key)[log.kept] for log in logs]) for key in ("q", "qd", "qdd")
    ]
    tau = np.concatenate([log.measured for log in logs])
    W = evaluator["torque_regressor"](*mixed_states(*motion, together=together))
    W = np.delete(W, evaluator.model.robot.passive, axis=1)
    linear = W.shape[2]
    spread = np.einsum("kja,ab,kjb->", W, covariance[:linear, :linear], W) / STATES
    size = float(np.mean(np.sum(tau**2, axis=1)))
    return float(np.sqrt(max(spread, 0.0) / max(size, 1e-300)))


def mixed_states(*motion: FloatArray, together: Sequence[Sequence[int]] = ()) -> list[FloatArray]:
    """Return states whose joints are drawn from a motion, (N, n) each, independently.

    Args:
        motion: positions, speeds, ....
        together: groups of joints that are drawn as one.
    """
    count, n = motion[0].shape
    rows = np.random.default_rng(SEED).integers(count, size=(STATES, n))
    for first, *others in together:
        rows[:, others] = rows[:, [first]]
    return [np.ascontiguousarray(x[rows, np.arange(n)]) for x in motion]


def parameters_use(
    parameters: Sequence[ParameterEstimate],
    physical: Consistency,
    doubts: Sequence[str],
    *,
    scaled: bool,
) -> Use:
    """Say which parameters are known, and what speaks against them as those of a robot.

    Args:
        parameters: of the estimate.
        physical: whether a robot can have them.
        doubts: further reasons.
        scaled: whether they have a common factor that is unknown.
    """
    if scaled:
        return Use("parameters", (_SCALED, *doubts))
    known = tuple(p.name for p in parameters if p.relative_std_percent <= KNOWN)
    reasons = list(doubts)
    hidden = [p.name for p in parameters if math.isnan(p.std)]
    if hidden:
        reasons.append(f"{_OPEN}: {first_of(hidden, 8)}")
    weak = [p.name for p in parameters if p.name not in (*known, *hidden)]
    if weak:
        told = f"{len(weak)} of {len(parameters)} {_WEAK} (std above {KNOWN:g} %)"
        reasons.append(f"{told}: {first_of(weak, 8)}")
    negative = negative_parameters(parameters)
    if negative:
        reasons.append(f"{', '.join(negative)} must be positive but is negative")
    if physical.feasible is False:
        reasons.append(f"not physically possible: {physical.reason}")
    return Use("parameters", tuple(reasons), known)


def below_zero(
    parameters: Sequence[ParameterEstimate], prefixes: Sequence[str], deviations: float
) -> list[str]:
    """Return the parameters of some kinds that are negative by so many deviations."""
    return [
        p.name
        for p in parameters
        if p.name.rstrip("0123456789") in prefixes and p.value < -deviations * p.std
    ]


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


def impossible(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, covariance: FloatArray
) -> tuple[str, ...]:
    """Say why no robot has some parameters, each reason beyond 3 standard deviations.

    Args:
        evaluator: the compiled model, with torque_regressor and inverse_dynamics.
        logs: the training logs.
        X, covariance: of the parameters, (p,) and (p, p).
    """
    std = np.sqrt(np.diag(covariance))
    below = negative_parameters(parameter_estimates(evaluator, X, std))
    return (
        *driving_friction(evaluator, logs, X, covariance),
        *negative_mass(evaluator, logs, X, covariance),
        *(f"{name} must be positive but is negative" for name in below),
    )


def level_exceeded(evaluator: Evaluator, logs: Sequence[FilteredLog], fit: Outcome) -> str:
    """Say which errors of a fit are above the level of an unknown cause; "" if none is.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the validation logs.
        fit: the fit of the training logs.
    """
    held = in_motion(fit.seen)
    noise = _noise_of(noise_fit(evaluator, logs, fit.solution.X).residual, held.residual)
    return "; ".join(_unexplained(held, noise, evaluator.model.robot, False, ""))


def like_no_robot(wrong: Sequence[str], possible: str) -> str:
    """Say that no robot has the parameters that fit, and what is known of possible ones.

    Parameters that no robot has can hide what is wrong with a log, on motion like its own alone.
    """
    return (
        f"no robot moves like this: {wrong[0].split(':')[0]}; physically possible parameters: "
        f"{possible}; check signs, units and gravity; {_SEARCH}"
    )


def negative_parameters(parameters: Sequence[ParameterEstimate]) -> list[str]:
    """Return what must be positive and is negative beyond doubt."""
    standard = [p for p in parameters if p.expression == p.name]
    return below_zero(standard, POSITIVE, SIGNIFICANT)


def simulation_use(
    evaluator: Evaluator,
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]],
    X: FloatArray,
    parameters: Sequence[ParameterEstimate],
    limits: Sequence[str] = (),
    trials: Trials = NO_TRIALS,
) -> Use:
    """Judge whether the model can be simulated over the range of the motion.

    The mass matrix has to be positive definite at positions of the logs, and at positions whose
    joints are drawn from them independently; coefficients of friction must not be negative. On
    held-out motion, the model has to come nearer to the log than a robot that stands still: after
    the shortest horizon, its position error must be below the distance moved. A simulated robot
    keeps no proportion: a model with `limits`, of motion alone, is good for none.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the training logs, and the held-out ones.
        X: the parameters, (p,).
        parameters: the same with their standard deviations.
        limits: what the model is restricted to, in words.
        trials: what is simulated beside X.
    """
    if limits:
        return Use("simulation", tuple(limits))
    train, held = logs
    q = np.concatenate([log.q[log.kept] for log in train])
    at = np.concatenate([q[:: max(1, len(q) // STATES)], *mixed_states(q)])
    M = mass_matrices(evaluator, at, X)
    least = np.linalg.eigvalsh((M + M.transpose(0, 2, 1)) / 2)[:, 0]
    reasons = []
    if (least <= 0).any():
        share = 100 * float(np.mean(least <= 0))
        reasons.append(
            f"the mass matrix is not positive definite at {share:.3g} % of the positions in the "
            "range of the motion"
        )
    rubs = below_zero(parameters, ("FS", "FV", "FSM", "FVM"), 0.0)
    if rubs:
        reasons.append(f"{', '.join(rubs)} is negative: friction would drive the joint")
    if reasons:
        reasons.append("symgen identify --method consistent gives physically possible parameters")
    windows = windows_of(held, max(1, WINDOWS_PLAYED // max(1, len(held))))
    if len(windows) > WINDOWS_PLAYED:  # more logs than windows
        evenly = np.linspace(0, len(windows) - 1, WINDOWS_PLAYED).astype(int)
        windows = [windows[k] for k in evenly]
    horizons, diverged = _played(evaluator, windows, X)
    before, _ = _played(evaluator, windows, trials.own_values)
    held_by, _ = _played(evaluator, windows, X, trials.gains) if trials.gains else ((), 0)
    if not horizons and not reasons:
        reasons.append("no held-out motion was simulated, which is what shows it")
    if horizons and horizons[0].position_error >= 1:
        first = horizons[0]
        reasons.append(
            f"under the torques of held-out motion it is {percent(first.position_error)} of the "
            f"distance moved away after {first.seconds:g} s"
        )
    return Use(
        "simulation",
        tuple(reasons),
        horizons=horizons,
        before=before,
        with_feedback=held_by,
        windows=len(windows) if horizons else 0,
        diverged=diverged,
    )


def _played(
    evaluator: Evaluator,
    windows: Sequence[Window],
    X: FloatArray | None,
    gains: Gains | None = None,
) -> tuple[tuple[Horizon, ...], int]:
    """Return the position errors over windows, and how many diverged; none without a motion."""
    if X is None or not windows:
        return (), 0
    t = np.array([0.0, *(h for h in HORIZONS if h <= windows[0].seconds)])
    try:
        mover = model_mover(evaluator.model, X)
    except ParameterError:  # negative friction: the reasons name it
        return (), 0
    return position_errors(windows, t, play(mover, windows, t, gains))


def headline(
    uses: Sequence[Use], count: int, errors: tuple[float, float], rests: Sequence[str] = ()
) -> str:
    """Return one line for each use: what the estimate is good for, and what helps if it is not.

    Args:
        uses: the assessed uses: prediction, parameters and simulation.
        count: number of parameters.
        errors: torque error on held-out data and on the training logs.
        rests: further texts for an estimate that is good for prediction.
    """
    prediction, parameters, simulation = uses
    held, own = map(percent, errors)
    known = len(parameters.known)
    first = ["Not good for torque prediction: ", *prediction.reasons]
    if prediction.ok:
        first = ["Good for torque prediction: ", f"{held} torque error on held-out data ({own} on "
                 "the training logs)", *rests]  # fmt: skip
    told = f"{known} of {count} are known to {KNOWN:g} %"
    unread = [reason for reason in parameters.reasons if reason.startswith(_UNREAD)]
    others = [r for r in parameters.reasons if r not in unread and _WEAK not in r]
    second = ["Parameters: ", *unread, told, *others]
    if known < count:
        second.append(_RICHER.replace("them", "more of them").removesuffix(" better"))
    third = ["Good for simulation", *filter(None, [_told_of_simulation(simulation)])]
    if not prediction.ok:
        # What moves slowly or swings freely keeps near its path under torques that are wrong.
        third[0] = "Good for simulation of positions over short times, not of torques"
    third[:1] = [f"{third[0]}: "] if len(third) > 1 else third[:1]
    if not simulation.ok:
        third = ["Not good for simulation: ", *simulation.reasons]
    return BETWEEN_USES.join(f"{line[0]}{'; '.join(line[1:])}." for line in (first, second, third))


def _told_of_simulation(use: Use) -> str:
    """Say how far the simulated robot is from held-out motion at the end; "" where unknown."""
    if not use.horizons:
        return ""
    last = use.horizons[-1]
    told = f"position error after {last.seconds:g} s {percent(last.position_error)} of the distance"
    if use.before:
        told += f" moved ({percent(use.before[-1].position_error)} with the values of the file)"
    else:
        told += " moved"
    if use.diverged:
        told += f", {use.diverged} of {use.windows} windows diverge"
    return told


def hardly_moving(logs: Sequence[FilteredLog], robot: Robot) -> tuple[str, ...]:
    """Say which joints stay slower than 2 % of the fastest one of their kind in all logs.

    What is fitted there carries over to faster motions of these joints by chance only, whatever
    its standard deviation.
    """
    moving = moving_joints([log.qd for log in logs], robot.sigma)
    size = np.ptp(np.concatenate([log.q for log in logs]), axis=0)
    return tuple(
        f"{robot.listed([j])} hardly moves ({size[j]:.2g} "
        f"{'m' if kind == names.PRISMATIC else 'rad'} in all): its "
        "friction and inertia hold for no larger motion; move it too, or fix it in the robot "
        "(sigma = 2; symgen import --fix)"
        for j, kind in enumerate(robot.sigma)
        if j not in moving
    )


def disagreement(found: Sequence[Alternative]) -> tuple[str, ...]:
    """Say which models see parameters apart from the chosen one, which is the first."""
    out = []
    for a in found:
        told = [f"{n} ({r:.2g} std)" for n, r in sorted(a.apart, key=lambda x: -x[1])]
        more = f" and {len(told) - 5} more" if len(told) > 5 else ""
        if told:
            out.append(
                f"the {a.model} model gives other values than the {found[0].model} model for "
                f"{', '.join(told[:5])}{more}: an effect is missing; {_SEARCH}"
            )
    return tuple(out)


def model_traces(part: EquatedLog, model: EquationModel, X: FloatArray) -> tuple[Trace, ...]:
    """Return what the model's own equations measure and predict, for drawing."""
    if model.name == "torque":  # drawn from `fit`
        return ()
    t = reduce(np.intersect1d, [e.t for e in part.equations])  # a mask is by joint
    kept = [(e, np.isin(e.t, t)) for e in part.equations]
    measured = np.stack([(e.y / e.scale)[k] for e, k in kept], axis=1)
    predicted = np.stack([(e.W @ X / e.scale)[k] for e, k in kept], axis=1)
    return (Trace(part.log.name, part.kind, model.name, t, measured, predicted),)


def wrong_sign(
    evaluator: Evaluator, train: Sequence[EquatedLog], model: EquationModel, left: float
) -> tuple[str, ...]:
    """Say which joint fits at least twice as well when its drive turns the other way.

    Tried for robots with [drive] alone, whose signs nothing else can prove.

    Args:
        evaluator: the compiled model.
        train: the training logs.
        model: of their equations.
        left: relative residual of the estimate on them.
    """
    robot = evaluator.model.robot
    if robot.drive is None or left < _LOUD:
        return ()
    turned = ("q", "qd", "tau") if robot.drive.position_side == "motor" else ("tau",)
    found: dict[int, float] = {}
    for j, joint in enumerate(robot.movable):
        logs = [multiplied(p.log, (j,), -1.0, turned) for p in train]
        parts = [equate(evaluator, log, model) for log in logs]
        system = system_of(evaluator, parts)
        with suppress(IdentificationError, np.linalg.LinAlgError):
            X = Wls().solve(system).X
            found[joint.number] = equation_residual(system.logs, X).relative
    best = min(found, key=lambda number: found[number], default=None)
    if best is None or found[best] > _BETTER * left:
        return ()
    return (
        f"{robot.label(best)} fits better with the other sign of its ratio in [drive]: the "
        "residual falls "
        f"from {100 * left:.2g} to {100 * found[best]:.2g} %",
    )
