"""Exact coefficients of a relation with known columns, over the field of the geometry.

Elimination modulo a prime gives the columns of a relation. Their coefficients are the null vector
of a small matrix, the columns at a few rational points of the state. With named lengths, symgen
evaluates it exactly with symbols; otherwise numerically with many digits. An angle that is not a
fraction of pi enters by the tangent t of its half, cos = (1 - t^2)/(1 + t^2) and sin = 2 t/(1 +
t^2), so that the matrix is rational.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from symgen.errors import SymgenError
from symgen.robot.types import Robot
from symgen.symbolic.elimination import NeedsValuesError
from symgen.symbolic.energy import state_columns
from symgen.symbolic.kinematics import base_inputs, joint_map
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.tape import Arithmetic, Numbers, Tape, real_symbol

_TRIES = 6
_LARGEST = 4  # columns of a lifted relation with a named angle
_DIGITS = 50


def lifted(
    robot: Robot,
    energy: Tape,
    state: Sequence[Parameter],
    support: Sequence[int],
) -> list[sp.Expr]:
    """Return c such that h_0 + sum of c_i h_i is constant over the support (0 the first column).

    The coefficients are formulas if the geometry has named symbols. If it has numbers only, they
    have 50 digits, because elimination has already given all rational ones.

    Raises:
        SymgenError: there is no exact relation; symgen does not cover the geometry.
    """
    tape = energy.keep([i for i in support if state[i].inertial])
    columns = _Columns(robot, tape, [state[i] for i in support])
    if not any(value.free_symbols for _, value in tape.constants):
        return _numbers(columns)
    general = {
        f.args[0]
        for _, value in tape.constants
        for f in value.atoms(sp.sin, sp.cos)
        if not (f.args[0] / sp.pi).is_Rational
    }
    if len(general) > 1 or (general and len(support) > _LARGEST):
        raise NeedsValuesError("a relation in several general angles")
    halves: dict[sp.Expr, sp.Symbol] = {}
    for attempt in range(_TRIES):
        arithmetic = _Exact(halves, following=len(robot.moving) > robot.n)
        draw = random.Random(f"lift {attempt}")
        points = (_point(robot, draw) for _ in range(len(support) + 3 + attempt))
        rest = _point(robot, random.Random("rest"))
        vector = _null_vector(sp.Matrix(columns.differences(arithmetic, points, rest, draw)))
        if vector is not None and vector[0] != 0:
            return [_in_full_angles(sp.cancel(c / vector[0]), halves) for c in vector[1:]]
    raise SymgenError(
        f"no exact regrouping relation was found for {state[support[0]].name}; "
        "give angles as fractions of pi where they are"
    )


def _null_vector(matrix: sp.Matrix) -> list[sp.Expr] | None:
    """Return the null vector of a matrix of formulas, or None if there are several.

    The field is that of rational functions over the rationals and the roots in the matrix. SymPy
    would choose a field without an exact zero for lengths times roots.
    """
    roots = sorted(
        {p.base for entry in matrix for p in entry.atoms(sp.Pow) if not p.exp.is_Integer},
        key=sp.default_sort_key,
    )
    if any(root.free_symbols for root in roots):
        raise NeedsValuesError("the root of a named length")
    numbers = sp.QQ.algebraic_field(*map(sp.sqrt, roots)) if roots else sp.QQ
    field = numbers.frac_field(*sorted(matrix.free_symbols, key=lambda symbol: symbol.name))
    rows = [[field.from_sympy(entry) for entry in row] for row in matrix.tolist()]
    reduced, pivots = DomainMatrix(rows, matrix.shape, field).rref()
    free = sorted(set(range(matrix.cols)) - set(pivots))
    if len(free) != 1:
        return None
    column = dict(zip(pivots, reduced.to_Matrix().col(free[0]), strict=False))
    return [-column.get(i, sp.S.NegativeOne) for i in range(matrix.cols)]


def _numbers(columns: _Columns) -> list[sp.Expr]:
    """Solve for the coefficients with many digits, from more points than unknowns."""
    import mpmath

    context = mpmath.mp.clone()
    context.dps = 2 * _DIGITS
    functions = {"sin": context.sin, "cos": context.cos}
    arithmetic = Numbers({}, functions, lambda value: context.mpf(str(value)), digits=2 * _DIGITS)
    draw, joints = random.Random("numbers"), columns.robot.movable

    def drawn() -> list[Any]:
        return [context.mpf(draw.randrange(-3000, 3000)) / 1000 for _ in joints]

    def point() -> _Point:
        q, qd = drawn(), drawn()
        return _Point(q, qd, q)

    half = [context.mpf(1) / 2 for _ in joints]
    points = (point() for _ in range(len(columns.parameters) + 3))
    matrix = columns.differences(arithmetic, points, _Point(half, half, half), draw)
    left = context.matrix([row[1:] for row in matrix])
    right = context.matrix([-row[0] for row in matrix])
    solution, residual = context.qr_solve(left, right)
    if residual > context.mpf(10) ** (-_DIGITS):
        first = columns.parameters[0].name
        raise SymgenError(f"no exact regrouping relation was found for {first}")
    return [sp.Float(str(context.nstr(c, _DIGITS)), _DIGITS) for c in solution]


def _in_full_angles(expr: sp.Expr, halves: dict[sp.Expr, sp.Symbol]) -> sp.Expr:
    """Write a rational function of t = tan(angle/2) in the cosine and sine of the angle."""
    for angle, t in halves.items():
        if not expr.has(t):
            continue
        c, s = sp.Dummy(real=True), sp.Dummy(real=True)
        reduced = [
            sp.rem(part, s**2 + c**2 - 1, s)
            for part in sp.fraction(sp.together(expr.subs(t, s / (1 + c))))
        ]
        expr = sp.cancel(reduced[0] / reduced[1])
        expr = expr.subs({c: sp.cos(angle, evaluate=False), s: sp.sin(angle, evaluate=False)})
    return sp.factor_terms(expr)


@dataclass(frozen=True)
class _Circle:
    """A joint angle by its cosine and sine, and an independent number for the angle itself."""

    c: sp.Expr
    s: sp.Expr

    def plus(self, other: _Circle) -> _Circle:
        """Return the sum of two angles."""
        return _Circle(
            sp.expand(self.c * other.c - self.s * other.s),
            sp.expand(self.s * other.c + self.c * other.s),
        )

    def opposite(self) -> _Circle:
        """Return the angle with its sign changed."""
        return _Circle(self.c, -self.s)


class _Point(NamedTuple):
    """A state: joint variables, speeds, and the variables as plain numbers."""

    q: list[Any]
    qd: list[Any]
    number: list[Any]


def _point(robot: Robot, draw: random.Random) -> _Point:
    """Draw a small rational state: points of the circle, positions and speeds."""
    q: list[Any] = []
    number = []
    for joint in robot.movable:
        t = sp.Rational(draw.randrange(-3, 4), draw.randrange(1, 4))
        number.append(sp.Integer(draw.randrange(-9, 10)))
        circle = _Circle((1 - t**2) / (1 + t**2), 2 * t / (1 + t**2))
        q.append(circle if joint.turns else number[-1])
    return _Point(q, [sp.Integer(draw.randrange(-3, 4)) for _ in robot.movable], number)


@dataclass(frozen=True)
class _Columns:
    """The columns of some parameters: energies by a tape, and q_j of an offset OF_j."""

    robot: Robot
    tape: Tape
    parameters: Sequence[Parameter]

    def differences(
        self, arithmetic: Arithmetic, points: Iterable[_Point], rest: _Point, draw: random.Random
    ) -> list[list[Any]]:
        """Return the columns at every point but the first, minus those at the first.

        If gravity or the motion of the base is an input, it is drawn at every point.
        """
        rows = []
        for point in points:
            state = {"q": point.q, "qd": point.qd}
            for name, symbols in base_inputs(self.robot):
                state[name] = [sp.Integer(draw.randrange(-9, 10)) for _ in symbols]
            at_rest = {"q": rest.q, "qd": rest.qd}
            number = joint_map(self.robot, point.number)
            rows.append(
                state_columns(self.tape, self.parameters, arithmetic, state, at_rest, number)
            )
        return [[a - b for a, b in zip(row, rows[0], strict=True)] for row in rows[1:]]


class _Exact(Arithmetic):
    """Exact arithmetic of SymPy expressions, for a few columns at a time."""

    def __init__(self, halves: dict[sp.Expr, sp.Symbol], following: bool) -> None:
        self.halves, self.following = halves, following

    def constant(self, value: sp.Expr) -> sp.Expr:
        return value.replace(
            lambda e: e.func in (sp.cos, sp.sin), lambda e: self._by_half(e.func, e.args[0])
        )

    def _by_half(self, function: Any, angle: sp.Expr) -> sp.Expr:
        if angle.has(sp.pi) and (angle / sp.pi).is_Rational:
            return sp.sqrtdenest(function(angle))
        t = self.halves.setdefault(angle, real_symbol(f"_t{len(self.halves)}"))
        return (1 - t**2) / (1 + t**2) if function is sp.cos else 2 * t / (1 + t**2)

    def add(self, a: Any, b: Any) -> Any:
        if isinstance(a, _Circle) or isinstance(b, _Circle):
            return self._turned(a, b)
        return sp.cancel(a + b) if self.halves else a + b

    def mul(self, a: Any, b: Any) -> Any:
        if isinstance(a, _Circle) or isinstance(b, _Circle):
            raise NeedsValuesError("a multiple of a joint variable")
        return sp.cancel(a * b) if self.halves else sp.expand(a * b)

    def neg(self, a: Any) -> Any:
        return a.opposite() if isinstance(a, _Circle) else -a

    def function(self, name: str, argument: Any) -> Any:
        return argument.c if name == "cos" else argument.s

    def _turned(self, a: Any, b: Any) -> _Circle:
        if isinstance(a, _Circle) and isinstance(b, _Circle):
            return a.plus(b)
        if self.following:
            raise NeedsValuesError("a constant angle and joints that follow others")
        # Adding a constant keeps the point random.
        return a if isinstance(a, _Circle) else b
