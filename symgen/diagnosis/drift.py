"""Which parameter of which robot changed since when, from one estimate a robot and day.

For a parameter and a day c the contrast is the mean from day c on less the mean before, weighted by
1/std^2,

    z = (after - before) / (f std),   p = looks * P(|t| > |z|)

with f, at least 1, by how much estimates scatter from day to day beyond their std: the median over
all robots of the differences of consecutive days, which the few that changed do not move. `looks`
counts robots, parameters and days: the chance of one false alarm in the whole fleet is at most the
level (Bonferroni). A robot that was another from its first day on is compared with a reference, or
with the median of the fleet, and the scatter from robot to robot belongs to its std.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import NORMAL
from symgen.estimation.statistics import f_tail
from symgen.names import LINK

FloatArray = NDArray[np.float64]
#: Chance of one false alarm in a fleet; share of a change's chi-square that a load must explain.
LEVEL, EXPLAINED = 0.01, 0.9
_EFFICIENCY = 0.37  # of a median absolute deviation beside a standard deviation, normal law
_FEWEST = 4  # differences from day to day for a scatter of their own
_FRICTION = {"FS": "coulomb_friction", "FV": "viscous_friction", "OF": "torque_offset"}
_TIED = 1e-3  # of the largest singular value of a load's columns, each in its std


@dataclass(frozen=True, eq=False)
class Course:
    """The estimates of one robot.

    Attributes:
        robot: its name.
        days: in their order.
        X: (D, p).
        covariance: (D, p, p).
    """

    robot: str
    days: tuple[str, ...]
    X: FloatArray
    covariance: FloatArray

    @property
    def variance(self) -> FloatArray:
        """(D, p)."""
        return np.asarray(np.maximum(np.einsum("dii->di", self.covariance), 1e-300))

    def mean(self, days: slice) -> tuple[FloatArray, FloatArray]:
        """Return the mean of some days and its variance, (p,) each."""
        weight = 1 / self.variance[days]
        total = weight.sum(axis=0)
        mean: FloatArray = (weight * self.X[days]).sum(axis=0) / total
        return mean, 1 / total

    def spread(self, days: slice) -> FloatArray:
        """Return the covariance of that mean, (p, p), days alike."""
        count = len(range(*days.indices(len(self.X))))
        return np.asarray(self.covariance[days].mean(axis=0) / count)


@dataclass(frozen=True)
class Moved:
    """One parameter that moved: before, after, and the standard deviation of the difference."""

    name: str
    before: float
    after: float
    std: float

    @property
    def percent(self) -> float:
        """The difference over the size before, in percent; infinite from zero."""
        change = self.after - self.before
        return 100 * change / abs(self.before) if self.before else math.copysign(math.inf, change)


@dataclass(frozen=True, eq=False)
class Step:
    """A robot whose parameters are others from a day on.

    Attributes:
        robot: its name.
        since: the first day with the new ones.
        first: whether that is the robot's first day.
        moved: parameters beyond chance.
        change: of all parameters, (p,).
        covariance: of the change, (p, p).
        p_value: of the surest, corrected for all looks.
        strength: sum of z^2 of those that moved.
    """

    robot: str
    since: str
    first: bool
    moved: tuple[Moved, ...]
    change: FloatArray
    covariance: FloatArray
    p_value: float
    strength: float


def scatter(courses: Sequence[Course]) -> FloatArray:
    """Return by how much estimates scatter from day to day over their std, (p,), at least 1."""
    apart = [
        np.diff(c.X, axis=0) / np.sqrt(c.variance[1:] + c.variance[:-1])
        for c in courses
        if len(c.X) > 1
    ]
    if sum(map(len, apart)) < _FEWEST:
        return np.ones(courses[0].X.shape[1])
    return np.maximum(NORMAL * np.median(np.abs(np.concatenate(apart)), axis=0), 1.0)


def steps(
    courses: Sequence[Course], names: Sequence[str], reference: FloatArray | None = None
) -> list[Step]:
    """Find the robots that changed, at their surest day, or were others from the first day on.

    Args:
        courses: of all robots.
        names: of the parameters.
        reference: (p,) what a robot should be; None for the median of the fleet, where it is large
            enough to tell one robot from the others.
    """
    factor = scatter(courses)
    freedom = max(sum(len(c.X) - 1 for c in courses), 4)
    looks = sum(len(c.X) for c in courses) * len(names)
    base = _Fleet.of(courses, reference)
    look = _Look(tuple(names), factor, freedom, looks)
    out = []
    for c in courses:
        found = []
        for k in range(1, len(c.X)):
            before = slice(0, k)
            found.append(
                look.contrast(c, c.mean(before), c.spread(before), slice(k, None), freedom)
            )
        changed = max(found, key=lambda step: step.strength, default=None)
        if changed is not None and not changed.moved:
            changed = None
        if base is not None:  # the days before that: was it another from the first one on?
            days = slice(0, len(c.X) if changed is None else c.days.index(changed.since))
            other = (base.centre, base.variance)
            first = look.contrast(
                c, other, np.diag(base.variance), days, _EFFICIENCY * len(courses), own=False
            )
            out += [first] if first.moved else []
        out += [] if changed is None else [changed]
    return out


@dataclass(frozen=True, eq=False)
class _Look:
    """What all contrasts share: names, the scatter of days, its degrees of freedom, and looks."""

    names: tuple[str, ...]
    factor: FloatArray
    freedom: int
    looks: int

    def contrast(
        self,
        course: Course,
        before: tuple[FloatArray, FloatArray],
        covariance: FloatArray,
        days: slice,
        degrees: float,
        own: bool = True,
    ) -> Step:
        """Compare the mean of some days with what was before.

        Args:
            course: of the robot.
            before: mean and variance, (p,) each.
            covariance: of that mean, (p, p).
            days: that are compared.
            degrees: of freedom of the variance before.
            own: whether it is that of other days of the robot, whose scatter it shares.
        """
        scale = self.factor if own else np.ones(len(self.factor))
        after, variance = course.mean(days)
        variance, other = self.factor**2 * variance, scale**2 * before[1]
        std, change = np.sqrt(variance + other), after - before[0]
        z = change / std
        # Satterthwaite's: the scatter from robot to robot is that of few
        freedom = std**4 / (variance**2 / self.freedom + other**2 / degrees)
        tails = [f_tail(float(x * x), 1, float(f)) for x, f in zip(z, freedom, strict=True)]
        p = np.minimum(self.looks * np.array(tails), 1.0)
        sure = [int(i) for i in np.flatnonzero(p < LEVEL)]
        moved = tuple(
            Moved(self.names[i], float(before[0][i]), float(after[i]), float(std[i])) for i in sure
        )
        whole = np.outer(self.factor, self.factor) * course.spread(days)
        whole = whole + np.outer(scale, scale) * covariance
        strength = float(np.sum(z[sure] ** 2))
        since = course.days[days.start]
        return Step(course.robot, since, not own, moved, change, whole, float(p.min()), strength)


@dataclass(frozen=True, eq=False)
class _Fleet:
    """What a robot of the fleet is, (p,), and the variance from robot to robot, (p,)."""

    centre: FloatArray
    variance: FloatArray

    @classmethod
    def of(cls, courses: Sequence[Course], reference: FloatArray | None) -> _Fleet | None:
        """Take it from the robots' first days; None where too few can tell."""
        if reference is None and len(courses) < _FEWEST + 1:
            return None
        first = np.stack([c.X[0] for c in courses])
        centre = np.median(first, axis=0) if reference is None else reference
        own = np.median([c.variance[0] for c in courses], axis=0)
        apart = (NORMAL * np.median(np.abs(first - np.median(first, axis=0)), axis=0)) ** 2
        return cls(centre, np.maximum(apart - own, 0.0) if len(courses) > _FEWEST else 0.0 * own)


