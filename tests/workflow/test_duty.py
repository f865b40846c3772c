"""Logs of servos that record their duty, or only their reference, instead of torques."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from oracles.arm import X
from scipy.interpolate import CubicSpline
from support_streams import FRICTION, motion, parquet, robot

import symgen
from symgen import Controller, Recording
from symgen.data.log import read_log
from symgen.data.long_logs import expanded
from symgen.data.signals import sampled
from symgen.errors import LogError
from symgen.estimation.opening import open_log
from symgen.faults.repair import open_samples
from symgen.robot.tables import LogForm

COLUMNS = motion(600, 3)
Q = np.column_stack([COLUMNS["q1"], COLUMNS["q2"]])
DUTY = np.column_stack([COLUMNS["tau1"], COLUMNS["tau2"]])
DUTY = np.round(0.9 * DUTY / np.abs(DUTY).max(), 3)
TENTHS = 1000 * DUTY
SENT = np.where(TENTHS < 0, 1024 - TENTHS, TENTHS)  # the sign in bit 10


def table(path: Path, names: str, values: np.ndarray, **more: np.ndarray) -> Path:
    """Write a log with columns of duty; * in the name is the number of the joint."""
    columns = {k: COLUMNS[k] for k in ("t", "q1", "q2")}
    columns |= {names.replace("*", str(j + 1)): values[:, j] for j in (0, 1)} | more
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, "%.12g", ",", header=",".join(columns), comments="")
    return path


def with_drive(lines: str) -> symgen.Robot:
    return symgen.parse_robot(f"{symgen.robot_toml(robot())}\n{lines}")


def opened(path: Path, arm: symgen.Robot | None = None, **options: object) -> symgen.Log:
    return open_log(path, arm or robot(), symgen.Reading(**options))


SUPPLY = "[drive]\nsupply = 12.0\n"


@pytest.mark.parametrize(
    ("names", "values", "options", "drive"),
    [
        ("present_pwm_* [%]", 100 * DUTY, {}, ""),
        ("u*", TENTHS, {"unit": {"u": "0.1%"}}, ""),
        ("u*", SENT, {"unit": {"u": "sign10:0.1%"}}, ""),
        ("load_*", 100 * DUTY, {"columns": "u=load_*", "unit": {"u": "%"}}, ""),
        ("u* [V]", 12 * DUTY, {}, SUPPLY),
        ("u*", 12e3 * DUTY, {"unit": {"u": "mV"}}, SUPPLY),
    ],
)
def test_duty_is_read_in_the_units_of_servos(tmp_path, names, values, options, drive):
    expected = opened(table(tmp_path / "plain.csv", "u*", DUTY))
    found = opened(table(tmp_path / "log.csv", names, values), with_drive(drive), **options)
    assert (found.drive_unit, expected.drive_unit) == ("duty", "duty")
    np.testing.assert_allclose(found.duty, DUTY, atol=1e-12)
    np.testing.assert_allclose(found.tau, expected.tau, atol=1e-12)


@pytest.mark.parametrize(("name", "unit", "size"), [("u* [V]", {}, 1), ("u*", {"u": "0.1V"}, 0.1)])
def test_volts_without_a_supply_stay_volts(tmp_path, name, unit, size):
    log = opened(table(tmp_path / "log.csv", name, 12 * DUTY / size), unit=unit)
    assert log.drive_unit == "V"
    np.testing.assert_allclose(log.duty, 12 * DUTY)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_the_recorded_supply_scales_duty(tmp_path, suffix):
    plain = opened(table(tmp_path / "plain.csv", "u*", DUTY))
    volts = 11 + np.linspace(-1, 1, len(DUTY))
    path = tmp_path / f"log{suffix}"
    if suffix == ".npz":
        np.savez(path, t=COLUMNS["t"], q=Q, u=DUTY, supply=volts)
    else:
        table(path, "u*", DUTY, supply=volts)
    log = opened(path, with_drive(SUPPLY))
    np.testing.assert_allclose(log.tau, plain.tau * volts[:, None] / 12.0, atol=2e-3)
    assert any("recorded supply" in note for note in log.notes)
    with pytest.raises(LogError, match=r"supply in \[drive\]"):
        opened(path)


def test_duty_is_clipped_at_its_limit_and_turned_by_a_negative_ratio(tmp_path):
    path = table(tmp_path / "log.csv", "u*", DUTY)
    plain = opened(table(tmp_path / "clipped.csv", "u*", np.clip(DUTY, -0.4, 0.4)))
    drive = 'ratio = [1, -50]\nposition_side = "joint"\nlimit = 0.4'
    log = opened(path, with_drive(f"[drive]\n{drive}\n"))
    np.testing.assert_allclose(log.tau, plain.tau * [1, -1], atol=1e-12)


def test_empty_cells_of_duty_are_missing_data(tmp_path):
    holes = DUTY.copy()
    holes[100:103, 0] = np.nan
    path = tmp_path / "log.npz"
    np.savez(path, t=COLUMNS["t"], q=Q, u=holes)
    log = opened(path)
    np.testing.assert_array_equal(log.missing[:, :, 2], np.isnan(holes))
    np.testing.assert_allclose(log.duty, DUTY, atol=0.02)


@pytest.mark.parametrize(
    ("names", "values", "options", "drive", "says"),
    [
        ("u*", 100 * DUTY, {}, "", "u1 is up to 90, .* --unit u=%, or --unit u=V"),
        ("u*", TENTHS, {}, "", "accepted: --unit u=0.1%"),
        ("u*", np.abs(SENT), {}, "", "sign is in bit 10; accepted: --unit u=sign10:0.1%"),
        ("u* [V]", 15 * DUTY, {}, SUPPLY, r"up to 13.5 V, and the supply of \[drive\] 12 V"),
        (
            "present_load_* [%]", DUTY, {"columns": "tau=present_load_*"}, "",
            "or --columns u1=.. for the duty of servos",
        ),
        ("pwm_*", DUTY, {"columns": "tau=pwm_*"}, "", "--columns u=.. with --unit u=%"),
        ("load_*", DUTY, {"columns": "tau=load_*"}, "", "is the duty of a servo by its name"),
    ],
)  # fmt: skip
def test_what_is_no_duty_or_no_torque_is_refused(tmp_path, names, values, options, drive, says):
    path = table(tmp_path / "log.csv", names, values)
    with pytest.raises(LogError, match=says):
        opened(path, with_drive(drive), **options)


def test_of_duty_and_torques_the_user_names_one(tmp_path):
    taus = {k: COLUMNS[k] for k in ("tau1", "tau2")}
    path = table(tmp_path / "log.csv", "u*", DUTY, **taus)
    with pytest.raises(LogError, match=r"--columns tau=\.\. or --columns u=\.\."):
        opened(path)
    assert opened(path, columns="tau=tau*").drive_unit == ""
    np.testing.assert_allclose(opened(path, columns="u=u*").duty, DUTY)


def test_a_load_with_the_unit_of_torques_is_a_torque(tmp_path):
    path = table(tmp_path / "log.csv", "load_*", 40 * DUTY)
    log = opened(path, columns="tau=load_*", unit={"tau": "Nm"})
    np.testing.assert_allclose(log.tau, 40 * DUTY, atol=1e-12)


def test_the_hold_of_the_duty_is_no_inertia():
    """A digital controller holds its torque from stamp to stamp; here it is 30 N m per duty."""
    per_duty, friction = 30.0, (6.0, 4.0)
    names = ("ZZ1R", "ZZ2", "MX2", "MY2", "FV1", "FV2")
    true = np.array([*X, *friction])
    made = symgen.simulate(
        robot(),
        dict(zip(names, true, strict=True)),
        recording=Recording(
            controller=Controller("pd", bandwidth=10.0, feedback="measured"), rate=50.0
        ),
    ).log()
    duty = np.round(made.tau / per_duty, 3)

    def distance(log: symgen.Log) -> np.ndarray:
        """Return how many standard deviations the estimate is from the arm."""
        found = symgen.identify(robot(), log, model="momentum")
        std = np.array([p.std for p in found.parameters])
        return np.abs(found.X - true / per_duty) / std

    held = symgen.make_log("held", made.t, made.q, None, duty=duty)
    assert (distance(held) < 3).all()
    assert distance(symgen.make_log("late", made.t, made.q, duty))[0] > 5


def test_a_duty_at_its_limit_is_not_masked():
    """It is the input of the drive; of a torque, the part above the limit is unknown."""
    steps = 0.3 * np.sign(np.sin(2 * COLUMNS["t"]))[:, None] * np.ones(2)
    steps[:200] = 0.3 * DUTY[:200]
    torque, repairs = open_samples(symgen.make_log("log", COLUMNS["t"], Q, steps), robot())
    assert "saturated" in [fault.kind for fault in repairs]
    assert torque.mask is not None
    duty, repairs = open_samples(symgen.make_log("log", COLUMNS["t"], Q, None, duty=steps), robot())
    assert duty.mask is None
    assert repairs == ()


def test_notes_on_torques_say_nothing_of_duty(tmp_path):
    """The limits of the file are torques, and its masses are kg."""
    arm = with_drive("[limits]\ntorque = [0.01, 0.01]\n")
    little = 0.01 * DUTY
    path = table(tmp_path / "log.csv", "u*", little)
    found = symgen.identify(arm, str(path), model="momentum")
    torques = symgen.make_log("log", COLUMNS["t"], Q, 2 * little)
    as_torques = symgen.identify(arm, torques, model="momentum")
    for words in ("its limit in the robot file", "look at the units of the log"):
        assert not any(words in note for note in found.notes)
        assert any(words in note for note in as_torques.notes)


KP, KD = np.array([3.0, 5.0]), np.array([0.2, 0.3])
SERVO = "[controller]\nkp = [3, 5]\nkd = [0.2, 0.3]\nunit = "
REFERENCE = Q + 0.05 * np.sin(2 * COLUMNS["t"])[:, None]


def test_duty_follows_from_gains_in_duty(tmp_path):
    """The servo sees its position at all times, and holds the reference until the next one."""
    path = table(tmp_path / "log.csv", "qr*", REFERENCE, qdr1=0 * DUTY[:, 0], qdr2=0 * DUTY[:, 1])
    torque = opened(path, with_drive(f"{SERVO}'N m'\n"))
    duty = opened(path, with_drive(f"{SERVO}'duty'\n[drive]\nlimit = 0.1\n"))
    late = np.vstack([REFERENCE[:1], 0.5 * (REFERENCE[1:] + REFERENCE[:-1])])
    expected = torque.tau + KP * (late - REFERENCE)
    assert duty.drive_unit == "duty"
    np.testing.assert_allclose(duty.tau, np.clip(expected, -0.1, 0.1), atol=2e-3)
    assert any("in duty" in note for note in duty.notes)


def test_currents_follow_from_gains_in_ampere(tmp_path):
    path = table(tmp_path / "log.csv", "qr*", REFERENCE)
    torque = opened(path, with_drive(f"{SERVO}'N m'\n"))
    with pytest.raises(LogError, match=r"torque_constant in \[drive\]"):
        opened(path, with_drive(f"{SERVO}'A'\n"))
    motors = 'ratio = [10, 20]\ntorque_constant = [0.1, 0.2]\nposition_side = "joint"\n'
    log = opened(path, with_drive(f"{SERVO}'A'\n[drive]\n{motors}"))
    assert log.drive_unit == ""
    np.testing.assert_allclose(log.tau, torque.tau * [1.0, 4.0], rtol=1e-12)


def test_a_robot_file_keeps_the_keys_of_servos():
    keys = "supply = 12\nresistance = [2.2, 2.0]\nlimit = 0.8\n"
    arm = with_drive(f"{SERVO}'duty'\n[drive]\n{keys}[log]\nrange = [[-1, 1], [2, -2]]\n")
    assert arm.drive.supply == (12.0, 12.0)
    assert arm.drive.ratio == ((1.0, 0.0), (0.0, 1.0))
    assert symgen.parse_robot(symgen.robot_toml(arm)) == arm
    with pytest.raises(symgen.SymgenError, match=r"drive, key 'supply'.*a number above 0"):
        with_drive("[drive]\nsupply = 0\n")


NAMES = ["elbow.pos", "shoulder.pos", "gripper.pos"]


def data_set(
    folder: Path,
    scale: np.ndarray,
    offset: np.ndarray,
    episodes: int = 1,
    action: np.ndarray = REFERENCE,
) -> Path:
    """Write a LeRobot data set whose last joint is a gripper, and its first the second one."""
    (folder / "meta/episodes").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    parquet(folder / "meta/episodes/file-000.parquet", {"episode_index": np.arange(episodes)})
    lists = {"shape": [3], "names": {"motors": NAMES}}
    features = {"observation.state": lists, "action": lists}
    info = {"fps": 100, "features": features}
    (folder / "meta/info.json").write_text(json.dumps(info))

    def rows(x: np.ndarray) -> pa.Array:
        stored = (x - offset) / scale
        return pa.array(np.column_stack([stored[:, ::-1], stored[:, 0]]).tolist())

    frames, count = np.arange(len(Q)), len(Q) // episodes
    columns = {"observation.state": rows(Q), "action": rows(action)}
    columns |= {"timestamp": (frames % count / 100).astype(np.float32), "index": frames + 7000}
    columns["episode_index"] = 4 + frames // count
    parquet(folder / "data/chunk-000/file-000.parquet", columns)
    return folder


def named(drive: str) -> symgen.Robot:
    arm = with_drive(drive)
    first, second = arm.joints
    joints = (replace(first, name="shoulder"), replace(second, name="elbow"))
    return replace(arm, joints=joints)


def test_a_lerobot_data_set_is_read_by_its_own_names(tmp_path):
    folder = data_set(tmp_path / "set", np.full(2, np.pi / 180), np.zeros(2))
    path = next(folder.glob("data/*/*.parquet"))
    servo = named(f"{SERVO}'duty'\n")
    with pytest.raises(LogError, match=r"--unit deg, --unit rad, or range = \[\[low, high\]"):
        opened(path, servo)
    log = opened(path, servo, unit={"": "deg"})
    np.testing.assert_allclose(log.q, Q, atol=1e-12)
    np.testing.assert_allclose(log.qr, REFERENCE, atol=1e-12)
    np.testing.assert_allclose(log.t - log.t[0], COLUMNS["t"], atol=1e-9)
    assert log.drive_unit == "duty"
    with pytest.raises(LogError, match=r"'wrist' is not among elbow, shoulder, .*--joints"):
        opened(path, servo, unit={"": "deg"}, joints=("elbow", "wrist"))


def test_a_data_set_without_torques_gives_the_arm_per_unit_of_duty(tmp_path):
    """The reference of each frame acts half a frame later on average, the position at once."""
    per_duty = np.abs(np.column_stack([COLUMNS["tau1"], COLUMNS["tau2"]])).max() / 0.9
    ahead = CubicSpline(COLUMNS["t"], Q + DUTY / KP)(COLUMNS["t"] + 0.005)
    folder = data_set(tmp_path / "set", np.full(2, np.pi / 180), np.zeros(2), action=ahead)
    arm = named("[controller]\nkp = [3, 5]\nkd = [0, 0]\nunit = 'duty'\n")
    reading = symgen.Reading(unit={"": "deg"})
    found = symgen.identify(arm, str(folder), model="momentum", reading=reading)
    std = np.array([p.std for p in found.parameters])
    true = np.array([*X, FRICTION, FRICTION]) / per_duty
    assert (np.abs(found.X - true) < 3 * std).all()
    assert (std < 0.05 * np.abs(true)).all()


def test_a_data_set_stands_for_its_log_and_gives_it_its_name(tmp_path):
    """Files of all data sets have the same names."""
    sets = [data_set(tmp_path / name, np.ones(2), np.zeros(2)) for name in ("free", "weight")]
    servo = named(f"{SERVO}'duty'\n")
    first, second = (opened(folder, servo, unit={"": "rad"}) for folder in sets)
    assert (first.name, second.name) == ("free/file-000.parquet", "weight/file-000.parquet")
    np.testing.assert_allclose(first.q, Q, atol=1e-12)
    parquet(sets[0] / "data/chunk-000/file-001.parquet", {"t": COLUMNS["t"]})
    with pytest.raises(LogError, match="free: has 2 logs; accepted: one of them"):
        opened(sets[0], servo, unit={"": "rad"})


def test_a_reference_alone_needs_the_gains_of_the_servo(tmp_path):
    path = table(tmp_path / "log.csv", "qr*", REFERENCE)
    with pytest.raises(LogError, match=r"symgen import writes .*unit = .duty. for servos"):
        opened(path)


def test_a_share_of_the_range_of_each_joint_is_read_by_the_range_in_the_robot_file(tmp_path):
    ranges = np.array([[-1.5, 2.0], [1.0, -3.0]])
    folder = data_set(tmp_path / "set", np.ptp(ranges, axis=1) / 200 * [1, -1], ranges.mean(axis=1))
    arm = replace(named(f"{SERVO}'duty'\n"), log=LogForm(range=tuple(map(tuple, ranges))))
    log = opened(next(folder.glob("data/*/*.parquet")), arm)
    np.testing.assert_allclose(log.q, Q, atol=1e-12)
    np.testing.assert_allclose(log.qr, REFERENCE, atol=1e-12)


def test_episodes_of_a_file_are_gaps_in_time(tmp_path):
    folder = data_set(tmp_path / "set", np.ones(2), np.zeros(2), episodes=2)
    (path,) = expanded([str(folder)])
    samples = sampled(opened(Path(str(path)), named(f"{SERVO}'duty'\n"), unit={"": "rad"}))
    assert samples.mask is not None
    assert 90 <= samples.mask.robot.sum() <= 110
    assert samples.drive_unit == "duty"
    assert any("gaps in time" in note for note in samples.notes)


@pytest.mark.parametrize(
    ("unit", "counts"),
    [
        ("ticks4096-2048", 2048 + Q * 4096 / (2 * np.pi)),
        ("sign15:ticks4096", None),
        ("0.5deg", Q * 360 / np.pi),
    ],
)
def test_positions_in_steps_of_a_register(tmp_path, unit, counts):
    steps = np.round(Q * 4096 / (2 * np.pi))
    expected = Q if counts is not None else steps * 2 * np.pi / 4096
    counts = np.where(steps < 0, 2**15 - steps, steps) if counts is None else counts
    columns = {"t": COLUMNS["t"], "q": counts, "tau": DUTY}
    np.savez(tmp_path / "log.npz", **columns)
    reading = symgen.Reading(unit={"q": unit})
    log = read_log(tmp_path / "log.npz", sigma=(0, 0), reading=reading)
    np.testing.assert_allclose(log.q, expected, atol=1e-12)


def test_speeds_in_steps_of_a_register(tmp_path):
    speed = np.gradient(Q, COLUMNS["t"], axis=0)
    np.savez(tmp_path / "log.npz", t=COLUMNS["t"], q=Q, tau=DUTY, qd=speed * 4096 / (2 * np.pi))
    reading = symgen.Reading(unit={"qd": "ticks4096/s"})
    log = read_log(tmp_path / "log.npz", sigma=(0, 0), reading=reading)
    np.testing.assert_allclose(log.qd, speed, atol=1e-12)
