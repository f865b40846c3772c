"""What a model misses, as a random function of the state: its rows, its size, and its intervals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import simpson
from support import rows_of

from symgen.data.signals import Samples
from symgen.estimation.band import Band
from symgen.estimation.estimators import Ols, Wls
from symgen.estimation.features import RUBS, WAVES, Features, features_of
from symgen.estimation.filtered_log import filter_log, unfiltered
from symgen.estimation.system import Equations, Extent, Rows, join
from symgen.estimation.windows import place_windows, rates_only, window_rows

#: Cosines and sines of the waves that are smooth; the others jump with the sign of a speed.
SMOOTH = np.r_[: WAVES - RUBS, WAVES : 2 * WAVES - RUBS]
NAMES = ("A", "B", "C")
TRUE = np.array([2.0, -1.0, 0.5])
ROWS = 480


def _state(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Times, and a slow motion of two variables, (ROWS, 2)."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 12, ROWS)
    rate, phase = rng.uniform(0.5, 2.5, (3, 2)), rng.uniform(0, 6, (3, 2))
    return t, np.sin(t[:, None, None] * rate + phase).sum(axis=1)


def _system(seed: int, misfit: float, known: bool, noise: float = 0.05) -> Rows:
    """Two logs of two joints, with a function of the state that the columns do not hold."""
    rng = np.random.default_rng([seed, 5])
    features = Features((0.0,) * 4, (0.7,) * 4, (1.0, 1.0))
    ways, phase = rng.normal(size=(4, 6)), rng.uniform(0, 6, (6, 2))  # the same in both logs
    logs = []
    for log in range(2):
        t, x = _state(10 * seed + log)
        state = np.hstack([x, np.gradient(x, t, axis=0)])
        missing = misfit / np.sqrt(3) * np.cos((state @ ways)[..., None] + phase).sum(axis=1)
        F = features(state[:, :2], state[:, 2:])
        W = np.stack([np.sin(x), x[:, ::-1] * x, state[:, 2:]], axis=2)
        y = W @ TRUE + missing + noise * rng.normal(size=(2, ROWS)).T
        ones, extents = np.ones(y.shape), (Extent(ROWS, 1),)
        logs.append(Rows(NAMES, W, y, t, ones, extents, features=F if known else None))
    return join(logs)


def _held(misfit: float, known: bool, runs: int = 25) -> float:
    """How many of 95 % intervals hold the truth."""
    inside = []
    for seed in range(runs):
        found = Wls().solve(_system(seed, misfit, known))
        inside.append(np.abs(found.X - TRUE) < 1.96 * found.std)
    return float(np.mean(inside))


def test_intervals_hold_the_truth_beside_a_function_that_no_column_has() -> None:
    assert _held(0.4, known=True) > 0.90
    assert _held(0.4, known=False) < 0.80
    assert _held(0.0, known=True) > 0.90


def _longer_friction(jumps: bool) -> float:
    """Deviation of a Coulomb friction, over that of a system whose misfit is known to be smooth."""
    rng = np.random.default_rng(3)
    t, x = _state(4)
    state = np.hstack([x, np.gradient(x, t, axis=0)])
    F = Features((0.0,) * 4, (0.7,) * 4, (1.0, 1.0))(state[:, :2], state[:, 2:])[:, 0]
    own = np.isin(np.arange(2 * WAVES), SMOOTH) ^ jumps
    missing = F[:, own] @ rng.normal(size=WAVES)
    W = np.column_stack([np.sin(x[:, 0]), x[:, 1] * x[:, 0], np.sign(state[:, 2])])
    y = W @ TRUE + missing + 0.05 * rng.normal(size=ROWS)
    smooth = np.where(np.isin(np.arange(2 * WAVES), SMOOTH), F, 0.0)
    systems = [Equations(W, y, 1, 0, features=rows) for rows in (F, smooth)]
    both, alone = (Ols().solve(rows_of(NAMES, e)).std[2] for e in systems)
    return float(both / alone)


def test_a_misfit_widens_coulomb_friction_by_its_own_jumps_alone() -> None:
    smooth, jumps = _longer_friction(False), _longer_friction(True)
    assert smooth < 1.05
    assert jumps > 1.0


def _samples() -> Samples:
    t = 0.005 * np.arange(4000)
    q = np.column_stack([np.sin(t), 0.5 * np.cos(1.7 * t), 0 * t])
    qd = np.column_stack([np.cos(t), -0.85 * np.sin(1.7 * t), 0 * t])
    return Samples("log", t, q, qd, np.column_stack([3 * np.sin(t), 0 * t, 0 * t]), 0.005, None, ())


@pytest.mark.parametrize("model", ["momentum", "energy"])
def test_equations_of_windows_see_the_integral_of_each_function(model: str) -> None:
    log = unfiltered(_samples())
    known, w = features_of([log], (0, 0, 0)), place_windows(log, 0.3)
    functions = known if model == "momentum" else known.powers
    q, qd = log.nodes(w.stride)
    rates = rates_only(lambda nodes: functions(q[nodes], qd[nodes]))
    rows = window_rows(len(q), w, log.step, rates)
    values = functions(log.q, log.qd)
    for row, first, last in zip(rows, *w.spans(len(log.t)), strict=True):
        expected = simpson(values[first : last + 1], dx=log.step, axis=0)
        np.testing.assert_allclose(row[..., SMOOTH], expected[..., SMOOTH], atol=1e-7)
        # a reversal between two nodes
        late = 2 * w.stride * log.step * np.abs(values).max()
        np.testing.assert_allclose(row, expected, atol=late)


def test_equations_of_torque_see_each_function_below_the_comparison_frequency() -> None:
    log = filter_log(_samples(), Band(20.0, 30.0, 5.0, "measured"))
    known = features_of([log], (0, 0, 0))
    rows, exact = (
        x[20:-20, ...] for x in (known.in_band(log.at_nodes()), known(log.q, log.qd)[log.kept])
    )
    np.testing.assert_allclose(
        rows[..., SMOOTH], exact[..., SMOOTH], atol=0.01 * np.abs(rows).max()
    )
    apart = np.abs(rows - exact)[:, :2].max(axis=(1, 2))
    assert np.median(apart) < 0.01 * np.abs(rows).max()  # away from reversals
