"""Bounds of the rounding errors of the Jacobian of a point of a link.

All errors are to first order, in units u of roundoff (Higham 2002, chapters 2 and 3). A turn keeps
the Frobenius norm of the errors of the axes, and adds those of its cosine and sine, of the products
and of the sum. A shift adds the error of the axis times its length. So

    axes      E = sum over the turns of sqrt(2) (e + 1 + sqrt(2))
    origins   rho (E + N + 3)
    z x r     rho (3 E + 2 N + 10)

bound the norms of the errors. e is the error of a cosine, N the number of shifts, and rho the sum
of their lengths, which no distance between two origins on the way exceeds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, Context

import sympy as sp

from symgen.robot.types import Joint, Robot
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.kinematics import by_joint, variables
from symgen.symbolic.placement import coordinates, links
from symgen.symbolic.tape import TapeBuilder, Values

#: Relative errors of a rounded constant, and of sin and cos (1.3 units in the last place), in u.
_CONSTANT, _FUNCTION = 1.0, 2.6


def unit_roundoff(tape: TapeBuilder) -> sp.Expr:
    """Return the unit roundoff of the numbers that run a tape, or its negative.

    4/3 is rounded, and all further operations are exact (Kahan; Higham 2002, problem 2.1).
    """
    third = tape.name("third", tape.constant("thirds", sp.Rational(4, 3)) - 1)
    return tape.name("roundoff", tape.name("epsilon", 3 * third - 1) / 2)


def jacobian_rounding(robot: Robot, tape: TapeBuilder, more: int) -> tuple[sp.Expr, sp.Expr]:
    """Return bounds of the errors of a row of velocity and of a row of turning, in u.

    They bound the Euclidean norm over the movable joints.

    Args:
        robot: the mechanism.
        tape: has q, the link and the point as inputs; receives the steps.
        more: errors from the use of a row, in u of the length of the row.
    """
    sizes = [tape.name(f"size{x}", sp.Abs(x)) for x in variables(robot).q]
    sums = _sums(robot)
    at = {0: _Way()}
    for joint in robot.joints:
        way = at[joint.antecedent]
        at[joint.number] = way.onward(joint, by_joint(robot, sizes), robot.values(), sums)
    ways = [at[joint.number] for joint in robot.joints]

    def chosen(name: str, values: Sequence[sp.Expr]) -> sp.Expr:
        if len(set(values)) == 1:
            return values[0]
        pairs = zip(links(robot), values, strict=True)
        return tape.name(name, sp.Add(*(a * tape.name(f"{name}{a}", v) for a, v in pairs)))

    points = (tape.name(f"size{c}", sp.Abs(c)) for c in coordinates("c"))
    reach = tape.name("reach", sp.Add(chosen("rho", [w.reach for w in ways]), *points))
    axes = chosen("axes", [w.axes + sums + more for w in ways])
    levers = chosen("levers", [3 * w.axes + 2 * w.shifts + 10 + 3 * sums + more for w in ways])
    turning = chosen("turning", [_up(math.hypot(*w.turning.values())) for w in ways])
    sliding = chosen("sliding", [_up(math.hypot(*w.sliding.values())) for w in ways])
    swung = tape.name("swung", reach * levers)
    return tape.name("offv", turning * swung + sliding * axes), tape.name("offw", turning * axes)


@dataclass(frozen=True)
class _Way:
    """The way from the base to a link.

    Attributes:
        axes: E.
        shifts: N, with the three coordinates of the point.
        reach: rho without the point, m.
        turning: sum of |dq_j/dq_k| over the revolute joints j of the way, by variable k.
        sliding: the same over the prismatic joints.
    """

    axes: sp.Expr = sp.S.Zero
    shifts: int = 3
    reach: sp.Expr = sp.S.Zero
    turning: Mapping[int, float] = field(default_factory=dict)
    sliding: Mapping[int, float] = field(default_factory=dict)

    def onward(self, joint: Joint, sizes: ByJoint, values: Values, sums: int) -> _Way:
        """Return the way to the link of the next joint.

        Args:
            joint: the joint.
            sizes: |q| of the movable joints.
            values: values of named lengths and angles.
            sums: roundings of a sum over joints.
        """

        def size(expr: sp.Expr) -> float:
            return abs(float(expr.subs(values)))

        shares = {k: size(c) for k, c in joint.shares}
        moved = sp.Add(*(_up(c) * sizes[k] for k, c in shares.items()))
        turn = joint.theta + (joint.offset if joint.turns else 0)
        slide = joint.r + (joint.offset if joint.slides else 0)
        axes = self.axes + sp.Add(
            *(_up(_turn(_CONSTANT)) for angle in (joint.gamma, joint.alpha) if not _quarter(angle))
        )
        turning, sliding = dict(self.turning), dict(self.sliding)
        for part in (turning,) if joint.turns else (sliding,) if joint.slides else ():
            part |= {k: part.get(k, 0.0) + c for k, c in shares.items()}
        if joint.turns:
            own = (0 if joint.movable else sums) + (0 if _quarter(turn) else 2)
            angle = moved + (0 if _quarter(turn) else _up(size(turn)))
            axes += _up(_turn(_FUNCTION)) + _up(math.sqrt(2) * own) * angle
        elif not _quarter(turn):
            axes += _up(_turn(_CONSTANT))
        lengths = [_up(size(length)) for length in (joint.b, joint.d, slide)]
        shifts = sum(length != 0 for length in lengths)
        if joint.slides:
            lengths.append(moved)
            shifts += slide == 0
        return _Way(axes, self.shifts + shifts, self.reach + sp.Add(*lengths), turning, sliding)


def _turn(error: float) -> float:
    return math.sqrt(2) * (error + 1 + math.sqrt(2))


def _quarter(angle: sp.Expr) -> bool:
    """Return whether cosine and sine of a constant angle are 0, 1 or -1."""
    return bool((2 * angle / sp.pi).is_Integer)


def _sums(robot: Robot) -> int:
    """Return the roundings of a sum over joints that follow others: constant, product, sums."""
    if len(robot.moving) == robot.n:
        return 0
    moved = [k for joint in robot.moving for k, _ in joint.shares]
    terms = [len(joint.shares) for joint in robot.moving]
    return 1 + max(*terms, *(moved.count(k) for k in moved))


def _up(number: float) -> sp.Expr:
    """Return a number rounded up to three digits."""
    return sp.Rational(str(Context(3, ROUND_CEILING).create_decimal_from_float(number)))
