"""Is a residual white? Lag correlations with their band, and one test of all of them.

A residual that is correlated in time holds motion that the model does not explain. Rows that share
a window, or what a filter spreads, are correlated by construction: only rows further apart count.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.statistics import chi2_tail
from symgen.estimation.values import Trace, Whiteness

FloatArray = NDArray[np.float64]
#: Most lags that are looked at, fewest, and rows that each needs.
LAGS, _LEAST, _ROWS = 20, 3, 5
#: Probability from which a residual is called correlated.
LEVEL = 0.01
_NORMAL = 1.959963984540054


def whiteness(traces: Sequence[Trace]) -> tuple[Whiteness, ...]:
    """Test the residuals of traces, logs of one kind together; short ones are left out.

    Args:
        traces: of any quantities and kinds; those with no spacing are left out.
    """
    groups: dict[tuple[str, str], list[Trace]] = {}
    for trace in (t for t in traces if t.spacing > 0 and len(t.t) > 1):
        groups.setdefault((trace.quantity, trace.kind), []).append(trace)
    out = []
    for (quantity, kind), members in groups.items():
        steps = [t.spacing * float(np.median(np.diff(t.t))) for t in members]
        pieces = [piece for t in members for piece in _pieces(t)]
        for component in range(members[0].measured.shape[1]):
            series = [piece[:, component] for piece in pieces]
            rows = sum(map(len, series))
            lags = min(LAGS, rows // _ROWS)
            if lags < _LEAST or not any(np.ptp(e) > 0 for e in series):
                continue
            r, deviation = lag_correlations(series, lags)
            statistic = float(np.sum((r / deviation) ** 2))
            out.append(
                Whiteness(
                    quantity,
                    component,
                    kind,
                    rows,
                    float(np.median(steps)),
                    tuple(map(float, r)),
                    tuple(map(float, _NORMAL * deviation)),
                    statistic,
                    chi2_tail(statistic, lags),
                )
            )
    return tuple(out)


def _pieces(trace: Trace) -> list[FloatArray]:
    """Return the residual of a log without its mean, (K, m), in the stretches between pauses."""
    residual = trace.measured - trace.predicted
    step = np.diff(trace.t)
    cuts = np.flatnonzero(step > 1.5 * np.median(step)) + 1
    return [e[:: trace.spacing] for e in np.split(residual - residual.mean(axis=0), cuts)]


def lag_correlations(series: Sequence[FloatArray], lags: int) -> tuple[FloatArray, FloatArray]:
    """Return r_k at lags k = 1 .. `lags` and their standard deviations where there is none.

        r_k = sum e_i e_(i+k) / sum e_i^2,    std_k = sqrt(sum (e_i e_(i+k))^2) / sum e_i^2

    The deviation also holds where the size of the residual changes along the motion, as it does
    with speed (Lobato, Nankervis and Savin 2001); sum (r_k/std_k)^2 is chi-square of `lags` degrees
    of freedom. With a constant size it is the statistic of Ljung and Box (1978).

    Args:
        series: residuals (K,) without their mean, stretch by stretch: no pair spans two.
        lags: how many.
    """
    power = sum(float(e @ e) for e in series)
    r, deviation = np.zeros(lags), np.zeros(lags)
    for k in range(1, lags + 1):
        products = np.concatenate([e[k:] * e[:-k] for e in series])
        r[k - 1] = products.sum() / power
        deviation[k - 1] = np.sqrt(float(products @ products)) / power
    return r, np.maximum(deviation, 1e-300)


def in_words(tested: Whiteness) -> str:
    """Return what a test says."""
    if tested.p_value >= LEVEL:
        return "white: no correlation beyond chance"
    sizes = np.abs(tested.correlations) / np.asarray(tested.bands)
    k = int(np.argmax(np.where(sizes > 1, np.abs(tested.correlations), 0.0)))
    return (
        f"not white: correlated by {tested.correlations[k]:.2f} after "
        f"{(k + 1) * tested.step_s:.2g} s"
    )
