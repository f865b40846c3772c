"""Every estimator against an independent one: statsmodels, SciPy, plain NumPy, published tables."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
import scipy.optimize
import scipy.stats
import statsmodels.api as sm
from oracles.precision import at_least_white
from support import rows_of

import symgen
from symgen.estimation.estimators import (
    METHODS,
    Estimator,
    Huber,
    InstrumentalVariables,
    Ols,
    Prior,
    TotalLeastSquares,
    Wls,
)
from symgen.estimation.summary import solve_gram, triangle
from symgen.estimation.system import Equations, Rows
from symgen.identification.parameters import read_prior
from symgen.identification.possible import nearest_possible

TRUE = np.array([1.5, -0.4, 0.02, 3.0])
NAMES = ("A", "B", "C", "FV1")
#: Eight lags of 400 rows: Kiefer and Vogelsang (2005), table 1, b = 0.02.
WIDER = (1.96 + 2.9694 * 0.02 + 0.4160 * 0.02**2 - 0.5324 * 0.02**3) / 1.96


def _rows(seed: int, rows: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """A regressor with columns of different sizes, and y with noise that is correlated in time."""
    draw = np.random.default_rng(seed)
    W = draw.normal(size=(rows, 4)) @ np.array(
        [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 30, 0.1], [0, 0, 0, 0.2]]
    )
    noise = draw.normal(size=rows + 1)
    return W, W @ TRUE + 0.3 * (noise[1:] + 0.6 * noise[:-1])


def _system(*logs: tuple[np.ndarray, np.ndarray], Z: np.ndarray | None = None) -> Rows:
    return rows_of(NAMES, *(Equations(W, y, Z=Z) for W, y in logs))


def test_ols_and_its_robust_errors_are_those_of_statsmodels() -> None:
    W, y = _rows(1)
    found = Ols().solve(_system((W, y)))
    expected = sm.OLS(y, W).fit(cov_type="HAC", cov_kwds={"maxlags": 7, "use_correction": True})
    np.testing.assert_allclose(found.X, expected.params, rtol=1e-10)
    plain, bread = WIDER**2 * expected.cov_params(), np.linalg.inv(W.T @ W)
    np.testing.assert_allclose(found.covariance, at_least_white(plain, bread, W, y), rtol=1e-8)


def test_nearly_dependent_columns_are_as_exact_as_by_reflections() -> None:
    """The products of A lose half the digits, its triangle must not: R^-1 makes A orthogonal."""
    for apart in (1e-3, 1e-5, 3e-6, 1e-7, 1e-8):
        A = np.random.default_rng(3).normal(size=(500, 3))
        A[:, 2] = A[:, 0] + apart * A[:, 2]
        Q = A @ np.linalg.inv(triangle(A))
        assert np.abs(Q.T @ Q - np.eye(3)).max() < 1e-15 / apart


@pytest.mark.parametrize("apart", [1.0, 1e-2, 1e-4, 3e-5, 0.0])
def test_products_of_rows_give_the_least_squares_of_numpy_whatever_their_scales(apart) -> None:
    """The shortest solution in units of the columns, where the rows do not determine it."""
    rng = np.random.default_rng(1)
    W = rng.normal(size=(400, 6)) * np.array([1.0, 1e-3, 50.0, 1.0, 7.0, 1e4])
    W[:, 3] = W[:, 0] + apart * W[:, 3]
    W[:, 4] *= apart > 0
    A = np.column_stack([W, rng.normal(size=400)])
    size = np.maximum(np.linalg.norm(W, axis=0), 1e-9)
    expected = np.linalg.lstsq(W / size, A[:, 6], rcond=1e-10)[0]
    error = np.abs(size * solve_gram(A.T @ A) - expected).max()
    # products have the square of the condition number
    assert error < 1e-14 / (apart or 1e-2) ** 2 * np.abs(expected).max()


def test_wls_is_that_of_statsmodels_with_the_same_weights() -> None:
    first, second = _rows(1), _rows(2)
    second = (second[0], second[1] + 3 * np.random.default_rng(3).normal(size=400))
    found = Wls().solve(_system(first, second))
    assert found.weights[0] > 5 * found.weights[1]
    W, y = (np.concatenate(pair) for pair in zip(first, second, strict=True))
    expected = sm.WLS(y, W, weights=np.repeat(np.square(found.weights), 400)).fit()
    np.testing.assert_allclose(found.X, expected.params, rtol=1e-9)
    # The weights are those of the residuals of the estimate itself.
    for (W1, y1), weight in zip((first, second), found.weights, strict=True):
        assert weight * np.sqrt(np.mean((y1 - W1 @ found.X) ** 2)) == pytest.approx(1, rel=1e-3)


def test_huber_is_that_of_statsmodels() -> None:
    W, y = _rows(4)
    y[::17] += 25.0
    found = Huber().solve(_system((W, y)))
    model = sm.RLM(y, W, M=sm.robust.norms.HuberT(1.345))
    expected = model.fit(tol=1e-12, maxiter=200)
    np.testing.assert_allclose(found.X, expected.params, rtol=1e-5)
    plain = Ols().solve(_system((W, y)))
    ratio = np.abs(found.X - TRUE) / np.sqrt(np.diag(found.covariance))
    assert ratio.max() < 4
    assert np.linalg.norm(W @ (found.X - TRUE)) < 0.5 * np.linalg.norm(W @ (plain.X - TRUE))
    share = float(found.notes[0].split(" %")[0])
    assert 100 / 17 < share < 35


# Pearson 1901, "On lines and planes of closest fit": his ten points, and his line of best fit.
PEARSON = np.array(
    [[0.0, 5.9], [0.9, 5.4], [1.8, 4.4], [2.6, 4.6], [3.3, 3.5], [4.4, 3.7], [5.2, 2.8],
     [6.1, 2.8], [6.5, 2.4], [7.4, 1.5]]
)  # fmt: skip


def test_total_least_squares_finds_the_line_of_pearson() -> None:
    x, y = PEARSON.T
    system = rows_of(("slope", "offset"), Equations(np.column_stack([x, np.ones(10)]), y))
    found = TotalLeastSquares(np.array([1.0, 0.0])).solve(system)
    # Published: slope -0.5456, intercept 5.7840 (Pearson 1901; York 1966).
    np.testing.assert_allclose(found.X, [-0.5456, 5.7840], atol=1e-4)


def test_total_least_squares_is_orthogonal_regression_of_scipy() -> None:
    W, _ = _rows(7)
    W = W[:, :2]
    draw = np.random.default_rng(8)
    y = W @ TRUE[:2] + 0.2 * draw.normal(size=len(W))
    noisy = W + np.array([0.1, 0.3]) * draw.normal(size=W.shape)
    noise = np.array([0.5, 1.5])
    system = rows_of(NAMES[:2], Equations(noisy, y))
    found = TotalLeastSquares(noise).solve(system)

    def distance(X: np.ndarray) -> float:
        return float(np.sum((y - noisy @ X) ** 2) / (1 + np.sum((noise * X) ** 2)))

    best = scipy.optimize.minimize(distance, Ols().solve(system).X, tol=1e-12)
    np.testing.assert_allclose(found.X, best.x, rtol=1e-5)


def test_total_least_squares_has_no_bias_where_its_noise_is_right_and_honest_errors() -> None:
    W, _ = _rows(9, 600)
    W = W[:, [0, 1]]
    draw = np.random.default_rng(10)
    noise = np.array([0.2, 0.3])
    X, std, least = [], [], []
    for _ in range(300):
        y = W @ TRUE[:2] + 0.2 * draw.normal(size=len(W))
        noisy = W + noise * draw.normal(size=W.shape)
        system = rows_of(NAMES[:2], Equations(noisy, y))
        found = TotalLeastSquares(noise / 0.2).solve(system)
        X.append(found.X)
        std.append(np.sqrt(np.diag(found.covariance)))
        least.append(Ols().solve(system).X)
    error = np.std(X, axis=0) / np.sqrt(300)
    assert np.all(np.abs(np.mean(X, axis=0) - TRUE[:2]) < 4 * error)
    assert np.all(np.abs(np.mean(least, axis=0) - TRUE[:2]) > 6 * error)
    np.testing.assert_allclose(np.mean(std, axis=0), np.std(X, axis=0), rtol=0.15)


def test_a_prior_is_its_normal_equations() -> None:
    W, y = _rows(11)
    mean, std = np.array([1.0, 0.0, 0.0, 2.0]), np.array([0.1, np.inf, 1e-3, 0.5])
    found = Prior(mean, std).solve(_system((W, y)))
    sigma2 = np.mean((y - W @ found.X) ** 2)
    information = np.diag(1 / std**2)
    expected = np.linalg.solve(
        W.T @ W / sigma2 + information, W.T @ y / sigma2 + information @ mean
    )
    np.testing.assert_allclose(found.X, expected, rtol=1e-3)


def test_a_prior_is_what_remains_where_data_say_nothing_and_gives_way_where_they_do() -> None:
    W, y = _rows(12)
    W[:, 1] = 0.0
    y = W @ TRUE + 0.01 * np.random.default_rng(1).normal(size=len(y))
    found = Prior(np.array([0.0, 7.0, 0.0, 0.0]), np.full(4, 5.0)).solve(_system((W, y)))
    np.testing.assert_allclose(found.X, [1.5, 7.0, 0.02, 3.0], atol=0.02)
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(5.0)


def _instrumented(seed: int, rows: int = 400) -> tuple[Rows, np.ndarray]:
    """Noise in W that is in y - W X too, and instruments with noise of their own."""
    draw = np.random.default_rng(seed)
    clean, _ = _rows(13, rows)
    y = clean @ TRUE + 0.1 * draw.normal(size=rows)
    size = np.std(clean, axis=0)
    W = clean + 0.4 * size * draw.normal(size=clean.shape)
    Z = clean + 0.4 * size * draw.normal(size=clean.shape)
    return _system((W, y), Z=Z), clean


def test_iv_is_two_stage_least_squares_of_statsmodels() -> None:
    from statsmodels.sandbox.regression.gmm import IV2SLS

    system, _ = _instrumented(14)
    e = system.parts[0]
    expected = IV2SLS(e.y, e.W, e.Z).fit().params
    found = InstrumentalVariables().solve(system)
    np.testing.assert_allclose(found.X, expected, rtol=1e-9)
    # White's sandwich with instruments, by hand: with lags of one row.
    assert e.Z is not None
    inverse = np.linalg.inv(e.Z.T @ e.W)
    scores = (e.y - e.W @ found.X)[:, None] * e.Z
    meat = scores.T @ scores
    for k in range(1, 8):
        lagged = scores[k:].T @ scores[:-k]
        meat += (1 - k / 8) * (lagged + lagged.T)
    plain = WIDER**2 * 400 / 396 * inverse @ meat @ inverse.T
    expected = at_least_white(plain, inverse, e.W, e.y, Z=e.Z)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-8)
    assert found.comparison[0].method == "wls"
    np.testing.assert_allclose(found.comparison[0].X, np.linalg.lstsq(e.W, e.y)[0], rtol=1e-9)


def test_iv_has_no_bias_where_least_squares_has_and_covers_the_truth() -> None:
    X, least, inside = [], [], []
    for seed in range(300):
        found = InstrumentalVariables().solve(_instrumented(1000 + seed)[0])
        X.append(found.X)
        least.append(found.comparison[0].X)
        inside.append(np.abs(found.X - TRUE) < 1.96 * np.sqrt(np.diag(found.covariance)))
    bias, before = np.mean(X, axis=0) - TRUE, np.mean(least, axis=0) - TRUE
    error = np.std(X, axis=0) / np.sqrt(300)
    assert np.all(np.abs(before[[0, 3]]) > 10 * error[[0, 3]])
    assert np.all(np.abs(bias) < 4 * error)
    assert 0.92 < np.mean(inside) < 0.975


def test_durbin_wu_hausman_is_the_augmented_regression_of_statsmodels() -> None:
    system, _ = _instrumented(15)
    e = system.parts[0]
    assert e.Z is not None
    V = e.W - e.Z @ np.linalg.lstsq(e.Z, e.W)[0]
    tests = {t.columns: t for t in InstrumentalVariables().solve(system).endogeneity}
    for label, columns in (("all", [0, 1, 2, 3]),):
        both = np.column_stack([e.W, V[:, columns]])
        fitted = sm.OLS(e.y, both).fit(
            cov_type="HAC", cov_kwds={"maxlags": 7, "use_correction": True}, use_t=True
        )
        wald = fitted.f_test(np.eye(both.shape[1])[4:])
        assert tests[label].statistic == pytest.approx(float(wald.statistic) / WIDER**2, rel=1e-6)
        freedom = (len(columns), 400 - 4 - len(columns))
        assert tests[label].df == freedom
        p_value = scipy.stats.f.sf(float(wald.statistic) / WIDER**2, *freedom)
        assert tests[label].p_value == pytest.approx(p_value, rel=1e-6, abs=1e-14)


@pytest.mark.parametrize("biased", [False, True])
def test_durbin_wu_hausman_rejects_at_its_level_and_finds_bias(biased: bool) -> None:
    rejected = []
    for seed in range(300):
        system, clean = _instrumented(3000 + seed)
        e = system.parts[0]
        if not biased:  # y follows W as measured: its noise is no error
            noise = 0.3 * np.random.default_rng(seed).normal(size=400)
            system = _system((e.W, e.W @ TRUE + noise), Z=clean)
        rejected.append(InstrumentalVariables().solve(system).endogeneity[0].p_value < 0.05)
    assert (np.mean(rejected) > 0.99) if biased else (0.02 < np.mean(rejected) < 0.11)


@pytest.mark.parametrize(
    ("estimator", "rows", "said"),
    [
        (InstrumentalVariables(), 400, "needs instruments; accepted"),
        *((e, 4, "4 equations for 4 parameters")
          for e in (Ols(), Wls(), Huber(), Prior(TRUE, TRUE), TotalLeastSquares())),
        *((Prior(mean, std), 400, "the prior is not one of 4 parameters")
          for mean, std in ((TRUE[:3], TRUE[:3]), (TRUE, np.ones(3)), (np.ones(5), np.ones(5)))),
        *((Prior(TRUE * mean, np.append(np.ones(3), std)), 400, "means are not finite, or a std")
          for mean, std in ((np.nan, 1), (np.inf, 1), (1, 0.0), (1, -1.0), (1, np.nan))),
        *((TotalLeastSquares(np.array(noise)), 400, "is not 4 numbers of 0 or above")
          for noise in ([0.1] * 3, [0.1, -0.1, 0, 0], [0.1, np.nan, 0, 0], [0.1, np.inf, 0, 0])),
    ],
)  # fmt: skip
def test_what_an_estimator_cannot_use_is_said(estimator: Estimator, rows: int, said: str) -> None:
    with pytest.raises(symgen.IdentificationError, match=said):
        estimator.solve(_system(_rows(1, rows)))


def test_total_least_squares_without_an_answer_says_so() -> None:
    W = 1e-3 * np.tile([1.0, -1.0], 50)[:, None]
    flat = rows_of("A", Equations(W, np.ones(100)))
    with pytest.raises(symgen.IdentificationError, match="total least squares has no"):
        TotalLeastSquares(np.ones(1)).solve(flat)


@pytest.mark.parametrize(
    ("alike", "names"), [(2, "A, B (1 of 10"), (8, "A, B, C, D, E, F, G, H (7 of 10"),
                         (9, "F, G, H, ... (8 of 10")],
)  # fmt: skip
def test_what_is_not_determined_is_named_and_counted(alike: int, names: str) -> None:
    W = np.random.default_rng(17).normal(size=(50, 10))
    W[:, :alike] = W[:, :1]
    system = rows_of("ABCDEFGHIJ", Equations(W, W[:, 0]))
    with pytest.raises(symgen.IdentificationError) as refused:
        Ols().solve(system)
    assert f"{names} combinations" in str(refused.value)


class TestNearestPossible:
    MODEL = symgen.derive(symgen.read_robot("planar2r"))
    #: ZZ1R, ZZ2, MX2, MY2: M2 = (MX2^2 + MY2^2)/ZZ2 at least, and L1^2 M2 at most ZZ1R
    IMPOSSIBLE = np.array([0.05, 0.02, 0.15, 0.075])
    COVARIANCE = np.diag([0.01, 0.01, 0.02, 0.03]) ** 2

    def test_the_nearest_is_that_of_the_analytic_condition(self) -> None:
        near = nearest_possible(self.MODEL, self.IMPOSSIBLE, self.COVARIANCE)
        std = np.sqrt(np.diag(self.COVARIANCE))

        def room(u: np.ndarray) -> float:
            X = self.IMPOSSIBLE + std * u
            return float(100 * (X[0] * X[1] - 0.25 * (X[2:] @ X[2:])))

        best = scipy.optimize.minimize(
            lambda u: float(u @ u),
            np.array([10.0, 10.0, 0.0, 0.0]),
            constraints={"type": "ineq", "fun": room},
            bounds=[(-1.9, None)] * 2 + [(None, None)] * 2,
            options={"ftol": 1e-12, "maxiter": 500},
        )
        assert best.success
        # The semidefinite program keeps the smallest eigenvalues above 1e-5 of the robot's unit.
        np.testing.assert_allclose(near.X, self.IMPOSSIBLE + std * best.x, atol=2e-4)
        assert near.distance == pytest.approx(np.sqrt(best.fun), rel=5e-3)

    def test_a_possible_estimate_is_kept_and_an_impossible_one_is_moved(self) -> None:
        X = np.array([1.702, 0.05644, 0.15, 0.075])
        kept = nearest_possible(self.MODEL, X, self.COVARIANCE)
        assert (kept.distance, kept.at_bound, kept.fault) == (0.0, (), "")
        assert np.array_equal(kept.X, X)
        moved = nearest_possible(self.MODEL, self.IMPOSSIBLE, self.COVARIANCE)
        assert "cannot be positive definite" in moved.fault
        assert set(moved.at_bound) <= set(self.MODEL.base.names)
        assert moved.X[0] * moved.X[1] >= 0.25 * (moved.X[2:] @ moved.X[2:])
        again = nearest_possible(self.MODEL, moved.X, self.COVARIANCE)
        assert np.array_equal(again.X, moved.X)


def test_every_method_has_a_source_and_says_what_its_intervals_exclude() -> None:
    years = [str(year) for year in range(1800, 2030)]
    kinds: list[Callable[..., Estimator] | type] = [
        Ols, Wls, Huber, TotalLeastSquares, InstrumentalVariables, Prior,
    ]  # fmt: skip
    for kind in kinds:
        from importlib import import_module

        text = (kind.__doc__ or "") + (import_module(kind.__module__).__doc__ or "")
        assert any(year in text for year in years), kind
        assert "bias" in kind.excludes, kind
    assert set(METHODS) == {"ols", "wls", "huber", "tls", "iv"}


def test_a_prior_is_read_from_toml_and_from_an_estimate(tmp_path) -> None:
    model = symgen.derive(symgen.read_robot("planar2r"))
    (tmp_path / "p.toml").write_text("[parameters]\nZZ1 = 1.452\nM2 = 1.0\nZZ2 = 0.05\n")
    prior = read_prior(tmp_path / "p.toml", model)
    np.testing.assert_allclose(prior.mean, [1.702, 0.05, 0.0, 0.0])
    np.testing.assert_allclose(prior.std, [0.3 * 1.702, 0.3 * 0.1702, np.inf, np.inf])
    entries = [{"name": "ZZ1R", "value": 1.7, "std": 0.01}, {"name": "MX2", "value": 0.1}]
    (tmp_path / "e.json").write_text(
        json.dumps({"schema": "symgen.estimate/1", "parameters": entries})
    )
    prior = read_prior(tmp_path / "e.json", model)
    np.testing.assert_allclose(prior.mean, [1.7, 0.0, 0.1, 0.0])
    np.testing.assert_allclose(prior.std, [0.01, np.inf, 0.03, np.inf])
    (tmp_path / "none.toml").write_text("[parameters]\nXX1 = 1.0\n")
    with pytest.raises(symgen.ParameterError, match="gives no base parameter"):
        read_prior(tmp_path / "none.toml", model)
