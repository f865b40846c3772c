"""The meaning of [drive]: gears and motors between the sensors of a log and the joints."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from symgen.errors import RobotError
from symgen.robot.types import Drive

if TYPE_CHECKING:
    from symgen.robot.schema import DriveTable

#: Largest condition number of a matrix of gears, its rows scaled to unit length.
MAX_CONDITION = 1e6


def drive_from_table(
    table: DriveTable | None, n: int, fail: Callable[[str], RobotError]
) -> Drive | None:
    """Return the drive that a validated table declares for n movable joints.

    Args:
        table: None where the file has none.
        n: number of movable joints.
        fail: makes an error of a message, with the name of the file.

    Raises:
        RobotError: another number of joints, a singular matrix, or nothing declared.
    """
    if table is None:
        return None
    accepted = f"one number for each of the {n} movable joints"
    if not table.model_fields_set:
        raise fail("drive: declares nothing; accepted: ratio, torque_constant, gain or side")
    ratio = [1.0] * n if table.ratio is None else table.ratio
    if len(ratio) != n:
        raise fail(
            f"drive, key 'ratio': {len(ratio)} entries; accepted: {accepted}, or a {n} x {n} matrix"
        )
    for key in ("torque_constant", "gain", "gain_std"):
        given = getattr(table, key)
        if given is not None and len(given) != n:
            raise fail(f"drive, key {key!r}: {len(given)} entries; accepted: {accepted}")
    constant, gain, std = table.torque_constant, table.gain, table.gain_std
    side = "joint" if table.side == "link" else "motor"
    matrix = np.array(ratio) if isinstance(ratio[0], list) else np.diag(ratio)
    sizes = np.linalg.norm(matrix, axis=1)
    if not sizes.all() or np.linalg.cond(matrix / sizes[:, None]) > MAX_CONDITION:
        raise fail(
            "drive, key 'ratio': the matrix is singular; accepted: q_motor = N q_joint that can "
            "be solved for q_joint"
        )
    return Drive(
        ratio=tuple(tuple(map(float, row)) for row in matrix),
        torque_constant=None if constant is None else tuple(constant),
        position_side=table.position_side or side,
        torque_side=table.torque_side or side,
        gain=None if gain is None else tuple(gain),
        gain_std=None if std is None else tuple(std),
    )


def drive_toml(drive: Drive) -> list[str]:
    """Return the lines of the table [drive]; a diagonal matrix is written as one list."""
    n = len(drive.ratio)
    diagonal = all(drive.ratio[i][j] == 0.0 for i in range(n) for j in range(n) if i != j)
    ratio = [drive.ratio[i][i] for i in range(n)] if diagonal else [list(r) for r in drive.ratio]
    lines = ["[drive]", f"ratio = {ratio}"]
    if drive.torque_constant is not None:
        lines.append(f"torque_constant = {list(drive.torque_constant)}")
    for key in ("gain", "gain_std"):
        if getattr(drive, key) is not None:
            lines.append(f"{key} = {list(getattr(drive, key))}")
    for key in ("position_side", "torque_side"):
        if getattr(drive, key) != "motor":
            lines.append(f'{key} = "{getattr(drive, key)}"')
    return lines
