"""The nearest physically possible parameters on line, against a conic solver."""

from __future__ import annotations

import random
from functools import cache

import numpy as np
import pytest

import symgen
from symgen.codegen.verification import physical_parameters
from symgen.identification.physical import nearest_consistent, pseudo_inertia
from symgen.names import LINK

KERNELS = (
    "energy_regressor", "friction_power", "momentum_regressor", "friction_torque",
    "inverse_dynamics",
)  # fmt: skip
NAMES = ("planar2r", "scara", "puma560")


@cache
def learned(name: str):
    """An identifier of a short, very noisy log, so that no robot can have its X."""
    kernels = [k for k in KERNELS if name != "planar2r" or not k.startswith("friction")]
    model = symgen.derive(name, kernels)
    evaluator = symgen.load(model, backend="c")
    X = np.array(physical_parameters(model, random.Random(3)))
    rng = np.random.default_rng(4)
    n, t = model.robot.n, np.arange(3000)[:, None, None] / 500
    w, a = rng.uniform(1, 9, (6, n)), rng.uniform(0.1, 0.3, (6, n))
    phase = t * w + rng.uniform(0, 2 * np.pi, (6, n))
    q, qd = (a * np.sin(phase)).sum(1), (a * w * np.cos(phase)).sum(1)
    qdd = (-a * w**2 * np.sin(phase)).sum(1)
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    tau += 3 * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
    identifier = symgen.Identifier(evaluator, window=40, model="momentum")
    identifier.run(t[:, 0, 0], q, qd, tau)
    return model, identifier, X


def possible(model, seed=0):
    """Standard parameters of a robot of solid links."""
    rng, out = np.random.default_rng(seed), []
    for parameter in model.base.standard:
        if parameter.prefix == "XX":
            mass, c = rng.uniform(1, 3), rng.uniform(-0.2, 0.2, 3)
            J = rng.uniform(0.05, 0.2) * np.eye(3) + mass * (c @ c * np.eye(3) - np.outer(c, c))
            out += [*J[np.triu_indices(3)], *(mass * c), mass]
        elif parameter.prefix not in LINK:
            out.append(rng.uniform(0.1, 1))
    return np.array(out)


@pytest.mark.parametrize("name", NAMES[1:])
def test_the_nearest_possible_parameters_are_those_of_the_conic_solver(name) -> None:
    model, identifier, _ = learned(name)
    Y, R = identifier.read()[0], identifier.R
    nearest, distance = nearest_consistent(model, Y, np.linalg.inv(R.T @ R))
    assert distance > 0
    for seed in range(3):
        X = identifier.project(possible(model, seed))
        found = np.linalg.norm(R @ (X - Y))
        print(name, distance, found)
        assert found < 1.001 * distance
        consistent, moved = nearest_consistent(model, X, np.linalg.inv(R.T @ R))
        assert moved < 0.01 * distance
        assert np.linalg.norm(R @ (X - nearest)) < 0.05 * distance
        assert consistent.shape == X.shape


@pytest.mark.parametrize("name", NAMES[:2])
def test_possible_parameters_stay(name) -> None:
    model, _, X = learned(name)
    evaluator = symgen.load(model, backend="c")
    clean = symgen.Identifier(evaluator, window=40, model="momentum")
    t = np.arange(3000) / 500
    w = np.linspace(2, 7, model.robot.n) * np.array([1.0, 1.7])[:, None]
    phase = t[:, None, None] * w + np.arange(2)[:, None]
    q, qd = 0.3 * np.sin(phase).sum(1), 0.3 * (w * np.cos(phase)).sum(1)
    qdd = -0.3 * (w**2 * np.sin(phase)).sum(1)
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    tau += 1e-3 * np.random.default_rng(1).normal(size=tau.shape)
    clean.run(t, q, qd, tau)
    Y, std = clean.read()
    np.testing.assert_allclose(clean.project(possible(model)), Y, rtol=0, atol=1e-2 * std.max())


def test_an_impossible_beginning_is_refused() -> None:
    model, identifier, _ = learned("planar2r")
    begin = possible(model)
    assert np.linalg.eigvalsh(pseudo_inertia(begin[:10]))[0] > 0
    for place, value in ((9, 0.0), (0, -1.0), (3, np.nan)):
        wrong = begin.copy()
        wrong[place] = value
        with pytest.raises(symgen.IdentificationError, match="no robot has these"):
            identifier.project(wrong)
    with pytest.raises(symgen.IdentificationError, match="accepted"):
        identifier.project(begin[1:])
