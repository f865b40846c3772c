"""Trigonometric polynomials: the closed form of what a tape computes, in a canonical form.

A number is a sum of

    c x1^a1 x2^a2 ... cos(k1 y1 + k2 y2 + ...)    or    sin in place of cos

with rational c, generators x (speeds, lengths, parameters, square roots) and angles y. Products of
sines and cosines become sums, as in cos u cos v = (cos(u - v) + cos(u + v))/2. Equal functions
therefore become equal sums, without a search: terms that cancel by sin^2 + cos^2 = 1 or by addition
theorems vanish. The computation stops if it exceeds a bound on its work.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import sympy as sp

from symgen.symbolic.kinematics import cosine_sine
from symgen.symbolic.tape import Arithmetic

_BITS = 16  # of one exponent or multiple: both are packed into integers, which add like vectors
_MASK, _HALF = (1 << _BITS) - 1, 1 << (_BITS - 1)

#: (packed exponents of the generators, packed multiples of the angles, sine?) of a term.
Key = tuple[int, int, bool]
Polynomial = dict[Key, Fraction]


class TooLargeError(Exception):
    """The closed form is longer than allowed, or does not exist in these terms."""


@dataclass
class Trigonometric(Arithmetic):
    """Arithmetic of trigonometric polynomials, for `Tape.run`.

    Attributes:
        work: number of products of terms that may still be taken.
        generators: the generator of each exponent, in the order of appearance.
        angles: the angle of each multiple.
    """

    work: int
    generators: list[sp.Expr] = field(default_factory=list)
    angles: list[sp.Expr] = field(default_factory=list)

    def variable(self, symbol: sp.Expr) -> Polynomial:
        """Return a generator as a number."""
        return {(1 << (_BITS * _index(self.generators, symbol)), 0, False): Fraction(1)}

    def constant(self, value: sp.Expr) -> Polynomial:
        out: Polynomial = {}
        for term in sp.Add.make_args(sp.expand(value)):
            number, rest = term.as_coeff_Mul()
            if not number.is_Rational:
                number, rest = sp.S.One, term
            product: Polynomial = {(0, 0, False): Fraction(int(number.p), int(number.q))}
            for f in sp.Mul.make_args(rest) if rest is not sp.S.One else ():
                product = self.mul(product, self._factor(f))
            out = self.add(out, product)
        return out

    def _factor(self, f: sp.Expr) -> Polynomial:
        if f.func in (sp.sin, sp.cos):
            return self.function(f.func.__name__, self.constant(f.args[0]))
        if f.is_Pow and f.exp.is_Integer and f.exp > 0:
            base = out = self._factor(f.base)
            for _ in range(int(f.exp) - 1):
                out = self.mul(out, base)
            return out
        return self.variable(f)

    def add(self, a: Polynomial, b: Polynomial) -> Polynomial:
        out = dict(a)
        for key, c in b.items():
            _put(out, key, c)
        return out

    def neg(self, a: Polynomial) -> Polynomial:
        return {key: -c for key, c in a.items()}

    def mul(self, a: Polynomial, b: Polynomial) -> Polynomial:
        self.work -= len(a) * len(b)
        if self.work < 0:
            raise TooLargeError
        out: Polynomial = {}
        for (m, u, su), c in a.items():
            for (n, v, sv), d in b.items():
                x, product = m + n, c * d
                if not (u and v):  # one of them is the constant 1 = cos(0)
                    _put(out, (x, u + v, su or sv), product)
                    continue
                half = product / 2
                # The sign of sin(u - v): plus in sin u cos v, minus in cos u sin v.
                _turn(out, x, u - v, su != sv, -half if sv and not su else half)
                _turn(out, x, u + v, su != sv, -half if su and sv else half)
        return out

    def function(self, name: str, argument: Polynomial) -> Polynomial:
        if name in ("sin", "cos"):
            return self._turned(argument, name == "sin")
        if name in ("inverse", "exp", "log"):
            raise TooLargeError  # no polynomial
        function = {"abs": sp.Abs, "sign": sp.sign, "tanh": sp.tanh}[name]
        value = function(self.expression(argument))
        return self.constant(value) if value.is_number else self.variable(value)

    def _turned(self, argument: Polynomial, sine: bool) -> Polynomial:
        phase, constant = 0, sp.S.Zero
        for (m, u, _), c in argument.items():
            if u:
                raise TooLargeError
            one = self._monomial(m)
            number = sp.Rational(c.numerator, c.denominator)
            if (one / sp.pi).is_Rational and cosine_sine(number * one)[0].func is not sp.cos:
                constant += number * one
            elif c.denominator == 1 and m:
                phase += c.numerator << (_BITS * _index(self.angles, one))
            else:
                sign = 1 if c > 0 else -1
                phase += sign << (_BITS * _index(self.angles, abs(number) * one))
        cosine, sinus = (self.constant(e) for e in cosine_sine(constant))
        turned: Polynomial = {}
        other: Polynomial = {}
        _turn(turned, 0, phase, sine, Fraction(1))
        _turn(other, 0, phase, not sine, Fraction(1))
        joined = self.add if sine else self.sub  # s cosine + c sinus, or c cosine - s sinus
        return joined(self.mul(turned, cosine), self.mul(other, sinus))

    def _monomial(self, m: int) -> sp.Expr:
        return sp.Mul(*(g**e for g, e in self.powers(m)))

    def powers(self, m: int) -> list[tuple[sp.Expr, int]]:
        """Return the generators of a monomial with their exponents."""
        out = []
        for generator in self.generators:
            if m & _MASK:
                out.append((generator, m & _MASK))
            m >>= _BITS
        return out

    def multiples(self, phase: int) -> list[tuple[sp.Expr, int]]:
        """Return the angles of a phase with their multiples."""
        out = []
        for angle in self.angles:
            k = ((phase + _HALF) & _MASK) - _HALF
            if k:
                out.append((angle, k))
            phase = (phase - k) >> _BITS
        return out

    def reduced(self, a: Polynomial) -> Polynomial:
        """Return the same number without squares of square roots."""
        squares = {
            i: Fraction(int((g**2).p), int((g**2).q))
            for i, g in enumerate(self.generators)
            if g.is_Pow and (g**2).is_Rational
        }
        out: Polynomial = {}
        for (m, u, sine), c in a.items():
            for i, square in squares.items():
                pairs = ((m >> (_BITS * i)) & _MASK) // 2
                m -= (2 * pairs) << (_BITS * i)
                c *= square**pairs
            _put(out, (m, u, sine), c)
        return out

    def expression(self, a: Polynomial) -> sp.Expr:
        """Return the number in SymPy."""
        out = sp.S.Zero
        for (m, u, sine), c in a.items():
            angle = sp.Add(*(k * y for y, k in self.multiples(u)))
            turn = sp.sin(angle) if sine else sp.cos(angle)
            out += sp.Rational(c.numerator, c.denominator) * self._monomial(m) * turn
        return out


def halves(u: int, v: int) -> tuple[int, int] | None:
    """Return (u + v)/2 and (u - v)/2 if both are whole multiples of the angles, else None."""
    total = u + v
    rest = total
    while rest:
        k = ((rest + _HALF) & _MASK) - _HALF
        if k % 2:
            return None
        rest = (rest - k) >> _BITS
    return total // 2, (u - v) // 2


def common(monomials: Mapping[int, object]) -> int:
    """Return the greatest common divisor of monomials."""
    out, shift = 0, 0
    rest = list(monomials)
    while all(rest):
        out |= min(m & _MASK for m in rest) << shift
        rest, shift = [m >> _BITS for m in rest], shift + _BITS
    return out


def _turn(out: Polynomial, m: int, phase: int, sine: bool, c: Fraction) -> None:
    """Add c m cos(phase) or c m sin(phase); the last angle of a phase counts positive."""
    if phase < 0:
        phase, c = -phase, -c if sine else c
    if phase or not sine:
        _put(out, (m, phase, sine), c)


def _put(out: Polynomial, key: Key, c: Fraction) -> None:
    total = out[key] + c if key in out else c
    if total:
        out[key] = total
    else:
        out.pop(key, None)


def _index(known: list[sp.Expr], expr: sp.Expr) -> int:
    if expr not in known:
        known.append(expr)
    return known.index(expr)
