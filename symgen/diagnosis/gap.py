"""The gap: the torque error of the declared and of the extended model, and its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from symgen.diagnosis.diagnosis import Curves, FoundEffect, Gap, Gaps, Place
from symgen.diagnosis.extended import Extended
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import noise_fit
from symgen.estimation.motion_error import floor_below
from symgen.estimation.system import torque_at
from symgen.estimation.torque_error import TorqueFit, size_of_kind, squares
from symgen.estimation.values import FloatArray, Residual
from symgen.hypotheses.registry import SearchResult
from symgen.hypotheses.score import dense
from symgen.robot.effect import definitions

ANY = "all"


@dataclass(frozen=True, eq=False)
class Measured:
    """Gaps on the validation data.

    Attributes:
        all_samples: gaps over all samples.
        moving: gaps over samples of joints in motion.
        curves: torques of each validation log.
    """

    all_samples: Gaps
    moving: Gaps
    curves: tuple[Curves, ...]

    @property
    def grew(self) -> bool:
        """Whether the gap after is above the gap before."""
        return any(g.after.total > g.before.total for g in (self.all_samples, self.moving))


def measure_gap(result: SearchResult, model: Extended) -> Measured:
    """Measure the gap of the declared model and of the extended model on the validation logs.

    Args:
        result: the adopted hypotheses; the declared model is compared with the logs as read.
        model: the extended model, which is compared with the corrected logs.
    """
    declared, problem = result.declared, result.problem
    was = now = TorqueFit.none(problem.robot)
    curves = []
    model_before = partial(torque_at, declared.evaluator, declared.estimate)
    modelled = [log.unmasked.modelled(model_before) for log in declared.held]
    corrected = _torques(model, problem.held) if result.items else modelled
    logs = zip(declared.held, problem.held, modelled, corrected, strict=True)
    for recorded, log, before, after in logs:
        measured, wanted = recorded.unmasked.measured, log.unmasked.measured
        counted, free = recorded.clear[recorded.kept], log.clear[log.kept]
        was += squares(counted, measured, before, recorded.resting)
        now += squares(free, wanted, after, log.resting)
        motion = log.t[log.kept], log.q[log.kept], log.qd[log.kept], log.qdd[log.kept]
        first = np.where(counted, measured - before, np.nan)
        residuals = first, np.where(free, wanted - after, np.nan)
        curves.append(Curves(log.name, *motion, wanted, before, after, residuals))
    noise = noise_fit(model.evaluator, problem.held, model.of_robot).residual
    moving = _gaps(was.in_motion.residual, now.in_motion.residual, noise)
    return Measured(_gaps(was.residual, now.residual, noise), moving, tuple(curves))


def error_in_motion(model: Extended, logs: Sequence[FilteredLog]) -> float:
    """Return the torque error of an extended model for joints in motion on some logs."""
    out = TorqueFit.none(model.problem.robot)
    for log, torque in zip(logs, _torques(model, logs), strict=True):
        out += squares(log.clear[log.kept], log.unmasked.measured, torque, log.resting)
    return out.in_motion.residual.relative


def _torques(model: Extended, logs: Sequence[FilteredLog]) -> list[FloatArray]:
    """Return the torque of the extended model along some logs, in the band, (K, n)."""
    problem, out = model.problem, []
    inside = problem.stage(model.effects).X
    for log in logs:
        torques = problem.torques_along(log, model.of_robot, model.evaluator, inside)
        torque, at = torques.model, model.count
        for c in (s.candidate for s in model.as_columns):
            columns = dense(c.columns(log, torques), log.tau.shape)
            torque = torque + columns @ model.X[at : at + c.size]
            at += c.size
        out.append(log.unmasked.compared(torque))
    return out


def _gaps(before: Residual, after: Residual, noise: Residual) -> Gaps:
    three = (before, after, floor_below(noise, after))
    return Gaps(*(Gap(r.per_joint or (), r.relative) for r in three))


def places(
    result: SearchResult, effects: Sequence[FoundEffect], gaps: Measured
) -> tuple[Place, ...]:
    """Return the joints whose gap before is above the noise floor, the largest share first.

    The pattern of a joint is that of the adopted effect that closes most of its gap. A joint
    without an effect has the pattern of its most probable rejected candidate.

    Args:
        result: the adopted hypotheses and the rejected candidates.
        effects: the adopted effects.
        gaps: gap before and noise floor.
    """
    robot = result.problem.robot
    before, floor = gaps.moving.before, gaps.moving.noise_floor
    size = np.sum([np.sum(c.measured**2, axis=0) for c in gaps.curves], axis=0)
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
        spans = [c.span for c in result.contacts if j in c.joints]
        window = (spans[0].start, spans[0].end) if spans else None
        out.append(Place(number, float(excess[j] / excess.sum()), pattern, window))
    return tuple(out)
