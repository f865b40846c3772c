"""The command to try next: what was typed, with an option changed, ready for a shell."""

from __future__ import annotations

import shlex

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm

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
        *("--cutoff", "8", "--least", "2", "--into", "out"),
    ]
    words = said(typed, "diagnose", into="out-why")
    assert words[:5] == ["symgen", "diagnose", "my arm.toml", "a.csv", "b c.csv"]
    assert dict(zip(words[5::2], words[6::2], strict=True)) == {
        "--validation": "v.csv",
        "--columns": "q=* pos",
        "--from": "2.0",
        "--mask": "rest",
        "--cutoff": "8.0",
        "--least": "2.0",
        "--into": "out-why",
    }


def test_a_doubtful_estimate_of_one_model_says_the_command_for_all(tmp_path, command) -> None:
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


def test_what_is_unexplained_comes_with_the_command_and_the_options_of_the_call(
    tmp_path, command
) -> None:
    asked = ["identify", tmp_path / "arm.toml"]
    asked[1].write_text(planar2r.robot_toml("arm", 'friction = ["viscous"]'))
    for name, seed in (("train", 3), ("test", 4)):
        rng = np.random.default_rng(seed)
        t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
        tau = Arm(np.array([3.7, 0.8, 1.2, 0.3])).torque(q, qd, qdd)
        tau = tau + 0.05 * tau.std(axis=0) * np.cos(3 * q[:, ::-1] + qd)
        table = np.column_stack([t, q, qd, tau])
        header = "t,q1,q2,qd1,qd2,tau1,tau2"
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=header, comments="")
    asked += [tmp_path / "train.csv", "--validation", tmp_path / "test.csv"]
    into = tmp_path / "out"
    code, out, err = command(*asked, "--model", "torque", "--until", "60", "--into", into)
    assert code == 0, out + err
    assert "of the torque is unexplained" in " ".join(out.split())
    (line,) = [line for line in out.splitlines() if line.startswith("try: symgen diagnose")]
    words = shlex.split(line.removeprefix("try: symgen diagnose"))
    assert words[:2] == [str(x) for x in asked[1:3]]
    assert words[words.index("--validation") + 1] == str(asked[-1])
    assert words[words.index("--until") + 1] == "60.0"
