"""Columns of recorders: what is matched by name, what is said of it, and what is refused."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from symgen.data.log import read_log
from symgen.data.raw import Reading
from symgen.errors import LogError

N, JOINTS = 30, ("hip", "knee", "knee_2")
T = 0.01 * np.arange(N)
#: Every column has a number of its own, so that a swap shows.
VALUES = {
    role: np.column_stack([np.sin(T + k + 0.1 * j) for j in range(3)])
    for k, role in enumerate(("q", "qd", "tau"))
}


@pytest.fixture
def log_of(tmp_path):
    """Write columns under names and read the log with three joints."""

    def read(names: dict[str, str], extra=(), joints=JOINTS, suffix="csv", **options):
        columns = {names["t"]: T}
        for role, values in VALUES.items():
            for j in range(len(values.T)):
                if role in names:
                    columns[names[role].format(name=JOINTS[j], k=j + 1, o=j)] = values[:, j]
        columns = {**dict.fromkeys(extra, np.full(N, 7.0)), **columns}
        path = tmp_path / f"log.{suffix}"
        if suffix == "csv":
            table = np.column_stack(list(columns.values()))
            header = ",".join(columns)
            np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.17g")
        else:
            import pyarrow as pa
            import pyarrow.parquet as pq

            pq.write_table(pa.table(columns), path)
        options = {"sigma": (0, 0, 0)} | options
        return read_log(path, names=joints, **options)

    return read


RECORDERS = {
    "joint and word": {
        "t": "time", "q": "{name}_position", "qd": "{name}_velocity", "tau": "{name}_effort",
    },
    "word and number": {"t": "timestamp", "q": "pos_{k}", "qd": "vel_{k}", "tau": "tau_{k}"},
    "from zero": {"t": "t", "q": "q_{o}", "qd": "dq_{o}", "tau": "tau_J_{o}"},
    "topics": {
        "t": "time [s]", "q": "/js/{name}/position", "qd": "/js/{name}/velocity",
        "tau": "/js/{name}/effort",
    },
    "arrays with units": {
        "t": "Time (s)", "q": "position[{o}] [rad]", "qd": "velocity[{o}] [rad/s]",
        "tau": "effort[{o}] [N m]",
    },
    "two numbers": {
        "t": "t", "q": "robot1_joint{k}_pos", "qd": "robot1_joint{k}_vel", "tau": "torque{k}_1",
    },
    "speeds are missing": {"t": "stamp", "q": "{name}.pos", "tau": "{name}.torque"},
}  # fmt: skip


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("case", RECORDERS)
def test_columns_of_a_recorder_are_matched_and_said_in_one_line(log_of, case, suffix) -> None:
    log = log_of(RECORDERS[case], extra=("hip_position_desired", "tau_d_1", "mode"), suffix=suffix)
    np.testing.assert_array_equal(log.t, T)
    np.testing.assert_array_equal(log.q, VALUES["q"])
    np.testing.assert_array_equal(log.tau, VALUES["tau"])
    if "qd" in RECORDERS[case]:
        np.testing.assert_array_equal(log.qd, VALUES["qd"])
    else:
        assert log.qd is None
    (line,) = log.notes
    assert "columns by name" in line
    assert "\n" not in line
    assert "q = " in line
    assert "tau = " in line
    assert "mode" in log.ignored


def test_names_of_the_robot_choose_among_the_joints_of_a_log(log_of) -> None:
    names = {"t": "time", "q": "{name}_position", "tau": "{name}_effort"}
    log = log_of(names, joints=("knee_2", "hip"), sigma=(0, 0))
    np.testing.assert_array_equal(log.q, VALUES["q"][:, [2, 0]])
    np.testing.assert_array_equal(log.tau, VALUES["tau"][:, [2, 0]])


@pytest.mark.parametrize("name", ["{joint} pos [{unit}]", "{joint}_position_{unit}"])
def test_joints_of_two_kinds_have_columns_of_two_units(tmp_path, name) -> None:
    units = {"hip": "deg", "lift": "mm"}
    columns = ["t", *(name.format(joint=j, unit=u) for j, u in units.items())]
    columns += [f"{joint}_effort" for joint in units]
    path = tmp_path / "log.csv"
    table = np.column_stack([T, *([[180.0], [1000.0], [3.0], [4.0]] * np.ones((4, N)))])
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    log = read_log(path, names=tuple(units), sigma=(0, 1))
    np.testing.assert_allclose(log.q[0], [np.pi, 1.0])


def test_of_columns_in_two_units_the_one_in_si_counts_unless_a_pattern_chooses(tmp_path) -> None:
    columns = ["time", *(f"pos_{j} [{unit}]" for unit in ("deg", "rad") for j in (1, 2))]
    columns += ["torque_1", "torque_2"]
    path = tmp_path / "log.csv"
    table = np.column_stack([T, *([[90.0], [180.0], [1.0], [2.0], [3.0], [4.0]] * np.ones((6, N)))])
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    np.testing.assert_allclose(read_log(path, 2).q[0], [1.0, 2.0])
    log = read_log(path, 2, reading=Reading(columns={"q": "pos_* [deg]"}))
    np.testing.assert_allclose(log.q[0], [np.pi / 2, np.pi])
    path.write_text(path.read_text().replace("[rad]", "[turn]"))
    with pytest.raises(LogError, match=r"q may be pos_\* \[deg\] or pos_\* \[turn\]"):
        read_log(path, 2)


@pytest.mark.parametrize("role", ["position", "effort"])
@pytest.mark.parametrize(
    ("column", "fits"),
    [("finger_{role}_est", True), ("channel_a", True), ("", False), ("finger_x [{unit}]", True)],
)
def test_a_joint_without_a_column_may_be_in_another_or_fixed(tmp_path, role, column, fits):
    spare = column.format(role=role, unit={"position": "mm", "effort": "N"}[role])
    other = "finger_y [A]"  # of no position and no torque
    names = {f"{joint}_{word}" for joint in ("hip", "finger") for word in ("position", "effort")}
    columns = ["t", *sorted(names - {f"finger_{role}"}), other, *([spare] if spare else [])]
    path = tmp_path / "log.csv"
    table = np.column_stack([T] * len(columns))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    with pytest.raises(LogError, match="no column for finger") as caught:
        read_log(path, names=("hip", "finger"), sigma=(0, 1))
    text, ours = str(caught.value), {"position": "q", "effort": "tau"}[role]
    option = f"{ours}=*_{role},{ours}2=COLUMN"
    assert (f'--columns "{option}" with COLUMN one of {spare}' in text) == fits
    assert ("--fix finger" in text) == (role == "position")
    if fits:
        reading = Reading(columns=option.replace("COLUMN", spare))
        read_log(path, names=("hip", "finger"), sigma=(0, 1), reading=reading)


@pytest.mark.skipif(shutil.which("sh") is None, reason="there is no shell")
def test_the_printed_option_is_what_a_shell_hands_over(log_of) -> None:
    """Columns of KUKA's recorder, whose $ a shell would replace in double quotes."""
    names = {"t": "Zeit", "q": "$AXIS_ACT_MEAS[{k}]", "tau": "$TORQUE_AXIS_ACT[{k}]"}
    with pytest.raises(LogError) as caught:
        log_of(names)
    _, option = str(caught.value).split("--columns ")
    typed = subprocess.run(["sh", "-c", f"printf %s {option}"], capture_output=True, text=True)
    assert typed.stdout == "q=$AXIS_ACT_MEAS[*]"
    columns = {"t": "Zeit", "q": "$AXIS_ACT_MEAS[*]", "tau": "$TORQUE_AXIS_ACT[*]"}
    log = log_of(names, reading=Reading(columns=columns))
    np.testing.assert_array_equal(log.q, VALUES["q"])


