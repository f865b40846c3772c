"""A hypothesis about what is wrong with a run, and its score in a model with other hypotheses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from symgen import names
from symgen.hypotheses.score import Key
from symgen.robot.effect import Definition, numbered
from symgen.robot.types import Robot


class Size(NamedTuple):
    """A constant of a hypothesis; std is NaN if it is unknown."""

    name: str
    value: float
    unit: str
    std: float = math.nan


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What may be wrong: an effect that the model lacks, a change of all logs, or a contact.

    Attributes:
        definition: its row of the library or of the robot file.
        joints: positions of its joints; empty for all.
        measured: whether no other motion can contradict it, because the logs show it separately.
    """

    definition: Definition
    joints: tuple[int, ...]
    measured: bool = field(default=False, kw_only=True)

    @property
    def name(self) -> str:
        """Its name in the library or in the robot file."""
        return self.definition.name

    @property
    def key(self) -> Key:
        """Name and joints, without the size."""
        return self.name, self.joints

    @property
    def sizes(self) -> Sequence[Size]:
        """Its constants."""
        return ()

    @property
    def extent(self) -> str:
        """Its size as a text, such as ", DT = 0.012 s"."""
        texts = [f", {s.name} = {s.value:.3g} {s.unit}" for s in self.sizes]
        return "".join(text.rstrip() for text in texts)

    def place(self, robot: Robot) -> tuple[int | str, int]:
        """Return the joint number in its names, "" without joints, and sigma of its first joint."""
        if not self.joints:
            return "", names.REVOLUTE
        first, last = self.joints[0], self.joints[-1]
        return robot.numbers[last], robot.sigma[first]

    def expression(self, robot: Robot) -> str:
        """Return its torque, or what it does to the logs."""
        d = self.definition
        return numbered(d, self.place(robot)[0]) or d.formula or d.says

    def presumes(self, other: Hypothesis) -> bool:
        """Whether it requires another one, for example Coulomb friction on the same joint."""
        word = self.definition.presumes
        native = bool(word) and word == other.definition.native
        return native and self.joints == other.joints

    def in_words(self, robot: Robot) -> str:
        """Return its name, its joints and its size."""
        every = f"the whole {'robot' if robot.floating else 'arm'}"
        labels = robot.listed(self.joints) if self.joints else every
        return f"{self.name.replace('_', ' ')} on {labels}{self.extent}"


@dataclass(frozen=True, eq=False)
class Judged:
    """A hypothesis and its score.

    Attributes:
        cause: the hypothesis.
        odds: log-odds that it is present, marginalised over its grid.
        worth: square root of the reduction of the squared error, as a part of a joint's torque.
        gain: share of the held-out sum of squares of its joints that it explains.
        torque: RMS of its torque on its joints, N m or N; NaN if it has none.
        alike: alternatives with almost the same torque, each with a probability.
    """

    cause: Hypothesis
    odds: float = 0.0
    worth: float = 0.0
    gain: float = 0.0
    torque: float = math.nan
    alike: tuple[Judged, ...] = ()

    @property
    def probability(self) -> float:
        """Probability that it is present."""
        from scipy.special import expit

        return float(expit(self.odds))

    @property
    def definition(self) -> Definition:
        """Its row of the library, or of the robot file."""
        return self.cause.definition

    @property
    def joints(self) -> tuple[int, ...]:
        """Positions of its joints; empty for all."""
        return self.cause.joints

    @property
    def key(self) -> Key:
        """Name and joints, without the size."""
        return self.cause.key
