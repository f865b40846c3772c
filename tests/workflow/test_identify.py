"""Identification from end to end: noise-free data, real logs, verdicts, refusals in words."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from oracles.arm import Arm, X, sines
from support import data_folder, sampled

import symgen
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered_log import unfiltered
from symgen.report.store import result_files


def _motion(step: float, seconds: float, friction: float = 0.0) -> symgen.Log:
    """A smooth motion of the paper's arm with its exact torques, from its closed form."""
    t = np.arange(0.0, seconds, step)
    q, qd, qdd = sines(t, [1.0, 1.0], [1.1, 1.7], [0.2, 0.9])
    return symgen.make_log("exact", t, q, Arm(X, FV=friction).torque(q, qd, qdd), qd)


@pytest.mark.parametrize(
    ("model", "step", "window"),
    sampled([(m, s, w) for m in ("auto", "energy", "momentum", "torque")
             for s in (0.001, 0.02, 0.0622) for w in (0.2, 1.0)], 4,
            always=[("momentum", 0.001, 0.2), ("torque", 0.001, 0.2)]),
)  # fmt: skip
def test_noise_free_data_return_the_parameters(model: str, step: float, window: float) -> None:
    estimate = symgen.identify(
        "planar2r", _motion(step, 20.0), model=model, window=max(window, 2 * step)
    )
    assert np.abs(estimate.X / X - 1).max() < 1e-4
    assert estimate.verdict == "trusted", estimate.reasons
    assert all(use.ok for use in estimate.uses), estimate.uses
    assert not estimate.repairs


@pytest.mark.rounding
def test_by_default_all_models_are_fitted_and_the_best_on_folds_is_taken() -> None:
    estimate = symgen.identify("planar2r", _shaken(_motion(0.005, 12.0), 0.02))
    assert {a.model for a in estimate.alternatives} == {"energy", "momentum", "torque"}
    (chosen,) = [a for a in estimate.alternatives if a.chosen]
    assert estimate.model == chosen.model
    assert chosen.held_out <= 1.03 * max(1e-6, min(a.held_out for a in estimate.alternatives))
    for a in estimate.alternatives:
        assert a.reason.startswith(f"{100 * a.held_out:#.3g} % torque error on folds left out")
    assert chosen.validation == estimate.torque_validation


def _shaken(log: symgen.Log, part: float, seed: int = 1) -> symgen.Log:
    """The log with noise of its torques, relative to each value."""
    noise = part * np.random.default_rng(seed).normal(size=log.tau.shape)
    return replace(log, tau=log.tau * (1 + noise))


@pytest.mark.rounding
def test_rounding_chooses_no_model() -> None:
    exact = _motion(0.005, 12.0)
    for seed in range(4):
        estimate = symgen.identify("planar2r", _shaken(exact, 1e-12, seed))
        assert max(a.held_out for a in estimate.alternatives) < 1e-6
        assert estimate.model == "momentum"


@pytest.mark.parametrize("model", ["energy", "momentum"])
def test_the_recursive_method_is_the_batch_where_nothing_is_forgotten(model: str) -> None:
    exact = _motion(0.002, 8.0)
    noise = 0.05 * np.random.default_rng(1).normal(size=exact.tau.shape)
    log = symgen.make_log("noisy", exact.t, exact.q, exact.tau + noise, exact.qd)
    batch = symgen.identify("planar2r", log, model=model, method="ols")
    recursive = symgen.identify("planar2r", log, model=model, method="recursive")
    np.testing.assert_allclose(recursive.X, batch.X, rtol=1e-10)
    stds = ([p.std for p in found.parameters] for found in (recursive, batch))
    np.testing.assert_allclose(*stds, rtol=1e-8)


def test_an_identifier_takes_a_log_at_once() -> None:
    log, identifier = _motion(0.005, 6.0), symgen.Identifier(symgen.load("planar2r"), window=40)
    identifier.run(log.t, log.q, log.qd, log.tau)
    assert np.abs(identifier.read()[0] / X - 1).max() < 1e-4


