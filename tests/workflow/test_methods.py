"""Methods, priors, forgetting and commanded motions of `identify`, from logs to estimate.json."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from oracles.arm import Arm, X, sines
from support import MOVED, sampled

import symgen
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import ESTIMATORS
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.system import Equations, Rows, join
from symgen.estimation.values import Reason
from symgen.identification.estimate import Consistency
from symgen.identification.instruments import instrumented
from symgen.identification.solving import ALL_METHODS, EquatedLog

STEP = 0.01


def _motion() -> tuple[np.ndarray, ...]:
    t = np.arange(0.0, 20.0, STEP)
    q, qd, qdd = sines(t, [1.0, 1.0], [1.1, 1.7], [0.2, 0.9])
    return t, q, qd, Arm(X).torque(q, qd, qdd)


def _log(seed: int | None = None, tachometer: float = 0.0, torque: float = 0.0) -> symgen.Log:
    """The paper's arm: encoder noise of 1e-5 rad, tachometer noise and torque noise."""
    t, q, qd, tau = _motion()
    if seed is not None:
        draw = np.random.default_rng(seed)
        q = q + 1e-5 * draw.normal(size=q.shape)
        qd = qd + tachometer * draw.normal(size=q.shape)
        tau = tau + torque * draw.normal(size=q.shape)
    return symgen.make_log(f"log {seed}", t, q, tau, qd)


@pytest.mark.parametrize(
    ("method", "model"),
    [(m, "momentum") for m in ALL_METHODS if m != "recursive"]
    + [("iv", "energy"), ("iv", "torque")],
)
def test_every_method_returns_the_parameters_of_nearly_clean_logs(method: str, model: str) -> None:
    log = _log(1, 1e-4, 1e-3)
    estimate = symgen.identify("planar2r", log, method=method, model=model)
    assert np.abs(estimate.X / X - 1).max() < 0.01
    content = estimate.to_json()
    assert content["method"] == ("wls" if method == "auto" else method)
    assert "bias" in content["std_excludes"]
    json.dumps(content, allow_nan=False)


#: Tachometers as they are, unfiltered.
MEASURED = Band(1 / STEP, 0.5 / STEP, 2.0, "measured")


def _with_instruments(evaluator: symgen.Evaluator, log: symgen.Log, model: str) -> Rows:
    """The equations of tachometers, with encoders as instruments."""
    equation_model = EquationModel(model, 0.1)
    motion = filter_log(symgen.prepare(log), MEASURED)
    part = EquatedLog("train", motion, equation_model.equations(evaluator, motion))
    return instrumented(evaluator, part, equation_model, None).equations


@pytest.fixture(scope="module")
def evaluator() -> symgen.Evaluator:
    return symgen.load(symgen.derive("planar2r", MOVED))


@pytest.mark.parametrize("model", ["energy", "momentum"])
def test_iv_with_encoders_as_instruments_takes_the_bias_of_the_tachometer_away(
    evaluator, model: str
) -> None:
    least, iv = [], []
    for seed in range(20):
        system = _with_instruments(evaluator, _log(seed, 0.05, 0.01), model)
        found = ESTIMATORS["iv"].solve(system)
        iv.append(found.X / X - 1)
        least.append(found.comparison[0].X / X - 1)
        assert found.comparison[0].method == "wls"
        assert found.endogeneity[0].columns == "all"
        assert found.endogeneity[0].p_value < 0.01
    bias, before = np.mean(iv, axis=0), np.mean(least, axis=0)
    print(f"{model}: relative bias of wls {before}, of iv {bias}")
    large = np.abs(before) > 0.1
    assert large.any()
    assert np.all(np.abs(bias[large]) < 0.2 * np.abs(before[large]))


@pytest.mark.parametrize(
    "model", sampled(["auto", "energy", "momentum", "torque"], 1, always=["auto"])
)
def test_speeds_are_derived_where_tachometers_are_worse_than_encoders(model: str) -> None:
    noisy = symgen.identify("planar2r", _log(1, 0.05, 0.01), model=model, window=0.1)
    assert noisy.band is not None
    assert noisy.band.velocity == "derived"
    assert np.abs(noisy.X / X - 1).max() < 0.02
    assert noisy.verdict == "trusted", noisy.reasons
    clean = symgen.identify("planar2r", _log(1, 1e-4, 0.01), model=model, window=0.1)
    assert clean.verdict == "trusted", clean.reasons
    assert not any(r.kind == "biased" for use in clean.uses for r in use.reasons)


