"""Check of the exact base parameters in floating point.

Exact arithmetic modulo a prime is right if the code maps the geometry into it consistently. This
check does not share that code. It evaluates the columns in double precision at the file's values:
the columns kept must be independent, and every regrouping must reproduce its column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.errors import SymgenError
from symgen.robot.types import Robot
from symgen.symbolic.elimination import ExactRow
from symgen.symbolic.energy import stacked, state_columns
from symgen.symbolic.kinematics import base_inputs, joint_map
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.tape import Numbers, Tape

#: Numpy's form of every function that a tape may hold.
FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "abs": np.abs,
    "sign": np.sign,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
}
_MARGIN = 10
#: Singular values of the kept columns, scaled, below which floats would call them dependent; far
#: below what any useful geometry has, far above rounding.
_DEPENDENT = 1e-13
_ERROR = 1e-6


def random_states(robot: Robot, count: int, seed: int = 0) -> list[NDArray[np.float64]]:
    """Return random q, qd, qdd, (count, n), over all postures of a robot."""
    draw = np.random.default_rng(seed)
    span = np.array([np.pi if j.turns else 1.0 for j in robot.movable])
    return [size * span * draw.uniform(-1, 1, (count, robot.n)) for size in (1.0, 1.0, 2.0)]


def random_inputs(robot: Robot, count: int, seed: int) -> dict[str, list[NDArray[np.float64]]]:
    """Return random states as inputs of a tape, with those of the base if it is an input."""
    states = random_states(robot, count, seed)
    inputs = {name: list(x.T) for name, x in zip(("q", "qd", "qdd"), states, strict=True)}
    for (name, _), x in zip(base_inputs(robot), random_base(robot, count), strict=True):
        inputs[name] = list(x.T)
    return inputs


def random_base(robot: Robot, count: int) -> list[NDArray[np.float64]]:
    """Return random values of the inputs that describe the base, (count, 3) each."""
    draw = np.random.default_rng(count)
    return [draw.uniform(-10, 10, (3, count)).T for _ in base_inputs(robot)]


def require_floats_agree(
    robot: Robot,
    energy: Tape,
    parameters: Sequence[Parameter],
    kept: Sequence[int],
    rows: Mapping[str, ExactRow],
) -> None:
    """Raise SymgenError if double precision contradicts the exact base parameters.

    Args:
        robot: the mechanism, with the file's values.
        energy: tape of the energy columns.
        parameters: those with a column of the state.
        kept: positions of the base parameters among them.
        rows: the relation of every other one.
    """
    values = robot.values()
    count = len(parameters) + _MARGIN
    state = random_inputs(robot, count, len(parameters))
    rest = {key: [x[:1] for x in state[key]] for key in ("q", "qd")}
    arithmetic, positions = Numbers(values, FUNCTIONS), joint_map(robot, state["q"])
    out = state_columns(energy, parameters, arithmetic, state, rest, positions)
    W = stacked(out, count).astype(float)
    W = W[1:] - W[0]
    column = {p.name: W[:, i] for i, p in enumerate(parameters)}
    size = max(1.0, float(np.abs(W).max(initial=0.0)))
    for name, row in rows.items():
        parts = [float(c.value.subs(values).evalf(30)) * column[n] for n, c in row.items()]
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