@dataclass(frozen=True)
class Named:
    """What a step is.

    Attributes:
        effect: a name of the effect library, or "" where parameters alone do not tell.
        joints: numbers of the joints.
        values: name, value and standard deviation: of the change, or of the load.
        says: in words.
    """

    effect: str
    joints: tuple[int, ...]
    values: tuple[tuple[str, float, float], ...]
    says: str


def named(step: Step, names: Sequence[str], load: FloatArray, link: int) -> list[Named]:
    """Name a step by what moved: friction of a joint, a load on the last link, or neither.

    Args:
        step: of a robot.
        names: of the parameters.
        load: (p, 10) what the link parameters XX .. MZ, M of a load add to X.
        link: number of the joint that carries it.
    """
    out: list[Named] = []
    inertial = [m for m in step.moved if _friction(m.name) is None]
    if inertial:
        carried = _load(step, names, load, link)
        out.append(carried or Named("", (), _values(inertial), _listed(inertial)))
    joints: dict[int, list[Moved]] = {}
    for m in step.moved:
        friction = _friction(m.name)
        if friction is not None:
            joints.setdefault(friction[1], []).append(m)
    for j, moved in joints.items():
        kinds = dict.fromkeys(_FRICTION[m.name[:2]] for m in moved)
        word = "up" if sum(m.after - m.before for m in moved) > 0 else "down"
        what = "offset" if list(kinds) == ["torque_offset"] else "friction"
        sizes = ", ".join(f"{m.name} {m.percent:+.0f} %" for m in moved)
        out += [
            Named(kind, (j,), _values([m for m in moved if _FRICTION[m.name[:2]] == kind]),
                  f"{what} of joint {j} {word} ({sizes})")
            for kind in kinds
        ]  # fmt: skip
    return out


