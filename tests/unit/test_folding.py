"""Rows evaluated and folded at once: what NumPy makes of the whole regressor, stored."""

from __future__ import annotations

import shutil
from functools import cache

import numpy as np
import pytest

import symgen
from symgen.runtime.build import forget_compilers
from symgen.runtime.folding import Fold, Folded

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) here")
BACKENDS = [pytest.param("c", marks=needs_cc), "casadi"]
KERNELS = ("torque_regressor", "power_regressor", "energy_regressor")
ROBOT = "rx90"


@pytest.fixture(scope="module", autouse=True)
def compiled(tmp_path_factory):
    """Compile into a folder of this run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMGEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        patch.setenv("SYMGEN_FLAGS", "native")
        patch.delenv("SYMGEN_CC", raising=False)
        forget_compilers()
        yield
        loaded.cache_clear()
        fold_of.cache_clear()
        forget_compilers()


@cache
def loaded(backend: str) -> symgen.Evaluator:
    """The arm's regressors."""
    model = symgen.derive(symgen.read_robot(ROBOT), KERNELS)
    return symgen.load(model, backend=backend)


@cache
def fold_of(backend: str, kernel: str, method: str) -> Fold:
    """A fold, compiled once."""
    return Fold(loaded(backend), kernel, method)


def samples(kernel: str, count: int) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    """Inputs, right-hand side, and the rows [W, y] as NumPy holds them."""
    draw = np.random.default_rng(count)
    evaluator = loaded("casadi")
    inputs = [draw.uniform(-2, 2, (count, len(s))) for _, s in evaluator[kernel].kernel.tape.inputs]
    W = np.asarray(evaluator[kernel](*inputs))
    y = draw.normal(size=W.shape[:-1])
    return inputs, y, np.concatenate([W, y[..., None]], axis=-1)


def products(rows: np.ndarray) -> np.ndarray:
    flat = rows.reshape(-1, rows.shape[-1])
    return flat.T @ flat


def agree(folded: Folded, rows: np.ndarray) -> None:
    """Each entry of A'A to 1e-13 of its columns' norms; R'R the same."""
    expected = products(rows)
    norm = np.sqrt(np.diag(expected))
    bound = 1e-13 * np.outer(norm, norm) + 1e-300
    assert (np.abs(folded.products - expected) <= bound).all()
    assert folded.rows == rows[..., 0].size
    if folded.triangle is not None:
        np.testing.assert_array_equal(folded.triangle, np.triu(folded.triangle))
        assert (np.diag(folded.triangle) >= 0).all()
        assert (np.abs(folded.triangle.T @ folded.triangle - expected) <= 10 * bound).all()


@pytest.mark.parametrize("method", ["normal", "orthogonal"])
@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("backend", BACKENDS)
def test_the_fold_is_that_of_the_stored_rows(backend, kernel, method):
    fold = fold_of(backend, kernel, method)
    for count in (1, 7, 33, 700):
        inputs, y, rows = samples(kernel, count)
        agree(fold(inputs, y), rows)


