"""Derivatives of inverse and forward dynamics, by recursion over composite bodies.

With the twist v_j and the acceleration a_j (less gravity) of link j, the screw S_j of its joint and

    S'_j = v_j x S_j,    S"_j = a_j x S_j + v_j x S'_j

the derivatives of the torques are, for j before or at i on the way to it,

    dtau_j/dq_i  = S_j . (I_i S"_i + 2 B_i S'_i + S_i x* f_i)
    dtau_i/dq_j  = S_i . (I_i S"_j + 2 B_i S'_j)
    dtau_j/dqd_i = S_j . 2 (I_i S'_i + B_i S_i)
    dtau_i/dqd_j = S_i . 2 (I_i S'_j + B_i S_j)

(Singh, Russo and Wensing 2022; for joints of one degree of freedom the rate of the screw is S').
I_i, B_i and f_i are those of link i with all that it carries. 2 B is here

    2 B (w; V) = (R w + w x k; 2 w x l)

with the momentum (l, k) of the bodies carried and R = dJ/dt, the rate of their inertia: moving R to
another frame takes l for m and no mass in the rule of composite bodies: B costs what I does.
Nothing is differentiated but friction and effects, along their own few steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.bodies import Inertia, cross, dot, named, plus, products, scaled
from symgen.symbolic.composite import composites
from symgen.symbolic.constraints import Rows, congruent, spread
from symgen.symbolic.dynamics import (
    Plant,
    along,
    handed_down,
    loads,
    mass_matrix,
    rigid_torques,
    with_load,
    wrenches,
)
from symgen.symbolic.forward import driving, factored, solved
from symgen.symbolic.kinematics import ZERO, Frame, Vector, frames, variables
from symgen.symbolic.motion import Motion, Screw, motions
from symgen.symbolic.tangent import tangents
from symgen.symbolic.tape import TapeBuilder


@dataclass(frozen=True)
class _Screws:
    """2 S' and S" of a joint, in its frame: angular and linear parts."""

    twice: Screw
    second: Screw


def inverse_dynamics_derivatives(p: Plant) -> tuple[Rows, Rows]:
    """Return dtau/dq and dtau/dqd, by rows and columns of movable joints."""
    qdd = dict(zip(p.numbers, variables(p.robot).qdd, strict=True))
    by_q, by_qd = _rigid(p, qdd)
    if p.robot.loaded:
        load = loads(p, rigid_torques(p, qdd))
    else:
        load = dict.fromkeys(p.numbers, sp.S.Zero)
    return _with_friction(p, by_q, load, "q"), _with_friction(p, by_qd, load, "qd")


def forward_dynamics_derivatives(p: Plant) -> tuple[Rows, Rows, Rows, list[sp.Expr]]:
    """Return dqdd/dq, dqdd/dqd and dqdd/dtau, and what must be positive: see `forward_dynamics`.

    From tau(q, qd, qdd(q, qd, tau)) = tau follows dqdd/dtau = (E M)^-1 and
    dqdd/dq = -(E M)^-1 dtau/dq, with E = 1 + the slope of effects over the load on their joint.
    """
    tape, order = p.tape, p.numbers
    right, positive = driving(p)
    factor = factored(p, mass_matrix(p))
    qdd = solved(p, factor, right, "o")
    by_q, by_qd = _rigid(p, qdd)
    load = dict.fromkeys(order, sp.S.Zero)
    if p.robot.loaded:
        load = loads(p, rigid_torques(p, qdd))
    slopes = [_with_friction(p, rows, load, k) for rows, k in ((by_q, "q"), (by_qd, "qd"))]
    inverse: Rows = {j: {} for j in order}
    for k in order:
        unit = dict.fromkeys(order, sp.S.Zero) | {k: sp.S.One}
        share = _share(p, load, k)
        for j, value in solved(p, factor, unit, f"i{k}_").items():
            if value != 0:
                inverse[j][k] = tape.name(f"I{j}_{k}", value * share)
    by_q, by_qd = (_against(p, inverse, rows, k) for rows, k in zip(slopes, "uv", strict=True))
    return by_q, by_qd, inverse, [*positive, *factor.pivots]


