"""payload: a load that Pinocchio's arm carries, with friction and noise, by every way to it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from browser import Page
from support import sampled

import symgen
from symgen.identification.load_result import LABELS, read_payload
from symgen.report.terminal import print_result
from symgen.robot.tables import Drive

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")

N, STEP = 6, 0.005
TABLE = {
    "sigma": [0] * N,
    "alpha": [0, -math.pi / 2, 0, -math.pi / 2, math.pi / 2, -math.pi / 2],
    "d": [0, 0, 0.43, 0, 0, 0],
    "r": [0, 0.2, 0, 0.43, 0, 0],
}
MASS, COM = 2.5, np.array([0.03, -0.02, 0.11])
INERTIA = np.array([[0.012, 0.001, -0.0005], [0.001, 0.010, 0.0008], [-0.0005, 0.0008, 0.006]])
TRUE = np.array([MASS, *COM, *INERTIA[np.triu_indices(3)]])
NOISE = np.array([0.4, 0.4, 0.3, 0.1, 0.1, 0.08])  # N m
FS, FV = np.array([4, 5, 3, 1, 0.8, 0.6]), np.array([6, 7, 4, 1.5, 1.2, 0.9])


def standard(mass: float, com: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """XX XY XZ YY YZ ZZ MX MY MZ M about the origin."""
    about = inertia + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return np.array([*about[np.triu_indices(3)], *(mass * com), mass])


LINKS = np.array(
    [
        standard(m, np.array(c), np.diag(i))
        for m, c, i in (
            (12, (0, 0, -0.1), (0.2, 0.2, 0.1)),
            (10, (0.2, 0, 0.05), (0.05, 0.25, 0.25)),
            (6, (0.02, -0.05, 0), (0.06, 0.03, 0.06)),
            (3, (0, 0.01, -0.05), (0.015, 0.012, 0.008)),
            (1.5, (0, -0.02, 0), (0.003, 0.003, 0.002)),
            (0.6, (0.002, 0, 0.03), (0.0006, 0.0006, 0.0004)),
        )
    ]
)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    from oracles.random_arms import to_toml
    from oracles.transforms import Arm

    path = tmp_path_factory.mktemp("payload") / "robot.toml"
    text = to_toml(Arm.from_table(TABLE), "arm", ("coulomb", "viscous"), False)
    path.write_text(text)
    return path


@cache
def moved(motion: int, carries: bool, seconds: float, link: int = N, pace: float = 1.0):
    """Stamps, true motion (a sum of sines) and torque of links and rotors without friction."""
    from oracles.pinocchio_arm import PinocchioArm
    from oracles.transforms import Arm

    links = LINKS.copy()
    links[link - 1] += carries * standard(MASS, COM, INERTIA)
    arm = PinocchioArm(Arm.from_table(TABLE), links)
    t = np.arange(0, seconds, STEP)
    own = np.random.default_rng(100 + motion)
    w = 2 * np.pi * pace * own.uniform(0.1, 0.9, (4, N))
    phase, size = own.uniform(0, 6, (4, N)), own.uniform(0.15, 0.5, (4, N))
    q = np.array([np.sum(size * np.sin(w * s + phase), axis=0) for s in t])
    qd = np.array([np.sum(size * w * np.cos(w * s + phase), axis=0) for s in t])
    qdd = np.array([np.sum(-size * w**2 * np.sin(w * s + phase), axis=0) for s in t])
    return t, q, qd, np.array([arm.inverse_dynamics(*x) for x in zip(q, qd, qdd, strict=True)])


def recorded(seed: int, carries: bool, motion: int = 0, seconds: float = 16.0, link: int = N,
             share: float = 0.0, pace: float = 1.0):  # fmt: skip
    """A log of the arm: q with the noise of encoders, torque with friction and its own noise.

    With a share, friction of that share of the torque of links acts on joints 2 and 3 as well.
    """
    t, q, qd, tau = moved(motion, carries, seconds, link, pace)
    rng = np.random.default_rng(seed)
    tau = tau + share * np.array([0, 1, 1, 0, 0, 0]) * np.abs(tau) * np.sign(qd)
    q = q + 1e-5 * rng.standard_normal(q.shape)
    tau = tau + FS * np.sign(qd) + FV * qd + NOISE * rng.standard_normal(tau.shape)
    return symgen.make_log(f"log {seed}", t, q, tau)


def quantities(found) -> tuple[np.ndarray, np.ndarray]:
    pairs = [(q.value, q.std) for _, q, _ in found.rows()]
    return np.array([v for v, _ in pairs]), np.array([s for _, s in pairs])


@pytest.fixture(scope="module")
def parameters(robot):
    """An estimate.json of the arm alone, from two other motions."""
    estimate = symgen.identify(
        robot, [recorded(1, False, 1), recorded(2, False, 2)], model="torque"
    )
    path = robot.with_name("estimate.json")
    path.write_text(json.dumps(estimate.to_json()))
    return path


WAYS = {
    "against parameters": lambda p: {"parameters": p},
    "beside logs without it": lambda _: {"without": [recorded(11, False)]},
    "beside logs of other motions": lambda _: {"without": [recorded(12, False, 3)]},
    "with a known mass": lambda p: {"parameters": p, "mass": MASS},
}


@pytest.mark.parametrize("way", sampled(WAYS, 0, always=["against parameters"]))
def test_a_simulated_load_is_found(robot, parameters, way) -> None:
    found = symgen.payload(robot, recorded(21, True), **WAYS[way](parameters))
    values, std = quantities(found)
    assert abs(values[0] / MASS - 1) < 0.015
    assert np.abs(values[1:4] - COM).max() < 0.005
    assert (np.abs(values - TRUE) <= 4 * std + 1e-12).all(), (values - TRUE) / std
    assert std[0] < 0.02 * MASS
    assert found.identifiable == LABELS
    assert found.frame == N
    assert found.residual.after < 0.5 * found.residual.before
    assert np.linalg.eigvalsh(_pseudo(values))[0] > 0


LATE = 3  # samples


def late(log: symgen.Log) -> symgen.Log:
    """The log of a recorder whose torques are late."""
    return symgen.make_log(log.name, log.t[:-LATE], log.q[LATE:], log.tau[:-LATE])


def test_a_delay_of_the_estimate_is_undone(robot, parameters, tmp_path) -> None:
    """The estimate says that its recorder was late; the load's may be on time."""
    content = json.loads(parameters.read_text())
    delay = {"log": "all logs", "channel": "tau", "fault": "late", "samples": 1, "done": "shifted"}
    content["repairs"] += [delay | {"values": [["DT", LATE * STEP, None]], "kind": "delay"}]
    recorder = tmp_path / "estimate.json"
    recorder.write_text(json.dumps(content))
    on_time = recorded(21, True, seconds=8.0)
    for log, shifts in ((late(on_time), 1), (on_time, 0)):
        found = symgen.payload(robot, log, parameters=recorder)
        values, std = quantities(found)
        assert [r.kind for r in found.repairs].count("delay") == shifts
        assert (np.abs(values - TRUE) <= 4 * std + 1e-12).all(), (values - TRUE) / std
        assert found.residual.after < 1.05 * found.residual.noise_floor


