"""Energy and momentum of a floating base, in windows that fall freely with it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support import parsed, sampled

import symgen
from symgen.codegen.model import regrouping
from symgen.data import long_logs
from symgen.data.log import make_log
from symgen.estimation.equation_model import EquationModel, kernels_of
from symgen.estimation.filtered_log import unfiltered
from symgen.estimation.masking import without_changes
from symgen.estimation.opening import open_log
from symgen.estimation.system import Rows
from symgen.report.store import load_result

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.legged import Legged, Motion, base_waves, table, text_of, times
from oracles.shaken import waves
from workflow.test_floating_logs import (
    DRONE,
    ENDS,
    FRAMES,
    HULL,
    IMU,
    drifting,
    flown,
    imu_of,
    log_of,
    noisy,
    of_drone,
    posed,
    walk,
    walked,
    walker,
)

WINDOW = 0.2
MODELS = ("energy", "momentum")
KERNELS = kernels_of(EquationModel(name, WINDOW) for name in MODELS)
#: Largest residual of clean rows, as a part of their size: that of integrals over steps of 4 ms.
CLEAN = 1e-8


def clean_rows(
    robot: symgen.Robot, log: symgen.Log | Path, model: str
) -> tuple[Rows, symgen.Model]:
    """The rows of a log without noise and filters, and the model."""
    derived = symgen.derive(robot, KERNELS)
    samples = without_changes(symgen.prepare(open_log(log, robot)))
    rows = EquationModel(model, WINDOW).equations(symgen.load(derived), unfiltered(samples))
    return rows, derived


def largest_errors(rows: Rows, X: np.ndarray) -> np.ndarray:
    """The largest residual of each equation, as a part of the largest measured value."""
    return np.abs(rows.y - rows.W @ X).max(axis=0) / np.abs(rows.y).max(axis=0)


@pytest.mark.parametrize(
    ("legs", "joints", "seed"),
    sampled([(a, b, seed) for a in (1, 2, 4) for b in (2, 3) for seed in range(5)], 3),
)
def test_rows_of_random_motions_hold(legs: int, joints: int, seed: int) -> None:
    """The wrench acts on the base."""
    arm = table(legs, joints)
    body = Legged(arm, seed, [])
    robot = parsed(text_of(arm, HULL))
    t = times(2.0)
    q = waves(t, np.full(arm.n, 0.8), 1.5, np.random.default_rng(seed))
    motion = Motion(t, *base_waves(t, seed, 2.0), q)
    (f, w, _), every = motion.base, body.torques(motion)
    imu, (wrench, tau) = np.hstack([f, w]), np.split(every, [6], axis=1)
    log = make_log("clean", t, q[0], tau, q[1], imu=imu, forces=wrench)
    for model, count in (("energy", 1), ("momentum", arm.n + 6)):
        rows, derived = clean_rows(robot, log, model)
        X = regrouping(derived) @ [body.standard[p.name] for p in derived.base.standard]
        assert rows.y.shape[1] == count
        assert largest_errors(rows, X).max() < CLEAN


def clean_walk() -> symgen.Log:
    """A log of the walker without noise."""
    motion, tau, wrenches = walked(1)
    f, w, _ = motion.base
    imu = np.hstack([f, w])
    return make_log("clean", motion.t, motion.q[0], tau, motion.q[1], imu=imu, forces=wrenches)


@pytest.mark.parametrize("model", MODELS)
def test_rows_hold_with_wrenches_on_the_feet(model: str) -> None:
    rows, _ = clean_rows(walker().robot, clean_walk(), model)
    assert largest_errors(rows, walker().X).max() < CLEAN


def test_a_spinning_body_that_a_known_force_throws(tmp_path: Path) -> None:
    """A force that is constant in the axes of a body, which turns about z at a constant rate.

    By hand: in axes that do not turn, u = f (sin wt, 1 - cos wt) / w from rest. In the frame in
    which the body rests at the end of a window, it has the speed -u at the start.
    """
    mass, inertia, w, T = 1.5, 0.04, 2.0, WINDOW
    fx, fz = 3.0, 7.0
    t = times(1.0)
    imu = np.tile([fx, 0, fz, 0, 0, w], (len(t), 1))
    wrench = np.tile([mass * fx, 0, mass * fz, 0, 0, 0], (len(t), 1))
    log = of_drone(tmp_path, t, imu, wrench)
    u = np.array([fx * np.sin(w * T) / w, fx * (1 - np.cos(w * T)) / w, fz * T])
    by_hand = {
        "momentum": mass * T * np.array([fx, 0, fz, 0, 0, 0]),
        "energy": -mass / 2 * np.array([u @ u]),
    }
    for model, want in by_hand.items():
        rows, derived = clean_rows(DRONE, log, model)
        columns = [derived.base.names.index(name) for name in ("ZZ0", "M0")]
        for side in (rows.y, rows.W[:, :, columns] @ [inertia, mass]):
            np.testing.assert_allclose(side, np.tile(want, (len(side), 1)), atol=1e-11)


@pytest.fixture(scope="module")
def walks() -> tuple[symgen.Log, symgen.Log]:
    return walk(1), walk(20)


@cache
def estimated(model: str) -> symgen.Estimate:
    return symgen.identify(walker().robot, walk(1), validation=walk(20), model=model)


@pytest.mark.parametrize("model", MODELS)
def test_noisy_logs_give_every_parameter(model: str) -> None:
    estimate = estimated(model)
    assert (estimate.model, estimate.verdict) == (model, "trusted")
    off = np.abs(walker().off(estimate))
    assert off.max() < 4
    assert np.mean(off < 1.96) > 0.88
    mass = next(p for p in estimate.parameters if p.name == "M0R")
    assert mass.value == pytest.approx(sum(walker().body.links[:, 9]), rel=5e-3)


def test_auto_compares_three_models() -> None:
    estimate = estimated("auto")
    assert {a.model for a in estimate.alternatives} == {*MODELS, "torque"}
    best = min(a.held_out for a in estimate.alternatives)
    assert estimate.model == "momentum"  # it is preferred if it is as good
    chosen = next(a for a in estimate.alternatives if a.chosen)
    assert chosen.held_out < 1.03 * best


def test_the_momentum_of_the_base_has_its_own_error_and_curves(tmp_path: Path) -> None:
    estimate = estimated("momentum")
    error = estimate.validation
    assert len(error.per_joint) == 4
    assert error.relative == max(error.base_force, error.base_moment, error.joints) < 0.02
    symgen.write(estimate, tmp_path / "id")
    page = (tmp_path / "id" / "report.html").read_text(encoding="utf-8")
    assert "base moment z, N m s" in page
    again = load_result(tmp_path / "id")
    assert again.validation == error
    curves = next(trace for trace in again.traces if trace.quantity == "momentum")
    assert curves.measured.shape[1] == 10


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_unknown_forces_are_refused(walks, model: str) -> None:
    robot, log = lifted(walks[0])
    forces = log.forces * np.repeat([1.0, np.nan], 6)
    with pytest.raises(symgen.SymgenError) as error:
        symgen.identify(robot, replace(log, forces=forces), model=model, cutoff=14)
    text = str(error.value)
    assert "the models of energy and momentum need the forces at right; " in text
    assert text.endswith("accepted: model torque, or columns right.fx .. right.nz")
    assert "\n" not in text


def test_an_imu_on_a_base_that_is_not_free_keeps_its_refusal() -> None:
    robot = parsed(text_of(walker().body.arm, base="imu"))
    for model in MODELS:
        with pytest.raises(symgen.SymgenError, match=r"base of legged has an IMU.+model torque"):
            symgen.identify(robot, walk(1), model=model)


def lifted(log: symgen.Log) -> tuple[symgen.Robot, symgen.Log]:
    """The walker with contacts, whose forces are measured, and a log in which they change."""
    contacts = "".join(
        f'[[contact]]\nframe = "{name}"\nkind = "surface"\n' for name in ("left", "right")
    )
    robot = parsed(text_of(walker().body.arm, FRAMES + contacts))
    return robot, replace(log, touches=np.column_stack([log.t % 4 < 2, log.t % 4 > 1.5]))


@pytest.mark.parametrize("model", MODELS)
def test_masked_samples_have_no_part_in_any_window(model: str) -> None:
    """Around changes of contacts, the log has wrong torques."""
    robot, log = lifted(clean_walk())
    changes = log.t[1:][np.diff(log.touches, axis=0).any(axis=1)]
    near = np.abs(log.t[:, None] - changes).min(axis=1) < 0.01
    log = replace(log, tau=log.tau + 50.0 * near[:, None])
    rows, _ = clean_rows(robot, log, model)
    used = rows.weight.all(axis=1)
    assert 0.5 < np.mean(used) < 0.9
    errors = np.abs(rows.y - rows.W @ walker().X).max(axis=1)
    assert errors[used].max() < CLEAN * np.abs(rows.y).max()
    assert errors[~used].max() > 0.1


@pytest.mark.parametrize("model", MODELS)
def test_flight_shows_the_parameters_by_the_torques_of_the_joints(model: str) -> None:
    case, t = walker(), times(16.0)
    q = waves(t, np.full(4, 0.8), 1.5, np.random.default_rng(5))
    motion = Motion(t, *base_waves(t, 5, 0.0), q)
    imu, tau = flown(case.body, motion)
    log = log_of(motion, tau, 5, imu=noisy(9, imu, IMU))
    estimate = symgen.identify(case.robot, log, method="wls", model=model)
    assert np.abs(case.off(estimate)).max() < 4.5
    assert np.isnan(estimate.torque_validation.base_force)  # there is no force


@pytest.mark.parametrize(("joints", "rank"), [(True, 38), (False, 7)])
def test_the_power_of_a_flight_shows_what_the_energy_model_does(joints: bool, rank: int) -> None:
    robot = walker().robot if joints else DRONE
    model = symgen.derive(robot, (*KERNELS, "torque_regressor"))
    part = symgen.EquationPart("power", flight=True)
    found = symgen.exact_rank(robot, model.base, [part])
    assert found.rank == rank
    assert (not found.unknown) == joints


def test_a_pose_stands_for_the_imu() -> None:
    for model in MODELS:
        found = symgen.identify(walker().robot, posed(), model=model, method="wls")
        assert np.abs(walker().off(found)).max() < 4.5


@pytest.mark.parametrize("model", MODELS)
def test_a_drone_has_no_joints(tmp_path: Path, model: str) -> None:
    motion, wrench, true = drifting()
    log = of_drone(tmp_path, motion.t, imu_of(motion, 1), wrench)
    estimate = symgen.identify(DRONE, log, model=model)
    off = [(p.value - x) / p.std for p, x in zip(estimate.parameters, true, strict=True)]
    assert np.abs(off).max() < 4


@pytest.mark.parametrize("model", MODELS)
def test_a_long_log_is_read_in_segments(tmp_path: Path, monkeypatch, model: str) -> None:
    log, robot = posed(), walker().robot
    arrays = {key: getattr(log, key) for key in ("t", "q", "qd", "tau", "pose")}
    names = [f"{side}.{end}" for side in ("left", "right") for end in ENDS]
    wrenches = dict(zip(names, log.forces.T, strict=True))
    np.savez(tmp_path / "a.npz", **arrays, **wrenches)
    want = symgen.identify(robot, log, method="wls", model=model, cutoff=14)
    monkeypatch.setattr(long_logs, "LIMIT", 2000)
    found = symgen.identify(robot, tmp_path / "a.npz", method="wls", model=model, cutoff=14)
    for p, x in zip(found.parameters, want.parameters, strict=True):
        assert abs(p.value - x.value) < 2 * x.std
        assert p.std == pytest.approx(x.std, rel=0.25)
