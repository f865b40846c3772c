"""The example of optimal control over the .casadi files of a package."""

from __future__ import annotations

import random
import textwrap
from collections.abc import Sequence

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters
from symgen.files import rendered


def possible(model: Model, kernels: Sequence[Kernel]) -> bool:
    """Whether a package with these kernels has what the example calls, and a smooth model."""
    robot = model.robot
    if robot.effects:
        return False
    called = {"inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix"}
    return called <= {k.name for k in kernels}


def program(name: str, model: Model) -> str:
    """Return example/NAME_optimal_control.py.

    Args:
        name: prefix of the package.
        model: gives the parameters of a robot that could exist, without dry friction.
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
