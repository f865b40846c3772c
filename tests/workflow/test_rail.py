"""A rail: messages and effects of a prismatic joint are in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symgen

RAIL = """
[robot]
name = "rail"
gravity = [0.0, 0.0, -9.81]
[[joint]]
sigma = 1
alpha = "pi/2"
[limits]
position = [[-1.5, 1.5]]
"""
MASS, FS, FV = 20.0, 8.0, 100.0  # kg, N, N s/m


def log(size: float, w: float, phase: float, pitch: float = 0.02) -> symgen.Log:
    """A slow motion over a rack whose pitch shows in the force."""
    t = np.arange(0, 300, 0.05)
    q = size * np.sin(w * t + phase) + 0.003 * np.sin(2 * t)
    qd = size * w * np.cos(w * t + phase) + 0.006 * np.cos(2 * t)
    qdd = -size * w**2 * np.sin(w * t + phase) - 0.012 * np.sin(2 * t)
    noise = 0.05 * np.random.default_rng(int(1000 * w)).standard_normal(len(t))
    ripple = 1.5 * np.sin(2 * np.pi * q / pitch + 0.4)
    tau = MASS * qdd + FS * np.sign(qd) + FV * qd + ripple + noise
    return symgen.make_log(f"log {w}", t, q[:, None], tau[:, None], qd[:, None])


def test_the_pitch_of_a_rack_is_found() -> None:
    train, test = log(0.7, 0.03, 0.0), log(0.6, 0.034, 1.0)
    found = symgen.diagnose(
        symgen.parse_robot(RAIL), train, validation=test, effects=["torque_ripple"]
    )
    (effect,) = [e for e in found.effects if e.adopted]
    k = next(p for p in effect.parameters if p.name == "k1")
    assert k.value == pytest.approx(2 * np.pi / 0.02, rel=1e-3)
    assert k.unit == "1/m"


@pytest.mark.parametrize("effect", ["torque_ripple", "position_dependent_friction"])
def test_effects_of_a_position_speak_of_no_turn(command, effect) -> None:
    code, out, _ = command("explain", effect)
    assert code == 0
    assert "over a turn" not in out
    assert "over the turn" not in out
    assert "full turns" not in out


def test_a_rail_in_millimetres_is_refused_with_the_unit_of_a_length(
    command, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rail.toml").write_text(RAIL)
    Path("rail_X.toml").write_text(f"[parameters]\nM1R = {MASS}\nFS1 = {FS}\nFV1 = {FV}\n")
    recorded = log(0.7, 0.03, 0.0)
    table = np.column_stack([recorded.t, 1e3 * recorded.q, recorded.tau])[:2000]
    np.savetxt("log.csv", table, delimiter=",", header="t,q1,tau1", comments="")
    asked = ["predict", "rail.toml", "log.csv", "--parameters", "rail_X.toml", "--into", "out"]
    code, _, err = command(*asked)
    assert code == 2
    assert "m, or --unit q1=mm" in err
    assert "rad" not in err
    assert "deg" not in err
    code, _, err = command(*asked, "--unit", "q1=mm")
    assert code == 0, err
