"""Data sets made to harm: what is refused alone is refused in a folder, in one line."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import PROJECT, messages

import symgen

T = np.arange(300) * 0.01
Q = np.column_stack([np.sin(5 * T), np.cos(3 * T)])
GOOD = {"t": T, "q": Q, "tau": Q}


def _array(content: np.ndarray, *spoil: tuple[bytes, bytes]) -> bytes:
    file = io.BytesIO()
    np.save(file, content)
    data = file.getvalue()
    for old, new in spoil:
        assert data.count(old) == 1
        data = data.replace(old, new)
    return data


STRUCTURED = np.zeros(300, [("a", "f8"), ("b", "f8")])
#: Arrays of an NPZ in place of the good ones: their bytes, and what the refusal says of them.
ARRAYS = {
    "t in a column": ("t", _array(T[:, None]), "t has the shape (300, 1)"),
    "t a scalar": ("t", _array(np.float64(1.0)), "t has the shape ()"),
    "t a text": ("t", _array(T.astype(str)), "t holds <U"),
    "t structured": ("t", _array(STRUCTURED), "t holds"),
    "t complex": ("t", _array(T + 0j), "t holds complex128"),
    "q a text": ("q", _array(Q.astype(str)), "q holds <U"),
    "q structured": ("q", _array(STRUCTURED), "q holds"),
    "q a scalar": ("q", _array(np.float64(1.0)), "q has the shape ()"),
    "q in three dimensions": ("q", _array(Q[..., None]), "q has the shape (300, 2, 1)"),
    "tau of dates": ("tau", _array(Q.astype("M8[s]")), "tau holds datetime64[s]"),
    "tau shorter": ("tau", _array(Q[:200]), "tau has the shape (200, 2), and t has 300 samples"),
    "three joints": ("q", _array(np.column_stack([Q, T])), "columns of q: 3, of tau: 2"),
    "a header of more rows": ("q", _array(Q, (b"(300, 2)", b"(900, 2)")), "cannot be read"),
    "a header of 1e18 rows": (
        "q", _array(Q, (b"(300, 2), }" + b" " * 16, b"(1" + b"0" * 18 + b", 2), }")),
        "cannot be read",
    ),
    "a header of fewer rows": ("q", _array(Q, (b"(300, 2)", b"(200, 2)")), "q has the shape (200"),
    "a negative shape": ("q", _array(Q, (b"(300, 2)", b"(-30, 2)")), "cannot be read"),
}  # fmt: skip


@pytest.mark.parametrize("packing", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
@pytest.mark.parametrize("fault", ARRAYS)
def test_an_npz_that_is_refused_alone_is_refused_in_a_folder_alike(
    command, tmp_path, fault, packing
):
    role, spoiled, says = ARRAYS[fault]
    file = tmp_path / "logs" / "log.npz"
    file.parent.mkdir()
    with zipfile.ZipFile(file, "w", packing) as archive:
        for name, array in GOOD.items():
            archive.writestr(f"{name}.npy", spoiled if name == role else _array(array))
    _refused_alike(command, tmp_path, file, says)


def test_a_flipped_bit_of_an_npz_is_seen_alone_and_in_a_folder_alike(command, tmp_path):
    file = tmp_path / "logs" / "log.npz"
    file.parent.mkdir()
    np.savez(file, **GOOD)
    data = bytearray(file.read_bytes())
    data[data.index(Q.tobytes()) + 803] ^= 1  # of q, in its last digits
    file.write_bytes(data)
    _refused_alike(command, tmp_path, file, "Bad CRC-32")


def _refused_alike(command, tmp_path: Path, file: Path, says: str) -> None:
    """Identify from a file, and from its folder: the same refusal, in one line."""
    lines = []
    for logs in (file, file.parent):
        code, _, err = command(
            "identify", "planar2r", logs, "--model", "momentum", "--into", tmp_path / "out"
        )
        assert code == 2
        (line,) = messages(err)
        assert line.startswith(f"symgen: error: {file}: "), line
        assert says in line
        assert "; accepted: " in line
        lines.append(line)
    assert lines[0] == lines[1]


def _corrupt(path: Path) -> None:
    """Spoil what is packed in a Parquet file: its last column's page of values."""
    about = pq.ParquetFile(path).metadata.row_group(0).column(4)
    data = bytearray(path.read_bytes())
    begin = about.data_page_offset + about.total_compressed_size // 2
    data[begin : begin + 40] = b"\xff" * 40
    path.write_bytes(data)


