"""payload: mass, centre of mass and inertia of what the arm carries, from logs with it.

Link parameters s of a load that is fixed on the last moving link enter the base parameters as those
of the link do, X = G s. With Y the torque regressor and G_n the columns of G of that link,

    tau = Y X + (Y G_n) s

is linear in s. Either the parameters X of the unloaded robot are given, and friction is taken anew
from the logs with the load; or logs without the load are, and all is solved at once: friction and
what the model misses, where both motions are alike, cancel (Khalil, Gautier, Lemoine 2007).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.raw import Reading
from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.equation_model import JUDGING
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered import filtered
from symgen.estimation.logs import (
    Source,
    listed_logs,
    require_logs,
    require_other_data,
)
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem, torque_equations
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.logs import in_one_band, open_logs
from symgen.identification.gains import calibrated
from symgen.identification.load import LABELS, LoadEstimate, read_off, units
from symgen.identification.parameters import link_columns, read_given, regrouping
from symgen.identification.payload_result import Left, Payload, Quantity
from symgen.identification.static import STATIC, open_poses, pose_equations, shown_columns
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load


@dataclass(frozen=True, eq=False)
class Seen:
    """What was read: torque equations log by log, and what is said of it."""

    equations: list[tuple[Equations, ...]]
    band: Band | None
    notes: tuple[str, ...]
    repairs: tuple[Fault, ...] = ()


def torques(
    evaluator: Evaluator,
    logs: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    band: Band | None,
    progress: Callable[[str], None],
) -> Seen:
    """Read logs of motions: in one band, that of the parameters where they have one."""
    (samples,), repairs = open_logs((logs,), evaluator.model.robot, reading, progress)
    require_other_data(samples, [])
    samples, _, mended = in_one_band(samples, [])
    band = band or choose_band(evaluator, samples, cutoff)
    if cutoff is not None:
        band = replace(band, cutoff_hz=cutoff)
    progress(f"band: {band.in_words()}")
    equations = [torque_equations(evaluator, filtered(s, band)) for s in samples]
    notes = (*(n for s in samples for n in s.notes), f"band: {band.in_words()}")
    return Seen(equations, band, notes, (*repairs, *mended))


def still_poses(
    evaluator: Evaluator,
    logs: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    _band: Band | None,
    progress: Callable[[str], None],
) -> Seen:
    """Read tables of still poses."""
    if cutoff is not None:
        raise IdentificationError("--cutoff: still poses pass no filter; accepted: none")
    progress(f"reading {', '.join(str(getattr(log, 'name', log)) for log in logs)}")
    poses = [open_poses(log, evaluator.model.robot, reading) for log in logs]
    require_other_data(poses, [])
    equations = [pose_equations(evaluator, s) for s in poses]
    return Seen(equations, None, tuple(n for s in poses for n in s.notes))


MODELS = ("torque", STATIC)
_TIED = 1e-7  # singular value, of scaled columns, of a direction that the logs do not determine


def payload(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    parameters: str | Path | None = None,
    without: Sequence[Source] | Source = (),
    mass: float | None = None,
    gain: float | None = None,
    calibrate: bool = False,
    model: str = "torque",
    cutoff: float | None = None,
    reading: Reading | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Payload:
    """Identify the load that a robot carries on its last moving link.

    Args:
        robot: a robot, a path or a library name.
        logs: recorded with the load.
        parameters: of the robot without it: estimate.json, or TOML with [parameters].
        without: logs without the load, best of the same motions; X is then taken from them.
        mass: of the load, kg, where it was weighed.
        gain: standard deviation of the drives' gains, in percent: it scales masses and inertias;
            by default that of [drive], where it states one.
        calibrate: whether the load, whose mass is known, tells the gains of the drives, from logs
            with it and without; see `symgen.identification.gains`.
        model: "torque"; or "static", where the rows of the logs are still poses.
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
            "what the robot is without its load is not known; accepted: --parameters, or --without "
            "with logs of the robot alone"
        )
    if calibrate and (mass is None or not bare):
        raise IdentificationError("--calibrate: accepted: with --mass and --without")
    if calibrate and model == STATIC:
        raise IdentificationError("--calibrate with --model static: accepted: logs of motions")
    if model not in MODELS:
        raise IdentificationError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    for name, value in (("--mass", mass), ("--gain", gain)):
        if value is not None and not 0 < value < 1e6:
            raise ParameterError(f"{name} {value:g}; accepted: a number above 0")
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    if source.loaded:
        raise ParameterError(
            f"{source.name}: effects that hold the torque of the links are not separated from a "
            "load; accepted: the robot without them"
        )
    if gain is None and source.drive is not None and not calibrate:
        gain = source.drive.gain_uncertainty_percent
    progress("deriving and compiling the model")
    derived = derive(source, JUDGING)
    known = _Known.read(parameters, derived, model == STATIC)
    read = still_poses if model == STATIC else torques
    seen = read(
        load(derived),
        [*loaded, *bare],
        reading,
        cutoff,
        None if known is None else known.band,
        progress,
    )
    with_load = [e for own in seen.equations[: len(loaded)] for e in own]
    alone = [e for own in seen.equations[len(loaded) :] for e in own]
    link = source.payload or source.movable[-1].number
    G = regrouping(derived)[:, link_columns(derived, link)]
    progress(f"solving {sum(len(e.y) for e in (*with_load, *alone))} equations")
    gains: tuple[Quantity, ...] = ()
    if calibrate:
        solved, gains = _calibrated(derived, with_load, alone, G, mass)
        how = "logs with and without the load, and the drives' gains, solved at once"
    elif alone:
        solved = _beside(derived, with_load, alone, G, mass)
        how = "logs with and without the load, solved at once"
    else:
        assert known is not None
        solved = _against(derived, with_load, known, G, mass)
        how = "logs with the load against given parameters, friction taken anew"
    found, before, after, notes = solved
    what = "of torque at standstill" if model == STATIC else "of torque"
    result = _payload(
        source, link, found, mass, gain, before, after,
        f"weighted least squares {what}: {how}", seen.band, (*seen.notes, *notes), seen.repairs,
    )  # fmt: skip
    return replace(result, gains=gains)


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known of the robot alone: X (p,), its covariance, and the band it was found in."""

    X: FloatArray
    covariance: FloatArray | None
    band: Band | None
    notes: tuple[str, ...] = ()

    @staticmethod
    def read(path: str | Path | None, model: Model, still: bool) -> _Known | None:
        if path is None:
            return None
        given = read_given(path, model)
        X, estimate = given.X, given.estimate
        if estimate is None:
            says = "std leaves out the errors of the given parameters: the file states none"
            return _Known(X, None, None, (says,))
        same = tuple(p.name for p in estimate.parameters) == model.base.names
        covariance = estimate.covariance if same and estimate.correlation.size else None
        if covariance is not None and not np.isfinite(covariance).all():
            if not still:
                raise ParameterError(
                    f"{given.file}: it does not determine all parameters; accepted: an estimate "
                    "from motions, or --model static with tables of still poses"
                )
            covariance = np.where(np.isfinite(covariance), covariance, 0.0)  # seen in no pose
        doubt = () if estimate.verdict == "trusted" else (f"{given.file}: a doubtful estimate",)
        return _Known(X, covariance, estimate.band, doubt)


Solved = tuple[LoadEstimate, float, float, tuple[str, ...]]


def _basis(rows: Sequence[Equations], G: FloatArray, free: Sequence[int]) -> FloatArray:
    """Return the directions (10, r) of the free parameters of a load that torques show.

    In the units of a load of 0.1 m and 1 kg; the columns are orthonormal.
    """
    scaled = (G * units())[:, free]
    R = np.linalg.qr(np.concatenate([e.W @ scaled for e in rows]), mode="r")
    _, sizes, V = np.linalg.svd(R)
    seen = V[sizes > _TIED * sizes[0]].T
    out = np.zeros((10, seen.shape[1]))
    out[list(free)] = seen
    return out


def _against(
    model: Model, rows: Sequence[Equations], known: _Known, G: FloatArray, mass: float | None
) -> Solved:
    """Solve for the load and friction, with given inertial parameters of the robot."""
    inertial = model.inertial
    # Friction as it was: what is left of it is solved for, so that its change has no say in s.
    rubbing = [k for k in shown_columns(rows).kept if k >= inertial]
    V, system, solution = _with_load(model, rows, (), G, mass, rubbing, known.X)
    covariance = solution.covariance
    if known.covariance is not None:
        shift = _shift(system, rows, solution)[:, :inertial]
        covariance = covariance + shift @ known.covariance[:inertial, :inertial] @ shift.T
    after = _relative(rows, [e.y - e.W @ solution.X for e in system.logs])
    before = _relative(rows, [e.y - e.W @ known.X for e in rows])
    return _found(V, solution.X, covariance, mass), before, after, known.notes


def _with_load(
    model: Model,
    rows: Sequence[Equations],
    alone: Sequence[Equations],
    G: FloatArray,
    mass: float | None,
    free: Sequence[int],
    X: FloatArray,
) -> tuple[FloatArray, LinearSystem, Solution]:
    """Solve for the load, and for a change of some parameters.

    Args:
        model: of the robot.
        rows: with the load.
        alone: without it.
        G: from the parameters of the load to X, (p, 10).
        mass: of the load, where it is known.
        free: places of the parameters that are solved for.
        X: the robot's parameters before, (p,).

    Returns:
        The directions of the load that torques show (10, r), the equations, and the solution: r
        parameters of the load, then the free ones.
    """
    V = _basis(rows, G, range(10 if mass is None else 9))
    own, r = np.eye(len(X))[:, list(free)], V.shape[1]
    loaded, known = np.hstack([G * units() @ V, own]), X + G @ _given(mass)
    bare = np.hstack([np.zeros((len(X), r)), own])
    labels = (*(f"load {k + 1}" for k in range(r)), *(model.base.names[k] for k in free))
    system = LinearSystem(
        labels,
        (
            *(replace(e, W=e.W @ loaded, y=e.y - e.W @ known) for e in rows),
            *(replace(e, W=e.W @ bare, y=e.y - e.W @ X) for e in alone),
        ),
    )
    return V, system, Wls().solve(system)


def _shift(system: LinearSystem, rows: Sequence[Equations], solution: Solution) -> FloatArray:
    """Return the derivative of a weighted solution with the parameters taken off y, (k, p)."""
    pairs = list(zip(solution.weights, system.logs, rows, strict=True))
    normal = sum(w * w * e.W.T @ e.W for w, e, _ in pairs)
    cross = sum(w * w * e.W.T @ row.W for w, e, row in pairs)
    return -np.linalg.solve(np.asarray(normal), np.asarray(cross))


def _beside(
    model: Model,
    rows: Sequence[Equations],
    alone: Sequence[Equations],
    G: FloatArray,
    mass: float | None,
) -> Solved:
    """Solve for the robot and the load at once, from logs with and without it."""
    kept, X = (
        shown_columns([*rows, *alone]).kept,
        np.zeros(len(G)),
    )
    V, system, solution = _with_load(model, rows, alone, G, mass, kept, X)
    after = _relative(rows, [e.y - e.W @ solution.X for e in system.logs[: len(rows)]])
    X[kept] = solution.X[V.shape[1] :]
    before = _relative(rows, [e.y - e.W @ X for e in rows])
    return _found(V, solution.X, solution.covariance, mass), before, after, ()


def _calibrated(
    model: Model,
    rows: Sequence[Equations],
    alone: Sequence[Equations],
    G: FloatArray,
    mass: float | None,
) -> tuple[Solved, tuple[Quantity, ...]]:
    """Solve for the drives' gains too, from a load whose mass is known."""
    V, given = _basis(rows, G, range(9)), _given(mass)
    found = calibrated(model.base.names, rows, alone, G * units() @ V, G @ given)
    before = _beside(model, rows, alone, G, mass)[1]
    told = tuple(Quantity(float(g), float(s)) for g, s in zip(found.gain, found.std, strict=True))
    after = _relative(rows, found.left)
    return (_found(V, found.a, found.covariance, mass), before, after, ()), told


