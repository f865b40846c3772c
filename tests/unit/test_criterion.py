"""The search for a motion: its loss by NumPy on identify's own equations, and its slopes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symgen
from symgen.experiment.bounds import Bounds, Space, space
from symgen.experiment.excitation import judge
from symgen.experiment.search import Clock, Program
from symgen.experiment.trajectory import basis

ROBOT = """
[robot]
name = "rubbing"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["viscous", "offset"]
[[joint]]
d = 0.5
friction = ["viscous"]
"""
LIMITS = Bounds(
    np.full(2, -2.0),
    np.full(2, 2.0),
    np.array([[3.0] * 2, [9.0] * 2, [np.inf] * 2]),
    np.full(2, np.inf),
    (1, 2),
)
WINDOW, STEPS = 0.2, 4


@pytest.fixture(scope="module")
def robot() -> symgen.Robot:
    return symgen.parse_robot(ROBOT, "rubbing")


def _choices(limits: Bounds = LIMITS) -> Space:
    bases = tuple((basis("fourier", T, 3), basis("bspline", T, 9)) for T in (3.0, 4.0))
    return space(bases, limits)


def _program(robot: symgen.Robot, choices: Space, model: str, criterion: str = "condition",
             prior: np.ndarray | None = None, clock: float = 100.0) -> Program:  # fmt: skip
    return Program(robot, choices, model, WINDOW, criterion, prior, Clock(clock), 30)


@pytest.mark.parametrize("model", ["energy", "momentum"])
@pytest.mark.parametrize("criterion", ["condition", "logdet"])
def test_the_loss_is_that_of_the_equations_that_identify_builds(robot, model, criterion) -> None:
    choices = _choices()
    program = _program(robot, choices, model, criterion)
    # Identify's equations at the stamps of the search: STEPS of them in a window.
    task = judge(robot, model, WINDOW, STEPS / WINDOW, LIMITS, None, False)
    for seed in range(3):
        z = choices.drawn(np.random.default_rng(seed))
        W = np.concatenate([e.W for e in task.equations(choices.trajectories(z), model)])
        norms = np.linalg.norm(W, axis=0)
        values = np.linalg.eigvalsh((W / norms).T @ (W / norms))
        powers = (np.log(np.sum(values**6)) + np.log(np.sum(values**-6.0))) / 12
        expected = powers if criterion == "condition" else -np.log(values).sum()
        if criterion == "condition":  # power means bound it from above
            log = np.log(np.linalg.cond(W / norms))
            assert log <= expected <= log + np.log(len(values)) / 6
        larger = 0.05 * np.mean(np.log(norms))  # of two alike in condition, the larger is preferred
        assert float(program.loss(z)) == pytest.approx(expected - larger, rel=1e-7)


@pytest.mark.parametrize("model", ["energy", "momentum", "torque"])
def test_motions_that_determine_nothing_have_a_loss_all_the_same(robot, model) -> None:
    choices = _choices()
    still = np.zeros(choices.size)
    assert np.isfinite(float(_program(robot, choices, model, "condition").loss(still)))


def test_torques_and_their_slopes_are_those_of_the_prior_model(robot) -> None:
    limits = replace(LIMITS, torque=np.array([np.inf, 2.0]))
    choices = _choices(limits)
    evaluator = symgen.load(symgen.derive(robot, ("inverse_dynamics",)))
    draw = np.random.default_rng(0)
    X = draw.uniform(0.1, 1, len(evaluator.model.base.parameters))
    program = _program(robot, choices, "energy", prior=X)
    kept = len(program.bounds["lbg"])
    free = len(_program(robot, choices, "energy").bounds["lbg"])
    slopes = program.solver.get_function("nlp_jac_g")
    z, d, e = choices.drawn(draw), draw.normal(size=choices.size), 1e-6
    g, jacobian = (x.full() for x in slopes(z, []))
    ends = [slopes(z + sign * e * d, [])[0].full()[:, 0] for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * e)
    np.testing.assert_allclose(jacobian @ d, difference, atol=1e-6 * np.abs(difference).max())
    expected = []
    for run in choices.trajectories(z):
        t = np.linspace(0, run.duration, (kept - free) // 2)
        tau = evaluator["inverse_dynamics"](run.at(t), run.at(t, 1), run.at(t, 2), X)
        expected.append(tau[:, 1] / 2.0)
    np.testing.assert_allclose(g[free:, 0], np.concatenate(expected), atol=1e-12)


def test_a_clock_that_has_run_out_stops_the_program(robot) -> None:
    choices = _choices()
    z = choices.drawn(np.random.default_rng(0))
    steps = {}
    for end in (0.0, 100.0):
        program = _program(robot, choices, "energy", clock=end)
        assert np.isfinite(program.solve(z)).all()
        steps[end] = program.solver.stats()["iter_count"]
    assert steps[0.0] <= 1 < steps[100.0]
