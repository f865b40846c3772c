"""Articulated bodies: M x = b solved joint by joint, with a number of steps linear in the joints.

The bodies behind a joint, free to move in their own joints, answer a motion (dw, dv) of the link's
frame with the wrench

    n = J dw + H dv + n0,      f = H^T dw + M dv + f0

(Featherstone 2008, Rigid Body Dynamics Algorithms, ch. 7). Speeds and gravity are in b already, so
that n0 and f0 are of the right-hand sides alone. What a joint leaves of its own body,

    I - U U^T / D,   U = I s,   D = s^T U + rotor inertia,

goes on to the link before. D are the pivots of M eliminated from the tips.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.bodies import Inertia, dot, named, plus, scaled
from symgen.symbolic.dynamics import Plant, rotors
from symgen.symbolic.kinematics import ZERO, Shift, Step, Turn, Vector, returned, shifted, turned
from symgen.symbolic.tape import TapeBuilder

Matrix = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Articulated:
    """J, H and M of an articulated body, rows of them, and its wrench at rest (n, f)."""

    J: Matrix
    H: Matrix
    M: Matrix
    n: Vector
    f: Vector

    def plus(self, other: Articulated, tag: str, tape: TapeBuilder) -> Articulated:
        """Return both bodies as one."""

        def both(letter: str, a: Matrix, b: Matrix, alike: bool) -> Matrix:
            out = [list(line) for line in a]
            for i in range(3):
                for k in range(i if alike else 0, 3):
                    out[i][k] = tape.name(f"{letter}{tag}{i + 1}{k + 1}", a[i][k] + b[i][k])
                    if alike:
                        out[k][i] = out[i][k]
            return _matrix(out)

        return Articulated(
            both("aJ", self.J, other.J, alike=True),
            both("aH", self.H, other.H, alike=False),
            both("aM", self.M, other.M, alike=True),
            named(plus(self.n, other.n), f"an{tag}", tape),
            named(plus(self.f, other.f), f"af{tag}", tape),
        )

    def before(self, motion: Turn | Shift, tape: TapeBuilder) -> Articulated:
        """Return the body in the frame before an elementary motion."""
        if isinstance(motion, Turn):
            half = _transposed(_rows(self.H, motion, "ah", tape))
            return Articulated(
                _symmetric(self.J, motion, "aJ", tape),
                _transposed(_rows(half, motion, "aH", tape)),
                _symmetric(self.M, motion, "aM", tape),
                returned(self.n, motion, "an", tape),
                returned(self.f, motion, "af", tape),
            )
        return self._shifted(motion, tape)

    def _shifted(self, motion: Shift, tape: TapeBuilder) -> Articulated:
        """H' = H + [P] M, J' = J - H [P] + [P] H'^T, n' = n + P x f, of P along an axis."""
        b, c, length = (motion.axis + 1) % 3, (motion.axis + 2) % 3, motion.length
        H = [list(row) for row in self.H]
        for k in range(3):
            H[b][k] = tape.name(f"aH{b + 1}{k + 1}{motion.tag}", H[b][k] - length * self.M[c][k])
            H[c][k] = tape.name(f"aH{c + 1}{k + 1}{motion.tag}", H[c][k] + length * self.M[b][k])
        J = [list(row) for row in self.J]
        for i in range(3):
            for k in range(i, 3):
                value = J[i][k]
                value += length * {b: -self.H[i][c], c: self.H[i][b]}.get(k, sp.S.Zero)
                value += length * {b: -H[k][c], c: H[k][b]}.get(i, sp.S.Zero)
                J[i][k] = J[k][i] = tape.name(f"aJ{i + 1}{k + 1}{motion.tag}", value)
        n = list(self.n)
        n[b] = tape.name(f"an{b + 1}{motion.tag}", n[b] - length * self.f[c])
        n[c] = tape.name(f"an{c + 1}{motion.tag}", n[c] + length * self.f[b])
        return Articulated(_matrix(J), _matrix(H), self.M, (n[0], n[1], n[2]), self.f)


def _matrix(rows: list[list[sp.Expr]]) -> Matrix:
    x, y, z = ((row[0], row[1], row[2]) for row in rows)
    return (x, y, z)


def _transposed(a: Matrix) -> Matrix:
    x, y, z = ((a[0][k], a[1][k], a[2][k]) for k in range(3))
    return (x, y, z)


def _rows(a: Matrix, motion: Turn, letter: str, tape: TapeBuilder) -> Matrix:
    """Return R a, the columns of a in the frame before a turn."""
    x, y, z = (
        returned(column, motion, f"{letter}{k + 1}", tape)
        for k, column in enumerate(_transposed(a))
    )
    return _transposed((x, y, z))


def _symmetric(a: Matrix, motion: Turn, letter: str, tape: TapeBuilder) -> Matrix:
    """Return R a R^T of a symmetric matrix; the trace of the turned block stays."""
    k, i, h = motion.axis, (motion.axis + 1) % 3, (motion.axis + 2) % 3
    out = [list(row) for row in a]

    def name(row: int, column: int, value: sp.Expr) -> sp.Expr:
        return tape.name(f"{letter}{row + 1}{column + 1}{motion.tag}", value)

    first = name(6, i, motion.c * a[i][i] - motion.s * a[i][h])
    second = name(6, h, motion.c * a[i][h] - motion.s * a[h][h])
    out[i][i] = name(i, i, motion.c * first - motion.s * second)
    out[i][h] = out[h][i] = name(i, h, motion.s * first + motion.c * second)
    out[h][h] = name(h, h, a[i][i] + a[h][h] - out[i][i])
    out[i][k] = out[k][i] = name(i, k, motion.c * a[i][k] - motion.s * a[h][k])
    out[h][k] = out[k][h] = name(h, k, motion.s * a[i][k] + motion.c * a[h][k])
    return _matrix(out)


def rigid(body: Inertia) -> Articulated:
    """Return one link: H = [m] x."""
    m = body.m
    J, H, M = (
        _matrix([list(row) for row in rows])
        for rows in (
            body.J,
            ((sp.S.Zero, -m[2], m[1]), (m[2], sp.S.Zero, -m[0]), (-m[1], m[0], sp.S.Zero)),
            [[body.M if i == k else sp.S.Zero for k in range(3)] for i in range(3)],
        )
    )
    return Articulated(J, H, M, ZERO, ZERO)


@dataclass(frozen=True)
class _Joint:
    """U = (n, f) in the frame of the link, 1 / D, and (right-hand side - s^T p) / D."""

    n: Vector
    f: Vector
    inverse: sp.Expr
    driven: sp.Expr


def linear_solution(
    p: Plant, right: Mapping[int, sp.Expr]
) -> tuple[dict[int, sp.Expr], list[sp.Expr]]:
    """Return x of M x = right by joint, and the pivots, from the tips.

    Args:
        p: without couplings and joints that follow others: these tie joints of separate bodies.
        right: by joint.
    """
    tape, rotor = p.tape, rotors(p)
    bodies = {j.number: rigid(p.inertia(j.number)) for j in p.robot.joints}
    joints: dict[int, _Joint] = {}
    pivots = []
    for step in reversed(p.way):
        j, a, body = step.joint.number, step.joint.antecedent, bodies[step.joint.number]
        if step.joint.sigma != names.FIXED:
            pivot, joints[j], body = _released(p, step, body, rotor[j][j], right[j])
            pivots.append(pivot)
        if a != 0:
            for motion in reversed((*step.before, *step.after)):
                body = body.before(motion, tape)
            bodies[a] = bodies[a].plus(body, f"{a}_{j}_", tape)
    return _accelerated(p, joints), pivots


def _released(
    p: Plant, step: Step, body: Articulated, rotor: sp.Expr, right: sp.Expr
) -> tuple[sp.Expr, _Joint, Articulated]:
    """Let a joint go: the pivot, what it takes, and what is left of its body."""
    tape, j = p.tape, step.joint.number
    turns = step.joint.sigma == names.REVOLUTE
    n, f = (body.J[2], body.H[2]) if turns else (_transposed(body.H)[2], body.M[2])
    pivot = (n[2] if turns else f[2]) + rotor
    inverse = tape.name(f"d{j}", 1 / pivot)
    driven = tape.name(f"y{j}", (right - (body.n[2] if turns else body.f[2])) * inverse)
    un, uf = (named(scaled(inverse, v), f"u{x}{j}_", tape) for v, x in ((n, "n"), (f, "f")))

    def less(letter: str, a: Matrix, column: Vector, row: Vector, alike: bool) -> Matrix:
        out = [list(line) for line in a]
        for i in range(3):
            for k in range(i if alike else 0, 3):
                value = a[i][k] - column[i] * row[k]
                out[i][k] = tape.name(f"{letter}{j}l{i + 1}{k + 1}", value)
                if alike:
                    out[k][i] = out[i][k]
        return _matrix(out)

    left = Articulated(
        less("aJ", body.J, un, n, alike=True),
        less("aH", body.H, un, f, alike=False),
        less("aM", body.M, uf, f, alike=True),
        named(plus(body.n, scaled(driven, n)), f"an{j}l", tape),
        named(plus(body.f, scaled(driven, f)), f"af{j}l", tape),
    )
    return pivot, _Joint(un, uf, inverse, driven), left


def _accelerated(p: Plant, joints: Mapping[int, _Joint]) -> dict[int, sp.Expr]:
    """Go back out: the motion of each link, and with it that of its joint."""
    tape, out = p.tape, dict[int, sp.Expr]()
    motions: dict[int, tuple[Vector, Vector]] = {0: (ZERO, ZERO)}
    for step in p.way:
        j = step.joint.number
        w, v = motions[step.joint.antecedent]
        for motion in (*step.before, *step.after):
            if isinstance(motion, Turn):
                w, v = turned(w, motion, "ow", tape), turned(v, motion, "ov", tape)
            else:
                v = shifted(v, w, motion, "ov", tape)
        if j in joints:
            own = joints[j]
            out[j] = tape.name(f"o{j}", own.driven - dot(own.n, w) - dot(own.f, v))
            if step.joint.sigma == names.REVOLUTE:
                w = (w[0], w[1], tape.name(f"ow{j}", w[2] + out[j]))
            else:
                v = (v[0], v[1], tape.name(f"ov{j}", v[2] + out[j]))
        motions[j] = (w, v)
    return out
