"""Excitation from end to end: limits kept, figures that NumPy confirms, refusals in words."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from oracles.transforms import Arm
from support import excited, heeds_ctrl_c, messages

import symgen
from symgen import Limits
from symgen.diagnosis.extend import with_effect
from symgen.experiment.plan import Plan

LIMITS = {
    "position": [(-2.5, 2.5), (-1.0, 2.0)],
    "velocity": [2.0, 3.0],
    "acceleration": [8.0, 12.0],
}
QUICK = {"duration": 6.0, "terms": 5, "searches": 2, "iterations": 100, "budget": 100.0}
X = np.array([1.702, 0.05644, 0.15, 0.075])
PRIOR = "[parameters]\n" + "".join(f"{n} = {v}\n" for n, v in zip(planar2r.NAMES, X, strict=True))
MODELS = ("energy", "momentum", "torque")


def motion(run: dict, t: np.ndarray, order: int) -> np.ndarray:
    """A run at times t from its coefficients in JSON, by sums."""
    T, columns = run["duration"], []
    for joint in run["joints"]:
        c = np.array(joint["coefficients"])
        w = 2j * np.pi / T * np.arange(1, joint["terms"] + 1)
        waves = ((c[1::2] - 1j * c[2::2]) * w**order * np.exp(np.outer(t, w))).sum(axis=1).real
        columns.append(waves + (c[0] if order == 0 else 0))
    return np.stack(columns, axis=1)


def windows(h: np.ndarray, rates: np.ndarray, step: float, length: int) -> np.ndarray:
    """Rows of sliding windows: differences of h, and integrals of rates by the trapezoid."""
    sums = np.cumsum(
        np.r_[np.zeros((1, rates.shape[1])), (rates[1:] + rates[:-1]) * step / 2], axis=0
    )
    whole = np.c_[h, sums]
    return whole[length:] - whole[:-length]


def scaled_condition(W: np.ndarray) -> float:
    return float(np.linalg.cond(W / np.linalg.norm(W, axis=0)))


def plan_of(**options) -> tuple[Plan, dict]:
    plan = excited("planar2r", **(LIMITS | QUICK | options))
    files = plan.to_files(Path("t.csv"))
    return plan, json.loads(files[Path("t.json")])


@cache
def usual() -> tuple[Plan, dict]:
    return plan_of()


def test_the_runs_keep_every_limit_and_rest_at_both_ends() -> None:
    _, content = plan_of(runs=2, jerk=[8.0, 12.0], terms=5, iterations=25)
    assert len(content["runs"]) == 2
    for run in content["runs"]:
        t = np.linspace(0, run["duration"], 17_001)
        q = motion(run, t, 0)
        assert (q >= np.array(LIMITS["position"])[:, 0]).all()
        assert (q <= np.array(LIMITS["position"])[:, 1]).all()
        allowed = (LIMITS["velocity"], LIMITS["acceleration"], [8.0, 12.0])
        for order, limit in enumerate(allowed, 1):
            assert (np.abs(motion(run, t, order)).max(axis=0) <= limit).all()
        for order in (1, 2):
            assert np.abs(motion(run, t[[0, -1]], order)).max() < 1e-9


def test_the_margins_are_those_of_a_dense_grid() -> None:
    _, content = usual()
    t = np.linspace(0, content["runs"][0]["duration"], 17_001)
    for entry in content["limits"]:
        order = ("position", "velocity", "acceleration").index(entry["limit"])
        x = motion(content["runs"][0], t, order)[:, entry["joint"] - 1]
        if order:
            share = np.abs(x).max() / abs(entry["allowed"])
        else:
            low, high = LIMITS["position"][entry["joint"] - 1]
            share = np.abs(x - (low + high) / 2).max() / ((high - low) / 2)
        assert 1 - entry["margin"] == pytest.approx(share, abs=1e-5)
        assert entry["binds"] == (share >= 0.97)


def test_the_condition_numbers_are_numpys_on_closed_forms() -> None:
    plan, content = usual()
    run, step = content["runs"][0], 1 / 200
    t = np.arange(round(run["duration"] / step) + 1) * step
    q, qd, qdd = (motion(run, t, order) for order in range(3))
    h = planar2r.energy_regressor(q, qd, 0.5)
    W = (h[40:] - h[:-40])[::4]  # windows of 0.2 s end at every tenth part of it
    assert plan.condition == pytest.approx(scaled_condition(W), rel=1e-9)
    p, slope = planar2r.momentum_regressor(q, qd, 0.5)
    rows = [windows(p[:, j], slope[:, j], step, 40) for j in range(2)]
    W = np.concatenate([r[:, :4] - r[:, 4:] for r in rows])
    assert plan.conditions["momentum"] == pytest.approx(scaled_condition(W), rel=1e-2)
    W = planar2r.torque_regressor(q, qd, qdd, 0.5).reshape(-1, 4)
    assert plan.conditions["torque"] == pytest.approx(scaled_condition(W), rel=5e-2)


def information(model: str, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, noise: np.ndarray):
    """W'W of the samples, each over the standard deviation of its noise."""
    W = planar2r.torque_regressor(q, qd, qdd, 0.5)
    if model == "energy":
        power = (qd[..., None] * W).sum(axis=1)
        return power.T @ power / np.mean((qd**2) @ noise**2)
    rows = (W / noise[:, None]).reshape(-1, 4)
    return rows.T @ rows


