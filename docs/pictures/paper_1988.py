"""Run the example paper_1988 and draw paper_1988.svg: python paper_1988.py"""

from __future__ import annotations

from pathlib import Path

from drawing import BLUE, GREY, INK, RED, Line, chart, example


def picture() -> str:
    """Return the estimates of the first run over the samples, relative to the true values."""
    made = example("paper_1988")
    run = made["estimates"][0] / made["X"]
    samples = range(made["FIRST"], made["FIRST"] + len(run))
    kept = [k for k, n in enumerate(samples) if n >= 20]
    lines = [
        Line(name, [samples[k] for k in kept], run[kept, j], color)
        for j, (name, color) in enumerate(zip(made["names"], (INK, BLUE, RED, GREY), strict=True))
    ]
    return chart(
        "Estimates of a run over the samples, relative to the true values",
        lines,
        ("samples", range(20, 101, 20)),
        ("estimate over true value", (0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6)),
    )


if __name__ == "__main__":
    Path("paper_1988.svg").write_text(picture(), encoding="utf-8")
