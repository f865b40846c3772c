"""Position and orientation of every frame in frame 0, and Jacobians and drift of points.

The link of a point is chosen at run time by one symbol for each link: 1 for the chosen link, and 0
for the others. Sums over these symbols select its frame, and the joints that move it. The code
therefore needs no branches.

With a free base, frame 0 moves. A Jacobian has six more columns before those of the joints, of the
velocities v and w of the base, and velocities are expressed in the axes of frame 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from symgen import names
from symgen.robot.exact_numbers import written_fraction
from symgen.robot.expressions import exact
from symgen.robot.types import Joint, Robot
from symgen.symbolic.bodies import Inertia
from symgen.symbolic.constraints import spread, to_variables
from symgen.symbolic.kinematics import (
    Way,
    arrays,
    axes,
    builder,
    cosine_sine,
    path,
    variables,
    way_of,
)
from symgen.symbolic.motion import (
    AT_REST,
    REAL,
    LinkState,
    accelerations,
    base_acceleration,
    moved,
)
from symgen.symbolic.spatial import (
    ZERO,
    Screw,
    Shift,
    Turn,
    Vector,
    around,
    axis,
    cross,
    dot,
    named,
    plus,
    scaled,
    unit_vector,
)
from symgen.symbolic.tape import Symbols, Tape, TapeBuilder, real_symbol

Place = tuple[Vector, ...]  # axes x, y, z and origin, in frame 0


def link_places(robot: Robot, tape: TapeBuilder) -> tuple[dict[int, Place], Way]:
    """Return the pose of every frame in frame 0, by joint number, and the steps to it."""
    way = way_of(robot, tape)
    out: dict[int, Place] = {0: (*map(unit_vector, range(3)), ZERO)}
    for step in way:
        place = out[step.joint.antecedent]
        for motion in step.way:
            place = moved_place(place, motion, tape)
        out[step.joint.number] = place
    return out, way


def moved_place(place: Place, motion: Turn | Shift, tape: TapeBuilder) -> Place:
    columns, k = list(place), motion.axis
    if isinstance(motion, Shift):
        origin = plus(place[3], scaled(motion.length, place[k]))
        columns[3] = named(origin, f"p{motion.tag}_", tape)
    else:
        a, b = around(k)
        new = {
            a: plus(scaled(motion.c, place[a]), scaled(motion.s, place[b])),
            b: plus(scaled(motion.c, place[b]), scaled(-motion.s, place[a])),
        }
        for i, column in new.items():
            columns[i] = named(column, f"R{i + 1}{motion.tag}_", tape)
    return tuple(columns)


def frames_tape(robot: Robot) -> Tape:
    """Derive 0T_j of every link, fixed ones included: (links, 4, 4), row-major."""
    tape = builder(robot)
    placed, _ = link_places(robot, tape)
    bottom = [sp.S.Zero, sp.S.Zero, sp.S.Zero, sp.S.One]
    out: list[sp.Expr] = []
    for joint in robot.joints:
        for row in zip(*placed[joint.number], strict=True):
            out += row
        out += bottom
    return tape.tape(arrays(robot, "q"), out)


def jacobian_tape(robot: Robot) -> Tape:
    """Derive the Jacobian of the last moving frame: rows v then w, (6, n), row-major.

    A fixed joint on the base that comes after it in the file, as in a URDF, does not count.
    """
    tape = builder(robot)
    placed, _ = link_places(robot, tape)
    moving = {j.number for j in robot.moving}
    paths = (path(robot, joint.number) for joint in reversed(robot.joints))
    way = next(numbers for numbers in paths if moving.intersection(numbers))
    tip = placed[way[0]][3]
    columns = _base_columns(robot, tip, "a", tape)
    for joint in robot.moving:
        j = joint.number
        if j in way:
            columns[j] = _column(joint, placed, tip, placed[j][2], "a", tape)
    return tape.tape(arrays(robot, "q"), _rows(robot, columns, tape))


def links(robot: Robot) -> Symbols:
    """Return the symbols that select a link, in file order; that of a free base comes first."""
    return tuple(real_symbol(f"X_at{joint.number}") for joint in robot.bodies)


def coordinates(letter: str, count: int = 3) -> Symbols:
    """Return symbols for the coordinates of a point or the entries of a small array."""
    return tuple(real_symbol(f"X_{letter}{i + 1}") for i in range(count))


def selected_link(robot: Robot, number: int) -> list[int]:
    """Return the input `link` of tapes: 1 for the link of a joint, 0 for all others."""
    return [int(joint.number == number) for joint in robot.bodies]


def link_jacobian_tape(robot: Robot) -> Tape:
    """Derive the Jacobian of a point of a link in frame 0: rows v then w, (6, n), row-major."""
    tape = _builder(robot)
    placed, _ = link_places(robot, tape)
    *axes, origin = (_chosen(robot, placed, k, f"R{k}", tape) for k in range(4))
    offsets = (scaled(c, a) for a, c in zip(axes, coordinates("c"), strict=True))
    tip = named(plus(origin, *offsets), "t", tape)
    at = dict(zip((j.number for j in robot.bodies), links(robot), strict=True))
    columns = _base_columns(robot, tip, "r", tape)
    for joint in robot.moving:
        j = joint.number
        behind = [at[k.number] for k in robot.joints if j in path(robot, k.number)]
        moves = tape.name(f"a{j}", sp.Add(*behind))
        z = named(scaled(moves, placed[j][2]), f"z{j}_", tape)
        columns[j] = _column(joint, placed, tip, z, "r", tape)
    return _close(robot, tape, _rows(robot, columns, tape), "q")


def _column(
    joint: Joint,
    placed: Mapping[int, Place],
    tip: Vector,
    z: Vector,
    letter: str,
    tape: TapeBuilder,
) -> Screw:
    """Return velocity and angular velocity of a point for a unit speed of a joint about z."""
    if axis(joint.sigma)[0] == ZERO:
        return z, ZERO
    j = joint.number
    arm = named(plus(tip, scaled(sp.S.NegativeOne, placed[j][3])), f"{letter}{j}_", tape)
    return named(cross(z, arm), f"v{j}_", tape), z


def _base_columns(robot: Robot, tip: Vector, letter: str, tape: TapeBuilder) -> dict[int, Screw]:
    """Return velocity and angular velocity of a point for unit velocities of a free base."""
    base = {number: axes(robot)[number][1] for number in robot.free}
    return {
        number: (plus(v, named(cross(w, tip), f"{letter}{number}_", tape)), w)
        for number, (w, v) in base.items()
    }


def _rows(robot: Robot, columns: Mapping[int, Screw], tape: TapeBuilder) -> list[sp.Expr]:
    """Return the entries of a Jacobian over the equations, row-major."""
    rows: list[sp.Expr] = []
    for row in range(6):
        entries = {j: column[row // 3][row % 3] for j, column in columns.items()}
        moved = to_variables(robot, entries, f"J{row}", tape)
        rows += [moved.get(number, sp.S.Zero) for number in robot.equations]
    return rows


def link_drift_tape(robot: Robot) -> Tape:
    """Derive dJ/dt qd of a point of a link in frame 0: (6,), linear then angular.

    With a free base, J (f, wd, qdd) plus this is specific force and angular acceleration.
    """
    tape = _builder(robot)
    placed, way = link_places(robot, tape)
    base = AT_REST
    if robot.floating:
        base = LinkState(ZERO, ZERO, w=base_acceleration(robot, tape).w)
    motion = {j: (m.w, m.dw, m.a) for j, m in accelerations(way, base, {}, tape).items()}
    w, dw, a = (_chosen(robot, motion, k, letter, tape) for k, letter in enumerate("wxy"))
    axes = [_chosen(robot, placed, k, f"R{k}", tape) for k in range(3)]
    point = coordinates("c")
    swung = named(cross(w, point), "s", tape)
    local = named(plus(a, cross(dw, point), cross(w, swung)), "u", tape), dw
    out = [
        tape.name(f"D{part}_{i}", dot(tuple(axis_[i] for axis_ in axes), vector))
        for part, vector in enumerate(local)
        for i in range(3)
    ]
    return _close(robot, tape, out, "q", "qd")


def tool_wrench_tape(robot: Robot) -> Tape:
    """Derive the wrench of a tool in the frame of the sensor, plus an offset: force, moment, (6,).

    The frame of the sensor is Trans(x, y, z) Rot(z, yaw) Rot(y, pitch) Rot(x, roll) in that of its
    link.
    """
    assert robot.sensor is not None  # other robots have no such kernel
    frame = robot.frame(robot.sensor.frame)
    load, offset = coordinates("l", len(names.LINK)), coordinates("o", 6)
    tape = builder(robot, (*load, *offset))
    qdd = spread(robot, variables(robot, "qdd"), tape)
    base = base_acceleration(robot, tape)
    motion = accelerations(way_of(robot, tape), base, qdd, tape)[frame.joint]
    for axis_, length in enumerate(frame.xyz):
        shift = Shift(axis_, tape.constant(f"xs{axis_}", exact(length)), f"s{axis_}")
        motion = moved(motion, shift, REAL, tape)
    for axis_, angle in reversed([*enumerate(frame.rpy)]):
        c, s = cosine_sine(written_fraction(exact(angle)))
        tag = f"y{axis_}"
        turn = Turn(axis_, tape.constant(f"C{tag}", c), tape.constant(f"S{tag}", s), tag)
        motion = moved(motion, turn, REAL, tape)
    tool = Inertia.of(dict(zip(names.LINK, load, strict=True)))
    force, moment = tool.wrench(motion, len(robot.joints) + 1, tape)
    wrench = named(plus((*force, *moment), offset), "w", tape)
    inputs = [*arrays(robot, "q", "qd", "qdd"), ("load", load), ("offset", offset)]
    return tape.tape(inputs, wrench)


def _builder(robot: Robot) -> TapeBuilder:
    return builder(robot, (*links(robot), *coordinates("c")))


def _close(robot: Robot, tape: TapeBuilder, outputs: Sequence[sp.Expr], *states: str) -> Tape:
    inputs = arrays(robot, *states)
    return tape.tape([*inputs, ("link", links(robot)), ("point", coordinates("c"))], outputs)


def _chosen(
    robot: Robot,
    vectors: Mapping[int, Sequence[Vector]],
    k: int,
    letter: str,
    tape: TapeBuilder,
) -> Vector:
    """Return vector k of the chosen link."""
    pairs = zip(links(robot), robot.bodies, strict=True)
    parts = (scaled(at, vectors[joint.number][k]) for at, joint in pairs)
    return named(plus(*parts), f"{letter}c", tape)
