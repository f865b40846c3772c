"""Physical consistency of parameters, and the nearest consistent ones, by semidefinite programs.

Base parameters X = G s determine only combinations of the standard parameters s. X is possible if
some s gives it in which every link is a body of positive mass density, and friction and rotor
inertia are not negative:

    G s = X,   [[S_j, m_j], [m_j', M_j]] positive definite for each link j,   IA, FS, FV >= 0

(Sousa and Cortesao 2014; Traversaro, Brossette, Escande, Nori 2016; Wensing, Kim, Slotine 2018).
Every base parameter has a leading standard parameter that no other one contains. The other standard
parameters are free variables, and X = G s holds to rounding. The units are a typical length and
mass of the robot, in which the entries of a pseudo-inertia have similar size.

The possible X nearest to an estimate X0 of covariance C has the whitened deviation z as variable,

    minimise |z|^2 + faint |y|^2   with   X = X0 + L z,   L L' = C

and the free standard parameters y. So the optimum has size one for any precision of the logs.

Of all links that give X, the nearest to those of a file minimise the log-determinant divergence of
their pseudo-inertias: it has no units and is the same in every frame (Lee, Wensing, Park 2020).

Programs have a quadratic objective, affine equations, signs and semidefinite matrices,

    minimise 1/2 y'P y + c'y   with   E y + f = 0, >= 0, or a positive semidefinite matrix

and are solved by Clarabel (Goulart and Chen 2024). Symmetric matrices are vectors: the upper
triangle column by column, off-diagonal entries times sqrt(2), so that tr(A B) is a scalar product.

Torques in N mm or in kN m fit equally well, with parameters a thousand times too large or small.
The inertia M_jj of a joint, divided by the square of the robot's reach from there, is an apparent
mass. A note reports if it is tonnes for all joints, or a few grams for all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.model import Model, regrouping
from symgen.errors import ParameterError
from symgen.estimation.estimators import NOISE_BIAS, Estimator, Wls
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import Solution
from symgen.estimation.system import LinearSystem
from symgen.estimation.values import FloatArray, OtherEstimate
from symgen.identification.estimate import Consistency
from symgen.identification.parameters import is_finite, mass_matrices
from symgen.names import REVOLUTE
from symgen.robot.body import Body
from symgen.robot.expressions import six_digits
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator


def pseudo_inertia(link: Sequence[float] | FloatArray) -> FloatArray:
    """Return the pseudo-inertia [[S, m], [m', M]] (4, 4) of a link (Wensing, Kim, Slotine 2018).

        S = tr(J)/2 I - J = integral of r r' dm,   m = (MX, MY, MZ)

    A body of positive mass density has a positive definite one, and vice versa.

    Args:
        link: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, (10,).
    """
    J, m, M = _matrices(link)
    out = np.zeros((4, 4))
    out[:3, :3] = np.trace(J) / 2 * np.eye(3) - J
    out[:3, 3] = out[3, :3] = m
    out[3, 3] = M
    return out


def bodies(robot: Robot, values: Mapping[str, float]) -> tuple[Body, ...]:
    """Return the link of every joint of the file, including fixed ones.

    With c = m/M, the inertia about the centre of mass is J - M (c'c I - c c'). A link whose
    parameters are all 0 is a frame without mass.

    Args:
        robot: the mechanism.
        values: its standard parameters by name; those of links are used (XX3 ... M3, XXL ... ML).

    Raises:
        ParameterError: a link parameter is missing, or a mass is not positive.
    """
    out = []
    for joint in robot.joints:
        suffixes = [str(joint.number)] + ["L"] * (robot.payload == joint.number)
        wanted = [[f"{prefix}{suffix}" for prefix in names.LINK] for suffix in suffixes]
        missing = [name for link in wanted for name in link if name not in values]
        if missing:
            raise ParameterError(
                f"link {joint.number}: {', '.join(missing[:5])} missing; accepted: all of "
                f"{' '.join(names.LINK)}"
            )
        link = np.sum([[values[name] for name in link] for link in wanted], axis=0)
        if not link.any():  # a frame
            out.append(Body(joint.number, 0.0, np.zeros(3), np.zeros((3, 3))))
            continue
        mass, com, inertia = about_centre(link)
        if not mass > 0:
            raise ParameterError(f"link {joint.number}: its mass is {mass:g}; accepted: above 0")
        out.append(Body(joint.number, mass, com, inertia))
    return tuple(out)


def parameters_of(P: FloatArray) -> FloatArray:
    """Return XX XY XZ YY YZ ZZ MX MY MZ M (10,) of a pseudo-inertia (4, 4)."""
    J = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
    return np.array([*J[np.triu_indices(3)], *P[:3, 3], P[3, 3]])


def about_centre(link: Sequence[float] | FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre of mass (3,) and inertia (3, 3) about it; NaN where the mass is 0.

    Args:
        link: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, (10,).
    """
    J, m, mass = _matrices(link)
    com = m / (mass or np.nan)
    return mass, com, J - mass * (com @ com * np.eye(3) - np.outer(com, com))


def _matrices(link: Sequence[float] | FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return J (3, 3), m (3,) and M."""
    J = np.zeros((3, 3))
    J[np.triu_indices(3)] = link[:6]
    J += np.triu(J, 1).T
    return J, np.array(link[6:9], dtype=float), float(link[9])


#: To the accuracy; and to it or to a hundred times it, which decides whether a solution exists.
_SOLVED, _DECIDED = ("Solved",), ("Solved", "AlmostSolved")
_ACCURACIES = (1e-10, 1e-8)  # of the first and of the second try


@dataclass(frozen=True, eq=False)
class Cone:
    """E y + f lies in a cone, "zero", "nonnegative" or "semidefinite"; E (m, n), f (m,)."""

    kind: str
    E: FloatArray
    f: FloatArray


def triangle_vector(matrix: FloatArray) -> FloatArray:
    """Return a symmetric matrix (m, m) as a vector (m (m + 1)/2,)."""
    columns, rows = np.tril_indices(len(matrix))  # the upper triangle, column by column
    return matrix[rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))


def minimise(
    P: FloatArray, c: FloatArray, cones: Sequence[Cone], accepted: Sequence[str] = _DECIDED
) -> tuple[FloatArray, list[FloatArray]]:
    """Return the minimiser y (n,), and the dual vector of every cone.

    Args:
        P: positive semidefinite (n, n).
        c: (n,).
        cones: constraints on y.
        accepted: statuses of Clarabel that are a solution.

    Raises:
        ParameterError: Clarabel finds no solution.
    """
    import clarabel
    from scipy.sparse import csc_matrix

    kinds = {
        "zero": clarabel.ZeroConeT,
        "nonnegative": clarabel.NonnegativeConeT,
        "semidefinite": lambda m: clarabel.PSDTriangleConeT(round((2 * m + 0.25) ** 0.5 - 0.5)),
    }
    E = np.concatenate([cone.E for cone in cones])
    for accuracy in _ACCURACIES:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        for name in ("gap_abs", "gap_rel", "feas"):
            setattr(settings, f"tol_{name}", accuracy)
            setattr(settings, f"reduced_tol_{name}", 100 * accuracy)
        # Variables of very different size stop the solver: the second try has them alike.
        size = np.sqrt(np.diag(P) + np.sum(E**2, axis=0))
        unit = np.ones(len(c)) if accuracy == _ACCURACIES[0] else 1 / np.where(size > 0, size, 1.0)
        solver = clarabel.DefaultSolver(
            csc_matrix(np.triu(P * np.outer(unit, unit))),
            c * unit,
            csc_matrix(-E * unit),
            np.concatenate([cone.f for cone in cones]),
            [kinds[cone.kind](len(cone.f)) for cone in cones],
            settings,
        )
        solution = solver.solve()
        if str(solution.status) in accepted:
            break
    else:
        raise ParameterError(f"the solver Clarabel ends with {solution.status}")
    ends = np.cumsum([len(cone.f) for cone in cones])[:-1]
    return np.array(solution.x) * unit, np.split(np.array(solution.z), ends)


def nearest_moves(free: int, cones: Sequence[Cone]) -> Iterator[FloatArray]:
    """Yield minimisers (y, z) of |z/unit|^2 + faint |y|^2, for a unit of distance that grows.

    The solver needs variables of size one, and the distance |z| of the nearest point is not known.
    The solution of the smallest unit is the most exact one.

    Args:
        free: number of variables y, which come first.
        cones: constraints on (y, z).
    """
    n = cones[0].E.shape[1]
    weights, size = np.ones(n), np.ones(n)
    weights[:free] = _FAINTEST
    for size[free:] in _DISTANCES:
        scaled = [replace(cone, E=cone.E * size) for cone in cones]
        with suppress(ParameterError):
            yield size * minimise(np.diag(weights), np.zeros(n), scaled, _SOLVED)[0]


def deviations(covariance: FloatArray) -> FloatArray:
    """Return L (p, p) with L L' a covariance, so that z of X = X0 + L z is in standard deviations.

    Eigenvalues of the correlation matrix are at least 1e-10.
    """
    std = np.sqrt(np.diag(covariance))
    unit = np.where(std > 0, std, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    L: FloatArray = unit[:, None] * vectors * np.sqrt(np.maximum(values, _TIED))
    return L


#: The pseudo-inertia of ten link parameters as a vector of the solver, the unit matrix as such a
#: vector, and the link parameters of which it is the pseudo-inertia.
MATRIX = np.array([triangle_vector(pseudo_inertia(unit)) for unit in np.eye(len(names.LINK))]).T
IDENTITY = triangle_vector(np.eye(4))
_BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(len(names.LINK))])
_UNIT = np.array([2.0, 0, 0, 2, 0, 2, 0, 0, 0, 1])
#: Smallest eigenvalue of a pseudo-inertia, in the robot's units, that counts as positive: what half
#: the digits of a number show ...
_CERTAIN = math.sqrt(np.finfo(float).eps)
#: ... that the nearest possible parameters keep, far below the smallest link of an arm ...
_NEAREST = 1e-7
#: ... and above which a robot is not asked for more.
_ENOUGH = 1e-3
#: Largest trace of a pseudo-inertia, in the robot's units.
_LARGEST = 300.0
#: Weights of the size of what a prior does not name, and of what has no other weight.
_FAINT, _FAINTEST = 1e-3, 1e-6
#: Units of distance in the search for the nearest, in standard deviations, one after the other.
_DISTANCES = (1.0, 10.0, 1e2, 1e3, 1e4, 1e6, 1e8, 1e10)
#: A negative value of this size, in the robot's units, is rounding.
_ROUNDING = 1e-12
#: Most steps of Newton's method, the shortest part of one, and the decrease that ends it.
_STEPS, _SHORTEST, _DONE = 200, 1e-12, 1e-22
#: Share of a link in what makes X impossible, from which it is named.
_BLAMED = 0.1
#: Smallest eigenvalue of a correlation matrix.
_TIED = 1e-10
#: Factor, and power of the length, of the robot's unit for each unit of a parameter; effects are
#: free of constraints and taken as they are.
_UNITS = {
    "kg m2": (1, 2),
    "kg m": (1, 1),
    "kg": (1, 0),
    "N m": (10, 1),
    "N m s/rad": (10, 1),
    "N": (10, 0),
    "N s/m": (10, 0),
}
#: Parameters that are positive by their nature.
POSITIVE = ("FS", "FV", "IA", "M", "FSM", "FVM", "IAM")
#: Parameters that are above zero in every body.
_DIAGONAL = ("XX", "YY", "ZZ", "M")


class Feasibility:
    """Constraints on the parameters of a robot, in its own units: x = s / scale.

    Raises:
        ParameterError: X are not finite base parameters of this robot.
    """

    def __init__(self, model: Model, X: Sequence[float] | FloatArray) -> None:
        base, self.robot = model.base, model.robot.name
        self._model = model
        self.parameters = base.parameters
        self.names = [p.name for p in base.standard]
        prefixes = [p.prefix for p in base.standard]
        self.X = np.array(X, dtype=float)
        if self.X.shape != (len(base.parameters),) or not np.isfinite(self.X).all():
            raise ParameterError(
                f"{self.robot}: X is not {len(base.parameters)} finite base parameters"
            )
        self.G = regrouping(model)
        self.never_negative = np.isin(prefixes, (*_DIAGONAL, *POSITIVE))
        self.heads = [p.index for p in base.parameters]
        n = len(self.names)
        self.free = sorted(set(range(n)) - set(self.heads))
        first = np.flatnonzero(np.array(prefixes) == names.LINK[0])
        self.links = first[:, None] + np.arange(len(names.LINK))
        drives = np.isin(prefixes, POSITIVE)
        drives[self.links] = False
        self.positive = np.flatnonzero(drives)
        length = _length(model.robot)
        scale = np.array([f * length**k for f, k in (_UNITS.get(p.unit, (1, 0))
                                                     for p in base.standard)])  # fmt: skip
        heads = self.heads[: base.inertial]
        mass = float(np.max(np.abs(self.X[: len(heads)]) / scale[heads], initial=0.0))
        self.scale = scale * (mass or 1.0)
        # x = onto y + at: the free parameters y, and the leading ones that X leaves. As equations
        # beside the cones, X = G s makes the solver fail on some robots of six joints.
        self.onto = np.eye(n)[:, self.free]
        self.onto[self.heads] = -self.G[:, self.free] * self.scale[self.free]
        self.onto[self.heads] /= self.scale[self.heads, None]
        self.at = np.zeros(n)
        self.at[self.heads] = self.X / self.scale[self.heads]

    def require(self, prior: Mapping[str, float]) -> None:
        """Refuse a prior without finite standard parameters of this robot."""
        for name, value in prior.items():
            if name not in self.names:
                raise ParameterError(
                    f"{self.robot}: the prior's {name} is no standard parameter; accepted: "
                    f"{', '.join(self.names[:11])}, ..."
                )
            if not is_finite(value):
                raise ParameterError(
                    f"{self.robot}: the prior's {name} is {value!r}; accepted: a finite number"
                )

    def fault(self) -> str:
        """Return a text: why no link parameters give X; '' if some do."""
        wrong = [
            f"{p.name} is {x:.4g} and cannot be negative"
            + f" ({six_digits(p.expression)})" * bool(p.terms)
            for row, p, x, size in zip(
                self.G, self.parameters, self.X, self.at[self.heads], strict=True
            )
            if size < -_ROUNDING and row.min() >= 0 and self.never_negative[row > 0].all()
        ]
        if wrong:
            return "; ".join(wrong[:3]) + (f"; {len(wrong) - 3} more" if len(wrong) > 3 else "")
        margin, blame = self.margin
        if margin > _CERTAIN:
            return ""
        worst = sorted(k for k in np.argsort(-blame, kind="stable")[:3] if blame[k] > _BLAMED)
        links = [f"link {self.names[self.links[k][0]].removeprefix('XX')}" for k in worst]
        return f"the inertia of {' and '.join(links)} cannot be positive definite"

    @cached_property
    def margin(self) -> tuple[float, FloatArray]:
        """The largest t with P_j - t I positive semidefinite for every link j, up to 1e-3.

        X is possible if it is positive. The second value is the share of each link in the binding
        constraints of t: the trace of its dual matrix.
        """
        (t, _), blame = self._widest(self.onto, self.at, self.links)
        return t, blame

    def _widest(
        self, onto: FloatArray, at: FloatArray, links: NDArray[np.intp]
    ) -> tuple[tuple[float, FloatArray], FloatArray]:
        """Return the largest t and y with P_j - t I >= 0 for x = onto y + at, and the blame."""
        floors = np.zeros(len(self.names))
        floors[links] = _UNIT
        wider = np.column_stack([onto, -floors])
        t = np.eye(wider.shape[1])[-1]
        trace = np.zeros((len(links), len(self.names)))
        np.put_along_axis(trace, links, (IDENTITY @ MATRIX)[None], axis=1)
        cones = [
            *self._consistent(wider, at, links),
            Cone("nonnegative", -trace @ np.pad(onto, ((0, 0), (0, 1))), _LARGEST - trace @ at),
            Cone("nonnegative", -t[None], np.array([_ENOUGH])),
        ]
        y, duals = minimise(np.zeros((len(t), len(t))), -t, cones)
        blame = np.array([IDENTITY @ z for z in duals[: len(links)]])
        return (float(y[-1]), y[:-1]), blame

    def closest(self, prior: Mapping[str, float]) -> FloatArray:
        """Return the standard parameters s that give X, with the links closest to the prior.

            minimise sum over links of tr(P0^-1 P) - log det(P0^-1 P)

        with P0 the pseudo-inertia in the prior. If a link has no mass in the prior, it has none in
        the result. Other links that are not bodies of positive mass in the prior become as small as
        possible.
        """
        target = np.array([float(prior.get(name, 0.0)) for name in self.names]) / self.scale
        named = np.isin(self.names, list(prior))
        given = named[self.links].all(axis=1)
        body = given & (_least(target[self.links]) > _CERTAIN)
        # Fixed to their values where that leaves room: they lead no base parameter.
        still = given & ~body & ~np.isin(self.links, self.heads).any(axis=1)
        for fixed in (still, still & False):
            held = np.isin(self.free, self.links[fixed])
            onto, links = self.onto[:, ~held], self.links[~fixed]
            at = self.at + self.onto[:, held] @ target[np.array(self.free, dtype=int)[held]]
            (margin, y), _ = self._widest(onto, at, links)
            if margin > _CERTAIN:
                break
        start = self._smallest(target, named, onto, at, links, margin, y)
        centres = np.where(body[~fixed, None], target[links], (onto @ start + at)[links])
        y = _closest_bodies(onto, at, links, centres, self.positive, target[self.positive], start)
        s: FloatArray = (onto @ y + at) * self.scale
        s[self.positive] = np.maximum(s[self.positive], 0.0)
        s[self.heads] = self.X - self.G[:, self.free] @ s[self.free]
        s[self.positive] = np.maximum(s[self.positive], 0.0)  # -1e-17, from the line above
        return s

    def _smallest(
        self,
        target: FloatArray,
        named: NDArray[np.bool_],
        onto: FloatArray,
        at: FloatArray,
        links: NDArray[np.intp],
        margin: float,
        widest: FloatArray,
    ) -> FloatArray:
        """Return y of the smallest parameters x = onto y + at: those nearest to the target.

        Parameters that are not `named` have a thousandth of the weight, unless none is. Every link
        has half of the least eigenvalue that all can have at once, or what it has in the prior
        where that is less. Where the solver does not keep that, they have all of it.
        """
        weights = np.where(named | (not named.any()), 1.0, _FAINT)
        floors = np.full(len(links), margin / 2)
        for j in np.flatnonzero(named[links].all(axis=1)):
            floors[j] = min(floors[j], max(float(_least(target[links[j]][None])[0]), _CERTAIN))
        weighted = onto.T * weights
        try:
            y, _ = minimise(
                weighted @ onto,
                weighted @ (at - target),
                self._consistent(onto, at, links, floors),
            )
        except ParameterError:
            return widest
        return y if (_least((onto @ y + at)[links]) > 0).all() else widest

    def nearest(
        self, covariance: FloatArray, known: FloatArray | None = None
    ) -> tuple[FloatArray, float]:
        """Return the nearest physically possible base parameters, and their distance.

        Args:
            covariance: of X, (p, p).
            known: parameters (p,); if a robot can have them, the nearest are at most as far.

        Raises:
            ParameterError: the solver finds no possible parameters, or the covariance is not one.
        """
        p = len(self.X)
        variances = np.diag(covariance) if covariance.shape == (p, p) else np.zeros(p)
        if not (np.isfinite(covariance).all() and (variances > 0).all()):
            raise ParameterError(
                f"the covariance is not a ({p}, {p}) matrix with a positive diagonal"
            )
        L = deviations(covariance)
        moved = np.zeros((len(self.names), p))
        moved[self.heads] = L / self.scale[self.heads, None]
        onto = np.hstack([self.onto, moved])
        least = np.full(len(self.links), _NEAREST)
        cones = self._consistent(onto, self.at, self.links, least)
        candidates = [] if known is None or not self._allows(known) else [known]
        for move in nearest_moves(len(self.free), cones):
            s = (onto @ move + self.at) * self.scale
            s[self.positive] = np.maximum(s[self.positive], 0.0)
            near = self.G @ s
            if self._allows(near):
                candidates.append(near)
                break
        if not candidates:
            raise ParameterError(f"{self.robot}: no possible robot is near these parameters")
        distances = np.linalg.norm(np.linalg.solve(L, np.transpose(candidates - self.X)), axis=0)
        first = int(np.argmin(distances))
        return candidates[first], float(distances[first])

    def _allows(self, X: FloatArray) -> bool:
        """Return whether other base parameters are possible."""
        return not Feasibility(self._model, X).fault()

    def _consistent(
        self,
        onto: FloatArray,
        at: FloatArray,
        links: NDArray[np.intp],
        least: FloatArray | None = None,
    ) -> list[Cone]:
        """Return the cones of x = onto y + at: links as bodies, and what is never negative.

        The pseudo-inertias of the links have eigenvalues of at least `least` (L,), by default 0.
        """
        least = np.zeros(len(links)) if least is None else least
        out = [
            Cone("semidefinite", MATRIX @ onto[link], MATRIX @ at[link] - floor * IDENTITY)
            for link, floor in zip(links, least, strict=True)
        ]
        return [*out, Cone("nonnegative", onto[self.positive], at[self.positive])]


def _least(links: FloatArray) -> FloatArray:
    """Return the least eigenvalue of the pseudo-inertia of some links (L, 10)."""
    return np.asarray(np.linalg.eigvalsh(np.tensordot(links, _BASIS, 1))[:, 0])


def _closest_bodies(
    onto: FloatArray,
    at: FloatArray,
    links: NDArray[np.intp],
    centres: FloatArray,
    positive: NDArray[np.intp],
    drawn: FloatArray,
    start: FloatArray,
) -> FloatArray:
    """Return y (m,) of the x = onto y + at whose links are closest to some bodies.

        minimise sum_j tr(C_j^-1 P_j) - log det P_j + 1/2 faint |z - drawn|^2,   z >= 0

    by Newton's method with an active set of signs (Nocedal and Wright 2006, chapter 16).

    Args:
        onto, at: (n, m) and (n,).
        links: (L, 10) places of the links in x.
        centres: (L, 10) the bodies.
        positive: (k,) places of z in x.
        drawn: (k,) what z is drawn to, by very little.
        start: (m,) where all links are bodies.
    """
    from scipy.linalg import null_space

    inverse = np.linalg.inv(np.tensordot(centres, _BASIS, 1))  # (L, 4, 4)
    pull = np.einsum("lab,kba->lk", inverse, _BASIS)
    rows = onto[links]  # (L, 10, m)
    # A sign that y does not change says nothing.
    used = np.abs(onto[positive]).max(axis=1, initial=0.0) > 0
    signs, floors, drawn = onto[positive][used], at[positive][used], drawn[used]

    def value(y: FloatArray) -> float:
        P = np.tensordot(rows @ y + at[links], _BASIS, 1)
        sign, log = np.linalg.slogdet(P)
        if (sign <= 0).any() or (np.linalg.eigvalsh(P)[:, 0] <= 0).any():
            return np.inf
        beside = _FAINTEST * float(np.sum((signs @ y + floors - drawn) ** 2)) / 2
        return float(np.sum(pull * (rows @ y + at[links])) - log.sum()) + beside

    y, now = start, value(start)
    active = signs @ y + floors <= 0
    for _ in range(_STEPS):
        P = np.linalg.inv(np.tensordot(rows @ y + at[links], _BASIS, 1))
        moved = P[:, None] @ _BASIS  # (L, 10, 4, 4)
        slope = pull - np.einsum("lkaa->lk", moved)
        bend = np.einsum("lkab,liba->lki", moved, moved)
        beside = signs @ y + floors - drawn
        g = np.einsum("lkm,lk->m", rows, slope) + _FAINTEST * signs.T @ beside
        H = np.einsum("lkm,lki,lin->mn", rows, bend, rows) + _FAINTEST * signs.T @ signs
        # Along the active signs nothing moves, however badly the matrix is conditioned.
        A = signs[active]
        Z = null_space(A) if len(A) else np.eye(len(y))
        d = Z @ np.linalg.lstsq(Z.T @ H @ Z, -Z.T @ g, rcond=None)[0]
        multipliers = np.linalg.lstsq(A.T, g + H @ d, rcond=None)[0]
        falls = signs @ d
        room = np.where(~active & (falls < 0), -(signs @ y + floors) / np.minimum(falls, -1e-300),
                        np.inf)  # fmt: skip
        length = min(1.0, float(room.min(initial=np.inf)))
        if length <= _SHORTEST:  # a sign in the way
            active[int(np.argmin(room))] = True
            continue
        while length > _SHORTEST and not value(y + length * d) <= now + 0.1 * length * float(g @ d):
            length /= 2
        if length <= _SHORTEST or float(-g @ d) < _DONE:
            if length > _SHORTEST and length == 1.0:
                y = y + d
            if not (multipliers < 0).any():
                break
            active[np.flatnonzero(active)[int(np.argmin(multipliers))]] = False
            continue
        y = y + length * d
        now = value(y)
        if length == float(room.min(initial=np.inf)):
            active[int(np.argmin(room))] = True
    return y


def _length(robot: Robot) -> float:
    """Return a typical length in m: the mean of those of the geometry, or 0.1."""
    plain = robot.with_values()
    lengths = [abs(float(e)) for j in plain.joints for e in (j.b, j.d, j.r) if e != 0]
    return sum(lengths) / len(lengths) if lengths else 0.1


_MISSING = "an effect is missing from the model: symgen diagnose searches for it"
CAVEAT = (
    "base parameters do not determine link parameters: these are one of infinitely many sets that "
    "give the same torques, and a single mass or centre need not be the robot's"
)


@dataclass(frozen=True, eq=False)
class LinkParameters:
    """Physically possible standard parameters of all links, for given base parameters.

    Attributes:
        values: every standard parameter by name, in the order of the model.
        X: the base parameters that they give, (p,).
        sigmas: distance d of X from the requested one, sqrt(d' C^-1 d); 0 if they are equal.
        bodies: mass, centre and inertia of the link of each joint.
        caveat: the limits of these numbers, as a text.
    """

    values: Mapping[str, float]
    X: FloatArray
    sigmas: float
    bodies: tuple[Body, ...]
    caveat: str = CAVEAT


def link_parameters(
    model: Model,
    X: Sequence[float] | FloatArray,
    *,
    prior: Mapping[str, float] | None = None,
    nearest: FloatArray | None = None,
) -> LinkParameters:
    """Find physically possible link parameters that give the base parameters X.

    Of all such sets it returns the one whose links are closest to those of the prior, by the
    log-determinant divergence of their pseudo-inertias; without a prior, the smallest, in units of
    a typical length and mass of the robot.

    Args:
        model: from `derive`.
        X: base parameters (p,), for example `estimate.X`.
        prior: standard parameters by name, for example from CAD. The others are kept small, with a
            thousandth of the weight.
        nearest: covariance (p, p) of X, for example `estimate.covariance`. With it, the function
            replaces an impossible X by the nearest possible one, and `sigmas` is the distance.

    Raises:
        ParameterError: no link parameters give X (the message has the reason), or X or the prior
            do not belong to this robot.
    """
    problem = Feasibility(model, X)
    prior = prior or {}
    problem.require(prior)
    fault = problem.fault()
    sigmas = 0.0
    if fault:
        if nearest is None:
            raise ParameterError(
                f"{model.robot.name}: no link parameters give these base parameters: {fault}; "
                "accepted: nearest=covariance of X, for the nearest possible values"
            )
        known = problem.G @ [prior.get(name, 0.0) for name in problem.names]
        near, sigmas = problem.nearest(np.asarray(nearest, dtype=float), known)
        problem = Feasibility(model, near)
    s = problem.closest(prior)
    values = dict(zip(problem.names, map(float, s), strict=True))
    return LinkParameters(values, problem.X, sigmas, bodies(model.robot, values))


def nearest_consistent(
    model: Model, X: FloatArray, covariance: FloatArray, known: FloatArray | None = None
) -> tuple[FloatArray, float]:
    """Return the nearest physically possible base parameters, and their distance.

        minimise (X - X0)' C^-1 (X - X0)

    over parameters of links whose pseudo-inertias are positive definite, with friction and rotor
    inertia not negative.

    Args:
        model: whose parameters they are.
        X: base parameters X0, (p,).
        covariance: C of X0, (p, p).
        known: base parameters (p,), such as those of the robot's file. If a robot can have them,
            the nearest ones are at most as far.

    Returns:
        The base parameters, and sqrt((X - X0)' C^-1 (X - X0)), which is 0 if X0 is possible.

    Raises:
        ParameterError: the solver finds no possible parameters.
    """
    problem = Feasibility(model, X)
    if not problem.fault():
        return problem.X, 0.0
    return problem.nearest(covariance, known)


def consistency(
    model: Model, X: FloatArray, covariance: FloatArray, known: FloatArray | None = None
) -> Consistency:
    """Return whether base parameters are physically possible, and the distance to the nearest.

    Args:
        model: whose parameters they are.
        X: base parameters (p,).
        covariance: of X, (p, p).
        known: as for `nearest_consistent`.
    """
    try:
        problem = Feasibility(model, X)
        fault = problem.fault()
    except ParameterError as error:
        return Consistency(None, None, f"not checked: {error}")
    if not fault:
        return Consistency(True, 0.0, "bodies of positive mass can have these base parameters")
    try:
        near, sigmas = problem.nearest(covariance, known)
    except ParameterError as error:
        return Consistency(False, None, f"{fault}; {error}; {_MISSING}")
    moves = np.abs(near - X) / np.sqrt(np.diag(covariance))
    worst = int(np.argmax(moves))
    advice = no_robot_near(sigmas, len(X)) or "symgen identify --method consistent gives them"
    return Consistency(
        False,
        sigmas,
        f"{fault}; the nearest possible values differ by {sigmas:.3g} standard deviations in all "
        f"(noise alone: up to {_noise(len(X)):.2g}), at most {moves[worst]:.2g} for "
        f"{model.base.names[worst]}: {advice}",
    )


def no_robot_near(sigmas: float, p: int) -> str:
    """Return a text if p estimates are farther from the possible than noise explains, else ""."""
    return f"no possible robot is near; {_MISSING}" if sigmas > _noise(p) else ""


def _noise(p: int) -> float:
    """Return the distance of p estimates from the truth that noise exceeds in 5 % of cases.

    Fisher's approximation of the quantile of chi with p degrees of freedom.
    """
    return (math.sqrt(2 * p - 1) + 1.645) / math.sqrt(2)


@dataclass(frozen=True, eq=False)
class Consistent:
    """The most likely parameters with every link a body of positive mass (Sousa, Cortesao 2014).

    All pseudo-inertias are positive definite, and friction and rotor inertia are not negative. Of
    these parameters, the method returns those nearest to a base estimate in the metric of its
    covariance (Wensing, Kim, Slotine 2018): a semidefinite program, solved by Clarabel. If all rows
    have equal residuals, this is constrained least squares.

    Attributes:
        model: model of the robot.
        base: estimator of the base estimate.
        known: base parameters (p,), such as those of the robot's file, as in `nearest_consistent`.
    """

    model: Model
    base: Estimator = field(default_factory=Wls)
    known: FloatArray | None = None
    name: ClassVar[str] = "consistent"
    excludes: ClassVar[str] = (
        NOISE_BIAS + "; the constraints (they are those of the estimate without them, and too wide "
        "where a constraint binds)"
    )

    def solve(self, system: LinearSystem) -> Solution:
        """Solve the base estimate, then the semidefinite program.

        Raises:
            ParameterError: no consistent parameters are found.
        """
        return self.bounded(self.base.solve(system), system.names)

    def bounded(self, free: Solution, names: tuple[str, ...]) -> Solution:
        """Return the solution nearest to an unconstrained one; raises the errors of `solve`."""
        near, sigmas = nearest_consistent(self.model, free.X, free.covariance, self.known)
        moved = (
            f"the physically possible parameters differ from the {self.base.name} estimate by "
            f"{sigmas:.3g} standard deviations in all"
            if sigmas
            else f"the {self.base.name} estimate is physically possible and is kept"
        )
        far = no_robot_near(sigmas, len(near))
        return replace(
            free,
            X=near,
            notes=(*free.notes, *filter(None, (far, moved))),
            comparison=(
                OtherEstimate.by(self.base.name, names, free.X, free.std),
                *free.comparison,
            ),
        )


#: kg: no robot moves like less than a few coins at every joint, nor like more than a lorry.
LIGHTEST, HEAVIEST = 0.02, 5000.0
_BODY = 0.1  # m of a last link beyond its frame
_STATES = 200


def implausible(evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray) -> str:
    """Return a note if a robot would be absurdly heavy or light, else "".

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the training logs.
        X: (p,) base parameters.
    """
    reach = _reach(evaluator.model.robot.with_values())
    q = np.concatenate([log.q[log.kept] for log in logs])
    q = np.ascontiguousarray(q[:: max(1, len(q) // _STATES)])
    inertia = np.mean(np.einsum("kjj->kj", mass_matrices(evaluator, q, X)), axis=0)
    masses = np.abs(inertia) / reach**2
    least, most = float(masses.min()), float(masses.max())
    if least <= HEAVIEST and most >= LIGHTEST:
        return ""
    seen = f"{least:.3g} kg at least" if least > HEAVIEST else f"{most:.3g} kg at most"
    return (
        f"every joint moves like {seen} at the end of the arm: look at the units of the log "
        "(N m, not N mm; N; rad; m; s)"
    )


def _reach(robot: Robot) -> FloatArray:
    """Return the reach of the robot from each joint, m (1 if prismatic), (n,)."""
    lengths = {j.number: sum(abs(float(x)) for x in (j.b, j.d, j.r)) for j in robot.joints}
    out = [
        _BODY + sum(x for number, x in lengths.items() if number > joint.number)
        if joint.sigma == REVOLUTE
        else 1.0
        for joint in robot.movable
    ]
    return np.array(out)
