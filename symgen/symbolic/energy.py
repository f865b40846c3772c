"""The energy model of Gautier and Khalil (1988): linear in the parameters, no accelerations.

Kinetic and potential energy of link j are E_j + U_j = (DE + DU) X_j with

    DE = [w1^2/2, w1 w2, w1 w3, w2^2/2, w2 w3, w3^2/2,
          w3 V2 - w2 V3, w1 V3 - w3 V1, w2 V1 - w1 V2, V.V/2, qd_j^2/2]
    DU = [0, 0, 0, 0, 0, 0, -g1, -g2, -g3, -g . 0P_j, 0]

for XX XY XZ YY YZ ZZ MX MY MZ M IA, with w, V and g in frame j. The rotor of a coupling
u = qd_j + ratio qd_k has u^2/2; a payload has the columns of its link.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic.friction import drive_speed
from symgen.symbolic.kinematics import (
    Way,
    arrays,
    base_inputs,
    builder,
    variables,
    way_of,
)
from symgen.symbolic.motion import AT_REST, LinkState, base_velocity, velocities
from symgen.symbolic.parameters import Parameter, standard_parameters
from symgen.symbolic.spatial import UPPER, cross, dot
from symgen.symbolic.tape import Drawing, Tape, TapeBuilder

_HALF = sp.Rational(1, 2)


def energy_tape(robot: Robot) -> Tape:
    """Derive the column of total energy of every inertial standard parameter.

    Returns:
        A tape from q and qd to h(q, qd) = DE + DU, in the order of `standard_parameters`.
    """
    tape = builder(robot)
    links = velocities(way_of(robot, tape), base_velocity(robot, tape), tape)
    columns = _columns(robot, inertial_parameters(robot), [("D", links)], tape)
    return tape.tape(arrays(robot, "q", "qd"), [column for (column,) in columns])


def separate_tape(robot: Robot) -> Tape:
    """Derive DE, then DU, of every inertial standard parameter (Gautier and Khalil 1988, 31 to 35).

    Returns:
        A tape from q and qd to the columns of kinetic energy, then those of potential energy.
    """
    tape = builder(robot)
    way = way_of(robot, tape)
    columns = separate_columns(robot, inertial_parameters(robot), way, tape)
    return tape.tape(
        arrays(robot, "q", "qd"), [column for columns_ in columns for column in columns_]
    )


def inertial_parameters(robot: Robot) -> list[Parameter]:
    """Return the standard parameters with an energy column."""
    return [p for p in standard_parameters(robot) if p.inertial]


def separate_columns(
    robot: Robot,
    parameters: Sequence[Parameter],
    way: Way,
    tape: TapeBuilder,
) -> Iterator[tuple[sp.Expr, ...]]:
    """Return the columns of kinetic energy of some parameters, and those of potential energy.

    A robot with a free base has kinetic energy only.
    """
    base = base_velocity(robot, tape)
    if robot.floating:
        moving = velocities(way, base, tape)
        return zip(*_columns(robot, parameters, [("D", moving)], tape), strict=True)
    moving = velocities(way, AT_REST, tape)
    resting = velocities(tuple(step.still() for step in way), base, tape)
    return zip(*_columns(robot, parameters, [("D", moving), ("U", resting)], tape), strict=True)


def _columns(
    robot: Robot,
    parameters: Sequence[Parameter],
    states: Sequence[tuple[str, Mapping[int, LinkState]]],
    tape: TapeBuilder,
) -> list[list[sp.Expr]]:
    """Return a row for every parameter: its energy in each state; rotors move in the first."""
    speed = variables(robot, "qd")
    drives = {c.second: drive_speed(c, speed, tape) for c in robot.couplings}
    rows = []
    for p in parameters:
        if p.prefix in names.LINK:
            rows.append(
                [
                    _link_column(p.prefix, links[p.joint], f"{letter}{p.prefix}{p.joint}", tape)
                    for letter, links in states
                ]
            )
        else:
            driven = speed if p.prefix == names.ROTOR else drives
            own = _half_square(driven[p.joint], p.name, tape)
            rows.append([own, *(sp.S.Zero for _ in states[1:])])
    return rows


@dataclass(frozen=True)
class StateColumns:
    """The columns of parameters that are functions of the state x = (q, qd).

    They are the energies h(x) - h(x0), and q_j for an offset OF_j. If gravity g, or the motion of
    the base, is an input, the energies are h(x, g) - h(x0, g). The motion of a free base belongs to
    its state x.

    Attributes:
        robot: the mechanism.
        energy: tape of the inertial parameters among them.
        parameters: the parameters, in the order of the columns; inertial ones come first.
    """

    robot: Robot
    energy: Tape
    parameters: Sequence[Parameter]

    def only(self, places: Sequence[int]) -> StateColumns:
        """Return the columns of some of the parameters."""
        kept = [self.parameters[i] for i in places]
        energy = self.energy.keep([i for i in places if self.parameters[i].inertial])
        return StateColumns(self.robot, energy, kept)

    def differences(self, arithmetic: Drawing, count: int) -> NDArray[Any]:
        """Return the columns at random states, minus those at the first one, (count - 1, p)."""
        state = drawn_state(self.robot, arithmetic, count)
        for name, symbols in base_inputs(self.robot):
            state[name] = [arithmetic.numbers(count) for _ in symbols]
        position = {
            j: getattr(q, "number", q) for j, q in zip(self.robot.numbers, state["q"], strict=True)
        }
        columns = self.energy.run(arithmetic, state)
        if base_inputs(self.robot) and not self.robot.floating:
            rest = drawn_state(self.robot, arithmetic, 1)
            there = self.energy.run(arithmetic, {**state, **rest})
            columns = [arithmetic.sub(a, b) for a, b in zip(columns, there, strict=True)]
        energies = iter(columns)
        every = [next(energies) if p.inertial else position[p.joint] for p in self.parameters]
        h = stacked(every, count)
        return np.asarray(h[1:] - h[:1])


def drawn_state(robot: Robot, arithmetic: Drawing, count: int) -> dict[str, list[Any]]:
    """Draw joint variables and speeds at some points."""
    ratios = [c for j in robot.joints for _, c in j.shares if j.turns]
    parts = math.lcm(*(int(c.q) for c in ratios))
    q = [
        arithmetic.joint_angle(count, parts) if j.turns else arithmetic.numbers(count)
        for j in robot.movable
    ]
    return {"q": q, "qd": [arithmetic.numbers(count) for _ in robot.movable]}


def stacked(columns: Sequence[Any], count: int) -> NDArray[Any]:
    """Return columns, some of them constant, as a matrix with `count` rows."""
    return np.stack([np.broadcast_to(c, (count,)) for c in columns], axis=1)


def _half_square(v: sp.Expr, name: str, tape: TapeBuilder) -> sp.Expr:
    """Return v^2/2, with v/2 as a step that other columns of v share."""
    if v == 0:
        return sp.S.Zero
    v = -v if v.as_coeff_Mul()[0] < 0 else v
    half = tape.name(f"H{v.name}", _HALF * v)
    return tape.name(f"D{name}", half * v)


def _link_column(prefix: str, frame: LinkState, name: str, tape: TapeBuilder) -> sp.Expr:
    """Return the column DE + DU of one parameter of a link."""
    (w, V), g = frame.twist, frame.g
    if prefix in names.INERTIA:
        a, b = UPPER[names.INERTIA.index(prefix)]
        return _half_square(w[a], name[1:], tape) if a == b else tape.name(name, w[a] * w[b])
    if prefix in names.MOMENT:
        c = names.MOMENT.index(prefix)
        return tape.name(name, cross(V, w)[c] - g[c])
    kinetic = _HALF * tape.name(f"E{name}", dot(V, V))
    return tape.name(name, kinetic + frame.u)
