"""Operational space at a point of a link (Khatib 1987).

    Lambda = (J M^-1 J')^-1,   J# = M^-1 J' Lambda,   tau_null = (I - J' J#') tau

for the rows of J that a task chooses. With S = diag(select), Lambda = S A^-1 S of
A = S J M^-1 J' S + (I - S)^2, which is positive definite if the chosen rows are independent.

Of rows that depend on each other, rounding leaves pivots of either sign. A guard is

    (c A_jj + pivot_j) - c A_jj

which is 0 where the pivot is lost in the rounding of the numbers that it is a difference of, in
double and in float.
"""

from __future__ import annotations

import sympy as sp

from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.dynamics import plant
from symgen.symbolic.forward import mass_matrix_factor
from symgen.symbolic.joined import merged
from symgen.symbolic.placement import link_jacobian_tape
from symgen.symbolic.tape import Symbols, Tape, TapeBuilder, real_symbol

Rows = list[list[sp.Expr]]
#: A pivot is lost where it is less than so many roundings of its diagonal entry.
_ROUNDING = 1024


def operational_space_tape(robot: Robot, base: BaseParameters) -> Tape:
    """Derive Lambda (6, 6), J# (n, 6) and the torque in the null space (n,), and their guards."""
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
    J = [outputs[n * i : n * (i + 1)] for i in range(6)]
    rest = outputs[6 * n :]
    upper = [rest[n * i : n * (i + 1)] for i in range(n)]
    diagonal, guards = rest[n * n : n * n + n], rest[n * n + n :]
    inverse = [tape.name(f"iD{j}", 1 / d) for j, d in enumerate(diagonal)]
    # L y = J', column by column; then M^-1 J' from L' x = y / D.
    Y = [_up(tape, upper, row, f"y{i}_") for i, row in enumerate(J)]
    Z = [[tape.name(f"z{i}_{k}", y * inverse[k]) for k, y in enumerate(row)]
         for i, row in enumerate(Y)]  # fmt: skip
    MJ = [_down(tape, upper, row, f"w{i}_") for i, row in enumerate(Z)]
    A: Rows = [[sp.S.Zero] * 6 for _ in range(6)]
    for i in range(6):
        for j in range(i, 6):
            mobility = tape.name(
                f"m{i}{j}", sp.Add(*(a * b for a, b in zip(Y[i], Z[j], strict=True)))
            )
            entry = tape.name(f"S{i}{j}", select[i] * select[j]) * mobility
            if i == j:
                left = tape.name(f"o{i}", 1 - select[i])
                entry = entry + left * left
            A[i][j] = A[j][i] = tape.name(f"A{i}{j}", entry)
    solved, positive = _inverse(tape, A)
    Lambda = [
        [tape.name(f"La{i}{j}", select[i] * tape.name(f"l{i}{j}", solved[i][j] * select[j]))
         for j in range(6)]
        for i in range(6)
    ]  # fmt: skip
    consistent = [
        [
            tape.name(f"c{k}_{i}", sp.Add(*(MJ[j][k] * Lambda[j][i] for j in range(6))))
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
    return tape.tape(arrays, [*entries, *guards, *positive])


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


def _inverse(tape: TapeBuilder, A: Rows) -> tuple[Rows, list[sp.Expr]]:
    """Return the inverse of a symmetric matrix by U D U', and a guard of each pivot."""
    n = len(A)
    guards: list[sp.Expr] = []
    upper: Rows = [[sp.S.Zero] * n for _ in range(n)]
    pivots, inverse = [sp.S.Zero] * n, [sp.S.Zero] * n
    for j in range(n - 1, -1, -1):
        held = [tape.name(f"h{j}{k}", upper[j][k] * pivots[k]) for k in range(j + 1, n)]
        above = sp.Add(*(upper[j][k] * h for k, h in zip(range(j + 1, n), held, strict=True)))
        pivots[j] = tape.name(f"p{j}", A[j][j] - above)
        large = tape.name(f"b{j}", _ROUNDING * A[j][j])
        guards.append(tape.name(f"g{j}", tape.name(f"e{j}", large + pivots[j]) - large))
        upper[j][j] = sp.S.One
        inverse[j] = tape.name(f"ip{j}", 1 / pivots[j])
        for i in range(j):
            known = sp.Add(*(upper[i][k] * h for k, h in zip(range(j + 1, n), held, strict=True)))
            upper[i][j] = tape.name(f"u{i}{j}", tape.name(f"v{i}{j}", A[i][j] - known) * inverse[j])
    columns = []
    for k in range(n):
        unit = [sp.S.One if i == k else sp.S.Zero for i in range(n)]
        y = _up(tape, upper, unit, f"s{k}_")
        z = [tape.name(f"t{k}_{i}", v * inverse[i]) for i, v in enumerate(y)]
        columns.append(_down(tape, upper, z, f"r{k}_"))
    return columns, guards
