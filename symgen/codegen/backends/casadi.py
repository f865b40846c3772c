"""CasADi: NAME_casadi.py, straight-line code of every kernel, the same bytes every time."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from symgen.codegen import example
from symgen.codegen.backends import Package
from symgen.codegen.kernel import Kernel
from symgen.codegen.python_printer import PythonPrinter, Vocabulary, docstring, wrapped
from symgen.files import rendered
from symgen.robot.types import Robot

_VOCABULARY = Vocabulary(
    library="ca",
    absolute="fabs",
    indexed=True,
    selected="link == {number}",
    inverse="1.0 / {value}",
    logarithm="ca.log({value})",
)


def files(package: Package) -> dict[str, str]:
    """Return NAME_casadi.py, and the optimal control if its kernels are in the package."""
    source = casadi_source(package.name, package.model.robot, package.kernels)
    return {f"{package.name}_casadi.py": source, **example.optimal_control(package)}


def casadi_source(name: str, robot: Robot, kernels: Sequence[Kernel]) -> str:
    """Return NAME_casadi.py: a function for each kernel that builds a casadi.Function.

    Arrays are columns and matrices with the shapes in NAME.h; 4x4 frames are stacked. An output is
    NaN if a guard is not positive: the mass matrix is not positive definite, or the robot has no
    such link.

    Args:
        name: prefix of the package.
        robot: the robot, with the values of the named lengths.
        kernels: kernels of the package.
    """
    return rendered(
        "casadi/kernels.py",
        name=name,
        robot=robot.name,
        kernels=[_described(name, robot, kernel) for kernel in kernels],
    )


def casadi_functions(
    name: str, robot: Robot, kernels: Sequence[Kernel]
) -> Mapping[str, Callable[[], Any]]:
    """Run NAME_casadi.py; return for each kernel the function that builds its casadi.Function."""
    content: dict[str, Any] = {"__name__": f"{name}_casadi"}
    exec(compile(casadi_source(name, robot, kernels), f"{name}_casadi.py", "exec"), content)
    functions: dict[str, Callable[[], Any]] = content["FUNCTIONS"]
    return functions


def _described(name: str, robot: Robot, kernel: Kernel) -> dict[str, Any]:
    """Return the data of a kernel for the template."""
    printer = PythonPrinter(kernel, robot, _VOCABULARY)
    guards = [printer.expression(e) for e in printer.guards]
    if kernel.link is not None:
        first, last = kernel.link.first, kernel.link.last
        guards.append(f"(link >= {first}) * (link <= {last}) * (link == ca.floor(link))")
    function = re.sub("_+", "_", f"{name}_casadi_{kernel.name}")  # CasADi refuses two in a row
    return {
        "name": kernel.name,
        "doc": docstring(kernel),
        "function": function.strip("_"),
        "inputs": [(a.name, 1 if a.plain else a.size) for a in kernel.inputs],
        "outputs": [{**o, "entries": wrapped(o["entries"])} for o in printer.outputs()],
        "guards": guards,
        "lines": list(printer.lines()),
    }
