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
    J = [[tape.name(f"j{i}_{k}", select[i] * outputs[n * i + k]) for k in range(n)]
         for i in range(6)]  # fmt: skip
    rest = outputs[6 * n :]
    upper = [rest[n * i : n * (i + 1)] for i in range(n)]
    diagonal, guards = rest[n * n : n * n + n], rest[n * n + n :]
    inverse = [tape.name(f"iD{j}", 1 / d) for j, d in enumerate(diagonal)]
    left = [tape.name(f"o{i}", 1 - x) for i, x in enumerate(select)]
    rows = _orthogonal(tape, J, [sp.S.One] * n, left, "k")
    independent = _independent(robot, tape, rows)
    # L y = J', column by column; then M^-1 J' from L' x = y / D.
    Y = [_up(tape, upper, row, f"y{i}_") for i, row in enumerate(J)]
    task = _orthogonal(tape, Y, inverse, left, "t")
    share = [
        tape.name(f"e{k}", x * i) for k, (x, i) in enumerate(zip(select, task.inverse, strict=True))
    ]
    Z = [[tape.name(f"z{i}_{k}", x * share[i]) for k, x in enumerate(row)]
         for i, row in enumerate(task.weighted)]  # fmt: skip
    MJ = [_down(tape, upper, row, f"w{i}_") for i, row in enumerate(Z)]
    T = task.combinations
    held = [[tape.name(f"h{i}_{k}", T[i][k] * share[k]) for k in range(6)] for i in range(6)]
    Lambda = [[sp.S.Zero] * 6 for _ in range(6)]
    for i in range(6):
        for j in range(i, 6):
            entry = sp.Add(*(held[i][k] * T[j][k] for k in range(j, 6)))
            Lambda[i][j] = Lambda[j][i] = tape.name(f"La{i}{j}", entry)
    consistent = [
        [
            tape.name(f"c{k}_{i}", sp.Add(*(MJ[j][k] * T[i][j] for j in range(i, 6))))
            for i in range(6)
        ]
        for k in range(n)
    ]
    force = [
        tape.name(f"f{i}", sp.Add(*(consistent[k][i] * tau[k] for k in range(n)))) for i in range(6)
    ]
    null = [
        tape.name(f"N{k}", tau[k] - sp.Add(*(J[i][k] * force[i] for i in range(6))))
        for k in range(n)
    ]
    arrays: list[tuple[str, Symbols]] = [
        *((name, inputs[name]) for name in inputs if name != "X"),
        ("select", select),
        ("tau", tau),
        ("X", inputs["X"]),
    ]
    entries = [x for row in Lambda for x in row] + [x for row in consistent for x in row] + null
    return tape.tape(arrays, [*entries, *guards, *independent])


@dataclass(frozen=True)
class _Orthogonal:
    """Rows A = R' Q', with Q' W Q diagonal and ones on the diagonal of the upper R.

    Attributes:
        weighted: rows of Q' W.
        squares: diagonal of Q' W Q, and 1 for rows that are not chosen.
        inverse: 1 / squares.
        combinations: R^-1; row i of Q' is the sum of rows j of A with its entries (j, i).
    """

    weighted: Rows
    squares: list[sp.Expr]
    inverse: list[sp.Expr]
    combinations: Rows


def _orthogonal(
    tape: TapeBuilder, rows: Rows, weights: Sequence[sp.Expr], left: Sequence[sp.Expr], name: str
) -> _Orthogonal:
    """Factor rows by modified Gram-Schmidt in a metric; rows that are not chosen are 0."""
    weighted: Rows = []
    squares: list[sp.Expr] = []
    inverse: list[sp.Expr] = []
    found: Rows = []
    T: Rows = [[sp.Integer(int(i == j)) for j in range(6)] for i in range(6)]
    for j, row in enumerate(rows):
        shares = []
        for i in range(j):
            along = tape.name(
                f"{name}d{i}{j}", sp.Add(*(a * b for a, b in zip(weighted[i], row, strict=True)))
            )
            shares.append(tape.name(f"{name}r{i}{j}", along * inverse[i]))
            row = [
                tape.name(f"{name}q{i}{j}_{k}", a - shares[i] * b)
                for k, (a, b) in enumerate(zip(row, found[i], strict=True))
            ]
        found.append(row)
        weighted.append(
            [
                tape.name(f"{name}w{j}_{k}", w * a)
                for k, (w, a) in enumerate(zip(weights, row, strict=True))
            ]
        )
        square = sp.Add(left[j] * left[j], *(a * b for a, b in zip(weighted[j], row, strict=True)))
        squares.append(tape.name(f"{name}s{j}", square))
        inverse.append(tape.name(f"{name}i{j}", 1 / squares[j]))
        for i in range(j):
            T[i][j] = tape.name(
                f"{name}T{i}{j}", -sp.Add(*(T[i][k] * shares[k] for k in range(i, j)))
            )
    return _Orthogonal(weighted, squares, inverse, T)


def _independent(robot: Robot, tape: TapeBuilder, rows: _Orthogonal) -> list[sp.Expr]:
    """Return for each row of the Jacobian whether it is independent of those before it.

    Each of five projections of a row is off by two scalar products and four operations.
    """
    bounds = jacobian_rounding(robot, tape, more=5 * (2 * robot.n + 4))
    u = unit_roundoff(tape)
    off = [tape.name(f"off{i}", bound * u) for i, bound in enumerate(bounds)]
    guards = []
    for j, square in enumerate(rows.squares):
        sizes = [tape.name(f"a{i}{j}", sp.Abs(rows.combinations[i][j])) for i in range(j + 1)]
        total = tape.name(f"l{j}", sp.Add(*(off[i // 3] * size for i, size in enumerate(sizes))))
        guards.append(tape.name(f"g{j}", square - total * total))
    return guards


def _up(tape: TapeBuilder, upper: Rows, b: list[sp.Expr], name: str) -> list[sp.Expr]:
    """Solve L y = b for unit upper L."""
    n, y = len(b), list(b)
    for i in range(n - 1, -1, -1):
        known = sp.Add(*(upper[i][k] * y[k] for k in range(i + 1, n)))
        y[i] = tape.name(f"{name}{i}", b[i] - known)
    return y


def _down(tape: TapeBuilder, upper: Rows, b: list[sp.Expr], name: str) -> list[sp.Expr]:
    """Solve L' x = b for unit upper L."""
    x = list(b)
    for i in range(len(b)):
        known = sp.Add(*(upper[k][i] * x[k] for k in range(i)))
        x[i] = tape.name(f"{name}{i}", b[i] - known)
    return x
