"""Kills, full disks, folders that cannot be written, no home, no compiler: nothing half-written.

One kill of one command by default, which SYMGEN_SEED draws; 200 over all commands, on purpose:

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
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from support import heeds_ctrl_c, messages
from support_commands import LIMITS, LOADED, PARAMETERS, URDF

import symgen
from symgen.report.store import load_result

KILLS = int(os.environ.get("SYMGEN_KILLS", "200"))
SEED = os.environ.get("SYMGEN_SEED", "1")
pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")

_EXCITE = ["planar2r", *LIMITS, "--duration", "2", "--searches", "1", "--budget", "1"]
_EXCITE += ["--parameters", "p.toml"]

#: Command, and which use of it: its arguments, what it writes, and how that is read again.
COMMANDS: dict[str, tuple[list[str], str, Callable[[Path], object]]] = {
    "generate": (["planar2r", "--target", "c"], "out", lambda p: _listed(p, "manifest.json")),
    "import": (["one.urdf"], "out.toml", symgen.read_robot),
    "generate --tex": (["planar2r", "--tex"], "out", lambda p: _listed(p, "manifest.json")),
    "excite": (_EXCITE, "out.csv", lambda p: _whole(p)),
    "excite --to ros": (
        [*_EXCITE, "--to", "ros"],
        "out.csv",
        lambda p: (_whole(p), _whole(p.with_suffix(".yaml"))),
    ),
    "simulate": (
        ["planar2r", "--parameters", "p.toml", "--duration", "4"],
        "out.csv",
        lambda p: symgen.read_log(p),
    ),
    "identify": (["planar2r", "log.csv"], "out", load_result),
    "predict": (["planar2r", "log.csv", "--parameters", "p.toml"], "out", load_result),
    "diagnose": (["planar2r", "log.csv"], "out", load_result),
    "payload": (["planar2r", "loaded.csv", "--parameters", "p.toml"], "out", load_result),
    "export": (["arm-est", "--from", "arm.urdf"], "out.urdf", symgen.read_robot),
    "report": (["est"], "out.html", lambda p: _whole(p)),
    "report of two": (["est", "est"], "out.html", lambda p: _whole(p)),
    "demo": ([], "out", lambda p: _whole(p / "demo.html")),
}

#: Beside the commands that a default test takes.
SLOW = [
    pytest.param(c, marks=pytest.mark.slow)
    for c in ("generate", "identify", "simulate", "predict", "payload", "export")
]


def _listed(folder: Path, marker: str) -> None:
    """Look at a package: every file that its manifest lists is there."""
    digests = json.loads((folder / marker).read_text())["digests"]
    assert {name for name in digests if not (folder / name).is_file()} == set()


def _whole(path: Path) -> None:
    """Look at a text that ends as its writer ends it."""
    text = path.read_text()
    assert text.rstrip().endswith("</html>") if path.suffix == ".html" else text.endswith("\n")


def line(command: str, into: str) -> list[str]:
    """Return the words that run a command, which writes `into`."""
    arguments, _, _ = COMMANDS[command]
    option = "--to" if command == "export" else "--into"  # what it writes
    return [sys.executable, "-m", "symgen", command.split()[0], *arguments, option, into]


def start(world: Path, command: str, into: str, **options: object) -> subprocess.Popen[str]:
    """Start a command that writes `into`, in a session of its own."""
    return subprocess.Popen(
        line(command, into),
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
    assert "Traceback" not in err, err  # Python ends with 1, too
    return job.returncode, out, messages(err)


#: What some commands read beside that, and how it is made.
BEFORE = {
    "payload": [("simulate", "planar2r --parameters loaded.toml --duration 4 --into loaded.csv")],
    "export": [
        ("import", "arm.urdf --into arm.toml"),
        ("simulate", "arm.toml --parameters arm_parameters.toml --duration 4 --into arm.csv"),
        ("identify", "arm.toml arm.csv --into arm-est"),
    ],
}


def run(folder: Path, command: str, words: str) -> None:
    """Run a command that has an answer."""
    script = [sys.executable, "-m", "symgen", command, *words.split()]
    done = subprocess.run(script, cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    assert "Traceback" not in done.stderr, done.stderr  # Python ends with 1, too


@pytest.fixture(scope="module")
def common(tmp_path_factory: pytest.TempPathFactory):
    """A folder with a log, an estimate and URDFs, and a cache of compiled models of its own."""
    folder = tmp_path_factory.mktemp("world")
    patch = pytest.MonkeyPatch()
    patch.setenv("SYMGEN_CACHE", str(tmp_path_factory.mktemp("cache") / "symgen"))
    (folder / "p.toml").write_text(PARAMETERS)
    (folder / "loaded.toml").write_text(LOADED)
    (folder / "one.urdf").write_text(URDF)
    (folder / "arm.urdf").write_text(URDF.replace('"one"', '"arm"').replace('ort="1"', 'ort="9"'))
    run(folder, "simulate", "planar2r --parameters p.toml --duration 4 --into log.csv")
    run(folder, "identify", "planar2r log.csv --into est")
    yield folder
    patch.undo()


@pytest.fixture
def world(common: Path, request: pytest.FixtureRequest) -> Path:
    """The folder, with what the test's command reads."""
    parameters = getattr(request.node, "callspec", None)
    steps = BEFORE.get(parameters and parameters.params.get("command"), [])
    for command, words in steps:
        if not (common / words.split()[-1]).exists():
            run(common, command, words)
    return common


