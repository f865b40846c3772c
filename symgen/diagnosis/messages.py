"""Messages of a diagnosis, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, Gap
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray
from symgen.hypotheses.priors import PHYSICS, priors
from symgen.names import joints_in_words
from symgen.policy import BEYOND
from symgen.robot.effect import definitions
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
    """Return "joint 2", "elbow (5) and wrist (6)", or "the whole arm"."""
    return joints_in_words(joints, robot.labels) if joints else "the whole arm"


def placed(effect: FoundEffect, robot: Robot) -> str:
    """Return the name of an effect and the joints on which it acts."""
    return f"{effect.name} on {on_joints(effect.joints, robot)}"


def summary(diagnosis: Diagnosis) -> str:
    """Return the verdict in a few sentences."""
    moving = diagnosis.gaps
    before, after = percent(moving.before.total), percent(moving.after.total)
    floor, remaining = moving.noise_floor.total, moving.after.total
    bound = "at most " if floor > moving.before.total else ""
    noise = f"(noise floor: {bound}{percent(floor)})"
    ratio = f", {remaining / floor:.2g} times the noise" if remaining > BEYOND * floor > 0 else ""
    fell = remaining < moving.before.total
    change = f"falls from {before} to {after}" if fell else f"is {after}"
    gap = f"The torque error {change}{ratio} {noise}."
    if diagnosis.corrected is not None:
        undeclared = dict.fromkeys(
            e.name for e in diagnosis.effects if e.adopted and not e.declared
        )
        gap += f" With {', '.join(undeclared)}, it is {percent(diagnosis.corrected.total)}."
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
    wrong = [e for e in adopted if e.declared and _side(e) != PHYSICS]
    lacks, corrects = len(adopted) - len(wrong), len(wrong)
    parts = [f"lacks {_counted(lacks)}"] if lacks else []
    if corrects:
        parts.append("needs one correction" if corrects == 1 else f"needs {corrects} corrections")
    return f"The model {' and '.join(parts)}."


def _side(effect: FoundEffect) -> str:
    """Return the source of an error: physics, recorder or file."""
    return priors()[effect.name].side if effect.name in priors() else PHYSICS


def corrections(declared: Robot, extended: Robot) -> tuple[str, ...]:
    """Return the values of the robot file that the extended robot corrects, one a line."""
    out = []
    for joint, other in zip(declared.joints, extended.joints, strict=True):
        for key in ("theta", "d", "r", "b"):
            was, now = getattr(joint, key), getattr(other, key)
            if was != now:
                out.append(f"{key} of {declared.label(joint.number)}: {was} -> {now}")
    for key in ("torque_constant", "gain"):
        out += _changed_drive(declared, key, getattr(declared.drive, key, None), extended)
    ratios = np.diag(declared.drive.ratio) if declared.drive else None
    out += _changed_drive(declared, "ratio", ratios, extended)
    if declared.gravity != extended.gravity:
        out.append(f"gravity: {list(declared.gravity)} -> {list(extended.gravity)}")
    return tuple(out)


def _changed_drive(
    declared: Robot, key: str, before: Sequence[float] | FloatArray | None, extended: Robot
) -> Iterator[str]:
    """Yield the changed values of a key of [drive], joint by joint."""
    after = getattr(extended.drive, key, None)
    if after is None:
        return
    after = np.diag(after) if key == "ratio" else after
    was = np.ones(declared.n) if before is None else before
    for joint, old, new in zip(declared.movable, was, after, strict=True):
        if old != new:
            yield f"[drive] {key} of {declared.label(joint.number)}: {old:g} -> {new:g}"


def _counted(count: int) -> str:
    return "one effect" if count == 1 else f"{count} effects"


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
    missing = dict.fromkeys(e.name for e in diagnosis.effects if e.adopted and not e.declared)
    return (f"robot.toml and its C code cannot contain {', '.join(missing)}",) if missing else ()


def describe_effects(effects: Sequence[FoundEffect], robot: Robot) -> tuple[str, ...]:
    """Return one line per effect name, with its joints and its description."""
    joints: dict[str, list[str]] = {}
    for effect in effects:
        joints.setdefault(effect.name, []).append(on_joints(effect.joints, robot))
    known = definitions()
    return tuple(
        f"{name} on {', '.join(places)}: "
        + (known[name].says if name in known else "an effect of the robot file")
        for name, places in joints.items()
    )


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
    known = definitions()
    out = []
    for e in effects:
        advice = priors()[e.name].advice if e.name in known else ""
        if e.adopted and advice:
            out.append(f"{placed(e, robot)}: {known[e.name].says}; {advice}")
    out += [tie(e, robot) for e in effects if e.indistinguishable_from and e.separate]
    if verdict in ("unexplained", "partly-explained"):
        out.append(
            f"no known effect explains the remaining torque error of {percent(after.total)} in "
            "motion: the plots of the residual in report.html show what it depends on"
        )
    return tuple(out)
