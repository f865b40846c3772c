"""The terminal: completion in bash, a bar with the time left, one line a run, commands to try."""

from __future__ import annotations

import io
import re
import shlex
import shutil
import subprocess
import sys

import pytest
import rich.progress  # noqa: F401 -- before a test sets the clock that it takes at its import
from documented import shell
from support import PROJECT
from support_commands import in_terminal

from symgen import names
from symgen.cli import progress
from symgen.cli.generate import NEXT
from symgen.cli.group import cli
from symgen.codegen import c_printer, package
from symgen.estimation.equation_model import NEEDED
from symgen.experiment import plan
from symgen.identification import solving
from symgen.report.content.parts import run_lines

BASH = shutil.which("bash")


@pytest.mark.skipif(BASH is None, reason="bash is not on PATH")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("symgen di", {"diagnose"}),
        ("symgen identify --meth", {"--method"}),
        ("symgen identify pan", {"panda", "pan.urdf"}),
        ("symgen identify panda --method h", {"huber"}),
        ("symgen explain gravity_", {"gravity_spring"}),
    ],
)
def test_bash_completes(typed: str, offered: set[str], tmp_path) -> None:
    """As bash does it: the function that the script registers, with the words that were typed."""
    words = typed.split()
    script = f"""
_SYMGEN_COMPLETE=bash_source symgen > symgen.bash
source symgen.bash
touch pan.urdf
complete -p symgen | grep -q _symgen_completion
COMP_WORDS=({shlex.join(words)}); COMP_CWORD={len(words) - 1}; COMPREPLY=()
_symgen_completion symgen {shlex.quote(words[-1])} {shlex.quote(words[-2])} || true
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    done = shell(script, tmp_path)
    assert done.returncode == 0, done.stderr
    assert offered <= set(done.stdout.split()), done.stdout + done.stderr


def words_of(command: str, option: str) -> set[str]:
    """Return the words that an option of a command offers."""
    (found,) = [p for p in cli.commands[command].params if p.name == option]
    return {*found.type.choices}


def test_options_offer_the_words_of_the_tables() -> None:
    assert words_of("identify", "model") == {"auto", *NEEDED}
    assert words_of("excite", "model") == words_of("study", "models") == {*NEEDED}
    assert words_of("identify", "method") == {*solving.ALL_METHODS}
    assert words_of("study", "methods") == {*solving.ALL_METHODS}
    assert words_of("generate", "target") == {*package.TARGETS, "all"} == {*NEXT}
    assert words_of("generate", "dtype") == {*c_printer.DTYPES}
    assert words_of("excite", "to") == {*plan.FORMATS}
    assert words_of("import", "base") == {*names.BASES}


def test_a_bar_comes_after_two_seconds_on_a_terminal_and_never_in_a_file(monkeypatch) -> None:
    class Screen(io.StringIO):
        def isatty(self) -> bool:
            return True

    def shown(stream: io.StringIO, seconds: float, said: str = "solving 12 equations") -> str:
        clock = iter([0.0, *[seconds] * 99])
        monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv("COLUMNS", "120")
        with progress.stages({"days": 0.2, "solving": 0.5}) as told:
            told(said)
        return stream.getvalue()

    assert "about 8 s left" in shown(Screen(), 8.0)
    assert "about 10 min left" in shown(Screen(), 600.0)
    # half of what lies between 0.2 and 0.5 of the time: 8 s were 0.35 of it
    assert "about 15 s left" in shown(Screen(), 8.0, "days: 20 of 40 days, 2 a second")
    assert "left" not in shown(Screen(), 1.0)
    assert "left" not in shown(io.StringIO(), 8.0)


SCHEMAS = PROJECT / "tests" / "reference" / "schemas"


@pytest.mark.parametrize("width", [80, 60])
@pytest.mark.parametrize("folder", ["estimate-2", "diagnosis-1", "payload-1"])
def test_no_line_is_wider_than_the_terminal_and_no_word_is_cut(folder, width) -> None:
    typed = ["report", str(SCHEMAS / folder)]
    shown = in_terminal(typed, width)
    assert [line for line in shown.splitlines() if len(line) > width] == []
    assert "\u2026" not in shown
    piped = subprocess.run(
        [sys.executable, "-m", "symgen", *typed], capture_output=True, text=True, timeout=60
    ).stdout
    words = {word.rstrip(":;") for word in shown.split()}
    assert {word.rstrip(":;") for word in piped.split()} <= words


def test_a_run_says_band_cutoff_speeds_and_repairs_in_one_line() -> None:
    from symgen.estimation.band import Band
    from symgen.faults.fault import CONVERTED, Fault

    mended = Fault("a.csv", "qd2", "1.8 ms late", 400, "shifted")
    first, *rest = run_lines(Band(500.0, 12.5, 3.5, "measured"), (mended, mended))
    assert re.match(
        r"run: 500 Hz, positions and speeds below 12.5 Hz, torques compared below 3.5 Hz, "
        r"speeds measured; repaired: qd2 of a.csv$",
        first,
    )
    assert rest == ["repair: a.csv: qd2: 1.8 ms late, 400 samples: shifted"]
    unit = Fault("a.csv", "q1", "in deg by the header", 0, "converted to rad", kind=CONVERTED)
    first, *rest = run_lines(None, (unit,))
    assert first == "run: no band; repaired: nothing"
    assert rest == ["note: a.csv: q1: in deg by the header: converted to rad"]
