"""What a folder of results holds, and its page."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from symgen.codegen.model import derive
from symgen.codegen.package import generate
from symgen.diagnosis import diagnosis as diagnoses
from symgen.diagnosis import fleet as fleets
from symgen.diagnosis.diagnosis import Diagnosis
from symgen.diagnosis.fleet import Fleet
from symgen.diagnosis.replay import replayed
from symgen.errors import ParameterError, SymgenError
from symgen.experiment import study_result
from symgen.experiment.study_result import Study
from symgen.files import json_text, write_folder
from symgen.identification import curves, payload_result, prediction
from symgen.identification import estimate as estimates
from symgen.identification.estimate import Estimate
from symgen.identification.export import values_header
from symgen.report.content import content
from symgen.report.html import page
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import parameters_toml, robot_toml
from symgen.robot.types import Robot

if TYPE_CHECKING:
    from symgen.report.content import Result, Shown

_PAGE = "report.html"
_READERS: dict[str, Callable[[Path], Result]] = {
    estimates.MARKER: estimates.read_estimate,
    diagnoses.MARKER: diagnoses.read_diagnosis,
    prediction.MARKER: prediction.read_prediction,
    payload_result.MARKER: payload_result.read_payload,
    study_result.MARKER: study_result.read_study,
    fleets.MARKER: fleets.read_fleet,
}

_MARKERS: dict[type, str] = {
    Estimate: estimates.MARKER,
    Diagnosis: diagnoses.MARKER,
    prediction.Prediction: prediction.MARKER,
    payload_result.Payload: payload_result.MARKER,
    Study: study_result.MARKER,
    Fleet: fleets.MARKER,
}


def read_result(path: str | Path) -> Result:
    """Read what identify, diagnose, predict, payload, study or fleet wrote.

    Args:
        path: the folder, or the JSON file in it.

    Raises:
        SymgenError: there is no result, there are two, or it is damaged.
    """
    path = Path(path)
    found = [name for name in _READERS if (path / name).is_file()]
    if path.is_file():
        found, path = [path.name], path.parent
    if len(found) != 1 or found[0] not in _READERS:
        what = f"it holds {' and '.join(found)}" if found else "it holds no result"
        if not path.exists():
            what = "it is not there"
        raise ParameterError(
            f"{path}: {what}; accepted: a folder that identify, diagnose, predict, payload, "
            f"study or fleet wrote, or the {', '.join(_READERS)} in it"
        )
    return _READERS[found[0]](path / found[0])


def result_robot(path: Path) -> Robot | None:
    """Return the robot that stands in a folder of results, None where there is none to be read."""
    file = (path if path.is_dir() else path.parent) / "robot.toml"
    try:
        return read_robot(file)
    except SymgenError:
        return None


def result_page(result: Shown, robot: Robot | None = None) -> str:
    """Return the HTML page of a result; the robot, where it is known, is drawn."""
    if isinstance(result, Diagnosis):
        told = "Figures over time are on the page that diagnose wrote: its folder holds no curves."
        result = replace(result, notes=(*result.notes, told))
    return page(content(result, robot))


def write(
    result: Result,
    folder: str | Path,
    *,
    robot: Robot | None = None,
    more: Mapping[str, bytes] | None = None,
) -> tuple[Path, ...]:
    """Write a result as its command does: JSON, a page that opens offline, and what goes with them.

    Args:
        result: of identify, diagnose, predict, payload, study or fleet.
        folder: a new or empty folder, or one that symgen wrote, which is replaced; whole or not at
            all.
        robot: what was identified, for its drawing and its file beside an estimate.
        more: names and contents of further files.

    Returns:
        The paths of the files.

    Raises:
        PackageError: the folder holds something else, or cannot be written.
    """
    files = result_files(result, robot) | dict(more or {})
    write_folder(Path(folder), files, _MARKERS[type(result)])
    return tuple(Path(folder) / name for name in files)


def result_files(result: Result, robot: Robot | None = None) -> dict[str, bytes]:
    """Return the files of a folder of results.

    Args:
        result: what was found.
        robot: what was identified, for its drawing and its file beside an estimate.

    Returns:
        The JSON and report.html; of an estimate NAME_values.h, curves.npz, from which figures are
        drawn, and robot.toml where the robot is given; of a diagnosis robot.toml and
        parameters.toml of the extended robot, and its package under generated/; of a prediction
        its CSV and no page.
    """
    if isinstance(result, prediction.Prediction):
        return result.to_files()
    if isinstance(result, Diagnosis):
        return _diagnosis_files(result)
    files = {_MARKERS[type(result)]: (_text(result) + "\n").encode()}
    if isinstance(result, Estimate):
        files[f"{result.robot}_values.h"] = values_header(result).encode()
    files[_PAGE] = page(content(result, robot)).encode()
    if isinstance(result, Estimate):
        files[curves.FILE] = curves.curves_npz(
            {"traces": result.traces, "balances": result.balances}, result.convergence
        )
        if robot is not None:
            files["robot.toml"] = robot_toml(robot).encode()
    return files


def _text(result: Estimate | payload_result.Payload | Study | Fleet) -> str:
    """The JSON of a result; an estimate, whose matrix of correlations is large, has rows of it."""
    if isinstance(result, Estimate):
        return json_text(result.to_json())
    return json.dumps(result.to_json(), indent=1)


def _diagnosis_files(diagnosis: Diagnosis) -> dict[str, bytes]:
    """Return the files of a diagnosis, with robot and package of the extended model."""
    model = derive(diagnosis.extended, "all")
    tree = generate(model)
    motion = None
    try:
        motion = replayed(diagnosis, model)
    except SymgenError as error:
        note = f"no motion under the measured torques: {error}"
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, note))
    files = {
        _PAGE: page(content(diagnosis, motion=motion)).encode(),
        "robot.toml": robot_toml(diagnosis.extended).encode(),
        **{f"generated/{path}": data for path, data in tree.files.items()},
    }
    values = {p.name: p.value for p in diagnosis.parameters if math.isfinite(p.value)}
    if values:
        files["parameters.toml"] = parameters_toml(values.items()).encode()
    # Who gets the folder can check that its files are those of this diagnosis.
    digests = {path: hashlib.sha256(data).hexdigest() for path, data in sorted(files.items())}
    moved = None if motion is None else motion.to_json()
    summary = replace(diagnosis, replay=moved, digests=digests).to_json()
    files[diagnoses.MARKER] = (json.dumps(summary, indent=1, allow_nan=False) + "\n").encode()
    return files
