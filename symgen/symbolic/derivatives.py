"""Derivatives of inverse and forward dynamics, by recursion over composite bodies.

With the twist v_j and the acceleration a_j (less gravity) of link j, the screw S_j of its joint and

    S'_j = v_j x S_j,    S"_j = a_j x S_j + v_j x S'_j

the derivatives of the torques are, for j on the path from the base to i,

    dtau_j/dq_i  = S_j . (I_i S"_i + 2 B_i S'_i + S_i x* f_i)
    dtau_i/dq_j  = S_i . (I_i S"_j + 2 B_i S'_j)
    dtau_j/dqd_i = S_j . 2 (I_i S'_i + B_i S_i)
    dtau_i/dqd_j = S_i . 2 (I_i S'_j + B_i S_j)

(Singh, Russo and Wensing 2022; for joints with one degree of freedom the rate of the screw is S').
I_i, B_i and f_i are those of link i with all links that it carries. 2 B is here

    2 B (w; V) = (R w + w x k; 2 w x l)

with the momentum (l, k) of the carried bodies, and R = dJ/dt, the rate of their inertia. R moves to
another frame by the rule of composite bodies, with l for m and without mass, so B costs as much as
I. Friction and effects are closed expressions, which SymPy differentiates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symgen.symbolic.bodies import Inertia, composites, products
from symgen.symbolic.constraints import ByJoint, Rows, add_to, combined, congruent, spread
from symgen.symbolic.dynamics import (
    Plant,
    loads,
    mass_matrix,
    rigid_torques,
    summed_to_base,
    weighted_effects,
    wrenches,
)
from symgen.symbolic.forward import accelerating_torque, factor_solution, factored
from symgen.symbolic.friction import friction_torque_slopes
from symgen.symbolic.kinematics import axes, variables
from symgen.symbolic.motion import LinkState, accelerations, velocities
from symgen.symbolic.spatial import (
    ZERO,
    Screw,
    Z,
    acting,
    cross,
    matvec,
    named,
    plus,
    scaled,
    screw_rate,
)
from symgen.symbolic.tape import TapeBuilder, real_symbol

_HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Screws:
    """S, 2 S' and S" of a joint in one frame: angular and linear parts."""

    screw: Screw
    twice: Screw
    second: Screw


@dataclass(frozen=True)
class _TorqueSlopes:
    """dtau/dq and dtau/dqd, and `gain`: d(tau_j)/d(rigid-body torque on joint j)."""

    by_q: Rows
    by_qd: Rows
    gain: ByJoint


def inverse_dynamics_derivatives(p: Plant) -> tuple[list[sp.Expr], ...]:
    """Return dtau/dq, dtau/dqd, and dtau/dw of a free base, row-major.

    Rows are the equations; columns are the movable joints, and the components of w.
    """
    found = _slopes(p, variables(p.robot, "qdd"))
    return tuple(_listed(p, *part) for part in _parts(p, found.by_q, found.by_qd))


def _parts(p: Plant, by_q: Rows, by_qd: Rows) -> list[tuple[Rows, tuple[int, ...]]]:
    """Return the derivatives by q, qd and w, with the numbers of their columns."""
    return [(by_q, p.numbers), (by_qd, p.numbers), (by_qd, p.robot.free[3:])]


def _listed(p: Plant, rows: Rows, columns: Sequence[int]) -> list[sp.Expr]:
    return [rows[j].get(k, sp.S.Zero) for j in p.equations for k in columns]


def _slopes(p: Plant, qdd: ByJoint) -> _TorqueSlopes:
    """Return the slopes of the torque at accelerations `qdd`."""
    by_q, by_qd = _rigid(p, qdd)
    load = loads(p, rigid_torques(p, qdd)) if p.robot.loaded else None
    gain = _load_gains(p, load)
    return _TorqueSlopes(
        _with_friction(p, by_q, load, gain, "q"), _with_friction(p, by_qd, load, gain, "qd"), gain
    )


