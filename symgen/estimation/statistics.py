"""Tails of distributions, for tests."""

from __future__ import annotations


def f_tail(statistic: float, numerator: float, denominator: float) -> float:
    """Return the probability that F(numerator, denominator) is above a value."""
    from scipy.special import fdtrc

    return float(fdtrc(numerator, denominator, max(statistic, 0.0)))


def chi2_tail(statistic: float, degrees: int) -> float:
    """Return the probability that chi-square of so many degrees of freedom is above a value."""
    from scipy.special import chdtrc

    return float(chdtrc(degrees, max(statistic, 0.0)))


def student_quantile(tail: float, degrees: int) -> float:
    """Return what Student's t of so many degrees of freedom exceeds with a probability."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees, 1 - tail))


def binomial_tail(count: int, trials: int, chance: float) -> float:
    """Return the probability of so many hits or more in some trials of a chance."""
    from scipy.special import bdtrc

    return 1.0 if count <= 0 else float(bdtrc(count - 1, trials, chance))
