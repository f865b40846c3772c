"""diagnose on floating bases: what it adopts, what it promises, and what it refuses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support import parsed

import symgen
from symgen.report.store import load_result

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.legged import Motion, base_waves, table, text_of, times
from oracles.shaken import waves
from workflow.test_floating_logs import (
    FRAMES,
    IMU,
    columns,
    flown,
    log_of,
    noisy,
    off_imu,
    walk,
    walker,
)
from workflow.test_floating_search import (
    LATE,
    Fault,
    delayed,
    logs,
    rubbed,
    sprung,
    turned,
)
from workflow.test_promise import DIGITS, Run, attempt, commands_in

CUTOFF = 14.0


@cache
def diagnosed(name: str, fault: Fault) -> tuple[symgen.Log, symgen.Diagnosis]:
    case, log = logs()[name]
    log = replace(log, tau=fault(log))
    return log, symgen.diagnose(case.robot, log, cutoff=CUTOFF)


def as_recorded(log: symgen.Log) -> np.ndarray:
    """Nothing is wrong."""
    return log.tau


def adopted(diagnosis: symgen.Diagnosis) -> list[tuple[str, tuple[int, ...]]]:
    return [(e.name, e.joints) for e in diagnosis.effects if e.adopted]


def require_promise(log: symgen.Log, diagnosis: symgen.Diagnosis) -> None:
    """The written robot file has the promised error on the same logs, in all of its numbers."""
    estimate = symgen.identify(diagnosis.extended, log, cutoff=CUTOFF)
    assert estimate.verdict == "trusted"
    error, gap = estimate.moving, diagnosis.moving.after
    assert gap.total == pytest.approx(error.relative, rel=1e-9)
    assert gap.total == max(gap.base_force, gap.base_moment, gap.joints)
    for key in ("per_joint", "base_force", "base_moment", "joints"):
        assert getattr(gap, key) == pytest.approx(getattr(error, key), rel=1e-9)


@pytest.fixture(scope="module")
def clean() -> symgen.Diagnosis:
    return diagnosed("walk", as_recorded)[1]


def test_nothing_is_named_on_a_clean_log(clean) -> None:
    assert clean.verdict == "consistent"
    assert clean.effects == ()
    assert clean.where == ()


ADOPTED = [
    ("walk", sprung, ("gravity_spring", (2,)), "K2", 3.0),
    ("walk", rubbed, ("coulomb_friction", (2,)), "FS2", 0.6),
    ("hidden", sprung, ("gravity_spring", (2,)), "K2", 3.0),
    ("hidden", rubbed, ("coulomb_friction", (2,)), "FS2", 0.6),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fault", "effect", "key", "value"), ADOPTED)
def test_a_missing_effect_is_adopted_with_its_value(name, fault, effect, key, value) -> None:
    log, diagnosis = diagnosed(name, fault)
    assert adopted(diagnosis) == [effect]
    assert diagnosis.verdict == "explained"
    assert diagnosis.gaps.after.total < 0.6 * diagnosis.gaps.before.total
    (found,) = (p for p in diagnosis.effects[0].parameters if p.name == key)
    assert abs(found.value - value) < 4 * found.std
    assert any("is not simulated" in note for note in diagnosis.notes)
    require_promise(log, diagnosis)


@pytest.mark.slow
def test_a_turned_torque_is_a_gain_of_the_written_file() -> None:
    log, diagnosis = diagnosed("walk", turned)
    assert adopted(diagnosis) == [("wrong_sign", (2,))]
    assert diagnosis.extended.drive.gain == (1.0, -1.0, 1.0, 1.0)
    require_promise(log, diagnosis)


@pytest.mark.slow
def test_a_late_torque_is_a_repair() -> None:
    log, diagnosis = diagnosed("walk", delayed)
    assert diagnosis.verdict == "consistent"
    assert adopted(diagnosis) == []
    (repair,) = diagnosis.repairs
    assert (repair.kind, repair.done) == ("delay", "shifted")
    assert repair.value == pytest.approx(LATE * 0.004, rel=0.03)
    require_promise(log, diagnosis)


@pytest.mark.slow
def test_nothing_is_named_on_a_clean_log_with_hidden_forces() -> None:
    _, diagnosis = diagnosed("hidden", as_recorded)
    assert diagnosis.verdict == "consistent"
    assert adopted(diagnosis) == []


@pytest.mark.slow
def test_offsets_of_an_imu_are_removed_before_the_search() -> None:
    errors = np.array([0.06, -0.05, 0.04, 0.004, -0.005, 0.006])
    log = off_imu(walk(1), errors, 1.5e-3)
    log = replace(log, tau=sprung(log))
    diagnosis = symgen.diagnose(walker().robot, log, cutoff=CUTOFF)
    assert adopted(diagnosis) == [("gravity_spring", (2,))]
    assert [fault.channel for fault in diagnosis.repairs] == ["imu", "imu"]
    require_promise(log, diagnosis)


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    """The commands on files of a walker with a spring."""
    folder = tmp_path_factory.mktemp("sprung")
    (folder / "robot.toml").write_text(text_of(walker().body.arm, FRAMES), "utf-8")
    for seed, name in ((1, "train"), (20, "test")):
        log = walk(seed)
        table = columns(replace(log, tau=sprung(log)))
        head, rows = ",".join(table), np.column_stack([*table.values()])
        np.savetxt(folder / f"{name}.csv", rows, "%.17g", ",", header=head, comments="")
    with commands_in(folder) as call:
        yield attempt(call, folder, ["robot.toml", "train.csv", "--validation", "test.csv"])


@pytest.mark.slow
def test_the_printed_line_delivers_what_is_promised(commands: Run) -> None:
    assert [e["name"] for e in commands.diagnosis["effects"]] == ["gravity_spring"]
    assert commands.said == pytest.approx(commands.delivered, rel=DIGITS)
    assert commands.said["exit"] == 0
    # The offsets of the IMU in the log are those of slightly different parameters.
    assert commands.predicted == pytest.approx(commands.said["after"], rel=DIGITS)
    page = Path("why/report.html").read_text("utf-8")
    assert "base force" in page
    again = load_result("why")
    gap = again.moving.after
    assert gap.total == max(gap.base_force, gap.base_moment, gap.joints)


@pytest.fixture(scope="module")
def flight() -> symgen.Log:
    case, t = walker(), times(16.0)
    q = waves(t, np.full(4, 0.8), 1.5, np.random.default_rng(5))
    motion = Motion(t, *base_waves(t, 5, 0.0), q)
    imu, tau = flown(case.body, motion)
    return log_of(motion, tau, 5, imu=noisy(9, imu, IMU))


def test_flights_are_refused(flight) -> None:
    with pytest.raises(symgen.LogError, match=r"flights.+accepted: symgen identify, or logs with"):
        symgen.diagnose(walker().robot, flight, cutoff=CUTOFF)


def test_a_robot_without_joints_is_refused(tmp_path: Path) -> None:
    hull = '[[frame]]\nname = "hull"\njoint = 0\n'
    robot = parsed(f'[robot]\nname = "drone"\nbase = "floating"\n{hull}')
    t = times(16.0)
    motion = Motion(t, *base_waves(t, 3), np.zeros((3, len(t), 0)))
    f, w, wd = motion.base
    heads = "t,fx,fy,fz,wx,wy,wz,hull.fx,hull.fy,hull.fz,hull.nx,hull.ny,hull.nz"
    rows = np.column_stack([t, f, w, noisy(1, f, 0.05), noisy(2, wd, 0.005)])
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header=heads, comments="")
    with pytest.raises(symgen.LogError, match=r"a robot without joints; accepted"):
        symgen.diagnose(robot, tmp_path / "a.csv", cutoff=CUTOFF)


def test_fixed_parameters_are_refused() -> None:
    robot = parsed(text_of(table(2, 2), FRAMES))
    with pytest.raises(symgen.RobotError, match=r"--parameters.+floating base; accepted: symgen d"):
        symgen.diagnose(robot, "a.csv", parameters="identified")
