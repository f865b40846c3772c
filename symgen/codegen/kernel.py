"""Kernels: named functions of the model, with a tape and output arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from symgen.symbolic.tape import Tape

#: Input that selects a link. On the tape it is one symbol for each link: 1 if selected, otherwise
#: 0. The number of the first link is 1, or 0 for a free base.
LINK = "link"
#: Scalar inputs.
SCALARS = ("mass",)
#: Inputs that all samples of a batch share.
SHARED = ("X", "g", "load", "offset")


@dataclass(frozen=True)
class Output:
    """One output array of a kernel: name, shape, and the parameter of each column."""

    name: str
    shape: tuple[int, ...]
    columns: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of entries."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Argument:
    """One argument of a kernel.

    Attributes:
        name: name in the interface.
        size: number of entries; for `link`, the number of links.
        read: whether the kernel reads it.
        written: whether the kernel writes it.
        first: for `link`, the number of the first link.
    """

    name: str
    size: int
    read: bool
    written: bool
    first: int = 1

    @property
    def last(self) -> int:
        """For `link`, the number of the last link."""
        return self.first + self.size - 1

    @property
    def link(self) -> bool:
        """Whether it selects a link (a size_t in C)."""
        return self.name == LINK

    @property
    def plain(self) -> bool:
        """Whether it is a scalar, passed by value."""
        return self.link or self.name in SCALARS

    @property
    def shared(self) -> bool:
        """Whether all samples of a batch share it."""
        return self.plain or self.name in SHARED

    def declared(self, real: str, *, batch: bool = False) -> str:
        """Return its C declaration for one sample, with the length of the array.

        Compilers use the length to warn about short arrays.
        """
        if self.plain:
            return f"{'size_t' if self.link else real} {self.name}"
        kind = real if self.written else f"const {real}"
        return f"{kind} *{self.name}" if batch else f"{kind} {self.name}[{self.size}]"


@dataclass(frozen=True)
class Kernel:
    """One function of the model.

    Attributes:
        name: name in the interface, for example energy_regressor.
        doc: description in one line.
        tape: the program. Its outputs are the entries of all arrays, then one number for each
            guard. The result is valid only if all guards are positive.
        outputs: the output arrays.
        guards: for each guard, the message if it is the first one that is not positive.
        batch: whether there is a version for N samples.
        first: number of the first link for its input `link`.
    """

    name: str
    doc: str
    tape: Tape
    outputs: tuple[Output, ...]
    guards: tuple[str, ...] = ()
    batch: bool = True
    first: int = 1

    @property
    def size(self) -> int:
        """Number of entries of all outputs."""
        return sum(output.size for output in self.outputs)

    @cached_property
    def arguments(self) -> tuple[Argument, ...]:
        """The arguments in C: inputs, then outputs. An argument changed in place is both."""
        written = {o.name: o.size for o in self.outputs}
        read = {name: len(symbols) for name, symbols in self.tape.inputs}
        sizes = read | {name: size for name, size in written.items() if name not in read}
        return tuple(
            Argument(n, size, n in read, n in written, self.first) for n, size in sizes.items()
        )

    @property
    def inputs(self) -> tuple[Argument, ...]:
        """The arguments that it reads."""
        return tuple(a for a in self.arguments if a.read)

    @property
    def link(self) -> Argument | None:
        """Its input `link`, or None."""
        return next((a for a in self.arguments if a.link), None)

    @property
    def fallible(self) -> bool:
        """Whether a call can fail; the C function then returns a status."""
        return bool(self.guards or self.link)

    def listed(self, real: str, *, batch: bool = False) -> str:
        """Return the C declarations of the arguments."""
        return ", ".join(a.declared(real, batch=batch) for a in self.arguments)

    def prototypes(self, prefix: str, real: str) -> tuple[str, ...]:
        """Return the C prototypes, for one sample and, if available, for N samples.

        Args:
            prefix: prefix of the function name.
            real: the floating type.
        """
        returns = "int" if self.fallible else "void"
        batch = f"{returns} {prefix}_{self.name}_batch(size_t N, {self.listed(real, batch=True)});"
        single = f"{returns} {prefix}_{self.name}({self.listed(real)});"
        return (single, batch) if self.batch else (single,)

    @cached_property
    def filled(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the entries of all outputs that are not always zero."""
        split = self.split(self.tape.outputs)
        return tuple(tuple(k for k, x in enumerate(part) if x != 0) for _, part in split)

    def split(self, entries: Sequence[Any]) -> Iterator[tuple[Output, Sequence[Any]]]:
        """Yield each output with its part of a flat sequence of entries."""
        begin = 0
        for output in self.outputs:
            yield output, entries[begin : begin + output.size]
            begin += output.size
