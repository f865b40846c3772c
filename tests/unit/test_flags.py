"""Flags by measurement: the race picks the fastest set, and its winner is remembered."""

from __future__ import annotations

import json
import os
import shutil
import stat

import pytest

import symgen
from symgen.runtime import doctor, flags
from symgen.runtime.build import Compiler, find_compiler
from symgen.runtime.flags import FlagSet, fastest

CC = shutil.which("cc")
pytestmark = [
    pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine"),
    pytest.mark.usefixtures("machine"),
]
# The flag says how long the work takes: a hundredfold between neighbours.
SOURCE = b"""
#include <stddef.h>
void work(size_t N, const double *in, double *out)
{
    volatile double sum = 0.0;
    for (size_t i = 0; i < N * TURNS; ++i) { sum = sum + in[0]; }
    out[0] = sum;
}
"""
FUNCTION = {"name": "work", "leading": [4], "inputs": [1], "outputs": [1]}
CONTEST = {"work.c": SOURCE}, [FUNCTION]
SLOW, FAST = FlagSet("slow", ("-DTURNS=100000",)), FlagSet("fast", ("-DTURNS=1000",))


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine that has measured nothing yet."""
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("SYMGEN_FLAGS", raising=False)


@pytest.fixture
def contest():
    """What is raced, and how often it was asked for."""
    asked = []

    def make():
        asked.append(1)
        return CONTEST

    make.asked = asked
    return make


@pytest.fixture
def compiler():
    """The compiler of this machine."""
    found = find_compiler(CC)
    assert found is not None
    return found


@pytest.mark.parametrize("sets", [(SLOW, FAST), (FAST, SLOW)])
def test_the_fastest_set_wins_wherever_it_stands(sets, compiler, contest):
    chosen = fastest("test", sets, compiler, contest)
    assert chosen.flags == FAST
    assert chosen.ratios[sets[0].name] == 1.0
    assert chosen.ratios["slow"] > 10 * chosen.ratios["fast"]


def test_sets_as_good_as_each_other_give_the_simpler_one(compiler, contest, monkeypatch):
    same = FlagSet("same", (*FAST.flags, "-DUNUSED"))
    monkeypatch.setattr(flags, "_AS_GOOD", 1.5)  # equal code on a busy machine
    assert fastest("test", (SLOW, FAST, same), compiler, contest).flags == FAST
    assert fastest("test", (SLOW, same, FAST), compiler, contest).flags == same


def test_a_set_that_the_compiler_rejects_or_the_processor_lacks_takes_no_part(compiler, contest):
    rejected = FlagSet("rejected", ("-DTURNS=1", "-fno-such-flag=anywhere"))
    lacking = FlagSet("lacking", ("-DTURNS=1",), ("__no_such_instruction__",))
    chosen = fastest("test", (SLOW, rejected, lacking, FAST), compiler, contest)
    assert chosen.flags == FAST
    assert set(chosen.ratios) == {"slow", "fast"}


def test_code_that_kills_the_race_kills_nothing_else(compiler):
    source = SOURCE.replace(b"out[0] = sum", b"__builtin_trap()")
    dying = {"work.c": source}, [FUNCTION]
    chosen = fastest("test", (SLOW, FAST), compiler, lambda: dying)
    assert (chosen.flags, dict(chosen.ratios)) == (SLOW, {})


def test_the_winner_is_remembered_by_processor_and_compiler(compiler, contest, monkeypatch):
    first = fastest("test", (SLOW, FAST), compiler, contest)
    again = fastest("test", (SLOW, FAST), compiler, contest)
    assert (again.flags, again.origin) == (first.flags, "measured before")
    assert len(contest.asked) == 1
    fastest("test", (SLOW, FAST), Compiler(compiler.command, "another"), contest)
    assert len(contest.asked) == 2
    monkeypatch.setattr(flags, "_processor", lambda: "another")
    fastest("test", (SLOW, FAST), compiler, contest)
    assert len(contest.asked) == 3


@pytest.mark.parametrize(
    "damage",
    ["", "{", "[]", "null", '{"winner": "-fplugin=evil.so", "ratios": {}}', '{"winner": "fast"}'],
)
def test_a_damaged_memory_is_measured_anew(damage, compiler, contest, tmp_path):
    fastest("test", (SLOW, FAST), compiler, contest)
    (memory,) = (tmp_path / "cache").glob("flags-test-*.json")
    memory.write_text(damage)
    assert fastest("test", (SLOW, FAST), compiler, contest).flags == FAST
    assert len(contest.asked) == 2
    assert json.loads(memory.read_text())["winner"] == "fast"
    assert [p.name for p in memory.parent.iterdir()] == [memory.name]


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="this user writes everywhere")
def test_a_cache_that_cannot_be_written_still_gives_a_winner(compiler, contest, tmp_path):
    (tmp_path / "cache").mkdir(mode=stat.S_IRUSR | stat.S_IXUSR)
    assert fastest("test", (SLOW, FAST), compiler, contest).flags == FAST


@pytest.mark.parametrize(
    ("chosen_by", "sets"),
    [(flags.chosen_flags, flags.SETS), (flags.panel_flags, flags.PANEL_SETS)],
    ids=["kernels", "panels"],
)
def test_the_kernels_and_panels_of_an_arm_are_raced(chosen_by, sets, compiler):
    chosen = chosen_by(compiler)
    assert chosen.flags in sets
    assert chosen.ratios["plain"] == 1.0
    assert chosen.ratios[chosen.flags.name] <= 1.05 * min(chosen.ratios.values())


def test_a_set_may_be_named_and_a_wrong_name_is_one_line(compiler, monkeypatch):
    monkeypatch.setenv("SYMGEN_FLAGS", "plain")
    assert flags.chosen_flags(compiler).flags.flags == ()
    assert flags.panel_flags(compiler).flags.flags == ()
    monkeypatch.setenv("SYMGEN_FLAGS", "avx512")  # of panels, and for single calls, too
    assert "-mavx512f" in flags.chosen_flags(compiler).flags.flags
    monkeypatch.setenv("SYMGEN_FLAGS", "-O3")
    with pytest.raises(symgen.BuildError, match="SYMGEN_FLAGS is '-O3'; accepted: plain, fma,"):
        flags.chosen_flags(compiler)


def test_doctor_shows_the_flags_and_where_they_come_from(monkeypatch):
    monkeypatch.setenv("SYMGEN_FLAGS", "fma")
    (found,) = (f.found for f in doctor.examine() if f.name == "C compiler")
    assert found.endswith("-mfma (asked for by SYMGEN_FLAGS)")
