"""Draw quick_start.svg: python docs/pictures/quick_start.py FOLDER of the tutorial."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from drawing import BLUE, GREY, RED, Line, chart


def picture(folder: Path) -> str:
    """Return the elbow torque of the second log: measured, and by both models."""
    old, new = (
        np.genfromtxt(folder / name / "prediction.csv", delimiter=",", names=True)
        for name in ("before", "after")
    )
    kept = slice(0, None, len(old) // 200)
    t = old["t"][kept]
    return chart(
        "Torque of the elbow: measured, by the URDF, and by the identified model",
        [
            Line("measured", t, old["tau3"][kept], GREY, width=5),
            Line("by the URDF", t, old["predicted3"][kept], RED),
            Line("by the identified model", t, new["predicted3"][kept], BLUE),
        ],
        ("time, s", range(0, 11, 2)),
        ("elbow torque, N m", range(-12, 13, 4)),
    )


if __name__ == "__main__":
    Path("quick_start.svg").write_text(picture(Path(sys.argv[1])), encoding="utf-8")
