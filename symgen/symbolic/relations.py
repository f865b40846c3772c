"""Linear relations between energy columns that hold by structure, in closed form.

A relation is a combination of energy columns that is constant in every motion: sum of n_k h_k =
const. The rules are those of Gautier and Khalil (1988, 1990), for bodies. If the motion of joint j
does not change a body on link j, the body can also belong to the antecedent of j.

* revolute j: a mass at the origin (M), a moment along z (MZ), and XX = YY: 3 relations;
* prismatic j: a body without mass and moment, of which only the orientation counts (XX..ZZ): 6;
* fixed j: any body: 10;
* as long as every rotation so far keeps one direction a (links before the second revolute axis
  that is not parallel to the first), the moment along a moves no energy: a . (MX, MY, MZ). A base
  with an IMU keeps no direction.

A body that belongs to the base has no energy, unless the base is free: it is then one of link 0.
"""

from __future__ import annotations

import sympy as sp

from symgen import names
from symgen.robot.types import Joint, Robot
from symgen.symbolic.bodies import Inertia
from symgen.symbolic.kinematics import cosine_sine, elementary
from symgen.symbolic.spatial import Shift, Turn, Vector, Z, turned
from symgen.symbolic.tape import TapeBuilder

Relation = dict[str, sp.Expr]
_Way = tuple[Turn | Shift, ...]


class _Formulas(TapeBuilder):
    """A tape builder that does not name steps, so results stay formulas."""

    def constant(self, _: str, value: sp.Expr) -> sp.Expr:
        return value

    def name(self, _: str, expr: sp.Expr) -> sp.Expr:
        return expr if expr.is_Atom else sp.expand(expr)


def structural_relations(robot: Robot) -> list[Relation]:
    """Return the relations of all joints, from the base to the tips, then those of the payload."""
    found: list[Relation] = []
    # Direction in each link that all rotations so far keep: () before a rotation, None without one.
    direction: dict[int, Vector | None] = {0: None if robot.imu else ()}
    for joint in robot.joints:
        c, s = cosine_sine(joint.theta)
        before, after = elementary(joint, c, s, joint.r, _Formulas())  # at q = 0
        found += [
            _moved(joint, body, (*before, *after), robot.floating) for body in _kept_bodies(joint)
        ]
        here = _kept_direction(joint, direction[joint.antecedent], before)
        direction[joint.number] = here
        if here and joint.slides:
            found.append(
                {f"{m}{joint.number}": a for m, a in zip(names.MOMENT, here, strict=True) if a != 0}
            )
    if robot.payload is not None:
        found += [
            {f"{prefix}L": sp.S.One, f"{prefix}{robot.payload}": sp.S.NegativeOne}
            for prefix in names.LINK
        ]
    return found


def _kept_direction(joint: Joint, axis: Vector | None, way: _Way) -> Vector | None:
    """Express the common direction of rotation of the antecedent in frame j."""
    if axis is None:
        return None
    if axis == ():
        return Z if joint.turns else ()
    for motion in way:
        if isinstance(motion, Turn):
            axis = turned(axis, motion, "", _Formulas())
    parallel = axis[0] == 0 and axis[1] == 0
    return axis if parallel or not joint.turns else None


def _kept_bodies(joint: Joint) -> list[dict[str, int]]:
    """Return the bodies on link j that a motion of joint j does not change."""
    if joint.turns:
        return [{"XX": 1, "YY": 1}, {"MZ": 1}, {"M": 1}]
    if joint.slides:
        return [{prefix: 1} for prefix in names.INERTIA]
    return [{prefix: 1} for prefix in names.LINK]


def _moved(joint: Joint, body: dict[str, int], way: _Way, floating: bool) -> Relation:
    """Return a body on link j minus the same body on its antecedent (nothing on a base)."""
    moved = Inertia.of({prefix: sp.Integer(value) for prefix, value in body.items()})
    out = {f"{prefix}{joint.number}": v for prefix, v in moved.parameters.items() if v != 0}
    if joint.antecedent == 0 and not floating:
        return out
    for motion in reversed(way):
        moved = moved.before(motion, joint.number, _Formulas())
    for prefix, value in moved.parameters.items():
        if value != 0:
            out[f"{prefix}{joint.antecedent}"] = -value
    return out
