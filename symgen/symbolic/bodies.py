"""What one body adds: wrench and momentum of each unit parameter, in the link's frame.

With w, V, dw = dw/dt, a = acceleration of the origin less gravity, all in the frame (Khalil and
Dombre, ch. 9), the wrench (f at the origin, n about it) of the parameters J, m = (MX, MY, MZ), M is

    f = M a + dw x m + w x (w x m),      n = J dw + w x (J w) + m x a

and the momentum   l = M V + w x m,      k = J w + m x V.
"""

from __future__ import annotations

import sympy as sp

from symgen import names
from symgen.symbolic.kinematics import ZERO, Frame, Vector
from symgen.symbolic.tape import TapeBuilder

Pair = tuple[Vector, Vector]
_AXES = {"X": 0, "Y": 1, "Z": 2}


def dot(a: Vector, b: Vector) -> sp.Expr:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scaled(factor: sp.Expr, a: Vector) -> Vector:
    """Return factor times a."""
    return (factor * a[0], factor * a[1], factor * a[2])


def named(vector: Vector, name: str, tape: TapeBuilder) -> Vector:
    """Name the three components of a vector."""
    x, y, z = (tape.name(f"{name}{i + 1}", c) for i, c in enumerate(vector))
    return (x, y, z)


def unit(axis: int) -> Vector:
    """Return the unit vector of an axis."""
    x, y, z = (sp.Integer(int(i == axis)) for i in range(3))
    return (x, y, z)


def products(w: Vector, j: int, tape: TapeBuilder) -> list[list[sp.Expr]]:
    """Name the products w_a w_b of a link: entry [a][b]."""
    out: list[list[sp.Expr]] = [[sp.S.Zero] * 3 for _ in range(3)]
    for a in range(3):
        for b in range(a, 3):
            out[a][b] = out[b][a] = tape.name(f"P{a + 1}{b + 1}{j}", w[a] * w[b])
    return out


def unit_wrench(prefix: str, w: Vector, dw: Vector, a: Vector, j: int, tape: TapeBuilder) -> Pair:
    """Return (f, n) of a link whose one parameter `prefix` is 1."""
    p = products(w, j, tape)
    if prefix == names.MASS:
        return a, ZERO
    if prefix in names.MOMENT:
        k = _AXES[prefix[1]]
        i, h = (k + 1) % 3, (k + 2) % 3
        f, n = [sp.S.Zero] * 3, [sp.S.Zero] * 3
        f[k] = -tape.name(f"Q{k + 1}{j}", p[i][i] + p[h][h])
        f[i] = tape.name(f"A{i + 1}{k + 1}{j}", p[k][i] + dw[h])
        f[h] = tape.name(f"A{h + 1}{k + 1}{j}", p[k][h] - dw[i])
        n[i], n[h] = -a[h], a[i]
        return (f[0], f[1], f[2]), (n[0], n[1], n[2])
    b, c = _AXES[prefix[0]], _AXES[prefix[1]]
    n = [sp.S.Zero] * 3
    if b == c:
        i, h = (b + 1) % 3, (b + 2) % 3
        n[b], n[i], n[h] = dw[b], p[b][h], -p[b][i]
        return ZERO, (n[0], n[1], n[2])
    # J couples b and c; k is the third axis, and (b, c, k) or its mirror is right-handed.
    k = 3 - b - c
    sign = 1 if (c - b) % 3 == 1 else -1
    n[b] = tape.name(f"A{b + 1}{c + 1}{k + 1}{j}", dw[c] - sign * p[b][k])
    n[c] = tape.name(f"A{c + 1}{b + 1}{k + 1}{j}", dw[b] + sign * p[c][k])
    n[k] = tape.name(f"B{k + 1}{j}", sign * (p[b][b] - p[c][c]))
    return ZERO, (n[0], n[1], n[2])


def unit_momentum(prefix: str, w: Vector, V: Vector) -> Pair:
    """Return (l, k) of a link whose one parameter `prefix` is 1."""
    if prefix == names.MASS:
        return V, ZERO
    if prefix in names.MOMENT:
        axis = unit(_AXES[prefix[1]])
        return cross(w, axis), cross(axis, V)
    b, c = _AXES[prefix[0]], _AXES[prefix[1]]
    k = [sp.S.Zero] * 3
    k[b] = w[c]
    k[c] = w[b]
    return ZERO, (k[0], k[1], k[2])


