"""Time the same functions in several libraries, in turns; this module runs as a separate process.

Code that this processor cannot run then ends only that process. The module uses the standard
library only. It reads one JSON object from standard input, and writes another one.
"""

from __future__ import annotations

import ctypes
import json
import math
import statistics
import sys
import time
from typing import Any

ROUNDS = 31
ENOUGH = 1e-4  # seconds of one timing


def race(libraries: dict[str, str], functions: list[dict[str, Any]]) -> dict[str, float]:
    """Return the time of each library relative to the first: the geometric mean over functions.

    The time of a function is the median of its ratios over many rounds. All libraries run once in
    a round, so a slow moment of the machine affects them equally.

    Args:
        libraries: name and path of each; the first is the reference.
        functions: name, the numbers that come first (`leading`), then the sizes of the arrays that
            are read (`inputs`) and written (`outputs`).
    """
    loaded = {name: ctypes.CDLL(path) for name, path in libraries.items()}
    logarithms = dict.fromkeys(loaded, 0.0)
    for function in functions:
        arrays = [
            (ctypes.c_double * (size + 8))(*(math.sin(1.7 * i) for i in range(size)))
            for size in function["inputs"]
        ]
        arrays += [(ctypes.c_double * (size + 8))() for size in function["outputs"]]
        arguments = (*map(ctypes.c_size_t, function["leading"]), *map(_aligned, arrays))
        calls = {name: getattr(library, function["name"]) for name, library in loaded.items()}
        for call in calls.values():
            call.restype = None
        first = next(iter(calls.values()))
        count = 1
        while _seconds(first, arguments, count) < ENOUGH:
            count *= 2
        ratios: dict[str, list[float]] = {name: [] for name in calls}
        for _ in range(ROUNDS):
            times = {name: _seconds(call, arguments, count) for name, call in calls.items()}
            base = next(iter(times.values()))
            for name, seconds in times.items():
                ratios[name].append(seconds / base)
        for name, found in ratios.items():
            logarithms[name] += math.log(statistics.median(found)) / len(functions)
    return {name: math.exp(value) for name, value in logarithms.items()}


def _aligned(array: Any) -> ctypes.c_void_p:
    """Return the first index of an array at a cache line: all libraries get the same."""
    return ctypes.c_void_p((ctypes.addressof(array) + 63) // 64 * 64)


def _seconds(call: Any, arguments: tuple[Any, ...], count: int) -> float:
    start = time.perf_counter()
    for _ in range(count):
        call(*arguments)
    return time.perf_counter() - start


if __name__ == "__main__":
    print(json.dumps(race(**json.load(sys.stdin))))
