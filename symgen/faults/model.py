"""Channel faults that the model shows: the logs fit better when the fault is undone.

These are late torques and, if the model error is large, exchanged channels of two joints, reversed
joints, and positions in degrees. (`symgen.faults.causes` finds torques with a wrong factor or sign,
and wrong gear ratios.) A fault counts if undoing it leaves, on some joint, at most 0.9 of the error
on folds that the fit did not use, and of the error on validation logs. Faults are found one at a
time, the largest first, because a wrong torque of one joint disturbs the fit of others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from symgen.data.mask import Bools, at_rest, moving_joints, touched
from symgen.data.raw import FloatArray
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.summary import (
    BLOCKS,
    Blocks,
    block_errors,
    block_summary,
    held_out_error,
    solve_gram,
)
from symgen.estimation.system import Equations, torque_equations
from symgen.faults import scene
from symgen.faults.channels import steps
from symgen.faults.fault import EVERYWHERE, Fault, fault_of
from symgen.faults.recorder import common_delay, late_fault
from symgen.faults.scene import Scene, mean_inertia
from symgen.faults.undo import backwards, exchanged, levelled, multiplied
from symgen.policy import MISFIT
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

Rows = Sequence[tuple[Equations, ...]]
#: Largest remaining error on held-out folds, relative to that without undoing, for a named fault.
_CLEARER = 0.9
_STD = 3.0
_AT_REST = 1e-3  # weight of rows at rest, which only determine what no motion determines
#: Torque error above which exchanged torques are tried, error above which faults of the motion are
#: tried, and the largest part of the error that they may leave.
_LOUD, _LOUDER, _EXCHANGED = 0.1, 0.2, 0.7
MOST = 3  # largest number of faults that are undone
_NODES = 8_000  # of all logs together, at which faults of the motion are tried
_MOTION = ("q", "qd")
_SIGMAS = 5.0
_HALF = 0.5  # part of a torque step that the residual must keep


def channel_faults(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    held: Sequence[FilteredLog] = (),
    kinds: Iterable[str] | None = None,
) -> tuple[Fault, ...]:
    """Find channel faults by the torque equations.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs in the band of the run.
        held: the validation logs, which confirm a fault.
        kinds: keys of FINDERS; None for all.
    """
    out: list[Fault] = []
    finders = [find for kind, find in FINDERS.items() if kinds is None or kind in {*kinds}]
    for _ in range(MOST):
        found = _largest(Trial(evaluator, logs, held), finders)
        if found is None or any((found.kind, found.joints) == (f.kind, f.joints) for f in out):
            break
        out.append(found)
        assert found.undo is not None
        if found.kind == "delay":  # everything else is searched again without the delay
            break
        logs, held = ([found.undo(log) for log in group] for group in (logs, held))
    return tuple(out)


@dataclass(frozen=True, eq=False)
class Trial:
    """Logs on which faults are tried.

    Attributes:
        evaluator: the compiled model.
        logs, held: training and validation logs.
    """

    evaluator: Evaluator
    logs: Sequence[FilteredLog]
    held: Sequence[FilteredLog]

    @cached_property
    def rows(self) -> Rows:
        """Equations of the training logs."""
        return _equations_of(self.evaluator, self.logs)

    @cached_property
    def held_rows(self) -> Rows:
        """Equations of the validation logs."""
        return _equations_of(self.evaluator, self.held)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.rows[0])

    @cached_property
    def moving(self) -> list[int]:
        """The joints that move in the training logs."""
        return moving_joints([log.qd for log in self.logs], self.evaluator.model.robot.sigma)

    @cached_property
    def base(self) -> Blocks:
        """Summary of the training logs as they are recorded."""
        return block_summary(self.rows)

    @cached_property
    def other(self) -> Blocks | None:
        """Summary of the validation logs as they are recorded; None without."""
        return block_summary(self.held_rows) if self.held else None

    @cached_property
    def own(self) -> FloatArray:
        """Result of `block_errors` for the training logs."""
        return block_errors(self.base, self.base)

    @cached_property
    def short(self) -> Trial:
        """The logs, or the first part of each, for evaluations of the model at many nodes."""
        groups = [_first_part(group) for group in (self.logs, self.held)]
        same = groups[0] is self.logs and groups[1] is self.held
        return self if same else Trial(self.evaluator, *groups)

    def share(
        self, train: Blocks, held: Callable[[], Blocks], sure: Bools | None = None
    ) -> tuple[float, float]:
        """Return the error ratio when a fault is undone; 1 if other logs do not confirm it.

        Args:
            train: summary of the training logs with the fault undone.
            held: gives that of the validation logs, if any; called only if needed.
            sure: joints with a significant gain; None to decide by the blocks.
        """
        after = block_errors(train, train)
        if held_out_error(after) > 1.0:  # no model fits: nothing is known
            return 1.0, 1.0
        share, together = _what_is_left(self.own, after, sure)
        if self.other is None:
            return share, together
        # If few blocks of the training logs show the gain, the other logs may confirm it.
        unsure = share > _CLEARER and sure is None
        if unsure:
            share, together = _what_is_left(self.own, after, np.ones(self.n, dtype=bool))
        if share > _CLEARER:
            return 1.0, 1.0
        right = held()
        before, X = _shares(self.other, self.base.fit()), train.fit()
        # The fault may be in the training logs only.
        plain = [] if right.grams.shape != self.other.grams.shape else [_shares(self.other, X)]
        for now in (_shares(right, X), *plain):
            found = _what_is_left(before, now, None if unsure else np.ones(self.n, dtype=bool))
            if found[0] <= _CLEARER:
                return share, together
        return 1.0, 1.0

    def right(self, fault: Fault, group: Sequence[FilteredLog]) -> Blocks:
        """Return the summary of logs with a fault undone."""
        assert fault.undo is not None
        return block_summary(_equations_of(self.evaluator, map(fault.undo, group)))

    def judged(self, faults: Iterable[Fault]) -> Iterator[Fault]:
        """Yield the faults whose correction leaves a small error."""
        for fault in faults:
            share, _ = self.share(
                self.right(fault, self.logs), partial(self.right, fault, self.held)
            )
            if share < _EXCHANGED:
                yield replace(fault, share=share)


def _largest(trial: Trial, finders: Iterable[Callable[[Trial], Iterator[Fault]]]) -> Fault | None:
    """Return the fault that explains most."""
    if held_out_error(trial.own) == 0.0:
        return None
    found = [fault for find in finders for fault in find(trial)]
    for fault in sorted(found, key=lambda f: f.share):
        if fault.kind != "sign" or _inertia_is_positive(trial, fault):
            return fault
    return None


def _inertia_is_positive(trial: Trial, fault: Fault) -> bool:
    """Whether the fit with the fault undone has positive mean inertias about its joints.

    If only the sign of X shows which joints are reversed, this selects the physically possible
    case.
    """
    X = trial.right(fault, trial.logs).fit()
    assert fault.undo is not None
    logs = [fault.undo(log) for log in trial.logs]
    return all(
        float(mean_inertia(trial.evaluator, logs, j)[: len(X)] @ X) >= 0 for j in fault.joints
    )


# Finders.


def _late(trial: Trial) -> Iterator[Fault]:
    """Find torques of all joints that are late: tau(t) = model(t - delay).

    A small delay is found to first order; a large one is searched for if the error is large. The
    column -d tau/dt is exact for a first-order filter. If it leaves less error than the shift, the
    cause is a filter, and there is no delay to undo.
    """
    blocks = _with_delay(trial.logs, trial.rows)
    if held_out_error(trial.own) > _LOUD:
        logs = tuple(trial.logs)
        fault = common_delay(Scene(scene.Rows(trial.evaluator, logs, len(logs), MISFIT)))
        known = True
    else:
        fault = late_fault(delay := float(blocks.fit()[-1]), trial.n)
        apart = np.array([blocks.fit([k])[-1] for k in range(BLOCKS)])
        known = abs(delay) > _STD * _jackknife(apart)
    if fault is None:
        return
    train, held = (partial(trial.right, fault, group) for group in (trial.logs, trial.held))
    shifted = train()
    left = [held_out_error(block_errors(found, found)) for found in (blocks, shifted)]
    if left[0] < _CLEARER * left[1]:
        return
    best, share = trial.share(shifted, held, np.ones(trial.n, dtype=bool) if known else None)
    if max(best, share) <= _CLEARER:  # all joints share a delay, or none has one
        yield replace(fault, share=share)


def _fault(
    kind: str,
    channel: str,
    says: str,
    joints: Iterable[int],
    value: float,
    undo: Callable[[FilteredLog], FilteredLog] | None = None,
    share: float = 1.0,
) -> Fault:
    return Fault(
        EVERYWHERE, channel, says,
        kind=kind, joints=tuple(joints), value=value, undo=undo, share=share,
    )  # fmt: skip


def _with_delay(logs: Sequence[FilteredLog], equations: Rows) -> Blocks:
    """Return the summary of tau = W X - delay dtau/dt."""
    extended = [
        _with_column(log, rows, -log.compared(np.gradient(log.tau, log.step, axis=0)))
        for log, rows in zip(logs, equations, strict=True)
    ]
    return block_summary(extended)


def _exchanged(trial: Trial) -> Iterator[Fault]:
    """Find two joints with exchanged torques."""
    if held_out_error(trial.own) <= _LOUD:
        return
    if any(len(e.y) != len(log[0].y) for log in (*trial.rows, *trial.held_rows) for e in log):
        return  # the masks of the joints differ
    for j, k in combinations(range(trial.n), 2):
        share, _ = trial.share(_turned(trial.rows, j, k), partial(_turned, trial.held_rows, j, k))
        if share < _EXCHANGED:
            yield replace(_exchange(trial.evaluator.model.robot, j, k, ("tau",)), share=share)


def _exchange(robot: Robot, j: int, k: int, keys: Sequence[str]) -> Fault:
    """Return the fault that channels of two joints are exchanged."""
    channel = ", ".join(f"{key}{i + 1}" for i in (j, k) for key in keys)
    what = channel.replace(", ", " and ") if keys == ("tau",) else None
    where = f"{what} are" if what else f"{channel}: {robot.listed([j, k])} are"
    undo = partial(exchanged, j=j, k=k, keys=keys)
    return _fault("exchange", channel, f"{where} exchanged", (j, k), 0.0, undo)


def _turned(equations: Rows, j: int, k: int) -> Blocks:
    """Return the summary with the torques of two joints exchanged."""
    turned = [
        tuple(
            e.with_sides(log[k if i == j else j]) if i in (j, k) else e for i, e in enumerate(log)
        )
        for log in equations
    ]
    return block_summary(turned)


def _modelled(trial: Trial, log: FilteredLog, X: FloatArray) -> FloatArray:
    """Return the torque of a model along a log, in the comparison band, (K, n)."""
    regressor = trial.evaluator["torque_regressor"]

    def torque(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        return np.asarray(regressor(q, qd, qdd))[:, :, : len(X)] @ X

    return np.concatenate([x for _, x in log.modelled(torque)])


def _moved(trial: Trial) -> Iterator[Fault]:
    """Find positions and speeds that are exchanged, reversed or in degrees."""
    masked = any(log.mask is not None for log in (*trial.logs, *trial.held))
    if held_out_error(trial.own) > _LOUDER and not masked:
        yield from trial.short.judged(_hypotheses(trial.evaluator))


def _hypotheses(evaluator: Evaluator) -> Iterator[Fault]:
    """Yield the faults of the motion that are tried."""
    joints = evaluator.model.robot.movable
    for keys in (_MOTION, (*_MOTION, "tau")):
        for j, k in combinations(range(len(joints)), 2):
            yield _exchange(evaluator.model.robot, j, k, keys)
        for j in range(len(joints)):
            names = ", ".join(f"{key}{j + 1}" for key in keys)
            undo = partial(multiplied, joints=(j,), factor=-1.0, keys=keys)
            yield _fault("sign", names, f"{names} have the wrong sign", (j,), -1.0, undo)
    turning = [j for j, joint in enumerate(joints) if joint.turns]
    factor = np.pi / 180
    for group in ([turning] if len(turning) > 1 else []) + [[j] for j in turning]:
        names = "q, qd" if len(group) > 1 else f"q{group[0] + 1}, qd{group[0] + 1}"
        undo = partial(multiplied, joints=tuple(group), factor=factor, keys=_MOTION)
        says = f"{names} are in degrees: multiply them by pi/180"
        yield _fault("units", names, says, group, 1 / factor, undo)


#: Finders of delays, exchanged channels and so on, which use the equations.
FINDERS: Mapping[str, Callable[[Trial], Iterator[Fault]]] = {
    "delay": _late,
    "exchange": _exchanged,
    "units": _moved,
}


# Equations.


def _equations_of(evaluator: Evaluator, logs: Iterable[FilteredLog]) -> Rows:
    """Return the torque equations of logs without rests, which cannot show channel faults."""
    return [
        tuple(e.with_rest_weight(_AT_REST) for e in torque_equations(evaluator, log))
        for log in logs
    ]


def _with_column(
    log: FilteredLog, rows: tuple[Equations, ...], column: FloatArray
) -> tuple[Equations, ...]:
    """Return the equations of one log with one more unknown, common to its joints.

    Args:
        log: the log.
        rows: its equations, joint by joint.
        column: (K, n) column of the unknown, at the kept samples.
    """
    out = []
    for j, e in enumerate(rows):
        own = column[:, j] if log.mask is None else column[log.free[:, j], j]
        out.append(replace(e, W=np.column_stack([e.W, own * e.scale]), Z=None))
    return tuple(out)


def _shares(blocks: Blocks, X: FloatArray) -> FloatArray:
    """Return ||y - W X||^2 of every block over the total ||y||^2, by joint, (B, m)."""
    measured = blocks.grams[:, :, -1, -1].sum(axis=0)
    errors = np.stack([blocks.errors([b], X) for b in range(len(blocks.grams))])
    return errors / np.where(measured > 0, measured, np.inf)


def _what_is_left(
    own: FloatArray, other: FloatArray, sure: Bools | None = None
) -> tuple[float, float]:
    """Return the error ratio of the joint with the largest gain, and of all; 1 if not significant.

    All joints together, each relative to its own error, must gain, and so must the torques
    themselves.
    """
    whole, rest = own.sum(axis=0), other.sum(axis=0)
    scale = 1 / np.where(whole > 0, whole, np.inf)
    together = float(np.sqrt((rest * scale).sum() / max((whole * scale).sum(), 1e-300)))
    if together >= 1.0 or rest.sum() >= whole.sum():
        return 1.0, 1.0
    gained = own - other
    deviation = gained.std(axis=0, ddof=1) * np.sqrt(len(gained))
    sure = gained.sum(axis=0) > _STD * deviation if sure is None else sure
    return float(np.sqrt(rest * scale)[sure & (whole > 0)].min(initial=1.0)), together


def _first_part(logs: Sequence[FilteredLog]) -> Sequence[FilteredLog]:
    """Return the logs, shortened for evaluations of the model at many nodes."""
    total = sum(log.rows.nodes for log in logs)
    if total <= _NODES:
        return logs
    cut = [log.samples.cut(slice(0, len(log.t) * _NODES // total)) for log in logs]
    return [filter_log(s, log.band) for s, log in zip(cut, logs, strict=True)]


# Further faults that a diagnosis checks.


def against_physics(trial: Trial) -> list[Fault]:
    """Find torques with the wrong sign and reversed time.

    The equations of each joint alone show them: inertia is positive, and friction dissipates.
    """
    found = {j: (_negative_inertia(trial, j), _driving_friction(trial, j)) for j in trial.moving}
    if found and all(loss and not mass for mass, loss in found.values()):
        says = "t: friction would add energy at every joint: time runs backwards in these logs"
        return [_fault("time", "t", says, (), -1.0, backwards)]
    return [
        _fault(
            "sign",
            f"tau{j + 1}",
            f"tau{j + 1}, or q{j + 1} and qd{j + 1}: with this sign the friction of "
            f"{trial.evaluator.model.robot.listed([j])} would add energy and its "
            "inertia would be negative: change the sign",
            (j,),
            -1.0,
            partial(multiplied, joints=(j,), factor=-1.0, keys=("tau",)),
        )
        for j, both in found.items()
        if all(both)
    ]


def _negative_inertia(trial: Trial, j: int) -> bool:
    """Whether the equations of a joint alone give it a negative mean inertia."""
    mean = mean_inertia(trial.evaluator, trial.logs, j)
    return _surely_negative(trial.base.grams[:, j], mean[: trial.base.grams.shape[-1] - 1])


def _driving_friction(trial: Trial, j: int) -> bool:
    """Whether the equations of a joint alone give it friction that does not dissipate.

    If no friction is declared, viscous friction is fitted.
    """
    first = trial.evaluator.model.inertial
    own, work = [], []
    bare = not any(np.any(rows[j].W[:, first:]) for rows in trial.rows)
    for log, rows in zip(trial.logs, trial.rows, strict=True):
        speed = log.qd[log.kept, j][log.free[:, j]]
        e = rows[j]
        if bare:
            e = replace(e, W=np.column_stack([e.W, speed * e.scale]), Z=None)
        own.append((e,))
        work.append(e.W * speed[:, None])
    mean = np.concatenate(work).mean(axis=0)
    mean[:first] = 0.0
    return _surely_negative(block_summary(own).grams[:, 0], mean)


def _surely_negative(grams: FloatArray, mean: FloatArray) -> bool:
    """Whether mean @ X is negative by five standard deviations of the jackknife over blocks."""
    whole = grams.sum(axis=0)
    apart = np.array([mean @ solve_gram(whole - gram) for gram in grams if gram.any()])
    return bool(mean.any()) and float(mean @ solve_gram(whole)) < -_SIGMAS * _jackknife(apart)


def _jackknife(apart: FloatArray) -> float:
    """Return the jackknife standard deviation from the estimates without each block."""
    return float(np.sqrt((len(apart) - 1) * np.mean((apart - apart.mean()) ** 2)))


def torque_steps(trial: Trial) -> Iterator[Fault]:
    """Find steps of a torque that stay in the residual until the next one, and remove them.

    A drive may step and move the robot, and friction steps when a motion starts, ends or reverses.
    These are part of the model. The step of a sensor stays in the residual.
    """
    X = trial.base.fit()
    for log in trial.logs:
        left = log.measured - _modelled(trial, log, X)
        rests, _ = at_rest(log.qd, log.step, trial.evaluator.model.robot.sigma)
        for j in trial.moving:
            found = _kept_steps(log, j, left[:, j], rests[:, j])
            if found:
                undo = partial(levelled, name=log.name, j=j, steps=found)
                i, size = next(iter(found.items()))
                says = f"tau{j + 1} of {log.name} jumps by {size:.3g} at t = {log.t[i]:.4g} s"
                yield fault_of(log.name, "step", "tau", j, says, len(found), undo=undo)


def _kept_steps(log: FilteredLog, j: int, left: FloatArray, rests: Bools) -> dict[int, float]:
    """Return the steps of a torque that its residual keeps: height by sample number."""
    x, qd, at = log.tau[:, j], log.qd[:, j], log.kept
    wide = max(5, int(2 / (log.band.comparison_hz * log.step)))
    away = rests if log.mask is None else rests | touched(log.mask.joint[:, j], wide // 4)

    def height(i: int, first: int, last: int) -> float:
        """Return the step of the residual after sample i; 0.0 if it differs from that of x."""
        before = left[(at >= first) & (at < i - wide // 4)]
        after = left[(at >= i + wide // 4) & (at < last)]
        if min(len(before), len(after)) < 2:
            return 0.0
        found = float(after.mean() - before.mean())
        return found if found / float(x[i + 1] - x[i]) > _HALF else 0.0

    heights = {
        i: height(i, i - wide, i + wide + wide // 4)
        for i in map(int, steps(x))
        if np.all(qd[i - 2 : i + 4] * qd[i] > 0)
        and not away[max(i - wide // 4, 0) : i + wide // 4].any()
    }
    kept = [i for i, size in heights.items() if size]
    spans = zip([0, *kept], kept, [*kept[1:], len(x)], strict=False)
    return {i: heights[i] for first, i, last in spans if height(i, first, last)}
