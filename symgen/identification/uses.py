"""The uses of an estimate: prediction, parameters and simulation, with reasons as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from symgen import policy
from symgen.estimation.playback import Horizon, require_same_times
from symgen.estimation.torque_error import percent
from symgen.estimation.values import Reason

#: Relative standard deviation up to which a parameter is known, in percent.
KNOWN = 100 * policy.KNOWN


def joined(reasons: Sequence[Reason]) -> str:
    """Return the texts of reasons in one line."""
    return "; ".join(reason.text for reason in reasons)


@dataclass(frozen=True)
class Use:
    """Whether an estimate is good for one use.

    Attributes:
        ok: whether there are no reasons against the use.
        reasons: reasons against the use.
    """

    name: ClassVar[str]

    ok: bool = field(init=False)
    reasons: tuple[Reason, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ok", not self.reasons)


@dataclass(frozen=True)
class PredictionUse(Use):
    """Whether an estimate predicts torque.

    Attributes:
        grade: grade of the torque error on held-out motion: "good", "usable" or "poor".
        large: driven joints with a large torque error on held-out motion, the largest first.
    """

    name: ClassVar[str] = "prediction"

    grade: str = "poor"
    large: tuple[Reason, ...] = ()

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        text = f"{self.grade.capitalize()} for torque prediction"
        if not self.ok:
            text = f"Not good for torque prediction: {joined(self.reasons)}"
        large = f" Large errors: {joined(self.large)}." if self.large else ""
        return f"{text}.{large}"


@dataclass(frozen=True)
class ParametersUse(Use):
    """Whether single parameters can be read.

    Attributes:
        known: names of the parameters with a relative standard deviation of at most KNOWN.
        count: number of all parameters.
    """

    name: ClassVar[str] = "parameters"

    known: tuple[str, ...] = ()
    count: int = 0

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        text = f"Parameters: {len(self.known)} of {self.count} are known to {KNOWN:g} %"
        others = [reason for reason in self.reasons if reason.kind not in ("weak", "at_bound")]
        return f"{text}; {joined(others)}." if others else f"{text}."


@dataclass(frozen=True)
class SimulationUse(Use):
    """Whether the model can be simulated.

    Attributes:
        horizons: position errors on held-out motion after some times.
        before: the same with the values of the robot file; empty if it has none.
        windows: number of simulated windows of held-out motion.
        diverged: number of windows in which the simulation diverges.
    """

    name: ClassVar[str] = "simulation"

    horizons: tuple[Horizon, ...] = ()
    before: tuple[Horizon, ...] = ()
    windows: int = 0
    diverged: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.before:
            require_same_times(self.horizons, self.before)

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        if not self.ok:
            return f"Not good for simulation: {joined(self.reasons)}."
        text = "Good for simulation"
        for last in self.horizons[-1:]:
            text += f": position error after {last.seconds:g} s "
            text += f"{percent(last.position_error)} of the distance moved"
        if self.before:
            text += f" ({percent(self.before[-1].position_error)} with the values of the file)"
        if self.diverged:
            text += f", {self.diverged} of {self.windows} windows diverge"
        return f"{text}."


class Uses(NamedTuple):
    """The three uses of an estimate."""

    prediction: PredictionUse
    parameters: ParametersUse
    simulation: SimulationUse

    def __repr__(self) -> str:
        """Return a line for each use."""
        return "\n".join(self.sentences)

    @property
    def sentences(self) -> tuple[str, ...]:
        """One sentence for each use."""
        return self.prediction.sentence, self.parameters.sentence, self.simulation.sentence
