"""symgen: dynamic models of robots in closed form, and their parameters from measured logs.

    robot = symgen.read_robot("planar2r")
    model = symgen.derive(robot)
    evaluator = symgen.load(model)
    estimate = symgen.identify(evaluator, ["train.csv"], validation=["test.csv"])

Names are imported when they are first used, so that `import symgen` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from symgen.codegen.model import Model as Model
    from symgen.codegen.model import derive as derive
    from symgen.codegen.package import generate as generate
    from symgen.codegen.package import write_package as write_package
    from symgen.data.log import Log as Log
    from symgen.data.log import make_log as make_log
    from symgen.data.log import read_log as read_log
    from symgen.data.raw import Reading as Reading
    from symgen.data.signals import prepare as prepare
    from symgen.diagnosis.diagnosis import Diagnosis as Diagnosis
    from symgen.diagnosis.fleet import fleet as fleet
    from symgen.diagnosis.workflow import diagnose as diagnose
    from symgen.errors import (
        BuildError as BuildError,
    )
    from symgen.errors import (
        ExpressionError as ExpressionError,
    )
    from symgen.errors import (
        IdentificationError as IdentificationError,
    )
    from symgen.errors import (
        LogError as LogError,
    )
    from symgen.errors import (
        PackageError as PackageError,
    )
    from symgen.errors import (
        ParameterError as ParameterError,
    )
    from symgen.errors import (
        RobotError as RobotError,
    )
    from symgen.errors import (
        SymgenError as SymgenError,
    )
    from symgen.errors import (
        SymgenWarning as SymgenWarning,
    )
    from symgen.estimation.band import Band as Band
    from symgen.estimation.errors_in_variables import TotalLeastSquares as TotalLeastSquares
    from symgen.estimation.essential import Essential as Essential
    from symgen.estimation.estimators import Huber as Huber
    from symgen.estimation.estimators import Ols as Ols
    from symgen.estimation.estimators import Prior as Prior
    from symgen.estimation.estimators import Ridge as Ridge
    from symgen.estimation.estimators import Wls as Wls
    from symgen.estimation.instrumental import InstrumentalVariables as InstrumentalVariables
    from symgen.experiment.controller import Controller as Controller
    from symgen.experiment.excitation import excite as excite
    from symgen.experiment.instruments import Instruments as Instruments
    from symgen.experiment.options import Motion as Motion
    from symgen.experiment.options import Search as Search
    from symgen.experiment.recording import Recording as Recording
    from symgen.experiment.simulate import simulate as simulate
    from symgen.experiment.study import study as study
    from symgen.experiment.study_result import Study as Study
    from symgen.identification.comparison import compare as compare
    from symgen.identification.estimate import Estimate as Estimate
    from symgen.identification.export import values_header as values_header
    from symgen.identification.payload import payload as payload
    from symgen.identification.physical import link_parameters as link_parameters
    from symgen.identification.prediction import predict as predict
    from symgen.identification.reading import read_estimate as read_estimate
    from symgen.identification.recursive import Identifier as Identifier
    from symgen.identification.robot_file import export as export
    from symgen.identification.workflow import identify as identify
    from symgen.robot.builtin import library as library
    from symgen.robot.toml_io import (
        parse_robot as parse_robot,
    )
    from symgen.robot.toml_io import (
        read_robot as read_robot,
    )
    from symgen.robot.toml_text import robot_toml as robot_toml
    from symgen.robot.types import Joint as Joint
    from symgen.robot.types import Limits as Limits
    from symgen.robot.types import Robot as Robot
    from symgen.runtime.check import Checked as Checked
    from symgen.runtime.check import check as check
    from symgen.runtime.evaluator import Evaluator as Evaluator
    from symgen.runtime.evaluator import load as load
    from symgen.symbolic.base_parameters import BaseParameters as BaseParameters

_WHERE = {
    "Band": "symgen.estimation.band",
    "BaseParameters": "symgen.symbolic.base_parameters",
    "BuildError": "symgen.errors",
    "Checked": "symgen.runtime.check",
    "Controller": "symgen.experiment.controller",
    "Diagnosis": "symgen.diagnosis.diagnosis",
    "Essential": "symgen.estimation.essential",
    "Estimate": "symgen.identification.estimate",
    "Evaluator": "symgen.runtime.evaluator",
    "ExpressionError": "symgen.errors",
    "Huber": "symgen.estimation.estimators",
    "IdentificationError": "symgen.errors",
    "Identifier": "symgen.identification.recursive",
    "Instruments": "symgen.experiment.instruments",
    "InstrumentalVariables": "symgen.estimation.instrumental",
    "Joint": "symgen.robot.types",
    "Limits": "symgen.robot.types",
    "Log": "symgen.data.log",
    "LogError": "symgen.errors",
    "Model": "symgen.codegen.model",
    "Motion": "symgen.experiment.options",
    "Ols": "symgen.estimation.estimators",
    "PackageError": "symgen.errors",
    "ParameterError": "symgen.errors",
    "Prior": "symgen.estimation.estimators",
    "Reading": "symgen.data.raw",
    "Recording": "symgen.experiment.recording",
    "Ridge": "symgen.estimation.estimators",
    "Robot": "symgen.robot.types",
    "RobotError": "symgen.errors",
    "Search": "symgen.experiment.options",
    "Study": "symgen.experiment.study_result",
    "SymgenError": "symgen.errors",
    "SymgenWarning": "symgen.errors",
    "TotalLeastSquares": "symgen.estimation.errors_in_variables",
    "Wls": "symgen.estimation.estimators",
    "check": "symgen.runtime.check",
    "compare": "symgen.identification.comparison",
    "derive": "symgen.codegen.model",
    "diagnose": "symgen.diagnosis.workflow",
    "export": "symgen.identification.robot_file",
    "excite": "symgen.experiment.excitation",
    "fleet": "symgen.diagnosis.fleet",
    "generate": "symgen.codegen.package",
    "identify": "symgen.identification.workflow",
    "library": "symgen.robot.builtin",
    "link_parameters": "symgen.identification.physical",
    "load": "symgen.runtime.evaluator",
    "make_log": "symgen.data.log",
    "parse_robot": "symgen.robot.toml_io",
    "payload": "symgen.identification.payload",
    "predict": "symgen.identification.prediction",
    "prepare": "symgen.data.signals",
    "read_estimate": "symgen.identification.reading",
    "read_log": "symgen.data.log",
    "read_robot": "symgen.robot.toml_io",
    "robot_toml": "symgen.robot.toml_text",
    "simulate": "symgen.experiment.simulate",
    "study": "symgen.experiment.study",
    "values_header": "symgen.identification.export",
    "write_package": "symgen.codegen.package",
}
__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module 'symgen' has no attribute {name!r}")
    return getattr(importlib.import_module(_WHERE[name]), name)


def __dir__() -> list[str]:
    return __all__
