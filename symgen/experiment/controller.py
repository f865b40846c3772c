"""What drives a simulated robot: a tracking controller, or given torques."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError
from symgen.experiment.plant import Repeated
from symgen.experiment.reference import Reference
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
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
            if not (math.isfinite(value) and value > 0):
                raise ParameterError(f"controller: {key} is {value:g}; accepted: above 0")


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

    def computed(t: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:
        aim = _aim(reference, t)
        v = aim[:, 2] + damp * (aim[:, 1] - qd) + stiff * (aim[:, 0] - q)
        return np.asarray(torque(q, qd, v))

    def pd(t: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:
        aim = _aim(reference, t)
        ahead = torque(aim[:, 0], aim[:, 1], aim[:, 2])
        return np.asarray(ahead + size * (damp * (aim[:, 1] - qd) + stiff * (aim[:, 0] - q)))

    return computed if controller.kind == "computed-torque" else pd


def _aim(reference: Reference, t: FloatArray) -> FloatArray:
    """Return the reference (runs or 1, 3, n); runs at one time share it."""
    return reference.at(t[:1] if (t == t[0]).all() else t)


def replay(t: FloatArray, tau: FloatArray, hold: bool) -> Law:
    """Return the law that plays torques (N, n) at stamps (N,), in straight lines or held."""

    def law(at: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:  # noqa: ARG001
        k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
        if hold:
            return np.asarray(tau[np.where(at >= t[-1], len(t) - 1, k)])
        s = np.clip((at - t[k]) / (t[k + 1] - t[k]), 0.0, 1.0)[:, None]
        return np.asarray((1 - s) * tau[k] + s * tau[k + 1])

    return law
