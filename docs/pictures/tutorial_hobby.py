"""Draw tutorial_hobby.svg from the tutorial: python tutorial_hobby.py FOLDER"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from drawing import BLUE, GREY, Line, chart


def picture(folder: Path) -> str:
    """Return the position error of a joint with and without gravity compensation.

    Means of half a second leave out the steps of the encoders.
    """
    seen = np.genfromtxt(folder / "errors.csv", delimiter=",", names=True)
    t, plain, gravity = (seen[k].reshape(-1, 15).mean(axis=1) for k in seen.dtype.names)
    return chart(
        "Position error of shoulder_lift on a slow motion",
        [
            Line("goals as wanted", t, plain, GREY),
            Line("with gravity compensation", t, gravity, BLUE),
        ],
        ("time, s", range(0, 21, 5)),
        ("error of shoulder_lift, degrees", range(-1, 5)),
    )


if __name__ == "__main__":
    Path("tutorial_hobby.svg").write_text(picture(Path(sys.argv[1])), encoding="utf-8")
