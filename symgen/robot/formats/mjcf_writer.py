"""Write identified values into an MJCF, the format of MuJoCo."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar
from xml.sax.saxutils import quoteattr

import numpy as np

from symgen.errors import ParameterError, located, plain
from symgen.robot.body import COUPLING, Body, CouplingDynamics, Dynamics, JointDynamics
from symgen.robot.formats.chain import Chain, on_base
from symgen.robot.formats.mjcf import ACCEPTED, Losses, MjcfTree
from symgen.robot.formats.mjcf_drives import JointDrive, drive_edits
from symgen.robot.formats.urdf import (
    CAVEAT,
    inertial_edit,
    joint_name,
    written_bodies,
)
from symgen.robot.formats.xml import Edit, Element, edited, inserted, with_attributes
from symgen.robot.imported import read_text

Drive = TypeVar("Drive", JointDynamics, CouplingDynamics)
_NO_DRIVES: Mapping[str, JointDrive] = {}
_HIGHER = ("damping_2", "damping_3")  # not written for an older MuJoCo
#: Coulomb friction as hard as steps of 2 ms allow; MuJoCo softens it for longer steps (refsafe).
_STICKING = {"solreffriction": "0.004 1", "solimpfriction": "0.99 0.99 0.001"}
_FULL = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # fullinertia


def updated_mjcf(
    path: Path,
    dynamics: Dynamics,
    drives: Mapping[str, JointDrive] = _NO_DRIVES,
    base: str | None = None,
) -> str:
    """Return an MJCF with identified values.

    Links go into <inertial>. Rotor inertia, friction and springs become attributes of <joint>,
    which override those of default classes. A coupling becomes a fixed tendon. Coulomb friction of
    joints sticks, unless the file has a solreffriction of its own or no refsafe.

    Args:
        path: path of the MJCF. All other bytes stay the same.
        dynamics: finite values of the imported robot. Links and joints without values stay
            unchanged.
        drives: drives by names of joints, whose actuators and limits they replace.
        base: base of the robot, as in `import_mjcf`.

    Raises:
        RobotError: the file cannot be read.
        ParameterError: a body or joint has no name or is in an included file, a body has several
            joints, or MuJoCo carries the weight of a body.
    """
    text, _ = read_text(path, ACCEPTED)
    content, edits = text.encode("utf-8"), list[Edit]()
    with located(path):
        tree = MjcfTree(path, text)
        tree.require_weight_on_motors()
        chain = Chain(on_base(tree.urdf, base))
        places = _by_name(tree.root.walk("body"))
        bodies = written_bodies(chain, dynamics.bodies)
        for link, body in bodies.items():
            at = _named(places, "body", link)
            body = replace(body, com=np.asarray(body.com) + tree.shift[link])
            edits.append(inertial_edit(content, at, [CAVEAT, _inertial(body)]))
        joints = _by_name(e for body in places.values() for e in body.all("joint"))
        section = tree.root.first("tendon")
        named = _by_name(section.children if section else ())
        tendons = list[str]()
        keeps = "solreffriction" in text or tree.is_off("REFSAFE")
        for joint in dynamics.joints:
            name = joint_name(chain, joint.joint)
            at = _named(joints, "joint", name)
            angle = tree.degrees if tree.urdf.joints[name].turns else 1.0
            has_spring = joint.springy or name in tree.springs
            own = _without(joint, tree.added[name], f"joint {plain(name)!r}")
            written = _attributes(own, angle, has_spring)
            if own.frictionloss and not keeps:
                written |= _STICKING
            if name in drives and "actuatorfrcrange" in text:
                written["actuatorfrclimited"] = "false"
            edits.append(with_attributes(content, at, written))
        for pair in dynamics.couplings:
            one, two = (joint_name(chain, number) for number in (pair.first, pair.second))
            if (one, two) in tree.tendons:
                tendon = tree.tendons[one, two]
                at = _named(named, "tendon", tendon.name)
                own_pair = _without(pair, tendon.added, f"tendon {plain(tendon.name)!r}")
                edits.append(with_attributes(content, at, _losses(own_pair)))
            else:
                tendons += _tendon(one, two, pair)
        edits += drive_edits(tree.root, drives)
        if tendons:
            if section is None:
                section, tendons = (
                    tree.root,
                    ["<tendon>", *map("  {}".format, tendons), "</tendon>"],
                )
            edits.append(inserted(content, section, tendons))
    return edited(text, edits)


def _without(dynamics: Drive, added: Losses, where: str) -> Drive:
    """Return the losses of a joint or tendon itself, without those of its actuators and followers.

    Raises:
        ParameterError: an identified loss is smaller than what they add.
    """
    own = {}
    for key, share in added._asdict().items():
        value = getattr(dynamics, key, 0.0)
        if not share or (key in _HIGHER and not value):
            continue
        if share > value:
            raise ParameterError(
                f"{where}: its actuators and followers have {key} {share:.4g}, more than the "
                f"identified {value:.4g}; accepted: a file with less {key} there"
            )
        own[key] = value - share
    return replace(dynamics, **own)


def _inertial(body: Body) -> str:
    """Return the <inertial> of a body, in the frame of the body element."""
    values = " ".join(repr(float(body.inertia[pair])) for pair in _FULL)
    centre = " ".join(repr(float(v)) for v in body.com)
    return f'<inertial pos="{centre}" mass="{float(body.mass)!r}" fullinertia="{values}"/>'


def _by_name(elements: Iterable[Element]) -> dict[str | None, Element]:
    """Return elements of the file by their names."""
    return {e.attributes.get("name"): e for e in elements}


def _named(places: Mapping[str | None, Element], what: str, name: str) -> Element:
    """Return the element with a name in the file itself.

    Raises:
        ParameterError: there is no such element.
    """
    found = places.get(name)
    if found is None:
        raise ParameterError(
            f"there is no {what} of the name {plain(name)!r} in the file itself; accepted: an MJCF "
            "whose bodies and joints have names, one joint at most in a body, and are not included"
        )
    return found


def _attributes(dynamics: JointDynamics, angle: float, spring: bool) -> dict[str, str]:
    """Return the attributes of a <joint>.

    Args:
        dynamics: the identified values.
        angle: the number that the file contains for a radian.
        spring: whether the joint has a spring, or had one in the file.
    """
    written = _losses(dynamics)
    if spring:
        written["stiffness"] = repr(float(dynamics.stiffness))
    if dynamics.springy:
        written["springref"] = repr(float(dynamics.springref * angle))
    for key in ("damping", "stiffness"):
        higher = [float(getattr(dynamics, f"{key}_{order}")) for order in (2, 3)]
        if any(higher):
            written[key] += "".join(f" {value!r}" for value in higher)
    return written


def _losses(dynamics: JointDynamics | CouplingDynamics) -> dict[str, str]:
    return {key: repr(float(getattr(dynamics, key))) for key in COUPLING.values()}


def _tendon(one: str, two: str, pair: CouplingDynamics) -> list[str]:
    """Return a fixed tendon of length q_first + ratio q_second."""
    words = " ".join(f'{key}="{value}"' for key, value in _losses(pair).items())
    return [
        f"<fixed name={quoteattr(f'coupling_{one}_{two}')} {words}>",
        f'  <joint joint={quoteattr(one)} coef="1"/>',
        f'  <joint joint={quoteattr(two)} coef="{float(pair.ratio)!r}"/>',
        "</fixed>",
    ]
