"""Long logs are read segment by segment: by whom changes nothing of the estimate."""

from __future__ import annotations

import pickle
import re
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from support_streams import FRICTION, motion, parquet, robot

import symgen
from symgen.data import long_logs

slow = partial(pytest.param, marks=pytest.mark.slow)
#: Of samples, for these tests.
LIMIT = 900


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two logs of 50 and 40 s."""
    folder = tmp_path_factory.mktemp("logs")
    parquet(folder / "a.parquet", motion(5000, 1))
    parquet(folder / "b.parquet", motion(4000, 2), rows=100_000)
    return folder


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Logs of some thousand samples are long ones."""
    monkeypatch.setattr(long_logs, "LIMIT", LIMIT)


def same(a: symgen.Estimate, b: symgen.Estimate) -> None:
    """The edges of segments of 20 s leave out a thirtieth of the rows."""
    std = np.array([p.std for p in a.parameters])
    assert np.abs((a.X - b.X) / std).max() < 0.4
    assert [p.std for p in b.parameters] == pytest.approx(std, rel=0.1)
    for key in ("train", "validation", "torque_train", "torque_validation"):
        assert getattr(b, key).relative == pytest.approx(getattr(a, key).relative, rel=0.05)
    assert (a.band, a.verdict, a.repairs) == (b.band, b.verdict, b.repairs)


@pytest.mark.parametrize("model", ["momentum", slow("torque")])
def test_segments_give_the_estimate_of_the_whole(logs: Path, monkeypatch, model: str) -> None:
    files = sorted(logs.glob("*.parquet"))
    whole = symgen.identify(robot(), files, model=model, window=0.3)
    monkeypatch.setattr(long_logs, "LIMIT", 2048)
    same(whole, symgen.identify(robot(), str(logs / "*.parquet"), model=model, window=0.3))


def test_above_and_below_the_limit_the_same_part_is_held_out(logs: Path, monkeypatch) -> None:
    below = symgen.identify(robot(), logs / "a.parquet")
    monkeypatch.setattr(long_logs, "LIMIT", 4999)
    above = symgen.identify(robot(), logs / "a.parquet")
    diagnosis = symgen.diagnose(robot(), logs / "a.parquet", effects=[])
    assert above.band == below.band
    assert np.abs((above.X - below.X) / [p.std for p in below.parameters]).max() < 0.1
    assert above.torque_validation is not None
    assert diagnosis.before.total == pytest.approx(above.torque_validation.relative, rel=1e-9)


def test_derived_speeds_and_a_robot_that_is_possible(logs: Path, tmp_path: Path, monkeypatch):
    columns = motion(4000, 5)
    columns["tau1"] = columns["tau1"] - (FRICTION + 0.02) * columns["qd1"]
    for name in ("qd1", "qd2"):
        del columns[name]
    train = parquet(tmp_path / "derived.parquet", columns)
    given = {"model": "momentum", "cutoff": 8.0, "validation": logs / "b.parquet"}
    whole = symgen.identify(robot(), train, **given)
    monkeypatch.setattr(long_logs, "LIMIT", 2048)
    part = symgen.identify(robot(), train, **given)
    assert whole.method == part.method == "consistent"
    assert np.abs((whole.X - part.X) / [p.std for p in whole.parameters]).max() < 0.4


@contextmanager
def dask_executor(processes: bool):
    library = pytest.importorskip("distributed")
    about = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    about["processes"] = processes
    with library.LocalCluster(**about) as cluster, library.Client(cluster) as client:
        yield client.get_executor()


@pytest.mark.usefixtures("short")
@pytest.mark.filterwarnings("default")  # of Dask's own
@pytest.mark.parametrize("kind", [slow("dask"), slow("spawn"), slow("dask processes")])
def test_any_executor_gives_the_estimate_of_threads(logs: Path, kind: str) -> None:
    given = {"model": "momentum", "cutoff": 5.0}
    alone = symgen.identify(robot(), str(logs), executor=ThreadPoolExecutor(1), **given)
    threads = symgen.identify(robot(), str(logs), **given)
    opened = {
        "spawn": partial(ProcessPoolExecutor, 2, get_context("spawn")),
        "dask": partial(dask_executor, False),
        "dask processes": partial(dask_executor, True),
    }
    sent: list[int] = []
    with opened[kind]() as executor:
        submit = executor.submit

        def counted(function, item):
            sent.append(len(pickle.dumps(item)))
            return submit(function, item)

        executor.submit = counted
        assert isinstance(executor, Executor)
        spread = symgen.identify(robot(), str(logs), executor=executor, **given)
    assert len(sent) > 10
    assert max(sent) < 2000  # the address of a segment
    assert alone.X.tobytes() == threads.X.tobytes() == spread.X.tobytes()


