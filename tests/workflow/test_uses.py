"""What an estimate may be used for: one line a use, and parameters that a robot can have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles import planar2r

import symgen

L1, X = 0.5, np.array([3.7, 0.8, 1.2, 0.3])
STOP = 0.054  # s
SCALE = np.array([20.0, 5.0])  # N m s/rad: that of the joints' torques over their speeds, about
ROBOT = planar2r.robot_toml("rubbing", 'friction = ["viscous"]\nrotor_inertia = false')

RUBBING = ROBOT.replace('["viscous"]', '["coulomb", "viscous"]')


def log(seed: int, viscous: float, noise: float = 1e-3, name: str = "log") -> symgen.Log:
    """A motion with viscous friction of about a share of each joint's torque."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    size = tau.std(axis=0)
    tau = tau + viscous * SCALE * qd + noise * size * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q, tau, qd)


def commands(
    viscous: float, noise: float, encoder: float, robot: str = ROBOT
) -> tuple[symgen.Robot, list[symgen.Log]]:
    """Two logs, and encoders that come in steps, rad."""
    logs = []
    for seed in (3, 4):
        true = log(seed, viscous, noise)
        q = np.round(true.q / encoder) * encoder if encoder else true.q
        logs.append(symgen.make_log(f"log {seed}", true.t, q, true.tau, true.qd))
    return symgen.parse_robot(robot, "rubbing.toml"), logs


def identified(viscous: float) -> symgen.Estimate:
    robot = symgen.parse_robot(ROBOT, "rubbing.toml")
    held = log(4, viscous, name="held")
    return symgen.identify(robot, log(3, viscous), validation=held)


def test_a_verdict_has_one_line_for_each_use() -> None:
    found = identified(0.1)
    first, second, third = found.headline.split(" | ")
    assert found.verdict == "trusted"
    assert first.startswith("Good for torque prediction: 0.")
    assert second == "Parameters: 6 of 6 are known to 30 %."
    assert third.startswith("Good for simulation: position error after 1 s 0.0")


def test_friction_that_drives_the_robot_a_little_is_bounded() -> None:
    found = identified(-0.004)
    values = {p.name: p.value for p in found.parameters}
    assert found.method == "consistent"
    assert min(values["FV1"], values["FV2"]) >= 0
    assert any("friction would drive joint" in note for note in found.notes), found.notes
    assert all(use.ok for use in found.uses if use.name != "parameters"), found.uses
    sound = identified(0.004)
    assert sound.method == "wls"


def test_friction_that_drives_the_robot_much_is_an_effect_that_is_missing() -> None:
    found = identified(-0.1)
    assert found.method == "wls"
    assert any("symgen diagnose" in note for note in found.notes), found.notes
    uses = {use.name: use for use in found.uses}
    assert not uses["simulation"].ok
    assert not uses["prediction"].ok


@pytest.mark.parametrize(
    ("viscous", "noise", "encoder", "robot"),
    [
        pytest.param(0.0, 1e-3, 1e-4, ROBOT, id="a robot without friction, measured"),
        pytest.param(0.05, 0.0, 1e-4, ROBOT, id="torques that hold friction"),
        pytest.param(0.05, 1e-3, 1e-4, RUBBING, id="drives without Coulomb friction"),
        pytest.param(0.0, 0.0, 0.0, ROBOT, id="a simulation without instruments"),
        pytest.param(
            0.0, 0.0, 1e-4, ROBOT.replace('["viscous"]', "[]"), id="a file without friction"
        ),
    ],
)
def test_what_may_have_been_measured_is_no_command(
    viscous: float, noise: float, encoder: float, robot: str
) -> None:
    parsed, logs = commands(viscous, noise, encoder, robot)
    found = symgen.identify(parsed, logs[:1], validation=logs[1:])
    assert found.verdict == "trusted", found.reasons


def lacking(part: float, noise: float = 1e-3) -> symgen.Estimate:
    """What is identified where the model lacks a part of the torque of joint 2."""
    logs = []
    for seed in (3, 4):
        own = log(seed, 0.1, 0.0, f"log {seed}")
        tau, size = own.tau.copy(), own.tau.std(axis=0)
        tau[:, 1] += part * size[1] * np.sqrt(2) * np.cos(3 * own.q[:, 0] + own.qd[:, 1])
        tau[:, 1] += noise * size[1] * np.random.default_rng(seed).normal(size=len(tau))
        logs.append(replace(own, tau=tau))
    return symgen.identify(symgen.parse_robot(ROBOT, "r.toml"), logs[0], validation=logs[1])


def test_a_torque_is_unexplained_beside_its_noise_and_doubtful_from_a_level_on() -> None:
    little, much = lacking(0.06), lacking(0.3)
    assert little.verdict == "trusted", little.reasons
    assert little.unexplained is not None
    assert little.unexplained < 0.05
    assert "of the torque is unexplained, cause unknown (noise floor: " in little.headline
    use = next(use for use in little.uses if use.name == "parameters")
    assert not use.ok
    assert use.reasons[0].startswith("do not use single values: ")
    assert use.reasons[0].endswith("% of the torque is unexplained")
    assert " | Parameters: do not use single values: " in little.headline
    assert much.verdict == "doubtful"
    (told,) = [r for r in much.reasons if "of single joints is unexplained" in r]
    assert "joint 2 " in told
    assert "joint 1 " not in told


def test_a_stop_between_two_moves_is_a_rest() -> None:
    """Moves of a fifth of a second with stops of 50 ms: friction at rest is none of the model's."""
    t, friction = np.arange(0, 12, 0.001), np.array([1.0, 0.5])
    robot = symgen.parse_robot(ROBOT.replace('"viscous"', '"coulomb", "viscous"'), "rubbing.toml")
    logs = []
    for seed in (5, 6):
        rng = np.random.default_rng(seed)
        q, qd, qdd = (np.zeros((len(t), 2)) for _ in range(3))
        at, begin = rng.uniform(-1, 1, 2), 0.0
        while begin < t[-1]:
            to, length = rng.uniform(-1, 1, 2), rng.uniform(0.18, 0.3)
            here = (t >= begin) & (t < begin + length + STOP)
            s, way = np.clip((t[here] - begin) / length, 0, 1)[:, None], to - at
            q[here] = at + way * s**3 * (10 - 15 * s + 6 * s**2)
            qd[here] = way / length * 30 * s**2 * (1 - s) ** 2
            qdd[here] = way / length**2 * 60 * s * (1 - s) * (1 - 2 * s)
            at, begin = to, begin + length + STOP
        tau = np.array([planar2r.inverse_dynamics(*x, X, L1) for x in zip(q, qd, qdd, strict=True)])
        tau += friction * np.sign(qd) + 0.2 * qd + 0.02 * rng.normal(size=q.shape)
        q += 1e-5 * rng.normal(size=q.shape)
        logs.append(symgen.make_log(f"moves {seed}", t, q, tau))
    found = symgen.identify(robot, logs[0], validation=logs[1])
    values = {p.name: p for p in found.parameters}
    for name, true in zip(("FS1", "FS2"), friction, strict=True):
        assert abs(values[name].value / true - 1) < 0.01
