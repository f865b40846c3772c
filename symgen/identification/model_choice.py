"""The band of a run, and the model that is chosen for it.

There are three ways to the same parameters: energy, momentum and torque from the same filtered
logs. What chooses between them is the error in torque, in the comparison band, on folds of the
training logs that a fit did not see.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

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
from symgen.estimation.logs import Source
from symgen.estimation.masking import require_equations
from symgen.estimation.solve import (
    IdentifiableColumns,
    Solution,
    column_norms,
    identifiable_columns,
)
from symgen.estimation.summary import (
    Blocks,
    block_errors,
    block_summary,
    held_out_error,
)
from symgen.estimation.torque_error import TorqueFit, fit, percent
from symgen.estimation.values import FloatArray, Reason
from symgen.faults.fault import EVERYWHERE, Fault
from symgen.faults.logs import join_bands
from symgen.faults.samples import unmended_faults
from symgen.hypotheses.ask import ask
from symgen.hypotheses.changes import Change
from symgen.hypotheses.event import Contact
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
from symgen.parallel import Say, silent
from symgen.policy import KNOWN
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Equations of the torques that models are compared by.
_COMPARED = EquationModel("torque", 0.0)
#: Speeds closer than this to a linear relation are proportional.
PROPORTIONAL = 0.03


@dataclass(frozen=True, eq=False)
class OpenLogs:
    """Logs that were opened and repaired, or a sample of them, and the model of their robot.

    Attributes:
        evaluator: the compiled model.
        train, held: the logs.
        repairs: what was mended in them.
        given: whether validation logs were given.
        progress: is told what is being done.
        threads: that look for the band at once.
    """

    evaluator: Evaluator
    train: Sequence[Samples]
    held: Sequence[Samples] = ()
    repairs: Sequence[Fault] = ()
    given: bool = True
    progress: Say = silent
    threads: int = 1


@dataclass(frozen=True, eq=False)
class Run:
    """Logs in the band that was chosen for them.

    Attributes:
        evaluator: the compiled model.
        band: the filters.
        train, held: the logs.
        repairs: what was mended in them.
        given: whether validation logs were given.
        shown: faults of recorder or robot file that are shown as the cause.
        suspected: what else may be wrong or missing.
        delay: by which torques were late, s.
        worst: torque error on the fold of motion where it is largest, of fits to the others; 0.0
            where something is masked.
    """

    evaluator: Evaluator
    band: Band
    train: tuple[FilteredLog, ...]
    held: tuple[FilteredLog, ...] = ()
    repairs: tuple[Fault, ...] = ()
    given: bool = True
    shown: tuple[Reason, ...] = ()
    suspected: tuple[Reason, ...] = ()
    delay: float = 0.0
    worst: float = 0.0

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """All logs."""
        return (*self.train, *self.held)

    def torques(self, X: FloatArray) -> tuple[TorqueFit, TorqueFit]:
        """Compare the torques of the training and of the validation logs with those of X, (p,)."""
        train = fit(self.evaluator, self.train, X, "train")
        return train, fit(self.evaluator, self.held, X)


def filter_in_band(opened: OpenLogs, cutoff: float | None, *, own_speeds: bool = False) -> Run:
    """Mend speeds, choose the band, and filter the logs in it.

    Args:
        opened: the logs.
        cutoff: of the filter, Hz, where the user gives it.
        own_speeds: whether measured speeds are kept in any case.
    """
    evaluator, progress = opened.evaluator, opened.progress
    progress("choosing the band")
    train, held, more = join_bands(opened.train, opened.held)
    threads = opened.threads
    band = choose_band(evaluator, train, cutoff, measured_speeds=own_speeds, threads=threads)
    progress(f"band: {band.in_words()}")
    logs, others = ([filter_log(s, band) for s in group] for group in (train, held))
    repairs = (*opened.repairs, *more)
    return Run(evaluator, band, tuple(logs), tuple(others), repairs, opened.given)


def ask_search(opened: OpenLogs, run: Run, cutoff: float | None, least: float) -> Run:
    """Ask what may be missing or wrong, and shift torques that are late.

    Where these are late by more than a kept row, no model has told the band: it is chosen again.

    Args:
        opened: the logs.
        run: the same in their band.
        cutoff: of the filter, Hz, where the user gives it.
        least: smallest torque that matters, as a part of a joint's torque.
    """
    robot = run.evaluator.model.robot
    every = [f for log in run.logs for f in unmended_faults(log.samples, robot.passive)]
    broken = tuple(Reason("broken_channel", text=f.fault) for f in every)
    # Where parameters are not told apart, any cause could be one of them.
    if broken or robot.loaded or proportional_joints(run.train):
        return replace(run, shown=broken)
    answer = ask(run.evaluator, run.train, run.held, least, opened.progress)
    for change in answer.delays:
        run = _shifted(run, change)
    if abs(run.delay) * run.band.comparison_hz * PER_PERIOD > 1:
        train, held = ([log.samples for log in group] for group in (run.train, run.held))
        again = replace(opened, train=train, held=held, repairs=())
        moved = filter_in_band(again, cutoff)
        run = replace(moved, repairs=run.repairs, delay=run.delay)
    if answer.delays:
        answer = ask(run.evaluator, run.train, run.held, least, opened.progress)
    run = _without(run, answer.contacts)
    # What is masked is filtered into the rows around it, a little.
    masked = any(log.mask is not None for log in run.logs)
    worst = 0.0 if masked else answer.worst
    return replace(run, shown=answer.shown, suspected=answer.suspected, worst=worst)


def _without(run: Run, contacts: Sequence[Contact]) -> Run:
    """Return the run without the samples of contacts, which no motion of the robot explains."""
    for contact in contacts:
        span = contact.span
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
        train, held = (tuple(map(span.left_out, group)) for group in (run.train, run.held))
        run = replace(run, train=train, held=held, repairs=(*run.repairs, fault))
    return run


def _shifted(run: Run, change: Change) -> Run:
    """Return the run with the torques of all joints shifted."""
    ((delay, _),) = change.constants.values()
    word = "late" if delay > 0 else "early"
    fault = Fault(
        EVERYWHERE,
        "tau",
        f"the torques of all joints are {1e3 * abs(delay):.3g} ms {word} against the motion",
        samples=sum(len(s.t) for s in run.logs),
        done="shifted",
        values=(("DT", delay, math.nan),),
        kind="delay",
    )
    train, held = (tuple(map(change.undo, group)) for group in (run.train, run.held))
    repairs = (*run.repairs, fault)
    return replace(run, train=train, held=held, repairs=repairs, delay=run.delay + delay)


@dataclass(frozen=True, eq=False)
class ModelCandidate:
    """A model with its equations, solved by weighted least squares.

    Attributes:
        model: of the equations.
        train: the training logs with them.
        blocks: summaries by blocks of time, of its equations and of the torques.
        held_out: error in torque on folds that were left out of the fit.
        columns: which parameters the equations determine; None for all.
        solution: by weighted least squares; None if they determine none.
        torques: of the training and the validation logs; empty without a solution.
        error: why there is no solution.
    """

    model: EquationModel
    train: list[EquatedLog]
    blocks: tuple[Blocks, Blocks]
    held_out: float = math.inf
    columns: IdentifiableColumns | None = None
    solution: Solution | None = None
    torques: tuple[TorqueFit, ...] = ()
    error: Exception | None = None

    @property
    def kept(self) -> list[int] | None:
        """Places of the parameters that are solved for; None for all."""
        return None if self.columns is None else self.columns.kept


@dataclass(frozen=True, eq=False)
class ChosenModel:
    """A run with the equations of the model that was chosen for it.

    Attributes:
        run: the logs.
        best: the model; its solution is None where an effect of the load had to settle.
        held: the validation logs with its equations.
        found: the models that were fitted, the chosen one first.
        fault: of the motion, in words, or "".
        together: joints whose speeds are proportional to each other throughout, in groups.
    """

    run: Run
    best: ModelCandidate
    held: list[EquatedLog]
    found: tuple[Alternative, ...]
    fault: str
    together: tuple[tuple[int, ...], ...]


def choose_model(
    run: Run,
    models: Sequence[EquationModel],
    method: Method,
    motions: Sequence[Source],
    progress: Say,
) -> ChosenModel:
    """Fit the models and take the one that predicts best.

    Args:
        run: the logs in the band.
        models: whose equations are tried.
        method: that solves them then.
        motions: the commanded motion of each training log, or none.
        progress: is told what is being done.

    Raises:
        IdentificationError: no model's equations fit these logs; the reason of the first.
        LogError: a mask leaves too little, or a validation log is too short.
    """
    evaluator, robot = run.evaluator, run.evaluator.model.robot
    together = proportional_joints(run.train)
    fault = motion_fault(together, robot)
    known = features_of(run.train, robot.sigma)
    models = [replace(model, features=known) for model in models]
    found: tuple[Alternative, ...] = ()
    if robot.loaded:
        progress("settling the effects that hold the model's torque")
        model = settle_load(evaluator, run.train, models[0])
        train = _equations(run, model)
        torques = block_summary([p.equations for p in train], model.gap)
        best = ModelCandidate(model, train, (torques, torques))
    else:
        progress(f"fitting {', '.join(m.name for m in models)}")
        reduce = bool(together) and method.prior is None  # a prior tells what the motion does not
        with blame_motion(fault):
            best, found = _best_model(run, models, reduce)
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
    return ChosenModel(run, replace(best, train=train), held, found, fault, together)


def _equations(run: Run, model: EquationModel) -> list[EquatedLog]:
    """Return the training logs with equations."""
    logs = [EquatedLog("train", log, model.equations(run.evaluator, log)) for log in run.train]
    _require_equations(logs, run.evaluator.model.robot)
    return logs


def _require_equations(logs: Sequence[EquatedLog], robot: Robot) -> None:
    """Refuse logs of which masks leave too few equations."""
    for part in logs:
        require_equations(part.log, part.equations, robot)


def _best_model(
    run: Run, models: Sequence[EquationModel], reduce: bool
) -> tuple[ModelCandidate, tuple[Alternative, ...]]:
    """Fit every model and compare them; validation logs report, and do not choose.

    Args:
        run: the logs in the band.
        models: whose equations are tried.
        reduce: whether to solve for what the equations determine alone.

    Returns:
        The model that predicts best, and the results of all, that one first.
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
        held_out = held_out_error(block_errors(blocks, torques))
        columns = _determined_columns(run, train, model) if reduce else None
        candidate = ModelCandidate(model, train, (blocks, torques), held_out, columns)
        candidates.append(_solved(run, candidate))
    if not candidates:
        raise next(iter(errors.values()))
    candidates.sort(key=lambda candidate: candidate.held_out)
    best = candidates[0]
    found = [_alternative(candidate, best) for candidate in candidates]
    for name, reason in errors.items():
        found.append(Alternative(name, math.inf, None, None, math.inf, False, str(reason)))
    return best, tuple(found)


