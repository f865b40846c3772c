"""Elimination modulo a prime: the reduced form that Python's integers give."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.symbolic.modular import primes, reduce_rows

P = next(primes(48))


def plain(matrix: list[list[int]]) -> tuple[list[int], list[list[int]]]:
    """Gauss-Jordan of Python's integers, one pivot at a time."""
    rows, pivots = [list(row) for row in matrix], []
    for column in range(len(matrix[0])):
        place = len(pivots)
        found = next((r for r in range(place, len(rows)) if rows[r][column]), None)
        if found is None:
            continue
        rows[place], rows[found] = rows[found], rows[place]
        inverse = pow(rows[place][column], -1, P)
        rows[place] = [v * inverse % P for v in rows[place]]
        for r in range(len(rows)):
            if r != place and rows[r][column]:
                factor = rows[r][column]
                rows[r] = [(v - factor * w) % P for v, w in zip(rows[r], rows[place], strict=True)]
        pivots.append(column)
    return pivots, rows[: len(pivots)]


@pytest.mark.parametrize(
    ("rows", "columns", "rank"),
    [(1, 1, 1), (4, 7, 2), (70, 31, 31), (70, 65, 33), (33, 97, 33), (90, 80, 5), (40, 40, 0)],
)
def test_rows_reduce_as_those_of_plain_integers_do(rows, columns, rank):
    draw = np.random.default_rng(rows * columns + rank)
    left, right = draw.integers(0, P, (rows, rank)), draw.integers(0, P, (rank, columns))
    product = left.astype(object) @ right.astype(object) if rank else 0
    matrix = np.array(product + np.zeros((rows, columns), dtype=object)) % P
    if columns > 10:
        matrix[:, 3] = 0
        matrix[:, 8] = matrix[:, 1]
    pivots, reduced = reduce_rows(matrix.astype(np.int64), P)
    expected_pivots, expected = plain(matrix.tolist())
    assert pivots == expected_pivots
    assert reduced.tolist() == expected


def test_products_of_the_largest_residues_are_exact():
    """One bit more would be lost in 64 bits."""
    matrix = np.full((64, 64), P - 1, dtype=np.int64)
    matrix[np.tril_indices(64, -1)] = P - 2
    pivots, reduced = reduce_rows(matrix, P)
    expected_pivots, expected = plain(matrix.tolist())
    assert pivots == expected_pivots
    assert reduced.tolist() == expected
