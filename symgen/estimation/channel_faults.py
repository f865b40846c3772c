"""Faults of channels that the model shows: what fits the logs better when it is undone.

The torque of a joint that fits with another factor or sign, torques that are late, and, where the
model leaves much, channels of two joints in each other's place, joints that are counted the other
way round, positions in degrees. A fault counts where undoing it leaves, on some joint, at most nine
tenths of the error on folds that the fit did not see, and of the error on logs that it never saw.
One is looked for at a time, the largest first: a wrong torque of one joint is felt in the fit of
others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools
from symgen.estimation.blocks import (
    BLOCKS,
    Blocks,
    block_errors,
    held_out_error,
    placed,
    residual_squares,
    solve_gram,
    summary,
)
from symgen.estimation.channels import Fault, earlier, hypotheses, multiplied, swapped
from symgen.estimation.filtered import FilteredLog, filtered
from symgen.estimation.system import Equations, torque_equations
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: A fault is named where undoing it leaves so much of the error on folds left out, at most.
_CLEARER = 0.9
#: Factors of a torque that are looked at are at least so far from 1.
_GAIN = 0.03
#: Exchanges of torques are tried where the error is above this, faults of the motion above that;
#: such a fault leaves so much of the error, at most.
_LOUD, _LOUDER, _EXCHANGED = 0.1, 0.2, 0.7
_STD = 3.0
_STATES = 200
_MOST = 3  # faults that are undone, one after the other
_SAMPLES = 30_000  # of all logs together, in which faults of the motion are looked for


def channel_faults(
    evaluator: Evaluator, logs: Sequence[FilteredLog], held: Sequence[FilteredLog] = ()
) -> tuple[Fault, ...]:
    """Find what is wrong with the channels, by the torque equations.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs in the band of the run.
        held: the validation logs, which confirm what is found.
    """
    out: list[Fault] = []
    for _ in range(_MOST):
        found = _largest(evaluator, logs, held)
        if found is None or any((found.kind, found.joints) == (f.kind, f.joints) for f in out):
            break
        out.append(found)
        if found.kind == "delay":  # all else is looked at again without it
            break
        logs, held = ([found.undone(log) for log in group] for group in (logs, held))
    return tuple(out)


def _largest(
    evaluator: Evaluator, logs: Sequence[FilteredLog], held: Sequence[FilteredLog]
) -> Fault | None:
    """Return the fault that explains most."""
    equations, other = (_equations(evaluator, group) for group in (logs, held))
    case = _case(equations, other)
    error = held_out_error(case.own)
    if error == 0.0:
        return None
    n = len(case.base.size)
    found = _late(case, (logs, equations), (held, other))
    found += [f for j in range(n) for f in _factor(case, j)]
    if error > _LOUD:
        found += _exchanged(case, equations, other)
    if error > _LOUDER:
        found += _turned_motion(evaluator, logs, held)
    for fault in sorted(found, key=lambda f: f.left):
        if fault.kind != "sign" or _inertia_is_positive(evaluator, logs, fault):
            return fault
    return None


def _inertia_is_positive(evaluator: Evaluator, logs: Sequence[FilteredLog], fault: Fault) -> bool:
    """Whether the fit to logs without the fault has positive mean inertias about its joints.

    Where nothing but the sign of X tells which joints are turned, this is what a robot can be.
    """
    right = [fault.undone(log) for log in logs]
    n = right[0].q.shape[1]
    X = summary(placed(_equations(evaluator, right)), n).fit()
    q = np.concatenate([log.q[log.kept] for log in right])
    q = np.ascontiguousarray(q[:: max(1, len(q) // _STATES)])
    regressor, zero = evaluator["torque_regressor"], np.zeros_like(q)
    still = np.asarray(regressor(q, zero, zero))[:, :, : len(X)] @ X
    for j in fault.joints:
        one = zero.copy()
        one[:, j] = 1.0
        moved = np.asarray(regressor(q, zero, one))[:, :, : len(X)] @ X
        if float(np.mean((moved - still)[:, j])) < 0:
            return False
    return True


@dataclass(frozen=True, eq=False)
class _Case:
    """Torques as they are recorded.

    Attributes:
        base: summary of the training logs.
        other: of the validation logs, or None.
        own: what `block_errors` are for the training logs.
    """

    base: Blocks
    other: Blocks | None
    own: FloatArray

    def left(
        self, train: Blocks, held: Callable[[], Blocks], sure: Bools | None = None
    ) -> tuple[float, float]:
        """Return what undoing a fault leaves, see `_left`; 1 where other logs do not confirm it.

        Args:
            train: summary of the training logs with the fault undone.
            held: gives that of the validation logs, where there are any; not asked in vain.
            sure: joints whose gain is known to be no chance; None to see that from the blocks.
        """
        share, together = _left(self.own, block_errors(train, train), sure)
        if share > _CLEARER or self.other is None:
            return share, together
        right = held()
        before, X = _shares(self.other, self.base.fit()), train.fit()
        # The fault may be one of the training logs alone.
        plain = [] if right.grams.shape != self.other.grams.shape else [_shares(self.other, X)]
        for after in (_shares(right, X), *plain):
            ratio = after / np.where(before > 0, before, np.inf)
            if ratio.mean() < 1 and np.sqrt(ratio.min()) <= _CLEARER:
                return share, together
        return 1.0, 1.0


_Rows = Sequence[tuple[Equations, ...]]
_Logs = tuple[Sequence[FilteredLog], _Rows]


def _equations(evaluator: Evaluator, logs: Iterable[FilteredLog]) -> _Rows:
    return [torque_equations(evaluator, log) for log in logs]


def _case(equations: _Rows, held: _Rows) -> _Case:
    n = len(equations[0])
    base = summary(placed(equations), n)
    other = summary(placed(held), n) if held else None
    return _Case(base, other, block_errors(base, base))


def _shares(blocks: Blocks, X: FloatArray) -> FloatArray:
    """Return ||y - W X||^2 / ||y||^2 by joint, (m,)."""
    grams = blocks.grams.sum(axis=0)
    measured = grams[:, -1, -1]
    return residual_squares(grams, X) / np.where(measured > 0, measured, np.inf)


def _left(own: FloatArray, other: FloatArray, sure: Bools | None = None) -> tuple[float, float]:
    """Return what is left of the error of the joint that gains most, and of all; 1 for chance.

    All joints together, each in units of its own error, must gain; as must the torques themselves.
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


