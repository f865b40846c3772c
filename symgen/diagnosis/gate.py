"""The measuring chain: every log is checked, mended where it can be, and the search goes on.

Motion comes first, as a torque is looked at along the corrected motion; a limit of the torque comes
last, as it needs the model's fit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symgen.data.signals import Samples
from symgen.diagnosis.diagnosis import (
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Place,
    Rejected,
)
from symgen.diagnosis.evidence import Evidence, Scene, evidence
from symgen.diagnosis.sanity import SENSOR, Fault, motion_faults
from symgen.diagnosis.torque_sanity import (
    SATURATION,
    modelled,
    saturations,
    torque_faults,
    torque_jumps,
)
from symgen.faults.fault import Fault as ChannelFault
from symgen.faults.fault import undone
from symgen.faults.model import channel_faults
from symgen.names import PRISMATIC, REVOLUTE, unit
from symgen.robot.effect import definitions
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

GAIN, DELAY = "drive_gain_error", "time_delay"
#: A factor of a torque from which it is of another unit; below, a spring may do as much, and it is
#: a candidate beside the physics.
_ANOTHER = 100.0
_WORDS = {
    SENSOR: "qd{0} = (1 + GV{0})*dq{0}(t - LV{0})/dt + OV{0}",
    DELAY: "tau(t) = model(t - DT)",
    GAIN: "tau{0} = (1 + G{0})*model{0}",
    SATURATION: "min(max(tau{0}, -limit{0}), limit{0})",
}


def check(
    evaluator: Evaluator,
    base: Evidence,
    train: Sequence[Samples],
    others: Sequence[tuple[Samples, Scene]] = (),
) -> tuple[Fault, ...]:
    """Return what is wrong with some logs; nothing for a sound set.

    Args:
        evaluator: the compiled model.
        base: its evidence on the training logs.
        train: the training logs, unfiltered, in the order of the scenes of base.
        others: validation logs; only their motion is looked at.
    """
    robot = evaluator.model.robot
    logs = [*zip(train, base.scenes, strict=True), *others]
    found = _pooled(f for samples, s in logs for f in motion_faults(robot, samples, s))
    if any(f.corrected is None for f in found):
        return found
    if found:
        base = evidence(evaluator, corrected(found, base.scenes))
    models = modelled(evaluator, base)
    wrong = _pooled(torque_faults(evaluator, train, base, models))
    wrong = wrong or _channels(evaluator, base.scenes, [s for _, s in others])
    wrong = wrong or _pooled(torque_jumps(robot, train, base, models))
    return (*found, *(wrong or saturations(evaluator, base)))


def rivals_physics(fault: Fault) -> bool:
    """Whether physics may look like it: another gear ratio, a step of a torque, a late torque.

    Friction that a robot file leaves out has the phase of a delay.
    """
    step = fault.name == "step" and fault.channel.startswith("tau")
    return step or fault.name in ("ratio", DELAY)


def _channels(
    evaluator: Evaluator, train: Sequence[Scene], held: Sequence[Scene]
) -> tuple[Fault, ...]:
    """Return what the model shows of the channels, as identify sees it."""
    robot = evaluator.model.robot
    if robot.loaded:
        return ()
    logs, other = ([s.log for s in group] for group in (train, held))
    out = []
    for f in channel_faults(evaluator, logs, other):
        mild = f.kind == "gain" and 1 / _ANOTHER < f.value < _ANOTHER
        if mild:  # a candidate beside the physics
            break
        name = f.kind
        parameters: tuple[FoundParameter, ...] = ()
        if f.kind == "delay":
            name, parameters = DELAY, (FoundParameter("DT", f.value, math.nan, "s"),)
        if f.kind == "gain":
            number = robot.movable[f.joints[0]].number
            name = GAIN
            parameters = (FoundParameter(f"G{number}", f.value - 1, math.nan, ""),)
        out.append(Fault(name, f.joints, f.channel, parameters, f.fault, partial(_undone, f)))
    return tuple(out)


def _undone(fault: ChannelFault, s: Scene) -> Scene:
    return replace(s, log=undone(s.log, [fault])[0])


def _pooled(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Make one fault of those of one channel in several logs; values are weighed by precision."""
    groups: dict[tuple[str, tuple[int, ...], str], list[Fault]] = {}
    for fault in faults:
        groups.setdefault((fault.name, fault.joints, fault.channel), []).append(fault)
    return tuple(
        replace(
            same[0],
            parameters=tuple(_mean(p) for p in zip(*(f.parameters for f in same), strict=True)),
            says="; ".join(f.says for f in same),
            p_value=min(f.p_value for f in same),
        )
        for same in groups.values()
    )


def _mean(same: Sequence[FoundParameter]) -> FoundParameter:
    weights = np.array([p.std for p in same]) ** -2.0
    value = float(weights @ [p.value for p in same] / weights.sum())
    return replace(same[0], value=value, std=float(weights.sum() ** -0.5))


def corrected(faults: Sequence[Fault], scenes: Iterable[Scene]) -> list[Scene]:
    """Return scenes without the faults that can be corrected."""
    out = []
    for s in scenes:
        for fault in faults:
            s = fault.corrected(s) if fault.corrected else s
        out.append(s)
    return out


