"""The example programs of a package, in C and with CasADi, for a physically possible robot."""

from __future__ import annotations

import random
import textwrap
from collections.abc import Sequence
from typing import Any

from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters
from symgen.files import rendered

#: Kernels that the controller calls, beside the identifier, and those of the optimal control.
CONTROLLER = frozenset({"inverse_dynamics", "forward_dynamics", "mass_matrix"})
OPTIMAL_CONTROL = frozenset({"inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix"})
#: Error of every mass, inertia and friction that the controller assumes, percent.
PERCENT = 5
#: Required ratio of the tracking errors of PD and of computed torque with these parameters.
BETTER = 10


def called_by(program: frozenset[str], kernels: Sequence[Kernel]) -> bool:
    """Whether a package with these kernels has all that a program calls."""
    return program <= {k.name for k in kernels}


def facts(model: Model, dtype: str) -> dict[str, Any]:
    """Return the parameters of the controller's example as C literals: actual and assumed ones.

    Args:
        model: from `derive`.
        dtype: double or float.
    """
    suffix = "f" if dtype == "float" else ""

    def literals(error: float) -> list[str]:
        X = physical_parameters(model, random.Random(SEED), error)
        return [f"{round(x, 6)!r}{suffix}" for x in X]

    return {
        "g": ", GRAVITY" if model.robot.gravity_input else "",
        "better": BETTER,
        "actual": literals(0.0),
        "assumed": literals(PERCENT / 100),
    }


def optimal_control(name: str, model: Model) -> str:
    """Return example/NAME_optimal_control.py.

    Args:
        name: prefix of the package.
        model: model of the robot; its parameters are physically possible, without dry friction.
    """
    X = physical_parameters(model, random.Random(SEED))
    for i, parameter in enumerate(model.base.parameters):
        standard = model.base.standard[parameter.index]
        joint = standard.joint
        smooth = standard.prefix == "FS" and model.robot.joint(joint).coulomb_width > 0
        X[i] = 0.0 if standard.prefix in ("FS", "FSM") and not smooth else round(X[i], 6)
    lines = textwrap.wrap(", ".join(map(repr, X)) + ",", 95)
    tilted = model.robot.gravity_input
    return rendered("casadi/optimal_control.py", name=name, lines=lines, tilted=tilted)
