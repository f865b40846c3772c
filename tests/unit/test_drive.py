"""[drive]: a log on the motor side becomes the log on the joint side, and back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import data_folder

import symgen
from symgen.data.drive import joint_side, motor_side
from symgen.data.log import make_log, read_log
from symgen.errors import LogError, RobotError
from symgen.robot.tables import Drive

TWO = '[robot]\nname = "two"\n[[joint]]\n[[joint]]\nd = 0.5\n'
T = np.arange(20) * 0.01
Q = np.column_stack([np.sin(3 * T), np.cos(2 * T)])
#: Torque over current in the logs of the UR10e, N m/A, on the joint side.
UR10E = (11.976, 11.976, 9.839, 10.752, 10.752, 10.752)


def drive_of(text):
    return symgen.parse_robot(f"{TWO}[drive]\n{text}\n").drive


def test_gears_and_torque_constants_by_hand():
    # Motor 1 turns 100 rad for 1 rad of joint 1; 2 A x 0.1 N m/A x 100 = 20 N m at the joint.
    drive = drive_of("ratio = [100, -50]\ntorque_constant = [0.1, 0.2]")
    ones = np.ones((20, 2))
    log = make_log("a", T, ones * [10, 5], None, ones * [300, 25], current=ones * [2, 3])
    seen = joint_side(log, drive)
    np.testing.assert_allclose(seen.q, ones * [0.1, -0.1])
    np.testing.assert_allclose(seen.qd, ones * [3.0, -0.5])
    np.testing.assert_allclose(seen.tau, ones * [20.0, -30.0])
    assert seen.mapped
    assert "motor currents" in seen.notes[1]


def test_a_coupled_wrist_by_hand():
    # q_m2 = 3 q1 + 50 q2: motor 2 pulls joint 1 along with 3 times its torque.
    drive = drive_of("ratio = [[100, 0], [3, 50]]")
    ones = np.ones((20, 2))
    seen = joint_side(make_log("a", T, ones * [10.0, 5.3], ones * [0.5, 2.0]), drive)
    np.testing.assert_allclose(seen.q, ones * [0.1, 0.1], rtol=1e-14)
    np.testing.assert_allclose(seen.tau, ones * [100 * 0.5 + 3 * 2.0, 50 * 2.0])
    driven = drive_of("ratio = [[100, 0], [3, 50]]\ntorque_constant = [0.5, 0.25]")
    log = make_log("a", T, ones * [10.0, 5.3], None, current=ones * [1.0, 8.0])
    np.testing.assert_allclose(joint_side(log, driven).tau, seen.tau)
    back = motor_side(joint_side(log, driven), driven)
    np.testing.assert_allclose(back.current, log.current)
    assert back.tau is None


@given(
    rows=st.lists(st.lists(st.floats(-50, 50), min_size=3, max_size=3), min_size=3, max_size=3),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=50, deadline=None)
def test_power_is_the_same_on_both_sides(rows, seed):
    N = np.array(rows) + 120 * np.eye(3)
    rng = np.random.default_rng(seed)
    qd, tau = rng.normal(size=(20, 3)), rng.normal(size=(20, 3))
    log = make_log("a", T, np.zeros((20, 3)), tau, qd)
    seen = joint_side(log, Drive(tuple(map(tuple, N))))
    power = np.sum(qd * tau, axis=1)
    np.testing.assert_allclose(np.sum(seen.qd * seen.tau, axis=1), power, atol=1e-12)
    back = motor_side(seen, Drive(tuple(map(tuple, N))))
    np.testing.assert_allclose(back.qd, qd, atol=1e-12)
    np.testing.assert_allclose(back.tau, tau, atol=1e-12)


@pytest.mark.parametrize("position", ["motor", "joint"])
@pytest.mark.parametrize("torque", ["motor", "joint"])
def test_each_side_is_mapped_where_it_is_said_to_be_the_motors(position, torque):
    drive = drive_of(f'ratio = [100, 50]\nposition_side = "{position}"\ntorque_side = "{torque}"')
    seen = joint_side(make_log("a", T, Q, Q, Q), drive)
    gears = np.array([100, 50])
    np.testing.assert_allclose(seen.q, Q / gears if position == "motor" else Q)
    np.testing.assert_allclose(seen.qd, Q / gears if position == "motor" else Q)
    np.testing.assert_allclose(seen.tau, Q * gears if torque == "motor" else Q)


def test_hundreds_of_radians_at_the_motor_are_no_degrees(tmp_path):
    rows = np.column_stack([T, 3000 * T, 3000 * T, Q])
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    with pytest.raises(LogError, match="--unit deg"):
        read_log(tmp_path / "a.csv")
    log = read_log(tmp_path / "a.csv", drive=drive_of("ratio = [100, 100]"))
    np.testing.assert_allclose(log.q[:, 0], 30 * T)


def test_currents_stand_in_place_of_torques_only_with_torque_constants(tmp_path):
    rows, header = np.column_stack([T, Q, Q]), "t,q1,q2,i1,i2"
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=header, comments="")
    np.savez(tmp_path / "a.npz", t=T, q=Q, i=Q)
    for name in ("a.csv", "a.npz"):
        with pytest.raises(LogError, match="torque_constant"):
            read_log(tmp_path / name, drive=drive_of("ratio = [100, 50]"))
        log = read_log(tmp_path / name, drive=drive_of("torque_constant = [2, 3]"))
        np.testing.assert_allclose(log.tau, Q * [2, 3])


def test_the_torques_of_the_ur10e_come_back_from_its_currents():
    path = data_folder() / "ur10e" / "train.csv"
    drive = Drive(tuple(map(tuple, np.eye(6))), UR10E)
    told, seen = read_log(path), read_log(path, drive=drive)
    # Seven digits of torque and current in the file.
    np.testing.assert_allclose(seen.tau, told.tau, rtol=1e-6, atol=2e-5)
    np.testing.assert_array_equal(seen.q, told.q)
    geared = Drive(
        tuple(map(tuple, 101 * np.eye(6))), tuple(k / 101 for k in UR10E), position_side="joint"
    )
    same = read_log(path, drive=geared)
    np.testing.assert_allclose(same.tau, seen.tau, rtol=1e-12)
    np.testing.assert_array_equal(same.q, told.q)


@pytest.mark.parametrize(
    "text",
    ["ratio = [100, -80.5]\ntorque_constant = [0.1, 0.2]", "ratio = [[100, 0], [3.25, 50]]",
     "gain = [1.02, 0.97]\ngain_std = [0.01, 0.02]", 'side = "link"',
     'ratio = [1e3, 2]\nposition_side = "joint"\ntorque_side = "joint"'],
)  # fmt: skip
def test_a_drive_is_written_back_as_it_was_read(text):
    robot = symgen.parse_robot(f"{TWO}[drive]\n{text}\n")
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot


def test_a_sensor_on_the_link_side_sees_no_rotor():
    """rotor_inertia = true beside it is kept: a word of its own stands above the default."""
    linked = symgen.parse_robot(f'{TWO}[drive]\nside = "link"\n')
    assert not any(joint.rotor_inertia for joint in linked.joints)
    assert linked.drive.torque_side == linked.drive.position_side == "joint"
    assert all(joint.rotor_inertia for joint in symgen.parse_robot(TWO).joints)
    own = TWO.replace("[[joint]]", "[[joint]]\nrotor_inertia = true", 1)
    kept = symgen.parse_robot(f'{own}[drive]\nside = "link"\n')
    assert [joint.rotor_inertia for joint in kept.joints] == [True, False]


def test_gains_multiply_torques_and_go_back():
    drive = drive_of("ratio = [100, 50]\ngain = [1.1, 0.9]\ngain_std = [0.022, 0.009]")
    log = make_log("a", T, 10 * Q, Q)
    seen = joint_side(log, drive)
    np.testing.assert_allclose(seen.tau, Q * [110, 45])
    assert "gains of [drive]" in seen.notes[-1]
    np.testing.assert_allclose(motor_side(seen, drive).tau, Q)
    assert drive.gain_uncertainty_percent == pytest.approx(2.0)


BAD = {
    "nothing": ("", "declares nothing"),
    "count": ("ratio = [1]", "1 entries"),
    "zero": ("ratio = [0, 1]", "other than 0"),
    "singular": ("ratio = [[1, 2], [2, 4]]", "singular"),
    "ragged": ("ratio = [[1, 2], [2]]", "n x n"),
    "three rows": ("ratio = [[1, 2, 3], [2, 1, 0], [0, 0, 1]]", "3 entries"),
    "number": ("ratio = 100", "a list"),
    "text": ('ratio = ["100", 1]', "a number"),
    "constants": ("torque_constant = [1]", "1 entries"),
    "not finite": ("torque_constant = [1, nan]", "finite"),
    "side": ('ratio = [1, 1]\nposition_side = "link"', "'motor' or 'joint'"),
    "key": ("gear = [1, 1]", "accepted: ratio, torque_constant"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_drive_is_one_line_with_its_key(case):
    text, word = BAD[case]
    with pytest.raises(RobotError) as caught:
        drive_of(text)
    assert word in str(caught.value)
    assert "drive" in str(caught.value)
    assert "\n" not in str(caught.value)
