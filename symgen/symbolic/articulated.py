"""Articulated bodies: solve M x = b joint by joint, with a number of steps linear in the joints.

The bodies behind a joint can move in their joints. A motion (dw, dv) of the link frame takes the
wrench

    n = J dw + H dv + n0,      f = H^T dw + M dv + f0

(Featherstone 2008, Rigid Body Dynamics Algorithms, ch. 7). b already contains speeds and gravity,
so n0 and f0 come from the right-hand sides alone. The previous link carries the body

    I - U U^T / D,   U = I s,   D = s^T U + rotor inertia.

D are the pivots of M in the elimination from the tips.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from symgen.symbolic.bodies import Inertia
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.dynamics import Plant, rotors
from symgen.symbolic.kinematics import Step
from symgen.symbolic.spatial import (
    UPPER,
    ZERO,
    Matrix,
    Screw,
    Shift,
    Turn,
    Vector,
    around,
    cross,
    dot,
    matrix,
    named,
    onward,
    plus,
    replaced,
    scaled,
    shift_moment,
    symmetric,
    transposed,
    turned,
    unit_vector,
)
from symgen.symbolic.tape import TapeBuilder


@dataclass(frozen=True)
class Articulated:
    """J, H and M of an articulated body, as rows, and its wrench at rest (n, f)."""

    J: Matrix
    H: Matrix
    M: Matrix
    n: Vector
    f: Vector

    def plus(self, other: Articulated, tag: str, tape: TapeBuilder) -> Articulated:
        """Return both bodies as one."""

        def both(letter: str, a: Matrix, b: Matrix, alike: bool = True) -> Matrix:
            return _named(f"{letter}{tag}", lambda i, k: a[i][k] + b[i][k], alike, tape)

        return Articulated(
            both("aJ", self.J, other.J),
            both("aH", self.H, other.H, alike=False),
            both("aM", self.M, other.M),
            named(plus(self.n, other.n), f"an{tag}", tape),
            named(plus(self.f, other.f), f"af{tag}", tape),
        )

    def before(self, motion: Turn | Shift, tape: TapeBuilder) -> Articulated:
        """Return the body in the frame before an elementary motion."""
        if isinstance(motion, Shift):
            return self._shifted(motion, tape)
        half = transposed(_rows(self.H, motion, "ah", tape))
        return Articulated(
            _symmetric(self.J, motion, "aJ", tape),
            transposed(_rows(half, motion, "aH", tape)),
            _symmetric(self.M, motion, "aM", tape),
            turned(self.n, motion.back, "an", tape),
            turned(self.f, motion.back, "af", tape),
        )

    def _shifted(self, motion: Shift, tape: TapeBuilder) -> Articulated:
        """H' = H + [P] M, J' = J - H [P] + [P] H'^T, n' = n + P x f, of P along an axis."""
        (b, c), length, M = around(motion.axis), motion.length, self.M
        H = [list(row) for row in self.H]
        for k in range(3):
            H[b][k] = tape.entry(H[b][k] - length * M[c][k], "aH", motion.tag, b, k)
            H[c][k] = tape.entry(H[c][k] + length * M[b][k], "aH", motion.tag, c, k)
        J = {}
        for i, k in UPPER:
            value = self.J[i][k] + length * {b: -self.H[i][c], c: self.H[i][b]}.get(k, sp.S.Zero)
            value += length * {b: -H[k][c], c: H[k][b]}.get(i, sp.S.Zero)
            J[i, k] = tape.entry(value, "aJ", motion.tag, i, k)
        n = shift_moment(self.n, self.f, motion.back, "an", tape)
        return Articulated(symmetric(J), matrix(lambda i, k: H[i][k]), M, n, self.f)


def _named(
    name: str, entry: Callable[[int, int], sp.Expr], alike: bool, tape: TapeBuilder
) -> Matrix:
    """Name the entries of a matrix; for a symmetric one (`alike`), those on one side only."""

    def named_entry(i: int, k: int) -> sp.Expr:
        return tape.entry(entry(i, k), name, "", i, k)

    return symmetric({at: named_entry(*at) for at in UPPER}) if alike else matrix(named_entry)


def _rows(a: Matrix, motion: Turn, letter: str, tape: TapeBuilder) -> Matrix:
    """Return R a, the columns of a in the frame before a turn."""
    columns = enumerate(transposed(a))
    return transposed(
        tuple(turned(column, motion.back, f"{letter}{k + 1}", tape) for k, column in columns)
    )


def _symmetric(a: Matrix, motion: Turn, letter: str, tape: TapeBuilder) -> Matrix:
    """Return R a R^T of a symmetric matrix; the trace of the turned block does not change."""
    k, (i, h), c, s = motion.axis, around(motion.axis), motion.c, motion.s

    def name(row: int, column: int, value: sp.Expr) -> sp.Expr:
        return tape.entry(value, letter, motion.tag, row, column)

    first = name(6, i, c * a[i][i] - s * a[i][h])
    second = name(6, h, c * a[i][h] - s * a[h][h])
    out = {(k, k): a[k][k], (i, i): name(i, i, c * first - s * second)}
    out[i, h] = name(i, h, s * first + c * second)
    out[h, h] = name(h, h, a[i][i] + a[h][h] - out[i, i])
    out[i, k] = name(i, k, c * a[i][k] - s * a[h][k])
    out[h, k] = name(h, k, s * a[i][k] + c * a[h][k])
    return symmetric(out)


def rigid(body: Inertia) -> Articulated:
    """Return one link: H = [m] x."""
    H = matrix(lambda i, k: cross(body.m, unit_vector(k))[i])
    M = matrix(lambda i, k: body.M if i == k else sp.S.Zero)
    return Articulated(body.J, H, M, ZERO, ZERO)


@dataclass(frozen=True)
class Driven:
    """U = (n, f) in the frame of the link, 1 / D, and (right-hand side - s^T p) / D."""

    n: Vector
    f: Vector
    inverse: sp.Expr
    driven: sp.Expr


def linear_solution(p: Plant, right: ByJoint) -> tuple[ByJoint, list[sp.Expr]]:
    """Return x of M x = right by joint, and the pivots, computed from the tips.

    Args:
        p: a robot without couplings and without joints that follow others.
        right: the right-hand side of each joint.
    """
    tape, rotor = p.tape, rotors(p)
    bodies = {j: rigid(body) for j, body in p.bodies.items()}
    joints: dict[int, Driven] = {}
    pivots = []
    for step in reversed(p.way):
        j, a, body = step.joint.number, step.joint.antecedent, bodies[step.joint.number]
        if not step.joint.fixed:
            pivot, joints[j], body = released(tape, step, body, rotor[j][j], right[j])
            pivots.append(pivot)
        if a != 0:
            for motion in reversed(step.way):
                body = body.before(motion, tape)
            bodies[a] = bodies[a].plus(body, f"{a}_{j}_", tape)
    return _accelerated(p, joints), pivots


def released(
    tape: TapeBuilder, step: Step, body: Articulated, rotor: sp.Expr, right: sp.Expr
) -> tuple[sp.Expr, Driven, Articulated]:
    """Return the pivot of a joint, its right-hand side, and the body that the previous link
    carries.
    """
    j, turns = step.joint.number, step.joint.turns
    n, f = (body.J[2], body.H[2]) if turns else (transposed(body.H)[2], body.M[2])
    pivot = (n[2] if turns else f[2]) + rotor
    inverse = tape.name(f"d{j}", 1 / pivot)
    driven = tape.name(f"y{j}", (right - (body.n[2] if turns else body.f[2])) * inverse)
    un, uf = (named(scaled(inverse, v), f"u{x}{j}_", tape) for v, x in ((n, "n"), (f, "f")))

    def less(letter: str, a: Matrix, column: Vector, row: Vector, alike: bool = True) -> Matrix:
        return _named(f"{letter}{j}l", lambda i, k: a[i][k] - column[i] * row[k], alike, tape)

    body_before = Articulated(
        less("aJ", body.J, un, n),
        less("aH", body.H, un, f, alike=False),
        less("aM", body.M, uf, f),
        named(plus(body.n, scaled(driven, n)), f"an{j}l", tape),
        named(plus(body.f, scaled(driven, f)), f"af{j}l", tape),
    )
    return pivot, Driven(un, uf, inverse, driven), body_before


def _accelerated(p: Plant, joints: Mapping[int, Driven]) -> ByJoint:
    """Return the acceleration of each joint, from the base to the tips."""
    out = ByJoint()
    twists: dict[int, Screw] = {0: (ZERO, ZERO)}
    for step in p.way:
        j, before = step.joint.number, twists[step.joint.antecedent]
        twists[j], found = accelerated(p.tape, step, joints.get(j), before)
        if found is not None:
            out[j] = found
    return out


def accelerated(
    tape: TapeBuilder, step: Step, driven: Driven | None, twist: Screw
) -> tuple[Screw, sp.Expr | None]:
    """Return the acceleration of a link and of its joint, from that of the previous link."""
    j = step.joint.number
    for motion in step.way:
        twist = onward(twist, motion, ("ow", "ov"), tape)
    if driven is None:
        return twist, None
    w, v = twist
    out = tape.name(f"o{j}", driven.driven - dot(driven.n, w) - dot(driven.f, v))
    if step.joint.turns:
        return (replaced(w, {2: tape.name(f"ow{j}", w[2] + out)}), v), out
    return (w, replaced(v, {2: tape.name(f"ov{j}", v[2] + out)})), out
