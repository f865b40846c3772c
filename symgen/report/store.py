"""What a folder of results holds, and its page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from symgen.diagnosis import fleet
from symgen.diagnosis import reading as diagnosis_reading
from symgen.diagnosis.diagnosis import Diagnosis
from symgen.diagnosis.fleet import Fleet
from symgen.errors import ParameterError, SymgenError
from symgen.experiment import study_result
from symgen.experiment.study_result import Study
from symgen.files import write_folder
from symgen.identification import payload_result, prediction, reading
from symgen.identification.comparison import Comparison
from symgen.identification.estimate import Estimate
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot

Result = Estimate | Diagnosis | prediction.Prediction | payload_result.Payload | Study
_READERS: dict[str, Callable[[Path], Result]] = {
    reading.MARKER: reading.read_estimate,
    diagnosis_reading.MARKER: diagnosis_reading.read_diagnosis,
    prediction.MARKER: prediction.read_prediction,
    payload_result.MARKER: payload_result.read_payload,
    study_result.MARKER: study_result.read_study,
}


def read_result(path: str | Path) -> Result:
    """Read what identify, diagnose, predict, payload or study wrote.

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
            f"{path}: {what}; accepted: a folder that identify, diagnose, predict, payload "
            f"or study wrote, or the {', '.join(_READERS)} in it"
        )
    return _READERS[found[0]](path / found[0])


def result_robot(path: Path) -> Robot | None:
    """Return the robot that stands in a folder of results, None where there is none to be read."""
    file = (path if path.is_dir() else path.parent) / "robot.toml"
    try:
        return read_robot(file)
    except SymgenError:
        return None


def result_page(result: Result | Comparison, robot: Robot | None = None) -> str:
    """Return the HTML page of a result; the robot, where it is known, is drawn."""
    from symgen.report.content.comparison import comparison_page
    from symgen.report.content.diagnosis import diagnosis_page
    from symgen.report.content.estimate import estimate_page
    from symgen.report.content.payload import payload_page
    from symgen.report.content.prediction import prediction_page
    from symgen.report.content.study import study_page

    if isinstance(result, Comparison):
        return comparison_page(result)
    if isinstance(result, Estimate):
        return estimate_page(result, robot)
    if isinstance(result, Diagnosis):
        told = "Figures over time are on the page that diagnose wrote: its folder holds no curves."
        return diagnosis_page(replace(result, notes=(*result.notes, told)))
    if isinstance(result, payload_result.Payload):
        return payload_page(result)
    if isinstance(result, Study):
        return study_page(result)
    return prediction_page(result)


def write(
    result: Result | Fleet,
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
    from symgen.report.content.diagnosis import diagnosis_files
    from symgen.report.content.estimate import estimate_files
    from symgen.report.content.fleet import fleet_files
    from symgen.report.content.payload import payload_files
    from symgen.report.content.study import study_files

    if isinstance(result, Estimate):
        marker, files = reading.MARKER, estimate_files(result, robot)
    elif isinstance(result, Diagnosis):
        marker, files = diagnosis_reading.MARKER, diagnosis_files(result)
    elif isinstance(result, prediction.Prediction):
        marker, files = prediction.MARKER, result.to_files()
    elif isinstance(result, payload_result.Payload):
        marker, files = payload_result.MARKER, payload_files(result)
    elif isinstance(result, Study):
        marker, files = study_result.MARKER, study_files(result)
    else:
        marker, files = fleet.MARKER, fleet_files(result)
    files |= more or {}
    write_folder(Path(folder), files, marker)
    return tuple(Path(folder) / name for name in files)
