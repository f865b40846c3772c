"""Tails of distributions, for tests."""

from __future__ import annotations


def f_tail(statistic: float, numerator: float, denominator: float) -> float:
    """Return the probability that F(numerator, denominator) is above a value."""
    from scipy.special import fdtrc

    return float(fdtrc(numerator, denominator, max(statistic, 0.0)))
