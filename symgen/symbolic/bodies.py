"""Wrench and momentum of a body in the link frame, and composite bodies.

The motion of the frame is w, V, dw = dw/dt and a, the acceleration of the origin minus gravity. The
parameters J, m = (MX, MY, MZ), M have the wrench (f at the origin, n about it) (Khalil and Dombre,
ch. 9)

    f = M a + dw x m + w x (w x m),      n = J dw + w x (J w) + m x a

and the momentum   l = M V + w x m,      k = J w + m x V.

A composite body is a link and all links that it carries, as one body in the link frame. A rotation
about one axis by (c, s), with D = J_aa - J_bb and z = s D + 2 c J_ab, gives

    J_aa' = J_aa - s z,  J_bb' = J_bb + s z,  J_ab' = c z - J_ab

and a shift of the origin along one axis k by l (Huygens and Steiner) gives

    J_ii' = J_ii + 2 l m_k + M l^2 (i != k),  J_ki' = J_ki - l m_i,  m_k' = m_k + M l.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.kinematics import Way
from symgen.symbolic.motion import LinkState
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
    matrix,
    matvec,
    named,
    plus,
    replaced,
    scaled,
    symmetric,
    turned,
    vector,
)
from symgen.symbolic.tape import TapeBuilder

_HALF = sp.Rational(1, 2)


def products(w: Vector, j: int, tape: TapeBuilder) -> Matrix:
    """Name the products w_a w_b of a link: entry [a][b]."""
    return symmetric({(a, b): tape.entry(w[a] * w[b], "P", j, a, b) for a, b in UPPER})


def unit_wrench(prefix: str, motion: LinkState, j: int, tape: TapeBuilder) -> Screw:
    """Return (f, n) of a link with 1 for the parameter `prefix` and 0 for the others."""
    p, dw, a = products(motion.w, j, tape), motion.dw, motion.a
    if prefix == names.MASS:
        return a, ZERO
    if prefix in names.MOMENT:
        k = names.MOMENT.index(prefix)
        i, h = around(k)
        f = {
            k: -tape.entry(p[i][i] + p[h][h], "Q", j, k),
            i: tape.entry(p[k][i] + dw[h], "A", j, i, k),
            h: tape.entry(p[k][h] - dw[i], "A", j, h, k),
        }
        return replaced(ZERO, f), replaced(ZERO, {i: -a[h], h: a[i]})
    b, c = UPPER[names.INERTIA.index(prefix)]
    if b == c:
        i, h = around(b)
        return ZERO, replaced(ZERO, {b: dw[b], i: p[b][h], h: -p[b][i]})
    # J couples b and c; k is the third axis, and (b, c, k) or its mirror is right-handed.
    k = 3 - b - c
    sign = 1 if (c - b) % 3 == 1 else -1
    n = {
        b: tape.entry(dw[c] - sign * p[b][k], "A", j, b, c, k),
        c: tape.entry(dw[b] + sign * p[c][k], "A", j, c, b, k),
        k: tape.entry(sign * (p[b][b] - p[c][c]), "B", j, k),
    }
    return ZERO, replaced(ZERO, n)


@dataclass(frozen=True)
class Inertia:
    """J (3, 3), m (3,) and M of a body, symbols or numbers."""

    J: Matrix
    m: Vector
    M: sp.Expr

    @staticmethod
    def of(values: Mapping[str, sp.Expr]) -> Inertia:
        """Return the body with some parameters, by their prefixes; the others are zero."""
        J, m = (
            [values.get(x, sp.S.Zero) for x in group] for group in (names.INERTIA, names.MOMENT)
        )
        entries = dict(zip(UPPER, J, strict=True))
        return Inertia(symmetric(entries), tuple(m), values.get(names.MASS, sp.S.Zero))

    @property
    def parameters(self) -> dict[str, sp.Expr]:
        """The ten parameters by their prefixes, in their order."""
        entries = (*(self.J[i][k] for i, k in UPPER), *self.m, self.M)
        return dict(zip(names.LINK, entries, strict=True))

    def plus(self, other: Inertia, tag: str, tape: TapeBuilder) -> Inertia:
        """Return both bodies as one."""
        J = {
            (i, k): tape.entry(self.J[i][k] + other.J[i][k], "J", f"s{tag}", i, k) for i, k in UPPER
        }
        m = vector(lambda i: tape.entry(self.m[i] + other.m[i], "m", f"s{tag}", i))
        return Inertia(symmetric(J), m, tape.name(f"ms{tag}", self.M + other.M))

    def before(self, motion: Turn | Shift, j: int, tape: TapeBuilder) -> Inertia:
        """Return the body in the frame before an elementary motion."""
        J, m, k, tag = self.J, self.m, motion.axis, f"{motion.tag}_{j}"
        a, b = around(k)
        if isinstance(motion, Shift):
            length = motion.length
            ml = tape.name(f"w{tag}", self.M * length)
            extra = tape.name(f"x{tag}", length * (2 * m[k] + ml))
            new = {
                (a, a): J[a][a] + extra,
                (b, b): J[b][b] + extra,
                (a, b): J[a][b],
                (a, k): J[k][a] - length * m[a],
                (b, k): J[k][b] - length * m[b],
            }
        else:
            c, s = motion.c, motion.s
            if c == 0 or s == 0:  # quarter turns swap axes
                first, second = (b, a) if c == 0 else (a, b)
                new = {(a, a): J[first][first], (b, b): J[second][second]}
                new[a, b] = (c * c - s * s) * J[a][b]
            else:
                difference = tape.name(f"D{tag}", J[a][a] - J[b][b])
                twice = tape.name(f"T{tag}", 2 * J[a][b])
                z = tape.name(f"z{tag}", s * difference + c * twice)
                new = {(a, a): J[a][a] - s * z, (b, b): J[b][b] + s * z, (a, b): c * z - J[a][b]}
            new |= {(a, k): c * J[a][k] - s * J[b][k], (b, k): s * J[a][k] + c * J[b][k]}
        entries = {
            (i, h): tape.name(f"J{min(i, h) + 1}{max(i, h) + 1}{tag}", value)
            for (i, h), value in new.items()
        }
        J = symmetric({**entries, (k, k): J[k][k]})
        if isinstance(motion, Shift):
            return Inertia(J, replaced(m, {k: tape.entry(m[k] + ml, "m", tag, k)}), self.M)
        return Inertia(J, turned(m, motion.back, f"m{j}_", tape), self.M)

    def less_half_trace(self, tag: str, tape: TapeBuilder) -> Matrix:
        """Return J - tr(J)/2."""
        trace = tape.name(f"t{tag}", self.J[0][0] + self.J[1][1] + self.J[2][2])
        half = tape.name(f"h{tag}", _HALF * trace)
        diagonal = [tape.entry(self.J[i][i] - half, "j", tag, i) for i in range(3)]
        return matrix(lambda i, k: diagonal[i] if i == k else self.J[i][k])

    def momentum(self, twist: Screw) -> Screw:
        """Return the momentum (l, k) of the moving body."""
        w, V = twist
        lin = plus(scaled(self.M, V), cross(w, self.m))
        return lin, plus(matvec(self.J, w), cross(self.m, V))

    def rate(self, frame: LinkState, lin: Vector, j: int, tape: TapeBuilder) -> Inertia:
        """Return dJ/dt in the fixed frame that coincides with the link frame now, with l for m.

        R = [w] J - J [w] + 2 (m . V) - V m^T - m V^T
        """
        (w, V), J, m = frame.twist, self.J, self.m
        R = {}
        for a in range(3):
            b, c = around(a)
            turning = w[b] * J[a][c] - w[c] * J[a][b]
            value = 2 * tape.entry(turning + m[b] * V[b] + m[c] * V[c], "r", j, a)
            R[a, a] = tape.entry(value, "R", j, a, a)
            pair = tape.entry(J[b][b] - J[a][a], "J", f"_{j}", a, b)
            value = w[b] * J[b][c] - w[a] * J[a][c] - pair * w[c]
            value = value - V[a] * m[b] - V[b] * m[a]
            R[a, b] = tape.entry(value, "R", j, a, b)
        return Inertia(symmetric(R), lin, sp.S.Zero)

    def wrench(self, motion: LinkState, j: int, tape: TapeBuilder) -> Screw:
        """Return the wrench (f, n) of the moving body.

        It is the sum of unit wrenches times parameters. This shares products of w and dw, and costs
        less than J w and w x (J w).
        """
        f, n = scaled(self.M, motion.a), cross(self.m, motion.a)
        p = products(motion.w, j, tape)
        for prefix, value in zip(names.MOMENT, self.m, strict=True):
            if value != 0:
                column, _ = unit_wrench(prefix, motion, j, tape)
                f = plus(f, scaled(value, column))
        diagonal = []
        for b in range(3):
            i, h = around(b)
            pair = tape.entry(self.J[h][h] - self.J[i][i], "J", f"_{j}", i, h)
            diagonal.append(self.J[b][b] * motion.dw[b] + pair * p[i][h])
            if self.J[i][h] != 0:
                prefix = names.INERTIA[UPPER.index((min(i, h), max(i, h)))]
                _, column = unit_wrench(prefix, motion, j, tape)
                n = plus(n, scaled(self.J[i][h], column))
        n = plus(n, tuple(diagonal))
        return named(f, f"F{j}_", tape), named(n, f"N{j}_", tape)

    def virtual_wrench(
        self, motion: LinkState, tag: str, tape: TapeBuilder, name: Callable[[Vector, str], Vector]
    ) -> Screw:
        """Return (f, n) of the body under a reference motion, with Christoffel's symbols.

            f = M a + dw x m + w x (w_real x m)
            n = m x a + J dw + w_real x ((J - tr(J)/2) w)

        Args:
            motion: the reference motion, from `references`.
            tag: suffix of the names of parameter sums.
            tape: receives the named steps.
            name: names the intermediate products h and k, and the results F and N.
        """
        w, dw, a = motion.w, motion.dw, motion.a
        wm = name(cross(motion.turning, self.m), "h")
        f = plus(cross(dw, self.m), cross(w, wm), scaled(self.M, a))
        k = name(matvec(self.less_half_trace(tag, tape), w), "k")
        n = plus(cross(self.m, a), matvec(self.J, dw), cross(motion.turning, k))
        return name(f, "F"), name(n, "N")


def composites(way: Way, bodies: Mapping[int, Inertia], tape: TapeBuilder) -> Mapping[int, Inertia]:
    """Return the composite body of every link, by joint number.

    Args:
        way: the steps to every joint, from `way_of`.
        bodies: the links alone, and link 0 of a free base.
        tape: receives the named steps.
    """
    total = dict(bodies)
    for step in reversed(way):
        j, a = step.joint.number, step.joint.antecedent
        if a not in total:
            continue
        moved = total[j]
        for motion in reversed(step.way):
            moved = moved.before(motion, j, tape)
        total[a] = total[a].plus(moved, f"{a}_{j}", tape)
    return total
