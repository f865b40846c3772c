"""The nearest physically possible robot to an estimate, by a semidefinite program.

Base parameters X = G s determine only combinations of the standard parameters s. X is possible if
some s gives X with bodies of positive mass density and non-negative friction and rotor inertia:

    G s = X,   pseudo-inertia P_j positive definite for each link j,   IA, FS, FV >= 0

(Sousa and Cortesao 2014; Traversaro, Brossette, Escande, Nori 2016; Wensing, Kim, Slotine 2018).
Every base parameter has a leading standard parameter that no other base parameter contains. The
other standard parameters are free variables, and X = G s holds to rounding. The units are a typical
length and mass of the robot, in which the entries of a pseudo-inertia have similar size.

The nearest possible X to an estimate X0 of covariance C minimises the whitened deviation z,

    minimise |z|^2 + faint |y|^2   with   X = X0 + L z,   L L' = C

over z and the free standard parameters y. The optimum has size one for any precision of the logs.

`symgen.identification.interior` solves such programs. It starts at a possible robot and visits only
possible ones, therefore there is always an answer. X is possible if some links give it, and is not
if dual matrices prove that none do. How the search ends decides nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symgen import names
from symgen.codegen.model import Model, regrouping
from symgen.data.raw import Places
from symgen.errors import ParameterError
from symgen.estimation.values import FloatArray
from symgen.identification.interior import Positive, minimise
from symgen.identification.pseudo_inertia import BASIS, LENGTH, UNIT
from symgen.robot.expressions import six_digits
from symgen.robot.types import Robot

#: Smallest eigenvalue of a pseudo-inertia that counts as positive, in the robot's units: half of
#: the digits of a number.
CERTAIN = math.sqrt(np.finfo(float).eps)
#: Smallest eigenvalue in the nearest possible parameters, far below the smallest link of an arm.
_MARGIN = 1e-7
#: Upper limit of the margin that `Constraints.margin` maximises.
_ENOUGH = 1e-3
#: Largest trace of a pseudo-inertia, in the robot's units: in the nearest possible parameters, and
#: of links that give X.
_LARGEST, _LIMIT = 300.0, 1e3
#: The search for the nearest robot starts again in the units of its result if these differ by more
#: than this factor. The second number is the largest number of searches.
_ALIKE, _SEARCHES = 3.0, 5
#: A negative value of this size, in the robot's units, is a rounding error.
_ROUNDING = 1e-12
#: Smallest share of a link in the violated constraints for which a message names it.
_BLAMED = 0.1
#: Smallest eigenvalue of a correlation matrix, and standard deviation in the robot's units.
_SMALLEST = 1e-10
#: Factor and power of the length in the robot's unit, for each unit of a parameter. Parameters of
#: effects have no constraints and no scaling.
_UNITS = {
    "kg m2": (1, 2),
    "kg m": (1, 1),
    "kg": (1, 0),
    "N m": (10, 1),
    "N m s/rad": (10, 1),
    "N": (10, 0),
    "N s/m": (10, 0),
}
#: Prefixes of parameters that cannot be negative.
POSITIVE = ("FS", "FV", "IA", "M", "FSM", "FVM", "IAM")
#: Prefixes of parameters that are positive in every body.
_DIAGONAL = ("XX", "YY", "ZZ", "M")


@dataclass(frozen=True, eq=False)
class Possible:
    """The possible base parameters nearest to an estimate.

    Attributes:
        X: (p,) base parameters; the estimate itself if it is possible.
        distance: sqrt((X - X0)' C^-1 (X - X0)) from the estimate X0; 0 if it is possible.
        at_bound: names of the parameters that a constraint holds at zero or moves by more than
            their standard deviation. Their standard deviations are not valid.
        fault: a text that says why the estimate is not possible; "" if it is possible.
        is_decided: whether it is certain that the estimate is possible, or that it is not.
    """

    X: FloatArray
    distance: float = 0.0
    at_bound: tuple[str, ...] = ()
    fault: str = ""
    is_decided: bool = True


def nearest_possible(model: Model, X: FloatArray, covariance: FloatArray) -> Possible:
    """Return the nearest physically possible base parameters.

        minimise (X - X0)' C^-1 (X - X0)

    The pseudo-inertias of all links are positive definite. Friction and rotor inertia are not
    negative.

    Args:
        model: model of the robot.
        X: base parameters X0, (p,).
        covariance: covariance C of X0, (p, p).

    Raises:
        ParameterError: X are not base parameters of this robot, or the covariance is not a finite
            matrix with a positive diagonal.
    """
    problem = Constraints.of(model, X)
    fault, is_decided = problem.fault()
    if not fault:
        return Possible(problem.X)
    p = len(problem.X)
    variances = np.diag(covariance) if np.shape(covariance) == (p, p) else np.zeros(p)
    if not (np.isfinite(covariance).all() and (variances > 0).all()):
        raise ParameterError(f"the covariance is not a ({p}, {p}) matrix with a positive diagonal")
    for _ in range(_SEARCHES):
        L = problem.axes(covariance)
        wider = problem.loosened(L)
        x = wider.onto @ _nearest(wider, L) + wider.at
        signed = x[problem.positive]
        x[problem.positive] = np.where(signed > _MARGIN, signed, 0.0)
        near = problem.G @ (x * problem.scale)
        unit, problem = problem.scale[0], Constraints.of(model, X, near)
        if 1 / _ALIKE < problem.scale[0] / unit < _ALIKE:
            break
    distance = float(np.linalg.norm(np.linalg.solve(L, near - problem.X)))
    at_zero = np.isin(problem.heads, problem.positive) & (near == 0)
    bound = at_zero | (np.abs(near - problem.X) > np.sqrt(variances))
    at_bound = tuple(name for name, held in zip(model.base.names, bound, strict=True) if held)
    return Possible(near, distance, at_bound, fault, is_decided)


def _nearest(problem: Constraints, L: FloatArray) -> FloatArray:
    """Return the variables (y, z) of the possible parameters with the smallest |z|.

    The search starts at the robot whose pseudo-inertias are unit matrices.

    Args:
        problem: constraints of y and z.
        L: axes of z, with X = X0 + L z.
    """
    start = np.zeros(len(problem.at))
    start[problem.links] = UNIT
    start[problem.positive] = 1.0
    z = np.linalg.solve(L, problem.G @ (start * problem.scale) - problem.X)
    y = np.append(start[problem.free], z)
    weights = np.diag(np.arange(len(y)) >= len(problem.free)).astype(float)
    constraints = [problem.bodies(_MARGIN), problem.traces(_LARGEST), problem.signs()]
    return minimise(weights, np.zeros(len(y)), constraints, y).y


class Margin(NamedTuple):
    """Distance from the limit of the possible.

    Attributes:
        value: the largest t with P_j - t I positive semidefinite for every link j, up to 1e-3.
        bound: an upper bound of the largest t, which the dual matrices prove.
        y: (m,) variables at this t.
        blame: (L,) share of each link in the constraints that limit t.
    """

    value: float
    bound: float
    y: FloatArray
    blame: FloatArray


@dataclass(frozen=True, eq=False)
class Constraints:
    """The standard parameters that give X, in the robot's units: x = onto y + at.

    Attributes:
        model: model of the robot.
        X: (p,) base parameters.
        G: (p, s) matrix of X = G s.
        scale: (s,) units: s = scale x.
        heads: index of the leading standard parameter of each base parameter.
        free: indices of the other standard parameters, which are the variables y.
        onto, at: (s, m) matrix and (s,) offset.
        links: (L, 10) indices of the parameters of each link.
        positive: indices of friction and rotor inertia.
    """

    model: Model
    X: FloatArray
    G: FloatArray
    scale: FloatArray
    heads: list[int]
    free: list[int]
    onto: FloatArray
    at: FloatArray
    links: Places
    positive: Places

    @classmethod
    def of(
        cls, model: Model, X: Sequence[float] | FloatArray, like: FloatArray | None = None
    ) -> Constraints:
        """Return the constraints on standard parameters that give X, (p,).

        The units are those of the parameters `like`, (p,); by default of X.

        Raises:
            ParameterError: X are not finite base parameters of this robot.
        """
        base = model.base
        X = np.array(X, dtype=float)
        if X.shape != (len(base.parameters),) or not np.isfinite(X).all():
            raise ParameterError(
                f"{model.robot.name}: X is not {len(base.parameters)} finite base parameters"
            )
        G, n = regrouping(model), len(base.standard)
        heads = [p.index for p in base.parameters]
        free = sorted(set(range(n)) - set(heads))
        prefixes = np.array([p.prefix for p in base.standard])
        links = np.flatnonzero(prefixes == names.LINK[0])[:, None] + np.arange(len(names.LINK))
        drives = np.isin(prefixes, POSITIVE)
        drives[links] = False
        scale = _units(model)
        inertial = heads[: base.inertial]
        sizes = np.abs(X if like is None else like)[: base.inertial]
        mass = float(np.max(sizes / scale[inertial], initial=0.0))
        scale = scale * (mass or 1.0)
        onto = np.eye(n)[:, free]
        onto[heads] = -G[:, free] * scale[free] / scale[heads, None]
        at = np.zeros(n)
        at[heads] = X / scale[heads]
        return cls(model, X, G, scale, heads, free, onto, at, links, np.flatnonzero(drives))

    def axes(self, covariance: FloatArray) -> FloatArray:
        """Return the axes L (p, p) of the deviations of X from an estimate of covariance C.

            L L' = (C^-1 + D^-1)^-1

        D contains the squares of the largest parameters of a robot. What the logs do not determine
        therefore stays near the estimate. Rounding errors are added.
        """
        units = self.scale[self.heads]
        covariance = covariance + np.diag((_SMALLEST * units) ** 2)
        std = np.sqrt(np.diag(covariance))
        sizes = np.outer(std, std)
        correlation = covariance / sizes
        largest = np.diag((_LARGEST * units / std) ** 2)
        bounded = correlation @ np.linalg.solve(correlation + largest, largest)
        return deviation_axes(sizes * (bounded + bounded.T) / 2)

    def loosened(self, L: FloatArray) -> Constraints:
        """Return constraints in which X may move by L z, with z after the variables y."""
        moved = np.zeros((len(self.at), L.shape[1]))
        moved[self.heads] = L / self.scale[self.heads, None]
        return replace(self, onto=np.hstack([self.onto, moved]))

    def bodies(self, least: float | FloatArray = 0.0, weight: FloatArray | float = 0.0) -> Positive:
        """Return the pseudo-inertias of y, minus a multiple of the unit matrix.

        Args:
            least: lower bound of the eigenvalues of the pseudo-inertias, a number or (L,).
            weight: weight of the log-determinant of each link, a number or (L,).
        """
        slopes = np.einsum("lpn,pab->labn", self.onto[self.links], BASIS)
        floors = np.broadcast_to(least, len(self.links))[:, None, None] * np.eye(4)
        return Positive(slopes, np.tensordot(self.at[self.links], BASIS, 1) - floors, weight)

    def traces(self, limit: float) -> Positive:
        """Return how far the traces of the pseudo-inertias are below a limit."""
        traces = np.trace(BASIS, axis1=1, axis2=2)
        slopes = np.tensordot(traces, self.onto[self.links], (0, 1))
        return Positive.numbers(-slopes, limit - self.at[self.links] @ traces)

    def signs(self) -> Positive:
        """Return friction and rotor inertia, plus a negligible number."""
        return Positive.numbers(self.onto[self.positive], self.at[self.positive] + 2 * CERTAIN)

    def margin(self) -> Margin:
        """Return the largest margin of parameters that give X.

        Friction and rotor inertia that vary with y exceed the margin as well.
        """
        narrowed = np.zeros(len(self.at))
        narrowed[self.links] = -UNIT
        narrowed[self.positive] = -1.0 * self.onto[self.positive].any(axis=1)
        wider = replace(self, onto=np.column_stack([self.onto, narrowed]))
        bodies, signs = wider.bodies(), wider.signs()
        t = np.eye(wider.onto.shape[1])[-1]
        enough = Positive.numbers(-t[None], np.array([_ENOUGH]))
        lowest = min(np.linalg.eigvalsh(bodies.f).min(), signs.f.min(initial=0.0))
        constraints = [bodies, signs, wider.traces(_LIMIT), enough]
        linear = np.zeros((len(t), len(t)))
        start = (lowest - 1.0) * t
        y, barriers, gap = minimise(linear, -t, constraints, start)
        inverses = np.linalg.inv(bodies.E @ y + bodies.f)
        blame = barriers[: len(inverses)] * np.trace(inverses, axis1=1, axis2=2)
        return Margin(float(y[-1]), float(y[-1]) + gap, y[:-1], blame)

    def fault(self) -> tuple[str, bool]:
        """Return why no link parameters give X, or "" if some do, and whether this is certain."""
        prefixes = [p.prefix for p in self.model.base.standard]
        never_negative = np.isin(prefixes, (*_DIAGONAL, *POSITIVE))
        wrong = []
        for k, p in enumerate(self.model.base.parameters):
            row = self.G[k]
            if self.at[self.heads[k]] >= -_ROUNDING or row.min() < 0:
                continue
            if never_negative[row > 0].all():
                formula = f" ({six_digits(p.expression)})" if p.terms else ""
                wrong.append(f"{p.name} is {self.X[k]:.4g} and cannot be negative{formula}")
        if wrong:
            more = wrong[3:]
            return "; ".join(wrong[:3]) + (f"; {len(more)} more" if more else ""), True
        value, bound, _, blame = self.margin()
        if value > CERTAIN:
            return "", True
        if bound > CERTAIN:
            return "it could not be decided whether a robot can have these parameters", False
        blamed = sorted(k for k in np.argsort(-blame, kind="stable")[:3] if blame[k] > _BLAMED)
        standard = self.model.base.standard
        numbers = [standard[self.links[k][0]].name.removeprefix(names.LINK[0]) for k in blamed]
        links = " and ".join(f"link {number}" for number in numbers)
        if not links:
            return "friction and rotor inertia cannot all be positive", True
        return f"the inertia of {links} cannot be positive definite", True


def _units(model: Model) -> FloatArray:
    """Return the unit of each standard parameter for a robot of 1 kg, (s,)."""
    units = [_UNITS.get(p.unit, (1, 0)) for p in model.base.standard]
    factors, powers = np.transpose(units)
    return np.asarray(factors * _length(model.robot) ** powers)


def _length(robot: Robot) -> float:
    """Return a typical length, m: the mean non-zero length of the geometry, or LENGTH."""
    plain = robot.with_values()
    every = [e for j in plain.joints for e in (j.b, j.d, j.r)]
    lengths = [abs(float(e)) for e in every if e != 0]
    return sum(lengths) / len(lengths) if lengths else LENGTH


def deviation_axes(covariance: FloatArray) -> FloatArray:
    """Return L (p, p) with L L' = covariance; z of X = X0 + L z is then in standard deviations.

    Smaller eigenvalues of the correlation matrix are raised to 1e-10.
    """
    std = np.sqrt(np.diag(covariance))
    unit = np.where(std > 0, std, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    L: FloatArray = unit[:, None] * vectors * np.sqrt(np.maximum(values, _SMALLEST))
    return L
