"""What is said of results, once: pages and terminals show the same content."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from symgen.diagnosis.diagnosis import Diagnosis
    from symgen.diagnosis.fleet import Fleet
    from symgen.diagnosis.replay import Replay
    from symgen.experiment.study_result import Study
    from symgen.identification.comparison import Comparison
    from symgen.identification.estimate import Estimate
    from symgen.identification.payload_result import Payload
    from symgen.identification.prediction import Prediction
    from symgen.report.content.parts import Content
    from symgen.robot.types import Robot

    Result: TypeAlias = Estimate | Diagnosis | Prediction | Payload | Study | Fleet
    Shown: TypeAlias = Result | Comparison


def content(result: Shown, robot: Robot | None = None, motion: Replay | None = None) -> Content:
    """Return what is said of a result.

    Args:
        result: of identify, diagnose, predict, payload, study, fleet or compare.
        robot: what was identified, where it is known: its drawing.
        motion: of a diagnosis, the models moved by the measured torques.
    """
    from symgen.diagnosis.diagnosis import Diagnosis
    from symgen.diagnosis.fleet import Fleet
    from symgen.experiment.study_result import Study
    from symgen.identification.comparison import Comparison
    from symgen.identification.estimate import Estimate
    from symgen.identification.payload_result import Payload
    from symgen.report.content.comparison import comparison_content
    from symgen.report.content.diagnosis import diagnosis_content
    from symgen.report.content.estimate import estimate_content
    from symgen.report.content.fleet import fleet_content
    from symgen.report.content.payload import payload_content
    from symgen.report.content.prediction import prediction_content
    from symgen.report.content.study import study_content

    match result:
        case Estimate():
            return estimate_content(result, robot)
        case Diagnosis():
            return diagnosis_content(result, motion)
        case Payload():
            return payload_content(result)
        case Study():
            return study_content(result)
        case Fleet():
            return fleet_content(result)
        case Comparison():
            return comparison_content(result)
        case _:
            return prediction_content(result)
