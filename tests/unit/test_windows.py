"""Where sliding windows end."""

from __future__ import annotations

import pytest

from symgen.estimation.windows import Windows, windows


@pytest.mark.parametrize(
    ("step", "stride", "window", "expected"),
    [
        (0.001, 7, 0.2, Windows(7, 29, 3)),  # every 0.021 s, not every 0.014 s
        (0.001, 4, 0.2, Windows(4, 50, 5)),
        (0.001, 40, 0.2, Windows(10, 20, 2)),  # nodes enough for the integral
        (0.01, 1, 0.2, Windows(1, 20, 2)),
        (0.01, 1, 0.04, Windows(1, 4, 1)),
        (0.01, 1, 0.004, Windows(1, 1, 1)),
    ],
)
def test_windows_end_at_the_tenth_part_of_their_length_that_is_nearest(
    step: float, stride: int, window: float, expected: Windows
) -> None:
    assert windows(step, stride, window) == expected
