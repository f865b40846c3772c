"""URDF to modified Denavit-Hartenberg frames with the inertias moved along, and back.

Frame 0 is the root link, q is the URDF's own (sign and zero). The frame of a movable joint has its
z along the joint's axis and its x along the common normal with the next axis; what remains of the
URDF's frame is a constant placement of the link frame in it. Fixed joints stand on the link that
carries them, after all others, and keep the URDF's frames.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.errors import ParameterError
from symgen.robot import dh
from symgen.robot.body import Body
from symgen.robot.expressions import shortened
from symgen.robot.imported import Imported
from symgen.robot.urdf_chain import Chain
from symgen.robot.urdf_text import TENSOR, parse_urdf
from symgen.robot.xml_text import Element, parse_xml

FloatArray = NDArray[np.float64]
CAVEAT = (
    "<!-- written by symgen: base parameters do not determine link parameters; this is one link of "
    "one robot that has them -->"
)


def import_urdf(text: str, where: str = "robot.urdf") -> Imported:
    """Read a URDF as a robot, with the inertias of its links as standard parameters.

    Rounded fractions of pi (1.5708) are read as what they mean.

    Args:
        text: the file's text.
        where: what error messages call the file.

    Raises:
        RobotError: it is no URDF, or no robot that symgen can have; one line names the fault.
    """
    return Chain(parse_urdf(text, where), where).imported()


def updated_urdf(text: str, bodies: Iterable[Body], where: str = "robot.urdf") -> str:
    """Write link parameters into the <inertial> elements of a copy of a URDF.

    A fixed link without <inertial> gets none: its body goes to the link that carries it.

    Args:
        text: of the URDF; everything else in it stays as it is, to the byte.
        bodies: links of the imported robot in the frames of their joints, as `link_parameters`
            gives them (fixed joints included); links that are not named keep what they have.
        where: what error messages call the file.

    Raises:
        RobotError: the URDF cannot be read.
        ParameterError: there is no such joint, or a value is not finite.
    """
    found = written_bodies(Chain(parse_urdf(text, where), where), bodies, where)
    links = {e.attributes["name"]: e for e in parse_xml(text, where).all("link")}
    return replaced_inertials(text, [(links[name], _inertial(b)) for name, b in found.items()])


def written_bodies(chain: Chain, bodies: Iterable[Body], where: str) -> dict[str, Body]:
    """Return what is to be written of links by their names, each in its link's frame.

    Args:
        chain: of the file.
        bodies: links of the robot in the frames of their joints.
        where: what error messages call the file.

    Raises:
        ParameterError: there is no such joint, or a value is not finite.
    """
    urdf, parts = chain.urdf, dict[str, list[Body]]()
    for body in bodies:
        if not 1 <= body.joint <= len(chain.order):
            raise ParameterError(
                f"{where}: there is no joint {body.joint}; accepted: 1 to {len(chain.order)}"
            )
        name = chain.order[body.joint - 1]
        link = urdf.joints[name].child
        _require_finite(body, f"{where}: joint {shortened(name)!r}")
        while link != urdf.root and urdf.links[link] is None:
            if chain.above[link].sigma != names.FIXED:
                break
            link = chain.above[link].parent
        empty = urdf.links[link] is None and not body.mass and not np.any(body.inertia)
        if link == urdf.root or empty:  # nothing moves it, or it is nothing
            continue
        pose = dh.inverse(chain.link[link]) @ chain.frame[name]
        parts.setdefault(link, []).append(_moved(body, pose))
    return {link: _joined(own) for link, own in parts.items()}


def replaced_inertials(text: str, edits: Iterable[tuple[Element, Sequence[str]]]) -> str:
    """Return a text with new lines in place of <inertial>, or inside, of some of its elements."""
    content = text.encode("utf-8")
    found = [_edit(content, element, lines) for element, lines in edits]
    for start, end, new in sorted(found, reverse=True):
        content = content[:start] + new + content[end:]
    return content.decode("utf-8")


def without_inertials(text: str, where: str = "robot.urdf") -> bytes:
    """Return a URDF or MJCF without its <inertial> elements and blanks: all that is never written.

    Raises:
        RobotError: it is no XML.
    """
    content = text.encode("utf-8")
    found, waiting = [], [parse_xml(text, where)]
    while waiting:
        element = waiting.pop()
        found += element.all("inertial")
        waiting += [child for child in element.children if child.tag != "inertial"]
    for element in sorted(found, key=lambda e: e.start, reverse=True):
        content = content[: element.start] + content[element.end :]
    return re.sub(rb"></(link|body)>", b"/>", b"".join(content.split()))


def _require_finite(body: Body, place: str) -> None:
    values = [np.asarray(v, dtype=float) for v in (body.mass, body.com, body.inertia)]
    shapes = [v.shape for v in values]
    if shapes != [(), (3,), (3, 3)] or not all(np.isfinite(v).all() for v in values):
        raise ParameterError(
            f"{place}: accepted: a mass, 3 coordinates of its centre and a 3 x 3 inertia, "
            "all finite"
        )


def _moved(body: Body, pose: dh.Array) -> Body:
    """Return a body of a frame in another, in which `pose` places it."""
    R, origin = pose[:3, :3].astype(float), pose[:3, 3].astype(float)
    inertia = np.asarray(body.inertia, dtype=float)
    return Body(body.joint, float(body.mass), R @ body.com + origin, R @ inertia @ R.T)


def _joined(bodies: Sequence[Body]) -> Body:
    """Return bodies of one frame as one: I about the common centre, by Steiner's theorem."""
    if len(bodies) == 1:
        return bodies[0]
    mass = sum(b.mass for b in bodies)
    com = np.sum([b.mass * b.com for b in bodies], axis=0) / (mass or 1.0)
    inertia = np.zeros((3, 3))
    for b in bodies:
        r = b.com - com
        inertia += b.inertia + b.mass * (r @ r * np.eye(3) - np.outer(r, r))
    return Body(bodies[0].joint, mass, com, inertia)


def _inertial(body: Body) -> list[str]:
    upper = [(i, k) for i in range(3) for k in range(i, 3)]
    tensor = " ".join(
        f'{key}="{float(body.inertia[i, k])!r}"' for key, (i, k) in zip(TENSOR, upper, strict=True)
    )
    return [
        "<inertial>",
        f"  {CAVEAT}",
        f'  <origin xyz="{" ".join(repr(float(v)) for v in body.com)}" rpy="0 0 0"/>',
        f'  <mass value="{body.mass!r}"/>',
        f"  <inertia {tensor}/>",
        "</inertial>",
    ]


def _edit(content: bytes, link: Element, lines: Sequence[str]) -> tuple[int, int, bytes]:
    """Return which bytes of the text give way to a new <inertial>."""
    old = link.first("inertial")
    start = link.start if old is None else old.start
    margin = content[content.rfind(b"\n", 0, start) + 1 : start]
    indent = margin.decode("utf-8") if not margin.strip() else ""
    if old is not None:
        return old.start, old.end, f"\n{indent}".join(lines).encode()
    inner = f"\n{indent}  "
    new = inner + inner.join(lines)
    if link.close > link.inside or link.end > link.close:
        return link.inside, link.inside, new.encode()
    tag = content[link.start : link.inside].removesuffix(b"/>").rstrip()
    return link.start, link.end, tag + f">{new}\n{indent}</{link.tag}>".encode()
