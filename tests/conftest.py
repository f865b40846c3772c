"""Fixtures of all tests, the order of their files, and what of long families waits for -m slow.

`SYMGEN_DURATIONS=1 pytest -m "slow or not slow" -n auto` writes what tests take into
durations.json. Cases of one test that take more than FAMILY seconds together are drawn by the seed
SAMPLE, as many as fit, and the shortest where none does; the others run with -m slow. A new test
above LONGEST seconds that is not marked slow fails. After `SYMGEN_SECONDS`, tests are skipped.
"""

from __future__ import annotations

import gc
import itertools
import json
import math
import os
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

# As the command line does: threads of NumPy make tests no faster, and their processor time longer.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from packages import write
from support import SAMPLE, messages

from symgen import cli

gc.disable()  # until all tests are known: modules and cases are no garbage, and slow to look at
#: Seconds of processor time, of this process and those that it starts, by file and test.
DURATIONS = Path(__file__).with_name("durations.json")
#: Seconds for the cases of one test, and from which a case's own and another test's are kept.
FAMILY, KEPT, LONG = 2.0, 0.2, 1.0
#: Seconds that a test of the default suite may take, without its fixtures. On a slower machine a
#: test that is known to be within them takes more.
LONGEST = 3.0
#: Seconds after which no test of a run begins, and when the run began.
_SECONDS, _BEGUN = float(os.environ.get("SYMGEN_SECONDS", "inf")), time.monotonic()
_KNOWN: dict[str, float] = json.loads(DURATIONS.read_text("utf-8"))
_TAKEN: Counter[str] = Counter()


@pytest.fixture
def command(monkeypatch, capsys) -> Callable[..., tuple[int, str, str]]:
    """Run the command line in this process; return (exit code, stdout, stderr)."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["symgen", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            cli.main()
        out, err = capsys.readouterr()
        return caught.value.code, out, err

    return call


@pytest.fixture
def run(command) -> Callable[..., tuple[int, str, list[str]]]:
    """Run the command line in this process; return (exit code, stdout, lines on stderr)."""

    def call(*arguments):
        code, out, err = command(*arguments)
        return code, out, messages(err)

    return call


@pytest.fixture(scope="session")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return the folder of a robot's package with every kernel, in double or float.

    It is made once a session, and only read. Workers of pytest-xdist share it.
    """
    base = tmp_path_factory.getbasetemp()
    root = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "complete"

    def package(name: str, dtype: str) -> Path:
        folder = root / dtype / name
        if not folder.is_dir():
            folder.parent.mkdir(parents=True, exist_ok=True)
            own = write(name, dtype, tmp_path_factory.mktemp("complete") / name, "all")
            with suppress(OSError):  # another worker was first
                own.rename(folder)
        return folder

    return package


def pytest_configure(config: pytest.Config) -> None:
    """Have pytest-xdist take files in the order in which they stand, not by their tests' number."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put long files first, so that no worker is left with one; draw the cases of long families.

    Tests that rounding once broke come before all others, also where the time does not suffice.
    """
    families: dict[str, dict[str, list[pytest.Item]]] = {}
    for item in items:
        if item.get_closest_marker("slow") is None and "[" in item.name:
            family = families.setdefault(_named(item).split("[")[0], {})
            family.setdefault(_named(item), []).append(item)
    for family in families.values():
        cases = random.Random(SAMPLE).sample(sorted(family), len(family))
        until = itertools.accumulate(_KNOWN.get(case, 0.0) for case in cases)
        drawn = [case for case, taken in zip(cases, until, strict=True) if taken <= FAMILY]
        drawn = drawn or [min((case for case in cases if case in _KNOWN), key=_KNOWN.__getitem__)]
        for case in set(cases) - set(drawn):
            for item in family[case]:
                item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: -_KNOWN.get(_file(item), math.inf))
    items.sort(key=lambda item: item.get_closest_marker("rounding") is None)


def pytest_collection_finish() -> None:
    """Leave what exists before the first test to no later search for garbage."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """Skip the tests for which no time is left."""
    if time.monotonic() - _BEGUN > _SECONDS:
        pytest.skip(f"not run: the {_SECONDS:g} s of SYMGEN_SECONDS are over")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Add what a test takes, with its fixtures, to its file and its own."""
    begun = sum(os.times()[:4])
    found = yield
    taken = sum(os.times()[:4]) - begun
    _TAKEN[_file(item)] += taken
    _TAKEN[_named(item)] += taken
    return found


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test of the default suite that takes too long; a busy machine makes none longer.

    Threads of NumPy do, six times where they wait for each other: with more than one, none fails.
    """
    begun = sum(os.times()[:4])
    found = yield
    taken = sum(os.times()[:4]) - begun
    told = _named(item) in _KNOWN and not os.environ.get("SYMGEN_DURATIONS")
    told = told or os.environ["OPENBLAS_NUM_THREADS"] != "1"
    if taken > LONGEST and not told and item.get_closest_marker("slow") is None:
        pytest.fail(f"takes {taken:.1f} s of processor time; accepted: {LONGEST:g} s, or slow")
    return found


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep what the tests of this run took; a worker hands it to the one who gave it work."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["taken"] = dict(_TAKEN)
    elif os.environ.get("SYMGEN_DURATIONS"):
        known = _KNOWN | {
            name: round(seconds, 1)
            for name, seconds in _TAKEN.items()
            if "::" not in name or seconds >= (KEPT if "[" in name else LONG)
        }
        DURATIONS.write_text(json.dumps(dict(sorted(known.items())), indent=1) + "\n", "utf-8")


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Add what the tests of a worker took."""
    _TAKEN.update(getattr(node, "workeroutput", {}).get("taken", {}))


def _file(item: pytest.Item) -> str:
    """Return the file of a test, as seen from the folder of tests."""
    return item.path.relative_to(DURATIONS.parent).as_posix()


def _named(item: pytest.Item) -> str:
    """Return a test by file and name."""
    return f"{_file(item)}::{item.name}"
