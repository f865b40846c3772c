"""The meaning of [limits]: what the joints may do, and the cell that the robot stands in."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from symgen.errors import RobotError
from symgen.robot.types import Limits

if TYPE_CHECKING:
    from symgen.robot.schema import LimitsTable

#: Keys with an entry for each movable joint.
OF_JOINTS = ("position", "velocity", "acceleration", "jerk", "torque")


def limits_from_table(
    table: LimitsTable | None, n: int, fail: Callable[[str], RobotError]
) -> Limits | None:
    """Return the limits that a validated table declares for n movable joints.

    Args:
        table: None where the file has none.
        n: number of movable joints.
        fail: makes an error of a message, with the name of the file.

    Raises:
        RobotError: another number of joints, an empty range, or a box without room.
    """
    if table is None:
        return None
    for key in OF_JOINTS:
        values = getattr(table, key)
        if values is not None and len(values) != n:
            raise fail(
                f"limits, key {key!r}: {len(values)} entries; accepted: one for each of "
                f"the {n} movable joints"
            )
    for low, high in table.position or ():
        if low >= high:
            raise fail(f"limits, key 'position': [{low}, {high}] is empty")
    for k, box in enumerate(table.boxes, 1):
        if any(low >= high for low, high in box):
            raise fail(f"limits, key 'boxes', entry {k}: empty; accepted: [[x, x], [y, y], [z, z]]")
    given = {key: getattr(table, key) for key in OF_JOINTS}
    return Limits(
        **{key: None if values is None else tuple(values) for key, values in given.items()},
        floor=table.floor,
        boxes=tuple(table.boxes),
        tool=table.tool,
    )


def limits_toml(limits: Limits) -> list[str]:
    """Return the lines of the table [limits]."""
    lines = ["[limits]"]
    for key in (*OF_JOINTS, "floor", "tool"):
        value = getattr(limits, key)
        if value is not None:
            lines.append(f"{key} = {_text(value)}")
    if limits.boxes:
        lines.append(f"boxes = {_text(limits.boxes)}")
    return lines


def _text(value: object) -> str:
    """Write numbers and nested tuples of them as TOML has them."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value))}]"
    return repr(value)
