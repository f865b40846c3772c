"""Composite bodies: each link with all that it carries, as one body in its own frame.

Turning about one axis by (c, s), with D = J_aa - J_bb and z = s D + 2 c J_ab:

    J_aa' = J_aa - s z,  J_bb' = J_bb + s z,  J_ab' = c z - J_ab

and shifting the origin along one axis k by l (Huygens and Steiner):

    J_ii' = J_ii + 2 l m_k + M l^2 (i != k),  J_ki' = J_ki - l m_i,  m_k' = m_k + M l.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from symgen.symbolic.bodies import Inertia
from symgen.symbolic.kinematics import Shift, Step, Turn, returned
from symgen.symbolic.tape import TapeBuilder


def composites(
    way: tuple[Step, ...], bodies: Mapping[int, Inertia], tape: TapeBuilder
) -> Mapping[int, Inertia]:
    """Return the composite body of every link, by joint number.

    Args:
        way: from `steps`.
        bodies: the links alone.
        tape: takes the named steps.
    """
    total = {j: _copy(body) for j, body in bodies.items()}
    for step in reversed(way):
        j, a = step.joint.number, step.joint.antecedent
        if a == 0:
            continue
        moved = total[j]
        for motion in reversed((*step.before, *step.after)):
            moved = _back(moved, motion, j, tape)
        total[a] = _sum(total[a], moved, f"{a}_{j}", tape)
    return total


def _copy(body: Inertia) -> Inertia:
    out = Inertia({})
    out.J, out.m, out.M = [list(row) for row in body.J], body.m, body.M
    return out


def _sum(a: Inertia, b: Inertia, tag: str, tape: TapeBuilder) -> Inertia:
    out = Inertia({})
    for i in range(3):
        for k in range(i, 3):
            value = tape.name(f"J{i + 1}{k + 1}s{tag}", a.J[i][k] + b.J[i][k])
            out.J[i][k] = out.J[k][i] = value
    x, y, z = (tape.name(f"m{i + 1}s{tag}", a.m[i] + b.m[i]) for i in range(3))
    out.m, out.M = (x, y, z), tape.name(f"ms{tag}", a.M + b.M)
    return out


def _back(body: Inertia, motion: Turn | Shift, j: int, tape: TapeBuilder) -> Inertia:
    """Express a body in the frame before an elementary motion."""
    out = _copy(body)
    k = motion.axis
    a, b = (k + 1) % 3, (k + 2) % 3
    tag = f"{motion.tag}_{j}"

    def put(i: int, h: int, value: sp.Expr) -> None:
        low, high = min(i, h), max(i, h)
        out.J[i][h] = out.J[h][i] = tape.name(f"J{low + 1}{high + 1}{tag}", value)

    if isinstance(motion, Turn):
        c, s = motion.c, motion.s
        if c == 0 or s == 0:  # quarter turns swap axes
            swapped = (body.J[b][b], body.J[a][a]) if c == 0 else (body.J[a][a], body.J[b][b])
            out.J[a][a], out.J[b][b] = swapped
            put(a, b, (c * c - s * s) * body.J[a][b])
            put(a, k, c * body.J[a][k] - s * body.J[b][k])
            put(b, k, s * body.J[a][k] + c * body.J[b][k])
            out.m = returned(body.m, motion, f"m{j}_", tape)
            return out
        difference = tape.name(f"D{tag}", body.J[a][a] - body.J[b][b])
        twice = tape.name(f"T{tag}", 2 * body.J[a][b])
        z = tape.name(f"z{tag}", s * difference + c * twice)
        put(a, a, body.J[a][a] - s * z)
        put(b, b, body.J[b][b] + s * z)
        put(a, b, c * z - body.J[a][b])
        put(a, k, c * body.J[a][k] - s * body.J[b][k])
        put(b, k, s * body.J[a][k] + c * body.J[b][k])
        out.m = returned(body.m, motion, f"m{j}_", tape)
        return out
    length = motion.length
    ml = tape.name(f"w{tag}", body.M * length)
    extra = tape.name(f"x{tag}", length * (2 * body.m[k] + ml))
    put(a, a, body.J[a][a] + extra)
    put(b, b, body.J[b][b] + extra)
    put(k, a, body.J[k][a] - length * body.m[a])
    put(k, b, body.J[k][b] - length * body.m[b])
    m = list(body.m)
    m[k] = tape.name(f"m{k + 1}{tag}", m[k] + ml)
    out.m = (m[0], m[1], m[2])
    return out
