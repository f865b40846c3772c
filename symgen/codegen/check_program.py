"""Data of NAME_check.c: every kernel called at the points of its verification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symgen.codegen.kernels import Kernel


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
    inputs, words = [], []
    for a in kernel.arguments:
        given = f"{a.name}_in" if a.written else a.name  # copied first, if it is changed in place
        first = f"{given}[i]"
        words.append(a.name if a.written else f"{first}[0]" if a.plain else first)
        if a.read:
            suffix = "u" if a.link else "f" if dtype == "float" else ""
            points = [point[a.name] for point in entry["points"]]
            inputs.append(
                {
                    "name": given,
                    "real": "size_t" if a.link else f"{prefix}_real",
                    "size": len(points[0]),
                    "rows": [", ".join(f"{v!r}{suffix}" for v in values) for values in points],
                }
            )
    sizes = [o.size for o in kernel.outputs]
    call = f"{prefix}_{kernel.name}({', '.join(words)})"
    return {
        "name": kernel.name,
        "size": kernel.size,
        "arguments": inputs,
        "changed": sorted(a.name for a in kernel.inputs if a.written),
        "outputs": [
            {"name": o.name, "size": o.size, "offset": sum(sizes[:i])}
            for i, o in enumerate(kernel.outputs)
        ],
        "call": f"worst += {call}" if kernel.fallible else call,
        "expected": [", ".join(repr(float(v)) for v in row) for row in entry["expected"]],
    }