@pytest.mark.parametrize("model", MODELS)
def test_the_expected_std_is_that_of_noisy_samples_by_closed_forms(model) -> None:
    noise = np.array([0.4, 0.1])
    plan, content = plan_of(model=model, runs=2, noise=noise, searches=1, iterations=20)
    G = np.zeros((4, 4))
    for run in content["runs"]:
        t = np.arange(1200) / 200
        G += information(model, *(motion(run, t, order) for order in range(3)), noise)
    expected = np.sqrt(np.diag(np.linalg.inv(G)))
    assert list(plan.std) == list(planar2r.NAMES)
    np.testing.assert_allclose(list(plan.std.values()), expected, rtol=0.03)
    assert content["expected_std"] == plan.std


def test_the_std_is_compared_with_what_a_percent_of_the_torque_limit_shows(tmp_path) -> None:
    """Limits ten times as high: the noise and the value that it hides are ten times as large."""
    (tmp_path / "prior.toml").write_text(PRIOR)
    low, high = (
        plan_of(torque=[t, t], parameters=tmp_path / "prior.toml", searches=1, iterations=5)[0]
        for t in (100.0, 1000.0)
    )
    for name, value in zip(planar2r.NAMES, X, strict=True):
        assert high.std[name] == pytest.approx(10 * low.std[name])
        assert low.scale[name] >= value
    assert low.scale["ZZ1R"] == X[0]  # a percent is less
    assert high.scale["MY2"] > 0.5 > low.scale["MY2"]


def random_motion(draw: np.random.Generator, t: np.ndarray) -> list[np.ndarray]:
    """q, qd, qdd of five random harmonics, each joint scaled to the first of its limits."""
    w = 2 * np.pi / QUICK["duration"] * np.arange(1, 6)
    waves = np.exp(1j * np.outer(t, w))
    c = draw.normal(size=(5, 2)) + 1j * draw.normal(size=(5, 2))
    q, qd, qdd = ((waves @ (c * (1j * w[:, None]) ** k)).real for k in (-1, 0, 1))
    low, high = np.array(LIMITS["position"]).T
    q -= (q.max(axis=0) + q.min(axis=0)) / 2
    tops = ((high - low) / 2, LIMITS["velocity"], LIMITS["acceleration"])
    scale = np.min([a / np.abs(x).max(axis=0) for a, x in zip(tops, (q, qd, qdd), strict=True)], 0)
    return [scale * q + (low + high) / 2, scale * qd, scale * qdd]


