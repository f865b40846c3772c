"""Run the example planned_motion and draw planned_motion.svg: python planned_motion.py"""

from __future__ import annotations

from pathlib import Path

from drawing import BLUE, RED, Line, chart, example


def picture() -> str:
    """Return the position of joint 2 in the planned and in the slow motion."""
    made = example("planned_motion")
    good, slow = made["good"], made["slow"]
    kept = slice(0, None, max(1, len(good.t) // 250))
    return chart(
        "Position of joint 2 in the planned motion and in the slow one",
        [
            Line("planned motion", good.t[kept], good.q[kept, 1], BLUE),
            Line("slow motion", slow.t[kept], slow.q[kept, 1], RED),
        ],
        ("time, s", range(0, 11, 2)),
        ("position of joint 2, rad", range(-2, 3)),
    )


if __name__ == "__main__":
    Path("planned_motion.svg").write_text(picture(), encoding="utf-8")