def _friction(name: str) -> tuple[str, int] | None:
    found = re.fullmatch(r"(FS|FV|OF)(\d+)R?", name)
    return None if found is None else (found[1], int(found[2]))


def _values(moved: Sequence[Moved]) -> tuple[tuple[str, float, float], ...]:
    return tuple((m.name, m.after - m.before, m.std) for m in moved)


def _listed(moved: Sequence[Moved]) -> str:
    largest = sorted(moved, key=lambda m: -abs(m.after - m.before) / m.std)[:4]
    return ", ".join(f"{m.name} {m.percent:+.0f} %" for m in largest)


def _load(step: Step, names: Sequence[str], load: FloatArray, link: int) -> Named | None:
    """Return the load that a step is, where one explains it.

    minimise (d - G s)' C^-1 (d - G s) over the link parameters s of the load, d the step.
    """
    own = [i for i, name in enumerate(names) if _friction(name) is None]
    std = np.sqrt(np.diag(step.covariance))[own]
    C = step.covariance[np.ix_(own, own)] / np.outer(std, std)
    values, vectors = np.linalg.eigh(C)
    root = (vectors / np.sqrt(np.maximum(values, 1e-6 * values[-1]))).T
    d, G = root @ (step.change[own] / std), root @ (load[own] / std[:, None])
    size = np.linalg.norm(G, axis=0)
    filled = np.flatnonzero(size > 0)
    if len(filled) == 0 or not float(d @ d) > 0:
        return None
    U, singular, turn = np.linalg.svd(G[:, filled] / size[filled], full_matrices=False)
    kept = singular > _TIED * singular[0]
    s = np.zeros(10)
    s[filled] = (turn[kept].T / singular[kept]) @ (U[:, kept].T @ d) / size[filled]
    left = float(np.sum((d - G @ s) ** 2))
    if left > (1 - EXPLAINED) * float(d @ d) + 3 * len(own):
        return None
    spread = (turn[kept].T / singular[kept]) @ (turn[kept].T / singular[kept]).T
    stds = np.zeros(10)
    stds[filled] = np.sqrt(np.diag(spread)) / size[filled]
    mass, error = float(s[9]), float(stds[9])
    sure = [k for k in range(10) if stds[k] > 0 and abs(s[k]) > 3 * stds[k]]
    told = tuple((f"{LINK[k]}L", float(s[k]), float(stds[k])) for k in sure)
    if not told or (error > 0 and mass < -3 * error):
        return None
    says = "payload" + (f" {mass:.3g} +- {error:.1g} kg" if 9 in sure else "")
    return Named("payload", (link,), told, says)
