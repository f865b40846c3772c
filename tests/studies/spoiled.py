"""What goes wrong between a robot and its file: logs and robot files that are spoiled.

Each kind takes a case, a seeded generator and the torque that the robot's weight asks for, and
returns the spoiled case with the joints that are concerned. `oracles.faults` has what instruments
and recorders do wrong; here is the rest: geometry, gravity, what is carried or touched, friction
that changes, torques that are not the motor's. Nothing here imports the package under test.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from oracles import faults
from oracles.faults import Fault, Log

Generator = np.random.Generator
_EDGE = 0.3  # s, in which a filter sees one side only


@dataclass(frozen=True, eq=False)
class Case:
    """A robot file's text, its training and its validation log.

    `weight` gives the torque (N, n) of gravity at positions, `load` that of a kilogram in a point
    (3,) of the last link along a motion: (t, q, point) -> (N, n). `friction` gives that of a log.
    """

    robot: str
    train: Log
    held: Log
    weight: Callable[[np.ndarray], np.ndarray]
    load: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    rigid: Callable[[Log, Generator], np.ndarray]
    friction: Callable[[Log], np.ndarray]

    def over(self, change: Callable[[Log], Log]) -> Case:
        """Change both logs."""
        return replace(self, train=change(self.train), held=change(self.held))


Spoiled = tuple[Case, tuple[int, ...]]


def _rms(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def _joint(case: Case, rng: Generator) -> int:
    return int(rng.integers(case.train.n))


def speed(log: Log) -> np.ndarray:
    return np.gradient(log.q, log.t, axis=0) if log.qd is None else log.qd


def _sign(log: Log, j: int) -> np.ndarray:
    v = speed(log)[:, j]
    return np.asarray(np.tanh(v / (0.02 * np.abs(v).max())))


def _with_torque(log: Log, j: int, more: np.ndarray) -> Log:
    return log.over("tau", lambda x: x + more[:, None], j)


# The robot file.


def _gravity(case: Case, turn: Callable[[np.ndarray], np.ndarray]) -> Case:
    found = re.search(r"gravity = \[(.*?)\]", case.robot)
    assert found
    g = turn(np.array([float(x) for x in found[1].split(",")]))
    text = ", ".join(repr(float(x)) for x in g)
    return replace(case, robot=case.robot.replace(found[0], f"gravity = [{text}]"))


def gravity_down(case: Case, _: Generator) -> Spoiled:
    """Gravity upside down."""
    return _gravity(case, np.negative), ()


def gravity_sideways(case: Case, rng: Generator) -> Spoiled:
    """Gravity along another axis."""
    return _gravity(case, lambda g: np.roll(g, int(rng.integers(1, 3)))), ()


def gravity_tilted(case: Case, rng: Generator) -> Spoiled:
    """Gravity tilted by 3 to 12 degrees."""
    angle, axis = np.deg2rad(rng.uniform(3, 12)), rng.normal(size=3)

    def turn(g: np.ndarray) -> np.ndarray:
        k = axis - g * (axis @ g) / (g @ g)
        k /= np.linalg.norm(k)
        return np.asarray(np.cos(angle) * g + np.sin(angle) * np.cross(k, g))

    return _gravity(case, turn), ()


def _zeros(case: Case, joints: list[int], offsets: np.ndarray) -> Spoiled:
    return case.over(lambda log: log.over("q", lambda x: x + offsets, *joints)), tuple(joints)


def one_zero(case: Case, rng: Generator) -> Spoiled:
    """The zero of one joint is off by 2 to 10 degrees."""
    size = np.deg2rad(rng.uniform(2, 10)) * rng.choice([-1, 1])
    return _zeros(case, [_joint(case, rng)], np.array([size]))


def three_zeros(case: Case, rng: Generator) -> Spoiled:
    """The zeros of up to three joints are off by 2 to 8 degrees."""
    count = min(3, case.train.n)
    joints = sorted(int(j) for j in rng.choice(case.train.n, count, replace=False))
    return _zeros(case, joints, np.deg2rad(rng.uniform(2, 8, count)) * rng.choice([-1, 1], count))


def zero_slips(case: Case, rng: Generator) -> Spoiled:
    """An encoder slips by 2 to 8 degrees in the middle of the training log."""
    j, size = _joint(case, rng), np.deg2rad(rng.uniform(2, 8))
    log = case.train
    at = log.t > log.t[0] + rng.uniform(0.3, 0.7) * np.ptp(log.t)
    return replace(case, train=log.over("q", lambda x: x + size * at[:, None], j)), (j,)


# What is carried, and what is touched.


def tool_in_a_part(case: Case, rng: Generator) -> Spoiled:
    """A tool is carried from some time of the training log on."""
    log = case.train
    torque = case.load(log.t, log.q, rng.uniform(-0.1, 0.1, 3))
    part = rng.uniform(0.1, 0.4) * np.linalg.norm(_rms(log.tau))
    on = log.t > log.t[0] + rng.uniform(0.3, 0.7) * np.ptp(log.t)
    torque = torque * (part / max(float(np.linalg.norm(_rms(torque))), 1e-9)) * on[:, None]
    return replace(case, train=replace(log, tau=log.tau + torque)), ()


def tool_in_training(case: Case, rng: Generator) -> Spoiled:
    """A tool is carried in the training log, and none in the validation log."""
    log = case.train
    torque = case.load(log.t, log.q, rng.uniform(-0.1, 0.1, 3))
    part = rng.uniform(0.1, 0.4) * np.linalg.norm(_rms(log.tau))
    torque = torque * (part / max(float(np.linalg.norm(_rms(torque))), 1e-9))
    return replace(case, train=replace(log, tau=log.tau + torque)), ()


def collision(case: Case, rng: Generator) -> Spoiled:
    """Something is hit for 0.1 to 0.5 s in the training log: all joints feel it."""
    log = case.train
    at = log.t[0] + rng.uniform(0.1, 0.9) * np.ptp(log.t)
    u = np.clip((log.t - at) / rng.uniform(0.1, 0.5), 0, 1)
    size = rng.uniform(0.5, 3, log.n) * _rms(log.tau) * rng.choice([-1, 1], log.n)
    return replace(case, train=replace(log, tau=log.tau + np.sin(np.pi * u)[:, None] * size)), ()


def leans(case: Case, rng: Generator) -> Spoiled:
    """Something leans on one joint for 1 to 3 s of the training log."""
    log, j = case.train, _joint(case, rng)
    at = log.t[0] + rng.uniform(0.1, 0.8) * np.ptp(log.t)
    on = (log.t > at) & (log.t < at + rng.uniform(1, 3))
    return replace(case, train=_with_torque(log, j, on * rng.uniform(0.3, 1) * _rms(log.tau)[j])), (
        j,
    )


# Friction and drives that change.


def _grown(case: Case, rng: Generator, shape: Callable[[np.ndarray], np.ndarray]) -> Spoiled:
    j = _joint(case, rng)
    size = rng.uniform(0.2, 0.6) * _rms(case.train.tau)[j]
    log = case.train
    u = (log.t - log.t[0]) / np.ptp(log.t)
    return replace(case, train=_with_torque(log, j, size * shape(u) * _sign(log, j))), (j,)


def brake_drags(case: Case, rng: Generator) -> Spoiled:
    """A brake drags from some time of the training log on."""
    at = rng.uniform(0.3, 0.7)
    return _grown(case, rng, lambda u: (u > at).astype(float))


def friction_fades(case: Case, rng: Generator) -> Spoiled:
    """Friction falls as the robot warms up in the training log."""
    return _grown(case, rng, lambda u: np.exp(-u / 0.3))


def torque_drifts(case: Case, rng: Generator) -> Spoiled:
    """A torque sensor drifts along the training log."""
    j, log = _joint(case, rng), case.train
    size = rng.uniform(0.2, 0.8) * _rms(log.tau)[j]
    more = size * (log.t - log.t[0]) / np.ptp(log.t)
    return replace(case, train=_with_torque(log, j, more)), (j,)


def gain_drifts(case: Case, rng: Generator) -> Spoiled:
    """The torque constant of one joint falls by 10 to 40 % along the training log."""
    j, log = _joint(case, rng), case.train
    gain = 1 - rng.uniform(0.1, 0.4) * (log.t - log.t[0]) / np.ptp(log.t)
    return replace(case, train=log.over("tau", lambda x: x * gain[:, None], j)), (j,)


# Torques that are not the motor's.


def _filtered(log: Log, joints: list[int], seconds: float) -> Log:
    from scipy.signal import lfilter

    a = np.exp(-log.step / seconds)

    def slow(x: np.ndarray) -> np.ndarray:
        return np.column_stack([lfilter([1 - a], [1, -a], c, zi=[a * c[0]])[0] for c in x.T])

    return log.over("tau", slow, *joints)


def slow_torques(case: Case, rng: Generator) -> Spoiled:
    """All torques pass a slow low-pass of 0.03 to 0.3 s before they are recorded."""
    seconds = float(10 ** rng.uniform(np.log10(0.03), np.log10(0.3)))
    return case.over(lambda log: _filtered(log, [*range(log.n)], seconds)), ()


def slow_torque(case: Case, rng: Generator) -> Spoiled:
    """The torque of one joint passes a slow low-pass of 0.03 to 0.3 s."""
    j, seconds = _joint(case, rng), float(10 ** rng.uniform(np.log10(0.03), np.log10(0.3)))
    return case.over(lambda log: _filtered(log, [j], seconds)), (j,)


def gravity_compensated(case: Case, _: Generator) -> Spoiled:
    """The torque beside what the controller adds for gravity."""
    return case.over(lambda log: replace(log, tau=log.tau - case.weight(log.q))), ()


def commanded(case: Case, rng: Generator) -> Spoiled:
    """What a controller asks for without the friction: gravity, and a part of what is left."""
    part = rng.uniform(0.2, 0.6)

    def ask(log: Log) -> Log:
        weight = case.weight(log.q)
        return replace(log, tau=weight + part * (log.tau - weight) * np.abs(np.tanh(speed(log))))

    return case.over(ask), ()


def fed_forward(case: Case, rng: Generator) -> Spoiled:
    """A controller's feed-forward: its own rigid-body model along the reference, no friction."""
    seed = int(rng.integers(1 << 30))

    def ask(log: Log) -> Log:
        # The ends are left out: what is smoothed there is no reference.
        inside = np.flatnonzero((log.t > log.t[0] + _EDGE) & (log.t < log.t[-1] - _EDGE))
        return replace(log, tau=case.rigid(log, np.random.default_rng(seed))).rows(inside)

    return case.over(ask), ()


