"""`--refine simulation` beside SciPy: an ODE solver and least_squares over windows of a log."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from support import sampled
from workflow import output_error_study
from workflow.output_error_study import GAINS, KD, KP, followed

import symgen

FIGURES = json.loads(Path(__file__).with_name("output_error_figures.json").read_text("utf-8"))

L1, TRUE = 0.5, np.array([3.7, 0.8, 1.2, 0.3, 2.0, 0.5])
ROBOT = planar2r.robot_toml("arm", 'friction = ["viscous"]\nrotor_inertia = false')
NAMES = (*planar2r.NAMES, "FV1", "FV2")
NOISE, ROWS = 4e-3, 200  # rad, and samples of a second


def log(seed: int, seconds: float, noise: float = NOISE, X: np.ndarray = TRUE) -> symgen.Log:
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = (x[: int(200 * seconds) + 2] for x in planar2r.harmonic_motion(rng, seed))
    rows = zip(q, qd, qdd, strict=True)
    tau = np.array([planar2r.inverse_dynamics(*r, X[:4], L1) for r in rows]) + X[4:] * qd
    return symgen.make_log(f"log {seed}", t, q + noise * rng.normal(size=q.shape), tau)


def fit(log: symgen.Log, X: np.ndarray, windows: int) -> np.ndarray:
    """Parameters and start states of all windows at once, with differences for derivatives."""
    torque, at = CubicSpline(log.t, log.tau), range(0, windows * ROWS, ROWS)
    begins = log.t[list(at)]
    starts = np.array([[*log.q[k], *(log.q[k + 20] - log.q[k]) / 0.1]
                       for k in range(0, windows * ROWS, ROWS)])  # fmt: skip

    def residuals(z: np.ndarray) -> np.ndarray:
        X = z[:6]

        def slope(at: float, x: np.ndarray) -> np.ndarray:
            q, qd = np.split(x.reshape(windows, 4), 2, axis=1)
            still = np.zeros_like(q)
            bias = planar2r.inverse_dynamics(q, qd, still, X[:4], L1) + X[4:] * qd
            units = (np.broadcast_to(e, q.shape) for e in np.eye(2))
            M = np.stack([planar2r.inverse_dynamics(q, still, e, X[:4], L1) for e in units], -1)
            force = torque(at + begins) - bias
            return np.concatenate([qd, np.linalg.solve(M, force[:, :, None])[:, :, 0]], 1).ravel()

        t = log.t[: ROWS + 1]
        moved = solve_ivp(slope, (0, 1), z[6:], t_eval=t - t[0], rtol=1e-7, atol=1e-8).y
        q = moved.reshape(windows, 4, -1)[:, :2].transpose(0, 2, 1)
        return np.ravel([log.q[k : k + ROWS + 1] - x for k, x in zip(at, q, strict=True)])

    sparse = np.zeros((windows * (ROWS + 1) * 2, 6 + 4 * windows))
    sparse[:, :6] = 1
    for w in range(windows):
        sparse[w * (ROWS + 1) * 2 : (w + 1) * (ROWS + 1) * 2, 6 + 4 * w : 10 + 4 * w] = 1
    z = np.concatenate([X, starts.ravel()])
    return least_squares(residuals, z, jac_sparsity=sparse, x_scale="jac", ftol=1e-6).x[:6]


def ordered(found: symgen.Estimate) -> tuple[np.ndarray, np.ndarray]:
    values = {p.name: (p.value, p.std) for p in found.parameters}
    X, std = np.array([values[n] for n in NAMES]).T
    return X, std


def test_the_parameters_are_those_of_scipy() -> None:
    robot, train, held = symgen.parse_robot(ROBOT, "arm"), log(5, 10), log(4, 5, 0.0)
    found = symgen.identify(robot, train, validation=held, refine="simulation")
    assert found.method == "wls, refined by simulation", found.notes
    X, std = ordered(found)
    expected = fit(train, X * [1.05, 0.95, 1.05, 0.95, 0.9, 1.1], 10)
    assert np.all(np.abs(X - expected) < 0.3 * std), (X, expected, std)


def test_a_refinement_that_is_farther_on_held_out_motion_is_not_kept() -> None:
    """The held-out log is that of a robot with the values of least squares."""
    robot, train = symgen.parse_robot(ROBOT, "arm"), log(5, 10)
    X, _ = ordered(symgen.identify(robot, train, validation=log(4, 5, 0.0)))
    held = log(4, 5, 0.0, X)
    found = symgen.identify(robot, train, validation=held, refine="simulation")
    assert found.method == "wls"
    assert any("on held-out motion, the position error" in note for note in found.notes)


def test_the_study_reaches_what_the_page_says() -> None:
    """Position errors are after 0.2, 0.5 and 1 s; pairs are of least squares and refined."""
    found = FIGURES["summary"]["upright"]
    assert found["runs"] >= 20
    assert np.median(found["error_left"]) < 0.2
    assert max(found["error_left"]) < 0.35
    assert found["held"][1] > 0.95
    assert max(found["ratio_median"]) < 0.8
    assert max(found["ratio_largest"]) <= 1.02
    other = FIGURES["summary"]["elbow"]
    assert other["runs"] >= 20
    assert other["held"][1] > 0.95
    constants = FIGURES["summary"]["stribeck"]
    assert constants["runs"] >= 20
    assert np.mean(constants["constants_held"]) > 0.9
    assert np.mean(constants["delays_held"]) > 0.9
    assert max(constants["ratio_median"]) < 0.8


@pytest.mark.xfail(strict=True, reason="missed: 10 of 20 elbow arms are not refined, one is worse")
def test_the_study_reaches_its_goals_for_an_elbow_arm() -> None:
    found = FIGURES["summary"]["elbow"]
    assert max(found["ratio_median"]) < 0.8
    assert max(found["ratio_largest"]) <= 1.02


@pytest.mark.xfail(strict=True, reason="missed: 92 % of the intervals beside a constant hold")
def test_the_study_reaches_its_goals_for_constants() -> None:
    found = FIGURES["summary"]["stribeck"]
    assert found["held"][1] > 0.95
    assert max(found["ratio_largest"]) <= 1.02


@pytest.mark.slow
@pytest.mark.parametrize("row", sampled(range(len(FIGURES["rows"])), 1))
def test_a_run_of_the_study_comes_out_again(row: int) -> None:
    """Takes 20 s."""
    kept = FIGURES["rows"][row]
    again = output_error_study.run(kept["arm"], kept["seed"])
    assert again["refined"] == kept["refined"]
    std = np.array(kept["stds"])
    assert np.all(np.abs(np.array(again["errors"]) - kept["errors"]) < 0.3 * std)
    assert np.allclose(again["position"], kept["position"], rtol=0.05)


#: A friction that the motion shows, and a spring whose constant b has no say within the motion.
WITH_CONSTANTS = (
    ROBOT
    + """
