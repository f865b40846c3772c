"""The runtime in C (least squares, the identifier on line): parts of a package, and their text."""

from __future__ import annotations

from collections.abc import Sequence

from symgen.codegen.kernels import ENERGY, Kernel
from symgen.codegen.model import Model
from symgen.files import rendered

PARTS = ("least_squares", "identifier", "identifier_momentum")


def runtime_parts(model: Model, kernels: Sequence[Kernel]) -> tuple[str, ...]:
    """Return the runtime's parts whose kernels are written: every column of their model.

    Args:
        model: from `derive`.
        kernels: those of the package.
    """
    written = {k.name for k in kernels}
    rubs = len(model.base.parameters) > model.inertial
    if model.robot.loaded:
        return ()  # not linear in X

    def complete(kernel: str, friction: str) -> bool:
        return {kernel, *([friction] if rubs else [])} <= written

    if not complete(*ENERGY):
        return ()
    return PARTS if complete("momentum_regressor", "friction_torque") else PARTS[:2]


def runtime_source(path: str, gravity_input: bool) -> str:
    """Return a file of the runtime, where NAME stands for the prefix.

    Args:
        path: in templates/c/runtime.
        gravity_input: whether its functions take g as their last input.
    """
    declared, given = (", const NAME_real *g", ", g") if gravity_input else ("", "")
    return rendered(f"c/runtime/{path}", gravity_input=gravity_input, G=declared, g=given)
