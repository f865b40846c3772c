"""Temperatures and positions of links: read alike from every format, NaN on joints without."""

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
        columns = table(temp2=WARM, qs1=LINK, temp9=WARM)
    log = read_log(written(tmp_path / f"log{suffix}", columns))
    assert log.temp is not None
    assert log.qs is not None
    np.testing.assert_allclose(log.temp[:, 1], WARM, rtol=1e-15)
    np.testing.assert_allclose(log.qs[:, 0], LINK, rtol=1e-15)
    assert np.isnan(log.temp[:, [0, 2]]).all()
    assert np.isnan(log.qs[:, 1:]).all()
    assert ("temp9" in log.ignored) == (suffix != ".npz")


def test_slow_channels_with_empty_cells_lie_on_straight_lines(tmp_path) -> None:
    slow = np.where(np.arange(len(T)) % 7 == 3, WARM, np.nan)
    log = read_log(written(tmp_path / "log.parquet", table(temp2=slow)))
    assert log.temp is not None
    np.testing.assert_allclose(log.temp[3:-1, 1], WARM[3:-1], atol=0.05)
    assert (log.temp[:3, 1] == WARM[3]).all()


def test_an_empty_log_of_temperatures_has_none() -> None:
    log = make_log("log", T, Q, Q, temp=np.full(Q.shape, np.nan), qs=np.full(Q.shape, np.nan))
    assert log.temp is None
    assert log.qs is None


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ({"temp": np.where(Q > 0.9, np.inf, Q)}, "temp"),
        ({"qs": np.where(Q > 0.9, np.nan, Q)}, "qs"),
        ({"temp": Q[:, :2]}, "columns of q: 3, of temp: 2"),
    ],
)
def test_what_is_broken_is_refused(fault, said) -> None:
    with pytest.raises(LogError, match=said):
        make_log("log", T, Q, Q, **fault)


def test_they_follow_rows_that_are_cut_dropped_or_resampled() -> None:
    temp = np.column_stack([WARM, np.full(len(T), np.nan), WARM])
    qs = np.column_stack([LINK, np.full(len(T), np.nan), LINK])
    log = make_log("log", T, Q, Q, temp=temp, qs=qs)
    part = cut(log, 0.1, 0.4)
    np.testing.assert_array_equal(part.temp[:, 0], WARM[10:41])
    np.testing.assert_array_equal(part.qs[:, 0], LINK[10:41])

    rows = np.sort(np.concatenate([np.arange(60), [7, 18, 31, 40, 52]]))
    t = np.arange(len(rows)) * 0.01
    repeated = make_log("log", t, Q[rows], Q[rows], temp=temp[rows], qs=qs[rows])
    mended, _ = repaired(repeated, (0, 0, 0))
    np.testing.assert_array_equal(mended.temp[:, 2], WARM)
    np.testing.assert_array_equal(mended.qs[:, 2], LINK)

    missing = np.delete(np.arange(60), [12, 33, 50])
    samples = sampled(
        make_log("log", T[missing], Q[missing], Q[missing], temp=temp[missing], qs=qs[missing])
    )
    np.testing.assert_allclose(samples.temp[:, 0], 30 + 5 * samples.t, atol=1e-9)
    np.testing.assert_allclose(samples.qs[:, 0], LINK, atol=1e-7)
    assert np.isnan(samples.temp[:, 1]).all()
    half = samples.cut(slice(20, 40))
    np.testing.assert_array_equal(half.temp, samples.temp[20:40])
