"""`diagnose` on channels that look like something else: signs, pairs of joints, ends of a tree.

The logs are closed forms, or the sound log of tests/logs with changed channels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles.arm import HANGING, IN_PLANE, Arm, sines
from oracles.planar2r import robot_toml
from stored_logs import made, stored

import symgen

Named = list[tuple[str, tuple[int, ...]]]


def adopted(found: symgen.Diagnosis) -> Named:
    return [(e.name, e.joints) for e in found.effects if e.adopted]


def values(found: symgen.Diagnosis) -> dict[str, float]:
    return {p.name: p.value for e in found.effects for p in e.parameters}


def planar(name: str, seed: int, arm: Arm = HANGING, sinks: float = 0.0) -> symgen.Log:
    """A log of the arm in a vertical plane, whose first joint sinks by an angle during the log."""
    rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    waves = sines(t, [[0.8, 0.6], [0.3, 0.4]], [[1.1, 1.7], [2.9, 4.3]], rng.uniform(0, 6, (2, 2)))
    q, qd, qdd = (x.copy() for x in waves)
    q[:, 0] -= sinks * t / t[-1]
    qd[:, 0] -= sinks / t[-1]
    t, q, tau, qd = arm.recorded(t, (q, qd, qdd), rng)
    return symgen.make_log(name, t, q, tau, qd)


PLANAR = symgen.parse_robot(robot_toml("arm", gravity=IN_PLANE))


def test_a_sign_is_told_from_the_energy_of_the_links() -> None:
    """The arm sinks, so its weight takes more work from the motors than friction costs."""
    smooth = replace(HANGING, FS=0.2 * HANGING.FS, FV=0.2 * HANGING.FV)
    logs = [planar(name, k, smooth, sinks=1.5) for k, name in enumerate(("train", "test"))]
    turned = [replace(x, tau=x.tau * [-1.0, 1.0]) for x in logs]
    found = symgen.diagnose(PLANAR, turned[0], validation=turned[1])
    assert adopted(found) == [("wrong_sign", (1,))]


def test_a_balancer_with_linkage_is_named_with_its_constants() -> None:
    k_ab, length, e, phi = 11.2, 0.52, 0.74, -1.67

    def balanced(log: symgen.Log) -> symgen.Log:
        """The spring hangs between points with a ratio e of their distances, in line at phi."""
        s = log.q[:, 1]
        pull = k_ab * np.sin(s) * (1 - length / np.sqrt(1 - e * np.cos(s)))
        tau = log.tau + np.column_stack([0 * s, pull])
        return replace(log, q=log.q + [0.0, phi], tau=tau)

    # The second link is turned by phi in its frame, which only moves its first moments.
    logs = [balanced(planar(name, k)) for k, name in enumerate(("train", "test"))]
    found = symgen.diagnose(PLANAR, logs[0], validation=logs[1])
    assert adopted(found) == [("balancer", (2,))]
    at = values(found)
    assert at["KB2"] == pytest.approx(k_ab, rel=0.05)
    assert at["KL2"] == pytest.approx(k_ab * length, rel=0.05)
    assert at["e2"] == pytest.approx(e, abs=0.02)
    assert at["phi2"] == pytest.approx(phi, abs=0.02)
    again = symgen.parse_robot(symgen.robot_toml(found.extended))
    assert [x.name for x in again.effects] == ["balancer"]


def test_the_ratio_of_two_coupled_joints_is_found() -> None:
    log = stored("sound")

    def coupled(name: str, x: dict[str, np.ndarray]) -> symgen.Log:
        u = x["qd"][:, 1] - 0.5 * x["qd"][:, 2]
        F = 2.0 * u + 3.0 * np.tanh(u / 0.01)
        return made(name, x | {"tau": x["tau"] + np.column_stack([0 * F, F, -0.5 * F])})

    found = symgen.diagnose(
        log.robot, coupled("train", log.train), validation=coupled("test", log.test)
    )
    assert adopted(found) == [("coupled_transmission", (2, 3))]
    assert values(found)["ratio3"] == pytest.approx(-0.5, abs=0.05)


@pytest.mark.parametrize(
    ("factor", "tried", "std"),
    [(0.7, ["drive_gain_error"], None), (-1.0, None, (0.01, 0.01))],
)
def test_a_corrected_gain_loses_the_deviation_of_the_old_one(factor, tried, std) -> None:
    drive = "ratio = [1, 1]\ngain = [1.1, 1.2]\ngain_std = [0.01, 0.01]"
    text = robot_toml("arm", gravity=IN_PLANE)
    robot = symgen.parse_robot(f"{text}\n[drive]\n{drive}\n")
    logs = (planar(name, k, sinks=1.5) for k, name in enumerate(("train", "test")))
    train, test = (replace(x, tau=x.tau * [1 / 1.1, factor / 1.2]) for x in logs)
    found = symgen.diagnose(robot, train, validation=test, effects=tried).extended.drive
    assert found is not None
    assert found.gain == pytest.approx((1.1, 1.2 / factor), rel=0.05)
    assert found.gain_std == std


@pytest.mark.parametrize(
    ("order", "factor", "option", "typed"),
    [
        ([1, 0], 1.0, "columns", "tau1=tau2,tau2=tau1"),
        ([0, 1], 1e3, "unit", "tau1=mNm"),
    ],
)
def test_the_advice_has_the_option_that_corrects_the_columns(
    tmp_path, order, factor, option, typed
) -> None:
    files = []
    for k, name in enumerate(("train", "test")):
        log = planar(name, k, sinks=1.5)
        tau = log.tau[:, order] * [factor, 1.0]
        table = np.column_stack([log.t, log.q, log.qd, tau])
        files.append(tmp_path / f"{name}.csv")
        head = "t,q1,q2,qd1,qd2,tau1,tau2"
        np.savetxt(files[-1], table, "%.9g", ",", header=head, comments="")
    tried = symgen.diagnose(PLANAR, files[0], validation=files[1])
    printed = [line.partition(f"--{option} ")[2] for line in tried.advice]
    assert typed in printed
    pairs = dict(pair.split("=") for pair in typed.split(","))
    reading = symgen.Reading(**{option: pairs})
    found = symgen.identify(PLANAR, files[0], validation=files[1], reading=reading)
    assert found.verdict == "trusted"


TREE = """[robot]
name = "pendulums"
gravity = [0.0, -9.81, 0.0]
[[joint]]
rotor_inertia = false
[[joint]]
antecedent = 0
rotor_inertia = false
"""


def pendulums(name: str, seed: int, load: float = 0.0) -> symgen.Log:
    """Two pendulums; a load, kg, is a point 0.4 m out on the first one."""
    rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    q, qd, qdd = sines(
        t, [[0.8, 0.6], [0.3, 0.4]], [[1.1, 1.7], [2.9, 4.3]], rng.uniform(0, 6, (2, 2))
    )
    inertia = np.array([0.5 + 0.16 * load, 0.4])
    moment = np.array([1.2 + 0.4 * load, 1.0])
    tau = inertia * qdd + 9.81 * moment * np.cos(q) + 0.3 * np.sign(qd) + 0.2 * qd
    tau += 0.01 * tau.std(axis=0) * rng.normal(size=q.shape)
    return symgen.make_log(name, t, q + 1e-5 * rng.normal(size=q.shape), tau, qd)


def test_a_load_on_any_end_of_a_tree_is_found(tmp_path) -> None:
    robot = symgen.parse_robot(TREE)
    empty = symgen.identify(robot, pendulums("empty", 1), model="torque")
    symgen.write(empty, tmp_path / "empty")
    found = symgen.diagnose(robot, pendulums("loaded", 2, 0.8), parameters=tmp_path / "empty")
    assert adopted(found) == [("payload", (1,))]
    assert values(found)["MXL"] == pytest.approx(0.32, rel=0.05)


def six_joints(change) -> tuple[symgen.Robot, list[symgen.Log]]:
    """An arm of six joints by Pinocchio, and two logs with changed channels."""
    pytest.importorskip("pinocchio")
    from oracles.hidden import machines
    from oracles.hidden.motion import reference
    from oracles.hidden.simulate import inverse

    machine, logs = machines.MACHINES["arm6r"], []
    for seed, kind in enumerate(("train", "validation")):
        motion = reference(machine, kind, seed)
        tau, rng = inverse(machine, motion)[::10], np.random.default_rng(seed)
        tau = tau + 0.01 * tau.std(axis=0) * rng.normal(size=tau.shape)
        x = {"q": motion.q[::10], "qd": motion.qd[::10], "tau": tau}
        x["q"] = x["q"] + 1e-5 * rng.normal(size=tau.shape)
        logs.append(made(kind, {"t": motion.t[::10]} | change(x)))
    return symgen.parse_robot(machine.robot_toml()), logs


@pytest.mark.slow
def test_exchanged_joints_of_a_wrist_are_named() -> None:
    """All three joints of the wrist have large errors then."""
    robot, logs = six_joints(lambda x: {k: v[:, [0, 1, 2, 5, 4, 3]] for k, v in x.items()})
    found = symgen.diagnose(robot, logs[0], validation=logs[1])
    assert adopted(found) == [("exchanged_channels", (4, 6))]


@pytest.mark.slow
def test_two_torques_in_another_unit_are_named_together() -> None:
    factors = np.array([1.0, 1e3, 1.0, 1.0, 1e3, 1.0])
    robot, logs = six_joints(lambda x: x | {"tau": x["tau"] * factors})
    found = symgen.diagnose(robot, logs[0], validation=logs[1])
    assert adopted(found) == [("wrong_unit", (2, 5))]
    assert {p.value for e in found.effects for p in e.parameters} == {1000.0}
    assert any(line.endswith("--unit tau2=mNm,tau5=mNm") for line in found.advice)
