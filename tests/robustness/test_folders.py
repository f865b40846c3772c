"""Folders of results: nothing of the user's is lost, whatever stands in them and whoever is killed.

Processes are killed by SIGKILL at every step that they take in the file system.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support import PROJECT

import symgen
from symgen.files import RECORD, write_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills by signals")

NAME = "re[s]ults"
MARKER = "estimate.json"


def content(value: str) -> dict[str, bytes]:
    """Return the files of a folder."""
    return {MARKER: b'{"schema": "symgen.x"}', "a": value.encode(), "deep/b": value.encode()}


def whole(folder: Path) -> str:
    """Return the value with which a folder was written whole."""
    value = (folder / "a").read_text()
    found = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert (folder / "deep/b").read_text() == value
    assert found == {MARKER, "a", "deep/b", RECORD}
    return value


KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from symgen import files
def content(value):
    return {"estimate.json": b'{"schema": "symgen.x"}', "a": value, "deep/b": value}
folder = Path(sys.argv[1])
if sys.argv[2] == "without exchange":
    import ctypes
    ctypes.CDLL = None
start = folder.parent / "start"
files.write_folder(start, content(b"1"), "estimate.json")
for k in range(10**6):
    place = folder.parent / str(k)
    place.mkdir()
    shutil.copytree(start, place / folder.name)
    child = os.fork()
    if not child:
        count = 0
        def heed(event, _):
            global count
            count += event.startswith(("open", "os.", "shutil.", "ctypes."))
            if count > k:
                os.kill(os.getpid(), signal.SIGKILL)
        sys.addaudithook(heed)
        files.write_folder(place / folder.name, content(b"2"), "estimate.json")
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        break
"""


@pytest.mark.parametrize("how", ["with exchange", "without exchange"])
def test_a_kill_at_any_step_loses_nothing_and_leaves_nothing(tmp_path: Path, how: str) -> None:
    command = [sys.executable, "-c", KILLED, tmp_path / NAME, how]
    subprocess.run(command, cwd=PROJECT, check=True, timeout=120)
    places = sorted((p for p in tmp_path.iterdir() if p.name.isdigit()), key=lambda p: int(p.name))
    assert len(places) > 20
    seen = set()
    for place in places:
        aside = place / f".{NAME}-old"
        kept = [p for p in (place / NAME, aside) if p.exists()]
        seen |= {(whole(p), p == aside) for p in kept[:1]}
        assert kept
        assert not aside.exists() or how == "without exchange"
    assert seen >= {("1", False), ("2", False)}
    assert whole(places[-1] / NAME) == "2"


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    tree = symgen.generate(symgen.derive(symgen.read_robot("planar2r"), ("energy",)))
    symgen.write_package(tree, tmp_path)
    assert (tmp_path / "manifest.json").is_file()


SPOILED: dict[str, Callable[[Path], object]] = {
    "notes.txt": lambda folder: (folder / "notes.txt").write_text("mine"),
    "deep/mine": lambda folder: (folder / "deep/mine").write_text("mine"),
    "a": lambda folder: (folder / "a").write_text("changed"),
    "link": lambda folder: (folder / "link").symlink_to("a"),
    "pipe": lambda folder: os.mkfifo(folder / "pipe"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_a_folder_with_a_file_of_the_user_is_refused_with_its_name(tmp_path, name) -> None:
    write_folder(tmp_path / NAME, content("1"), MARKER)
    SPOILED[name](tmp_path / NAME)
    before = sorted(p for p in tmp_path.rglob("*"))
    with pytest.raises(symgen.PackageError, match=name):
        write_folder(tmp_path / NAME, content("2"), MARKER)
    assert sorted(p for p in tmp_path.rglob("*")) == before
    assert (tmp_path / NAME / "deep/b").read_text() == "1"


def test_foreign_files_and_results_of_another_kind_are_refused(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text('{"schema": "symgen.manifest/1"}')
    write_folder(tmp_path / "estimate", content("1"), MARKER)
    for folder in (tmp_path, tmp_path / "estimate"):
        with pytest.raises(symgen.PackageError, match=r"manifest\.json"):
            write_folder(folder, {"manifest.json": b"{}"}, "manifest.json")
    assert whole(tmp_path / "estimate") == "1"
