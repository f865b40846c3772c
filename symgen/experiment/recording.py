"""How the logs of a simulated robot come about: what drives it, and what is seen of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.experiment.plant import Repeated
from symgen.runtime.evaluator import Evaluator

if TYPE_CHECKING:
    from symgen.experiment.reference import Reference

_POSITION, _VELOCITY, _TORQUE, _DISTURBANCE = range(4)


@dataclass(frozen=True)
class Instruments:
    """The measuring chain, alike on all joints; errors are independent of joint, sample and run.

    A log shows, of what truly happens at t,

        q(t)   = round((q(t - delay) + position_noise e) / encoder_step) encoder_step
        qd(t)  = velocity_gain qd(t - delay) + velocity_noise e
        tau(t) = command(t) + (torque_noise + torque_noise_relative RMS(command)) e

    with e normal of unit variance. An encoder_step of 0 does not round.

    Attributes:
        encoder_step: resolution of the encoders, rad or m.
        position_noise: standard deviation, rad or m.
        velocity_noise: standard deviation, rad/s or m/s.
        velocity_gain: of the tachometers.
        velocity: whether the log has qd at all.
        torque_noise: standard deviation, N m or N.
        torque_noise_relative: standard deviation over the RMS of that joint's command.
        delay: of q and qd behind the torque, s; before the first state the joint is taken to rest.

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

    def motion_noise(
        self, runs: range, seed: int, shape: tuple[int, int]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the errors of q and qd in some runs, (runs, N, n); (1, 1, 1) without any."""
        return (
            _normal(self.position_noise, runs, seed, _POSITION, shape),
            _normal(self.velocity_noise, runs, seed, _VELOCITY, shape),
        )

    def read(
        self, q: FloatArray, qd: FloatArray, q_error: FloatArray, qd_error: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return what encoders and tachometers show of q and qd, arrays of one shape."""
        q, qd = q + q_error, self.velocity_gain * qd + qd_error
        if self.encoder_step:
            q = self.encoder_step * np.floor(q / self.encoder_step + 0.5)
        return q, qd

    def torque(self, command: FloatArray, runs: range, seed: int) -> FloatArray:
        """Return the torques that the logs of some runs show, (runs, N, n).

        Args:
            command: the commanded ones, (runs, N, n), or (1, N, n) where they are alike.
            runs: numbers of the runs.
            seed: of all noise.
        """
        if not (self.torque_noise or self.torque_noise_relative):
            return command
        size = np.sqrt(np.mean(command**2, axis=1, keepdims=True))
        e = _normal(1.0, runs, seed, _TORQUE, (command.shape[1], command.shape[2]))
        return np.asarray(command + (self.torque_noise + self.torque_noise_relative * size) * e)

    def delayed(
        self, t: FloatArray, q: FloatArray, qd: FloatArray, at: slice
    ) -> tuple[FloatArray, FloatArray]:
        """Return q and qd (runs, K, n) of `delay` before the stamps t[at]: cubics in between.

        Args:
            t: (N,) stamps, s.
            q: (runs, N, n), known up to the last of the stamps asked for.
            qd: (runs, N, n).
            at: which stamps.
        """
        if not self.delay:
            return q[:, at], qd[:, at]
        from scipy.interpolate import CubicHermiteSpline  # not where a study is only read

        then, last = t[at] - self.delay, range(*at.indices(len(t)))[-1]
        first = max(int(np.searchsorted(t, then[0], side="right")) - 1, 0)
        known = slice(first, max(last, first + 1) + 1)
        course = CubicHermiteSpline(t[known], q[:, known], qd[:, known], axis=1)
        moved = np.maximum(then, t[0])
        return course(moved), np.where((then < t[0])[:, None], 0.0, course(moved, 1))


def unseen_torque(size: FloatArray, runs: range, seed: int, samples: int) -> FloatArray:
    """Return torques (runs, N, n) that act on the joints unseen, of standard deviations (n,)."""
    e = _normal(1.0, runs, seed, _DISTURBANCE, (samples, len(size)))
    return size * e


def _normal(
    size: float, runs: range, seed: int, channel: int, shape: tuple[int, int]
) -> FloatArray:
    """Draw from a stream of its own for each run and instrument: run 3 is run 3 of however many."""
    if not size:
        return np.zeros((1, 1, 1))
    out = np.empty((len(runs), *shape))
    for k, run in enumerate(runs):
        out[k] = size * np.random.default_rng([seed, run, channel]).standard_normal(shape)
    return out


KINDS = ("computed-torque", "pd")
FEEDBACKS = ("true", "measured")


@dataclass(frozen=True)
class Controller:
    """A tracking controller.

    With e = q_r - q and the controller's model of the robot, scale times its parameters,

        computed-torque:  tau = ID(q, qd, qdd_r + 2 damping bandwidth e' + bandwidth^2 e)
        pd:               tau = ID(q_r, qd_r, qdd_r) + D (2 damping bandwidth e' + bandwidth^2 e)

    where D is the diagonal of M at the beginning of the reference. The model has rigid body,
    rotors, viscous friction and offsets; Coulomb friction and effects are left to the feedback, so
    that the torque has no steps.

    Attributes:
        kind: "computed-torque" or "pd".
        bandwidth: of the position loop, rad/s.
        damping: ratio.
        scale: of the controller's parameters over the robot's (the paper's figure 2: 1.2).
        feedback: "true": acts in continuous time on what truly happens. "measured": acts at every
            stamp on what the instruments show and holds its torque until the next, as a digital
            controller does.

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
    """How the logs of a simulated robot come about.

    Attributes:
        instruments: what the logs show.
        controller: that moves the robot along its reference; not used where torques are played.
        disturbance: standard deviation of torques that act on the joints and that no log shows, new
            at every stamp; one number, or one for each joint, N m or N.
        rate: stamps of the logs per second; None for those of the trajectory or of the torques,
            and 1000 for the Fourier series and the paper's motion.
        clip: whether torques are kept within [limits], instead of being refused beyond them.

    Raises:
        ParameterError: a number has no meaning.
    """

    instruments: Instruments = field(default_factory=Instruments)
    controller: Controller = field(default_factory=Controller)
    disturbance: float | tuple[float, ...] = 0.0
    rate: float | None = None
    clip: bool = False

    def __post_init__(self) -> None:
        if self.rate is not None and not 0 < self.rate < math.inf:
            raise ParameterError(f"simulate: rate is {self.rate:g}; accepted: above 0 Hz")

    def unseen(self, n: int) -> FloatArray:
        """Return the disturbance of each of n joints, (n,).

        Raises:
            ParameterError: another number of joints, or no standard deviations.
        """
        out = np.asarray(self.disturbance, dtype=np.float64)
        if out.shape not in ((), (n,)) or not np.isfinite(out).all() or out.min() < 0:
            raise ParameterError(
                f"simulate: disturbance {self.disturbance}; accepted: one or {n} numbers from 0 on"
            )
        return np.broadcast_to(out, (n,))

    @property
    def moves_alike(self) -> bool:
        """Whether runs differ in what is measured alone."""
        return not np.any(self.disturbance) and self.controller.feedback == "true"


#: Torques (runs, n) as a function of times (runs,) and states q, qd (runs, n).
Law = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def tracking(
    controller: Controller, reference: Reference, evaluator: Evaluator, X: FloatArray
) -> Law:
    """Return the law of a controller.

    Args:
        controller: which one.
        reference: what it follows.
        evaluator: with inverse_dynamics and mass_matrix.
        X: (p,) parameters of the robot that the controller knows of.
    """
    known = controller.scale * X
    torque = Repeated(evaluator, "inverse_dynamics", known)
    w = controller.bandwidth
    stiff, damp = w * w, 2 * controller.damping * w
    size = np.abs(np.diagonal(evaluator["mass_matrix"](reference.q[0], known)))

    def law(t: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:
        # Runs at one time share the reference.
        aim = reference.at(t[:1] if (t == t[0]).all() else t)
        back = damp * (aim[:, 1] - qd) + stiff * (aim[:, 0] - q)
        if controller.kind == "pd":
            return np.asarray(torque(aim[:, 0], aim[:, 1], aim[:, 2]) + size * back)
        return torque(q, qd, aim[:, 2] + back)

    return law


def replay(t: FloatArray, tau: FloatArray, hold: bool) -> Law:
    """Return the law that plays torques (N, n) at stamps (N,), in straight lines or held."""

    columns = np.ascontiguousarray(tau.T)

    def law(at: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:  # noqa: ARG001
        if hold:
            return tau[np.maximum(np.searchsorted(t, at, side="right") - 1, 0)]
        return np.stack([np.interp(at, t, column) for column in columns], axis=-1)

    return law
