"""Columns of effects that are no expression of a joint's variables: states, time, the model.

Each is the one coefficient's column on a joint: what the torque of the motor gains with it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.filtered import FilteredLog

FloatArray = NDArray[np.float64]


class Torques(NamedTuple):
    """The model on a scene.

    Attributes:
        model: its torque (N, n).
        friction: the part of it that is friction.
        links: (links, 10) parameters of the links that give it, one of many sets.
    """

    model: FloatArray
    friction: FloatArray
    links: FloatArray

    @property
    def load(self) -> FloatArray:
        """What the rigid body asks of the joints, (N, n): taur of effects."""
        return self.model - self.friction


#: Column (N,) of the one coefficient of an effect on a joint, by its position and constants.
Shape = Callable[[FilteredLog, Torques, int, Mapping[str, float]], FloatArray]


def gain(_: FilteredLog, torques: Torques, j: int, __: Mapping[str, float]) -> FloatArray:
    """A channel that reads G times too much: tau = (1 + G) model."""
    return torques.model[:, j]


def drift(s: FilteredLog, torques: Torques, j: int, constants: Mapping[str, float]) -> FloatArray:
    """Friction times 1 + DR exp(-t/T)."""
    fading: FloatArray = np.exp(-(s.t - s.t[0]) / constants["T"])
    return torques.friction[:, j] * fading


def pulse(s: FilteredLog, _: Torques, j: int, constants: Mapping[str, float]) -> FloatArray:
    """A pulse after each reversal, in the new direction, while the joint crosses `width`."""
    return -_after_reversals(s, j, constants["width"])


def dahl(s: FilteredLog, _: Torques, j: int, constants: Mapping[str, float]) -> FloatArray:
    """Friction of one N m that turns over a way xs: z = sign + (z0 - sign) exp(-way/xs).

    The way since the last reversal counts, z0 is the state there; the joint comes from afar.
    """
    q, xs = s.q[:, j], constants["xs"]
    sign = np.sign(np.diff(q, prepend=2 * q[0] - q[1]))
    turns = [0, *(np.flatnonzero(sign[1:] != sign[:-1]) + 1), len(q)]
    z, state = np.empty(len(q)), float(sign[0])
    for first, last in itertools.pairwise(turns):
        here = slice(first, last)
        way = np.abs(q[here] - q[max(first - 1, 0)])
        z[here] = sign[first] + (state - sign[first]) * np.exp(-way / xs)
        state = float(z[last - 1])
    return z


def contact(s: FilteredLog, _: Torques, __: int, constants: Mapping[str, float]) -> FloatArray:
    """A constant torque from `start`, s after the log's first sample, for `length` s."""
    t = s.t - s.t[0]
    start, length = constants["start"], constants["length"]
    return np.asarray((t >= start) & (t < start + length), dtype=float)


def _after_reversals(s: FilteredLog, j: int, width: float) -> FloatArray:
    """Return a half sine of unit height over the way since the last reversal, with its sign."""
    speed = s.qd[:, j]
    moves = np.abs(speed) > 1e-3 * np.sqrt(np.mean(speed**2))
    at = np.flatnonzero(moves)
    out = np.zeros(len(s.t))
    if len(at) == 0:
        return out
    sign = np.sign(speed[at])
    turns = at[1:][sign[1:] != sign[:-1]]
    last = np.searchsorted(turns, np.arange(len(s.t)), side="right") - 1
    turned = last >= 0
    way = np.abs(s.q[turned, j] - s.q[turns[last[turned]], j])
    out[turned] = np.sign(speed[turned]) * np.sin(np.pi * np.minimum(way / width, 1.0))
    return out
