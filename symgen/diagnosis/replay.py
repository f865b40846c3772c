"""The motion of a model under the measured torques of a log: the model error seen as motion.

    M(q) qdd + h(q, qd) + A' f = tau_m(t) + M(q) (w^2 (q_m - q) + 2 w (qd_m - qd))

A model alone drifts away under measured torques. A weak and critically damped feedback keeps it
near the measured motion. With e = q - q_m, and the missing torque d of the model,

    M (e'' + 2 w e' + w^2 e) = -d

to first order and without the stiffness of gravity: e is d over the mass, through a low-pass at w.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symgen import names
from symgen.codegen.model import derive
from symgen.data.mask import spans
from symgen.data.signals import interpolated
from symgen.diagnosis.diagnosis import Curves, Diagnosis
from symgen.errors import ParameterError, SymgenError
from symgen.estimation.playback import TOLERANCE
from symgen.estimation.values import FloatArray
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.runtime.integrator import integrate
from symgen.runtime.plant import KERNELS, Plant, plant

#: Bandwidth of the feedback, rad/s.
BANDWIDTH = 2 * np.pi
#: Shortest window, s: a period of the feedback; and longest one.
_SHORTEST = 2 * np.pi / BANDWIDTH
_LONGEST = 3 * _SHORTEST
#: Largest number of torque evaluations, which limits the time for one plot.
_MOST = 20_000
_UNITS = {names.REVOLUTE: "rad", names.PRISMATIC: "m"}


@dataclass(frozen=True, eq=False)
class Replay:
    """Simulated minus measured position under the measured torques, before and after.

    Attributes:
        log: name of the log with the torques.
        t: (K,) s.
        before: (K, n) of the declared model, rad or m.
        after: (K, n) of the extended model, rad or m.
        units: unit of each joint, "rad" or "m".
        left_out: names of found effects that the extended robot, and so the motion, does not
            include.
    """

    log: str
    t: FloatArray
    before: FloatArray
    after: FloatArray
    units: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    @property
    def rms(self) -> tuple[FloatArray, FloatArray]:
        """RMS over the window before and after, (n,) each, rad or m."""
        first, last = (np.sqrt(np.mean(x**2, axis=0)) for x in (self.before, self.after))
        return first, last

    def to_json(self) -> dict[str, Any]:
        """Return log, window and RMS distances per joint, for diagnosis.json."""
        before, after = self.rms
        return {
            "log": self.log,
            "start": float(self.t[0]),
            "end": float(self.t[-1]),
            "unit": list(self.units),
            "before": before.tolist(),
            "after": after.tolist(),
            "left_out": list(self.left_out),
        }


def replayed(diagnosis: Diagnosis) -> Replay:
    """Simulate both models under the measured torques, where the gap before is largest.

    Args:
        diagnosis: the diagnosis, with its curves, the declared robot and its parameters.

    Raises:
        SymgenError: there is nothing to show, or the simulation fails, with the reason.
    """
    if diagnosis.verdict == "bad-measurement":
        raise ParameterError("the measurement is wrong")
    beside = {e.name for e in diagnosis.extended.on_logs}
    moving = [e for e in diagnosis.effects if e.declared and e.name not in beside]
    left_out = tuple(dict.fromkeys(e.name for e in diagnosis.effects if e not in moving))
    if diagnosis.effects and not moving:
        raise ParameterError(f"the extended robot is without {', '.join(left_out)}")
    declared = diagnosis.declared
    if declared is None:
        raise ParameterError("the declared robot is not known")
    seen, window = worst(diagnosis.curves)
    after = _evaluator(diagnosis.extended)
    # Nothing was added: both robots are one, with one derivation.
    before = after if declared == diagnosis.extended else _evaluator(declared)

    def distance(label: str, evaluator: Evaluator, values: Sequence[float]) -> FloatArray:
        try:
            q = driven(evaluator, np.array(values), seen, seen.t[window])
        except SymgenError as error:
            said = str(error).split("; accepted:")[0].removeprefix("simulate: ")
            raise ParameterError(f"the model {label}: {said.removeprefix('run 1, ')}") from error
        return q - seen.q[window]

    return Replay(
        seen.name,
        seen.t[window],
        distance("before", before, diagnosis.values),
        distance("after", after, [p.value for p in diagnosis.parameters]),
        tuple(_UNITS[sigma] for sigma in diagnosis.extended.sigma),
        left_out,
    )


def _evaluator(robot: Robot) -> Evaluator:
    """Return the kernels of a simulation, run by CasADi: compiling takes longer than the run."""
    return load(derive(robot, KERNELS), backend="casadi")


def worst(curves: Sequence[Curves]) -> tuple[Curves, slice]:
    """Return the log and the window of at most 3 s where the torque gap before is largest.

    The gap is the RMS over window and joints of measured minus modelled torque, in units of each
    joint's RMS torque on all logs. No window has a masked torque.

    Raises:
        ParameterError: no log has samples of a second.
    """
    parts = [(c, part) for c in curves for part in _stretches(c)]
    if not parts:
        raise ParameterError(f"no validation log shows {_SHORTEST:g} s of motion")
    size = np.sqrt(np.mean(np.concatenate([c.measured[part] for c, part in parts]) ** 2, axis=0))
    size = np.where(size > 0, size, np.inf)
    found: list[tuple[float, Curves, slice]] = []
    for c, part in parts:
        t = c.t[part]
        step = (t[-1] - t[0]) / (len(t) - 1)
        count = min(len(t), int(_LONGEST / step * (1 + 1e-9)) + 1)
        square = np.mean(((c.measured - c.before)[part] / size) ** 2, axis=1)
        sums = np.concatenate([[0.0], np.cumsum(square)])
        mean = (sums[count:] - sums[:-count]) / count
        k = int(np.argmax(mean))
        found.append((float(mean[k]), c, slice(part.start + k, part.start + k + count)))
    return max(found, key=lambda item: item[0])[1:]


def _stretches(c: Curves) -> list[slice]:
    """Return the time spans of a second or more without masked torque."""
    free = np.ones((len(c.t), 1), dtype=bool) if c.free is None else c.free
    return [slice(a, b) for a, b in spans(np.all(free, axis=1)) if c.t[b - 1] - c.t[a] >= _SHORTEST]


def driven(evaluator: Evaluator, X: FloatArray, seen: Curves, t: FloatArray) -> FloatArray:
    """Return the motion of a model under the measured torque and the weak feedback.

    It starts in the measured state. Cubic splines interpolate between the samples of the log.

    Args:
        evaluator: the model with the kernels of `symgen.runtime.plant`.
        X: base parameters (p,).
        seen: the measured motion and torque.
        t: (K,) times within those of `seen`, s.

    Returns:
        q (K, n), rad or m.

    Raises:
        SymgenError: X does not fit the model or is no physical robot, or the motion is not finite,
            or too stiff to be integrated in time.
    """
    if len(X) != len(evaluator.model.base.names) or not np.isfinite(X).all():
        raise ParameterError("its parameters are not all known")
    n, w, moved = seen.q.shape[1], BANDWIDTH, plant(evaluator, X)
    measured = interpolated(seen.t, np.concatenate([seen.measured, seen.q, seen.qd], axis=1))
    done = 0

    def law(at: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:
        nonlocal done
        done += 1
        if done > _MOST:  # not a ParameterError, for which the integrator only takes a shorter step
            raise SymgenError("it is too stiff to be moved in a few seconds")
        here = measured(at)
        pull = w**2 * (here[:, n : 2 * n] - q) + 2 * w * (here[:, 2 * n :] - qd)
        return np.asarray(here[:, :n] + (moved.mass(q) @ pull[:, :, None])[:, :, 0])

    start = measured(t[:1])
    _require_mass(moved, t, measured(t)[:, n : 2 * n])
    motion = integrate(
        moved, law, t, start[:, n : 2 * n], start[:, 2 * n :], smooth=True, tolerance=TOLERANCE
    )
    return np.asarray(motion.q[0])


def _require_mass(moved: Plant, t: FloatArray, q: FloatArray) -> None:
    """Require that M is positive definite along a motion (N, n); CasADi's kernels do not check it.

    From such a state no motion leads to a state where M is not positive definite, because qdd grows
    without bound on the way.

    Raises:
        ParameterError: M is not positive definite.
    """
    least = np.linalg.eigvalsh(moved.mass(q))[:, 0]
    if least.min() <= 0:
        at = t[int(np.argmax(least <= 0))]
        raise ParameterError(f"t = {at:.6g} s: the mass matrix is not positive definite")
