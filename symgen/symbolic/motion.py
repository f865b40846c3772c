"""Accelerations, joint screws and wrenches along the way from the base to the links.

Accelerations start from -g at the base, so that weight needs no term of its own (Luh, Walker and
Paul 1980). Steps repeat those of `frames` word by word: the tape keeps one of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.kinematics import ZERO, Shift, Step, Turn, Vector, returned, shifted, turned
from symgen.symbolic.tape import TapeBuilder


@dataclass(frozen=True)
class Motion:
    """Velocity and acceleration of a link frame, in the frame; a is less gravity."""

    w: Vector
    dw: Vector
    a: Vector


def motions(
    way: tuple[Step, ...], base_gravity: Vector, qdd: Mapping[int, sp.Expr], tape: TapeBuilder
) -> Mapping[int, Motion]:
    """Derive w, dw and a of every link by joint number.

    Args:
        way: from `steps`; its speeds may be zero.
        base_gravity: acceleration of gravity in frame 0.
        qdd: joint accelerations by joint number; absent means zero.
        tape: takes the named steps.
    """
    gx, gy, gz = base_gravity
    states = {0: Motion(ZERO, ZERO, (-gx, -gy, -gz))}
    for step in way:
        j, now = step.joint.number, states[step.joint.antecedent]
        for motion in step.before:
            now = _moved(now, motion, tape)
        w, dw, a = now.w, now.dw, now.a
        speed, acceleration = step.qd, qdd.get(j, sp.S.Zero)
        if step.joint.sigma == names.REVOLUTE:
            dw = (
                tape.name(f"X1{j}", dw[0] + w[1] * speed),
                tape.name(f"X2{j}", dw[1] - w[0] * speed),
                tape.name(f"X3{j}", dw[2] + acceleration),
            )
            w = (w[0], w[1], tape.name(f"W3{j}", w[2] + step.rate))
        now = Motion(w, dw, a)
        for shift in step.after:
            now = _moved(now, shift, tape)
        if step.joint.sigma == names.PRISMATIC:
            w, a = now.w, now.a
            twice = tape.name(f"Y{j}", 2 * speed)
            a = (
                tape.name(f"Z1{j}", a[0] + w[1] * twice),
                tape.name(f"Z2{j}", a[1] - w[0] * twice),
                tape.name(f"Z3{j}", a[2] + acceleration),
            )
            now = Motion(w, now.dw, a)
        states[j] = now
    return states


def _moved(now: Motion, motion: Turn | Shift, tape: TapeBuilder) -> Motion:
    if isinstance(motion, Turn):
        return Motion(
            turned(now.w, motion, "W", tape),
            turned(now.dw, motion, "X", tape),
            turned(now.a, motion, "Z", tape),
        )
    return Motion(now.w, now.dw, carried(now.a, now.w, now.dw, now.w, motion, tape))


def carried(
    a: Vector, w: Vector, dw: Vector, other: Vector, shift: Shift, tape: TapeBuilder, tag: str = "Z"
) -> Vector:
    """Return a + dw x P + other x (w x P) for P along one axis."""
    k, length = shift.axis, shift.length
    i, h = (k + 1) % 3, (k + 2) % 3
    same = other is w

    def product(p: int, q: int) -> sp.Expr:
        low, high = (min(p, q), max(p, q)) if same else (p, q)
        return tape.name(f"{tag}P{low + 1}{high + 1}{shift.tag}", other[low] * w[high])

    # The wrench of the body needs the same sums: with names there is one of each.
    column = {
        i: tape.name(f"{tag}A{i + 1}{shift.tag}", product(k, i) + dw[h]),
        h: tape.name(f"{tag}A{h + 1}{shift.tag}", product(k, h) - dw[i]),
        k: -tape.name(f"{tag}A{k + 1}{shift.tag}", product(i, i) + product(h, h)),
    }
    out = list(a)
    for axis, value in column.items():
        out[axis] = tape.name(f"{tag}{axis + 1}{shift.tag}", a[axis] + length * value)
    return (out[0], out[1], out[2])


Screw = tuple[Vector, Vector]


def screws(way: tuple[Step, ...], tape: TapeBuilder) -> Mapping[int, Mapping[int, Screw]]:
    """Return, for each link i and each joint j that moves it, the screw (e, v) of j in frame i.

    w_i = sum of e_ij qd_j and V_i = sum of v_ij qd_j.
    """
    z = (sp.S.Zero, sp.S.Zero, sp.S.One)
    own: dict[int, Screw] = {}
    for step in way:
        if step.joint.sigma != names.FIXED:
            revolute = step.joint.sigma == names.REVOLUTE
            own[step.joint.number] = (z, ZERO) if revolute else (ZERO, z)
    return handed_on(way, own, ("E", "L"), tape)


def handed_on(
    way: tuple[Step, ...], own: Mapping[int, Screw], letters: tuple[str, str], tape: TapeBuilder
) -> Mapping[int, Mapping[int, Screw]]:
    """Express the twist `own` of each joint j, given in frame j, in frame i of each link behind."""
    states: dict[int, dict[int, Screw]] = {0: {}}
    for step in way:
        here = dict(states[step.joint.antecedent])
        for motion in (*step.before, *step.after):
            here = {j: _screwed(s, motion, j, letters, tape) for j, s in here.items()}
        j = step.joint.number
        if j in own:
            here[j] = own[j]
        states[j] = here
    return states


def _screwed(
    screw: Screw, motion: Turn | Shift, j: int, letters: tuple[str, str], tape: TapeBuilder
) -> Screw:
    (e, v), (first, second) = screw, letters
    if isinstance(motion, Turn):
        return turned(e, motion, f"{first}{j}_", tape), turned(v, motion, f"{second}{j}_", tape)
    return e, shifted(v, e, motion, f"{second}{j}_", tape)


def handed_back(
    wrench: tuple[Vector, Vector], step: Step, tag: str, tape: TapeBuilder
) -> tuple[Vector, Vector]:
    """Express a wrench (f, n) on link j as one on its antecedent: n moves by P x f."""
    f, n = wrench
    for motion in reversed((*step.before, *step.after)):
        if isinstance(motion, Turn):
            f = returned(f, motion, f"F{tag}", tape)
            n = returned(n, motion, f"N{tag}", tape)
        else:
            back = Shift(motion.axis, -motion.length, motion.tag)  # P x f = f x (-P)
            n = shifted(n, f, back, f"N{tag}", tape)
    return f, n
