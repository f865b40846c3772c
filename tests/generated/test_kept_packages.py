"""Packages in the cache: what generate writes from it, and when it derives again."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support_commands import URDF

from symgen.robot.builtin import library_text

#: A command in a process of its own, which prints the heavy modules at its end.
RUN = """
import atexit, sys
from symgen.__main__ import main
heavy = {"sympy", "numpy", "casadi", "jinja2", "pydantic"}
atexit.register(lambda: print("imported:", *sorted(heavy & sys.modules.keys())))
main()
"""
FAST = ["--kernels", "energy_regressor", "--target", "c"]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> Path:
    """An empty cache, and a folder with a robot file, in which the commands run."""
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    Path("arm.toml").write_text(library_text("planar2r"))
    return tmp_path / "cache"


def content(folder: str) -> dict[str, bytes]:
    """Return the files of a folder."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in Path(folder).rglob("*")
        if path.is_file()
    }


def separate(*words: str) -> tuple[int, str, str]:
    """Run a command in a process of its own; return exit code, output without the modules, and
    the modules.
    """
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words], capture_output=True, text=True, check=False
    )
    out, _, modules = done.stdout.rpartition("imported:")
    return done.returncode, out + done.stderr, modules.strip()


def kept(cache: Path) -> list[Path]:
    """Return the files of the packages in the cache."""
    return sorted(cache.rglob("package-*.pickle"))


def test_an_unchanged_robot_is_written_without_a_heavy_import():
    code, first, _ = separate("generate", "arm.toml", "--into", "one", *FAST)
    assert code == 0
    shutil.copy("arm.toml", "same.toml")
    code, again, modules = separate("generate", "same.toml", "--into", "two", *FAST)
    assert (code, modules) == (0, "")
    assert again == re.sub(r"\bone\b", "two", first)
    assert content("two") == content("one")
    assert separate("generate", "arm.toml", "--check", "one", *FAST) == (
        0, "  deriving planar2r\n", "",
    )  # fmt: skip


def test_another_file_or_option_is_derived(command, cache):
    assert command("generate", "arm.toml", "--into", "one", *FAST)[0] == 0
    command("generate", "arm.toml", "--into", "other", "--dtype", "float", *FAST)
    assert "planar2rf.h" in content("other")
    assert len(kept(cache)) == 2
    text = Path("arm.toml").read_text().replace('name = "planar2r"', 'name = "arm"')
    Path("arm.toml").write_text(text)
    shown = command("generate", "arm.toml", *FAST)
    assert f"written: {Path('generated') / 'arm'} (" in shown[1]
    assert len(kept(cache)) == 3


@pytest.mark.parametrize("damage", ["changed", "cut", "foreign"])
def test_a_damaged_package_in_the_cache_is_made_again(command, cache, damage):
    assert command("generate", "arm.toml", "--into", "one", *FAST)[0] == 0
    (path,) = kept(cache)
    whole = path.read_bytes()
    spoiled = bytearray(whole)
    spoiled[len(whole) // 2] ^= 1
    path.write_bytes(
        {"changed": bytes(spoiled), "cut": whole[:-9], "foreign": b"cos\nsystem\n(S'x'\ntR."}[damage]
    )
    assert command("generate", "arm.toml", "--into", "two", *FAST)[0] == 0
    assert content("two") == content("one")
    assert path.read_bytes() == whole


def test_a_changed_folder_is_refused_before_anything_else(command):
    for _ in range(2):  # the second time from the cache, into the folder of the first
        assert command("generate", "arm.toml", "--into", "one", *FAST)[0] == 0
    Path("one/planar2r.h").write_text("mine")
    again = command("generate", "arm.toml", "--into", "one", *FAST)
    code, out, err = command("generate", "arm.toml", "--into", "one", *FAST, "--exact")  # derived
    assert (code, out) == (2, "")
    assert err.startswith("symgen: error: one: holds files that symgen did not write")
    assert again == (code, out, err)


def test_values_of_parameters_are_read_each_time(command):
    values = "[parameters]\nZZ1R = 3.5\nZZ2 = 0.06\nMX2 = 0.124\nMY2 = 0.006\n"
    for digits in ("3.5", "4.25"):
        Path("P.toml").write_text(values.replace("3.5", digits))
        command("generate", "arm.toml", "--into", "one", "--parameters", "P.toml", *FAST)
        assert digits in Path("one/planar2r_values.h").read_text()


def test_warnings_about_a_foreign_file_are_repeated(command):
    Path("one.urdf").write_text(URDF.replace("<axis", '<origin xyz="500 0 0"/><axis'))
    first, again = (command("generate", "one.urdf", "--into", "one", *FAST) for _ in range(2))
    assert first == again
    assert first[0] == 0
    assert "symgen: warning: one.urdf: " in first[2]
