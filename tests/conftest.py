"""Fixtures of all tests, and the order of their files: the long ones first.

`SYMGEN_DURATIONS=1 pytest FILE...`, without -n, writes what files take into durations.json.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from symgen import cli

#: Seconds of processor time, of this process and those that it starts, by file.
DURATIONS = Path(__file__).with_name("durations.json")
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


def pytest_configure(config: pytest.Config) -> None:
    """Have pytest-xdist take files in the order in which they stand, not by their tests' number."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put long files first, and new ones: no worker is left with one when the others have ended."""
    known = json.loads(DURATIONS.read_text("utf-8"))
    items.sort(key=lambda item: -known.get(_file(item), math.inf))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Add what a test takes, with its fixtures, to its file."""
    begun = sum(os.times()[:4])
    found = yield
    _TAKEN[_file(item)] += sum(os.times()[:4]) - begun
    return found


def pytest_sessionfinish() -> None:
    """Keep what the files of this run took."""
    if os.environ.get("SYMGEN_DURATIONS"):
        known = json.loads(DURATIONS.read_text("utf-8"))
        known |= {file: round(seconds, 1) for file, seconds in _TAKEN.items()}
        DURATIONS.write_text(json.dumps(dict(sorted(known.items())), indent=1) + "\n", "utf-8")


def _file(item: pytest.Item) -> str:
    """Return the file of a test, as seen from the folder of tests."""
    return item.path.relative_to(DURATIONS.parent).as_posix()
