"""symgen doctor: what it finds, and what it says where something is missing."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from support import forget_compilers

from symgen.runtime import doctor


def _named() -> dict[str, doctor.Finding]:
    forget_compilers()
    try:
        return {f.name: f for f in doctor.examine()}
    finally:
        forget_compilers()


def test_everything_that_is_needed_is_found_here() -> None:
    found = _named()
    assert all(f.well for f in found.values())
    assert found["Python"].found.startswith(f"{sys.version_info[0]}.{sys.version_info[1]}.")
    assert found["numpy"].found == __import__("numpy").__version__


def test_a_missing_compiler_is_said_and_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYMGEN_CC", "none")
    found = _named()["C compiler"]
    assert found.well
    assert found.found.startswith("none")
    assert "symgen[cc]" in found.advice


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
def test_a_compiler_that_asks_for_declarations_is_well(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As GCC from 14 and clang from 16 do by default."""
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("SYMGEN_CC", "cc -Werror=implicit-function-declaration")
    monkeypatch.setenv("SYMGEN_FLAGS", "plain")
    found = _named()["C compiler"]
    assert "fails" not in found.found
    assert found.advice == ""


def test_a_missing_library_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    known = doctor.util.find_spec
    monkeypatch.setattr(doctor.util, "find_spec", lambda n: None if n == "casadi" else known(n))
    found = _named()["casadi"]
    assert not found.well
    assert found.advice == "pip install casadi"


def test_what_to_do_is_whole_in_a_narrow_terminal(monkeypatch: pytest.MonkeyPatch, command) -> None:
    known = doctor.util.find_spec
    monkeypatch.setattr(doctor.util, "find_spec", lambda n: None if n == "mujoco" else known(n))
    monkeypatch.setenv("COLUMNS", "40")
    code, out, _ = command("doctor")
    assert code == 0
    assert "C compiler" in out
    assert "mujoco: pip install 'symgen[mjcf]'" in out.splitlines()


def test_the_version_is_short_to_ask_for(command) -> None:
    from importlib.metadata import version

    assert command("-V") == command("--version")
    code, out, _ = command("-V")
    assert code == 0
    assert version("symgen") in out
