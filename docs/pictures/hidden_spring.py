"""Run the example hidden_spring and draw hidden_spring.svg: python hidden_spring.py"""

from __future__ import annotations

from pathlib import Path

from drawing import BLUE, RED, Line, chart, example


def picture() -> str:
    """Return the residual of joint 2 on the second log, without and with the spring."""
    made, lines = example("hidden_spring"), []
    for label, name, color in (("without the spring", "before", RED),
                               ("with the spring", "after", BLUE)):  # fmt: skip
        trace = next(
            t for t in made[name].traces if (t.quantity, t.kind) == ("torque", "validation")
        )
        kept = slice(0, None, max(1, len(trace.t) // 250))
        residual = trace.measured[kept, 1] - trace.predicted[kept, 1]
        lines.append(Line(label, trace.t[kept], residual, color))
    return chart(
        "Residual torque of joint 2 without and with the spring",
        lines,
        ("time, s", range(0, 17, 4)),
        ("residual of joint 2, N m", range(-6, 7, 3)),
    )


if __name__ == "__main__":
    Path("hidden_spring.svg").write_text(picture(), encoding="utf-8")
