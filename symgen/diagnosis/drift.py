"""Detect changes of parameters in a fleet, from one estimate for each robot and day.

For a parameter and a day c, the contrast is the mean from day c on minus the mean before, weighted
by 1/std^2,

    z = (after - before) / (f std),   p = looks * P(|t| > |z|)

The factor f, at least 1, is the scatter of estimates from day to day relative to their std. It is
the median over all robots of the differences of consecutive days, so the few changed robots do not
affect it. `looks` counts robots, parameters and days: the probability of a false alarm in the whole
fleet is at most the level (Bonferroni). A robot that differs from its first day on is compared with
a reference, or with the median of the fleet. Its std then includes the scatter between robots.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symgen.data.signals import NORMAL
from symgen.estimation.statistics import f_tail
from symgen.estimation.values import FloatArray
from symgen.names import LINK
from symgen.schemas import OrNan

#: Probability of one false alarm in a fleet; share of a change's chi-square that a load must
#: explain.
LEVEL, EXPLAINED = 0.01, 0.9
_EFFICIENCY = 0.37  # median absolute deviation: efficiency relative to the std, normal distribution
_FEWEST = 4  # smallest number of day-to-day differences for which a scatter is estimated
_FRICTION = {"FS": "coulomb_friction", "FV": "viscous_friction", "OF": "torque_offset"}
_TIED = 1e-3  # singular value of a load's columns over the largest, in units of their std


class Shift(NamedTuple):
    """A change of a parameter or its value, with the standard deviation."""

    name: str
    value: OrNan
    std: OrNan


@dataclass(frozen=True)
class Finding:
    """A robot that changed or stands out.

    Attributes:
        robot: name of the robot.
        since: first day of the change.
        effect: name of the effect, "" if none explains the change.
        joints: numbers of the joints.
        parameters: name, value and standard deviation of the changes, or of a load.
        p_value: p-value, corrected for the number of robots, parameters and days.
        says: a text about the change.
    """

    robot: str
    since: str
    effect: str
    joints: tuple[int, ...]
    parameters: tuple[Shift, ...]
    p_value: OrNan
    says: str


class Mean(NamedTuple):
    """A mean of estimates.

    Attributes:
        X: (p,) the mean.
        variance: (p,) its variance.
        covariance: (p, p) its covariance, without day-to-day scatter.
        freedom: degrees of freedom of the variance.
    """

    X: FloatArray
    variance: FloatArray
    covariance: FloatArray
    freedom: float


@dataclass(frozen=True, eq=False)
class Course:
    """The estimates of one robot.

    Attributes:
        robot: name of the robot.
        days: days in order.
        X: (D, p) estimates.
        covariance: (D, p, p) their covariances.
    """

    robot: str
    days: tuple[str, ...]
    X: FloatArray
    covariance: FloatArray

    @property
    def variance(self) -> FloatArray:
        """(D, p) variances of the estimates."""
        return np.asarray(np.maximum(np.einsum("dii->di", self.covariance), 1e-300))

    def mean(self, days: slice, factor: FloatArray | float = 1.0, freedom: float = 1.0) -> Mean:
        """Return the mean of some days, if estimates scatter by `factor` (p,) times their std."""
        weight = 1 / self.variance[days]
        total = weight.sum(axis=0)
        C = self.covariance[days]
        scale = np.ones(self.X.shape[1]) * factor
        spread = np.outer(scale, scale) * (C.mean(axis=0) / len(C))
        X = (weight * self.X[days]).sum(axis=0) / total
        return Mean(X, scale**2 / total, spread, freedom)


class Moved(NamedTuple):
    """One parameter that moved: before, after, and the standard deviation of the difference."""

    name: str
    before: float
    after: float
    std: float

    @property
    def change(self) -> float:
        """Value after minus value before."""
        return self.after - self.before

    @property
    def says(self) -> str:
        """The change relative to the value before, in percent; infinite if that is zero."""
        percent = math.copysign(math.inf, self.change)
        if self.before:
            percent = 100 * self.change / abs(self.before)
        return f"{self.name} {percent:+.0f} %"


@dataclass(frozen=True, eq=False)
class Step:
    """A robot whose parameters changed on a day.

    Attributes:
        robot: name of the robot.
        since: first day with the new parameters.
        first: true if that is the robot's first day.
        moved: parameters with a significant change.
        change: (p,) change of all parameters.
        covariance: (p, p) covariance of the change.
        p_value: of the most significant parameter, corrected for `looks`.
        strength: sum of z^2 of the parameters in `moved`.
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
    """Return the day-to-day scatter of estimates relative to their std, (p,), at least 1."""
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
    """Find robots that changed, with the most significant day, or that differ from the start.

    Args:
        courses: estimates of all robots.
        names: names of the parameters.
        reference: (p,) expected parameters; None for the median of the fleet, if it has enough
            robots.
    """
    factor = scatter(courses)
    freedom = max(sum(len(c.X) - 1 for c in courses), 4)
    looks = sum(len(c.X) for c in courses) * len(names)
    fleet = _of_fleet(courses, reference)

    def contrast(course: Course, days: slice, before: Mean | None = None) -> Step:
        """Compare the mean of some days with `before`, or with the mean of the days before them."""
        old = before or course.mean(slice(0, days.start), factor, freedom)
        new = course.mean(days, factor, freedom)
        std, change = np.sqrt(new.variance + old.variance), new.X - old.X
        z = change / std
        # Satterthwaite: the scatter between few robots has few degrees of freedom
        degrees = std**4 / (new.variance**2 / freedom + old.variance**2 / old.freedom)
        tails = [f_tail(float(x * x), 1, float(f)) for x, f in zip(z, degrees, strict=True)]
        p = np.minimum(looks * np.array(tails), 1.0)
        sure = np.flatnonzero(p < LEVEL)
        rows = zip(names, old.X.tolist(), new.X.tolist(), std.tolist(), strict=True)
        moved = tuple(Moved(*row) for row, small in zip(rows, p < LEVEL, strict=True) if small)
        whole, strength = new.covariance + old.covariance, float(np.sum(z[sure] ** 2))
        since, first = course.days[days.start], before is not None
        return Step(course.robot, since, first, moved, change, whole, float(p.min()), strength)

    out = []
    for c in courses:
        later = [contrast(c, slice(k, None)) for k in range(1, len(c.X))]
        surest = max(later, key=lambda step: step.strength, default=None)
        changed = [] if surest is None or not surest.moved else [surest]
        if fleet is not None:  # did the robot differ from the fleet from its first day on?
            days = slice(0, c.days.index(changed[0].since) if changed else len(c.X))
            first = contrast(c, days, fleet)
            out += [first] if first.moved else []
        out += changed
    return out


