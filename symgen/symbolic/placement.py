"""Kinematics: the place of every frame in frame 0, and the Jacobian of the last that moves."""

from __future__ import annotations

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.bodies import cross, named
from symgen.symbolic.constraints import folded
from symgen.symbolic.kinematics import Shift, Step, Turn, Vector, steps, variables
from symgen.symbolic.tape import Tape, TapeBuilder

Place = tuple[Vector, Vector, Vector, Vector]  # axes x, y, z and origin, in frame 0


def places(robot: Robot, tape: TapeBuilder) -> tuple[dict[int, Place], tuple[Step, ...]]:
    """Return the place of every frame in frame 0, by joint number, and the way that leads there."""
    way = steps(robot, variables(robot), tape)
    unit = [tuple(sp.Integer(int(i == k)) for i in range(3)) for k in range(4)]
    out: dict[int, Place] = {0: (unit[0], unit[1], unit[2], unit[3])}
    for step in way:
        place = out[step.joint.antecedent]
        for motion in (*step.before, *step.after):
            place = _moved(place, motion, tape)
        out[step.joint.number] = place
    return out, way


def _moved(place: Place, motion: Turn | Shift, tape: TapeBuilder) -> Place:
    columns = list(place)
    k = motion.axis
    if isinstance(motion, Shift):
        shift = [p + motion.length * z for p, z in zip(place[3], place[k], strict=True)]
        columns[3] = named((shift[0], shift[1], shift[2]), f"p{motion.tag}_", tape)
    else:
        a, b = (k + 1) % 3, (k + 2) % 3
        pairs = list(zip(place[a], place[b], strict=True))
        first = [motion.c * x + motion.s * y for x, y in pairs]
        second = [motion.c * y - motion.s * x for x, y in pairs]
        columns[a] = named((first[0], first[1], first[2]), f"R{a + 1}{motion.tag}_", tape)
        columns[b] = named((second[0], second[1], second[2]), f"R{b + 1}{motion.tag}_", tape)
    return (columns[0], columns[1], columns[2], columns[3])


def path(robot: Robot, number: int) -> list[int]:
    """Return the numbers of the joints from one down to the base."""
    out = []
    while number:
        out.append(number)
        number = robot.joint(number).antecedent
    return out


def frames_tape(robot: Robot) -> Tape:
    """Derive 0T_j of every link, fixed ones included: (links, 4, 4), row-major."""
    tape = friction.builder(robot, variables(robot).q)
    placed, _ = places(robot, tape)
    bottom = [sp.S.Zero, sp.S.Zero, sp.S.Zero, sp.S.One]
    out: list[sp.Expr] = []
    for joint in robot.joints:
        place = placed[joint.number]
        for i in range(3):
            out += [column[i] for column in place]
        out += bottom
    return tape.tape([("q", variables(robot).q)], out)


def jacobian_tape(robot: Robot) -> Tape:
    """Derive the Jacobian of the last frame that moves: rows v then w, (6, n), row-major.

    A fixed joint on the base that stands after it, as in a URDF, has none.
    """
    tape = friction.builder(robot, variables(robot).q)
    placed, _ = places(robot, tape)
    moving = {j.number for j in robot.moving}
    paths = (path(robot, joint.number) for joint in reversed(robot.joints))
    way = next(numbers for numbers in paths if moving.intersection(numbers))
    last = way[0]
    zero: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
    columns: dict[int, tuple[Vector, Vector]] = {}
    tip = placed[last][3]
    for joint in robot.moving:
        _, _, z, origin = placed[joint.number]
        if joint.number not in way:
            continue
        if joint.sigma == names.PRISMATIC:
            columns[joint.number] = (z, zero)
        else:
            arm = named(
                (tip[0] - origin[0], tip[1] - origin[1], tip[2] - origin[2]),
                f"a{joint.number}_",
                tape,
            )
            columns[joint.number] = (named(cross(z, arm), f"v{joint.number}_", tape), z)
    rows: list[sp.Expr] = []
    for part in range(2):  # velocity, then angular velocity
        for i in range(3):
            row = {j: column[part][i] for j, column in columns.items()}
            moved = folded(robot, row, f"J{3 * part + i}", tape)
            rows += [moved.get(joint.number, sp.S.Zero) for joint in robot.movable]
    return tape.tape([("q", variables(robot).q)], rows)
