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
from itertools import pairwise

import numpy as np

from symgen.data.raw import Places
from symgen.data.signals import (
    OPEN,
    TAIL,
    continuation,
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
        beyond = min(reach // self.stride, self.nodes - 1)  # nodes that extend an end
        window = end_window(self.stride * self.step, self.cutoff)
        near = max(beyond + 1, window)
        period = self.every // math.gcd(self.every, self.stride)
        # the next block has the same position among the kept samples
        block = period * max(1, block_size // period)
        begin = block * -(-near // block)
        inner = range(begin, self.nodes - near, block)
        smooth = total = np.zeros((len(kept), 1))
        for first, last in pairwise([0, *inner, self.nodes]):
            block_values = values(first, last)
            flat = block_values.reshape(last - first, -1)
            backwards, start = flat[::-1], first
            if first == 0:
                flat = np.concatenate([continuation(flat, beyond, window), flat])
                start = -beyond
                smooth = np.zeros((len(kept), flat.shape[1]))
            if last == self.nodes:
                after = continuation(backwards, beyond, window)
                flat = np.concatenate([flat, after[::-1]])
            low = start * self.stride - reach
            high = (start + len(flat) - 1) * self.stride + reach
            among = np.searchsorted(kept, [low, high + 1])
            reached = slice(*among.tolist())
            offsets = kept[reached] - start * self.stride
            rows = len(offsets)
            if rows:
                weights = _weights(self, reach, int(offsets[0]), rows, len(flat))
                smooth[reached] += weights @ flat
                total[reached] += weights.sum(axis=1, keepdims=True)
        return (smooth / total).reshape(len(kept), *block_values.shape[1:])


@lru_cache(maxsize=64)
def _weights(d: Decimation, reach: int, offset: int, rows: int, nodes: int) -> FloatArray:
    """Return the weights of some nodes in consecutive kept samples, (rows, nodes).

    Args:
        d: the decimation, with a filter.
        reach: samples on either side with a weight.
        offset: samples from the first node to the first kept one.
        rows, nodes: number of kept samples and of nodes.
    """
    assert d.cutoff is not None  # only called with a filter
    kept = offset + d.every * np.arange(rows)
    away = np.abs(kept[:, None] - d.stride * np.arange(nodes))
    weights = response(d.step, d.cutoff, reach)[reach:]
    return np.where(away <= reach, weights[np.minimum(away, reach)], 0.0)


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
