"""MEX: every kernel in MATLAB and Octave, through one gateway."""

from __future__ import annotations

from typing import Any

from symgen.codegen.backends import Package


def files(package: Package) -> dict[str, str]:
    """Return the files of the folder mex/: the gateway and its build function."""
    name, kernels = package.name, package.kernels
    parameters = len(package.model.base.parameters)
    inputs = [a for k in kernels for a in k.inputs if not a.plain]
    data: dict[str, Any] = {
        "kernels": kernels,
        "known": package.values is not None,
        "inputs": max(len(k.inputs) for k in kernels),
        "outputs": max(len(k.outputs) for k in kernels),
        "widest": max(parameters if a.name == "X" else a.size for a in inputs),
        "largest": max(parameters, *(o.size for k in kernels for o in k.outputs)),
    }
    return {
        f"mex/{name}_mex.c": package.render("mex/gateway.c", **data),
        f"mex/{name}_build.m": package.render("mex/build.m", **data),
    }