def _of_fleet(courses: Sequence[Course], reference: FloatArray | None) -> Mean | None:
    """Return the mean of the robots' first days; None if there are too few robots."""
    if reference is None and len(courses) <= _FEWEST:
        return None
    first = np.stack([c.X[0] for c in courses])
    middle = np.median(first, axis=0)
    own = np.median([c.variance[0] for c in courses], axis=0)
    apart = (NORMAL * np.median(np.abs(first - middle), axis=0)) ** 2
    variance = np.maximum(apart - own, 0.0) if len(courses) > _FEWEST else 0.0 * own
    centre = middle if reference is None else reference
    return Mean(centre, variance, np.diag(variance), _EFFICIENCY * len(courses))


def named(step: Step, names: Sequence[str], load: FloatArray, link: int) -> list[Finding]:
    """Explain a step by friction of a joint or by a load, where one of them does.

    Args:
        step: the step of a robot.
        names: names of the parameters.
        load: (p, 10) derivative of X by the link parameters XX .. MZ, M of a load.
        link: number of the joint that carries the load.
    """

    def finding(
        effect: str, joints: tuple[int, ...], values: Iterable[Shift], says: str
    ) -> Finding:
        return Finding(step.robot, step.since, effect, joints, tuple(values), step.p_value, says)

    out: list[Finding] = []
    joints: dict[int, list[Moved]] = {}
    inertial: list[Moved] = []
    for m in step.moved:
        friction = _friction(m.name)
        (inertial if friction is None else joints.setdefault(friction[1], [])).append(m)
    if inertial:
        carried = _load(step, names, load)
        largest = sorted(inertial, key=lambda m: -abs(m.change) / m.std)[:4]
        out.append(
            finding("", (), _values(inertial), ", ".join(m.says for m in largest))
            if carried is None
            else finding("payload", (link,), *carried)
        )
    for j, moved in joints.items():
        kinds = dict.fromkeys(_FRICTION[m.name[:2]] for m in moved)
        word = "up" if sum(m.change for m in moved) > 0 else "down"
        what = "offset" if list(kinds) == ["torque_offset"] else "friction"
        says = f"{what} of joint {j} {word} ({', '.join(m.says for m in moved)})"
        for kind in kinds:
            own = _values(m for m in moved if _FRICTION[m.name[:2]] == kind)
            out.append(finding(kind, (j,), own, says))
    return out


def _friction(name: str) -> tuple[str, int] | None:
    found = re.fullmatch(r"(FS|FV|OF)(\d+)R?", name)
    return None if found is None else (found[1], int(found[2]))


def _values(moved: Iterable[Moved]) -> list[Shift]:
    return [Shift(m.name, m.change, m.std) for m in moved]


def _load(
    step: Step, names: Sequence[str], load: FloatArray
) -> tuple[tuple[Shift, ...], str] | None:
    """Return the load that explains a step and a text about it; None if no load does.

    Minimises (d - G s)' C^-1 (d - G s) over the link parameters s of the load, with the step d.
    """
    own = [i for i, name in enumerate(names) if _friction(name) is None]
    std = np.sqrt(np.diag(step.covariance))[own]
    values, vectors = np.linalg.eigh(step.covariance[np.ix_(own, own)] / np.outer(std, std))
    root = (vectors / np.sqrt(np.maximum(values, 1e-6 * values[-1]))).T
    d, G = root @ (step.change[own] / std), root @ (load[own] / std[:, None])
    size = np.linalg.norm(G, axis=0)
    filled = np.flatnonzero(size > 0)
    if not len(filled) or not float(d @ d) > 0:
        return None
    inverse = np.linalg.pinv(G[:, filled] / size[filled], rcond=_TIED) / size[filled, None]
    s, stds = np.zeros((2, 10))
    s[filled], stds[filled] = inverse @ d, np.linalg.norm(inverse, axis=1)
    if float(np.sum((d - G @ s) ** 2)) > (1 - EXPLAINED) * float(d @ d) + 3 * len(own):
        return None
    sure = (stds > 0) & (np.abs(s) > 3 * stds)
    rows = zip(LINK, s.tolist(), stds.tolist(), strict=True)
    told = tuple(Shift(f"{row[0]}L", *row[1:]) for row, is_ in zip(rows, sure, strict=True) if is_)
    mass, error = float(s[9]), float(stds[9])
    if not told or (error > 0 and mass < -3 * error):
        return None
    return told, "payload" + (f" {mass:.3g} +- {error:.1g} kg" if sure[9] else "")
