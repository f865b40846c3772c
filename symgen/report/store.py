"""Read and write folders of results and their pages."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from symgen.codegen.model import derive
from symgen.codegen.package import generate
from symgen.diagnosis import diagnosis as diagnoses
from symgen.diagnosis.diagnosis import Diagnosis
from symgen.errors import ParameterError, SymgenError
from symgen.experiment import playback
from symgen.experiment import study as studies
from symgen.experiment.plan import Plan
from symgen.experiment.playback import SimulationComparison
from symgen.experiment.study import Study
from symgen.faults.fault import delay_of
from symgen.files import json_text, write_folder
from symgen.identification import curves, prediction
from symgen.identification import estimate as estimates
from symgen.identification import load_result as payloads
from symgen.identification.comparison import Comparison
from symgen.identification.estimate import Estimate
from symgen.identification.export import values_header
from symgen.identification.load_result import Payload
from symgen.identification.parameters import PARAMETERS
from symgen.identification.prediction import Prediction
from symgen.report.content.comparison import comparison_content
from symgen.report.content.diagnosis import diagnosis_content
from symgen.report.content.estimate import estimate_content
from symgen.report.content.model import model_content
from symgen.report.content.parts import Content
from symgen.report.content.payload import payload_content
from symgen.report.content.plan import plan_content
from symgen.report.content.prediction import prediction_content
from symgen.report.content.simulation import simulation_content
from symgen.report.content.study import study_content
from symgen.report.html import page
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import parameters_toml, robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.schemas import as_json

Result: TypeAlias = Estimate | Diagnosis | Prediction | Payload | Study | SimulationComparison
#: Values with a page: results, and values that no folder of results contains.
Value: TypeAlias = Result | Comparison | Plan | Evaluator
_PAGE = "report.html"


class _Kind(NamedTuple):
    """A kind of result: its class, the reader of its folder, and its content for a page."""

    made: type
    read: Callable[[Path], Result]
    say: Callable[..., Content]


#: By the name of the JSON file.
_KINDS = {
    estimates.MARKER: _Kind(Estimate, estimates.read_estimate, estimate_content),
    diagnoses.MARKER: _Kind(Diagnosis, diagnoses.read_diagnosis, diagnosis_content),
    prediction.MARKER: _Kind(Prediction, prediction.read_prediction, prediction_content),
    payloads.MARKER: _Kind(Payload, payloads.read_payload, payload_content),
    studies.MARKER: _Kind(Study, studies.read_study, study_content),
    playback.MARKER: _Kind(SimulationComparison, playback.read_comparison, simulation_content),
}


#: Content of values that no folder of results contains.
_OTHERS: dict[type, Callable[[Any], Content]] = {
    Comparison: comparison_content,
    Plan: plan_content,
    Evaluator: model_content,
}


def _kind(result: Result) -> tuple[str, _Kind]:
    return next((name, kind) for name, kind in _KINDS.items() if isinstance(result, kind.made))


def content(result: Value, *extra: Robot | None) -> Content:
    """Return the content of a result for a page and a terminal.

    Args:
        result: result of identify, diagnose, predict, payload, study, compare, excite or load.
        extra: for an estimate, its robot, which is drawn; for a diagnosis, the models moved by the
            measured torques.
    """
    if isinstance(result, Comparison | Plan | Evaluator):
        return _OTHERS[type(result)](result)
    return _kind(result)[1].say(result, *extra)


def load_result(path: str | Path) -> Result:
    """Read the result of identify, diagnose, predict, payload or study.

    Args:
        path: the folder, or the JSON file in it.

    Raises:
        SymgenError: there is no result, there are two, or it is damaged.
    """
    path = Path(path)
    found = [name for name in _KINDS if (path / name).is_file()]
    if path.is_file():
        found, path = [path.name], path.parent
    if len(found) != 1 or found[0] not in _KINDS:
        what = f"it holds {' and '.join(found)}" if found else "it holds no result"
        if not path.exists():
            what = "it is not there"
        raise ParameterError(
            f"{path}: {what}; accepted: a folder that identify, diagnose, predict, payload "
            f"or study wrote, or the {', '.join(_KINDS)} in it"
        )
    return _KINDS[found[0]].read(path / found[0])


def result_robot(path: Path) -> Robot | None:
    """Return the robot of a folder of results, or None if there is no readable one."""
    file = (path if path.is_dir() else path.parent) / "robot.toml"
    try:
        return read_robot(file)
    except SymgenError:
        return None


def result_page(result: Value, robot: Robot | None = None) -> str:
    """Return the HTML page of a result; with the robot of an estimate, the page draws it."""
    if isinstance(result, Diagnosis):
        note = "The figures are on the page that diagnose wrote: its folder holds no curves."
        result = replace(result, notes=(*result.notes, note))
    return page(content(result, *([robot] if isinstance(result, Estimate) else [])))


def write(
    result: Result,
    folder: str | Path,
    *,
    robot: Robot | None = None,
    more: Mapping[str, bytes] | None = None,
) -> tuple[Path, ...]:
    """Write a result as its command does: JSON, a page that opens offline, and further files.

    Args:
        result: result of identify, diagnose, predict, payload or study.
        folder: a new or empty folder, or a folder written by symgen, which is replaced. On an
            error, no file is written.
        robot: the identified robot, for its drawing and its file in the folder of an estimate.
        more: names and contents of further files.

    Returns:
        The paths of the files.

    Raises:
        PackageError: the folder contains other files, or cannot be written.
    """
    files = result_files(result, robot) | dict(more or {})
    write_folder(Path(folder), files, _kind(result)[0])
    return tuple(Path(folder) / name for name in files)


def result_files(result: Result, robot: Robot | None = None) -> dict[str, bytes]:
    """Return the files of a folder of results.

    Args:
        result: the result.
        robot: the identified robot, for its drawing and its file in the folder of an estimate.

    Returns:
        The JSON and report.html. Also, for an estimate: NAME_values.h, curves.npz with the data of
        the figures, and robot.toml if `robot` is set; for a diagnosis: robot.toml and
        parameters.toml of the extended robot, and its package under generated/; for a
        prediction: prediction.csv; for a payload: curves.npz; for simulated robots: window.csv.
    """
    if isinstance(result, Diagnosis):
        result, files = _diagnosis_files(result)
    else:
        files = {_PAGE: result_page(result, robot).encode()}
    if isinstance(result, Prediction):
        files[prediction.CURVES] = result.to_csv()
    if isinstance(result, SimulationComparison):
        files[playback.WINDOW] = result.to_csv()
    if isinstance(result, Payload):
        files[curves.FILE] = curves.traces_npz(result.traces)
    if isinstance(result, Estimate):
        files[f"{result.robot}_values.h"] = values_header(result).encode()
        files[curves.FILE] = curves.traces_npz(result.traces)
        if robot is not None:
            files["robot.toml"] = robot_toml(robot).encode()
    return {_kind(result)[0]: (json_text(result.to_json()) + "\n").encode(), **files}


def _diagnosis_files(diagnosis: Diagnosis) -> tuple[Diagnosis, dict[str, bytes]]:
    """Return a diagnosis with its file digests, and its other files: page, robot, package."""
    extended = diagnosis.extended
    package = generate(derive(extended, "all")).files
    files = {
        _PAGE: page(content(diagnosis)).encode(),
        "robot.toml": robot_toml(extended).encode(),
        **{f"generated/{path}": data for path, data in package.items()},
    }
    values = {p.name: p.value for p in diagnosis.parameters if math.isfinite(p.value)}
    if values:
        band = None if diagnosis.band is None else as_json(diagnosis.band)
        delays = {fault.channel: delay_of(fault) for fault in diagnosis.repairs if delay_of(fault)}
        files[PARAMETERS] = parameters_toml(values.items(), band, delays).encode()
    # The recipient of the folder can check that its files belong to this diagnosis.
    digests = {path: hashlib.sha256(data).hexdigest() for path, data in sorted(files.items())}
    return replace(diagnosis, digests=digests), files
