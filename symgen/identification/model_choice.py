"""The band of a run, and the model that is chosen for it.

There are three ways to the same parameters: energy, momentum and torque from the same filtered
logs. What chooses between them is the error in torque, in the comparison band, on folds of the
training logs that a fit did not see. Where two of them give parameters that differ by more than
chance, the model of the robot misses something.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from statistics import NormalDist

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
from symgen.estimation.masking import require_left
from symgen.estimation.solve import (
    IdentifiableColumns,
    Solution,
    column_norms,
    identifiable_columns,
)
from symgen.estimation.summary import (
    BLOCKS,
    Blocks,
    block_errors,
    block_summary,
    deviation_of_difference,
    held_out_error,
)
from symgen.estimation.torque_error import TorqueFit, fit
from symgen.estimation.values import FloatArray
from symgen.faults.causes import find_cause
from symgen.faults.fault import Fault, undo_faults
from symgen.faults.logs import join_bands
from symgen.faults.model import channel_faults
from symgen.faults.samples import unmended_faults
from symgen.faults.scene import Rows, Scene
from symgen.identification.estimate import Alternative, Apart
from symgen.identification.instruments import instrumented
from symgen.identification.solving import (
    EquatedLog,
    Method,
    equate,
    noise_columns,
    settle_load,
    solve,
    system_of,
)
from symgen.parallel import Say, silent
from symgen.policy import MISFIT
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

_SHIFTS = 3  # of torques that are late
#: Difference in standard deviations from which two estimates of one parameter disagree, for one
#: comparison; more for more of them, so that as few are chance (Bonferroni).
APART = 3.0
#: Equations of the torques that models are compared by.
_COMPARED = EquationModel("torque", 0.0)
#: Speeds closer than this to a linear relation are proportional.
PROPORTIONAL = 0.03
#: Noise takes so much of what a column has for itself, at most: least squares is biased by as much,
#: and a parameter counts as known up to 30 % (Fuller 1987, section 1.1).
_ATTENUATED = 0.3


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
        faults: of the channels, that are left.
        causes: what is wrong with the logs or the robot file, in words.
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
    faults: tuple[Fault, ...] = ()
    causes: tuple[str, ...] = ()
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
    band = choose_band(evaluator, train, cutoff, own_speeds=own_speeds, threads=threads)
    progress(f"band: {band.in_words()}")
    logs, others = ([filter_log(s, band) for s in group] for group in (train, held))
    repairs = (*opened.repairs, *more)
    return Run(evaluator, band, tuple(logs), tuple(others), repairs, opened.given)


def undo_delay(run: Run) -> Run:
    """Shift torques that are late by the model; keep what else is wrong with the channels."""
    if run.evaluator.model.robot.loaded:
        return run
    for _ in range(_SHIFTS):
        faults = channel_faults(run.evaluator, run.train, run.held)
        late = next((f for f in faults if f.kind == "delay"), None)
        if late is None:
            break
        told = replace(
            late, samples=sum(len(s.t) for s in run.logs), done="shifted", undo=None,
            values=(("DT", late.value, math.nan),),
        )  # fmt: skip
        train, held = (
            tuple(undo_faults(log, [late])[0] for log in group) for group in (run.train, run.held)
        )
        repairs, delay = (*run.repairs, told), run.delay + late.value
        run = replace(run, train=train, held=held, repairs=repairs, delay=delay)
    return replace(run, faults=tuple(f for f in faults if f.kind != "delay"))


def filter_in_time(opened: OpenLogs, cutoff: float | None, *, own_speeds: bool = False) -> Run:
    """Filter the logs in their band, and shift torques that are late; arguments as before.

    Where these were late by more than a kept row, no model has told the band: it is chosen again.
    """
    run = undo_delay(filter_in_band(opened, cutoff, own_speeds=own_speeds))
    if abs(run.delay) * run.band.comparison_hz * PER_PERIOD <= 1:
        return run
    train, held = ([log.samples for log in group] for group in (run.train, run.held))
    shifted = OpenLogs(
        opened.evaluator, train, held, (), opened.given, opened.progress, opened.threads
    )
    again = filter_in_band(shifted, cutoff, own_speeds=own_speeds)
    return replace(again, repairs=run.repairs, faults=run.faults, delay=run.delay)


def name_cause(run: Run) -> Run:
    """Name what is wrong with the logs or the robot file, where the data do.

    Besides, it is found how large the error is on motion that a fit did not see.
    """
    robot = run.evaluator.model.robot
    logs = [log.samples for log in run.logs]
    broken = tuple(f.fault for s in logs for f in unmended_faults(s, robot.passive))
    if broken or robot.loaded:
        return replace(run, causes=broken)  # behind it, other causes would not be comparable
    scene = Scene(Rows(run.evaluator, run.logs, len(run.train), MISFIT))
    # Where parameters are not told apart, any cause could be one of them.
    told = not proportional_joints(run.train)
    cause = find_cause(scene, run.faults, run.repairs) if told else None
    # What is masked is filtered into the rows around it, a little.
    worst = 0.0 if any(log.mask is not None for log in run.logs) else scene.worst
    return replace(run, causes=(cause.says,) if cause else (), worst=worst)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A model with its equations, solved by weighted least squares.

    Attributes:
        model: of the equations.
        train: the training logs with them.
        blocks: their summary by blocks of time.
        held_out: error in torque on folds that were left out of the fit.
        solution: by weighted least squares; the error where the equations determine none.
        torques: of the training and the validation logs; empty without a solution.
        columns: which parameters the equations determine; None for all.
    """

    model: EquationModel
    train: list[EquatedLog]
    blocks: Blocks
    held_out: float
    solution: Solution | Exception
    torques: tuple[TorqueFit, ...]
    columns: IdentifiableColumns | None


