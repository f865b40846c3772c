"""Late and clipped torques, and contacts.

They compete with other causes on the rows of the recorded torque.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symgen.data.mask import moving_joints
from symgen.data.signals import noise_of_differences
from symgen.estimation.events import Event
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.summary import Blocks
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, Fault
from symgen.faults.scene import Scene
from symgen.faults.undo import earlier, left_out, unlimited

#: Largest delay in s, and number of values that are tried.
_LATEST, _TRIED = 0.5, 12
_FEWEST, _ROWS = 4, 3000  # shortest log, in largest delays; approximate number of rows
#: Quantile of the torque that a clipped torque reaches; distances, in noise std, in which the level
#: is searched and in which a torque counts as clipped; samples needed to estimate the noise.
_TOP, _WITHIN, _AT_LIMIT, _FEW = 0.999, 6.0, 3.0, 20
_ROUNDS, _EXACT = 6, 1e-5  # of the Gauss-Newton method; accuracy in s


def late_torques(scene: Scene) -> Iterator[Fault]:
    """Yield torques that are late: of all joints, and of the joint with the largest gain.

        tau_j(t) = W_j(t - d) X

    Delays d up to half a second are tried between the kept rows, with the ends of the logs cut
    equally for all. The Gauss-Newton method with the column -d tau_j/dt then refines them. A single
    joint is never early.

    Args:
        scene: the model.
    """
    n = scene.n
    if n > 1:
        tried = [_roughly(scene, [j]) for j in moving_joints(
            [log.qd for log in scene.rows.logs], scene.rows.evaluator.model.robot.sigma
        )]  # fmt: skip
        _, joints, delay = min(tried, default=(0.0, [], 0.0))
        delay = settled_delay(scene, joints, delay) if delay else 0.0
        if delay > 0:
            j = joints[0]
            says = (
                f"tau{j + 1} is about {1e3 * delay:.3g} ms late relative to the other joints, or "
                "passes a slow filter: log it without delay"
            )
            yield _late(f"tau{j + 1}", says, joints, delay)
    if fault := common_delay(scene):
        yield fault


def common_delay(scene: Scene) -> Fault | None:
    """Return the delay of the torques of all joints, with its sign; None if there is none."""
    joints = list(range(scene.n))
    delay = settled_delay(scene, joints, _roughly(scene, joints, early=True)[2])
    return late_fault(delay, scene.n) if delay else None


def late_fault(delay: float, n: int) -> Fault:
    """Return the fault for a delay of all n torques, s; negative if they are early."""
    word = "late" if delay > 0 else "early"
    says = f"the torques of all joints are {1e3 * abs(delay):.3g} ms {word} against the motion"
    return _late("tau", says, range(n), delay)


def _late(channel: str, says: str, joints: Sequence[int], delay: float) -> Fault:
    undo = partial(earlier, delay=delay, joints=tuple(joints))
    own = tuple(joints)
    return Fault(EVERYWHERE, channel, says, kind="delay", joints=own, value=delay, undo=undo)


def _rates(logs: Sequence[FilteredLog]) -> FloatArray:
    """Return -d tau/dt in the comparison band, (K, n)."""
    parts = [log.unmasked.compared(-np.gradient(log.tau, log.step, axis=0)) for log in logs]
    return np.concatenate(parts)


def _roughly(
    scene: Scene, joints: list[int], early: bool = False
) -> tuple[float, list[int], float]:
    """Return the log residual of the best delay of some joints, the joints, and the delay.

    The motion is shifted by whole rows. The column -d tau/dt covers half the distance to the next
    value. Rows nearer to the ends than the largest delay are left out.
    """
    rows, W = scene.rows, scene.score.W
    spans = kept_spans(rows.logs)
    step = float(np.median(np.diff(rows.logs[0].compared_t[:100])))
    most = min(round(_LATEST / step), *((s.stop - s.start) // _FEWEST for s in spans))
    shifts = sorted({round(x) for x in np.linspace(0, most, _TRIED + 1)})
    at = np.concatenate([np.arange(s.start + most, s.stop - most) for s in spans])
    at = at[:: max(1, len(at) // _ROWS)]
    rate, p = _rates(rows.logs)[at], W.shape[2]

    def products(shift: int, own: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return [W rate y]' [W rate y] of joints with shifted motion, and the number of rows."""
        moved = W[at - shift][:, own]
        weight = (rows.weight[at] * rows.weight[at - shift])[:, own]
        both = [moved, rate[:, own, None], rows.y[at][:, own, None]]
        whole = (np.concatenate(both, axis=2) * weight[:, :, None]).transpose(1, 0, 2)
        return whole.swapaxes(1, 2) @ whole, (weight**2).sum(axis=0)

    grams, count = products(0, range(scene.n))
    grams[:, p], grams[:, :, p] = 0.0, 0.0  # the other joints have no delay
    best, delay = np.inf, 0.0
    for shift in [*shifts, *(-s for s in shifts[1:] if early)]:
        grams[joints], count[joints] = products(shift, joints)
        X, sigma = scene.fitted(Blocks(grams[None], count[None]))
        more = float(X[p])
        if abs(more) > step * max(np.diff(shifts), default=1):
            continue
        variance = sigma**2 + (rows.misfit * rows.size) ** 2
        left = float(np.sum(count * np.log(variance)) / max(count.sum(), 1.0))
        if left < best:
            best, delay = left, shift * step + more
    return best, joints, delay


