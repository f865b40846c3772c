"""The stiffness of a joint with a second encoder on its link, from the balance of its motor.

    tau = K (q - qs) + D (q' - qs') + IA q'' + FS sign(q') + FV q' + OF

Here q is the motor's position and qs the link's, both on the joint side. Every column is measured
and none contains the model of the links. A zero error of an encoder enters OF. Without qs,
elasticity shows only in the torque, near the resonance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.data.signals import differentiate, lowpass, white_noise
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.floor import passband
from symgen.estimation.solve import weighed
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray
from symgen.hypotheses.rows import Rows

NAME = "joint_elasticity"
#: K is known if it exceeds this many standard deviations, and if the noise of q - qs in the band is
#: at most this part of the column beside the others. The bias of K grows with its square.
_SURE, _NOISE = 5.0, 0.1
#: Largest q - qs relative to the motion; above, it is another gear ratio or another unit.
_BENT = 0.25
_NAMES = ("K", "D", "IA", "FS", "FV", "OF")


@dataclass(frozen=True)
class Stiffness:
    """The result of the second encoder of a joint.

    Attributes:
        joint: index among the movable joints.
        stiffness, damping: K and D with their standard deviations, N m/rad and N m s/rad.
        p_value: p-value of K = 0.
        fault: the reason why K is not known, or "".
    """

    joint: int
    stiffness: tuple[float, float] = (0.0, 0.0)
    damping: tuple[float, float] = (0.0, 0.0)
    p_value: float = 1.0
    fault: str = ""


def has_links(scenes: Sequence[FilteredLog], j: int) -> bool:
    """Whether all logs have a second encoder on a joint."""
    found = [s.samples.qs for s in scenes]
    return all(qs is not None and bool(np.isfinite(qs[:, j]).all()) for qs in found)


def deflection(s: FilteredLog, j: int) -> FloatArray:
    """Return q - qs of a joint below the cutoff of the run, (N,), rad or m; requires qs."""
    qs = s.samples.qs
    assert qs is not None
    x = s.samples.q[:, j] - qs[:, j]
    edge = passband(s)
    return x if edge is None else lowpass(x, s.step, edge)


def stiffnesses(evidence: Rows) -> list[Stiffness]:
    """Return the results of the second encoders, for each joint that has one."""
    joints = [j for j in range(evidence.n) if has_links(evidence.logs, j)]
    return [_stiffness(evidence, j) for j in joints]


def _stiffness(evidence: Rows, j: int) -> Stiffness:
    scenes, moves = evidence.logs, evidence.moves[:, j] > 0
    travel = max(float(np.ptp(s.q[s.kept, j])) for s in scenes)
    bent = max(float(np.ptp(deflection(s, j)[s.kept])) for s in scenes)
    if bent > _BENT * travel:
        percent = 100 * bent / travel
        return Stiffness(
            j,
            fault=f"q - qs spans {percent:.2g} % of the motion: another ratio or unit, no bending",
        )
    parts = []
    for s, at in zip(scenes, kept_spans(scenes), strict=True):
        moving = moves[at]
        W, y = _columns(s, j)[moving], s.unmasked.measured[moving, j]
        parts.append(Equations(s.name, W, y, s.compared_t[moving], 2, j))
    system = LinearSystem(_NAMES, tuple(parts))
    solution = weighed(system, [np.ones(e.rows) for e in parts])
    W, X, std = system.W, solution.X, solution.std
    own = W[:, 0] - W[:, 1:] @ np.linalg.lstsq(W[:, 1:], W[:, 0], rcond=None)[0]
    noise = float(np.sqrt(np.mean([_noise(s, j) ** 2 for s in scenes])))
    if noise > _NOISE * float(np.sqrt(np.mean(own**2))):
        return Stiffness(j, fault="what it bends is no more than the noise of its two encoders")
    if X[0] < _SURE * std[0]:
        return Stiffness(j, fault="its torque does not follow what its two encoders differ by")
    p_value = math.erfc(max(float(X[0] / std[0]), 0.0) / math.sqrt(2))
    return Stiffness(j, (float(X[0]), float(std[0])), (float(X[1]), float(std[1])), p_value)


def _columns(s: FilteredLog, j: int) -> FloatArray:
    """Return the columns of the motor's balance, in the band at the kept samples, (K, 6)."""
    bent, speed = deflection(s, j), s.qd[:, j]
    rate = differentiate(bent, s.step)
    columns = [bent, rate, s.qdd[:, j], np.sign(speed), speed, np.ones_like(speed)]
    return s.unmasked.compared(np.column_stack(columns))


def _noise(s: FilteredLog, j: int) -> float:
    """Return the standard deviation of the encoders' noise in the band."""
    qs, band, edge = s.samples.qs, s.rows.cutoff, passband(s)
    if band is None or edge is None or qs is None:
        return 0.0
    raw = s.samples.q[:, j] - qs[:, j]
    high = (raw - deflection(s, j))[:, None]
    white = float(white_noise(high, s.step, edge)[0])
    return white * float(np.sqrt(2 * band * s.step))
