"""Draw tutorial_simulator.svg from the tutorial: python tutorial_simulator.py FOLDER"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from drawing import BLUE, GREY, RED, Line, chart


def picture(folder: Path) -> str:
    """Return the angle of the elbow: measured, and simulated with both files."""
    seen = np.genfromtxt(folder / "simulated" / "window.csv", delimiter=",", names=True)
    kept = slice(0, None, len(seen) // 200)
    t = seen["t"][kept]
    # The picture ends where the original arm has left the measured motion by far.
    near = np.abs(seen["file1_q2"][kept]) < 1.5
    first = len(t) if near.all() else int(np.argmin(near))
    return chart(
        "Angle of the elbow in simulation",
        [
            Line("measured", t, seen["q2"][kept], GREY, 4.0),
            Line("arm.xml", t[:first], seen["file1_q2"][kept][:first], RED),
            Line("identified.xml", t, seen["file2_q2"][kept], BLUE),
        ],
        ("time, s", [0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        ("angle of the elbow, rad", [-1.5, -1, -0.5, 0, 0.5, 1, 1.5]),
    )


if __name__ == "__main__":
    Path("tutorial_simulator.svg").write_text(picture(Path(sys.argv[1])), encoding="utf-8")
