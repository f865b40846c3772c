"""The intermediate form of all kernels: named single assignments, as in SYMORO.

A Tape describes the computation of a kernel: constants of the geometry, then steps `name =
expression` in SymPy symbols, then the outputs. An output is a symbol, its negative, or a number.
symgen prints C from it. NumPy, CasADi and arithmetic modulo a prime run it through `Tape.run`.
Expressions are never expanded.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial, reduce
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen.errors import SymgenError

Symbols = tuple[sp.Symbol, ...]
#: Symbols with their definitions.
Steps = tuple[tuple[sp.Symbol, sp.Expr], ...]
#: Values of symbols: numbers for named lengths, or expressions.
Values = Mapping[sp.Symbol, sp.Expr]


@lru_cache(maxsize=100_000)
def real_symbol(name: str) -> sp.Symbol:
    """Return the symbol of a name. All symbols of a tape and of robot files are real."""
    return sp.Symbol(name, real=True)


@lru_cache(maxsize=100_000)  # SymPy walks the expression at every request
def symbols_in(expr: sp.Expr) -> frozenset[sp.Symbol]:
    """Return the symbols of an expression."""
    if expr.is_Symbol:
        return frozenset((expr,))
    return frozenset().union(*map(symbols_in, expr.args))


class Arithmetic(ABC):
    """Arithmetic operations for running a tape, over any kind of number."""

    @abstractmethod
    def constant(self, value: sp.Expr) -> Any:
        """Return the number for an exact geometric expression."""

    @abstractmethod
    def add(self, a: Any, b: Any) -> Any:
        """Return a + b."""

    def sub(self, a: Any, b: Any) -> Any:
        """Return a - b."""
        return self.add(a, self.neg(b))

    @abstractmethod
    def mul(self, a: Any, b: Any) -> Any:
        """Return a b."""

    @abstractmethod
    def neg(self, a: Any) -> Any:
        """Return -a."""

    @abstractmethod
    def function(self, name: str, argument: Any) -> Any:
        """Return sin, cos, abs, sign, tanh or the inverse of a number."""


class Drawing(Arithmetic):
    """Arithmetic that draws random states."""

    @abstractmethod
    def numbers(self, count: int) -> NDArray[Any]:
        """Draw some numbers."""

    def joint_angle(self, count: int, parts: int) -> Any:  # noqa: ARG002
        """Draw some values of a revolute joint variable, with its 1/parts."""
        return self.numbers(count)


@dataclass(frozen=True)
class Operations:
    """Counts of the scalar operations of a kernel; `sincos` counts the angles, `other` abs and
    tanh.
    """

    mul: int
    add: int
    div: int
    sincos: int
    other: int = 0

    def plus(self, more: Operations, times: int = 1) -> Operations:
        """Return the sum of these and `times` times more operations."""
        pairs = zip(vars(self).values(), vars(more).values(), strict=True)
        return Operations(*(a + times * b for a, b in pairs))


@dataclass(frozen=True)
class Tape:
    """A straight-line program.

    Attributes:
        inputs: the input arrays, each a name and its scalar symbols.
        constants: symbols with their exact value in numbers and named lengths.
        steps: assignments in order; each right-hand side contains earlier symbols.
        outputs: one symbol, negated symbol or number for every output scalar.
    """

    inputs: tuple[tuple[str, Symbols], ...]
    constants: Steps
    steps: Steps
    outputs: tuple[sp.Expr, ...]

    @cached_property
    def order(self) -> Mapping[sp.Symbol, int]:
        """Position of every symbol, which determines the order of terms and factors in output."""
        symbols = [s for _, group in self.inputs for s in group]
        symbols += [s for s, _ in self.constants] + [s for s, _ in self.steps]
        return {s: i for i, s in enumerate(symbols)}

    @cached_property
    def terms(self) -> Callable[[sp.Expr], list[tuple[bool, list[sp.Expr]]]]:
        """Return a function that splits a sum as `terms` does, in the order of this tape."""
        return cache(partial(terms, order=self.order))

    def keep(self, indices: Sequence[int]) -> Tape:
        """Return the tape of some of the outputs, without steps that they do not need."""
        outputs = tuple(self.outputs[i] for i in indices)
        needed = set().union(*map(symbols_in, outputs))
        steps = []
        for symbol, expr in reversed(self.steps):
            if symbol in needed:
                steps.append((symbol, expr))
                needed |= symbols_in(expr)
        constants = tuple((s, e) for s, e in self.constants if s in needed)
        return Tape(self.inputs, constants, tuple(reversed(steps)), outputs)

    def run(self, arithmetic: Arithmetic, inputs: Mapping[str, Sequence[Any]]) -> list[Any]:
        """Evaluate the outputs in some arithmetic.

        Args:
            arithmetic: the number system.
            inputs: the entries of every input array; each is a number or an array of samples.
        """
        known: dict[sp.Symbol, Any] = {}

        def value(expr: sp.Expr) -> Any:
            if expr.is_Symbol:
                return known[expr]
            if expr.is_number:
                return arithmetic.constant(expr)
            if expr.is_Pow and expr.exp == -1:
                return arithmetic.function("inverse", value(expr.base))
            if expr.is_Function:
                return arithmetic.function(expr.func.__name__.lower(), value(expr.args[0]))
            total: Any = None
            for negative, factors in self.terms(expr):
                product = reduce(arithmetic.mul, map(value, factors))
                if total is None:
                    total = arithmetic.neg(product) if negative else product
                else:
                    total = (arithmetic.sub if negative else arithmetic.add)(total, product)
            return total

        for name, symbols in self.inputs:
            known |= zip(symbols, inputs[name], strict=True)
        for symbol, expr in self.constants:
            known[symbol] = arithmetic.constant(expr)
        for symbol, expr in self.steps:
            known[symbol] = value(expr)
        return [value(expr) for expr in self.outputs]

    @cached_property
    def operations(self) -> Operations:
        """Count the operations of one evaluation in C."""
        count = {"mul": 0, "add": 0, "div": 0, "other": 0}
        angles = set()
        for _, expr in self.steps:
            for part in sp.preorder_traversal(expr):
                if part.is_Add:
                    count["add"] += len(part.args) - 1
                elif part.is_Mul:
                    count["mul"] += sum(1 for f in part.args if f is not sp.S.NegativeOne) - 1
                elif part.func in (sp.sin, sp.cos):
                    angles.add(part.args[0])
                elif part.is_Pow and part.exp == -1:
                    count["div"] += 1
                elif part.is_Pow:
                    count["mul"] += int(part.exp) - 1
                elif part.is_Function:
                    count["other"] += 1
        # C contains the argument of sin and cos once for both.
        repeated = len(
            [1 for _, e in self.steps if e.func in (sp.sin, sp.cos) and e.args[0].is_Add]
        )
        shared = len([a for a in angles if a.is_Add])
        return Operations(
            mul=count["mul"],
            add=count["add"] - repeated + shared,
            div=count["div"],
            sincos=len(angles),
            other=count["other"],
        )


def terms(expr: sp.Expr, order: Mapping[sp.Symbol, int]) -> list[tuple[bool, list[sp.Expr]]]:
    """Split a sum into (negative?, factors) in the order of the tape, positive terms first.

    SymPy's order of arguments may change with its version, so it is not used.
    """

    def key(expr: sp.Expr) -> tuple[int, ...]:
        if expr.is_Symbol:
            return (order[expr],)
        return tuple(sorted(order[s] for s in symbols_in(expr)))

    out = []
    for term in sp.Add.make_args(expr):
        number, rest = term.as_coeff_Mul()
        factors = [] if rest is sp.S.One else sorted(_repeated(rest), key=key)
        if number not in (sp.S.One, sp.S.NegativeOne) or not factors:
            factors = [abs(number), *factors]
        out.append((bool(number.is_negative), factors))
    return sorted(out, key=lambda t: (t[0], [key(f) for f in t[1]], len(t[1])))


def _repeated(product: sp.Expr) -> list[sp.Expr]:
    """Return the factors of a product, a square as the same factor twice."""
    factors: list[sp.Expr] = []
    for f in sp.Mul.make_args(product):
        if f.is_Pow and f.exp == -1:
            factors.append(f)
        elif f.is_Pow and not (f.exp.is_Integer and f.exp > 0):
            raise SymgenError(f"a tape cannot hold {f}")
        else:
            factors += [f.base] * int(f.exp) if f.is_Pow else [f]
    return factors


class TapeBuilder:
    """Collects and names the steps of a derivation. It is mutable, and only used during one
    derivation.

    Args:
        reserved: names that steps must not have.
        last: groups of inputs that come last: each group if the derivation reads any of it.
    """

    def __init__(
        self,
        reserved: Iterable[str] = (),
        last: Sequence[Sequence[tuple[str, Symbols]]] = (),
    ) -> None:
        self._last = tuple(last)
        self._constants: dict[sp.Expr, sp.Symbol] = {}
        self._steps: dict[sp.Expr, sp.Symbol] = {}
        self._sums: dict[frozenset[sp.Expr], sp.Symbol] = {}  # the same steps, by their terms
        self._taken = set(reserved)

    def symbol(self, name: str) -> sp.Symbol:
        """Return a real symbol with this name, or with the next free one."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return real_symbol(name)

    def constant(self, name: str, value: sp.Expr) -> sp.Expr:
        """Return a symbol for a constant of the geometry; 0, 1 and -1 stay unchanged."""
        if value in (0, 1, -1):
            return value
        if value.as_coeff_Mul()[0] < 0:
            return -self.constant(name, -value)
        if value not in self._constants:
            own = value.is_Symbol and value.name not in {s.name for s in self._constants.values()}
            symbol = value if own else self.symbol(name)
            self._constants[value] = symbol
        return self._constants[value]

    def name(self, name: str, expr: sp.Expr) -> sp.Expr:
        """Name a step. Numbers, symbols and known expressions get no new name."""
        if expr.is_number or expr.is_Symbol:
            return expr
        known = self._steps.get(expr)
        if known is not None:
            return known
        parts = sp.Add.make_args(expr)
        negated = [-part for part in parts]  # SymPy is slow to make this a sum
        if len(parts) == 1 and negated[0].is_Symbol:
            return expr
        opposite = self._sums.get(frozenset(negated))
        if opposite is not None:
            return -opposite
        symbol = self.symbol(name)
        self._steps[expr] = self._sums[frozenset(parts)] = symbol
        return symbol

    def entry(self, expr: sp.Expr, letter: str, tag: object, *places: int) -> sp.Expr:
        """Name an entry of an array by its letter, its indices counted from 1, and a tag."""
        return self.name(f"{letter}{''.join(str(k + 1) for k in places)}{tag}", expr)

    def tape(
        self, inputs: Iterable[tuple[str, Sequence[sp.Symbol]]], outputs: Sequence[sp.Expr]
    ) -> Tape:
        """Return the tape of the derivation, without dead steps and empty inputs."""
        tape = Tape(
            tuple((name, tuple(symbols)) for name, symbols in inputs if symbols),
            tuple((s, e) for e, s in self._constants.items()),
            tuple((s, e) for e, s in self._steps.items()),
            tuple(outputs),
        ).keep(range(len(outputs)))
        read = {s for e in (*tape.outputs, *(e for _, e in tape.steps)) for s in symbols_in(e)}
        last = (
            group for group in self._last if any(read.intersection(symbols) for _, symbols in group)
        )
        return replace(tape, inputs=(*tape.inputs, *(x for group in last for x in group)))