def forward_dynamics_derivatives(p: Plant) -> tuple[list[sp.Expr], ...]:
    """Return dqdd/dq, dqdd/dqd, dqdd/dtau, and the pivots that must be positive.

    For a free base, the rows are those of f, wd and qdd, and the columns of dtau those of the
    wrench and of tau. The derivatives by its w come before the pivots.

    `forward_dynamics` defines the pivots.

    From tau(q, qd, qdd(q, qd, tau)) = tau follows dqdd/dtau = (E M)^-1 and dqdd/dq = -(E M)^-1
    dtau/dq, with E = 1 + the slope of effects over the load on their joint. Each column is solved
    separately, because products with the inverse lose as many digits as the condition number of M
    has.
    """
    tape, order = p.tape, p.equations
    right, positive = accelerating_torque(p)
    factor = factored(p, mass_matrix(p))
    qdd = factor_solution(p, factor, right, "o")
    slopes = _slopes(_accelerated(p, qdd), qdd)
    share = {}
    for j, gain in slopes.gain.items():
        share[j] = tape.name(f"h{j}", 1 / gain)
    inverse: Rows = {j: {} for j in order}
    by_q: Rows = {j: {} for j in order}
    by_qd: Rows = {j: {} for j in order}
    for k in order:
        unit = dict.fromkeys(order, sp.S.Zero) | {k: sp.S.One}
        for j, value in factor_solution(p, factor, unit, f"i{k}_").items():
            if value != 0:
                inverse[j][k] = tape.name(f"I{j}_{k}", value * share[k])
        for rows, found, letter in ((slopes.by_q, by_q, "u"), (slopes.by_qd, by_qd, "v")):
            right = {j: share[j] * rows[j].get(k, sp.S.Zero) for j in order}
            for j, value in factor_solution(p, factor, right, f"{letter}{k}_").items():
                found[j][k] = -value
    q, qd, w = (_listed(p, *part) for part in _parts(p, by_q, by_qd))
    return q, qd, _listed(p, inverse, order), w, [*positive, *factor.pivots]


def _accelerated(p: Plant, solution: ByJoint) -> Plant:
    """Return the plant with the accelerations of a free base from a solution."""
    if not p.robot.floating:
        return p
    values = tuple(solution[k] for k in p.robot.free)
    return replace(p, mounting=LinkState(values[3:], values[:3], w=p.mounting.w))


def _load_gains(p: Plant, load: ByJoint | None) -> ByJoint:
    """Return, by joint, 1 + the slope of effects over the rigid-body torque on the joint."""
    gains: ByJoint = dict.fromkeys(p.equations, sp.S.One)
    for j in load or ():
        columns = weighted_effects(p, load, real_symbol(f"taur{j}"))
        gains[j] = p.tape.name(f"g{j}", 1 + combined(columns).get(j, sp.S.Zero))
    return gains


def _with_friction(p: Plant, rigid: Rows, load: ByJoint | None, gain: ByJoint, by: str) -> Rows:
    """Add the derivatives of friction and effects, and combine joints that follow others."""
    tape, rows = p.tape, congruent(p.robot, rigid, f"d{by}", p.tape)
    out: Rows = {j: {k: gain[j] * v for k, v in rows[j].items()} for j in p.equations}
    for k, symbol in variables(p.robot, by).items():
        columns = weighted_effects(p, None, symbol)
        if load is not None:
            columns += weighted_effects(p, load, symbol)
        for j, value in combined(columns).items():
            add_to(out[j], k, value)
    if by == "qd":
        for parameter, slopes in friction_torque_slopes(p.robot, tape):
            for j, row in slopes.items():
                for k, value in row.items():
                    add_to(out[j], k, p.value(parameter.name) * value)
    return {j: {k: tape.name(f"D{by}{j}_{k}", v) for k, v in row.items()} for j, row in out.items()}


