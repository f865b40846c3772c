"""Draw the frames of a robot from its Denavit-Hartenberg table, as SVG for a page."""

from __future__ import annotations

import html
from collections.abc import Iterator

import numpy as np

from symgen import names
from symgen.data.raw import FloatArray
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
    out = [
        f'<svg class="robot" data-poses="{len(poses)}" viewBox="0 0 {wide:.0f} {high:.0f}" '
        f'width="{wide:.0f}" role="img" aria-label="Frames of {html.escape(robot.name)}">'
    ]
    for placed, at in zip(poses, places, strict=True):
        out += ["<g>", *_pose(robot, placed, at), "</g>"]
    return "\n".join([*out, "</svg>"])


def _pose(robot: Robot, placed: FloatArray, at: FloatArray) -> Iterator[str]:
    """Yield the elements of a pose with frames (f, 4, 4) at places (f, 2) of the drawing."""
    for joint, end in zip(robot.joints, at[1:], strict=True):
        yield _line(at[joint.antecedent], end, "link")
    for place, T in zip(at, placed, strict=True):
        for axis, _, dash in _AXES:
            along = _VIEW @ T[:3, axis]
            tip = place + 30 * np.array([along[0], -along[1]])
            yield _line(place, tip, f"axis {'xz'[axis > 0]}", dash)
    for joint, (x, y) in zip(robot.joints, at[1:].tolist(), strict=True):
        if joint.sigma == names.REVOLUTE:
            yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6"/>'
        elif joint.sigma == names.PRISMATIC:
            yield f'<rect x="{x - 6:.1f}" y="{y - 6:.1f}" width="12" height="12"/>'
    for near in _merged([*at]):
        yield _label(*near)


def _line(start: FloatArray, end: FloatArray, kind: str, dash: str = "") -> str:
    (x1, y1), (x2, y2) = start, end
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path class="{kind}"{dashed} d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"/>'


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


def _label(place: FloatArray, numbers: list[int]) -> str:
    text = ", ".join(map(str, numbers))
    return f'<text x="{place[0] + 10:.1f}" y="{place[1] + 18:.1f}">{text}</text>'
