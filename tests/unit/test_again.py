"""The command to try next: what was typed, with an option changed, ready for a shell."""

from __future__ import annotations

import shlex

import pytest

from symgen.cli.group import cli
from symgen.cli.options import again

TYPED = {
    "an option is changed": (
        ["identify", "a.toml", "l.csv", "--model", "energy", "--into", "out"],
        ["a.toml", "l.csv"],
        {"--into": "out", "--model": "auto"},
    ),
    "with an equals sign": (
        ["identify", "--model=energy", "a.toml", "l.csv", "--into=out"],
        ["a.toml", "l.csv"],
        {"--into": "out", "--model": "auto"},
    ),
    "blanks are quoted": (
        ["identify", "my arm.toml", "l.csv", "--columns", "q=* pos", "--into", "out"],
        ["my arm.toml", "l.csv"],
        {"--into": "out", "--columns": "q=* pos", "--model": "auto"},
    ),
    "a file of that name stays": (
        ["identify", "model", "l.csv", "--into", "out"],
        ["model", "l.csv"],
        {"--into": "out", "--model": "auto"},
    ),
}


def said(typed: list[str], *arguments: str, **changed: str) -> list[str]:
    """Return the words of the command to try after the one that was typed."""
    with cli.make_context("symgen", list(typed)) as outer:
        name, command, rest = cli.resolve_command(outer, typed)
        with command.make_context(name, rest, parent=outer):
            return shlex.split(again(*arguments, **changed))


@pytest.mark.parametrize("case", TYPED)
def test_the_command_is_what_was_typed_with_the_change(case) -> None:
    typed, arguments, options = TYPED[case]
    words = said(typed, model="auto")
    assert words[:2] == ["symgen", "identify"]
    assert words[2 : 2 + len(arguments)] == arguments
    rest = words[2 + len(arguments) :]
    assert dict(zip(rest[::2], rest[1::2], strict=True)) == options


def test_another_command_keeps_the_options_that_it_has() -> None:
    typed = [
        *("identify", "my arm.toml", "a.csv", "b c.csv", "--validation", "v.csv"),
        *("--window", "0.1", "--columns", "q=* pos", "--from", "2", "--mask", "rest"),
        *("--cutoff", "8", "--into", "out"),
    ]
    words = said(typed, "diagnose", into="out-why")
    assert words[:5] == ["symgen", "diagnose", "my arm.toml", "a.csv", "b c.csv"]
    assert dict(zip(words[5::2], words[6::2], strict=True)) == {
        "--validation": "v.csv",
        "--columns": "q=* pos",
        "--from": "2.0",
        "--mask": "rest",
        "--cutoff": "8.0",
        "--into": "out-why",
    }


def test_a_doubtful_estimate_of_one_model_says_the_command_for_all(tmp_path, command) -> None:
    import numpy as np

    t = np.arange(0, 6, 0.01)
    q = np.stack([0.4 * np.sin(2 * t), 0.3 * np.sin(3 * t)], 1)
    tau = np.random.default_rng(1).standard_normal(q.shape)  # nothing to do with the motion
    log = tmp_path / "log.csv"
    table = np.column_stack([t, q, tau])
    np.savetxt(log, table, delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    into = tmp_path / "out"
    asked = ["identify", "planar2r", log, "--model", "torque", "--into", into]
    code, out, err = command(*asked)
    assert code == 1, err
    (line,) = [line for line in out.splitlines() if line.startswith("try: ") and "auto" in line]
    words = shlex.split(line.removeprefix("try: symgen "))
    code, out, err = command(*words)
    assert code == 1, err
    assert (tmp_path / "out-auto" / "estimate.json").is_file()
    # All models were tried: what is left is to ask what they lack.
    tried = [line for line in out.splitlines() if line.startswith("try: ")]
    assert tried
    assert all(line.startswith("try: symgen diagnose ") for line in tried)
