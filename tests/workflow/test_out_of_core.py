"""A data set that is read chunk by chunk gives what the same logs give in memory."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support import sampled
from support_streams import FRICTION, X, motion, parquet, robot

import symgen
from symgen import distributed
from symgen.data.dataset import DataSet, listed_files
from symgen.data.tables import ColumnTable, StoredArray
from symgen.estimation import chunks
from symgen.identification import out_of_core
from symgen.identification.out_of_core import is_long
from symgen.robot.toml_text import robot_toml

#: Own rows of a chunk and of a partition: many of both in a log of some thousand samples.
CHUNK, PARTITION = 900, 1800


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    """A folder of two logs of 50 and 40 s."""
    folder = tmp_path / "logs"
    folder.mkdir()
    parquet(folder / "a.parquet", motion(5000, 1))
    parquet(folder / "b.parquet", motion(4000, 2), rows=100_000)
    return folder


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks so small that these logs have many."""
    cut = partial(chunks.partitions, chunk=CHUNK, most=PARTITION)
    monkeypatch.setattr(out_of_core, "partitions", cut)


def same(a: symgen.Estimate, b: symgen.Estimate, within: float) -> None:
    """Compare all numbers of two estimates."""
    assert a.band == b.band
    assert pytest.approx(a.X, rel=within) == b.X
    # What the model misses is a difference of products, which costs two digits more.
    said = [p.std for p in a.parameters]
    assert [p.std for p in b.parameters] == pytest.approx(said, rel=100 * within)
    for key in ("train", "validation", "torque_train", "torque_validation"):
        one, other = getattr(a, key), getattr(b, key)
        assert other.relative == pytest.approx(one.relative, rel=within)
        assert (other.per_joint or ()) == pytest.approx(one.per_joint or (), rel=within)
    assert b.condition_number == pytest.approx(a.condition_number, rel=within)
    assert np.abs(a.correlation - b.correlation).max() < within
    assert (a.verdict, a.headline, a.repairs) == (b.verdict, b.headline, b.repairs)
    assert a.notes == b.notes


@pytest.mark.parametrize("model", sampled(["momentum", "energy", "torque"], 2))
def test_a_data_set_gives_the_estimate_of_its_logs_in_memory(logs: Path, model: str) -> None:
    files = sorted(logs.glob("*.parquet"))
    memory = symgen.identify(robot(), files, model=model, window=0.3)
    chunks = symgen.identify(robot(), str(logs / "*.parquet"), model=model, window=0.3)
    assert memory.X[:4] == pytest.approx(X, rel=0.02)
    same(memory, chunks, 1e-9)


def test_threads_change_nothing(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for cores in (1, 2, 4):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, n=cores: range(n), raising=False)
        found.append(symgen.identify(robot(), str(logs / "*.parquet"), model="momentum"))
    for other in found[1:]:
        assert other.X.tobytes() == found[0].X.tobytes()
        same(found[0], other, 1e-15)


def test_derived_speeds_masks_and_a_validation_log_too(logs: Path, tmp_path: Path) -> None:
    columns = motion(5000, 5)
    columns["tau1"] = columns["tau1"] - (FRICTION + 0.02) * columns["qd1"]
    for name in ("qd1", "qd2"):
        del columns[name]
    train = parquet(tmp_path / "derived.parquet", columns)
    held = logs / "b.parquet"
    given = {"model": "momentum", "cutoff": 8.0, "validation": [held]}
    workers = symgen.Workers(1)
    memory = symgen.identify(robot(), train, method="ols", **given)
    same(memory, symgen.identify(robot(), train, method="ols", workers=workers, **given), 1e-9)
    # A joint that its friction drives is no robot's: parameters of one come from a conic solver,
    # which ends at a distance in the metric of the covariance.
    memory, chunks = (
        symgen.identify(robot(), train, **given, **more) for more in ({}, {"workers": workers})
    )
    assert memory.method == chunks.method == "consistent"
    assert np.abs((memory.X - chunks.X) / [p.std for p in memory.parameters]).max() < 1e-5
    assert memory.torque_validation.relative == pytest.approx(chunks.torque_validation.relative)


