"""symgen diagnose and symgen explain: exit codes, files, the contract's keys, one screen."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from oracles.arm import PLANAR2R, save_planar2r

import symgen
from symgen.robot.effect import definitions

SPRING = 0.4


def sprung(path: Path, seed: int) -> Path:
    """A log of planar2r with a spring on joint 2."""
    return save_planar2r(path, seed, lambda q, *_: SPRING * (q - 0.2) * [0, 1])


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return sprung(folder / "train.npz", 1), sprung(folder / "test.npz", 2)


@pytest.fixture
def run(command):
    return command


def test_a_hidden_spring_is_found_added_and_shown(run, logs, tmp_path):
    into = tmp_path / "out"
    code, out, err = run("diagnose", "planar2r", logs[0], "--validation", logs[1], "--into", into)
    assert code == 0, out + err
    assert "\x1b" not in out
    assert "\nverdict: explained\n" in out
    assert len(out.splitlines()) <= 24
    for words in ("gravity_spring", "K2", "N m/rad", "joint 2", "noise floor"):
        assert words in out, words
    assert "trying" in err

    again = run("report", into)
    assert again[0] == 0
    lines = out.splitlines()
    assert again[1].splitlines() == [x for x in lines if not x.startswith(("written", "next: "))]
    rest = re.search(r"-K2\*q2, q0 = (\S+) rad$", out, re.MULTILINE)
    assert rest is not None, out
    assert float(rest[1]) == pytest.approx(0.2, abs=0.02)
    assert rest[0] in (into / "report.html").read_text("utf-8")

    (line,) = [x for x in lines if x.startswith(("next: ", "try: "))]
    typed = shlex.split(line.removeprefix("next: symgen "))
    assert typed[:2] == ["identify", str(into / "robot.toml")]

    content = json.loads((into / "diagnosis.json").read_text(), parse_constant=pytest.fail)
    keys = {"schema", "robot", "verdict", "cutoff_hz", "gap", "where", "effects", "rejected"}
    assert keys <= set(content)
    assert (content["schema"], content["robot"]) == ("symgen.diagnosis/1", "planar2r")
    gap = content["gap"]
    assert gap["metric"] == "torque"
    for part in ("before", "after", "noise_floor"):
        ratios = gap[part]["per_joint"]
        assert min(ratios) <= gap[part]["total"] <= max(ratios)  # over all joints together
    assert gap["after"]["total"] < 0.3 * gap["before"]["total"]
    effect = content["effects"][0]
    assert {"name", "joints", "parameters", "expression", "p_value", "gap_reduction",
            "indistinguishable_from"} <= set(effect)  # fmt: skip
    assert (effect["name"], effect["joints"]) == ("gravity_spring", [2])
    assert effect["parameters"][0]["value"] == pytest.approx(SPRING, rel=0.02)
    assert sum(place["share"] for place in content["where"]) == pytest.approx(1)

    robot = symgen.read_robot(into / "robot.toml")
    assert [e.name for e in robot.effects] == ["gravity_spring"]
    assert (into / "generated" / "planar2r.h").is_file()
    assert (into / "generated" / "planar2r_casadi.py").is_file()
    assert "<html" in (into / "report.html").read_text("utf-8")
    code, out, err = run(
        *("predict", into / "robot.toml", logs[1], "--parameters", into / "parameters.toml"),
        *("--into", tmp_path / "prediction"),
    )
    assert code == 0, err


def test_the_first_plot_shows_the_hidden_spring_and_that_it_is_gone(logs, tmp_path):
    known, names = tmp_path / "known.toml", ("ZZ1R", "ZZ2", "MX2", "MY2")
    lines = (f"{name} = {value}\n" for name, value in zip(names, PLANAR2R, strict=True))
    known.write_text("[parameters]\n" + "".join(lines))
    found = symgen.diagnose(
        *("planar2r", logs[0]), validation=logs[1], parameters=known, effects=["gravity_spring"]
    )
    (panel,) = found.plot().panels
    assert (panel.title, panel.xlabel) == ("joint 2, N m", "position, rad")
    recorded = np.load(logs[1])
    noise = 0.01 * recorded["tau"][:, 1].std()
    q, before = panel.series["residual before"]
    assert np.ptp(q) > 0.9 * np.ptp(recorded["q"][:, 1])
    np.testing.assert_allclose(before, SPRING * (q - 0.2), atol=5 * noise)
    np.testing.assert_allclose(panel.series["residual after"][1], 0, atol=5 * noise)


def test_the_residuals_are_those_of_the_repaired_log(tmp_path):
    paths = [sprung(tmp_path / f"{seed}.npz", seed) for seed in (1, 2)]
    for path in paths:  # torques that come 30 ms late
        log = dict(np.load(path))
        late = np.clip(log["t"] - 0.03, log["t"][0], None)
        columns = [np.interp(late, log["t"], column) for column in log["tau"].T]
        np.savez(path, **{**log, "tau": np.stack(columns, axis=1)})
    found = symgen.diagnose("planar2r", paths[0], validation=paths[1])
    named = {e.name for e in found.effects if e.adopted}
    assert named == {"gravity_spring"}
    (late,) = found.repairs
    assert (late.kind, late.channel) == ("delay", "tau")
    assert late.value == pytest.approx(0.03, abs=5 * late.std)
    assert found.where[0].joint == 2
    assert found.where[0].pattern == "position"
    (c,) = found.curves
    for gap, residual, modelled in zip(
        (found.before, found.after), c.residuals, (c.before, c.after), strict=True
    ):
        measured = residual + modelled
        ratios = np.linalg.norm(residual, axis=0) / np.linalg.norm(measured, axis=0)
        np.testing.assert_allclose(ratios, gap.per_joint, rtol=1e-9)


def test_effects_limit_the_search_and_what_they_cannot_say_is_unexplained(run, logs, tmp_path):
    code, out, _ = run(
        *("diagnose", "planar2r", logs[0], "--validation", logs[1]),
        *("--effects", "torque_offset, viscous_friction", "--into", tmp_path / "out"),
    )
    content = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    named = {e["name"] for e in (*content["effects"], *content["rejected"])}
    assert named <= {"torque_offset", "viscous_friction"}
    assert code == (0 if content["trusted"] else 1)
    assert re.search(r"^verdict: (partly-|un)explained$", out, re.MULTILINE)


def test_an_interrupt_leaves_nothing(run, logs, tmp_path, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("symgen.report.store.generate", stop)
    arguments = ("diagnose", "planar2r", logs[0], "--effects", "gravity_spring")
    code, _, err = run(*arguments, "--into", tmp_path / "out")
    assert (code, err.splitlines()[-1]) == (130, "symgen: interrupted")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["diagnose", "planar2r", "nowhere.csv", "--into", "x"], "nowhere.csv"),
        (["diagnose", "planar2r", "--into", "x"], "LOGS"),
        (["diagnose", "planar2r", "LOG"], "--into"),
        (["diagnose", "planar2r", "LOG", "--effects", "gremlins", "--into", "x"], "gremlins"),
        (["diagnose", "planar2r", "LOG", "--effects", "", "--into", "x"], "accepted"),
        (["diagnose", "scara", "LOG", "--into", "x"], "q"),
        (["diagnose", "nothing", "LOG", "--into", "x"], "nothing"),
        (["diagnose", "planar2r", "LOG", "--cutoff", "-1", "--into", "x"], "cutoff"),
        (["diagnose", "planar2r", "LOG", "--cutoff", "nan", "--into", "x"], "cutoff"),
        (["diagnose", "planar2r", "LOG", "--into", "LOG"], "not a folder"),
        (["explain", "gremlins"], "gravity_spring"),
        (["explain", "a" * 5000], "accepted"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(run, logs, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(*(str(logs[0]) if a == "LOG" else a for a in arguments))
    lines = [line for line in err.splitlines() if not line.startswith("  ")]
    assert code == 2, out + err
    assert len(lines) == 1, err
    assert lines[0].startswith("symgen: error: ")
    assert words in lines[0]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", definitions())
def test_every_effect_is_explained(run, name):
    code, out, err = run("explain", name)
    assert (code, err) == (0, "")
    definition = definitions()[name]
    said = " ".join(out.split())
    for words in (definition.says, definition.pattern, definition.confused, definition.separate,
                  definition.formula or definition.torque, *definition.linear,
                  *definition.nonlinear, "in robot.toml"):  # fmt: skip
        assert " ".join(words.split()) in said, words
    assert all(len(line) <= 120 for line in out.splitlines())


TWO = """
[robot]
name = "two"
[[joint]]
KEYS
[[joint]]
alpha = "pi/2"
"""


@pytest.mark.parametrize("name", sorted({*definitions()} - {"unnamed"}))
def test_what_explain_says_of_a_robot_file_declares_the_effect(run, name):
    out = run("explain", name)[1]
    said = out.split("in robot.toml")[1].splitlines()[0].strip()
    definition = definitions()[name]
    if said.startswith("not declared there"):
        assert not any((definition.native, definition.declarable))
        return
    keys, more = (plain := "friction = []\nrotor_inertia = false"), ""
    if " with " in said:
        more = re.sub(r", (?=\w+ = [\[{\d])", "\n", said.replace(" with ", "\n").split(", and ")[0])
        more = more.replace("[j", "[1").replace("k]", "2]").replace("= j, the link", "= 1 #")
    else:
        keys = said.split(" of the joint")[0]
    declared = symgen.parse_robot(TWO.replace("KEYS", keys) + more)
    assert declared != symgen.parse_robot(TWO.replace("KEYS", plain))
    if said.startswith("[[effect]]"):
        assert [e.name for e in declared.effects] == [name]
    assert definition.offset == ('"offset" among' in said)
