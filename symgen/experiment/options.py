"""What a user asks of `excite`: what the runs look like, and how long they are searched."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from symgen.errors import ParameterError
from symgen.experiment.criterion import CRITERIA

_MOST = 10_000


@dataclass(frozen=True)
class Motion:
    """What the runs of an excitation look like.

    Attributes:
        duration: of each run, s, one or one for each; None for 10 s, or what identify trusts in
            all.
        runs: how many, each with coefficients of its own.
        kind: "fourier", "bspline", or the paper's "cubic" and "cosine"; one for all joints or one
            for each.
        terms: harmonics, coefficients (bspline) or strokes (cubic) of a joint; None for what the
            duration suggests.
        start: where every run begins, (n,), rad or m; None for anywhere.
        rate: of the sampled references, Hz.

    Raises:
        ParameterError: a number has no meaning.
    """

    duration: float | Sequence[float] | None = None
    runs: int = 1
    kind: str | Sequence[str] = "fourier"
    terms: int | None = None
    start: Sequence[float] | None = None
    rate: float = 200.0

    def __post_init__(self) -> None:
        _require_count("runs", self.runs)
        require_positive("rate", self.rate)


@dataclass(frozen=True)
class Search:
    """How runs are searched for.

    Attributes:
        criterion: "condition" number, or "logdet" of the information matrix.
        budget: of time, s: the search stops then with the best that it has.
        searches: how many random starts are improved.
        iterations: of IPOPT for each, at most.
        seed: of the random starts. The same seed gives the same runs where the budget lasts.

    Raises:
        ParameterError: a number has no meaning.
    """

    criterion: str = "condition"
    budget: float = 60.0
    searches: int = 4
    iterations: int = 500
    seed: int = 0

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise ParameterError(f"criterion {self.criterion!r}; accepted: {', '.join(CRITERIA)}")
        require_positive("budget", self.budget)
        _require_count("searches", self.searches)
        _require_count("iterations", self.iterations)


def require_positive(what: str, value: float) -> None:
    """Raise ParameterError where a number is not above 0, or not finite."""
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f"{what} {value:g}; accepted: a number above 0")


def _require_count(what: str, count: int) -> None:
    if not 1 <= count <= _MOST:
        raise ParameterError(f"{what} {count}; accepted: 1 to {_MOST}")
