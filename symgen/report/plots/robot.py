"""Draw the frames of a robot from its Denavit-Hartenberg table, as SVG for a page."""

from __future__ import annotations

from typing import Any

import numpy as np

from symgen.data.raw import FloatArray
from symgen.files import rendered
from symgen.robot import dh
from symgen.robot.types import Robot

_ROOM, _MARGIN = np.array([540.0, 320.0]), 52.0  # pixels
#: Projection of x, y, z of frame 0 to right and up in the drawing: x to the right, view from above.
_VIEW = np.array([[0.91, 0.42, 0.0], [-0.18, 0.38, 0.91]])
_AXES = ((0, "x", "6 4"), (2, "z", ""))
_NEAR = 14.0  # pixels; closer origins are drawn as one


def drawing(robot: Robot, *positions: dict[int, float]) -> str:
    """Return the SVG: links as lines, joints as circles and squares, axes x and z of each frame.

    Args:
        robot: the robot.
        positions: number of a movable joint -> position, of each drawn pose; by default at zero.
    """
    fixed = robot.with_values()
    at_zero = dict.fromkeys((joint.number for joint in robot.movable), 0.0)
    poses = np.array([dh.frames(fixed, each) for each in positions or [at_zero]])
    flat = poses[:, :, :3, 3] @ _VIEW.T
    low, size = flat.min(axis=(0, 1)), np.ptp(flat, axis=(0, 1))
    scale = float(min(_ROOM / np.maximum(size, 1e-9))) if size.max() > 1e-9 else 1.0
    wide, high = scale * size + 2 * _MARGIN
    places = scale * (flat - low) + _MARGIN
    places[..., 1] = high - places[..., 1]
    drawn = [_pose(robot, placed, at) for placed, at in zip(poses, places, strict=True)]
    size = f"{wide:.0f}", f"{high:.0f}"
    return rendered("report/robot.svg", name=robot.name, size=size, poses=drawn)


def _pose(robot: Robot, placed: FloatArray, at: FloatArray) -> dict[str, Any]:
    """Return the lines, joints and labels of a pose with frames (f, 4, 4) at places (f, 2)."""
    ends = list(zip(robot.joints, at[1:].tolist(), strict=True))
    lines = [("link", "", *at[joint.antecedent], *end) for joint, end in ends]
    for place, T in zip(at, placed, strict=True):
        for axis, word, dash in _AXES:
            right, up = _VIEW @ T[:3, axis]
            tip = place + 30 * np.array([right, -up])
            lines.append((f"axis {word}", dash, *place, *tip))
    joints = [(joint.sigma, *end) for joint, end in ends]
    return {"lines": lines, "joints": joints, "labels": _merged([*at])}


def _merged(at: list[FloatArray]) -> list[tuple[FloatArray, list[int]]]:
    """Return each origin with the numbers of its frames."""
    out: list[tuple[FloatArray, list[int]]] = []
    for number, place in enumerate(at):
        near = next((numbers for there, numbers in out if np.hypot(*(there - place)) < _NEAR), None)
        if near is None:
            out.append((place, [number]))
        else:
            near.append(number)
    return out