def test_an_inertia_that_is_not_determined_has_no_value(
    robot, parameters, tmp_path, capsys
) -> None:
    found = symgen.payload(robot, recorded(21, True, pace=0.12), parameters=parameters)
    assert found.identifiable == LABELS[:4]
    symgen.write(found, tmp_path / "load")
    written = json.loads((tmp_path / "load/payload.json").read_text())
    assert written["inertia"] == 6 * [{"value": None, "std": None}]
    assert abs(written["mass"]["value"] / MASS - 1) < 0.015
    assert read_payload(tmp_path / "load").inertia == found.inertia
    print_result(found)
    page = Page((tmp_path / "load/report.html").read_text("utf-8"))
    for shown in (page.text, capsys.readouterr().out):
        assert shown.count("not determined") == 6


LOAD_FRICTION = """
[[effect]]
name = "load_dependent_friction"
joints = [2, 3]
"""


@pytest.mark.parametrize("beside", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_load_on_an_arm_whose_friction_grows_with_it(robot, tmp_path, beside: bool) -> None:
    (tmp_path / "robot.toml").write_text(robot.read_text() + LOAD_FRICTION)
    arm = symgen.read_robot(tmp_path / "robot.toml")
    known: dict[str, object] = {"without": [recorded(72, False, share=0.1)]}
    if not beside:
        logs = [recorded(k, False, k, share=0.1) for k in (1, 2)]
        symgen.write(symgen.identify(arm, logs), tmp_path / "result")
        known = {"parameters": tmp_path / "result"}
    found = symgen.payload(arm, recorded(71, True, share=0.1), **known)
    values, std = quantities(found)
    assert (np.abs(values - TRUE) <= 4 * std + 1e-12).all(), (values - TRUE) / std
    assert abs(values[0] / MASS - 1) < 0.015
    assert found.residual.after < 1.1 * found.residual.noise_floor


def test_a_load_is_given_in_a_frame_of_its_link(robot, parameters, tmp_path, capsys) -> None:
    tool = symgen.Frame("tool0", N, (0.05, -0.02, 0.1), (0.3, -0.5, 1.1))
    other = symgen.Frame("elbow", 3)
    framed = replace(symgen.read_robot(robot), frames=(tool, other))
    log, asked = recorded(24, True), {"parameters": parameters}
    own, found = (symgen.payload(framed, log, frame=f, **asked) for f in ("", "tool0"))
    T = np.array(tool.transform)
    R, at = T[:3, :3], T[:3, 3]
    (values, _), (there, std) = quantities(own), quantities(found)
    np.testing.assert_allclose(there[1:4], R.T @ (values[1:4] - at), rtol=1e-9, atol=1e-12)
    J = np.zeros((3, 3))
    J[np.triu_indices(3)] = values[4:]
    J = R.T @ (J + np.triu(J, 1).T) @ R
    np.testing.assert_allclose(there[4:], J[np.triu_indices(3)], rtol=1e-8, atol=1e-12)
    true = np.array([*(R.T @ (COM - at)), *(R.T @ INERTIA @ R)[np.triu_indices(3)]])
    assert (np.abs(there[1:] - true) < 4 * std[1:]).all()
    content = found.to_json()
    assert (content["frame"], content["joint"], own.to_json()["frame"]) == ("tool0", N, N)
    symgen.write(found, tmp_path / "load")
    assert read_payload(tmp_path / "load").frame == "tool0"
    print_result(found)
    for shown in ((tmp_path / "load/report.html").read_text(), capsys.readouterr().out):
        assert "cx, cy and cz are in the frame of tool0." in shown
    for name, says in (("flange", "no frame 'flange'; accepted: tool0, elbow"),
                       ("elbow", "on the link of joint 3")):  # fmt: skip
        with pytest.raises(symgen.RobotError, match=says):
            symgen.payload(framed, log, frame=name, **asked)


def _pseudo(values: np.ndarray) -> np.ndarray:
    """Density-weighted second moments of a load about its centre: positive of what exists."""
    xx, xy, xz, yy, yz, zz = values[4:]
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return np.trace(J) / 2 * np.eye(3) - J


def test_friction_that_changed_since_has_no_say(robot, parameters, monkeypatch) -> None:
    before = symgen.payload(robot, recorded(22, True), parameters=parameters)
    monkeypatch.setitem(globals(), "FS", 1.3 * FS)
    found = symgen.payload(robot, recorded(22, True), parameters=parameters)
    assert abs(found.mass.value / MASS - 1) < 0.015
    assert found.residual.after < 1.05 * before.residual.after


@pytest.mark.slow
def test_what_the_motion_does_not_show_has_no_value() -> None:
    """A planar arm across gravity's axis sees mass and centre in its plane, and not beside it."""
    robot = symgen.read_robot("planar2r")
    t = np.arange(0, 12, 0.01)
    q = np.stack([np.sin(1.3 * t) + 0.4 * np.sin(3 * t), np.cos(1.9 * t)], 1)
    qd = np.stack([1.3 * np.cos(1.3 * t) + 1.2 * np.cos(3 * t), -1.9 * np.sin(1.9 * t)], 1)
    qdd = np.stack([-1.69 * np.sin(1.3 * t) - 3.6 * np.sin(3 * t), -3.61 * np.cos(1.9 * t)], 1)
    inverse = symgen.load(symgen.derive(robot, ("inverse_dynamics",)))["inverse_dynamics"]
    X = np.array([3.5, 0.06, 0.124, 0.006])
    # A point mass of 2 kg at (0.3, 0) of link 2: ZZ2 grows by 0.18, MX2 by 0.6, ZZ1R by 2 L1^2.
    loaded = X + np.array([0.5, 0.18, 0.6, 0.0])
    noise = 0.01 * np.random.default_rng(5).standard_normal((2, *q.shape))
    alone = symgen.make_log("alone", t, q, inverse(q, qd, qdd, X) + noise[0], qd)
    carried = symgen.make_log("carried", t, q, inverse(q, qd, qdd, loaded) + noise[1], qd)
    found = symgen.payload(robot, carried, without=alone)
    assert set(found.identifiable) == {"mass", "cx", "cy"}  # ZZ of a point mass is noise
    assert abs(found.mass.value - 2.0) < 0.03
    assert abs(found.com[0].value - 0.3) < 0.005
    assert found.com[2].value is None
    assert found.inertia[0].value is None


def test_the_command_writes_the_contract(robot, parameters, tmp_path, command) -> None:
    path = tmp_path / "carried.csv"
    log = recorded(31, True)
    header = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))])
    table = np.column_stack([log.t, log.q, log.tau])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g")
    into = tmp_path / "load"
    asked = ["payload", robot, path, "--parameters", parameters, "--gain", 2, "--into", into]
    code, out, err = command(*asked)
    assert code == 0, err
    assert "mass" in out
    content = json.loads((into / "payload.json").read_text())
    assert content["schema"] == "symgen.payload/1"
    assert set(content["mass"]) == {"value", "std"}
    assert abs(content["mass"]["value"] / MASS - 1) < 0.015
    assert content["mass"]["std"] > 0.02 * MASS
    assert [len(content[key]) for key in ("com", "inertia")] == [3, 6]
    assert content["frame"] == N
    assert content["gain_uncertainty_percent"] == 2
    assert content["residual"]["after"] < content["residual"]["before"]
    html = (into / "report.html").read_text("utf-8")
    page = Page(html)
    assert "Payload of arm" in page.text
    assert len(page.figures) == 1
    assert not any("src" in attrs for _, attrs in page.tags)
    again = tmp_path / "again.html"
    code, reported, _ = command("report", into, "--into", again)
    assert code == 0
    assert again.read_text("utf-8") == html
    assert reported.splitlines()[:-1] == out.splitlines()[:-1]  # but for what was written
    del content["inertia"][0]
    (into / "payload.json").write_text(json.dumps(content))
    code, _, err = command("report", into)
    assert code == 2
    assert "damaged" in err


