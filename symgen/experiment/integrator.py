"""Integration of a plant over many runs at once, with exact stops and starts of dry friction.

Dormand and Prince's pair of orders 5 and 4 (1980), whose steps pass over stamps where the torque is
smooth. Each run has its own step and its own modes of friction, so that it moves as it would alone.
Where a sliding friction comes to rest, or the force on a sticking one passes its limit, the step is
cut there (by a cubic, or the secant) and the modes are settled anew: no step spans a jump, and
nothing chatters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError
from symgen.experiment import dormand_prince as pair
from symgen.experiment.controller import Law
from symgen.experiment.plant import SLACK, Plant

FloatArray = NDArray[np.float64]
Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]

#: Speed at which a friction that slows down has come to rest, rad/s or m/s.
_STOPPED = 1e-8
#: Below this step, s, what remains of a search for an event is rounding; as an accuracy it is
#: out of reach.
_SHORTEST = 1e-11
_PIECES = 20_000
#: Stamps that are moved over at once where the torque is smooth.
_STRIDE = 32
#: Stamps at which the law is evaluated at once.
_BLOCK = 50_000
_FAR = 1e8


@dataclass(frozen=True, eq=False)
class Motion:
    """What truly happened: t (N,) s; q, qd and the commanded torque tau, each (runs, N, n)."""

    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray


@dataclass(eq=False)
class _State:
    """The runs at one time: what the integrator alone may change."""

    x: FloatArray  # (runs, 2 n): q, qd
    mode: FloatArray  # (runs, m)
    step: FloatArray  # (runs,) the step that the accuracy allows, s
    slope: FloatArray  # (runs, 2 n) of x, where known
    force: FloatArray  # (runs, m) of the frictions, where known
    known: Mask  # (runs,) whether slope and force are those at x


def integrate(
    plant: Plant,
    law: Law,
    t: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    *,
    held: Callable[[int, FloatArray, FloatArray], FloatArray] | None = None,
    unseen: FloatArray | None = None,
    smooth: bool = False,
    tolerance: float = 1e-9,
    progress: Callable[[int], None] = lambda _: None,
) -> Motion:
    """Move a plant from stamp to stamp.

    Args:
        plant: the robot.
        law: the torque as a function of time and state.
        t: (N,) stamps, s.
        q: (runs, n) first positions, rad or m.
        qd: (runs, n) first speeds, rad/s or m/s.
        held: where given, in place of the law: the torque (runs, n) that acts from stamp k to the
            next, as a function of k and of all true q and qd (runs, N, n) up to it.
        unseen: (runs, N, n) torques that act as well, held from stamp to stamp.
        smooth: whether the law does not bend at stamps: a step may then span several.
        tolerance: of the error of each step, absolute in rad, m, rad/s, m/s and relative.
        progress: is told the stamp that is reached.

    Raises:
        ParameterError: M is not positive definite, a joint leaves all bounds, or the accuracy is
            out of reach; the message says when and where.
    """
    runs, n = q.shape
    shape = (runs, len(t), n)
    out = Motion(t, np.zeros(shape), np.zeros(shape), np.zeros(shape))
    out.q[:, 0], out.qd[:, 0] = q, qd
    v = plant.speed(qd)
    mode = np.where(np.abs(v) > _STOPPED, np.sign(v), 0.0)
    qd = plant.stopped(qd, mode)
    state = _State(
        np.concatenate([q, qd], axis=1),
        mode,
        np.full(runs, t[1] - t[0]),
        np.zeros((runs, 2 * n)),
        np.zeros_like(mode),
        np.zeros(runs, dtype=bool),
    )
    stride = _STRIDE if smooth and held is None and unseen is None else 1
    shown = 1 + len(t) // 200 // stride
    for k in range(0, len(t) - 1, stride):
        end = min(k + stride, len(t) - 1)
        command = held(k, out.q, out.qd) if held else out.tau[:, k]
        out.tau[:, k] = command
        extra = None if unseen is None else unseen[:, k]
        if held or unseen is not None:
            state.known[:] = False

        def torque(
            at: FloatArray,
            q: FloatArray,
            qd: FloatArray,
            rows: Rows,
            command: FloatArray = command,
            extra: FloatArray | None = extra,
        ) -> FloatArray:
            tau = command[rows] if held else law(at, q, qd)
            return tau if extra is None else tau + extra[rows]

        passed = _advance(plant, torque, state, t[k : end + 1], tolerance)
        out.q[:, k + 1 : end + 1], out.qd[:, k + 1 : end + 1] = passed[..., :n], passed[..., n:]
        if k // stride % shown == 0:
            progress(k)
    last = len(t) - 1
    if held:
        out.tau[:, last] = held(last, out.q, out.qd)
    else:
        for run in range(runs):
            for part in (slice(at, at + _BLOCK) for at in range(0, len(t), _BLOCK)):
                out.tau[run, part] = law(t[part], out.q[run, part], out.qd[run, part])
    return out


Torque = Callable[[FloatArray, FloatArray, FloatArray, Rows], FloatArray]


def _advance(
    plant: Plant, torque: Torque, state: _State, stamps: FloatArray, tolerance: float
) -> FloatArray:
    """Move all runs from the first stamp to the last; return x (runs, K, 2 n) at the others."""
    runs, n = len(state.x), state.x.shape[1] // 2
    t, span = float(stamps[0]), float(stamps[-1] - stamps[0])
    since = stamps[1:-1] - t
    passed = np.empty((runs, len(since) + 1, 2 * n))
    rows = np.arange(runs)
    done = np.zeros(runs)
    limit = np.full(runs, np.inf)  # how far the search for an event lets a run go
    for _ in range(_PIECES):
        x, mode = state.x[rows], state.mode[rows]
        h = np.minimum(np.minimum(span - done[rows], state.step[rows]), limit[rows])
        trial = _step(plant, torque, state, rows, t + done[rows], h)
        if trial.mode is not mode:
            state.mode[rows] = mode = trial.mode
        with np.errstate(invalid="ignore", over="ignore"):
            size = tolerance * (1.0 + np.maximum(np.abs(x), np.abs(trial.x)))
            ratio = (np.abs(trial.error) / size).max(axis=1)
        ratio = np.where(np.isfinite(ratio), ratio, 1e10)
        exact = ratio <= 1.0
        growth = np.minimum(np.maximum(0.9 * np.maximum(ratio, 1e-10) ** -0.2, 0.1), 4.0)
        # A step that the stamp or an event cut short says nothing against longer ones.
        before = np.where(exact & (h < state.step[rows]), state.step[rows], 0.0)
        state.step[rows] = np.maximum(before, h * growth)
        _require_sane(plant, trial, exact, h, t + done[rows], rows)
        part, event = _events(plant, x, mode, trial, h)
        found = exact & ((part >= 1.0) | (h <= _SHORTEST))
        if not found.all():
            shorter = np.where(exact, h * part, limit[rows])
            limit[rows] = np.where(found, np.inf, shorter)
        else:
            limit[rows] = np.inf
        kept = rows[found]
        if len(since):
            _interpolate(plant, x, trial, h, done[rows], found, since, rows, passed)
        state.x[kept], state.slope[kept] = trial.x[found], trial.slopes[6, found]
        state.force[kept], state.known[kept] = trial.force[1][found], True
        done[kept] += h[found]
        if len(plant.A) and len(kept):
            event = event[found]
            if event.any():
                # What comes to rest sticks; the next step settles whether it can.
                turned = np.where(event == 2.0, 0.0, np.where(event == 0.0, mode[found], event))
                state.mode[kept] = turned
                state.known[kept] = ~event.any(axis=1)
            if not state.mode[kept].all():
                state.x[kept, n:] = plant.stopped(state.x[kept, n:], state.mode[kept])
        rows = rows[(span - done[rows]) > 1e-12 * span]
        if not len(rows):
            passed[:, -1] = state.x
            return passed
    raise ParameterError(
        f"simulate: run {rows[0] + 1} comes to no end at t = {t:.6g} s; accepted: a less stiff "
        "controller, or Coulomb friction with a coulomb_width"
    )


def _interpolate(
    plant: Plant,
    x: FloatArray,
    trial: _Trial,
    h: FloatArray,
    begin: FloatArray,
    found: Mask,
    since: FloatArray,
    rows: Rows,
    passed: FloatArray,
) -> None:
    """Write the states at the stamps that the kept steps pass."""
    over = (begin[:, None] < since) & (since <= (begin + h)[:, None]) & found[:, None]
    run, stamp = np.nonzero(over)
    if len(run):
        weights = pair.inside((since[stamp] - begin[run]) / h[run])[:, :, None]
        n = x.shape[1] // 2
        at = x[run] + h[run, None] * np.add.reduce(weights * trial.slopes[:, run], axis=0)
        if len(plant.A):
            at[:, n:] = plant.stopped(at[:, n:], trial.mode[run])
        passed[rows[run], stamp] = at


@dataclass(frozen=True, eq=False)
class _Trial:
    """A step that may be kept: its end, its error, and what the frictions do at both ends."""

    x: FloatArray
    slopes: FloatArray  # (7, runs, 2 n)
    error: FloatArray
    mode: FloatArray  # the modes that it was made with
    pull: tuple[FloatArray, FloatArray]  # acceleration A qdd at its ends, (runs, m)
    force: tuple[FloatArray, FloatArray]  # friction at its ends, (runs, m)


def _step(
    plant: Plant, torque: Torque, state: _State, rows: Rows, t: FloatArray, h: FloatArray
) -> _Trial:
    x, mode, force = state.x[rows], state.mode[rows], state.force[rows]
    n = x.shape[1] // 2
    slopes = np.empty((7, *x.shape))
    wide = h[:, None]
    try:
        slopes[0] = state.slope[rows]
        new = ~state.known[rows]
        if new.any():
            slopes[0, new, :n] = x[new, n:]
            slopes[0, new, n:], force[new] = _rates(
                plant, torque, x[new], mode[new], rows[new], t[new]
            )
        fresh = _unsettled(plant, x, mode, force)
        if fresh.any():
            tau = torque(t, x[:, :n], x[:, n:], rows)[fresh]
            mode = mode.copy()
            mode[fresh] = plant.settle(x[fresh, :n], x[fresh, n:], tau, mode[fresh])
            slopes[0, fresh, n:], force[fresh] = plant.accelerate(
                x[fresh, :n], x[fresh, n:], tau, mode[fresh]
            )
        at, last = x, force
        for i in range(1, 7):
            at = x + wide * np.add.reduce(pair.A[i - 1] * slopes[:i], axis=0)
            slopes[i, :, :n] = at[:, n:]
            slopes[i, :, n:], last = _rates(plant, torque, at, mode, rows, t + pair.C[i] * h)
    except (ParameterError, np.linalg.LinAlgError) as error:
        _explain(plant, x, t, rows, error)
        # A stage that went astray is no verdict on the robot: the step is too long.
        return _Trial(x, slopes, np.full_like(x, np.inf), mode, (mode, mode), (mode, mode))
    miss = wide * np.add.reduce(pair.E * slopes, axis=0)
    return _Trial(at, slopes, miss, mode, _pulls(plant, slopes), (force, last))


def _rates(
    plant: Plant, torque: Torque, x: FloatArray, mode: FloatArray, rows: Rows, t: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return qdd and the friction forces."""
    n = x.shape[1] // 2
    q, qd = x[:, :n], x[:, n:]
    return plant.accelerate(q, qd, torque(t, q, qd, rows), mode)


