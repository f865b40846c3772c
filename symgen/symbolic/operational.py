"""Operational space at a point of a link (Khatib 1987).

    Lambda = (J M^-1 J')^-1,   J# = M^-1 J' Lambda,   tau_null = (I - J' J#') tau

for the rows J = S J_link that a task chooses, S = diag(select). With M = L D L', modified
Gram-Schmidt in the metric of D^-1 gives L^-1 J' = Q R, R with ones on its diagonal, so that

    Lambda = T W^-1 T',   J# = L^-T D^-1 Q W^-1 T',   T = R^-1,   W = Q' D^-1 Q

without squares of the condition number. Rows that are not chosen have Q = 0, and W = 1.

Rows of the Jacobian depend on each other if and only if a sum of them with coefficients c is 0. The
guards are about J' = Q R in the metric of I, where q_j = sum of c_ij J_i with c = R^-1:

    |q_j|^2 - (sum of |c_ij| h_i)^2

with a bound h_i of the error of row i, from the Jacobian and from Gram-Schmidt, which is backward
stable (Higham 2002, theorem 19.13). It is positive for independent rows, unless a change of each
row within h_i makes them depend on each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.dynamics import plant
from symgen.symbolic.forward import mass_matrix_factor
from symgen.symbolic.joined import merged
from symgen.symbolic.placement import link_jacobian_tape
from symgen.symbolic.rounding import jacobian_rounding, unit_roundoff
from symgen.symbolic.spatial import Vector, dot, named, plus, scaled, transposed
from symgen.symbolic.tape import Symbols, Tape, TapeBuilder, real_symbol

Rows = list[list[sp.Expr]]


def operational_space_tape(robot: Robot, base: BaseParameters) -> Tape:
    """Derive Lambda (6, 6), J# (n, 6), the torque in the null space (n,), and guards of M and J."""
    n, p = robot.n, plant(robot, base)
    numbers = robot.numbers
    L, D, pivots = mass_matrix_factor(p)
    factor = p.close(
        ["q"],
        [*(L[j].get(k, sp.S.Zero) for j in numbers for k in numbers), *D, *pivots],
        inertial=True,
    )
    jacobian = link_jacobian_tape(robot)
    select = tuple(real_symbol(f"select{i}") for i in range(6))
    tau = tuple(real_symbol(f"tau{j}") for j in numbers)
    tape, inputs, outputs = merged(robot, [jacobian, factor], (*select, *tau))
    J = [named(scaled(s, outputs[n * i : n * (i + 1)]), f"j{i}_", tape)
         for i, s in enumerate(select)]  # fmt: skip
    rest = outputs[6 * n :]
    upper = [rest[n * i : n * (i + 1)] for i in range(n)]
    diagonal, guards = rest[n * n : n * n + n], rest[n * n + n :]
    inverse = [tape.name(f"iD{j}", 1 / d) for j, d in enumerate(diagonal)]
    left = [tape.name(f"o{i}", 1 - x) for i, x in enumerate(select)]
    rows = _orthogonal(tape, J, [sp.S.One] * n, left, "k")
    # L y = J', column by column; then L^-T D^-1 Q from L' x = z.
    Y = [_up(tape, upper, row, f"y{i}_") for i, row in enumerate(J)]
    task = _orthogonal(tape, Y, inverse, left, "t")
    T = task.combinations
    share = named([s * x for s, x in zip(select, task.inverse, strict=True)], "e", tape)
    Z = [named(scaled(x, row), f"z{i}_", tape)
         for i, (x, row) in enumerate(zip(share, task.weighted, strict=True))]  # fmt: skip
    back = transposed([_down(tape, upper, row, f"w{i}_") for i, row in enumerate(Z)])
    held = [named([x * s for x, s in zip(row, share, strict=True)], f"h{i}_", tape)
            for i, row in enumerate(T)]  # fmt: skip
    Lambda = [[tape.name(f"La{min(i, k)}{max(i, k)}", dot(held[min(i, k)], T[max(i, k)]))
               for k in range(6)] for i in range(6)]  # fmt: skip
    consistent = [named([dot(row, x) for row in T], f"c{k}_", tape) for k, x in enumerate(back)]
    force = named([dot(column, tau) for column in transposed(consistent)], "f", tape)
    null = [tape.name(f"N{k}", x - dot(column, force))
            for k, (x, column) in enumerate(zip(tau, transposed(J), strict=True))]  # fmt: skip
    arrays: list[tuple[str, Symbols]] = [
        *((name, inputs[name]) for name in inputs if name != "X"),
        ("select", select),
        ("tau", tau),
        ("X", inputs["X"]),
    ]
    entries = [x for matrix in (Lambda, consistent, [null]) for row in matrix for x in row]
    return tape.tape(arrays, [*entries, *guards, *_independent(robot, tape, rows)])


