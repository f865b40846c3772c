"""The low-pass of the comparison band and its decimation, as one product with a banded matrix.

Whatever is compared or solved passes the same zero-phase low-pass (Gautier's parallel filter), and
is kept four times a period of its cutoff. Both at once are a matrix with the filter's impulse
response in every row, shifted: a chunk of a regressor of many columns is filtered by a few dense
products, and nothing of the length of the log has to be stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import TAIL, continued, lowpass_weights

FloatArray = NDArray[np.float64]
#: Rows kept in a period of the cutoff.
PER_PERIOD = 4
#: Seconds that are left out at either end of a log, where the filter runs in.
ENDS = 0.3
_CHUNK = 8192  # nodes that are evaluated at once


@dataclass(frozen=True)
class Decimation:
    """A low-pass on nodes (every `stride`-th sample), and the nodes that are kept.

    Attributes:
        nodes: number of nodes.
        step: between nodes, s.
        cutoff: Hz; None where nothing is filtered and every node is kept.
        every: nodes from one kept to the next.
        margin: nodes left out at either end, where the filter runs in.
    """

    nodes: int
    step: float
    cutoff: float | None
    every: int
    margin: int

    @property
    def kept(self) -> NDArray[np.int64]:
        """Numbers of the kept nodes."""
        return np.arange(self.margin, self.nodes - self.margin, self.every)

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
                low, high = int(kept[part][0]), int(kept[part][-1]) + 1
                yield part, values(low, high)[:: self.every]
            return
        reach = min(self.nodes - 1, math.ceil(TAIL / (self.cutoff * self.step)))
        weights = lowpass_weights(self.step, self.cutoff, reach)
        rows = max(1, -(-reach // self.every))
        band = _banded(weights, rows, self.every)
        a_chunk = max(rows, rows * (_CHUNK // max(rows * self.every, 1)))
        for first in range(0, len(kept), a_chunk):
            part = slice(first, min(first + a_chunk, len(kept)))
            low, high = int(kept[part][0]) - reach, int(kept[part][-1]) + reach + 1
            inside = values(max(low, 0), min(high, self.nodes))
            before, after = max(-low, 0), max(high - self.nodes, 0)
            if before or after:
                inside = self._extended(values, inside, before, after, reach)
            flat = inside.reshape(len(inside), -1)
            out = np.empty((part.stop - part.start, flat.shape[1]))
            for start in range(0, len(out), rows):
                count = min(rows, len(out) - start)
                span = (count - 1) * self.every + 2 * reach + 1
                source = flat[start * self.every : start * self.every + span]
                out[start : start + count] = band[:count, :span] @ source
            yield part, out.reshape(len(out), *inside.shape[1:])

    def _extended(
        self,
        values: Callable[[int, int], FloatArray],
        inside: FloatArray,
        before: int,
        after: int,
        reach: int,
    ) -> FloatArray:
        """Put the continuation of the signal before and behind its end, as `lowpass` does."""
        assert self.cutoff is not None
        ends = min(self.nodes, 2 * reach + 2)
        parts = [inside]
        if before:
            head = values(0, ends)
            parts.insert(0, continued(head, self.step, self.cutoff, reach)[reach - before : reach])
        if after:
            tail = continued(values(self.nodes - ends, self.nodes), self.step, self.cutoff, reach)
            parts.append(tail[reach + ends : reach + ends + after])
        return np.concatenate(parts)


def _banded(weights: FloatArray, rows: int, every: int) -> FloatArray:
    """Return the matrix of `rows` outputs, `every` inputs apart."""
    out = np.zeros((rows, (rows - 1) * every + len(weights)))
    for k in range(rows):
        out[k, k * every : k * every + len(weights)] = weights
    return out


def decimation(samples: int, step: float, stride: int, cutoff: float) -> Decimation:
    """Return the decimation of a log whose every `stride`-th sample is a node.

    Args:
        samples: of the log.
        step: sampling step, s.
        stride: samples from node to node.
        cutoff: of the low-pass, Hz.
    """
    nodes, apart = -(-samples // stride), stride * step
    if not cutoff < 0.45 / apart:
        return Decimation(nodes, apart, None, 1, 0)
    every = max(1, int(1 / (PER_PERIOD * cutoff * apart)))
    margin = min(int(ENDS / apart), nodes // 10)
    return Decimation(nodes, apart, cutoff, every, margin)
