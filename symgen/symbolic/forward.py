"""Forward dynamics: M qdd = tau - h by M = L^T D L, without square roots, or by recursion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symgen.symbolic.articulated import linear_solution
from symgen.symbolic.constraints import ByJoint, Rows, combined
from symgen.symbolic.dynamics import (
    Plant,
    bias,
    bias_torque,
    friction_torques,
    mass_matrix,
    weighted_effects,
)
from symgen.symbolic.kinematics import base_inputs, path, variables

#: Number of joints in one chain from which articulated bodies need fewer steps than the factored
#: mass matrix. The factor keeps the zeros of branches.
MANY = 14


def accelerating_torque(p: Plant) -> tuple[ByJoint, list[sp.Expr]]:
    """Return M qdd of every movable joint, and the terms that must be positive for a unique value.

    The equations of a free base come first, with the wrench on it.

    The load effects are z (a taur + b |taur|), where a and b depend on the motion. With R = tau -
    friction = (1 + z a) taur + z b |taur|, the solution is taur = R / (1 + z a + z b sign(R)). It
    is unique if the denominator is positive for both signs.
    """
    tape, order, wrench = p.tape, p.numbers, dict(base_inputs(p.robot)).get("wrench", ())
    commanded = dict(zip(p.robot.free, wrench, strict=True)) | variables(p.robot, "tau")
    if not p.robot.loaded:
        known = bias_torque(p)
        return {j: tape.name(f"b{j}", tau - known[j]) for j, tau in commanded.items()}, []
    rigid, rubbing = bias(p), friction_torques(p)
    slopes = []  # of the effects by taur, for taur > 0 and for taur < 0
    for sign in (sp.S.One, sp.S.NegativeOne):
        columns = weighted_effects(p, dict.fromkeys(order, sign))
        slope = combined((sign * coefficient, column) for coefficient, column in columns)
        slopes.append({j: tape.name(f"e{j}", value) for j, value in slope.items()})
    right, positive = {}, []
    for j, tau in commanded.items():
        load = tape.name(f"R{j}", tau - rubbing.get(j, sp.S.Zero))
        if j in slopes[0] or j in slopes[1]:
            up, down = (s.get(j, sp.S.Zero) for s in slopes)
            half = sp.Rational(1, 2)
            mean, spread_ = (
                tape.name(f"{n}{j}", half * e) for n, e in (("a", up + down), ("B", up - down))
            )
            turned_ = tape.name(f"G{j}", sp.sign(load))
            share = tape.name(f"E{j}", 1 + mean + spread_ * turned_)
            positive += [tape.name(f"P{j}", 1 + e) for e in (up, down)]
            load = load * tape.name(f"I{j}", 1 / share)
        right[j] = tape.name(f"b{j}", load - rigid[j])
    return right, positive


def forward_dynamics(p: Plant) -> tuple[ByJoint, list[sp.Expr], list[sp.Expr]]:
    """Return (qdd, (f, wd) of a free base, pivots).

    M is positive definite if and only if all pivots of L D L^T are.

    `pivots` also contains the terms that must be positive for load effects (see
    `accelerating_torque`). Long chains use the articulated-body algorithm (`articulated`).
    """
    right, positive = accelerating_torque(p)
    longest = max((len(path(p.robot, number)) for number in p.numbers), default=0)
    plain = len(p.robot.moving) == p.robot.n and not p.robot.couplings and not p.robot.floating
    if longest >= MANY and plain:
        qdd, pivots = linear_solution(p, right)
        return qdd, [], [*positive, *pivots]
    factor = factored(p, mass_matrix(p))
    qdd = factor_solution(p, factor, right, "o")
    base = [qdd.pop(j) for j in p.robot.free]
    return qdd, base, [*positive, *factor.pivots]


def solve_mass_matrix(p: Plant) -> tuple[ByJoint, list[sp.Expr]]:
    """Return (x, pivots) of M x = b."""
    factor = factored(p, mass_matrix(p))
    x = factor_solution(p, factor, variables(p.robot, "b"), "o")
    return x, list(factor.pivots)


def mass_matrix_factor(p: Plant) -> tuple[Rows, list[sp.Expr], list[sp.Expr]]:
    """Return L (entries by rows, without zeros) and D of M = L D L^T, and D as the pivots."""
    factor = factored(p, mass_matrix(p))
    rows: Rows = {j: {j: sp.S.One} for j in p.equations}
    for (k, i), value in factor.low.items():
        rows[i][k] = value
    return rows, list(reversed(factor.pivots)), list(factor.pivots)


@dataclass(frozen=True)
class MassFactor:
    """M = L^T D L with ones on the diagonal of L.

    Attributes:
        low: nonzero entries L(k, i), i < k.
        inverse: 1 / D(k).
        pivots: D in the order of the elimination, from the tips. After a pivot that is not
            positive, the others are meaningless.
    """

    low: Mapping[tuple[int, int], sp.Expr]
    inverse: ByJoint
    pivots: tuple[sp.Expr, ...]


def factored(p: Plant, M: Rows) -> MassFactor:
    """Factor a mass matrix from the tips: L keeps the zeros of branches (Featherstone 2005)."""
    rows = {j: dict(row) for j, row in M.items()}
    tape, order = p.tape, p.equations
    low: dict[tuple[int, int], sp.Expr] = {}
    pivots, inverse = [], {}
    for at, k in enumerate(reversed(order)):
        earlier = order[: len(order) - 1 - at]
        pivots.append(rows[k].get(k, sp.S.Zero))
        inverse[k] = tape.name(f"d{k}", 1 / pivots[-1])
        for i in earlier:
            if rows[k].get(i, sp.S.Zero) != 0:
                low[k, i] = tape.name(f"l{k}_{i}", rows[k][i] * inverse[k])
        for i in earlier:
            if (k, i) not in low:
                continue
            for j in order[: order.index(i) + 1]:
                if (k, j) in low:
                    value = rows[i].get(j, sp.S.Zero) - low[k, i] * rows[k][j]
                    rows[i][j] = rows[j][i] = tape.name(f"m{k}_{i}_{j}", value)
    return MassFactor(low, inverse, tuple(pivots))


def factor_solution(p: Plant, factor: MassFactor, right: ByJoint, letter: str) -> ByJoint:
    """Solve M x = right: L^T y = right from the tips, then D, then L from the base."""
    tape, order, low = p.tape, p.equations, factor.low
    y = dict(right)
    for k in reversed(order):
        for i in order:
            if (k, i) in low:
                y[i] = tape.name(f"y{k}_{i}", y[i] - low[k, i] * y[k])
    out: ByJoint = {}
    for k in order:
        known = (-low[k, i] * out[i] for i in order if (k, i) in low)
        out[k] = tape.name(f"{letter}{k}", sp.Add(y[k] * factor.inverse[k], *known))
    return out