[[effect]]
name = "soft"
joints = [1]
torque = "-F*tanh(qd1/w)"
linear = { F = "N m" }
nonlinear = { w = 0.35 }
[[effect]]
name = "far"
joints = [2]
torque = "-G*q2*tanh((q2 + 20)/b)"
linear = { G = "N m/rad" }
nonlinear = { b = 2 }
"""
)


def with_effects(seed: int, seconds: float, noise: float = NOISE) -> symgen.Log:
    _, q, qd, _ = planar2r.harmonic_motion(np.random.default_rng(seed), seed)
    more, plain = np.stack([3 * np.tanh(qd[:, 0] / 0.25), q[:, 1]], 1), log(seed, seconds, noise)
    return symgen.make_log(plain.name, plain.t, plain.q, plain.tau + more[: len(plain.t)])


def test_constants_of_effects_are_fitted_if_the_log_determines_them(tmp_path) -> None:
    robot = symgen.parse_robot(WITH_CONSTANTS, "arm")
    train, held = with_effects(5, 11.5, 1e-5), with_effects(4, 5, 0.0)
    plain, found = (
        symgen.identify(robot, train, validation=held, refine=refine)
        for refine in (None, "simulation")
    )
    assert plain.constants is None
    (w,) = found.constants
    assert (w.name, w.effect) == ("w", "soft")
    assert w.std < 1e-3
    assert abs(w.value - 0.25) < 1e-3
    X, std = ordered(found)
    assert np.all(np.abs(X - TRUE) < 4 * std), (X, std)
    assert any(note.endswith("the logs do not determine it: b") for note in found.notes)
    before, after = (e.uses[2].horizons[-1].position_error for e in (plain, found))
    assert after < 0.8 * before

    into = tmp_path / "found"
    symgen.write(found, into, robot=robot)
    again, own = symgen.read_estimate(into), symgen.read_robot(into / "robot.toml")
    assert again.constants == found.constants
    assert [float(v) for effect in own.effects for _, v in effect.nonlinear] == [w.value, 2.0]
    assert symgen.predict(own, held, into).error.relative < 0.02
    with pytest.raises(symgen.ParameterError, match=r"accepted: the robot.toml in"):
        symgen.predict(robot, held, into)


def test_gains_of_a_controller_replace_torques() -> None:
    robot = symgen.parse_robot(ROBOT + GAINS, "arm")
    assert symgen.parse_robot(symgen.robot_toml(robot), "arm") == robot
    train, held = [followed(seed, 11.5, 1e-3) for seed in (5, 6)], followed(4, 6, 1e-5)
    found = symgen.identify(robot, train, validation=held, refine="simulation")
    X, std = ordered(found)
    assert np.all(np.abs(X - TRUE) < 3 * std), (X, std)
    assert np.all(std < 0.05 * TRUE), std
    assert found.uses[2].with_feedback


def test_the_scale_of_unknown_gains_is_named(tmp_path) -> None:
    made, train = followed(5, 11.5, 1e-4), tmp_path / "log.csv"
    columns = np.column_stack([made.t, made.q, made.qr, made.qdr])
    np.savetxt(train, columns, "%.12g", ",", header="t,q1,q2,qr1,qr2,qdr1,qdr2", comments="")
    with pytest.raises(symgen.LogError, match=r"scale all torques.*scale = \"unknown\""):
        symgen.identify(symgen.parse_robot(ROBOT, "arm"), train)
    with pytest.raises(symgen.LogError, match=r"a data set has a reference and no torques"):
        symgen.identify(symgen.parse_robot(ROBOT + GAINS, "arm"), train, workers=1)
    gains = tmp_path / "gains.toml"
    gains.write_text(f"[controller]\nkp = {(2 * KP).tolist()}\nkd = {(2 * KD).tolist()}\n"
                     'scale = "unknown"')  # fmt: skip
    found = symgen.identify(symgen.parse_robot(ROBOT, "arm"), train, controller=gains)
    prediction, parameters, _ = found.uses
    assert prediction.ok
    assert not parameters.ok
    assert not parameters.known
    assert "only ratios of parameters hold" in parameters.reasons[0]
    assert np.allclose(ordered(found)[0], 2 * TRUE, rtol=0.02)


def test_a_model_that_lacks_an_effect_is_not_made_worse(tmp_path, command) -> None:
    made = log(3, 12, 1e-4)
    spring = made.tau + 1.5 * np.sin(2 * made.q)  # declared nowhere
    rows = np.column_stack([made.t, made.q, spring])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", comments="", header="t,q1,q2,tau1,tau2")
    (tmp_path / "robot.toml").write_text(ROBOT)
    errors = []
    for more in ((), ("--refine", "simulation")):
        into = tmp_path / f"out{len(more)}"
        code, _, err = command("identify", tmp_path / "robot.toml", tmp_path / "log.csv", *more,
                               "--into", into)  # fmt: skip
        assert code in (0, 1), err
        found = json.loads((into / "estimate.json").read_text())
        errors.append(found["uses"]["simulation"]["horizons"][-1]["position_error"])
    assert any("refined by simulation: on held-out windows" in note for note in found["notes"])
    assert errors[1] <= 1.02 * errors[0]


def test_what_is_refined_is_said() -> None:
    with pytest.raises(symgen.IdentificationError, match="accepted: simulation"):
        symgen.identify(symgen.parse_robot(ROBOT, "arm"), log(3, 5), refine="other")
    with pytest.raises(symgen.IdentificationError, match="accepted: simulation"):
        symgen.identify(symgen.parse_robot(ROBOT, "arm"), log(3, 5), model="static",
                        refine="simulation")  # fmt: skip
