"""Compiling models: the cache, its damage and its races, and machines without a compiler."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from support import forget_compilers

import symgen
from symgen.cache import cache_folder
from symgen.robot.tables import Limits, LogForm
from symgen.runtime import build
from symgen.runtime.build import Compiler, build_module, find_compiler
from symgen.runtime.flags import kernel_flags, panel_flags

PROJECT = Path(__file__).resolve().parents[2]
CC = shutil.which("cc")
pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="compilers are stood in for by shell scripts"),
    pytest.mark.usefixtures("machine"),
]
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
SOURCES = {
    "seven.h": b"int seven(void);\n",
    "seven.c": b'#include "seven.h"\nint seven(void) { return 7; }\n',
}
DECLARATIONS = "int seven(void);"
# Of a compiler in shell: files are compiled as usual, and what follows happens at the link.
COMPILES = 'for a; do [ "$a" = -c ] && exec cc "$@"; done\n'
# Builds in a process of its own; the compiler is the first argument.
LOAD = f"""
import sys
from symgen.runtime.build import Compiler, build_module
compiler = Compiler((sys.argv[1],), "fake 1")
print(build_module({SOURCES!r}, {DECLARATIONS!r}, compiler).lib.seven())
"""


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine of its own for each test: an empty cache, no chosen compiler, nothing said yet."""
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("SYMGEN_CC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    forget_compilers()
    yield
    forget_compilers()


@pytest.fixture
def cache(tmp_path):
    """The folder of compiled models of this test."""
    return tmp_path / "cache"


def script(path: Path, body: str) -> str:
    """Write a compiler: it tells its version, and otherwise runs `body`."""
    answers = 'if [ "$1" = --version ]; then echo fake 1; exit 0; fi\n'
    # What processor? Does it answer at all?
    answers += 'for a; do case "$a" in -E|-S) exec cc "$@";; esac; done\n'
    path.write_text(f"#!/bin/sh\n{answers}{body}\n")
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def counted(tmp_path):
    """A compiler that notes each link, and how many there were."""
    log = tmp_path / "compilations"
    path = script(tmp_path / "counted-cc", f'{COMPILES}echo once >> "{log}"\nexec cc "$@"')

    def count() -> int:
        return len(log.read_text().splitlines()) if log.exists() else 0

    return Compiler((path,), "fake 1"), count


def modules(folder: Path) -> list[str]:
    """What the cache holds that could be taken for a module."""
    return sorted(p.name for p in folder.glob("_symgen_*"))


def build_elsewhere(
    compiler: str, *, group: bool = False, before: str = ""
) -> subprocess.Popen[str]:
    """Start a process that builds or loads the module."""
    return subprocess.Popen(
        [sys.executable, "-c", f"{before}\n{LOAD}", compiler],
        cwd=PROJECT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=group,
    )


def wait_for(marker: Path, job: subprocess.Popen[str]) -> None:
    """Wait until a process has made a file."""
    deadline = time.monotonic() + 60
    while not marker.exists():
        assert job.poll() is None, job.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)


# The cache.


@needs_cc
def test_a_second_load_does_not_compile(counted, cache):
    compiler, count = counted
    first = build_module(SOURCES, DECLARATIONS, compiler)
    again = build_module(dict(reversed(SOURCES.items())), DECLARATIONS, compiler)
    assert (first.lib.seven(), again.lib.seven()) == (7, 7)
    assert count() == 1
    assert len(modules(cache)) == 1
    assert list(cache.glob("build-*")) == []


@needs_cc
@pytest.mark.parametrize(
    "change",
    ["source", "name of a source", "declarations", "version", "command", "processor", "flags"],
)
def test_whatever_the_result_depends_on_gives_another_module(change, counted, cache, monkeypatch):
    compiler, count = counted
    build_module(SOURCES, DECLARATIONS, compiler)
    sources, declarations = dict(SOURCES), DECLARATIONS
    if change == "source":
        sources["seven.c"] = sources["seven.c"].replace(b"return 7", b"return 3 + 4")
    elif change == "name of a source":
        sources["eight.c"] = sources.pop("seven.c")
    elif change == "declarations":
        declarations += " "
    elif change == "version":
        compiler = Compiler(compiler.command, "fake 2")
    elif change == "command":
        compiler = Compiler((*compiler.command, "-g"), compiler.version)
    elif change == "processor":
        monkeypatch.setattr(build, "native", lambda _: "another processor")
    flags = ("-DNDEBUG",) if change == "flags" else ()
    assert build_module(sources, declarations, compiler, flags).lib.seven() == 7
    assert count() == 2
    assert len(modules(cache)) == 2


@needs_cc
def test_a_compiler_that_does_not_know_this_processor_still_builds(tmp_path):
    refuse = 'for a; do case "$a" in -march=*) exit 1;; esac; done\nexec cc "$@"'
    path = tmp_path / "plain-cc"
    path.write_text(f"#!/bin/sh\n{refuse}\n")
    path.chmod(0o755)
    compiler = Compiler((str(path),), "fake 1")
    assert build.native(compiler) == ""
    assert kernel_flags(compiler) == panel_flags(compiler) == ()
    assert build_module(SOURCES, DECLARATIONS, compiler).lib.seven() == 7


