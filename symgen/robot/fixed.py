"""Fix joints, for example the fingers of a gripper, or an axis that is locked during a log.

A joint that is fixed at q0 keeps its number, its link and its table row; q0 is added to theta or r.
The joint then has no variable, friction or rotor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from typing import Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import ExpressionError, RobotError, located, shortened
from symgen.robot import expressions
from symgen.robot.imported import Imported
from symgen.robot.schema import per_joint
from symgen.robot.types import Joint, Robot, joint_variable

_ACCEPTED = "NAME, which is held at 0, or NAME=VALUE in rad or m"
_PER_JOINT = (names.ROTOR, *names.FRICTION.values())


def with_fixed(imported: Imported, fixed: Sequence[str]) -> Imported:
    """Fix some joints of a robot, and the joints that follow them.

    Args:
        imported: the robot of the file.
        fixed: names or numbers of movable joints, with an optional position in rad or m (default
            0): "panda_finger_joint1" or "panda_finger_joint1=0.02".

    Raises:
        RobotError: there is no such movable joint, a position is outside the limits, no movable
            joint remains, or a loop, coupling or effect of the robot involves the joint.
    """
    robot = imported.robot
    held: dict[int, sp.Expr] = {}
    for text in fixed:
        with located(f"--fix {shortened(text)}"):
            name, sign, value = text.rpartition("=") if "=" in text else (text, "", "0")
            joint = _named(robot, name.strip())
            if joint.number in held:
                raise RobotError("given twice; accepted: every joint once")
            try:
                held[joint.number] = expressions.exact(Decimal(value.strip()))
            except (ArithmeticError, ExpressionError, ValueError) as error:
                raise RobotError(f"accepted: {_ACCEPTED}") from error
            within = robot.fixes[robot.movable.index(joint)]
            if not sign and "=" in within:
                raise RobotError(f"its zero lies outside its limits; accepted: --fix {within}")
    if not held:
        return imported
    drive = robot.drive
    coupled = drive is not None and np.count_nonzero(drive.ratio) > robot.n
    if robot.loops or robot.couplings or robot.effects or robot.sought or coupled:
        raise RobotError(
            f"--fix: {robot.name} has loops, couplings, effects or a [drive] of coupled joints; "
            "accepted: sigma = 2 in its robot.toml"
        )
    joints = tuple(_substituted(joint, held) for joint in robot.joints)
    if not any(joint.movable for joint in joints) and not robot.floating:
        raise RobotError(
            f"--fix: no joint of {robot.name} would be movable; accepted: at least one"
        )
    still = [j.number for j, before in zip(joints, robot.joints, strict=True) if j != before]
    kept = [k for k, joint in enumerate(robot.movable) if joint.number not in held]
    limits = None if robot.limits is None else _of_joints(robot.limits, kept)
    if drive is not None:
        rows = tuple(tuple(row[k] for k in kept) for row in drive.ratio)
        drive = _of_joints(replace(drive, ratio=rows), kept)
    notes = list(imported.notes)
    for joint in (robot.joints[number - 1] for number in still):
        at = held.get(joint.number)
        where = ", as it follows one" if at is None else f" at {float(at):g}"
        notes.append(f"joint {shortened(joint.name) or joint.number} is held{where}")
    lost = {f"{prefix}{number}" for prefix in _PER_JOINT for number in still}
    return replace(
        imported,
        robot=replace(robot, joints=joints, limits=limits, drive=drive),
        parameters=tuple(pair for pair in imported.parameters if pair[0] not in lost),
        notes=tuple(notes),
    )


def _of_joints(table: Any, kept: Sequence[int]) -> Any:
    """Return a table with the entries of some movable joints."""
    given = (key for key in per_joint(type(table)) if getattr(table, key) is not None)
    return replace(table, **{key: tuple(getattr(table, key)[k] for k in kept) for key in given})


def _named(robot: Robot, name: str) -> Joint:
    """Return a movable joint by its name or number."""
    for joint in robot.movable:
        if name in (joint.name, str(joint.number)):
            return joint
    known = ", ".join(shortened(j.name) or str(j.number) for j in robot.movable[:24])
    raise RobotError(
        f"{robot.name} has no such movable joint; accepted: --fix once for each, of {known}"
    )


def _substituted(joint: Joint, values: dict[int, sp.Expr]) -> Joint:
    """Return a joint with the positions of the fixed joints substituted."""
    q = values.get(joint.number)
    if joint.follows is not None:
        follows = sp.expand(
            joint.follows.subs({joint_variable(number): at for number, at in values.items()})
        )
        if follows.free_symbols & {joint_variable(k) for k, _ in joint.shares}:
            return replace(joint, follows=follows)
        q = follows
    if q is None:
        return joint
    key = "r" if joint.slides else "theta"
    return replace(
        joint,
        sigma=names.FIXED,
        follows=None,
        friction=(),
        coulomb_width=0.0,
        rotor_inertia=False,
        **{key: getattr(joint, key) + q},
    )
