"""identify, predict with its estimate, and diagnose given it say one number of one log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import data_folder, sampled

import symgen
from symgen.identification.estimate import Estimate
from symgen.report.store import result_files

ROBOTS = {"emps": ".csv", "ur10": ".csv", "dp_c0": ".npz"}


@pytest.fixture(scope="module", params=sampled(ROBOTS, 1, always=["emps"]))
def found(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Estimate, Path]:
    """The folder of a robot's logs, its default estimate, and the file that identify writes."""
    folder, suffix = data_folder() / request.param, ROBOTS[request.param]
    estimate = symgen.identify(
        folder / "robot.toml", folder / f"train{suffix}", validation=folder / f"test{suffix}"
    )
    into = tmp_path_factory.mktemp(request.param)
    for name, content in result_files(estimate).items():
        (into / name).write_bytes(content)
    return folder, estimate, into / "estimate.json"


def test_the_estimate_says_it_of_its_own_torques(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, _ = found
    said = estimate.torque_validation
    assert said is not None
    assert said.per_joint is not None
    (trace,) = [t for t in estimate.traces if t.quantity == "torque" and t.kind == "validation"]
    left, size = (
        np.linalg.norm(x, axis=0) for x in (trace.measured - trace.predicted, trace.measured)
    )
    print(f"{folder.name}: {said.relative:.4f}, {np.round(said.per_joint, 4)}")
    np.testing.assert_allclose(said.per_joint, left / size, rtol=0, atol=1e-9)
    stacked = np.linalg.norm(left) / np.linalg.norm(size)
    assert said.relative == pytest.approx(stacked, rel=0, abs=1e-9)


def test_predict_says_what_identify_says(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, file = found
    prediction = symgen.predict(folder / "robot.toml", folder / f"test{ROBOTS[folder.name]}", file)
    said = estimate.torque_validation
    assert said is not None
    assert prediction.band == estimate.band
    np.testing.assert_allclose(prediction.error.per_joint, said.per_joint, rtol=0, atol=1e-9)
    assert prediction.error.relative == pytest.approx(said.relative, rel=0, abs=1e-9)


def test_diagnose_says_what_identify_says(found: tuple[Path, Estimate, Path]) -> None:
    folder, estimate, file = found
    suffix = ROBOTS[folder.name]
    diagnosis = symgen.diagnose(
        folder / "robot.toml",
        folder / f"train{suffix}",
        validation=[folder / f"test{suffix}"],
        parameters=file,
        effects=["gravity_spring"],
    )
    said = estimate.torque_validation
    assert said is not None
    assert said.per_joint is not None
    np.testing.assert_allclose(diagnosis.before.per_joint, said.per_joint, rtol=0, atol=1e-9)
    assert diagnosis.before.total == pytest.approx(said.relative, rel=0, abs=1e-9)
