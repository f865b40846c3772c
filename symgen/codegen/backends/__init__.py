"""Backends: each writes a model as the files of one kind of program, over the same C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from symgen.codegen.kernels import Kernel
from symgen.codegen.model import Model


@dataclass(frozen=True)
class Package:
    """The C that a backend builds on.

    Attributes:
        name: prefix of every function.
        model: the derived model.
        dtype: "double" or "float".
        kernels: those that are written.
        files: path and text of every file of the C package.
    """

    name: str
    model: Model
    dtype: str
    kernels: Sequence[Kernel]
    files: Mapping[str, str]


class Backend(Protocol):
    """What a target adds to a package of C; a module is one.

    Attributes:
        NEEDS: names of the kernels that it calls.
    """

    NEEDS: frozenset[str]

    def files(self, package: Package) -> dict[str, str]:
        """Return path and text of its files."""
        ...
