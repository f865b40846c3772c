"""Gains of drives from a load of known mass: what a log makes of a torque, joint by joint.

    tau_j = k_j (Y_j X + c Y_j G s),    c = 1 in logs with the load, 0 in those without

with X the robot's parameters, s those of the load, whose mass is known, and tau the torques of the
log. All joints share X and s, which sets the k_j against each other, and the mass sets their scale
(Gautier and Briot, Global identification of joint drive gains and dynamic parameters of robots,
2014; there by total least squares). Here tau, which is noisy, stays on the left, and the product
k X is solved by Gauss and Newton: each step is weighted least squares of

    tau_j + k0_j m0_j - k0_j c Y_j G s_known = k0_j Y_j X + k0_j c Y_j G U a + m0_j k_j

with m0 the torque of the model before and s = s_known + U a. The gain of a drive, which its logged
torque is to be multiplied with, is 1/k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Drive, Robot

if TYPE_CHECKING:
    from symgen.identification.payload_result import Payload

_STEPS, _SETTLED = 30, 1e-3  # of the standard deviation


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a load of known mass tells.

    Attributes:
        a: (r,) the load, along the directions that were given.
        covariance: of a, (r, r).
        gain, std: (n,) torque over what the log makes of it.
        left: of the logs with the load, what no parameter explains, N m (N), one each.
    """

    a: FloatArray
    covariance: FloatArray
    gain: FloatArray
    std: FloatArray
    left: tuple[FloatArray, ...]


def calibrated(
    names: Sequence[str],
    loaded: Sequence[Equations],
    alone: Sequence[Equations],
    columns: FloatArray,
    known: FloatArray,
) -> Calibration:
    """Solve for gains, robot and load.

    Args:
        names: of X.
        loaded: torque equations of the logs with the load, (K, p) each.
        alone: those of the logs without it.
        columns: G U, (p, r): what the load's unknown directions are to X.
        known: G s_known, (p,): what is known of it.

    Raises:
        IdentificationError: the logs do not determine the gains, or the steps do not settle.
    """
    logs = [(e, 1.0) for e in loaded] + [(e, 0.0) for e in alone]
    p, r = columns.shape
    n = 1 + max(e.joint or 0 for e, _ in logs)
    labels = (*(f"load {k + 1}" for k in range(r)), *names, *(f"gain {j + 1}" for j in range(n)))
    Z = np.concatenate([np.zeros(r + p), np.ones(n)])
    m = [np.zeros(len(e.y)) for e, _ in logs]  # then the first step has k = 1
    solution: Solution | None = None
    for step in range(_STEPS):
        k = Z[r + p :]
        rows = []
        for (e, c), own in zip(logs, m, strict=True):
            j = e.joint or 0
            scale = np.zeros((len(e.y), n))
            scale[:, j] = own
            W = np.hstack([k[j] * c * (e.W @ columns), k[j] * e.W, scale])
            rows.append(replace(e, W=W, y=e.y + k[j] * (own - c * (e.W @ known))))
        # without a model's torque yet, nothing tells the gains: the first step leaves them at 1
        used = slice(None) if step else slice(0, r + p)
        system = LinearSystem(labels[used], tuple(replace(e, W=e.W[:, used]) for e in rows))
        solution = Wls().solve(system)
        before, Z = Z, Z.copy()
        Z[used] = solution.X
        X, a = Z[r : r + p], Z[:r]
        m = [e.W @ (X + c * (columns @ a + known)) for e, c in logs]
        if step and _settled(Z - before, solution):
            break
    else:
        raise IdentificationError(
            "the gains do not settle; accepted: logs with and without the load, of motions that "
            "turn it against gravity at every joint"
        )
    assert solution is not None
    k, C = Z[r + p :], solution.covariance
    if not (k > 0).all():
        j = int(np.argmin(k)) + 1
        raise IdentificationError(
            f"the gain of movable joint {j} came out as {1 / k[j - 1]:.3g}; accepted: logs in "
            "which the load shows at every joint, and torques of the right sign"
        )
    std = np.sqrt(np.diag(C)[r + p :]) / k**2
    left = tuple(e.y - k[e.joint or 0] * own for (e, c), own in zip(logs, m, strict=True) if c)
    return Calibration(Z[:r], C[:r, :r], 1 / k, std, left)


def _settled(step: FloatArray, solution: Solution) -> bool:
    return bool((np.abs(step) <= _SETTLED * solution.std + 1e-12).all())


def with_gains(robot: Robot, found: Payload) -> str:
    """Return the robot.toml of a robot whose [drive] holds the gains that a load calibrated.

    They multiply those that [drive] had before, with which the logs were read.
    """
    one = tuple(tuple(float(i == j) for j in range(robot.n)) for i in range(robot.n))
    drive = robot.drive or Drive(one)
    before = drive.gain or (1.0,) * robot.n
    pairs = [(b, q.value or 1.0, q.std or 0.0) for b, q in zip(before, found.gains, strict=True)]
    gain = tuple(b * value for b, value, _ in pairs)
    std = tuple(abs(b) * s for b, _, s in pairs)
    return robot_toml(replace(robot, drive=replace(drive, gain=gain, gain_std=std)))
