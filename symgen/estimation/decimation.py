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

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import TAIL, continued, end_window, lowpass_weights
from symgen.estimation.band import OPEN

FloatArray = NDArray[np.float64]
#: Rows kept in a period of the cutoff.
PER_PERIOD = 4
#: Seconds that are left out at either end of a log, where the filter runs in.
ENDS = 0.3
_CHUNK = 8192  # nodes that are evaluated at once, about


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
        self, values: Callable[[int, int], FloatArray]
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate nodes chunk by chunk, filter them and keep some.

        Args:
            values: gives nodes first .. last (exclusive), (last - first, ...).

        Yields:
            Which of `kept` come now, and their filtered values (k, ...).
        """
        kept = self.kept
        if self.cutoff is None:
            for first in range(0, len(kept), _CHUNK):
                part = slice(first, min(first + _CHUNK, len(kept)))
                yield part, values(int(kept[part][0]), int(kept[part][-1]) + 1)
            return
        reach = min(self.samples - 1, math.ceil(TAIL / (self.cutoff * self.step)))
        response = lowpass_weights(self.step, self.cutoff, reach)[reach:]
        rows = max(1, -(-reach // self.every))
        a_chunk = max(rows, rows * (_CHUNK * self.stride // (rows * self.every)))
        for first in range(0, len(kept), a_chunk):
            part = slice(first, min(first + a_chunk, len(kept)))
            low, high = self._around(kept[part], reach)
            inside = values(max(low, 0), min(high, self.nodes))
            before, after = max(-low, 0), max(high - self.nodes, 0)
            if before or after:
                inside = self._extended(values, inside, before, after)
            flat = inside.reshape(len(inside), -1)
            out = np.empty((part.stop - part.start, flat.shape[1]))
            for start in range(0, len(out), rows):
                now = kept[part][start : start + rows]
                begin, end = self._around(now, reach)
                away = np.abs(now[:, None] - self.stride * np.arange(begin, end))
                band = np.where(away <= reach, response[np.minimum(away, reach)], 0.0)
                band /= band.sum(axis=1, keepdims=True)
                out[start : start + len(now)] = band @ flat[begin - low : end - low]
            yield part, out.reshape(len(out), *inside.shape[1:])

    def _around(self, kept: NDArray[np.int64], reach: int) -> tuple[int, int]:
        """Return the nodes, first and behind the last, that reach some samples."""
        first, last = int(kept[0]) - reach, int(kept[-1]) + reach
        return -(-first // self.stride), min(last // self.stride + 1, 2 * self.nodes - 1)

    def _extended(
        self, values: Callable[[int, int], FloatArray], inside: FloatArray, before: int, after: int
    ) -> FloatArray:
        """Put the continuation of the signal before and behind its end, as `lowpass` does."""
        assert self.cutoff is not None
        apart, reach = self.stride * self.step, max(before, after)
        ends = min(self.nodes, max(reach, end_window(apart, self.cutoff)) + 1)
        parts = [inside]
        if before:
            head = values(0, ends)
            parts.insert(0, continued(head, apart, self.cutoff, reach)[reach - before : reach])
        if after:
            tail = continued(values(self.nodes - ends, self.nodes), apart, self.cutoff, reach)
            parts.append(tail[reach + ends : reach + ends + after])
        return np.concatenate(parts)


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
