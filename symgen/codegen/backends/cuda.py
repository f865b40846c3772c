"""CUDA: NAME.cu, every function with a batch for arrays of states in device memory."""

from __future__ import annotations

import textwrap
from typing import Any

from symgen.codegen.backends import Package, c
from symgen.codegen.kernel import Argument, Kernel

BUILDS_ON: tuple[str, ...] = ("c",)
_LINE = 100
_PARAMETERS = "X"


def files(package: Package) -> dict[str, str]:
    """Return NAME.cu and its header."""
    name = package.name
    kernels = [_described(package, kernel) for kernel in package.kernels if kernel.batch]
    math = ""
    if any(k["needs_sincos"] for k in kernels):
        source = c.runtime_source("math.h", package.model.robot.gravity_input, package.dtype)
        marked = source.replace("static inline", "NAME_FUNCTION static inline")
        math = marked.replace("NAME", name).strip()
    return {
        f"{name}.cu": package.render("c/cuda.cu", kernels=kernels, math=math),
        f"{name}_cuda.h": package.render("c/cuda.h", kernels=kernels),
    }


def _described(package: Package, kernel: Kernel) -> dict[str, Any]:
    """Return the data of a kernel for the templates."""
    name, real = package.name, package.dtype
    each = any(a.name == _PARAMETERS for a in kernel.inputs)
    columns = [a for a in kernel.inputs if a.size and not a.shared]
    declared = [_pointer(a, real) for a in kernel.arguments]
    passed = [a.name for a in kernel.arguments]
    states = list(declared)
    called = [_of_state(a, columns) for a in kernel.arguments]
    if each:
        at = passed.index(_PARAMETERS)
        passed[at], states[at] = "parameters", "Parameters X"
    if kernel.fallible:
        declared.append("int *status")
        states.append("int *status")
        passed.append("status")
    head = ["void *stream", "size_t N", *["int x_each"] * each, *declared]
    prototype = f"int {name}_{kernel.name}_cuda({', '.join(head)})"
    qualifiers = f"{name}_FUNCTION static"
    return {
        **c.described(package, kernel, False),
        "qualifiers": f"template <class Parameters>\n{qualifiers}" if each else qualifiers,
        "parameters": ", ".join(_parameter(a, real) for a in kernel.arguments),
        "each": each,
        "columns": columns,
        "prototype": textwrap.wrap(prototype, _LINE, subsequent_indent="    "),
        "states": ", ".join(["size_t N", *states]),
        "call": ", ".join(called),
        "passed": ", ".join(["N", *passed]),
    }


def _pointer(argument: Argument, real: str) -> str:
    """Return the declaration of an argument for all states."""
    return argument.declared(real, batch=True)


def _parameter(argument: Argument, real: str) -> str:
    """Return the declaration of an argument of the function for one state."""
    if argument.name == _PARAMETERS:
        return f"const Parameters {argument.name}"
    return f"const Column {argument.name}" if argument.written else argument.declared(real)


def _of_state(argument: Argument, columns: list[Argument]) -> str:
    """Return the text that passes an argument of state k."""
    name = argument.name
    if argument.written:
        return f"Column{{{name} + k, N}}"
    if name == _PARAMETERS:
        return f"{name}.at(k)"
    return f"{name}_k" if argument in columns else name
