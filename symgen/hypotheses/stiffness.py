"""The stiffness of a joint with a second encoder on its link, from the balance of its motor.

    tau = K (q - qs) + D (q' - qs') + IA q'' + FS sign(q') + FV q' + OF

Here q is the motor's position and qs the link's, both on the joint side. Every column is measured
and none contains the model of the links. A zero error of an encoder enters OF. Without qs,
elasticity shows only in the torque, near the resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from symgen.data.signals import differentiate, lowpass
from symgen.estimation.estimators import Ols
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import passband
from symgen.estimation.system import Rows
from symgen.estimation.values import FloatArray
from symgen.hypotheses.rows import FittedRows
from symgen.policy import DEFLECTS

NAME = "joint_elasticity"
_NAMES = ("K", "D", "IA", "FS", "FV", "OF")


@dataclass(frozen=True)
class Stiffness:
    """The result of the second encoder of a joint.

    Attributes:
        joint: index among the movable joints.
        stiffness, damping: K and D with their standard deviations, N m/rad and N m s/rad.
        p_value: p-value of K = 0.
        why: the reason why K is not known, or "".
    """

    joint: int
    stiffness: tuple[float, float] = (0.0, 0.0)
    damping: tuple[float, float] = (0.0, 0.0)
    p_value: float = 1.0
    why: str = ""


def deflection(s: FilteredLog, j: int) -> FloatArray:
    """Return q - qs of a joint below the cutoff of the run, (N,), rad or m; requires qs."""
    qs = s.samples.qs
    assert qs is not None
    q = s.samples.q[:, j]
    x = q - qs[:, j]
    edge = passband(s)
    return x if edge is None else lowpass(x, s.step, edge)


def stiffnesses(evidence: FittedRows) -> list[Stiffness]:
    """Return the stiffness of each joint that has a second encoder in all logs; none on a floating
    base.
    """
    if evidence.logs[0].base_rows:
        return []
    encoders = [log.samples.qs for log in evidence.logs]
    joints = []
    for j in range(evidence.logs[0].q.shape[1]):
        if all(qs is not None and np.isfinite(qs[:, j]).all() for qs in encoders):
            joints.append(j)
    return [_stiffness(evidence, j) for j in joints]


def _stiffness(evidence: FittedRows, j: int) -> Stiffness:
    """Fit the torque balance of a motor by least squares."""
    W = np.concatenate([_columns(s, j) for s in evidence.logs])
    y, t = evidence.y[:, [j]], evidence.t
    weight = evidence.weight[:, [j]]
    rows = Rows(_NAMES, W[:, None], y, t, weight, evidence.extents)
    solution = Ols().solve(rows)
    moving = rows.part(slice(None), 0)
    basis, _ = np.linalg.qr(moving.W[:, 1:])
    both = np.column_stack([moving.W[:, 0], moving.y])
    both -= basis @ (basis.T @ both)
    column, torque = both.T / np.linalg.norm(both, axis=0)[:, None]
    shared = float(column @ torque)
    if shared < math.sqrt(DEFLECTS):
        why = "its torque does not follow q - qs: check their units and the gear ratio"
        return Stiffness(j, why=why)
    stiffness, damping, *_ = zip(solution.X.tolist(), solution.std.tolist(), strict=True)
    value, std = stiffness
    p_value = math.erfc(value / std / math.sqrt(2))
    return Stiffness(j, stiffness, damping, p_value)


def _columns(s: FilteredLog, j: int) -> FloatArray:
    """Return the columns of the motor's torque balance, in the band at the kept samples, (K, 6)."""
    bent, speed = deflection(s, j), s.qd[:, j]
    rate = differentiate(bent, s.step)
    friction = [np.sign(speed), speed, np.ones_like(speed)]
    columns = [bent, rate, s.qdd[:, j], *friction]
    return s.unmasked.compared(np.column_stack(columns))
