"""Random functions of the motion's state, which stand for what a model may miss.

What no effect of a model explains is a function of positions and speeds that nobody knows, the same
one whenever the robot comes by. It is taken as random: a sum of waves with random directions and
lengths in the state, their coefficients independent and of one size (random Fourier features,
Rahimi and Recht 2007).

    m(q, qd) = sum over waves k of a_k cos(d_k'x) + b_k sin(d_k'x),    x = (state - middle) / spread

Equations of torque see it through the comparison band, those of windows its integral.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from symgen.data.mask import moving_joints
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.integrals import window_integrals
from symgen.estimation.system import Equations, Model
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import Windows, chunks

#: Waves, with a cosine and a sine each; and their seed.
WAVES, SEED = 32, 1988
#: Radians of a wave over one spread of the motion: from nearly a straight line to a whole wave.
_SLOW, _FAST = 0.5, 2 * np.pi


@dataclass(frozen=True)
class Features:
    """Random functions of the state of a motion.

    Attributes:
        middle: mean of q and of qd over the motion, (2 n).
        scale: 1 over their standard deviations, (2 n); 0 for joints that hardly move.
        size: RMS of the torque of each joint, (n): the energy model has one equation for all.
    """

    middle: tuple[float, ...]
    scale: tuple[float, ...]
    size: tuple[float, ...]

    def __call__(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return the functions at states (K, n), (K, 2 WAVES), whose squares sum to 1."""
        directions, _ = _drawn(len(self.size))
        angle = (np.hstack([q, qd]) - self.middle) * self.scale @ directions
        return np.asarray(np.hstack([np.cos(angle), np.sin(angle)]) / np.sqrt(WAVES))

    def powers(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return the power of the functions, each a torque in a direction of its own."""
        _, torques = _drawn(len(self.size))
        return self(q, qd) * (qd * self.size @ torques)

    def over_windows(
        self, model: str, q: FloatArray, qd: FloatArray, w: Windows, step: float
    ) -> FloatArray:
        """Return the integrals over the windows of a log, (K, 2 WAVES).

        Args:
            model: energy or momentum.
            q, qd: (nodes, n) of the log.
            w: its windows.
            step: of the log, s.
        """
        values = self.powers if model == "energy" else self
        return np.concatenate([
            w.stride * step * window_integrals(w.steps, ends, span, values(q[span], qd[span]))
            for ends, span in chunks(len(q), w.steps, w.hop)
        ])  # fmt: skip

    def in_band(
        self, modelled: Callable[[Model], Iterator[tuple[slice, FloatArray]]], n: int = 1
    ) -> FloatArray:
        """Return the functions in the comparison band, (K, n, 2 WAVES).

        Args:
            modelled: evaluates a model along a log, as `FilteredLog.modelled` does.
            n: how often: once for each joint where a mask weighs what is filtered.
        """

        def values(q: FloatArray, qd: FloatArray, _: FloatArray) -> FloatArray:
            return np.repeat(self(q, qd)[:, None], n, axis=1)

        return np.concatenate([x for _, x in modelled(values)])


@cache
def _drawn(n: int) -> tuple[FloatArray, FloatArray]:
    """Return the waves of n joints, (2 n, WAVES), and directions of torque, (n, 2 WAVES)."""
    rng = np.random.default_rng(SEED)
    directions = rng.normal(size=(2 * n, WAVES))
    lengths = np.exp(rng.uniform(np.log(_SLOW), np.log(_FAST), WAVES))
    directions *= lengths / np.linalg.norm(directions, axis=0)
    torques = rng.normal(size=(n, 2 * WAVES))
    return directions, torques


def features_of(logs: Sequence[FilteredLog], sigma: Sequence[int]) -> Features:
    """Return random functions of the state of some logs, on the scale of their motion.

    Args:
        logs: in the band of the run.
        sigma: (n,) types of the joints. Those that hardly move have no say.
    """
    states = np.concatenate([np.hstack([log.q, log.qd]) for log in logs])
    moving = np.isin(np.arange(len(sigma)), moving_joints([log.qd for log in logs], sigma))
    spread = np.where(np.tile(moving, 2), states.std(axis=0), np.inf)
    scale = 1 / np.where(spread > 0, spread, np.inf)
    size = np.sqrt(np.mean(np.concatenate([np.square(log.tau) for log in logs]), axis=0))
    return Features(*(tuple(map(float, x)) for x in (states.mean(axis=0), scale, size)))


def with_features(
    equations: Sequence[Equations], rows: FloatArray, t: FloatArray
) -> tuple[Equations, ...]:
    """Return the equations of a log with the rows of random functions.

    Args:
        equations: joint by joint, those of masked rows left out.
        rows: (K, joints or 1, m) of all rows.
        t: (K,) their times.
    """
    out = []
    for j, e in enumerate(equations):
        own = rows[:, min(j, rows.shape[1] - 1)]
        if len(e.t) < len(t):
            own = own[np.searchsorted(t, e.t)]
        out.append(replace(e, features=own if e.rest is None else own * e.scale[:, None]))
    return tuple(out)
