"""payload: mass, centre of mass and inertia of what the arm carries, from logs with it.

Link parameters s of a load that is fixed on the last moving link enter the base parameters as those
of the link do, X = G s. With Y the torque regressor and G_n the columns of G of that link,

    tau = Y X + (Y G_n) s

is linear in s. Either the parameters X of the unloaded robot are given, and friction is taken anew
from the logs with the load; or logs without the load are, and all is solved at once: friction and
what the model misses, where both motions are alike, cancel (Khalil, Gautier, Lemoine 2007).

What can be read off a drawing follows from s,

    s = (XX XY XZ YY YZ ZZ MX MY MZ M),   c = (MX, MY, MZ)/M,   I_c = J - M (c'c I - c c')

its standard deviations to first order. Where the logs do not determine some direction of s, what
depends on it has no value.

A load of known mass also tells the gains of drives, what a log makes of a torque, joint by joint:

    tau_j = k_j (Y_j X + c Y_j G s),    c = 1 in logs with the load, 0 in those without

All joints share X and s, which sets the k_j against each other, and the mass sets their scale
(Gautier and Briot, Global identification of joint drive gains and dynamic parameters of robots,
2014; there by total least squares). Here tau, which is noisy, stays on the left, and the product
k X is solved by Gauss and Newton: each step is weighted least squares of

    tau_j + k0_j m0_j - k0_j c Y_j G s_known = k0_j Y_j X + k0_j c Y_j G U a + m0_j k_j

with m0 the torque of the model before and s = s_known + U a. The gain of a drive, which its logged
torque is to be multiplied with, is 1/k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from symgen import names
from symgen.codegen.model import Model, derive, regrouping
from symgen.data.raw import Reading
from symgen.errors import IdentificationError, ParameterError, RobotError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.equation_model import JUDGING, EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import filter_log
from symgen.estimation.logs import (
    Source,
    listed_logs,
    require_logs,
    require_other_data,
)
from symgen.estimation.solve import Solution, identifiable_columns
from symgen.estimation.summary import triangle
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.torque_error import relative_error
from symgen.estimation.values import FloatArray, Trace
from symgen.faults.fault import Fault
from symgen.faults.logs import join_bands, open_logs
from symgen.faults.undo import with_known_shifts
from symgen.identification.curves import FILE, read_traces
from symgen.identification.estimate import Joint, joints_of
from symgen.identification.parameters import Given, link_columns, read_given
from symgen.identification.possible import Cone, deviations, nearest_moves
from symgen.identification.pseudo_inertia import (
    IDENTITY,
    MATRIX,
    about_centre,
    parameters_of,
    pseudo_inertia,
)
from symgen.parallel import Say, silent
from symgen.robot.expressions import shortened
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Drive, Frame, Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.schemas import BESIDE, OPTIONAL, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.payload/1"
MARKER = "payload.json"
COM = ("cx", "cy", "cz")
#: Names of mass, centre and inertia about it, in the order of `read_off`.
LABELS = ("mass", *COM, *names.INERTIA)
#: Quantities of the traces: torque of a model without the load, and of one with it.
WITHOUT, WITH = "torque without the load", "torque with the load"
_LENGTH = 0.1  # m, the size of a load in whose units its parameters compare
#: Units of ten link parameters for that length and a mass of 1 kg.
UNITS = np.array([*[_LENGTH**2] * 6, *[_LENGTH] * 3, 1.0])
_TIED = 1e-7  # singular value, of scaled columns, of a direction that the logs do not determine
_SEEN = 1e-6  # share of a parameter in directions that the logs do not determine
_MARGIN = 1e-6  # smallest eigenvalue of the pseudo-inertia of the nearest body, in its units
_FITS, _SEEN_MASS = 0.8, 3.0  # of the torque that is left; standard deviations of a mass
_STEPS, _SETTLED = 30, 1e-3  # of the standard deviation
#: Places in s that mass, centre and inertia about it depend on: XX on MY, MZ and M, and so on.
_NEEDED = (
    (9,),
    *((6, 9), (7, 9), (8, 9)),
    *((0, 7, 8, 9), (1, 6, 7, 9), (2, 6, 8, 9), (3, 6, 8, 9), (4, 7, 8, 9), (5, 6, 7, 9)),
)


@dataclass(frozen=True)
class Quantity:
    """A value with its standard deviation; both None where the logs do not determine it."""

    value: float | None
    std: float | None


@dataclass(frozen=True)
class Left:
    """What is left of the torque, ||tau - model|| / ||tau||, of the logs with the load.

    Attributes:
        before: without the load in the model.
        after: with it.
    """

    before: float
    after: float


@dataclass(frozen=True)
class Payload(Viewable):
    """What the arm carries, in the frame of a link.

    Attributes:
        robot: its name.
        frame: name of the frame of com and inertia; the number of `joint` for that of its link.
        mass: kg.
        com: centre of mass (3), m.
        inertia: XX XY XZ YY YZ ZZ about the centre of mass, kg m2; XY is the matrix entry.
        identifiable: names of what the logs determine, of mass, cx cy cz, XX .. ZZ.
        gain_uncertainty_percent: of the drives' gains, which is part of std; None: not given.
        residual: what is left of the torque without and with the load.
        method: in words.
        band: the filters of the run.
        repairs: what was mended in the logs.
        notes: what was done, in words.
        gains: of the drives, joint by joint, where the load calibrated them: torque over what the
            log makes of it.
        joints: number, unit and name of each movable joint; None in an older file.
        joint: number of the joint whose link carries the load; None in an older file, whose frame
            is that of this joint.
        traces: measured torque of the logs with the load, and that of the model, log by log: of
            the quantities WITHOUT and WITH the load.
    """

    robot: str
    frame: int | str
    mass: Quantity
    com: tuple[Quantity, Quantity, Quantity]
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]
    identifiable: tuple[str, ...]
    gain_uncertainty_percent: float | None
    residual: Left
    method: str
    band: Band | None
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...]
    gains: tuple[Quantity, ...] = ()
    joints: Annotated[tuple[Joint, ...] | None, OPTIONAL] = None
    joint: Annotated[int | None, OPTIONAL] = None
    traces: Annotated[tuple[Trace, ...], BESIDE] = ()

    def __repr__(self) -> str:
        """Return robot and mass."""
        mass = "not determined" if self.mass.value is None else f"{self.mass.value:.4g} kg"
        return f"<Payload of {self.robot} on {self.link}: mass {mass}>"

    @property
    def link(self) -> str:
        """How results call the joint whose link carries the load."""
        labels = {joint.number: joint.label for joint in self.joints or ()}
        number = self.joint if isinstance(self.frame, str) else self.frame
        return labels.get(number or 0, f"joint {number}")

    @property
    def frame_label(self) -> str:
        """How results call the frame of the load."""
        return self.frame if isinstance(self.frame, str) else self.link

    def to_json(self) -> dict[str, Any]:
        """Return the content of payload.json."""
        return to_json(self, SCHEMA)

    def rows(self) -> list[tuple[str, Quantity, str]]:
        """Return name, quantity and unit of every number."""
        inertia = zip(names.INERTIA, self.inertia, strict=True)
        labels = [j.label for j in self.joints or ()]
        labels = labels or [f"movable joint {k + 1}" for k in range(len(self.gains))]
        return [
            ("mass", self.mass, "kg"),
            *((name, q, "m") for name, q in zip(COM, self.com, strict=True)),
            *((name, q, "kg m2") for name, q in inertia),
            *((f"gain of {label}", q, "") for label, q in zip(labels, self.gains, strict=False)),
        ]


def read_payload(path: str | Path) -> Payload:
    """Read a payload again.

    Args:
        path: the folder that `payload` wrote, or the payload.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    traces = read_traces(file.with_name(FILE))
    return replace(read_result(Payload, file, SCHEMA, traces=()), traces=traces)


