"""Draw pipeline.svg: python pipeline.py, in docs/pictures."""

from __future__ import annotations

from pathlib import Path

#: Column, row, first line, second line, and whether it is the user's own.
BOXES = (
    (0, 0, "robot.toml, URDF,", "MJCF, SYMORO", True),
    (0, 2, "logs: CSV, NPZ,", "bags, MCAP", True),
    (1, 0, "model in closed form,", "minimal, proved", False),
    (2, 0, "C99, CasADi,", "FMU, MEX", False),
    (1, 1, "excite: a motion", "within your limits", False),
    (1, 2, "identify: parameters,", "precision, verdict", False),
    (2, 1, "payload: what", "the arm carries", False),
    (2, 2, "diagnose: what", "the model misses", False),
)
#: From box to box.
ARROWS = ((0, 2), (2, 3), (2, 4), (4, 1), (1, 5), (2, 5), (5, 6), (5, 7))
WIDTH, HEIGHT, ACROSS, DOWN = 190, 56, 270, 92
INK, LINE, MINE, OURS = "#24292f", "#57606a", "#fdf8e8", "#eaf3fa"


def picture() -> str:
    """Return the SVG."""
    wide, high = 2 * ACROSS + WIDTH + 20, 2 * DOWN + HEIGHT + 20
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" '
        'font-family="system-ui, Segoe UI, Helvetica, Arial, sans-serif" font-size="14">',
        "<title>From a table and a log to a model, its parameters, and what they miss</title>",
        f'<rect width="{wide}" height="{high}" rx="8" fill="#ffffff"/>',
        '<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" '
        f'orient="auto"><path d="M0 0L8 4L0 8z" fill="{LINE}"/></marker>',
    ]
    for start, end in ARROWS:
        (x1, y1), (x2, y2) = _ends(start, end)
        out.append(f'<path d="M{x1} {y1}L{x2} {y2}" stroke="{LINE}" stroke-width="1.5" '
                   'marker-end="url(#tip)"/>')  # fmt: skip
    for column, row, first, second, mine in BOXES:
        x, y = 10 + column * ACROSS, 10 + row * DOWN
        out.append(f'<rect x="{x}" y="{y}" width="{WIDTH}" height="{HEIGHT}" rx="6" '
                   f'fill="{MINE if mine else OURS}" stroke="{LINE}"/>')  # fmt: skip
        for k, line in enumerate((first, second)):
            out.append(f'<text x="{x + WIDTH // 2}" y="{y + 24 + 19 * k}" fill="{INK}" '
                       f'text-anchor="middle">{line}</text>')  # fmt: skip
    return "\n".join([*out, "</svg>", ""])


def _ends(start: int, end: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return where an arrow leaves a box and where it meets the other."""
    (c1, r1, *_), (c2, r2, *_) = BOXES[start], BOXES[end]
    x1, y1 = 10 + c1 * ACROSS, 10 + r1 * DOWN
    x2, y2 = 10 + c2 * ACROSS, 10 + r2 * DOWN
    if c1 == c2:
        # past a box between them, on its left
        side = 40 if r2 - r1 > 1 else WIDTH // 2
        return (x1 + side, y1 + HEIGHT), (x2 + side, y2)
    right = c2 > c1
    return (
        (x1 + (WIDTH if right else 0), y1 + HEIGHT // 2),
        (x2 + (0 if right else WIDTH), y2 + HEIGHT // 2),
    )


if __name__ == "__main__":
    Path("pipeline.svg").write_text(picture(), encoding="utf-8")
