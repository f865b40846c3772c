"""The gap: the torque error of the declared and of the extended model, and its joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.diagnosis.diagnosis import Curves, FoundEffect, Gap, Place
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.torque_error import TorqueFit, size_of_kind
from symgen.estimation.values import FloatArray, Residual
from symgen.hypotheses.event import Contact
from symgen.hypotheses.registry import SearchResult
from symgen.robot.effect import described

ANY = "all"


def gap_of(residual: Residual) -> Gap:
    """Return a residual as a gap."""
    of_kinds = residual.base_force, residual.base_moment, residual.joints
    return Gap(residual.per_joint or (), residual.relative, *of_kinds)


def moving_gap(torques: TorqueFit) -> Gap:
    """Return the gap of joints in motion."""
    return gap_of(torques.in_motion.residual)


def validation_curves(
    logs: Sequence[Sequence[FilteredLog]], torques: Sequence[Sequence[FloatArray]]
) -> tuple[Curves, ...]:
    """Return measured and modelled torques of the joints, (K, n) each, of each validation log.

    Args:
        logs: the validation logs as the declared model sees them, and as the extended one does.
        torques: torques of the declared and of the extended model along them, (K, m) each.
    """
    curves = []
    for recorded, log, before, after in zip(*logs, *torques, strict=True):
        motion = log.t, log.q, log.qd, log.qdd
        t, q, qd, qdd = (x[log.kept] for x in motion)
        residuals = _residual(recorded, before), _residual(log, after)
        torques_of = log.unmasked.measured, before, after, *residuals
        first = log.base_rows
        measured, before, after, *residual = (x[:, first:] for x in torques_of)
        both = residual[0], residual[1]
        curves.append(Curves(log.name, t, q, qd, qdd, measured, before, after, both))
    return tuple(curves)


def _residual(log: FilteredLog, torque: FloatArray) -> FloatArray:
    """Return measured minus modelled torque, (K, m); NaN at masked samples."""
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
        number = robot.numbers[j]
        named = [e for e in effects if number in e.joints or not e.joints]
        probable = [s for s in result.rejected if s.odds > 0]
        patterns = [s.definition.pattern for s in probable if j in s.joints]
        if named:
            main = max(named, key=lambda e: np.nan_to_num(e.gap_reduction))
            patterns = [described(main.name).pattern]
        spans = [c.cause for c in contacts if j in c.joints]
        window = (spans[0].start, spans[0].end) if spans else None
        share = float(excess[j] / excess.sum())
        pattern, *_ = *patterns, ANY
        out.append(Place(number, share, pattern, window))
    return tuple(out)
