"""Data of the example controller: a robot that could exist, and how wrong the controller has it."""

from __future__ import annotations

import random
from collections.abc import Sequence

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.verification import SEED, physical_parameters

#: What the example calls beside the identifier.
NEEDED = frozenset({"inverse_dynamics", "forward_dynamics", "mass_matrix"})
#: How wrong every mass, inertia and friction of the controller is, in percent.
PERCENT = 5
#: So many times better than PD must computed torque with these parameters track.
BETTER = 10


def possible(kernels: Sequence[Kernel]) -> bool:
    """Whether a package with these kernels has all that the example calls."""
    return {k.name for k in kernels} >= NEEDED


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
