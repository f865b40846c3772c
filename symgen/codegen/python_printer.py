"""Print a tape as Python, in the words of a library of numbers."""

from __future__ import annotations

import keyword
import textwrap
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import Printer, literal
from symgen.codegen.kernel import LINK, SCALARS, Kernel
from symgen.robot.types import Robot
from symgen.symbolic.tape import Steps, Symbols

_WIDTH = 88


@dataclass(frozen=True)
class Vocabulary:
    """How a library writes what a tape needs.

    Attributes:
        library: its name in the text, before the names of its functions.
        absolute: its function of absolute values.
        indexed: whether the text reads entries of inputs by index. Otherwise an entry has the name
            that it has on the tape.
        selected: text that is 1 if the input `link` is {number}, otherwise 0.
        inverse: text of the inverse of {value}, a number that a guard requires to be positive.
        turned: text of the cosines and sines of {angles}, as two lists; "" if steps call cos and
            sin one by one.
        taken: further names that the text uses; steps must not have them.
    """

    library: str
    absolute: str
    indexed: bool
    selected: str
    inverse: str
    turned: str = ""
    taken: tuple[str, ...] = ()


class PythonPrinter(Printer):
    """Writes the body of a kernel in Python."""

    def __init__(self, kernel: Kernel, robot: Robot, vocabulary: Vocabulary) -> None:
        super().__init__(kernel, {}, robot.values(), "double")
        self.vocabulary = vocabulary
        self.guards = kernel.tape.outputs[kernel.size :]
        taken = {vocabulary.library, *vocabulary.taken, *keyword.kwlist}
        given = {name for name, _ in kernel.tape.inputs}
        if not vocabulary.indexed:
            for name, symbols in kernel.tape.inputs:
                if name not in SCALARS:
                    self.word |= {s: s.name for s in symbols}
        for symbol, word in self.word.items():
            if word in taken:
                self.word[symbol] = f"{word}__"
        assert not given & taken

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        return f"{self.word[symbol]} = {self.expression(expr)}"

    def expression(self, expr: sp.Expr) -> str:
        if expr.is_Pow and expr.exp == -1 and expr.base in self.guards:
            return self.vocabulary.inverse.format(value=self.factor(expr.base))
        return super().expression(expr)

    def called(self, name: str, argument: sp.Expr) -> str:
        function = self.vocabulary.absolute if name == "fabs" else name
        return f"{self.vocabulary.library}.{function}({self.expression(argument)})"

    def lines(self) -> Iterator[str]:
        """Yield the statements between the inputs and the outputs."""
        tape = self.tape
        for name, symbols in tape.inputs:
            if name == LINK:
                yield from self._selections(symbols)
        for symbol, value in tape.constants:
            yield f"{self.word[symbol]} = {literal(value.subs(self.values), self.dtype)}"
        first = yield from self._turns()
        done = {symbol for symbol, _ in first}
        for symbol, expr in tape.steps:
            if symbol not in done:
                yield self.step(symbol, expr)

    def _turns(self) -> Generator[str, None, Steps]:
        """Yield the steps up to the angles, and the turn of all angles; return these steps."""
        if not self.vocabulary.turned:
            return ()
        self.turning: list[sp.Expr] = []
        first, _ = self.angles("")  # the second is text of C
        for symbol, expr in first:
            yield self.step(symbol, expr)
        angles = ", ".join(self.expression(a) for a in self.turning)
        if angles:
            yield f"cosines, sines = {self.vocabulary.turned.format(angles=angles)}"
        return first

    def turned(
        self, _prefix: str, angles: Sequence[sp.Expr], _name: str, _start: int
    ) -> Iterator[str]:
        for at, angle in enumerate(angles, len(self.turning)):
            self.word[sp.cos(angle)] = f"cosines[{at}]"
            self.word[sp.sin(angle)] = f"sines[{at}]"
        self.turning += angles
        return iter(())

    def _selections(self, links: Symbols) -> Iterator[str]:
        for number, symbol in enumerate(links, 1):
            yield f"{self.word[symbol]} = {self.vocabulary.selected.format(number=number)}"

    def outputs(self) -> Iterator[dict[str, Any]]:
        """Yield name, shape and entries of each output, for a template."""
        read = {a.name for a in self.kernel.inputs}
        for output, entries in self.kernel.split(self.tape.outputs):
            yield {
                "name": f"{output.name}_out" if output.name in read else output.name,
                "shape": output.shape,
                "size": output.size,
                "entries": [self.expression(e) for e in entries],
            }


def wrapped(words: Sequence[str]) -> list[str]:
    """Return the lines of a list."""
    return textwrap.wrap(", ".join(words), _WIDTH)


def docstring(kernel: Kernel) -> list[str]:
    """Return the description of a kernel as lines of a docstring."""
    text = kernel.doc.replace("\\", "/").replace('"""', "'''")
    return textwrap.wrap(text, _WIDTH)
