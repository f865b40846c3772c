"""The example programs of a package, in C and with CasADi, for a physically possible robot."""

from __future__ import annotations

import random
import textwrap
from collections.abc import Sequence
from typing import Any

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters
from symgen.files import rendered

#: Program -> kernels that it calls. The controller also uses the identifier.
PROGRAMS = {
    "controller": {"inverse_dynamics", "forward_dynamics", "mass_matrix"},
    "observer": {"inverse_dynamics", "forward_dynamics", "generalized_momentum", "friction"},
    "gravity": {"forward_dynamics", "bias_torque"},
    "adaptive": {"slotine_li_regressor", "forward_dynamics", "mass_matrix"},
    "impedance": {
        "add_body",
        "bias_torque",
        "forward_dynamics",
        "frames",
        "gravity_torque",
        "link_jacobian",
    },
}
#: Error of every mass, inertia and friction that the programs assume, percent.
PERCENT = 5
#: Required ratio of the tracking errors of PD and of computed torque with these parameters.
BETTER = 10
#: Share of the friction that gravity compensation removes.
SHARE = 0.8


def programs(model: Model, kernels: Sequence[Kernel], *, identifier: bool) -> tuple[str, ...]:
    """Return the programs of a package with these kernels.

    A robot with effects has only the controller.

    Args:
        model: from `derive`.
        kernels: kernels of the package.
        identifier: whether the package has the identifier.
    """
    written = {k.name for k in kernels}
    return tuple(
        name
        for name, needs in PROGRAMS.items()
        if written >= needs and (identifier if name == "controller" else not model.robot.effects)
    )


def facts(model: Model, kernels: Sequence[Kernel], dtype: str) -> dict[str, Any]:
    """Return data of the robot for the templates: links, disturbances, and parameters.

    The parameters are C literals of X: `actual`, and `assumed` by the controller.

    Args:
        model: from `derive`.
        kernels: kernels of the package.
        dtype: double or float.
    """
    weight = [k.tape.outputs for k in kernels if k.name == "gravity_torque"]
    suffix = "f" if dtype == "float" else ""

    def literals(error: float) -> list[str]:
        X = physical_parameters(model, random.Random(SEED), error)
        return [f"{round(x, 6)!r}{suffix}" for x in X]

    return {
        "g": ", GRAVITY" if model.robot.gravity_input else "",
        "better": BETTER,
        "share": SHARE,
        "links": len(model.robot.joints),
        "link": model.robot.movable[-1].number,
        "rubs": any(j.friction for j in model.robot.joints),
        "falls": any(torque != 0 for torques in weight for torque in torques),
        "actual": literals(0.0),
        "assumed": literals(PERCENT / 100),
    }


def controllable(model: Model, kernels: Sequence[Kernel]) -> bool:
    """Whether the optimal-control example has its kernels and a smooth model."""
    robot = model.robot
    if robot.effects:
        return False
    called = {"inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix"}
    return called <= {k.name for k in kernels}


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