@dataclass(frozen=True, eq=False)
class LoadEstimate:
    """Ten link parameters of a load, as far as logs determine them.

    Attributes:
        s: (10,) XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame.
        covariance: of s, (10, 10), in the directions that are determined.
        null: (10, k) orthonormal directions, in units of 0.1 m and 1 kg, that are not.
    """

    s: FloatArray
    covariance: FloatArray
    null: FloatArray

    def seen_from(self, frame: Frame) -> LoadEstimate:
        """Return the load in another frame of the same link.

            P' = A P A',  A = T^-1,  with the pseudo-inertia P of the load

        Args:
            frame: constant in the frame of the load.
        """
        A = np.linalg.inv(np.array(frame.transform))
        T = np.array([parameters_of(A @ pseudo_inertia(unit) @ A.T) for unit in np.eye(10)]).T
        null = np.linalg.qr((T * UNITS / UNITS[:, None]) @ self.null)[0]
        return LoadEstimate(T @ self.s, T @ self.covariance @ T.T, null)

    def known(self) -> tuple[bool, ...]:
        """Say which of mass, centre and inertia about it are determined, as `LABELS` has them."""
        hidden = np.linalg.norm(self.null, axis=1) > _SEEN
        return tuple(not hidden[list(needed)].any() for needed in _NEEDED)

    def std(self) -> FloatArray:
        """Return standard deviations of mass, centre and inertia about it, (10,)."""
        step = 1e-6 * UNITS * max(abs(float(self.s[-1])), 1e-3)
        slopes = [
            (read_off(self.s + h) - read_off(self.s - h)) / (2 * h.sum()) for h in np.diag(step)
        ]
        J = np.array(slopes).T
        return np.sqrt(np.maximum(np.diag(J @ self.covariance @ J.T), 0.0))

    def nearest(self, mass: float | None = None) -> LoadEstimate:
        """Return the most likely load that exists: a body of positive density.

            minimise |z|^2   with   s = s0 + L z,  L L' = C,  and a positive definite pseudo-inertia

        Directions that the logs do not determine are free.

        Args:
            mass: kept, where it is known.

        Raises:
            ParameterError: the solver finds no solution.
        """
        scale = UNITS * max(abs(float(self.s[-1])), 1e-3)
        if not self.null.size and float(np.linalg.eigvalsh(pseudo_inertia(self.s / scale))[0]) > 0:
            return self
        x0 = self.s / scale
        onto = np.hstack([self.null, deviations(self.covariance) / scale[:, None]])
        cones = [Cone("semidefinite", MATRIX @ onto, MATRIX @ x0 - _MARGIN * IDENTITY)]
        if mass is not None:
            cones.append(Cone("zero", onto[-1:], x0[-1:] - mass / scale[-1]))
        move = next(nearest_moves(self.null.shape[1], cones), None)
        if move is None:
            raise ParameterError("no possible load is near the estimate")
        x = x0 + onto @ move
        return LoadEstimate(x * scale, self.covariance, self.null)


