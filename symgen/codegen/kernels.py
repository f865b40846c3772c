"""What a kernel is: a named function of the model, its tape, and the arrays that it writes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.tape import Tape

#: Input that is the number of a link; on the tape, one symbol for each link: 1 at its own, else 0.
LINK = "link"
#: Inputs that are plain numbers.
SCALARS = ("mass",)
#: Arrays that all samples of a batch share.
SHARED = ("X", "g")


@dataclass(frozen=True)
class Output:
    """One array that a kernel writes: name, shape, and the parameter behind each column."""

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
        name: as the contract has it.
        size: number of entries; of `link`, the number of links.
        read: whether the kernel reads it.
        written: whether the kernel writes it.
    """

    name: str
    size: int
    read: bool
    written: bool

    @property
    def link(self) -> bool:
        """Whether it is the number of a link, in C a size_t."""
        return self.name == LINK

    @property
    def plain(self) -> bool:
        """Whether it is one number, passed by value."""
        return self.link or self.name in SCALARS

    @property
    def shared(self) -> bool:
        """Whether all samples of a batch have it in common."""
        return self.plain or self.name in SHARED

    def declared(self, real: str, *, batch: bool = False) -> str:
        """Return its declaration in C, an array of one sample with its length.

        Compilers then warn of a short one.
        """
        if self.plain:
            return f"{'size_t' if self.link else real} {self.name}"
        kind = real if self.written else f"const {real}"
        return f"{kind} *{self.name}" if batch else f"{kind} {self.name}[{self.size}]"


@dataclass(frozen=True)
class Kernel:
    """One function of the model.

    Attributes:
        name: the contract's name, for example energy_regressor.
        doc: what it computes, in a line.
        tape: the program; its outputs are those of all arrays, one after the other, then `guards`
            numbers that must be positive for the result to have a meaning.
        outputs: the arrays it writes.
        guards: how many.
        batch: whether there is a form for N samples at once.
    """

    name: str
    doc: str
    tape: Tape
    outputs: tuple[Output, ...]
    guards: int = 0
    batch: bool = True

    @property
    def size(self) -> int:
        """Number of entries of all outputs."""
        return sum(output.size for output in self.outputs)

    @cached_property
    def arguments(self) -> tuple[Argument, ...]:
        """Its arguments in C: inputs, then outputs; what is changed in place is both."""
        written = {o.name: o.size for o in self.outputs}
        read = {name: len(symbols) for name, symbols in self.tape.inputs}
        sizes = read | {name: size for name, size in written.items() if name not in read}
        return tuple(Argument(n, size, n in read, n in written) for n, size in sizes.items())

    @property
    def inputs(self) -> tuple[Argument, ...]:
        """Those of its arguments that it reads."""
        return tuple(a for a in self.arguments if a.read)

    @property
    def links(self) -> int:
        """Number of links that its input `link` chooses from; 0 where it has no such input."""
        return next((a.size for a in self.arguments if a.link), 0)

    @property
    def fallible(self) -> bool:
        """Whether a call can fail: in C the kernel returns a status then."""
        return bool(self.guards or self.links)

    def listed(self, real: str, *, batch: bool = False) -> str:
        """Return how C declares its arguments."""
        return ", ".join(a.declared(real, batch=batch) for a in self.arguments)

    def prototypes(self, prefix: str, real: str) -> tuple[str, ...]:
        """Return how C declares it: for one sample, and for N where it has such a form.

        Args:
            prefix: of the function's name.
            real: the floating type.
        """
        returns = "int" if self.fallible else "void"
        batch = f"{returns} {prefix}_{self.name}_batch(size_t N, {self.listed(real, batch=True)});"
        single = f"{returns} {prefix}_{self.name}({self.listed(real)});"
        return (single, batch) if self.batch else (single,)

    @cached_property
    def filled(self) -> tuple[tuple[int, ...], ...]:
        """Entries of each output, counted through, that are not zero whatever comes in."""
        split = self.split(self.tape.outputs)
        return tuple(tuple(k for k, x in enumerate(part) if x != 0) for _, part in split)

    def split(self, entries: Sequence[Any]) -> Iterator[tuple[Output, Sequence[Any]]]:
        """Yield each output with its share of entries that stand one after the other."""
        begin = 0
        for output in self.outputs:
            yield output, entries[begin : begin + output.size]
            begin += output.size


#: What identification by energy needs.
ENERGY = ("energy_regressor", "friction_power")


def regrouped(
    base: BaseParameters, standard: Sequence[float], numbers: dict[sp.Symbol, sp.Expr]
) -> list[float]:
    """Return base parameters X from standard ones: X_b = X_head + sum of c X_d."""
    value = dict(zip((p.name for p in base.standard), standard, strict=True))
    return [
        value[p.head] + sum(float(c.subs(numbers).evalf(30)) * value[name] for c, name in p.terms)
        for p in base.parameters
    ]
