"""Read URDF as modified Denavit-Hartenberg frames, and write link parameters into a URDF.

Frame 0 is the root link. q has the sign and the zero of the URDF. The frame of a movable joint has
z along the joint axis, and x along the common normal to the next axis. The URDF link frame is
constant in it. Fixed joints come last and keep the frames of the URDF.

Numbers stay exact decimals. The format is https://wiki.ros.org/urdf/XML, with the quaternions of
version 1.1 and the limits of version 1.2. symgen ignores geometry for collision and display, and
plugins; a note names other content. The attribute armature of <dynamics>, the inertia of the rotor
on the joint side, is an extension of symgen.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from decimal import Decimal
from functools import partial
from typing import TypeVar

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import ExpressionError, RobotError, first_of, located, shortened
from symgen.files import rendered
from symgen.robot import dh, expressions
from symgen.robot.body import Body, Dynamics, merge_bodies
from symgen.robot.exact_numbers import context
from symgen.robot.formats.chain import (
    ORIGIN,
    Chain,
    Inertial,
    Mimic,
    Triple,
    Urdf,
    UrdfJoint,
    many,
    on_base,
)
from symgen.robot.formats.xml import Edit, Element, edited, inserted, parse_xml, with_attributes
from symgen.robot.imported import Imported
from symgen.robot.types import MAX_JOINTS

Value = TypeVar("Value")
KINDS = {
    "revolute": names.REVOLUTE,
    "continuous": names.REVOLUTE,
    "prismatic": names.PRISMATIC,
    "fixed": names.FIXED,
}
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
CAVEAT = (
    "<!-- written by symgen: base parameters do not determine link parameters; this is one link of "
    "one robot that has them -->"
)
#: A frame without mass. Simulators replace a missing <inertial> or a mass of 0 by 1 kg, or by the
#: mass of the collision geometry; MuJoCo reads no moment of inertia below 1e-15.
_FRAME = (
    '<inertial><mass value="1e-9"/><inertia ixx="1e-12" ixy="0" ixz="0" iyy="1e-12" iyz="0" '
    'izz="1e-12"/></inertial>'
)
#: Entries of an inertia below this share of its largest entry are rounding errors.
_ROUNDING = 1e-12
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MAX_TITLE = 200
_NOT_UNIT = 1e-3  # deviation of the length of a quaternion from 1
_ANGLE_DIGITS = 20  # of angles that are computed from a quaternion
_LARGEST_GEAR = 1e6
#: Values of a transmission without an effect.
_MOTOR = {"mechanicalReduction": 1.0, "mechanical_reduction": 1.0, "motorInertia": 0.0}
_LOSSES = dict.fromkeys(("damping", "friction", "armature"), 0.0)
_GEARED = (
    "gears and rotor inertias are those of the transmissions; q and tau of logs are on the joint "
    "side, unless you change position_side and torque_side of [drive]"
)
#: Children that symgen reads, and those that do not change the dynamics.
_KNOWN = {
    "robot": "link joint transmission gazebo ros2_control material sensor mujoco",
    "link": "inertial visual collision contact sensor",
    "joint": "origin parent child axis limit dynamics mimic calibration safety_controller",
    "gazebo": "material plugin sensor visual collision mu mu1 mu2 kp kd minDepth min_depth maxVel "
    "max_vel maxContacts fdir1 selfCollide self_collide laserRetro provideFeedback stopCfm stopErp "
    "disableFixedJointLumping preserveFixedJoint implicitSpringDamper static",
}


def import_urdf(text: str, where: str = "robot.urdf", base: str | None = None) -> Imported:
    """Read a URDF as a robot, with the inertias of its links as standard parameters.

    Rounded fractions of pi (1.5708) become exact.

    Args:
        text: the file's text.
        where: name of the file in error messages.
        base: base of the robot; None for a fixed one. The root link, or the link below a joint of
            type floating, is link 0.

    Raises:
        RobotError: the text is not a URDF, or symgen cannot represent the robot.
    """
    with located(where):
        return Chain(on_base(_tree(parse_xml(text)), base)).imported()


def updated_urdf(
    text: str, dynamics: Dynamics, where: str = "robot.urdf", base: str | None = None
) -> str:
    """Write identified values into a copy of a URDF.

    Links go into <inertial>, friction and rotor inertia go into <dynamics>. A fixed link without
    <inertial> gets a negligible one; its body is added to the link that carries it. A URDF cannot
    contain springs, offsets and couplings.

    Args:
        text: text of the URDF. All other bytes stay the same.
        dynamics: finite values of the imported robot. Links and joints without values stay
            unchanged.
        where: name of the file in error messages.
        base: base of the robot, as in `import_urdf`.

    Raises:
        RobotError: the URDF cannot be read.
    """
    with located(where):
        root, content = parse_xml(text), text.encode("utf-8")
        chain = Chain(on_base(_tree(root), base))
        found = written_bodies(chain, dynamics.bodies)
        links = {e.attributes["name"]: e for e in root.all("link")}
        edits = [inertial_edit(content, links[name], _inertial(b)) for name, b in found.items()]
        for joint in chain.urdf.joints.values():
            link = links.get(joint.child)
            if joint.fixed and not joint.floats and link and not link.first("inertial"):
                edits.append(inserted(content, link, [_FRAME]))
        edits += _joint_edits(content, root, chain, dynamics)
        return edited(text, edits)


# Elements.


def _tree(root: Element) -> Urdf:
    """Return the links and joints of a URDF, checked.

    Raises:
        RobotError: the text is not a URDF, or its joints are not a tree.
    """
    if root.tag != "robot":
        raise RobotError(f"the root element is <{shortened(root.tag)}>; accepted: <robot>")
    for element in root.children:
        if element.tag.startswith("xacro:"):
            raise RobotError(
                f"line {element.line}: <{shortened(element.tag)}> is a macro; accepted: plain "
                "URDF, as after xacro FILE.xacro > FILE.urdf"
            )
    version = root.attributes.get("version", "1.0")
    links = _named("link", root, partial(_link, version=version))
    if not links:
        raise RobotError("there is no <link>; accepted: at least two and a joint")
    joints = _named("joint", root, partial(_joint, version=version))
    if len(joints) > MAX_JOINTS:
        raise RobotError(f"{len(joints)} joints; accepted: at most {MAX_JOINTS}")
    base = _root(links, joints)
    above = {joint.child: joint for joint in joints.values()}
    for joint in joints.values():
        at = joint.parent
        while at in above and above[at].fixed:
            at = above[at].parent
        if joint.floats and at != base:
            with located(f"joint {shortened(joint.name)!r}"):
                raise RobotError(f"type 'floating' on a moving link; accepted: {', '.join(KINDS)}")
    motors, unread = _motors(root), [*_unread(root)]
    moving = [j.name for j in joints.values() if not j.fixed and j.mimic is None]
    if sorted(name for name, *_ in motors) != sorted(moving):
        motors = []
        unread += [
            (tag, e.line)
            for tag, none in _MOTOR.items()
            for e in root.walk(tag)
            if _value(e) != none
        ]
    for name, ratio, inertia in motors:
        armature = joints[name].armature or ratio * ratio * inertia
        joints[name] = replace(joints[name], armature=armature)
    notes = [_GEARED] if motors else []
    if unread:
        shown = first_of(
            [f"<{shortened(tag)}> (line {line})" for tag, line in dict(unread).items()], 6
        )
        notes.append(f"not read, and may change the dynamics: {shown}")
    gears = {name: ratio for name, ratio, _ in motors}
    title = root.attributes.get("name", "")
    return Urdf(title, base, links, joints, gears=gears, notes=tuple(notes))


def _motors(root: Element) -> list[tuple[str, float, float]]:
    """Return joint, gear ratio and inertia of the motor of each transmission with both."""
    out = []
    for element in root.walk("transmission"):
        ends, ratios, inertias = (
            list(element.walk(tag)) for tag in ("joint", "mechanicalReduction", "motorInertia")
        )
        if len(ends) == len(ratios) == len(inertias) == 1:
            ratio, inertia = _value(ratios[0]), _value(inertias[0])
            if 1 <= abs(ratio) * _LARGEST_GEAR <= _LARGEST_GEAR**2 and inertia >= 0:
                out.append((ends[0].attributes.get("name", ""), ratio, inertia))
    return out


def _unread(root: Element) -> Iterator[tuple[str, int]]:
    """Yield the elements and the attributes of <dynamics> that symgen does not know, and lines."""
    for element in (root, *root.children):
        for child in element.children:
            if child.tag not in _KNOWN.get(element.tag, child.tag).split():
                yield child.tag, child.line
    for dynamics in root.walk("dynamics"):
        for key in sorted(dynamics.attributes.keys() - _LOSSES.keys()):
            yield f"dynamics {key}", dynamics.line


def _value(element: Element) -> float:
    return float(_numbers(element.text, 1, element.tag)[0])


def _named(tag: str, root: Element, read: Callable[[Element], Value]) -> dict[str, Value]:
    """Read all elements with a tag; each must have a unique name."""
    out: dict[str, Value] = {}
    for element in root.all(tag):
        name = element.attributes.get("name", "")
        if not name or len(name) > _MAX_TITLE or not name.isprintable():
            raise RobotError(
                f"line {element.line}: a {tag} has no usable name; accepted: 1 to {_MAX_TITLE} "
                "printable characters"
            )
        with located(f"{tag} {shortened(name)!r}"):
            if name in out:
                raise RobotError("the name stands twice")
            out[name] = read(element)
    return out


def _numbers(text: str, count: int, key: str) -> tuple[sp.Rational, ...]:
    words = text.split()
    try:
        if len(words) == count and all(map(_NUMBER.fullmatch, words)):
            return tuple(expressions.exact(Decimal(word)) for word in words)
    except (ExpressionError, ArithmeticError):
        pass
    what = "a finite number" if count == 1 else f"{count} finite numbers"
    raise RobotError(f"{key} is {shortened(text)!r}; accepted: {what}")


def _number(element: Element, key: str, default: str | None = None) -> sp.Rational:
    text = element.attributes.get(key, default)
    if text is None:
        raise RobotError(f"{key} is missing from <{element.tag}>; it must be given")
    return _numbers(text, 1, key)[0]


def _triple(element: Element | None, key: str, default: Triple = ORIGIN) -> Triple:
    if element is None or key not in element.attributes:
        return default
    x, y, z = _numbers(element.attributes[key], 3, key)
    return x, y, z


def _origin(element: Element, version: str) -> tuple[Triple, Triple]:
    origin = element.first("origin")
    if origin is None or "quat_xyzw" not in origin.attributes:
        return _triple(origin, "xyz"), _triple(origin, "rpy")
    if version == "1.0" or "rpy" in origin.attributes:
        raise RobotError(
            'quat_xyzw needs <robot version="1.1"> and no rpy: other readers ignore it in version '
            "1.0; accepted: this, or rpy"
        )
    return _triple(origin, "xyz"), _angles(origin.attributes["quat_xyzw"])


def _angles(text: str) -> Triple:
    """Return roll, pitch and yaw of a quaternion x y z w.

    Raises:
        RobotError: it is not a unit quaternion.
    """
    quaternion = many(_numbers(text, 4, "quat_xyzw"))
    if abs(dh.norm(quaternion) - 1) > _NOT_UNIT:
        raise RobotError(f"quat_xyzw is {shortened(text)!r}; accepted: x y z w of length 1")
    v, eye = quaternion[:3], np.eye(3, dtype=object)
    half = quaternion[3] * eye + np.cross(eye, v)
    angles = dh.turned_by(half @ half + np.outer(v, v), _ROUNDING)
    roll, pitch, yaw = (sp.Rational(context().nstr(angle, _ANGLE_DIGITS)) for angle in angles)
    return roll, pitch, yaw


def _link(element: Element, version: str) -> Inertial | None:
    inertial = element.first("inertial")
    if inertial is None:
        return None
    mass, tensor = inertial.first("mass"), inertial.first("inertia")
    if mass is None or tensor is None:
        raise RobotError("<inertial> needs <mass> and <inertia>; both must be given")
    value = _number(mass, "value")
    if value < 0:
        raise RobotError(f"the mass is {float(value):g} kg; accepted: 0 or more")
    inertia = tuple(_number(tensor, key) for key in TENSOR)
    return Inertial(*_origin(inertial, version), value, inertia)


def _joint(element: Element, version: str) -> UrdfJoint:
    kind = element.attributes.get("type", "")
    floats = kind == "floating"
    if floats:  # `_tree` refuses it on a moving link
        kind = "fixed"
    if kind not in KINDS:
        found = f"type {shortened(kind)!r}" if kind else "no type"
        raise RobotError(f"{found}; accepted: {', '.join(KINDS)}")
    parent, child = (_end(element, key) for key in ("parent", "child"))
    xyz, rpy = _origin(element, version)
    axis = _triple(element.first("axis"), "xyz", (sp.S.One, sp.S.Zero, sp.S.Zero))
    if KINDS[kind] != names.FIXED and axis == ORIGIN:
        raise RobotError("the axis is zero; accepted: any direction")
    limit, given = {}, element.first("limit")
    if given is not None:  # the format has a default if one of the two is absent
        limit = {"lower": 0.0, "upper": 0.0} if kind != "continuous" else {}
        for key in (*limit, "velocity", "effort", "acceleration", "deceleration", "jerk"):
            if key in given.attributes:
                limit[key] = float(_number(given, key))
    dynamics = element.first("dynamics")
    loss = _LOSSES
    if dynamics is not None:
        loss = {key: float(_number(dynamics, key, "0")) for key in loss}
    return UrdfJoint(
        element.attributes["name"], KINDS[kind], parent, child, xyz, rpy, axis, limit, **loss,
        mimic=_mimic(element.first("mimic")), floats=floats,
    )  # fmt: skip


def _end(joint: Element, key: str) -> str:
    """Return the link at one end of a joint."""
    end = joint.first(key)
    if end is None or not end.attributes.get("link"):
        raise RobotError(f"<{key} link=...> is missing; it must be given")
    return end.attributes["link"]


def _mimic(mimic: Element | None) -> Mimic | None:
    if mimic is None:
        return None
    if not mimic.attributes.get("joint"):
        raise RobotError("<mimic> names no joint; it must be given")
    factor = _number(mimic, "multiplier", "1")
    return ((mimic.attributes["joint"], factor),), _number(mimic, "offset", "0")


def _root(links: Collection[str], joints: dict[str, UrdfJoint]) -> str:
    """Check that the links are one tree, and return its root."""
    above: dict[str, UrdfJoint] = {}
    for joint in joints.values():
        with located(f"joint {shortened(joint.name)!r}"):
            for key in (joint.parent, joint.child):
                if key not in links:
                    raise RobotError(f"there is no link {shortened(key)!r}")
            if joint.child in above:
                raise RobotError(
                    f"link {shortened(joint.child)!r} already has joint "
                    f"{shortened(above[joint.child].name)!r} to a parent; accepted: open chains"
                )
        above[joint.child] = joint
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        shown = first_of([repr(shortened(name)) for name in roots], 3)
        raise RobotError(
            f"{len(roots)} links have no parent ({shown}); accepted: one tree, with one root link"
        )
    for name in links:
        top = name
        for _ in above:  # within this many steps, the root is reached or the ring repeats
            top = above[top].parent if top in above else top
        if top in above:
            raise RobotError(
                f"link {shortened(name)!r}: hangs in a ring of joints; accepted: one tree"
            )
    return roots[0]


# Writing inertias.


def written_bodies(chain: Chain, bodies: Iterable[Body]) -> dict[str, Body]:
    """Return link name -> body in the frame of that link, for writing.

    Args:
        chain: chain of the file.
        bodies: links of the robot in the frames of their joints, of finite values.
    """
    urdf, parts = chain.urdf, dict[str, list[Body]]()
    for body in bodies:
        name = joint_name(chain, body.joint)
        link = chain.host(name)
        empty = urdf.links[link] is None and not body.mass and not np.any(body.inertia)
        still = link == urdf.root and urdf.base != "floating"
        if still or empty:  # no joint moves the link, or the body is empty
            continue
        parts.setdefault(link, []).append(body.moved(chain.pose(name).astype(float)))
    return {link: _without_rounding(merge_bodies(own)) for link, own in parts.items()}


def joint_name(chain: Chain, number: int) -> str:
    """Return the name of a joint in the file, or "" for link 0 of a floating base."""
    return chain.order[number - 1] if number else ""


def _without_rounding(body: Body) -> Body:
    """Set entries of the inertia to 0 that are only rounding errors."""
    least = _ROUNDING * np.abs(body.inertia).max()
    return replace(body, inertia=np.where(np.abs(body.inertia) < least, 0.0, body.inertia))


def _inertial(body: Body) -> list[str]:
    if not body.mass and not np.any(body.inertia):
        return [_FRAME]
    return rendered("text/inertial.urdf", body=body, caveat=CAVEAT).splitlines()


def _joint_edits(content: bytes, root: Element, chain: Chain, dynamics: Dynamics) -> Iterator[Edit]:
    """Yield the edits that set the friction and the rotor inertia of joints."""
    joints = {e.attributes["name"]: e for e in root.all("joint")}
    for own in dynamics.joints:
        name = joint_name(chain, own.joint)
        values = {"damping": repr(own.damping), "friction": repr(own.frictionloss)}
        if own.armature or chain.urdf.joints[name].armature:
            values["armature"] = repr(own.armature)
        given = joints[name].first("dynamics")
        if given is None:
            words = " ".join(f'{key}="{value}"' for key, value in values.items())
            yield inserted(content, joints[name], [f"<dynamics {words}/>"])
        else:
            yield with_attributes(content, given, values)


def inertial_edit(content: bytes, link: Element, lines: Sequence[str]) -> Edit:
    """Return the edit that adds or replaces the <inertial> of a link or body."""
    old = link.first("inertial")
    if old is None:
        return inserted(content, link, lines)
    margin = content[content.rfind(b"\n", 0, old.start) + 1 : old.start]
    indent = margin.decode("utf-8") if not margin.strip() else ""
    return old.start, old.end, f"\n{indent}".join(lines).encode()