def judged(faults: Sequence[Fault], before: Diagnosis, after: Diagnosis) -> Diagnosis:
    """Return the verdict on faulty logs, which names no physics.

    Args:
        faults: what is wrong.
        before, after: the model on the logs as they are, and as corrected, without any effect.
    """
    robot = after.extended
    if not any(f.corrected for f in faults):
        after = replace(after, after=before.before)  # nothing was done about it
    named = [f for f in faults if f.name in definitions()]
    plain = [f for f in faults if f.name not in definitions()]
    effects = tuple(_effect(f, robot, before.before, after.after) for f in named)
    curves = tuple(
        replace(a, before=b.before) for a, b in zip(after.curves, before.curves, strict=True)
    )
    rejected = tuple(Rejected(f.name, _numbers(f, robot), f.says) for f in plain)
    return replace(
        after,
        verdict="bad-measurement",
        before=before.before,
        where=_where(faults, before, robot),
        effects=tuple(sorted(effects, key=lambda e: -e.gap_reduction)),
        rejected=rejected,
        advice=(*(f.says for f in faults), "no physics is looked for in a log that is wrong"),
        curves=curves,
    )


def closed(before: Gap, after: Gap) -> float:
    """Return the share of the square of a gap that is closed."""
    return 1 - (after.total / before.total) ** 2 if before.total else 0.0


def mended(
    repairs: Sequence[ChannelFault], robot: Robot, raw: Gap, now: Gap, least: float
) -> list[FoundEffect]:
    """Name what was mended or masked in the logs, where that closes a part of the gap.

    Args:
        repairs: what was done.
        robot: whose joints they are.
        raw, now: gap of the logs as they were recorded, and as they are mended.
        least: share of the square of the gap that has to be closed.
    """
    share = closed(raw, now)
    if share < least:
        return []
    groups: dict[str, list[ChannelFault]] = {}
    common = any(r.channel == "qd" and r.values for r in repairs)
    for r in repairs:
        if common and r.channel.startswith("qd") and r.channel != "qd" and r.values:
            continue  # what all joints share in one log is what they have in another
        if r.values or "dq/dt" in r.done:
            groups.setdefault(r.channel, []).append(r)
    out = []
    for channel, same in groups.items():
        name = SATURATION if channel.startswith("tau") else SENSOR
        digits = channel.lstrip("qdtau")
        j = int(digits) - 1 if digits else None
        number: int | str = "" if j is None else robot.movable[j].number
        out.append(
            FoundEffect(
                name=name,
                joints=() if j is None else (robot.movable[j].number,),
                parameters=tuple(_values(same, robot, j, number)),
                expression=_WORDS[name].format(number),
                p_value=0.0,
                gap_reduction=max(0.0, share),
                declared=False,
            )
        )
    return out


def _values(
    same: Sequence[ChannelFault], robot: Robot, j: int | None, number: int | str
) -> Iterator[FoundParameter]:
    """Return the mean over the logs of what was measured."""
    sigma = REVOLUTE if j is None else robot.movable[j].sigma
    slides = sigma == PRISMATIC
    units = {"GV": "", "LV": "s", "OV": "m/s" if slides else "rad/s", "limit": unit("FS", sigma)}
    for name, word in units.items():
        seen = [(x, std) for r in same for key, x, std in r.values if key == name]
        if seen:
            x, std = np.mean(seen, axis=0)
            yield FoundParameter(f"{name}{number}", float(x), float(std), word)


def with_chain(
    diagnosis: Diagnosis,
    named: Sequence[FoundEffect],
    before: Gap,
    share: float = 0.0,
    says: Sequence[str] = (),
) -> Diagnosis:
    """Return a diagnosis with the faults of the measuring chain that were repaired before it.

    Args:
        diagnosis: of the repaired logs.
        named: the faults, as effects.
        before: the gap before they were repaired.
        share: of the square of the gap that undoing the faults without a name closes.
        says: these, in words.
    """
    chain = max([share, *(e.gap_reduction for e in named)])
    physics = max((e.gap_reduction for e in diagnosis.effects), default=0.0)
    verdict = diagnosis.verdict
    if chain >= physics * (1 - chain):
        verdict = "bad-measurement"
    elif verdict == "consistent":
        verdict = "explained"
    effects = sorted((*named, *diagnosis.effects), key=lambda e: -e.gap_reduction)
    after = diagnosis.after if diagnosis.after.total <= before.total else before
    return replace(
        diagnosis,
        verdict=verdict,
        effects=tuple(effects),
        advice=(*says, *diagnosis.advice),
        before=before,
        after=after,
    )


def _numbers(fault: Fault, robot: Robot) -> tuple[int, ...]:
    return tuple(robot.movable[j].number for j in fault.joints)


def _effect(fault: Fault, robot: Robot, before: Gap, after: Gap) -> FoundEffect:
    number = robot.movable[fault.joints[0]].number
    whole = fault.name == DELAY
    # The wrong speed of one joint is felt in the torques of others.
    joints = fault.joints if fault.name == SATURATION else range(robot.n)
    was, left = (sum(g.per_joint[j] ** 2 for j in joints) for g in (before, after))
    return FoundEffect(
        name=fault.name,
        joints=() if whole else _numbers(fault, robot),
        parameters=fault.parameters,
        expression=_WORDS[fault.name].format(number),
        p_value=fault.p_value,
        gap_reduction=max(0.0, 1 - left / was) if was else 0.0,
        declared=False,
    )


def _where(faults: Sequence[Fault], before: Diagnosis, robot: Robot) -> tuple[Place, ...]:
    """Return the joints of the faults, each with its share of the gap before."""
    pattern: dict[int, str] = {}
    for fault in faults:
        own = definitions()[fault.name].pattern if fault.name in definitions() else "all"
        for j in fault.joints or range(robot.n):
            pattern.setdefault(j, own)
    size = np.array([before.before.per_joint[j] ** 2 for j in pattern])
    share = size / size.sum() if size.sum() > 0 else np.full(len(size), 1 / len(size))
    rows = [
        Place(robot.movable[j].number, float(part), word)
        for (j, word), part in zip(pattern.items(), share, strict=True)
    ]
    return tuple(sorted(rows, key=lambda p: -p.share))
