"""What a gap depends on where no known law has its shape: free functions of one or two variables.

A polynomial of position, speed and load of a joint, or of two joints' positions and speeds, says of
what a torque is a function, and not which one. It competes by the score that effects compete by,
and nothing is added to a robot for it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.effects import Score
from symgen.diagnosis.whitened_system import compared
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray

_DEGREE = 4  # of a polynomial, in all its variables
_HALF = 0.5  # of what is left of a joint's square: as much explains where a gap comes from
_SURE = math.log(9.0)
_VARIABLES = ("the position of joint {0}", "the speed of joint {0}", "the load of joint {0}")


def free_functions(
    baseline: Baseline, accepted: Sequence[Score], least: float, misfit: float
) -> tuple[str, ...]:
    """Say of what the torque is a function that a model with its effects misses, joint by joint.

    Args:
        baseline: the model as it is declared, and its training logs.
        accepted: the effects that were found.
        least: part of a joint's torque that matters.
        misfit: part of a joint's torque that no model is righter than.
    """
    base = baseline.base
    score = baseline.score(baseline.beside(accepted), misfit)
    alone, out = score.alone, []
    states = _states(baseline)
    columns: dict[tuple[int, ...], FloatArray] = {}
    for j in map(int, np.flatnonzero(np.sqrt(alone.left) > least * base.size)):
        tried = []
        for variables in _sets(baseline.robot.n, j):
            if variables not in columns:
                columns[variables] = _polynomials(base.logs, states, variables)
            tried.append((score.beside({j: columns[variables]}), variables))
        best, variables = max(tried, key=lambda found: found[0].score)
        sure = best.score - alone.score > _SURE + math.log(len(tried))
        if sure and best.left[j] < _HALF * alone.left[j]:
            joints = baseline.robot.movable
            names = [
                _VARIABLES[v // len(joints)].format(joints[v % len(joints)].number)
                for v in variables
            ]
            before, after = (
                100 * math.sqrt(x) / base.size[j] for x in (alone.left[j], best.left[j])
            )
            out.append(
                f"the torque that joint {joints[j].number} misses depends on {' and '.join(names)}:"
                f" a free function leaves {after:.2g} % in place of {before:.2g} %; no known law "
                "has this shape"
            )
    return tuple(out)


def _sets(n: int, j: int) -> Iterator[tuple[int, ...]]:
    """Yield what a torque on joint j may be a function of: numbers of q, then qd, then the load."""
    own = (j, n + j, 2 * n + j)
    yield from ((v,) for v in own)
    yield from itertools.combinations(own, 2)
    for k in range(2 * n):
        if k % n != j:
            yield from ((v, k) for v in own[:2])


def _states(baseline: Baseline) -> list[FloatArray]:
    """Return q, qd and the load of all joints along each training log, thinned, (N, 3 n)."""
    logs = [log.thinned for log in baseline.base.logs]
    along = baseline.torques(baseline.base)
    return [np.hstack([s.q, s.qd, t.load]) for s, t in zip(logs, along, strict=True)]


def _polynomials(
    logs: Sequence[FilteredLog], states: Sequence[FloatArray], variables: Sequence[int]
) -> FloatArray:
    """Return Legendre polynomials of some variables in the band, (K, m), without the constant."""
    legendre = np.polynomial.legendre.legvander
    parts = [part[:, list(variables)] for part in states]
    whole = np.concatenate(parts)
    low, high = whole.min(axis=0), whole.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    powers = [
        p for p in itertools.product(range(_DEGREE + 1), repeat=len(variables))
        if 0 < sum(p) <= _DEGREE
    ]  # fmt: skip
    out = []
    for log, part in zip(logs, parts, strict=True):
        x = 2 * (part - low) / span - 1
        values: list[FloatArray] = [legendre(column, _DEGREE) for column in x.T]
        products = [
            math.prod((v[:, k] for v, k in zip(values, p, strict=True)), start=np.ones(len(x)))
            for p in powers
        ]
        out.append(compared(log, np.stack(products, axis=1)))
    return np.concatenate(out)