def friction_taken_off(case: Case, rng: Generator) -> Spoiled:
    """The torque beside 60 to 95 % of the friction, which the drive adds by itself."""
    part = rng.uniform(0.6, 0.95)
    return case.over(lambda log: replace(log, tau=log.tau - part * case.friction(log))), ()


def sensor_creeps(case: Case, rng: Generator) -> Spoiled:
    """The zero of a torque sensor relaxes to its value in each log, from 20 to 80 % of the RMS."""
    j, part = _joint(case, rng), rng.uniform(0.2, 0.8) * rng.choice([-1, 1])
    seconds = rng.uniform(0.1, 0.6) * np.ptp(case.train.t)
    size = part * _rms(case.train.tau)[j]
    return case.over(lambda x: _with_torque(x, j, size * np.exp((x.t[0] - x.t) / seconds))), (j,)


def sensor_creeps_with_load(case: Case, rng: Generator) -> Spoiled:
    """A torque sensor follows 5 to 20 % of its torque with a lag of 3 s and more."""
    from scipy.signal import lfilter

    j, part = _joint(case, rng), rng.uniform(0.05, 0.2)
    seconds = max(3.0, rng.uniform(0.1, 0.6) * np.ptp(case.train.t))

    def late(log: Log) -> Log:
        a = np.exp(-log.step / seconds)
        return _with_torque(log, j, part * lfilter([1 - a], [1, -a], log.tau[:, j]))

    return case.over(late), (j,)


