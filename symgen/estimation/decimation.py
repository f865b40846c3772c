"""The low-pass of the comparison band and its decimation, as one product with a banded matrix.

Everything that is compared or solved passes the same zero-phase low-pass (the parallel filter of
Gautier). Four samples in a period of its cutoff are kept, from 0.3 s on. Filter and decimation
together are one matrix, with the shifted impulse response in every row. A few dense products
therefore filter a chunk of a regressor, and nothing as long as the log has to be stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symgen.data.convolution import lowpass_weights
from symgen.data.signals import TAIL, end_window, onto_end
from symgen.estimation.band import OPEN
from symgen.estimation.values import FloatArray

#: Rows kept in a period of the cutoff.
PER_PERIOD = 4
#: Seconds that are left out at either end of a log, where the filter runs in.
ENDS = 0.3
_CHUNK = 8192  # samples that are evaluated at once where nothing is filtered
#: Nodes that are evaluated at once, about: what they give of many columns stays in a cache.
BLOCK = 256


@dataclass(frozen=True)
class Decimation:
    """A low-pass on nodes (every `stride`-th sample), and the samples at which its output is kept.

    Kept samples need not be nodes. The impulse response is evaluated at the distance to the nodes
    around, so the output does not depend on the nodes at which a model is evaluated.

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
    def kept(self) -> NDArray[np.int64]:
        """Numbers of the kept samples."""
        return np.arange(self.margin, self.samples - self.margin, self.every)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return -(-self.samples // self.stride)

    def chunks(
        self, values: Callable[[int, int], FloatArray], together: int = BLOCK
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate nodes block by block, each once, filter them and keep some.

        Args:
            values: returns the values at nodes first to last (exclusive), (last - first, ...).
            together: approximate number of nodes in a block.

        Yields:
            The indices into `kept`, and their filtered values (k, ...).
        """
        kept = self.kept
        if self.cutoff is None:
            for first in range(0, len(kept), _CHUNK):
                part = slice(first, min(first + _CHUNK, len(kept)))
                yield part, values(int(kept[part][0]), int(kept[part][-1]) + 1)
            return
        apart, reach = self.stride * self.step, math.ceil(TAIL / (self.cutoff * self.step))
        reach = min(reach, self.samples - 1)
        beyond = min(reach // self.stride, self.nodes - 1)
        alone = max(beyond + 1, end_window(apart, self.cutoff))  # nodes that continue an end
        period = self.every // math.gcd(self.every, self.stride)
        block = period * max(1, together // period)  # that lies among the kept as the next one does
        edges = range(block * -(-alone // block), self.nodes - alone, block)
        begun = 0  # first of the kept that is not yet given; sums and weights of it and the next
        left, weight = np.zeros((0, 1)), np.zeros(0)
        for first, last in pairwise([0, *edges, self.nodes]):
            inside = values(first, last)
            flat = inside.reshape(len(inside), -1)
            end = done = len(kept)
            if last < self.nodes:
                until = last * self.stride + reach
                end, done = np.searchsorted(kept, [until, until - 2 * reach]).tolist()
            sums, total = np.zeros((end - begun, flat.shape[1])), np.zeros(end - begun)
            sums[: len(left)], total[: len(left)] = left, weight
            if end > begun:
                ends = beyond if first == 0 else 0, beyond if last == self.nodes else 0
                offset = int(kept[begun]) - first * self.stride
                rows, own = _weights(self, reach, offset, (end - begun, len(flat)), ends)
                sums += rows @ flat
                total += own
            if done > begun:
                smooth = sums[: done - begun] / total[: done - begun, None]
                yield slice(begun, done), smooth.reshape(done - begun, *inside.shape[1:])
            left, weight, begun = sums[done - begun :], total[done - begun :], done


@lru_cache(maxsize=256)  # some ten for each log and band, of about half a megabyte
def _weights(
    d: Decimation, reach: int, offset: int, shape: tuple[int, int], ends: tuple[int, int]
) -> tuple[FloatArray, FloatArray]:
    """Return the weights of a block of nodes in kept samples, and their sums.

    Args:
        d: the decimation, with a filter.
        reach: samples on either side that have a weight.
        offset: samples from the first node to the first kept one.
        shape: numbers of kept samples and of nodes.
        ends: nodes by which the ends of the log are continued; what continues them is a sum of the
            nodes there, so that their weights add to those of these nodes.
    """
    assert d.cutoff is not None  # something is filtered
    (count, own), (head, tail) = shape, ends
    kept, nodes = offset + d.every * np.arange(count), d.stride * np.arange(-head, own + tail)
    away = np.abs(kept[:, None] - nodes)
    response = lowpass_weights(d.step, d.cutoff, reach)[reach:]
    whole = np.where(away <= reach, response[np.minimum(away, reach)], 0.0)
    out = whole[:, head : head + own].copy()
    apart, back = d.stride * d.step, slice(None, None, -1)
    for length, x, y in ((head, whole, out), (tail, whole[:, back], out[:, back])):
        if length:
            onto_end(x[:, :length], min(own, end_window(apart, d.cutoff)), y)
    return out, whole.sum(axis=1)


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