def state(folder: Path) -> dict[str, bytes]:
    """Return what is in a folder, without what begins with a dot."""
    return {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and not any(part[0] == "." for part in p.relative_to(folder).parts)
    }


def _killed(world: Path, command: str, after: float) -> str:
    """Kill a command after so many seconds: what it was to write is absent or whole.

    Returns:
        "finished" before it was killed, or what it left: "whole" or "absent".
    """
    _, into, read = COMMANDS[command]
    before = state(world)
    job = start(world, command, into)
    end = "finished"
    try:
        job.wait(after)
    except subprocess.TimeoutExpired:
        end = "absent"
        os.killpg(job.pid, signal.SIGKILL)
    job.communicate()
    now = state(world)
    written = {name for name in now if name not in before}
    assert {name: now.get(name) for name in before} == before
    # excite writes out.json, out.yaml and out.mcap beside out.csv.
    roots = {name.split("/")[0] for name in written}
    assert roots <= {into, "out.json", "out.yaml", "out.mcap", "one_parameters.toml"}
    if written:
        read(world / into)
        end = end if end == "finished" else "whole"
    return end


def _clear(world: Path) -> None:
    for path in (*world.glob("out*"), world / "one_parameters.toml"):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def _kills(world: Path, command: str, count: int, seed: int | str) -> Counter[str]:
    """Kill a command so often at random moments; return how often it left what.

    What had finished before is no kill, and is tried again, up to three times as often in all.
    """
    _clear(world)
    begun = time.monotonic()
    code, _, said = finished(start(world, command, COMMANDS[command][1]))
    lasts = time.monotonic() - begun
    assert code in (0, 1), said
    draw = random.Random(f"{command} {seed}")
    ends: Counter[str] = Counter()
    for _ in range(3 * count):
        if ends.total() - ends["finished"] < count:
            _clear(world)
            ends[_killed(world, command, lasts * draw.random())] += 1
    _clear(world)
    code, _, said = finished(start(world, command, COMMANDS[command][1]))
    assert code in (0, 1), said
    COMMANDS[command][2](world / COMMANDS[command][1])
    _clear(world)
    return ends


#: What needs nothing made before, and is quick.
QUICK = ("generate", "import", "report")