def _given(mass: float | None) -> FloatArray:
    """Return the part of s that is known: the mass, or nothing."""
    out = np.zeros(10)
    out[-1] = mass or 0.0
    return out


def _found(V: FloatArray, a: FloatArray, C: FloatArray, mass: float | None) -> LoadEstimate:
    """Return s = given + U V a with its covariance, U the units; a comes first in X and its C."""
    onto, given, r = units()[:, None] * V, _given(mass), V.shape[1]
    a, C = a[:r], C[:r, :r]
    rest = np.linalg.svd(np.column_stack([V, given != 0]))
    null = rest[0][:, np.linalg.matrix_rank(np.column_stack([V, given != 0])) :]
    return LoadEstimate(given + onto @ a, onto @ C @ onto.T, null)


def _relative(rows: Sequence[Equations], left: Sequence[FloatArray]) -> float:
    """Return ||what is left|| over ||torque||, all joints stacked."""
    size = np.sqrt(sum(float(e.y @ e.y) for e in rows))
    return float(np.sqrt(sum(float(x @ x) for x in left)) / size)


def _payload(
    robot: Robot,
    link: int,
    found: LoadEstimate,
    mass: float | None,
    gain: float | None,
    before: float,
    after: float,
    method: str,
    band: Band | None,
    notes: tuple[str, ...],
    repairs: tuple[Fault, ...],
) -> Payload:
    """Return the load that exists nearest to what was found, with what is known of it."""
    known = list(found.known())
    if not known[0]:
        raise IdentificationError(
            f"the logs do not determine the mass of a load on link {link}; accepted: logs in which "
            "it is turned against gravity, or --mass"
        )
    try:
        body = found.nearest(mass)
        if body is not found:
            notes += ("of the loads that can exist, the most likely one is given",)
    except ParameterError as error:
        body = found
        notes += (f"whether such a load can exist is not checked: {error}",)
    values, std = read_off(body.s), found.std()
    if mass is not None:
        std[0] = 0.0
    share = (gain or 0.0) / 100
    scales = np.array([mass is None, 0, 0, 0, *[1] * 6])
    std = np.hypot(std, share * scales * np.abs(values))
    mass_found, x, y, z, *turning = (
        Quantity(float(v), float(s)) if k else Quantity(None, None)
        for v, s, k in zip(values, std, known, strict=True)
    )
    xx, xy, xz, yy, yz, zz = turning
    identifiable = tuple(name for name, k in zip(LABELS, known, strict=True) if k)
    return Payload(
        robot.name, link, mass_found, (x, y, z), (xx, xy, xz, yy, yz, zz), identifiable, gain,
        Left(before, after), method, band, repairs, notes,
    )  # fmt: skip
