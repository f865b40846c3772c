"""The study of perturbed estimates: each has a nearest robot, and no robot is called impossible."""

from __future__ import annotations

import pytest
from studies.possible_study import ROBOTS, estimate_of, study


def require_answers(name: str, count: int) -> None:
    found = study(*estimate_of(name), count)
    assert found["all"] == count
    assert [found[key] for key in ("unanswered", "denied", "disproved")] == [0, 0, 0], found


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_a_hundred_perturbed_estimates_of_each_robot_are_answered(name: str) -> None:
    require_answers(name, 100)