def test_what_an_identifier_cannot_do_is_said() -> None:
    evaluator = symgen.load("planar2r")
    with pytest.raises(symgen.IdentificationError, match="accepted: energy, momentum"):
        symgen.Identifier(evaluator, model="torque")
    with pytest.raises(symgen.IdentificationError, match="needs the kernel momentum_regressor"):
        symgen.Identifier(evaluator, model="momentum")
    for settings in ({"window": 0}, {"window": -1}, {"forgetting": 0.0}, {"forgetting": 1.1}):
        with pytest.raises(symgen.IdentificationError, match="at least 1 sample"):
            symgen.Identifier(evaluator, **settings)
    with pytest.raises(symgen.BuildError, match=r"pip install 'symgen\[cc\]'"):
        symgen.Identifier(symgen.load("planar2r", backend="casadi"))
    with pytest.raises(symgen.IdentificationError, match="energy and momentum"):
        symgen.identify("planar2r", _motion(0.01, 8.0), model="torque", method="recursive")


def test_standard_deviations_cover_the_truth() -> None:
    # Torque noise alone leaves the regressor exact: least squares is unbiased, std must be honest.
    clean = _motion(0.01, 48.0)
    draw = np.random.default_rng(7)
    evaluator = symgen.load("planar2r")
    inside = []
    for _ in range(200):
        tau = clean.tau + 0.2 * draw.normal(size=clean.tau.shape)
        log = symgen.make_log("noisy", clean.t, clean.q, tau, clean.qd)
        prepared = unfiltered(symgen.prepare(log))
        equations = EquationModel("energy", 0.2).equations(evaluator, prepared)
        solution = Wls().solve(equations)
        std = np.sqrt(np.diag(solution.covariance))
        inside.append(np.abs(solution.X - X) < 1.96 * std)
    print("coverage of the 95 % interval:", np.mean(inside))
    assert 0.90 < np.mean(inside) < 0.99


class TestRealLogs:
    def test_emps(self) -> None:
        folder = data_folder() / "emps"
        estimate = symgen.identify(
            folder / "robot.toml",
            folder / "train.csv",
            validation=folder / "test.csv",
            model="energy",
        )
        value = {p.name: p.value for p in estimate.parameters}
        print(f"emps: {value}, residual {estimate.train} -> {estimate.validation}")
        assert abs(value["M1"] / 95.1089 - 1) < 0.02
        assert abs(value["FS1"] / 20.3935 - 1) < 0.05
        assert abs(value["FV1"] / 203.5034 - 1) < 0.05
        assert estimate.train.relative < 0.027
        assert estimate.validation.relative < 0.040
        assert estimate.verdict == "trusted", estimate.reasons
        assert estimate.band is not None
        assert estimate.cutoff_hz == estimate.band.cutoff_hz
        assert f"band: {estimate.band.in_words()}" in estimate.notes

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("model", "train", "held"),
        [("energy", 0.027, 0.049), ("momentum", 0.042, 0.045), ("torque", 0.042, 0.045)],
    )
    def test_ur10e(self, model: str, train: float, held: float) -> None:
        folder = data_folder() / "ur10e"
        estimate = symgen.identify(
            folder / "robot.toml",
            [folder / f"{name}.csv" for name in ("train", "train2", "train3")],
            validation=[folder / f"{name}.csv" for name in ("test", "ptp")],
            model=model,
        )
        print(f"ur10e, {model}: residual {estimate.train} -> {estimate.validation}")
        assert estimate.train.relative < train
        assert estimate.validation.relative < held
        assert "resampled" in " ".join(estimate.notes)

    @pytest.mark.slow
    def test_tx40_is_doubtful_with_reasons(self) -> None:
        folder = data_folder() / "tx40"
        estimate = symgen.identify(
            folder / "robot.toml", folder / "train.csv", validation=folder / "test.csv"
        )
        print(f"tx40: residual {estimate.train} -> {estimate.validation}, {estimate.reasons}")
        assert estimate.verdict == "doubtful"
        prediction = estimate.uses.prediction
        assert prediction.reasons == estimate.reasons
        assert [reason.kind for reason in prediction.reasons] == ["error"]
        assert prediction.grade == "poor"
        # its wrist is coupled, which this robot file does not say
        assert [reason.joints for reason in prediction.large] == [(5,), (6,)]
        (reason,) = estimate.uses.simulation.reasons
        assert (reason.kind, reason.limit) == ("position_error", 0.3)


