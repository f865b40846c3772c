"""Bags made to fill memory, disk or time: one line, in bounds, and nothing left."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from oracles.bags import DEFINITION, JOINT_STATE, State, write_bag
from support import PROJECT

import symgen
from symgen.data.bounded import read_bounded
from symgen.data.raw import Raw, Reading

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="bounds as Linux has them")
UNPACKED = 512 << 20
MEMORY = 400  # MB, of a process that may take 256 MB beside what Python takes
STATES = [State(k * 10**7 + 1, "ab", [0.1 * k, 0], [0, 0], [1, k]) for k in range(40)]

# In a process of its own, so that what its child takes can be told: memory in MB.
READ = """
import json, resource, sys
import symgen
from symgen.data import bounded
from symgen.data.log import read_log
from symgen.data.bounded import read_bounded
from symgen.data.raw import Raw, Reading
bounded._SECONDS, bounded._LEAST = 1.0, 256 << 20  # smaller, so that tests are quick
try:
    said = read_log(sys.argv[1], reading=Reading(joints=("a", "b"))).q.shape
except symgen.SymgenError as error:
    said = str(error)
took = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([said, took.ru_maxrss / 1024, took.ru_utime]))
"""


def read(path: Path, temporary: Path) -> tuple[str, float]:
    """Return what is said of a bag, and the memory in MB; it took seconds, and left nothing."""
    temporary.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", READ, path],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(PROJECT), "TMPDIR": str(temporary)},
    )
    assert done.returncode == 0, done.stderr
    said, memory, seconds = json.loads(done.stdout)
    assert seconds < 4
    assert list(temporary.iterdir()) == []
    return said, memory


def mcap(path: Path, compression: str) -> Path:
    """Write an MCAP file by its authors' writer: one message of zeros that unpacks to 512 MB."""
    writer = pytest.importorskip("mcap.writer")
    with path.open("wb") as file:
        out = writer.Writer(file, compression=writer.CompressionType[compression])
        out.start(profile="ros2")
        schema = out.register_schema(JOINT_STATE, "ros2msg", DEFINITION.encode())
        channel = out.register_channel("/joint_states", "cdr", schema)
        out.add_message(channel, 1, bytes(UNPACKED), 1)
        out.finish()
    return path


def bag(folder: Path) -> Path:
    """Write a good bag of SQLite."""
    pytest.importorskip("rosbags")
    return write_bag(folder, {"/joint_states": STATES}, "sqlite3")


def test_a_good_bag_is_read_in_bounds(tmp_path):
    said, memory = read(bag(tmp_path / "bag"), tmp_path / "temporary")
    assert said == [len(STATES), 2]
    assert memory < 200


def test_a_chunk_that_would_fill_the_memory_is_refused(tmp_path):
    path = mcap(tmp_path / "log.mcap", "ZSTD")
    assert path.stat().st_size < 1e5
    said, memory = read(path, tmp_path / "temporary")
    assert "accepted: " in said
    assert memory < MEMORY


