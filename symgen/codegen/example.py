"""The example programs of a package, in C and with CasADi, for a physically possible robot."""

from __future__ import annotations

import random
import textwrap

from symgen.codegen.backends import Package
from symgen.codegen.verification import SEED, physical_parameters

#: Kernels that the controller calls in addition to the identifier; and those of the optimal
#: control.
_CONTROLLER = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
_OPTIMAL_CONTROL = ("inverse_dynamics", "inverse_dynamics_derivatives", "mass_matrix")
#: Error of every mass, inertia and friction value that the controller uses, percent.
PERCENT = 5
#: Required ratio of the tracking errors of PD and of computed torque with these parameters.
_BETTER = 10
_LINE = 95


def has_controller(package: Package) -> bool:
    """Return whether the package contains the example of the controller, which calls the
    identifier.
    """
    return "c" in package.targets and "identifier" in package.runtime and package.has(*_CONTROLLER)


def controller(package: Package) -> dict[str, str]:
    """Return the controller example in C, with parameter errors; {} without its kernels."""
    if not has_controller(package):
        return {}
    gravity = ", GRAVITY" if package.model.robot.gravity_input else ""
    out = {}
    for file in ("simulated.h", "controller.c"):
        out[f"example/{package.name}_{file}"] = package.render(
            f"c/example/{file}",
            g=gravity,
            better=_BETTER,
            percent=PERCENT,
            actual=_literals(package, 0.0),
            assumed=_literals(package, PERCENT / 100),
        )
    return out


def _literals(package: Package, error: float) -> list[str]:
    """Return the parameters as C literals, with a relative error."""
    suffix = "f" if package.dtype == "float" else ""
    X = physical_parameters(package.model, random.Random(SEED), error)
    return [f"{round(x, 6)!r}{suffix}" for x in X]


def has_optimal_control(package: Package) -> bool:
    """Return whether the package can contain the optimal control, which needs smooth torques."""
    robot = package.model.robot
    return not (robot.effects or robot.imu) and package.has(*_OPTIMAL_CONTROL)


def optimal_control(package: Package) -> dict[str, str]:
    """Return the optimal control with CasADi, without dry friction; {} without its kernels."""
    if not has_optimal_control(package):
        return {}
    model = package.model
    X = physical_parameters(model, random.Random(SEED))
    for i, parameter in enumerate(model.base.parameters):
        standard = model.base.standard[parameter.index]
        joint = standard.joint
        smooth = standard.prefix == "FS" and model.robot.joint(joint).coulomb_width > 0
        X[i] = 0.0 if standard.prefix in ("FS", "FSM") and not smooth else round(X[i], 6)
    lines = textwrap.wrap(", ".join(map(repr, X)) + ",", _LINE)
    tilted = model.robot.gravity_input
    text = package.render("casadi/optimal_control.py", lines=lines, tilted=tilted)
    return {f"example/{package.name}_optimal_control.py": text}