def read_off(s: FloatArray) -> FloatArray:
    """Return mass, centre of mass (3) and inertia XX XY XZ YY YZ ZZ about it, (10,).

    Raises:
        ParameterError: the mass is zero.
    """
    mass, com, inertia = about_centre(s)
    if not np.isfinite(com).all():
        raise ParameterError("the load has no mass: the logs with and without it do not differ")
    return np.array([mass, *com, *inertia[np.triu_indices(3)]])


@dataclass(frozen=True, eq=False)
class Seen:
    """What was read: torque equations log by log, and what is said of it."""

    equations: list[tuple[Equations, ...]]
    band: Band | None
    notes: tuple[str, ...]
    repairs: tuple[Fault, ...] = ()


def read_equations(
    evaluator: Evaluator,
    logs: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    given: Given | None,
    progress: Say,
) -> Seen:
    """Read logs of motions in one band.

    If the given parameters come from an estimate, its band and its shifts of the torques apply.
    """
    (samples,), repairs = open_logs((logs,), evaluator.model.robot, reading, progress)
    require_other_data(samples, [])
    samples, _, mended = join_bands(samples, [])
    known = None if given is None else given.band
    band = known or choose_band(evaluator, samples, cutoff)
    if cutoff is not None:
        band = replace(band, cutoff_hz=cutoff)
    progress(f"band: {band.in_words()}")
    shifted = [with_known_shifts(s, () if given is None else given.shifts) for s in samples]
    logs_in_band = [filter_log(s, band) for s, _ in shifted]
    model = EquationModel(
        "torque", 0.0, features=features_of(logs_in_band, evaluator.model.robot.sigma)
    )
    equations = [model.equations(evaluator, log) for log in logs_in_band]
    notes = (*(n for s in samples for n in s.notes), f"band: {band.in_words()}")
    return Seen(
        equations, band, notes, (*repairs, *mended, *(r for _, own in shifted for r in own))
    )


