"""Small charts for the tutorials, as SVG that is legible on a phone."""

from __future__ import annotations

import runpy
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

WIDTH, HEIGHT = 400, 270
LEFT, RIGHT, TOP, BOTTOM = 44, 14, 48, 44
INK, GRID, GREY, BLUE, RED = "#24292f", "#e3e6ea", "#a8b0b9", "#0b6bcb", "#d1480f"


@dataclass(frozen=True)
class Line:
    """A curve of a chart."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    color: str
    width: float = 1.6


def example(name: str) -> dict[str, Any]:
    """Run a script of docs/examples, which prints its output, and return its variables."""
    script = Path(__file__).parents[1] / "examples" / f"{name}.py"
    return runpy.run_path(str(script), run_name="__main__")


def chart(
    title: str,
    lines: Sequence[Line],
    x: tuple[str, Sequence[float]],
    y: tuple[str, Sequence[float]],
) -> str:
    """Return a chart; `x` and `y` are the name of an axis and its ticks, from end to end."""

    def across(value: float) -> float:
        return LEFT + (value - x[1][0]) / (x[1][-1] - x[1][0]) * (WIDTH - LEFT - RIGHT)

    def down(value: float) -> float:
        return HEIGHT - BOTTOM - (value - y[1][0]) / (y[1][-1] - y[1][0]) * (HEIGHT - TOP - BOTTOM)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="560" '
        'font-family="system-ui, Segoe UI, Helvetica, Arial, sans-serif" font-size="13" '
        f'fill="{INK}">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#ffffff"/>',
    ]
    for tick in x[1]:
        out.append(_rule(across(tick), TOP, across(tick), HEIGHT - BOTTOM))
        out.append(_text(across(tick), HEIGHT - BOTTOM + 16, f"{tick:g}", "middle"))
    for tick in y[1]:
        out.append(_rule(LEFT, down(tick), WIDTH - RIGHT, down(tick)))
        out.append(_text(LEFT - 6, down(tick) + 4, f"{tick:g}", "end"))
    for line in lines:
        xy = [(across(a), down(b)) for a, b in zip(line.x, line.y, strict=True)]
        out.append(_curve(xy, line))
    out.append(_text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 8, x[0], "middle"))
    out.append(_text(8, TOP - 8, y[0], "start"))
    out += _legend(lines)
    return "\n".join([*out, "</svg>", ""])


def _legend(lines: Sequence[Line]) -> Iterable[str]:
    at = 8.0
    for line in lines:
        yield f'<rect x="{at:.0f}" y="10" width="14" height="5" rx="2" fill="{line.color}"/>'
        yield _text(at + 18, 17, line.label, "start")
        at += 34 + 6.8 * len(line.label)


def _rule(x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="{GRID}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _curve(xy: Sequence[tuple[float, float]], line: Line) -> str:
    path = "L".join(f"{a:.1f} {b:.1f}" for a, b in xy)
    return f'<path d="M{path}" fill="none" stroke="{line.color}" stroke-width="{line.width}"/>'
