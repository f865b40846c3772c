"""What a recorder does to torques beside factors and signs: it is late, or cuts them off.

Both compete with other causes on the rows of the torque as it was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symgen.data.mask import moving_joints
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.summary import Blocks
from symgen.estimation.values import FloatArray
from symgen.faults.fault import EVERYWHERE, Fault
from symgen.faults.scene import Scene
from symgen.faults.undo import earlier

#: Largest delay in s that is looked for, and values that are tried up to it.
_LATEST, _TRIED = 0.5, 12
_FEWEST = 4  # times the largest delay: a log is at least so long
_ROUNDS, _EXACT = 6, 1e-5  # of Gauss and Newton's method, and s to which it settles


def late_torques(scene: Scene) -> Iterator[Fault]:
    """Yield torques that come late: those of all joints, and those of the joint that gains most.

        tau_j(t) = W_j(t - d) X

    Delays d up to half a second are tried between the kept rows, ends of the logs trimmed alike for
    all; steps of Gauss and Newton's method with the column -d tau_j/dt find it exactly. A joint
    alone is never early.

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
                f"tau{j + 1} is about {1e3 * delay:.2g} ms late against the other joints, or "
                "passes a slow filter"
            )
            yield _late(f"tau{j + 1}", says, joints, delay)
    if fault := common_delay(scene):
        yield fault


def common_delay(scene: Scene) -> Fault | None:
    """Return by how much the torques of all joints are late, or early; None where they are not."""
    joints = list(range(scene.n))
    delay = settled_delay(scene, joints, _roughly(scene, joints, early=True)[2])
    if not delay:
        return None
    word = "late" if delay > 0 else "early"
    says = f"the torques of all joints are {1e3 * abs(delay):.2g} ms {word} against the motion"
    return _late("tau", says, joints, delay)


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
    """Return what the best delay of some joints leaves, as a logarithm, the joints and the delay.

    Motion is moved by whole rows, and the column -d tau/dt reaches half way to the next value that
    is tried. Rows nearer to the ends than the largest delay have no say.
    """
    rows, W = scene.rows, scene.score.W
    spans = kept_spans(rows.logs)
    step = float(np.median(np.diff(rows.logs[0].compared_t[:100])))
    most = min(round(_LATEST / step), *((s.stop - s.start) // _FEWEST for s in spans))
    shifts = sorted({round(x) for x in np.linspace(0, most, _TRIED + 1)})
    at = np.concatenate([np.arange(s.start + most, s.stop - most) for s in spans])
    rate, p = _rates(rows.logs)[at], W.shape[2]

    def products(shift: int, own: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return [W rate y]' [W rate y] of some joints whose motion comes late, and their rows."""
        moved = W[at - shift][:, own]
        weight = (rows.weight[at] * rows.weight[at - shift])[:, own]
        both = [moved, rate[:, own, None], rows.y[at][:, own, None]]
        whole = (np.concatenate(both, axis=2) * weight[:, :, None]).transpose(1, 0, 2)
        return whole.swapaxes(1, 2) @ whole, (weight**2).sum(axis=0)

    grams, count = products(0, range(scene.n))
    grams[:, p], grams[:, :, p] = 0.0, 0.0  # the others come in time
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
    """Return the delay of some joints, s, near one: Gauss and Newton's; 0.0 where it is none."""
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
