"""PyTorch: NAME_torch.py, a function of tensors for every kernel."""

from __future__ import annotations

from symgen.codegen.array_backend import array_files
from symgen.codegen.backends import Package

BUILDS_ON: tuple[str, ...] = ()


def files(package: Package) -> dict[str, str]:
    """Return NAME_torch.py."""
    return array_files(package, "torch", "torch")
