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
from symgen.symbolic.tape import Steps, symbols_in

_WIDTH = 88
#: Largest number of steps between two cuts.
_LONGEST = 400


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
        logarithm: text of the logarithm of {value}, which may be 0.
        turned: text of the cosines and sines of {angles}, as two lists; "" if steps call cos and
            sin one by one.
        kept: text of the arrays of the list `kept`, which the compiler of the library computes
            before what follows; "" if it needs no such cuts.
        taken: further names that the text uses; steps must not have them.
    """

    library: str
    absolute: str
    indexed: bool
    selected: str
    inverse: str
    logarithm: str
    turned: str = ""
    kept: str = ""
    taken: tuple[str, ...] = ()


class PythonPrinter(Printer):
    """Writes the body of a kernel in Python."""

    def __init__(self, kernel: Kernel, robot: Robot, vocabulary: Vocabulary) -> None:
        super().__init__(kernel, {}, robot.values(), "double")
        self.vocabulary = vocabulary
        self.guards = kernel.tape.outputs[kernel.size :]
        taken = {vocabulary.library, *vocabulary.taken, *keyword.kwlist}
        for name, symbols in kernel.tape.inputs:
            assert name not in taken
            if not vocabulary.indexed and name not in SCALARS:
                self.word |= {s: s.name for s in symbols}
        for symbol, word in self.word.items():
            if word in taken:
                self.word[symbol] = f"{word}__"

    def step(self, symbol: sp.Symbol, expr: sp.Expr) -> str:
        return f"{self.word[symbol]} = {self.expression(expr)}"

    def expression(self, expr: sp.Expr) -> str:
        if expr.is_Pow and expr.exp == -1 and expr.base in self.guards:
            return self.vocabulary.inverse.format(value=self.factor(expr.base))
        return super().expression(expr)

    def called(self, name: str, argument: sp.Expr) -> str:
        value = self.expression(argument)
        if name == "log":
            return self.vocabulary.logarithm.format(value=value)
        function = self.vocabulary.absolute if name == "fabs" else name
        return f"{self.vocabulary.library}.{function}({value})"

    def lines(self) -> Iterator[str]:
        """Yield the statements between the inputs and the outputs."""
        tape = self.tape
        for name, symbols in tape.inputs:
            for number, symbol in enumerate(symbols if name == LINK else (), self.first):
                selected = self.vocabulary.selected.format(number=number)
                yield f"{self.word[symbol]} = {selected}"
        for symbol, value in tape.constants:
            yield f"{self.word[symbol]} = {literal(value.subs(self.values), self.dtype)}"
        first = yield from self._turns()
        done = {symbol for symbol, _ in first}
        steps = tuple(step for step in tape.steps if step[0] not in done)
        cuts = self._cuts(steps) if self.vocabulary.kept else {}
        for at, (symbol, expr) in enumerate(steps):
            yield self.step(symbol, expr)
            if cuts.get(at):
                values = wrapped([self.word[s] for s in cuts[at]])
                yield from ("kept = [", *values, "]", "[", *values, f"] = {self.vocabulary.kept}")

    def _cuts(self, steps: Steps) -> dict[int, list[sp.Symbol]]:
        """Return cuts of a long tape: the step before each, and the values that cross it.

        A cut stands where the fewest values cross, at most _LONGEST steps after the one before.
        """
        last: dict[sp.Symbol, int] = {}
        for at, expr in enumerate([*(expr for _, expr in steps), *self.tape.outputs]):
            last |= dict.fromkeys(symbols_in(expr), at)
        cuts: dict[int, list[sp.Symbol]] = {}
        begin = 0
        while len(steps) - begin > _LONGEST:
            crossing: dict[int, list[sp.Symbol]] = {}
            for at in range(begin + _LONGEST // 3, begin + _LONGEST, 20):
                crossing[at] = [s for s, expr in steps[: at + 1]
                                if last[s] > at and expr not in self.word]  # fmt: skip
            begin = min(crossing, key=lambda at: len(crossing[at]))
            cuts[begin] = crossing[begin]
        return cuts

    def _turns(self) -> Generator[str, None, Steps]:
        """Yield the steps up to the angles, and the turn of all angles; return these steps."""
        if not self.vocabulary.turned:
            return ()
        self.turning: list[sp.Expr] = []
        first, _ = self.angles("")  # the second is text of C
        for symbol, expr in first:
            yield self.step(symbol, expr)
        if self.turning:
            angles = ", ".join(map(self.expression, self.turning))
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

    def outputs(self) -> Iterator[dict[str, Any]]:
        """Yield name, shape and entries of each output, for a template."""
        read = [a.name for a in self.kernel.inputs]
        for output, entries in self.kernel.split(self.tape.outputs):
            yield {
                "name": output.name + "_out" * (output.name in read),
                "shape": output.shape,
                "size": output.size,
                "entries": list(map(self.expression, entries)),
            }


def wrapped(words: Sequence[str]) -> list[str]:
    """Return the lines of a list."""
    return textwrap.wrap(", ".join(words), _WIDTH)


def docstring(kernel: Kernel) -> list[str]:
    """Return the description of a kernel as lines of a docstring."""
    text = kernel.doc.replace("\\", "/").replace('"""', "'''")
    return textwrap.wrap(text, _WIDTH)
