"""Check of the exact base parameters in floating point.

Exact arithmetic modulo a prime is right if the code maps the geometry into it consistently. This
check does not share that code. It evaluates the columns in double precision at the values of the
file. The kept columns must be independent, and every regrouping must reproduce its column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symgen.errors import SymgenError
from symgen.symbolic.elimination import ExactRow
from symgen.symbolic.energy import StateColumns
from symgen.symbolic.sampling import FUNCTIONS
from symgen.symbolic.tape import DrawnNumbers

_MARGIN = 10
#: Singular values of the scaled kept columns below this count as dependent in floats. It is far
#: below those of any useful geometry, and far above rounding.
_DEPENDENT = 1e-13
_ERROR = 1e-6


def require_floats_agree(
    columns: StateColumns, kept: Sequence[int], rows: Mapping[str, ExactRow]
) -> None:
    """Raise SymgenError if double precision contradicts the exact base parameters.

    Args:
        columns: the columns that are functions of the state.
        kept: positions of the base parameters among them.
        rows: the relations of the other parameters.
    """
    values, parameters = columns.robot.values(), columns.parameters
    arithmetic = DrawnNumbers(values, FUNCTIONS)
    W = columns.differences(arithmetic, len(parameters) + _MARGIN).astype(float)
    place = {p.name: i for i, p in enumerate(parameters)}
    relations = np.zeros((len(rows), len(parameters)))
    for k, row in enumerate(rows.values()):
        for name, c in row.items():
            relations[k, place[name]] = float(c.value.subs(values))
    size = np.abs(W).max(axis=0, initial=0.0)
    least = max(1.0, float(size.max(initial=0.0)))
    scale = np.maximum(least, (np.abs(relations) * size).max(axis=1, initial=0.0))
    held = np.abs(W @ relations.T).max(axis=0, initial=0.0) <= _ERROR * scale
    for name, holds in zip(rows, held, strict=True):
        if not holds:
            raise SymgenError(f"the regrouping of {name} contradicts its column in numbers")
    K = W[:, list(kept)]
    norms = np.linalg.norm(K, axis=0)
    singular = np.linalg.svd(K / np.where(norms > 0, norms, 1.0), compute_uv=False)
    if len(singular) and singular[-1] < _DEPENDENT * singular[0]:
        raise SymgenError(
            f"the {len(singular)} base parameters are independent, but not in double precision: "
            f"singular values range over {singular[0] / max(singular[-1], 1e-300):.0e}; "
            "accepted: lengths, and factors of 'follows', of like size"
        )
