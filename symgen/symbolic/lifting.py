"""Exact coefficients of a relation with known columns, over the field of the geometry.

Elimination modulo a prime gives the columns of a relation. Their coefficients are the null vector
of a small matrix, the columns at a few rational points of the state. With named lengths, symgen
evaluates it exactly with symbols; otherwise numerically with many digits. An angle that is not a
fraction of pi enters by the tangent t of its half, cos = (1 - t^2)/(1 + t^2) and sin = 2 t/(1 +
t^2), so that the matrix is rational.
"""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.polys.matrices import DomainMatrix

from symgen.errors import SymgenError
from symgen.symbolic.elimination import NeedsValuesError
from symgen.symbolic.energy import StateColumns
from symgen.symbolic.modular import JointAngle
from symgen.symbolic.tape import Drawing, DrawnNumbers, real_symbol

_TRIES = 6
_LARGEST = 4  # columns of a lifted relation with a named angle
_DIGITS = 50


def lifted(columns: StateColumns) -> list[sp.Expr]:
    """Return c such that h_0 + sum of c_i h_i is constant, with h_0 the first of the columns.

    The coefficients are formulas if the geometry has named symbols. If it has numbers only, they
    have 50 digits, because elimination has already given all rational ones.

    Raises:
        SymgenError: there is no exact relation; symgen does not cover the geometry.
    """
    robot, count = columns.robot, len(columns.parameters)
    constants = columns.energy.constants
    if not any(value.free_symbols for _, value in constants):
        return _numbers(columns)
    general = {
        f.args[0]
        for _, value in constants
        for f in value.atoms(sp.sin, sp.cos)
        if not (f.args[0] / sp.pi).is_Rational
    }
    if len(general) > 1 or (general and count > _LARGEST):
        raise NeedsValuesError("a relation in several general angles")
    halves: dict[sp.Expr, sp.Symbol] = {}
    for attempt in range(_TRIES):
        arithmetic = _Exact(attempt, halves, following=len(robot.moving) > robot.n)
        rows = columns.differences(arithmetic, count + 3 + attempt)
        vector = _null_vector(sp.Matrix(rows.tolist()))
        if vector is not None and vector[0] != 0:
            ratios = (sp.radsimp(sp.cancel(c / vector[0]), symbolic=False) for c in vector[1:])
            return [_in_full_angles(ratio, halves) for ratio in ratios]
    raise SymgenError(
        f"no exact regrouping relation was found for {columns.parameters[0].name}; "
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


def _numbers(columns: StateColumns) -> list[sp.Expr]:
    """Solve for the coefficients with many digits, from more points than unknowns."""
    import mpmath

    context = mpmath.mp.clone()
    context.dps = 2 * _DIGITS
    functions = {name: np.frompyfunc(getattr(context, name), 1, 1) for name in ("sin", "cos")}
    arithmetic = DrawnNumbers({}, functions, lambda x: context.mpf(str(x)), digits=2 * _DIGITS)
    matrix = columns.differences(arithmetic, len(columns.parameters) + 3)
    left = context.matrix(matrix[:, 1:].tolist())
    right = context.matrix((-matrix[:, 0]).tolist())
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


#: Functions of SymPy on arrays of expressions.
_cancel, _expand, _re, _im, _conjugate = (
    np.frompyfunc(f, 1, 1) for f in (sp.cancel, sp.expand, sp.re, sp.im, sp.conjugate)
)


class _Exact(Drawing):
    """Exact arithmetic of SymPy expressions, for a few columns at a time.

    Random states are small and rational: points of the circle, positions and speeds.
    """

    def __init__(self, seed: int, halves: dict[sp.Expr, sp.Symbol], following: bool) -> None:
        self.draw = random.Random(f"lift {seed}")
        self.halves, self.following = halves, following

    def numbers(self, count: int) -> NDArray[Any]:
        return np.array([sp.Integer(self.draw.randrange(-9, 10)) for _ in range(count)])

    def joint_angle(self, count: int, parts: int) -> JointAngle:  # noqa: ARG002
        units = []
        for _ in range(count):
            t = sp.Rational(self.draw.randrange(-3, 4), self.draw.randrange(1, 4))
            units.append(_half(sp.cos, t) + sp.I * _half(sp.sin, t))
        return JointAngle(self.numbers(count), np.array(units))

    def constant(self, value: sp.Expr) -> sp.Expr:
        return value.replace(
            lambda e: e.func in (sp.cos, sp.sin), lambda e: self._by_half(e.func, e.args[0])
        )

    def _by_half(self, function: Any, angle: sp.Expr) -> sp.Expr:
        if angle.has(sp.pi) and (angle / sp.pi).is_Rational:
            return sp.sqrtdenest(function(angle))
        return _half(function, self.halves.setdefault(angle, real_symbol(f"_t{len(self.halves)}")))

    def add(self, a: Any, b: Any) -> Any:
        if isinstance(a, JointAngle) and isinstance(b, JointAngle):
            return JointAngle(a.number + b.number, _expand(a.unit * b.unit))
        if isinstance(a, JointAngle) or isinstance(b, JointAngle):
            if self.following:
                raise NeedsValuesError("a constant angle and joints that follow others")
            # Adding a constant keeps the point random.
            return a if isinstance(a, JointAngle) else b
        return _cancel(a + b) if self.halves else a + b

    def mul(self, a: Any, b: Any) -> Any:
        if isinstance(a, JointAngle) or isinstance(b, JointAngle):
            raise NeedsValuesError("a multiple of a joint variable")
        return _cancel(a * b) if self.halves else _expand(a * b)

    def neg(self, a: Any) -> Any:
        return JointAngle(-a.number, _conjugate(a.unit)) if isinstance(a, JointAngle) else -a

    def function(self, name: str, argument: Any) -> Any:
        return (_re if name == "cos" else _im)(argument.unit)


def _half(function: Any, t: sp.Expr) -> sp.Expr:
    """Return the cosine or sine of an angle from the tangent of its half."""
    return (1 - t**2) / (1 + t**2) if function is sp.cos else 2 * t / (1 + t**2)