def _late(case: _Case, train: _Logs, held: _Logs) -> list[Fault]:
    """Find torques that are late against the motion: tau(t) = model(t - delay)."""
    blocks = _with_delay(*train)
    delay = float(blocks.fit()[-1])
    apart = np.array([blocks.fit([k])[-1] for k in range(BLOCKS)])
    std = np.sqrt((BLOCKS - 1) * np.mean((apart - apart.mean()) ** 2))  # the jackknife's
    sure = None if abs(delay) <= _STD * std else np.ones(len(case.base.size), dtype=bool)
    best, left = case.left(blocks, lambda: _with_delay(*held), sure)
    if max(best, left) > _CLEARER:  # it is common to all joints, or none
        return []
    word = "late" if delay > 0 else "early"
    says = f"the torques of all joints are {1e3 * abs(delay):.2g} ms {word} against the motion"
    joints, undone = tuple(range(len(case.base.size))), partial(earlier, delay=delay)
    return [Fault("tau", says, left, "delay", joints, delay, undone)]


def _with_delay(logs: Sequence[FilteredLog], equations: _Rows) -> Blocks:
    """Summarise tau = W X - delay dtau/dt."""
    extended = []
    for log, rows in zip(logs, equations, strict=True):
        slope = log.compared(np.gradient(log.tau, log.step, axis=0))
        longer = []
        for j, e in enumerate(rows):
            d = slope[:, j] if log.mask is None else slope[log.free[:, j], j]
            longer.append(replace(e, W=np.column_stack([e.W, -d]), Z=None))
        extended.append(tuple(longer))
    return summary(placed(extended), len(equations[0]))


