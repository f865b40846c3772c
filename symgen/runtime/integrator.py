"""Integration of a plant over many runs at once, with exact stops and starts of dry friction.

The method is the pair of orders 5 and 4 of Dormand and Prince (1980). A step can span several time
stamps if the torque is smooth. Each run has its own step and friction modes, so it moves as it
would alone. If a sliding friction comes to rest, or the force on a sticking one exceeds its limit,
the step ends there (found by a cubic or the secant), and new modes are determined. No step spans a
jump, and the modes do not chatter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import FloatArray
from symgen.distributed import silent
from symgen.errors import ParameterError
from symgen.runtime.plant import SLACK, Plant

#: Torques (runs, n) as a function of times (runs,) and states q, qd (runs, n).
Law = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]

#: Dormand and Prince (1980), as SciPy has it, which takes half a second to import: nodes (7,),
#: weights of the stages (i, 1, 1), of the error (7, 1, 1), and of Shampine's interpolant (7, 4).
_C = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
_A = [
    np.array(row)[:, None, None]
    for row in (
        [1 / 5],
        [3 / 40, 9 / 40],
        [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    )
]
_E = np.array([-71 / 57600, 0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40])[
    :, None, None
]
_P = np.array(
    [
        [1, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0, 0, 0, 0],
        [0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ]
)
#: Largest error of a step that callers get by default, absolute and relative.
TOLERANCE = 1e-9
#: Speed at which a friction that slows down has come to rest, rad/s or m/s.
_STOPPED = 1e-8
#: Below this step, s, what remains of a search for an event is rounding; as an accuracy it is
#: out of reach.
_SHORTEST = 1e-11
_PIECES = 20_000
_HALVINGS = 50  # of a step, until its part before an event is known to rounding
#: Stamps that are moved over at once where the torque is smooth.
_STRIDE = 32
#: Stamps at which the law is evaluated at once.
_BLOCK = 50_000
_FAR = 1e8


@dataclass(frozen=True, eq=False)
class Motion:
    """A true or measured motion: t (N,) s; q, qd and the torque tau, each (runs, N, n)."""

    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray


@dataclass(eq=False)
class _State:
    """The state of all runs at one time; only the integrator changes it."""

    x: FloatArray  # (runs, 2 n): q, qd
    mode: FloatArray  # (runs, m)
    step: FloatArray  # (runs,) the step that the accuracy allows, s
    slope: FloatArray  # (runs, 2 n) of x, where known
    force: FloatArray  # (runs, m) of the frictions, where known
    known: Mask  # (runs,) whether mode, slope and force are those at x
    clock: FloatArray  # (runs,) the law's time of a run at the stamp 0, s


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
    clock: FloatArray | None = None,
    tolerance: float = TOLERANCE,
    bounds: FloatArray | float = _FAR,
    progress: Callable[[int], None] = silent,
) -> Motion:
    """Move a plant from stamp to stamp.

    Args:
        plant: the robot.
        law: the torque as a function of time and state.
        t: (N,) stamps, s.
        q: (runs, n) first positions, rad or m.
        qd: (runs, n) first speeds, rad/s or m/s.
        held: used instead of the law if not None: the torque (runs, n) from stamp k to the next, as
            a function of k and of all true q and qd (runs, N, n) up to it.
        unseen: additional torques (runs, N, n), held from stamp to stamp.
        smooth: whether the law is smooth at stamps; a step can then span several.
        clock: (runs,) time at which the law is asked, minus the stamp, s; 0 by default.
        tolerance: largest error of a step, absolute in rad, m, rad/s, m/s, and relative.
        bounds: of the sizes of q, (n,) or one for all, rad or m.
        progress: called with the stamp that is reached.

    Raises:
        ParameterError: M is not positive definite, a joint leaves all bounds, or the accuracy
            cannot be reached. The message has time and joint.
    """
    runs, n = q.shape
    shape = (runs, len(t), n)
    out = Motion(t, np.zeros(shape), np.zeros(shape), np.zeros(shape))
    out.q[:, 0], out.qd[:, 0] = q, qd
    v = plant.speed(qd)
    mode = np.where(np.abs(v) > _STOPPED, np.sign(v), 0.0)
    x = np.concatenate([q, plant.stopped(qd, mode)], axis=1)
    step, known = np.full(runs, t[1] - t[0]), np.zeros(runs, dtype=bool)
    clock = np.zeros(runs) if clock is None else clock
    state = _State(x, mode, step, np.zeros_like(x), np.zeros_like(mode), known, clock)
    stride = _STRIDE if smooth and held is None and unseen is None else 1
    shown = 1 + len(t) // 200 // stride
    constant = np.zeros((runs, n))
    for k in range(0, len(t) - 1, stride):
        end = min(k + stride, len(t) - 1)
        if held:
            out.tau[:, k] = constant = held(k, out.q, out.qd)
        added = constant if unseen is None else constant + unseen[:, k]
        if stride == 1:
            state.known[:] = False
        about = state, t[k : end + 1], tolerance, bounds
        x = _advance(plant, None if held else law, added, *about)
        out.q[:, k + 1 : end + 1], out.qd[:, k + 1 : end + 1] = x[..., :n], x[..., n:]
        if k // stride % shown == 0:
            progress(k)
    if held:
        out.tau[:, -1] = held(len(t) - 1, out.q, out.qd)
        return out
    for run in range(runs):
        for part in (slice(at, at + _BLOCK) for at in range(0, len(t), _BLOCK)):
            out.tau[run, part] = law(t[part] + clock[run], out.q[run, part], out.qd[run, part])
    return out


def _advance(
    plant: Plant,
    law: Law | None,
    added: FloatArray,
    state: _State,
    stamps: FloatArray,
    tolerance: float,
    bounds: FloatArray | float,
) -> FloatArray:
    """Move all runs from the first stamp to the last; return x (runs, K, 2 n) at the others.

    Args:
        plant: the robot.
        law: the torque as a function of time and state, None for none.
        added: additional torques (runs, n).
        state: state of the runs; it is changed.
        stamps: (K + 1,) s.
        tolerance: largest error of a step.
        bounds: of the sizes of q.
    """
    runs, n = len(state.x), state.x.shape[1] // 2
    t, span = float(stamps[0]), float(stamps[-1] - stamps[0])
    since = stamps[1:-1] - t
    passed = np.empty((runs, len(since) + 1, 2 * n))
    rows = np.arange(runs)
    done = np.zeros(runs)
    limit = np.full(runs, np.inf)  # how far the search for an event lets a run go
    for _ in range(_PIECES):
        begin, x = done[rows], state.x[rows]
        h = np.minimum(np.minimum(span - begin, state.step[rows]), limit[rows])
        trial = _step(plant, law, added, state, rows, t + begin, h)
        with np.errstate(invalid="ignore", over="ignore"):
            size = tolerance * (1.0 + np.maximum(np.abs(x), np.abs(trial.x)))
            ratio = (np.abs(trial.error) / size).max(axis=1)
        ratio = np.where(np.isfinite(ratio), ratio, 1e10)
        exact = ratio <= 1.0
        growth = np.minimum(np.maximum(0.9 * np.maximum(ratio, 1e-10) ** -0.2, 0.1), 4.0)
        # A step that the stamp or an event cut short says nothing against longer ones.
        before = np.where(exact & (h < state.step[rows]), state.step[rows], 0.0)
        state.step[rows] = np.maximum(before, h * growth)
        far, stiff = (
            exact & (np.abs(trial.x[:, :n]) > bounds).any(axis=1),
            ~exact & (h <= _SHORTEST),
        )
        if (far | stiff).any():
            raise _insane(plant, trial, far, stiff, t + begin, rows)
        part, event = _events(plant, x, state.mode[rows], trial, h)
        found = exact & ((part >= 1.0) | (h <= _SHORTEST))
        limit[rows] = np.where(found, np.inf, np.where(exact, h * part, limit[rows]))
        kept, mode = rows[found], state.mode[rows[found]]
        end = (begin + h)[:, None]
        run, stamp = np.nonzero((begin[:, None] < since) & (since <= end) & found[:, None])
        if len(run):  # Shampine's interpolant of order 4 (1986)
            powers = ((since[stamp] - begin[run]) / h[run]) ** np.arange(1, 5)[:, None]
            weights = (_P[:, :, None] * powers).sum(axis=1)[:, :, None]
            at = x[run] + h[run, None] * np.add.reduce(weights * trial.slopes[:, run], axis=0)
            at[:, n:] = plant.stopped(at[:, n:], state.mode[rows[run]])
            passed[rows[run], stamp] = at
        state.x[kept], state.slope[kept] = trial.x[found], trial.slopes[6, found]
        state.force[kept], done[kept] = trial.force[1][found], begin[found] + h[found]
        # What comes to rest sticks; the next step settles whether it can.
        event, known = event[found], part[found] >= 1.0
        turned = np.where(event == 2.0, 0.0, np.where(event == 0.0, mode, event))
        state.mode[kept], state.known[kept] = turned, known & ~event.any(axis=1)
        state.x[kept, n:] = plant.stopped(state.x[kept, n:], turned)
        rows = rows[(span - done[rows]) > 1e-12 * span]
        if not len(rows):
            passed[:, -1] = state.x
            return passed
    raise ParameterError(
        f"simulate: run {rows[0] + 1} comes to no end at t = {t:.6g} s; accepted: a less stiff "
        "controller, or Coulomb friction with a coulomb_width"
    )


@dataclass(frozen=True, eq=False)
class _Trial:
    """A tentative step: its end, its error, and the friction forces at both ends."""

    x: FloatArray
    slopes: FloatArray  # (7, runs, 2 n)
    error: FloatArray
    force: tuple[FloatArray, FloatArray]  # friction at its ends, (runs, m)


def _step(
    plant: Plant,
    law: Law | None,
    added: FloatArray,
    state: _State,
    rows: Rows,
    t: FloatArray,
    h: FloatArray,
) -> _Trial:
    """Make a step of Dormand and Prince; first determine unknown friction modes.

    Raises:
        ParameterError: M is not positive definite at the beginning.
    """
    x, n = state.x[rows], state.x.shape[1] // 2
    slopes, wide = np.empty((7, *x.shape)), h[:, None]

    def torque(at: FloatArray, x: FloatArray, rows: Rows) -> FloatArray:
        tau = added[rows]
        return tau if law is None else tau + law(at + state.clock[rows], x[:, :n], x[:, n:])

    try:
        new = ~state.known[rows]
        if new.any():
            own, fresh = x[new], rows[new]
            tau = torque(t[new], own, fresh)
            settled = plant.settle(own[:, :n], own[:, n:], tau, state.mode[fresh])
            state.mode[fresh], qdd, state.force[fresh] = settled
            state.slope[fresh] = np.concatenate([own[:, n:], qdd], axis=1)
            state.known[fresh] = True
        mode, force = state.mode[rows], state.force[rows]
        slopes[0], at, last = state.slope[rows], x, force
        for i in range(1, 7):
            at = x + wide * np.add.reduce(_A[i - 1] * slopes[:i], axis=0)
            slopes[i, :, :n] = at[:, n:]
            tau = torque(t + _C[i] * h, at, rows)
            slopes[i, :, n:], last = plant.accelerate(at[:, :n], at[:, n:], tau, mode)
    except (ParameterError, np.linalg.LinAlgError) as error:
        negative = np.linalg.eigvalsh(plant.mass(x[:, :n]))[:, 0] <= 0
        if negative.any():
            i = int(np.argmax(negative))
            raise ParameterError(
                f"simulate: run {rows[i] + 1}, t = {t[i]:.6g} s: the mass matrix is not positive "
                "definite; accepted: parameters of a robot that can exist"
            ) from error
        # A stage that went astray is no verdict on the robot: the step is too long.
        zero = np.zeros_like(state.mode[rows])
        return _Trial(x, np.zeros_like(slopes), np.full_like(x, np.inf), (zero, zero))
    return _Trial(at, slopes, wide * np.add.reduce(_E * slopes, axis=0), (force, last))


def _events(
    plant: Plant, x: FloatArray, mode: FloatArray, trial: _Trial, h: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the part of the step before the first event, and the event.

    Returns:
        (runs,) the part of the step before the first event, 1 without an event. And (runs, m): 2
        for a friction that comes to rest at the end, 1 or -1 for one that begins to slide in that
        direction, 0 for all others.
    """
    parts, event, n = np.ones_like(mode), np.zeros_like(mode), x.shape[1] // 2
    if not mode.shape[1]:
        return np.ones(len(x)), event
    with np.errstate(all="ignore"):
        after = mode * plant.speed(trial.x[:, n:])
        sliding = mode != 0
        passed = sliding & (after < -_STOPPED)
        near = sliding & (np.abs(after) <= _STOPPED)
        if near.any():
            event[near & (mode * plant.speed(trial.slopes[6, :, n:]) < 0)] = 2.0
        if passed.any():
            before = mode * plant.speed(x[:, n:])
            slopes = (mode * plant.speed(trial.slopes[k, :, n:]) * h[:, None] for k in (0, 6))
            ends = (before, next(slopes), after, next(slopes))
            parts[passed] = _crossing(*(end[passed] for end in ends))
        holding = ~sliding.all(axis=1) & np.isfinite(trial.error).all(axis=1)
        if holding.any():
            stuck = ~sliding[holding]
            low, high = plant.limits(trial.x[holding, :n], trial.x[holding, n:])
            slack = SLACK * (high - low) + 1e-12
            first, last = (f[holding] for f in trial.force)
            side = np.where(last > (low + high) / 2, 1.0, -1.0)
            room, left = (np.where(side > 0, high - f, f - low) for f in (first, last))
            over = stuck & (left < -slack)
            where = (room + slack / 2) / np.maximum(room - left, 1e-300)
            parts[holding] = np.where(over, np.clip(where, 0.05, 0.95), parts[holding])
            event[holding] += np.where(stuck & ~over & (left <= 0), side, 0.0)
    # A search that has come down to rounding ends where it is.
    event[(h <= _SHORTEST)[:, None] & (parts < 1.0) & sliding] = 2.0
    return parts.min(axis=1), event


