"""Reference motions: from a file or a log, or a Fourier series within limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from symgen import names
from symgen.data.drive import joint_side
from symgen.data.log import MIN_SAMPLES, Log, read_log, read_only
from symgen.data.raw import FloatArray, csv_bytes, refuse
from symgen.data.signals import differentiate, prepare
from symgen.data.tables import read_columns
from symgen.errors import LogError
from symgen.experiment.trajectory import Fourier
from symgen.robot.tables import Limits
from symgen.robot.types import Robot

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

_ACCEPTED = "CSV with the columns t, q1.. and optionally qd1.., qdd1.."
_HARMONICS = 5
_MOST = 20_000_000  # samples: more would exhaust the memory
#: Default limits of a reference without [limits]: position, speed, acceleration.
_MODEST = {names.REVOLUTE: (1.0, 1.5, 6.0), names.PRISMATIC: (0.2, 0.5, 3.0)}
#: Share of the limits that a reference uses: the controller needs the rest.
_PART = 0.9


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion to follow, interpolated by polynomials of degree five.

    Attributes:
        name: name in messages.
        t: (N,) s, increasing.
        q: (N, n) rad or m.
        qd: (N, n) rad/s or m/s.
        qdd: (N, n) rad/s2 or m/s2.
        curves: q, qd and qdd over time.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    curves: tuple[BPoly, ...]

    def at(self, t: FloatArray) -> FloatArray:
        """Return q, qd and qdd (T, 3, n) at times (T,); the robot rests outside the motion."""
        inside = np.clip(t, self.t[0], self.t[-1])
        out = np.stack([curve(inside) for curve in self.curves], axis=1)
        out[inside != t, 1:] = 0.0
        return out


def make_reference(
    name: str, t: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> Reference:
    """Make a reference from arrays.

    Args:
        name: name in messages.
        t: (N,) s.
        q: (N, n) rad or m.
        qd: (N, n), dq/dt.
        qdd: (N, n), dqd/dt.

    Raises:
        LogError: there are fewer than 2 stamps, shapes differ, a number is not finite, or time does
            not increase.
    """
    from scipy.interpolate import BPoly

    shape = len(t), q.shape[-1]
    if len(t) <= 1 or not q.shape == qd.shape == qdd.shape == shape:
        refuse(f"{name}: t {t.shape}, q {q.shape}, qd {qd.shape}, qdd {qdd.shape}", "(N,), (N, n)")
    if not all(np.isfinite(x).all() for x in (t, q, qd, qdd)):
        refuse(f"{name}: a value is not a finite number", "finite numbers")
    if np.diff(t).min() <= 0:
        k = int(np.argmin(np.diff(t) > 0)) + 1
        refuse(f"{name}: sample {k}: {t[k]:.9g} s comes after {t[k - 1]:.9g} s", "increasing time")
    h = np.diff(t)[:, None]
    v, w = qd * 2 / 5, qdd / 20
    begin = [q[:-1], q[:-1] + h * v[:-1] / 2, q[:-1] + h * v[:-1] + h**2 * w[:-1]]
    end = [q[1:] - h * v[1:] + h**2 * w[1:], q[1:] - h * v[1:] / 2, q[1:]]
    path = BPoly(np.stack([*begin, *end]), t)
    t, q, qd, qdd = map(read_only, (t, q, qd, qdd))
    return Reference(name, t, q, qd, qdd, (path, path.derivative(), path.derivative(2)))


def reference_of(
    source: Reference | Log | str | Path | None, robot: Robot, **options: float
) -> Reference:
    """Return a reference from any of its sources.

    Args:
        source: a reference; a log or its NPZ or Parquet file, whose motion is filtered; a CSV; None
            for a Fourier series.
        robot: the robot that moves.
        options: duration, rate and seed of the Fourier series.

    Raises:
        LogError: the file cannot be read, or has another number of joints than the robot.
    """
    if isinstance(source, (Log, str, Path)):
        source = opened(source, robot)
    if source is None:
        reference = fourier(robot, **options)
    elif isinstance(source, Reference):
        reference = source
    elif isinstance(source, Log):
        reference = from_log(source)
    else:
        reference = read_reference(source)
    if reference.q.shape[1] != robot.n:
        refuse(
            f"{reference.name}: it moves {reference.q.shape[1]} joints, the robot has {robot.n}",
            "as many",
        )
    return reference


def opened(source: Log | str | Path, robot: Robot) -> Log | str | Path:
    """Read a source in a log format; return the path of a CSV, which can have fewer columns.

    The [drive] of the robot maps a log to the joint side. A CSV is already on it.
    """
    if isinstance(source, Log):
        return joint_side(source, robot.drive)
    if Path(source).suffix.lower() not in (".npz", ".parquet"):
        return source
    return read_log(source, drive=robot.drive)


def from_log(log: Log) -> Reference:
    """Return the measured motion of a log: q through a zero-phase low-pass filter, and its slopes.

    Measured speeds are not used, so that q, qd and qdd belong to one motion.
    """
    s = prepare(Log(log.name, log.t, log.q, None, log.tau))
    return make_reference(log.name, s.t, s.q, s.qd, differentiate(s.qd, s.step))


def torques_of(
    source: Log | str | Path, robot: Robot
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]]:
    """Return t (N,), tau (N, n), and the initial state.

    Raises:
        LogError: the source cannot be read, or has another number of joints.
    """
    source = opened(source, robot)
    if isinstance(source, Log):
        aim = from_log(source)
        assert source.tau is not None  # from_log guarantees it
        name, t, tau = source.name, source.t, source.tau
        start = (aim.q[0], aim.qd[0]) if source.qd is None else (source.q[0], source.qd[0])
    else:
        name, rest = str(source), np.zeros((1, robot.n))
        t, columns = read_columns(source, ("tau",), ("q", "qd"), "CSV with the columns t, tau1..")
        tau, start = columns["tau"], (columns.get("q", rest)[0], columns.get("qd", rest)[0])
    if tau.shape[1] != robot.n:
        raise LogError(f"{name}: {tau.shape[1]} torques, the robot has {robot.n} joints")
    return t, tau, start


def read_reference(path: str | Path) -> Reference:
    """Read a reference from CSV; a spline of degree five supplies missing derivatives.

    Raises:
        LogError: the file cannot be read, or derivatives are missing and time steps vary.
    """
    t, columns = read_columns(path, ("q",), ("qd", "qdd"), _ACCEPTED)
    step = float((t[-1] - t[0]) / (len(t) - 1))
    uniform = float(np.abs(np.diff(t) - step).max()) <= 1e-3 * step
    if not (uniform or {"qd", "qdd"} <= columns.keys()):
        refuse(
            f"{path}: time steps vary, and derivatives are missing",
            "qd1.. and qdd1.., or equal time steps",
        )
    q = columns["q"]
    qd = columns["qd"] if "qd" in columns else differentiate(q, step)
    qdd = columns["qdd"] if "qdd" in columns else differentiate(qd, step)
    return make_reference(str(path), t, q, qd, qdd)


def as_csv(t: FloatArray, groups: Mapping[str, FloatArray]) -> bytes:
    """Return the content of a CSV with t (N,) and columns q1, q2, ... of groups q, ... (N, n)."""
    names = [f"{name}{j + 1}" for name, x in groups.items() for j in range(x.shape[1])]
    return csv_bytes(["t", *names], np.column_stack([t, *groups.values()]), 12)


def fourier(
    robot: Robot, *, duration: float = 20.0, rate: float = 1000.0, seed: float = 0
) -> Reference:
    """Return a seeded Fourier series that begins and ends at rest, within 90 % of [limits].

        q_j = c_j + sum over k = 1..5 of (a_jk sin(k w t) - b_jk cos(k w t)) / (k w),
        w = 2 pi / duration, at least 0.1 Hz

    with speeds and accelerations of 0 at t = 0 (Swevers and others 1997). The default limits are
    1 rad, 1.5 rad/s, 6 rad/s2 (0.2 m, 0.5 m/s, 3 m/s2) about zero.

    Args:
        robot: robot with the limits.
        duration: duration in s. The series repeats, so that its period is at most 10 s.
        rate: stamps per second.
        seed: seed of the coefficients.
    """
    samples = duration * rate
    if not (math.isfinite(samples) and MIN_SAMPLES <= samples <= _MOST):
        accepted = f"{MIN_SAMPLES} to {_MOST:,} samples"
        refuse(f"reference: {duration:g} s at {rate:g} Hz", accepted)
    t = np.arange(round(samples) + 1) / rate
    series = Fourier(duration / math.ceil(duration / 10.0), _HARMONICS)
    k = np.arange(1, _HARMONICS + 1)
    draw = np.random.default_rng([int(seed), 4])
    a, b = draw.uniform(-1, 1, (2, robot.n, _HARMONICS))
    a -= a.mean(axis=1, keepdims=True)  # speed and acceleration are 0 at both ends
    b -= (b @ k)[:, None] * k / (k @ k)
    w = 2 * math.pi / series.duration * k
    c = np.zeros((2 * _HARMONICS + 1, robot.n))
    c[1::2], c[2::2] = -(b / w).T, (a / w).T
    motion = np.stack([series.matrix(t, order) @ c for order in range(3)])
    limits = robot.limits or Limits()
    far, fast, hard = np.array([_MODEST[sigma] for sigma in robot.sigma]).T
    low, high = np.array(limits.position).T if limits.position else (-far, far)
    # A wide range would give slow motion with few reversals; one turn in each direction is enough.
    half = np.minimum((high - low) / 2, 2 * far)
    top = np.array([half, limits.velocity or fast, limits.acceleration or hard])
    motion[0] -= (motion[0].max(axis=0) + motion[0].min(axis=0)) / 2
    motion *= _PART * (top / np.abs(motion).max(axis=1)).min(axis=0)
    motion[0] += (low + high) / 2
    return make_reference("Fourier series", t, *motion)
