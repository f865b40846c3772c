"""A collision is left out of the fit, named with its time, and nothing else is blamed for it.

The logs are those of simulators that share no code with the package; the collision is added here.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")

from oracles.hidden.cases import Case, Spec, write

from symgen.diagnosis.diagnosis import Diagnosis
from symgen.diagnosis.workflow import diagnose

BEGIN, LENGTH = 4.0, 0.4
NEAR = 0.25  # s, half a period of the lowest band in which torques are compared


def _hit(log: dict[str, np.ndarray], size: float) -> None:
    """Push on all joints with half a sine, of `size` times the RMS of each torque."""
    u = np.clip((log["t"] - log["t"][0] - BEGIN) / LENGTH, 0, 1)
    rms = np.sqrt(np.mean(log["tau"] ** 2, axis=0))
    log["tau"] = log["tau"] + size * np.sin(np.pi * u)[:, None] * rms


def _diagnosed(case: Case, folder: Path) -> Diagnosis:
    write(case, folder)
    return diagnose(
        folder / "robot.toml", folder / "train.csv", validation=[folder / "validation.csv"]
    )


def _spans(found: Diagnosis) -> list[tuple[float, float]]:
    [effect] = [e for e in found.effects if e.name == "external_contact"]
    assert effect.expression.endswith("in train.csv, validation.csv")
    begin, length = ([p.value for p in effect.parameters][k::2] for k in (0, 1))
    return [(a, a + b) for a, b in zip(begin, length, strict=True)]


def test_collisions_are_named_and_left_out_beside_a_missing_effect(tmp_path: Path) -> None:
    case = Spec("planar2r", "coulomb_friction", "moderate", 7).run()
    clean = _diagnosed(case, tmp_path / "clean")
    for log in (case.train, case.validation):
        _hit(log, 1.0)
    found = _diagnosed(case, tmp_path / "hit")
    others = [(e.name, e.joints) for e in found.effects if e.name != "external_contact"]
    assert others == [(e.name, e.joints) for e in clean.effects]
    for log, (begin, end) in zip((case.train, case.validation), _spans(found), strict=True):
        start = float(log["t"][0]) + BEGIN
        assert start - NEAR < begin < start + LENGTH / 2 < end < start + LENGTH + NEAR
    assert found.verdict == "explained"
    # What is left is that of the logs without a collision: neither fit nor gap contains it.
    assert found.before.total > 1.1 * clean.before.total
    assert found.after.total < 1.3 * clean.after.total
    for own, other in zip(found.parameters, clean.parameters, strict=True):
        assert abs(own.value - other.value) < other.std
