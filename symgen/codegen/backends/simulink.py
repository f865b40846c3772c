"""Simulink: a function of MATLAB that makes a library of C Caller blocks, one for each kernel."""

from __future__ import annotations

from symgen.codegen.backends import Package


def files(package: Package) -> dict[str, str]:
    """Return NAME_simulink.m."""
    text = package.render(
        "simulink/simulink.m",
        kernels=package.kernels,
        values=package.values,
    )
    return {f"{package.name}_simulink.m": text}