# Damage and races.


@needs_cc
@pytest.mark.parametrize("when", ["before", "half-written", "written"])
def test_a_killed_build_leaves_nothing_that_loads_and_the_next_one_works(when, tmp_path, cache):
    write = {
        "before": "",
        "half-written": 'for last; do case "$last" in *.so) echo ELF > "$last";; esac; done',
        "written": 'cc "$@"',
    }[when]
    marker = tmp_path / "compiling"
    stuck = script(tmp_path / "stuck-cc", f'{COMPILES}{write}\ntouch "{marker}"\nexec sleep 60')
    job = build_elsewhere(stuck, group=True)
    wait_for(marker, job)
    os.killpg(job.pid, signal.SIGKILL)
    job.communicate(timeout=30)
    assert modules(cache) == []
    Path(stuck).unlink()
    script(Path(stuck), 'exec cc "$@"')  # the same compiler, so the same digest
    job = build_elsewhere(stuck)
    out, err = job.communicate(timeout=120)
    assert (job.returncode, out) == (0, "7\n"), err
    assert len(modules(cache)) == 1


@needs_cc
def test_builds_at_once_all_succeed(cache):
    jobs = [build_elsewhere("cc") for _ in range(2)]
    assert [job.communicate(timeout=120)[0] for job in jobs] == ["7\n"] * 2
    assert len(modules(cache)) == 1


@needs_cc
@pytest.mark.parametrize("damage", ["empty", "text", "half"])
def test_a_damaged_module_in_the_cache_is_built_again(damage, counted, cache):
    compiler, count = counted
    assert build_elsewhere(compiler.command[0]).communicate(timeout=60)[0] == "7\n"
    (name,) = modules(cache)
    whole = (cache / name).read_bytes()
    half = whole[: len(whole) // 2]
    (cache / name).unlink()
    (cache / name).write_bytes({"empty": b"", "text": b"not a module", "half": half}[damage])
    before = count()
    job = build_elsewhere(compiler.command[0])
    out, err = job.communicate(timeout=60)
    assert (job.returncode, out) == (0, "7\n"), err
    assert count() == before + 1
    assert modules(cache) == [name]


def test_another_robot_in_the_cache_is_not_this_one(cache):
    def derive(name: str) -> tuple[list[object], list[Path]]:
        before = set(cache.rglob("*.pickle"))
        model = symgen.derive(name)
        own = sorted(set(cache.rglob("*.pickle")) - before)
        return [*model.base.names, *(kernel.size for kernel in model.kernels)], own

    planar2r, kept = derive("planar2r")
    _, others = derive("emps")
    for ours, theirs in zip(kept, others, strict=True):
        ours.write_bytes(theirs.read_bytes())
    again, _ = derive("planar2r")
    assert again == planar2r


@needs_cc
def test_a_cache_that_cannot_be_written_falls_back_to_the_temporary_folder(
    counted, tmp_path, monkeypatch
):
    compiler, count = counted
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("USER", "someone")
    for _ in range(2):
        assert build_module(SOURCES, DECLARATIONS, compiler).lib.seven() == 7
    spare = tmp_path / "symgen-someone"
    assert len(modules(spare)) == 1
    assert spare.stat().st_mode & 0o777 == 0o700
    assert count() == 1


@pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="only root may give a folder away"
)
def test_a_temporary_folder_of_another_user_is_not_trusted(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("USER", "someone")
    spare = tmp_path / "symgen-someone"
    spare.mkdir()
    os.chown(spare, 4242, 4242)
    with pytest.raises(symgen.BuildError, match="belongs to another user; set SYMGEN_CACHE"):
        build_module(SOURCES, DECLARATIONS, Compiler(("cc",), ""))


# What is loaded is run: nothing of somebody else's is.


@needs_cc
def test_the_cache_is_private_whatever_the_umask(counted, cache):
    compiler, _ = counted
    before = os.umask(0)
    try:
        build_module(SOURCES, DECLARATIONS, compiler)
    finally:
        os.umask(before)
    (name,) = modules(cache)
    assert cache.stat().st_mode & 0o777 == 0o700
    assert (cache / name).stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        (0o777, "may be written by others"),
        (0o770, "may be written by others"),
        (None, "is a link"),
    ],
)
def test_a_cache_that_others_may_write_or_a_link_is_refused(mode, words, cache, tmp_path):
    (tmp_path / "real").mkdir(mode=0o700)
    if mode is not None:
        (tmp_path / "real").chmod(mode)
        (tmp_path / "real").rename(cache)
    else:
        cache.symlink_to(tmp_path / "real")
    with pytest.raises(symgen.BuildError, match=f"{words}; set SYMGEN_CACHE"):
        build_module(SOURCES, DECLARATIONS, Compiler(("cc",), ""))
    assert list(cache.iterdir()) == []


