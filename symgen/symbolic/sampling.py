"""Random states of a robot, and the outputs of a tape at them in double precision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.robot.types import Robot
from symgen.symbolic.energy import stacked
from symgen.symbolic.kinematics import base_inputs
from symgen.symbolic.tape import Numbers, Tape, Values

#: NumPy's form of every function in a tape.
FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "abs": np.abs,
    "sign": np.sign,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
}


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


def columns_at(
    tape: Tape, values: Values, inputs: Mapping[str, Sequence[Any]], count: int
) -> NDArray[np.float64]:
    """Return the outputs of a tape at some states, (count, outputs).

    Args:
        tape: tape of columns.
        values: named length -> exact value.
        inputs: entries of every input array, (count,) each.
        count: number of states.
    """
    return stacked(tape.run(Numbers(values, FUNCTIONS), inputs), count).astype(float)