def _rigid(p: Plant, qdd: ByJoint) -> tuple[Rows, Rows]:
    """Return dtau/dq and dtau/dqd of the links, over all moving joints.

    A free base adds its rows, and three columns dtau/dw to the second. As f and wd stay, no
    acceleration of a link changes with w, and S' replaces 2 S' there.
    """
    tape, free, links = p.tape, p.robot.free, axes(p.robot)
    # The torques do not depend on the velocity of the base; it is zero here.
    base = LinkState(p.mounting.w, ZERO)
    moving, rates = velocities(p.way, base, tape), spread(p.robot, qdd, tape)
    motion = accelerations(p.way, p.mounting, rates, tape)
    force = summed_to_base(p, wrenches(p, rates), "")
    momentum = p.momenta(moving)
    changing = {j: b.rate(moving[j], momentum[j][0], j, tape) for j, b in p.bodies.items()}
    bodies, growing = composites(p.way, p.bodies, tape), composites(p.way, changing, tape)
    momenta = summed_to_base(p, momentum, "k")
    screws = {}
    for j, (a, screw) in links.items():
        screws[j] = (
            Screws(screw, screw_rate(screw, moving[a].twist), (ZERO, ZERO))
            if j in free
            else _screws(screw, moving[a], motion[a], j, tape)
        )
    by_q: Rows = {j: {} for j in screws}
    by_qd: Rows = {j: {} for j in screws}
    for i, at in screws.items():
        a = links[i][0]
        reactions = reaction_wrenches(at, bodies[a], growing[a], momenta[a], force[a], i, tape)
        place, speed, inertia, couple = (
            summed_to_base(p, {a: wrench}, f"{letter}{i}")
            for wrench, letter in zip(reactions, "pqmu", strict=True)
        )
        numbers = (j for link in place for j in ((link,) if link else free))
        for j in (j for j in numbers if j in screws):
            b, before = links[j][0], screws[j]
            if i not in free:
                by_q[j][i] = tape.name(f"P{j}_{i}", acting(place[b], before.screw))
                by_qd[j][i] = tape.name(f"Q{j}_{i}", acting(speed[b], before.screw))
                if j == i:
                    continue
            if j not in free:
                half = _HALF * acting(couple[b], before.twice)
                value = half + acting(inertia[b], before.second)
                by_q[i][j] = tape.name(f"P{i}_{j}", value)
            if j not in free[:3]:
                value = acting(couple[b], before.screw) + acting(inertia[b], before.twice)
                by_qd[i][j] = tape.name(f"Q{i}_{j}", value)
    return by_q, by_qd


def _screws(screw: Screw, frame: LinkState, motion: LinkState, j: int, tape: TapeBuilder) -> Screws:
    (w, V), dw = frame.twist, motion.dw
    p = products(w, j, tape)
    turn = named(scaled(sp.Integer(2), cross(w, Z)), f"a{j}_", tape)
    # dw x z + w x (w x z), the acceleration of a moment along z, with the names of the motion.
    second = (
        tape.name(f"A13{j}", p[2][0] + dw[1]),
        tape.name(f"A23{j}", p[2][1] - dw[0]),
        -tape.name(f"Q3{j}", p[0][0] + p[1][1]),
    )
    if screw[0] == ZERO:
        return Screws(screw, (ZERO, turn), (ZERO, second))
    slide = named(scaled(sp.Integer(2), cross(V, Z)), f"b{j}_", tape)
    linear = named(plus(cross(motion.a, Z), cross(V, turn)), f"c{j}_", tape)
    return Screws(screw, (turn, slide), (second, linear))


def reaction_wrenches(
    screws: Screws,
    body: Inertia,
    rate: Inertia,
    momentum: Screw,
    force: Screw,
    i: int,
    tape: TapeBuilder,
) -> list[Screw]:
    """Return the wrenches of q_i and qd_i on earlier joints; I S and 2 B^T S.

    Args:
        screws: screws of joint i, in some frame. All other arguments are in the same frame.
        body: link i with all links that it carries.
        rate: the rate of its inertia.
        momentum: the momentum of the body.
        force: the wrench on the body.
        i: number of the joint, for names.
        tape: receives the named steps.
    """
    (e, v), (turn, _) = screws.screw, screws.twice
    (lin, ang), (f, n) = momentum, force
    second, first = body.momentum(screws.second), body.momentum(screws.twice)
    spin = matvec(rate.J, e)
    half = named(scaled(_HALF, plus(matvec(rate.J, turn), cross(turn, ang))), f"g{i}_", tape)
    double = sp.Integer(2)
    found = {
        "p": (
            plus(second[0], cross(turn, lin), cross(e, f)),
            plus(second[1], half, cross(e, n), cross(v, f)),
        ),
        "q": (
            plus(first[0], scaled(double, cross(e, lin))),
            plus(first[1], spin, cross(e, ang)),
        ),
        "m": body.momentum(screws.screw),
        "u": (ZERO, plus(spin, cross(ang, e), scaled(double, cross(lin, v)))),
    }
    return [
        (named(linear, f"f{letter}{i}_", tape), named(angular, f"n{letter}{i}_", tape))
        for letter, (linear, angular) in found.items()
    ]
