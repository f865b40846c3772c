"""Messages of a diagnosis, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, Gap
from symgen.estimation.torque_error import percent
from symgen.names import joints_in_words
from symgen.policy import BEYOND
from symgen.robot.effect import PHYSICS, definitions, described
from symgen.robot.types import Robot

#: Colour of a verdict: "good", "warn" or "bad".
TONES = {
    "consistent": "good",
    "explained": "good",
    "partly-explained": "warn",
    "unexplained": "bad",
    "bad-measurement": "bad",
}


def on_joints(joints: Sequence[int], robot: Robot) -> str:
    """Return "joint 2", "elbow (5) and wrist (6)", "the whole arm", or "the whole robot"."""
    if not joints:
        return "the whole robot" if robot.floating else "the whole arm"
    return joints_in_words(joints, robot.labels)


def placed(effect: FoundEffect, robot: Robot) -> str:
    """Return the name of an effect and the joints on which it acts."""
    return f"{effect.name} on {on_joints(effect.joints, robot)}"


def summary(diagnosis: Diagnosis) -> str:
    """Return the verdict in a few sentences."""
    gaps = diagnosis.gaps
    was, now = gaps.before.total, gaps.after.total
    floor = gaps.noise_floor.total
    before, after = percent(was), percent(now)
    bound = "at most " if floor > was else ""
    noise = f"(noise floor: {bound}{percent(floor)})"
    ratio = f", {now / floor:.2g} times the noise" if now > BEYOND * floor > 0 else ""
    change = f"falls from {before} to {after}" if now < was else f"is {after}"
    gap = f"The torque error {change}{ratio} {noise}."
    if diagnosis.corrected is not None:
        with_all = percent(diagnosis.corrected.total)
        gap += f" With {_undeclared(diagnosis)}, it is {with_all}."
    return {
        "consistent": "The model explains these logs, and no effect is adopted. The "
        f"torque error is {before} {noise}.",
        "explained": f"{_lacks(diagnosis)} {gap}",
        "partly-explained": f"{_lacks(diagnosis)} A part of the torque is unexplained. {gap}",
        "bad-measurement": f"The measurement is wrong. {gap}",
        "unexplained": f"The torque error is {before} {noise}, and no effect that explains it is "
        "adopted.",
    }[diagnosis.verdict]


def _lacks(diagnosis: Diagnosis) -> str:
    """Return how many effects the model lacks, and how many keys of the file are wrong."""
    adopted = [e for e in diagnosis.effects if e.adopted]
    corrected = [e.declared and described(e.name).side != PHYSICS for e in adopted]
    lacks, corrects = corrected.count(False), corrected.count(True)
    parts = [f"lacks {_counted(lacks, 'effect')}"] if lacks else []
    if corrects:
        parts.append(f"needs {_counted(corrects, 'correction')}")
    return f"The model {' and '.join(parts)}."


def corrections(declared: Robot, extended: Robot) -> tuple[str, ...]:
    """Return the values of the robot file that the extended robot corrects, one a line."""
    was, now = _written(declared), _written(extended)
    changed = [key for key in now if was[key] != now[key]]
    return tuple(f"{key}: {was[key]} -> {now[key]}" for key in changed)


def _written(robot: Robot) -> dict[str, object]:
    """Return the values of a robot file that a diagnosis may correct, by key and joint."""
    out: dict[str, object] = {}
    for joint in robot.joints:
        for key in ("theta", "d", "r", "b"):
            value = getattr(joint, key)
            text = f"{float(value):.6g}" if value.is_number else str(value)
            out[f"{key} of {robot.label(joint.number)}"] = text
    for key in ("torque_constant", "gain", "ratio"):
        values = getattr(robot.drive, key, None)
        each = np.ones(robot.n) if values is None else np.array(values)
        each = np.diag(each) if each.ndim > 1 else each
        for number, value in zip(robot.numbers, each, strict=True):
            out[f"[drive] {key} of {robot.label(number)}"] = f"{value:g}"
    return {**out, "gravity": list(robot.gravity)}


def _counted(count: int, noun: str) -> str:
    return f"one {noun}" if count == 1 else f"{count} {noun}s"


def alike(effect: FoundEffect, robot: Robot) -> str:
    """Return the effects that these data cannot distinguish from an effect, or ""."""
    return ", ".join(
        name if joints == effect.joints else f"{name} on {on_joints(joints, robot)}"
        for name, joints in effect.indistinguishable_from
    )


def tie(effect: FoundEffect, robot: Robot) -> str:
    """Return the alternatives of an effect and the motion that distinguishes them, as a text."""
    text = (
        f"these logs cannot distinguish {placed(effect, robot)} from {alike(effect, robot)}; this "
        f"motion can: {effect.separate}"
    )
    if not effect.declared or effect.name not in definitions():
        return text
    where = "-".join(map(str, effect.joints))
    command = f"symgen excite ROBOT --for {effect.name}:{where} --into motion.csv"
    return f"{text} ({command} plans one)"


def undeclared(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return a line with the adopted effects that no robot file can declare, if there are any."""
    missing = _undeclared(diagnosis)
    return (f"robot.toml and its C code cannot contain {missing}",) if missing else ()


def _undeclared(diagnosis: Diagnosis) -> str:
    """Return the names of the adopted effects that no robot file can declare."""
    adopted = [e for e in diagnosis.effects if e.adopted]
    return ", ".join(dict.fromkeys(e.name for e in adopted if not e.declared))


def describe_effects(effects: Sequence[FoundEffect], robot: Robot) -> tuple[str, ...]:
    """Return one line per effect name, with its joints and its description."""
    out = []
    for name in dict.fromkeys(e.name for e in effects):
        places = [on_joints(e.joints, robot) for e in effects if e.name == name]
        out.append(f"{name} on {', '.join(places)}: {described(name).says}")
    return tuple(out)


def grade(effect: FoundEffect) -> str:
    """Return the grade of an effect: shown (as the cause), adopted, or suspected."""
    if effect.shown:
        return "shown"
    return "adopted" if effect.adopted else "suspected"


def advice_of(
    effects: Sequence[FoundEffect], robot: Robot, verdict: str, after: Gap
) -> tuple[str, ...]:
    """Return texts on what to do next.

    Args:
        effects: the adopted and the suspected effects.
        robot: gives the names of joints.
        verdict: the verdict of the diagnosis.
        after: the gap after, for joints in motion.
    """
    out = []
    for e in effects:
        row = described(e.name)
        if e.adopted and row.advice:
            last = e.expression.split()[-1].strip("()")
            typed = f" {last}" if "=" in last else ""
            out.append(f"{placed(e, robot)}: {row.says}; {row.advice}{typed}")
    out += [tie(e, robot) for e in effects if e.indistinguishable_from and e.separate]
    suspected = any(not e.adopted for e in effects)
    if verdict in ("unexplained", "partly-explained") and not suspected:
        out.append(
            f"no known effect explains the remaining torque error of {percent(after.total)} in "
            "motion: the plots of the residual in report.html show what it depends on"
        )
    return tuple(out)
