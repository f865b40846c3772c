"""What an engineer computes by hand from logs: the torque residual of parameters, and his own fit.

Of the package under test it is given the kernel torque_regressor and nothing else. The filter is a
sine transform: a log is continued oddly about both ends, where a Butterworth filter run both ways
is the square of its gain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.fft import dst, idst
from scipy.interpolate import CubicSpline

CUTOFFS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0)  # Hz, that an analyst tries
FOLDS = 5
EDGE = 0.3  # s at both ends that are left out, where a filter sees one side only
FASTEST = 1000.0  # Hz, of the equations
Kernel = Callable[[np.ndarray, np.ndarray, np.ndarray], Any]


class Even(NamedTuple):
    """A log at an even rate, Hz: q, qd (None where not measured), tau, (N, n)."""

    rate: float
    q: np.ndarray
    qd: np.ndarray | None
    tau: np.ndarray


def even(t: np.ndarray, q: np.ndarray, qd: np.ndarray | None, tau: np.ndarray) -> Even:
    """Drop rows that repeat the one before or do not advance; interpolate at the mean rate."""
    x = np.hstack([q, tau] if qd is None else [q, tau, qd]).astype(float)
    keep = np.r_[True, (np.diff(t) > 0) & np.any(np.diff(x, axis=0) != 0, axis=1)]
    t, x = t[keep], x[keep]
    grid, n = np.linspace(t[0], t[-1], len(t)), q.shape[1]
    x = np.column_stack([np.interp(grid, t, column) for column in x.T])
    rate = (len(t) - 1) / float(t[-1] - t[0])
    return Even(rate, x[:, :n], None if qd is None else x[:, 2 * n :], x[:, n : 2 * n])


def channels(path: str | Path) -> tuple[np.ndarray, ...]:
    """t, q, qd (None where not measured) and tau of an .npz, or of a .csv with a header."""
    if Path(path).suffix == ".npz":
        with np.load(path) as file:
            return file["t"], file["q"], file.get("qd"), file["tau"]
    with open(path) as file:
        names = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    stems = [c.rstrip("0123456789") for c in names]
    q, qd, tau = (table[:, [s == key for s in stems]] for key in ("q", "qd", "tau"))
    return table[:, names.index("t")], q, qd if qd.size else None, tau


def read(path: str | Path) -> Even:
    """A log at an even rate."""
    return even(*channels(path))


def lowpass(x: np.ndarray, rate: float, cutoff: float) -> np.ndarray:
    """Butterworth, fourth order, both ways: 1 / (1 + (tan(pi f/rate) / tan(pi cutoff/rate))^8)."""
    if cutoff >= 0.45 * rate:
        return x
    f = np.arange(1, len(x) - 1) / (2 * (len(x) - 1))
    gain = 1 / (1 + (np.tan(np.pi * f) / np.tan(np.pi * cutoff / rate)) ** 8)
    out = np.linspace(x[0], x[-1], len(x))
    out[1:-1] += idst(gain[:, None] * dst(x[1:-1] - out[1:-1], 1, axis=0), 1, axis=0)
    return out


def derivative(x: np.ndarray, rate: float) -> np.ndarray:
    """Of the cubic spline through the samples."""
    t = np.arange(len(x)) / rate
    return np.asarray(CubicSpline(t, x)(t, 1))


def comparison_band(logs: Sequence[Even]) -> float:
    """Twice the frequency below which 99 % of a joint's power of speed lies, 2 to 10 Hz."""
    f, power = [], []
    for rate, q, *_ in logs:
        v = derivative(lowpass(q, rate, 50.0), rate)
        f.append(np.fft.rfftfreq(len(v), 1 / rate))
        power.append(np.abs(np.fft.rfft(v - v.mean(axis=0), axis=0)) ** 2 / (len(v) * rate))
    order = np.argsort(np.concatenate(f))
    share = np.cumsum(np.concatenate(power)[order], axis=0)
    highest = max(np.concatenate(f)[order][np.searchsorted(c, 0.99 * c[-1])] for c in share.T)
    return float(np.clip(2 * highest, 2.0, 10.0))


def equations(
    kernel: Kernel,
    log: Even,
    cutoff: float,
    comparison: float,
    derived: bool = False,
    fastest: float = FASTEST,
) -> tuple[np.ndarray, np.ndarray]:
    """Regressor (K, n, p) and torque (K, n) in the comparison band, at four times its rate."""
    rate, q, qd, tau = log
    q = lowpass(q, rate, cutoff)
    qd = derivative(q, rate) if qd is None or derived else lowpass(qd, rate, cutoff)
    thin = max(1, round(rate / fastest))
    W = np.asarray(
        kernel(*(np.ascontiguousarray(x[::thin]) for x in (q, qd, derivative(qd, rate))))
    )
    y, rate = lowpass(tau, rate, comparison)[::thin], rate / thin
    W = lowpass(W.reshape(len(W), -1), rate, comparison).reshape(W.shape)
    edge, step = round(EDGE * rate), max(1, int(rate / (4 * comparison)))
    return W[edge : len(W) - edge : step], y[edge : len(y) - edge : step]


def residual(W: np.ndarray, y: np.ndarray, X: np.ndarray) -> tuple[np.ndarray, float]:
    """||tau_j - model_j|| / ||tau_j|| of each joint, and the same of all joints stacked."""
    miss, norm = np.linalg.norm(y - W @ X, axis=0), np.linalg.norm(y, axis=0)
    return miss / norm, float(np.linalg.norm(miss) / np.linalg.norm(norm))


def least_squares(W: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Joints are weighed by their torque, then by what the first solution misses."""
    weight = 1 / y.std(axis=0)
    for _ in range(2):
        A = (W * weight[:, None]).reshape(-1, W.shape[2])
        scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
        X = np.linalg.lstsq(A / scale, (y * weight).ravel(), rcond=1e-10)[0] / scale
        weight = 1 / np.maximum((y - W @ X).std(axis=0), 1e-12 * y.std(axis=0))
    return X


def analyst(
    kernel: Kernel, logs: Sequence[Even], comparison: float, derived: bool = False
) -> tuple[np.ndarray, float]:
    """Parameters, and the cutoff of CUTOFFS that is best on held-out folds of these logs."""
    tried = []
    for cutoff in (c for c in CUTOFFS if c >= 0.7 * comparison):
        parts = [equations(kernel, log, cutoff, comparison, derived) for log in logs]
        W, y = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        loss = 0.0
        for out in np.array_split(np.arange(len(y)), FOLDS):
            X = least_squares(np.delete(W, out, axis=0), np.delete(y, out, axis=0))
            loss += float(np.sum(((y[out] - W[out] @ X) / y.std(axis=0)) ** 2))
        tried.append((loss, cutoff, least_squares(W, y)))
    _, cutoff, X = min(tried, key=lambda entry: entry[0])
    return X, cutoff
