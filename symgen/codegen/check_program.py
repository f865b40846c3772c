"""Data of NAME_check.c: every kernel called at the points of its verification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symgen.codegen.kernels import LINK, SCALARS, Kernel
from symgen.codegen.prototypes import arguments


def checks(
    prefix: str, kernels: Sequence[Kernel], verified: Mapping[str, Any], dtype: str
) -> list[dict[str, Any]]:
    """Return what the template prints of each kernel.

    Args:
        prefix: of the package.
        kernels: those of the package.
        verified: points and expected values by kernel, from `verification`.
        dtype: double or float.
    """
    return [_check(prefix, kernel, verified[kernel.name], dtype) for kernel in kernels]


def _check(prefix: str, kernel: Kernel, entry: Mapping[str, Any], dtype: str) -> dict[str, Any]:
    offsets = [sum(o.size for o in kernel.outputs[:i]) for i in range(len(kernel.outputs))]
    outputs = [
        {"name": o.name, "size": o.size, "offset": offset}
        for o, offset in zip(kernel.outputs, offsets, strict=True)
    ]
    # What is changed in place is copied from its points first.
    changed = {o.name for o in kernel.outputs} & {name for name, _ in kernel.tape.inputs}
    given = {name: f"{name}_in" if name in changed else name for name, _ in kernel.tape.inputs}
    inputs = [
        {
            "name": given[name],
            "real": f"{prefix}_real" if name != LINK else "size_t",
            "size": len(entry["points"][0][name]),
            "rows": [_row(name, point[name], dtype) for point in entry["points"]],
        }
        for name, _ in kernel.tape.inputs
    ]
    words = {name: f"{given[name]}[i]" for name in given if name not in changed}
    words |= {name: f"{name}[i][0]" for name in given if name == LINK or name in SCALARS}
    listed = [words.get(a.name, a.name) for a in arguments(kernel, dtype)]
    call = f"{prefix}_{kernel.name}({', '.join(listed)})"
    return {
        "name": kernel.name,
        "size": kernel.size,
        "arguments": inputs,
        "changed": sorted(changed),
        "outputs": outputs,
        "call": f"worst += {call}" if kernel.fallible else call,
        "expected": [", ".join(repr(float(v)) for v in row) for row in entry["expected"]],
    }


def _row(name: str, values: Sequence[float], dtype: str) -> str:
    suffix = "u" if name == LINK else "f" if dtype == "float" else ""
    return ", ".join(f"{v!r}{suffix}" for v in values)
