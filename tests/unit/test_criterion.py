"""The criterion: NumPy's condition number, differences, and identify's own equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symgen
from symgen.data.signals import Samples
from symgen.estimation.system import energy_equations, momentum_equations
from symgen.experiment.bounds import Bounds
from symgen.experiment.criterion import KERNELS, condition_number, log_determinant, loss, windows
from symgen.experiment.objective import Objective, smooth_robot
from symgen.experiment.search import Clock, Program, Torques
from symgen.experiment.space import space
from symgen.experiment.trajectory import basis

ROBOT = """
[robot]
name = "rubbing"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
[[joint]]
d = 0.5
friction = ["viscous", "offset"]
"""
LIMITS = Bounds(
    np.full(2, -2.0),
    np.full(2, 2.0),
    np.array([[3.0] * 2, [9.0] * 2, [np.inf] * 2]),
    np.full(2, np.inf),
    (1, 2),
)


@pytest.mark.parametrize("seed", range(5))
def test_condition_number_and_log_det_are_numpys_on_scaled_columns(seed: int) -> None:
    draw = np.random.default_rng(seed)
    W = draw.normal(size=(60, 7)) * 10.0 ** draw.uniform(-3, 3, 7)
    scaled = W / np.sqrt((W**2).sum(axis=0))
    assert condition_number(W) == pytest.approx(np.linalg.cond(scaled), rel=1e-10)
    sign, value = np.linalg.slogdet(scaled.T @ scaled)
    assert sign == 1
    assert log_determinant(W) == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize("spoil", ["zero column", "equal columns", "few rows"])
def test_a_singular_regressor_is_infinitely_badly_conditioned(spoil: str) -> None:
    W = np.random.default_rng(0).normal(size=(20, 4))
    if spoil == "zero column":
        W[:, 2] = 0
    elif spoil == "equal columns":
        W[:, 2] = 3 * W[:, 1]
    else:
        W = W[:3]
    assert condition_number(W) == np.inf or condition_number(W) > 1e14


@pytest.mark.parametrize("criterion", ["condition", "logdet"])
def test_the_gradient_of_the_loss_is_that_of_differences(criterion: str) -> None:
    draw = np.random.default_rng(3)
    W, d, e = draw.normal(size=(30, 6)), draw.normal(size=(30, 6)), 1e-6
    slope = (loss(W + e * d, criterion)[0] - loss(W - e * d, criterion)[0]) / (2 * e)
    assert np.sum(loss(W, criterion)[1] * d) == pytest.approx(slope, rel=1e-6)


def test_the_loss_bounds_the_log_of_the_condition_number_from_above() -> None:
    # Power means over p values exceed the largest by a factor of at most p ** (1/6).
    W = np.random.default_rng(4).normal(size=(30, 6))
    scaled = W / np.linalg.norm(W, axis=0)
    smooth = loss(scaled, "condition")[0]  # columns of unit norm: no reward for large ones
    log = np.log(np.linalg.cond(scaled))
    assert log <= smooth <= log + np.log(6) / 6


@pytest.mark.parametrize("criterion", ["condition", "logdet"])
def test_of_motions_alike_in_condition_the_larger_is_preferred(criterion: str) -> None:
    W = np.random.default_rng(4).normal(size=(30, 6))
    assert loss(2 * W, criterion)[0] < loss(W, criterion)[0]
    better = np.linalg.qr(W)[0] * np.linalg.norm(W, axis=0)  # best conditioned, of the same size
    assert loss(better, criterion)[0] < loss(2 * W, criterion)[0]


@pytest.fixture(scope="module")
def evaluator() -> symgen.Evaluator:
    return symgen.load(symgen.derive(symgen.parse_robot(ROBOT, "rubbing"), "all"))


def _samples(count: int, step: float) -> Samples:
    t = np.arange(count) * step
    q = np.stack([np.sin(1.3 * t), np.cos(2.1 * t)], axis=1)
    qd = np.stack([1.3 * np.cos(1.3 * t), -2.1 * np.sin(2.1 * t)], axis=1)
    return Samples("motion", t, q, qd, 0 * q, step, None, ())


@pytest.mark.parametrize("model", ["energy", "momentum"])
def test_windows_are_the_equations_that_identify_builds(evaluator, model: str) -> None:
    s = _samples(80, 0.05)
    outputs = [evaluator[name](s.q, s.qd) for name in KERNELS[model]]
    flat = tuple(x for o in outputs for x in (o if isinstance(o, tuple) else (o,)))
    W = windows(model, 80, 0.05, 4).rows(flat)
    if model == "energy":
        expected = energy_equations(evaluator, s, 0.2).W
    else:
        joints = momentum_equations(evaluator, s, 0.2)
        expected = np.stack([e.W for e in joints], axis=1).reshape(-1, W.shape[1])
    np.testing.assert_allclose(W, expected, atol=1e-12)


@pytest.mark.parametrize("model", ["energy", "momentum", "torque"])
def test_the_way_back_through_the_windows_is_the_transpose(model: str) -> None:
    draw = np.random.default_rng(2)
    shapes = {
        "energy": ((30, 5), (30, 4)),
        "momentum": ((30, 2, 5), (30, 2, 5), (30, 2, 4)),
        "torque": ((30, 2, 9),),
    }[model]
    own = windows(model, 30, 0.05, 4)
    samples = tuple(draw.normal(size=s) for s in shapes)
    W = own.rows(samples)
    G = draw.normal(size=W.shape)
    back = own.transposed(G, samples)
    assert sum(np.sum(a * b) for a, b in zip(back, samples, strict=True)) == pytest.approx(
        np.sum(G * W)
    )


@pytest.mark.parametrize("model", ["energy", "momentum", "torque"])
@pytest.mark.parametrize("criterion", ["condition", "logdet"])
def test_the_gradient_through_the_kernels_is_that_of_differences(
    evaluator, model, criterion
) -> None:
    bases = tuple((basis("fourier", T, 3), basis("bspline", T, 9)) for T in (3.0, 4.0))
    choices = space(bases, LIMITS)
    robot = smooth_robot(evaluator.model.robot, LIMITS)
    objective = Objective(robot, choices, model, 0.2, evaluator.model)
    draw = np.random.default_rng(0)
    z = choices.drawn(draw, LIMITS)
    for _ in range(3):
        d, e = draw.normal(size=choices.size), 1e-6
        slope = (objective(z + e * d, criterion)[0] - objective(z - e * d, criterion)[0]) / (2 * e)
        assert objective(z, criterion)[1] @ d == pytest.approx(slope, rel=1e-4, abs=1e-5)


def test_torques_and_their_jacobian_are_those_of_the_prior_model(evaluator) -> None:
    limits = replace(LIMITS, torque=np.array([np.inf, 2.0]))
    bases = tuple((basis("fourier", T, 3), basis("bspline", T, 9)) for T in (3.0, 4.0))
    choices = space(bases, limits)
    robot = smooth_robot(evaluator.model.robot, limits)
    objective = Objective(robot, choices, "energy", 0.2, evaluator.model)
    draw = np.random.default_rng(0)
    X = draw.uniform(0.1, 1, len(evaluator.model.base.parameters))
    torques = Torques(objective, limits, X)
    z, d, e = choices.drawn(draw, limits), draw.normal(size=choices.size), 1e-6
    values, jacobian = torques.at(z)
    slope = (torques.at(z + e * d)[0] - torques.at(z - e * d)[0]) / (2 * e)
    np.testing.assert_allclose(jacobian @ d, slope, atol=1e-6 * np.abs(slope).max())
    smooth = symgen.load(symgen.derive(robot, ("inverse_dynamics",)), backend="casadi")
    expected = []
    for run in choices.trajectories(z):
        t = np.linspace(0, run.duration, len(values) // 2)
        tau = smooth["inverse_dynamics"](run.at(t), run.at(t, 1), run.at(t, 2), X)
        expected.append(tau[:, 1] / 2.0)
    np.testing.assert_allclose(values, np.concatenate(expected), atol=1e-12)


def test_a_clock_that_has_run_out_stops_the_program(evaluator) -> None:
    choices = space(((basis("fourier", 5.0, 6),) * 2,), LIMITS)
    robot = smooth_robot(evaluator.model.robot, LIMITS)
    objective = Objective(robot, choices, "energy", 0.2, evaluator.model)
    z = choices.drawn(np.random.default_rng(0), LIMITS)
    steps = {}
    for end in (0.0, 100.0):
        program = Program(objective, LIMITS, None, Clock(end), 30)
        found = program.solve(z, "condition")
        steps[end] = program.solvers["condition"].stats()["iter_count"]
        assert np.isfinite(found).all()
    assert steps[0.0] <= 1 < steps[100.0]