def test_planned_motions_are_more_precise_than_the_best_of_ten_random_ones() -> None:
    """By the torque regressor with equal noise: less than 0.75 of the median std."""

    def median(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> float:
        G = information("torque", q, qd, qdd, np.ones(2))
        return float(np.median(np.sqrt(np.diag(np.linalg.inv(G)))))

    draw, t = np.random.default_rng(5), np.linspace(0, QUICK["duration"], 301)
    at_random = min(median(*random_motion(draw, t)) for _ in range(10))
    for seed in (0, 1):
        plan, content = plan_of(model="momentum", seed=seed, iterations=300)
        assert median(*(motion(content["runs"][0], t, k) for k in range(3))) < 0.75 * at_random
        assert plan.optimised
        assert plan.deviation < 0.95 * plan.start
        assert plan.good == (plan.independent >= 12)


def test_a_budget_that_ends_at_once_is_told(command, tmp_path) -> None:
    options = ["--budget", 1e-6, "--into", tmp_path / "run.csv"]
    code, out, _ = command("excite", "planar2r", *SHORT[:6], *options)
    assert code == 1
    assert "not optimised" in out
    assert "not optimised" in (tmp_path / "run.html").read_text()
    content = json.loads((tmp_path / "run.json").read_text())
    assert content["stopped"] == "budget"
    assert any("--budget" in text for text in content["warnings"])


def test_the_csv_holds_the_sampled_references() -> None:
    plan, content = usual()
    assert (plan.searches, plan.stopped) == ((2, 2), "done")
    files = plan.to_files(Path("folder/t.csv"))
    assert list(files) == [Path("folder/t.csv"), Path("folder/t.json")]
    lines = files[Path("folder/t.csv")].decode().splitlines()
    assert lines[0] == "t,q1,q2,qd1,qd2,qdd1,qdd2"
    rows = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert rows[0, 0] == 0
    assert rows[-1, 0] == 6
    np.testing.assert_allclose(np.diff(rows[:, 0]), 1 / 200, rtol=1e-9)
    for order in range(3):
        expected = motion(content["runs"][0], rows[:, 0], order)
        np.testing.assert_allclose(rows[:, 1 + 2 * order : 3 + 2 * order], expected, atol=1e-9)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    first, again, other = (plan_of(seed=s)[0].to_files(Path("t.csv")) for s in (3, 3, 4))
    assert first == again
    assert first != other


def test_torques_of_the_prior_model_stay_within_their_limits(tmp_path) -> None:
    (tmp_path / "prior.toml").write_text(PRIOR)
    shares = {}
    for name, torque in (("wide", [100.0, 100.0]), ("narrow", [1.5, 0.15])):
        plan, content = plan_of(torque=torque, parameters=tmp_path / "prior.toml", noise=[1, 1])
        run = content["runs"][0]
        t = np.linspace(0, run["duration"], 11_001)
        tau = planar2r.inverse_dynamics(*(motion(run, t, order) for order in range(3)), X, 0.5)
        shares[name] = np.abs(tau).max(axis=0) / torque
        stated = [u.share for u in plan.uses if u.limit == "torque"]
        np.testing.assert_allclose(stated, shares[name], rtol=1e-3)
    assert shares["wide"].max() < 0.2  # it would take more than the narrow limits allow
    assert (shares["wide"] * 100 > np.array([1.5, 0.15])).any()
    assert 0.9 < shares["narrow"].max() <= 1


@pytest.mark.parametrize("model", MODELS)
def test_identify_finds_the_condition_that_was_promised_and_the_parameters(model: str) -> None:
    logs, promised = [], []
    for seed in (0, 1):
        plan, _ = plan_of(model=model, seed=seed, searches=1)
        t = plan.runs[0].times(1 / plan.rate)
        q, qd, qdd = (plan.runs[0].at(t, order) for order in range(3))
        tau = planar2r.inverse_dynamics(q, qd, qdd, X, 0.5)
        logs.append(symgen.make_log(f"run {seed}", t, q, tau, qd))
        promised.append(plan.condition)
    estimate = symgen.identify("planar2r", logs[0], validation=logs[1], model=model, method="ols")
    assert estimate.condition_number == pytest.approx(promised[0], rel=1e-6)
    np.testing.assert_allclose(estimate.X, X, rtol=1e-3)
    assert estimate.verdict == "trusted", estimate.reasons


def test_joints_carry_the_numbers_of_the_file_and_limits_come_from_it() -> None:
    text = """
[robot]
name = "fixed"
[[joint]]
sigma = 2
r = 0.3
[[joint]]
[[joint]]
alpha = "pi/2"
d = 0.2
[limits]
position = [[-2.0, 2.0], [-0.5, 1.5]]
velocity = [2.0, 1.0]
torque = [50.0, 50.0]
"""
    plan = excited(symgen.parse_robot(text, "fixed"), **(QUICK | {"iterations": 5}))
    found = {(u.limit, u.joint): abs(u.allowed) for u in plan.uses}
    assert sorted(found) == [("position", 2), ("position", 3), ("velocity", 2), ("velocity", 3)]
    assert (found["velocity", 2], found["velocity", 3]) == (2.0, 1.0)
    assert ["--parameters" in note for note in plan.notes] == [True]


def test_the_start_is_where_every_run_begins() -> None:
    _, content = plan_of(start=[0.4, -0.5], runs=2, iterations=20)
    for run in content["runs"]:
        np.testing.assert_allclose(motion(run, np.zeros(1), 0)[0], [0.4, -0.5], atol=1e-9)


def test_runs_that_are_good_for_torque_and_poor_for_energy_are_said_to_be() -> None:
    plan, _ = usual()
    poor = Plan(
        **{**plan.__dict__, "conditions": {"energy": 2.0, "momentum": 900.0, "torque": np.inf}}
    )
    assert poor.other_models == (
        "for the model of momentum these runs are poor (condition number 900)",
        "for the model of torque these runs are singular",
    )
    content = json.loads(poor.to_files(Path("t.csv"))[Path("t.json")])
    assert content["condition_number"]["torque"] is None
    assert len(content["warnings"]) == 2 + len(poor.warnings)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"duration": 0.2}, ["run of 0.2 s", "0.25 s"]),
        ({"terms": 2}, ["2 terms", "3 or more"]),
        ({"position": None}, ["positions are not limited", "[limits]"]),
        ({"velocity": None}, ["speeds are not limited"]),
        ({"velocity": [1.0]}, ["velocity has 1 entries"]),
        ({"position": [(1.0, 1.0)] * 2}, ["LOW below HIGH"]),
        ({"acceleration": [1.0, -1.0]}, ["above 0"]),
        ({"torque": [1.0, 1.0]}, ["prior model"]),
        ({"model": "power"}, ["energy, momentum, torque"]),
        ({"noise": [1.0]}, ["noise 1", "each of 2"]),
        ({"noise": [1.0, 0.0]}, ["noise 1, 0", "above 0"]),
        ({"start": [9.0, 0.0]}, ["inside the limits"]),
        ({"window": 0.0}, ["window 0"]),
        ({"budget": -1.0}, ["budget -1"]),
        ({"runs": 0}, ["runs 0"]),
    ],
)
def test_what_has_no_meaning_is_refused_in_a_line(options, words) -> None:
    with pytest.raises(symgen.ParameterError) as caught:
        plan_of(**options)
    assert "\n" not in str(caught.value)
    assert all(word in str(caught.value) for word in words), caught.value


