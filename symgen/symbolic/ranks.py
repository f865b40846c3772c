"""Exact ranks of parts of the equations of a floating base: the parameters that logs can show.

All ranks are those of columns at random states modulo two primes, as for the base parameters. Each
state gives one random combination of its equations. A contact that stays makes the velocity of its
point (or surface) zero, and its specific force -g:

    J (v, w, qd) = 0,    J (f, wd, qdd) + drift + g = 0 (without g for the angular acceleration)

Its force is unknown. Only the equations in the null space of J remain. In flight, no wrench acts on
the base, and f and wd depend on X. Friction is ignored: the equations of joints show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from symgen.errors import SymgenError
from symgen.robot.expressions import exact
from symgen.robot.tables import Contact
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters, modulo_primes
from symgen.symbolic.energy import drawn_state, stacked
from symgen.symbolic.modular import BadDrawError, PrimeField, Residues, reduce_rows
from symgen.symbolic.placement import link_drift_tape, link_jacobian_tape, selected_link
from symgen.symbolic.regressor import torque_tape
from symgen.symbolic.tape import Tape

_BASE = 6  # equations of the base
_MARGIN = 10  # more states than columns
_ROWS = {"all": slice(None), "base": slice(_BASE), "joints": slice(_BASE, None)}


@dataclass(frozen=True)
class EquationPart:
    """Equations that a span of a log gives.

    Attributes:
        rows: "all", "base" for wrenches without torques, "joints" for torques without wrenches, or
            "power" for their power in a frame of any speed, as in the energy model.
        contacts: contacts that stay, with unknown forces; all rows count.
        flight: whether no force acts on the robot, for drawn X.
    """

    rows: str = "all"
    contacts: tuple[Contact, ...] = ()
    flight: bool = False


@dataclass(frozen=True)
class Rank:
    """The rank of some equations.

    Attributes:
        rank: number of combinations of inertial base parameters that they show.
        unknown: the inertial base parameters that they do not determine.
    """

    rank: int
    unknown: tuple[str, ...]


def exact_rank(robot: Robot, base: BaseParameters, parts: Sequence[EquationPart]) -> Rank:
    """Return the rank of the equations of some parts, as one system.

    Args:
        robot: a robot with a floating base.
        base: its base parameters.
        parts: the equations that logs give.
    """
    (rank,) = exact_ranks(robot, base, [parts])
    return rank


def exact_ranks(
    robot: Robot, base: BaseParameters, systems: Sequence[Sequence[EquationPart]]
) -> list[Rank]:
    """Return the ranks of some systems of equations; see `exact_rank`.

    The equations of a part are drawn once for all systems.

    Args:
        robot: a robot with a floating base.
        base: its base parameters.
        systems: the parts of each system.
    """
    names = tuple(p.name for p in base.parameters if p.inertial)
    parts = [*dict.fromkeys(part for system in systems for part in system)]
    equations = _equations(robot, base)
    samples = modulo_primes(
        equations.robot,
        lambda field: np.vstack([_rows(equations, part, field) for part in parts]),
    )
    ranks = []
    for sample in samples:
        rows = dict(zip(parts, np.split(sample.matrix, len(parts)), strict=True))
        of_systems = (np.vstack([rows[part] for part in system]) for system in systems)
        ranks.append([_rank(names, matrix, sample.field.p) for matrix in of_systems])
    if ranks[0] != ranks[1]:
        raise SymgenError("the exact rank differs between primes: an unlucky draw")
    return ranks[0]


def _rank(names: Sequence[str], matrix: Residues, p: int) -> Rank:
    """Return the rank of rows modulo a prime, with the names of undetermined columns."""
    pivots, rows = reduce_rows(matrix, p)
    shared = (rows != 0).sum(axis=1) > 1
    known = {k for k, more in zip(pivots, shared, strict=True) if not more}
    unknown = (name for k, name in enumerate(names) if k not in known)
    return Rank(len(pivots), tuple(unknown))


class _Equations(NamedTuple):
    """A robot without friction, and tapes of its columns (m, p) and of points of its links."""

    robot: Robot
    torques: Tape
    jacobian: Tape
    drift: Tape


def _equations(robot: Robot, base: BaseParameters) -> _Equations:
    """Return the equations of a robot."""
    joints = tuple(replace(joint, friction=()) for joint in robot.joints)
    robot = replace(robot, joints=joints, effects=()).with_values()
    tape, rows = torque_tape(robot), range(len(robot.equations))
    width = len(tape.outputs) // len(rows)
    places = [p.index for p in base.parameters if p.inertial]
    torques = tape.keep([row * width + place for row in rows for place in places])
    return _Equations(robot, torques, link_jacobian_tape(robot), link_drift_tape(robot))


def _rows(equations: _Equations, part: EquationPart, field: PrimeField) -> Residues:
    """Return a combination of the equations of a part at each of N states, (N, p)."""
    robot, torques, jacobian, drifts = equations
    m, p = len(robot.equations), field.p
    width = len(torques.outputs) // m
    count = width + _MARGIN
    state = drawn_state(robot, field, count)

    def drawn(size: int) -> Residues:
        return field.numbers(count * size).reshape(count, size)

    def run(tape: Tape, rows: int, **more: Any) -> Residues:
        out = stacked(tape.run(field, {**state, **more}), count)
        return np.asarray(out.reshape(count, rows, -1) % p)

    def at_contacts(tape: Tape) -> Residues:
        parts = []
        for contact in part.contacts:
            frame = robot.frame(contact.frame)
            link = selected_link(robot, frame.joint)
            point = [field.constant(exact(x)) for x in frame.xyz]
            rows = run(tape, _BASE, link=link, point=point)
            parts.append(rows[:, : contact.rows])
        return np.concatenate(parts, axis=1)

    state |= _split(drawn(m), "f", "wd", "qdd") | _split(drawn(_BASE), "v", "w")
    weight = np.zeros((count, m), np.int64)
    if part.rows == "power":
        weight = np.column_stack([*state["v"], *state["w"], *state["qd"]])
    else:
        weight[:, _ROWS[part.rows]] = drawn(m)[:, _ROWS[part.rows]]
    if part.contacts:
        J = at_contacts(jacobian)
        weight, speed = _null_vectors(field, J), _null_vectors(field, J)
        state |= _split(speed, "v", "w", "qd")
        drift = at_contacts(drifts)
        linear = [row < 3 for c in part.contacts for row in range(c.rows)]
        gravity = np.tile(drawn(3), sum(linear) // 3)
        drift[:, linear, 0] += gravity
        state |= _split(_solutions(field, J, drift % p), "f", "wd", "qdd")
    if part.flight:
        # all parts are of one robot
        X, wrenches = np.random.default_rng(p).integers(1, p, width), []
        for k in range(_BASE + 1):  # linear in f and wd: six unit vectors, then zero
            unit = np.eye(1, _BASE, k, dtype=np.int64).repeat(count, axis=0)
            W = run(torques, m, **_split(unit, "f", "wd"))[:, :_BASE]
            wrenches.append((W * X % p).sum(axis=2) % p)
        *parts, rest = wrenches
        A = np.stack([wrench - rest for wrench in parts], axis=2)
        state |= _split(_solutions(field, A, rest[:, :, None]), "f", "wd")
    products = weight[:, :, None] * run(torques, m) % p
    return np.asarray(products.sum(axis=1) % p)


def _split(vectors: Residues, *names: str) -> dict[str, Any]:
    """Return vectors (N, m) as inputs of a tape: linear and angular motion, then joints."""
    parts = np.split(vectors, (3, _BASE), axis=1)
    return {name: list(part.T) for name, part in zip(names, parts, strict=False)}


def _solutions(field: PrimeField, A: Residues, b: Residues) -> Residues:
    """Return a random solution of A x + b = 0 for each of N systems."""
    x = _null_vectors(field, np.concatenate([A, b], axis=2))
    if not x[:, -1].all():
        raise BadDrawError("an equation has no solution at this point")
    scale = np.array([pow(int(last), -1, field.p) for last in x[:, -1]])
    return np.asarray(x[:, :-1] * scale[:, None] % field.p)


def _null_vectors(field: PrimeField, A: Residues) -> Residues:
    """Return a random vector of the null space of each of N matrices."""
    out = []
    for matrix in A:
        pivots, rows = reduce_rows(matrix, field.p)
        vector = field.numbers(matrix.shape[1])
        vector[pivots] = 0
        vector[pivots] = -(rows * vector % field.p).sum(axis=1) % field.p
        out.append(vector)
    return np.array(out)
