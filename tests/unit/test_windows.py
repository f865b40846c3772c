"""Where sliding windows end."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import unfiltered
from symgen.estimation.windows import Windows, place_windows, windows


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


def test_a_window_is_longer_than_half_a_sample_and_shorter_than_its_log() -> None:
    t = np.arange(101) * 0.01
    motion = (np.sin(3 * t)[:, None], 3 * np.cos(3 * t)[:, None], np.zeros((101, 1)))
    log = unfiltered(Samples("log", t, *motion, 0.01, None, ()))
    assert place_windows(log, 0.006).steps == 1
    assert place_windows(log, 0.99).steps == 99
    for window in (0.004, 1.01):
        with pytest.raises(IdentificationError, match=f"{window:g} s does not fit"):
            place_windows(log, window)
