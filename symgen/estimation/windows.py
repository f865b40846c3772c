"""Sliding windows of a log: their ends in nodes, and integrals over them.

Integrals of many columns are the product of the columns with a small matrix, chunk by chunk.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from symgen.data.raw import Places
from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.integrals import POINTS, window_weights
from symgen.estimation.values import FloatArray

#: From a span of k nodes to functions of the state, (k, m, a), and rates, (k, m, a + c), of which
#: the first are slopes of these functions.
Terms = Callable[[slice], tuple[FloatArray, FloatArray]]
_OVERLAP = 10
_CHUNK = 128  # approximate number of nodes to evaluate at once
_FINE = 20  # minimum number of nodes of a window, if the log has enough


@dataclass(frozen=True)
class Windows:
    """Sliding windows of a log, in nodes.

    Attributes:
        stride: samples from node to node.
        steps: nodes of a window.
        hop: nodes from the end of a window to that of the next.
    """

    stride: int
    steps: int
    hop: int

    @property
    def correlation(self) -> int:
        """Number of windows that share samples."""
        return max(1, self.steps // self.hop)

    def spans(self, samples: int) -> tuple[Places, Places]:
        """Return the first and last samples of the windows of a log of `samples` samples, (K,)
        each.
        """
        last = np.arange(self.steps, -(-samples // self.stride), self.hop)
        return (last - self.steps) * self.stride, last * self.stride


def place_windows(log: FilteredLog, window: float) -> Windows:
    """Place the windows of a log.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    length = log.samples.length
    if not log.step / 2 < window < length:
        raise IdentificationError(
            f"{log.name}: a window of {window:g} s does not fit a log of {length:.3g} s with a "
            f"sample every {log.step:g} s"
        )
    return windows(log.step, log.stride, window)


def windows(step: float, stride: int, window: float) -> Windows:
    """Place windows, with ends spaced by a tenth of their length.

    Args:
        step: sampling step of the log, s.
        stride: maximum number of samples from node to node.
        window: length of the windows, s.
    """
    steps = max(1, round(window / step))
    stride = min(stride, max(1, steps // _FINE))
    nodes = max(1, round(steps / stride))
    return Windows(stride, nodes, max(1, round(nodes / _OVERLAP)))


def window_rows(
    nodes: int, w: Windows, step: float, terms: Terms, count: int | None = None
) -> FloatArray:
    """Return the changes of functions of a motion over windows, and integrals, (K, m, a + c).

        s(t2) - s(t1) - integral slope dt,    integral r dt

    Args:
        nodes: number of nodes of a log.
        w: the windows of the log.
        step: sampling step, s.
        terms: function from a span of nodes to s (k, m, a), and to slope and r (k, m, a + c). The
            span ends POINTS nodes behind its last window.
        count: number of windows of a span; None to choose it.
    """
    last = np.arange(w.steps, nodes, w.hop)
    count = count or max(1, max(_CHUNK, 2 * w.steps) // w.hop)
    parts = []
    for first in range(0, len(last), count):
        ends = last[first : first + count]
        low = max(int(ends[0]) - w.steps - POINTS, 0)
        high = int(ends[-1]) + 1 + POINTS
        state, rates = terms(slice(low, high))
        at = ends - low
        weights = step * _weights(len(state), int(at[0]), len(at), w)
        flat = rates.reshape(len(rates), -1)
        rows = (weights @ flat).reshape(-1, *rates.shape[1:])
        change = state[at] - state[at - w.steps]
        slopes = rows[:, :, : change.shape[2]]
        slopes[:] = change - slopes
        parts.append(rows)
    return np.concatenate(parts)


def over_windows(
    x: Callable[[slice], FloatArray],
    samples: int,
    w: Windows,
    step: float,
    count: int | None = None,
) -> FloatArray:
    """Return the integrals of a signal over windows, (K, m).

    Args:
        x: function from a span of samples to the signal (k, m).
        samples: number of samples.
        w, step, count: as in `window_rows`.
    """
    every = Windows(1, w.steps * w.stride, w.hop * w.stride)
    terms = rates_only(lambda at: x(at)[:, :, None])
    return window_rows(samples, every, step, terms, count)[:, :, 0]


def rates_only(rates: Callable[[slice], FloatArray]) -> Terms:
    """Return the terms of functions that are only integrated."""

    def terms(nodes: slice) -> tuple[FloatArray, FloatArray]:
        values = rates(nodes)
        return values[:, :, :0], values

    return terms


@lru_cache(maxsize=32)
def _weights(nodes: int, first: int, count: int, w: Windows) -> FloatArray:
    """Return the weights of the nodes of a chunk in its integrals, in steps of the log.

    Args:
        nodes: number of nodes of the chunk.
        first: node at which its first window ends.
        count: number of its windows.
        w: the windows of the log.
    """
    last = first + w.hop * np.arange(count)
    return w.stride * window_weights(nodes, last, w.steps)
