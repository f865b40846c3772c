"""Linear relations between energy columns that hold by structure, in closed form.

A relation is a combination of standard parameters that no motion can show: sum of n_k h_k = const.
The rules are those of Gautier and Khalil (1988, 1990), stated for bodies: a body on link j that
the motion of joint j leaves as it is, is a body on the antecedent of j.

* revolute j: a mass at the origin (M), a moment along z (MZ), and XX = YY: 3 relations;
* prismatic j: a body without mass and moment, of which only the orientation counts (XX..ZZ): 6;
* fixed j: any body: 10;
* as long as every rotation so far keeps one direction a (links before the second revolute axis
  that is not parallel to the first), the moment along a moves no energy: a . (MX, MY, MZ).
"""

from __future__ import annotations

import sympy as sp

from symgen import names
from symgen.robot.types import Joint, Robot
from symgen.symbolic.kinematics import cosine_sine

Relation = dict[str, sp.Expr]
Matrix = list[list[sp.Expr]]


def structural_relations(robot: Robot) -> list[Relation]:
    """Return the relations of all joints, from the base to the tips, then those of the payload."""
    found: list[Relation] = []
    # Direction, in each link, that all rotations so far keep: [] for none yet, None for several.
    direction: dict[int, list[sp.Expr] | None] = {0: []}
    for joint in robot.joints:
        rotation, position = _placement(joint)
        found += [_moved(joint, body, rotation, position) for body in _kept_bodies(joint)]
        here = _carried(joint, direction[joint.antecedent], rotation)
        direction[joint.number] = here
        if here and joint.sigma == names.PRISMATIC:
            found.append(
                {f"{m}{joint.number}": a for m, a in zip(names.MOMENT, here, strict=True) if a != 0}
            )
    if robot.payload is not None:
        found += [
            {f"{prefix}L": sp.S.One, f"{prefix}{robot.payload}": sp.S.NegativeOne}
            for prefix in names.LINK
        ]
    return found


def _placement(joint: Joint) -> tuple[Matrix, list[sp.Expr]]:
    """Return rotation and origin of frame j in its antecedent at q = 0."""
    cg, sg = cosine_sine(joint.gamma)
    ca, sa = cosine_sine(joint.alpha)
    ct, st = cosine_sine(joint.theta)
    about_z: Matrix = [[cg, -sg, sp.S.Zero], [sg, cg, sp.S.Zero], [sp.S.Zero, sp.S.Zero, sp.S.One]]
    rotation = _product(
        about_z, [[ct, -st, sp.S.Zero], [ca * st, ca * ct, -sa], [sa * st, sa * ct, ca]]
    )
    x, y, z = joint.d, -sa * joint.r, ca * joint.r + joint.b
    return rotation, [cg * x - sg * y, sg * x + cg * y, z]


def _carried(joint: Joint, axis: list[sp.Expr] | None, rotation: Matrix) -> list[sp.Expr] | None:
    """Carry the common direction of rotation from the antecedent into frame j."""
    if axis is None:
        return None
    if axis == []:
        return [sp.S.Zero, sp.S.Zero, sp.S.One] if joint.sigma == names.REVOLUTE else []
    turned = [sum((rotation[i][k] * axis[i] for i in range(3)), sp.S.Zero) for k in range(3)]
    if joint.sigma != names.REVOLUTE:
        return turned
    parallel = turned[0] == 0 and turned[1] == 0
    return turned if parallel else None


def _kept_bodies(joint: Joint) -> list[dict[str, int]]:
    """Return the bodies on link j that a motion of joint j does not change."""
    if joint.sigma == names.REVOLUTE:
        return [{"XX": 1, "YY": 1}, {"MZ": 1}, {"M": 1}]
    if joint.sigma == names.PRISMATIC:
        return [{prefix: 1} for prefix in names.INERTIA]
    return [{prefix: 1} for prefix in names.LINK]


def _moved(
    joint: Joint, body: dict[str, int], rotation: Matrix, position: list[sp.Expr]
) -> Relation:
    """Return body on link j minus the same body on its antecedent (nothing on the base)."""
    out: Relation = {f"{prefix}{joint.number}": sp.Integer(v) for prefix, v in body.items()}
    if joint.antecedent == 0:
        return out
    for prefix, value in transported(body, rotation, position).items():
        if value != 0:
            out[f"{prefix}{joint.antecedent}"] = -value
    return out


def transported(body: dict[str, int], R: Matrix, P: list[sp.Expr]) -> dict[str, sp.Expr]:
    """Return the ten parameters of a body in another frame: Huygens and Steiner.

        J' = R J R^T - [m]x [P]x - [P]x [m]x - M [P]x [P]x,   MS' = m + M P,   m = R MS

    Args:
        body: the nonzero parameters about the origin of frame j, in frame j.
        R: rotation (3, 3) from frame j to the other frame.
        P: origin (3,) of frame j in the other frame, m.
    """
    full = {prefix: sp.Integer(body.get(prefix, 0)) for prefix in names.LINK}
    J = [
        [full["XX"], full["XY"], full["XZ"]],
        [full["XY"], full["YY"], full["YZ"]],
        [full["XZ"], full["YZ"], full["ZZ"]],
    ]
    mass = full["M"]
    m = [sum((R[i][k] * full[names.MOMENT[k]] for k in range(3)), sp.S.Zero) for i in range(3)]
    turned = _product(_product(R, J), [list(row) for row in zip(*R, strict=True)])
    dot = sum((m[i] * P[i] for i in range(3)), sp.S.Zero)
    square = sum((P[i] * P[i] for i in range(3)), sp.S.Zero)
    out: dict[str, sp.Expr] = {}
    for i in range(3):
        for k in range(i, 3):
            # -[m]x[P]x - [P]x[m]x = 2 (m.P) I - m P^T - P m^T, and -[P]x[P]x = (P.P) I - P P^T
            steiner = -m[i] * P[k] - P[i] * m[k] - mass * P[i] * P[k]
            if i == k:
                steiner += 2 * dot + mass * square
            out["XYZ"[i] + "XYZ"[k]] = sp.expand(turned[i][k] + steiner)
    for i, prefix in enumerate(names.MOMENT):
        out[prefix] = sp.expand(m[i] + mass * P[i])
    out[names.MASS] = mass
    return out


def _product(A: Matrix, B: Matrix) -> Matrix:
    return [
        [sum((A[i][k] * B[k][j] for k in range(3)), sp.S.Zero) for j in range(3)] for i in range(3)
    ]