def test_a_pattern_chooses_where_two_would_do(log_of) -> None:
    names = RECORDERS["joint and word"]
    twice = [f"{j}_position_raw" for j in JOINTS]
    with pytest.raises(LogError, match="q may be") as caught:
        log_of(names, extra=twice)
    assert '--columns "q=*_position' in str(caught.value)
    log = log_of(names, extra=twice, reading=Reading(columns={"q": "*_position"}))
    np.testing.assert_array_equal(log.q, VALUES["q"])
    np.testing.assert_array_equal(log.tau, VALUES["tau"])
    log = log_of(names, extra=twice, reading=Reading(columns={"q": "*_position_raw"}))
    assert (log.q == 7).all()
    log = log_of(RECORDERS["from zero"], reading=Reading(columns={"tau": "tau_J_*"}))
    np.testing.assert_array_equal(log.tau, VALUES["tau"])


TRACK = {"t": "t", "q": "A{k}.pos", "qd": "A{k}.vel", "tau": "A{k}.torque"}


def test_a_pattern_holds_for_the_joints_without_a_column_of_their_own(log_of) -> None:
    """An external axis and the axes of the arm have other names."""
    joints = ("rail", *JOINTS)
    options = {"extra": ("E1.pos", "E1.force", "mode"), "joints": joints, "sigma": (1, 0, 0, 0)}
    columns = {"q1": "E1.pos", "tau1": "E1.force", "q": "A*.pos", "tau": "A*.torque"}
    log = log_of(TRACK, reading=Reading(columns=columns), **options)
    assert log.qd is None  # the rail has none
    np.testing.assert_array_equal(log.q, np.column_stack([np.full(N, 7.0), VALUES["q"]]))
    np.testing.assert_array_equal(log.tau[:, 1:], VALUES["tau"])
    (line, *_) = log.notes
    for words in ("q1 = E1.pos", "q = A*.pos", "* = 1 to 3 for hip, knee, knee_2"):
        assert words in line
    assert "not used: E1.pos" not in line
    assert "mode" in line.split("not used: ")[1]
    log = log_of(
        RECORDERS["joint and word"], extra=("z",), joints=JOINTS,
        reading=Reading(columns={"q2": "z", "q": "*_position"}),
    )  # fmt: skip
    np.testing.assert_array_equal(log.q[:, [0, 2]], VALUES["q"][:, [0, 2]])
    assert (log.q[:, 1] == 7).all()
    with pytest.raises(LogError, match=r'A\*.pos has 3 columns for 4 joints.*"q1=NAME,q=A\*.pos"'):
        log_of(TRACK, **options)