@pytest.mark.parametrize("method", ["normal", "orthogonal"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_weights_scale_rows(backend, method):
    fold = fold_of(backend, "torque_regressor", method)
    inputs, y, rows = samples("torque_regressor", 83)
    draw = np.random.default_rng(0)
    each = draw.uniform(0.1, 3.0, y.shape)
    each[draw.random(y.shape) < 0.2] = 0.0
    agree(fold(inputs, y, 2.5), 2.5 * rows)
    agree(fold(inputs, y, each[0]), each[0][:, None] * rows)
    agree(fold(inputs, y, each), each[..., None] * rows)


@needs_cc
@pytest.mark.parametrize("flags", ["plain", "avx2"])
@pytest.mark.parametrize("method", ["normal", "orthogonal"])
def test_every_width_of_registers_gives_the_same(method, flags, monkeypatch):
    monkeypatch.setenv("SYMGEN_FLAGS", flags)
    fold = Fold(loaded("c"), "energy_regressor", method)
    inputs, y, rows = samples("energy_regressor", 101)
    agree(fold(inputs, y), rows)


@pytest.mark.parametrize("method", ["normal", "orthogonal"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_parts_of_a_log_merge_in_any_order(backend, method):
    fold = fold_of(backend, "torque_regressor", method)
    inputs, y, rows = samples("torque_regressor", 90)
    cuts = [slice(0, 1), slice(1, 40), slice(40, 90)]
    first, second, third = (fold([a[c] for a in inputs], y[c]) for c in cuts)
    agree(first.merge(second).merge(third), rows)
    agree(third.merge(first.merge(second)), rows)


@pytest.mark.parametrize("method", ["normal", "orthogonal"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_solve_is_least_squares(backend, method):
    inputs, y, rows = samples("torque_regressor", 300)
    X, rss = fold_of(backend, "torque_regressor", method)(inputs, y).solve()
    flat = rows.reshape(-1, rows.shape[-1])
    expected, residual, *_ = np.linalg.lstsq(flat[:, :-1], flat[:, -1], rcond=None)
    np.testing.assert_allclose(X, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    assert rss == pytest.approx(residual[0], rel=1e-9)


@pytest.mark.parametrize("method", ["normal", "orthogonal"])
def test_data_without_noise_leave_no_residual(method):
    inputs, _, rows = samples("torque_regressor", 300)
    true = np.linspace(0.5, 1.5, rows.shape[-1] - 1)
    y = rows[..., :-1] @ true
    X, rss = fold_of("casadi", "torque_regressor", method)(inputs, y).solve()
    np.testing.assert_allclose(X, true, rtol=1e-9)
    assert 0 <= rss <= 1e-12 * (y**2).sum()


@needs_cc
def test_reflections_keep_what_sums_of_products_lose():
    """A motion so small that the square of the condition number passes what a double holds."""
    draw = np.random.default_rng(1)
    evaluator = loaded("c")
    inputs = [scale * draw.uniform(-1, 1, (3000, 6)) for scale in (2e-4, 1e-2, 0.3)]
    W = np.asarray(evaluator["torque_regressor"](*inputs)).reshape(18000, -1)
    scale = np.linalg.norm(W, axis=0)
    assert np.linalg.cond(W / scale) > 1e8
    true = draw.uniform(0.5, 1.5, W.shape[1])
    y = (W @ true).reshape(3000, 6)
    X, _ = fold_of("c", "torque_regressor", "orthogonal")(inputs, y).solve()
    expected = np.linalg.lstsq(W / scale, y.ravel(), rcond=None)[0] / scale
    lost = np.abs((expected - true) * scale).max()
    assert np.abs((X - true) * scale).max() <= 100 * lost
    with pytest.raises(symgen.ParameterError, match="method='orthogonal'"):
        fold_of("c", "torque_regressor", "normal")(inputs, y).solve()


def test_no_rows_worth_the_name_are_said():
    inputs, y, _ = samples("torque_regressor", 2)
    for method in ("normal", "orthogonal"):
        folded = fold_of("casadi", "torque_regressor", method)(inputs, 0 * y, 0.0)
        with pytest.raises(symgen.ParameterError, match="the rows do not determine X"):
            folded.solve()


def test_wrong_names_and_shapes_are_one_line():
    evaluator = loaded("casadi")
    with pytest.raises(symgen.ParameterError, match="method 'qr'; accepted: normal, orthogonal"):
        Fold(evaluator, "torque_regressor", "qr")
    fold = fold_of("casadi", "torque_regressor", "normal")
    inputs, y, _ = samples("torque_regressor", 5)
    with pytest.raises(symgen.ParameterError, match=r"y has shape \(5,\); accepted: \(5, 6\)"):
        fold(inputs, y[:, 0])
    with pytest.raises(symgen.ParameterError, match=r"weights have shape \(5,\); accepted"):
        fold(inputs, y, np.ones(5))
    with pytest.raises(symgen.ParameterError, match="a fold takes a batch"):
        fold([a[0] for a in inputs], y[0])
    model = symgen.derive(symgen.read_robot("planar2r"), ("inverse_dynamics",))
    with pytest.raises(symgen.ParameterError, match="inverse_dynamics has no columns"):
        Fold(symgen.load(model, backend="casadi"), "inverse_dynamics")