@dataclass(frozen=True, eq=False)
class ChosenModel:
    """A run with the equations of the model that was chosen for it.

    Attributes:
        run: the logs.
        model: of the equations.
        train, held: the logs with its equations.
        found: the models that were fitted, the chosen one first.
        fault: of the motion, in words, or "".
        plain: weighted least squares of these equations, where they determine it and no effect of
            the load had to settle.
        torques: of the training and the validation logs at its X.
        columns: which parameters the equations determine; None for all.
        together: joints whose speeds are proportional to each other throughout, in groups.
    """

    run: Run
    model: EquationModel
    train: list[EquatedLog]
    held: list[EquatedLog]
    found: tuple[Alternative, ...] = ()
    fault: str = ""
    plain: Solution | None = None
    torques: tuple[TorqueFit, ...] = ()
    columns: IdentifiableColumns | None = None
    together: tuple[tuple[int, ...], ...] = ()

    @property
    def kept(self) -> list[int] | None:
        """Places of the parameters that are solved for; None for all."""
        return None if self.columns is None else self.columns.kept


def choose_model(
    run: Run,
    models: Sequence[EquationModel],
    method: Method,
    shares: Sequence[float],
    motions: Sequence[Source],
    progress: Say,
) -> ChosenModel:
    """Fit the models and take the one that predicts best.

    Args:
        run: the logs in the band.
        models: whose equations are tried.
        method: that solves them then.
        shares: weights of the squared residuals of each training log, or none.
        motions: the commanded motion of each training log, or none.
        progress: is told what is being done.

    Raises:
        IdentificationError: no model's equations fit these logs; the reason of the first.
        LogError: a mask leaves too little, or a validation log is too short.
    """
    evaluator = run.evaluator
    together = proportional_joints(run.train)
    fault = motion_fault(together, evaluator.model.robot)
    known = features_of(run.train, evaluator.model.robot.sigma)
    models = [replace(model, features=known) for model in models]
    if evaluator.model.robot.loaded:
        progress("settling the effects that hold the model's torque")
        model = settle_load(evaluator, run.train, models[0])
        chosen = ChosenModel(
            run, model, _enough(run, _equations(run, model, shares)), [], fault=fault
        )
    else:
        progress(f"fitting {', '.join(m.name for m in models)}")
        with blame_motion(fault):
            # A prior tells what the motion does not.
            reduce = bool(together) and method.prior is None
            best, found = _alternatives(run, models, shares, reduce)
        plain = best.solution if isinstance(best.solution, Solution) else None
        about = plain, best.torques, best.columns, together
        chosen = ChosenModel(run, best.model, best.train, [], found, fault, *about)
    try:
        held = [equate(evaluator, log, chosen.model, kind="validation") for log in run.held]
    except IdentificationError as error:
        what = "; accepted: a longer log, or a second one for validation"
        raise LogError(f"{error}{what}") from error
    return replace(
        chosen,
        train=[
            instrumented(evaluator, part, chosen.model, motions[k] if motions else None)
            if method.name == "iv" or method.is_tested(part.log)
            else part
            for k, part in enumerate(chosen.train)
        ],
        held=_enough(run, held),
    )


def _equations(run: Run, model: EquationModel, shares: Sequence[float]) -> list[EquatedLog]:
    """Return the training logs with equations, weighed as it was asked for."""
    pairs = zip(run.train, shares or [1.0] * len(run.train), strict=True)
    return [equate(run.evaluator, log, model, weight) for log, weight in pairs]