def _pulls(plant: Plant, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    n = slopes.shape[2] // 2
    return plant.speed(slopes[0, :, n:]), plant.speed(slopes[6, :, n:])


def _unsettled(plant: Plant, x: FloatArray, mode: FloatArray, force: FloatArray) -> Mask:
    """Return which runs have a sticking friction that cannot hold any more."""
    n = x.shape[1] // 2
    out = np.asarray((mode == 0).any(axis=1))
    if mode.size and out.any():
        low, high = plant.limits(x[out, :n], x[out, n:])
        slack = SLACK * (high - low) + 1e-12
        f = force[out]
        over = (f > high + slack) | (f < low - slack)
        out[out] = ((mode[out] == 0) & over).any(axis=1)
    return out


def _events(
    plant: Plant, x: FloatArray, mode: FloatArray, trial: _Trial, h: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far the step goes until the first event, and what happens at its end.

    Returns:
        (runs,) the part of the step before an event that it passed over, 1 where it passed none;
        and (runs, m) 2 for a friction that comes to rest at the end, 1 or -1 for one that begins to
        slide that way, 0 for all others.
    """
    part = np.ones(len(x))
    if not len(plant.A):
        return part, mode
    n = plant.A.shape[1]
    with np.errstate(invalid="ignore", over="ignore"):
        before = mode * plant.speed(x[:, n:])
        after = mode * plant.speed(trial.x[:, n:])
        slope = mode * trial.pull[0] * h[:, None]
        sliding = mode != 0
        passed = sliding & (after < -_STOPPED)
        rest = sliding & (abs(after) <= _STOPPED) & (mode * trial.pull[1] < 0)
        if sliding.all() and not (passed | rest).any():
            return part, np.zeros_like(mode)
        parts = np.ones_like(mode)
        if passed.any():
            ends = (before, slope, after, mode * trial.pull[1] * h[:, None])
            parts[passed] = pair.crossing(*(x[passed] for x in ends))
        event = np.where(rest, 2.0, 0.0)
        holding = ~sliding.all(axis=1) & np.isfinite(trial.error).all(axis=1)
        if holding.any():
            stuck = mode[holding] == 0
            low, high = plant.limits(trial.x[holding, :n], trial.x[holding, n:])
            slack = SLACK * (high - low) + 1e-12
            first, last = (f[holding] for f in trial.force)
            side = np.where(last > (low + high) / 2, 1.0, -1.0)
            margin = [np.where(side > 0, high - f, f - low) for f in (first, last)]
            over = stuck & (margin[1] < -slack)
            where = (margin[0] + slack / 2) / np.maximum(margin[0] - margin[1], 1e-300)
            parts[holding] = np.where(over, np.clip(where, 0.05, 0.95), parts[holding])
            event[holding] += np.where(stuck & ~over & (margin[1] <= 0), side, 0.0)
    # A search that has come down to rounding ends where it is.
    tiny = (h <= _SHORTEST)[:, None]
    event = np.where(tiny & (parts < 1.0), np.where(sliding, 2.0, event), event)
    return parts.min(axis=1), event


def _explain(plant: Plant, x: FloatArray, t: FloatArray, rows: Rows, error: Exception) -> None:
    """Say where M is not positive definite, if it is so at the beginning of a step.

    Raises:
        ParameterError: it is.
    """
    n = x.shape[1] // 2
    for i, state in enumerate(x):
        try:
            plant.evaluator["forward_dynamics"](state[:n], state[n:], np.zeros(n), plant.X)
        except ParameterError:
            raise ParameterError(
                f"simulate: run {rows[i] + 1}, t = {t[i]:.6g} s: the mass matrix is not positive "
                "definite; accepted: parameters of a robot that can exist"
            ) from error


def _require_sane(
    plant: Plant, trial: _Trial, exact: Mask, h: FloatArray, t: FloatArray, rows: Rows
) -> None:
    """Refuse states that no robot has, and an accuracy that no step reaches.

    Raises:
        ParameterError: with the run, the time and the joint.
    """
    far = exact & (np.abs(trial.x).max(axis=1) > _FAR)
    stiff = ~exact & (h <= _SHORTEST)
    for bad, size, what in (
        (far, np.abs(trial.x), "leaves all bounds"),
        (stiff, np.abs(trial.error), "moves too abruptly for any step"),
    ):
        if bad.any():
            i = int(np.argmax(bad))
            worst = int(np.argmax(np.where(np.isnan(size[i]), np.inf, size[i])))
            joint = plant.evaluator.model.robot.movable[worst % (size.shape[1] // 2)].number
            raise ParameterError(
                f"simulate: run {rows[i] + 1}, joint {joint}, {what} at t = {t[i]:.6g} s; "
                "accepted: torques or gains under which the motion is finite"
            )
