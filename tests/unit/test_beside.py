"""Positions of links: read alike from every format, NaN on joints without."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.data.log import cut, make_log, read_log
from symgen.data.signals import sampled
from symgen.errors import LogError
from symgen.faults.samples import repaired

T = np.arange(60) * 0.01
Q = np.column_stack([np.sin(3 * T), np.cos(2 * T), np.sin(T)])
WARM = 30 + 5 * T
LINK = Q[:, 0] - 0.001 * np.cos(3 * T)


def table(**more: np.ndarray) -> dict[str, np.ndarray]:
    columns = {"t": T}
    for role, array in (("q", Q), ("tau", 2 * Q)):
        columns |= {f"{role}{j + 1}": array[:, j] for j in range(3)}
    return columns | more


def written(path, columns):
    import pyarrow as pa
    import pyarrow.csv as pacsv
    import pyarrow.parquet as pq

    if path.suffix == ".npz":
        np.savez(path, t=T, q=Q, tau=2 * Q, **columns)
    else:
        kind = pq.write_table if path.suffix == ".parquet" else pacsv.write_csv
        kind(pa.table(columns), str(path))
    return path


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".npz"])
def test_joints_without_have_none(tmp_path, suffix) -> None:
    nothing = np.full(len(T), np.nan)
    if suffix == ".npz":
        columns = {
            "temp": np.column_stack([nothing, WARM, nothing]),
            "qs": np.column_stack([LINK, nothing, nothing]),
        }
    else:
        columns = table(temp2=WARM, qs1=LINK, qs9=LINK)
    log = read_log(written(tmp_path / f"log{suffix}", columns))
    assert log.qs is not None
    np.testing.assert_allclose(log.qs[:, 0], LINK, rtol=1e-15)
    assert np.isnan(log.qs[:, 1:]).all()
    np.testing.assert_allclose(log.tau, 2 * Q, rtol=1e-15)
    assert log.ignored == (("temp",) if suffix == ".npz" else ("temp2", "qs9"))


def test_a_log_with_empty_columns_has_none() -> None:
    log = make_log("log", T, Q, Q, qs=np.full(Q.shape, np.nan))
    assert log.qs is None


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ({"qs": np.where(Q > 0.9, np.inf, Q)}, "qs"),
        ({"qs": np.where(Q > 0.9, np.nan, Q)}, "qs"),
        ({"qs": Q[:, :2]}, "columns of q: 3, of qs: 2"),
    ],
)
def test_what_is_broken_is_refused(fault, said) -> None:
    with pytest.raises(LogError, match=said):
        make_log("log", T, Q, Q, **fault)


def test_they_follow_rows_that_are_cut_dropped_or_resampled() -> None:
    qs = np.column_stack([LINK, np.full(len(T), np.nan), LINK])
    log = make_log("log", T, Q, Q, qs=qs)
    part = cut(log, 0.1, 0.4)
    np.testing.assert_array_equal(part.qs[:, 0], LINK[10:41])

    rows = np.sort(np.concatenate([np.arange(60), [7, 18, 31, 40, 52]]))
    t = np.arange(len(rows)) * 0.01
    repeated = make_log("log", t, Q[rows], Q[rows], qs=qs[rows])
    mended, _ = repaired(repeated, (0, 0, 0))
    np.testing.assert_array_equal(mended.qs[:, 2], LINK)

    missing = np.delete(np.arange(60), [12, 33, 50])
    samples = sampled(make_log("log", T[missing], Q[missing], Q[missing], qs=qs[missing]))
    np.testing.assert_allclose(samples.qs[:, 0], LINK, atol=1e-7)
    assert np.isnan(samples.qs[:, 1]).all()
    half = samples.cut(slice(20, 40))
    np.testing.assert_array_equal(half.qs, samples.qs[20:40])
