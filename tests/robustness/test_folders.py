"""Folders of results: nothing of the user's is lost, whatever stands in them and whoever is killed.

Processes are killed by SIGKILL at every step that they take in the file system.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support import PROJECT
from support_commands import PARAMETERS

import symgen
from symgen.files import check_replaceable, write_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills by signals")

NAME = "re[s]ults"
MARKER = "estimate.json"


def content(value: str) -> dict[str, bytes]:
    """Return the files of a folder."""
    return {MARKER: b'{"schema": "symgen.x"}', "a": value.encode(), "deep/b": value.encode()}


def whole(folder: Path) -> str:
    """Return the value with which a folder was written whole; it also has what the user put."""
    value = (folder / "a").read_text()
    found = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert (folder / "deep/b").read_text() == value
    assert (folder / "notes.txt").read_text() == "mine"
    assert (folder / "deep/mine").read_text() == "mine"
    assert found - {".symgen.sha256"} == {MARKER, "a", "deep/b", "notes.txt", "deep/mine"}
    return value


def command(*arguments: object) -> tuple[int, str]:
    """Run a command; return its exit code and what is on stderr."""
    done = subprocess.run(
        [sys.executable, "-m", "symgen", *map(str, arguments)],
        capture_output=True, text=True, cwd=PROJECT,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    return done.returncode, done.stderr


#: Begins a process that heeds what the test says at the steps that it takes in the file system.
STEPS = """
import os, signal, sys
from pathlib import Path
from symgen import files
from symgen.errors import SymgenWarning
SEEN = ("open", "os.", "shutil.", "ctypes.")
def at_steps(heed):
    sys.addaudithook(lambda event, _: heed(event) if event.startswith(SEEN) else None)
def content(value):
    return {"estimate.json": b'{"schema": "symgen.x"}', "a": value, "deep/b": value}
folder = Path(sys.argv[1])
if sys.argv[2] == "without exchange":
    files.exchanged = lambda *_: False
"""

KILLED = """
import shutil
start = folder.parent / "start"
files.write_folder(start, content(b"1"), "estimate.json")
(start / "notes.txt").write_text("mine")
(start / "deep/mine").write_text("mine")
last = 0
for k in range(10**6):
    place = folder.parent / str(k)
    place.mkdir()
    shutil.copytree(start, place / folder.name)
    child = os.fork()
    if not child:
        count = 0
        def heed(event):
            global count
            count += 1
            if count > k:
                os.kill(os.getpid(), signal.SIGKILL)
        at_steps(heed)
        files.write_folder(place / folder.name, content(b"2"), "estimate.json")
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        break
"""


@pytest.mark.parametrize("how", ["with exchange", "without exchange"])
def test_a_kill_at_any_step_loses_nothing_and_leaves_nothing(tmp_path: Path, how: str) -> None:
    folder = tmp_path / NAME
    subprocess.run(
        [sys.executable, "-c", STEPS + KILLED, folder, how],
        cwd=PROJECT, check=True, timeout=120,
    )  # fmt: skip
    places = sorted((p for p in tmp_path.iterdir() if p.name.isdigit()), key=lambda p: int(p.name))
    assert len(places) > 20
    seen = set()
    for place in places:
        asides = list(place.glob(".re*-old-*"))
        if asides:
            (aside,) = asides
            assert whole(aside) == "1"
            with pytest.warns(symgen.SymgenWarning, match=r"-old-.*had moved aside; move it back"):
                check_replaceable(place / NAME, MARKER)
        seen.add(whole(place / NAME) if (place / NAME).exists() else "aside")
        present = (place / NAME).exists()
        write_folder(place / NAME, content("3"), MARKER)
        assert (place / NAME / "a").read_text() == "3"
        assert not present or whole(place / NAME) == "3"
        assert set(place.iterdir()) == {place / NAME, *asides}
        assert not asides or whole(asides[0]) == "1"
    assert seen == {"1", "2"} | ({"aside"} if how == "without exchange" else set())
    assert whole(places[-1] / NAME) == "3"


WAITS = """
def heed(event):
    global waited
    if event == "os.mkdir" and not waited and list(folder.parent.glob(".symgen-part-*")):
        waited = True
        print("there", flush=True)
        sys.stdin.readline()
