"""Vectors, twists and wrenches, and their change of frame under elementary motions.

The modified Denavit-Hartenberg transform is a product of elementary motions along and about z and
x. A twist (w, V) of a frame behind such a motion is (R^T w, R^T (V + w x P)). A wrench transforms
in the opposite direction: a force f and its moment n change as w and V do under the opposite
motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.symbolic.constraints import ByJoint
from symgen.symbolic.tape import TapeBuilder

Vector = tuple[sp.Expr, ...]
Matrix = tuple[Vector, ...]
#: A twist or screw, angular part first; or a wrench or momentum, force or linear part first.
Screw = tuple[Vector, Vector]


def vector(entry: Callable[[int], sp.Expr]) -> Vector:
    """Return the vector with these entries."""
    return tuple(entry(i) for i in range(3))


def matrix(entry: Callable[[int, int], sp.Expr]) -> Matrix:
    """Return the matrix (3, 3) with these entries."""
    return tuple(vector(lambda k, i=i: entry(i, k)) for i in range(3))  # type: ignore[misc]


def symmetric(entries: Mapping[tuple[int, int], sp.Expr]) -> Matrix:
    """Return the symmetric matrix (3, 3) with these entries on one side; others are zero."""
    return matrix(lambda i, k: entries.get((i, k), entries.get((k, i), sp.S.Zero)))


#: Positions in a symmetric matrix, in the order XX XY XZ YY YZ ZZ.
UPPER = tuple((i, k) for i in range(3) for k in range(i, 3))


def unit_vector(axis: int) -> Vector:
    """Return the unit vector of an axis."""
    return vector(lambda i: sp.Integer(int(i == axis)))


ZERO: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
Z = unit_vector(2)


def axis(sigma: int) -> Screw:
    """Return the screw of a joint in the frame of the joint: a turn about z, a shift along it, or
    0.
    """
    return Z if sigma == names.REVOLUTE else ZERO, Z if sigma == names.PRISMATIC else ZERO


def product(x: sp.Expr, y: sp.Expr) -> sp.Expr:
    """Return x y."""
    # Skipping zeros takes half the time: many entries are zero, and SymPy is slow with them too.
    return sp.S.Zero if x is sp.S.Zero or y is sp.S.Zero else sp.Mul(x, y)


def dot(a: Sequence[sp.Expr], b: Sequence[sp.Expr]) -> sp.Expr:
    """Return a . b."""
    return sp.Add(*map(product, a, b))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""

    def entry(i: int, k: int) -> sp.Expr:
        return sp.Add(product(a[i], b[k]), -product(a[k], b[i]))

    return entry(1, 2), entry(2, 0), entry(0, 1)


def plus(*vectors: Vector) -> Vector:
    """Return the sum of vectors."""
    return tuple(sp.Add(*entries) for entries in zip(*vectors, strict=True))


def scaled(factor: sp.Expr, a: Sequence[sp.Expr]) -> Vector:
    """Return factor times a."""
    return tuple(product(factor, x) for x in a)


def matvec(a: Matrix, b: Vector) -> Vector:
    """Return the product of a matrix and a vector."""
    return tuple(dot(row, b) for row in a)


def transposed(a: Sequence[Sequence[sp.Expr]]) -> Matrix:
    """Return a matrix with its rows as columns."""
    return tuple(zip(*a, strict=True))


def named(a: Sequence[sp.Expr], name: str, tape: TapeBuilder) -> Vector:
    """Name the components of a vector."""
    return tuple(tape.entry(x, name, "", i) for i, x in enumerate(a))


def screw_rate(screw: Screw, twist: Screw) -> Screw:
    """Return twist x screw, the rate of a screw that moves with a twist."""
    (e, v), (w, V) = screw, twist
    return cross(w, e), plus(cross(w, v), cross(V, e))


def acting(wrench: Screw, screw: Screw) -> sp.Expr:
    """Return the power of a wrench on a screw: e . n + v . f."""
    (f, n), (e, v) = wrench, screw
    return dot(e, n) + dot(v, f)


@dataclass(frozen=True)
class Turn:
    """A rotation about x (axis 0) or z (axis 2) by an angle with this cosine and sine."""

    axis: int
    c: sp.Expr
    s: sp.Expr
    tag: str

    @property
    def back(self) -> Turn:
        """The opposite rotation."""
        return Turn(self.axis, self.c, -self.s, self.tag)


@dataclass(frozen=True)
class Shift:
    """A translation along x (axis 0) or z (axis 2), m."""

    axis: int
    length: sp.Expr
    tag: str

    @property
    def back(self) -> Shift:
        """The opposite translation."""
        return Shift(self.axis, -self.length, self.tag)


def around(axis: int) -> tuple[int, int]:
    """Return the two axes that follow an axis."""
    return (axis + 1) % 3, (axis + 2) % 3


def replaced(a: Vector, entries: ByJoint) -> Vector:
    """Return a vector with some entries replaced."""
    return vector(lambda i: entries.get(i, a[i]))


def turned(v: Vector, turn: Turn, letter: str, tape: TapeBuilder) -> Vector:
    """Express a vector in the turned frame."""
    a, b = around(turn.axis)
    new = {a: dot((turn.c, turn.s), (v[a], v[b])), b: dot((turn.c, -turn.s), (v[b], v[a]))}
    return _renamed(v, new, letter, turn.tag, tape)


def shift_moment(moment: Vector, v: Vector, shift: Shift, letter: str, tape: TapeBuilder) -> Vector:
    """Return moment + v x P: the velocity of the shifted origin, for (V, w)."""
    a, b = around(shift.axis)
    new = {a: moment[a] + v[b] * shift.length, b: moment[b] - v[a] * shift.length}
    return _renamed(moment, new, letter, shift.tag, tape)


def _renamed(a: Vector, new: ByJoint, letter: str, tag: str, tape: TapeBuilder) -> Vector:
    """Replace entries of a vector by steps with a name."""
    return replaced(a, {i: tape.entry(x, letter, tag, i) for i, x in new.items()})


def onward(twist: Screw, motion: Turn | Shift, letters: Sequence[str], tape: TapeBuilder) -> Screw:
    """Express a twist in the frame after an elementary motion, or a wrench in the one before."""
    (w, V), (first, second) = twist, letters
    if isinstance(motion, Turn):
        return turned(w, motion, first, tape), turned(V, motion, second, tape)
    return w, shift_moment(V, w, motion, second, tape)
