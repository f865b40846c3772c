"""Add an effect to a robot: a friction entry, a rotor, a coupling, or an [[effect]] table.

A correction changes a key of the file: [drive], gravity, a length or an angle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import ParameterError
from symgen.hypotheses.changes import Change
from symgen.robot.declared_effects import of_file, of_library, torque_variables
from symgen.robot.effect import Definition, Effect, SearchRange, definitions, described
from symgen.robot.expressions import exact
from symgen.robot.tables import Coupling, Drive
from symgen.robot.types import Joint, Robot

#: Changes of the logs that [drive] corrects.
_DRIVE = ("wrong_sign", "gear_ratio")
#: Effects that change the geometry of the file, and the coefficient that changes each key.
_GEOMETRY = ("geometry_error", "zero_offset")
_GEOMETRY_KEYS = {"d": "delta_d", "r": "delta_r", "b": "delta_b", "theta": "DZ"}
#: Effects with a separate key in robot.toml.
_NATIVE = (*names.FRICTION, "rotor", "coupling")


def extended(
    robot: Robot,
    definition: Definition,
    positions: tuple[int, ...],
    constants: Mapping[str, float],
    coefficients: Mapping[str, float],
) -> Robot | None:
    """Return the robot with an effect declared; None if a robot file cannot declare it.

    A length error changes a length, and a zero offset an angle.

    Args:
        robot: the robot without the effect.
        definition: the effect.
        positions: indices of the movable joints that it acts on.
        constants: value of every constant; written with six digits.
        coefficients: values that change the geometry, as delta_d2 of a length.
    """
    native, joints = definition.native, [robot.movable[i] for i in positions]
    if definition.name in _GEOMETRY and coefficients:
        return _moved(robot, joints[0], coefficients)
    if native in names.FRICTION:
        return _with_friction(robot, joints[0], native)
    if native == "rotor":
        return _with_joint(robot, joints[0], rotor_inertia=True)
    if native == "coupling":
        ratio = sp.nsimplify(_rounded(constants["ratio"]))
        coupling = Coupling((joints[0].number, joints[1].number), ratio)
        return replace(robot, couplings=(*robot.couplings, coupling))
    if native == "payload":
        return replace(robot, payload=joints[0].number)
    if not definition.declarable:
        return None
    rounded = {name: _rounded(value) for name, value in constants.items()}
    joint = joints[0]
    if definition.own:
        effect = _custom_effect(robot, definition, joint.number, rounded)
    else:
        effect = of_library(definition, joint.number, joint.sigma, rounded)
    out = replace(robot, effects=(*robot.effects, effect))
    return _with_friction(out, joint, "offset") if definition.offset else out


def corrected(robot: Robot, change: Change) -> Robot | None:
    """Return the robot whose file corrects a change for every log; None if no key does.

    Gravity is corrected in the model already. Signs and gear ratios are those of [drive].
    """
    if change.gravity is not None:
        return robot
    if change.definition.name not in _DRIVE:
        return None
    drive = robot.drive or _direct(robot)
    motion = change.factors.get("q", 1.0)
    torque = change.factors.get("tau", 1.0)
    if motion != 1.0 and drive.position_side != "motor":
        return None
    ratio = np.array(drive.ratio)
    for j in change.joints:
        ratio[:, j] /= motion
    if motion != 1.0 and drive.torque_side == "motor":
        torque *= motion  # the other ratio divides torques by this factor
    rows = tuple(map(tuple, ratio.tolist()))
    out = replace(robot, drive=replace(drive, ratio=rows))
    for j in change.joints:
        out = with_torques_scaled(out, j, torque)
    return out


def with_torques_scaled(robot: Robot, position: int, factor: float) -> Robot:
    """Return the robot with a torque constant, or else the gain of a joint, times a factor.

    The standard deviations of the gains are those of the old ones, and hold for a sign alone.
    """
    drive = robot.drive or _direct(robot)
    key = "gain" if drive.torque_constant is None else "torque_constant"
    values = [*(getattr(drive, key) or (1.0,) * robot.n)]
    values[position] = float(f"{factor * values[position]:.6g}")
    changed: dict[str, Any] = {key: tuple(values)}
    if abs(factor) != 1.0:
        changed["gain_std"] = None
    return replace(robot, drive=replace(drive, **changed))


def _direct(robot: Robot) -> Drive:
    """Return a drive that changes nothing."""
    return Drive(tuple(map(tuple, np.eye(robot.n).tolist())))


def with_effect(robot: Robot, text: str) -> Robot:
    """Return the robot with one more effect, to plan a motion that shows the effect.

    The constants of the effect are in the middle of the ranges that `diagnose` searches.

    Args:
        robot: the robot.
        text: NAME:JOINT, for example gravity_spring:2; coupling:5-6 for the two joints of a drive.

    Raises:
        ParameterError: the effect or joint does not exist, or a robot file cannot declare it.
    """
    name, _, where = text.partition(":")
    known = {d.name: d for d in definitions().values() if d.declarable or d.native in _NATIVE}
    if name not in known:
        shows = described(name).separate
        why = f"; what shows it: {shows}" if shows else ""
        raise ParameterError(f"effect {name!r}{why}; accepted: {', '.join(known)}")
    try:
        numbers = map(int, where.split("-"))
        positions = tuple(robot.numbers.index(number) for number in numbers)
    except ValueError as error:
        listed = ", ".join(map(str, robot.numbers))
        raise ParameterError(
            f"{text}: joint {where!r}; accepted: NAME:JOINT of {listed}"
        ) from error
    definition = known[name]
    if len(positions) != 1 + (definition.native == "coupling"):
        raise ParameterError(f"{text}: accepted: one joint, or two of a coupling as 5-6")
    if definition.native == "coupling":
        constants = {"ratio": 1.0}
    else:
        constants = {k: _middle(robot, positions[0], s) for k, s in definition.nonlinear.items()}
    out = extended(robot, definition, positions, constants, {})
    assert out is not None  # checked above
    return out


def _middle(robot: Robot, position: int, search: SearchRange) -> float:
    """Return the middle of a range, in the units of the joint."""
    value = (search.low * search.high) ** 0.5 if search.by_ratio else (search.low + search.high) / 2
    limits = robot.limits
    if search.scale == "speed" and limits is not None and limits.velocity is not None:
        return value * limits.velocity[position]
    if search.scale == "gear" and robot.drive is not None:
        return round(value) * robot.drive.ratio[position][position]
    return float(round(value)) if search.scale in ("turn", "gear") else value


def _moved(robot: Robot, joint: Joint, coefficients: Mapping[str, float]) -> Robot:
    """Return the robot with another length or angle of a joint."""
    changed = {}
    for key, name in _GEOMETRY_KEYS.items():
        change = coefficients.get(f"{name}{joint.number}")
        if change is not None:
            changed[key] = getattr(joint, key) + _rounded(change)
    return _with_joint(robot, joint, **changed)


def _rounded(value: float) -> sp.Expr:
    return exact(float(f"{value:.6g}"))


def _custom_effect(
    robot: Robot, definition: Definition, number: int, constants: Mapping[str, sp.Expr]
) -> Effect:
    """Return an effect whose torque is an expression in the variables of any joint."""
    name, taken = definition.name, {e.name for e in robot.effects}
    if name in definitions():  # a robot file cannot use a name of the library
        name = f"{name}_{number}"
        while name in taken:
            name += "_more"
    return of_file(
        name,
        number,
        definition.torque,
        definition.linear,
        constants,
        torque_variables(number, [j.number for j in robot.movable]),
        dict(robot.geometry),
    )


def _with_friction(robot: Robot, joint: Joint, word: str) -> Robot:
    words = tuple(w for w in names.FRICTION if w in (*joint.friction, word))
    return _with_joint(robot, joint, friction=words)


def _with_joint(robot: Robot, joint: Joint, **changed: Any) -> Robot:
    other = replace(joint, **changed)
    joints = tuple(other if j.number == joint.number else j for j in robot.joints)
    return replace(robot, joints=joints)
