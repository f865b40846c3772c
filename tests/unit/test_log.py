"""Logs are read alike from every format, kept as recorded, and cannot be changed afterwards."""

import csv
from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.data.log import Log, make_log, read_log
from symgen.data.raw import Reading

N, JOINTS = 40, 2
T = np.arange(N) * 0.01
Q = np.column_stack([np.sin(3 * T), np.cos(2 * T)])
QD = np.column_stack([3 * np.cos(3 * T), -2 * np.sin(2 * T)])
TAU = np.column_stack([5 * np.cos(T), T - 1.0])


def table(with_qd: bool = True) -> dict[str, np.ndarray]:
    columns = {"t": T}
    for role, array in (("q", Q), ("qd", QD), ("tau", TAU)):
        if role != "qd" or with_qd:
            columns |= {f"{role}{j + 1}": array[:, j] for j in range(JOINTS)}
    return columns


def write_csv(path: Path, columns: dict[str, np.ndarray], bom: bool = False) -> Path:
    with path.open("w", encoding="utf-8-sig" if bom else "utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return path


def write_parquet(path: Path, columns: dict[str, np.ndarray]) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(columns), path)
    return path


def assert_holds(log: Log, qd: np.ndarray | None = QD) -> None:
    np.testing.assert_array_equal(log.t, T)
    np.testing.assert_array_equal(log.q, Q)
    np.testing.assert_array_equal(log.tau, TAU)
    if qd is None:
        assert log.qd is None
    else:
        np.testing.assert_array_equal(log.qd, qd)


@pytest.mark.parametrize("with_qd", [True, False])
def test_csv_parquet_and_npz_give_the_same_log_to_the_last_bit(tmp_path, with_qd):
    qd = {"qd": QD} if with_qd else {}
    write_csv(tmp_path / "a.csv", table(with_qd))
    write_parquet(tmp_path / "a.parquet", table(with_qd))
    np.savez(tmp_path / "a.npz", t=T, q=Q, tau=TAU, **qd)
    for name in ("a.csv", "a.parquet", "a.npz"):
        log = read_log(tmp_path / name, JOINTS)
        assert log.name == name
        assert_holds(log, QD if with_qd else None)


def test_other_columns_are_kept_apart_even_when_they_hold_text(tmp_path):
    columns = {"mode": np.array(["auto"] * N), **table(), "i1": T, "temperature": T}
    columns["temperature"] = np.full(N, np.nan)
    for path in (
        write_csv(tmp_path / "a.csv", columns),
        write_parquet(tmp_path / "a.parquet", columns),
    ):
        log = read_log(path)
        assert log.ignored == ("mode", "i1", "temperature")
        assert_holds(log)
    np.savez(tmp_path / "a.npz", t=T, q=Q, tau=TAU, mode=np.array(["auto"]))
    assert read_log(tmp_path / "a.npz").ignored == ("mode",)


def test_a_column_that_another_takes_the_name_of_is_ignored(tmp_path):
    path = write_csv(tmp_path / "a.csv", {**table(), "better": 2 * Q[:, 0]})
    log = read_log(path, reading=Reading(columns={"q1": "better"}))
    np.testing.assert_array_equal(log.q, np.column_stack([2 * Q[:, 0], Q[:, 1]]))
    assert log.ignored == ("q1",)
    np.savez(tmp_path / "a.npz", time=T, angle=Q, qd=QD, tau=TAU)
    reading = Reading(columns={"t": "time", "q": "angle"})
    assert_holds(read_log(tmp_path / "a.npz", reading=reading))


def test_blanks_in_the_header_a_byte_order_mark_and_blank_lines_are_tolerated(tmp_path):
    plain = write_csv(tmp_path / "a.csv", table(), bom=True)
    text = plain.read_text(encoding="utf-8")
    assert text.startswith("\ufefft,")
    plain.write_text("\ufeff\n" + text[1:].replace(",", " , ", 12) + "\n", encoding="utf-8")
    assert_holds(read_log(plain))
    padded = {f" {name} ": values for name, values in table().items()}
    assert_holds(read_log(write_parquet(tmp_path / "a.parquet", padded)))


@pytest.mark.parametrize("dtype", ["int8", "uint16", "int64", "float16", "float32", "longdouble"])
def test_npz_takes_any_float_or_integer_type(tmp_path, dtype):
    whole = np.arange(20).astype(dtype)
    np.savez(tmp_path / "a.npz", t=whole, q=whole[:, None], tau=whole)
    log = read_log(tmp_path / "a.npz", 1)
    assert log.q.dtype == np.float64
    np.testing.assert_array_equal(log.tau[:, 0], np.arange(20.0))


def test_a_single_joint_may_come_as_vectors():
    log = make_log("one", T, Q[:, 0], TAU[:, 0], QD[:, 0], n=1)
    assert log.q.shape == log.tau.shape == (N, 1)
    assert log.qd is not None
    assert log.qd.shape == (N, 1)


def test_arrays_are_contiguous_read_only_copies():
    q = np.asfortranarray(Q)
    log = make_log("copy", T, q, TAU, QD)
    assert log.qd is not None
    for array in (log.t, log.q, log.qd, log.tau):
        assert array.flags.c_contiguous
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    q[0, 0] = 99.0
    assert log.q[0, 0] == Q[0, 0]
    with pytest.raises(FrozenInstanceError):
        log.name = "other"


@given(
    span=st.floats(51.0, 1e4),
    ratio=st.sampled_from([180 / np.pi, np.pi / 180]),
    j=st.integers(0, 1),
)
@settings(max_examples=30, deadline=None)
def test_a_prismatic_joint_is_never_taken_for_degrees(span, ratio, j):
    q, qd = Q.copy(), QD.copy()
    q[:, j] = np.linspace(0, span, N)
    qd[:, j] = span / (N - 1) / 0.01 * ratio
    sigma = [0, 0]
    sigma[j] = 1
    assert make_log("metres", T, q, TAU, qd, sigma=sigma).q.shape == (N, JOINTS)
