"""Identification on line from whole logs: all equations by quadrature, one QR of them all."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

DELAY = 7  # samples that a window waits for, after its last
LARGEST_GAIN = 2.0


def folded(W, y, forgetting=1.0):
    """R (diagonal >= 0), z = Q'y, rss and count of rows that each forget those before them."""
    weights = forgetting ** np.arange(len(y) - 1.0, -1.0, -1.0)
    stacked = np.sqrt(weights)[:, None] * np.c_[W, y]
    R = np.linalg.qr(np.r_[stacked, np.zeros((stacked.shape[1],) * 2)], mode="r")
    R *= np.where(np.diag(R) < 0, -1.0, 1.0)[:, None]
    return SimpleNamespace(
        R=R[:-1, :-1], z=R[:-1, -1], rss=R[-1, -1] ** 2, count=float(weights.sum())
    )


def rule(t, k):
    """First node and weights for the integral over step k: of the polynomial through up to six."""
    for reach in (2, 1):
        first = max(0, k - reach)
        x = (t[first : k + 2 + reach] - t[k]) / (t[k + 1] - t[k])
        powers = np.arange(len(x))
        weights = np.linalg.solve(x[None] ** powers[:, None], 1 / (powers + 1))
        if np.abs(weights).sum() <= LARGEST_GAIN:
            return first, weights
    return k, np.array([0.5, 0.5])


def equations(t, value, rate, mode, window):
    """Equations [w, y] that an identifier has taken at the end of a log, oldest first.

    Args:
        t: (N,) time.
        value: (N, equations, p + 1), whose change belongs to [w, y].
        rate: likewise, whose integral does.
        mode: start, sliding or consecutive.
        window: samples.
    """
    samples, count = value.shape[:2]
    length = {"start": count, "sliding": (window + 1) // 2}.get(mode, window)
    windows = max(samples - 1 - DELAY, 0) // length
    total = value.copy()
    for k in range(windows * length):
        first, weights = rule(t, k)
        step = (t[k + 1] - t[k]) * np.tensordot(weights, rate[first : first + len(weights)], 1)
        total[k + 1 :] += step
    ends = total[: windows * length + 1 : length]
    if mode == "start":
        rows = ends[1:] - ends[0]
    elif mode == "consecutive":
        rows = np.diff(ends, axis=0)
    else:
        halves = total[: windows * length].reshape(windows, length, count, -1).mean(axis=1)
        rows = np.diff(halves, axis=0)
    late = samples - DELAY - windows * length  # steps that had turns for the last window's
    taken = max(len(rows) - 1, 0) * count + min(count, late * -(-count // length))
    return rows.reshape(-1, value.shape[2])[: taken if len(rows) else 0]


def share(mode, window, count, forgetting):
    """Weight of the past per equation, where a sample forgets so much."""
    length = {"start": count, "sliding": (window + 1) // 2}.get(mode, window)
    return forgetting ** (length / count)
