"""Faults of channels that the model shows: what fits the logs better when it is undone.

The torque of a joint that fits with another factor or sign, torques that are late, and, where the
model leaves much, channels of two joints in each other's place, joints that are counted the other
way round, positions in degrees; a joint that was recorded through another gear ratio. A fault
counts where undoing it leaves, on some joint, at most nine tenths of the error on folds that the
fit did not see, and of the error on logs that it never saw. One is looked for at a time, the
largest first: a wrong torque of one joint is felt in the fit of others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.channels import (
    Fault,
    earlier,
    hypotheses,
    multiplied,
    swapped,
)
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.motion_faults import EXCHANGED, geared_joints, trial_of
from symgen.estimation.recorded import (
    CLEARER,
    STD,
    Logs,
    Recorded,
    Rows,
    equations_of,
    recorded,
    with_column,
)
from symgen.estimation.summary import (
    BLOCKS,
    Blocks,
    held_out_error,
    placed,
    residual_squares,
    solve_gram,
    summary,
)
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Factors of a torque that are looked at are at least so far from 1.
_GAIN = 0.03
#: Exchanges of torques are tried where the error is above this, faults of the motion above that.
_LOUD, _LOUDER = 0.1, 0.2
_ALIKE = 1.05  # errors that are left
_NONE = 1e-6  # of a factor: nothing
_STATES = 200
_MOST = 3  # faults that are undone, one after the other


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
    equations, other = (equations_of(evaluator, group) for group in (logs, held))
    case = recorded(equations, other)
    error = held_out_error(case.own)
    if error == 0.0:
        return None
    n = len(case.base.size)
    found = _late(case, (logs, equations), (held, other))
    found += [f for j in range(n) for f in _factor(case, j)]
    if error > _LOUD:
        found += _exchanged(case, equations, other)
    trial = trial_of(evaluator, (logs, equations), (held, other), case)
    found += geared_joints(trial)
    if error > _LOUDER and not any(log.mask is not None for log in (*logs, *held)):
        found += trial.judged(hypotheses(evaluator))
    for fault in sorted(found, key=lambda f: f.left):
        if fault.kind != "sign" or _inertia_is_positive(evaluator, logs, fault):
            return _with_others(fault, found)
    return None


def _with_others(fault: Fault, found: Sequence[Fault]) -> Fault:
    """Name gains of other joints that explain as much: of two joints, either can be meant."""
    same = (f for f in found if f is not fault and f.kind == fault.kind == "gain")
    others = [f"{f.channel} {f.value:.3g} times" for f in same if f.left <= _ALIKE * fault.left]
    return replace(fault, says=f"{fault.says}, or {' or '.join(others)}") if others else fault


def _inertia_is_positive(evaluator: Evaluator, logs: Sequence[FilteredLog], fault: Fault) -> bool:
    """Whether the fit to logs without the fault has positive mean inertias about its joints.

    Where nothing but the sign of X tells which joints are turned, this is what a robot can be.
    """
    right = [fault.undone(log) for log in logs]
    n = right[0].q.shape[1]
    X = summary(placed(equations_of(evaluator, right)), n).fit()
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


def _late(case: Recorded, train: Logs, held: Logs) -> list[Fault]:
    """Find torques that are late against the motion: tau(t) = model(t - delay)."""
    blocks = _with_delay(*train)
    delay = float(blocks.fit()[-1])
    apart = np.array([blocks.fit([k])[-1] for k in range(BLOCKS)])
    std = np.sqrt((BLOCKS - 1) * np.mean((apart - apart.mean()) ** 2))  # the jackknife's
    sure = None if abs(delay) <= STD * std else np.ones(len(case.base.size), dtype=bool)
    best, left = case.left(blocks, lambda: _with_delay(*held), sure)
    if max(best, left) > CLEARER:  # it is common to all joints, or none
        return []
    word = "late" if delay > 0 else "early"
    says = f"the torques of all joints are {1e3 * abs(delay):.2g} ms {word} against the motion"
    joints, undone = tuple(range(len(case.base.size))), partial(earlier, delay=delay)
    return [Fault("tau", says, left, "delay", joints, delay, undone)]


def _with_delay(logs: Sequence[FilteredLog], equations: Rows) -> Blocks:
    """Summarise tau = W X - delay dtau/dt."""
    extended = [
        with_column(log, rows, -log.compared(np.gradient(log.tau, log.step, axis=0)))
        for log, rows in zip(logs, equations, strict=True)
    ]
    return summary(placed(extended), len(equations[0]))


def _factor(case: Recorded, j: int) -> list[Fault]:
    """Find a torque that fits better with another factor, beside those of the other joints."""
    base, other = case.base, case.other
    if len(base.size) == 1:
        return []

    best = min(_fitted_factors(base, j), key=lambda g: _error(_scaled(base, j, g)))
    if not _NONE < abs(best) < 1 / _NONE:
        return []
    share, _ = case.left(_scaled(base, j, best), lambda: _scaled(other or base, j, best))
    if share > CLEARER or abs(best - 1) < _GAIN:
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


def _error(blocks: Blocks) -> float:
    """Return the share of the torques that a fit leaves, all joints together."""
    left = residual_squares(blocks.grams.sum(axis=0), blocks.fit())
    return float(np.sum(left / np.maximum(blocks.size**2 * blocks.rows.sum(axis=0), 1e-300)))


def _fitted_factors(base: Blocks, j: int) -> Iterator[float]:
    """Yield g with tau_j / g = W_j X, where the other joints say what X is.

    Weighted least squares of X and 1/g together: y_j stands on the side of the unknowns. Joints
    weigh by what a fit leaves of them, or, as a wrong torque can spoil that of another joint, by
    the size of their torques.
    """
    grams, rows = base.grams.sum(axis=0), np.maximum(base.rows.sum(axis=0), 1.0)
    left = residual_squares(grams, base.fit()) / rows
    p = grams.shape[-1] - 1
    for variance in (np.maximum(left, 1e-12 * base.size**2), base.size**2):
        weight = 1 / variance
        weight[j] = 1 / base.size[j] ** 2
        whole = np.zeros((p + 2, p + 2))  # X, 1/g, and what the other joints measured
        for i, (gram, w) in enumerate(zip(grams, weight, strict=True)):
            own = np.arange(p + 2) != (p + 1 if i == j else p)
            signs = np.ones(p + 1)
            signs[-1] = -1.0 if i == j else 1.0
            whole[np.ix_(own, own)] += w * gram * np.outer(signs, signs)
        inverse = float(solve_gram(whole)[-1])
        yield 1 / inverse if abs(inverse) > _NONE else 1 / _NONE


def _scaled(base: Blocks, j: int, g: float) -> Blocks:
    grams = base.grams.copy()
    grams[:, j, -1, :] /= g
    grams[:, j, :, -1] /= g
    return Blocks(grams, base.rows)


def _exchanged(
    case: Recorded,
    equations: Rows,
    held: Rows,
) -> list[Fault]:
    """Find two joints whose torques stand in each other's channel."""
    n = len(equations[0])
    if any(len(e.y) != len(log[0].y) for log in (*equations, *held) for e in log):
        return []  # masks differ from joint to joint
    out = []
    for j, k in combinations(range(n), 2):
        left, _ = case.left(_turned(equations, j, k), partial(_turned, held, j, k))
        if left < EXCHANGED:
            says = f"tau{j + 1} and tau{k + 1} stand in each other's place"
            channel, undone = f"tau{j + 1}, tau{k + 1}", partial(swapped, j=j, k=k, keys=("tau",))
            out.append(Fault(channel, says, left, "exchange", (j, k), 0.0, undone))
    return out


def _turned(equations: Rows, j: int, k: int) -> Blocks:
    """Summarise the equations with the torques of two joints exchanged."""
    turned = [
        tuple(
            e.with_sides(log[k if i == j else j]) if i in (j, k) else e for i, e in enumerate(log)
        )
        for log in equations
    ]
    return summary(placed(turned), len(equations[0]))
