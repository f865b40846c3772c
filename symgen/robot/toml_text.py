"""The text of a robot.toml."""

from __future__ import annotations

import json
from collections.abc import Iterable
from decimal import Decimal

import sympy as sp

from symgen import names
from symgen.robot import expressions
from symgen.robot.drive import drive_toml
from symgen.robot.limits import limits_toml
from symgen.robot.types import Robot


def robot_toml(robot: Robot) -> str:
    """Return the robot as the text of a robot.toml; reading it gives the same robot."""

    def scalar(expr: sp.Expr) -> str:
        written = _decimal(expr) or expressions.text(expr)
        try:
            plain = expr.is_Rational and expressions.exact(Decimal(written)) == expr
        except ArithmeticError:
            plain = False
        return written if plain else f'"{written}"'

    out = [
        "[robot]",
        f'name = "{robot.name}"',
        'convention = "modified-dh"',
        'gravity = "input"'
        if robot.gravity_input
        else f"gravity = [{', '.join(scalar(g) for g in robot.gravity)}]",
    ]
    if robot.geometry:
        out += ["", "[geometry]", *(f"{key} = {scalar(v)}" for key, v in robot.geometry)]
    for joint in robot.joints:
        out += ["", f"[[joint]]  # {joint.number}", f"sigma = {joint.sigma}"]
        if joint.antecedent != joint.number - 1:
            out.append(f"antecedent = {joint.antecedent}")
        for key in ("gamma", "b", "alpha", "d", "theta", "r"):
            if not getattr(joint, key).is_zero:
                out.append(f"{key} = {scalar(getattr(joint, key))}")
        if joint.name:
            out.append(f"name = {json.dumps(joint.name, ensure_ascii=False)}")
        if joint.follows is not None:
            out.append(f'follows = "{expressions.text(joint.follows)}"')
        elif joint.sigma != names.FIXED:
            words = ", ".join(f'"{word}"' for word in joint.friction)
            out.append(f"friction = [{words}]")
            if joint.coulomb_width:
                out.append(f"coulomb_width = {joint.coulomb_width!r}")
            out.append(f"rotor_inertia = {str(joint.rotor_inertia).lower()}")
    for coupling in robot.couplings:
        out += ["", "[[coupling]]", f"joints = [{coupling.first}, {coupling.second}]"]
        out.append(f"ratio = {scalar(coupling.ratio)}")
    if robot.payload is not None:
        out += ["", "[payload]", f"joint = {robot.payload}"]
    for loop in robot.loops:
        out += ["", "[[loop]]", f"cut = [{loop.first}, {loop.second}]"]
    sought = [(s.effect, {name: ends for name, *ends in s.ranges}) for s in robot.sought]
    for effect, ranges in [*((e, {}) for e in robot.effects), *sought]:
        out += ["", "[[effect]]", f"name = {json.dumps(effect.name, ensure_ascii=False)}"]
        out.append(f"joints = {list(effect.joints)}")
        if effect.own:
            out.append(f'torque = "{expressions.text(effect.torque[0][1])}"')
            units = ", ".join(
                f"{k} = {json.dumps(u, ensure_ascii=False)}" for k, u in effect.linear
            )
            out.append(f"linear = {{ {units} }}")
        if effect.constants:
            constants = ", ".join(
                f"{key} = [{', '.join(map(scalar, ranges[key]))}]"
                if key in ranges
                else f"{key} = {scalar(value)}"
                for key, value in effect.constants
            )
            out.append(f"nonlinear = {{ {constants} }}")
    for known in robot.on_logs:
        out += ["", "[[effect]]", f'name = "{known.name}"', f"joints = [{known.joint}]"]
        values = ", ".join(f"{name} = {scalar(value)}" for name, value in known.values)
        out.append(f"values = {{ {values} }}")
    if robot.limits is not None:
        out += ["", *limits_toml(robot.limits)]
    if robot.drive is not None:
        out += ["", *drive_toml(robot.drive)]
    return "\n".join(out) + "\n"


def parameters_toml(values: Iterable[tuple[str, float]]) -> str:
    """Return values of parameters by name as the text of a TOML file with [parameters]."""
    return "[parameters]\n" + "".join(f"{name} = {value!r}\n" for name, value in values)


def _decimal(expr: sp.Expr) -> str | None:
    """Write a decimal of up to 17 digits as one: the grammar's own text keeps to shorter ones."""
    if not expr.is_Rational or 10**17 % expr.q != 0 or abs(expr) >= 10**6:
        return None
    return format(Decimal(int(expr.p)) / Decimal(int(expr.q)), "f")
