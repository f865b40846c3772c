"""What link parameters must obey to exist, and the nearest that do: semidefinite programs.

Base parameters X = G s are realisable when some s gives them with every link a body of positive
mass density, and friction and rotor inertia not negative (see physical.py). Every base parameter is
led by a standard parameter that no other contains: the rest are free variables, and X = G s holds
to rounding. Units are a typical length and mass of the robot, in which the entries of a
pseudo-inertia compare. Clarabel solves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.identification.parameters import regrouping
from symgen.identification.physical.bodies import pseudo_inertia
from symgen.identification.physical.conic import Cone, minimise, triangle_vector
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]
#: Smallest eigenvalue of a pseudo-inertia, in the robot's units, that counts as positive ...
_CERTAIN = 1e-8
#: ... that the nearest consistent parameters keep ...
_NEAREST = 1e-5
#: ... and above which a robot is not asked for more.
_ENOUGH = 1e-3
#: Largest trace of a pseudo-inertia, in the robot's units.
_LARGEST = 100.0
#: Weight of the size of what a prior does not name, and of size in the search for the nearest.
_FAINT, _FAINTEST, _TINY = 1e-3, 1e-6, 1e-12
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
    """What the parameters of one robot must obey, in its own units: x = s / scale.

    Raises:
        ParameterError: X are not finite base parameters of this robot.
    """

    def __init__(self, model: Model, X: Sequence[float] | FloatArray) -> None:
        base, self.robot = model.base, model.robot.name
        self.parameters = base.parameters
        self.names = [p.name for p in base.standard]
        self.prefix = {p.name: p.prefix for p in base.standard}
        self.X = np.array(X, dtype=float)
        if self.X.shape != (len(base.parameters),) or not np.isfinite(self.X).all():
            raise ParameterError(
                f"{self.robot}: X is not {len(base.parameters)} finite base parameters"
            )
        self.G = regrouping(model)
        self.heads = [p.index for p in base.parameters]
        self.free = sorted(set(range(len(self.names))) - set(self.heads))
        first = [i for i, p in enumerate(base.standard) if p.prefix == names.LINK[0]]
        self.links = [list(range(i, i + len(names.LINK))) for i in first]
        within = {i for link in self.links for i in link}
        self.positive = [
            i for i, p in enumerate(base.standard) if p.prefix in POSITIVE and i not in within
        ]
        length = _length(model.robot)
        scale = [
            f * length**power for f, power in (_UNITS.get(p.unit, (1, 0)) for p in base.standard)
        ]
        heads = self.heads[: base.inertial]
        mass = float(np.max(np.abs(self.X[: len(heads)]) / np.take(scale, heads), initial=0.0))
        self.scale = np.array(scale) * (mass or 1.0)
        # x = onto y + at: the free parameters y, and the leading ones that X leaves
        self.onto = np.zeros((len(self.names), len(self.free)))
        self.onto[self.free, range(len(self.free))] = 1.0
        self.onto[self.heads] = -self.G[:, self.free] * self.scale[self.free]
        self.onto[self.heads] /= self.scale[self.heads, None]
        self.at = np.zeros(len(self.names))
        self.at[self.heads] = self.X / self.scale[self.heads]

    def require(self, prior: Mapping[str, float]) -> None:
        """Refuse a prior that does not hold finite standard parameters of this robot."""
        for name, value in prior.items():
            if name not in self.prefix:
                raise ParameterError(
                    f"{self.robot}: the prior's {name} is no standard parameter; accepted: "
                    f"{', '.join(self.names[:11])}, ..."
                )
            number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
            if not number or not math.isfinite(value):
                raise ParameterError(
                    f"{self.robot}: the prior's {name} is {value!r}; accepted: a finite number"
                )

    def fault(self) -> str:
        """Return in words why no link parameters give X, or ''."""
        wrong = [
            f"{p.name} is {x:.4g} and cannot be negative" + f" ({p.expression})" * bool(p.terms)
            for row, p, x in zip(self.G, self.parameters, self.X, strict=True)
            if x < 0 and self._adds_up_positive(row)
        ]
        if wrong:
            return "; ".join(wrong[:3]) + (f"; {len(wrong) - 3} more" if len(wrong) > 3 else "")
        margin, blame = self.margin
        if margin > _CERTAIN:
            return ""
        worst = sorted(k for k in np.argsort(-blame, kind="stable")[:3] if blame[k] > _BLAMED)
        links = [f"link {self.names[self.links[k][0]].removeprefix('XX')}" for k in worst]
        return f"the inertia of {' and '.join(links)} cannot be positive definite"

    def _adds_up_positive(self, row: FloatArray) -> bool:
        """Say whether a base parameter is a sum of what is never negative."""
        members = np.flatnonzero(row)
        kinds = {self.prefix[self.names[i]] for i in members}
        return bool((row > 0)[members].all()) and kinds <= {*_DIAGONAL, *POSITIVE}

    @cached_property
    def margin(self) -> tuple[float, FloatArray]:
        """The largest t with P_j - t I positive semidefinite for every link j, up to 1e-3.

        X is realisable when it is positive. The second value is the share of each link in what
        binds t: the trace of its dual matrix.
        """
        onto = np.pad(self.onto, ((0, 0), (0, 1)))
        t = np.eye(onto.shape[1])[-1]
        cones = [
            Cone(
                "semidefinite",
                MATRIX @ onto[link] - np.outer(IDENTITY, t),
                MATRIX @ self.at[link],
            )
            for link in self.links
        ]
        cones += [Cone("nonnegative", onto[self.positive], self.at[self.positive])]
        trace = np.zeros((len(self.links), len(self.names)))
        for j, link in enumerate(self.links):
            trace[j, link] = IDENTITY @ MATRIX
        cones += [
            Cone("nonnegative", -trace @ onto, _LARGEST - trace @ self.at),
            Cone("nonnegative", -t[None], np.array([_ENOUGH])),
        ]
        y, duals = minimise(np.zeros((len(t), len(t))), -t, cones)
        return float(y[-1]), np.array([IDENTITY @ z for z in duals[: len(self.links)]])

    def closest(self, prior: Mapping[str, float]) -> FloatArray:
        """Return the standard parameters s that give X and come closest to the prior."""
        target = np.array([float(prior.get(name, 0.0)) for name in self.names]) / self.scale
        named = np.array([name in prior for name in self.names])
        weights = np.where(named | (not prior), 1.0, _FAINT)
        # Half of what all links can have at once, but no more than a link has in the prior.
        floors = np.full(len(self.links), self.margin[0] / 2)
        for j, link in enumerate(self.links):
            if named[link].all():
                own = float(np.linalg.eigvalsh(pseudo_inertia(target[link]))[0])
                floors[j] = min(floors[j], max(own, _CERTAIN))
        weighted = self.onto.T * weights
        y, _ = minimise(
            weighted @ self.onto,
            weighted @ (self.at - target),
            self._consistent(self.onto, self.at, floors),
        )
        s: FloatArray = (self.onto @ y + self.at) * self.scale
        s[self.positive] = np.maximum(s[self.positive], 0.0)
        s[self.heads] = self.X - self.G[:, self.free] @ s[self.free]
        s[self.positive] = np.maximum(s[self.positive], 0.0)  # -1e-17, from the line above
        return s

    def nearest(
        self,
        covariance: FloatArray,
        divergence: float = 0.0,
        towards: Mapping[str, float] | None = None,
    ) -> tuple[FloatArray, float]:
        """Return the nearest base parameters that a robot can have, and how far they are."""
        whiten = _whitening(covariance, len(self.X))
        n, p = len(self.names), len(self.X)
        # In units of the most precise direction: deviations may span many decades.
        precise = float(np.linalg.norm(whiten @ self.G * self.scale, 2))
        unit = whiten / precise
        cones, linear = self._log_det(n + p, towards or {}) if divergence else ([], np.zeros(n + p))
        size = len(linear)
        distance = np.zeros((p, size))
        distance[:, :n], distance[:, n : n + p] = unit @ self.G * self.scale, -np.eye(p)
        floors = np.full(len(self.links), _NEAREST)
        bound = self._consistent(np.eye(n, size), np.zeros(n), floors)
        faint = np.full(n, max(_FAINTEST / precise**2, _TINY))
        y, _ = minimise(
            np.diag([*faint, *np.ones(p), *np.zeros(size - n - p)]),
            divergence / precise**2 * linear,
            [Cone("zero", distance, -unit @ self.X), *bound, *cones],
        )
        s = y[:n] * self.scale
        s[self.positive] = np.maximum(s[self.positive], 0.0)
        near: FloatArray = self.G @ s
        return near, float(np.linalg.norm(whiten @ (near - self.X)))

    def _log_det(self, first: int, towards: Mapping[str, float]) -> tuple[list[Cone], FloatArray]:
        """Return the cones and the linear objective of the divergence of all links.

        log det P is the largest sum of u_i with u_i <= log L_ii and [[P, L], [L', diag L]] positive
        semidefinite, L lower triangular (Ben-Tal and Nemirovski 2001). The variables of link j,
        ten of L and four of u, follow at `first` + 14 j.
        """
        size = first + 14 * len(self.links)
        linear = np.zeros(size)
        cones = []
        lower = [(i, k) for i in range(4) for k in range(i + 1)]
        for j, link in enumerate(self.links):
            at = first + 14 * j
            E = np.zeros((36, size))
            for column, unit in zip(link, np.eye(len(link)), strict=True):
                E[:, column] = _block(pseudo_inertia(unit), np.zeros((4, 4)))
            for m, (i, k) in enumerate(lower):
                single = np.zeros((4, 4))
                single[i, k] = 1.0
                E[:, at + m] = _block(np.zeros((4, 4)), single)
                if i == k:
                    e = np.zeros((3, size))
                    e[0, at + 10 + i] = e[2, at + m] = 1.0
                    cones.append(Cone("exponential", e, np.array([0.0, 1.0, 0.0])))
            cones.append(Cone("semidefinite", E, np.zeros(36)))
            linear[at + 10 : at + 14] = -1.0
            linear[link] = triangle_vector(self._reference(link, towards)) @ MATRIX
        return cones, linear

    def _reference(self, link: list[int], towards: Mapping[str, float]) -> FloatArray:
        """Return the inverse of P0 of a link, in the robot's units."""
        if all(self.names[i] in towards for i in link):
            P = pseudo_inertia(np.array([towards[self.names[i]] for i in link]) / self.scale[link])
            if float(np.linalg.eigvalsh(P)[0]) > _CERTAIN:
                return np.asarray(np.linalg.inv(P), dtype=float)
        return np.eye(4)

    def _consistent(self, onto: FloatArray, at: FloatArray, floors: FloatArray) -> list[Cone]:
        """Return the cones of x = onto y + at: links as bodies, and what is never negative."""
        out = [
            Cone("semidefinite", MATRIX @ onto[link], MATRIX @ at[link] - floor * IDENTITY)
            for link, floor in zip(self.links, floors, strict=True)
        ]
        return [*out, Cone("nonnegative", onto[self.positive], at[self.positive])]


#: The pseudo-inertia of ten link parameters as a vector of the solver, and the unit matrix.
MATRIX = np.array([triangle_vector(pseudo_inertia(unit)) for unit in np.eye(len(names.LINK))]).T
IDENTITY = triangle_vector(np.eye(4))


def _block(P: FloatArray, L: FloatArray) -> FloatArray:
    """Return [[P, L], [L', diag L]] as a vector of the solver."""
    return triangle_vector(np.block([[P, L], [L.T, np.diag(np.diag(L))]]))


def _length(robot: Robot) -> float:
    """Return a typical length in m: the mean of those of the geometry, or 0.1."""
    plain = robot.with_values()
    lengths = [abs(float(e)) for j in plain.joints for e in (j.b, j.d, j.r) if e != 0]
    return sum(lengths) / len(lengths) if lengths else 0.1


def _whitening(covariance: FloatArray, p: int) -> FloatArray:
    """Return W (p, p) with W'W the inverse of a covariance."""
    std = np.sqrt(np.diag(covariance)) if covariance.shape == (p, p) else np.zeros(p)
    if not (np.isfinite(covariance).all() and (std > 0).all()):
        raise ParameterError(f"the covariance is not a ({p}, {p}) matrix with a positive diagonal")
    values, vectors = np.linalg.eigh(covariance / np.outer(std, std))
    whiten: FloatArray = vectors.T / np.sqrt(np.maximum(values, _TIED))[:, None] / std
    return whiten
