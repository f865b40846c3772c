"""The torque that the drive of each joint gives per unit of its input, from logs of that input.

A servo that reports its duty, or its voltage, gives the torque

    tau_j = a_j u_j - b_j qd_j,    a = N kt V/R,  b = N^2 kt^2/R

at the joint: ratio N, torque constant kt, resistance R of the winding, supply V. The back-EMF b qd
has the form of viscous friction, so X contains both. With the torque regressor Y, a load s in the
logs that carry it, and noise of u:

    u_j = Y_j (X + c G s)/a_j,    c = 1 in logs with the load, 0 in those without

X, the unknown part of s, and log a come from Gauss-Newton steps of weighted least squares. The
linear equations for a with u as a column are only the start: noise in a column shrinks all values.

Nothing in u tells X from a multiple of X with the same multiple of a. A known mass tells it, or a
prior: values of the motors from a catalogue, or the masses of the robot file. The null space of the
equations shows which scales follow from these. The scale of other joints is that of a reference.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symgen.codegen.model import regrouping
from symgen.data.mask import Bools, rms
from symgen.data.raw import Places
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import SINGULAR, Solution, column_norms, weighted_least_squares
from symgen.estimation.summary import triangle
from symgen.estimation.system import Rows, join, torque_columns, torque_equations
from symgen.estimation.values import FloatArray
from symgen.identification.parameters import link_columns
from symgen.robot.body import Body
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Standard deviation of log a from values of a catalogue, which leave out losses of the gears, and
#: from the masses of a robot file.
CATALOGUE, MASSES = 0.15, 0.2
_ROUGH = ", with a standard deviation of {:g} %; --carried LOG --mass KG measures it"
_SPREAD = 0.2  # expected radius of gyration of a body, m
#: Rounding of parts of unit vectors, and a number that is no size.
_ALIKE, _TINY = 1e-5, 1e-300
#: Variance of the log of a free factor.
_FREE = 1e6
#: Part of the largest scale to which a smaller one is raised.
_FAINT = 0.02
#: Most rounds of the inputs, and their change, as a part of the inputs, that ends them.
_ROUNDS, _SETTLED = 20, 1e-5
#: Probability of a larger difference below which scales differ.
_DIFFERENT = 0.003


@dataclass(frozen=True, eq=False)
class Carried:
    """A known body that the arm carries in some logs.

    Attributes:
        mass: its mass, kg.
        com: (3,) its centre of mass in the frame of the link, m; None if unknown.
    """

    mass: float
    com: tuple[float, float, float] | None = None

    @property
    def known(self) -> FloatArray:
        """(10,) known part of its link parameters."""
        none = np.zeros((3, 3))
        at = none[0] if self.com is None else np.array(self.com)
        return np.array(Body(0, self.mass, at, none).standard)

    @property
    def free(self) -> FloatArray:
        """(10, k) unknown part: inertias of the expected size, and the first moments."""
        sizes = self.mass * np.repeat([_SPREAD**2, 1.0], [6, 3])
        return np.diag(np.append(sizes, 0.0))[:, : 6 if self.com is not None else 9]


@dataclass(frozen=True, eq=False)
class Scales:
    """The torque of each joint per unit of the input of its drive, a.

    Attributes:
        unit: unit of the input, "duty" or "V".
        torque: (n,) a_j, in N m (N) per unit, or in units of the reference.
        covariance: (n, n) covariance of log a; zero for a reference.
        reference: (n,) position of the joint in whose input torques are counted; -1 for N m.
        names: (p,) names of the parameters.
        slopes: (p, n) derivative of X with respect to log a.
        unequal: probability of a larger difference if all scales were equal.
        source: what the scale comes from; "" if it is unknown.
    """

    unit: str
    torque: FloatArray
    covariance: FloatArray
    reference: tuple[int, ...]
    names: tuple[str, ...]
    slopes: FloatArray
    unequal: float
    source: str

    @property
    def std(self) -> FloatArray:
        """(n,) standard deviations of a."""
        return self.torque * np.sqrt(np.diag(self.covariance))

    @property
    def in_words(self) -> tuple[str, ...]:
        """What the scales come from, and whether they are equal."""
        out = list[str]()
        if self.source:
            out.append(f"the torque of the drives per {self.unit} comes from {self.source}")
        if len(self.torque) > 1 and max(self.reference) == min(self.reference):
            low, high = self.torque.min(), self.torque.max()
            alike = "differ" if self.unequal < _DIFFERENT else "may be equal"
            out.append(
                f"the drives {alike}: {low:.3g} to {high:.3g}; equal ones would differ as much "
                f"with a probability of {self.unequal:.2g}"
            )
        return tuple(out)

    def unit_of(self, joint: int, unit: str) -> str:
        """Return the unit of a parameter of a joint, from that with N m or N for its torque.

        Args:
            joint: position of the joint.
            unit: unit of the parameter.
        """
        if self.reference[joint] < 0:
            return unit
        forces, count = re.subn(r"^N( m)?(?![a-z])", self.unit, unit)
        return forces if count else f"{unit} per {self.unit}"

    def with_uncertainty(self, solution: Solution, names: Sequence[str]) -> Solution:
        """Return a solution with the uncertainty of the scales.

        Args:
            solution: X of a model that may have more parameters. They scale with all torques.
            names: names of its parameters.
        """
        rows = dict(zip(self.names, self.slopes, strict=True))
        even = np.full(len(self.torque), 1 / len(self.torque))
        slopes = np.array(
            [rows.get(name, x * even) for name, x in zip(names, solution.X, strict=True)]
        )
        more = slopes @ self.covariance @ slopes.T
        return replace(solution, misfit=solution.misfit + more)


def with_torques(drives: FloatArray, log: FilteredLog) -> FilteredLog:
    """Return a log of inputs with torques in their place.

    Args:
        drives: (n,) torque of each drive per unit of its input.
        log: the log.
    """
    s = log.samples
    command = None if s.command is None else s.command * drives
    return replace(log, samples=replace(s, tau=s.tau * drives, command=command))


@dataclass(frozen=True, eq=False)
class _Problem:
    """The equations a_j u_j = W_j x + known_j of the inputs u, and a prior of the load.

    Attributes:
        rows: (K, n, m) regressor W of x, that is X and the unknown part of the load; u as y.
        known: (K, n) torque of the known part of the load.
        prior: (r, m + n) equations of the prior: zero with a deviation of one.
        parameters: number of entries of X, which come first in x.
    """

    rows: Rows
    known: FloatArray
    prior: FloatArray
    parameters: int

    @property
    def linear(self) -> int:
        """Number m of entries of x."""
        return int(self.rows.W.shape[2])

    def columns(self, inputs: FloatArray) -> FloatArray:
        """Return the columns [W, -u] of x and a, (K, n, m + n), for some inputs, (K, n)."""
        of_scales = np.einsum("kj,ji->kji", -inputs, np.eye(inputs.shape[1]))
        return np.concatenate([self.rows.W, of_scales], axis=2)

    def inputs(self, theta: FloatArray) -> FloatArray:
        """Return the inputs (K, n) of the solution x and a, (m + n,)."""
        x, a = np.split(theta, [self.linear])
        torque: FloatArray = self.rows.W @ x + self.known
        return torque / a

    def triangle(self, inputs: FloatArray, kept: Bools | slice) -> FloatArray:
        """Return the triangular factor of the weighted columns of some unknowns."""
        columns = self.columns(inputs)[:, :, kept]
        columns = columns * self.rows.weight[..., None]
        return triangle(columns.reshape(-1, columns.shape[2]))

    def directions(self, inputs: FloatArray, kept: Bools) -> tuple[FloatArray, FloatArray]:
        """Return the directions of some unknowns that the equations determine, and the others.

        Args:
            inputs: (K, n) inputs in the columns of a.
            kept: (m + n,) whether an unknown is one of them.

        Returns:
            Two matrices with one column a direction, in the units of the unknowns.
        """
        measured = self.triangle(inputs, kept)
        R = triangle(np.vstack([measured, self.prior[:, kept]]))
        scale = column_norms(R)
        _, values, V = np.linalg.svd(R / scale)
        ways, rank = (V / scale).T, np.count_nonzero(values > SINGULAR * values[0])
        return ways[:, :rank], ways[:, rank:]

    def solve(self, fixed: Bools, a: FloatArray) -> _Fit:
        """Solve for x and a, where some entries of a are fixed.

        The first columns of a are the measured inputs, whose noise shrinks the solution. Those of
        each further round are the inputs of the solution before, as in the method of Gauss-Newton.

        Args:
            fixed: (n,) whether a is fixed.
            a: (n,) its values; those of the others do not matter.

        Raises:
            IdentificationError: there are fewer equations than unknowns.
        """
        u, m = self.rows.y, self.linear
        kept = np.append(np.ones(m, dtype=bool), ~fixed)
        inputs, theta = u, np.append(np.zeros(m), a)
        for _ in range(_ROUNDS):
            ways, _ = self.directions(inputs, kept)
            columns = self.columns(inputs)[:, :, kept]
            y = theta[m:] * (u - ~fixed * inputs) - self.known
            rows = replace(self.rows.with_regressor(columns @ ways), y=y)
            prior = np.column_stack([self.prior[:, kept] @ ways, np.zeros(len(self.prior))])
            solution = weighted_least_squares(rows, prior=prior if len(prior) else None)
            theta[kept] = ways @ solution.X
            # A scale that the logs hardly tell may come out with the wrong sign.
            theta[m:] = np.maximum(theta[m:], _FAINT * theta[m:].max())
            before, inputs = inputs, self.inputs(theta)
            if (rms(inputs - before) <= _SETTLED * rms(u)).all():
                break
        covariance = np.zeros((len(kept), len(kept)))
        covariance[np.ix_(kept, kept)] = ways @ solution.covariance @ ways.T
        return _Fit(theta, covariance, inputs)

    def references(self, inputs: FloatArray) -> Places:
        """Return the reference of each joint, whose scale nothing tells; -1 for a known scale.

        The first joint of those with a common factor is their reference, also its own.

        Args:
            inputs: (K, n) inputs of a solution.
        """
        every = np.ones(self.linear + inputs.shape[1], dtype=bool)
        _, null = self.directions(inputs, every)
        factors = null[self.linear :]
        factors = factors / np.maximum(np.abs(factors).max(axis=0), _TINY)
        apart = np.abs(factors[:, None] - factors)
        alike = apart.max(axis=2, initial=0.0) < _ALIKE
        sizes = np.abs(factors).max(axis=1, initial=0.0)
        return np.where(sizes > _ALIKE, np.argmax(alike, axis=1), -1)


class _Fit(NamedTuple):
    """A solution: x and a, (m + n,), their covariance, and its inputs, (K, n)."""

    theta: FloatArray
    covariance: FloatArray
    inputs: FloatArray


def find_scales(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    carrying: Sequence[FilteredLog],
    body: Carried | None,
    file_values: FloatArray | None,
) -> Scales:
    """Find the scales of the drives of a robot.

    Args:
        evaluator: the compiled model.
        logs: training logs in the band of the run, with inputs in place of torques.
        carrying: logs in which the arm carries a known body.
        body: this body; None if there is none.
        file_values: (p,) parameters in the robot file; None if it has none.

    Raises:
        IdentificationError: the logs have fewer equations than unknowns.
    """
    robot, unit = evaluator.model.robot, logs[0].samples.drive_unit
    problem = _problem(evaluator, logs, carrying, body)
    p, m, n = problem.parameters, problem.linear, robot.n
    every, ones = np.ones(n, dtype=bool), np.ones(n)
    # Any solution shows which scales are open: they multiply its x and a.
    references = problem.references(problem.solve(every, ones).inputs)
    heads = np.unique(references[references >= 0])
    groups = (references[:, None] == heads).astype(float)
    fit = problem.solve(references == np.arange(n), ones)
    a = fit.theta[m:]
    scales = np.log(a)
    covariance = fit.covariance[m:, m:] / np.outer(a, a)
    source = "" if body is None else f"a mass of {body.mass:g} kg"
    catalogue = catalogue_scales(robot, unit)
    if catalogue is not None:
        scales, covariance = _with_catalogue(scales, covariance, groups, np.log(catalogue))
        references[:] = -1
        source = source or f"the values of [drive]{_ROUGH.format(100 * CATALOGUE)}"
    elif file_values is not None:
        for group in groups.T:
            share = _share_of_weight(evaluator, logs, np.flatnonzero(group), file_values)
            weight = float(share @ fit.theta[:p])
            if weight > 0:
                scales = scales - group * np.log(weight)
                covariance = covariance + MASSES**2 * np.outer(group, group)
                references[group > 0] = -1
                source = f"the masses of the robot file{_ROUGH.format(100 * MASSES)}"
    a = np.exp(scales)
    return Scales(
        unit,
        torque=a,
        covariance=covariance,
        reference=tuple(references.tolist()),
        names=evaluator.model.base.names[:p],
        slopes=_slopes(problem, problem.solve(every, a)),
        unequal=_unequal(scales, covariance),
        source=source,
    )


def _with_catalogue(
    scales: FloatArray, covariance: FloatArray, groups: FloatArray, catalogue: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return log a and its covariance with the values of a catalogue.

    The errors of both are independent, and a factor of each group is free.

    Args:
        scales, covariance: log a, (n,), with a factor in each group, and its covariance.
        groups: (n, g) whether a joint belongs to a group.
        catalogue: (n,) log a in the catalogue.
    """
    free = covariance + _FREE * groups @ groups.T
    variance = CATALOGUE**2
    both = free + variance * np.eye(len(scales))
    gain = free @ np.linalg.inv(both)
    return scales + gain @ (catalogue - scales), variance * gain


