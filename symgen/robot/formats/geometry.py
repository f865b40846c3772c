"""Shapes of a robot file, as far as they bound a link: primitives, and points of meshes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symgen.errors import RobotError, located, told_by
from symgen.robot.body import FloatArray
from symgen.robot.expressions import shortened

_NUMBERS = rb"\s+(\S+)\s+(\S+)\s+(\S+)"
_VERTEX = {".stl": re.compile(rb"\bvertex" + _NUMBERS), ".obj": re.compile(rb"^v" + _NUMBERS, re.M)}
#: Binary STL: a head of 80 bytes, the number of triangles, and the triangles.
_HEAD, _FIRST = 80, 84
_TRIANGLE = np.dtype([("normal", "<3f4"), ("points", "<9f4"), ("attributes", "<u2")])


class Shape(NamedTuple):
    """All sums of a point and of A u with |u| <= 1; of a mesh or box as many as bound it.

    Attributes:
        points: (k, 3), m.
        A: (3, 3), m; 0 for a mesh or box, r I for balls of radius r about the points.
    """

    points: FloatArray
    A: FloatArray

    def ends(self, pose: FloatArray) -> FloatArray:
        """Return its lowest and highest coordinates (2, 3) in another frame.

        Args:
            pose: the frame of the shape (4, 4) there.
        """
        R = pose[:3, :3]
        points, reach = self.points @ R.T + pose[:3, 3], np.linalg.norm(R @ self.A, axis=1)
        return np.stack([points.min(axis=0) - reach, points.max(axis=0) + reach])


def primitive(kind: str, size: Sequence[float] | FloatArray) -> Shape:
    """Return a shape about the origin, along z.

    Args:
        kind: sphere, capsule, cylinder, ellipsoid or box.
        size: (3,) half lengths of a box or ellipsoid; else the radius, and half the length of a
            cylinder, or of the line of centres of a capsule.
    """
    radius, half, _ = size
    radii, halves = {
        "sphere": ((radius, radius, radius), (0, 0, 0)),
        "capsule": ((radius, radius, radius), (0, 0, half)),
        "cylinder": ((radius, radius, 0), (0, 0, half)),
        "ellipsoid": (size, (0, 0, 0)),
        "box": ((0, 0, 0), size),
    }[kind]
    corners = np.array([*product((-1.0, 1.0), repeat=3)]) * halves
    return Shape(corners, np.diag(np.array(radii, dtype=float)))


def mesh(points: FloatArray) -> Shape:
    """Return the shape of a mesh with points (k, 3)."""
    return Shape(points, np.zeros((3, 3)))


def read_mesh(name: str, folder: Path) -> FloatArray:
    """Return the points (k, 3) of an STL or OBJ.

    Args:
        name: as a URDF has it: a path in the folder, file://PATH, or package://PACKAGE/PATH. The
            package is looked for in the folder and in those above it.
        folder: of the URDF.

    Raises:
        RobotError: the file is not there, or has no points that can be read.
    """
    with located(f"mesh {shortened(name)!r}"):
        kind = Path(name).suffix.lower()
        if kind not in _VERTEX:
            raise RobotError("accepted: STL and OBJ")
        scheme, _, rest = name.rpartition("://")
        places = [folder / rest]
        if scheme not in ("", "file"):
            above, inside = (folder, *folder.resolve().parents), rest.partition("/")[2]
            places = [up / part for up in above for part in (rest, inside)]
        try:
            path = next((place for place in places if place.is_file()), None)
            if path is None:
                raise RobotError("there is no such file")
            points = _points(path.read_bytes(), kind)
        except (OSError, ValueError) as error:
            raise RobotError(told_by(error)) from error
        if not len(points) or not np.isfinite(points).all():
            raise RobotError("accepted: a file with points, all finite")
        return points


def _points(content: bytes, kind: str) -> FloatArray:
    """Return the points (k, 3) in a file of a kind.

    Raises:
        ValueError: a number cannot be read.
    """
    count = int.from_bytes(content[_HEAD:_FIRST], "little")
    if kind == ".stl" and 0 < count <= (len(content) - _FIRST) // _TRIANGLE.itemsize:
        triangles = np.frombuffer(content, _TRIANGLE, count, _FIRST)
        with np.errstate(invalid="ignore"):  # the caller refuses NaN
            return triangles["points"].reshape(-1, 3).astype(float)
    return np.array(_VERTEX[kind].findall(content)).astype(float)
