"""The filter band of a run: the cutoff of positions and speeds, and the comparison band of torques.

symgen chooses both from all training logs and uses them in the whole run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from symgen.data.mask import mean_speeds, slow_speeds
from symgen.data.signals import OPEN, Samples, can_filter
from symgen.estimation.values import FloatArray
from symgen.schemas import OPTIONAL

#: No run has a lower rate or cutoff, Hz.
_LOWEST = 1e-9


@dataclass(frozen=True)
class Rests:
    """Down-weights samples at standstill, where static friction can take any value.

    Attributes:
        slow: (n,) speeds in rad/s (m/s) below which a joint is at rest; negative if it never is.
        weight: (n,) weight of equations at rest relative to those in motion, in (0, 1].
    """

    slow: tuple[float, ...]
    weight: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.slow) != len(self.weight) or not all(0 < w <= 1 for w in self.weight):
            raise ValueError("weights beyond (0, 1], or of other joints")


@dataclass(frozen=True)
class Band:
    """The filters of a run.

    Attributes:
        rate_hz: sampling rate of the training logs, the lowest of them.
        cutoff_hz: cutoff of the zero-phase low-pass of positions and speeds; half the sampling rate
            without a filter.
        comparison_hz: cutoff of the low-pass of measured and modelled torque before their
            comparison.
        velocity: "measured", or "derived" from positions.
        rests: speeds and weights of joints at rest; None if no joint rests.
    """

    rate_hz: float
    cutoff_hz: float
    comparison_hz: float
    velocity: str
    rests: Annotated[Rests | None, OPTIONAL] = None

    def __post_init__(self) -> None:
        derived = self.velocity in ("measured", "derived")
        if not (derived and min(self.rate_hz, self.cutoff_hz, self.comparison_hz) > _LOWEST):
            raise ValueError("no run has such a band")

    def filters(self, step: float) -> bool:
        """Return whether symgen low-passes the positions of a log with this sampling step."""
        return can_filter(self.cutoff_hz, step)

    def in_words(self) -> str:
        """Return the line that every command prints."""
        passed = (
            f"positions and speeds below {self.cutoff_hz:.3g} Hz"
            if self.cutoff_hz < OPEN * self.rate_hz
            else "positions and speeds unfiltered"
        )
        return (
            f"{self.rate_hz:.4g} Hz, {passed}, torques compared below {self.comparison_hz:.3g} Hz, "
            f"speeds {self.velocity}"
        )


def rest_speeds(logs: Sequence[Samples], sigma: Sequence[int]) -> FloatArray:
    """Return the mean speeds below which joints rest, (n,) rad/s (m/s); -1 if one never moves.

    Args:
        logs: logs from which the speeds of the joints are taken.
        sigma: (n,) types of the joints.
    """
    largest = np.max([np.abs(mean_speeds(s.q, s.step)).max(axis=0) for s in logs], axis=0)
    slow, still = slow_speeds(largest, sigma)
    return np.where(still, -1.0, slow)
