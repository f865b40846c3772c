"""Write a robot as the text of a robot.toml."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from decimal import Decimal
from typing import Any

import numpy as np
import sympy as sp

from symgen.robot import expressions
from symgen.robot.types import LENGTHS, Joint, Robot


def robot_toml(robot: Robot) -> str:
    """Return the robot as robot.toml text; reading it gives the same robot."""
    gravity = "input" if robot.gravity_input else robot.gravity
    head = {"name": robot.name, "convention": "modified-dh", "gravity": gravity}
    tables: list[tuple[str, Mapping[str, Any]]] = [("[robot]", head)]
    if robot.geometry:
        tables.append(("[geometry]", dict(robot.geometry)))
    tables += [(f"[[joint]]  # {joint.number}", _joint(joint)) for joint in robot.joints]
    for c in robot.couplings:
        tables.append(("[[coupling]]", {"joints": (c.first, c.second), "ratio": c.ratio}))
    if robot.payload is not None:
        tables.append(("[payload]", {"joint": robot.payload}))
    tables += [("[[loop]]", {"cut": (loop.first, loop.second)}) for loop in robot.loops]
    sought = [(s.effect, {name: ends for name, *ends in s.ranges}) for s in robot.sought]
    for effect, ranges in [*((e, {}) for e in robot.effects), *sought]:
        about: dict[str, Any] = {"name": effect.name, "joints": effect.joints}
        if effect.own:
            about |= {
                "torque": expressions.text(effect.torque[0][1]),
                "linear": dict(effect.linear),
            }
        about["nonlinear"] = dict(effect.constants) | ranges or None
        tables.append(("[[effect]]", about))
    tables += [("[[frame]]", vars(frame)) for frame in robot.frames]
    if robot.limits is not None:
        tables.append(("[limits]", vars(robot.limits) | {"boxes": robot.limits.boxes or None}))
    if robot.drive is not None:
        ratio = np.array(robot.drive.ratio)
        diagonal = np.array_equal(ratio, np.diag(np.diag(ratio)))
        sides = {
            key: side if side != "motor" else None
            for key, side in vars(robot.drive).items()
            if key.endswith("side")
        }
        about = {"ratio": (np.diag(ratio) if diagonal else ratio).tolist()}
        tables.append(("[drive]", vars(robot.drive) | sides | about))
    if robot.controller is not None:
        tables.append(("[controller]", vars(robot.controller)))
    if robot.log_columns:
        tables.append(("[log]", {"columns": robot.log_columns}))
    return "\n".join(f"{head}\n{_lines(entries)}" for head, entries in tables)


def _joint(joint: Joint) -> dict[str, Any]:
    """Return the entries of a joint that differ from the defaults."""
    out: dict[str, Any] = {"sigma": joint.sigma}
    if joint.antecedent != joint.number - 1:
        out["antecedent"] = joint.antecedent
    out |= {key: getattr(joint, key) for key in LENGTHS if not getattr(joint, key).is_zero}
    out["name"] = joint.name or None
    out["actuated"] = None if joint.actuated else False
    if joint.follows is not None:
        out["follows"] = expressions.text(joint.follows)
    elif not joint.fixed:
        out["friction"] = joint.friction
        out["coulomb_width"] = joint.coulomb_width or None
        out["rotor_inertia"] = joint.rotor_inertia
    return out


def _lines(entries: Mapping[str, Any]) -> str:
    """Write the entries of a table, except those that are None."""
    known = ((key, value) for key, value in entries.items() if value is not None)
    return "".join(f"{key} = {_value(value)}\n" for key, value in known)


def _value(value: Any) -> str:
    """Write a value as TOML; an exact one becomes a decimal or a quoted expression."""
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
    values: Iterable[tuple[str, float]], band: Mapping[str, Any] | None = None
) -> str:
    """Return parameter values, and the filters that gave them, as the text of a TOML file."""
    text = f"[parameters]\n{_lines(dict(values))}"
    return text if band is None else f"{text}\n[band]\n{_lines(band)}"


def _decimal(expr: sp.Expr) -> str | None:
    """Write a rational as a decimal of up to 17 digits, or return None."""
    if not expr.is_Rational or 10**17 % expr.q != 0 or abs(expr) >= 10**6:
        return None
    return format(Decimal(int(expr.p)) / Decimal(int(expr.q)), "f")
