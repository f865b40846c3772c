"""Targets of a package: C, CasADi, and what is built on the C."""

from __future__ import annotations

from collections.abc import Sequence

from symgen.codegen.backends import Backend, fmu, mex
from symgen.codegen.kernels import Kernel
from symgen.errors import PackageError
from symgen.robot.types import Robot, require_gravity

#: What stands on the C: each of these comes with it.
BACKENDS: dict[str, Backend] = {"fmu": fmu, "mex": mex}
TARGETS = ("c", "casadi", *BACKENDS, "all")


def backends(target: str, kernels: Sequence[Kernel], robot: Robot) -> tuple[str, ...]:
    """Return the names of the backends that a target asks for; "all", those that the kernels allow.

    Raises:
        PackageError: there is no such target, or it needs a kernel that is not written.
        RobotError: it is an FMU, and gravity is an input.
    """
    if target not in TARGETS:
        raise PackageError(f"target {target!r}; accepted: {', '.join(TARGETS)}")
    written = {k.name for k in kernels}
    if target == "all":
        possible = [name for name in BACKENDS if name != "fmu" or not robot.gravity_input]
        return tuple(name for name in possible if written >= BACKENDS[name].NEEDS)
    if target == "fmu":
        require_gravity(robot, "an FMU")
    if target not in BACKENDS:
        return ()
    missing = sorted(BACKENDS[target].NEEDS - written)
    if missing:
        raise PackageError(f"target {target}: needs the kernels {', '.join(missing)}")
    return (target,)
