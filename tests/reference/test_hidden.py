"""The simulators of hidden effects obey mechanics and hide what they say, where they say."""

from __future__ import annotations

import ast
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.pinocchio_arm import load_pinocchio
from oracles.random_arms import random_parameters
from oracles.transforms import column_names, kinetic_regressor, potential_regressor

try:
    load_pinocchio()
    import mujoco  # noqa: F401
except ImportError as missing:
    pytest.skip(f"needs Pinocchio and MuJoCo: {missing}", allow_module_level=True)

from oracles.hidden.engines import MujocoEngine, PinocchioEngine
from oracles.hidden.machines import MACHINES, Machine
from oracles.hidden.simulate import Run, inverse, simulate
from studies.hidden.cases import Case, case
from studies.hidden.sizes import SMALL, place, rms

ROBOTS = tuple(MACHINES)
MEASURING = ("saturation", "drive_gain_error", "time_delay", "velocity_sensor_error")
pytestmark = pytest.mark.slow


def _short(robot: str, seconds: float = 2.0) -> Machine:
    return replace(MACHINES[robot], seconds=seconds)


def _run(robot: str, effect: str | None = None, engine: str = "pinocchio") -> tuple[Machine, Run]:
    believed = _short(robot)
    machine = place(effect, robot, "moderate", 3).machine(believed) if effect else believed
    return machine, simulate(machine, believed, "train", 3, engine)