def test_huber_bears_torque_spikes() -> None:
    t, q, qd, tau = _motion()
    tau = tau + 0.02 * np.random.default_rng(3).normal(size=tau.shape)
    tau[::97] += 15.0
    log = symgen.make_log("spikes", t, q, tau, qd)
    plain = symgen.identify("planar2r", log, model="torque", method="ols", cutoff=40.0)
    robust = symgen.identify("planar2r", log, model="torque", method="huber", cutoff=40.0)
    assert np.abs(robust.X / X - 1).max() < 0.5 * np.abs(plain.X / X - 1).max()


def test_forgetting_follows_a_load_that_is_put_down() -> None:
    t = np.arange(0.0, 40.0, STEP)
    q, qd, qdd = sines(t, [1.0, 1.0], [1.1, 1.7], [0.2, 0.9])
    after = np.array([1.702, 0.04, 0.10, 0.05])
    half = len(t) // 2
    tau = Arm(X).torque(q, qd, qdd)
    tau[half:] = Arm(after).torque(q, qd, qdd)[half:]
    log = symgen.make_log("load", t, q, tau, qd)
    options = {"model": "energy", "method": "recursive"}
    kept = symgen.identify("planar2r", log, **options)
    fading = symgen.identify("planar2r", log, fit=symgen.FitOptions(forgetting=0.99), **options)
    assert np.abs(fading.X / after - 1).max() < 0.01
    assert np.abs(kept.X / after - 1).max() > 0.1
    assert all(p.std < 0.01 * abs(p.value) for p in fading.parameters)
    with pytest.raises(symgen.IdentificationError, match="does not forget"):
        symgen.identify("planar2r", log, fit=symgen.FitOptions(forgetting=0.9))
    with pytest.raises(symgen.IdentificationError, match="above 0 and at most 1"):
        symgen.identify("planar2r", log, method="recursive", fit=symgen.FitOptions(forgetting=1.5))


def _at_every_sample(
    evaluator: symgen.Evaluator, log: FilteredLog, window: float
) -> tuple[np.ndarray, Equations]:
    """Energy equations whose windows end at every sample: of logs cut a sample shorter each."""
    steps, hop = round(window / STEP), max(1, round(window / STEP) // 10)
    found = []
    for first in range(hop):
        span = slice(first, None)
        cut = FilteredLog(log.samples.cut(span), log.band, log.q[span], log.qd[span])
        found.append(EquationModel("energy", window).equations(evaluator, cut))
    rows = join(found)
    order = np.argsort(rows.t)
    assert len(order) == len(log.t) - steps
    return rows.t[order], Equations(rows.W[order, 0], rows.y[order, 0])


def test_forgetting_is_least_squares_with_weights_that_fade() -> None:
    log = _log(3, 1e-4, 0.02)  # smooth speeds: quadratures of different order agree
    evaluator = symgen.load("planar2r")
    held, options = _log(), {"model": "energy", "method": "recursive", "cutoff": 20.0}
    found = symgen.identify(
        "planar2r", log, validation=held, fit=symgen.FitOptions(forgetting=0.998), **options
    )
    assert found.band is not None
    # a window that ends at every sample, as those of the recursion do
    motion = filter_log(symgen.prepare(log), found.band)
    t, equations = _at_every_sample(evaluator, motion, 0.2)
    age = (t[-1] - t) / STEP
    fading = np.sqrt(0.998) ** age
    expected = np.linalg.lstsq(fading[:, None] * equations.W, fading * equations.y, rcond=None)[0]
    kept = np.linalg.lstsq(equations.W, equations.y, rcond=None)[0]
    apart = np.abs(found.X - expected)
    assert np.all(apart < 0.1 * np.abs(kept - expected).max())
    assert np.all(apart < 0.25 * np.array([p.std for p in found.parameters]))


def test_the_command_line_takes_method_and_prior(tmp_path, command, monkeypatch) -> None:
    log = _log(7, 1e-4, 0.05)
    rows = np.column_stack([log.t, log.q, log.qd, log.tau])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", comments="",
               header="t,q1,q2,qd1,qd2,tau1,tau2")  # fmt: skip
    (tmp_path / "cad.toml").write_text(
        "[parameters]\nZZ1R = 1.7\nZZ2 = 0.056\nMX2 = 0.15\nMY2 = 0.3\n"
    )

    monkeypatch.chdir(tmp_path)
    asked = ("identify", "planar2r", "log.csv", "--model", "torque", "--into", "out")
    code, _, err = command(*asked, "--method", "consistent", "--prior", "cad.toml")
    assert code == 0, err
    content = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert content["method"] == "consistent with prior"
    assert content["possible"] is True
    code, _, err = command(*asked, "--method", "magic")
    assert code == 2
    assert "'auto', 'wls', 'ols', 'huber', 'tls', 'iv', 'consistent'" in err
    with pytest.raises(
        symgen.IdentificationError, match="takes no prior; accepted: auto, wls, cons"
    ):
        symgen.identify("planar2r", log, method="tls", fit=symgen.FitOptions(tmp_path / "cad.toml"))