REFUSED = {
    "neither": ({}, "--without"),
    "a mass below 0": ({"mass": -1.0, "parameters": "x.toml"}, "--mass -1"),
    "no such parameters": ({"parameters": "nowhere.toml"}, "cannot be read"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_answered_is_refused(robot, case) -> None:
    options, says = REFUSED[case]
    with pytest.raises(symgen.SymgenError) as caught:
        symgen.payload(robot, recorded(41, True, seconds=4.0), **options)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("link", [2, 3])
def test_a_load_on_another_link_is_no_load_of_the_last(robot, parameters, link) -> None:
    with pytest.raises(symgen.IdentificationError, match=r"another link.*\[payload\]"):
        symgen.payload(robot, recorded(51, True, link=link), parameters=parameters)


def test_no_load_is_none(robot, parameters) -> None:
    with pytest.raises(symgen.IdentificationError, match=r"no load on the link of joint 6"):
        symgen.payload(robot, recorded(52, False), parameters=parameters)


GAINS = np.array([1.06, 0.95, 1.02, 0.97, 1.08, 0.94])


def miscalibrated(seed: int, carries: bool, motion: int = 0):
    """A log of drives whose torque is GAINS times what the log makes of it."""
    log = recorded(seed, carries, motion)
    return symgen.make_log(log.name, log.t, log.q, log.tau / GAINS)


def test_gains_of_the_drives_are_part_of_the_intervals(robot) -> None:
    """With the gains of [drive], a load is right that is wrong without them."""
    logs, alone = miscalibrated(63, True, 1), miscalibrated(64, False, 1)
    before = symgen.payload(robot, logs, without=alone)
    source = symgen.read_robot(robot)
    one = tuple(tuple(float(i == j) for j in range(source.n)) for i in range(source.n))
    drive = Drive(one, gain=tuple(GAINS), gain_std=tuple(0.01 * GAINS))
    weighed = symgen.payload(replace(source, drive=drive), logs, without=alone)
    assert abs(weighed.mass.value / MASS - 1) < 0.015
    assert weighed.gain_uncertainty_percent == pytest.approx(1.0)
    assert abs(before.mass.value / MASS - 1) > 2 * abs(weighed.mass.value / MASS - 1)
