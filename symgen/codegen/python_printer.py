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
        steps = tuple(step for step in tape.steps if step[0] not in done)
        cuts = self._cuts(steps) if self.vocabulary.kept else {}
        for at, (symbol, expr) in enumerate(steps):
            yield self.step(symbol, expr)
            if cuts.get(at):
                values = wrapped([self.word[s] for s in cuts[at]])
                yield from ("kept = [", *(f"    {line}" for line in values), "]")
                yield from ("[", *(f"    {line}" for line in values), f"] = {self.vocabulary.kept}")

    def _cuts(self, steps: Steps) -> dict[int, list[sp.Symbol]]:
        """Return cuts of a long tape: the step before each, and the values that cross it.

        A cut stands where the fewest values cross, at most _LONGEST steps after the one before.
        """
        last: dict[sp.Symbol, int] = {}
        for at, (_, expr) in enumerate(steps):
            last |= dict.fromkeys(expr.free_symbols, at)
        for output in self.tape.outputs:
            last |= dict.fromkeys(output.free_symbols, len(steps))
        computed = [(at, s) for at, (s, expr) in enumerate(steps) if expr not in self.word]
        cuts: dict[int, list[sp.Symbol]] = {}
        begin = 0
        while len(steps) - begin > _LONGEST:
            places = range(begin + _LONGEST // 3, begin + _LONGEST)
            crossing = {at: [s for k, s in computed if k <= at < last[s]] for at in places}
            begin = min(places, key=lambda at: len(crossing[at]))
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
