"""Write a robot as the text of a robot.toml."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from decimal import Decimal
from typing import Any

import numpy as np
import sympy as sp

from symgen.robot import expressions
from symgen.robot.effect import Effect
from symgen.robot.schema import keys
from symgen.robot.tables import CONVENTION, Drive, EffectTable
from symgen.robot.types import Joint, Robot


def robot_toml(robot: Robot) -> str:
    """Return the robot as robot.toml text; reading it gives the same robot."""
    gravity = "input" if robot.gravity_input else robot.gravity
    head: dict[str, Any] = {"name": robot.name, "convention": CONVENTION, "gravity": gravity}
    if robot.imu:
        head["base"] = robot.base
    if robot.exact:
        head["exact"] = True
    tables: list[tuple[str, Mapping[str, Any]]] = [("[robot]", head)]
    if robot.geometry:
        tables.append(("[geometry]", dict(robot.geometry)))
    tables += [(f"[[joint]]  # {joint.number}", _joint(joint)) for joint in robot.joints]
    tables += [("[[coupling]]", _entries(coupling)) for coupling in robot.couplings]
    if robot.payload is not None:
        tables.append(("[payload]", {"joint": robot.payload}))
    tables += [("[[loop]]", _entries(loop)) for loop in robot.loops]
    tables += [("[[effect]]", _effect(effect, {})) for effect in robot.effects]
    for s in robot.sought:
        ranges = {name: ends for name, *ends in s.ranges}
        tables.append(("[[effect]]", _effect(s.effect, ranges)))
    tables += [("[[frame]]", _entries(frame)) for frame in robot.frames]
    tables += [("[[contact]]", _entries(contact)) for contact in robot.contacts]
    if robot.mount is not None:
        tables.append(("[base]", _entries(robot.mount)))
    for key in ("sensor", "limits", "drive", "controller", "log"):
        table = getattr(robot, key)
        if table is not None:
            ratio = {"ratio": _ratio(table)} if key == "drive" else {}
            tables.append((f"[{key}]", _entries(table) | ratio))
    return "\n".join(f"{head}\n{_lines(entries)}" for head, entries in tables)


def _entries(table: Any, *always: str) -> dict[str, Any]:
    """Return the entries of a table that differ from the defaults, and some others."""
    out, known = {}, keys(type(table))
    for f in fields(table):
        value = getattr(table, f.name)
        default = f.default_factory() if f.default_factory is not MISSING else f.default
        if f.name in known and (value != default or f.name in always):
            out[f.name] = value
    return out


def _joint(joint: Joint) -> dict[str, Any]:
    """Return the entries of a joint; the default of its antecedent is the previous joint."""
    out = _entries(joint, "friction", "rotor_inertia")
    if not joint.movable:
        del out["friction"], out["rotor_inertia"]
    if joint.antecedent == joint.number - 1:
        del out["antecedent"]
    return out


def _effect(effect: Effect, ranges: Mapping[str, Any]) -> dict[str, Any]:
    torque = expressions.text(effect.torque) if effect.own else ""
    linear = dict(effect.linear) if effect.own else {}
    constants = {**dict(effect.constants), **ranges}
    return _entries(EffectTable(effect.name, effect.joints, torque, linear, constants))


def _ratio(drive: Drive) -> list[Any]:
    """Return the gear ratios as a list if each motor moves only its joint, else as a matrix."""
    ratio = np.array(drive.ratio)
    diagonal: list[Any] = np.diag(ratio).tolist()
    return diagonal if np.array_equal(ratio, np.diag(diagonal)) else ratio.tolist()


def _lines(entries: Mapping[str, Any]) -> str:
    """Write the entries of a table."""
    return "".join(f"{key} = {_value(value)}\n" for key, value in entries.items())


def _value(value: Any) -> str:
    """Write a value as TOML; an exact value becomes a decimal or a quoted expression."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_value(v)}' for key, v in value.items())} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False)
    if not isinstance(value, sp.Expr):
        return repr(value)
    written = _decimal(value) or expressions.text(value)
    try:
        plain = value.is_Rational and expressions.exact(Decimal(written)) == value
    except ArithmeticError:
        plain = False
    return written if plain else f'"{written}"'


def parameters_toml(
    values: Iterable[tuple[str, float]],
    band: Mapping[str, Any] | None = None,
    delays: Mapping[str, float] | None = None,
) -> str:
    """Return parameter values as the text of a TOML file.

    Args:
        values: names and values.
        band: filters of their estimate.
        delays: delays of torque channels that were undone, s, by channel: "tau" for all, or "tau2".
    """
    tables = {"parameters": dict(values), "band": band, "delays": delays}
    return "\n".join(f"[{name}]\n{_lines(table)}" for name, table in tables.items() if table)


def _decimal(expr: sp.Expr) -> str | None:
    """Write a rational as a decimal of up to 17 digits, or return None."""
    if not expr.is_Rational or 10**17 % expr.q != 0 or abs(expr) >= 10**6:
        return None
    return format(Decimal(int(expr.p)) / Decimal(int(expr.q)), "f")