def test_a_recorder_may_leave_out_the_end_of_joint_names(tmp_path: Path) -> None:
    """The URDF has hip_joint and hip_2_joint; the columns begin with hip and hip_2."""
    words = [f"{joint}/{word}" for word in ("position", "effort") for joint in ("hip_2", "hip")]
    path, table = tmp_path / "log.csv", np.column_stack([T, *np.ones((4, N))])
    table[:, 1], table[:, 2] = 2 * T, T
    np.savetxt(path, table, delimiter=",", header=",".join(["t", *words]), comments="")
    log = read_log(path, names=("hip_joint", "hip_2_joint"), sigma=(0, 0))
    np.testing.assert_allclose(log.q, np.column_stack([T, 2 * T]))
    reading = Reading(columns={"q": "*/position"})
    with pytest.raises(LogError, match="--joints hip_2,hip, in the order"):
        read_log(path, reading=reading, names=("shoulder", "elbow"), sigma=(0, 0))


REFUSED = {
    "a finger has no column": (
        {"joints": (*JOINTS, "finger"), "sigma": (0, 0, 0, 1)},
        {}, "no column for finger", "symgen import FILE --fix finger --into robot.toml",
    ),
    "more joints by number": (
        {"joints": ("a", "b"), "sigma": (0, 0)}, RECORDERS["from zero"] | {"qd": "x_{o}"},
        "the log has 3 joints", "the robot has 2",
    ),
    "two times": ({"extra": ("stamp",)}, {}, "stamp and time are times", '--columns "t=stamp"'),
    "degrees": ({}, {"q": "{name}_position_deg"}, "_position_deg", "--unit q="),
    "milliseconds": ({}, {"t": "time_ms"}, "'time_ms' (t)", "--time-unit s"),
    "what was asked": ({}, {"tau": "{name}_effort_cmd"}, "no column tau1", "--columns"),
    "two roles in a name": ({}, {"tau": "{name}_velocity_effort"}, "no column tau1", "--columns"),
    "one joint of three by number": (
        {"reading": Reading(columns={"q3": "knee_2_position"})}, {},
        "there are only q3", "all joints",
    ),
    "a unit of other joints": (
        {"sigma": (0, 0, 1), "reading": Reading(unit={"q": "deg"})}, {},
        "no unit of length, which joint 3 has", "joints: --unit deg",
    ),
    "no such pattern": (
        {"reading": Reading(columns={"q": "*_angle"})}, {}, "--columns q=*_angle", "hip_position",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_unclear_is_refused_with_what_helps(log_of, case) -> None:
    options, names, *says = REFUSED[case]
    with pytest.raises(LogError) as caught:
        log_of(RECORDERS["joint and word"] | names, **options)
    for words in says:
        assert words in str(caught.value)
    assert "\n" not in str(caught.value)
