"""What an estimate does on logs: residuals of its equations, energies, and what is drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import Samples
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.fit import MEMORY
from symgen.estimation.integrals import cumulative_integral
from symgen.estimation.system import Equations
from symgen.estimation.values import Balance, Residual, Trace
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_AT_ONCE = 8192  # samples whose energies are evaluated together


@dataclass(frozen=True, eq=False)
class Part:
    """One log in the band of the run, for one purpose: "train" or "validation"."""

    kind: str
    log: FilteredLog
    equations: tuple[Equations, ...]
    quantity: str = "energy"

    @property
    def samples(self) -> Samples:
        """The log as it was sampled."""
        return self.log.samples


def residual(parts: Sequence[Part], X: FloatArray) -> Residual:
    """Return ||y - W X|| / ||y|| of some equations, in all and by joint."""
    errors: dict[int | None, float] = {}
    sizes: dict[int | None, float] = {}
    for e in (e for p in parts for e in p.equations):
        errors[e.joint] = errors.get(e.joint, 0.0) + float(np.sum((e.y - e.W @ X) ** 2))
        sizes[e.joint] = sizes.get(e.joint, 0.0) + float(np.sum(e.y**2))
    total = math.sqrt(sum(errors.values()) / max(sum(sizes.values()), 1e-300))
    if None in errors:
        return Residual(total)
    return Residual(
        total,
        tuple(
            math.sqrt(errors[j] / max(sizes[j], 1e-300))
            for j in sorted(j for j in sizes if j is not None)
        ),
    )


def model_traces(part: Part, X: FloatArray) -> tuple[Trace, ...]:
    """Return what the model's own equations measure and predict, for drawing."""
    first = part.equations[0]
    quantity = "energy" if first.joint is None else part.quantity
    if quantity == "torque":  # drawn from `fit`
        return ()
    t = reduce(np.intersect1d, [e.t for e in part.equations])  # a mask is by joint
    kept = [(e, np.isin(e.t, t)) for e in part.equations]
    measured = np.stack([(e.y / e.scale)[k] for e, k in kept], axis=1)
    predicted = np.stack([(e.W @ X / e.scale)[k] for e, k in kept], axis=1)
    log = part.log
    apart = first.correlation + 1  # neighbouring windows share the sample where they meet
    if log.band.filters(log.step) and len(first.t) > 1:
        row = float(np.median(np.diff(first.t)))
        apart += math.ceil(MEMORY / (log.band.cutoff_hz * row))
    return (Trace(log.name, part.kind, quantity, t, measured, predicted, apart),)


def energy_balances(
    evaluator: Evaluator, parts: Sequence[Part], X: FloatArray
) -> tuple[Balance, ...]:
    """Return where the measured work went, log by log.

    Masked logs, whose torque is not to be believed throughout, are left out; and all are where the
    model has effects that hold its own torque.

    Args:
        evaluator: the compiled model, with the kernels of energy.
        parts: the logs.
        X: the parameters, (p,).
    """
    model = evaluator.model
    if model.base.linear < len(model.base.parameters):
        return ()
    out = []
    for part in parts:
        s, every = part.log, slice(None, None, part.log.stride)
        if s.mask is not None:
            continue
        q, qd = (np.ascontiguousarray(x[every]) for x in (s.q, s.qd))
        h, lost = np.empty(len(q)), np.empty((len(q), 1))
        for first in range(0, len(q), _AT_ONCE):
            now = slice(first, first + _AT_ONCE)
            h[now] = evaluator.energy_regressor(q[now], qd[now]) @ X[: model.inertial]
            lost[now, 0] = evaluator.friction_power(q[now], qd[now]) @ X[model.inertial :]
        power = np.einsum("ij,ij->i", s.qd, s.tau)[:, None]
        work = cumulative_integral(power, s.step)[every, 0]
        friction = cumulative_integral(lost, s.step * s.stride)[:, 0]
        out.append(Balance(s.name, part.kind, s.t[every], work, h - h[0], friction))
    return tuple(out)