def settled_delay(scene: Scene, joints: Sequence[int], delay: float) -> float:
    """Return the delay of some joints, s, near a start value; 0.0 without convergence."""
    rows = scene.rows
    own = np.zeros(scene.n)
    own[list(joints)] = 1.0
    for _ in range(_ROUNDS):
        logs = tuple(earlier(log, delay, tuple(joints)) for log in rows.logs)
        undone = rows.with_torques(logs)
        column = (_rates(logs) * own)[:, :, None]
        wide = replace(scene, rows=undone)
        W = np.concatenate([scene.score.W, column], axis=2)
        more = float(wide.fitted(wide.blocks(W, undone.weight))[0][-1])
        delay += more
        if not abs(delay) < 2 * _LATEST:
            return 0.0
        if abs(more) < _EXACT:
            break
    return delay


def cut_torques(scene: Scene) -> Iterator[tuple[Fault, FloatArray, FloatArray]]:
    """Yield clipped torques of one joint, with the largest value of each log as the limit.

    If the drive itself cannot exceed a limit, the robot moves by the clipped torque. The model then
    needs no more torque, and there is no fault.

    Args:
        scene: the model.

    Yields:
        The fault; (K,) limit of the rows; and (K, n) their weight without those near the limit.
    """
    rows = scene.rows
    for j in scene.driven:
        limits, noise = (
            np.array(x) for x in zip(*(_top(log, j) for log in rows.logs), strict=True)
        )
        near = dict(zip((log.name for log in rows.logs), limits - _AT_LIMIT * noise, strict=True))
        undo = partial(unlimited, j=j, limits=near)
        weight = rows.with_torques(tuple(map(undo, rows.logs))).weight
        if not weight[:, j].any():
            continue  # the whole signal is near the limit
        counts = [np.count_nonzero(np.abs(log.tau[:, j]) > near[log.name]) for log in rows.logs]
        shares = [count / len(log.t) for count, log in zip(counts, rows.logs, strict=True)]
        most = int(np.argmax(shares))
        says = (
            f"tau{j + 1} is clipped at {limits[most]:.4g} in {100 * shares[most]:.2g} % of the "
            f"samples of {rows.logs[most].name}: record it with a larger range, or move more slowly"
        )
        std = float(noise[most]) / math.sqrt(max(int(counts[most]), 1))
        fault = Fault(
            EVERYWHERE, f"tau{j + 1}", says, int(sum(counts)),
            values=(("limit", float(limits[most]), std),), kind="saturated", joints=(j,),
            value=float(limits[most]), undo=undo,
        )  # fmt: skip
        yield fault, np.repeat(limits, [len(log.kept) for log in rows.logs]), weight


def _top(log: FilteredLog, j: int) -> tuple[float, float]:
    """Return the level of the largest torques of a joint, and the std of its noise."""
    x = log.tau[:, j] if log.mask is None else log.tau[~log.mask.joint[:, j], j]
    size = np.abs(x)
    if len(x) < _FEW:
        return math.inf, 0.0
    noise = float(noise_of_differences(x)) + 1e-6 * float(size.max())
    return float(np.median(size[size >= np.quantile(size, _TOP) - _WITHIN * noise])), noise


def contact_fault(event: Event, log: FilteredLog) -> Fault:
    """Return an event of a log as a fault; its undo leaves out the samples of its joints."""
    at = slice(event.first, event.last + 1)
    says = (
        f"a contact or collision in {log.name} between {event.start:.3g} and {event.end:.3g} s: "
        "leave this time out of the log"
    )
    values = (("start", event.start, math.nan), ("length", event.end - event.start, math.nan))
    return Fault(
        log.name, ", ".join(f"tau{j + 1}" for j in event.joints), says, at.stop - at.start,
        values=values, kind="contact", joints=event.joints,
        undo=partial(left_out, name=log.name, at=at, joints=event.joints),
    )  # fmt: skip
