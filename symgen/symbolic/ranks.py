"""Exact ranks of parts of the equations of a floating base: the parameters that logs can show.

All ranks are those of columns at random states modulo two primes, as for the base parameters. Each
state gives one random combination of its equations. A contact that stays makes the velocity of its
point (or surface) zero, and its specific force -g:

    J (v, w, qd) = 0,    J (f, wd, qdd) + drift = -g (and 0 for the angular acceleration)

Its force is unknown. Only the equations in the null space of J remain. In flight, no wrench acts on
the base, and f and wd depend on X. Friction is left out: the equations of joints show it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symgen.errors import SymgenError
from symgen.robot.expressions import exact
from symgen.robot.tables import Contact
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters, modulo_primes
from symgen.symbolic.energy import drawn_state, stacked
from symgen.symbolic.modular import BadDrawError, PrimeField, Residues, reduce_rows
from symgen.symbolic.placement import link_drift_tape, link_jacobian_tape
from symgen.symbolic.regressor import torque_tape
from symgen.symbolic.tape import Tape

_BASE = 6  # equations of the base
_MARGIN = 10  # more states than columns
_State = dict[str, list[Any]]


@dataclass(frozen=True)
class Rank:
    """The rank of some equations.

    Attributes:
        rank: number of combinations of inertial base parameters that they show.
        unknown: the inertial base parameters that they do not determine.
    """

    rank: int
    unknown: tuple[str, ...]


def rank_of_rows(robot: Robot, base: BaseParameters, rows: str) -> Rank:
    """Return the rank of equations in any motion.

    Args:
        robot: a robot with a floating base.
        base: its base parameters.
        rows: "all", "base" for wrenches without torques, or "joints" for torques without wrenches.
    """
    part = {"all": slice(None), "base": slice(_BASE), "joints": slice(_BASE, None)}[rows]
    equations = _Equations.of(robot, base)

    def columns(field: PrimeField) -> Residues:
        state = _drawn(robot, field, equations.states)
        return _mixed(field, equations.regressor(field, state)[:, part])

    return equations.rank(columns)


def rank_in_contact(
    robot: Robot, base: BaseParameters, sets: Sequence[Collection[Contact]]
) -> Rank:
    """Return the rank of equations with unknown forces at contacts.

    Args:
        robot: a robot with a floating base.
        base: its base parameters.
        sets: the sets of contacts that stay at some time; the rank is that of all together.
    """
    equations = _Equations.of(robot, base)

    def columns(field: PrimeField) -> Residues:
        return np.vstack([equations.in_contact(field, contacts) for contacts in sets])

    return equations.rank(columns)


def rank_in_flight(robot: Robot, base: BaseParameters, *, torques: bool) -> Rank:
    """Return the rank of equations without any force on the robot, at drawn X.

    Args:
        robot: a robot with a floating base.
        base: its base parameters.
        torques: whether joint torques are known. Without them, X has one unknown factor.
    """
    equations = _Equations.of(robot, base)
    rows = slice(None if torques else _BASE)
    return equations.rank(lambda field: _mixed(field, equations.in_flight(field)[:, rows]))


@dataclass(frozen=True)
class _Equations:
    """The equations of a robot at drawn states, in its inertial base parameters."""

    robot: Robot
    names: tuple[str, ...]
    torques: Tape
    jacobian: Tape
    drift: Tape

    @classmethod
    def of(cls, robot: Robot, base: BaseParameters) -> _Equations:
        joints = tuple(replace(joint, friction=()) for joint in robot.joints)
        plain = replace(robot, joints=joints, effects=()).with_values()
        tape, rows = torque_tape(plain), len(robot.equations)
        width = len(tape.outputs) // rows
        kept = [b for b in base.parameters if b.inertial]
        tape = tape.keep([row * width + b.index for row in range(rows) for b in kept])
        names = tuple(b.name for b in kept)
        return cls(plain, names, tape, link_jacobian_tape(plain), link_drift_tape(plain))

    @property
    def states(self) -> int:
        """Number of states N."""
        return len(self.names) + _MARGIN

    def rank(self, columns: Callable[[PrimeField], Residues]) -> Rank:
        found = set()
        for sample in modulo_primes(self.robot, columns):
            pivots, rows = reduce_rows(sample.matrix, sample.field.p)
            shared = (rows != 0).sum(axis=1) > 1
            known = {k for k, more in zip(pivots, shared, strict=True) if not more}
            unknown = (name for k, name in enumerate(self.names) if k not in known)
            found.add(Rank(len(pivots), tuple(unknown)))
        if len(found) > 1:
            raise SymgenError("the exact rank differs between primes: an unlucky draw")
        return found.pop()

    def regressor(self, field: PrimeField, state: _State) -> Residues:
        """Return the columns (N, m, p) at some states."""
        W = stacked(self.torques.run(field, state), self.states) % field.p
        return W.reshape(self.states, len(self.robot.equations), -1)

    def in_contact(self, field: PrimeField, contacts: Collection[Contact]) -> Residues:
        """Return combinations of equations that forces at contacts do not reach, (N, p)."""
        state = _drawn(self.robot, field, self.states)
        J = self._at(field, self.jacobian, contacts, state)
        spaces = [_solved(field, j, 0 * j[:, 0])[1] for j in J]
        virtual, u = ([_within(field, Z) for Z in spaces] for _ in range(2))
        state |= _split(u, "v", "w", "qd")
        drift = self._at(field, self.drift, contacts, state)[:, :, 0]
        gravity = np.zeros((self.states, len(contacts), _BASE), np.int64)
        gravity[:, :, :3] = np.stack(state["g"], axis=1)[:, None]
        rows = [k for c, contact in enumerate(contacts) for k in _rows(contact, _BASE * c)]
        held = -drift - gravity.reshape(self.states, -1)[:, rows]
        a = [
            _solved(field, j, h)[0] + _within(field, Z)
            for j, h, Z in zip(J, held % field.p, spaces, strict=True)
        ]
        state |= _split(a, "f", "wd", "qdd")
        return _weighed(field, np.array(virtual), self.regressor(field, state))

    def _at(
        self, field: PrimeField, tape: Tape, contacts: Collection[Contact], state: _State
    ) -> Residues:
        """Return rows of a tape of a point at all contacts, (N, rows, columns)."""
        parts = []
        for contact in contacts:
            frame = self.robot.frame(contact.frame)
            link = [int(joint.number == frame.joint) for joint in self.robot.bodies]
            point = [field.constant(exact(x)) for x in frame.xyz]
            out = tape.run(field, {**state, "link": link, "point": point})
            rows = stacked(out, self.states).reshape(self.states, _BASE, -1)
            parts.append(rows[:, _rows(contact, 0)])
        return np.concatenate(parts, axis=1) % field.p

    def in_flight(self, field: PrimeField) -> Residues:
        """Return the columns (N, m, p) where no force acts on the robot, with drawn X."""
        state, p = _drawn(self.robot, field, self.states), field.p
        X = field.numbers(len(self.names))
        wrenches = []
        for k in range(_BASE + 1):  # linear in f and wd: six unit vectors, then zero
            unit = np.zeros((self.states, _BASE), np.int64)
            unit[:, k : k + 1] = 1
            W = self.regressor(field, state | _split([*unit], "f", "wd"))
            wrenches.append((W[:, :_BASE] * X % p).sum(axis=2) % p)
        rest = wrenches.pop()
        A = np.stack([wrench - rest for wrench in wrenches], axis=2) % p
        a = [_solved(field, m, -r % p)[0] for m, r in zip(A, rest, strict=True)]
        return self.regressor(field, state | _split(a, "f", "wd"))


def _rows(contact: Contact, first: int) -> list[int]:
    """Return the rows of a contact among six: of the velocity, and of the turning of a surface."""
    return [*range(first, first + (3 if contact.kind == "point" else _BASE))]


def _split(vectors: Sequence[Residues], *names: str) -> _State:
    """Return vectors (N, m) as inputs of a tape: linear and angular motion, then joints."""
    parts = np.split(np.array(vectors), (3, _BASE), axis=1)
    return {name: list(part.T) for name, part in zip(names, parts, strict=False)}


def _drawn(robot: Robot, field: PrimeField, count: int) -> _State:
    """Draw joints and the motion of the base, and gravity g in its axes."""
    state = drawn_state(robot, field, count)
    state["qdd"] = [field.numbers(count) for _ in robot.movable]
    for name in ("f", "v", "w", "wd", "g"):
        state[name] = [field.numbers(count) for _ in range(3)]
    return state


def _mixed(field: PrimeField, columns: Residues) -> Residues:
    """Return one random combination of the equations of each state, (N, p), of (N, rows, p)."""
    weight = field.numbers(columns.shape[0] * columns.shape[1])
    return _weighed(field, weight.reshape(columns.shape[:2]), columns)


def _weighed(field: PrimeField, weight: Residues, columns: Residues) -> Residues:
    products = weight[:, :, None] * columns % field.p
    return np.asarray(products.sum(axis=1) % field.p)


def _solved(field: PrimeField, A: Residues, b: Residues) -> tuple[Residues, Residues]:
    """Return a solution of A x = b, and a basis (columns) of the null space of A."""
    size = A.shape[1]
    pivots, rows = reduce_rows(np.hstack([A, b[:, None]]), field.p)
    if size in pivots:
        raise BadDrawError("contacts that cannot stay together at this point")
    x = np.zeros(size, np.int64)
    x[pivots] = rows[:, size]
    free = [k for k in range(size) if k not in pivots]
    Z = np.zeros((size, len(free)), np.int64)
    Z[free, range(len(free))] = 1
    Z[pivots] = -rows[:, free] % field.p
    return x, Z


def _within(field: PrimeField, Z: Residues) -> Residues:
    """Return a random vector of the space that the columns of Z span."""
    products = Z * field.numbers(Z.shape[1]) % field.p
    return np.asarray(products.sum(axis=1) % field.p)
