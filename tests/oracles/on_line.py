"""Identification on line from whole logs: all equations by quadrature, one QR of them all."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

DELAY = 10  # samples that a window waits for, after its last
LARGEST_GAIN = 2.0


def folded(W, y, forgetting=1.0):
    """R (diagonal >= 0), z = Q'y, rss and count of rows, with forgetting in what they excite.

    From the information matrix A, in long double: rows are added. Once they determine X, `gather`
    rows are gathered, and the next p rows take from A, each along one row b of the triangle of
    these, without its part along those before it in the metric of A^-1 (in which they had the
    length 1 when they were taken),

        (1 - forgetting^(gather + p)) / (b' A^-1 b) b b'.
    """
    p = W.shape[1]
    gather = max(2 * p, int(1 / (4 * (1 - forgetting)))) if forgetting < 1 else len(y)
    R, rss, count, A, k = np.zeros((p + 1, p + 1)), 0.0, 0.0, None, 0
    rows, taken = np.zeros((p, p)), []
    for w, right in zip(W, y, strict=True):
        if A is None:
            R = np.linalg.qr(np.r_[R[:p], [np.r_[w, right]]], mode="r")
            left = R[p, p] ** 2
            norms = np.linalg.norm(R[:p, :p], axis=0)
            if forgetting < 1 and np.all(np.abs(np.diag(R)[:p]) > 1e-10 * norms):
                exact = R[:p].astype(np.longdouble)
                A, b = exact[:, :p].T @ exact[:, :p], exact[:, :p].T @ exact[:, p]
        else:
            w = w.astype(np.longdouble)
            X = _solved(A, b)
            left = (right - w @ X) ** 2 / (1 + w @ _solved(A, w))
            A, b = A + np.outer(w, w), b + w * right
            at = k % (gather + p)
            if at < gather:
                rows = np.zeros((p, p)) if at == 0 else rows
                rows = np.linalg.qr(np.r_[rows, [w.astype(float)]], mode="r")
            else:
                d = rows[p - 1 - (at - gather)].astype(np.longdouble)
                taken = taken if at > gather else []
                g = _solved(A, d)
                d = d - sum((g @ other) * other for other in taken)
                h, kept = d @ _solved(A, d), np.longdouble(forgetting) ** (gather + p)
                if h > 0.01 * (1 - kept):
                    X, taken = _solved(A, b), [*taken, d * np.sqrt(kept / h)]
                    A = A - (1 - kept) / h * np.outer(d, d)
                    b = A @ X
            k += 1
        rss, count = forgetting * rss + float(left), forgetting * count + 1
    if A is not None:
        L = _factor(A)
        R = np.c_[L.T, _forward(L, b)].astype(float)
    R = R[:p] * np.where(np.diag(R[:p]) < 0, -1.0, 1.0)[:, None]
    return SimpleNamespace(R=R[:, :p], z=R[:, p], rss=rss, count=count)


def _factor(A):
    """L of A = L L' (Cholesky), in the precision of A."""
    L = np.zeros_like(A)
    for j in range(len(A)):
        rest = A[j:, j] - L[j:, :j] @ L[j, :j]
        L[j:, j] = rest / np.sqrt(rest[0])
    return L


def _forward(L, b):
    x = b.copy()
    for i in range(len(b)):
        x[i] = (x[i] - L[i, :i] @ x[:i]) / L[i, i]
    return x


def _solved(A, b):
    """A^-1 b, in the precision of A."""
    L = _factor(A)
    return _forward(L.T[::-1, ::-1], _forward(L, b)[::-1])[::-1]


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


def share(mode, window, count, forgetting, p):
    """Weight of the past per equation, where a sample forgets so much, and 4 p equations stay."""
    length = {"start": count, "sliding": (window + 1) // 2}.get(mode, window)
    return max(forgetting ** (length / count), 1 - 1 / (4 * p))
