"""Simulation of a robot: forward dynamics, integrated by LSODA.

    M(q) qdd + h(q, qd) = tau(t, q, qd),    with FS tanh(qd/width) for FS sign(qd)

LSODA switches between Adams' methods and backward differences as the equations become stiff
(Petzold 1983). They are stiff at rest, where the width makes friction a damper of FS/width. A joint
that friction holds therefore creeps by about the width times the time: 0.01 mrad in a second.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.parallel import silent
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

#: Torques (n,) as a function of time and state q, qd (n,).
Law = Callable[[float, FloatArray, FloatArray], FloatArray]
#: Speed over which friction changes its sign, rad/s or m/s, for joints without coulomb_width in the
#: robot file. A UR10e that is held by 80 % of its friction creeps 0.1 mrad in 10 s, and 12 mrad
#: with 1e-3.
WIDTH = 1e-5
#: Largest error of a step, absolute (rad, m, rad/s, m/s) and relative.
TOLERANCE = 1e-6
#: Longest step, s: a longer one could miss a pulse of the torque.
_STEP = 0.05
_STEPS = 10**6  # most, from stamp to stamp
_SOMETIMES = 8  # evaluations from one check of the bounds to the next
_FAR = 1e8
_KERNEL = "forward_dynamics"


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A simulated motion.

    Attributes:
        t: (N,) stamps, s.
        q: (N, n) positions, rad or m; NaN after the motion has left its bounds.
        qd: (N, n) speeds, rad/s or m/s.
        tau: (N, n) torques of the law, N m or N.
    """

    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray


def simulate_motion(
    model: Model,
    X: FloatArray,
    law: Law,
    t: FloatArray,
    start: tuple[FloatArray, FloatArray],
    *,
    width: float = WIDTH,
    hold: bool = False,
    pushed: FloatArray | None = None,
    bounds: FloatArray | None = None,
    tolerance: float = TOLERANCE,
    calls: float = math.inf,
    progress: Callable[[float], None] = silent,
) -> SimulatedMotion:
    """Simulate a robot under a torque law, and return its state at the stamps.

    Args:
        model: the robot with its base parameters.
        X: (p,) values of the base parameters.
        law: the torque as a function of time and state.
        t: (N,) stamps, s, increasing.
        start: q and qd at the first stamp, (n,) each.
        width: width of friction for joints without a declared one, rad/s or m/s.
        hold: whether the torque at a stamp stays constant until the next one.
        pushed: additional torques (N, n), constant from stamp to stamp.
        bounds: (n,) distance from the start at which the motion ends, rad or m; None for no bound.
        tolerance: largest error of a step, absolute and relative.
        calls: largest number of evaluations of the forward dynamics.
        progress: called with the finished part, from 0 to 1.

    Returns:
        The motion. Torques that change at the stamps are integrated stamp by stamp. At 500 Hz, this
        takes about three times the duration of the motion.

    Raises:
        ParameterError: friction is negative, the mass matrix is not positive definite, or the
            motion is not finite, or `calls` do not suffice. The message has the time.
    """
    require_friction(model, X)
    slope = _Slope(_evaluator(model.robot, width), X, law, calls, bounds)
    x = np.concatenate(start)
    n = len(x) // 2
    states = np.full((len(t), 2 * n), np.nan)
    torques = np.full((len(t), n), np.nan)
    states[0] = x
    if not hold and pushed is None:
        reached = _integrated(slope, t, x, tolerance)
        states[: len(reached)] = reached
        progress(1.0)
    else:
        for k in range(len(t) - 1):
            q, qd = states[k, :n], states[k, n:]
            torques[k] = law(float(t[k]), q, qd)
            push = 0.0 if pushed is None else pushed[k]
            slope.law = _constant(torques[k] + push) if hold else _sum(law, push)
            states[k + 1] = _integrated(slope, t[k : k + 2], states[k], tolerance)[-1]
            progress((k + 1) / (len(t) - 1))
    missing = np.isnan(torques[:, 0]) & np.isfinite(states[:, 0])
    for row in np.flatnonzero(missing).tolist():
        torques[row] = law(float(t[row]), states[row, :n], states[row, n:])
    return SimulatedMotion(t, states[:, :n], states[:, n:], torques)


def _constant(torque: FloatArray) -> Law:
    return lambda t, q, qd: torque  # noqa: ARG005


