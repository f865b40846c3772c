"""The sanity gate's second half: torques, looked at with little model.

The equations of one joint alone tell whether its torque has the right sign: friction dissipates and
inertia is positive; a torque that stays at its largest value where the model asks for more is cut
by a limit. What the model of the whole arm tells of channels is in
`symgen.estimation.channel_faults`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import at_rest
from symgen.data.signals import Samples
from symgen.diagnosis.diagnosis import FoundParameter
from symgen.diagnosis.evidence import Evidence, Scene, least_squares, model_torque, solved
from symgen.diagnosis.sanity import (
    Fault,
    covariance_of,
    frozen,
    jumped,
    moving,
    step_fault,
    stuck,
)
from symgen.robot.effect import unit
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
SATURATION = "saturation"
SIGMAS = 5.0
HALF = 0.5  # of a jump of a torque: what its residual keeps
_FLAT = 2.0  # times the channel's noise: how flat the top of a cut torque is
_AT_LIMIT = 3.0  # times the noise: how near to the limit a torque is that is cut
_LEAST = 100  # samples in which a limit is looked for
_PEAKS = 60  # limits that are tried
_ROUNDS = 4
_SIGNIFICANCE = 0.001
_CUT = 0.01  # least gain, of the joint's sum of squares


def modelled(evaluator: Evaluator, base: Evidence) -> list[FloatArray]:
    """Return the model's torque in the band along every training log, (N, n)."""
    return [s.smooth(model_torque(evaluator, base.X, s)) for s in base.scenes]


def torque_faults(
    evaluator: Evaluator,
    samples: Sequence[Samples],
    base: Evidence,
    models: Sequence[FloatArray],
) -> list[Fault]:
    """Look at the torques of the training logs, with the equations of each joint alone.

    Args:
        evaluator: the compiled model.
        samples: the logs, unfiltered.
        base: the model's evidence on the same logs.
        models: its torques there.
    """
    robot = evaluator.model.robot
    out: list[Fault] = []
    for log, s, model in zip(samples, base.scenes, models, strict=True):
        out += _stuck_torques(robot, log, s, model)
    taken = {j for fault in out for j in fault.joints}
    joints = [j for j in moving(base.scenes[0]) if j not in taken]
    signs = {j: _reversed(evaluator, base, j) for j in joints}
    for j, (mass, loss) in signs.items():
        if mass and loss:
            number = robot.movable[j].number
            says = (
                f"tau{number}, or q{number} and qd{number}: with this sign the friction of joint "
                f"{number} would give energy and its inertia would be negative: change the sign"
            )
            out.append(Fault("sign", (j,), f"tau{number}", (), says))
    if signs and all(loss and not mass for mass, loss in signs.values()):
        says = "t: friction would give energy at every joint: time runs backwards in these logs"
        out.append(Fault("time", (), "t", (), says))
    return out


def torque_jumps(
    robot: Robot, samples: Sequence[Samples], base: Evidence, models: Sequence[FloatArray]
) -> list[Fault]:
    """Find steps of torques that the model does not ask for, once all channels are in order.

    Args:
        robot: the robot.
        samples: the logs, unfiltered.
        base: the model's evidence on the same logs.
        models: its torques there.
    """
    out = []
    for log, s, model in zip(samples, base.scenes, models, strict=True):
        out += _jumping_torques(robot, log, s, model)
    return out


def _stuck_torques(robot: Robot, samples: Samples, s: Scene, model: FloatArray) -> list[Fault]:
    out = []
    moves = np.abs(s.qd) > 0.1 * np.sqrt(np.mean(s.qd**2, axis=0))  # friction at rest is anything
    moves &= s.free
    for j in moving(s):
        x = samples.tau[:, j]
        top = 0.999 * float(np.abs(x).max())
        dead = (0, len(x) - 1) if np.ptp(x) == 0 else None
        span = dead or frozen(x, model[:, j], moves[:, j], top)
        if span is not None:
            out.append(stuck(f"tau{robot.movable[j].number}", (j,), samples, span))
    return out


