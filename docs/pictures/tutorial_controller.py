"""Draw tutorial_controller.svg: python tutorial_controller.py FOLDER of the tutorial."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from drawing import BLUE, GREY, RED, Line, chart


def picture(folder: Path) -> str:
    """Return the position error of joint 1 under the three controllers."""
    seen = np.genfromtxt(folder / "errors.csv", delimiter=",", names=True)
    kept = slice(0, None, len(seen) // 200)
    t = seen["t"][kept]
    return chart(
        "Position error of joint 1 under three controllers",
        [
            Line("PD", t, seen["pd"][kept], GREY),
            Line("PD + gravity", t, seen["gravity"][kept], RED),
            Line("PD + inverse dynamics", t, seen["inverse"][kept], BLUE),
        ],
        ("time, s", range(7)),
        ("error of joint 1, degrees", range(-2, 9, 2)),
    )


if __name__ == "__main__":
    Path("tutorial_controller.svg").write_text(picture(Path(sys.argv[1])), encoding="utf-8")
