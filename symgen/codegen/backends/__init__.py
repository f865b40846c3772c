"""Backends: each writes the files of one target, based on the C package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model
from symgen.codegen.values import Values


@dataclass(frozen=True)
class Package:
    """The C package on which a backend builds.

    Attributes:
        name: prefix of every function.
        model: the derived model.
        dtype: "double" or "float".
        kernels: kernels of the package.
        files: path -> text of every file of the C package.
        values: values of the parameters, if they are known.
    """

    name: str
    model: Model
    dtype: str
    kernels: Sequence[Kernel]
    files: Mapping[str, str]
    values: Values | None = None


class Backend(Protocol):
    """Interface of a backend module: the files that a target adds to a C package.

    Attributes:
        NEEDS: names of the kernels that it calls.
    """

    NEEDS: frozenset[str]

    def files(self, package: Package) -> dict[str, str]:
        """Return path -> text of its files."""
        ...