def _crossing(
    before: FloatArray, slope: FloatArray, after: FloatArray, last: FloatArray
) -> FloatArray:
    """Return where the cubic through both ends, with their slopes, comes to zero, from 0 to 1.

    By bisection.
    """
    before = np.maximum(before, 0.0)
    low, high = np.zeros_like(before), np.ones_like(before)
    rise = after - before
    c2, c3 = 3 * rise - 2 * slope - last, slope + last - 2 * rise
    for _ in range(_HALVINGS):
        part = (low + high) / 2
        ahead = before + part * (slope + part * (c2 + part * c3)) > 0
        low, high = np.where(ahead, part, low), np.where(ahead, high, part)
    return np.clip(low, 1e-3, 0.999)


def _insane(
    plant: Plant, trial: _Trial, far: Mask, stiff: Mask, t: FloatArray, rows: Rows
) -> ParameterError:
    """Return the reason to refuse impossible states, or an accuracy that no step reaches."""
    bad, size, what = far, np.abs(trial.x), "leaves all bounds"
    if not far.any():
        bad, size, what = stiff, np.abs(trial.error), "moves too abruptly for any step"
    i = int(np.argmax(bad))
    worst = int(np.argmax(np.where(np.isnan(size[i]), np.inf, size[i])))
    joint = plant.evaluator.model.robot.listed([worst % (size.shape[1] // 2)])
    return ParameterError(
        f"simulate: run {rows[i] + 1}, {joint}, {what} at t = {t[i]:.6g} s; "
        "accepted: torques or gains under which the motion is finite"
    )