def catalogue_scales(robot: Robot, unit: str) -> FloatArray | None:
    """Return N kt V/R of each joint from [drive], (n,); None if a value is missing."""
    drive = robot.drive
    if drive is None:
        return None
    supply = 1.0 if unit == "V" else drive.supply
    if drive.torque_constant is None or drive.resistance is None or supply is None:
        return None
    ratio = np.abs(np.diag(np.array(drive.ratio, dtype=float)))
    return np.asarray(ratio * drive.torque_constant * np.array(supply) / drive.resistance)


def _problem(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    carrying: Sequence[FilteredLog],
    body: Carried | None,
) -> _Problem:
    """Return the equations of the inputs of all logs."""
    every = *logs, *carrying
    features = features_of(every, evaluator.model.robot.sigma)
    rows = join([torque_equations(evaluator, log, features=features) for log in every])
    p, n = rows.W.shape[2], rows.y.shape[1]
    if body is None:
        return _Problem(rows, np.zeros(rows.y.shape), np.zeros((0, p + n)), p)
    model = evaluator.model
    assert model.robot.payload is not None
    G = regrouping(model)[:p, link_columns(model, model.robot.payload)]
    counts = [len(log.kept) for log in every]
    loads = [0.0] * len(logs) + [1.0] * len(carrying)
    loaded = np.repeat(loads, counts)
    of_load = loaded[:, None, None] * (rows.W @ G)
    known, unknown = of_load @ body.known, of_load @ body.free
    prior = np.zeros((6, p + unknown.shape[2] + n))
    prior[:, p : p + 6] = np.eye(6)
    both = rows.with_regressor(np.concatenate([rows.W, unknown], axis=2))
    return _Problem(both, known, prior, p)