@pytest.mark.usefixtures("short")
def test_a_gap_in_time_makes_two_logs(tmp_path: Path) -> None:
    first, second = motion(3000, 1), motion(3000, 2, start=1000.0)
    both = {name: np.concatenate([first[name], second[name]]) for name in first}
    gap = symgen.identify(robot(), parquet(tmp_path / "gap.parquet", both), model="momentum")
    two = [parquet(tmp_path / f"{k}.parquet", c) for k, c in enumerate((first, second))]
    apart = symgen.identify(robot(), two, model="momentum")
    assert pytest.approx(apart.X, rel=1e-9) == gap.X


def test_files_of_every_kind_and_at_a_url(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(long_logs, "LIMIT", 5000)  # one segment a file, also of a CSV
    memory = pytest.importorskip("fsspec").filesystem("memory")
    columns = motion(3000, 3)
    table = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "a.csv", table, "%.17g", ",", header=",".join(columns), comments="")
    arrays = {role: np.column_stack([columns[f"{role}{j}"] for j in (1, 2)])
              for role in ("q", "qd", "tau")}  # fmt: skip
    np.savez(tmp_path / "b.npz", t=columns["t"] + 100, **arrays)
    mixed = symgen.identify(robot(), str(tmp_path), model="momentum")
    for name, start in (("c", 0.0), ("d", 100.0)):
        file = parquet(tmp_path / "one.parquet", {**columns, "t": columns["t"] + start})
        memory.pipe(f"/segments/{name}.parquet", file.read_bytes())
    remote = symgen.identify(robot(), "memory://segments/*.parquet", model="momentum")
    assert pytest.approx(mixed.X, rel=1e-9) == remote.X


@pytest.mark.usefixtures("short")
def test_rows_of_an_npz_give_the_estimate_of_a_parquet(tmp_path: Path) -> None:
    columns = motion(3000, 3)
    arrays = {role: np.column_stack([columns[f"{role}{j}"] for j in (1, 2)])
              for role in ("q", "qd", "tau")}  # fmt: skip
    columnwise = {role: np.asfortranarray(x) for role, x in arrays.items()}
    np.savez(tmp_path / "rows.npz", t=columns["t"], **arrays)
    np.savez_compressed(tmp_path / "packed.npz", t=columns["t"], **columnwise)
    parquet(tmp_path / "a.parquet", columns)
    rows = symgen.identify(robot(), tmp_path / "a.parquet", model="momentum")
    for name in ("rows.npz", "packed.npz"):
        estimate = symgen.identify(robot(), tmp_path / name, model="momentum")
        np.testing.assert_array_equal(estimate.X, rows.X)
        assert estimate.notes == rows.notes  # it is not read completely


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize(
    ("source", "given", "said"),
    [
        ("a.parquet", {"method": "huber"}, ["huber", "wls", "ols", "consistent"]),
        ("none*.parquet", {}, ["none*.parquet", "Parquet"]),
        ("s4://bucket/log.parquet", {}, ["s4://bucket/log.parquet", "s3"]),
        ("a.parquet", {"validation": "a.parquet"}, ["a.parquet"]),
        ("bad.parquet", {"cutoff": 5.0}, ["bad.parquet", "q2", "7.77"]),
        ("back.parquet", {}, ["back.parquet", "column t", "1500"]),
    ],
)
def test_what_is_refused_is_named(tmp_path: Path, source, given, said) -> None:
    columns = {"a": motion(2000), "bad": motion(2000), "back": motion(2000)}
    columns["bad"]["q2"][777], columns["back"]["t"][1500] = np.inf, 0.0
    for name, own in columns.items():
        parquet(tmp_path / f"{name}.parquet", own)
    given = {key: str(tmp_path / x) if key == "validation" else x for key, x in given.items()}
    name = source if "://" in source else str(tmp_path / source)
    with pytest.raises(symgen.SymgenError, match=re.escape(said[0])) as refused:
        symgen.identify(robot(), name, **{"model": "momentum", **given})
    assert all(word in str(refused.value) for word in said)
