"""Exact arithmetic modulo a prime, for the proof of ranks and relations.

A geometric constant is an element of Q(symbols, sqrt(2), cos(angle), ...). Modulo a prime p it
becomes an integer. Lengths are random integers, or the rationals of the file. An angle is a sum of
rational multiples of generators. Each generator x is one random unit z = e^(ix), so that cos x = (z
+ 1/z)/2 and sin x = (z - 1/z)/(2i). Commensurable angles thereby share one point of the circle.
Fractions of pi are roots of unity, with p = 1 modulo the order needed. Generators that are
independent over the rationals have algebraically independent exponentials (Lindemann and
Weierstrass). A random point is therefore the right model.

A rank modulo p is never larger than the true one. It is smaller with a probability of about
degree/p (Schwartz and Zippel), about 1e-8 for each prime if angles are fractions of pi. Decimal
angles raise the degree; `guard` checks the result in floating point.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen.errors import SymgenError
from symgen.symbolic.tape import Drawing

Residues = NDArray[np.int64]
_BITS = 31  # products of two residues fit in 64 bits
_TWELFTH = 48  # k pi/24 is a power of e^(2 pi i/48)


class BadDrawError(SymgenError):
    """A random point makes a denominator zero or a radicand a non-residue; draw another one."""


class _Constant(int):
    """A residue with its exact expression, which is needed for the cosine and sine of an angle."""

    expr: sp.Expr


@dataclass(frozen=True, eq=False)
class JointAngle:
    """Random values of a revolute joint variable: numbers, and the units e^(iq) or None.

    `root` is e^(iq/parts). Fractions of the angle are powers of it; other multiples have a number
    only.
    """

    number: NDArray[Any]
    unit: Any
    root: Residues | None = None
    parts: int = 1


class PrimeField(Drawing):
    """Integers modulo p, with a fixed random value for every geometric symbol and angle.

    Args:
        prime: p, with p - 1 a multiple of `order`.
        seed: seed of the random values.
        angles: all constant angles of the computation. They determine the generators.
        order: order of the roots of unity, from `order_needed(angles)`.
    """

    def __init__(
        self,
        prime: int,
        seed: int,
        angles: Iterable[sp.Expr] = (),
        order: int = _TWELFTH,
    ) -> None:
        self.p, self.order = prime, order
        self._random = random.Random(f"{seed} {prime}")
        self._constants: dict[sp.Expr, _Constant] = {}
        self._numbers: dict[sp.Expr, int] = {}
        self._root = self._primitive_root_of_unity()
        self._half = pow(2, -1, prime)
        self._half_i = pow(2 * pow(self._root, order // 4, prime), -1, prime)
        self._unit: dict[sp.Expr, sp.Rational] = {}
        for angle in angles:
            for number, base in _angle_terms(angle):
                known = self._unit.get(base, sp.S.Zero)
                # formulas may contain half an angle
                self._unit[base] = _rational_gcd(known, number / 2)
        self._z = {base: self._random.randrange(2, prime) for base in self._unit}

    def _primitive_root_of_unity(self) -> int:
        factors = list(sp.factorint(self.order))
        while True:
            z = pow(self._random.randrange(2, self.p), (self.p - 1) // self.order, self.p)
            if all(pow(z, self.order // f, self.p) != 1 for f in factors):
                return z

    # The operations of a tape, on int64 arrays of residues or plain integers.

    def constant(self, value: sp.Expr) -> int:
        """Return the residue of an exact geometric expression."""
        known = self._constants.get(value)
        if known is None:
            known = _Constant(self._evaluate(value) % self.p)
            known.expr = value
            self._constants[value] = known
        return known

    def add(self, a: Any, b: Any) -> Any:
        if isinstance(a, JointAngle):
            return self._turned(a, b)
        if isinstance(b, JointAngle):
            return self._turned(b, a)
        return (a + b) % self.p

    def mul(self, a: Any, b: Any) -> Any:
        if isinstance(b, JointAngle):
            a, b = b, a
        if isinstance(a, JointAngle):
            return self._multiple(a, b)
        return (a * b) % self.p

    def neg(self, a: Any) -> Any:
        if isinstance(a, JointAngle):
            return self._multiple(a, self.constant(sp.S.NegativeOne))
        if isinstance(a, _Constant):
            return self.constant(-a.expr)
        return (-a) % self.p

    def function(self, name: str, argument: Any) -> Any:
        unit = argument.unit if isinstance(argument, JointAngle) else None
        if unit is not None and name in ("sin", "cos"):
            c, s = self._cosine_sine(unit)
            return c if name == "cos" else s
        raise SymgenError(f"{name} has no exact value modulo a prime")

    def joint_angle(self, count: int, parts: int) -> JointAngle:
        number, root = self.numbers(count), self.numbers(count)
        return JointAngle(number, self._power(root, parts), root, parts)

    def numbers(self, count: int) -> Residues:
        """Draw `count` random nonzero residues."""
        return np.array([self._random.randrange(1, self.p) for _ in range(count)], dtype=np.int64)

    def _turned(self, angle: JointAngle, other: Any) -> Any:
        """Return angle + other; it is an angle if `other` is an angle or a constant."""
        if not isinstance(other, JointAngle | _Constant):
            return (angle.number + other) % self.p
        unit: Any = None
        if isinstance(other, _Constant):
            number: Any = int(other)
            if angle.unit is not None and self._is_angle(other.expr):
                unit = angle.unit * self._e_i(other.expr) % self.p
        else:
            number = other.number
            if angle.unit is not None and other.unit is not None:
                unit = angle.unit * other.unit % self.p
        return JointAngle((angle.number + number) % self.p, unit)

    def _multiple(self, angle: JointAngle, factor: Any) -> Any:
        """Return factor times angle; it is an angle if the factor is a fraction of its parts."""
        number = angle.number * factor % self.p
        if not isinstance(factor, _Constant):
            return number
        unit = None
        if factor.expr.is_Integer and angle.unit is not None:
            unit = self._power(angle.unit, int(factor.expr))
        elif angle.root is not None and (factor.expr * angle.parts).is_Integer:
            unit = self._power(angle.root, int(factor.expr * angle.parts))
        return JointAngle(number, unit)

    def _power(self, units: Residues, exponent: int) -> Residues:
        if exponent == 1:
            return units
        return np.array([pow(int(z), exponent, self.p) for z in units], dtype=np.int64)

    def _cosine_sine(self, z: Any) -> tuple[Any, Any]:
        """Return (z + 1/z)/2 and (z - 1/z)/(2i)."""
        if isinstance(z, int):
            inverse: Any = pow(z, -1, self.p)
        else:
            inverse = np.array([pow(int(x), -1, self.p) for x in z], dtype=np.int64)
        return (z + inverse) * self._half % self.p, (z - inverse) * self._half_i % self.p

    def _is_angle(self, expr: sp.Expr) -> bool:
        """Return whether a constant is a sum of angles of the geometry; a length is not."""
        return all(
            base is sp.pi or (base in self._unit and (number / self._unit[base]).is_Integer)
            for number, base in _angle_terms(expr)
        )

    def _e_i(self, angle: sp.Expr) -> int:
        """Return e^(i angle) of a constant angle: a product of powers of the units."""
        z = 1
        for number, base in _angle_terms(angle):
            if base is sp.pi:
                turns = number * self.order / 2
                z = z * pow(self._root, int(turns) % self.order, self.p) % self.p
            else:
                power = number / self._unit[base]
                if not power.is_Integer:
                    raise SymgenError(f"the angle {angle} does not belong to this geometry")
                z = z * pow(self._z[base], int(power) % (self.p - 1), self.p) % self.p
        return z

    def _evaluate(self, e: sp.Expr) -> int:
        p = self.p
        if e.is_Rational:
            return int(e.p) * self._inverse(int(e.q))
        if e.is_Symbol or e is sp.pi:  # outside sin and cos, pi is transcendental like a length
            if e not in self._numbers:
                self._numbers[e] = self._random.randrange(1, p)
            return self._numbers[e]
        if e.is_Add:
            return sum(self._evaluate(a) for a in e.args) % p
        if e.is_Mul:
            return math.prod(map(self._evaluate, e.args)) % p
        if e.is_Pow and (2 * e.exp).is_Integer:
            whole = e.exp.is_Integer
            base = self._evaluate(e.base) if whole else self._square_root(e.base)
            exponent = int(e.exp if whole else 2 * e.exp)
            return pow(base if exponent > 0 else self._inverse(base), abs(exponent), p)
        if e.func in (sp.cos, sp.sin, sp.tan):
            c, s = self._cosine_sine(self._e_i(e.args[0]))
            return int(c if e.func is sp.cos else s if e.func is sp.sin else s * self._inverse(c))
        raise SymgenError(f"{e} has no exact value modulo a prime")

    def _inverse(self, a: int) -> int:
        if a % self.p == 0:
            raise BadDrawError("a denominator vanishes at this point")
        return pow(int(a), -1, self.p)

    def _square_root(self, e: sp.Expr) -> int:
        if not e.is_Rational:
            return self._residue_root(self._evaluate(e))
        root = 1
        for factor, power in sp.factorint(int(e.p * e.q)).items():
            if power % 2:
                root = root * self._prime_root(int(factor)) % self.p
            root = root * pow(int(factor), power // 2, self.p) % self.p
        return root * self._inverse(int(e.q)) % self.p

    def _prime_root(self, factor: int) -> int:
        """Return a square root of a prime, consistent with the roots of unity that contain it.

        The roots of 2 and 3 are cosines. For an odd prime f of the order, Gauss's sum over the f-th
        roots of unity gives the root: its square is f, or -f if f = 3 modulo 4.
        """
        if factor in (2, 3):
            angle = sp.pi / (4 if factor == 2 else 6)
            return int(2 * self._cosine_sine(self._e_i(angle))[0] % self.p)
        if self.order % factor == 0:
            z = pow(self._root, self.order // factor, self.p)
            total = sum(
                (1 if pow(a, (factor - 1) // 2, factor) == 1 else -1) * pow(z, a, self.p)
                for a in range(1, factor)
            )
            if factor % 4 == 3:
                total *= pow(self._root, 3 * self.order // 4, self.p)  # times -i
            return total % self.p
        key = sp.Integer(factor)
        if key not in self._numbers:
            self._numbers[key] = self._residue_root(factor)
        return self._numbers[key]

    def _residue_root(self, a: int) -> int:
        root = sp.sqrt_mod(a, self.p)
        if root is None:
            raise BadDrawError("not a quadratic residue at this point")
        return int(root)


def _angle_terms(angle: sp.Expr) -> list[tuple[sp.Rational, sp.Expr]]:
    """Split an angle into rational multiples of generators: pi, 1, and monomials of symbols."""
    terms = (term.as_coeff_Mul() for term in sp.Add.make_args(sp.expand(angle)))
    return [(number, base) for number, base in terms if number]


def _rational_gcd(a: sp.Rational, b: sp.Rational) -> sp.Rational:
    """Return the largest rational of which both are integer multiples."""
    return sp.Rational(math.gcd(int(a.p * b.q), int(b.p * a.q)), int(a.q * b.q))


def order_needed(angles: Iterable[sp.Expr]) -> int:
    """Return the order of the roots of unity that the fractions of pi in some angles need."""
    order = _TWELFTH
    for angle in angles:
        for number, base in _angle_terms(angle):
            if base is sp.pi:
                order = math.lcm(order, 2 * int(number.q))
    if order > 10**6:
        raise SymgenError("an angle is a fraction of pi with too large a denominator")
    return order


def primes(order: int) -> Iterator[int]:
    """Yield the primes under 2^31 that are 1 modulo `order`, the largest first."""
    candidate = (2**_BITS - 2) // order * order + 1
    while candidate > 2 ** (_BITS - 1):
        if sp.isprime(candidate):
            yield candidate
        candidate -= order


def reduce_rows(matrix: Residues, p: int) -> tuple[list[int], Residues]:
    """Gauss-Jordan elimination modulo p, from the first column to the last.

    Returns:
        The pivot columns, and the reduced rows. Each column contains the coefficients of the pivot
        columns in it.
    """
    m = np.array(matrix, dtype=np.int64) % p
    pivots: list[int] = []
    for column in range(m.shape[1]):
        row = len(pivots)
        nonzero = np.flatnonzero(m[row:, column])
        if nonzero.size == 0:
            continue
        m[[row, row + int(nonzero[0])]] = m[[row + int(nonzero[0]), row]]
        m[row] = m[row] * pow(int(m[row, column]), -1, p) % p
        factors = p - m[:, column]
        factors[row] = 0
        m = (m + factors[:, None] * m[row]) % p  # below 2^62 + 2^31
        pivots.append(column)
    return pivots, m[: len(pivots)]


def rational(residues: Sequence[int], moduli: Sequence[int]) -> sp.Rational | None:
    """Return the small rational that has these residues (Wang), or None.

    A coefficient that depends on random values of symbols has unrelated residues. Its
    reconstruction from all primes then has no small numerator and denominator.
    """
    product, value = 1, 0
    for r, p in zip(residues, moduli, strict=True):  # Chinese remainders
        value += product * ((r - value) * pow(product, -1, p) % p)
        product *= p
    # with half of the bits, a rational would fit by chance
    bound = 1 << (product.bit_length() // 3)
    a, b, u, v = product, value, 0, 1
    while b > bound:
        q = a // b
        a, b, u, v = b, a - q * b, v, u - q * v
    if v == 0 or abs(v) > bound:
        return None
    return sp.Rational(b, v)
