"""The gap: the torque error of the declared and of the extended model, and its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.diagnosis.diagnosis import Curves, FoundEffect, Gap, Place
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.torque_error import TorqueFit, size_of_kind
from symgen.estimation.values import FloatArray, Residual
from symgen.hypotheses.event import Contact
from symgen.hypotheses.registry import SearchResult
from symgen.robot.effect import definitions

ANY = "all"


@dataclass(frozen=True, eq=False)
class Fitted:
    """Torque errors of a model on the validation logs.

    Attributes:
        all_samples: errors over all samples.
        moving: errors of joints in motion.
    """

    all_samples: Gap
    moving: Gap

    @classmethod
    def of(cls, torques: TorqueFit) -> Fitted:
        """Return the errors of a torque fit."""
        return cls(gap_of(torques.residual), gap_of(torques.in_motion.residual))


def gap_of(residual: Residual) -> Gap:
    """Return a residual as a gap."""
    return Gap(residual.per_joint or (), residual.relative)


def validation_curves(
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]],
    before: Sequence[FloatArray],
    after: Sequence[FloatArray],
) -> tuple[Curves, ...]:
    """Return measured and modelled torques, (K, n) each, of each validation log.

    Args:
        logs: the validation logs as the declared model sees them, and as the extended one does.
        before, after: torques of the declared and of the extended model along them.
    """
    curves = []
    for recorded, log, first, last in zip(*logs, before, after, strict=True):
        measured = log.unmasked.measured
        motion = log.t[log.kept], log.q[log.kept], log.qd[log.kept], log.qdd[log.kept]
        residuals = _residual(recorded, first), _residual(log, last)
        curves.append(Curves(log.name, *motion, measured, first, last, residuals))
    return tuple(curves)


def _residual(log: FilteredLog, torque: FloatArray) -> FloatArray:
    """Return measured minus modelled torque, (K, n); NaN at masked samples."""
    return np.where(log.clear[log.kept], log.unmasked.measured - torque, np.nan)


def places(
    result: SearchResult,
    effects: Sequence[FoundEffect],
    before: Gap,
    floor: Gap,
    curves: Sequence[Curves],
    contacts: Sequence[Contact],
) -> tuple[Place, ...]:
    """Return the joints whose gap before is above the noise floor, the largest share first.

    The pattern of a joint is that of the adopted effect that closes most of its gap. A joint
    without an effect has the pattern of its most probable rejected candidate.

    Args:
        result: the adopted hypotheses and the rejected candidates.
        effects: the adopted effects.
        before, floor: gap before and noise floor of joints in motion.
        curves: the torques of the validation logs.
        contacts: the contacts.
    """
    robot = result.problem.robot
    size = np.sum([np.sum(c.measured**2, axis=0) for c in curves], axis=0)
    excess = np.square(before.per_joint) - np.nan_to_num(np.square(floor.per_joint))
    excess = np.maximum(excess, 0.0) * size / size_of_kind(size, robot.sigma)
    out = []
    for j in np.argsort(-excess):
        if excess[j] <= 0:
            break
        number = robot.movable[j].number
        named = [e for e in effects if number in e.joints or not e.joints]
        rows = [s.definition for s in result.rejected if j in s.joints and s.odds > 0]
        if named:
            main = max(named, key=lambda e: np.nan_to_num(e.gap_reduction))
            rows = [d for d in definitions().values() if d.name == main.name]
        pattern = rows[0].pattern if rows else ANY
        spans = [c.cause for c in contacts if j in c.joints]
        window = (spans[0].start, spans[0].end) if spans else None
        out.append(Place(number, float(excess[j] / excess.sum()), pattern, window))
    return tuple(out)
