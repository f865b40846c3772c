"""Draw tutorial_diagnose.svg: python docs/pictures/tutorial_diagnose.py FOLDER of the tutorial."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from drawing import BLUE, RED, Line, chart


def picture(folder: Path) -> str:
    """Return the residual of joint 2 over time, before and after the diagnosis."""
    lines = []
    for label, name, color in (("model of arm.toml", "before", RED),
                               ("with the named effect", "after", BLUE)):  # fmt: skip
        found = np.genfromtxt(folder / name / "prediction.csv", delimiter=",", names=True)
        kept = slice(0, None, len(found) // 250)
        residual = found["tau2"] - found["predicted2"]
        lines.append(Line(label, found["t"][kept], residual[kept], color))
    return chart(
        "Residual torque of joint 2 before and after the diagnosis",
        lines,
        ("time, s", range(0, 21, 5)),
        ("residual of joint 2, N m", range(-4, 5, 2)),
    )


if __name__ == "__main__":
    Path("tutorial_diagnose.svg").write_text(picture(Path(sys.argv[1])), encoding="utf-8")