@pytest.mark.parametrize("command", random.Random(SEED).sample(QUICK, 1))
def test_a_killed_command_leaves_nothing_half_written(world, command):
    """One kill of one command; the long run kills each of all, and says what they leave."""
    _kills(world, command, 1, SEED)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_200_kills_leave_nothing_half_written(world, command):
    ends = _kills(world, command, -(-KILLS // len(COMMANDS)), 1)
    print(f"{command}: {dict(ends)}")


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_interrupted_at_any_time_is_a_line(world, command):
    begun = time.monotonic()
    finished(start(world, command, COMMANDS[command][1]))
    lasts = time.monotonic() - begun
    for k in range(6):
        _clear(world)
        job = start(world, command, COMMANDS[command][1], preexec_fn=heeds_ctrl_c)
        # Before this the interpreter itself is starting, and what it says is its own.
        time.sleep(0.15 + lasts * k / 6)
        job.send_signal(signal.SIGINT)
        _, err = job.communicate(timeout=60)
        assert "Traceback" not in err, err
        # Where it met code that exec made, CPython dies of the signal; to a shell that is 130, too.
        assert job.returncode in (0, 1, 130, -signal.SIGINT)
    _clear(world)


# The disk and the folders.


def small_disk() -> None:
    """Let files grow to 300 bytes and no further, as a disk that is full does."""
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))


@pytest.mark.parametrize("command", ["report", *SLOW])
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


#: In a mount of its own, which goes with it: a disk of 64 kB with so many bytes left.
FULL = """
mount -t tmpfs -o size=64k none "$1" || exit 77
head -c 65536 /dev/zero > "$1/filler" 2>/dev/null
truncate -s -"$2" "$1/filler"
shift 2
"$@"
code=$?
ls -A "$DISK" >&3
exit $code
"""


@pytest.mark.skipif(shutil.which("unshare") is None, reason="no unshare on this machine")
@pytest.mark.parametrize("left", [0, pytest.param(4096, marks=pytest.mark.slow)])
@pytest.mark.parametrize("command", ["report", *SLOW])
def test_a_disk_without_room_is_a_line_and_leaves_nothing(world, tmp_path, command, left):
    if command == "export" and left:
        pytest.skip("there is room for what it writes")
    disk, listing = tmp_path / "disk", tmp_path / "listing"
    disk.mkdir()
    words = line(command, str(disk / COMMANDS[command][1]))
    script = ["unshare", "-m", "sh", "-c", FULL, "sh", disk, str(left), *words]
    with listing.open("w") as file:
        done = subprocess.run(
            script,
            cwd=world,
            capture_output=True,
            text=True,
            env={**os.environ, "DISK": str(disk)},
            preexec_fn=lambda: os.dup2(file.fileno(), 3),
            pass_fds=(3, file.fileno()),
        )
    said = messages(done.stderr)
    if "unshare" in done.stderr or done.returncode == 77:
        pytest.skip(f"no mount of its own: {said[-1]}")
    assert (done.returncode, len(said)) == (2, 1), said
    assert "No space left on device" in said[0]
    assert listing.read_text().split() == ["filler"]


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no folder that even root cannot write")
@pytest.mark.parametrize("command", ["report", *SLOW])
def test_a_folder_that_cannot_be_written_is_a_line(world, command):
    before = state(world)
    code, _, said = finished(start(world, command, f"/proc/{COMMANDS[command][1]}"))
    assert (code, len(said)) == (2, 1), said
    assert f"/proc/{COMMANDS[command][1]}" in said[0]
    assert state(world) == before


# The surroundings.


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        {"HOME": None, "XDG_CACHE_HOME": None, "SYMGEN_CACHE": None},
        {"SYMGEN_CC": "broken"},
        {"HOME": "/proc/none", "XDG_CACHE_HOME": None, "SYMGEN_CACHE": None},
        {"SYMGEN_CC": "none"},
        {"SYMGEN_CC": "false"},
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
    here, there = (load_result(p) for p in (world / "est", into))
    assert abs(here.X - there.X).max() <= 1e-8 * abs(here.X).max()
