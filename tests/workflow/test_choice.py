"""The default chooses between models and methods where folds of a log do not determine X."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import MOVED, data_folder

import symgen
from symgen.identification.parameters import base_values

FOUR = [(model, method) for model in ("torque", "momentum") for method in ("wls", "consistent")]
MASSES = np.array([15.0, 17.0, 5.0, 1.0, 0.4, 0.1])
#: Size of the torque of each joint, N m.
SIZES = np.array([10.0, 40.0, 15.0, 2.0, 1.0, 0.5])


@cache
def arm() -> tuple[symgen.Evaluator, np.ndarray]:
    """The Puma 560 with bodies of 0.1 m, and its parameters without friction."""
    evaluator = symgen.load(symgen.derive("puma560", MOVED))
    rng = np.random.default_rng(5)
    values = {p.name: 0.0 for p in evaluator.model.base.standard}
    for j, m in enumerate(MASSES, 1):
        c = rng.uniform(-0.1, 0.1, 3)
        own = np.diag(0.02 * m * (1 + rng.uniform(-0.3, 0.3, 3)))
        J = own + m * (c @ c * np.eye(3) - np.outer(c, c))
        inertia = J[np.triu_indices(3)]
        keys = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M", "IA")
        for key, value in zip(keys, [*inertia, *(m * c), m, 0.02 * m], strict=True):
            if f"{key}{j}" in values:
                values[f"{key}{j}"] = value
    return evaluator, base_values(values, evaluator.model, "test")


def short_log(name: str, seed: int, seconds: float) -> symgen.Log:
    """A slow motion with noisy speeds, and with friction that the robot file does not have."""
    evaluator, X = arm()
    rng, noise = np.random.default_rng(seed), np.random.default_rng(seed + 100)
    t = np.arange(0.0, seconds, 0.01)
    w, a = rng.uniform(0.5, 2.5, (3, 6)), rng.uniform(0.1, 0.5, (3, 6))
    phase, middle = rng.uniform(0.0, 6.28, (3, 6)), rng.uniform(-0.7, 0.7, 6)
    angle = t[:, None, None] * w + phase
    shapes = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    q, qd, qdd = (x.sum(axis=1) for x in shapes)
    friction = 0.15 * np.tanh(qd / 0.02) * (1 + 0.5 * np.exp(-((qd / 0.1) ** 2))) + 0.1 * qd
    tau = np.asarray(evaluator["inverse_dynamics"](q + middle, qd, qdd, X))
    tau = tau + SIZES * (friction + 0.02 * noise.normal(size=q.shape))
    q = q + middle + 1e-5 * noise.normal(size=q.shape)
    return symgen.make_log(name, t, q, tau, qd + 3e-3 * noise.normal(size=q.shape))


@cache
def default(seed: int) -> symgen.Estimate:
    """The default estimate from 4 s, with the validation log of this seed."""
    held = short_log("held", seed, 4.0)
    return symgen.identify(arm()[0], short_log("train", 2, 4.0), validation=held)


@pytest.mark.slow
def test_a_short_log_does_not_extrapolate_and_the_reason_says_what_held_the_folds() -> None:
    found = default(52)
    assert found.method == "consistent"
    # Least squares has 30 % by both models, and the folds alone have a multiple of it.
    assert found.torque_validation.relative < 0.15
    assert any("with a weak prior (without it " in a.reason for a in found.alternatives)


@pytest.mark.slow
def test_another_validation_log_changes_neither_model_nor_method_nor_parameters() -> None:
    found, other = default(52), default(53)
    assert found.torque_validation.relative != other.torque_validation.relative
    assert (found.model, found.method) == (other.model, other.method)
    np.testing.assert_array_equal(found.X, other.X)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_the_default_is_as_good_as_the_best_of_both_models_and_methods(seed: int) -> None:
    train, held = short_log("train", seed, 4.0), short_log("held", seed + 50, 8.0)
    errors = []
    for model, method in (("auto", "auto"), *FOUR):
        found = symgen.identify(arm()[0], train, validation=held, model=model, method=method)
        errors.append(found.torque_validation.relative)
    assert errors[0] <= 1.15 * min(errors[1:]), errors


@pytest.mark.slow
def test_the_default_is_as_good_as_the_best_where_joints_move_in_proportion() -> None:
    folder = data_folder() / "panda30"
    evaluator = symgen.load(symgen.derive(folder / "robot.toml", MOVED))
    errors = []
    for model, method in (("auto", "auto"), *FOUR):
        found = symgen.identify(
            evaluator,
            folder / "train.npz",
            validation=folder / "test.npz",
            model=model,
            method=method,
        )
        errors.append(found.torque_validation.relative)
    assert errors[0] <= 1.1 * min(errors[1:]), errors
    assert errors[1] < 0.03, "torque by least squares, from which no parameter is taken out"