def _jumping_torques(robot: Robot, samples: Samples, s: Scene, model: FloatArray) -> list[Fault]:
    """Find steps of a torque that the residual keeps until the next one, and take them out.

    A drive may give a jump, which moves the robot, and friction jumps where a motion starts, ends
    or turns; a sensor's step stays in the residual.
    """
    out = []
    left = s.smooth(s.tau) - model
    rests, _ = at_rest(s.qd, s.step, robot.sigma)
    wide = int(2 / (s.band * s.step)) if s.band else 5
    for j in moving(s):
        x, rest = samples.tau[:, j], left[:, j]
        near: dict[int, float] = {}
        for i in map(int, jumped(x)):
            if (
                s.free[i : i + 2, j].all()  # a repair may end in a step
                and np.all(s.qd[i - 2 : i + 4, j] * s.qd[i, j] > 0)
                and not rests[max(i - wide // 4, 0) : i + wide // 4, j].any()
            ):
                before, after = rest[max(i - wide, 0) : i - wide // 4], rest[i + wide // 4 :][:wide]
                near[i] = _step(before, after, x, i)
        at = [i for i, height in near.items() if height]
        spans = zip([0, *at], at, [*at[1:], len(x)], strict=False)
        jump = {
            i: near[i]
            for first, i, last in spans
            if _step(rest[first : i - wide // 4], rest[i + wide // 4 : last], x, i)
        }
        if jump:
            name, fixed = f"tau{robot.movable[j].number}", partial(_level, samples.name, j, jump)
            out.append(step_fault(name, j, samples, x, np.array([*jump]), fixed))
    return out


def _level(log: str, j: int, steps: Mapping[int, float], s: Scene) -> Scene:
    """Return a scene without the steps (height after each sample) of a torque, where it has them.

    The torque before the first one is taken for the right one.
    """
    if s.name != log:
        return s
    tau = s.tau.copy()
    for i, height in steps.items():
        tau[i + 1 :, j] -= height
    return s.with_torque(tau)


def _step(before: FloatArray, after: FloatArray, x: FloatArray, i: int) -> float:
    """Return the step of a residual after sample i; 0.0 where it has not what jumps there in x."""
    if len(before) < 2 or len(after) < 2:
        return 0.0
    height = float(np.mean(after) - np.mean(before))
    return height if height / float(x[i + 1] - x[i]) > HALF else 0.0


def _reversed(evaluator: Evaluator, base: Evidence, j: int) -> tuple[bool, bool]:
    """Whether a joint's own equations give a negative inertia, and friction that gives energy."""
    q = np.concatenate([s.q[s.kept] for s in base.scenes])
    qd = np.concatenate([s.qd[s.kept] for s in base.scenes])
    rows = base.moves[:, j] > 0
    one, zero = np.zeros_like(q), np.zeros_like(q)
    one[:, j] = 1.0
    kernel = evaluator["torque_regressor"]
    mass = np.asarray(kernel(q, zero, one) - kernel(q, zero, zero))[rows, j]
    W, speed = base.W[rows, j], qd[rows, j]
    mass = np.pad(mass, ((0, 0), (0, W.shape[1] - mass.shape[1])))  # effects of the load have none
    first = evaluator.model.inertial
    loss = np.zeros_like(W)
    loss[:, first:] = W[:, first:] * speed[:, None]
    if not np.any(loss):  # no friction is declared: look for a viscous one
        W = np.column_stack([W, speed])
        loss, mass = (np.column_stack([x, c]) for x, c in ((loss, speed**2), (mass, 0 * speed)))
    used = np.linalg.norm(W, axis=0) > 0
    W, y = W[:, used], base.y[rows, j]
    scale = np.linalg.norm(W, axis=0)
    A = W / scale
    x = least_squares(A, y)
    covariance = covariance_of(A, y - A @ x)
    found = []
    for part in (mass, loss):
        g = part[:, used].mean(axis=0) / scale
        least = -SIGMAS * math.sqrt(max(float(g @ covariance @ g), 0.0))
        found.append(bool(g.any()) and float(g @ x) <= least)
    return found[0], found[1]


def saturations(evaluator: Evaluator, base: Evidence) -> list[Fault]:
    """Find torques that a limit cuts: flat at a largest value where the model asks for more.

    The model is fitted without the rows near the limit, the limit is the one whose clipped model
    is nearest to the torque; both in turn. Only torques count that are as flat there as the
    channel's noise, which is taken from sixth differences.

    Args:
        evaluator: the compiled model.
        base: the model's evidence on the training logs.
    """
    out = []
    for j in moving(base.scenes[0]):
        fault = _saturation(evaluator, base, j)
        if fault is not None:
            out.append(fault)
    return out


def _saturation(evaluator: Evaluator, base: Evidence, j: int) -> Fault | None:
    robot = evaluator.model.robot
    free = [s.free[_span(s), j] for s in base.scenes]
    tau = np.concatenate([s.tau[_span(s), j][f] for s, f in zip(base.scenes, free, strict=True)])
    if len(tau) < _LEAST:
        return None
    noise = _noise(tau) + 1e-6 * float(np.abs(tau).max())
    X, limit, W = base.X, math.inf, base.W
    for _ in range(_ROUNDS):
        whole = [model_torque(evaluator, X, s)[_span(s), j] for s in base.scenes]
        model = np.concatenate([w[f] for w, f in zip(whole, free, strict=True)])
        last, limit = limit, _nearest(tau, model)
        if not _gains(tau, model, limit):
            return None
        if abs(limit - last) < 0.1 * noise:
            break
        scenes = tuple(cut(s, j, limit, noise) for s in base.scenes)
        X = solved(scenes, W, base.y).X
    asked = np.abs(model) > limit + _AT_LIMIT * noise
    over = np.abs(tau[asked]) - limit
    excess = np.abs(model[asked]) - limit
    if len(over) < 10 or float(np.sqrt(np.mean(over**2))) > _FLAT * noise:
        return None
    beyond = np.mean(np.abs(tau) > limit + SIGMAS * noise)
    if beyond > 1e-3 or not _gains(tau, model, limit):
        return None
    s = base.scenes[0]
    # Noise in the band is taken as one value in each half period.
    independent = max(1.0, len(over) * s.step * 2 * (s.band or 0.5 / s.step))
    std = float(np.std(over)) / math.sqrt(independent)
    model_error = float(np.sqrt(np.mean((tau - model)[~asked] ** 2)))
    z = float(np.mean(excess)) / model_error * math.sqrt(independent)
    p = math.erfc(z / math.sqrt(2))
    if p * robot.n > _SIGNIFICANCE:
        return None
    joint = robot.movable[j]
    number, name = joint.number, unit("torque", joint.sigma)
    says = (
        f"tau{number} is cut at {limit:.4g} {name} in {100 * np.mean(asked):.1f} % of the samples: "
        "these are left out of the fit; move more slowly, or raise the limit"
    )
    value = FoundParameter(f"limit{number}", limit, std, name)

    def corrected(s: Scene) -> Scene:
        return cut(s, j, limit, noise)

    return Fault(SATURATION, (j,), f"tau{number}", (value,), says, corrected, p)


def _span(s: Scene) -> slice:
    """Return the samples between the first and the last row: no others were given to the fit."""
    return slice(s.kept.start, s.kept.stop)


def _noise(x: FloatArray) -> float:
    """Return the standard deviation of white noise from sixth differences, kinks left aside."""
    return float(np.median(np.abs(np.diff(x, 6)))) / 0.6745 / math.sqrt(924)


def _nearest(tau: FloatArray, model: FloatArray) -> float:
    """Return the limit whose clipped model is nearest to the torque."""
    size, top = np.abs(model), float(np.abs(tau).max())

    def loss(limit: float) -> float:
        # Where the model is within the limit it makes no difference.
        asked = size > limit
        own = np.sign(model[asked]) * tau[asked]
        return float(np.sum((own - limit) ** 2 - (own - size[asked]) ** 2))

    limits = np.linspace(0.2 * top, top, _PEAKS)
    for _ in range(3):
        at = int(np.argmin([loss(x) for x in limits]))
        low, high = limits[max(at - 1, 0)], limits[min(at + 1, len(limits) - 1)]
        limits = np.linspace(low, high, 20)
    return float(limits[np.argmin([loss(x) for x in limits])])


def _gains(tau: FloatArray, model: FloatArray, limit: float) -> bool:
    """Whether clipping the model brings it nearer to the torque by more than a hundredth."""
    whole = float(np.sum((tau - model) ** 2))
    return whole - float(np.sum((tau - np.clip(model, -limit, limit)) ** 2)) > _CUT * whole


def cut(s: Scene, j: int, limit: float, noise: float) -> Scene:
    """Return a scene that knows the limit of a torque, and leaves out the rows that it touches."""
    limits = np.full(s.tau.shape[1], math.inf) if s.limit is None else s.limit.copy()
    held = np.zeros(s.tau.shape, dtype=bool) if s.held is None else s.held.copy()
    limits[j] = limit
    at = np.abs(s.tau[:, j]) > limit - _AT_LIMIT * noise
    # The low-pass carries a cut to its neighbours, half a period of its cutoff away.
    reach = int(0.5 / (s.band * s.step)) if s.band else 0
    held[:, j] = np.convolve(at, np.ones(2 * reach + 1), mode="same") > 0.5
    return replace(s, limit=limits, held=held)