def _sum(law: Law, push: FloatArray | float) -> Law:
    return lambda t, q, qd: law(t, q, qd) + push


class _OutsideError(Exception):
    """The motion leaves its bounds; the argument is the time in s."""


class _Slope:
    """The rate of the state x = (q, qd) of a robot, as SciPy calls it."""

    def __init__(
        self,
        evaluator: Evaluator,
        X: FloatArray,
        law: Law,
        calls: float,
        bounds: FloatArray | None,
    ) -> None:
        self.law = law
        self.start = np.zeros(0)  # positions from which the bounds count
        self._bounds = bounds
        self._done, self._calls = 0, calls
        self._bound = evaluator[_KERNEL].bind()
        self._q, self._qd, self._tau, parameters = self._bound.inputs
        parameters[...] = X[: len(parameters)]
        self._rate = np.empty(2 * len(self._q))  # SciPy copies it

    def __call__(self, t: float, x: FloatArray) -> FloatArray:
        """Return dx/dt.

        Raises:
            ParameterError: the mass matrix is not positive definite, the state is too large, or no
                calls are left.
        """
        if self._done >= self._calls:
            raise ParameterError(
                f"simulate: t = {t:.6g} s: {self._calls:g} evaluations do not suffice; accepted: "
                "a less stiff controller, or parameters of which no mass is much too small"
            )
        self._done += 1
        n = len(self._q)
        q, qd = x[:n], x[n:]
        checked = self._bounds is not None and self._done % _SOMETIMES == 0
        if checked and (np.abs(q - self.start) > self._bounds).any():
            raise _OutsideError(t)
        self._q[...] = q
        self._qd[...] = qd
        self._tau[...] = self.law(t, q, qd)
        if self._bound.call() or x @ x > _FAR**2:
            raise ParameterError(
                f"simulate: t = {t:.6g} s: the mass matrix is not positive definite, or the motion "
                "is not finite; accepted: parameters of a robot that can exist, and torques under "
                "which it stays"
            )
        self._rate[:n] = qd
        self._rate[n:] = self._bound.out
        return self._rate


def _integrated(slope: _Slope, t: FloatArray, x: FloatArray, tolerance: float) -> FloatArray:
    """Return the states (K, 2 n) at the stamps; fewer if the motion leaves its bounds."""
    from scipy.integrate import ODEintWarning, odeint

    slope.start = x[: len(x) // 2]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ODEintWarning)  # the message says it
            states, found = odeint(
                slope,
                x,
                t,
                tfirst=True,
                full_output=True,
                rtol=tolerance,
                atol=tolerance,
                hmax=_STEP,
                tcrit=t[-1:],
                mxstep=_STEPS,
            )
    except _OutsideError as outside:
        inside = t[t < outside.args[0]]
        return _integrated(slope, inside, x, tolerance) if len(inside) > 1 else x[None]
    if found["message"] != "Integration successful.":
        raise ParameterError(
            f"simulate: t = {found['tcur'][-1]:.6g} s: {found['message']}; accepted: a less stiff "
            "controller, or a larger coulomb_width"
        )
    return np.asarray(states)


@lru_cache(maxsize=8)
def _evaluator(robot: Robot, width: float) -> Evaluator:
    """Return the forward dynamics of a robot, with a width for the friction of every joint."""
    joints = []
    for joint in robot.joints:
        if joint.movable and not joint.coulomb_width:
            joint = replace(joint, coulomb_width=width)
        joints.append(joint)
    return load(derive(replace(robot, joints=tuple(joints)), (_KERNEL,)))


def require_friction(model: Model, X: FloatArray) -> None:
    """Refuse negative Coulomb friction, which would accelerate a joint.

    Raises:
        ParameterError: the message contains the parameter.
    """
    for parameter, value in zip(model.base.parameters, X, strict=False):
        if model.base.standard[parameter.index].prefix in ("FS", "FSM") and value < 0:
            raise ParameterError(
                f"{parameter.name} = {value:.4g}: negative Coulomb friction drives its joint; "
                "accepted: 0 or more"
            )


def without_dry(model: Model, X: FloatArray) -> FloatArray:
    """Return X (p,) with rigid body, rotors, viscous friction and offsets only."""
    out = np.array(X, dtype=np.float64)
    for i, p in enumerate(model.base.parameters):
        if not p.inertial and model.base.standard[p.index].prefix not in ("FV", "FVM", "OF"):
            out[i] = 0.0
    return out
