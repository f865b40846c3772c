"""What some joints' logs have beside the motion: temperatures, and positions of links.

temp (N, n) in deg C changes slowly: what was not read anew lies on straight lines, and nothing is
ever differentiated. qs (N, n), of a second encoder behind what bends in the joint, is a position
as q is. Joints without have NaN.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen.data.raw import NUMBERED, FloatArray, read_only, refuse
from symgen.data.spline import interpolated


def spread(found: FloatArray | None, names: Sequence[str], joints: int) -> FloatArray | None:
    """Put columns of some joints, (N, k) named temp2.., at their places: NaN on the others.

    Args:
        found: the columns, None for none.
        names: theirs.
        joints: of the log.
    """
    if found is None or not names:
        return None
    out = np.full((len(found), joints), np.nan)
    for column, name in zip(found.T, names, strict=True):
        match = NUMBERED.fullmatch(name)
        assert match is not None  # the columns were chosen by it
        out[:, int(match[2]) - 1] = column
    return out


def temperatures(file: str, t: FloatArray, temp: FloatArray) -> FloatArray | None:
    """Fill what was not read anew with straight lines; None where no joint has a temperature.

    Raises:
        LogError: a value is not finite.
    """
    out = np.array(temp)
    for j, column in enumerate(temp.T):
        known = ~np.isnan(column)
        _require_finite(file, f"temp{j + 1}", column[known], "deg C, or empty cells")
        if known.any():
            out[:, j] = np.interp(t, t[known], column[known])
    return read_only(out) if np.isfinite(out).any() else None


def links(file: str, qs: FloatArray) -> FloatArray | None:
    """Require positions that are whole, on the joints that have any; None where none has.

    Raises:
        LogError: a value is missing or not finite.
    """
    for j, column in enumerate(qs.T):
        if not np.isnan(column).all():
            _require_finite(file, f"qs{j + 1}", column, "rad (m) in every sample")
    return qs if np.isfinite(qs).any() else None


def _require_finite(file: str, name: str, column: FloatArray, accepted: str) -> None:
    bad = np.flatnonzero(~np.isfinite(column))
    if len(bad):
        refuse(file, f"column {name}: {len(bad)} values are missing or not finite", accepted)


def temperatures_at(log_t: FloatArray, temp: FloatArray | None, t: FloatArray) -> FloatArray | None:
    """Return temperatures (N, n) at other times, on straight lines."""
    if temp is None or _same(log_t, t):
        return temp
    return read_only(np.column_stack([np.interp(t, log_t, column) for column in temp.T]))


def links_at(log_t: FloatArray, qs: FloatArray | None, t: FloatArray) -> FloatArray | None:
    """Return positions of links (N, n) at other times, on a cubic spline."""
    if qs is None or _same(log_t, t):
        return qs
    out = np.full((len(t), qs.shape[1]), np.nan)
    known = np.isfinite(qs).all(axis=0)
    out[:, known] = interpolated(log_t, qs[:, known])(t)
    return read_only(out)


def _same(a: FloatArray, b: FloatArray) -> bool:
    return len(a) == len(b) and np.array_equal(a, b)