def test_simulators_do_not_know_the_package_under_test() -> None:
    tests = Path(__file__).parents[1]
    for path in (*tests.glob("oracles/hidden/*.py"), *tests.glob("studies/hidden/*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "symgen" for name in names), path


@pytest.mark.parametrize("robot", ROBOTS)
def test_both_engines_are_the_same_robot(robot: str) -> None:
    machine, rng = MACHINES[robot], np.random.default_rng(0)
    # Bodies and frames without any symmetry.
    turned = replace(machine.arm, theta=tuple(rng.normal(size=machine.n)), r=(0.1,) * machine.n)
    machine = replace(machine, arm=turned, links=random_parameters(turned, 0)[0])
    q, qd, qdd = rng.normal(size=(3, 20, machine.n))
    ours, theirs = PinocchioEngine(machine), MujocoEngine(machine)
    torque = ours.torque(q, qd, qdd)
    np.testing.assert_allclose(theirs.torque(q, qd, qdd), torque, rtol=0, atol=1e-9)
    for engine in (ours, theirs):
        found = [engine.acceleration(*row) for row in zip(q, qd, torque, strict=True)]
        np.testing.assert_allclose(found, qdd, rtol=0, atol=1e-8)


@pytest.mark.parametrize("robot", ROBOTS)
def test_without_effect_the_torque_is_the_other_engine_s_inverse_dynamics(robot: str) -> None:
    machine, run = _run(robot)
    expected = inverse(machine, run.motion, "mujoco")
    np.testing.assert_allclose(run.tau, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("robot", ROBOTS)
def test_work_of_motors_and_friction_is_the_change_of_energy(robot: str) -> None:
    machine, run = _run(robot)
    motion, names = run.motion, column_names(machine.arm)
    X = np.array([(machine.parameters())[name] for name in names])
    energy = kinetic_regressor(machine.arm, motion.q, motion.qd) @ X
    energy = energy + potential_regressor(machine.arm, motion.q) @ X
    force = run.tau + machine.friction(motion.t, motion.qd)
    power = np.sum(force * motion.qd, axis=1)
    # Simpson's rule over pairs of steps.
    work = np.cumsum(power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) * (motion.t[1] / 3)
    change = energy[2::2] - energy[0]
    assert np.abs(change - work).max() < 1e-5 * np.abs(change).max()


@pytest.mark.parametrize("effect", [None, "coupled_transmission", "joint_elasticity"])
def test_pinocchio_and_mujoco_run_alike(effect: str | None) -> None:
    _, ours = _run("arm3r", effect)
    _, theirs = _run("arm3r", effect, "mujoco")
    for key in ("q", "qd", "qdd"):
        expected = getattr(ours.motion, key)
        np.testing.assert_allclose(getattr(theirs.motion, key), expected, rtol=0, atol=1e-7)
    np.testing.assert_allclose(theirs.tau, ours.tau, rtol=0, atol=1e-7)


@pytest.mark.parametrize("effect", ["coupled_transmission", "load_dependent_friction"])
def test_forward_and_inverse_dynamics_know_the_same_effect(effect: str) -> None:
    machine, run = _run("arm3r", effect)
    np.testing.assert_allclose(inverse(machine, run.motion), run.tau, rtol=0, atol=1e-9)
    assert np.abs(inverse(_short("arm3r"), run.motion) - run.tau).max() > 0.1


def test_two_masses_come_near_the_first_order_in_the_compliance() -> None:
    # Without Coulomb friction, whose steps shake a spring at its own frequency.
    believed = replace(_short("planar2r", 4.0), coulomb=np.zeros(2))
    machine = replace(believed, elastic=(1, 4e3, 20.0))
    run = simulate(machine, believed, "train", 0)
    rigid = run.tau - inverse(believed, run.motion)
    first = inverse(machine, run.motion) - inverse(believed, run.motion)
    late = slice(500, -5)
    assert rms((rigid - first)[late]).max() < 0.3 * rms(rigid[late]).max()
    # At rest the spring already carries the weight: nothing falls when the clock starts.
    assert np.all(rms(rigid[:100]) < 0.05 * rms(run.tau))


@pytest.mark.parametrize("effect", ["gravity_spring", "stribeck_friction"])
def test_an_effect_of_one_joint_is_seen_on_that_joint_alone_and_as_large_as_asked(
    effect: str,
) -> None:
    hidden = case("planar2r", effect, "small", 1)
    ((name, (joint,), _),) = hidden.truth
    shares = rms(hidden.hidden["train"]) / rms(hidden.true["train"]["tau"])
    others = np.delete(shares, joint - 1)
    assert name == effect
    assert shares[joint - 1] == pytest.approx(SMALL, rel=0.1)
    assert others.max() < 1e-12


def test_moderate_means_three_times_the_floor_after_a_fit() -> None:
    hidden = case("planar2r", "load_dependent_friction", "moderate", 1)
    assert np.max(hidden.gap / hidden.floor) > 3
    assert np.all(hidden.gap <= 1.05 * np.max(hidden.missed))


@pytest.mark.parametrize("effect", MEASURING)
def test_errors_of_measurement_change_one_channel_and_no_motion(effect: str) -> None:
    clean, wrong = case("planar2r", None, "moderate", 1), case("planar2r", effect, "moderate", 1)
    for key in ("q", "qd", "qdd", "tau"):
        np.testing.assert_array_equal(wrong.true["train"][key], clean.true["train"][key])
    np.testing.assert_array_equal(wrong.train["q"], clean.train["q"])
    apart = {key: rms(wrong.train[key] - wrong.true["train"][key]) for key in ("qd", "tau")}
    noise = {key: rms(clean.train[key] - clean.true["train"][key]) for key in ("qd", "tau")}
    changed = {key for key in apart if np.max(apart[key] / noise[key]) > 1.5}
    assert changed == {"qd" if effect == "velocity_sensor_error" else "tau"}
    assert wrong.robot_toml == clean.robot_toml


def test_what_is_forgotten_in_the_file_is_what_is_hidden() -> None:
    clean, hidden = case("planar2r", None, "moderate", 1), case("planar2r", "coulomb_friction")
    ((_, (joint,), values),) = hidden.truth
    table = tomllib.loads(hidden.robot_toml)["joint"]
    assert [j for j, row in enumerate(table, 1) if "coulomb" not in row["friction"]] == [joint]
    differing = {k for k, v in hidden.parameters.items() if v != clean.parameters[k]}
    assert differing == {f"FS{joint}"}
    assert hidden.parameters[f"FS{joint}"] == 0.0 < values["FS"]


@pytest.fixture(scope="module")
def clean() -> Case:
    return case("planar2r", None, "moderate", 1)


def test_instruments_have_their_noise(clean: Case) -> None:
    machine = MACHINES["planar2r"]
    for log, true in ((clean.train, clean.true["train"]), (clean.validation,
                                                          clean.true["validation"])):  # fmt: skip
        steps = log["q"] / machine.resolution
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
        assert np.abs(log["q"] - true["q"]).max() <= 0.51 * machine.resolution.max()
        assert rms(log["qd"] - true["qd"]) == pytest.approx(machine.tacho, rel=0.05)
        level = rms(log["tau"] - true["tau"]) / rms(true["tau"])
        assert level == pytest.approx(np.hypot(0.01, 0.003) * np.ones(2), rel=0.05)
    assert np.all((clean.floor > 0.0015) & (clean.floor < 0.006))
    assert np.all(clean.missed < 1e-9)
