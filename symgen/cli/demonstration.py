"""The demonstration of `symgen demo`: a 7-axis arm with a spring that its robot file does not
declare.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from symgen.diagnosis.messages import on_joints
from symgen.files import rendered
from symgen.report.content.parts import number, percent
from symgen.robot.builtin import library_text

if TYPE_CHECKING:
    from symgen.diagnosis.diagnosis import Diagnosis
    from symgen.experiment.simulate import Simulation
    from symgen.identification.estimate import Estimate
    from symgen.robot.types import Robot

LOGS = ("train.csv", "test.csv")
#: The content of the robot file: the joints of the Panda, with their limits of position and speed.
FILE = f"""{library_text("panda")}
[limits]
position = [[-2.7, 2.7], [-1.6, 1.6], [-2.7, 2.7], [-2.9, -0.2], [-2.7, 2.7], [0.1, 3.6], [-2.7, 2.7]]
velocity = [1.8, 1.8, 1.8, 1.8, 2.2, 2.2, 2.2]
"""  # noqa: E501
#: The spring that the robot file does not declare.
SPRING = '\n[[effect]]\nname = "gravity_spring"\njoints = [2]\n'
#: The true parameters of the simulated arm, with the stiffness of its spring.
PARAMETERS = Path(__file__).with_suffix(".toml")
_RATE, _DURATION, _ENCODER, _TORQUE_NOISE = 250.0, 15.0, 2e-5, 0.3


@dataclass(frozen=True, eq=False)
class Demonstration:
    """A robot file, two logs, and the results of symgen.

    Attributes:
        logs: training and validation log, with different motions.
        why: the diagnosis, with the estimates before and after it.
    """

    logs: tuple[Simulation, Simulation]
    why: Diagnosis

    def files(self) -> dict[str, bytes]:
        """Return the robot file, the logs and the folders of results."""
        from symgen import parse_robot
        from symgen.report.store import Result, result_files

        before, after = self.why.estimates
        results: dict[str, tuple[Result, Robot | None]] = {
            "identified": (before, parse_robot(FILE)),
            "diagnosis": (self.why, None),
            "better": (after, self.why.extended),
        }
        inside = {
            f"{folder}/{name}": content
            for folder, (result, robot) in results.items()
            for name, content in result_files(result, robot).items()
        }
        logs = zip(LOGS, self.logs, strict=True)
        return {
            "robot.toml": FILE.encode(),
            **{name: log.file() for name, log in logs},
            **inside,
        }

    def text(self) -> str:
        """Return the lines for the terminal, step by step."""
        before, after = map(_said, self.why.estimates)
        effects = []
        for effect in self.why.effects:
            known = [p for p in effect.parameters if np.isfinite(p.std)]
            place = on_joints(effect.joints, self.why.extended)
            effects.append((effect.name, place, known))
        logs = "train.csv --validation test.csv"
        return rendered(
            "text/demo.txt", logs=logs, before=before, after=after, effects=effects, number=number
        )


def _said(estimate: Estimate) -> str:
    """Return verdict and torque error on held-out motion."""
    error = estimate.moving or estimate.torque_validation
    assert error is not None
    return f"{estimate.verdict}: {percent(error.relative)}"


def demonstrate(told: Callable[[str], None]) -> Demonstration:
    """Simulate the arm with its spring; diagnose it without the spring.

    The diagnosis identifies the arm before and after.

    Args:
        told: called with a text about the current step.
    """
    import symgen

    known, arm = symgen.parse_robot(FILE), symgen.parse_robot(FILE + SPRING)
    told("simulating two logs of the arm")
    seen = symgen.Instruments(encoder_step=_ENCODER, torque_noise=_TORQUE_NOISE)
    train, test = (
        symgen.simulate(
            arm,
            PARAMETERS,
            duration=_DURATION,
            seed=seed,
            recording=symgen.Recording(seen, rate=_RATE),
        )
        for seed in (1, 2)
    )
    logs, held = (
        [replace(run.log(), name=name)] for run, name in zip((train, test), LOGS, strict=True)
    )
    told("identifying the arm, and diagnosing what robot.toml does not declare")
    why = symgen.diagnose(known, logs, validation=held)
    told("finishing: the pages, and the code of the arm with what was found")
    return Demonstration((train, test), why)