def test_too_short_a_run_is_refused_with_the_limits_that_bind() -> None:
    limits = {"position": [(-2, 2)] * 6, "velocity": [1.0] * 6, "acceleration": [2.0] * 6}
    quick = {"duration": 0.6, "searches": 1, "iterations": 3, "seed": 1}
    with pytest.raises(symgen.IdentificationError, match=r"0.6 s.*acceleration of joint.*longer"):
        excited("tx40", **limits, **quick)


def test_torque_that_gravity_alone_exceeds_is_refused_by_its_name(tmp_path) -> None:
    robot = symgen.parse_robot(
        '[robot]\nname = "weight"\n[[joint]]\nsigma = 1\nfriction = ["viscous"]\n', "weight"
    )
    (tmp_path / "prior.toml").write_text("[parameters]\nM1 = 10.0\nIA1 = 0.0\nFV1 = 1.0\n")
    with pytest.raises(
        symgen.IdentificationError, match=r"torque of joint 1: it needs .*allowed 90"
    ):
        excited(
            robot,
            position=[(0.0, 1.0)],
            velocity=[1.0],
            torque=[90.0],
            parameters=tmp_path / "prior.toml",
            **(QUICK | {"searches": 1}),
        )


SHORT = ["--position", "2.5,-1:2", "--velocity", "2", "--duration", "6", "--searches", "1",
         "--iterations", "5"]  # fmt: skip