waited = False
at_steps(heed)
files.write_folder(folder, content(b"2"), "estimate.json")
"""


def test_what_a_living_process_writes_is_left_alone(tmp_path: Path) -> None:
    write_folder(tmp_path / NAME, content("1"), MARKER)
    job = subprocess.Popen(
        [sys.executable, "-c", STEPS + WAITS, tmp_path / NAME, ""],
        cwd=PROJECT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert job.stdout.readline() == "there\n"
    (place,) = tmp_path.glob(".symgen-part-*")
    write_folder(tmp_path / "other", content("1"), MARKER)
    write_folder(tmp_path / NAME, content("3"), MARKER)
    assert place.is_dir()
    job.communicate("go on\n", timeout=60)
    assert job.returncode == 0
    assert (tmp_path / NAME / "a").read_text() == "2"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["other", NAME]


OFTEN = """
for k in range(60):
    files.write_folder(folder, content(str(k).encode()), "estimate.json")
"""


@pytest.mark.parametrize("first", ["absent", "there"])
def test_processes_that_write_one_folder_at_once_leave_it_whole(tmp_path: Path, first: str) -> None:
    if first == "there":
        write_folder(tmp_path / NAME, content("1"), MARKER)
        (tmp_path / NAME / "notes.txt").write_text("mine")
        (tmp_path / NAME / "deep/mine").write_text("mine")
    jobs = [
        subprocess.Popen(
            [sys.executable, "-c", STEPS + OFTEN, tmp_path / NAME, ""],
            cwd=PROJECT, stderr=subprocess.PIPE, text=True,
        )
        for _ in range(3)
    ]  # fmt: skip
    assert [job.communicate(timeout=120)[1] for job in jobs] == [""] * 3
    assert (tmp_path / NAME / "a").read_text() == "59"
    assert first == "absent" or whole(tmp_path / NAME) == "59"
    assert [p.name for p in tmp_path.iterdir()] == [NAME]


# What others put there.


def test_an_estimate_from_elsewhere_makes_nothing_ours(tmp_path: Path) -> None:
    """Even where its digests are those of the user's files."""
    folder = tmp_path / "mine"
    shutil.copytree(PROJECT / "tests/reference/schemas/estimate-2", folder)
    (folder / "notes.txt").write_text("mine")
    (folder / "robot.toml").write_text("mine")
    estimate = json.loads((folder / MARKER).read_text())
    sha = hashlib.sha256(b"mine").hexdigest()
    estimate["digests"] = {"notes.txt": sha, "robot.toml": sha, "../log.csv": sha}
    (folder / MARKER).write_text(json.dumps(estimate))
    before = {p: p.read_bytes() for p in folder.iterdir()}
    arguments = ("simulate", "planar2r", "--parameters", tmp_path / "p.toml", "--duration", "4")
    (tmp_path / "p.toml").write_text(PARAMETERS)
    code, said = command(*arguments, "--into", tmp_path / "log.csv")
    assert code == 0, said
    code, said = command("identify", "planar2r", tmp_path / "log.csv", "--into", folder)
    assert {p: p.read_bytes() for p in folder.iterdir()} == before
    assert (code, said.count("\n")) == (2, 1)
    assert "not ours (no .symgen.sha256 in it); accepted: a new or empty folder" in said


def test_what_the_user_changed_is_kept_under_another_name(tmp_path: Path) -> None:
    folder = tmp_path / "package"
    tree = symgen.generate(symgen.derive(symgen.read_robot("planar2r"), ("energy",)))
    symgen.write_package(tree, folder)
    (folder / "robot.toml").write_text("changed")
    for kept in ("robot.toml.kept", "robot.toml.kept-2"):
        with pytest.warns(symgen.SymgenWarning, match=r"changed since symgen wrote it.*is now .*k"):
            symgen.write_package(tree, folder)
        assert (folder / kept).read_text() == "changed"
        assert (folder / "robot.toml").read_bytes() == tree.files["robot.toml"]
        (folder / "robot.toml").write_text("changed")
    (folder / "manifest.json").write_text("changed")
    with pytest.raises(symgen.PackageError, match="not ours"):
        symgen.write_package(tree, folder)
    assert (folder / "manifest.json").read_text() == "changed"