def _enough(run: Run, logs: list[EquatedLog]) -> list[EquatedLog]:
    """Return logs of which masks leave enough equations."""
    for part in logs:
        require_left(part.log, part.equations, run.evaluator.model.robot)
    return logs


def _summary(logs: Sequence[EquatedLog], model: EquationModel) -> Blocks:
    """Return the summary of equations by blocks of time."""
    return block_summary([p.equations for p in logs], model.gap)


def _alternatives(
    run: Run, models: Sequence[EquationModel], shares: Sequence[float], reduce: bool
) -> tuple[Candidate, tuple[Alternative, ...]]:
    """Fit every model and compare them; validation logs report, and do not choose.

    Args:
        run: the logs in the band.
        models: whose equations are tried.
        shares: weights of the squared residuals of each training log, or none.
        reduce: whether to solve for what the equations determine alone.

    Returns:
        The model that predicts best, and what is told of all, that one first.
    """
    compared = _equations(run, replace(_COMPARED, features=models[0].features), shares)
    torques = _summary(compared, _COMPARED)
    fitted, lost = list[Candidate](), dict[str, IdentificationError]()
    for model in models:
        try:
            torque = model.name == _COMPARED.name
            train = _enough(run, compared if torque else _equations(run, model, shares))
        except IdentificationError as error:
            lost[model.name] = error
            continue
        blocks = _summary(train, model)
        left = held_out_error(block_errors(blocks, torques))
        columns = _determined_columns(run, train, model) if reduce else None
        kept = None if columns is None else columns.kept
        solution: Solution | Exception
        fits: tuple[TorqueFit, ...] = ()
        try:
            solution = solve(run.evaluator, train, Method(Wls.name), model, kept)
            fits = run.torques(solution.X)
        except (IdentificationError, np.linalg.LinAlgError) as singular:
            solution = singular
        fitted.append(Candidate(model, train, blocks, left, solution, fits, columns))
    if not fitted:
        raise next(iter(lost.values()))
    best = min(fitted, key=lambda f: f.held_out)
    found = [_alternative(f, best, run.evaluator.model.base.names) for f in fitted]
    found.sort(key=lambda a: (not a.chosen, a.held_out))
    found += [
        Alternative(model, math.inf, None, None, math.inf, False, str(error))
        for model, error in lost.items()
    ]
    return best, tuple(found)


def _determined_columns(
    run: Run, train: Sequence[EquatedLog], model: EquationModel
) -> IdentifiableColumns | None:
    """Return which parameters some equations determine beyond noise; None for all."""
    W = system_of(run.evaluator, train).W
    noise = noise_columns(run.evaluator, run.train, model)
    columns = identifiable_columns(W, noise / math.sqrt(_ATTENUATED))
    return None if len(columns.known) == W.shape[1] else columns


def _alternative(own: Candidate, best: Candidate, names: Sequence[str]) -> Alternative:
    """Return what is told of a model beside the best one."""
    reason = f"{100 * own.held_out:.3g} % torque error on folds left out"
    apart: tuple[Apart, ...] = ()
    number, train, held = math.inf, None, None
    if own is not best:
        reason += f", {own.held_out / max(best.held_out, 1e-300):.3g} times the best"
    if isinstance(own.solution, Solution):
        number = own.solution.condition_number
        train, held = (f.residual for f in own.torques)
        told = own is not best and own.columns is None and best.columns is None
        apart = _apart(own.blocks, best.blocks, names) if told else ()
    else:
        singular = isinstance(own.solution, np.linalg.LinAlgError)
        reason += "; singular" if singular else f"; {own.solution}"
    model = own.model.name
    return Alternative(model, number, train, held, own.held_out, own is best, reason, apart)


def _apart(a: Blocks, b: Blocks, names: Sequence[str]) -> tuple[Apart, ...]:
    """Return the parameters that two models see apart, with how far, in std of the difference."""
    filled = [k for k in range(BLOCKS) if a.rows[k].any() and b.rows[k].any()]
    if len(filled) < BLOCKS // 2:
        return ()
    std = deviation_of_difference(a, b, filled)
    from scipy.special import stdtrit

    # the level of 3 std for one comparison, shared by all of them, under Student's law
    tail = (1 - NormalDist().cdf(APART)) / max(len(names), 1)
    level = stdtrit(len(filled) - 1, 1 - tail)
    ratio = np.abs(a.fit() - b.fit()) / np.where(std > 0, std, np.inf)
    return tuple(Apart(name, float(r)) for name, r in zip(names, ratio, strict=True) if r > level)


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