def _against(p: Plant, inverse: Rows, slopes: Rows, letter: str) -> Rows:
    """Return -inverse slopes."""
    out: Rows = {j: {} for j in p.numbers}
    for j in p.numbers:
        for k in p.numbers:
            terms = (value * slopes[i].get(k, sp.S.Zero) for i, value in inverse[j].items())
            out[j][k] = -p.tape.name(f"{letter}{j}_{k}", sum(terms, sp.S.Zero))
    return out


def _share(p: Plant, load: Mapping[int, sp.Expr], j: int) -> sp.Expr:
    """Return 1 / E of a joint."""
    symbol = _bare(load[j])
    if not p.robot.loaded or symbol is None:
        return sp.S.One
    seed = {symbol: sp.S.One if load[j] == symbol else sp.S.NegativeOne}
    slope = tangents({j: with_load(p, load)[j]}, seed, p.tape, f"E{j}_").get(j)
    if slope is None:
        return sp.S.One
    return p.tape.name(f"h{j}", 1 / p.tape.name(f"g{j}", 1 + slope))


def _bare(expr: sp.Expr) -> sp.Symbol | None:
    """Return the symbol of a name or of its negative."""
    return expr if expr.is_Symbol else -expr if (-expr).is_Symbol else None


def _with_friction(p: Plant, rigid: Rows, load: Mapping[int, sp.Expr], by: str) -> Rows:
    """Add what friction and effects contribute, and fold joints that follow others."""
    rows = congruent(p.robot, rigid, f"d{by}", p.tape)
    rest = with_load(p, load)
    out: Rows = {j: dict(rows[j]) for j in p.numbers}
    for k, symbol in zip(p.numbers, getattr(variables(p.robot), by), strict=True):
        seeds: dict[sp.Symbol, sp.Expr] = {symbol: sp.S.One}
        for j, value in load.items():
            own = _bare(value)
            if own is not None:
                slope = rows[j].get(k, sp.S.Zero)
                seeds[own] = slope if own == value else -slope
        for j, value in tangents(rest, seeds, p.tape, f"{by}{k}_").items():
            out[j][k] = out[j].get(k, sp.S.Zero) + value
    return {
        j: {k: p.tape.name(f"D{by}{j}_{k}", v) for k, v in row.items()} for j, row in out.items()
    }


def _rigid(p: Plant, qdd: Mapping[int, sp.Expr]) -> tuple[Rows, Rows]:
    """Return dtau/dq and dtau/dqd of links, over all joints that move."""
    tape = p.tape
    moving, rates = frames(p.way, ZERO, tape), spread(p.robot, qdd, tape)
    motion = motions(p.way, p.gravity, rates, tape)
    force = handed_down(p, wrenches(p, rates), "")
    bodies = {j.number: p.inertia(j.number) for j in p.robot.joints}
    momentum = {j: body.momentum(moving[j], f"{j}", tape) for j, body in bodies.items()}
    changing = {j: body.rate(moving[j], momentum[j][0], j, tape) for j, body in bodies.items()}
    whole, growing = composites(p.way, bodies, tape), composites(p.way, changing, tape)
    carried = handed_down(p, momentum, "k")
    sigma = {joint.number: joint.sigma for joint in p.robot.moving}
    screws = {j: _screws(s, moving[j], motion[j], j, tape) for j, s in sigma.items()}
    by_q: Rows = {j: {} for j in sigma}
    by_qd: Rows = {j: {} for j in sigma}
    for i, s in sigma.items():
        column = _columns(s, screws[i], whole[i], growing[i], carried[i], force[i], i, tape)
        place, speed, inertia, couple = (
            handed_down(p, {i: wrench}, f"{letter}{i}")
            for wrench, letter in zip(column, "pqmu", strict=True)
        )
        for j in place:
            if j not in sigma:
                continue
            by_q[j][i] = tape.name(f"P{j}_{i}", along(sigma[j], place[j]))
            by_qd[j][i] = tape.name(f"Q{j}_{i}", along(sigma[j], speed[j]))
            if j == i:
                continue
            own, (f, n) = screws[j], inertia[j]
            half = sp.Rational(1, 2) * dot(couple[j][1], own.twice[0])
            value = half + dot(n, own.second[0]) + dot(f, own.second[1])
            by_q[i][j] = tape.name(f"P{i}_{j}", value)
            value = along(sigma[j], couple[j]) + dot(n, own.twice[0]) + dot(f, own.twice[1])
            by_qd[i][j] = tape.name(f"Q{i}_{j}", value)
    return by_q, by_qd


