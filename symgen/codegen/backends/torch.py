"""PyTorch: NAME_torch.py, a function of tensors for every kernel."""

from __future__ import annotations

from symgen.codegen.array_backend import Library, array_source
from symgen.codegen.backends import Package

BUILDS_ON: tuple[str, ...] = ()
_LIBRARY = Library(
    title="PyTorch",
    needs="torch, and nothing else",
    file="torch.py",
    name="torch",
    convert="as_tensor",
    unpack="torch.unbind({array}, -1)",
    transforms="Gradients and torch.func apply to the functions, also by X.",
)


def files(package: Package) -> dict[str, str]:
    """Return NAME_torch.py."""
    module = f"{package.name}_torch"
    return {f"{module}.py": array_source(package, _LIBRARY, module)}
