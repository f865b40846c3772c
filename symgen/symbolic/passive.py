"""Reference motions beside the real one: M qddr + C(q, qd) qdr + g, and momentum with its rate.

C is that of Christoffel's symbols. Reference speeds and accelerations go through the links like
real ones, beside the real velocity (Slotine and Li 1987; in body coordinates, Niemeyer and Slotine
1991):

    f = M a_r + dw_r x m + w_r x (w x m)
    n = m x a_r + J dw_r + w x ((J - tr(J)/2) w_r)

Momentum p = M qd is e . k + v . l of all that a joint carries, and C^T qd - g = dL/dq, in frame j

    k . (w x z) + l . (V x z) - g_j, revolute;    l . (w x z) - g_j, prismatic.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.bodies import cross, unit
from symgen.symbolic.constraints import folded, spread
from symgen.symbolic.dynamics import (
    Plant,
    along,
    gravity_torque,
    handed_down,
    in_all,
    rotors,
    to_joints,
    virtual_wrench,
)
from symgen.symbolic.kinematics import ZERO, Step, Turn, Vector, frames, turned, variables
from symgen.symbolic.motion import Motion, Screw, carried, motions
from symgen.symbolic.tape import TapeBuilder


@dataclass(frozen=True)
class Reference:
    """The real angular velocity w of a link, and its reference motion; a_r is less gravity."""

    w: Vector
    w_r: Vector
    dw_r: Vector
    a_r: Vector


def references(
    way: tuple[Step, ...],
    base_gravity: Vector,
    speed: Mapping[int, sp.Expr],
    acceleration: Mapping[int, sp.Expr],
    tape: TapeBuilder,
) -> dict[int, Reference]:
    """Derive the reference motion of every link, by joint number.

    Args:
        way: from `steps`, with the real speeds.
        base_gravity: acceleration of gravity in frame 0.
        speed: reference speeds of all joints that move.
        acceleration: their reference accelerations.
        tape: takes the named steps.
    """
    real: Mapping[int, Motion] = motions(way, ZERO, {}, tape)
    x, y, z = base_gravity
    states = {0: Reference(ZERO, ZERO, ZERO, (-x, -y, -z))}
    for step in way:
        j, now = step.joint.number, states[step.joint.antecedent]
        w, w_r, dw_r, a_r = now.w, now.w_r, now.dw_r, now.a_r
        for motion in step.before:
            if isinstance(motion, Turn):
                w, w_r, dw_r, a_r = (
                    turned(vector, motion, letter, tape)
                    for vector, letter in ((w, "W"), (w_r, "E"), (dw_r, "e"), (a_r, "l"))
                )
            else:
                a_r = carried(a_r, w, dw_r, w_r, motion, tape, "v")
        w = real[j].w
        rate, faster = speed.get(j, sp.S.Zero), acceleration.get(j, sp.S.Zero)
        if step.joint.sigma == names.REVOLUTE:
            dw_r = (
                tape.name(f"e1j{j}", dw_r[0] + w[1] * rate),
                tape.name(f"e2j{j}", dw_r[1] - w[0] * rate),
                tape.name(f"e3j{j}", dw_r[2] + faster),
            )
            w_r = (w_r[0], w_r[1], tape.name(f"E3j{j}", w_r[2] + rate))
        for shift in step.after:
            a_r = carried(a_r, w, dw_r, w_r, shift, tape, "v")
        if step.joint.sigma == names.PRISMATIC:
            a_r = (
                tape.name(f"l1j{j}", a_r[0] + w[1] * rate + w_r[1] * step.qd),
                tape.name(f"l2j{j}", a_r[1] - w[0] * rate - w_r[0] * step.qd),
                tape.name(f"l3j{j}", a_r[2] + faster),
            )
        states[j] = Reference(w, w_r, dw_r, a_r)
    return states


def slotine_li_torque(p: Plant) -> dict[int, sp.Expr]:
    """Return M qddr + C(q, qd) qdr + g + friction(qd); effects of the load see its rigid part."""
    variable, tape = variables(p.robot), p.tape
    qdr, qddr = (
        dict(zip(p.numbers, symbols, strict=True)) for symbols in (variable.qdr, variable.qddr)
    )
    found = references(
        p.way, p.gravity, spread(p.robot, qdr, tape), spread(p.robot, qddr, tape), tape
    )
    wrench = {
        j.number: virtual_wrench(
            p.inertia(j.number), r.w, r.w_r, r.dw_r, r.a_r, f"{j.number}", tape
        )
        for j in p.robot.joints
        for r in (found[j.number],)
    }
    torque = folded(p.robot, to_joints(p, wrench, "s"), "Tf", tape)
    for j, coefficient in rotors(p).items():
        for k, value in coefficient.items():
            torque[j] += value * qddr.get(k, sp.S.Zero)
    return in_all(p, torque)


def reference_unit_wrench(prefix: str, r: Reference) -> Screw:
    """Return (f, n) of a link whose one parameter `prefix` is 1."""
    if prefix == names.MASS:
        return r.a_r, ZERO
    if prefix in names.MOMENT:
        axis = unit(names.MOMENT.index(prefix))
        turning, spinning = cross(r.dw_r, axis), cross(r.w_r, cross(r.w, axis))
        force = (turning[0] + spinning[0], turning[1] + spinning[1], turning[2] + spinning[2])
        return force, cross(axis, r.a_r)
    b, c = "XYZ".index(prefix[0]), "XYZ".index(prefix[1])
    moment, spin = [sp.S.Zero] * 3, [sp.S.Zero] * 3
    moment[b], spin[b] = r.dw_r[c], r.w_r[c]
    moment[c], spin[c] = r.dw_r[b], r.w_r[b]
    if b == c:
        spin = [spin[i] - sp.Rational(1, 2) * r.w_r[i] for i in range(3)]
    x, y, z = cross(r.w, (spin[0], spin[1], spin[2]))
    return ZERO, (moment[0] + x, moment[1] + y, moment[2] + z)


def generalized_momentum(p: Plant) -> tuple[dict[int, sp.Expr], dict[int, sp.Expr]]:
    """Return p = M qd and C^T qd - g by movable joint."""
    tape, qd = p.tape, dict(zip(p.numbers, variables(p.robot).qd, strict=True))
    moving = frames(p.way, ZERO, tape)
    total = handed_down(
        p,
        {j.number: p.inertia(j.number).momentum(moving[j.number], f"{j.number}", tape)
         for j in p.robot.joints},
        "k",
    )  # fmt: skip
    momentum, rate = {}, {}
    for joint in p.robot.moving:
        j, (lin, ang) = joint.number, total[joint.number]
        w, V = moving[j].w, moving[j].V
        momentum[j] = along(joint.sigma, (lin, ang))
        if joint.sigma == names.REVOLUTE:
            rate[j] = ang[0] * w[1] - ang[1] * w[0] + lin[0] * V[1] - lin[1] * V[0]
        else:
            rate[j] = lin[0] * w[1] - lin[1] * w[0]
        rate[j] = tape.name(f"r{j}", rate[j])
    momentum, rate = folded(p.robot, momentum, "pf", tape), folded(p.robot, rate, "rf", tape)
    weight = gravity_torque(p)
    for j, coefficient in rotors(p).items():
        for k, value in coefficient.items():
            momentum[j] += value * qd.get(k, sp.S.Zero)
    return (
        {j: tape.name(f"p{j}", momentum[j]) for j in p.numbers},
        {j: tape.name(f"R{j}", rate[j] - weight.get(j, sp.S.Zero)) for j in p.numbers},
    )