def crosstalk(case: Case, rng: Generator) -> Spoiled:
    """A torque channel has 5 to 20 % of the torque of another joint."""
    j, k = (int(x) for x in rng.choice(case.train.n, 2, replace=False))
    part = rng.uniform(0.05, 0.2) * rng.choice([-1, 1])
    return case.over(lambda log: _with_torque(log, j, part * log.tau[:, k])), (j,)


def two_millinewton_metres(case: Case, rng: Generator) -> Spoiled:
    """The torques of two joints are in mN m."""
    joints = sorted(int(j) for j in rng.choice(case.train.n, 2, replace=False))
    return case.over(lambda log: log.over("tau", lambda x: 1e3 * x, *joints)), tuple(joints)


def two_gains(case: Case, rng: Generator) -> Spoiled:
    """The torques of two joints are wrong by 1.2 to 2."""
    joints = sorted(int(j) for j in rng.choice(case.train.n, min(2, case.train.n), replace=False))
    gain = rng.uniform(1.2, 2, len(joints)) ** rng.choice([-1, 1], len(joints))
    return case.over(lambda log: log.over("tau", lambda x: x * gain, *joints)), tuple(joints)


def two_signs(case: Case, rng: Generator) -> Spoiled:
    """Two torques have the other sign."""
    joints = sorted(int(j) for j in rng.choice(case.train.n, min(2, case.train.n), replace=False))
    return case.over(lambda log: log.over("tau", np.negative, *joints)), tuple(joints)


