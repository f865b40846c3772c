"""Pieces of work that an interrupted run kept, and somebody or something damaged since."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support import PROJECT
from support_streams import motion, parquet, robot

import symgen
from symgen.estimation import chunks
from symgen.identification import out_of_core
from symgen.robot.toml_text import robot_toml


def _spoiled(path: Path, value: float) -> bytes:
    """Return a piece in which every number is another one: it is a whole NPZ file."""
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    for array in arrays.values():
        if array.dtype == float and array.ndim:
            array[...] = value
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def _turned(path: Path) -> bytes:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    return bytes(content)


DAMAGE: dict[str, Callable[[Path], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda path: path.read_bytes()[:-100],
    "half": lambda path: path.read_bytes()[: path.stat().st_size // 2],
    "nan": lambda path: _spoiled(path, np.nan),
    "other numbers": lambda path: _spoiled(path, 0.5),
    "one bit": _turned,
    "something else": lambda _: b"PK\x03\x04 and nothing else",
}


def _told(lines: list[str]) -> list[str]:
    return [line for line in lines if "computed again" in line]


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of two logs that make many pieces."""
    cut = partial(chunks.partitions, chunk=900, most=1800)
    monkeypatch.setattr(out_of_core, "partitions", cut)
    folder = tmp_path / "logs"
    folder.mkdir()
    parquet(folder / "a.parquet", motion(3000, 1))
    parquet(folder / "b.parquet", motion(3000, 2))
    return folder


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("kind", ["npz", "rows"])
def test_a_damaged_piece_is_computed_again_and_that_is_said(
    logs: Path, tmp_path: Path, kind: str, damage: str
) -> None:
    work, said = tmp_path / "work", list[str]()
    run = partial(
        symgen.identify, robot(), str(logs), model="momentum", cutoff=5.0,
        workers=symgen.Workers(1, work=work), progress=said.append,
    )  # fmt: skip
    whole = run()
    assert not _told(said)
    pieces = sorted(work.glob(f"*.{kind}"))
    assert len(pieces) > 3
    for path in pieces if kind == "npz" else pieces[:2]:
        path.write_bytes(DAMAGE[damage](path))
    if kind == "rows":  # the run was killed before the last pass, which reads them
        for path in sorted(work.glob("*.npz"), key=lambda p: p.stat().st_mtime_ns)[-4:]:
            path.unlink()
    said.clear()
    again = run()
    assert again.X.tobytes() == whole.X.tobytes()
    assert [p.std for p in again.parameters] == pytest.approx([p.std for p in whole.parameters])
    told = _told(said)
    if kind == "npz":
        counts = [int(line.rsplit(": ", 1)[1]) for line in told]
        assert sum(counts) == len(pieces)
    else:
        assert told == ["errors: damaged pieces of an earlier run, computed again: 2"]
    assert not list(work.glob(".symgen-part-*"))
    said.clear()
    assert run().X.tobytes() == whole.X.tobytes()
    assert any("were finished before" in line for line in said)


@pytest.mark.parametrize("damage", ["empty", "nan"])
def test_a_damaged_day_is_computed_again_and_that_is_said(tmp_path: Path, damage: str) -> None:
    work, said = tmp_path / "work", list[str]()
    for day in "123":
        for name in "ab":
            (tmp_path / "logs" / name).mkdir(parents=True, exist_ok=True)
            parquet(tmp_path / "logs" / name / f"{day}.parquet", motion(1500, int(day)))
    run = partial(
        symgen.fleet, robot(), str(tmp_path / "logs"), cutoff=5.0,
        workers=symgen.Workers(1, work=work), progress=said.append,
    )  # fmt: skip
    whole = run().to_json()
    for path in sorted(work.glob("*.npz"))[:2]:
        path.write_bytes(DAMAGE[damage](path))
    said.clear()
    assert run().to_json() == whole
    assert _told(said) == ["days: damaged pieces of an earlier run, computed again: 2"]


def test_the_command_goes_on_after_kills_and_keeps_what_others_put_into_its_folder(
    logs: Path, tmp_path: Path
) -> None:
    (tmp_path / "robot.toml").write_text(robot_toml(robot()))
    command = [sys.executable, "-m", "symgen", "identify", tmp_path / "robot.toml", logs]
    command += ["--model", "momentum", "--into", tmp_path / "out"]
    start = partial(
        subprocess.Popen, command, cwd=PROJECT, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True,
    )  # fmt: skip
    work = tmp_path / ".out-work"
    job = start()
    while job.poll() is None and not list(work.glob("*.npz")):
        time.sleep(0.005)
    os.killpg(job.pid, signal.SIGKILL)
    job.communicate()
    assert not (tmp_path / "out").exists()
    pieces = list(work.glob("*.npz"))
    assert pieces
    pieces[0].write_bytes(b"")
    (work / "notes.txt").write_text("mine")
    job = start()
    _, said = job.communicate(timeout=300)
    assert job.returncode in (0, 1), said
    assert "damaged pieces of an earlier run, computed again: 1" in said
    assert [p.name for p in work.iterdir()] == ["notes.txt"]
    names = {p.name for p in tmp_path.iterdir()}
    assert names == {"logs", "out", "robot.toml", ".out-work"}