def test_casadi_files_of_an_older_symgen_go_and_those_of_the_user_stay(tmp_path: Path) -> None:
    """Packages without NAME_casadi.py had NAME_KERNEL.casadi, and no digests of them."""
    folder = tmp_path / "package"
    tree = symgen.generate(symgen.derive(symgen.read_robot("planar2r"), ("energy",)))
    symgen.write_package(tree, folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "planar2r_casadi.py").unlink()
    del manifest["digests"]["planar2r_casadi.py"]
    (folder / "manifest.json").write_text(json.dumps(manifest))
    for name in ("planar2r_energy", "planar2r_friction", "energy"):
        (folder / f"{name}.casadi").write_text(name)
    symgen.write_package(tree, folder)
    kept = {path.name for path in folder.glob("*.casadi")}
    assert kept == {"planar2r_friction.casadi", "energy.casadi"}
    (folder / "planar2r_energy.casadi").write_text("saved by NAME_casadi.py")
    symgen.write_package(tree, folder)
    assert (folder / "planar2r_energy.casadi").is_file()


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    tree = symgen.generate(symgen.derive(symgen.read_robot("planar2r"), ("energy",)))
    symgen.write_package(tree, tmp_path)
    assert (tmp_path / "manifest.json").is_file()


def test_a_manifest_from_elsewhere_makes_nothing_ours(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    sha = hashlib.sha256(b"mine").hexdigest()
    listed = {"schema": "symgen.manifest/1", "digests": {"notes.txt": sha}}
    (tmp_path / "manifest.json").write_text(json.dumps(listed))
    code, said = command("generate", "planar2r", "--into", tmp_path)
    assert (code, (tmp_path / "notes.txt").read_text()) == (2, "mine"), said


@pytest.mark.parametrize(
    "put",
    [
        lambda folder: (folder / "a/b").mkdir(parents=True),
        lambda folder: (folder / "a").symlink_to("/"),
        lambda folder: os.mkfifo(folder / "a"),
    ],
    ids=["folder", "link", "pipe"],
)
def test_what_stands_where_a_file_goes_is_kept(tmp_path: Path, put: Callable) -> None:
    folder = tmp_path / NAME
    write_folder(folder, content("1"), MARKER)
    (folder / "a").unlink()
    put(folder)
    kind = (folder / "a").lstat().st_mode
    os.link(folder / "deep/b", folder / "same")  # two names of one file, one of them the user's
    (folder / "empty").mkdir()
    with pytest.warns(symgen.SymgenWarning, match="it is now a.kept"):
        write_folder(folder, content("2"), MARKER)
    assert (folder / "a").read_text() == "2"
    assert (folder / "a.kept").lstat().st_mode == kind
    assert (folder / "same").read_text() == "1"
    assert (folder / "empty").is_dir()


def test_an_old_result_aside_is_named_and_neither_put_back_nor_removed(tmp_path: Path) -> None:
    aside = tmp_path / ".out-old-abcd1234" / "out"
    aside.mkdir(parents=True)
    (aside / MARKER).write_text("old")
    nothing = ("identify", "planar2r", tmp_path / "none.csv", "--into", tmp_path / "out")
    for _ in range(2):
        code, said = command(*nothing)
        assert code == 2
        assert sum(".out-old-abcd1234" in line for line in said.splitlines()) == 1
        assert [p.name for p in tmp_path.iterdir()] == [".out-old-abcd1234"]
        assert (aside / MARKER).read_text() == "old"


def test_files_of_a_run_that_was_killed_go_with_the_next(tmp_path: Path) -> None:
    """Of single files, too."""
    code = STEPS + WAITS[: WAITS.rindex("files.")].replace("os.mkdir", "open")
    code += "files.write_files([(folder, b'1')])"
    job = subprocess.Popen(
        [sys.executable, "-c", code, tmp_path / "out.csv", ""],
        cwd=PROJECT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert job.stdout.readline() == "there\n"
    job.kill()
    job.communicate()
    assert len(list(tmp_path.iterdir())) == 1
    write_folder(tmp_path / NAME, content("1"), MARKER)
    assert [p.name for p in tmp_path.iterdir()] == [NAME]
