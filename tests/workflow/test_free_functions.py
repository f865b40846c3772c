"""Where no law of the library has the shape of a gap, diagnose says of what it is a function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from browser import Page
from oracles import planar2r

import symgen
from symgen.cli.demonstration import demonstrate
from symgen.diagnosis.diagnosis import read_diagnosis

L1, X = 0.5, np.array([3.7, 0.8, 1.2, 0.3])
ROBOT = planar2r.robot_toml("odd")


def log(seed: int, law: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> symgen.Log:
    """A motion with one more torque on joint 1, from positions and speeds."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += np.sign(qd) + 0.5 * qd + 0.02 * rng.normal(size=tau.shape)
    tau[:, 0] += law(q, qd)
    return symgen.make_log(f"log {seed}", t, q, tau, qd)


@pytest.mark.parametrize("strength", [0.0, 6.0])
def test_the_variables_of_a_torque_without_a_law_are_told(strength: float) -> None:
    robot = symgen.parse_robot(ROBOT, "odd.toml")
    logs = [
        log(seed, lambda q, _: strength * np.sin(2 * (q[:, 0] - q[:, 1]))) for seed in (2, 3, 4)
    ]
    found = symgen.diagnose(robot, logs[:2], validation=logs[2])
    told = [line for line in found.advice if "a free function reduces" in line]
    if not strength:
        assert found.verdict == "consistent"
        assert not told
        return
    assert found.verdict in ("unexplained", "partly-explained")
    (line,) = told
    assert line.startswith(
        "the unexplained torque of joint 1 depends on the position of joint 1 and the position of "
        "joint 2:"
    )
    (curve,) = found.free_functions or ()
    assert (curve.joint, curve.variables, curve.effects) == (1, ("q1", "q2"), ())
    assert len(curve.at) == len(curve.torque) == len(curve.std) == 3
    assert curve.law == ()


def bump(qd: np.ndarray) -> np.ndarray:
    """Friction that is largest at 1 rad/s, which no law of the library has."""
    return 3 * np.sign(qd) * np.exp(-(((np.abs(qd) - 1.0) / 0.3) ** 2))


def stribeck(qd: np.ndarray) -> np.ndarray:
    return 2 * np.sign(qd) * np.exp(-((qd / 0.4) ** 2))


def friction(
    law: Callable[[np.ndarray], np.ndarray], effects: Sequence[str] = ("stribeck_friction",)
) -> symgen.Diagnosis:
    logs = [log(seed, lambda _, qd: law(qd[:, 0])) for seed in (2, 3, 4)]
    robot = symgen.parse_robot(ROBOT, "odd.toml")
    return symgen.diagnose(robot, logs[:2], validation=logs[2], effects=effects)


def test_a_law_of_another_shape_stands_beside_the_curve(tmp_path: Path) -> None:
    found = friction(bump, ("nonlinear_viscous_friction", "smooth_friction"))
    names = tuple(e.name for e in found.effects)
    (curve,) = found.free_functions or ()
    assert (curve.joint, curve.variables) == (1, ("qd1",))
    assert set(curve.effects) == set(names) != set()
    assert curve.gain_ratio < 0.8
    v, torque, std = np.array(curve.grid), np.array(curve.torque[0]), np.array(curve.std[0])
    true = np.sign(v) + 0.5 * v + bump(v)
    error, law = torque - true, np.array(curve.law[0]) - true
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.sqrt(np.mean(law**2))
    assert np.mean(np.abs(error) < 3 * std) > 0.8

    symgen.write(found, tmp_path / "why")
    assert read_diagnosis(tmp_path / "why").free_functions == found.free_functions
    page = Page((tmp_path / "why" / "report.html").read_text("utf-8"))
    (figure,) = [f for f in page.figures if any(c.get("name") == "named law" for c in f["data"])]
    assert {c.get("name") for c in figure["data"]} == {None, "free function", "named law"}
    (line,) = [x for x in found.advice if x.endswith("no known law has this shape")]
    assert "joint 1" in line
    assert all(name in line for name in names)
    assert line in page.text


def test_a_law_of_the_right_shape_stands_alone() -> None:
    found = friction(stribeck)
    assert [e.name for e in found.effects] == ["stribeck_friction"]
    assert found.free_functions is None
    assert "free_functions" not in found.to_json()


@pytest.mark.slow
def test_a_spring_that_carries_much_of_the_weight_has_its_law() -> None:
    """Gravity says most of the spring's torque: less is missing than the spring carries."""
    done = demonstrate(lambda _: None)
    assert [(e.name, e.joints) for e in done.why.effects] == [("gravity_spring", (2,))]
    assert not done.why.free_functions


def test_an_effect_that_is_small_in_the_training_motion_alone_is_told() -> None:
    robot = symgen.parse_robot(ROBOT, "odd.toml")

    def motion(seed: int, slower: float) -> symgen.Log:
        """Friction that grows with the square of the speed of joint 1."""
        t, q, qd, qdd = planar2r.harmonic_motion(np.random.default_rng(seed), seed)
        qd, qdd = qd / slower, qdd / slower**2
        tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
        tau += np.sign(qd) + 0.5 * qd
        tau += 0.005 * np.random.default_rng(seed + 9).normal(size=tau.shape)
        tau[:, 0] += 0.25 * qd[:, 0] * np.abs(qd[:, 0])
        return symgen.make_log(f"log {seed}", t * slower, q, tau, qd)

    found = symgen.diagnose(robot, motion(2, 3.0), validation=motion(3, 1.0))
    assert (found.verdict, found.effects) == ("unexplained", ())
    (told,) = found.advice
    assert "nonlinear_viscous_friction on joint 1 is probable, but too small on the train" in told
    assert "larger on the validation data: there it reduces the torque error of joint 1" in told
