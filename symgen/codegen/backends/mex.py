"""MEX: every kernel in MATLAB and Octave, through one gateway over NAME.h."""

from __future__ import annotations

from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.kernels import Kernel
from symgen.files import rendered

NEEDS: frozenset[str] = frozenset()


def files(package: Package) -> dict[str, str]:
    """Return the files of the folder mex/: the gateway, and the function that compiles it."""
    name, model = package.name, package.model
    kernels = [_described(kernel) for kernel in package.kernels]
    parameters = len(model.base.parameters)
    data: dict[str, Any] = {
        "name": name,
        "kernels": kernels,
        "inputs": max(len(k["inputs"]) for k in kernels),
        "outputs": max(len(k["outputs"]) for k in kernels),
        "widest": max(model.robot.n, parameters),
        "largest": max(o.size for kernel in package.kernels for o in kernel.outputs),
        "sources": [f"{name}_{kernel.name}.c" for kernel in package.kernels],
    }
    return {
        f"mex/{name}_mex.c": rendered("mex/gateway.c", **data),
        f"mex/{name}_build.m": rendered("mex/build.m", **data),
    }


def _described(kernel: Kernel) -> dict[str, Any]:
    inputs = [name for name, _ in kernel.tape.inputs]
    outputs = [output.name for output in kernel.outputs]
    shapes = [(*output.shape, 0, 0)[:3] for output in kernel.outputs]
    arrays = [f"in[{i}]" for i in range(len(inputs))] + [f"out[{i}]" for i in range(len(outputs))]
    return {
        "name": kernel.name,
        "guarded": bool(kernel.guards),
        "inputs": inputs,
        "outputs": outputs,
        "shapes": [", ".join(map(str, shape)) for shape in shapes],
        "arguments": ", ".join(arrays),
    }
