"""The public names of symgen and where they are: `__init__` imports them by this list."""

import symgen.views
from symgen.codegen.model import (
    Model as Model,
    derive as derive,
)
from symgen.codegen.package import (
    generate as generate,
    write_package as write_package,
)
from symgen.data.log import (
    Log as Log,
    make_log as make_log,
    read_log as read_log,
)
from symgen.data.raw import Reading as Reading
from symgen.data.signals import prepare as prepare
from symgen.diagnosis.diagnosis import Diagnosis as Diagnosis
from symgen.diagnosis.workflow import diagnose as diagnose
from symgen.errors import (
    BuildError as BuildError,
    ExpressionError as ExpressionError,
    IdentificationError as IdentificationError,
    LogError as LogError,
    PackageError as PackageError,
    ParameterError as ParameterError,
    RobotError as RobotError,
    SymgenError as SymgenError,
    SymgenWarning as SymgenWarning,
)
from symgen.estimation.band import Band as Band
from symgen.estimation.estimators import TotalLeastSquares as TotalLeastSquares
from symgen.estimation.estimators import (
    Huber as Huber,
    Ols as Ols,
    Prior as Prior,
    Wls as Wls,
)
from symgen.estimation.instrumental import InstrumentalVariables as InstrumentalVariables
from symgen.experiment.excitation import (
    Motion as Motion,
    Search as Search,
    excite as excite,
)
from symgen.experiment.recording import (
    Controller as Controller,
    Instruments as Instruments,
    Recording as Recording,
)
from symgen.experiment.reference import (
    Reference as Reference,
    make_reference as make_reference,
)
from symgen.experiment.simulate import (
    simulate as simulate,
)
from symgen.experiment.study import Study as Study
from symgen.experiment.study import study as study
from symgen.identification.comparison import compare as compare
from symgen.identification.estimate import Estimate as Estimate
from symgen.identification.export import values_header as values_header
from symgen.identification.solving import FitOptions as FitOptions
from symgen.identification.payload import payload as payload
from symgen.identification.physical import link_parameters as link_parameters
from symgen.identification.prediction import predict as predict
from symgen.identification.estimate import read_estimate as read_estimate
from symgen.identification.online.identifier import Identifier as Identifier
from symgen.identification.export import export as export
from symgen.identification.workflow import identify as identify
from symgen.report.store import write as write
from symgen.robot.builtin import library as library
from symgen.robot.toml_io import (
    parse_robot as parse_robot,
    read_robot as read_robot,
)
from symgen.robot.toml_text import robot_toml as robot_toml
from symgen.robot.tables import (
    Frame as Frame,
    Contact as Contact,
    Limits as Limits,
)
from symgen.robot.types import (
    Joint as Joint,
    Robot as Robot,
)
from symgen.runtime.evaluator import (
    Evaluator as Evaluator,
    load as load,
)
from symgen.symbolic.base_parameters import BaseParameters as BaseParameters
from symgen.symbolic.ranks import (
    EquationPart as EquationPart,
    Rank as Rank,
    exact_rank as exact_rank,
)

def load_views() -> symgen.views.Views: ...
