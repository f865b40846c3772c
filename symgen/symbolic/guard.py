"""A guard in floating point: the exact result must not contradict plain numbers.

Exact arithmetic modulo a prime is right as long as the geometry is mapped into it consistently, a
claim about code. Here the columns are evaluated in double precision at the file's values: the
columns kept must be independent there, and every regrouping must reproduce its column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp

from symgen.errors import SymgenError
from symgen.robot.types import Robot
from symgen.symbolic.elimination import ExactRow
from symgen.symbolic.energy import stacked, state_columns
from symgen.symbolic.kinematics import by_joint
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.tape import Numbers, Tape, Values

_MARGIN = 10
#: Singular values of the kept columns, scaled, below which floats would call them dependent; far
#: below what any useful geometry has, far above rounding.
_DEPENDENT = 1e-13
_ERROR = 1e-6


def require_floats_agree(
    robot: Robot,
    energy: Tape,
    parameters: Sequence[Parameter],
    kept: Sequence[int],
    rows: Mapping[str, ExactRow],
) -> None:
    """Raise SymgenError where double precision contradicts the exact base parameters.

    Args:
        robot: the mechanism, with the file's values.
        energy: tape of the energy columns.
        parameters: those with a column of the state.
        kept: positions of the base parameters among them.
        rows: the relation of every other one.
    """
    values = robot.values()
    count = len(parameters) + _MARGIN
    draw = np.random.default_rng(len(parameters))
    span = [np.pi if j.turns else 1.0 for j in robot.movable]
    q = [draw.uniform(-s, s, count) for s in span]
    qd = [draw.uniform(-2, 2, count) for _ in span]
    functions = {"sin": np.sin, "cos": np.cos}
    state: dict[str, list[Any]] = {"q": q, "qd": qd}
    rest = {key: [x[:1] for x in entries] for key, entries in state.items()}
    if robot.gravity_input:
        state["g"] = [draw.uniform(-10, 10, count) for _ in range(3)]
    arithmetic = Numbers(values, functions)
    out = state_columns(energy, parameters, arithmetic, state, rest, by_joint(robot, q))
    W = stacked(out, count).astype(float)
    W = W[1:] - W[0]
    column = {p.name: W[:, i] for i, p in enumerate(parameters)}
    size = max(1.0, float(np.abs(W).max(initial=0.0)))
    for name, row in rows.items():
        parts = [_float(c.value, values) * column[n] for n, c in row.items()]
        scale = max(size, max(float(np.abs(part).max()) for part in parts))
        if not float(np.abs(np.sum(parts, axis=0)).max()) <= _ERROR * scale:
            raise SymgenError(f"the regrouping of {name} contradicts its column in numbers")
    K = W[:, list(kept)]
    norms = np.linalg.norm(K, axis=0)
    singular = np.linalg.svd(K / np.where(norms > 0, norms, 1.0), compute_uv=False)
    if len(singular) and singular[-1] < _DEPENDENT * singular[0]:
        raise SymgenError(
            f"the {len(singular)} base parameters are independent, but not in double precision: "
            f"singular values range over {singular[0] / max(singular[-1], 1e-300):.0e}; "
            "accepted: lengths, and factors of 'follows', of like size"
        )


def _float(expr: sp.Expr, values: Values) -> float:
    return float(expr if expr.is_Rational else expr.subs(values).evalf(30))