def _factor(case: _Case, j: int) -> list[Fault]:
    """Find a torque that fits better with another factor, beside those of the other joints."""
    base, other = case.base, case.other
    if len(base.size) == 1:
        return []

    best = _fitted_factor(base, j)
    if not 1e-6 < abs(best) < 1e6:
        return []
    share, _ = case.left(_scaled(base, j, best), lambda: _scaled(other or base, j, best))
    if share > _CLEARER or abs(best - 1) < _GAIN:
        return []
    if best < 0:
        says = f"tau{j + 1} has the other sign"
        undone = partial(multiplied, joints=(j,), factor=-1.0, keys=("tau",))
        return [Fault(f"tau{j + 1}", says, share, "sign", (j,), best, undone)]
    says = (
        f"tau{j + 1} is {best:.3g} times what the other joints ask for (torque constant, gear "
        "ratio or unit)"
    )
    undone = partial(multiplied, joints=(j,), factor=1 / best, keys=("tau",))
    return [Fault(f"tau{j + 1}", says, share, "gain", (j,), best, undone)]


def _fitted_factor(base: Blocks, j: int) -> float:
    """Return g with tau_j / g = W_j X, where the other joints say what X is.

    Weighted least squares of X and 1/g together: y_j stands on the side of the unknowns.
    """
    grams, rows = base.grams.sum(axis=0), np.maximum(base.rows.sum(axis=0), 1.0)
    left = residual_squares(grams, base.fit()) / rows
    weight = 1 / np.maximum(left, 1e-12 * base.size**2)
    weight[j] = 1 / base.size[j] ** 2
    p = grams.shape[-1] - 1
    whole = np.zeros((p + 2, p + 2))  # X, 1/g, and what the other joints measured
    for i, (gram, w) in enumerate(zip(grams, weight, strict=True)):
        own = np.arange(p + 2) != (p + 1 if i == j else p)
        signs = np.ones(p + 1)
        signs[-1] = -1.0 if i == j else 1.0
        whole[np.ix_(own, own)] += w * gram * np.outer(signs, signs)
    inverse = float(solve_gram(whole)[-1])
    return 1 / inverse if inverse else np.inf


def _scaled(base: Blocks, j: int, g: float) -> Blocks:
    grams = base.grams.copy()
    grams[:, j, -1, :] /= g
    grams[:, j, :, -1] /= g
    return Blocks(grams, base.rows)


def _exchanged(
    case: _Case,
    equations: _Rows,
    held: _Rows,
) -> list[Fault]:
    """Find two joints whose torques stand in each other's channel."""
    n = len(equations[0])
    if any(len(e.y) != len(log[0].y) for log in (*equations, *held) for e in log):
        return []  # masks differ from joint to joint
    out = []
    for j, k in combinations(range(n), 2):
        left, _ = case.left(_turned(equations, j, k), partial(_turned, held, j, k))
        if left < _EXCHANGED:
            says = f"tau{j + 1} and tau{k + 1} stand in each other's place"
            channel, undone = f"tau{j + 1}, tau{k + 1}", partial(swapped, j=j, k=k, keys=("tau",))
            out.append(Fault(channel, says, left, "exchange", (j, k), 0.0, undone))
    return out


def _turned(equations: _Rows, j: int, k: int) -> Blocks:
    """Summarise the equations with the torques of two joints exchanged."""
    turned = [
        tuple(
            replace(e, y=log[k if i == j else j].y) if i in (j, k) else e for i, e in enumerate(log)
        )
        for log in equations
    ]
    return summary(placed(turned), len(equations[0]))


def _turned_motion(
    evaluator: Evaluator, logs: Sequence[FilteredLog], held: Sequence[FilteredLog]
) -> list[Fault]:
    """Find joints whose motion is exchanged, counted the other way round, or in degrees."""
    if any(log.mask is not None for log in (*logs, *held)):
        return []
    logs, held = _short(logs), _short(held)
    case = _case(_equations(evaluator, logs), _equations(evaluator, held))

    def right(fault: Fault, group: Sequence[FilteredLog]) -> Blocks:
        rows = _equations(evaluator, map(fault.undone, group))
        return summary(placed(rows), len(case.base.size))

    out = []
    for fault in hypotheses(evaluator):
        left, _ = case.left(right(fault, logs), partial(right, fault, held))
        if left < _EXCHANGED:
            out.append(replace(fault, left=left))
    return out


def _short(logs: Sequence[FilteredLog]) -> list[FilteredLog]:
    """Return the logs, or the first part of each where they are long."""
    total = sum(len(log.t) for log in logs)
    if total <= _SAMPLES:
        return list(logs)
    cut = [log.samples.cut(slice(0, len(log.t) * _SAMPLES // total)) for log in logs]
    return [filtered(s, log.band) for s, log in zip(cut, logs, strict=True)]