def loud(case: Case, rng: Generator) -> Spoiled:
    """One torque has noise of half its size and more: honest, if badly measured."""
    j, part = _joint(case, rng), rng.uniform(0.5, 1.5)
    return case.over(
        lambda log: _with_torque(log, j, part * _rms(log.tau)[j] * rng.normal(size=len(log.t)))
    ), (j,)


def constant(case: Case, rng: Generator) -> Spoiled:
    """One torque is a constant."""
    j = _joint(case, rng)
    return case.over(lambda log: log.over("tau", lambda x: 0 * x + x.mean(), j)), (j,)


def clock_runs_fast(case: Case, rng: Generator) -> Spoiled:
    """The stamps run 1.1 to 1.5 times too fast; measured speeds are right."""
    rate = rng.uniform(1.1, 1.5)
    return case.over(lambda log: replace(log, t=log.t[0] + (log.t - log.t[0]) / rate)), ()


def leak(case: Case, rng: Generator) -> Spoiled:
    """The validation log is a piece of the training log, renamed and stamped from zero."""
    log = case.train
    length = int(len(log.t) * rng.uniform(0.2, 0.5))
    begin = int(rng.integers(0, len(log.t) - length))
    piece = log.rows(np.arange(begin, begin + length))
    return replace(case, held=replace(piece, t=piece.t - piece.t[0])), ()


def resampled_leak(case: Case, rng: Generator) -> Spoiled:
    """The validation log is a piece of the training log at other stamps, linear between samples."""
    log = case.train
    length, step = rng.uniform(0.2, 0.5) * np.ptp(log.t), log.step * rng.uniform(0.6, 1.4)
    begin = log.t[0] + rng.uniform(0, 1) * (np.ptp(log.t) - length)
    t = np.arange(begin, begin + length, step)

    def at(x: np.ndarray) -> np.ndarray:
        return np.column_stack([np.interp(t, log.t, c) for c in x.T])

    qd = None if log.qd is None else at(log.qd)
    return replace(case, held=replace(log, t=t - begin, q=at(log.q), qd=qd, tau=at(log.tau))), ()


OWN = (
    gravity_down, gravity_sideways, gravity_tilted, one_zero, three_zeros, zero_slips,
    tool_in_a_part, tool_in_training, collision, leans, brake_drags, friction_fades,
    torque_drifts, gain_drifts, slow_torques, slow_torque, gravity_compensated, commanded,
    fed_forward, two_gains, two_signs, loud, constant, clock_runs_fast, leak, resampled_leak,
    friction_taken_off, sensor_creeps, sensor_creeps_with_load, crosstalk, two_millinewton_metres,
)  # fmt: skip


def _recorder(spoil: Callable[[Log, Generator], tuple[Log, Fault]]) -> Callable[..., Spoiled]:
    """A fault of `oracles.faults` in both logs alike."""

    def kind(case: Case, rng: Generator) -> Spoiled:
        seed = int(rng.integers(1 << 30))
        train, done = spoil(case.train, np.random.default_rng(seed))
        held, _ = spoil(case.held, np.random.default_rng(seed))
        joints = {int(c.lstrip("qdtau")) - 1 for c in done.channels if c.lstrip("qdtau")}
        return replace(case, train=train, held=held), tuple(sorted(joints))

    return kind


KINDS: dict[str, Callable[[Case, Generator], Spoiled]] = {
    **{f.__name__: f for f in OWN},
    **{f.__name__: _recorder(f) for f in faults.HEAVY},
}
