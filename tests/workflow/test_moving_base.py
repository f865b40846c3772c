"""A robot on a base that moves: identify, predict and diagnose from logs with its IMU."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.data.log import make_log
from symgen.identification.parameters import base_values
from symgen.report.store import load_result
from symgen.robot.toml_io import read_imported

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from oracles.shaken import FIXED, recorded, with_noise

IMU = ("fx", "fy", "fz", "wx", "wy", "wz")


@dataclass(frozen=True)
class Case:
    """The arm on a base at rest and on one that moves, with two logs each, and estimates."""

    fixed: symgen.Robot
    moving: symgen.Robot
    logs: tuple[symgen.Log, symgen.Log]
    estimates: tuple[symgen.Estimate, symgen.Estimate]


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    file = tmp_path_factory.mktemp("arm") / "arm.xml"
    file.write_text(FIXED)
    fixed = symgen.read_robot(file)
    moving = replace(fixed, base="imu")
    at_rest, shaken = (
        [make_log(f"log {k}", **recorded(k, moves=moves)) for k in (1, 2)]
        for moves in (False, True)
    )
    estimates = [
        symgen.identify(robot, train, validation=held, model="torque")
        for robot, (train, held) in ((fixed, at_rest), (moving, shaken))
    ]
    return Case(fixed, moving, (shaken[0], shaken[1]), (estimates[0], estimates[1]))


def table(log: symgen.Log) -> tuple[list[str], np.ndarray]:
    """The columns of a CSV of a log."""
    heads = [f"{role}{j}" for role in ("q", "qd", "tau") for j in range(1, 5)]
    return ["t", *heads, *IMU], np.column_stack([log.t, log.q, log.qd, log.tau, log.imu])


def test_a_shaken_arm_is_predicted_as_well_as_one_at_rest(case: Case) -> None:
    at_rest, shaken = (e.torque_validation for e in case.estimates)
    assert shaken.relative < 1.1 * at_rest.relative
    assert case.estimates[1].verdict == "trusted"


def test_links_regain_parameters(case: Case) -> None:
    names = [[p.name for p in e.parameters] for e in case.estimates]
    assert len(names[1]) == 8 * 4 + 8 > len(names[0])  # and friction
    assert {"XX1R", "IA1", "MX1", "MY1R"} <= set(names[1]) - set(names[0])


def test_parameters_are_those_of_the_file(case: Case) -> None:
    estimate = case.estimates[1]
    value = {p.name: p for p in estimate.parameters}
    for j, friction in enumerate((0.4, 0.5, 0.3, 0.1), 1):
        p = value[f"FV{j}"]
        assert abs(p.value - friction) < 5 * p.std


def test_a_csv_and_an_npz_hold_the_motion_of_the_base(case: Case, tmp_path: Path) -> None:
    log = case.logs[0]
    heads, rows = table(log)
    np.savetxt(tmp_path / "a.csv", rows, "%.17g", ",", header=",".join(heads), comments="")
    arrays = {key: getattr(log, key) for key in ("t", "q", "qd", "tau", "imu")}
    np.savez(tmp_path / "a.npz", **arrays)
    for name in ("a.csv", "a.npz"):
        found = symgen.read_log(tmp_path / name, 4)
        np.testing.assert_array_equal(found.imu, log.imu)
    rows[7, -1] = np.nan
    np.savetxt(tmp_path / "b.csv", rows, "%.17g", ",", header=",".join(heads), comments="")
    with pytest.raises(symgen.SymgenError, match=r"wz.+sample 7"):
        symgen.read_log(tmp_path / "b.csv", 4)


def test_without_the_motion_of_the_base_the_message_names_its_columns(case: Case) -> None:
    with pytest.raises(symgen.SymgenError, match=r"motion of the base.+fx, fy, fz, wx, wy, wz"):
        symgen.identify(case.moving, replace(case.logs[0], imu=None))


def test_a_specific_force_in_other_units_is_refused(case: Case) -> None:
    log = case.logs[0]
    in_g = log.imu / np.repeat([9.81, 1.0], 3)
    with pytest.raises(symgen.SymgenError, match=r"specific force.+m/s2, gravity included"):
        symgen.identify(case.moving, replace(log, imu=in_g))


@pytest.mark.parametrize("model", ["energy", "momentum"])
def test_models_without_accelerations_are_refused(case: Case, model: str) -> None:
    with pytest.raises(symgen.SymgenError, match=rf"model {model}.+IMU.+model torque"):
        symgen.identify(case.moving, case.logs[0], model=model)


def test_predict_takes_the_motion_of_the_base(case: Case, tmp_path: Path) -> None:
    estimate = case.estimates[1]
    symgen.write(estimate, tmp_path / "id")
    found = symgen.predict(case.moving, case.logs[1], tmp_path / "id")
    # The offsets of the IMU are those of slightly different parameters.
    assert found.error.relative == pytest.approx(estimate.torque_validation.relative, rel=1e-3)
    symgen.write(found, tmp_path / "predicted")
    assert load_result(tmp_path / "predicted").error == found.error


def test_what_has_a_base_at_rest_is_refused(case: Case, tmp_path: Path) -> None:
    symgen.write(case.estimates[1], tmp_path / "id")
    with pytest.raises(symgen.SymgenError, match="'imu' has no place in a simulation"):
        symgen.simulate(case.moving, tmp_path / "id")


@pytest.mark.slow
def test_diagnose_names_a_spring_on_a_shaken_arm(case: Case) -> None:
    logs = []
    for log in case.logs:
        spring = np.zeros_like(log.tau)
        spring[:, 1] = 8.0 * (log.q[:, 1] - 0.3)
        logs.append(replace(log, tau=log.tau + spring))
    found = symgen.diagnose(case.moving, logs[:1], validation=logs[1:])
    (effect,) = (e for e in found.effects if e.adopted)
    assert (effect.name, effect.joints) == ("gravity_spring", (2,))
    assert effect.parameters[0].value == pytest.approx(8.0, rel=0.02)


@pytest.mark.slow
def test_excite_plans_for_the_base_at_rest(case: Case) -> None:
    limits = symgen.Limits(position=((-1.5, 1.5),) * 4, velocity=(2.0,) * 4)
    plan = symgen.excite(case.moving, limits=limits, search=symgen.Search(searches=1, iterations=5))
    assert [*plan.std] == [p.name for p in case.estimates[0].parameters]


@pytest.mark.slow
def test_intervals_contain_the_parameters_of_the_file(tmp_path: Path) -> None:
    """95 % intervals of 30 noisy logs of an arm without dry friction."""
    (tmp_path / "arm.xml").write_text(FIXED)
    imported = read_imported(tmp_path / "arm.xml")
    joints = [replace(j, friction=("viscous",)) for j in imported.robot.joints]
    robot = replace(imported.robot, base="imu", joints=tuple(joints))
    model = symgen.derive(robot, ("torque_regressor", "inverse_dynamics"))
    given = {name: value for name, value in imported.parameters if not name.startswith("FS")}
    X = base_values(given, model, "arm.xml")
    clean = recorded(1, moves=True, dry=False, noisy=False)
    inside = []
    for k in range(30):
        log = make_log("log", **with_noise(clean, np.random.default_rng(k)))
        found = symgen.identify(robot, log, model="torque", method="wls").parameters
        off = [abs(p.value - x) / p.std for p, x in zip(found, X, strict=True)]
        inside.append(np.array(off) < 1.96)
    assert 0.93 < np.mean(inside) < 0.97