@dataclass(frozen=True)
class _Orthogonal:
    """Rows A = R' Q', with Q' W Q diagonal and ones on the diagonal of the upper R.

    Attributes:
        weighted: rows of Q' W.
        squares: diagonal of Q' W Q, and 1 for rows that are not chosen.
        inverse: 1 / squares.
        combinations: R^-1; row i of Q' is the sum of rows j of A with its entries (j, i).
    """

    weighted: list[Vector]
    squares: list[sp.Expr]
    inverse: list[sp.Expr]
    combinations: list[list[sp.Expr]]


def _orthogonal(
    tape: TapeBuilder,
    rows: Sequence[Vector],
    weights: Sequence[sp.Expr],
    left: Sequence[sp.Expr],
    name: str,
) -> _Orthogonal:
    """Factor rows by modified Gram-Schmidt in a metric; rows that are not chosen are 0."""
    done: list[Vector] = []
    found = _Orthogonal([], [], [], [[sp.Integer(i == j) for j in range(6)] for i in range(6)])
    T = found.combinations
    for j, row in enumerate(rows):
        shares = []
        for i, other in enumerate(done):
            along = tape.name(f"{name}d{i}{j}", dot(found.weighted[i], row))
            shares.append(tape.name(f"{name}r{i}{j}", along * found.inverse[i]))
            row = named(plus(row, scaled(-shares[i], other)), f"{name}q{i}{j}_", tape)
        done.append(row)
        weighted = tuple(w * x for w, x in zip(weights, row, strict=True))
        found.weighted.append(named(weighted, f"{name}w{j}_", tape))
        square = left[j] * left[j] + dot(found.weighted[j], row)
        found.squares.append(tape.name(f"{name}s{j}", square))
        found.inverse.append(tape.name(f"{name}i{j}", 1 / found.squares[j]))
        for i in range(j):
            T[i][j] = tape.name(f"{name}T{i}{j}", -dot(T[i][:j], shares))
    return found


def _independent(robot: Robot, tape: TapeBuilder, rows: _Orthogonal) -> list[sp.Expr]:
    """Return a guard for each row of the Jacobian: it does not depend on the rows before it.

    Each of five projections of a row is off by two scalar products and four operations.
    """
    bounds = jacobian_rounding(robot, tape, more=5 * (2 * robot.n + 4))
    roundoff = unit_roundoff(tape)
    off = [tape.name(f"off{i}", bound * roundoff) for i, bound in enumerate(bounds)]
    guards = []
    for j, square in enumerate(rows.squares):
        sizes = [tape.name(f"a{i}{j}", sp.Abs(rows.combinations[i][j])) for i in range(j + 1)]
        total = tape.name(f"l{j}", sp.Add(*(off[i // 3] * size for i, size in enumerate(sizes))))
        guards.append(tape.name(f"g{j}", square - total * total))
    return guards


def _up(tape: TapeBuilder, upper: Rows, b: Vector, name: str) -> Vector:
    """Solve L y = b for unit upper L."""
    n, y = len(b), list(b)
    for i in range(n - 1, -1, -1):
        y[i] = tape.name(f"{name}{i}", b[i] - dot(upper[i][i + 1 :], y[i + 1 :]))
    return tuple(y)


def _down(tape: TapeBuilder, upper: Rows, b: Vector, name: str) -> Vector:
    """Solve L' x = b for unit upper L."""
    x = list(b)
    for i in range(len(b)):
        x[i] = tape.name(f"{name}{i}", b[i] - dot([row[i] for row in upper[:i]], x[:i]))
    return tuple(x)