class Numbers(Arithmetic):
    """Arithmetic of floats, arrays and CasADi expressions: Python's operators.

    Args:
        values: value of every named length.
        functions: sin, cos, abs, sign and tanh for this kind of number.
        number: turns a constant of `digits` digits into this kind of number.
        digits: number of digits of the constants.
    """

    def __init__(
        self,
        values: Values,
        functions: Mapping[str, Callable[[Any], Any]],
        number: Callable[[sp.Expr], Any] = float,
        digits: int = 50,
    ) -> None:
        self.values, self.functions, self.number = values, functions, number
        self.digits = digits
        self._known: dict[sp.Expr, Any] = {}

    def constant(self, value: sp.Expr) -> Any:
        known = self._known.get(value)
        if known is None:
            exact = value.subs(self.values) if symbols_in(value) else value
            known = self._known[value] = self.number(exact.evalf(self.digits))
        return known

    def add(self, a: Any, b: Any) -> Any:
        return a + b

    def sub(self, a: Any, b: Any) -> Any:
        return a - b

    def mul(self, a: Any, b: Any) -> Any:
        return a * b

    def neg(self, a: Any) -> Any:
        return -a

    def function(self, name: str, argument: Any) -> Any:
        return 1 / argument if name == "inverse" else self.functions[name](argument)


class DrawnNumbers(Numbers, Drawing):
    """Numbers with random states of moderate size."""

    @cached_property
    def _draw(self) -> np.random.Generator:
        return np.random.default_rng(0)

    def numbers(self, count: int) -> NDArray[Any]:
        values = self._draw.uniform(-3, 3, count)
        return np.array([self.number(x) for x in values])
