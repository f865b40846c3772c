"""NAME.hpp: the C functions as a struct in C++17, for templates over robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symgen.codegen.kernels import Kernel
from symgen.codegen.manifest import base_table
from symgen.codegen.model import Model
from symgen.files import rendered


def header(name: str, model: Model, kernels: Sequence[Kernel]) -> str:
    """Return the text of NAME.hpp.

    Args:
        name: prefix of the C functions.
        model: gives the names of the parameters.
        kernels: those of the package; each becomes two static functions of the struct NAME_robot.
    """
    described = [_described(kernel) for kernel in kernels]
    return rendered("cpp/model.hpp", name=name, base=base_table(model), kernels=described)


def _described(kernel: Kernel) -> dict[str, Any]:
    # X is one vector for all kernels: those that need its first entries alone take it whole, too.
    inputs = [
        (a, "parameters" if a == "X" else str(len(symbols))) for a, symbols in kernel.tape.inputs
    ]
    arrays = [f"std::array<real, {o.size}>" for o in kernel.outputs]
    names = [o.name for o in kernel.outputs]
    several = len(names) > 1
    value = f"std::tuple<{', '.join(arrays)}>" if several else arrays[0]
    returned = f"{{ {', '.join(names)} }}" if several else names[0]
    return {
        "name": kernel.name,
        "doc": kernel.doc,
        "guarded": bool(kernel.guards),
        "outputs": [
            {"name": o.name, "size": o.size, "shape": ", ".join(map(str, o.shape))}
            for o in kernel.outputs
        ],
        "inputs": ", ".join(f"input<{size}> {a}" for a, size in inputs),
        "written": ", ".join(f"output<{o.size}> {o.name}" for o in kernel.outputs),
        "names": ", ".join([a for a, _ in inputs] + names),
        "pointers": ", ".join(f"{a}.data()" for a in [*(a for a, _ in inputs), *names]),
        "value": f"std::optional<{value}>" if kernel.guards else value,
        "returned": returned,
    }
