"""The wrench on a tool behind a force/torque sensor.

With the specific force a - g of the origin of the sensor's frame, its angular velocity w and its
angular acceleration dw, in this frame, the sensor measures

    f = M (a - g) + dw x m + w x (w x m),    n = J dw + w x (J w) + m x (a - g)

plus an offset (see `bodies`). Both are linear in J, m = (MX, MY, MZ) and M of the tool.
"""

from __future__ import annotations

import sympy as sp

from symgen import names
from symgen.robot.exact_numbers import written_fraction
from symgen.robot.expressions import exact
from symgen.robot.tables import Frame
from symgen.robot.types import Joint, Robot
from symgen.symbolic.bodies import Inertia
from symgen.symbolic.constraints import spread
from symgen.symbolic.kinematics import (
    Step,
    arrays,
    builder,
    cosine_sine,
    path,
    variables,
    way_of,
)
from symgen.symbolic.motion import accelerations, base_acceleration
from symgen.symbolic.placement import coordinates
from symgen.symbolic.spatial import Shift, Turn
from symgen.symbolic.tape import Tape, TapeBuilder


def tool_wrench_tape(robot: Robot) -> Tape:
    """Derive force and moment (6,) of a rigid tool in the frame of the sensor, plus its offset."""
    assert robot.sensor is not None  # other robots have no such kernel
    frame = robot.frame(robot.sensor.frame)
    load, offset = coordinates("l", len(names.LINK)), coordinates("o", 6)
    tape = builder(robot, (*load, *offset))
    to_sensor = _step_to(frame, len(robot.joints) + 1, tape)
    behind = path(robot, frame.joint)
    way = [step for step in way_of(robot, tape) if step.joint.number in behind]
    qdd = spread(robot, variables(robot, "qdd"), tape)
    motion = accelerations((*way, to_sensor), base_acceleration(robot, tape), qdd, tape)
    number = to_sensor.joint.number
    tool = Inertia.of(dict(zip(names.LINK, load, strict=True)))
    force, moment = tool.wrench(motion[number], number, tape)
    wrench = zip((*force, *moment), offset, strict=True)
    outputs = [tape.name(f"w{k}", x + shift) for k, (x, shift) in enumerate(wrench, 1)]
    inputs = [*arrays(robot, "q", "qd", "qdd"), ("load", load), ("offset", offset)]
    return tape.tape(inputs, outputs)


def _step_to(frame: Frame, number: int, tape: TapeBuilder) -> Step:
    """Return the step from the frame of a joint to one that is fixed on its link."""
    motions: list[Turn | Shift] = []
    for axis, length in enumerate(map(exact, frame.xyz)):
        if length != 0:
            motions.append(Shift(axis, tape.constant(f"x{axis}", length), f"x{axis}"))
    for axis, angle in reversed([*enumerate(map(exact, frame.rpy))]):
        if angle != 0:
            c, s = cosine_sine(written_fraction(angle))
            tag = f"y{axis}"
            turn = Turn(axis, tape.constant(f"C{tag}", c), tape.constant(f"S{tag}", s), tag)
            motions.append(turn)
    joint = Joint(number, names.FIXED, frame.joint)
    return Step(joint, tuple(motions), (), sp.S.Zero, sp.S.Zero)
