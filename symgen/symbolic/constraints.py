"""Joints that follow others: rates and torques of the movable joints and of the tree.

The variables q_k of the movable joints give every joint of the tree by q_j = sum of G_jk q_k + c_j
with constant G. By virtual work, torques on the tree belong to tau = G^T tau_tree, a mass or
Coriolis matrix to G^T M_tree G, and a Jacobian to J_tree G (Khalil and Dombre 2002, ch. 10).
Without such joints G is the identity and nothing is added to the tape.
"""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from symgen.robot.types import Joint, Robot
from symgen.symbolic.tape import TapeBuilder

#: Values by joint number, and matrices by rows and columns of joint numbers.
ByJoint = dict[int, sp.Expr]
Rows = dict[int, ByJoint]


def followed(joint: Joint, values: ByJoint, tape: TapeBuilder) -> sp.Expr:
    """Return the sum of G_jk values_k for one joint, or its value if it follows none."""
    return sum((c * values[k] for k, c in _shares(joint, tape) if k in values), sp.S.Zero)


def spread(robot: Robot, values: ByJoint, tape: TapeBuilder) -> ByJoint:
    """Return G values: the rates of all moving joints from those of the movable joints."""
    return {j.number: followed(j, values, tape) for j in robot.moving}


def to_variables(robot: Robot, by_joint: ByJoint, name: str, tape: TapeBuilder) -> ByJoint:
    """Return G^T by_joint: torques on the variables from torques on the joints of the tree."""
    if len(robot.moving) == robot.n:
        return dict(by_joint)
    base = {k: by_joint[k] for k in robot.free if k in by_joint}
    acting = (joint for joint in robot.moving if joint.number in by_joint)
    out = combined((by_joint[joint.number], dict(_shares(joint, tape))) for joint in acting)
    return base | {k: tape.name(f"{name}_{k}", value) for k, value in out.items()}


def combined(columns: Iterable[tuple[sp.Expr, ByJoint]]) -> ByJoint:
    """Return the sum of columns by joint, each with its coefficient in front."""
    out: ByJoint = {}
    for coefficient, column in columns:
        for j, value in column.items():
            add_to(out, j, coefficient * value)
    return out


def add_to(sums: ByJoint, j: int, value: sp.Expr) -> None:
    """Add a value to the sum of a joint; an absent one is zero."""
    sums[j] = sums.get(j, sp.S.Zero) + value


def congruent(robot: Robot, rows: Rows, name: str, tape: TapeBuilder) -> Rows:
    """Return G^T rows G of a matrix over the joints of the tree."""
    if len(robot.moving) == robot.n:
        return rows
    half = {j: to_variables(robot, row, f"{name}r{j}", tape) for j, row in rows.items()}
    out: Rows = {k: {} for k in robot.equations}
    for k in out:
        column = {j: row[k] for j, row in half.items() if k in row}
        for j, value in to_variables(robot, column, f"{name}c{k}", tape).items():
            out[j][k] = value
    return out


def _shares(joint: Joint, tape: TapeBuilder) -> list[tuple[int, sp.Expr]]:
    return [(k, tape.constant(f"G{joint.number}_{k}", c)) for k, c in joint.shares]