def test_no_window_straddles_a_gap_and_stretches_are_logs(tmp_path: Path) -> None:
    first, second = motion(3000, 1), motion(3000, 2, start=1000.0)
    whole = {name: np.concatenate([first[name], second[name]]) for name in first}
    one = parquet(tmp_path / "gap.parquet", whole)
    two = [parquet(tmp_path / f"{k}.parquet", c) for k, c in enumerate((first, second))]
    apart = symgen.identify(robot(), two, model="momentum")
    gap = symgen.identify(robot(), one, model="momentum", workers=symgen.Workers(1))
    assert pytest.approx(apart.X, rel=1e-9) == gap.X
    assert gap.torque_validation.relative == pytest.approx(apart.torque_validation.relative)
    with pytest.raises(symgen.LogError, match=r"--until 29\.99"):
        symgen.identify(robot(), one, model="momentum")


def test_each_row_is_the_own_of_one_chunk_and_is_decoded_once(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    covers: list[list[chunks.Partition]] = []

    def kept(*given):
        covers.append(chunks.partitions(*given, chunk=CHUNK, most=PARTITION))
        return covers[-1]

    monkeypatch.setattr(out_of_core, "partitions", kept)
    symgen.identify(robot(), str(logs), model="momentum")
    (cover,) = covers
    seen = {name: np.zeros(count, int) for name, count in (("a", 5000), ("b", 4000))}
    for part in cover:
        for c in part.chunks:
            seen[Path(part.file).stem][c.rows[0] + c.own[0] : c.rows[0] + c.own[1]] += 1
    assert all((count == 1).all() for count in seen.values())
    assert len(cover) > 4
    assert max(len(part.chunks) for part in cover) > 1


def test_what_a_run_does_not_need_is_not_imported(logs: Path) -> None:
    """The command with its page, on files read chunk by chunk: seconds of every run."""
    (logs / "robot.toml").write_text(robot_toml(robot()))
    code = (
        "import sys; from symgen.__main__ import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(*sorted(m for m in sys.modules), file=sys.stderr)"
    )
    command = [sys.executable, "-c", code, "identify", str(logs / "robot.toml")]
    command += [str(logs / "*.parquet"), "--model", "momentum", "--into", str(logs / "result")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (logs / "result" / "report.html").exists(), done.stderr
    imported = set(done.stderr.split())
    assert {"numpy", "pyarrow.parquet"} <= imported
    spared = {"pandas", "scipy.stats", "scipy.signal", "scipy.optimize", "casadi", "dask"}
    assert not imported & spared


class BrokenError(Exception):
    """What ends a run in these tests."""


def test_an_interrupted_run_goes_on_from_what_was_finished(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    work, results = tmp_path / "work", distributed.Executor.results
    whole = symgen.identify(robot(), str(logs), model="momentum")

    def breaks(self, task: Callable, items) -> Iterator:
        for k, found in enumerate(results(self, task, items)):
            if k == 2:
                raise BrokenError
            yield found

    monkeypatch.setattr(distributed.Executor, "results", breaks)
    with pytest.raises(BrokenError):
        symgen.identify(robot(), str(logs), model="momentum", workers=symgen.Workers(work=work))
    assert len(list(work.glob("*.npz"))) == 2
    monkeypatch.setattr(distributed.Executor, "results", results)
    said: list[str] = []
    again = symgen.identify(
        robot(),
        str(logs),
        model="momentum",
        workers=symgen.Workers(work=work),
        progress=said.append,
    )
    assert any("samples were finished before" in line for line in said)
    assert any("a second" in line and "s left" in line for line in said)
    assert again.X.tobytes() == whole.X.tobytes()
    # other settings depend on nothing of it
    said.clear()
    symgen.identify(
        robot(),
        str(logs),
        model="momentum",
        window=0.4,
        workers=symgen.Workers(work=work),
        progress=said.append,
    )
    assert not any("finished before" in line for line in said)


def test_a_sample_stands_for_what_is_looked_at_in_memory(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = symgen.identify(robot(), str(logs), model="momentum", cutoff=5.0)
    monkeypatch.setattr(out_of_core, "SAMPLE", 4000)
    monkeypatch.setattr(out_of_core, "HELD_SAMPLE", 1500)
    part = symgen.identify(robot(), str(logs), model="momentum", cutoff=5.0)
    assert any("9,000 samples in 4 parts were folded" in note for note in part.notes)
    if part.band == replace(whole.band):  # the fold is of all samples
        assert pytest.approx(whole.X, rel=1e-9) == part.X
    assert pytest.approx(whole.X, rel=1e-3) == part.X


def test_the_last_pass_goes_on_from_what_the_first_kept(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[int] = []
    rows = ColumnTable.spans

    def counted(self, spans):
        for raw in rows(self, spans):
            read.append(len(raw.arrays["t"]))
            yield raw

    monkeypatch.setattr(ColumnTable, "spans", counted)
    given = {"model": "momentum", "cutoff": 6.0}
    kept = symgen.identify(
        robot(), str(logs), workers=symgen.Workers(work=tmp_path / "work"), **given
    )
    once, files = sum(read), list((tmp_path / "work").glob("*.rows"))
    assert len(files) > 4
    assert sum(f.stat().st_size for f in files) < once * 7 * 8
    read.clear()
    monkeypatch.setattr(out_of_core.Work, "path", lambda *_: None)
    anew = symgen.identify(robot(), str(logs), **given)
    assert sum(read) > 1.5 * once
    same(anew, kept, 1e-12)


def test_long_logs_for_least_squares_are_read_chunk_by_chunk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    columns = motion(4000, 7)
    arrays = {role: np.column_stack([columns[f"{role}{j}"] for j in (1, 2)])
              for role in ("q", "qd", "tau")}  # fmt: skip
    path, packed = tmp_path / "long.npz", tmp_path / "packed.npz"
    np.savez(path, t=columns["t"], **arrays)
    np.savez_compressed(packed, t=columns["t"], **arrays)
    memory = symgen.identify(robot(), path, model="momentum")
    monkeypatch.setattr("symgen.identification.out_of_core.LONG", 3000)
    read, rows = [], StoredArray.__getitem__

    def counted(self, span):
        read.append(len(part := rows(self, span)))
        return part

    monkeypatch.setattr(StoredArray, "__getitem__", counted)
    monkeypatch.setattr("symgen.data.tables.BATCH", 500)
    same(memory, symgen.identify(robot(), path, model="momentum"), 1e-9)
    assert len(read) > 4 * len(arrays)
    assert is_long([path], True)
    assert not is_long([path], False)
    assert not is_long([packed], True)
    short = tmp_path / "short.csv"
    short.write_text("t,q1,q2,tau1,tau2\n", "utf-8")
    assert not is_long([path, short], True)
    monkeypatch.setattr("symgen.identification.out_of_core.LONG", 4000)
    assert not is_long([path], True)
    assert is_long([path, path], True)
    huber = symgen.identify(robot(), path, model="momentum", method="huber")
    assert huber.method == "huber"
    same(
        memory, symgen.identify(robot(), packed, model="momentum", workers=symgen.Workers(1)), 1e-9
    )


def test_csv_and_npz_in_a_folder_and_url_of_memory(tmp_path: Path) -> None:
    fsspec = pytest.importorskip("fsspec")
    columns = motion(3000, 3)
    names = list(columns)
    table = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "a.csv", table, "%.17g", ",", header=",".join(names), comments="")
    arrays = {role: np.column_stack([columns[f"{role}{j}"] for j in (1, 2)])
              for role in ("q", "qd", "tau")}  # fmt: skip
    np.savez(tmp_path / "b.npz", t=columns["t"] + 100, **arrays)
    mixed = symgen.identify(robot(), str(tmp_path), model="momentum")
    parquet(tmp_path / "c.parquet", columns)
    memory = fsspec.filesystem("memory")
    for name, start in (("a", 0.0), ("b", 100.0)):
        path = parquet(tmp_path / "one.parquet", {**columns, "t": columns["t"] + start})
        memory.pipe(f"/fleet/{name}.parquet", path.read_bytes())
    remote = symgen.identify(robot(), "memory://fleet/*.parquet", model="momentum")
    assert pytest.approx(mixed.X, rel=1e-9) == remote.X
    memory.rm("/fleet", recursive=True)


def test_refusals_say_what_is_accepted(logs: Path, tmp_path: Path) -> None:
    def refused(match: str, logs: object = str(logs), **given) -> None:
        with pytest.raises(symgen.SymgenError, match=match):
            symgen.identify(robot(), logs, **{"model": "momentum", **given})

    refused("method huber on a data set; accepted: wls, ols", method="huber")
    refused("no file of a log is there; accepted: Parquet", str(tmp_path / "none*.parquet"))
    refused("trains and validates", validation=[logs / "a.parquet"])
    with pytest.raises(symgen.SymgenError, match="accepted: one of them"):
        symgen.Workers(2, "tcp://127.0.0.1:1")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"PAR1 and nothing else")
    refused("broken.parquet: is not a readable Parquet file", broken, workers=symgen.Workers(1))
    bad = motion(1000)
    bad["q2"][777] = np.inf
    refused(
        r"bad.parquet: rows .*: column q2, sample .* \(t = 7.77 s\): inf",
        parquet(tmp_path / "bad.parquet", bad), workers=symgen.Workers(1), cutoff=5.0,
    )  # fmt: skip
    backwards = motion(1000)
    backwards["t"][500] = 0.0
    refused(
        "column t, sample 500.*; accepted: finite, strictly increasing",
        parquet(tmp_path / "back.parquet", backwards), workers=symgen.Workers(1),
    )  # fmt: skip


def test_stretches_are_found_batch_by_batch(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("symgen.data.tables.BATCH", 64)
    columns = motion(1000)
    columns["t"] = columns["t"] + np.where(np.arange(1000) >= 640, 5.0, 0.0)  # between batches
    columns["t"] += np.where(np.arange(1000) >= 700, 5.0, 0.0)
    path = parquet(tmp_path / "gaps.parquet", columns)
    found = DataSet(robot()).stretches(str(path))
    assert [s.rows for s in found] == [(0, 640), (640, 700), (700, 1000)]
    assert found[1].times == pytest.approx((11.4, 11.99))
    assert listed_files([tmp_path]) == [str(path)]
    spans = [(600, 660), (650, 1000)]
    whole = DataSet(robot()).logs(DataSet(robot()).stretches(str(path))[0], spans, "x")
    for (first, last), log in zip(spans, whole, strict=True):
        assert np.array_equal(log.q[:, 1], columns["q2"][first:last])
        assert np.array_equal(log.t, columns["t"][first:last])


def test_a_folder_is_diagnosed_as_its_logs_are(tmp_path, monkeypatch) -> None:
    """Coulomb friction that the robot file leaves out, in two logs of a folder."""
    folder, files = tmp_path / "logs", []
    folder.mkdir()
    for seed in (1, 2):
        columns = motion(6000, seed)
        columns["tau1"] = columns["tau1"] + 0.4 * np.sign(columns["qd1"])
        files.append(parquet(folder / f"{seed}.parquet", columns))
    found = symgen.diagnose(robot(), str(folder))
    plain = symgen.diagnose(robot(), files)
    named = [(e.name, e.joints) for e in found.effects]
    assert named == [(e.name, e.joints) for e in plain.effects]
    assert named[0] == ("coulomb_friction", (1,))
    assert found.after.total < 0.3 * found.before.total
    assert not any("the diagnosis is that of" in note for note in found.notes)
    monkeypatch.setattr(out_of_core, "SAMPLE", 4000)  # of 9,600 that train
    some = symgen.diagnose(robot(), str(folder))
    assert some.effects[0].name == "coulomb_friction"
    assert any("the diagnosis is that of" in note for note in some.notes), some.notes