#: Text before metadata.yaml, and a line of it with what it becomes.
YAML = {
    # 10 to the power of 9 words, for whoever puts them into a message.
    "laughs": (
        "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n"
        + "".join(f"a{k}: &a{k} [{','.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 10)),
        ("compression_format: ''", "compression_format: *a9"),
        ("compression_mode: ''", "compression_mode: file"),
    ),
    "merges": (
        "m0: &m0 {a: 1}\n"
        + "".join(f"m{k}: &m{k} {{<<: [{','.join([f'*m{k - 1}'] * 10)}]}}\n" for k in range(1, 9)),
    ),
    "nested": ("[" * 100_000 + "\n",),
}


@pytest.mark.parametrize("kind", YAML)
def test_yaml_that_grows_without_end_is_refused(tmp_path, kind):
    text = bag(tmp_path / "bag") / "metadata.yaml"
    before, *changes = YAML[kind]
    content = text.read_text("utf-8")
    for old, new in changes:
        assert old in content
        content = content.replace(old, new)
    text.write_text(before + content)
    said, memory = read(tmp_path / "bag", tmp_path / "temporary")
    assert "accepted: " in said
    assert len(said) < 2000
    assert memory < MEMORY


def test_a_packed_file_of_a_bag_does_not_fill_the_disk(tmp_path):
    """The bag unpacks its only file, to 512 MB, into the folder of temporary files."""
    zstd = pytest.importorskip("backports.zstd")
    folder = bag(tmp_path / "bag")
    (file,) = folder.glob("*.db3")
    packed = zstd.ZstdCompressor()
    with file.open("wb") as out:
        for _ in range(UNPACKED >> 23):
            out.write(packed.compress(bytes(8 << 20)))
        out.write(packed.flush())
    about = folder / "metadata.yaml"
    text = about.read_text("utf-8").replace("compression_format: ''", "compression_format: zstd")
    about.write_text(text.replace("compression_mode: ''", "compression_mode: FILE"))
    said, memory = read(folder, tmp_path / "temporary")
    # On a busy machine the limit of time comes first.
    assert "File too large" in said or "to read; accepted" in said
    assert memory < MEMORY


_ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)"
SQL = {
    "a view without end": f"CREATE VIEW messages AS {_ENDLESS} "
    "SELECT x AS id, 1 AS topic_id, x AS timestamp, x'00' AS data FROM c",
    "a view of what is large": f"CREATE VIEW messages AS {_ENDLESS} SELECT x AS id, "
    "1 AS topic_id, x AS timestamp, zeroblob(900000000) AS data FROM c LIMIT 9",
    "a computed column": "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, "
    "data BLOB AS (zeroblob(900000000))); "
    "INSERT INTO messages(id, topic_id, timestamp) SELECT id, topic_id, timestamp FROM old",
    "a trigger": "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data); "
    "INSERT INTO messages SELECT * FROM old; CREATE TRIGGER t AFTER INSERT ON messages "
    "BEGIN DELETE FROM messages; END",
    "a table whose rows are texts": "CREATE TABLE messages AS SELECT id, topic_id, 'x' AS "
    "timestamp, 'y' AS data FROM old",
}


@pytest.mark.parametrize("kind", SQL)
def test_a_database_that_computes_what_it_holds_is_refused_in_bounds(tmp_path, kind):
    folder = bag(tmp_path / "bag")
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as connection:
        script = f"DROP INDEX timestamp_idx; ALTER TABLE messages RENAME TO old; {SQL[kind]};"
        connection.executescript(script)
    connection.close()
    before = file.read_bytes()
    said, memory = read(folder, tmp_path / "temporary")
    if kind == "a trigger":  # reading fires none
        assert said == [len(STATES), 2]
    else:
        assert "accepted: " in said
    assert memory < MEMORY
    assert file.read_bytes() == before


def test_what_a_process_takes_beyond_its_bounds_is_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr("symgen.data.bounded._LEAST", 1 << 20)
    path = bag(tmp_path / "bag")
    with pytest.raises(symgen.LogError, match=r"bag: takes more than .* GB or .* s to read"):
        symgen.read_log(path, reading=Reading(joints=("a", "b")))


def limits(_path: Path) -> Raw:
    """Return the limits of this process: on files, bytes, and on processor time, s."""
    import resource  # of POSIX

    found = [resource.getrlimit(of)[0] for of in (resource.RLIMIT_FSIZE, resource.RLIMIT_CPU)]
    return Raw({"limits": np.array(found, dtype=float)}, (), ())


def test_a_large_file_may_take_what_its_ten_byte_messages_take(tmp_path):
    """Each 2 kB, and 0.2 ms."""
    small, large, messages = tmp_path / "small", tmp_path / "large", 200_000
    small.write_bytes(b"")
    large.write_bytes(bytes(10 * messages))
    before, after = (read_bounded(limits, path).arrays["limits"] for path in (small, large))
    assert (after - before).tolist() == [2000 * messages, 2e-4 * messages]
