"""The low-pass of the comparison band and its decimation, as one product with a banded matrix.

All compared and all solved signals pass the same zero-phase low-pass (the parallel filter of
Gautier). The output keeps four samples in a period of the cutoff and leaves out 0.3 s at both ends.
Filter and decimation are one matrix, with the shifted impulse response in every row. Each chunk of
a regressor adds one dense product to the rows within its reach, so no array as long as the log has
to be stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from symgen.data.raw import Places
from symgen.data.signals import (
    OPEN,
    TAIL,
    end_of_cubic,
    end_window,
    response,
)
from symgen.estimation.values import FloatArray

#: Rows kept in a period of the cutoff.
PER_PERIOD = 4
#: Seconds to leave out at both ends of a log, where the filter settles.
ENDS = 0.3
#: Approximate number of nodes to evaluate at once: many columns of this length fit into a cache.
BLOCK = 256


@dataclass(frozen=True)
class Decimation:
    """A low-pass on nodes (every `stride`-th sample), and the samples at which it keeps its output.

    Kept samples need not be nodes. The impulse response takes the distance from the kept sample to
    the surrounding nodes, so the output does not depend on the choice of nodes.

    Attributes:
        samples: number of samples of the log.
        step: sampling step, s.
        stride: samples from node to node.
        cutoff: cutoff, Hz; None without a filter, when every sample is kept.
        every: samples from one kept sample to the next.
        margin: samples left out at both ends, where the filter settles.
    """

    samples: int
    step: float
    stride: int
    cutoff: float | None
    every: int
    margin: int

    @property
    def kept(self) -> Places:
        """Numbers of the kept samples."""
        return np.arange(self.margin, self.samples - self.margin, self.every)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return -(-self.samples // self.stride)

    def filtered(
        self, values: Callable[[int, int], FloatArray], block_size: int = BLOCK
    ) -> FloatArray:
        """Return the output of the low-pass at the kept samples, (K, ...), with one evaluation a
        node.

        Args:
            values: returns the values at nodes first to last (exclusive), (last - first, ...).
            block_size: approximate number of nodes to evaluate at once.
        """
        if self.cutoff is None:
            blocks = range(0, self.samples, block_size)
            return np.concatenate([values(k, min(k + block_size, self.samples)) for k in blocks])
        kept = self.kept
        reach = min(math.ceil(TAIL / (self.cutoff * self.step)), self.samples - 1)
        period = self.every // math.gcd(self.every, self.stride)
        # the next block has the same position among the kept samples
        block = period * max(1, block_size // period)
        ends = [_End(self, reach, at) for at in (kept, (self.nodes - 1) * self.stride - kept)]
        total = ends[0].moments[:, 0] / 2 + ends[1].moments[:, 0] / 2
        smooth = np.zeros((len(kept), 0))
        for first in range(0, self.nodes, block):
            last = min(first + block, self.nodes)
            block_values = values(first, last)
            flat = block_values.reshape(last - first, -1)
            if first == 0:
                smooth = np.zeros((len(kept), flat.shape[1]))
            begin, end = first * self.stride - reach, (last - 1) * self.stride + reach
            reached = slice(*np.searchsorted(kept, [begin, end + 1]).tolist())
            rows = reached.stop - reached.start
            if rows:
                offset = int(kept[reached.start]) - begin - reach
                weights = _weights(self, reach, offset, rows, last - first)
                total[reached] += weights.sum(axis=1)
                numbers = np.arange(first, last)
                weights = weights + ends[0].weights(reached, numbers)
                weights += ends[1].weights(reached, self.nodes - 1 - numbers)
                smooth[reached] += weights @ flat
        return (smooth / total[:, None]).reshape(len(kept), *block_values.shape[1:])


class _End:
    """An end of a log, beyond which `continuation` extends a signal.

    The samples beyond the end are sums of the last ones. Their weights in the kept samples are
    therefore additional weights of these.

    Attributes:
        moments: (K, 2) weights of the value and the second derivative at the end in kept samples.
    """

    def __init__(self, d: Decimation, reach: int, away: Places) -> None:
        """Find the moments.

        Args:
            d: the decimation, with a filter.
            reach: samples on either side of a kept sample with a weight.
            away: samples from the end to the kept samples, (K,).
        """
        assert d.cutoff is not None
        self.d, self.reach, self.away = d, reach, away
        self.beyond = min(reach // d.stride, d.nodes - 1)  # nodes that extend the end
        self.cubic = end_of_cubic(min(end_window(d.stride * d.step, d.cutoff), d.nodes))
        numbers = np.arange(1, self.beyond + 1)
        self.moments = np.zeros((len(away), 2))
        near = np.flatnonzero(away <= reach)
        outside = _impulse(d, reach, away[near, None] + d.stride * numbers)
        self.moments[near] = outside @ np.column_stack([2.0 + 0 * numbers, numbers**2])

    def weights(self, rows: slice, numbers: Places) -> FloatArray | float:
        """Return additional weights of nodes in kept samples, (rows, nodes).

        Args:
            rows: kept samples.
            numbers: numbers of the nodes, from the end.
        """
        window = self.cubic.shape[1]
        away = self.away[rows]
        if numbers.min() > max(self.beyond, window) or away.min() > self.reach:
            return 0.0
        mirrored = (numbers > 0) & (numbers <= self.beyond)
        distance = away[:, None] + self.d.stride * numbers
        out = np.where(mirrored, -_impulse(self.d, self.reach, distance), 0.0)
        inside = numbers < window
        out[:, inside] += self.moments[rows] @ self.cubic[:, numbers[inside]]
        return np.asarray(out)


def _impulse(d: Decimation, reach: int, away: Places) -> FloatArray:
    """Return the impulse response at distances in samples; 0 beyond the reach."""
    assert d.cutoff is not None  # only called with a filter
    weights = response(d.step, d.cutoff, reach)[reach:]
    return np.where(away <= reach, weights[np.minimum(away, reach)], 0.0)


@lru_cache(maxsize=8)
def _weights(d: Decimation, reach: int, offset: int, rows: int, nodes: int) -> FloatArray:
    """Return the weights of some nodes in consecutive kept samples, (rows, nodes).

    Args:
        d: the decimation, with a filter.
        reach: samples on either side with a weight.
        offset: samples from the first node to the first kept one.
        rows, nodes: number of kept samples and of nodes.
    """
    kept = offset + d.every * np.arange(rows)
    away = np.abs(kept[:, None] - d.stride * np.arange(nodes))
    return _impulse(d, reach, away)


def decimation(samples: int, step: float, stride: int, cutoff: float) -> Decimation:
    """Return the decimation of a log whose every `stride`-th sample is a node.

    Args:
        samples: number of samples of the log.
        step: sampling step, s.
        stride: samples from node to node.
        cutoff: cutoff of the low-pass, Hz.
    """
    if not cutoff < OPEN / (stride * step):
        return Decimation(samples, step, 1, None, 1, 0)
    every = max(1, int(1 / (PER_PERIOD * cutoff * step)))
    margin = min(int(ENDS / step), samples // 10)
    return Decimation(samples, step, stride, cutoff, every, margin)
