"""payload --sensor: the tool behind a force/torque sensor, from the wrench of points of mass."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from browser import Page
from oracles import wrist

import symgen

SHORT = {"poses": 6, "rest": 1.0, "swing": 5.0, "rate": 200.0}
WRENCH = ("wfx", "wfy", "wfz", "wnx", "wny", "wnz")
TOOL = wrist.tool(1.5)


@pytest.fixture(scope="module")
def robot() -> symgen.Robot:
    return symgen.parse_robot(wrist.ROBOT)


@cache
def made(seed: int, mass: float = 1.5, drift: float = 0.0, sign: float = 1.0) -> tuple:
    """A log of the arm with a tool and the offset of its sensor; the drift in noises."""
    move = wrist.motion(seed, **SHORT)
    tool = wrist.tool(mass)
    data, offset = wrist.recorded(tool, seed, drift * wrist.NOISE, sign, move=move)
    return symgen.make_log(f"log {seed}", data["t"], data["q"], None, wrench=data["wrench"]), offset


def quantities(found: symgen.Payload) -> tuple[np.ndarray, np.ndarray]:
    pairs = [(q.value, q.std) for _, q, _ in found.rows()]
    return tuple(np.array(column, dtype=float) for column in zip(*pairs, strict=True))


def away(found: symgen.Payload, true: np.ndarray) -> np.ndarray:
    """Errors in standard deviations."""
    values, std = quantities(found)
    return np.abs(values - true) / std


@pytest.mark.parametrize("backend", ["c", "casadi"])
def test_the_kernel_is_newtons_law_of_points(robot, backend: str) -> None:
    kernel = symgen.load(symgen.derive(robot, ("tool_wrench",)), backend=backend)["tool_wrench"]
    q, qd, qdd = np.random.default_rng(1).uniform(-2, 2, (3, 20, 6))
    offset = np.arange(6.0)
    found = kernel(q, qd, qdd, TOOL.standard, offset)
    expected = wrist.wrench(TOOL, q, qd, qdd) + offset
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_no_sensor_no_kernel() -> None:
    assert symgen.derive("planar2r", "all").kernel("tool_wrench") is None


@pytest.mark.parametrize("drift", [0.0, 1.0])
def test_a_tool_is_found_with_offset_and_drift(robot, drift: float) -> None:
    log, offset = made(3, drift=drift)
    found = symgen.payload(robot, log, sensor=True)
    assert (away(found, TOOL.quantities) < 4).all()
    assert found.frame == "wrist"
    assert found.residual.after < 1.2 * found.residual.noise_floor
    assert not found.sensor.turned
    for q, true in zip(found.sensor.offset, offset, strict=True):
        assert abs(q.value - true) < 4 * q.std
    for q, noise in zip(found.sensor.drift, wrist.NOISE, strict=True):
        assert q.value is None if drift == 0 else abs(q.value - noise) < 4 * q.std


def test_an_offset_that_warms_up_biases_nothing(robot) -> None:
    log, _ = made(4)
    late = (log.t / log.t[-1])[:, None]
    warm = log.wrench + 4 * wrist.NOISE * np.exp(-3 * late)
    found = symgen.payload(
        robot, symgen.make_log("warm", log.t, log.q, None, wrench=warm), sensor=True
    )
    assert (away(found, TOOL.quantities) < 4).all()


def test_a_sensor_of_the_opposite_sign_is_turned(robot) -> None:
    log, offset = made(3, sign=-1.0)
    found = symgen.payload(robot, log, sensor=True)
    assert (away(found, TOOL.quantities) < 4).all()
    assert found.sensor.turned
    assert any("multiplied by -1" in note for note in found.notes)
    assert abs(found.sensor.offset[0].value - offset[0]) < 4 * found.sensor.offset[0].std


def test_every_log_has_its_own_offset(robot) -> None:
    logs, offsets = zip(made(5), made(6), strict=True)
    assert np.abs(offsets[0] - offsets[1])[:3].max() > 1
    found = symgen.payload(robot, logs, sensor=True)
    assert (away(found, TOOL.quantities) < 4).all()
    assert abs(found.sensor.offset[0].value - offsets[1][0]) < 4 * found.sensor.offset[0].std


def test_a_gap_in_the_log_is_left_out(robot) -> None:
    log, _ = made(3)
    kept = (log.t < 4.0) | (log.t > 5.5)
    rows = (x[kept] for x in (log.t, log.q))
    found = symgen.payload(
        robot, symgen.make_log("gap", *rows, None, wrench=log.wrench[kept]), sensor=True
    )
    assert any("gaps in time" in note for note in found.notes)
    assert (away(found, TOOL.quantities) < 4).all()


HOME = np.array([0.0, -1.4, 1.6, -1.7, -1.5, 0.0])


def slowly(*ends: np.ndarray) -> symgen.Log:
    """A log of rests at poses with moves of 4 s between them."""
    knots = np.array(ends)
    t = np.arange(round(100 * (6.0 * len(knots)))) / 100
    move = wrist._moves(t, 2.0 + 6.0 * np.arange(len(knots) - 1), knots, 4.0)
    data, _ = wrist.recorded(TOOL, 9, move=(t, *move))
    return symgen.make_log("poses", t, data["q"], None, wrench=data["wrench"])


def test_poses_about_a_vertical_axis_leave_the_mass_open(robot) -> None:
    turns = [HOME + [angle, 0, 0, 0, 0, 0] for angle in (0.0, 0.6, 1.2, -0.7)]
    with pytest.raises(symgen.IdentificationError, match=r"mass.*vertical axis") as caught:
        symgen.payload(robot, slowly(*turns), sensor=True)
    assert "\n" not in str(caught.value)


def test_two_poses_show_the_mass_and_not_the_centre(robot) -> None:
    found = symgen.payload(robot, slowly(HOME, HOME + [0, 0, 0, 0.0, 1.2, 0]), sensor=True)
    assert abs(found.mass.value - 1.5) < 4 * found.mass.std
    assert "mass" in found.identifiable


REFUSED = {
    "no tool": (lambda: made(3, mass=1e-6)[0], "no load on the link of joint 6"),
    "no wrench": (
        lambda: symgen.make_log("bare", made(3)[0].t, made(3)[0].q, made(3)[0].q),
        "bare: lacks the wrench of the sensor; accepted: columns wfx, wfy",
    ),
    "twice the same log": (lambda: [made(3)[0]] * 2, "holds the same data"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_shows_no_tool_is_refused(robot, case: str) -> None:
    log, says = REFUSED[case]
    with pytest.raises(symgen.SymgenError) as caught:
        symgen.payload(robot, log(), sensor=True)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_axes_that_are_not_those_of_the_sensor_are_refused() -> None:
    text = wrist.ROBOT.replace(str(list(wrist.RPY)), "[1.7, -0.2, 0.7]")
    with pytest.raises(symgen.IdentificationError, match=r"rigid tool.*axes of the sensor"):
        symgen.payload(symgen.parse_robot(text), made(3)[0], sensor=True)


OPTIONS = {
    "mass": ({"mass": 1.0}, "--mass"),
    "frame": ({"frame": "wrist"}, "--frame"),
    "cutoff": ({"cutoff": 500.0}, "cutoff"),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_options_without_a_meaning_are_refused(robot, case: str) -> None:
    options, says = OPTIONS[case]
    with pytest.raises(symgen.SymgenError, match=says):
        symgen.payload(robot, made(3)[0], sensor=True, **options)


def test_a_robot_without_a_sensor_is_refused_and_so_is_an_unknown_frame() -> None:
    bare = wrist.ROBOT.partition("[sensor]")[0]
    with pytest.raises(symgen.RobotError, match=r"accepted: \[sensor\] with frame"):
        symgen.payload(symgen.parse_robot(bare), made(3)[0], sensor=True)
    with pytest.raises(symgen.RobotError, match=r"\[sensor\]|sensor, key 'frame': .*'tcp'.*wrist"):
        symgen.parse_robot(wrist.ROBOT.replace('frame = "wrist"', 'frame = "tcp"'))
    robot = symgen.parse_robot(wrist.ROBOT)
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot


def test_joint_torques_of_the_same_log_stand_beside_the_sensor(robot, tmp_path) -> None:
    move = wrist.motion(8, **SHORT)
    data, _ = wrist.recorded(TOOL, 8, move=move)
    noise = 0.2 * np.random.default_rng(8).normal(size=data["q"].shape)
    tau = wrist.torques(TOOL, *move[1:]) + noise
    log = symgen.make_log("both", data["t"], data["q"], tau, wrench=data["wrench"])
    names = symgen.derive(robot).base.names
    file = tmp_path / "alone.toml"
    file.write_text("[parameters]\n" + "".join(f"{name} = 0.0\n" for name in names))
    found = symgen.payload(robot, log, sensor=True, parameters=file)
    assert (away(found, TOOL.quantities) < 4).all()
    mass, *_ = found.sensor.torques
    assert abs(mass.value - 1.5) < 4 * mass.std
    assert mass.std > found.mass.std
    with pytest.raises(symgen.LogError, match="has a wrench and no torques"):
        symgen.identify(robot, made(3)[0])


def test_a_missing_column_of_the_wrench_is_named(tmp_path, command) -> None:
    log, _ = made(3)
    (tmp_path / "ur.toml").write_text(wrist.ROBOT)
    names = ",".join(["t", *(f"q{j}" for j in range(1, 7)), "Fx", *WRENCH[1:]])
    table = np.column_stack([log.t, log.q, log.wrench])
    np.savetxt(tmp_path / "log.csv", table, "%.12g", ",", header=names, comments="")
    asked = ["payload", tmp_path / "ur.toml", tmp_path / "log.csv", "--sensor"]
    code, _, err = command(*asked, "--into", tmp_path / "load")
    assert code == 2
    assert "no column wfx among" in err
    assert "--columns wfx=NAME" in err
    code, _, err = command(*asked, "--columns", "wfx=Fx", "--into", tmp_path / "load")
    assert code == 0, err
    (tmp_path / "log.csv").write_text((tmp_path / "log.csv").read_text().replace("wfz", "Fz"))
    code, _, err = command(*asked, "--columns", "wfx=Fx", "--into", tmp_path / "load")
    assert code == 2
    assert "no column wfz among" in err


def test_the_unit_of_a_channel_of_the_wrench_is_an_option(tmp_path) -> None:
    log, _ = made(3)
    names = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *WRENCH])
    table = np.column_stack([log.t, log.q, log.wrench * [1, 1, 1, 1, 1, 1000]])
    np.savetxt(tmp_path / "log.csv", table, "%.12g", ",", header=names, comments="")
    reading = symgen.Reading(unit={"wrench6": "mNm"})
    read = symgen.read_log(tmp_path / "log.csv", reading=reading)
    np.testing.assert_allclose(read.wrench, log.wrench, rtol=1e-9)


@pytest.mark.parametrize("ending", ["csv", "npz", "parquet"])
def test_the_command_reads_the_wrench_and_writes_the_contract(tmp_path, command, ending) -> None:
    log, _ = made(3)
    (tmp_path / "ur.toml").write_text(wrist.ROBOT)
    file, into = tmp_path / f"log.{ending}", tmp_path / "load"
    names = ["t", *(f"q{j}" for j in range(1, 7)), *WRENCH[:-1], "wnz [mNm]"]
    table = np.column_stack([log.t, log.q, log.wrench * [1, 1, 1, 1, 1, 1000]])
    if ending == "npz":
        np.savez(file, t=log.t, q=log.q, wrench=log.wrench)
    elif ending == "csv":
        np.savetxt(file, table, "%.12g", ",", header=",".join(names), comments="")
    else:
        arrow = pytest.importorskip("pyarrow")
        parquet = pytest.importorskip("pyarrow.parquet")
        parquet.write_table(arrow.table(dict(zip(names, table.T, strict=True))), file)
    code, out, err = command("payload", tmp_path / "ur.toml", file, "--sensor", "--into", into)
    assert code == 0, err
    content = json.loads((into / "payload.json").read_text())
    assert content["schema"] == "symgen.payload/1"
    assert abs(content["mass"]["value"] - 1.5) < 4 * content["mass"]["std"]
    assert [len(content["sensor"][key]) for key in ("offset", "drift", "load")] == [6, 6, 10]
    np.testing.assert_allclose(content["sensor"]["load"], TOOL.standard, atol=2e-3)
    html = (into / "report.html").read_text("utf-8")
    for shown in (out, Page(html).text):
        assert "wnz" in shown
        assert "frame of wrist" in shown
    code, again, _ = command("report", into, "--into", tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text("utf-8") == html
    assert again.splitlines()[:-1] == out.splitlines()[:-1]