class Inertia:
    """J (3, 3), m (3,) and M of a body, symbols or zero."""

    def __init__(self, values: dict[str, sp.Expr]) -> None:
        def of(prefix: str) -> sp.Expr:
            return values.get(prefix, sp.S.Zero)

        self.J = [
            [of("XX"), of("XY"), of("XZ")],
            [of("XY"), of("YY"), of("YZ")],
            [of("XZ"), of("YZ"), of("ZZ")],
        ]
        self.m: Vector = (of("MX"), of("MY"), of("MZ"))
        self.M = of("M")

    def times(self, vector: Vector) -> Vector:
        """Return J v."""
        x, y, z = (sum((self.J[i][k] * vector[k] for k in range(3)), sp.S.Zero) for i in range(3))
        return (x, y, z)

    def less_half_trace(self, tag: str, tape: TapeBuilder) -> Inertia:
        """Return the body with J - tr(J)/2 in place of J."""
        out = Inertia({})
        trace = tape.name(f"t{tag}", self.J[0][0] + self.J[1][1] + self.J[2][2])
        half = tape.name(f"h{tag}", sp.Rational(1, 2) * trace)
        out.J = [list(row) for row in self.J]
        for i in range(3):
            out.J[i][i] = tape.name(f"j{i + 1}{tag}", self.J[i][i] - half)
        return out

    def momentum(self, frame: Frame, tag: str, tape: TapeBuilder) -> Pair:
        """Return (l, k) of the body's motion, with names."""
        w, V = frame.w, frame.V
        lin = plus(scaled(self.M, V), cross(w, self.m))
        ang = plus(self.times(w), cross(self.m, V))
        return named(lin, f"l{tag}_", tape), named(ang, f"k{tag}_", tape)

    def rate(self, frame: Frame, lin: Vector, j: int, tape: TapeBuilder) -> Inertia:
        """Return dJ/dt in a frame at rest that is now where the link's is, with l for m.

        R = [w] J - J [w] + 2 (m . V) - V m^T - m V^T
        """
        out, w, V, m = Inertia({}), frame.w, frame.V, self.m
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            turning = w[b] * self.J[a][c] - w[c] * self.J[a][b]
            value = 2 * tape.name(f"r{a + 1}{j}", turning + m[b] * V[b] + m[c] * V[c])
            out.J[a][a] = tape.name(f"R{a + 1}{a + 1}{j}", value)
            pair = tape.name(f"J{a + 1}{b + 1}_{j}", self.J[b][b] - self.J[a][a])
            value = w[b] * self.J[b][c] - w[a] * self.J[a][c] - pair * w[c]
            value = value - V[a] * m[b] - V[b] * m[a]
            out.J[a][b] = out.J[b][a] = tape.name(f"R{a + 1}{b + 1}{j}", value)
        out.m = lin
        return out

    def wrench(self, w: Vector, dw: Vector, a: Vector, j: int, tape: TapeBuilder) -> Pair:
        """Return (f, n) of the body's motion: unit wrenches times parameters, Euler's terms paired.

        J_ii and J_hh both multiply w_i w_h in n_b; products and sums of w and dw are shared with
        the unit wrenches of m, which costs less than J w and w x (J w).
        """
        f: Vector = (self.M * a[0], self.M * a[1], self.M * a[2])
        n: Vector = cross(self.m, a)
        p = products(w, j, tape)
        for axis, value in enumerate(self.m):
            if value != 0:
                column, _ = unit_wrench(names.MOMENT[axis], w, dw, a, j, tape)
                f = plus(f, scaled(value, column))
        diagonal = list(ZERO)
        for b in range(3):
            i, h = (b + 1) % 3, (b + 2) % 3
            pair = tape.name(f"J{i + 1}{h + 1}_{j}", self.J[h][h] - self.J[i][i])
            diagonal[b] = self.J[b][b] * dw[b] + pair * p[i][h]
            if self.J[i][h] != 0:
                product = "XYZ"[min(i, h)] + "XYZ"[max(i, h)]
                _, column = unit_wrench(product, w, dw, a, j, tape)
                n = plus(n, scaled(self.J[i][h], column))
        n = plus(n, (diagonal[0], diagonal[1], diagonal[2]))
        return named(f, f"F{j}_", tape), named(n, f"N{j}_", tape)
