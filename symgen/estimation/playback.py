"""Playback: simulate windows of a log from measured states under the measured torques.

    M(q) qdd + h(q, qd) + A' f = tau_m(t) + kp (q_m - q) + kd (qd_m - qd)

A window begins in the measured state. Without gains, the measured torque alone moves the robot.
Torques are sampled 16 times in a period of the highest frequency of the motion and interpolated by
a cubic spline. symgen compares the positions after 0.2, 0.5 and 1 s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from symgen.codegen.model import Model
from symgen.data.drive import torque_of_command
from symgen.data.mask import STILL, spans
from symgen.data.signals import can_filter, lowpass
from symgen.errors import ParameterError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.robot.types import Robot
from symgen.runtime.simulate import Law, require_friction, simulate_motion
from symgen.schemas import Size

#: Times at which positions are compared, s.
HORIZONS = (0.2, 0.5, 1.0)
#: A position error above this multiple of the joint's range of motion counts as divergence, and as
#: this multiple.
_AWAY = 10.0
#: Evaluations of the forward dynamics after which a window counts as diverged. Windows of 1 s take
#: 360 to 6,000 in 38 recorded and simulated logs, and 12,000 in the stiffest one (a TX40).
_CALLS = 50_000
#: Largest error of a step. A window without feedback is unstable: with 1e-6, positions after 1 s
#: are wrong by up to 0.4 % of the distance.
_TOLERANCE = 3e-7


@dataclass(frozen=True)
class Horizon:
    """Position error of a simulated robot some time after the measured state.

    Attributes:
        seconds: time after the start of a window.
        position_error: RMS of simulated minus measured position over windows and joints, over the
            RMS of the distance that the joints moved. An error is limited to ten times the range of
            motion of its joint.
        spread: standard deviation of that over the windows.
        per_joint: (n,) RMS over windows, rad or m.
    """

    seconds: Size
    position_error: Size
    spread: Size
    per_joint: tuple[Size, ...]


def require_same_times(*several: Sequence[Horizon]) -> None:
    """Raise ValueError unless there are lists of horizons, all of the same times."""
    times = {tuple(horizon.seconds for horizon in horizons) for horizons in several}
    if len(times) != 1 or () in times:
        raise ValueError("no horizons, or of other times")


@dataclass(frozen=True, eq=False)
class Window:
    """A part of a log to simulate.

    Attributes:
        log: the log in the band of the run.
        start: first sample of the window.
        seconds: length of the window.
    """

    log: FilteredLog
    start: int
    seconds: float

    @property
    def rows(self) -> slice:
        """Samples of the window."""
        return slice(self.start, self.start + round(self.seconds / self.log.step) + 1)


#: kp and kd of the feedback towards the measured motion, (n,) each.
Gains = tuple[FloatArray, FloatArray]


#: Returns the positions (K, n) of a robot at times (K,) s. Arguments: the state q, qd (n,) at the
#: first time, the torque law, the times, and the bounds (n,) around the start. Positions are NaN
#: once the robot leaves the bounds.
Mover = Callable[[FloatArray, FloatArray, Law, FloatArray, FloatArray], FloatArray]


def model_mover(model: Model, X: FloatArray) -> Mover:
    """Return a mover that simulates the model with parameters X (p,).

    Raises:
        ParameterError: friction is negative, so that a motion from rest is not determined.
    """
    require_friction(model, X)

    def positions(
        q: FloatArray, qd: FloatArray, law: Law, t: FloatArray, bounds: FloatArray
    ) -> FloatArray:
        try:
            simulated = simulate_motion(
                model, X, law, t, (q, qd), bounds=bounds, tolerance=_TOLERANCE, calls=_CALLS
            )
            return simulated.q
        except ParameterError:  # the motion is not finite, or has not ended
            return np.concatenate([q[None], np.full((len(t) - 1, len(q)), np.nan)])

    return positions


def gains_of(robot: Robot) -> Gains | None:
    """Return the feedback gains kp and kd of a robot, (n,) each; None if it has none."""
    servo = robot.controller
    if servo is None:
        return None
    factor = torque_of_command(servo, robot.drive)
    return factor * servo.kp, factor * servo.kd


def windows_of(logs: Sequence[FilteredLog], most: int) -> list[Window]:
    """Return windows of the longest possible horizon, evenly over each log and free of masks.

    Args:
        logs: the logs in the band of the run.
        most: maximum number of windows of each log.
    """
    for seconds in reversed(HORIZONS):
        out = [Window(log, k, seconds) for log in logs for k in _starts(log, seconds, most)]
        if out:
            return out
    return []


def _starts(log: FilteredLog, seconds: float, most: int) -> list[int]:
    rows = round(seconds / log.step)
    whole = spans(np.all(log.clear, axis=1))
    clear = [(a, b) for a, b in whole if b - a > rows]
    if not clear:
        return []
    every = np.concatenate([np.arange(a, b - rows) for a, b in clear])
    count = min(most, max(1, len(every) // rows))
    return [int(k) for k in every[np.linspace(0, len(every) - 1, count).astype(int)]]


def at_nodes(log: FilteredLog, x: FloatArray) -> FloatArray:
    """Return a signal (N, c) of a log at its nodes, (K, c), below a quarter of their rate.

    The torque steps at joint reversals are above the cutoff of the motion.
    """
    cutoff = 0.25 / (log.stride * log.step)
    if log.stride > 1 and can_filter(cutoff, log.step):
        x = lowpass(x, log.step, cutoff)
    return x[:: log.stride]


def torque_law(log: FilteredLog, gains: Gains | None = None) -> Law:
    """Return the torque of a log as a law, with feedback towards its measured motion."""
    from scipy.interpolate import CubicSpline

    n, tau, times = log.q.shape[1], at_nodes(log, log.tau), log.t[:: log.stride]
    motion = log.nodes(log.stride) if gains else ()
    pieces = CubicSpline(times, np.concatenate([tau, *motion], axis=1)).c
    first, last = times[[0, -1]].tolist()
    step = log.stride * log.step

    def law(t: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        passed = min(float(t), last) - first
        k = min(int(passed / step), len(times) - 2)
        u = passed - k * step
        powers = np.array((u**3, u**2, u, 1.0))
        at: FloatArray = powers @ pieces[:, k]
        if gains is None:
            return at
        kp, kd = gains
        torque, q_wanted, qd_wanted = at[:n], at[n : 2 * n], at[2 * n :]
        return np.asarray(torque + kp * (q_wanted - q) + kd * (qd_wanted - qd))

    return law


def reference_law(log: FilteredLog) -> Law:
    """Return the reference of a log as a law that holds it until the next sample.

    Raises:
        ParameterError: the log has no reference, or a part of one.
    """
    held = log.samples.reference
    if held is None or np.isnan(held).any():
        raise ParameterError(
            f"compare-sim: {log.name} has no torques and no reference; accepted: a log with qr1.."
        )

    def law(t: float, q: FloatArray, qd: FloatArray) -> FloatArray:  # noqa: ARG001
        before = int(np.searchsorted(log.t, t, side="right")) - 1
        return np.asarray(held[before])

    return law


def play(
    mover: Mover,
    windows: Sequence[Window],
    t: FloatArray,
    law_of: Callable[[FilteredLog], Law] = torque_law,
) -> FloatArray:
    """Simulate windows; return the positions (windows, K, n), NaN where one diverges.

    Args:
        mover: moves the robot.
        windows: windows of one length, grouped by log.
        t: (K,) times after the start of each window, s; the first is 0.
        law_of: returns what moves the robot in a log; by default its torques.
    """
    laws = {log: law_of(log) for log in dict.fromkeys(w.log for w in windows)}
    bounds = position_bounds(windows)
    courses = []
    for window in windows:
        log, start = window.log, window.start
        times = log.t[start] + t
        courses.append(mover(log.q[start], log.qd[start], laws[log], times, bounds))
    return np.stack(courses)


def position_bounds(windows: Sequence[Window]) -> FloatArray:
    """Return the distance from its start at which each joint counts as diverged, (n,).

    It is ten times the range of the joint. A joint that never moves gets a share of the largest
    distance.
    """
    logs = dict.fromkeys(w.log for w in windows)
    ranges = np.ptp(np.concatenate([log.q for log in logs]), axis=0)
    return np.asarray(_AWAY * np.maximum(ranges, max(STILL * ranges.max(), 1e-9)))


def position_errors(
    windows: Sequence[Window], t: FloatArray, moved: FloatArray
) -> tuple[tuple[Horizon, ...], int]:
    """Return the errors over all windows by horizon, and the number of windows that diverged.

    Args:
        windows: the windows of `play`.
        t: (K,) times of `play`, s.
        moved: (windows, K, n) simulated positions.
    """
    far = position_bounds(windows)
    out, diverged = [], 0
    for seconds in HORIZONS:
        if seconds > windows[0].seconds:
            break
        at = int(np.argmin(np.abs(t - seconds)))
        ends = [w.start + round(seconds / w.log.step) for w in windows]
        measured = np.array([w.log.q[k] for w, k in zip(windows, ends, strict=True)])
        way = measured - np.array([w.log.q[w.start] for w in windows])
        e = np.nan_to_num(moved[:, at] - measured, nan=np.inf)
        diverged = max(diverged, int((np.abs(e) > far).any(axis=1).sum()))
        e = np.clip(e, -far, far)
        size = float(np.sqrt(np.mean(way**2))) or 1.0
        each = np.sqrt(np.mean(e**2, axis=1)) / size
        per_joint = tuple(float(x) for x in np.sqrt(np.mean(e**2, axis=0)))
        out.append(Horizon(seconds, float(np.sqrt(np.mean(each**2))), float(each.std()), per_joint))
    return tuple(out), diverged
