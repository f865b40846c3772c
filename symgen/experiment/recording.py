"""How the logs of a simulated robot come about: what moves it, and what is seen of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError
from symgen.experiment.controller import Controller
from symgen.experiment.instruments import Instruments

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """How the logs of a simulated robot come about.

    Attributes:
        instruments: what the logs show.
        controller: that moves the robot along its reference; not used where torques are played.
        disturbance: standard deviation of torques that act on the joints and that no log shows, new
            at every stamp; one number, or one for each joint, N m or N.
        rate: stamps of the logs per second; None for those of the trajectory or of the torques,
            and 1000 for the Fourier series and the paper's motion.
        clip: whether torques are kept within [limits], instead of being refused beyond them.

    Raises:
        ParameterError: a number has no meaning.
    """

    instruments: Instruments = field(default_factory=Instruments)
    controller: Controller = field(default_factory=Controller)
    disturbance: float | tuple[float, ...] = 0.0
    rate: float | None = None
    clip: bool = False

    def __post_init__(self) -> None:
        if self.rate is not None and not (math.isfinite(self.rate) and self.rate > 0):
            raise ParameterError(f"simulate: rate is {self.rate:g}; accepted: above 0 Hz")

    def unseen(self, n: int) -> FloatArray:
        """Return the disturbance of each of n joints, (n,).

        Raises:
            ParameterError: another number of joints, or no standard deviations.
        """
        out = np.asarray(self.disturbance, dtype=np.float64)
        if out.shape not in ((), (n,)) or not np.isfinite(out).all() or out.min() < 0:
            raise ParameterError(
                f"simulate: disturbance {self.disturbance}; accepted: one or {n} numbers from 0 on"
            )
        return np.broadcast_to(out, (n,))

    @property
    def moves_alike(self) -> bool:
        """Whether runs differ in what is measured alone."""
        return not np.any(self.disturbance) and self.controller.feedback == "true"
