"""Backends: each writes a model as the files of one kind of program, over the same C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from symgen.codegen.kernels import LINK, SCALARS, SHARED, Kernel
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


@dataclass(frozen=True)
class Input:
    """What goes into a kernel, as other languages see it.

    Attributes:
        name: as in C.
        size: entries; those of a whole X, of which some kernels read the first only.
        link: whether it is the number of a joint.
        plain: whether it is one number, passed by value.
        shared: whether all samples have it in common.
        changed: whether the kernel writes it, too.
    """

    name: str
    size: int
    link: bool
    plain: bool
    shared: bool
    changed: bool


def inputs_of(kernel: Kernel, parameters: int) -> list[Input]:
    """Return the inputs of a kernel of a model with so many parameters."""
    written = {output.name for output in kernel.outputs}
    out = []
    for name, symbols in kernel.tape.inputs:
        link, plain = name == LINK, name == LINK or name in SCALARS
        size = 1 if plain else parameters if name == "X" else len(symbols)
        shared = plain or name in SHARED or not kernel.batch
        out.append(Input(name, size, link, plain, shared, name in written))
    return out


class Backend(Protocol):
    """What a target adds to a package of C; a module is one.

    Attributes:
        NEEDS: names of the kernels that it calls.
    """

    NEEDS: frozenset[str]

    def files(self, package: Package) -> dict[str, str]:
        """Return path and text of its files."""
        ...