@dataclass(frozen=True, eq=False)
class LoadFit:
    """A solution for robot, load and gains.

    Attributes:
        X: (p,) the robot's parameters.
        a: (r,) the load, along the directions that torques show.
        k: (n,) of a joint's torque, what the log makes of it.
    """

    X: FloatArray
    a: FloatArray
    k: FloatArray


@dataclass(frozen=True, eq=False)
class LoadProblem:
    """Torque equations of logs with a load and without, joint by joint.

    Attributes:
        names: of X.
        loaded, alone: equations of the logs with the load, and of those without.
        G: (p, 10) from the parameters of the load to X.
        V: (10, r) directions of the load that torques show, orthonormal in UNITS.
        given: (10,) what is known of the load: its mass, or nothing.
        free: places of the parameters of the robot that are solved for.
    """

    names: tuple[str, ...]
    loaded: Sequence[Equations]
    alone: Sequence[Equations]
    G: FloatArray
    V: FloatArray
    given: FloatArray
    free: Sequence[int]
    robot: Robot

    def step(self, at: LoadFit, gains: bool = False) -> tuple[LoadFit, LinearSystem, Solution]:
        """Solve for changes of the load, of the free parameters, and of the gains where asked.

        Returns:
            What comes of them, the equations of the changes, and their solution: r of the load,
            then the free parameters, then the gains.
        """
        columns, carried = self.G * UNITS @ self.V, self.in_X(at)
        units = np.eye(len(at.k)) if gains else np.zeros((len(at.k), 0))
        rows = []
        logs = [(e, at.X + carried, columns) for e in self.loaded]
        logs += [(e, at.X, 0 * columns) for e in self.alone]
        for e, X, shown in logs:
            k, unit, torque = at.k[e.joint], units[e.joint], e.W @ X
            W = np.hstack([k * (e.W @ shown), k * e.W[:, self.free], torque[:, None] * unit])
            rows.append(replace(e, W=W, y=e.y - k * torque))
        labels = (
            *(f"load {k + 1}" for k in range(len(at.a))),
            *(self.names[k] for k in self.free),
            *(f"gain {j + 1}" for j in range(units.shape[1])),
        )
        system = LinearSystem(labels, tuple(rows))
        solution = Wls().solve(system)
        a, X, k = np.split(solution.X, [len(at.a), len(at.a) + len(self.free)])
        whole = at.X.copy()
        whole[self.free] += X
        return LoadFit(whole, at.a + a, at.k + k if gains else at.k), system, solution

    def in_X(self, fit: LoadFit) -> FloatArray:
        """Return what the load adds to X, (p,)."""
        return self.G @ (self.given + UNITS * (self.V @ fit.a))

    def estimate(self, fit: LoadFit, covariance: FloatArray) -> LoadEstimate:
        """Return the load of a fit, with the covariance of its directions, (r, r)."""
        from scipy.linalg import null_space

        onto = UNITS[:, None] * self.V
        null = null_space(np.column_stack([self.V, self.given != 0]).T)
        return LoadEstimate(self.given + onto @ fit.a, onto @ covariance @ onto.T, null)

    def calibrated(self, fit: LoadFit) -> tuple[LoadFit, Solution]:
        """Solve for the gains too, from a fit without.

        Raises:
            IdentificationError: the logs do not determine the gains, or the steps do not settle.
        """
        for _ in range(_STEPS):
            fit, _, solution = self.step(fit, gains=True)
            if (np.abs(solution.X) <= _SETTLED * solution.std + 1e-12).all():
                break
        else:
            raise IdentificationError(
                "the torque gains do not converge; accepted: logs with and without the load, of "
                "motions that turn it against gravity at every joint"
            )
        j = int(np.argmin(fit.k))
        if fit.k[j] <= 0:
            raise IdentificationError(
                f"the torque gain of {self.robot.listed([j])} is {1 / fit.k[j]:.3g}; accepted: "
                "logs in which the load acts on every joint, and torques of the right sign"
            )
        return fit, solution


def _directions(rows: Sequence[Equations], G: FloatArray, free: int) -> FloatArray:
    """Return the directions (10, r) of the first parameters of a load that torques show.

    In the units of a load of 0.1 m and 1 kg; the columns are orthonormal.
    """
    scaled = (G * UNITS)[:, :free]
    _, sizes, V = np.linalg.svd(triangle(np.concatenate([e.W @ scaled for e in rows])))
    seen = V[: len(sizes)][sizes > _TIED * sizes[0]].T
    return np.pad(seen, ((0, 10 - free), (0, 0)))