def _solved(run: Run, candidate: ModelCandidate) -> ModelCandidate:
    """Return a candidate with its solution, or with the error of the solver."""
    plain, model = Method(Wls.name), candidate.model
    try:
        solution = solve_equations(run.evaluator, candidate.train, plain, model, candidate.kept)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return replace(candidate, error=error)
    return replace(candidate, solution=solution, torques=run.torques(solution.X))


def _determined_columns(
    run: Run, train: Sequence[EquatedLog], model: EquationModel
) -> IdentifiableColumns | None:
    """Return which parameters some equations determine beyond noise; None for all.

    Noise takes as much of what a column has for itself as a known parameter may be wrong, at most:
    least squares is biased by that (Fuller 1987, section 1.1).
    """
    W = system_of(run.evaluator, train).W
    noise = noise_columns(run.evaluator, run.train, model)
    columns = identifiable_columns(W, noise / math.sqrt(KNOWN))
    return None if len(columns.known) == W.shape[1] else columns


def _alternative(own: ModelCandidate, best: ModelCandidate) -> Alternative:
    """Return the result of a model beside the best one."""
    number, train, held = math.inf, None, None
    reason = f"{percent(own.held_out)} torque error on folds left out"
    if own is not best:
        reason += f", {own.held_out / max(best.held_out, 1e-300):.3g} times the best"
    if own.error is not None:
        reason += f"; {own.error}"
    if own.solution is not None:
        number = own.solution.condition_number
        train, held = (fit.residual for fit in own.torques)
    return Alternative(own.model.name, number, train, held, own.held_out, own is best, reason)


@contextmanager
def blame_motion(fault: str) -> Iterator[None]:
    """Say why data do not determine parameters, where the motion is why.

    Raises:
        IdentificationError: they do not.
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
    """Return the joints whose speeds are proportional to each other throughout, in groups.

    Gautier and Khalil warn of them: the arm then moves as one body with fewer degrees of freedom,
    and the information matrix is singular.

    Args:
        logs: in the band of the run.
    """
    from scipy.sparse.csgraph import connected_components

    qd = np.concatenate([log.qd for log in logs])
    unit = qd / column_norms(qd)
    apart = np.sqrt(np.maximum(0.0, 1 - (unit.T @ unit) ** 2))
    count, label = connected_components(apart < PROPORTIONAL, directed=False)
    groups = (np.flatnonzero(label == k) for k in range(count))
    return tuple(tuple(map(int, group)) for group in groups if len(group) > 1)


def motion_fault(together: Sequence[Sequence[int]], robot: Robot) -> str:
    """Return in words why a motion cannot excite a model, or ''.

    Args:
        together: joints whose speeds are proportional to each other.
        robot: for the names of joints.
    """
    return "; ".join(
        f"the speeds of {robot.listed(group)} are proportional to each other "
        "throughout; move the joints independently"
        for group in together
    )
