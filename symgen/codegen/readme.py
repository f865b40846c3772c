"""The README of a package."""

from __future__ import annotations

import html
import re

import sympy as sp

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
    return package.render(
        "c/README.md",
        c=c,
        casadi=package.kernels[-1].name if "casadi" in package.targets else "",
        stems=stems,
        text=text,
        markdown=_markdown,
        variable=_variable,
        joints=robot.joints,
        effects=robot.effects,
        gravity=robot.gravity,
        identifier=c and "identifier" in package.runtime,
        payload=c and "payload" in package.runtime,
        geometry=robot.geometry,
        base=base.parameters,
        proof=base.proof,
        nominal=base.nominal,
        no_effect=base.no_effect,
        kernels=package.kernels,
        control=example.has_optimal_control(package),
        example=example.has_controller(package),
        percent=example.PERCENT,
        backends=package.targets,
    )


def _variable(joint: Joint) -> sp.Expr:
    """Return the position of a joint in the variables of the robot."""
    return sum((c * joint_variable(k) for k, c in joint.shares), joint.offset)


def _markdown(name: str) -> str:
    """Escape a text for Markdown, so that it forms no HTML tag, link or table cell."""
    return re.sub(r"([\\`*\[\]|!])", r"\\\1", html.escape(name, quote=False))
