"""symgen demo: an arm with a hidden spring, with a compiler and without."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from documented import assert_quoted, blocks
from support import PROJECT
from support_commands import in_terminal


def _demo(folder: Path, compiler: str, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "symgen", "demo", *options],
        cwd=folder, capture_output=True, text=True, env={**os.environ, "SYMGEN_CC": compiler},
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="xdg-open opens pages on Linux alone")
def test_a_page_is_opened_in_a_terminal_alone(tmp_path) -> None:
    opened, opener = tmp_path / "opened", tmp_path / "xdg-open"
    opener.write_text(f'#!/bin/sh\necho "$1" >> {opened}\n')
    opener.chmod(0o755)
    path = {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    piped = subprocess.run(
        [sys.executable, "-m", "symgen", "demo", "--into", "piped"],
        cwd=tmp_path, capture_output=True, text=True, env=os.environ | path,
    )  # fmt: skip
    assert piped.returncode == 0, piped.stderr
    assert not opened.exists()
    in_terminal(["demo", "--into", "shown"], folder=tmp_path, **path)
    for _ in range(100):  # the opener is not waited for
        if opened.exists():
            break
        time.sleep(0.1)
    assert opened.read_text().split() == [str(tmp_path / "shown" / "diagnosis" / "report.html")]


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["", "none"])
def test_the_hidden_spring_is_found_and_the_gap_closes(tmp_path, compiler) -> None:
    done = _demo(tmp_path, compiler)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "symgen-demo"
    told = json.loads((folder / "diagnosis" / "diagnosis.json").read_text("utf-8"))
    (effect,) = told["effects"]
    assert (effect["name"], effect["joints"]) == ("gravity_spring", [2])
    assert abs(effect["parameters"][0]["value"] - 60) < 3 * effect["parameters"][0]["std"]
    assert told["gap"]["after"]["total"] < told["gap"]["before"]["total"] / 5
    shown = (b.code for b in blocks(PROJECT / "README.md") if b.kind == "output")
    assert_quoted(next(shown), done.stdout)
    identified = json.loads((folder / "identified" / "estimate.json").read_text("utf-8"))
    assert identified["physical"]["distance_sigma"] is not None
    for name in ("identified", "diagnosis", "better"):
        assert (folder / name / "report.html").is_file()
