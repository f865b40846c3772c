"""The low-pass of the comparison band and its decimation, as one product with a banded matrix.

Whatever is compared or solved passes the same zero-phase low-pass (Gautier's parallel filter) and
is kept four times a period of its cutoff from 0.3 s on, where an engineer's decimation keeps it.
Both at once are a matrix with the filter's impulse response in every row, shifted: a chunk of a
regressor of many columns is filtered by a few dense products, and nothing of the length of the log
has to be stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from symgen.data.convolution import lowpass_weights
from symgen.data.signals import TAIL, end_of_cubic, end_window
from symgen.estimation.band import OPEN
from symgen.estimation.values import FloatArray

#: Rows kept in a period of the cutoff.
PER_PERIOD = 4
#: Seconds that are left out at either end of a log, where the filter runs in.
ENDS = 0.3
_CHUNK = 8192  # samples that are evaluated at once where nothing is filtered
_BLOCK = 256  # nodes that are evaluated at once, about: what they give stays in a cache
#: Samples of a few channels that are filtered at once.
CHANNELS = 2048


@dataclass(frozen=True)
class Decimation:
    """A low-pass on nodes (every `stride`-th sample), and the samples at which its output is kept.

    These are no nodes: wherever they lie, the impulse response is taken at its distance from the
    nodes around, so that what is kept does not depend on where a model is evaluated.

    Attributes:
        samples: of the log.
        step: between samples, s.
        stride: samples from node to node.
        cutoff: Hz; None where nothing is filtered and every sample is kept.
        every: samples from one kept to the next.
        margin: samples left out at either end, where the filter runs in.
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
        self, values: Callable[[int, int], FloatArray], together: int = _BLOCK
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate nodes block by block, each once, filter them and keep some.

        Args:
            values: gives nodes first .. last (exclusive), (last - first, ...).
            together: nodes of a block, about.

        Yields:
            Which of `kept` come now, and their filtered values (k, ...).
        """
        kept = self.kept
        if self.cutoff is None:
            for first in range(0, len(kept), _CHUNK):
                part = slice(first, min(first + _CHUNK, len(kept)))
                yield part, values(int(kept[part][0]), int(kept[part][-1]) + 1)
            return
        if len(kept) == 0:
            return
        weights = _weights(self)
        reach, period = weights.reach, self.every // math.gcd(self.every, self.stride)
        block = period * max(1, together // period)  # that lies among the kept as the next one does
        low = max(-(-(int(kept[0]) - reach) // self.stride), 0)
        high = min((int(kept[-1]) + reach) // self.stride + 1, self.nodes)
        begun, left = 0, np.zeros((0, 0))  # first of the kept that is not yet given, and its sums
        shape: tuple[int, ...] = ()
        for first in range(low, high, block):
            last = min(first + block, high)
            inside = values(first, last)
            flat, shape = inside.reshape(len(inside), -1), inside.shape[1:]
            rows = slice(
                *np.searchsorted(
                    kept, [first * self.stride - reach, (last - 1) * self.stride + reach + 1]
                )
            )
            more = rows.stop - begun - len(left)
            left = np.concatenate(
                [left.reshape(len(left), flat.shape[1]), np.zeros((more, flat.shape[1]))]
            )
            left[rows.start - begun : rows.stop - begun] += weights(rows, first, last) @ flat
            done = (
                int(np.searchsorted(kept, last * self.stride - reach)) if last < high else len(kept)
            )
            if done > begun:
                yield slice(begun, done), left[: done - begun].reshape(done - begun, *shape)
                left, begun = left[done - begun :], done


class _Weights:
    """What nodes weigh in the kept samples.

    A signal is continued at its ends as `lowpass` does it, which is linear in its first and last
    nodes: these weigh by so much more.
    """

    def __init__(self, d: Decimation) -> None:
        assert d.cutoff is not None
        self._d, self._kept = d, d.kept
        self.reach = min(d.samples - 1, math.ceil(TAIL / (d.cutoff * d.step)))
        self._response = lowpass_weights(d.step, d.cutoff, self.reach)[self.reach :]
        self._known: dict[tuple[int, int, int, int], FloatArray] = {}
        kept, last = self._kept, (d.nodes - 1) * d.stride
        self._head = self._end(kept[kept < self.reach])
        self._tail = self._end((last - kept)[last - kept < self.reach][::-1])

    def __call__(self, rows: slice, first: int, last: int) -> FloatArray:
        """Return the weights of nodes first .. last (exclusive) in some of the kept, (K, nodes)."""
        kept, stride, nodes = self._kept[rows], self._d.stride, self._d.nodes
        count, (heads, head), (tails, tail) = len(kept), self._head.shape, self._tail.shape
        begins = rows.start < heads and first < head
        ends = rows.stop > len(self._kept) - tails and last > nodes - tail
        key = (int(kept[0]) - first * stride, count, last - first, first * (begins or ends))
        if key in self._known:
            return self._known[key]
        out = self._at(kept[:, None] - stride * np.arange(first, last))
        if begins:
            more = self._head[rows, first:last]
            out[: len(more), : more.shape[1]] += more
        if ends:  # seen from the end
            before = slice(len(self._kept) - rows.stop, len(self._kept) - rows.start)
            more = self._tail[before, nodes - last : nodes - first][::-1, ::-1]
            out[count - len(more) :, last - first - more.shape[1] :] += more
        out /= self._sums(kept)[:, None]
        self._known[key] = out
        return out

    def _at(self, away: NDArray[np.int64]) -> FloatArray:
        """Return the impulse response some samples away."""
        away = np.abs(away)
        found = self._response[np.minimum(away, self.reach)]
        return np.where(away <= self.reach, found, 0.0)

    def _end(self, kept: NDArray[np.int64]) -> FloatArray:
        """Return what the continuation before node 0 weighs: x(-s) = 2 x0 - x(s) + a0 s**2.

        Args:
            kept: (K,) samples after node 0, increasing.

        Returns:
            (K, nodes): of as many nodes as it is made of.
        """
        stride, nodes, cutoff = self._d.stride, self._d.nodes, self._d.cutoff
        assert cutoff is not None
        if len(kept) == 0:
            return np.zeros((0, 0))
        window = min(nodes, end_window(stride * self._d.step, cutoff))
        s = np.arange(1, min((self.reach - int(kept[0])) // stride, nodes - 1) + 1)
        before = self._at(kept[:, None] + stride * s)  # of node -s
        out = np.zeros((len(kept), max(len(s) + 1, window)))
        out[:, 1 : len(s) + 1] = -before
        start, curvature = end_of_cubic(window)
        out[:, :window] += np.outer(2 * before.sum(axis=1), start)
        out[:, :window] += np.outer(before @ s.astype(float) ** 2, curvature)
        return out

    def _sums(self, kept: NDArray[np.int64]) -> FloatArray:
        """Return the sum of the weights of all nodes, those of the continuation with them, (K,)."""
        stride, d = self._d.stride, self._d
        phases, where = np.unique(kept % stride, return_inverse=True)
        span = self.reach // stride + 1
        away = phases[:, None] + stride * np.arange(-span, span + 1)
        sums = self._at(away).sum(axis=1)[where]
        return np.asarray(sums - self._at((2 * d.nodes - 1) * stride - kept))  # that node is none


@lru_cache(maxsize=4)
def _weights(d: Decimation) -> _Weights:
    return _Weights(d)


def decimation(samples: int, step: float, stride: int, cutoff: float) -> Decimation:
    """Return the decimation of a log whose every `stride`-th sample is a node.

    Args:
        samples: of the log.
        step: sampling step, s.
        stride: samples from node to node.
        cutoff: of the low-pass, Hz.
    """
    if not cutoff < OPEN / (stride * step):
        return Decimation(samples, step, 1, None, 1, 0)
    every = max(1, int(1 / (PER_PERIOD * cutoff * step)))
    margin = min(int(ENDS / step), samples // 10)
    return Decimation(samples, step, stride, cutoff, every, margin)