def test_the_command_writes_a_csv_for_each_run_and_what_is_known(tmp_path, command) -> None:
    into = tmp_path / "run.csv"
    options = [*SHORT, "--runs", "2", "--into", into]
    code, out, err = command("excite", "planar2r", *options)
    assert (code, messages(err)) == (0, [])
    files = ["run.html", "run.json", "run_1.csv", "run_2.csv"]
    assert sorted(p.name for p in tmp_path.iterdir()) == files
    assert "condition number, momentum model" in out
    content = json.loads((tmp_path / "run.json").read_text())
    assert content["schema"] == "symgen.trajectory/1"
    # Nothing is overwritten.
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    code, _, err = command("excite", "planar2r", *options)
    assert code == 2
    assert "run_1.csv: exists" in messages(err)[0]
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--velocity", "fast"], "--velocity fast"),
        (["--velocity", "1,2,3"], "one for each of 2"),
        (["--position", "1:b"], "--position 1:b"),
        (["--velocity", "nan"], "above 0"),
        (["--into", "run.txt"], "ends in .csv"),
        (["--runs", "0"], "runs"),
        (["--seed", "-1"], "seed"),
    ],
)
def test_the_command_refuses_in_one_line(options, word, tmp_path, monkeypatch, command) -> None:
    monkeypatch.chdir(tmp_path)
    usual = [*SHORT, "--into", "run.csv"]
    code, _, err = command("excite", "planar2r", *usual, *options)
    assert code == 2
    (line,) = messages(err)
    assert word in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_the_search_with_the_best_that_it_has(tmp_path) -> None:
    command = [sys.executable, "-m", "symgen", "excite", "planar2r", *SHORT[:6],
               "--searches", "9999", "--budget", "300",
               "--into", str(tmp_path / "t.csv")]  # fmt: skip
    pipes = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen(command, **pipes, preexec_fn=heeds_ctrl_c)
    for line in process.stderr:
        if "search 1: begins" in line:
            process.send_signal(signal.SIGINT)
            break
    out, _ = process.communicate(timeout=60)
    assert process.returncode in (0, 1)  # 1: it had not gained yet
    assert "stopped: interrupted" in out
    assert json.loads((tmp_path / "t.json").read_text())["stopped"] == "interrupted"


