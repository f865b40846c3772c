"""Joints that move in proportion: what is determined is solved and predicts, the rest is said."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracles.arm import HANGING, IN_PLANE, Arm, sines
from oracles.planar2r import robot_toml

import symgen

ARM, STEP = HANGING, 0.008
ROBOT = symgen.parse_robot(robot_toml("tried", gravity=IN_PLANE))
#: With q2 = q1/2 each inertia is felt in one combination with the others.
HIDDEN = ["ZZ1R", "ZZ2", "IA2"]


def motion(seed: int, own: float = 0.0) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Joint 2 moves half as far as joint 1, and `own` of a motion of its own besides."""
    t, w = np.arange(0.0, 16.0, STEP), np.array([[1.1, 1.7], [2.9, 4.3]])
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, w.shape)
    mixed = np.array([[1.0, 0.5], [0.0, own]])
    return t, tuple(x @ mixed for x in sines(t, [[0.8, 0.8], [0.3, 0.3]], w, phase))


@cache
def log(
    name: str, seed: int, own: float = 0.0, noise: float = 1.0, arm: Arm = ARM, late: int = 0
) -> symgen.Log:
    """A log of a motion, with torques that are late by some samples."""
    t, moved = motion(seed, own)
    rng = np.random.default_rng(seed + 10)
    t, q, tau, qd = arm.recorded(t, moved, rng, position=noise * 1e-5, speed=noise * 1e-3)
    tau = np.concatenate([np.repeat(tau[:1], late, axis=0), tau[: len(tau) - late]])
    return symgen.make_log(name, t, q, tau, qd)


def hidden(estimate: symgen.Estimate) -> list[str]:
    return [p.name for p in estimate.parameters if math.isnan(p.std)]


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_what_moves_in_proportion_predicts_and_what_is_not_determined_is_named(noise) -> None:
    train, held = log("a", 2, noise=noise), log("b", 3, noise=noise)
    found = symgen.identify(ROBOT, train, validation=held)
    assert hidden(found) == HIDDEN
    assert found.to_json()["possible"] is True
    assert found.verdict == "trusted", found.reasons
    assert found.torque_validation.relative < 0.01  # the noise, of which the filters keep a part
    (restriction,) = found.uses.simulation.reasons
    assert (restriction.kind, restriction.joints) == ("in_proportion", (1, 2))
    assert not set(HIDDEN) & set(found.uses.parameters.known)
    reason = next(r for r in found.uses.parameters.reasons if r.kind == "not_determined")
    assert reason.value == len(HIDDEN)
    assert ", ".join(HIDDEN) in reason.text
    truth = ARM.values | {"MY1": 0.0}
    for p in found.parameters:
        if p.name not in HIDDEN:
            assert abs(p.value - truth[p.name]) < 4 * p.std, p


def test_torques_that_are_late_are_shifted_and_no_effect_is_named() -> None:
    found = symgen.identify(ROBOT, log("a", 2, late=2), validation=log("b", 3, late=2))
    assert found.torque_validation.relative < 0.01
    assert [repair.kind for repair in found.repairs] == ["delay"]
    assert found.suspected == ()


@pytest.mark.parametrize(("rotor", "verdict"), [(0.05, "trusted"), (2.0, "doubtful")])
def test_motion_out_of_proportion_is_judged_by_its_error(rotor: float, verdict: str) -> None:
    """The logs give one combination of the inertias of joint 2, whose parts other motion shows."""
    arm = replace(ARM, IA2=rotor)
    found = symgen.identify(
        ROBOT, log("a", 2, arm=arm), validation=log("b", 3, own=1.0, arm=arm), model="torque"
    )
    values = {p.name: p.value for p in found.parameters}
    combined = 1.5 * values["ZZ2"] + 0.5 * values["IA2"]
    assert combined == pytest.approx(1.5 * arm.X[1] + 0.5 * rotor, rel=0.02)
    inertias = np.array([values["ZZ1R"], values["ZZ2"], *arm.X[2:]])
    _, moved = motion(3, own=1.0)
    true = arm.torque(*moved)
    off = replace(arm, X=inertias, IA2=values["IA2"]).torque(*moved) - true
    share = np.linalg.norm(off) / np.linalg.norm(true)
    assert found.torque_train.relative < 0.01
    assert found.torque_validation.relative == pytest.approx(share, rel=0.1)
    assert found.verdict == verdict, found.reasons


def test_a_prior_tells_what_the_motion_does_not(tmp_path: Path) -> None:
    logs = log("a", 2), log("b", 3)
    values = ARM.values | {"MY1": 0.1, "IA2": 1e-3}
    lines = [f"{name} = {value}" for name, value in values.items()]
    (tmp_path / "prior.toml").write_text("\n".join(["[parameters]", *lines]))
    fit = symgen.FitOptions(prior=tmp_path / "prior.toml")
    found = symgen.identify(ROBOT, logs[0], validation=logs[1], model="torque", fit=fit)
    assert hidden(found) == []
