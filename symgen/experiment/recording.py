"""Controllers and instruments of a simulated robot, which determine its logs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.simulate import Law

if TYPE_CHECKING:
    from symgen.experiment.reference import Reference

_POSITION, _VELOCITY, _TORQUE, _DISTURBANCE = range(4)


@dataclass(frozen=True)
class Instruments:
    """The sensors, the same on all joints; errors are independent between joints, samples and runs.

    The log at time t has

        q(t)   = round((q(t - delay) + position_noise e) / encoder_step) encoder_step
        qd(t)  = velocity_gain qd(t - delay) + velocity_noise e
        tau(t) = command(t) + (torque_noise + torque_noise_relative RMS(command)) e

    with e normal of unit variance. An encoder_step of 0 does not round.

    Attributes:
        encoder_step: resolution of the encoders, rad or m.
        position_noise: standard deviation, rad or m.
        velocity_noise: standard deviation, rad/s or m/s.
        velocity_gain: gain of the tachometers.
        velocity: whether the log has qd.
        torque_noise: standard deviation, N m or N.
        torque_noise_relative: standard deviation over the RMS of that joint's command.
        delay: delay of q and qd relative to the torque, s; the robot is at rest before the first
            state.

    Raises:
        ParameterError: a value is negative or not finite.
    """

    encoder_step: float = 0.0
    position_noise: float = 0.0
    velocity_noise: float = 0.0
    velocity_gain: float = 1.0
    velocity: bool = True
    torque_noise: float = 0.0
    torque_noise_relative: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 <= value < math.inf:
                raise ParameterError(f"instruments: {name} is {value:g}; accepted: 0 or more")

    def errors(self, run: int, seed: int, shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return the errors of q and qd in a run, (N, n) each; (1, 1) without errors."""
        return (
            _normal(self.position_noise, run, seed, _POSITION, shape),
            _normal(self.velocity_noise, run, seed, _VELOCITY, shape),
        )

    def read(
        self, q: FloatArray, qd: FloatArray, q_error: FloatArray, qd_error: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the readings of encoders and tachometers for q and qd, arrays of one shape."""
        q, qd = q + q_error, self.velocity_gain * qd + qd_error
        if self.encoder_step:
            q = self.encoder_step * np.floor(q / self.encoder_step + 0.5)
        return q, qd

    def recorded(
        self, t: FloatArray, q: FloatArray, qd: FloatArray, tau: FloatArray, run: int, seed: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return q, qd and tau (N, n) in the log of a run, from true motion and command (N, n)."""
        motion = self.delayed(t, q, qd, slice(0, len(t)))
        q, qd = self.read(*motion, *self.errors(run, seed, q.shape))
        size = self.torque_noise + self.torque_noise_relative * np.sqrt(np.mean(tau**2, axis=0))
        return q, qd, tau + size * _normal(float(np.any(size)), run, seed, _TORQUE, tau.shape)

    def delayed(
        self, t: FloatArray, q: FloatArray, qd: FloatArray, at: slice
    ) -> tuple[FloatArray, FloatArray]:
        """Return q and qd (K, n) at t[at] - delay, by cubic interpolation.

        Args:
            t: (N,) stamps, s.
            q: (N, n), known up to the last requested stamp.
            qd: (N, n).
            at: the requested stamps.
        """
        if not self.delay:
            return q[at], qd[at]
        # imported late: reading a study does not need it
        from scipy.interpolate import CubicHermiteSpline

        then = t[at] - self.delay
        first = max(int(np.searchsorted(t, then[0], side="right")) - 1, 0)
        known = slice(first, max(at.stop, first + 2))
        course = CubicHermiteSpline(t[known], q[known], qd[known])
        moved = np.maximum(then, t[0])
        return course(moved), np.where((then < t[0])[:, None], 0.0, course(moved, 1))


def disturbance_torque(size: FloatArray, run: int, seed: int, samples: int) -> FloatArray:
    """Return torques (N, n) of unmeasured disturbances with standard deviations (n,)."""
    return size * _normal(1.0, run, seed, _DISTURBANCE, (samples, len(size)))


def _normal(size: float, run: int, seed: int, channel: int, shape: tuple[int, ...]) -> FloatArray:
    """Draw from a separate stream for each run and instrument, so that runs are independent."""
    if not size:
        return np.zeros((1, 1))
    return size * np.random.default_rng([seed, run, channel]).standard_normal(shape)


KINDS = ("computed-torque", "pd")
FEEDBACKS = ("true", "measured")


@dataclass(frozen=True)
class Controller:
    """A tracking controller.

    It uses e = q_r - q and a model of the robot with `scale` times its parameters:

        computed-torque:  tau = ID(q, qd, qdd_r + 2 damping bandwidth e' + bandwidth^2 e)
        pd:               tau = ID(q_r, qd_r, qdd_r) + D (2 damping bandwidth e' + bandwidth^2 e)

    where D is the diagonal of M at the beginning of the reference. The model contains rigid body,
    rotors, viscous friction and offsets. It lacks Coulomb friction and effects, so the torque has
    no steps.

    Attributes:
        kind: "computed-torque" or "pd".
        bandwidth: bandwidth of the position loop, rad/s.
        damping: damping ratio.
        scale: ratio of the controller's parameters to the robot's (figure 2 of the paper: 1.2).
        feedback: "true" acts in continuous time on the true motion. "measured" acts at every stamp
            on the measured motion and keeps its torque until the next one, as a digital controller
            does.

    Raises:
        ParameterError: a value is not accepted.
    """

    kind: str = "computed-torque"
    bandwidth: float = 40.0
    damping: float = 1.0
    scale: float = 1.0
    feedback: str = "true"

    def __post_init__(self) -> None:
        for key, accepted in (("kind", KINDS), ("feedback", FEEDBACKS)):
            if getattr(self, key) not in accepted:
                raise ParameterError(
                    f"controller: {key} {getattr(self, key)!r}; accepted: {', '.join(accepted)}"
                )
        for key in ("bandwidth", "damping", "scale"):
            value = getattr(self, key)
            if not 0 < value < math.inf:
                raise ParameterError(f"controller: {key} is {value:g}; accepted: above 0")


@dataclass(frozen=True)
class Recording:
    """Sensors, controller and disturbance of a simulated robot.

    Attributes:
        instruments: the sensors.
        controller: moves the robot along its reference; not used if torques are given.
        disturbance: standard deviation of unmeasured torques on the joints, new at every stamp; one
            number, or one for each joint, N m or N.
        rate: sampling rate of the logs, Hz. None means that of the trajectory or of the torques,
            and 1000 Hz for the Fourier series.

    Raises:
        ParameterError: a number is not valid.
    """

    instruments: Instruments = field(default_factory=Instruments)
    controller: Controller = field(default_factory=Controller)
    disturbance: float | tuple[float, ...] = 0.0
    rate: float | None = None

    def __post_init__(self) -> None:
        if self.rate is not None and not 0 < self.rate < math.inf:
            raise ParameterError(f"simulate: rate is {self.rate:g}; accepted: above 0 Hz")

    def disturbance_std(self, n: int) -> FloatArray:
        """Return the disturbance of each of n joints, (n,).

        Raises:
            ParameterError: the number of joints is wrong, or a standard deviation is not valid.
        """
        out = np.asarray(self.disturbance, dtype=np.float64)
        if out.shape not in ((), (n,)) or not np.isfinite(out).all() or out.min() < 0:
            raise ParameterError(
                f"simulate: disturbance {self.disturbance}; accepted: one or {n} numbers from 0 on"
            )
        return np.broadcast_to(out, (n,))

    @property
    def moves_alike(self) -> bool:
        """Whether all runs have the same true motion and differ only in measurement noise."""
        return not np.any(self.disturbance) and self.controller.feedback == "true"


def tracking(
    controller: Controller, reference: Reference, evaluator: Evaluator, X: FloatArray
) -> Law:
    """Return the law of a controller.

    Args:
        controller: kind and gains.
        reference: the motion to follow.
        evaluator: model with inverse_dynamics and mass_matrix.
        X: parameters (p,) of the robot, before `scale`.
    """
    known = controller.scale * X
    torque = evaluator["inverse_dynamics"].bind()
    own_q, own_qd, own_qdd, parameters = torque.inputs
    parameters[...] = known[: len(parameters)]
    w = controller.bandwidth
    stiff, damp = w * w, 2 * controller.damping * w
    size = np.abs(np.diagonal(evaluator["mass_matrix"](reference.q[0], known)))

    def law(t: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        aim_q, aim_qd, aim_qdd = reference.at(np.array([t]))[0]
        back = damp * (aim_qd - qd) + stiff * (aim_q - q)
        if controller.kind == "pd":
            own_q[...], own_qd[...], own_qdd[...] = aim_q, aim_qd, aim_qdd
            torque()
            return np.asarray(torque.out + size * back)
        own_q[...], own_qd[...], own_qdd[...] = q, qd, aim_qdd + back
        torque()
        return torque.out.copy()

    return law


def replay(t: FloatArray, tau: FloatArray, hold: bool) -> Law:
    """Return the law that applies torques (N, n) at stamps (N,), interpolated or held."""
    last = len(t) - 1

    def law(at: float, q: FloatArray, qd: FloatArray) -> FloatArray:  # noqa: ARG001
        k = min(max(int(np.searchsorted(t, at, side="right")) - 1, 0), last)
        if hold or k == last:
            return np.asarray(tau[k])
        share = (at - t[k]) / (t[k + 1] - t[k])
        return np.asarray(tau[k] + share * (tau[k + 1] - tau[k]))

    return law
