"""What is said of logs reaches identify, predict and diagnose: masks, weights, spans, drives."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from oracles.bags import State, write_mcap
from support import data_folder, sampled

import symgen
from symgen.data.drive import motor_side
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered_log import filter_log
from symgen.faults.repair import open_samples

ARM = """
[robot]
name = "pendulum"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
"""
STEP = 0.004
TRUE_NAMES = ("ZZ1R", "MX1", "MY1", "FS1", "FV1")  # ZZ1R = ZZ1 + IA1
TRUE = np.array([0.8, 1.1, 0.3, 2.0, 0.7])


def pendulum(seconds=40.0, seed=0, pauses=True):
    """A pendulum that swings, and rests now and then where friction can be anything.

    Returns t, q, qd, the true torque (M qdd + gravity + friction), all analytic.
    """
    t = np.arange(0, seconds, STEP)
    rng = np.random.default_rng(seed)
    w, a, c = rng.uniform(1.5, 7, 5), rng.uniform(0.2, 0.6, 5), rng.uniform(0, 6, 5)
    # Time that stands still between k and k + 0.35 of every fourth unit, smooth to third order.
    s, ds, dds = paused(t) if pauses else (t, np.ones_like(t), np.zeros_like(t))
    x = np.sum(a * np.sin(w * s[:, None] + c), axis=1)
    dx = np.sum(a * w * np.cos(w * s[:, None] + c), axis=1)
    ddx = np.sum(-a * w**2 * np.sin(w * s[:, None] + c), axis=1)
    q, qd, qdd = x, dx * ds, ddx * ds**2 + dx * dds
    zz, mx, my, fs, fv = TRUE
    friction = fs * np.sign(qd) + fv * qd
    tau = zz * qdd + 9.81 * (mx * np.cos(q) - my * np.sin(q)) + friction
    return t, q, qd, tau


def paused(t):
    """A clock that stops for 1 s in every 4 s, with its first two derivatives."""
    phase = t % 4.0
    ramp = np.clip((phase - 1.0) / 0.5, 0, 1), np.clip((phase - 2.5) / 0.5, 0, 1)
    blend = [u**3 * (10 - 15 * u + 6 * u**2) for u in ramp]
    slope = [30 * u**2 * (1 - u) ** 2 / 0.5 for u in ramp]
    ds = 1 - blend[0] + blend[1]
    from scipy.integrate import cumulative_simpson

    return cumulative_simpson(ds, dx=STEP, initial=0), ds, slope[1] - slope[0]


@pytest.fixture(scope="module")
def robot():
    return symgen.parse_robot(ARM)


@pytest.fixture(scope="module")
def resting():
    """Logs with stiction: at rest the torque is that of gravity and something within +-FS."""

    def log(seed):
        t, q, qd, tau = pendulum(seed=seed)
        held = qd == 0
        stuck = TRUE[3] * np.sin(0.9 * t + seed)
        return symgen.make_log(f"rest{seed}", t, q, np.where(held, tau + stuck, tau), qd)

    return log(0), log(1)


@pytest.fixture(scope="module")
def cut_off():
    """Logs whose torque sensor ends at 14 N m, while the motion goes on."""

    def log(seed):
        t, q, qd, tau = pendulum(seed=seed, pauses=False)
        return symgen.make_log(f"cut{seed}", t, q, np.clip(tau, -14, 14), qd)

    return log(2), log(3)


def error(estimate):
    return float(np.max(np.abs(estimate.X - TRUE) / np.abs(TRUE)))


def identified(robot, logs, mask=(), **options):
    reading = symgen.Reading(mask=mask)
    return symgen.identify(robot, logs[0], validation=logs[1], reading=reading, **options)


@pytest.mark.parametrize("model", ["momentum", "torque"])
def test_without_its_rests_a_log_with_stiction_gives_the_parameters(robot, resting, model):
    bound = 1e-3 if model == "momentum" else 5e-3
    counted = identified(robot, resting, model=model, cutoff=20)  # for what they are worth
    assert error(counted) < bound
    estimate = identified(robot, resting, ("rest",), model=model, cutoff=20)
    assert error(estimate) < bound
    note = next(n for n in estimate.notes if n.startswith("rest0: masked at rest"))
    t, _, qd, _ = pendulum(seed=0)
    told = int(re.search(r"joint 1 (\d+) \(", note)[1])
    assert np.sum(qd == 0) <= told <= np.sum(np.abs(qd) < 0.02 * np.abs(qd).max())
    assert f"of {len(t)} samples" in note


@pytest.mark.parametrize("model", ["energy", "momentum", "torque"])
def test_without_saturation_a_log_that_is_cut_off_gives_the_parameters(robot, cut_off, model):
    rows_of = EquationModel(model, 0.2)
    evaluator = symgen.load(symgen.derive(robot, rows_of.all_kernels))
    taken = replace(open_samples(cut_off[0], robot)[0], mask=None)  # as if nothing had been cut
    band = Band(1 / STEP, 20.0, 10.0, "measured")
    rows = rows_of.equations(evaluator, filter_log(taken, band))
    assert np.max(np.abs(Wls().solve(rows).X / TRUE - 1)) > 0.02
    found = identified(robot, cut_off, model=model, cutoff=20)
    estimate = identified(robot, cut_off, ("saturation",), model=model, cutoff=20)
    assert error(estimate) < (5e-3 if model == "torque" else 1e-3)
    assert any("cut2: masked in saturation" in note for note in estimate.notes)
    # it shows in the log by itself: what is cut off is masked without being told
    assert error(found) < (5e-3 if model == "torque" else 1e-3)
    assert [(r.log, r.channel, r.why, r.done) for r in found.repairs] == [
        (name, "tau1", "clipped at 14", "masked") for name in ("cut2", "cut3")
    ]
    at = np.abs(cut_off[0].tau) >= 14 * (1 - 1e-9)
    assert found.repairs[0].samples == np.sum(at)


@pytest.mark.parametrize("model", ["energy", "momentum", "torque"])
def test_a_mask_leaves_out_equations_and_changes_none(robot, resting, cut_off, model):
    rows_of = EquationModel(model, 0.2)
    evaluator = symgen.load(symgen.derive(robot, rows_of.all_kernels))
    for log, kind in ((resting[0], "rest"), (cut_off[0], "saturation")):
        masked, _ = open_samples(log, robot, symgen.Reading(mask=(kind,)))
        plain = replace(open_samples(log, robot)[0], mask=None)
        for array in ("t", "q", "qd", "tau"):
            np.testing.assert_array_equal(getattr(masked, array), getattr(plain, array))
        band = Band(1 / STEP, 0.5 / STEP, 10.0, "measured")
        if model == "torque":  # what a masked sample says changes nothing
            joint = masked.mask.joint
            odd = replace(masked, tau=np.where(joint, 1e3, masked.tau))
            left, same = (
                rows_of.equations(evaluator, filter_log(s, band)).parts[0] for s in (masked, odd)
            )
            np.testing.assert_array_equal(left.W, same.W)
            np.testing.assert_allclose(left.y, same.y, atol=1e-9)
            assert 0.2 < len(left.y) / len(filter_log(plain, band).kept) < 0.98
            continue
        whole, rows = (rows_of.equations(evaluator, filter_log(s, band)) for s in (plain, masked))
        kept, (left,) = rows.weight[:, 0] > 0, rows.parts
        assert 0.2 < np.mean(kept) < 0.98
        np.testing.assert_array_equal(whole.W[kept, 0], left.W)
        np.testing.assert_array_equal(whole.y[kept, 0], left.y)
        bad = plain.t[masked.mask.joint[:, 0]]
        near = [np.any((bad > t - 0.2 - 1e-9) & (bad < t + 1e-9)) for t in rows.t[kept]]
        assert not any(near)


def test_a_diagnosis_does_not_name_a_saturation_that_is_masked(robot):
    def cut(seed):
        log = noisy(seed, 0.1)
        return replace(log, tau=np.clip(log.tau, -14, 14))

    options = {"validation": cut(3), "effects": ["saturation"]}
    reading = symgen.Reading(mask=("saturation",))
    masked = symgen.diagnose(robot, cut(2), reading=reading, **options)
    plain = symgen.diagnose(robot, cut(2), **options)  # found and masked without being told
    assert any("tau1: clipped at 14" in note and "masked" in note for note in plain.notes)
    assert (masked.effects, masked.verdict) == ((), "consistent")
    assert [e.name for e in plain.effects] == ["saturation"]
    assert plain.verdict == "bad-measurement"
    for diagnosis in (masked, plain):
        assert diagnosis.after.total < 0.02


def test_a_mask_that_leaves_nothing_is_one_line(robot, resting):
    with pytest.raises(symgen.LogError, match=r"--mask leaves \d+ equations.*accepted"):
        identified(robot, resting, ("rest",), model="momentum", window=3.1)


def noisy(seed, sigma):
    t, q, qd, tau = pendulum(20.0, seed, pauses=False)
    noise = sigma * np.random.default_rng(seed).normal(size=len(t))
    return symgen.make_log(f"noisy{seed}", t, q, tau + noise, qd)


def test_a_span_of_time_is_cut_before_anything_is_done(robot, cut_off):
    samples, _ = open_samples(cut_off[0], robot, symgen.Reading(start=5.0, until=12.0))
    inside = (cut_off[0].t >= 5) & (cut_off[0].t <= 12)
    np.testing.assert_array_equal(samples.t, cut_off[0].t[inside])
    np.testing.assert_array_equal(samples.tau, cut_off[0].tau[inside])
    assert "cut to t = 5 s to 12 s" in samples.notes[0]
    with pytest.raises(symgen.LogError, match=r"0 samples lie between 50 s.*39\.996 s; accepted"):
        open_samples(cut_off[0], robot, symgen.Reading(start=50.0))


def test_a_log_on_the_other_side_than_said_is_refused_where_limits_tell():
    text = ARM + "[drive]\nratio = [0.1]\n[limits]\nposition = [[-3.0, 3.0]]\n"
    t, q, qd, tau = pendulum(20.0, 7, pauses=False)
    with pytest.raises(symgen.LogError, match=r"q1 runs from .* limits .* are -3 and 3.*\[drive\]"):
        open_samples(symgen.make_log("a", t, q, tau, qd), symgen.parse_robot(text))
    joint = symgen.parse_robot(text.replace("[limits]", 'position_side = "joint"\n[limits]'))
    assert open_samples(symgen.make_log("a", t, q, tau, qd), joint)[0].notes


def test_currents_without_torque_constants_are_refused(robot):
    t, q, qd, tau = pendulum(20.0, 7, pauses=False)
    log = symgen.make_log("a", t, q, None, qd, current=tau)
    with pytest.raises(symgen.LogError, match="torque_constant"):
        open_samples(log, robot)
    with pytest.raises(symgen.LogError, match="torque constants"):
        symgen.prepare(log)


# The command line


@pytest.fixture
def run(command):
    """Run the command line in this process; return its exit code and the lines on stderr."""

    def call(*arguments):
        code, _, err = command(*arguments)
        return code, err.splitlines()

    return call


@pytest.fixture
def arm(tmp_path):
    (tmp_path / "arm.toml").write_text(ARM)
    return tmp_path / "arm.toml"


def table(path, log, header=("t", "q1", "qd1", "tau1")):
    rows = np.column_stack([log.t, log.q, log.qd, log.tau])
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows.tolist())
    return path


def values_of(folder):
    found = json.loads((folder / "estimate.json").read_text())
    return np.array([p["value"] for p in found["parameters"]]), found


def test_columns_joints_and_masks_reach_the_three_commands(run, arm, cut_off, tmp_path):
    theirs = ("stamp", "hip", "hip speed", "hip torque")
    one, two = (table(tmp_path / f"{k}.csv", log, theirs) for k, log in enumerate(cut_off))
    names = "t=stamp,q1=hip,qd1=hip speed,tau1=hip torque"
    shared = ("--mask", "saturation", "--from", "1", "--until", "38")
    code, _ = run("identify", arm, one, "--validation", two, "--columns", names, *shared,
                  "--into", tmp_path / "a")  # fmt: skip
    X, found = values_of(tmp_path / "a")
    assert code == 0
    np.testing.assert_allclose(X, TRUE, rtol=1e-3)
    assert sum("masked in saturation" in note for note in found["notes"]) == 2
    assert sum("cut to t = 1 s" in note for note in found["notes"]) == 2

    mapped = tmp_path / "mapped.toml"
    mapped.write_text(arm.read_text() + f'[log]\ncolumns = "{names}"\n')
    code, _ = run("predict", mapped, one, "--parameters", tmp_path / "a" / "estimate.json", *shared,
                  "--into", tmp_path / "p")  # fmt: skip
    assert code == 0
    notes = json.loads((tmp_path / "p" / "prediction.json").read_text())["notes"]
    assert any("masked" in note for note in notes)
    code, _ = run("diagnose", mapped, one, "--validation", two, *shared, "--effects", "backlash",
                  "--into", tmp_path / "d")  # fmt: skip
    assert code in (0, 1)
    assert json.loads((tmp_path / "d" / "diagnosis.json").read_text())["effects"] == []


def test_a_bag_on_the_motor_side_gives_what_the_table_of_the_joint_side_gives(run, arm, tmp_path):
    pytest.importorskip("rosbags")
    pytest.importorskip("mcap_ros2")
    t, q, qd, tau = pendulum(20.0, 7, pauses=False)
    log = symgen.make_log("log", t, q, tau, qd)
    geared = tmp_path / "geared.toml"
    geared.write_text(ARM + "[drive]\nratio = [50.0]\ntorque_constant = [0.2]\n")
    messages = [
        State(round(at * 1e9), ["m1"], [50 * a], [50 * b], [c / 50 / 0.2])
        for at, a, b, c in zip(t, q, qd, tau, strict=True)
    ]
    bag = write_mcap(tmp_path / "log.mcap", {"/joint_states": messages})
    # noise-free folds choose between cutoffs by their rounding: it is given, as is the model
    same = ("--model", "energy", "--cutoff", "20")
    run("identify", arm, table(tmp_path / "log.csv", log), *same, "--into", tmp_path / "a")
    run("identify", geared, bag, "--joints", "m1", "--columns", "i=effort", *same, "--into",
        tmp_path / "b")  # fmt: skip
    (X, _), (same, found) = values_of(tmp_path / "a"), values_of(tmp_path / "b")
    np.testing.assert_allclose(same, X, rtol=1e-9)
    assert any("motor side to the joint side" in note for note in found["notes"])
    assert any("motor currents" in note for note in found["notes"])


@pytest.mark.slow
def test_currents_of_the_ur10e_give_the_parameters_of_its_torques():
    folder = data_folder() / "ur10e"
    plain = symgen.read_robot(folder / "robot.toml")
    text = symgen.robot_toml(plain) + (
        "[drive]\nratio = [101.0, 101.0, 101.0, 101.0, 101.0, 101.0]\ntorque_constant = "
        '[0.11857, 0.11857, 0.097416, 0.106455, 0.106455, 0.106455]\nposition_side = "joint"\n'
    )
    driven = symgen.parse_robot(text)
    told, seen = (
        symgen.identify(robot, folder / "train.csv", validation=folder / "test.csv", model="torque")
        for robot in (plain, driven)
    )
    gains = np.repeat([11.976, 11.976, 9.839, 10.752, 10.752, 10.752], 1)
    drive = np.array([0.11857, 0.11857, 0.097416, 0.106455, 0.106455, 0.106455]) * 101
    np.testing.assert_allclose(drive, gains, rtol=1e-4)
    assert abs(seen.torque_validation.relative - told.torque_validation.relative) < 1e-4
    std = np.array([p.std for p in told.parameters])
    assert np.max(np.abs(seen.X - told.X) / std) < 0.05
    assert any("differs from it by up to" in note for note in seen.notes)


@pytest.mark.parametrize("suffix", sampled([".csv", ".npz"], 0, always=[".npz"]))
def test_a_simulated_log_is_on_the_side_that_the_robots_logs_are_on(tmp_path, suffix):
    text = ARM + "[drive]\nratio = [50.0]\ntorque_constant = [0.2]\n"
    geared, plain = symgen.parse_robot(text), symgen.parse_robot(ARM)
    true = dict(zip(symgen.derive(plain).base.names, TRUE.tolist(), strict=True))
    t, q, qd, tau = pendulum(4.0, 7, pauses=False)
    motion = symgen.make_log("motion", t, q, tau, qd)
    one, other = (
        symgen.simulate(robot, true, trajectory=log)
        for robot, log in ((plain, motion), (geared, motor_side(motion, geared.drive)))
    )
    np.testing.assert_allclose(other.q, one.q, atol=1e-7)
    path = tmp_path / f"log{suffix}"
    path.write_bytes(other.file(suffix=suffix))
    raw = (
        np.load(path)["q"]
        if suffix == ".npz"
        else np.loadtxt(path, delimiter=",", skiprows=1, usecols=[1], ndmin=2)
    )
    np.testing.assert_allclose(raw, 50 * other.q[0], rtol=1e-9)
    for source in (path, other.log()):
        seen, repairs = open_samples(source, geared)
        assert not repairs
        np.testing.assert_allclose(seen.q, other.q_log[0], atol=1e-9)
        np.testing.assert_allclose(seen.tau, other.tau_log[0], rtol=1e-9, atol=1e-9)


BAD = {
    "mask": (["--mask", "noise"], "accepted: rest, saturation"),
    "columns": (["--columns", "q1"], "ours=theirs"),
    "columns twice": (["--columns", "q1=a,q1=b"], "given twice"),
    "same column": (["--columns", "q1=a,tau1=a"], "given twice"),
    "role": (["--columns", "speed1=a"], "no column of a log"),
    "no such column": (["--columns", "q1=hip"], "there is no column 'hip'"),
    "all joints": (["--columns", "q=q1"], "one column a joint"),
    "span": (["--from", "3", "--until", "2"], "above 0 s"),
    "far": (["--from", "300"], "samples lie between"),
    "not finite": (["--until", "nan"], "finite"),
}


@pytest.mark.parametrize("case", BAD)
def test_options_that_no_log_can_be_read_with_are_one_line(
    run, arm, cut_off, tmp_path, monkeypatch, case
):
    monkeypatch.chdir(tmp_path)
    options, word = BAD[case]
    log = table(tmp_path / "log.csv", cut_off[0])
    code, lines = run("predict", arm, log, "--parameters", "none", *options, "--into", "out")
    lines = [line for line in lines if not line.startswith("  ")]
    if case in ("no such column", "all joints", "far"):  # said when the log is opened
        code, lines = run("identify", arm, log, *options, "--into", "out")
        lines = [line for line in lines if line.startswith("symgen: error")]
    assert code == 2
    assert len(lines) == 1
    assert word in lines[0]
    assert not (tmp_path / "out").exists()
