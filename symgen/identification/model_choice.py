"""Choose the band of a run and its model.

Three models give the same parameters from the same filtered logs: energy, momentum and torque.
symgen keeps the one with the smallest torque error, in the comparison band, on held-out folds of
the training logs. The fits to the other folds have a weak prior, since these folds alone may not
determine all parameters. Of models that are as good, symgen prefers momentum to energy, and energy
to torque, which needs accelerations: they are noisier than speeds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.masking import require_equations
from symgen.estimation.opening import Source
from symgen.estimation.solve import (
    Solution,
    column_norms,
    identifiable_columns,
)
from symgen.estimation.summary import Blocks, block_summary, summaries
from symgen.estimation.torque_error import TorqueFit, fit, percent
from symgen.estimation.values import FloatArray, Reason
from symgen.faults.fault import Fault, shifted_torques
from symgen.faults.repair import join_bands
from symgen.faults.samples import unmended_faults
from symgen.hypotheses.ask import ask
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.event import Contact
from symgen.hypotheses.registry import SearchResult
from symgen.identification.estimate import Alternative
from symgen.identification.instruments import instrumented
from symgen.identification.solving import (
    EquatedLog,
    Method,
    noise_columns,
    settle_load,
    solve_equations,
    system_of,
)
from symgen.identification.weak_prior import WeakPrior
from symgen.parallel import Say, silent
from symgen.policy import AS_GOOD, KNOWN, ROUNDING, VARIES
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Kind of the reason that a channel must be recorded again.
BROKEN = "broken_channel"
#: Torque equations, on which the models are compared.
_COMPARED = EquationModel("torque", 0.0)
#: Models in the order of preference if they are as good.
_PREFERRED = ("momentum", "energy", "torque")
#: Factor of the information of a prior that has no effect.
_NONE = 1e-9
_ROUNDS = 3  # most searches; each may find a fault that the ones before hid
#: Two speeds are proportional if the sine of the angle between them is below this.
PROPORTIONAL = 0.03


@dataclass(frozen=True, eq=False)
class OpenLogs:
    """Opened and repaired logs, or a sample of them, and the model of their robot.

    Attributes:
        evaluator: the compiled model.
        train, held: the training and the validation logs.
        repairs: repairs of the logs.
        has_validation: whether there are validation logs from the user.
        progress: called with a text about the current step.
        threads: number of threads that choose the band.
    """

    evaluator: Evaluator
    train: Sequence[Samples]
    held: Sequence[Samples] = ()
    repairs: Sequence[Fault] = ()
    has_validation: bool = True
    progress: Say = silent
    threads: int = 1


@dataclass(frozen=True, eq=False)
class Run:
    """Logs in their band.

    Attributes:
        evaluator: the compiled model.
        band: the filters.
        train, held: the training and the validation logs.
        repairs: repairs of the logs.
        has_validation: whether there are validation logs from the user.
        shown: faults of recorder or robot file that are shown as the cause.
        suspected: other possible faults and missing effects.
        delays: delays of torques that are undone: positions of the joints, empty for all, and s.
        contacts: contacts in the training logs, whose samples are masked.
        largest_fold_error: largest torque error of a fold, predicted by the fit to the other folds;
            0.0 if samples are masked.
        asked: the short search on these logs; None if faults were undone after it.
    """

    evaluator: Evaluator
    band: Band
    train: tuple[FilteredLog, ...]
    held: tuple[FilteredLog, ...] = ()
    repairs: tuple[Fault, ...] = ()
    has_validation: bool = True
    shown: tuple[Reason, ...] = ()
    suspected: tuple[Reason, ...] = ()
    delays: tuple[tuple[tuple[int, ...], float], ...] = ()
    contacts: tuple[Contact, ...] = ()
    largest_fold_error: float = 0.0
    asked: SearchResult | None = None

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """The training logs, then the validation logs."""
        return (*self.train, *self.held)

    def torques(self, X: FloatArray) -> tuple[TorqueFit, TorqueFit]:
        """Compare the torques of the training and of the validation logs with those of X, (p,)."""
        train = fit(self.evaluator, self.train, X, "train")
        return train, fit(self.evaluator, self.held, X)


def filter_in_band(
    opened: OpenLogs, cutoff: float | None, *, own_speeds: bool = False, known: Band | None = None
) -> Run:
    """Repair speeds, choose the band, and filter the logs in it.

    Args:
        opened: the logs.
        cutoff: cutoff of the filter, Hz; None to choose it.
        own_speeds: whether to keep measured speeds in any case.
        known: the band of an earlier run; a cutoff changes its own.
    """
    evaluator, progress = opened.evaluator, opened.progress
    progress("choosing the band")
    train, held, more = join_bands(opened.train, opened.held)
    threads = opened.threads
    if known is None:
        band = choose_band(evaluator, train, cutoff, measured_speeds=own_speeds, threads=threads)
    else:
        band = replace(known, cutoff_hz=known.cutoff_hz if cutoff is None else cutoff)
    progress(f"band: {band.in_words()}")
    logs, others = ([filter_log(s, band) for s in group] for group in (train, held))
    repairs = (*opened.repairs, *more)
    return Run(evaluator, band, tuple(logs), tuple(others), repairs, opened.has_validation)


def ask_search(opened: OpenLogs, run: Run, cutoff: float | None, least: float) -> Run:
    """Search for missing effects and faults of the logs, and undo delays and contacts.

    A delay of more than one kept row spoils the choice of the band, which is then repeated.

    Args:
        opened: the logs.
        run: the same logs in their band.
        cutoff: cutoff of the filter, Hz; None to choose it.
        least: smallest torque that matters, as a part of a joint's torque.
    """
    robot = run.evaluator.model.robot
    every = [f for log in run.logs for f in unmended_faults(log.samples, robot.passive)]
    broken = tuple(Reason(BROKEN, text=f.fault) for f in every)
    if broken:
        return replace(run, shown=broken)
    for _ in range(_ROUNDS):
        answer = ask(run.evaluator, run.train, run.held, least, opened.progress)
        if not (answer.delays or answer.contacts):
            break
        run = _without(_shifted(run, answer.delays), answer.contacts)
        if answer.delays:
            run = _in_better_band(opened, run, cutoff)
    undone = bool(run.delays or run.contacts)
    run = replace(run, asked=None if undone else answer.result)
    # The filter spreads masked samples slightly into the rows around them.
    masked = any(log.mask is not None for log in run.logs)
    largest = 0.0 if masked else answer.largest_fold_error
    run = replace(run, largest_fold_error=largest)
    # With parameters that the logs cannot separate, the search could name any of several causes.
    if proportional_joints(run.train):
        return run
    return replace(run, shown=answer.shown, suspected=answer.suspected)


def _in_better_band(opened: OpenLogs, run: Run, cutoff: float | None) -> Run:
    """Return the run in a band that is chosen again, if its delays spoiled the choice."""
    longest = max(abs(delay) for _, delay in run.delays)
    if longest * run.band.comparison_hz * PER_PERIOD <= 1:
        return run
    train, held = ([log.samples for log in group] for group in (run.train, run.held))
    again = filter_in_band(replace(opened, train=train, held=held, repairs=()), cutoff)
    return replace(again, repairs=run.repairs, delays=run.delays, contacts=run.contacts)


def _without(run: Run, contacts: Sequence[Contact]) -> Run:
    """Return the run with the samples of contacts masked."""
    for contact in contacts:
        span = contact.cause
        where = run.evaluator.model.robot.listed(contact.joints)
        fault = Fault(
            span.log,
            "tau",
            f"contact of {where}, {span.start:.3g} to {span.end:.3g} s",
            samples=span.last - span.first + 1,
            done="left out",
            kind=contact.definition.name,
            joints=contact.joints,
        )
        train, held = (tuple(map(span.mask, group)) for group in (run.train, run.held))
        repairs = (*run.repairs, fault)
        run = replace(run, train=train, held=held, repairs=repairs)
    return replace(run, contacts=(*run.contacts, *contacts))


def _shifted(run: Run, delays: Sequence[Changed]) -> Run:
    """Return the run with the torques of some joints, or of all, shifted."""
    for item in delays:
        change = item.cause
        train, held = (tuple(map(change.undo, group)) for group in (run.train, run.held))
        run = replace(
            run,
            train=train,
            held=held,
            repairs=(*run.repairs, _shift(item, run)),
            delays=(*run.delays, (change.joints, change.delay)),
        )
    return run


def _shift(item: Changed, run: Run) -> Fault:
    """Return the repair of a delay of torques."""
    change, robot = item.cause, run.evaluator.model.robot
    channel = ", ".join(f"tau{j + 1}" for j in change.joints) or "tau"
    joints = robot.listed(change.joints) if change.joints else "all joints"
    fault = shifted_torques(channel, change.delay, change.sizes[0].std, joints)
    samples = sum(len(log.t) for log in run.logs)
    return replace(fault, samples=samples, joints=change.joints, gap_reduction=item.gain)


@dataclass(frozen=True, eq=False)
class ModelCandidate:
    """A model with its equations and its weighted least-squares solution.

    Attributes:
        model: model of the equations.
        train: the training logs with their equations.
        blocks: summaries of the equations and of the torques, by blocks of time.
        prior: weak prior for what the equations do not determine.
        held_out: torque error on held-out folds, of fits with the prior.
        known: indices of the parameters that the equations determine; None for all.
        solution: the weighted least-squares solution, with the prior if the equations do not
            determine all parameters; None if there is none.
        torques: torques of the training and of the validation logs; empty without a solution.
        error: the error of the solver, if there is no solution.
    """

    model: EquationModel
    train: list[EquatedLog]
    blocks: tuple[Blocks, Blocks]
    prior: WeakPrior
    held_out: float = math.inf
    known: list[int] | None = None
    solution: Solution | None = None
    torques: tuple[TorqueFit, ...] = ()
    error: Exception | None = None

    @property
    def needed_prior(self) -> WeakPrior | None:
        """The prior if the equations do not determine all parameters."""
        return None if self.known is None else self.prior

    @cached_property
    def without_prior(self) -> float:
        """Torque error on held-out folds, of fits without the prior."""
        weaker = replace(self.prior, information=_NONE * self.prior.information)
        return weaker.held_out(self.blocks).relative

    @property
    def folds_tell(self) -> bool:
        """Whether the other folds determine the parameters without the prior."""
        return self.without_prior <= VARIES * self.held_out


@dataclass(frozen=True, eq=False)
class ChosenModel:
    """A run and its chosen model.

    Attributes:
        run: the logs.
        best: the chosen model. Its solution is None if the robot has load-dependent effects.
        held: the validation logs with the equations of the model.
        alternatives: the results of all fitted models, the chosen one first.
        fault: a text on a fault of the motion, or "".
        proportional: groups of joints whose speeds are proportional in all training logs.
    """

    run: Run
    best: ModelCandidate
    held: list[EquatedLog]
    alternatives: tuple[Alternative, ...]
    fault: str
    proportional: tuple[tuple[int, ...], ...]


def choose_model(
    run: Run,
    models: Sequence[EquationModel],
    method: Method,
    motions: Sequence[Source],
    progress: Say,
) -> ChosenModel:
    """Fit the models and keep the one with the smallest held-out torque error.

    Args:
        run: the logs in the band.
        models: models to fit.
        method: method that later solves the equations of the chosen model.
        motions: commanded motion of each training log; empty if there are none.
        progress: called with a text about the current step.

    Raises:
        IdentificationError: no model fits these logs; the reason is that of the first model.
        LogError: a mask leaves too few samples, or a validation log is too short.
    """
    evaluator, robot = run.evaluator, run.evaluator.model.robot
    proportional = proportional_joints(run.train)
    fault = motion_fault(proportional, robot)
    known = features_of(run.train, robot.sigma)
    models = [replace(model, features=known) for model in models]
    alternatives: tuple[Alternative, ...] = ()
    if robot.loaded:
        progress("settling the effects that hold the model's torque")
        model = settle_load(evaluator, run.train, models[0])
        train = _equations(run, model)
        torques = block_summary([p.equations for p in train], model.gap)
        prior = _weak_prior(run, train)
        best = ModelCandidate(model, train, (torques, torques), prior)
    else:
        progress(f"fitting {', '.join(m.name for m in models)}")
        # A prior determines the parameters that the motion does not.
        partial = bool(proportional) and method.prior is None
        with blame_motion(fault):
            best, alternatives = _best_model(run, models, partial)
    train = []
    for k, part in enumerate(best.train):
        if method.name == "iv" or method.is_tested(part.log):
            part = instrumented(evaluator, part, best.model, motions[k] if motions else None)
        train.append(part)
    try:
        held = []
        for log in run.held:
            equations = best.model.equations(evaluator, log)
            held.append(EquatedLog("validation", log, equations))
    except IdentificationError as error:
        what = "; accepted: a longer log, or a second one for validation"
        raise LogError(f"{error}{what}") from error
    _require_equations(held, robot)
    return ChosenModel(run, replace(best, train=train), held, alternatives, fault, proportional)


def _equations(run: Run, model: EquationModel) -> list[EquatedLog]:
    """Return the training logs with the equations of a model."""
    logs = [EquatedLog("train", log, model.equations(run.evaluator, log)) for log in run.train]
    _require_equations(logs, run.evaluator.model.robot)
    return logs


def _require_equations(logs: Sequence[EquatedLog], robot: Robot) -> None:
    """Refuse logs whose masks leave too few equations."""
    for part in logs:
        require_equations(part.log, part.equations, robot)


def _best_model(
    run: Run, models: Sequence[EquationModel], partial: bool
) -> tuple[ModelCandidate, tuple[Alternative, ...]]:
    """Fit every model and compare them on folds of the training logs.

    Args:
        run: the logs in the band.
        models: models to fit.
        partial: whether the equations may determine only some of the parameters.

    Returns:
        The model with the smallest torque error, the first of equals, and the results of all
        models, that one first.
    """
    compared = _equations(run, replace(_COMPARED, features=models[0].features))
    torques = block_summary([p.equations for p in compared], _COMPARED.gap)
    candidates, errors = list[ModelCandidate](), dict[str, IdentificationError]()
    for model in models:
        try:
            train = compared
            if model.name != _COMPARED.name:
                train = _equations(run, model)
        except IdentificationError as error:
            errors[model.name] = error
            continue
        blocks = block_summary([p.equations for p in train], model.gap)
        prior = _weak_prior(run, train)
        held_out = prior.held_out((blocks, torques)).relative
        known = _known_parameters(run, train, model) if partial else None
        candidate = ModelCandidate(model, train, (blocks, torques), prior, held_out, known)
        candidates.append(_solved(run, candidate))
    if not candidates:
        raise next(iter(errors.values()))
    least = min(candidate.held_out for candidate in candidates)
    limit = AS_GOOD * max(least, ROUNDING)
    candidates.sort(key=lambda c: (max(c.held_out, limit), _PREFERRED.index(c.model.name)))
    best = candidates[0]
    alternatives = [_alternative(candidate, best) for candidate in candidates]
    for name, reason in errors.items():
        alternatives.append(Alternative(name, math.inf, None, None, math.inf, False, str(reason)))
    return best, tuple(alternatives)


def _solved(run: Run, candidate: ModelCandidate) -> ModelCandidate:
    """Return a candidate with its solution, or with the error of the solver."""
    plain, model = Method(Wls.name), candidate.model
    try:
        solution = solve_equations(
            run.evaluator, candidate.train, plain, model, candidate.needed_prior
        )
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return replace(candidate, error=error)
    return replace(candidate, solution=solution, torques=run.torques(solution.X))


def _weak_prior(run: Run, train: Sequence[EquatedLog]) -> WeakPrior:
    """Return the weak prior for the equations of the training logs."""
    return WeakPrior.of(run.evaluator.model, summaries(system_of(run.evaluator, train)))


def _known_parameters(
    run: Run, train: Sequence[EquatedLog], model: EquationModel
) -> list[int] | None:
    """Return the parameters that some equations determine beyond noise; None for all.

    Noise E of the regressor W biases least squares: along a direction v of the parameters, by the
    share ||E v||^2 / ||W v||^2 (Fuller 1987, section 1.1). The equations determine v if this share
    is below `symgen.policy.KNOWN`.
    """
    W = system_of(run.evaluator, train).W
    noise = noise_columns(run.evaluator, run.train, model)
    known = identifiable_columns(W, noise / math.sqrt(KNOWN)).known
    return None if len(known) == W.shape[1] else known


def _alternative(candidate: ModelCandidate, best: ModelCandidate) -> Alternative:
    """Return the result of a model, compared with the best one."""
    number, train, held = math.inf, None, None
    reason = f"{percent(candidate.held_out)} torque error on folds left out"
    if not candidate.folds_tell:
        without = percent(candidate.without_prior)
        reason += (
            f" with a weak prior (without it {without}: folds do not determine all parameters)"
        )
    if candidate.held_out > best.held_out:
        reason += f", {candidate.held_out / max(best.held_out, 1e-300):.3g} times the best"
    if candidate.error is not None:
        reason += f"; {candidate.error}"
    if candidate.solution is not None:
        number = candidate.solution.condition_number
        train, held = (fit.residual for fit in candidate.torques)
    return Alternative(
        candidate.model.name, number, train, held, candidate.held_out, candidate is best, reason
    )


@contextmanager
def blame_motion(fault: str) -> Iterator[None]:
    """Add a fault of the motion to the error that the data do not determine the parameters.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    try:
        yield
    except IdentificationError as error:
        raise IdentificationError(f"{error}; {fault}" if fault else str(error)) from error
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            "the information matrix is singular: these data do not determine the parameters"
            + (f"; {fault}" if fault else "")
        ) from error


def proportional_joints(logs: Sequence[FilteredLog]) -> tuple[tuple[int, ...], ...]:
    """Return the groups of joints whose speeds are proportional in all logs.

    The arm then moves like one with fewer degrees of freedom, and the information matrix is
    singular (a warning of Gautier and Khalil).

    Args:
        logs: logs in the band of the run.
    """
    from scipy.sparse.csgraph import connected_components

    qd = np.concatenate([log.qd for log in logs])
    unit = qd / column_norms(qd)
    sines = np.sqrt(np.maximum(0.0, 1 - (unit.T @ unit) ** 2))
    count, label = connected_components(sines < PROPORTIONAL, directed=False)
    groups = (np.flatnonzero(label == k) for k in range(count))
    return tuple(tuple(map(int, group)) for group in groups if len(group) > 1)


def motion_fault(proportional: Sequence[Sequence[int]], robot: Robot) -> str:
    """Return a text that says why a motion cannot excite a model, or "".

    Args:
        proportional: groups of joints whose speeds are proportional.
        robot: gives the names of joints.
    """
    return "; ".join(
        f"the speeds of {robot.listed(group)} are proportional to each other "
        "throughout; move the joints independently"
        for group in proportional
    )