def test_torques_and_speeds_of_six_joints_are_within_limits_by_pinocchio(tmp_path) -> None:
    pytest.importorskip("pinocchio")
    from oracles.pinocchio_arm import PinocchioArm

    arm = Arm.from_table(
        {
            "sigma": [0] * 6,
            "alpha": [0, -np.pi / 2, 0, np.pi / 2, -np.pi / 2, np.pi / 2],
            "d": [0, 0, 0.225, 0, 0, 0],
            "theta": [0, 0, 0, 0, 0, np.pi],
            "r": [0.32, 0, 0.035, 0.225, 0, 0],
        }
    )
    names = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
    links = np.zeros((6, 10))
    for j, (mass, z) in enumerate([(8, 0.0), (6, 0.05), (4, 0.1), (2, 0.1), (1, 0.0), (0.3, 0.02)]):
        inertia = mass * (0.05**2 + z**2)
        links[j, [0, 3, 5, 8, 9]] = inertia, inertia, mass * 0.05**2, mass * z, mass
    IA, FS, FV = np.full(6, 0.05), np.array([3, 3, 2, 1, 1, 0.3]), np.full(6, 0.5)
    rows = [f"{n}{j + 1} = {links[j, k]}" for k, n in enumerate(names) for j in range(6)]
    for n, values in (("IA", IA), ("FS", FS), ("FV", FV), ("OF", np.zeros(6))):
        rows += [f"{n}{j} = {v}" for j, v in enumerate(values, 1)]
    (tmp_path / "prior.toml").write_text("[parameters]\n" + "\n".join(rows) + "\n")
    torque = [15.0, 30.0, 15.0, 4.0, 4.0, 1.0]
    limits = {"position": [(-2, 2)] * 6, "velocity": [3.0] * 6, "acceleration": [12.0] * 6}
    quick = {"duration": 10.0, "searches": 1, "iterations": 150}
    plan = excited("tx40", **limits, **quick, torque=torque, parameters=tmp_path / "prior.toml")
    oracle = PinocchioArm(arm, links, IA)
    t = np.linspace(0, 10, 401)
    q, qd, qdd = (plan.runs[0].at(t, order) for order in range(3))
    rigid = np.array([oracle.inverse_dynamics(*x) for x in zip(q, qd, qdd, strict=True)])
    shares = np.abs(rigid + FS * np.sign(np.round(qd, 4)) + FV * qd).max(axis=0) / torque
    assert 0.8 < shares.max() <= 1
    assert (np.abs(q) <= 2).all()
    assert (np.abs(qd) <= 3).all()
    assert (np.abs(qdd) <= 12).all()


def test_a_motion_for_effects_shows_them(command, tmp_path) -> None:
    """Of the column q2 of a spring, half at least is none of the model's, offset included.

    The plan counts the spring, its offset and Stribeck's friction beside four of the robot.
    """
    quick = ("--duration", 6, "--terms", 3, "--searches", 1, "--iterations", 20)
    limits = ("--position", 1.5, "--velocity", 2, "--acceleration", 6, "--budget", 60)
    into = tmp_path / "run.csv"
    wanted = ("--for", "gravity_spring:2", "--for", "stribeck_friction:1")
    code, out, err = command("excite", "planar2r", *quick, *limits, *wanted, "--into", into)
    assert code in (0, 1), err
    assert "for 7 parameters" in out
    t, *q = np.loadtxt(into, delimiter=",", skiprows=1)[:, :3].T
    q = np.column_stack(q)
    qd = np.gradient(q, t, axis=0)
    qdd = np.gradient(qd, t, axis=0)
    W = np.array([planar2r.torque_regressor(*s, 0.5) for s in zip(q, qd, qdd, strict=True)])
    model = np.concatenate([W, np.tile([[[0.0], [1.0]]], (len(t), 1, 1))], axis=2)
    spring = np.column_stack([0 * t, q[:, 1]]).ravel()
    Q = np.linalg.qr(model.reshape(len(spring), -1))[0]
    assert np.linalg.norm(spring - Q @ (Q.T @ spring)) > 0.5 * np.linalg.norm(spring)


def test_a_planned_effect_has_a_speed_in_the_middle_of_its_range() -> None:
    """Of ratios: the range of vs, 0.02 to 1.5 of the usual speed, is searched by them."""
    robot = replace(symgen.read_robot("planar2r"), limits=Limits(velocity=(2.0, 3.0)))
    [effect] = with_effect(robot, "stribeck_friction:2").effects
    assert dict(effect.nonlinear)["vs2"] == pytest.approx(3.0 * np.sqrt(0.02 * 1.5), rel=1e-5)


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("nonsense:1", "accepted: coulomb_friction"),
        ("time_delay:1", "what shows it: the same motion at twice the speed"),
        ("gravity_spring:7", "accepted: NAME:JOINT of 1, 2"),
        ("gravity_spring", "accepted: NAME:JOINT of 1, 2"),
        ("coupled_transmission:1", "two of a coupling"),
    ],
)
def test_what_no_motion_is_planned_for_is_refused(command, tmp_path, text, answer) -> None:
    asked = ("excite", "planar2r", "--for", text, "--into", tmp_path / "run.csv")
    code, _, err = command(*asked)
    assert code == 2
    assert answer in err
    assert len(err.splitlines()) == 1
