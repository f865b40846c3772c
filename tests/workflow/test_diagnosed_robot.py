"""The robot that diagnose writes is one that other commands take, with the same numbers."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from stored_logs import made, stored

import symgen

CASE = "load_friction"


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> tuple[symgen.Diagnosis, Path, symgen.Log]:
    """The diagnosis of an arm whose friction grows with its load, its folder, and another log."""
    case = stored(CASE)
    train, test = made("train", case.train), made("test", case.test)
    found = symgen.diagnose(
        case.robot, [train], validation=[test], effects=["load_dependent_friction"]
    )
    into = tmp_path_factory.mktemp("diagnosed") / "diagnosed"
    symgen.write(found, into)
    return found, into, test


def test_predict_takes_its_folder_and_says_the_same_number(written) -> None:
    found, folder, test = written
    assert symgen.read_robot(folder / "robot.toml").loaded
    for parameters in (folder, folder / "parameters.toml"):
        prediction = symgen.predict(folder / "robot.toml", test, parameters)
        np.testing.assert_allclose(prediction.error.per_joint, found.after.per_joint, rtol=1e-9)
        assert prediction.error.relative == pytest.approx(found.after.total, rel=1e-9)
        assert prediction.moving.relative <= prediction.error.relative
        assert prediction.noise.relative <= prediction.moving.relative


@pytest.mark.parametrize("place", [0, 1], ids=["before", "after"])
def test_its_estimates_are_those_of_identify(written, place) -> None:
    found, _, _ = written
    case = stored(CASE)
    robot = (case.robot, found.extended)[place]
    train, test = made("train", case.train), made("test", case.test)
    again = symgen.identify(robot, [train], validation=[test])
    assert again.to_json() == found.estimates[place].to_json()


def test_its_parameters_carry_the_band(written) -> None:
    found, folder, test = written
    band = tomllib.loads((folder / "parameters.toml").read_text())["band"]
    assert band["cutoff_hz"] == found.band.cutoff_hz
    assert band["comparison_hz"] == found.band.comparison_hz
    assert symgen.predict(folder / "robot.toml", test, folder).band == found.band
    text = (folder / "parameters.toml").read_text()
    (folder.parent / "bad.toml").write_text(text.replace("rate_hz = ", "rate_hz = -"))
    with pytest.raises(symgen.ParameterError, match=r"bad.toml: damaged"):
        symgen.predict(folder / "robot.toml", test, folder.parent / "bad.toml")


def test_diagnose_takes_it_as_the_state_before(written) -> None:
    found, folder, test = written
    again = symgen.diagnose(
        folder / "robot.toml", [test], parameters=folder, effects=["gravity_spring"]
    )
    assert again.cutoff_hz == found.cutoff_hz
    assert again.verdict == "consistent"