class TestOtherModels:
    @pytest.mark.parametrize("model", sampled(["auto", "momentum", "torque"], 0, always=["auto"]))
    def test_emps_is_within_three_percent_of_the_published_values(self, model: str) -> None:
        folder = data_folder() / "emps"
        estimate = symgen.identify(
            folder / "robot.toml", folder / "train.csv", validation=folder / "test.csv", model=model
        )
        value = {p.name: p.value for p in estimate.parameters}
        print(f"emps, {model}: {value}, residual {estimate.train} -> {estimate.validation}")
        published = {"M1": 95.1089, "FS1": 20.3935, "FV1": 203.5034, "OF1": -3.1648}
        for name, expected in published.items():
            assert abs(value[name] / expected - 1) < 0.03, name

    @pytest.mark.slow
    def test_tx40_with_its_wrist_coupling(self) -> None:
        folder = data_folder() / "tx40"
        text = (folder / "robot.toml").read_text() + "\n[[coupling]]\njoints = [5, 6]\n"
        robot = symgen.parse_robot(text)
        test = symgen.read_log(folder / "test.csv")
        moving = test.t < 7.4  # at rest sign(qd) is noise
        held = symgen.make_log(
            "test before 7.4 s", test.t[moving], test.q[moving], test.tau[moving]
        )
        results = {
            name: symgen.identify(
                r, folder / "train.csv", validation=held, model="torque", cutoff=10
            )
            for name, r in (("without", folder / "robot.toml"), ("with", robot))
        }
        for name, estimate in results.items():
            print(f"tx40 {name} coupling: {estimate.train} -> {estimate.validation}")
        joints = {name: e.validation.per_joint for name, e in results.items()}
        assert joints["with"][4] < 0.35 < 1.5 < joints["without"][4]
        assert joints["with"][5] < 0.30 < 0.5 < joints["without"][5]
        assert {"IAM6", "FVM6", "FSM6"} <= {p.name for p in results["with"].parameters}


class TestRefusals:
    def test_proportional_joint_speeds(self) -> None:
        log = _motion(0.01, 8.0)
        same = np.column_stack([log.q[:, 0], 0.5 * log.q[:, 0]])
        speed = np.column_stack([log.qd[:, 0], 0.5 * log.qd[:, 0]])
        bad = symgen.make_log("proportional", log.t, same, log.tau, speed)
        found = symgen.identify("planar2r", bad, model="energy")
        # its torques are those of the other motion
        assert (2,) in [reason.joints for reason in found.uses.prediction.large]
        assert {"ZZ1R", "ZZ2"} == {p.name for p in found.parameters if math.isnan(p.std)}

    def test_a_joint_at_rest(self) -> None:
        log = _motion(0.01, 8.0)
        still = np.column_stack([log.q[:, 0], np.zeros(len(log.t))])
        speed = np.column_stack([log.qd[:, 0], np.zeros(len(log.t))])
        bad = symgen.make_log("still", log.t, still, log.tau, speed)
        with pytest.raises(symgen.IdentificationError, match="did not move"):
            symgen.identify("planar2r", bad)

    def test_a_log_of_another_robot(self) -> None:
        with pytest.raises(symgen.LogError, match="2 joints"):
            symgen.identify("panda", _motion(0.01, 8.0))

    @pytest.mark.parametrize("window", [0.0, -1.0, float("nan"), float("inf"), 100.0, 1e-9])
    @pytest.mark.parametrize("model", ["energy", "momentum"])
    def test_a_window_that_does_not_fit(self, model: str, window: float) -> None:
        with pytest.raises(symgen.SymgenError, match="window"):
            symgen.identify("planar2r", _motion(0.01, 8.0), model=model, window=window)

    @pytest.mark.parametrize("window", [0.0, -1.0, float("nan"), float("inf")])
    def test_a_window_that_fits_no_log(self, window: float) -> None:
        with pytest.raises(symgen.IdentificationError, match="accepted: a length above 0"):
            symgen.identify("planar2r", _motion(0.01, 8.0), window=window)

    @pytest.mark.parametrize("window", [100.0, 1e-9])
    def test_a_window_that_does_not_fit_leaves_the_torque_model(self, window: float) -> None:
        estimate = symgen.identify("planar2r", _motion(0.01, 8.0), window=window)
        assert estimate.model == "torque"
        lost = {a.model: a.reason for a in estimate.alternatives if not a.chosen}
        assert set(lost) == {"energy", "momentum"}
        assert all(f"a window of {window:g} s" in reason for reason in lost.values()), lost

    @pytest.mark.parametrize("option", [{"model": "torques"}, {"method": "magic"}])
    def test_unknown_options(self, option: dict[str, str]) -> None:
        with pytest.raises(symgen.IdentificationError, match="accepted"):
            symgen.identify("planar2r", _motion(0.01, 8.0), **option)


