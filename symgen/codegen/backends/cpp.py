"""NAME.hpp: the C functions as a C++17 struct, for templates over robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symgen.codegen.kernels import Argument, Kernel
from symgen.codegen.model import Model
from symgen.files import rendered


def header(name: str, model: Model, kernels: Sequence[Kernel]) -> str:
    """Return the text of NAME.hpp.

    Args:
        name: prefix of the C functions.
        model: model with the names of the parameters.
        kernels: kernels of the package. Each becomes two static functions of the struct
            NAME_robot, or one if it changes its argument in place.
    """
    described = [_described(kernel) for kernel in kernels]
    return rendered("cpp/model.hpp", name=name, base=model.base.parameters, kernels=described)


def _described(kernel: Kernel) -> dict[str, Any]:
    inputs = kernel.inputs
    changed = {i.name for i in inputs if i.written}
    outputs = [o for o in kernel.outputs if o.name not in changed]
    arrays = [f"std::array<real, {o.size}>" for o in outputs]
    names = [o.name for o in outputs]
    several = len(names) > 1
    value = f"std::tuple<{', '.join(arrays)}>" if several else "".join(arrays)
    listed = f"{{ {', '.join(names)} }}"
    if kernel.fallible:  # std::optional takes no list
        listed = f"std::make_tuple({', '.join(names)})"
    words = [i.name if i.plain else f"{i.name}.data()" for i in inputs]
    return {
        "name": kernel.name,
        "doc": kernel.doc,
        "fallible": kernel.fallible,
        "reason": " or ".join(
            ["there is no such link"] * bool(kernel.links) + ["it has none"] * bool(kernel.guards)
        ),
        "outputs": [
            {"name": o.name, "size": o.size, "shape": ", ".join(map(str, o.shape))} for o in outputs
        ],
        "inputs": ", ".join(map(_declared, inputs)),
        "written": "".join(f", output<{o.size}> {o.name}" for o in outputs),
        "names": ", ".join([*(i.name for i in inputs), *names]),
        "pointers": ", ".join([*words, *(f"{name}.data()" for name in names)]),
        "value": "" if changed else f"std::optional<{value}>" if kernel.fallible else value,
        "returned": listed if several else "".join(names),
    }


def _declared(argument: Argument) -> str:
    if argument.plain:
        return f"{'std::size_t' if argument.link else 'real'} {argument.name}"
    size = "parameters" if argument.name == "X" else str(argument.size)
    return f"{'output' if argument.written else 'input'}<{size}> {argument.name}"
