"""Faults of the measuring chain: find, undo where possible, and name them as effects.

Faults of the motion come first, because torques are compared along the corrected motion. The limit
of a torque comes last, because it needs the fit of the model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.data.mask import rms
from symgen.diagnosis.diagnosis import (
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Place,
    Rejected,
)
from symgen.estimation.filtered_log import FilteredLog
from symgen.faults.causes import ANOTHER, find_cause, unmendable
from symgen.faults.fault import Fault, undo_faults
from symgen.faults.model import (
    MOST,
    Trial,
    against_physics,
    channel_faults,
    torque_steps,
)
from symgen.faults.samples import unmended_faults
from symgen.faults.scene import Rows, Scene
from symgen.names import REVOLUTE
from symgen.policy import MISFIT
from symgen.robot.effect import definitions, unit
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Causes that need a new record. They stay named whatever their correction closes of the gap.
_UNMENDABLE = ("upside down", "weightless", "clock", "command")
_SENSOR = "velocity_sensor_error"
#: Kinds of faults with an effect in the library.
_EFFECTS = {
    "speed": _SENSOR,
    "unrelated": _SENSOR,
    "delay": "time_delay",
    "gain": "drive_gain_error",
    "saturated": "saturation",
    "command": "commanded_torque",
}
#: Effects of the measuring chain, and the expression of each.
CHAIN = {
    _SENSOR: "qd{0} = (1 + GV{0})*dq{0}(t - LV{0})/dt + OV{0}",
    "time_delay": "tau(t) = model(t - DT)",
    "drive_gain_error": "tau{0} = (1 + G{0})*model{0}",
    "saturation": "min(max(tau{0}, -limit{0}), limit{0})",
    "commanded_torque": "tau = a controller's command",
}


def check(
    evaluator: Evaluator,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog] = (),
    repairs: Sequence[Fault] = (),
) -> tuple[tuple[Fault, ...], tuple[Fault, ...]]:
    """Return the faults of repaired logs, and those of them that need a new record.

    Args:
        evaluator: the compiled model.
        train, held: training and validation logs in the band of the run.
        repairs: repairs of these logs.
    """
    passive = evaluator.model.robot.passive
    found = tuple(f for log in (*train, *held) for f in unmended_faults(log.samples, passive))
    if found:
        return found, found
    trial = Trial(evaluator, train, held)
    if wrong := against_physics(trial):
        return tuple(wrong), tuple(wrong)
    others = _channels(trial, repairs)
    lost = tuple(f for f in others if f.kind in _UNMENDABLE)
    return tuple(others or torque_steps(trial)), lost


def _channels(trial: Trial, repairs: Sequence[Fault]) -> list[Fault]:
    """Return the channel faults that `identify` finds too; a small gain may be physics."""
    found: list[Fault] = []
    if trial.evaluator.model.robot.loaded:
        return found
    logs, held = trial.logs, trial.held
    for _ in range(MOST):
        faults = channel_faults(trial.evaluator, logs, held, ("exchange", "units"))
        rows = Rows(trial.evaluator, (*logs, *held), len(logs), MISFIT)
        scene = Scene(rows)
        cause = find_cause(scene, faults, repairs, undone=True)
        if cause is not None and cause.fault is not None:
            faults = (cause.fault,)
        elif cause is not None and cause.kind in _UNMENDABLE:
            return [*found, unmendable(scene, cause)]
        new = [f for f in faults if (f.kind, f.joints) not in {(o.kind, o.joints) for o in found}]
        # A torque in the same unit may also be wrong by a spring, so it competes with the physics.
        if not new or (new[0].kind == "gain" and 1 / ANOTHER < new[0].value < ANOTHER):
            break
        found += new
        logs, held = ([undo_faults(log, new)[0] for log in group] for group in (logs, held))
    return found


def rivals_physics(fault: Fault) -> bool:
    """Whether physics may look like the fault: another gear ratio, or a step of a torque."""
    return fault.kind == "ratio" or (fault.kind == "step" and fault.channel.startswith("tau"))


def is_effect(fault: Fault) -> bool:
    """Whether the library has an effect for the fault."""
    return fault.kind in _EFFECTS


def name_of(fault: Fault) -> str:
    """Return the name of a fault: that of its effect in the library, or its kind."""
    return _EFFECTS.get(fault.kind, fault.kind)


def named_effects(
    faults: Sequence[Fault], robot: Robot, before: Gap, after: Gap
) -> list[FoundEffect]:
    """Return the faults that are effects, with the share of the gap that each correction closes.

    Args:
        faults: the faults of the logs.
        robot: the robot of the logs.
        before, after: gap of the declared model on the logs as recorded, and corrected.
    """
    out = []
    for f in filter(is_effect, faults):
        # A wrong speed of one joint changes the torques of others.
        joints = f.joints if f.kind == "saturated" else range(robot.n)
        was, left = (sum(g.per_joint[j] ** 2 for j in joints) for g in (before, after))
        out.append(_effect([f], robot, 1 - left / was if was else 0.0))
    return out


def rejected(fault: Fault, robot: Robot, and_so: str = "") -> Rejected:
    """Return a fault as a rejected candidate, with the reason."""
    numbers = tuple(robot.movable[j].number for j in fault.joints)
    return Rejected(name_of(fault), numbers, fault.fault + and_so)


def closed(before: Gap, after: Gap) -> float:
    """Return the share of the square of a gap that is closed."""
    return 1 - (after.total / before.total) ** 2 if before.total else 0.0


def matters(before: Gap, after: Gap, least: float) -> bool:
    """Whether the gap of a joint falls by at least `least` of its torque, computed from squares."""
    was, left = (np.square(gap.per_joint) for gap in (before, after))
    return after.total < before.total and bool((was - left >= least**2).any())


def mended(
    repairs: Sequence[Fault],
    logs: Sequence[FilteredLog],
    robot: Robot,
    raw: Diagnosis,
    now: Diagnosis,
    least: float,
) -> list[FoundEffect]:
    """Return the repaired or masked faults of the logs that matter, as effects.

    A repair matters if it lowers the torque error of a joint by at least `least`. A repaired speed
    also matters if its error was at least `least` and the repair closes any part of the gap.

    Args:
        repairs: repairs of the logs.
        logs: the repaired logs, in the band of the run.
        robot: the robot of the logs.
        raw, now: the declared model on the logs as recorded, and on the repaired logs, both with
            measured speeds.
        least: smallest torque that matters, as a part of the joint's torque.
    """
    share, told = closed(raw.before, now.before), matters(raw.moving[0], now.moving[0], least)
    named = {log.name: log for log in logs}
    groups: dict[tuple[str, tuple[int, ...]], list[Fault]] = {}
    common = any(r.kind == "speed" and not r.joints for r in repairs)
    for r in (one for fault in repairs for one in _by_joint(fault)):
        if not told and (share <= 0 or _speed_error(r, named[r.log]) < least):
            continue
        if r.kind == "stuck" and r.channel.startswith("qd"):
            r = replace(r, kind="unrelated")
        if r.kind == "speed" and r.joints and common:
            continue  # a fault of all joints is the same in each log
        if is_effect(r):
            groups.setdefault((name_of(r), r.joints), []).append(r)
    return [_effect(same, robot, share) for same in groups.values()]


def _by_joint(fault: Fault) -> list[Fault]:
    """Return one fault for each joint of a fault of several joints, each with its own values."""
    if len(fault.joints) < 2:
        return [fault]
    out = []
    for j in fault.joints:
        number = str(j + 1)
        values = [(n.removesuffix(number), x, s) for n, x, s in fault.values if n.endswith(number)]
        channel = next(c for c in fault.channel.split(", ") if c.endswith(number))
        out.append(replace(fault, channel=channel, joints=(j,), values=tuple(values)))
    return out


def _speed_error(fault: Fault, log: FilteredLog) -> float:
    """Return the relative error of a measured speed; 0 for another fault."""
    if fault.kind == "unrelated":
        return math.inf
    if fault.kind != "speed":
        return 0.0
    value = {name: x for name, x, _ in fault.values}
    joints = list(fault.joints) or slice(None)
    speed, change = (np.maximum(rms(x[:, joints]), 1e-300) for x in (log.qd, log.qdd))
    parts = np.array([value.get("LV", 0.0) * change / speed, value.get("OV", 0.0) / speed])
    return float(np.sqrt(value.get("GV", 0.0) ** 2 + np.sum(parts**2, axis=0)).max())


def _effect(same: Sequence[Fault], robot: Robot, share: float) -> FoundEffect:
    """Return one fault of one or more logs as an effect; values are means over the logs."""
    first = same[0]
    whole = first.channel == "tau" or not first.joints
    joint = None if whole else robot.movable[first.joints[0]]
    number, sigma = ("", REVOLUTE) if joint is None else (joint.number, joint.sigma)
    parameters = []
    if first.kind == "delay":
        parameters.append(FoundParameter("DT", first.value, math.nan, "s"))
    if first.kind == "gain":
        parameters.append(FoundParameter(f"G{number}", first.value - 1, math.nan, ""))
    units = {"GV": "", "LV": "s", "OV": unit("speed", sigma), "limit": unit("torque", sigma)}
    for key, word in units.items():
        seen = [(x, std) for r in same for name, x, std in r.values if name == key]
        if seen:
            x, std = np.mean(seen, axis=0)
            parameters.append(FoundParameter(f"{key}{number}", float(x), float(std), word))
    name = name_of(first)
    return FoundEffect(
        name=name,
        joints=() if joint is None else (joint.number,),
        parameters=tuple(parameters),
        expression=CHAIN[name].format(number),
        p_value=0.0,
        gap_reduction=max(0.0, share),
        declared=False,
    )


def with_chain(
    diagnosis: Diagnosis,
    named: Sequence[FoundEffect],
    before: Gap,
    share: float = 0.0,
    says: Sequence[str] = (),
    lasting: Sequence[Fault] = (),
) -> Diagnosis:
    """Return a diagnosis with the faults that were repaired before it.

    Args:
        diagnosis: the diagnosis of the repaired logs.
        named: the faults, as effects.
        before: the gap before the repairs.
        share: share of the squared gap closed by correcting faults without an effect.
        says: texts about these faults.
        lasting: all faults that need a new record.
    """
    chain = max([share, *(e.gap_reduction for e in named)])
    physics = max((e.gap_reduction for e in diagnosis.effects), default=0.0)
    verdict = diagnosis.verdict
    if lasting or chain >= physics * (1 - chain):
        verdict = "bad-measurement"
    elif verdict == "consistent":
        verdict = "explained"
    effects = sorted((*named, *diagnosis.effects), key=lambda e: -e.gap_reduction)
    after = diagnosis.after if diagnosis.after.total <= before.total else before
    return replace(
        diagnosis,
        verdict=verdict,
        effects=tuple(effects),
        rejected=(
            *(rejected(f, diagnosis.extended) for f in lasting if not is_effect(f)),
            *diagnosis.rejected,
        ),
        advice=(*says, *diagnosis.advice),
        before=before,
        after=after,
    )


def places_of(faults: Sequence[Fault], before: Gap, robot: Robot) -> tuple[Place, ...]:
    """Return the joints of the faults, each with its share of the gap before."""
    pattern: dict[int, str] = {}
    for fault in faults:
        own = definitions()[name_of(fault)].pattern if is_effect(fault) else "all"
        for j in fault.joints or range(robot.n):
            pattern.setdefault(j, own)
    size = np.array([before.per_joint[j] ** 2 for j in pattern])
    share = size / size.sum() if size.sum() > 0 else np.full(len(size), 1 / len(size))
    rows = [
        Place(robot.movable[j].number, float(part), word)
        for (j, word), part in zip(pattern.items(), share, strict=True)
    ]
    return tuple(sorted(rows, key=lambda p: -p.share))
