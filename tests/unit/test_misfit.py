"""What a torque of no name gets by chance: the bar that a name has to be above."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles import planar2r

import symgen
from symgen.diagnosis.baseline import KERNELS, Baseline
from symgen.diagnosis.chance_test import beyond_misfit, chance_share, share_of_unknown
from symgen.diagnosis.effects import candidates
from symgen.diagnosis.search import Search, Selection
from symgen.diagnosis.select import Score, judge, quick_gain
from symgen.diagnosis.whitened_system import WhitenedSystem, fitted_system
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered_log import filter_log
from symgen.faults.logs import open_samples
from symgen.runtime.evaluator import Evaluator

X, L1, STEP = np.array([1.702, 0.05644, 0.15, 0.075]), 0.5, 0.005
ROBOT = """
[robot]
name = "odd"
gravity = [0.0, 0.0, -9.81]
[[joint]]
[[joint]]
d = 0.5
"""


def motion(seed: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, STEP)
    w = np.array([[0.9, 1.3], [2.1, 2.7], [3.7, 4.6]])
    a, phase = np.array([[0.7], [0.35], [0.2]]), rng.uniform(0, 2 * np.pi, w.shape)
    angle = t[:, None, None] * w + phase
    waves = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    return (t, *(x.sum(axis=1) for x in waves))


def odd(seed: int, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """A torque of no name, of unit size: a few bends and bumps in directions of the motion."""
    rng = np.random.default_rng(seed)
    states = np.column_stack([q, qd]) / np.concatenate([q.std(axis=0), qd.std(axis=0)])
    out = np.zeros(len(q))
    for _ in range(6):
        along = states @ rng.normal(size=4) + rng.normal()
        out += rng.normal() * np.tanh(along) + rng.normal() * np.exp(-(along**2))
    return np.asarray(out / out.std())


def fields(q: np.ndarray, qd: np.ndarray, count: int) -> np.ndarray:
    """Gaussian fields over positions and speeds with a range of one spread, (N, count)."""
    states = np.column_stack([q, qd]) / np.concatenate([q.std(axis=0), qd.std(axis=0)])
    apart = np.sum((states[:, None] - states[None]) ** 2, axis=2)
    values, vectors = np.linalg.eigh(np.exp(-apart / 2))
    noise = np.random.default_rng(5).normal(size=(len(q), count))
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0))) @ noise)


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    return symgen.load(symgen.derive(symgen.parse_robot(ROBOT), KERNELS))


def looked_at(evaluator: Evaluator, more: np.ndarray | float, seed: int = 1) -> WhitenedSystem:
    """The equations of a log whose joint 2 has one more torque, N m."""
    t, q, qd, qdd = motion(seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += [1.0, 0.4] * np.sign(qd) + [0.6, 0.25] * qd
    tau[:, 1] += more
    tau += 0.005 * np.random.default_rng(seed).normal(size=tau.shape)
    log = symgen.make_log("log", t, q, tau, qd)
    samples, _ = open_samples(log, evaluator.model.robot)
    band = choose_band(evaluator, [samples], 10.0)
    return fitted_system(evaluator, [filter_log(samples, band)])


def searched(evaluator: Evaluator, base: WhitenedSystem) -> Search:
    model = Baseline(evaluator, base, (), base.X, False)
    return Search(model, candidates(evaluator.model.robot, base.logs))


def test_of_other_fields_few_are_above_the_bar(evaluator) -> None:
    search = searched(evaluator, looked_at(evaluator, 0.0))
    bar = chance_share(search, (1,))
    columns = [c for _, c in search.on_joints((1,))]
    base = search.baseline.base
    (s,) = base.logs
    basis = base.basis.reshape(base.y.size, -1)
    above = []
    for torque in fields(s.q[s.kept], s.qd[s.kept], 100).T:
        whole = np.zeros(base.y.shape)
        whole[:, 1] = base.moves[:, 1] / base.sigma[1] * torque
        flat = whole.ravel()
        left = (flat - basis @ (basis.T @ flat)).reshape(base.y.shape) * base.sigma
        told = replace(base, y=left, X=0 * base.X)
        above.append(max(quick_gain(told, c) for c in columns) > bar)
    assert 0.3 < bar < 0.95
    assert np.mean(above) <= 0.1


def offset(search: Search) -> Score:
    """The constant torque on joint 2, judged alone."""
    candidate = next(c for c in search.pool if c.key == ("torque_offset", (1,)))
    columns = search.baseline.seen(search.baseline.base)(candidate)
    return judge(search.baseline.base, candidate, columns, 1)


def selected(score: Score) -> Selection:
    return Selection((score,), (), 1)


def test_an_offset_that_explains_its_gap_stays_and_one_beside_a_misfit_goes(evaluator) -> None:
    noise = np.full(2, 0.002)
    _, q, qd, _ = motion(1)
    alone = searched(evaluator, looked_at(evaluator, 0.2))
    score = offset(alone)
    assert share_of_unknown(alone.baseline.base, [score], score, noise) > 0.98
    assert beyond_misfit(selected(score), alone, noise).accepted == (score,)

    mixed = searched(evaluator, looked_at(evaluator, 0.1 + 0.2 * odd(3, q, qd)))
    score = offset(mixed)
    share = share_of_unknown(mixed.baseline.base, [score], score, noise)
    assert 0.02 < share < 0.6
    answer = beyond_misfit(selected(score), mixed, noise)
    assert answer.accepted == ()
    assert "by chance" in answer.rejected[0].fault
