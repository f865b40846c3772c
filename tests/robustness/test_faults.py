"""Kills, full disks, folders that cannot be written, no home, no compiler: nothing half-written.

A few kills of every command by default; 200 over all commands, on purpose:

    pytest -m slow tests/robustness/test_faults.py

SYMGEN_KILLS sets their number.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from support import messages
from support_commands import LIMITS, PARAMETERS, URDF

import symgen
from symgen.results import read_result

KILLS = int(os.environ.get("SYMGEN_KILLS", "200"))
pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")

#: Command: its arguments, what it writes, and how that is read again.
COMMANDS: dict[str, tuple[list[str], str, Callable[[Path], object]]] = {
    "generate": (["planar2r", "--target", "c"], "out", lambda p: _listed(p, "manifest.json")),
    "import": (["one.urdf"], "out.toml", symgen.read_robot),
    "excite": (
        ["planar2r", *LIMITS, "--duration", "2", "--searches", "1", "--budget", "1"]
        + ["--parameters", "p.toml"],
        "out.csv",
        lambda p: _whole(p),
    ),
    "simulate": (
        ["planar2r", "--parameters", "p.toml", "--duration", "4"],
        "out.csv",
        lambda p: symgen.read_log(p),
    ),
    "identify": (["planar2r", "log.csv"], "out", read_result),
    "predict": (["planar2r", "log.csv", "--parameters", "p.toml"], "out", read_result),
    "diagnose": (["planar2r", "log.csv"], "out", read_result),
    "report": (["est"], "out.html", lambda p: _whole(p)),
    "demo": (["--runs", "20"], "out", lambda p: _whole(p / "demo.html")),
}

#: Beside the commands that a default test takes.
SLOW = [
    pytest.param(c, marks=pytest.mark.slow) for c in ("generate", "simulate", "predict", "report")
]


def _listed(folder: Path, marker: str) -> None:
    """Look at a package: every file that its manifest lists is there."""
    digests = json.loads((folder / marker).read_text())["digests"]
    assert {name for name in digests if not (folder / name).is_file()} == set()


def _whole(path: Path) -> None:
    """Look at a text that ends as its writer ends it."""
    text = path.read_text()
    assert text.rstrip().endswith("</html>") if path.suffix == ".html" else text.endswith("\n")


def start(world: Path, command: str, into: str, **options: object) -> subprocess.Popen[str]:
    """Start a command that writes `into`, in a session of its own."""
    arguments, _, _ = COMMANDS[command]
    return subprocess.Popen(
        [sys.executable, "-m", "symgen", command, *arguments, "--into", into],
        cwd=world,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **options,  # type: ignore[call-overload]
    )


def finished(job: subprocess.Popen[str]) -> tuple[int, str, list[str]]:
    """Return exit code, stdout and the lines on stderr that are no progress."""
    out, err = job.communicate(timeout=300)
    return job.returncode, out, messages(err)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory):
    """A folder with a log, an estimate and a URDF, and a cache of compiled models of its own."""
    folder = tmp_path_factory.mktemp("world")
    patch = pytest.MonkeyPatch()
    patch.setenv("SYMGEN_CACHE", str(tmp_path_factory.mktemp("cache") / "symgen"))
    (folder / "p.toml").write_text(PARAMETERS)
    (folder / "one.urdf").write_text(URDF)
    for command, into in (("simulate", "log.csv"), ("identify", "est")):
        code, _, said = finished(start(folder, command, into))
        assert code in (0, 1), said
    yield folder
    patch.undo()


def state(folder: Path) -> dict[str, bytes]:
    """Return what is in a folder, without what begins with a dot."""
    return {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and not any(part[0] == "." for part in p.relative_to(folder).parts)
    }


def _killed(world: Path, command: str, after: float) -> None:
    """Kill a command after so many seconds: what it was to write is absent or whole."""
    _, into, read = COMMANDS[command]
    before = state(world)
    job = start(world, command, into)
    try:
        job.wait(after)
    except subprocess.TimeoutExpired:
        os.killpg(job.pid, signal.SIGKILL)
    job.communicate()
    now = state(world)
    written = {name for name in now if name not in before}
    assert {name: now.get(name) for name in before} == before
    # excite writes out.json beside out.csv.
    roots = {name.split("/")[0] for name in written}
    assert roots <= {into, "out.json", "one_parameters.toml"}
    if written:
        read(world / into)


def _clear(world: Path) -> None:
    for path in (*world.glob("out*"), world / "one_parameters.toml"):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def _kills(world: Path, command: str, count: int, seed: int) -> None:
    _clear(world)
    begun = time.monotonic()
    code, _, said = finished(start(world, command, COMMANDS[command][1]))
    lasts = time.monotonic() - begun
    assert code in (0, 1), said
    draw = random.Random(f"{command} {seed}")
    for _ in range(count):
        _clear(world)
        _killed(world, command, lasts * draw.random())
    _clear(world)
    code, _, said = finished(start(world, command, COMMANDS[command][1]))
    assert code in (0, 1), said
    COMMANDS[command][2](world / COMMANDS[command][1])
    _clear(world)


@pytest.mark.parametrize("command", ["identify", *SLOW])
def test_a_killed_command_leaves_nothing_half_written(world, command):
    _kills(world, command, 1, 0)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_200_kills_leave_nothing_half_written(world, command):
    _kills(world, command, -(-KILLS // len(COMMANDS)), 1)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_interrupted_at_any_time_is_a_line(world, command):
    begun = time.monotonic()
    finished(start(world, command, COMMANDS[command][1]))
    lasts = time.monotonic() - begun
    for k in range(6):
        _clear(world)
        job = start(world, command, COMMANDS[command][1])
        # Before this the interpreter itself is starting, and what it says is its own.
        time.sleep(0.15 + lasts * k / 6)
        job.send_signal(signal.SIGINT)
        _, err = job.communicate(timeout=60)
        assert "Traceback" not in err, err
        assert job.returncode in (0, 1, 130)
    _clear(world)


# The disk and the folders.


def small_disk() -> None:
    """Let files grow to 3 kB and no further, as a disk that is full does."""
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))


@pytest.mark.parametrize("command", ["identify", *SLOW])
def test_a_full_disk_is_a_line_and_leaves_nothing(world, command):
    # Compiled models are there already, or CasADi takes their place.
    before, hidden = state(world), set(world.iterdir())
    into = f"full-{COMMANDS[command][1]}"
    environment = {**os.environ, "SYMGEN_CC": "none", "PYTHONDONTWRITEBYTECODE": "1"}
    job = start(world, command, into, preexec_fn=small_disk, env=environment)
    code, _, said = finished(job)
    said = [line for line in said if "warning" not in line]
    assert (code, len(said)) == (2, 1), said
    assert said[0].startswith("symgen: error: ")
    assert state(world) == before
    assert set(world.iterdir()) == hidden


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no folder that even root cannot write")
@pytest.mark.parametrize("command", ["identify", *SLOW])
def test_a_folder_that_cannot_be_written_is_a_line(world, command):
    before = state(world)
    code, _, said = finished(start(world, command, f"/proc/{COMMANDS[command][1]}"))
    assert (code, len(said)) == (2, 1), said
    assert f"/proc/{COMMANDS[command][1]}" in said[0]
    assert state(world) == before


# The surroundings.


@pytest.mark.parametrize(
    "change",
    [
        {"HOME": None, "XDG_CACHE_HOME": None, "SYMGEN_CACHE": None},
        pytest.param({"SYMGEN_CC": "broken"}, marks=pytest.mark.slow),
        pytest.param(
            {"HOME": "/proc/none", "XDG_CACHE_HOME": None, "SYMGEN_CACHE": None},
            marks=pytest.mark.slow,
        ),
        pytest.param({"SYMGEN_CC": "none"}, marks=pytest.mark.slow),
        pytest.param({"SYMGEN_CC": "false"}, marks=pytest.mark.slow),
    ],
    ids=["no home", "broken compiler", "a home that is not there", "no compiler", "no answer"],
)
def test_a_poor_machine_gives_the_same_answer(world, tmp_path, change):
    broken = tmp_path / "broken"
    broken.write_text('#!/bin/sh\ncase "$1" in --version) echo broken 1;; *) exit 1;; esac\n')
    broken.chmod(0o755)
    change = {k: str(broken) if v == "broken" else v for k, v in change.items()}
    wanted = {**os.environ, "TMPDIR": str(tmp_path), **change}
    environment = {k: v for k, v in wanted.items() if v is not None}
    into = str(tmp_path / "est")
    code, _, said = finished(start(world, "identify", into, env=environment))
    assert code == 0, said
    assert len(said) <= 1
    for line in said:  # that CasADi takes the compiler's place
        assert line.startswith("symgen: warning: ")
    here, there = (read_result(p) for p in (world / "est", into))
    assert abs(here.X - there.X).max() <= 1e-8 * abs(here.X).max()


# A model of its own, so that the cache of another test does not have it.
BUILD = """
import symgen
text = symgen.robot_toml(symgen.read_robot("planar2r")).replace("L1 = 0.5", "L1 = 0.4375")
evaluator = symgen.load(symgen.parse_robot(text), backend="c")
print(evaluator.energy_regressor([0.1, 0.2], [1.0, 0.0])[0])
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
@pytest.mark.parametrize("jobs", [pytest.param(4), pytest.param(20, marks=pytest.mark.slow)])
def test_builds_at_once_all_succeed_and_leave_one_module(jobs, tmp_path):
    environment = {**os.environ, "SYMGEN_CACHE": str(tmp_path / "cache")}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", BUILD],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        for _ in range(jobs)
    ]
    answers = [job.communicate(timeout=500) for job in started]
    assert {job.returncode for job in started} == {0}, answers
    assert {out for out, _ in answers} == {"0.5\n"}
    assert len(list((tmp_path / "cache").glob("*.so"))) == 1
