"""The examples in C: which there are, a robot that could exist, and how wrong they have it."""

from __future__ import annotations

import random
from collections.abc import Sequence

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters

#: The kernels that each program calls; the controller watches with the identifier, too.
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
#: How wrong every mass, inertia and friction of the programs is, in percent.
PERCENT = 5
#: So many times better than PD must computed torque with these parameters track.
BETTER = 10
#: Part of the friction that gravity compensation takes away.
SHARE = 0.8


def programs(model: Model, kernels: Sequence[Kernel], *, identifier: bool) -> tuple[str, ...]:
    """Return the programs that a package with these kernels has.

    Effects suit the controller alone.

    Args:
        model: from `derive`.
        kernels: those of the package.
        identifier: whether it is in the package.
    """
    written = {k.name for k in kernels}
    return tuple(
        name
        for name, needs in PROGRAMS.items()
        if written >= needs and (identifier if name == "controller" else not model.robot.effects)
    )


def facts(model: Model, kernels: Sequence[Kernel]) -> dict[str, int | bool]:
    """Return what programs are told of the robot: its links, the last that moves, what acts on it.

    Args:
        model: from `derive`.
        kernels: those of the package.
    """
    weight = [k.tape.outputs for k in kernels if k.name == "gravity_torque"]
    return {
        "links": len(model.robot.joints),
        "link": model.robot.movable[-1].number,
        "rubs": any(j.friction for j in model.robot.joints),
        "falls": any(torque != 0 for torques in weight for torque in torques),
    }


def parameters(model: Model, suffix: str) -> dict[str, list[str]]:
    """Return the C literals of X: `actual`, and `assumed` by the controller.

    Args:
        model: from `derive`.
        suffix: of the literals, "f" for float.
    """
    errors = {"actual": 0.0, "assumed": PERCENT / 100}
    return {
        key: [
            f"{round(x, 6)!r}{suffix}"
            for x in physical_parameters(model, random.Random(SEED), error)
        ]
        for key, error in errors.items()
    }
