"""A point fixed in any link: its Jacobian, and what is left of its acceleration without qdd.

The link is chosen at run time by one symbol for each link, 1 at its own and 0 elsewhere: sums over
these pick its frame, and say of each joint whether it moves the link. Straight-line code stays so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.bodies import cross, named
from symgen.symbolic.constraints import folded
from symgen.symbolic.kinematics import ZERO, Vector, variables
from symgen.symbolic.motion import motions
from symgen.symbolic.placement import Place, path, places
from symgen.symbolic.tape import Tape, TapeBuilder


def links(robot: Robot) -> tuple[sp.Symbol, ...]:
    """Return the symbols that choose a link, in file order."""
    return tuple(sp.Symbol(f"X_at{joint.number}", real=True) for joint in robot.joints)


def coordinates(letter: str, count: int = 3) -> tuple[sp.Symbol, ...]:
    """Return symbols for the coordinates of a point or the entries of a small array."""
    return tuple(sp.Symbol(f"X_{letter}{i + 1}", real=True) for i in range(count))


def link_jacobian_tape(robot: Robot) -> Tape:
    """Derive the Jacobian of a point of a link in frame 0: rows v then w, (6, n), row-major."""
    tape = _builder(robot, variables(robot).q)
    placed, _ = places(robot, tape)
    tip = _point(robot, placed, tape)
    at = dict(zip((j.number for j in robot.joints), links(robot), strict=True))
    columns: dict[int, tuple[Vector, Vector]] = {}
    for joint in robot.moving:
        j = joint.number
        behind = [at[k.number] for k in robot.joints if j in path(robot, k.number)]
        moves = tape.name(f"a{j}", sum(behind, sp.S.Zero))
        _, _, axis, origin = placed[j]
        z = named((moves * axis[0], moves * axis[1], moves * axis[2]), f"z{j}_", tape)
        if joint.sigma == names.PRISMATIC:
            columns[j] = (z, ZERO)
        else:
            arm = [tape.name(f"r{j}_{i + 1}", tip[i] - origin[i]) for i in range(3)]
            columns[j] = (named(cross(z, (arm[0], arm[1], arm[2])), f"v{j}_", tape), z)
    rows: list[sp.Expr] = []
    for part in range(2):
        for i in range(3):
            row = {j: column[part][i] for j, column in columns.items()}
            moved = folded(robot, row, f"J{3 * part + i}", tape)
            rows += [moved.get(joint.number, sp.S.Zero) for joint in robot.movable]
    return tape.tape(_inputs(robot, ("q",)), rows)


def link_drift_tape(robot: Robot) -> Tape:
    """Derive dJ/dt qd of a point of a link in frame 0: (6,), linear then angular."""
    variable = variables(robot)
    tape = _builder(robot, (*variable.q, *variable.qd))
    placed, way = places(robot, tape)
    motion = motions(way, ZERO, {}, tape)
    numbers = [joint.number for joint in robot.joints]
    w, dw, a = (
        _chosen(robot, [getattr(motion[j], key) for j in numbers], letter, tape)
        for key, letter in (("w", "w"), ("dw", "x"), ("a", "y"))
    )
    axes = [_chosen(robot, [placed[j][k] for j in numbers], f"R{k}", tape) for k in range(3)]
    point = coordinates("c")
    swung = named(cross(w, point), "s", tape)
    linear = [a[i] + cross(dw, point)[i] + cross(w, swung)[i] for i in range(3)]
    local = (named((linear[0], linear[1], linear[2]), "u", tape), dw)
    out = [
        tape.name(f"D{part}_{i}", sum((axes[k][i] * vector[k] for k in range(3)), sp.S.Zero))
        for part, vector in enumerate(local)
        for i in range(3)
    ]
    return tape.tape(_inputs(robot, ("q", "qd")), out)


def _builder(robot: Robot, symbols: tuple[sp.Symbol, ...]) -> TapeBuilder:
    return friction.builder(robot, (*symbols, *links(robot), *coordinates("c")))


def _inputs(robot: Robot, states: Sequence[str]) -> list[tuple[str, Sequence[sp.Symbol]]]:
    variable = variables(robot)
    arrays = [(name, getattr(variable, name)) for name in states]
    return [*arrays, ("link", links(robot)), ("point", coordinates("c"))]


def _chosen(robot: Robot, vectors: Sequence[Vector], letter: str, tape: TapeBuilder) -> Vector:
    """Return the vector of the chosen link."""
    parts = [
        sum((at * v[i] for at, v in zip(links(robot), vectors, strict=True)), sp.S.Zero)
        for i in range(3)
    ]
    return named((parts[0], parts[1], parts[2]), f"{letter}c", tape)


def _point(robot: Robot, placed: Mapping[int, Place], tape: TapeBuilder) -> Vector:
    """Return where the point is, in frame 0."""
    numbers = [joint.number for joint in robot.joints]
    x, y, z, origin = (
        _chosen(robot, [placed[j][k] for j in numbers], f"R{k}", tape) for k in range(4)
    )
    cx, cy, cz = coordinates("c")
    parts = [origin[i] + x[i] * cx + y[i] * cy + z[i] * cz for i in range(3)]
    return named((parts[0], parts[1], parts[2]), "t", tape)
