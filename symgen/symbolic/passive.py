"""Torques of a reference motion, M qddr + C(q, qd) qdr + g, and generalized momentum.

C contains the Christoffel symbols. Reference speeds and accelerations pass through the links along
with the real velocity (Slotine and Li 1987; in body coordinates, Niemeyer and Slotine 1991). The
momentum p = M qd is e . k + v . l of all links that a joint carries. C^T qd - g = dL/dq is, in
frame j,

    k . (w x z) + l . (V x z) - g_j, revolute;    l . (w x z) - g_j, prismatic.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from symgen.symbolic.bodies import composites
from symgen.symbolic.constraints import ByJoint, spread, to_variables
from symgen.symbolic.dynamics import (
    Plant,
    gravity_torque,
    in_all,
    summed_to_base,
    to_joints,
    with_rotors,
)
from symgen.symbolic.kinematics import axes, variables
from symgen.symbolic.motion import (
    AT_REST,
    LinkState,
    accelerations,
    base_velocity,
    references,
    velocities,
)
from symgen.symbolic.spatial import acting, cross, named, plus, scaled, screw_rate


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
    """Return p = M qd and C^T qd - g by movable joint.

    The momentum of a robot with a free base comes first. Velocities are then those in a frame that
    falls freely, where no part has a weight.
    """
    tape, qd = p.tape, variables(p.robot, "qd")
    moving = _moving(p)
    total = summed_to_base(p, p.momenta(moving), "k")
    momentum, rate = {}, {}
    for j, (link, screw) in axes(p.robot).items():
        momentum[j] = acting(total[link], screw)
        change = acting(total[link], screw_rate(screw, moving[link].twist))
        rate[j] = tape.name(f"r{j}", change)
    momentum = to_variables(p.robot, momentum, "pf", tape)
    rate = to_variables(p.robot, rate, "rf", tape)
    weight = {} if p.robot.floating else gravity_torque(p)
    momentum = with_rotors(p, momentum, qd)
    return (
        {j: tape.name(f"p{j}", momentum[j]) for j in p.equations},
        {j: tape.name(f"R{j}", rate[j] - weight.get(j, sp.S.Zero)) for j in p.equations},
    )


def centroidal_momentum(p: Plant) -> list[sp.Expr]:
    """Return the momentum (l, k) about the centre of mass, that centre, and the mass as a guard.

    With the momentum (l, k0) and the body (m, M) of all links about the origin of frame 0,

        c = m / M,    k = k0 - c x l
    """
    tape = p.tape
    linear, angular = summed_to_base(p, p.momenta(_moving(p)), "k")[0]
    robot = composites(p.way, p.bodies, tape)[0]
    inverse = tape.name("iM", 1 / robot.M)
    centre = named(scaled(inverse, robot.m), "c", tape)
    about = plus(angular, scaled(sp.S.NegativeOne, cross(centre, linear)))
    return [*linear, *named(about, "K", tape), *centre, robot.M]


def _moving(p: Plant) -> Mapping[int, LinkState]:
    """Return the velocities of all links; the base rests, unless it is free."""
    base = base_velocity(p.robot, p.tape) if p.robot.floating else AT_REST
    return velocities(p.way, base, p.tape)