def _of_given(system: LinearSystem, solution: Solution, rows: Sequence[Equations]) -> FloatArray:
    """Return the derivative of a weighted solution with the parameters taken off y, (k, p)."""
    weights = solution.weights
    own = np.concatenate([w * e.W for w, e in zip(weights, system.logs, strict=True)])
    given = np.concatenate([w * e.W for w, e in zip(weights, rows, strict=True)])
    out: FloatArray = -np.linalg.lstsq(own, given, rcond=None)[0]
    return out


def _error(rows: Sequence[Equations], X: FloatArray, gain: FloatArray) -> float:
    """Return ||tau - model|| / ||tau||, all joints stacked."""
    rows = [e.with_rest_weight(1.0) for e in rows]
    left = [e.y - gain[e.joint] * (e.W @ X) for e in rows]
    squares = [(x @ x, e.y @ e.y) for x, e in zip(left, rows, strict=True)]
    return relative_error(*np.array(squares).T).relative


def _traces(
    rows: Sequence[Equations], quantity: str, X: FloatArray, gain: FloatArray
) -> tuple[Trace, ...]:
    """Return measured and modelled torque, log by log, where no joint is masked."""
    logs: dict[str, list[Equations]] = {}
    for e in rows:
        logs.setdefault(e.log, []).append(e.with_rest_weight(1.0))
    out = []
    for name, own in logs.items():
        t = reduce(np.intersect1d, [e.t for e in own])
        at = [np.searchsorted(e.t, t) for e in own]
        both = [(e.y[k], gain[e.joint] * (e.W[k] @ X)) for e, k in zip(own, at, strict=True)]
        measured, modelled = (np.column_stack(columns) for columns in zip(*both, strict=True))
        out.append(Trace(name, "train", quantity, t, measured, modelled))
    return tuple(out)


