"""The demonstration of `symgen demo`: a 7-axis arm with a spring that its robot file does not
declare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from symgen.diagnosis.messages import on_joints
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
HIDDEN, JOINT, STIFFNESS = "gravity_spring", 2, 60.0  # N m/rad
SPRING = f'\n[[effect]]\nname = "{HIDDEN}"\njoints = [{JOINT}]\n'
#: For each link: mass in kg, centre of mass in its frame in m, radius of an equivalent ball in m.
#: For each joint: rotor inertia in kg m2, Coulomb friction in N m, viscous friction in N m s/rad.
_LINKS = (
    (4.0, (0.00, -0.03, -0.10), 0.08, (0.90, 4.0, 3.0)),
    (4.2, (0.00, -0.10, 0.03), 0.08, (1.00, 4.5, 3.5)),
    (3.2, (0.04, 0.03, -0.08), 0.07, (0.70, 3.0, 2.5)),
    (3.0, (-0.04, 0.07, 0.02), 0.07, (0.70, 3.5, 2.5)),
    (2.8, (0.00, 0.05, -0.14), 0.07, (0.30, 1.8, 1.2)),
    (1.6, (0.05, -0.01, 0.00), 0.06, (0.25, 1.5, 1.0)),
    (0.9, (0.01, 0.01, 0.08), 0.05, (0.20, 1.2, 0.8)),
)
_RATE, _DURATION, _ENCODER, _TORQUE_NOISE = 250.0, 15.0, 2e-5, 0.3
#: Of an integration step. The motion is then exact to 1 % of an encoder step.


def true_parameters() -> dict[str, float]:
    """Return the standard parameters of the simulated arm, and the stiffness of its spring."""
    found = {f"K{JOINT}": STIFFNESS}
    for j, (mass, at, radius, drive) in enumerate(_LINKS, start=1):
        c = np.array(at)
        size = 0.4 * radius**2 + c @ c
        about = mass * (size * np.eye(3) - np.outer(c, c))
        inertia = zip(("XX", "XY", "XZ", "YY", "YZ", "ZZ"), about[np.triu_indices(3)], strict=True)
        moments = zip(("MX", "MY", "MZ"), mass * c, strict=True)
        drives = zip(("IA", "FS", "FV"), drive, strict=True)
        named = (*inertia, *moments, *drives, ("M", mass))
        found |= {f"{key}{j}": float(x) for key, x in named}
    return found


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

    def lines(self) -> Iterator[str]:
        """Yield the lines for the terminal, step by step."""
        before, after = self.why.estimates
        logs = "train.csv --validation test.csv"
        yield f"A simulated 7-axis arm has a spring of {STIFFNESS:g} N m/rad on joint {JOINT}."
        yield "robot.toml does not declare it."
        yield f"1. symgen identify robot.toml {logs} --into identified"
        yield f"   {_said(before)}"
        yield f"2. symgen diagnose robot.toml {logs} --into diagnosis"
        for effect in self.why.effects:
            found = ", ".join(
                f"{p.name} = {number(p.value, 3)} {p.unit} (standard deviation {number(p.std, 2)})"
                for p in effect.parameters
                if np.isfinite(p.std)
            )
            yield f"   {effect.name} on {on_joints(effect.joints, self.why.extended)}: {found}"
        yield f"3. symgen identify diagnosis/robot.toml {logs} --into better"
        yield f"   {_said(after)}"
        yield "4. symgen generate diagnosis/robot.toml --into diagnosis/generated"


def _said(estimate: Estimate) -> str:
    return f"{estimate.verdict}: {percent(_error(estimate))} torque error on test.csv"


def _error(estimate: Estimate) -> float:
    error = estimate.moving or estimate.torque_validation
    assert error is not None
    return error.relative


def demonstrate(told: Callable[[str], None]) -> Demonstration:
    """Simulate the arm with its spring; diagnose it without the spring.

    The diagnosis identifies the arm before and after.

    Args:
        told: called with a text about the current step.
    """
    import symgen
    from symgen.identification.parameters import base_values

    known, arm = symgen.parse_robot(FILE), symgen.parse_robot(FILE + SPRING)
    told("simulating two logs of the arm")
    X = base_values(true_parameters(), symgen.derive(arm), "demo")
    seen = symgen.Instruments(encoder_step=_ENCODER, torque_noise=_TORQUE_NOISE)
    train, test = (
        symgen.simulate(
            arm,
            X,
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