def _share_of_weight(
    evaluator: Evaluator, logs: Sequence[FilteredLog], joints: Places, X: FloatArray
) -> FloatArray:
    """Return c (p,), with c X the weight of links as a part of that of the file on some joints.

    It is the projection of their torques at rest, in the poses of the logs, on those of the file;
    zero if gravity does not load the joints.

    Args:
        evaluator: the compiled model.
        logs: the logs.
        joints: positions of the joints.
        X: parameters in the file, (p,).
    """
    at_rest = []
    for log in logs:
        q, qd, qdd, *base = (x[log.kept] for x in log.motion)
        still = q, 0 * qd, 0 * qdd, *base
        columns = torque_columns(evaluator, still)
        at_rest += list(columns[:, joints])
    rows = np.concatenate(at_rest)
    torque = rows @ X[: rows.shape[1]]
    return np.asarray(torque @ rows / max(float(torque @ torque), _TINY))


def _slopes(problem: _Problem, fit: _Fit) -> FloatArray:
    """Return the derivative of X with respect to log a at a solution, (p, n)."""
    m = problem.linear
    R = problem.triangle(fit.inputs, slice(None))
    scale = column_norms(R[:, :m])
    response = np.linalg.lstsq(R[:, :m] / scale, -R[:, m:] * fit.theta[m:], rcond=SINGULAR)[0]
    return np.asarray((response / scale[:, None])[: problem.parameters])


def _unequal(scales: FloatArray, covariance: FloatArray) -> float:
    """Return the probability of a larger difference if all scales were equal.

    Args:
        scales: (n,) log a.
        covariance: (n, n) its covariance.
    """
    from scipy.stats import chi2

    differences = np.diff(np.eye(len(scales)), axis=0)
    d = differences @ scales
    inverse = np.linalg.pinv(differences @ covariance @ differences.T, hermitian=True)
    return float(chi2.sf(d @ inverse @ d, len(d))) if len(d) else 1.0
