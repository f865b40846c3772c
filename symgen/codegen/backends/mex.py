"""MEX: every kernel in MATLAB and Octave, through one gateway."""

from __future__ import annotations

from typing import Any

from symgen.codegen.backends import Package
from symgen.codegen.kernel import Kernel
from symgen.files import rendered


def files(package: Package) -> dict[str, str]:
    """Return the files of the folder mex/: the gateway and its build function."""
    name, parameters = package.name, len(package.model.base.parameters)
    kernels = [_described(kernel, parameters) for kernel in package.kernels]
    data: dict[str, Any] = {
        "name": name,
        "first": 0 if package.model.robot.floating else 1,
        "kernels": kernels,
        "parameters": parameters,
        "known": package.values is not None,
        "inputs": max(len(k["inputs"]) for k in kernels),
        "outputs": max(len(k["shapes"]) for k in kernels),
        "widest": max(size for k in kernels for _, size, *_ in k["inputs"]),
        "largest": max(parameters, *(o.size for k in package.kernels for o in k.outputs)),
        "sources": [f"{name}_{kernel.name}.c" for kernel in package.kernels],
    }
    return {
        f"mex/{name}_mex.c": rendered("mex/gateway.c", **data),
        f"mex/{name}_build.m": rendered("mex/build.m", **data),
    }


def _described(kernel: Kernel, parameters: int) -> dict[str, Any]:
    place = {output.name: i for i, output in enumerate(kernel.outputs)}
    inputs, copies, words = [], [], []
    for i, a in enumerate(kernel.inputs):
        size = 1 if a.plain else parameters if a.name == "X" else a.size
        shared = int(a.shared or not kernel.batch)
        inputs.append((a.name, size, shared, a.last if a.link else 0))
        if a.written:
            copies.append((place[a.name], i, size))
        words.append(
            f"out[{place[a.name]}]" if a.written else f"(size_t)in[{i}][0]" if a.link
            else f"in[{i}][0]" if a.plain else f"in[{i}]"
        )  # fmt: skip
    words += [f"out[{place[a.name]}]" for a in kernel.arguments if not a.read]
    return {
        "name": kernel.name,
        "fallible": kernel.fallible,
        "inputs": inputs,
        "shapes": [o.shape for o in kernel.outputs],
        "copies": copies,
        "arguments": ", ".join(words),
    }
