"""Instrumental variables and what they say of least squares, beside plain NumPy and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
from oracles.precision import at_least_white, long_run, wider
from support import rows_of

import symgen
from symgen.estimation.estimators import Wls
from symgen.estimation.instrumental import (
    InstrumentalVariables,
    bias_of_least_squares,
    durbin_wu_hausman,
)
from symgen.estimation.system import Equations, Rows
from symgen.estimation.values import Endogeneity, OtherEstimate

NAMES = ("ZZ1", "MX2", "FV1")
TRUE = np.array([1.5, -0.4, 3.0])


def _log(seed: int, rows: int = 300, noise: float = 0.3, own: float = 0.1, correlation: int = 1):
    """A log whose W is measured with noise, and its instruments with another."""
    draw = np.random.default_rng(seed)
    clean = draw.normal(size=(rows, 3)) * np.array([1.0, 5.0, 0.3])
    y = clean @ TRUE + own * draw.normal(size=rows)
    size = np.array([1.0, 5.0, 0.3])
    W = clean + noise * size * draw.normal(size=clean.shape)
    Z = clean + 0.3 * size * draw.normal(size=clean.shape)
    return Equations(W, y, correlation, Z=Z)


def _system(*logs: Equations) -> Rows:
    return rows_of(NAMES, *logs)


def _two_stage(logs, weights) -> np.ndarray:
    """X = (Z'W)^-1 Z'y of weighted rows."""
    Z, W = (
        np.concatenate([w * getattr(e, k) for w, e in zip(weights, logs, strict=True)])
        for k in ("Z", "W")
    )
    y = np.concatenate([w * e.y for w, e in zip(weights, logs, strict=True)])
    return np.linalg.solve(Z.T @ W, Z.T @ y)


def test_logs_are_weighed_by_their_own_residual_in_three_passes() -> None:
    logs = [_log(1, own=0.05, noise=0.05), _log(2, 200, own=2.0), _log(3, 100, own=0.4)]
    found = InstrumentalVariables().solve(_system(*logs))
    weights = np.array(Wls().solve(_system(*logs)).weights)
    X = _two_stage(logs, weights)
    for _ in range(3):
        weights = np.array([1 / np.sqrt(np.mean((e.y - e.W @ X) ** 2)) for e in logs])
        X = _two_stage(logs, weights)
    np.testing.assert_allclose(found.X, X, rtol=1e-9)
    np.testing.assert_allclose(found.weights, weights, rtol=1e-9)
    # the sandwich, log by log over lags of eight rows
    Zs = [w * e.Z for w, e in zip(weights, logs, strict=True)]
    scores = [(w * (e.y - e.W @ X))[:, None] * Z for w, e, Z in zip(weights, logs, Zs, strict=True)]
    A = sum(Z.T @ (w * e.W) for Z, w, e in zip(Zs, weights, logs, strict=True))
    meat = sum(long_run(s, 8) for s in scores)
    inverse = np.linalg.inv(A)
    plain = wider((600, 8)) ** 2 * 600 / 597 * inverse @ meat @ inverse.T
    y = np.concatenate([w * e.y for w, e in zip(weights, logs, strict=True)])
    Z, W = np.concatenate(Zs), np.concatenate([w * e.W for w, e in zip(weights, logs, strict=True)])
    expected = at_least_white(plain, inverse, W, y, Z=Z)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-8)
    unit = Z / np.linalg.norm(Z, axis=0), W / np.linalg.norm(W, axis=0)
    assert found.condition_number == pytest.approx(np.linalg.cond(unit[0].T @ unit[1]), rel=1e-8)


def test_instruments_that_depend_or_see_nothing_do_not_determine() -> None:
    e = _log(7)
    assert e.Z is not None
    same = e.Z.copy()
    same[:, 1] = same[:, 0]
    blind = e.Z - e.W @ np.linalg.lstsq(e.W, e.Z, rcond=None)[0]
    for Z in (same, blind):
        with pytest.raises(symgen.IdentificationError, match="these instruments do not determine"):
            InstrumentalVariables().solve(_system(replace(e, Z=Z)))
    W = e.W.copy()
    W[:, 2] = W[:, 0]
    with pytest.raises(symgen.IdentificationError, match="do not determine ZZ1, FV1"):
        InstrumentalVariables().solve(_system(replace(e, W=W)))


@pytest.mark.parametrize(("share", "weak"), [(0.34, False), (0.26, True)])
def test_weak_instruments_are_told_with_their_correlation(share: float, weak: bool) -> None:
    """Orthogonal columns, one of whose instruments is `share` of it: that is its correlation."""
    Q = np.linalg.qr(np.random.default_rng(8).normal(size=(400, 6)))[0]
    Z = Q[:, :3].copy()
    Z[:, 1] = share * Q[:, 1] + np.sqrt(1 - share**2) * Q[:, 4]
    y = Q[:, :3] @ TRUE + 1e-3 * np.random.default_rng(9).normal(size=400)
    e = Equations(Q[:, :3] * np.array([1, 30, 1e-3]), y, Z=7 * Z)
    notes = InstrumentalVariables().solve(_system(e)).notes
    told = [note for note in notes if note.startswith("weak instruments")]
    assert len(told) == weak
    if weak:
        assert f"has a correlation of {share:.2g} with them" in told[0]


def test_tests_leave_out_what_the_instruments_explain() -> None:
    e = _log(10)
    assert e.Z is not None
    Z = e.Z.copy()
    Z[:, 2] = e.W[:, 2]  # the speed is exact
    test = durbin_wu_hausman(_system(replace(e, Z=Z)), np.ones(1))
    assert test is not None
    assert (test.columns, test.df) == ("all", (2, 300 - 3 - 2))
    Z = e.W.copy()
    Z[:, 2] = e.Z[:, 2]
    test = durbin_wu_hausman(_system(replace(e, Z=Z)), np.ones(1))
    assert test is not None
    assert test.df[0] == 1
    assert durbin_wu_hausman(_system(replace(e, Z=e.W.copy())), np.ones(1)) is None
    test = durbin_wu_hausman(_system(e), np.ones(1))
    assert test is not None
    assert test.df[0] == 3


def test_windows_that_overlap_count_once_and_too_few_are_not_tested() -> None:
    one, other = _log(11, 300, correlation=10), _log(12, 100, correlation=4)
    test = durbin_wu_hausman(_system(one, other), np.ones(2))
    assert test is not None
    assert test.df == (3, 300 / 10 + 100 / 4 - 6)
    assert test.p_value == pytest.approx(scipy.stats.f.sf(test.statistic, *test.df), rel=1e-9)
    # 7 and 6 windows for 6 columns: a test of some alone would say that no bias is seen
    for rows, tested in ((70, True), (60, False)):
        system = _system(_log(13, rows, correlation=10))
        assert bool(durbin_wu_hausman(system, np.ones(1))) is tested
        notes = InstrumentalVariables().solve(system).notes
        said = "no Durbin-Wu-Hausman test: the logs hold too few independent equations"
        assert (said in notes) is not tested


def test_logs_count_in_a_test_by_their_weights() -> None:
    """As one log whose rows were multiplied, where scores of no lag but their own are summed."""
    one, other = _log(14, 200, correlation=0), _log(15, 200, correlation=0)
    one, other = (replace(e, correlation=1) for e in (one, other))
    weighed = [replace(e, W=w * e.W, y=w * e.y, Z=w * e.Z) for e, w in ((one, 1.0), (other, 3.0))]
    found = durbin_wu_hausman(_system(one, other), np.array([1.0, 3.0]))
    expected = durbin_wu_hausman(_system(*weighed), np.ones(2))
    even = durbin_wu_hausman(_system(one, other), np.ones(2))
    assert found is not None
    assert expected is not None
    assert even is not None
    assert found.statistic == pytest.approx(expected.statistic, rel=1e-8)
    assert abs(even.statistic / found.statistic - 1) > 0.01


# What is said of least squares.


class TestBias:
    """What `bias_of_least_squares` makes of an answer of instrumental variables."""

    LEAST, STD = np.array([1.0, 2.0, -4.0]), np.array([0.1, 0.1, 0.1])

    def _said(self, monkeypatch, X, spread, p_value=1e-4, std=None, tests=True) -> str:
        solution = Wls().solve(_system(_log(16)))
        test = Endogeneity("all", 20.0, (3, 290.0), p_value)
        contrast = OtherEstimate.by("wls", NAMES, self.LEAST, self.STD if std is None else std)
        answer = replace(
            solution,
            X=np.array(X),
            noise=np.diag(np.square(spread)),
            misfit=np.zeros((len(spread),) * 2),
            notes=("a note",),
            endogeneity=(test,) if tests else (),
            comparison=(contrast,),
        )
        monkeypatch.setattr(InstrumentalVariables, "solve", lambda *_: answer)
        compared, said = bias_of_least_squares(_system(_log(16)), replace(solution, notes=("b",)))
        assert compared.notes == ("b", "a note")
        assert compared.endogeneity == answer.endogeneity
        (other,) = compared.comparison
        assert other.method == "iv"
        np.testing.assert_allclose(other.X, X)
        np.testing.assert_allclose(other.std, spread)
        np.testing.assert_array_equal(compared.X, solution.X)
        return said

    def test_it_is_said_with_the_parameter_that_moves_most_of_its_std(self, monkeypatch) -> None:
        said = self._said(monkeypatch, [1.0, 1.6, -4.5], [0.01, 0.01, 0.01])
        assert said == (
            "plain least squares is biased by noise in the speeds: FV1 by 5 std, 11.1 %; "
            "compare method iv"
        )

    @pytest.mark.parametrize(
        ("X", "spread", "p_value", "biased"),
        [
            ([1.0, 1.6, -4.0], [0.01] * 3, 1e-4, True),  # 4 std, 25 %
            ([1.0, 1.6, -4.0], [0.01] * 3, 0.01, False),  # the test does not see it
            ([1.0, 1.6, -4.0], [0.01] * 3, 0.0099, True),
            ([1.0, 1.71, -4.0], [0.01] * 3, 1e-4, False),  # 2.9 std
            ([1.0, 1.69, -4.0], [0.01] * 3, 1e-4, True),  # 3.1 std
            ([1.0, 1.6, -4.0], [0.01, 0.47, 0.01], 1e-4, True),  # known to 29 %
            ([1.0, 1.6, -4.0], [0.01, 0.49, 0.01], 1e-4, False),  # known to 31 %
            ([1.0, 2.0, -3.62], [0.01] * 3, 1e-4, True),  # 3.8 std, 10 %
        ],
    )
    def test_it_must_be_seen_large_known_and_material(
        self, monkeypatch, X, spread, p_value, biased
    ) -> None:
        assert bool(self._said(monkeypatch, X, spread, p_value)) is biased

    @pytest.mark.parametrize(("X", "biased"), [(2.09, False), (2.12, True)])
    def test_less_than_a_twentieth_of_a_parameter_is_no_bias(self, monkeypatch, X, biased) -> None:
        std = np.array([0.1, 0.01, 0.1])  # 9 std, but 4.3 % of it; 12 std and 5.7 %
        assert bool(self._said(monkeypatch, [1.0, X, -4.0], [0.01] * 3, std=std)) is biased

    def test_without_a_std_or_a_test_nothing_is_said(self, monkeypatch) -> None:
        assert self._said(monkeypatch, [1.0, 1.6, -4.0], [0.01] * 3, std=np.zeros(3)) == ""
        assert self._said(monkeypatch, [1.0, 1.6, -4.0], [0.01] * 3, tests=False) == ""

    def test_without_instruments_or_an_answer_the_solution_stays(self) -> None:
        e = _log(17)
        solution = Wls().solve(_system(e))
        system = _system(e, replace(_log(18), Z=None))
        assert bias_of_least_squares(system, solution) == (solution, "")
        assert e.Z is not None
        blind = replace(e, Z=np.zeros_like(e.Z))
        compared, said = bias_of_least_squares(_system(blind), solution)
        assert said == ""
        assert compared.notes == (
            *solution.notes,
            "no Durbin-Wu-Hausman test: the logs hold too few independent equations",
        )
        assert compared.comparison == solution.comparison

    def test_a_bias_that_is_there_is_found(self) -> None:
        biased, clean = _log(19, 2000, noise=0.5), _log(19, 2000, noise=0.0)
        for e, there in ((biased, True), (clean, False)):
            system = _system(e)
            said = bias_of_least_squares(system, Wls().solve(system))[1]
            assert said.startswith("plain least squares is biased by noise") is there
