"""Values of the parameters in a package: NAME_values.h, and start values of other targets."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symgen.files import rendered
from symgen.robot.expressions import six_digits
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters


@dataclass(frozen=True)
class Values:
    """Values of the parameters of a robot.

    Attributes:
        X: base parameters (p,).
        std: their standard deviations, None where unknown.
        standard: standard parameters in the order of the model, or () if they are unknown.
        facts: the origin of the values, one line each.
        units: units of X, if they are not those of the model: "duty" for N m.
        drives: torque of the drive of each joint per unit of its input, with the unit; () for none.
    """

    X: tuple[float, ...]
    std: tuple[float | None, ...]
    standard: tuple[float, ...] = ()
    facts: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    drives: tuple[tuple[float, str], ...] = ()


def model_digest(robot_file: str) -> str:
    """Return the digest of a model for C: 64 bits of a SHA-256.

    Args:
        robot_file: the SHA-256 of the canonical robot.toml, in hexadecimal digits.
    """
    return f"0x{robot_file[:16]}ULL"


def robot_digest(robot: Robot) -> str:
    """Return the digest of a robot for C, from its robot.toml."""
    return model_digest(hashlib.sha256(robot_toml(robot).encode()).hexdigest())


def values_header_text(
    name: str,
    robot: str,
    values: Values,
    parameters: Sequence[tuple[str, str, str]],
    *,
    digest: str | None = None,
    standard: Sequence[str] = (),
) -> str:
    """Return NAME_values.h: X as `static const NAME_real NAME_values[]`.

    It includes NAME.h. It compiles only with a package that has these parameters in this order, and
    this digest if there is one.

    Args:
        name: prefix of the package.
        robot: name of the robot.
        values: the values.
        parameters: name, expression and unit of each base parameter.
        digest: `model_digest` of the robot file.
        standard: names of the standard parameters, if their values are known.
    """
    units = values.units or tuple(unit for *_, unit in parameters)
    return rendered(
        "c/values.h",
        name=name,
        robot=robot,
        digest=digest,
        facts=[_comment(fact) for fact in values.facts],
        parameters=[
            {
                "name": parameter,
                "value": x,
                "formula": _comment(
                    parameter
                    if expression == parameter
                    else f"{parameter} = {six_digits(expression)}"
                ),
                "unit": unit,
                "std": "unknown" if std is None else f"{std:.3g}",
            }
            for (parameter, expression, _), unit, x, std in zip(
                parameters, units, values.X, values.std, strict=True
            )
        ],
        drives=values.drives,
        standard=[*zip(standard, values.standard, strict=False)],
    )


def named_values(
    X: Sequence[float],
    values: Mapping[str, float],
    deviations: Mapping[str, float | None],
    base: BaseParameters,
    facts: Sequence[str],
) -> Values:
    """Return values from a table of parameters.

    Args:
        X: base parameters (p,), regrouped from the table.
        values: values of base or standard parameters by name.
        deviations: their standard deviations by name, if known.
        base: the base parameters of the model.
        facts: the origin of the table, for the header, one line each.
    """
    std = map(deviations.get, base.names)
    names = [p.name for p in base.standard]
    known = all(name in values for name in names)
    return Values(
        tuple(map(float, X)),
        tuple(None if s is None or not math.isfinite(s) else float(s) for s in std),
        tuple(float(values[name]) for name in names) if known else (),
        tuple(facts),
    )


def _comment(text: str) -> str:
    """Return a text as one line that is safe inside a C comment."""
    line = "".join(c if c.isprintable() else " " for c in text)
    # no start or end of a comment, and no trigraph
    return re.sub(r"(\*(?=/)|/(?=\*)|\?(?=\?))", r"\1 ", line).rstrip("\\")