class TestPrediction:
    PARAMETERS = "[parameters]\nZZ1 = 1.452\nM2 = 1.0\nZZ2 = 0.05644\nMX2 = 0.15\nMY2 = 0.075\n"

    def test_exact_parameters_predict_an_exact_log(self, tmp_path) -> None:
        # ZZ1R = ZZ1 + L1**2*M2 = 1.702: standard parameters are regrouped.
        (tmp_path / "p.toml").write_text(self.PARAMETERS)
        prediction = symgen.predict("planar2r", _motion(0.002, 8.0), tmp_path / "p.toml")
        assert prediction.error.relative < 1e-3
        energy = prediction.kinetic + prediction.potential
        log = _motion(0.002, 8.0)
        work = np.sum(log.qd * log.tau, axis=1)
        gained = np.concatenate([[0], np.cumsum((work[1:] + work[:-1]) / 2) * 0.002])
        np.testing.assert_allclose(energy - energy[0], gained, atol=1e-4)

    def test_an_estimate_is_read_back(self, tmp_path) -> None:
        estimate = symgen.identify("planar2r", _motion(0.01, 12.0))
        (tmp_path / "estimate.json").write_text(json.dumps(estimate.to_json()))
        prediction = symgen.predict("planar2r", _motion(0.01, 8.0), tmp_path / "estimate.json")
        assert prediction.error.relative < 1e-2
        assert set(result_files(prediction)) == {
            "prediction.json", "prediction.csv", "report.html"
        }  # fmt: skip

    @pytest.mark.parametrize(
        ("content", "words"),
        [
            ("", r"\[parameters\] is missing"),
            ("[parameters]\nZZ1R = 1\n", "missing: ZZ2, MX2, MY2"),
            ("[parameters]\nQQ7 = 1\n", "no parameter of planar2r"),
            ("[parameters]\nZZ1R = nan\n", "finite number"),
            ("[parameters]\nZZ1R = true\n", "finite number"),
            ("= 3", "cannot be read"),
        ],
    )
    def test_bad_parameters_are_refused_in_words(self, tmp_path, content, words) -> None:
        (tmp_path / "p.toml").write_text(content)
        with pytest.raises(symgen.ParameterError, match=words):
            symgen.predict("planar2r", _motion(0.01, 8.0), tmp_path / "p.toml")


def test_command_writes_the_estimate_and_a_page(tmp_path) -> None:
    log = _motion(0.01, 8.0)
    rows = np.column_stack([log.t, log.q, log.qd, log.tau])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="t,q1,q2,qd1,qd2,tau1,tau2",
               comments="")  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "symgen", "identify", "planar2r", "log.csv", "--into", "out"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "verdict: trusted" in done.stdout
    estimate = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert estimate["schema"] == "symgen.estimate/2"
    assert [p["name"] for p in estimate["parameters"]] == ["ZZ1R", "ZZ2", "MX2", "MY2"]
    assert {m["model"] for m in estimate["models"]} == {"energy", "momentum", "torque"}
    assert [m["chosen"] for m in estimate["models"]].count(True) == 1
    assert set(estimate["band"]) == {"rate_hz", "cutoff_hz", "comparison_hz", "velocity"}
    assert estimate["repairs"] == []
    assert set(estimate["uses"]) == {"prediction", "parameters", "simulation"}
    assert set(estimate["residual"]) == {"train", "validation"}
    assert set(estimate["torque_residual"]["validation"]) == {"relative", "per_joint"}
    assert estimate["torque_residual"]["validation"]["relative"] < 1e-3
    assert set(estimate["physical"]) == {"distance_sigma", "reason", "held_out"}
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000
    assert "planar2r_values" in (tmp_path / "out" / "planar2r_values.h").read_text()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.csv", "out"]
