"""Run the example two_links and draw two_links.svg: python two_links.py"""

from __future__ import annotations

from pathlib import Path

from drawing import BLUE, GREY, Line, chart, example


def picture() -> str:
    """Return the torque of joint 1 in the second run: measured, and by the identified model."""
    made = example("two_links")
    kept = slice(0, None, 50)
    test, tau = made["test"], made["tau"]
    return chart(
        "Torque of joint 1 in the second run: measured, and by the identified model",
        [
            Line("measured", test.t[kept], test.tau[kept, 0], GREY, width=5),
            Line("by the identified model", test.t[kept], tau[kept, 0], BLUE),
        ],
        ("time, s", range(0, 21, 5)),
        ("torque of joint 1, N m", range(-6, 10, 3)),
    )


if __name__ == "__main__":
    Path("two_links.svg").write_text(picture(), encoding="utf-8")
