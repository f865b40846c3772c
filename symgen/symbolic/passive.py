"""Torques of a reference motion, M qddr + C(q, qd) qdr + g, and generalized momentum.

C contains the Christoffel symbols. Reference speeds and accelerations pass through the links along
with the real velocity (Slotine and Li 1987; in body coordinates, Niemeyer and Slotine 1991). The
momentum p = M qd is e . k + v . l of all links that a joint carries. C^T qd - g = dL/dq is, in
frame j,

    k . (w x z) + l . (V x z) - g_j, revolute;    l . (w x z) - g_j, prismatic.
"""

from __future__ import annotations

import sympy as sp

from symgen.symbolic.constraints import ByJoint, spread, to_variables
from symgen.symbolic.dynamics import (
    Plant,
    gravity_torque,
    in_all,
    summed_to_base,
    to_joints,
    with_rotors,
)
from symgen.symbolic.kinematics import variables
from symgen.symbolic.motion import AT_REST, accelerations, references, velocities
from symgen.symbolic.spatial import acting, axis, screw_rate


def slotine_li_torque(p: Plant) -> ByJoint:
    """Return M qddr + C(q, qd) qdr + g + friction(qd), and the effects of its rigid-body torque."""
    tape, qdr, qddr = p.tape, variables(p.robot, "qdr"), variables(p.robot, "qddr")
    speed, acceleration = (spread(p.robot, rate, tape) for rate in (qdr, qddr))
    real = accelerations(p.way, AT_REST, {}, tape)
    found = references(p.way, real, p.mounting, speed, acceleration, tape)
    wrench = {
        j: body.virtual_wrench(found[j], f"{j}", tape, p.namer(f"{j}"))
        for j, body in p.bodies.items()
    }
    torque = to_variables(p.robot, to_joints(p, wrench, "s"), "Tf", tape)
    return in_all(p, with_rotors(p, torque, qddr))


def generalized_momentum(p: Plant) -> tuple[ByJoint, ByJoint]:
    """Return p = M qd and C^T qd - g by movable joint."""
    tape, qd = p.tape, variables(p.robot, "qd")
    moving = velocities(p.way, AT_REST, tape)
    total = summed_to_base(p, p.momenta(moving), "k")
    momentum, rate = {}, {}
    for joint in p.robot.moving:
        j, screw, twist = joint.number, axis(joint.sigma), moving[joint.number].twist
        momentum[j] = acting(total[j], screw)
        rate[j] = tape.name(f"r{j}", acting(total[j], screw_rate(screw, twist)))
    momentum = to_variables(p.robot, momentum, "pf", tape)
    rate = to_variables(p.robot, rate, "rf", tape)
    weight, momentum = gravity_torque(p), with_rotors(p, momentum, qd)
    return (
        {j: tape.name(f"p{j}", momentum[j]) for j in p.numbers},
        {j: tape.name(f"R{j}", rate[j] - weight.get(j, sp.S.Zero)) for j in p.numbers},
    )
