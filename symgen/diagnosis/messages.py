"""Messages of a diagnosis, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Sequence

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, Gap
from symgen.estimation.torque_error import percent
from symgen.hypotheses.priors import RECORDER, priors
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
    """Return the verdict in one or two sentences."""
    moving = diagnosis.gaps
    before, after, noise = (
        percent(gap.total) for gap in (moving.before, moving.after, moving.noise_floor)
    )
    floor, remaining = moving.noise_floor.total, moving.after.total
    ratio = f", {remaining / floor:.2g} times the noise" if remaining > BEYOND * floor > 0 else ""
    fell = remaining < moving.before.total
    change = f"falls from {before} to {after}" if fell else f"is {after}"
    gap = f"The torque error {change}{ratio} (noise floor: {noise})."
    adopted = [e for e in diagnosis.effects if e.adopted]
    effects = _counted(len(adopted))
    recorded = sum(e.name in priors() and priors()[e.name].side == RECORDER for e in adopted)
    named = f": {_counted(recorded)} of the measuring chain" if recorded else ""
    return {
        "consistent": "The model explains these logs, and no effect is adopted. The "
        f"torque error is {before} (noise floor: {noise}).",
        "explained": f"The model lacks {effects}. {gap}",
        "partly-explained": f"The model lacks {effects}, and a part of the torque is unexplained. "
        f"{gap}",
        "bad-measurement": f"The measurement is wrong{named}. {gap}",
        "unexplained": f"The torque error is {before} (noise floor: {noise}), and no effect that "
        "explains it is adopted.",
    }[diagnosis.verdict]


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