def test_a_user_without_a_home_has_a_cache(monkeypatch, tmp_path):
    def nowhere() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("SYMGEN_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("USER", "someone")
    assert cache_folder() == tmp_path / "symgen-someone"


# Compilers that fail, and none.


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            'echo "x.c:1:2: warning: hm" >&2; echo "x.c:3:4: error: boom" >&2; '
            "echo more >&2; exit 1",
            r"failed on the generated C: x\.c:3:4: error: boom",
        ),
        ("echo one >&2; echo two >&2; exit 1", "failed on the generated C"),
        ("exit 1", "failed on the generated C"),
        ("exit 0", "failed on the generated C"),
    ],
    ids=["error", "no error line", "silent", "no output"],
)
def test_a_compiler_that_fails_gives_one_line_and_leaves_nothing(body, words, tmp_path, cache):
    compiler = Compiler((script(tmp_path / "bad-cc", body),), "fake 1")
    with pytest.raises(symgen.BuildError, match=words) as caught:
        build_module(SOURCES, DECLARATIONS, compiler)
    assert "\n" not in str(caught.value)
    assert "bad-cc" in str(caught.value)
    assert list(cache.iterdir()) == []


def test_a_compiler_that_prints_what_is_not_utf_8_is_one_line(tmp_path, monkeypatch):
    body = r"""printf 'x.c:1: error: \377\376 \033[31mred\n' >&2; exit 1"""
    compiler = Compiler((script(tmp_path / "latin-cc", body),), "fake 1")
    with pytest.raises(symgen.BuildError, match=r"latin-cc failed .*: x\.c:1: error"):
        build_module(SOURCES, DECLARATIONS, compiler)
    speaks = tmp_path / "speaks-cc"
    speaks.write_text(r"""#!/bin/sh
printf 'caf\351 cc 1\n'
""")
    speaks.chmod(0o755)
    monkeypatch.setenv("SYMGEN_CC", str(speaks))
    found = find_compiler()
    assert found is not None
    assert found.version == "caf\N{REPLACEMENT CHARACTER} cc 1"


def test_a_module_that_cannot_be_loaded_is_a_build_error(tmp_path):
    body = 'for a; do case "$a" in *.so) echo nonsense > "$a";; esac; done'
    compiler = Compiler((script(tmp_path / "odd-cc", body),), "fake 1")
    with pytest.raises(symgen.BuildError, match="cannot be loaded"):
        build_module(SOURCES, DECLARATIONS, compiler)


def test_without_a_compiler_casadi_evaluates_and_a_warning_says_so_once(monkeypatch):
    monkeypatch.setenv("SYMGEN_CC", "none")
    assert find_compiler() is None
    with pytest.warns(symgen.SymgenWarning, match=r"symgen\[cc\]") as caught:
        loaded = symgen.load("planar2r")
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert loaded.backend == "casadi"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = symgen.load("planar2r")
    assert again.energy_regressor([0.1, 0.2], [1.0, 0.0])[0] == 0.5


def test_a_failing_compiler_is_a_warning_by_default_and_an_error_for_backend_c(
    tmp_path, monkeypatch
):
    bad = script(tmp_path / "bad-cc", "echo 'x: error: boom' >&2; exit 1")
    monkeypatch.setenv("SYMGEN_CC", bad)
    with pytest.warns(symgen.SymgenWarning, match="boom.*CasADi"):
        assert symgen.load("planar2r").backend == "casadi"
    with pytest.raises(symgen.BuildError, match="boom"):
        symgen.load("planar2r", backend="c")


@needs_cc
def test_the_chosen_compiler_comes_before_cc_and_cc_before_the_usual_ones(tmp_path, monkeypatch):
    mine, other = (script(tmp_path / name, 'exec cc "$@"') for name in ("mine", "other"))
    found = find_compiler()
    assert found is not None
    assert found.command == ("cc",)
    monkeypatch.setenv("CC", f"{other} -g")
    forget_compilers()
    found = find_compiler()
    assert found is not None
    assert found.command == (other, "-g")
    monkeypatch.setenv("SYMGEN_CC", mine)
    forget_compilers()
    assert find_compiler() == Compiler((mine,), "fake 1")


def test_a_chosen_compiler_that_does_not_exist_is_named_in_the_error(monkeypatch):
    monkeypatch.setenv("SYMGEN_CC", "no-such-cc")
    with pytest.raises(symgen.BuildError, match="no-such-cc"):
        symgen.load("planar2r", backend="c")


@needs_cc
def test_other_limits_and_names_derive_and_compile_nothing_again(cache):
    robot = symgen.read_robot("planar2r")
    symgen.load(symgen.derive(robot))
    made = set(cache.iterdir())
    joints = tuple(replace(joint, name=f"arm_{joint.number}") for joint in robot.joints)
    limited = replace(robot, joints=joints, limits=Limits(velocity=(1.0, 2.0)), log=LogForm("q=a"))
    symgen.load(symgen.derive(limited))
    assert set(cache.iterdir()) == made
