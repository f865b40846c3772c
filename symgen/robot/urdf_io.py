"""URDF to modified Denavit-Hartenberg frames with the inertias moved along, and back.

Frame 0 is the root link, q is the URDF's own (sign and zero). The frame of a movable joint has its
z along the joint's axis and its x along the common normal with the next axis; what remains of the
URDF's frame is a constant placement of the link frame in it. Fixed joints stand on the link that
carries them, after all others, and keep the URDF's frames.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from symgen.errors import ParameterError
from symgen.robot.denavit_hartenberg import Matrix
from symgen.robot.expressions import shortened
from symgen.robot.imported import Imported, read_text
from symgen.robot.recognition import context, number
from symgen.robot.urdf_chain import Chain
from symgen.robot.urdf_text import TENSOR, parse_urdf
from symgen.robot.xml_text import Element

_CAVEAT = """<!-- The inertial values below were written by symgen. Measured motion determines
     base parameters only, and base parameters do not determine link parameters: these are one
     physically consistent member of the family that has them. -->
"""


class Body(NamedTuple):
    """Mass [kg], centre of mass [m] and inertia about it [kg m2] of a link, in one frame."""

    mass: float
    centre: Sequence[float]
    inertia: Sequence[Sequence[float]]


def import_urdf(text: str, where: str = "robot.urdf", exact: bool = True) -> Imported:
    """Read a URDF as a robot, with the inertias of its links as standard parameters.

    Args:
        text: the file's text.
        where: what error messages call the file.
        exact: whether rounded fractions of pi (1.5708) are read as what they mean.

    Raises:
        RobotError: it is no URDF, or no robot that symgen can have; one line names the fault.
    """
    chain = Chain(parse_urdf(text, where), where, exact)
    return Imported(chain.robot(), tuple(chain.parameters()), tuple(chain.notes))


def updated_urdf(
    source: str | Path, bodies: Mapping[int, Body], where: str = "robot.urdf", exact: bool = True
) -> str:
    """Write link parameters into the <inertial> elements of a copy of a URDF.

    Args:
        source: the text of the URDF, or its path; everything else in it stays as it is.
        bodies: by joint number of the imported robot, the body behind that joint in frame j
            (fixed joints included); links that are not named keep what they have.
        where: what error messages call a text.
        exact: as in `import_urdf`.

    Raises:
        RobotError: the URDF cannot be read.
        ParameterError: there is no such joint, or a value is not finite.
    """
    if isinstance(source, Path):
        where = str(source)
        source, _ = read_text(source, "accepted: a path to a .urdf")
    urdf = parse_urdf(source, where)
    chain = Chain(urdf, where, exact)
    content = source.encode("utf-8")
    edits: list[tuple[int, int, bytes]] = []
    for joint, body in bodies.items():
        if not 1 <= joint <= len(chain.order):
            raise ParameterError(
                f"{where}: there is no joint {joint}; accepted: 1 to {len(chain.order)}"
            )
        name = chain.order[joint - 1]
        link = urdf.links[urdf.joints[name].child]
        written = _inertial(_moved(body, chain, name, where))
        edits.append(_edit(content, link.element, written))
    for start, end, new in sorted(edits, reverse=True):
        content = content[:start] + new + content[end:]
    text = content.decode("utf-8")
    head = re.match(r"\s*<\?xml[^>]*\?>\s*", text)
    at = head.end() if head else 0
    return text[:at] + _CAVEAT + text[at:]


def _moved(body: Body, chain: Chain, name: str, where: str) -> Body:
    """Return a body of frame j in the frame of the URDF's link."""
    mass, centre, inertia = body
    values = [mass, *centre, *(v for row in inertia for v in row)]
    if len(values) != 13 or not all(math.isfinite(v) for v in values):
        raise ParameterError(
            f"{where}: joint {shortened(name)!r}: accepted: a mass, 3 coordinates of its centre "
            "and a 3 x 3 inertia, all finite"
        )
    mpf = context().mpf
    x, y, z = (mpf(float(v)) for v in centre)
    rows: list[tuple[object, object, object]] = []
    for row in inertia:
        a, b, c = (mpf(float(v)) for v in row)
        rows.append((a, b, c))
    tensor: Matrix = (rows[0], rows[1], rows[2])
    pose = chain.inside(name).inverse()
    place = pose.point((x, y, z))
    turned = pose.tensor(tensor)
    return Body(
        float(mass), [number(v) for v in place], [[number(v) for v in row] for row in turned]
    )


def _inertial(body: Body) -> list[str]:
    upper = [(i, k) for i in range(3) for k in range(i, 3)]
    tensor = " ".join(
        f'{key}="{body.inertia[i][k]!r}"' for key, (i, k) in zip(TENSOR, upper, strict=True)
    )
    return [
        "<inertial>",
        f'  <origin xyz="{" ".join(map(repr, body.centre))}" rpy="0 0 0"/>',
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
    return link.start, link.end, tag + f">{new}\n{indent}</link>".encode()
