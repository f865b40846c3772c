"""What a user asks of `identify` beside model and method: what else the solution is drawn from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from symgen.errors import IdentificationError
from symgen.estimation.logs import Source

#: Methods for which logs can be given weights.
WEIGHED = ("wls", "ols")


@dataclass(frozen=True)
class Fit:
    """How equations are solved.

    Attributes:
        prior: estimate.json, TOML with [parameters], or the .urdf that the robot was imported from:
            pulls methods wls and consistent towards its values (see `read_prior`).
        weights: one a log, of its squared residuals; None: all alike. For wls and ols.
        commanded: the commanded motion of each log, in their order, for the instruments of method
            iv; by default they come from the encoders, where speeds were measured too.
        forgetting: weight of the past for each new sample, of method recursive, in (0, 1]: some
            1 / (1 - forgetting) samples are remembered, whatever the model and the window.
    """

    prior: str | Path | None = None
    weights: Sequence[float] | None = None
    commanded: Sequence[Source] | Source = ()
    forgetting: float = 1.0

    def shares(self, logs: int, method: str) -> Sequence[float]:
        """Return one weight a log.

        Raises:
            IdentificationError: the method weighs no logs, or these are no weights of them.
        """
        weights = self.weights
        if weights is None:
            return [1.0] * logs
        if method not in WEIGHED:
            raise IdentificationError(
                f"weights with method {method}; accepted: {', '.join(WEIGHED)}"
            )
        if len(weights) != logs or not all(0 < w < math.inf for w in weights):
            shown = ", ".join(f"{w:g}" for w in weights)
            raise IdentificationError(
                f"weights {shown}; accepted: a number above 0 for each of {logs} logs"
            )
        return weights