@pytest.fixture
def corrupt(tmp_path: Path) -> Path:
    """A folder of one Parquet file that cannot be unpacked."""
    path = tmp_path / "logs" / "arm_1.parquet"
    path.parent.mkdir()
    steps = np.round(Q, 1)  # that are packed
    columns = {"t": T, "q1": Q[:, 0], "q2": Q[:, 1], "tau1": steps[:, 0], "tau2": steps[:, 1]}
    pq.write_table(pa.table(columns), path, compression="snappy", use_dictionary=False)
    _corrupt(path)
    return path


def test_a_corrupt_parquet_is_refused_alone_and_in_a_folder_alike(command, tmp_path, corrupt):
    _refused_alike(command, tmp_path, corrupt, "is not a readable Parquet file: Corrupt snappy")


def test_a_corrupt_column_that_names_the_robot_is_a_line(command, tmp_path, corrupt):
    arguments = ("--by", "tau2", "--into", tmp_path / "out")
    code, _, err = command("fleet", "planar2r", corrupt.parent, *arguments)
    (line,) = messages(err)
    assert code == 2
    assert f"{corrupt}: is not a readable Parquet file: Corrupt snappy" in line


@pytest.mark.parametrize("name", ["9" * 5000, "0" * 5000, "٣" * 5000, "²", ""])
def test_a_robot_of_5_000_digits_is_one_like_others(command, tmp_path, name):
    """Days that cannot be identified: of the second robot, whatever it is called."""
    for k, robot in enumerate(("7", name)):
        columns = {"t": T[:30], "q1": T[:30], "tau1": T[:30], "robot": [robot] * 30}
        pq.write_table(pa.table(columns), tmp_path / f"day_{k}.parquet")
    arguments = ("--by", "robot", "--cutoff", "5", "--into", tmp_path / "out")
    code, _, err = command("fleet", "planar2r", tmp_path, *arguments)
    assert code == 2
    assert "no day could be identified: failed: " in messages(err)[-1]


def test_a_column_of_5_000_digits_is_a_line(command, tmp_path, corrupt):
    arguments = ("--by", "9" * 5000, "--into", tmp_path / "out")
    code, _, err = command("fleet", "planar2r", corrupt.parent, *arguments)
    (line,) = messages(err)
    assert code == 2
    assert "accepted: t, q1, q2, tau1, tau2" in line
    assert len(line) < 2100


@pytest.mark.parametrize("std", ["1e200", "-1e200", "1.7e308"])
def test_a_deviation_whose_square_is_no_number_is_damage(command, tmp_path, std):
    written = PROJECT / "tests" / "reference" / "schemas" / "fleet-1"
    shutil.copytree(written, tmp_path / "fleet")
    path = tmp_path / "fleet" / "fleet.json"
    content = json.loads(path.read_text())
    known = next(day for day in content["estimates"] if day["parameters"])
    known["parameters"][0]["std"] = float(std)
    path.write_text(json.dumps(content))
    code, _, err = command("report", tmp_path / "fleet")
    (line,) = messages(err)
    assert code == 2
    assert f"{path}: damaged at estimates" in line
    assert "; accepted: " in line


#: URLs, and what the refusal says of them.
URLS = {
    **dict.fromkeys(
        ("zip://a.parquet", "reference://", "dir://a", "zip://a.npz::file:///b.zip", "://", "1://a",
         "simplecache::s3://bucket/a.parquet", "github://a:b@c/d", "ftp://a/b", "local://a",
         "nothing://a", "x" * 5000 + "://a", "ssh://a/b", "data://a", "jupyter://a", "libarchive://a"),
        "accepted: file, s3, gs, az, http, https, memory",
    ),
    **dict.fromkeys(
        ("http://[::1/x", "https://[/a.parquet", "http://a]b/c", "http://a:99999/x.parquet", "s3://",
         "http://", "https:///a.parquet", "file://a::zip://b", "memory://a::http://b"),
        "accepted: ",
    ),
}  # fmt: skip


@pytest.mark.parametrize("url", URLS)
@pytest.mark.parametrize("verb", ["identify", "fleet"])
def test_a_url_that_is_none_is_a_line(command, tmp_path, verb, url):
    pytest.importorskip("fsspec", reason="fsspec is not installed")
    code, _, err = command(verb, "planar2r", url, "--model", "momentum", "--into", tmp_path / "out")
    assert code == 2
    (line,) = messages(err)
    assert URLS[url] in line
    assert len(line) < 2100


@pytest.mark.parametrize(
    "name", ["a\0*.npz", "a" * 5000 + "*", "[", "**/[!", "a" * 300 + "/*.csv", "**/" * 2000]
)
def test_a_pattern_that_no_disk_has_is_a_line(name):
    with pytest.raises(symgen.LogError, match="; accepted: "):
        symgen.identify("planar2r", name, model="momentum")