def _known_covariance(given: Given, model: Model) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Return the covariance of given parameters where it is known, and what is said of it."""
    estimate = given.estimate
    if estimate is None:
        return None, ("std leaves out the errors of the given parameters: the file states none",)
    doubt = () if estimate.verdict == "trusted" else (f"{given.file}: a doubtful estimate",)
    if tuple(p.name for p in estimate.parameters) != model.base.names:
        return None, doubt
    if not estimate.correlation.size:
        return None, doubt
    known = np.isfinite(estimate.covariance)
    if not known.all():
        raise ParameterError(
            f"{given.file}: it does not determine all parameters; accepted: an estimate that does"
        )
    return estimate.covariance, doubt


def payload(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    parameters: str | Path | None = None,
    without: Sequence[Source] | Source = (),
    frame: str = "",
    mass: float | None = None,
    gain: float | None = None,
    calibrate: bool = False,
    cutoff: float | None = None,
    reading: Reading | None = None,
    progress: Say = silent,
) -> Payload:
    """Identify the load that a robot carries on its last moving link.

    Args:
        robot: a robot, a path or a library name.
        logs: recorded with the load.
        parameters: of the robot without it: estimate.json, or TOML with [parameters].
        without: logs without the load, best of the same motions; X is then taken from them.
        frame: name of the frame in which the load is given, one of `Robot.frames` on its link; ""
            for that of the joint.
        mass: of the load, kg, where it was weighed.
        gain: standard deviation of the drives' gains, in percent: it scales masses and inertias;
            by default that of [drive], where it states one.
        calibrate: whether the load, whose mass is known, tells the gains of the drives, from logs
            with it and without.
        cutoff: of the filter of positions and speeds, Hz; by default that of the estimate, or else
            the one that suits the logs best.
        reading: how logs are read, and what of them is left out.
        progress: is told what is being done.

    Raises:
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: the parameters are another robot's, or a number is none.
        IdentificationError: the logs do not show a load, or neither parameters nor logs without it
            are given.
    """
    loaded, bare = listed_logs(logs), listed_logs(without)
    require_logs(loaded)
    if parameters is None and not bare:
        raise IdentificationError(
            "the parameters of the robot without the load are unknown; accepted: --parameters with "
            "the folder that symgen identify wrote, or --without with logs of the robot alone"
        )
    if calibrate and (mass is None or not bare):
        raise IdentificationError("--calibrate: accepted: with --mass and --without")
    for name, value in (("--mass", mass), ("--gain", gain)):
        if value is not None and not 0 < value < 1e6:
            raise ParameterError(f"{name} {value:g}; accepted: a number above 0")
    source = read_robot(robot)
    if source.loaded:
        raise ParameterError(
            f"{source.name}: effects that hold the torque of the links are not separated from a "
            "load; accepted: the robot without them"
        )
    if gain is None and source.drive is not None and not calibrate:
        gain = source.drive.gain_uncertainty_percent
    link = source.payload or source.movable[-1].number
    seen_in = _frame_on(source, frame, link)
    progress("deriving and compiling the model")
    derived = derive(source, JUDGING)
    given = None if parameters is None else read_given(parameters, derived)
    spread, doubts = (None, ()) if given is None else _known_covariance(given, derived)
    evaluator, every = load(derived), [*loaded, *bare]
    seen = read_equations(evaluator, every, reading, cutoff, given, progress)
    with_load, alone = (
        [e for own in part for e in own]
        for part in (seen.equations[: len(loaded)], seen.equations[len(loaded) :])
    )
    progress(f"solving {sum(len(e.y) for e in (*with_load, *alone))} equations")
    G = regrouping(derived)[:, link_columns(derived, link)]
    V = _directions(with_load, G, 10 if mass is None else 9)
    start = LoadFit(np.zeros(len(G)), np.zeros(V.shape[1]), np.ones(source.n))
    every_row = np.concatenate([e.W for e in (*with_load, *alone)])
    free, notes = identifiable_columns(every_row).kept, seen.notes
    if given is not None and not bare:
        # Friction as it was: what is left of it is solved for, so that its change has no say in s.
        free = [k for k in free if k >= derived.inertial]
        start, notes = replace(start, X=given.X), (*notes, *doubts)
        how = "logs with the load and given parameters, with the friction fitted again"
    else:
        how = "logs with and without the load, solved together"
    known = np.array([*[0.0] * 9, mass or 0.0])
    problem = LoadProblem(derived.base.names, with_load, alone, G, V, known, free, source)
    fit, system, solution = problem.step(start)
    covariance = solution.covariance
    if spread is not None and not bare:
        shift = _of_given(system, solution, with_load)[:, : derived.inertial]
        covariance = covariance + shift @ spread[: derived.inertial, : derived.inertial] @ shift.T
    unloaded = fit.X if bare else start.X
    before = _error(with_load, unloaded, fit.k)
    traces = _traces(with_load, WITHOUT, unloaded, fit.k)
    gains: tuple[Quantity, ...] = ()
    if calibrate:
        how = "logs with and without the load, and the torque gains, solved together"
        fit, solution = problem.calibrated(fit)
        covariance = solution.covariance
        std = solution.std[-source.n :] / fit.k**2
        gains = tuple(Quantity(*pair) for pair in np.column_stack([1 / fit.k, std]).tolist())
    whole = fit.X + problem.in_X(fit)
    after = _error(with_load, whole, fit.k)
    traces += _traces(with_load, WITH, whole, fit.k)
    r = len(fit.a)
    found = problem.estimate(fit, covariance[:r, :r])
    found = found.seen_from(seen_in) if seen_in else found
    identifiable = tuple(name for name, k in zip(LABELS, found.known(), strict=True) if k)
    if "mass" not in identifiable:
        raise IdentificationError(
            f"the logs do not determine the mass of a load on the link of {source.label(link)}; "
            "accepted: "
            "logs in which "
            "it is turned against gravity, or --mass"
        )
    quantities, told = _quantities(found, identifiable, mass, (gain or 0.0) / 100)
    if not calibrate:
        _require_load(derived, problem, start, link, after, quantities[0] if mass is None else None)
    own_mass, x, y, z, xx, xy, xz, yy, yz, zz = quantities
    return Payload(
        source.name, frame or link, own_mass, (x, y, z), (xx, xy, xz, yy, yz, zz), identifiable,
        gain,
        Left(before, after), f"weighted least squares of torque: {how}", seen.band, seen.repairs,
        notes + told, gains, joints_of(source), link if frame else None, traces,
    )  # fmt: skip


def _frame_on(robot: Robot, name: str, link: int) -> Frame | None:
    """Return a frame on the link of the load; None without a name.

    Raises:
        RobotError: the robot has no such frame, or it is on another link.
    """
    if not name:
        return None
    found = robot.frame(name)
    if found.joint != link:
        own = ", ".join(f.name for f in robot.frames if f.joint == link) or "none"
        raise RobotError(
            f"--frame {shortened(name)}: it is on the link of joint {found.joint}, and the load "
            f"on that of {robot.label(link)}; accepted: {own}"
        )
    return found


def _require_load(
    model: Model,
    problem: LoadProblem,
    start: LoadFit,
    link: int,
    after: float,
    mass: Quantity | None,
) -> None:
    """Refuse a load that is not seen, or that another link carries.

    Args:
        model: of the robot.
        problem: of a load on its link.
        start: where its solution began.
        link: its number.
        after: what it leaves of the torque.
        mass: of the load; None where it is given.

    Raises:
        IdentificationError: its mass is within 3 standard deviations of none, or a load on another
            link leaves less than 0.8 times as much.
    """
    left = {link: after}
    for joint in model.robot.movable:
        if joint.number == link:
            continue
        G = regrouping(model)[:, link_columns(model, joint.number)]
        V = _directions(problem.loaded, G, 10 if mass is not None else 9)
        if V.shape[1] == 0:
            continue
        other = replace(problem, G=G, V=V)
        fit, *_ = other.step(replace(start, a=np.zeros(V.shape[1])))
        left[joint.number] = _error(problem.loaded, fit.X + other.in_X(fit), fit.k)
    best = min(left, key=lambda number: left[number])
    if left[best] < _FITS * after:
        raise IdentificationError(
            f"a load on another link fits better: the torque error is {100 * left[best]:.3g} % "
            f"with a load on {model.robot.label(best)}, {100 * after:.3g} % with one on "
            f"{model.robot.label(link)}; accepted: joint = {best} in [payload] of the robot file"
        )
    if mass is not None and (mass.value or 0.0) < _SEEN_MASS * (mass.std or 0.0):
        raise IdentificationError(
            f"the logs show no load on the link of {model.robot.label(link)}: its mass is "
            f"{mass.value:.3g} kg with a standard deviation of {mass.std:.3g} kg; accepted: logs "
            "recorded with the load"
        )


def _quantities(
    found: LoadEstimate, identifiable: Sequence[str], mass: float | None, gain: float
) -> tuple[list[Quantity], tuple[str, ...]]:
    """Return mass, centre and inertia of the load that exists nearest to one, and what is said.

    Args:
        found: the load of the equations.
        identifiable: names of what the logs determine.
        mass: where it is known.
        gain: standard deviation of the drives' gains, a share: masses and inertias scale by it.
    """
    body, said = found, ""
    try:
        body = found.nearest(mass)
        if body is not found:
            said = "the load is the most probable one that is physically possible"
    except ParameterError as error:
        said = f"not checked whether the load is physically possible: {error}"
    values, std = read_off(body.s), found.std()
    std[0] *= mass is None
    scaled = np.array([mass is None, 0, 0, 0, *[1] * 6])
    std = np.hypot(std, gain * scaled * np.abs(values))
    quantities = [
        Quantity(*pair) if name in identifiable else Quantity(None, None)
        for name, *pair in zip(LABELS, values.tolist(), std.tolist(), strict=True)
    ]
    return quantities, (said,) if said else ()


def with_gains(robot: Robot, found: Payload) -> str:
    """Return the robot.toml of a robot whose [drive] holds the gains that a load calibrated.

    They multiply those that [drive] had before, with which the logs were read.
    """
    one = tuple(tuple(float(i == j) for j in range(robot.n)) for i in range(robot.n))
    drive = robot.drive or Drive(one)
    before = drive.gain or (1.0,) * robot.n
    pairs = [(b, q.value or 1.0, q.std or 0.0) for b, q in zip(before, found.gains, strict=True)]
    gain = tuple(b * value for b, value, _ in pairs)
    std = tuple(abs(b) * s for b, _, s in pairs)
    return robot_toml(replace(robot, drive=replace(drive, gain=gain, gain_std=std)))
