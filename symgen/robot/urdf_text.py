"""The text of a URDF as checked values: links, joints and the tree that they make.

Numbers stay the exact decimals that the file writes. https://wiki.ros.org/urdf/XML is the format;
geometry for collision and display, transmissions and plugins are not looked at.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from decimal import Decimal
from typing import TypeVar

import sympy as sp

from symgen import names
from symgen.errors import ExpressionError, RobotError
from symgen.robot import expressions
from symgen.robot.expressions import shortened
from symgen.robot.xml_text import Element, parse_xml

Value = TypeVar("Value")
Triple = tuple[sp.Rational, sp.Rational, sp.Rational]
KINDS = {
    "revolute": names.REVOLUTE,
    "continuous": names.REVOLUTE,
    "prismatic": names.PRISMATIC,
    "fixed": names.FIXED,
}
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MAX_JOINTS = 200
_MAX_TITLE = 200
_ZERO: Triple = (sp.S.Zero, sp.S.Zero, sp.S.Zero)


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], centre of mass (frame xyz, rpy in the link) and inertia about it [kg m2]."""

    xyz: Triple
    rpy: Triple
    mass: sp.Rational
    inertia: tuple[sp.Rational, ...]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint between two links: its frame in the parent's, its axis in its own.

    Attributes:
        sigma: 0 revolute or continuous, 1 prismatic, 2 fixed.
        limit: lower, upper, velocity, effort where the file gives them.
        mimic: name of the joint that it follows, multiplier and offset.
    """

    name: str
    sigma: int
    parent: str
    child: str
    xyz: Triple
    rpy: Triple
    axis: Triple = (sp.S.One, sp.S.Zero, sp.S.Zero)
    limit: dict[str, float] = field(default_factory=dict)
    damping: float = 0.0
    friction: float = 0.0
    mimic: tuple[str, sp.Rational, sp.Rational] | None = None


@dataclass(frozen=True)
class Urdf:
    """A tree of links, each with its inertia, and joints in document order."""

    name: str
    root: str
    links: dict[str, Inertial | None]
    joints: dict[str, UrdfJoint]


def parse_urdf(text: str, where: str) -> Urdf:
    """Read and check a URDF.

    Args:
        text: the file's text.
        where: what error messages call the file.

    Raises:
        RobotError: it is no URDF, or no tree of joints that symgen has; one line names the fault.
    """
    root = parse_xml(text, where)
    if root.tag != "robot":
        raise RobotError(f"{where}: the root element is <{shortened(root.tag)}>; accepted: <robot>")
    for element in root.children:
        if element.tag.startswith("xacro:"):
            raise RobotError(
                f"{where}: line {element.line}: <{shortened(element.tag)}> is a macro; accepted: "
                "plain URDF, as the program xacro writes it"
            )
    reader = _Reader(where)
    links = reader.named("link", root, reader.link)
    if not links:
        raise RobotError(f"{where}: there is no <link>; accepted: at least two and a joint")
    joints = reader.named("joint", root, reader.joint)
    if len(joints) > _MAX_JOINTS:
        raise RobotError(f"{where}: {len(joints)} joints; accepted: at most {_MAX_JOINTS}")
    return Urdf(root.attributes.get("name", ""), reader.root(links, joints), links, joints)


class _Reader:
    """Gives meaning to elements; `where` names the file in messages."""

    def __init__(self, where: str) -> None:
        self.where = where

    def named(
        self, tag: str, root: Element, read: Callable[[str, Element], Value]
    ) -> dict[str, Value]:
        """Read all elements of a kind, each of which has a name of its own."""
        out: dict[str, Value] = {}
        for element in root.all(tag):
            name = element.attributes.get("name", "")
            if not name or len(name) > _MAX_TITLE or not name.isprintable():
                raise RobotError(
                    f"{self.where}: line {element.line}: a {tag} has no usable name; accepted: "
                    f"1 to {_MAX_TITLE} printable characters"
                )
            if name in out:
                raise RobotError(f"{self.where}: {tag} {shortened(name)!r}: the name stands twice")
            out[name] = read(f"{tag} {shortened(name)!r}", element)
        return out

    def fail(self, place: str, message: str) -> RobotError:
        return RobotError(f"{self.where}: {place}: {message}")

    def numbers(self, text: str, count: int, place: str, key: str) -> tuple[sp.Rational, ...]:
        words = text.split()
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        if len(words) != count or not all(_NUMBER.fullmatch(w) for w in words):
            raise self.fail(place, f"{key} is {shortened(text)!r}; accepted: {what}")
        try:
            return tuple(expressions.exact(Decimal(word)) for word in words)
        except (ExpressionError, ArithmeticError) as error:
            raise self.fail(place, f"{key} is {shortened(text)!r}; accepted: {what}") from error

    def number(self, element: Element, key: str, place: str, default: str | None) -> sp.Rational:
        text = element.attributes.get(key, default)
        if text is None:
            raise self.fail(place, f"{key} is missing from <{element.tag}>; it must be given")
        return self.numbers(text, 1, place, key)[0]

    def triple(self, element: Element | None, key: str, place: str, default: Triple) -> Triple:
        if element is None or key not in element.attributes:
            return default
        x, y, z = self.numbers(element.attributes[key], 3, place, key)
        return x, y, z

    def origin(self, element: Element, place: str) -> tuple[Triple, Triple]:
        origin = element.first("origin")
        if origin is not None and "quat_xyzw" in origin.attributes:
            raise self.fail(place, "quat_xyzw is not read; accepted: xyz and rpy")
        return (
            self.triple(origin, "xyz", place, _ZERO),
            self.triple(origin, "rpy", place, _ZERO),
        )

    def link(self, place: str, element: Element) -> Inertial | None:
        inertial = element.first("inertial")
        if inertial is None:
            return None
        mass, tensor = inertial.first("mass"), inertial.first("inertia")
        if mass is None or tensor is None:
            raise self.fail(place, "<inertial> needs <mass> and <inertia>; both must be given")
        value = self.number(mass, "value", place, None)
        if value < 0:
            raise self.fail(place, f"the mass is {float(value):g} kg; accepted: 0 or more")
        inertia = tuple(self.number(tensor, key, place, None) for key in TENSOR)
        xyz, rpy = self.origin(inertial, place)
        return Inertial(xyz, rpy, value, inertia)

    def joint(self, place: str, element: Element) -> UrdfJoint:
        kind = element.attributes.get("type", "")
        if kind not in KINDS:
            found = f"type {shortened(kind)!r}" if kind else "no type"
            raise self.fail(place, f"{found}; accepted: {', '.join(KINDS)}")
        ends = []
        for key in ("parent", "child"):
            end = element.first(key)
            if end is None or not end.attributes.get("link"):
                raise self.fail(place, f"<{key} link=...> is missing; it must be given")
            ends.append(end.attributes["link"])
        xyz, rpy = self.origin(element, place)
        axis = self.triple(element.first("axis"), "xyz", place, (sp.S.One, sp.S.Zero, sp.S.Zero))
        if KINDS[kind] != names.FIXED and axis == _ZERO:
            raise self.fail(place, "the axis is zero; accepted: any direction")
        limit, given = {}, element.first("limit")
        if given is not None:  # the format says what holds where one of the two is absent
            limit = {"lower": 0.0, "upper": 0.0} if kind != "continuous" else {}
            for key in (*limit, "velocity", "effort"):
                if key in given.attributes:
                    limit[key] = float(self.number(given, key, place, None))
        dynamics, loss = element.first("dynamics"), dict.fromkeys(("damping", "friction"), 0.0)
        if dynamics is not None:
            loss = {key: float(self.number(dynamics, key, place, "0")) for key in loss}
        for key, value in loss.items():
            if value < 0:
                raise self.fail(place, f"{key} is {value:g}; accepted: 0 or more")
        return UrdfJoint(
            element.attributes["name"], KINDS[kind], ends[0], ends[1], xyz, rpy, axis, limit,
            **loss, mimic=self.mimic(place, element),
        )  # fmt: skip

    def mimic(self, place: str, element: Element) -> tuple[str, sp.Rational, sp.Rational] | None:
        mimic = element.first("mimic")
        if mimic is None:
            return None
        if not mimic.attributes.get("joint"):
            raise self.fail(place, "<mimic> names no joint; it must be given")
        factor = self.number(mimic, "multiplier", place, "1")
        return mimic.attributes["joint"], factor, self.number(mimic, "offset", place, "0")

    def root(self, links: Collection[str], joints: dict[str, UrdfJoint]) -> str:
        """Check that the links are one tree, and return its root."""
        above: dict[str, UrdfJoint] = {}
        for joint in joints.values():
            place = f"joint {shortened(joint.name)!r}"
            for key in (joint.parent, joint.child):
                if key not in links:
                    raise self.fail(place, f"there is no link {shortened(key)!r}")
            if joint.child in above:
                raise self.fail(
                    place,
                    f"link {shortened(joint.child)!r} already has joint "
                    f"{shortened(above[joint.child].name)!r} to a parent; accepted: open chains",
                )
            above[joint.child] = joint
        roots = [name for name in links if name not in above]
        if len(roots) > 1:
            shown = ", ".join(repr(shortened(name)) for name in roots[:3])
            more = ", ..." if len(roots) > 3 else ""
            raise RobotError(
                f"{self.where}: {len(roots)} links have no parent ({shown}{more}); accepted: one "
                "tree, with one root link"
            )
        for name in links:
            top = name
            for _ in above:  # as many joints as there are lead to the root, or around
                top = above[top].parent if top in above else top
            if top in above:
                place = f"link {shortened(name)!r}"
                raise self.fail(place, "hangs in a ring of joints; accepted: one tree")
        return roots[0]
