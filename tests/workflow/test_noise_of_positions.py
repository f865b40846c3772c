"""Noise of positions makes effects by least squares: diagnose does not name them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from browser import Page
from oracles import planar2r

import symgen

L1, X = 0.5, np.array([3.7, 0.8, 1.2, 0.3])
Law = Callable[[np.ndarray, np.ndarray], np.ndarray]


def log(seed: int, noise: float, law: Law) -> symgen.Log:
    """A motion whose positions have white noise, rad, with one more torque on joint 1."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += np.sign(qd) + 0.5 * qd + 0.02 * rng.normal(size=tau.shape)
    tau[:, 0] += law(q[:, 0], qd[:, 0])
    return symgen.make_log(f"log {seed}", t, q + noise * rng.normal(size=q.shape), tau, n=2)


def diagnosed(
    seed: int, noise: float, law: Law, effects: Sequence[str], cutoff: float | None = None
) -> symgen.Diagnosis:
    robot = symgen.parse_robot(planar2r.robot_toml("noisy"), "noisy.toml")
    logs = [log(seed + k, noise, law) for k in range(3)]
    return symgen.diagnose(robot, logs[:2], validation=logs[2], effects=effects, cutoff=cutoff)


@pytest.mark.parametrize("seed", [5, 8])
def test_an_elasticity_that_noise_makes_is_not_named(seed: int) -> None:
    found = diagnosed(seed, 1e-3, lambda q, _: 0 * q, ["joint_elasticity"], cutoff=12.0)
    assert (found.verdict, found.effects) == ("consistent", ())


def test_the_page_says_why_noise_is_no_backlash(tmp_path: Path) -> None:
    found = diagnosed(5, 3e-3, lambda q, _: 0 * q, ["backlash"], cutoff=12.0)
    assert found.effects == ()
    why = [r.reason for r in found.rejected if "noise of the positions" in r.reason]
    assert why
    symgen.write(found, tmp_path / "why")
    page = Page((tmp_path / "why" / "report.html").read_text("utf-8")).text
    assert all(reason in page for reason in why)


def test_an_elasticity_of_an_impossible_sign_says_so() -> None:
    found = diagnosed(5, 1e-3, lambda q, _: 0 * q, ["joint_elasticity"], cutoff=12.0)
    assert any("sign that it cannot have" in r.reason for r in found.rejected)


@pytest.mark.parametrize(
    ("name", "law", "noise"),
    [
        ("stribeck_friction", lambda _, v: 2 * np.sign(v) * np.exp(-((v / 0.4) ** 2)), 5e-4),
        ("gravity_spring", lambda q, _: 3 * (q - 0.2), 1e-4),
    ],
)
def test_a_true_effect_carries_none(name: str, law: Law, noise: float) -> None:
    found = diagnosed(2, noise, law, [name])
    assert [(e.name, e.note) for e in found.effects] == [(name, None)]
    assert "note" not in found.to_json()["effects"][0]
