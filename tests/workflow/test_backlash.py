"""Play in a gear is named with its width, on logs of an arm whose motor and link are two bodies."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.backlash import ROBOT, Gear, recorded
from support import sampled

import symgen


def found(gear: Gear, seed: int) -> symgen.Diagnosis:
    """Diagnose two logs of different motion."""
    logs = []
    for k in (1, 2):
        log = recorded(100 * seed + k, gear)
        logs.append(symgen.make_log(f"log{k}", log["t"], log["q"], log["tau"], log["qd"]))
    return symgen.diagnose(symgen.parse_robot(ROBOT), logs[:1], validation=logs[1:])


@pytest.mark.parametrize(
    ("joint", "degrees", "seed"), sampled([(1, 0.5, 1), (1, 1.0, 2), (1, 2.0, 3), (0, 0.5, 4)], 1)
)
def test_play_is_named_with_its_width(joint: int, degrees: float, seed: int) -> None:
    answer = found(Gear(joint, np.radians(degrees)), seed)
    (effect,) = answer.effects
    assert (effect.name, effect.joints) == ("backlash", (joint + 1,))
    width, _ = effect.parameters
    assert width.value == pytest.approx(np.radians(degrees), rel=0.2)
    assert answer.after.total < 0.5 * answer.before.total


@pytest.mark.parametrize("stiffness", sampled([6e4, 3000.0, 1000.0], 1))
def test_a_gear_without_play_has_none(stiffness: float) -> None:
    names = {e.name for e in found(Gear(1, 0.0, stiffness, 10.0), 5).effects}
    assert names <= {"joint_elasticity"}
    assert names or stiffness > 1000
