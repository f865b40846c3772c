"""Sliding windows of a log: their ends in nodes, and the chunks of nodes that they need."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from symgen.data.raw import Places
from symgen.errors import IdentificationError
from symgen.estimation.decimation import BLOCK
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.integrals import POINTS, over_windows
from symgen.estimation.values import FloatArray

#: From q, qd (k, n) to functions of the state (k, m, a) and rates (k, m, c).
Terms = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
_OVERLAP = 10
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


def window_rows(terms: Terms, q: FloatArray, qd: FloatArray, w: Windows, step: float) -> FloatArray:
    """Return the changes of functions of a motion over windows plus integrals, (K, m, c).

        s(t2) - s(t1) + integral r dt,    with the a columns of s added to the first a of r

    Args:
        terms: function from q, qd (k, n) to s (k, m, a) and r (k, m, c).
        q, qd: (nodes, n) motion of a log.
        w: the windows of the log.
        step: sampling step, s.
    """
    parts = []
    for ends in _chunks(len(q), w.steps, w.hop):
        low = max(int(ends[0]) - w.steps - POINTS, 0)
        span, at = slice(low, int(ends[-1]) + 1 + POINTS), ends - low
        state, rates = terms(q[span], qd[span])
        rows = over_windows(rates, w.stride * step, at, w.steps)
        rows[:, :, : state.shape[2]] += state[at] - state[at - w.steps]
        parts.append(rows)
    return np.concatenate(parts)


def _chunks(nodes: int, steps: int, hop: int) -> Iterator[Places]:
    """Yield the window ends chunk by chunk, as node numbers."""
    last = np.arange(steps, nodes, hop)
    count = max(1, max(BLOCK, 2 * steps) // hop)
    for first in range(0, len(last), count):
        yield last[first : first + count]
