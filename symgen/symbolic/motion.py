"""Velocities, accelerations, joint screws and wrenches from the base to the links.

With the antecedent a of joint j, its speed qd, and P from the origin of a to that of j,

    jw_j = jA_a aw_a + sigmabar z qd,    jV_j = jA_a (aV_a + aw_a x aP_j) + sigma z qd

(Khalil and Kleinfinger 1987). Accelerations start from -g at the base, so weight needs no separate
term (Luh, Walker and Paul 1980). If the base has an IMU, they start from its measurements: specific
force, angular velocity and angular acceleration. Steps repeat those of `velocities` exactly, and
the tape keeps one copy of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.kinematics import Step, Way, axes, base_inputs, gravity
from symgen.symbolic.spatial import (
    ZERO,
    Screw,
    Shift,
    Turn,
    Vector,
    Z,
    around,
    cross,
    onward,
    plus,
    replaced,
    scaled,
    turned,
    vector,
)
from symgen.symbolic.tape import TapeBuilder


@dataclass(frozen=True)
class LinkState:
    """The motion of a link frame, in this frame.

    A twist (w, V) propagates to the next link like the acceleration (dw, a) of a motion from rest.
    The recursion of velocities is therefore that of accelerations with w = 0.

    Attributes:
        dw: angular acceleration, or the angular velocity.
        a: acceleration of the origin minus gravity, or the velocity of the origin.
        w: angular velocity; zero in the recursion of velocities.
        real: in a reference motion, the real angular velocity of the link.
        g: gravity.
        u: potential energy of a unit mass at the origin, J/kg.
    """

    dw: Vector
    a: Vector
    w: Vector = ZERO
    real: Vector | None = None
    g: Vector = ZERO
    u: sp.Expr = sp.S.Zero

    @property
    def twist(self) -> Screw:
        """Angular velocity, and velocity of the origin."""
        return self.dw, self.a

    @property
    def turning(self) -> Vector:
        """The real angular velocity."""
        return self.w if self.real is None else self.real


@dataclass(frozen=True)
class Letters:
    """Names of the steps of a recursion.

    Attributes:
        w: rotated angular velocities; `dw` and `a` of the accelerations.
        shift: acceleration a after a shift.
        joint: the term that a revolute joint adds, from a letter, an axis and the joint number.
        slide: the same for a prismatic joint.
    """

    w: str
    dw: str
    a: str
    shift: str
    joint: str
    slide: str


VELOCITY = Letters("", "W", "V", "V", "{}{}{}", "V{}{}")
REAL = Letters("W", "X", "Z", "Z", "{}{}{}", "Z{}{}")
REFERENCE = Letters("E", "e", "l", "v", "{}{}j{}", "l{}j{}")


#: A base at rest, without gravity.
AT_REST = LinkState(ZERO, ZERO)


def base_velocity(robot: Robot, tape: TapeBuilder) -> LinkState:
    """Return the twist of the base and gravity, for the recursion of velocities.

    With an IMU, only the proof of minimality uses it, for any velocity of the base and any gravity.
    Their symbols are those of wd and f. The velocity of a free base is that in a frame that falls
    freely, without gravity.
    """
    if not robot.imu:
        return replace(AT_REST, g=gravity(robot, tape))
    inputs = dict(base_inputs(robot))
    if robot.floating:
        return LinkState(inputs["w"], inputs["v"])
    return LinkState(inputs["w"], inputs["wd"], g=inputs["f"])


def base_acceleration(robot: Robot, tape: TapeBuilder) -> LinkState:
    """Return the motion of the base minus gravity, for the recursion of accelerations."""
    if not robot.imu:
        return replace(AT_REST, a=scaled(sp.S.NegativeOne, gravity(robot, tape)))
    inputs = dict(base_inputs(robot))
    return LinkState(inputs["wd"], inputs["f"], w=inputs["w"])


def velocities(way: Way, base: LinkState, tape: TapeBuilder) -> Mapping[int, LinkState]:
    """Derive the twist, gravity and height of every link by joint number; 0 is the base.

    Args:
        way: the steps to every joint, from `way_of`.
        base: the motion of the base, from `base_velocity`; AT_REST if the caller does not use
            gravity.
        tape: receives the named steps.
    """
    states = {0: base}
    for step in way:
        rates = sp.S.Zero, sp.S.Zero, step.rate
        before = states[step.joint.antecedent]
        states[step.joint.number] = passed(before, step, rates, VELOCITY, tape)
    return states


def accelerations(
    way: Way, base: LinkState, qdd: ByJoint, tape: TapeBuilder
) -> Mapping[int, LinkState]:
    """Derive w, dw and a of every link by joint number.

    Args:
        way: the steps to every joint, from `way_of`; their speeds may be zero.
        base: the motion of the base, from `base_acceleration`.
        qdd: joint accelerations by joint number; absent means zero.
        tape: receives the named steps.
    """
    states = {0: base}
    for step in way:
        j = step.joint.number
        rates = step.rate, step.qd, qdd.get(j, sp.S.Zero)
        states[j] = passed(states[step.joint.antecedent], step, rates, REAL, tape)
    return states


def references(
    way: Way,
    real: Mapping[int, LinkState],
    base: LinkState,
    speed: ByJoint,
    acceleration: ByJoint,
    tape: TapeBuilder,
    letters: Letters = REFERENCE,
) -> Mapping[int, LinkState]:
    """Derive the reference motion of links by joint number, with their real velocity.

    Args:
        way: the steps to every joint, from `way_of`, with the real speeds; links before its first
            joint are at rest.
        real: the real motion of every link, from `accelerations`.
        base: the motion of the base, from `base_acceleration`.
        speed: reference speeds by joint number; absent means zero.
        acceleration: reference accelerations by joint number.
        tape: receives the named steps.
        letters: letters for the names of steps.
    """
    states: dict[int, LinkState] = {}
    for step in way:
        j = step.joint.number
        rate = speed.get(j, sp.S.Zero)
        rates = rate, rate, acceleration.get(j, sp.S.Zero)
        before = step.joint.antecedent
        now = replace(states.get(before, base), real=real[before].turning)
        states[j] = passed(now, step, rates, letters, tape)
    return states


def passed(
    now: LinkState,
    step: Step,
    rates: tuple[sp.Expr, sp.Expr, sp.Expr],
    letters: Letters,
    tape: TapeBuilder,
) -> LinkState:
    """Express a motion in the frame of joint j, and add its rate, speed and acceleration."""
    j, (rate, speed, faster) = step.joint.number, rates
    for motion in step.before:
        now = moved(now, motion, letters, tape)
    if step.joint.turns:
        gained = plus(now.dw, cross(now.turning, scaled(speed, Z)), scaled(faster, Z))
        dw = vector(lambda i: tape.name(letters.joint.format(letters.dw, i + 1, j), gained[i]))
        w = _faster(now.w, letters.joint.format(letters.w, 3, j), rate, tape)
        real = now.real and _faster(now.real, f"W3{j}", step.rate, tape)
        now = replace(now, w=w, dw=dw, real=real)
    for shift in step.after:
        now = moved(now, shift, letters, tape)
    if step.joint.slides:
        if now.real is None:
            twice = tape.name(f"Y{j}", 2 * speed)
            turning = cross(now.w, scaled(twice, Z))
        else:
            turning = plus(cross(now.real, scaled(speed, Z)), cross(now.w, scaled(step.qd, Z)))
        gained = plus(now.a, turning, scaled(faster, Z))
        a = vector(lambda i: tape.name(letters.slide.format(i + 1, j), gained[i]))
        now = replace(now, a=a)
    return now


def _faster(w: Vector, name: str, rate: sp.Expr, tape: TapeBuilder) -> Vector:
    """Return an angular velocity plus the rate of a joint about z."""
    return replaced(w, {2: tape.name(name, w[2] + rate)})


def moved(now: LinkState, motion: Turn | Shift, letters: Letters, tape: TapeBuilder) -> LinkState:
    if isinstance(motion, Shift):
        a = _shifted(now, motion, letters.shift, tape)
        u = tape.name(f"U{motion.tag}", now.u - now.g[motion.axis] * motion.length)
        return replace(now, a=a, u=u)
    w = turned(now.w, motion, letters.w, tape)
    real = now.real and turned(now.real, motion, "W", tape)
    dw, a = turned(now.dw, motion, letters.dw, tape), turned(now.a, motion, letters.a, tape)
    return LinkState(dw, a, w, real, turned(now.g, motion, "G", tape), now.u)


def _shifted(now: LinkState, shift: Shift, letter: str, tape: TapeBuilder) -> Vector:
    """Return a + dw x P + w x (real w x P) for P along one axis."""
    k, (i, h) = shift.axis, around(shift.axis)

    def product(p: int, q: int) -> sp.Expr:
        low, high = (min(p, q), max(p, q)) if now.real is None else (p, q)
        name = f"{letter}P{low + 1}{high + 1}{shift.tag}"
        return tape.name(name, now.w[low] * now.turning[high])

    def sum_of(axis: int, value: sp.Expr) -> sp.Expr:
        # The wrench of the body needs the same sums; with names, each exists once.
        return tape.entry(value, f"{letter}A", shift.tag, axis)

    column = {
        i: sum_of(i, product(k, i) + now.dw[h]),
        h: sum_of(h, product(k, h) - now.dw[i]),
        k: -sum_of(k, product(i, i) + product(h, h)),
    }
    new = {axis: now.a[axis] + shift.length * value for axis, value in column.items()}
    named = {axis: tape.entry(x, letter, shift.tag, axis) for axis, x in new.items()}
    return replaced(now.a, named)


def screws(robot: Robot, way: Way, tape: TapeBuilder) -> Mapping[int, Mapping[int, Screw]]:
    """Return, for each link i and each joint j that moves it, the screw (e, v) of j in frame i.

    w_i = sum of e_ij qd_j and V_i = sum of v_ij qd_j. A free base has six screws.
    """
    twists = {j: screw for j, (_, screw) in axes(robot).items()}
    return in_later_frames(way, twists, "EL", tape)


def in_later_frames(
    way: Way, twists: Mapping[int, Screw], letters: str, tape: TapeBuilder
) -> Mapping[int, Mapping[int, Screw]]:
    """Express the twist of each joint j, in frame j, in each frame that j moves.

    Twists with other numbers are those of the base, in frame 0.
    """
    joints = {step.joint.number for step in way}
    states = {0: {j: twist for j, twist in twists.items() if j not in joints}}
    for step in way:
        here = states[step.joint.antecedent]
        for motion in step.way:
            here = {
                j: onward(twist, motion, [f"{letter}{j}_" for letter in letters], tape)
                for j, twist in here.items()
            }
        j = step.joint.number
        states[j] = here | ({j: twists[j]} if j in twists else {})
    return states


def wrench_on_antecedent(wrench: Screw, step: Step, tag: str, tape: TapeBuilder) -> Screw:
    """Express a wrench (f, n) on link j as one on its antecedent: n changes by P x f."""
    for motion in step.back:
        wrench = onward(wrench, motion, (f"F{tag}", f"N{tag}"), tape)
    return wrench
