"""The C that folds rows of a regressor into normal equations or a triangle on this machine."""

from __future__ import annotations

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model
from symgen.codegen.panels import panel_sources
from symgen.files import rendered, templates

_PANELS = 32  # of rows in a block: its columns stay in the second cache


def foldable(kernel: Kernel) -> bool:
    """Whether a kernel's one output is a matrix of columns, linear in X."""
    return len(kernel.outputs) == 1 and bool(kernel.outputs[0].columns)


def fold_sources(model: Model, kernel: Kernel) -> dict[str, bytes]:
    """Return the sources of NAME_KERNEL_fold and of the panels that it evaluates."""
    name = model.robot.name
    (output,) = kernel.outputs
    columns = len(output.columns)
    rows = output.size // columns
    zero = [entry == 0 for entry in kernel.tape.outputs]
    first = [
        next((c for c in range(columns) if not zero[r * columns + c]), columns) for r in range(rows)
    ]
    arguments = [(a, len(symbols)) for a, symbols in kernel.tape.inputs]
    described = {
        "name": kernel.name,
        "columns": columns,
        "rows": rows,
        "panels": max(1, _PANELS // rows),
        # The last row that has begun: rows before it may begin later.
        "reached": [
            1 + max((r for r in range(rows) if first[r] <= c), default=-1) for c in range(columns)
        ],
        "strides": ", ".join(f"&{a}[k * {size}u]" for a, size in arguments),
        "parameters": ", ".join(
            ["size_t N", *(f"const double *{a}" for a, _ in arguments)]
            + ["const double *y", "const double *weights", "int varying", "int orthogonal"]
            + ["void *room", "double *out"]
        ),
    }
    files = {
        f"{name}_{kernel.name}_fold{suffix}": rendered(
            f"c/fold{suffix}", name=name, k=described
        ).encode()
        for suffix in (".h", ".c")
    }
    plain = (templates() / "c" / "runtime" / "fold.inc").read_text("utf-8").replace("NAME", name)
    return panel_sources(model, kernel) | files | {f"{name}_fold.inc": plain.encode()}
