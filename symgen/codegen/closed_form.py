"""Closed forms of small kernels, as in a textbook.

Running a tape on trigonometric polynomials gives each output in a canonical form. Its terms are
collected by base parameters, then by sines and cosines, and the coefficients are factored. Two
sines or cosines with equal coefficients become a product: cos u + cos v = 2 cos((u+v)/2)
cos((u-v)/2), so 1 + cos(2 u) = 2 cos(u)^2.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import gcd, lcm

import sympy as sp

from symgen.codegen.formula import Call, Factor, Formula, Product, constant_factor, geometric
from symgen.symbolic.tape import Symbols, Tape, real_symbol
from symgen.symbolic.trigonometric import Polynomial, TooLargeError, Trigonometric, common, halves

#: Longest closed form of a kernel, in products; a longer one is printed as a recursion.
LONGEST = 200
_WORK = 12_000  # products of terms for one kernel: limits the time to about 0.1 s
_PLAIN = 12  # largest integer inside parentheses after a common divisor or factor
_PAIRED = 64  # largest number of sines and cosines of a sum to pair
_FACTORED = 24  # terms of the longest polynomial to factor

Motion = dict[int, Fraction]  # a polynomial without sines: packed monomial -> coefficient
Turning = tuple[tuple[int, bool], ...]  # factors cos(phase), or sin(phase) where True


def closed_form(tape: Tape) -> tuple[Formula, ...] | None:
    """Return the outputs of a tape as closed formulas, or None if these are too long."""
    arithmetic = Trigonometric(_WORK)
    inputs = dict(tape.inputs)
    parameters = inputs.get("X", ())
    # Generators in printing order: lengths, parameters, motion.
    lengths = sorted({s.name for _, value in tape.constants for s in value.free_symbols})
    motion = [s for name, group in tape.inputs if name != "X" for s in group]
    for name in lengths:
        arithmetic.variable(real_symbol(name))
    try:
        for _, value in tape.constants:
            arithmetic.constant(value)
        for symbol in (*parameters, *motion):
            arithmetic.variable(symbol)
        values = tape.run(
            arithmetic, {name: [arithmetic.variable(s) for s in g] for name, g in tape.inputs}
        )
        if sum(map(len, values)) > 2 * LONGEST:
            return None
    except TooLargeError:
        return None
    writer = _Writer(arithmetic, parameters)
    forms = tuple(writer.formula(arithmetic.reduced(value)) for value in values)
    return forms if sum(form.size for form in forms) <= LONGEST else None


@dataclass(frozen=True)
class _Writer:
    arithmetic: Trigonometric
    parameters: Symbols

    def formula(self, value: Polynomial) -> Formula:
        """Collect terms by parameters."""
        by: dict[sp.Expr, Polynomial] = {p: {} for p in (None, *self.parameters)}
        for key, c in value.items():
            behind = [g for g, _ in self.arithmetic.powers(key[0]) if g in self.parameters]
            by[behind[0] if behind else None][key] = c
        return Formula(tuple(p for group in by.values() if group for p in self.collected(group)))

    def collected(self, value: Polynomial) -> list[Product]:
        """Collect the column of one parameter by sines and cosines, as one product if possible."""
        turns: dict[Turning, Motion] = {}
        for (m, phase, sine), c in sorted(value.items(), key=lambda term: term[0][::-1]):
            turns.setdefault(((phase, sine),) if phase else (), {})[m] = c
        merged = _paired(turns)
        shared = common({m: 0 for motion in merged.values() for m in motion})
        behind = any(g in self.parameters for g, _ in self.arithmetic.powers(shared))
        taken = shared if behind and len(merged) > 1 else 0
        parts = [self.product(motion, turn, taken) for turn, motion in merged.items()]
        if not taken:
            return _flat(parts) if len(parts) > 1 else parts
        content = _content([sp.Rational(p.number) for p in parts])
        inner = Formula(tuple(_flat([Product(p.number / content, p.factors) for p in parts])))
        return [Product(content, (*self.factors(shared), Factor(inner)))]

    def product(self, motion: Motion, turning: Turning, without: int) -> Product:
        """Return motion/without times sines and cosines, factored."""
        shared = common(motion)
        rest = {m - shared: c for m, c in motion.items()}
        number, sums = self.factored(rest)
        outside = self.factors(shared - without)
        turns = (self.turn(*turn, turning.count(turn)) for turn in dict.fromkeys(turning))
        return Product(number, (*outside, *sums, *turns))

    def factored(self, motion: Motion) -> tuple[sp.Expr, list[Factor]]:
        """Return number and factors of a polynomial that has no monomial divisor."""
        if len(motion) == 1:
            (c,) = motion.values()
            return sp.Rational(c.numerator, c.denominator), []
        values = [sp.Rational(c.numerator, c.denominator) for c in motion.values()]
        content = _content(values)
        whole = {m: c / content for m, c in zip(motion, values, strict=True)}
        if len(motion) > _FACTORED:
            return content, [Factor(self.sum(whole))]
        gens = sorted(
            {g for m in motion for g, _ in self.arithmetic.powers(m)},
            key=self.arithmetic.generators.index,
        )
        exponents = {
            tuple(dict(self.arithmetic.powers(m)).get(g, 0) for g in gens): c
            for m, c in whole.items()
        }
        number, found = sp.Poly.from_dict(exponents, *gens, domain="QQ").factor_list()
        factors = []
        for poly, power in found:
            inner = self.ordered({self.packed(gens, powers): c for powers, c in poly.terms()})
            if any(abs(c) > _PLAIN for c in inner.values()):
                return content, [Factor(self.sum(whole))]
            sign = _sign(list(inner.values()))
            place = len(inner), [self.places(m) for m in inner]
            factor = Factor(self.sum({m: c * sign for m, c in inner.items()}), power)
            factors.append((place, factor))
            number *= sign**power
        return content * number, [f for _, f in sorted(factors, key=lambda pair: pair[0])]

    def sum(self, motion: dict[int, sp.Expr]) -> Formula:
        return Formula(tuple(Product(c, self.factors(m)) for m, c in self.ordered(motion).items()))

    def ordered(self, motion: dict[int, sp.Expr]) -> dict[int, sp.Expr]:
        """Sort terms by their generators, positive terms before negative ones."""

        return {
            m: motion[m]
            for m in sorted(motion, key=lambda m: (bool(motion[m] < 0), self.places(m)))
        }

    def places(self, m: int) -> list[int]:
        """Return the numbers of the generators of a monomial, repeated by their powers."""
        index = self.arithmetic.generators.index
        return [index(g) for g, e in self.arithmetic.powers(m) for _ in range(e)]

    def packed(self, gens: list[sp.Expr], exponents: tuple[int, ...]) -> int:
        out = 0
        for g, e in zip(gens, exponents, strict=True):
            ((key, _),) = self.arithmetic.variable(g).items()
            out += key[0] * e
        return out

    def factors(self, m: int) -> tuple[Factor, ...]:
        """Return the factors of a monomial in the order of the generators."""
        out = []
        powers = self.arithmetic.powers(m)
        for generator, exponent in sorted(powers, key=lambda power: not power[0].is_number):
            factor = constant_factor(generator)
            out.append(Factor(factor.base, factor.power * exponent))
        return tuple(out)

    def turn(self, phase: int, sine: bool, power: int) -> Factor:
        """Return a power of a sine or cosine."""
        angle = sorted(self.arithmetic.multiples(phase), key=lambda part: part[1] < 0)
        argument = Formula(tuple(p for y, k in angle for p in geometric(k * y).products))
        return Factor(Call("sin" if sine else "cos", argument), power)


def _paired(turns: dict[Turning, Motion]) -> dict[Turning, Motion]:
    """Join all pairs with equal or opposite coefficients into products."""
    out = dict(turns)
    while len(out) <= _PAIRED:
        for first, second in combinations(out, 2):
            sign = _ratio(out[first], out[second])
            joined = _joined(first, second, sign) if sign else None
            if joined is not None and joined[1] not in out:
                break
        else:
            return out
        motion = out.pop(first)
        del out[second]
        out[joined[1]] = {m: joined[0] * c for m, c in motion.items()}
    return out


def _ratio(first: Motion, second: Motion) -> int:
    """Return 1 if two polynomials are equal, -1 if they are opposite, else 0."""
    if first == second:
        return 1
    return -1 if first == {m: -c for m, c in second.items()} else 0


def _joined(first: Turning, second: Turning, sign: int) -> tuple[int, Turning] | None:
    """Return number and factors of first + sign second, or None if it is not a product."""
    shared = Counter(first) & Counter(second)
    one, other = (list((Counter(t) - shared).elements()) for t in (first, second))
    if len(one) > 1 or len(other) > 1:
        return None
    (u, sine), (v, odd) = (rest[0] if rest else (0, False) for rest in (one, other))
    both = halves(u, v) if sine == odd else None
    if both is None:
        return None
    number = 2
    if sine:  # sin u + sin v = 2 sin(mean) cos(half difference); a minus swaps the two
        kinds = (True, False) if sign > 0 else (False, True)
    else:  # cos u + cos v = 2 cos cos; a minus gives -2 sin sin
        kinds = (False, False) if sign > 0 else (True, True)
        number *= sign
    out = list(shared.elements())
    for phase, kind in zip(both, kinds, strict=True):
        if phase < 0 and kind:
            number = -number
        out.append((abs(phase), kind))
    return number, tuple(sorted(out, key=lambda t: (t[1], t[0])))


def _content(values: list[sp.Rational]) -> sp.Rational:
    """Return the common divisor of numbers if the quotients are simple, mostly positive ones."""
    out = sp.Rational(gcd(*(int(v.p) for v in values)), lcm(*(int(v.q) for v in values)))
    if any(abs(v / out) > _PLAIN for v in values):
        out = sp.S.One
    return _sign(values) * out


def _sign(values: list[sp.Rational]) -> int:
    return -1 if 2 * sum(bool(v < 0) for v in values) > len(values) else 1


def _flat(parts: list[Product]) -> list[Product]:
    """Expand sums that only a number multiplies."""
    out = []
    for p in parts:
        base = p.factors[0].base if len(p.factors) == 1 and p.factors[0].power == 1 else None
        if isinstance(base, Formula):
            out += [Product(p.number * inner.number, inner.factors) for inner in base.products]
        else:
            out.append(p)
    return sorted(out, key=lambda p: bool(p.number < 0))
