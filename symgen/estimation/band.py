"""The band of a run: the filter of positions and speeds, and that in which torques are compared.

Both are chosen from the training logs together, and used for everything that the run then does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from symgen.data.signals import Samples, lowpass
from symgen.estimation.values import FloatArray
from symgen.schemas import OPTIONAL

#: Share of the power of a joint's speed that lies below half the comparison band.
POWER = 0.99
#: Hz: the comparison band is at least and at most this. Friction steps at reversals live up there.
LOWEST, HIGHEST = 2.0, 10.0
#: Cutoffs above this share of the sampling rate filter nothing: positions are taken as they are.
OPEN = 0.45
_SEEN = 50.0  # Hz, of the speeds whose spectrum is looked at
_GRID = np.linspace(0.0, _SEEN, 2001)


@dataclass(frozen=True)
class Rests:
    """Joints at rest: friction there is anything between its limits, which no column says.

    Attributes:
        slow: (n,) speeds in rad/s (m/s) below which a joint is at rest; below 0 where it never is.
        weight: (n,) of the equations of a joint at rest beside those of it in motion, in (0, 1].
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
        cutoff_hz: of the zero-phase low-pass that positions and speeds pass; half the rate where
            they pass none.
        comparison_hz: of the low-pass that measured and modelled torque pass before they are
            compared.
        velocity: "measured", or "derived" from positions.
        rests: what counts as rest, and for how much; None where no joint rests.
    """

    rate_hz: float
    cutoff_hz: float
    comparison_hz: float
    velocity: str
    rests: Annotated[Rests | None, OPTIONAL] = None

    def __post_init__(self) -> None:
        derived = self.velocity in ("measured", "derived")
        if not (derived and min(self.rate_hz, self.cutoff_hz, self.comparison_hz) > 0):
            raise ValueError("no run has such a band")

    def filters(self, step: float) -> bool:
        """Whether positions of a log of this step pass a low-pass."""
        return self.cutoff_hz < OPEN / step

    def in_words(self) -> str:
        """Return what every command says in one line."""
        passed = (
            f"positions and speeds below {self.cutoff_hz:.3g} Hz"
            if self.cutoff_hz < OPEN * self.rate_hz
            else "positions and speeds unfiltered"
        )
        return (
            f"{self.rate_hz:.4g} Hz, {passed}, torques compared below {self.comparison_hz:.3g} Hz, "
            f"speeds {self.velocity}"
        )


def comparison_band(logs: Sequence[Samples]) -> float:
    """Return the band in which torques are compared, Hz.

    Twice the lowest frequency below which 99 % of the power of a joint's speed lies, all logs
    together, the largest over the joints, but within 2 to 10 Hz. Speeds are central differences of
    positions below 50 Hz. A piece of a longer log begins and ends in the middle of its motion,
    which would look like a wide spectrum: its speeds fade in and out (Hann's window; Welch 1967).
    """
    found = 0.0
    for j in range(logs[0].q.shape[1]):
        power: FloatArray = np.zeros(len(_GRID))
        for s in logs:
            q = lowpass(s.q[:, j], s.step, _SEEN) if OPEN / s.step > _SEEN else s.q[:, j]
            speed = np.gradient(q, s.step)
            speed = speed - speed.mean()
            if s.piece:
                fade = np.hanning(len(speed))
                speed = (speed - fade @ speed / fade.sum()) * fade / np.sqrt(np.mean(fade**2))
            lines = np.abs(np.fft.rfft(speed)) ** 2 * s.step / len(speed)
            frequency = np.fft.rfftfreq(len(speed), s.step)
            power = power + np.interp(_GRID, frequency, np.cumsum(lines))
        if power[-1] > 0:
            found = max(found, 2 * float(_GRID[np.searchsorted(power, POWER * power[-1])]))
    return min(max(found, LOWEST), HIGHEST)