def _screws(sigma: int, frame: Frame, motion: Motion, j: int, tape: TapeBuilder) -> _Screws:
    w, V, a = frame.w, frame.V, motion.a
    p = products(w, j, tape)
    turn = named((2 * w[1], -2 * w[0], sp.S.Zero), f"a{j}_", tape)
    # dw x z + w x (w x z): what a moment along z makes of the motion, and named like it.
    second: Vector = (
        tape.name(f"A13{j}", p[2][0] + motion.dw[1]),
        tape.name(f"A23{j}", p[2][1] - motion.dw[0]),
        -tape.name(f"Q3{j}", p[0][0] + p[1][1]),
    )
    if sigma != names.REVOLUTE:
        return _Screws((ZERO, turn), (ZERO, second))
    slide = named((2 * V[1], -2 * V[0], sp.S.Zero), f"b{j}_", tape)
    linear = named(plus((a[1], -a[0], sp.S.Zero), cross(V, turn)), f"c{j}_", tape)
    return _Screws((turn, slide), (second, linear))


def _columns(
    sigma: int,
    screws: _Screws,
    body: Inertia,
    rate: Inertia,
    momentum: Screw,
    force: Screw,
    i: int,
    tape: TapeBuilder,
) -> tuple[Screw, Screw, Screw, Screw]:
    """Return, in frame i, what earlier joints see of q_i and qd_i; I S and 2 B^T S."""
    (turn, slide), (angular, linear) = screws.twice, screws.second
    (lin, ang), (f, n), m, M = momentum, force, body.m, body.M
    mx, my, _ = m
    fz: Vector = (-f[1], f[0], sp.S.Zero)
    if sigma == names.REVOLUTE:
        nz: Vector = (-n[1], n[0], sp.S.Zero)
        z_ang: Vector = (-ang[1], ang[0], sp.S.Zero)  # z x k
        z_lin: Vector = (-2 * lin[1], 2 * lin[0], sp.S.Zero)
        column = (rate.J[0][2], rate.J[1][2], rate.J[2][2])
        half = scaled(sp.Rational(1, 2), plus(rate.times(turn), cross(turn, ang)))
        half = named(half, f"g{i}_", tape)
        place = (
            plus(plus(scaled(M, linear), cross(angular, m)), plus(cross(turn, lin), fz)),
            plus(plus(body.times(angular), cross(m, linear)), plus(half, nz)),
        )
        speed = (
            plus(plus(scaled(M, slide), cross(turn, m)), z_lin),
            plus(plus(body.times(turn), cross(m, slide)), plus(column, z_ang)),
        )
        inertia: Screw = ((-my, mx, sp.S.Zero), (body.J[0][2], body.J[1][2], body.J[2][2]))
        couple: Screw = (ZERO, plus(column, scaled(sp.S.NegativeOne, z_ang)))
    else:
        place = (scaled(M, linear), plus(cross(m, linear), fz))
        speed = (scaled(M, slide), cross(m, slide))
        inertia = ((sp.S.Zero, sp.S.Zero, M), (my, -mx, sp.S.Zero))
        couple = (ZERO, (2 * lin[1], -2 * lin[0], sp.S.Zero))
    out = [
        (named(force_, f"f{letter}{i}_", tape), named(moment, f"n{letter}{i}_", tape))
        for letter, (force_, moment) in (("p", place), ("q", speed), ("m", inertia), ("u", couple))
    ]
    return out[0], out[1], out[2], out[3]
