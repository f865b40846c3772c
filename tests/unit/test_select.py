"""The rule by which an effect is taken, on equations that are made up: each clause by itself."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from symgen.diagnosis.select import _worse_fold, judge, project, quick_gain
from symgen.diagnosis.whitened_system import WhitenedSystem

K, N, P = 400, 2, 3


def candidate(
    kind: str = "linear",
    sign: str = "",
    change: bool = False,
    m: int = 1,
    reads: tuple[str, ...] = (),
) -> Any:
    definition = SimpleNamespace(
        kind=kind, sign=sign, linear={f"c{k}": "" for k in range(m)}, reads=reads
    )
    return SimpleNamespace(definition=definition, change=change)


def evidence(y: np.ndarray, W: np.ndarray, sigma=(1.0, 1.0), moves=None) -> WhitenedSystem:
    """Equations whose model is fitted by plain least squares, rows weighed by 1/sigma."""
    moves = np.ones((K, N)) if moves is None else moves
    weight = moves / np.array(sigma)
    X = np.linalg.lstsq(
        (W * weight[:, :, None]).reshape(y.size, -1), (y * weight).ravel(), rcond=None
    )[0]
    block = np.arange(len(y)) * 20 // len(y)
    logs: Any = (SimpleNamespace(unmasked=SimpleNamespace(measured=y)),)
    return WhitenedSystem(logs, W, y, X, np.array(sigma), moves, block, np.zeros(y.shape[1]))


@pytest.fixture
def draw() -> np.random.Generator:
    return np.random.default_rng(7)


@pytest.fixture
def parts(draw):
    """Regressor, parameters, noise, and a column that the model cannot say."""
    W = draw.normal(size=(K, N, P))
    return W, np.array([1.0, -2.0, 0.5]), draw.normal(size=(K, N)), draw.normal(size=(K, 1))


def rss(columns: np.ndarray, y: np.ndarray, weight: np.ndarray) -> float:
    """Sum of squares that least squares leaves."""
    A, b = (columns * weight[:, :, None]).reshape(K * N, -1), (y * weight).ravel()
    return float(np.sum((b - A @ np.linalg.lstsq(A, b, rcond=None)[0]) ** 2))


def both(W: np.ndarray, columns: dict[int, np.ndarray]) -> np.ndarray:
    wide = np.zeros((K, N, next(iter(columns.values())).shape[1]))
    for j, c in columns.items():
        wide[:, j] = c
    return np.concatenate([W, wide], axis=2)


@pytest.mark.parametrize("joints", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("sigma", [(1.0, 1.0), (0.2, 3.0)])
def test_the_gain_is_what_least_squares_gains_by_the_columns(parts, draw, joints, sigma):
    W, X, noise, _ = parts
    columns = {j: draw.normal(size=(K, 2)) for j in joints}
    moves = (draw.random((K, N)) > 0.2).astype(float)
    y = W @ X + noise * sigma
    for j, c in columns.items():
        y[:, j] += sigma[j] * c @ [0.6, -0.4]
    e = evidence(y, W, sigma, moves)
    weight = moves / np.array(sigma)
    own = np.sum(e.residual[:, list(joints)] ** 2)
    wanted = (rss(W, y, weight) - rss(both(W, columns), y, weight)) / own
    assert quick_gain(e, columns) == pytest.approx(wanted, rel=1e-6)
    score = judge(e, candidate(m=2), columns, 1)
    assert score.gain == pytest.approx(wanted, rel=1e-6)
    # Coefficients of both together, and the share of the whole gap in units of the torque.
    A = (both(W, columns) * weight[:, :, None]).reshape(K * N, -1)
    X_all = np.linalg.lstsq(A, (y * weight).ravel(), rcond=None)[0]
    np.testing.assert_allclose(score.coefficients, X_all[P:], rtol=1e-6)
    share = (np.array(sigma) / np.sqrt(np.mean(y**2, axis=0))) ** 2
    after = moves * (y - both(W, columns) @ X_all) / sigma
    closes = 1 - np.sum(after**2, axis=0) @ share / (np.sum(e.residual**2, axis=0) @ share)
    assert score.closes == pytest.approx(closes, rel=1e-6)
    assert score.fault == "" or "whole gap" in score.fault
    np.testing.assert_allclose(score.explained, e.residual - after, atol=1e-9)


def test_of_an_effect_that_is_not_there_p_is_even_and_std_that_of_the_estimates(draw):
    W = draw.normal(size=(K, N, P))
    ps, z, small = [], [], 0
    for _ in range(300):
        column = draw.normal(size=(K, 1))
        e = evidence(W @ np.ones(P) + draw.normal(size=(K, N)), W)
        score = judge(e, candidate(), {0: column}, 1)
        ps.append(score.p_value)
        z.append(score.coefficients[0] / score.std[0])
        small += "explains" in score.fault
    # Robust errors are the larger of two: p is even, or a little too large, never too small.
    assert stats.kstest(ps, "uniform", alternative="greater").pvalue > 0.001
    assert 0.4 < np.median(ps) < 0.75
    assert 0.75 < np.std(z) < 1.1
    assert small > 290


@pytest.mark.parametrize("unit", [1e-9, 1e5])
def test_the_unit_of_a_column_changes_its_coefficient_alone(parts, draw, unit):
    e, columns = effect(0.8, parts)
    columns = {0: np.hstack([columns[0], draw.normal(size=(K, 1))])}
    other = {0: columns[0] * [unit, 1.0]}
    a, b = (judge(e, candidate(m=2), c, 1) for c in (columns, other))
    np.testing.assert_allclose(b.coefficients * [unit, 1.0], a.coefficients, rtol=1e-6)
    np.testing.assert_allclose(b.std * [unit, 1.0], a.std, rtol=1e-6)
    assert (b.gain, b.p_value) == pytest.approx((a.gain, a.p_value), rel=1e-6)
    assert quick_gain(e, other) == pytest.approx(quick_gain(e, columns), rel=1e-6)
    assert project(e, other).known.tolist() == project(e, columns).known.tolist() == [True, True]


@pytest.mark.parametrize("blocks", [20, 2])
def test_one_coefficient_is_tested_by_t_with_a_block_less_than_there_are(parts, blocks):
    e, columns = effect(0.2, parts)
    e = replace(e, block=np.arange(K) * blocks // K)
    score = judge(e, candidate(), columns, 1)
    z = abs(score.coefficients[0] / score.std[0])
    assert z > 1
    assert score.p_value == pytest.approx(2 * stats.t.sf(z, blocks - 1), rel=1e-9)


def test_several_coefficients_are_tested_together(draw, parts):
    W, X, noise, _ = parts
    columns = {0: draw.normal(size=(K, 3))}
    y = W @ X + noise
    y[:, 0] += columns[0] @ [0.15, 0.15, 0.15]
    e = evidence(y, W)
    found = judge(e, candidate(m=3), columns, 1)
    white = (found.coefficients / found.std) ** 2
    # The columns are nearly orthogonal: the F test is of the mean of three squares.
    expected = stats.f.sf(white.sum() / 3 * (20 - 3) / (20 - 1), 3, 20 - 3)
    assert np.log(found.p_value) == pytest.approx(np.log(expected), rel=0.25)


def test_correlated_residuals_widen_the_std(draw, parts):
    W, X, _, _ = parts
    slow = np.repeat(draw.normal(size=(K // 10, N)), 10, axis=0)
    column = np.repeat(draw.normal(size=(K // 10, 1)), 10, axis=0)
    found = [
        judge(evidence(W @ X + e, W), candidate(), {0: column}, 1).std[0]
        for e in (slow, draw.permutation(slow))
    ]
    assert found[0] > 2 * found[1]


def test_what_the_model_says_itself_is_absorbed(parts):
    W, X, noise, column = parts
    e = evidence(W @ X + noise, W)
    said = {j: W[:, j] @ [[1.0], [2.0], [0.0]] for j in range(N)}
    score = judge(e, candidate(), said, 1)
    assert score.fault == "the model absorbs it"
    assert (score.gain, score.coefficients.tolist(), score.std.tolist()) == (0, [0], [0])
    assert (score.p_value, score.closes) == (1, 0)
    assert quick_gain(e, said) == 0
    # Of five per cent of it, no more than that counts as its own.
    nearly = {j: said[j] + 0.02 * column for j in range(N)}
    assert judge(e, candidate(), nearly, 1).fault == "the model absorbs it"
    clearly = {j: said[j] + 0.4 * column for j in range(N)}
    half = project(e, clearly)
    assert half.directions.shape == (1, 1)
    assert half.known.tolist() == [True]  # absorbed in part, but in no other direction


def test_coefficients_that_share_a_direction_with_the_model_are_not_known(parts, draw):
    W, X, noise, column = parts
    e = evidence(W @ X + noise, W)
    said = [W[:, j] @ [[1.0], [2.0], [0.0]] for j in range(N)]
    free = draw.normal(size=(K, 1))
    p = project(e, {j: np.hstack([free, said[j] + column, column]) for j in range(N)})
    assert p.directions.shape == (3, 2)
    assert p.known.tolist() == [True, False, False]


def test_a_column_of_zeros_is_known_to_do_nothing_and_is_not_positive(parts):
    W, X, noise, column = parts
    e = evidence(W @ X + noise + 0.8 * column, W)
    nothing = np.zeros((K, 1))
    assert judge(e, candidate(), {0: nothing}, 1).fault == "the model absorbs it"
    # Beside coefficients that are not known it alone is looked at.
    columns = {j: np.hstack([nothing, W[:, j] @ [[1.0], [2.0], [0.0]] + column, column])
               for j in range(N)}  # fmt: skip
    assert project(e, columns).known.tolist() == [True, False, False]
    score = judge(e, candidate(sign="positive", m=3), columns, 1)
    assert (score.coefficients[0], score.std[0]) == (0, 0)
    assert score.fault == "its coefficient has the wrong sign"
    assert judge(e, candidate(m=3), columns, 1).fault == ""
    # Nor is it negative.
    columns = {j: np.hstack([nothing, column]) for j in range(N)}
    assert judge(e, candidate(sign="positive", m=2), columns, 1).fault == ""


def effect(size: float, parts, joint: int = 0) -> tuple[WhitenedSystem, dict[int, np.ndarray]]:
    """Equations with an effect of so many standard deviations of the noise on a joint."""
    W, X, noise, column = parts
    y = W @ X + noise
    y[:, joint] += size * column[:, 0]
    return evidence(y, W), {joint: column}


# Of a column of unit size the gain is size^2 / (1 + size^2).
@pytest.mark.parametrize(
    ("kind", "size", "says"),
    [
        ("linear", 0.08, "needed: 2 %"),
        ("linear", 0.7, ""),
        ("model", 0.4, "needed: 20 %"),
        ("model", 0.8, ""),
        ("log", 0.8, "needed: 50 %"),
        ("log", 1.3, ""),
    ],
)
def test_what_belongs_to_the_chain_has_to_explain_more(parts, kind, size, says):
    e, columns = effect(size, parts)
    score = judge(e, candidate(kind), columns, 1)
    assert says in score.fault
    assert bool(says) == bool(score.fault)
    if says:
        assert score.fault.startswith(f"it explains {100 * score.gain:.2g} % ")


@pytest.mark.parametrize("stds", [2.6, 3.2])
def test_an_effect_counts_from_a_hundredth_of_the_residual(parts, stds):
    """In squares: 1 - 0.99^2."""
    e, columns = effect(0.2, parts)
    first = judge(e, candidate(), columns, 1)
    y = e.y.copy()
    y[:, 0] += (stds * first.std[0] - first.coefficients[0]) * columns[0][:, 0]
    score = judge(evidence(y, e.W), candidate(), columns, 1)
    assert (0.01 < score.gain < 0.0199) if stds == 2.6 else (0.0199 < score.gain < 0.0398)
    assert ("needed: 2 %" in score.fault) == (stds == 2.6)


def test_what_has_a_measurement_of_its_own_is_physics(parts):
    e, columns = effect(0.7, parts)
    assert judge(e, candidate("log", reads=("temp",)), columns, 1).fault == ""


@pytest.mark.parametrize(("other", "waits"), [(1.0, False), (40.0, True)])
def test_what_closes_little_of_the_whole_gap_waits(parts, other, waits):
    W, X, noise, column = parts
    y = W @ X + noise * [1.0, other]
    y[:, 0] += 0.8 * column[:, 0]
    score = judge(evidence(y, W, (1.0, other)), candidate(), {0: column}, 1)
    assert ("of the whole gap; needed: 5 %" in score.fault) == waits
    assert (score.closes < 1 - 0.95**2) == waits
    if waits:
        assert f"closes {100 * (1 - np.sqrt(1 - score.closes)):.2g} %" in score.fault


def test_every_candidate_that_was_tried_counts_in_its_significance(parts):
    e, columns = effect(0.55, parts)
    p = judge(e, candidate(), columns, 1).p_value
    assert 0 < p < 1e-5
    few, many = int(0.0009 / p), int(0.0011 / p) + 1
    assert judge(e, candidate(), columns, few).fault == ""
    assert f"{many} candidates were tried" in judge(e, candidate(), columns, many).fault


@pytest.mark.parametrize("sign", ["positive", ""])
@pytest.mark.parametrize("change", [False, True])
@pytest.mark.parametrize("size", [0.8, -0.8])
def test_a_coefficient_that_must_be_positive_is(parts, sign, change, size):
    e, columns = effect(size, parts)
    fault = judge(e, candidate(sign=sign, change=change), columns, 1).fault
    wrong = sign == "positive" and not change and size < 0
    assert fault == ("its coefficient has the wrong sign" if wrong else "")


def test_one_positive_coefficient_is_enough_and_one_negative_too_much(parts, draw):
    W, X, noise, column = parts
    other = draw.normal(size=(K, 1))
    for sizes, wrong in (((0.8, 0.0), False), ((0.8, -0.8), True), ((0.0, -0.8), True)):
        y = W @ X + noise
        y[:, 0] += np.hstack([column, other]) @ sizes
        fault = judge(
            evidence(y, W), candidate(sign="positive", m=2), {0: np.hstack([column, other])}, 1
        ).fault
        assert ("wrong sign" in fault) == wrong, sizes


@pytest.mark.parametrize(("stds", "wrong"), [(-1.8, False), (-2.2, True)])
def test_a_negative_coefficient_counts_from_two_std(parts, draw, stds, wrong):
    e, first = effect(0.8, parts)
    columns = {0: np.hstack([first[0], draw.normal(size=(K, 1))])}
    score = judge(e, candidate(m=2), columns, 1)
    # What the columns say already moves their coefficients, and no residual.
    y = e.y.copy()
    y[:, 0] += (stds * score.std[1] - score.coefficients[1]) * columns[0][:, 1]
    moved = judge(evidence(y, e.W), candidate(sign="positive", m=2), columns, 1)
    assert moved.coefficients[1] / moved.std[1] == pytest.approx(stds, rel=1e-6)
    assert ("wrong sign" in moved.fault) == wrong


def test_positive_coefficients_of_three_std_each_are_positive(parts, draw):
    """None of them is much above its error; all together they are significant."""
    e, _ = effect(0.0, parts)
    e = replace(e, block=np.arange(K) * 100 // K)
    columns = {j: draw.normal(size=(K, 12)) for j in range(N)}
    score = judge(e, candidate(m=12), columns, 1)
    y = e.y.copy()
    for j in range(N):
        y[:, j] += columns[j] @ (3 * score.std - score.coefficients)
    moved = replace(evidence(y, e.W), block=e.block)
    found = judge(moved, candidate(sign="positive", m=12), columns, 1)
    np.testing.assert_allclose(found.coefficients / found.std, 3, rtol=1e-6)
    assert found.fault == ""


@pytest.mark.parametrize(("share", "larger"), [(0.06, True), (0.25, True), (0.5, False)])
def test_a_torque_larger_than_the_torque_itself_is_none(parts, share, larger):
    """Columns that the model nearly says: the part that it cannot say is all that was measured."""
    W, _, noise, column = parts
    columns = {j: W[:, [j], 0] + share * column for j in range(N)}
    e = evidence(0.01 * noise + share * column, W, (0.01, 0.01))
    score = judge(e, candidate(), columns, 1)
    assert score.coefficients == pytest.approx([1], rel=0.1)
    assert (np.sqrt(1 + share**2) > 3 * share) == larger
    assert score.fault == ("its torque would be larger than the torque itself" if larger else "")


@pytest.mark.parametrize("fold", range(5))
def test_each_fold_must_fit_better_with_it(parts, fold):
    """In one fifth of the time the effect has the other sign: that fold is named."""
    W, X, noise, column = parts
    acting = np.cumsum(column[:, 0] ** 2)
    at = np.minimum((5 * acting / acting[-1]).astype(int), 4) == fold
    y = W @ X + 0.3 * noise
    y[:, 1] += np.where(at, -0.4, 1.0) * column[:, 0]
    e = evidence(y, W)
    score = judge(e, candidate(), {1: column}, 1)
    assert score.fault == f"the fit of held-out fold {fold + 1} is not better with it"


def test_rows_at_rest_have_no_say(parts):
    e, columns = effect(0.8, parts)
    W, moves = e.W, np.ones((K, N))
    moves[::3, 0] = moves[1::4, 1] = 0
    still = evidence(e.y, W, moves=moves)
    wrong = evidence(np.where(moves > 0, e.y, e.y + 50.0), W, moves=moves)
    a, b = (judge(x, candidate(), columns, 1) for x in (still, wrong))
    for name in ("coefficients", "std", "gain", "p_value"):
        assert getattr(a, name) == pytest.approx(getattr(b, name), rel=1e-9)
    assert a.fault == b.fault == ""


@pytest.mark.parametrize("joints", [(0,), (0, 1)])
def test_folds_are_those_of_cross_validation_by_hand(joints):
    """The first fold whose joints fit no better, or none; effects are weak: a near thing."""
    answers = []
    for seed in range(40):
        rng = np.random.default_rng([seed, len(joints)])
        W = rng.normal(size=(K, N, P)) * [1.0, 30.0, 0.1]
        sigma = np.array([0.5, 2.0])
        moves = (rng.random((K, N)) > 0.1).astype(float)
        columns = {j: rng.normal(size=(K, 2)) * np.linspace(0.5, 2, K)[:, None] for j in joints}
        y = W @ [1.0, 0.1, 5.0] + sigma * rng.normal(size=(K, N))
        for j, c in columns.items():
            y[:, j] += 0.12 * sigma[j] * c @ [1.0, -1.0]
        e = evidence(y, W, sigma, moves)
        p = project(e, columns)
        answers.append(_worse_fold(e, p, list(joints)))
        assert answers[-1] == _by_hand(W, y, columns, moves / sigma, joints), seed
    assert {0, 1, 2, 3} <= set(answers)


def test_what_changes_no_fit_makes_none_better():
    """Pairs of plus and minus in each fold, beside a constant: all sums are whole numbers."""
    free = np.zeros(16)
    free[:12] = [1, -1] * 5 + [0.25, -0.25]  # the last is what completes the fifth fold
    e = evidence(np.full((16, 1), 2.0), np.ones((16, 1, 1)), (1.0,), np.ones((16, 1)))
    p: Any = SimpleNamespace(free=free[:, None, None])
    assert _worse_fold(e, p, [0]) == 1


def _by_hand(W, y, columns, weight, joints) -> int:
    """Fit on four fifths, with and without the columns, and compare on the fifth."""
    wide = both(W, columns) * weight[:, :, None]
    rest, b = wide[:, :, :P], y * weight
    inside = rest.reshape(K * N, P)
    own = wide[:, :, P:].reshape(K * N, -1)
    own = own - inside @ np.linalg.lstsq(inside, own, rcond=None)[0]
    # It acts where, in orthonormal combinations, it is what the model cannot say.
    left, _, _ = np.linalg.svd(own, full_matrices=False)
    acting = np.cumsum(np.sum(left.reshape(K, N, -1) ** 2, axis=(1, 2)))
    fold = np.minimum((5 * acting / acting[-1]).astype(int), 4)
    for f in range(5):
        train, test = fold != f, fold == f
        errors = []
        for A in (rest, wide):
            n = A.shape[2]
            x = np.linalg.lstsq(A[train].reshape(-1, n), b[train].ravel(), rcond=None)[0]
            at = list(joints)
            errors.append(np.sum((b[test][:, at] - A[test][:, at] @ x) ** 2))
        if errors[1] >= errors[0]:
            return f + 1
    return 0


def test_the_whole_gap_counts_what_rests_leave(parts):
    e, columns = effect(0.8, parts)
    plain = judge(e, candidate(), columns, 1)
    share = (e.sigma / e.size) ** 2
    was = float(np.sum(e.residual**2, axis=0) @ share)
    rest = np.array([was / share[0], 0.0])  # as much again
    score = judge(replace(e, rest=rest), candidate(), columns, 1)
    assert score.closes == pytest.approx(plain.closes / 2)
    np.testing.assert_array_equal(score.coefficients, plain.coefficients)
    assert score.gain == plain.gain