def test_what_no_robot_can_have_is_not_exported_as_consistent() -> None:
    estimate = symgen.identify("planar2r", _log(7, 1e-4, 0.05), method="consistent")
    assert symgen.values_header(estimate)
    reason = Reason("effect_missing", text="ZZ2 is negative")
    spoiled = replace(estimate, physical=Consistency(9.0, reason))
    with pytest.raises(symgen.ParameterError, match=r"not exported.*ZZ2 is negative"):
        symgen.values_header(spoiled)


def test_a_prior_holds_what_a_poor_motion_does_not_show(tmp_path) -> None:
    # Joint 2 hardly moves: MX2 and MY2 are not told apart.
    t = np.arange(0.0, 10.0, STEP)
    q, qd, qdd = sines(t, [1.0, 0.02], [2.1, 3.3])
    tau = Arm(X).torque(q, qd, qdd)
    tau += np.random.default_rng(2).normal(size=tau.shape)
    log = symgen.make_log("poor", t, q, tau, qd)
    (tmp_path / "cad.toml").write_text(
        "[parameters]\nZZ1R = 1.8\nZZ2 = 0.055\nMX2 = 0.16\nMY2 = 0.08\n"
    )
    free = symgen.identify("planar2r", log, model="momentum")
    held = symgen.identify(
        "planar2r", log, model="momentum", fit=symgen.FitOptions(tmp_path / "cad.toml")
    )
    assert held.method == "wls with prior"
    assert np.abs(held.X / X - 1).max() < 0.3 < np.abs(free.X / X - 1).max()
    assert "errors of the prior" in held.excludes
    sure = symgen.Prior(mean := np.array([1.8, 0.055, 0.16, 0.08]), np.full(4, 1e-6))
    tied = symgen.identify("planar2r", log, model="momentum", method=sure)
    assert (tied.method, tied.excludes) == (held.method, held.excludes)
    assert np.abs(tied.X / mean - 1).max() < 1e-3


@dataclass(frozen=True)
class Halved:
    """An estimator of the user's: half of weighted least squares."""

    name: ClassVar[str] = "halved"
    excludes: ClassVar[str] = "the other half"
    prior: float = 0.5  # no prior of symgen's

    def solve(self, rows: Rows):
        found = symgen.Wls().solve(rows)
        return replace(found, X=self.prior * found.X)


@dataclass(frozen=True)
class Recursive(Halved):
    """One that has the name of a method of symgen's."""

    name: ClassVar[str] = "recursive"


@pytest.mark.parametrize("own", [Halved(), Recursive()])
def test_an_estimator_of_the_user_keeps_its_name_and_what_it_excludes(own, tmp_path) -> None:
    log = _log(1, 1e-4, 1e-3)
    estimate = symgen.identify("planar2r", log, method=own, model="momentum")
    np.testing.assert_allclose(estimate.X, X / 2, rtol=0.01)
    symgen.write(estimate, tmp_path)
    content = json.loads((tmp_path / "estimate.json").read_text())
    assert (content["method"], content["std_excludes"]) == (own.name, own.excludes)
