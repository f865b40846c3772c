"""Public verbs answer as they are kept to: `behaviour.json.gz`, see tests/behaviour.py."""

from __future__ import annotations

import json

import behaviour
import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")

#: Cases that take a second or two, and whose numbers do not hang on the rounding of a simulation:
#: where a joint rests, it decides the sign of its friction. Each default run draws the same few.
_QUICK = ("drive", "fault-clipped", "fault-held", "fault-speeds_scaled", "fleet", "refused",
          "static", "study", "words")  # fmt: skip
_DRAWN = sorted(np.random.default_rng(23).choice(_QUICK, 5, replace=False))


def _compare(name: str) -> None:
    now = json.loads(json.dumps(behaviour.answers(name)))
    assert behaviour.differences(behaviour.kept()[name], now) == []


@pytest.mark.parametrize("name", _DRAWN)
def test_a_verb_answers_as_before(name: str) -> None:
    _compare(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(behaviour.CASES) - set(_DRAWN)))
def test_every_verb_answers_as_before(name: str) -> None:
    _compare(name)


def test_a_changed_answer_is_seen() -> None:
    was = {"fit/estimate.json": {"/parameters/0/value": 1.0, "/verdict": "trusted"}}
    now = {"fit/estimate.json": {"/parameters/0/value": 1.00001, "/verdict": "doubtful"}}
    assert len(behaviour.differences(was, now)) == 2
    assert behaviour.differences(was, was) == []
