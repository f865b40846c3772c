"""The sanity gate: what a log's samples say about its own channels, before any physics.

Position and speed of one joint must be one motion; a channel that stays constant while its joint
moves is dead; a jump that would need several times the joint's fastest motion is none of the
joint's. Torques are looked at in `symgen.diagnosis.torque_sanity`, with little model.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import Samples, differentiate
from symgen.diagnosis.diagnosis import FoundParameter
from symgen.diagnosis.evidence import Scene, least_squares
from symgen.names import REVOLUTE
from symgen.robot.effect import unit
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]
SENSOR = "velocity_sensor_error"
#: Share of the speed, RMS, below which an error of its sensor is not worth a word.
_MATTERS = 0.01
_SIGNIFICANCE = 0.001
_STILL = 0.01  # of the fastest joint's RMS speed
_COHERENT = 0.5  # least share of a measured speed that the derivative of q explains
_STUCK = 0.1  # of its range: what a channel should have changed while it stays the same
_NEAR = 5  # samples
_JUMP = 5.0  # times the largest usual difference (99 of 100 are smaller)
_UNITS = {
    180 / math.pi: ("degrees", "multiply it by pi/180"),
    math.pi / 180: ("degrees", "multiply it by pi/180"),
    1000.0: ("thousandths", "divide it by 1000"),
    0.001: ("thousandths", "divide it by 1000"),
    30 / math.pi: ("turns per minute", "multiply it by pi/30"),
}


@dataclass(frozen=True, eq=False)
class Fault:
    """Something that is wrong with the channels of a log.

    Attributes:
        name: of an effect of the library (velocity_sensor_error, saturation), or "units", "sign",
            "swapped", "stuck", "step".
        joints: positions of the movable joints; empty for all.
        channel: what the log calls it.
        parameters: how much, with standard deviations.
        says: how much and how to correct it, one line.
        corrected: a scene -> the scene without the fault; None where no correction is known.
        p_value: of the test.
    """

    name: str
    joints: tuple[int, ...]
    channel: str
    parameters: tuple[FoundParameter, ...]
    says: str
    corrected: Callable[[Scene], Scene] | None = None
    p_value: float = 0.0


@dataclass(frozen=True, eq=False)
class Kinematics:
    """How a measured speed follows the derivative v of the position.

    qd(t) = (1 + gain) v(t - lag) + offset.

    Attributes:
        values, std: (3,) gain, lag in s, offset in rad/s (m/s).
        share: RMS of the error over RMS of the speed.
        coherence: share of the measured speed's square (mean apart) that v explains.
        p_value: that there is no error.
    """

    values: FloatArray
    std: FloatArray
    share: float
    coherence: float
    p_value: float


def kinematics(s: Scene, j: int, other: int | None = None) -> Kinematics:
    """Regress a measured speed on the derivative of a position and on its derivative.

    To first order qd = (1 + G) (v(t - L0) - (L - L0) v'(t - L0)) + O, iterated in L0. Noise in the
    band is taken as white, so that four samples in a period are worth two, and three deviations of
    blocks are not below it.

    Args:
        s: the log in the motion's band.
        j: position of the joint whose speed is looked at.
        other: position of the joint whose position is differentiated; None for the same.
    """
    v = differentiate(s.q[:, j if other is None else other], s.step)
    a = differentiate(v, s.step)
    y, t, lag = s.qd[s.kept, j], s.t[s.kept], 0.0
    size = float(np.sqrt(np.mean(v[s.kept] ** 2))) or 1.0
    x, A = np.zeros(3), np.zeros((len(y), 3))
    for _ in range(4):
        moved = (np.interp(t - lag, s.t, c) for c in (v, -a))
        A = np.column_stack([*moved, np.ones(len(t))])
        x = least_squares(A, y)
        step = float(x[1] / x[0]) if abs(x[0]) > 1e-3 else 0.0
        if abs(lag + step) * 10 > s.t[-1] - s.t[0]:
            break
        lag += step
    error = y - A @ x
    spread = float(np.sum((y - y.mean()) ** 2))
    coherence = 1 - float(np.sum(error**2)) / spread if spread > 0 else 0.0
    # In parameters (1 + G, (1 + G) lag, O); lag = second over first.
    # Rounding of the numbers themselves is an error too, where a log is free of noise.
    floor = (1e-9 * size) ** 2 * np.linalg.pinv(A.T @ A) * len(y)
    covariance = covariance_of(A, error) + floor
    gain = float(x[0])
    scale = np.array([1.0, 1 / max(abs(gain), 1e-3), 1.0])
    values: FloatArray = np.array([gain - 1, lag, x[2]])
    std: FloatArray = np.asarray(np.sqrt(np.diag(covariance)) * scale, dtype=np.float64)
    wrong = y - v[s.kept] - error
    wald = np.array([gain - 1, gain * lag, x[2]])
    z2 = float(wald @ np.linalg.solve(covariance, wald))
    # Survival of chi-square with three degrees of freedom.
    p = math.erfc(math.sqrt(z2 / 2)) + math.sqrt(2 * z2 / math.pi) * math.exp(-z2 / 2)
    return Kinematics(values, std, float(np.sqrt(np.mean(wrong**2))) / size, coherence, p)


def covariance_of(A: FloatArray, error: FloatArray, blocks: int = 20) -> FloatArray:
    """Return the covariance of least squares: the larger trace of white noise and of blocks."""
    bread: FloatArray = np.asarray(np.linalg.pinv(A.T @ A), dtype=np.float64)
    plain = 2 * bread * float(np.mean(error**2))
    pieces = np.array_split(A * error[:, None], blocks)
    sums = np.array([piece.sum(axis=0) for piece in pieces])
    robust = bread @ (sums.T @ sums) @ bread
    size = np.maximum(np.diag(plain), 1e-300)
    growth = float(np.max(np.diag(robust) / size))
    out: FloatArray = plain * max(1.0, growth)
    return out


def motion_faults(robot: Robot, samples: Samples, s: Scene) -> list[Fault]:
    """Look at the positions and speeds of one log: no model.

    Args:
        robot: gives the joints' numbers and types.
        samples: the log, unfiltered.
        s: the same log in the motion's band.
    """
    out = _stuck_motion(robot, samples, s)
    taken = {j for fault in out for j in fault.joints}
    jumps = _jumps(robot, samples, "q", samples.q)
    if not samples.velocity_derived:
        jumps += _jumps(robot, samples, "qd", samples.qd)
    out += [fault for fault in jumps if not taken.intersection(fault.joints)]
    if samples.velocity_derived:
        return out
    taken = {j for fault in out for j in fault.joints}
    own = {j: kinematics(s, j) for j in moving(s) if j not in taken}
    factors = [_factor(1 + k.values[0]) for k in own.values() if k.coherence > _COHERENT]
    if len(own) > 1 and factors and None not in factors and len(set(factors)) == 1:
        says = f"t of {s.name}: speeds are {factors[0]:.4g} times dq/dt on every joint: check units"
        return [*out, Fault("units", (), "t or qd", (), says)]
    tests = max(len(own), 1)
    for j, k in own.items():
        fault = None if j in taken else _speed_fault(robot, s, j, k, tests)
        if fault is not None:
            out.append(fault)
            taken |= set(fault.joints)
    return out


def _speed_fault(robot: Robot, s: Scene, j: int, k: Kinematics, tests: int) -> Fault | None:
    number, sigma = robot.movable[j].number, robot.movable[j].sigma
    channel, where = f"qd{number}", f"qd{number} of {s.name}"
    if k.coherence < _COHERENT:
        for other in moving(s):
            cross = kinematics(s, j, other)
            if other != j and cross.coherence > 1 - (1 - _COHERENT) / 5:
                follows = robot.movable[other].number
                says = f"{where} follows dq{follows}/dt: swap the channels of the two joints"
                return Fault("swapped", (j, other), channel, (), says, _derived((j, other)))
        says = f"{where} is not the derivative of q{number}: leave it out, or look at the sensor"
        return Fault("stuck", (j,), channel, (), says, _derived((j,)))
    if k.share < _MATTERS or k.p_value * tests > _SIGNIFICANCE:
        return None
    gain, lag, offset = (float(x) for x in k.values)
    factor = _factor(1 + gain) if sigma == REVOLUTE or abs(gain) > 100 else None
    if factor is not None:
        unit_, how = _UNITS[factor]
        wrong = channel if factor > 1 else f"q{number}"
        says = f"{where} is {factor:.4g} times dq{number}/dt: {wrong} is in {unit_}; {how}"
        fixed = _derived((j,)) if factor > 1 else None
        return Fault("units", (j,), wrong, (), says, fixed)
    if gain < -1:
        says = f"{where} is {1 + gain:.3g} times dq{number}/dt: change its sign"
        return Fault("sign", (j,), channel, (), says, _derived((j,)))
    units = ("", "s", unit("speed", sigma))
    names = (f"GV{number}", f"LV{number}", f"OV{number}")
    rows = zip(names, k.values, k.std, units, strict=True)
    says = (
        f"{where} differs from dq{number}/dt by {100 * k.share:.1f} % of the speed: gain "
        f"{1 + gain:.4g}, lag {1e3 * lag:.3g} ms, offset {offset:.3g} {units[2]}; qd is replaced "
        f"by the derivative of q{number}"
    )
    values = tuple(FoundParameter(n, float(x), float(d), u) for n, x, d, u in rows)
    return Fault(SENSOR, (j,), channel, values, says, _derived((j,)), k.p_value)


def _factor(gain: float) -> float | None:
    """Return the factor between two customary units that a gain is, within 2 %."""
    return next((f for f in _UNITS if abs(gain / f - 1) < 0.02), None)


def _derived(joints: tuple[int, ...]) -> Callable[[Scene], Scene]:
    """Return the correction of speeds: the derivative of the position, in the same band."""

    def correct(s: Scene) -> Scene:
        qd = s.qd.copy()
        for j in joints:
            qd[:, j] = differentiate(s.q[:, j], s.step)
        return s.along(s.q, qd)

    return correct


def moving(s: Scene) -> list[int]:
    """Return the joints that move, faster than a hundredth of the fastest one in RMS."""
    speed = np.sqrt(np.mean(differentiate(s.q, s.step)[s.kept] ** 2, axis=0))
    return [int(j) for j in np.flatnonzero(speed > _STILL * speed.max(initial=0.0))]


def _stuck_motion(robot: Robot, samples: Samples, s: Scene) -> list[Fault]:
    """Find positions and speeds that stay exactly the same while the other one says motion."""
    if samples.velocity_derived:
        return []
    out = []
    v = differentiate(s.q, s.step)
    travel = np.cumsum(s.qd, axis=0) * s.step
    for j, joint in enumerate(robot.movable):
        pairs = (("q", samples.q, travel, s.qd), ("qd", samples.qd, v, v))
        for channel, x, should, speed in pairs:
            if np.sqrt(np.mean(speed[:, j] ** 2)) <= _STILL * _fastest(speed):
                continue
            span = frozen(x[:, j], should[:, j], s.free[:, j])
            if span is not None:
                name = f"{channel}{joint.number}"
                fixed = _derived((j,)) if channel == "qd" else None
                out.append(stuck(name, (j,), samples, span, fixed))
                break
    return out


def _fastest(speed: FloatArray) -> float:
    return float(np.sqrt(np.mean(speed**2, axis=0)).max())


def stuck(
    channel: str,
    joints: tuple[int, ...],
    samples: Samples,
    span: tuple[int, int],
    fixed: Callable[[Scene], Scene] | None = None,
) -> Fault:
    says = (
        f"{channel} of {samples.name} stays the same from t = {samples.t[span[0]]:.4g} s to "
        f"{samples.t[span[1]]:.4g} s while the joint moves: leave that time out, or look at the "
        "sensor"
    )
    return Fault("stuck", joints, channel, (), says, fixed)


def frozen(
    x: FloatArray, should: FloatArray, counts: NDArray[np.bool_], except_: float = math.inf
) -> tuple[int, int] | None:
    """Return the first and last sample of a constant run in which x should have changed.

    Args:
        x: (N,) a channel, unfiltered.
        should: (N,) what it should be like, up to an offset.
        counts: (N,) where that is known.
        except_: runs at this absolute value or beyond are the business of a limit.
    """
    edges = np.flatnonzero(np.diff(x) != 0)
    first, last = np.r_[0, edges + 1], np.r_[edges, len(x) - 1]
    whole = _range(should[counts])
    for at in np.argsort(first - last)[:3]:
        run = slice(first[at], last[at] + 1)
        changed = _range(should[run][counts[run]])
        # A quantised channel stays the same for less than a step of its own.
        coarse = np.abs(np.diff(x))
        step = float(np.min(coarse[coarse > 0], initial=whole)) if len(edges) else 0.0
        if changed > _STUCK * whole > 0 and changed > 5 * step and abs(x[first[at]]) < except_:
            return int(first[at]), int(last[at])
    return None


def _range(x: FloatArray) -> float:
    return float(np.ptp(x)) if len(x) else 0.0


def _jumps(robot: Robot, samples: Samples, name: str, x: FloatArray) -> list[Fault]:
    """Find one-sample jumps far beyond the usual differences; a speed's must not be a motion's."""
    out = []
    for j, joint in enumerate(robot.movable):
        jump = jumped(x[:, j])
        if name == "qd":
            jump = jump[[not _moved(samples.q[:, j], x[:, j], i, samples.step) for i in jump]]
        if len(jump):
            fixed = _derived((j,)) if name == "qd" else None
            out.append(step_fault(f"{name}{joint.number}", j, samples, x[:, j], jump, fixed))
    return out


def _moved(q: FloatArray, qd: FloatArray, i: int, step: float, wide: int = _NEAR) -> bool:
    """Whether a jump of the speed after sample i is one of the motion, as at a hard stop.

    The mean speed over some samples then changes as the slope of q does; a sensor's single wrong
    sample shifts it by a fifth of the jump, a step by all of it.
    """
    before, after = max(i - wide, 0), min(i + 1 + wide, len(q) - 1)
    slopes = (q[i] - q[before]) / (i - before), (q[after] - q[i + 1]) / (after - i - 1)
    means = _mean_speed(qd[before : i + 1]), _mean_speed(qd[i + 1 : after + 1])
    change = means[1] - means[0] - (slopes[1] - slopes[0]) / step
    return abs(float(change)) < 0.15 * abs(float(qd[i + 1] - qd[i]))


def _mean_speed(qd: FloatArray) -> float:
    """Return the mean speed from the first to the last sample, by trapezoids."""
    return float(np.mean((qd[1:] + qd[:-1]) / 2))


def step_fault(
    channel: str,
    j: int,
    samples: Samples,
    x: FloatArray,
    jump: NDArray[np.intp],
    fixed: Callable[[Scene], Scene] | None = None,
) -> Fault:
    at = int(jump[0])
    says = (
        f"{channel} of {samples.name} jumps by {x[at + 1] - x[at]:.4g} from one sample to the next "
        f"at t = {samples.t[at]:.6g} s ({len(jump)} such): leave that time out, or look at the "
        "sensor"
    )
    return Fault("step", (j,), channel, (), says, fixed)


def jumped(x: FloatArray) -> NDArray[np.intp]:
    """Return the samples after which x jumps by several times its largest usual difference."""
    d = np.diff(x)
    size = np.abs(d)
    if len(d) < 10 or not np.any(size > 0):
        return np.zeros(0, dtype=np.intp)
    usual = float(np.quantile(size[size > 0], 0.99))
    around = np.median([np.roll(d, k) for k in (-3, -2, -1, 1, 2, 3)], axis=0)
    found = np.flatnonzero((np.abs(d - around) > _JUMP * usual)[3:-3]) + 3
    return found[np.diff(found, prepend=-_NEAR - 1) > _NEAR]  # there and back is one
