"""The README of a package."""

from __future__ import annotations

import html
import re

from symgen.codegen import example
from symgen.codegen.backends import Package
from symgen.codegen.panels import panelled
from symgen.robot.expressions import text
from symgen.robot.types import Joint, joint_variable


def readme(package: Package) -> str:
    """Return README.md: build, geometry, base parameters, operations, deviations."""
    robot, base = package.model.robot, package.model.base
    panels = (f"{k.name}_panels" for k in package.kernels if panelled(k))
    stems = (*(k.name for k in package.kernels), *panels, *package.runtime, "warm")
    c = "c" in package.targets
    start = f"{package.name}_" if c else ""
    effects = [(_markdown(e.name), e.joint, text(e.torque), e.nonlinear) for e in robot.effects]
    return package.render(
        "c/README.md",
        c=c,
        casadi=package.kernels[-1].name if "casadi" in package.targets else "",
        stems=stems,
        table=[" | ".join(_row(joint)) for joint in robot.joints],
        effects=effects,
        gravity="[" + ", ".join(text(g) for g in robot.gravity) + "]",
        identifier=c and "identifier" in package.runtime,
        payload=c and "payload" in package.runtime,
        geometry=[(name, text(value)) for name, value in robot.geometry],
        base=base.parameters,
        proof=base.proof,
        nominal=base.nominal,
        no_effect=", ".join(base.no_effect) or "none",
        kernels=[(start + k.name, *vars(k.tape.operations).values()) for k in package.kernels],
        control=example.has_optimal_control(package),
        example=example.has_controller(package),
        percent=example.PERCENT,
        backends=package.targets,
    )


def _row(joint: Joint) -> list[str]:
    """Return the row of a joint in the geometry table."""
    lengths = (joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r)
    variable = sum((c * joint_variable(k) for k, c in joint.shares), joint.offset)
    numbers = [str(joint.number), str(joint.sigma), str(joint.antecedent)]
    return [*numbers, *map(text, lengths), text(variable), _markdown(joint.name) or "-"]


def _markdown(name: str) -> str:
    """Escape a text for Markdown, so that it forms no HTML tag, link or table cell."""
    return re.sub(r"([\\`*\[\]|!])", r"\\\1", html.escape(name, quote=False))
