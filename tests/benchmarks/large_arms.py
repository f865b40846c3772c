"""Large robots: chains of revolute joints, and a humanoid of 30 joints."""

from __future__ import annotations

import math

from oracles.transforms import GEOMETRY, Arm


def chain(joints: int) -> Arm:
    """A chain of revolute joints, axes at right angles in turn."""
    turns = (0.0, *((-1.0) ** j * math.pi / 2 for j in range(1, joints)))
    return Arm.from_table(
        {
            "sigma": (0,) * joints,
            "alpha": turns,
            "d": tuple(0.1 * (j % 3) for j in range(joints)),
            "r": tuple(0.2 * ((j + 1) % 3) for j in range(joints)),
        }
    )


def humanoid() -> Arm:
    """Two legs of 6 joints and a waist of 3 on the base; two arms of 7 and a head on the waist."""
    table: dict[str, list[float]] = {key: [] for key in ("sigma", "ant", *GEOMETRY)}

    def limb(root: int, joints: int, gamma: float, b: float) -> int:
        for j in range(joints):
            aside = (gamma, b) if j == 0 else (0.0, 0.0)
            alpha, d, r = (-1) ** j * math.pi / 2, 0.05 * (j % 3), 0.1 * ((j + 1) % 3)
            row = (0, len(table["ant"]) if j else root, *aside, alpha, d, 0.2 * j, r)
            for key, value in zip(("sigma", "ant", *GEOMETRY), row, strict=True):
                table[key].append(value)
        return len(table["ant"])

    limb(0, 6, 0.3, -0.1)
    limb(0, 6, -0.3, -0.1)
    waist = limb(0, 3, 0.0, 0.2)
    limb(waist, 7, 0.7, 0.4)
    limb(waist, 7, -0.7, 0.4)
    limb(waist, 1, 0.0, 0.5)
    return Arm.from_table(table)


#: Name -> robot, as tests and benchmarks take them.
LARGE = {**{f"chain{n}": chain(n) for n in (7, 15, 30, 50)}, "humanoid": humanoid()}
