"""Simulink: a function of MATLAB that makes a library of C Caller blocks, one for each kernel."""

from __future__ import annotations

from symgen.codegen.backends import Package
from symgen.codegen.kernel import Kernel

BUILDS_ON: tuple[str, ...] = ("c",)
_TYPES = {"double": "double", "float": "single"}


def files(package: Package) -> dict[str, str]:
    """Return NAME_simulink.m."""
    kernels = [{"name": k.name, "ports": _ports(k)} for k in package.kernels]
    values = None if package.values is None else list(map(repr, package.values.X))
    kind = _TYPES[package.dtype]
    text = package.render("simulink/simulink.m", kernels=kernels, values=values, type=kind)
    return {f"{package.name}_simulink.m": text}


def _ports(kernel: Kernel) -> list[str]:
    """Return pairs: an argument that the function writes, and its scope in Simulink."""
    pairs = ((a.name, "InputOutput" if a.read else "Output") for a in kernel.arguments if a.written)
    return [word for pair in pairs for word in pair]
