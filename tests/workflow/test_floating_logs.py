"""A robot with a floating base: identify and predict from logs of its motion and of forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Page
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from support import parsed

import symgen
from symgen.codegen.model import regrouping
from symgen.data import long_logs
from symgen.data.log import make_log
from symgen.identification.prediction import torque_errors
from symgen.report.store import load_result

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.legged import (
    VISCOUS,
    Foot,
    Legged,
    Motion,
    base_waves,
    crawl,
    stride,
    table,
    text_of,
    times,
)
from oracles.shaken import turned, waves

#: Standard deviations of noise: rad, rad/s, N m, m/s2 and rad/s, N.
ENCODER, SPEED, TORQUE, FORCE = 1e-5, 1e-3, 0.05, 0.3
IMU = np.repeat([0.02, 0.002], 3)
ENDS = ("fx", "fy", "fz", "nx", "ny", "nz")
#: Yaw of the axes of the second foot.
YAW = 0.7
FRAMES = f"""
[[frame]]
name = "left"
joint = 2
xyz = [0.1, 0.2, 0.3]

[[frame]]
name = "right"
joint = 4
xyz = [0.0, -0.2, 0.1]
rpy = [0.0, 0.0, {YAW}]
"""


@dataclass(frozen=True)
class Case:
    """A robot, and its base parameters."""

    body: Legged
    robot: symgen.Robot

    @property
    def X(self) -> np.ndarray:
        model = symgen.derive(self.robot, ("inverse_dynamics", "torque_regressor"))
        values = [self.body.standard[p.name] for p in model.base.standard]
        return regrouping(model) @ np.array(values)

    def off(self, estimate: symgen.Estimate) -> np.ndarray:
        """Errors of the parameters in standard deviations."""
        pairs = zip(estimate.parameters, self.X, strict=True)
        return np.array([(p.value - x) / p.std for p, x in pairs])


@cache
def walker() -> Case:
    """A body with two legs of two joints."""
    axes = np.array([[np.cos(YAW), -np.sin(YAW), 0], [np.sin(YAW), np.cos(YAW), 0], [0, 0, 1]])
    arm = table(2, 2)
    body = Legged(arm, 3, [Foot(2, (0.1, 0.2, 0.3)), Foot(4, (0.0, -0.2, 0.1), axes)])
    return Case(body, parsed(text_of(arm, FRAMES)))


def noisy(seed: int, x: np.ndarray, size: Any) -> np.ndarray:
    return x + size * np.random.default_rng(seed).normal(size=x.shape)


def log_of(motion: Motion, tau: np.ndarray, seed: int = 1, **more: np.ndarray) -> symgen.Log:
    """A log of joints, with noise, and of what else there is."""
    q, qd, _ = motion.q
    return make_log(
        f"log{seed}", motion.t, noisy(seed, q, ENCODER), noisy(seed + 1, tau, TORQUE),
        noisy(seed + 2, qd, SPEED), **more,
    )  # fmt: skip


def imu_of(motion: Motion, seed: int) -> np.ndarray:
    f, w, _ = motion.base
    return noisy(seed + 3, np.hstack([f, w]), IMU)


@dataclass(frozen=True)
class Load:
    """A load on a link: its mass, centre of mass, and inertia about it."""

    link: int
    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, ...]

    @property
    def true(self) -> np.ndarray:
        return np.array([self.mass, *self.com, *self.inertia])

    def on(self, case: Case) -> Legged:
        """The robot with this load."""
        c, inertia = np.array(self.com), np.zeros((3, 3))
        inertia[np.triu_indices(3)] = self.inertia
        steiner = self.mass * (c @ c * np.eye(3) - np.outer(c, c))
        about = (inertia + steiner)[np.triu_indices(3)]
        body = case.body
        ten = np.array([*about, *self.mass * c, self.mass])
        return Legged(body.arm, 3, body.feet, {self.link: ten})

    def off(self, found: symgen.Payload) -> np.ndarray:
        """Errors of what is found in standard deviations."""
        pairs = zip([q for _, q, _ in found.rows()], self.true, strict=True)
        return np.array([(q.value - x) / q.std for q, x in pairs if q.value is not None])


BACKPACK = Load(0, 2.0, (0.05, -0.03, 0.12), (0.02, 0.001, 0.0, 0.03, 0.002, 0.025))
CUFF = Load(2, 0.5, (0.02, 0.01, -0.05), (0.002, 0.0, 0.0, 0.002, 0.0, 0.001))


@cache
def walked(seed: int, load: Load | None = None) -> tuple[Motion, np.ndarray, np.ndarray]:
    """A motion of the walker, its torques, and the wrenches on both feet, (N, 12)."""
    t = times(16.0)
    q = waves(t, np.full(4, 0.8), 1.5, np.random.default_rng(seed + 100))
    motion = Motion(t, *base_waves(t, seed), q)
    body = walker().body if load is None else load.on(walker())
    every, wrenches = body.supported(motion, np.ones((len(t), 2), bool), 6)
    return motion, every[:, 6:], wrenches.reshape(len(t), -1)


def walk(seed: int, load: Load | None = None) -> symgen.Log:
    """A log of the walker, with the wrenches on its feet."""
    motion, tau, wrenches = walked(seed, load)
    forces = noisy(seed + 4, wrenches, FORCE)
    return log_of(motion, tau, seed, imu=imu_of(motion, seed), forces=forces)


@pytest.fixture(scope="module")
def walks() -> tuple[symgen.Log, symgen.Log, symgen.Estimate]:
    train, held = walk(1), walk(20)
    return train, held, symgen.identify(walker().robot, train, validation=held)


def columns(log: symgen.Log) -> dict[str, np.ndarray]:
    """The columns of a file of a log of the walker."""
    out = {"t": log.t}
    for role in ("q", "qd", "tau"):
        out |= {f"{role}{j + 1}": x for j, x in enumerate(getattr(log, role).T)}
    out |= dict(zip(("fx", "fy", "fz", "wx", "wy", "wz"), log.imu.T, strict=True))
    names = [f"{frame}.{end}" for frame in ("left", "right") for end in ENDS]
    return out | dict(zip(names, log.forces.T, strict=True))


def test_measured_wrenches_give_every_parameter_and_the_total_mass(walks) -> None:
    _, _, estimate = walks
    assert estimate.verdict == "trusted"
    assert np.abs(walker().off(estimate)).max() < 4
    mass = next(p for p in estimate.parameters if p.name == "M0R")
    total = sum(walker().body.links[:, 9])
    assert mass.value == pytest.approx(total, rel=5e-3)


def test_the_torque_error_has_three_numbers(walks) -> None:
    error = walks[2].torque_validation
    assert len(error.per_joint) == 4
    assert error.relative == max(error.base_force, error.base_moment, error.joints)
    content = walks[2].to_json()["torque_residual"]["validation"]
    assert content["base_force"] == error.base_force < 0.002


def test_held_out_motion_is_predicted_as_by_the_true_parameters(walks, tmp_path: Path) -> None:
    _, held, estimate = walks
    symgen.write(estimate, tmp_path / "id")
    found = symgen.predict(walker().robot, held, tmp_path / "id")
    # The offsets of the IMU in `held` are those of slightly different parameters.
    assert found.error.relative == pytest.approx(estimate.torque_validation.relative, rel=1e-3)
    names = [p.name for p in estimate.parameters]
    lines = "".join(f"{n} = {x!r}\n" for n, x in zip(names, walker().X.tolist(), strict=True))
    (tmp_path / "true.toml").write_text(f"[parameters]\n{lines}")
    true = symgen.predict(walker().robot, held, tmp_path / "true.toml", cutoff=estimate.cutoff_hz)
    for key in ("base_force", "base_moment", "joints"):
        assert getattr(found.error, key) < 1.3 * getattr(true.error, key)
    symgen.write(found, tmp_path / "predicted")
    again = load_result(tmp_path / "predicted")
    assert again.error == found.error
    assert again.torque.measured.shape[1] == 10


def test_the_page_shows_the_equations_of_the_base(walks, tmp_path: Path) -> None:
    symgen.write(walks[2], tmp_path / "id")
    page = (tmp_path / "id" / "report.html").read_text(encoding="utf-8")
    assert "base force x, N" in page
    assert "base moment z, N m" in page
    again = load_result(tmp_path / "id")
    assert again.torque_validation == walks[2].torque_validation


@pytest.mark.slow
def test_a_csv_holds_wrenches_of_frames(walks, tmp_path: Path) -> None:
    log, robot = walks[0], walker().robot
    table = columns(log)
    rows = np.column_stack([*table.values()])
    np.savetxt(tmp_path / "a.csv", rows, "%.17g", ",", header=",".join(table), comments="")
    want, found = (
        symgen.identify(robot, given, method="wls", cutoff=14)
        for given in (log, tmp_path / "a.csv")
    )
    assert [p.value for p in found.parameters] == [p.value for p in want.parameters]


def posed() -> symgen.Log:
    """The first log of the walker with a pose instead of an IMU."""
    motion, tau, wrenches = walked(1)
    return log_of(motion, tau, 1, pose=pose_of(motion), forces=noisy(5, wrenches, FORCE))


def pose_of(motion: Motion) -> np.ndarray:
    quaternion, *_ = turned(motion.angles)
    pose = np.hstack([motion.place[0], -quaternion])  # the same attitude
    return noisy(8, pose, 1e-6)


@pytest.mark.slow
def test_a_long_npz_is_read_in_segments(walks, tmp_path: Path, monkeypatch) -> None:
    log, robot = posed(), walker().robot
    table = columns(replace(log, imu=walks[0].imu))
    arrays = {key: getattr(log, key) for key in ("t", "q", "qd", "tau", "pose")}
    wrenches = {name: x for name, x in table.items() if "." in name}
    np.savez(tmp_path / "a.npz", **arrays, **wrenches)
    want = symgen.identify(robot, log, method="wls", cutoff=14)
    monkeypatch.setattr(long_logs, "LIMIT", 1200)
    found = symgen.identify(robot, tmp_path / "a.npz", method="wls", cutoff=14)
    for p, x in zip(found.parameters, want.parameters, strict=True):
        assert abs(p.value - x.value) < 2 * x.std
        assert p.std == pytest.approx(x.std, rel=0.25)


def test_a_missing_column_is_named(walks, tmp_path: Path) -> None:
    table = columns(walks[0])
    del table["right.ny"]
    rows = np.column_stack([*table.values()])
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header=",".join(table), comments="")
    with pytest.raises(symgen.SymgenError, match=r"no column right\.ny"):
        symgen.identify(walker().robot, tmp_path / "a.csv")
    with pytest.raises(symgen.SymgenError, match=r"motion of the base.+fx, fy.+px, py, pz, qw"):
        symgen.identify(walker().robot, replace(walks[0], imu=None))
    tables = FRAMES + '[[contact]]\nframe = "left"\nkind = "point"\n'
    robot = parsed(text_of(walker().body.arm, tables))
    with pytest.raises(symgen.SymgenError, match=r"lacks the column left\.contact.+left\.fx"):
        symgen.identify(robot, replace(walks[0], forces=None))


def test_a_pose_stands_for_the_imu(walks) -> None:
    log = posed()
    estimate = symgen.identify(walker().robot, log, validation=walks[1])
    assert np.abs(walker().off(estimate)).max() < 4.5
    assert estimate.torque_validation.relative < 1.3 * walks[2].torque_validation.relative
    bent = replace(log, pose=log.pose * [1, 1, 1, 1.02, 1.02, 1.02, 1.02])
    with pytest.raises(symgen.SymgenError, match=r"norm 1\.02.+within 1 %"):
        symgen.identify(walker().robot, bent)


def test_an_imu_at_another_place_is_moved_to_the_origin() -> None:
    motion, tau, wrenches = walked(1)
    place, rpy = np.array([0.2, -0.1, 0.15]), (0.3, -0.2, 1.1)
    f, w, wd = motion.base
    there = f + np.cross(wd, place) + np.cross(w, np.cross(w, place))
    axes = Rotation.from_euler("ZYX", rpy[::-1]).as_matrix()
    imu = noisy(4, np.hstack([there @ axes, w @ axes]), IMU)
    log = log_of(motion, tau, 1, imu=imu, forces=noisy(5, wrenches, FORCE))
    mount = f"\n[base]\nposition = {place.tolist()}\nrotation = {[*rpy]}\n"
    robot = parsed(text_of(walker().body.arm, FRAMES + mount))
    estimate = symgen.identify(robot, log, method="wls")
    assert np.abs(walker().off(estimate)).max() < 4.5


def off_imu(log: symgen.Log, offsets: np.ndarray, late: float) -> symgen.Log:
    """A log whose IMU has offsets and is late by some seconds."""
    spline = CubicSpline(log.t, log.imu)
    return replace(log, imu=spline(np.maximum(log.t - late, 0.0)) + offsets)


def test_offsets_and_delay_of_an_imu_are_estimated_and_removed(walks, tmp_path: Path) -> None:
    robot, late = walker().robot, 1.5e-3
    errors = np.array([[0.06, -0.05, 0.04, 0.004, -0.005, 0.006], [-0.05, 0.04, -0.06, 0, 0, 0]])
    train, held = (off_imu(log, o, late) for log, o in zip(walks[:2], errors, strict=True))
    estimate = symgen.identify(robot, train, validation=held)
    assert np.abs(walker().off(estimate)).max() < 4
    assert estimate.torque_validation.relative < 1.1 * walks[2].torque_validation.relative
    repairs = [fault for fault in estimate.repairs if fault.channel == "imu"]
    of_train, delay, of_held = repairs
    for fault, true in ((of_train, errors[0]), (of_held, errors[1])):
        _, found, std = zip(*fault.values, strict=True)
        assert np.all(np.abs(np.array(found) - true) < 4 * np.array(std))
    assert abs(delay.value - late) < 4 * delay.std
    symgen.write(estimate, tmp_path / "id")
    predicted = symgen.predict(robot, held, tmp_path / "id")
    assert predicted.error.relative == pytest.approx(estimate.torque_validation.relative, rel=1e-3)


def test_a_log_with_a_pose_is_used_with_one_of_an_imu(walks) -> None:
    errors = np.array([0.06, -0.05, 0.04, 0.004, -0.005, 0.006])
    logs = [posed(), off_imu(walks[1], errors, 1.5e-3)]
    estimate = symgen.identify(walker().robot, logs, method="wls", cutoff=14)
    assert np.abs(walker().off(estimate)).max() < 4


def test_a_radius_belongs_to_a_point() -> None:
    tables = FRAMES + '[[contact]]\nframe = "left"\nkind = "surface"\nradius = 0.02\n'
    with pytest.raises(symgen.SymgenError, match=r"radius.+kind = 'point'"):
        parsed(text_of(walker().body.arm, tables))


def test_flight_gives_parameters_from_the_torques_of_the_joints() -> None:
    case, t = walker(), times(16.0)
    q = waves(t, np.full(4, 0.8), 1.5, np.random.default_rng(5))
    motion = Motion(t, *base_waves(t, 5, 0.0), q)
    imu, tau = flown(case.body, motion)
    log = log_of(motion, tau, 5, imu=noisy(9, imu, IMU))
    estimate = symgen.identify(case.robot, log, method="wls")
    assert estimate.torque_validation.joints < 0.05
    assert np.isnan(estimate.torque_validation.base_force)  # there is no force
    base, joints, both = estimate.identifiable.logged
    assert (base.rank, joints.rank, both.rank) == (37, 28, 38)
    assert base.equations == "forces on the base in flight"
    mass = next(p for p in estimate.parameters if p.name == "M0R")
    assert abs(mass.value / sum(case.body.links[:, 9]) - 1) < 0.1


def flown(body: Legged, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """The IMU and the torques of a flight with some motion of the joints."""
    step, w = motion.t[1], np.array([0.2, -0.3, 0.1])
    rows = [*zip(*motion.q, strict=True)]

    def free(row: Sequence[np.ndarray], w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Specific force and angular acceleration without a wrench."""
        rest = body.flyer.dynamics(*row, np.zeros(3), w, np.zeros(3))
        f, wd = np.split(np.linalg.solve(body.flyer.masses(row[0])[:6, :6], -rest[:6]), 2)
        return f, wd

    imu, tau = [], []
    for row, after in zip(rows, [*rows[1:], rows[-1]], strict=True):
        f, wd = free(row, w)
        imu.append([*f, *w])
        tau.append(body.flyer.dynamics(*row, f, w, wd)[6:] + VISCOUS * row[1])
        _, later = free(after, w + step * wd)
        w = w + step * (wd + later) / 2  # Heun
    return np.array(imu), np.array(tau)


@cache
def crawler() -> Case:
    """A body with four legs, whose feet touch the ground at points."""
    arm, feet = table(4, 3), [3 * k + 3 for k in range(4)]
    frames = [f'[[frame]]\nname = "foot{k}"\njoint = {k}\n' for k in feet]
    contacts = [f'[[contact]]\nframe = "foot{k}"\nkind = "point"\n' for k in feet]
    body = Legged(arm, 3, [Foot(k) for k in feet])
    return Case(body, parsed(text_of(arm, "\n".join([*frames, *contacts]))))


def crawled(seed: int, *, lifts: bool, measured: int = 0, load: Load | None = None) -> symgen.Log:
    """A log of the crawler with the forces on some of its feet."""
    motion, touches = crawl(seed, 12.0, lifts=lifts)
    body = crawler().body if load is None else load.on(crawler())
    tau, on_feet = body.supported(motion, touches, 3)
    forces = np.full((len(motion.t), 4, 6), np.nan)
    forces[:, :measured, :3] = noisy(seed + 4, on_feet[:, :measured], FORCE)
    forces[:, :measured, 3:] = 0.0
    more = {"forces": forces.reshape(len(motion.t), -1), "touches": touches.astype(float)}
    return log_of(motion, tau[:, 6:], seed, imu=imu_of(motion, seed), **more)


@pytest.fixture(scope="module")
def crawls() -> list[symgen.Estimate]:
    """Estimates from a log in which every foot lifts, and from one in which none does."""
    robot = crawler().robot
    logs = [crawled(1, lifts=lifts) for lifts in (True, False)]
    return [symgen.identify(robot, log, method="wls", cutoff=14) for log in logs]


def test_hidden_forces_at_contacts_have_no_part_in_the_estimate(crawls) -> None:
    estimate = crawls[0]
    assert (estimate.model, estimate.verdict) == ("torque", "trusted")
    for other in estimate.alternatives[1:]:  # of energy and momentum
        assert "need the forces at foot3, foot6, foot9, foot12" in other.reason
    off = crawler().off(estimate)
    assert np.abs(off).max() < 4.5
    assert np.mean(np.abs(off) < 1.96) > 0.88
    masses = [p.value for p in estimate.parameters if p.name in ("M0R", "M3", "M6", "M9", "M12")]
    assert sum(masses) == pytest.approx(sum(crawler().body.links[:, 9]), rel=0.01)


def rolled(seconds: float, *, posed: bool) -> tuple[symgen.Robot, symgen.Log]:
    """The crawler on round feet, and a log of it."""
    motion, touches = crawl(1, seconds)
    feet = [replace(foot, radius=0.03) for foot in crawler().body.feet]
    tau, _ = Legged(crawler().body.arm, 3, feet).supported(motion, touches, 3)
    more = {"pose": pose_of(motion)} if posed else {"imu": imu_of(motion, 1)}
    log = log_of(motion, tau[:, 6:], 1, **more, touches=touches.astype(float))
    contacts = tuple(replace(contact, radius=0.03) for contact in crawler().robot.contacts)
    return replace(crawler().robot, contacts=contacts), log


@pytest.mark.slow
def test_the_force_on_a_round_foot_acts_below_its_centre() -> None:
    estimate = symgen.identify(*rolled(12.0, posed=True), method="wls", cutoff=14)
    assert np.abs(crawler().off(estimate)).max() < 4.5
    assert estimate.torque_validation.relative < 0.002


@pytest.mark.slow
def test_an_imu_shows_where_a_round_foot_touches() -> None:
    robot, log = rolled(12.0, posed=False)
    estimates = [
        symgen.identify(of_feet, log, method="wls", cutoff=14)
        for of_feet in (robot, crawler().robot)
    ]
    assert np.abs(crawler().off(estimates[0])).max() < 4.5
    ours, of_points = (e.torque_validation.relative for e in estimates)
    assert ours < 0.3 * of_points


@pytest.mark.slow
def test_forces_on_some_feet_are_measured_and_on_others_hidden() -> None:
    log = crawled(1, lifts=True, measured=2)
    off = crawler().off(symgen.identify(crawler().robot, log, method="wls", cutoff=14))
    assert np.abs(off).max() < 4.5
    assert np.mean(np.abs(off) < 1.96) > 0.88


def test_the_feet_that_never_lift_are_named_and_their_masses_unknown(crawls) -> None:
    estimate = crawls[1]
    unknown = [p.name for p in estimate.parameters if np.isnan(p.std)]
    assert unknown == ["M3", "M6", "M9", "M12"]
    (reason,) = (r for r in estimate.uses.parameters.reasons if r.kind == "not_determined")
    assert "foot3, foot6, foot9, foot12 never lift" in reason.text


@cache
def strider() -> Case:
    """A body with two legs of six joints and flat feet."""
    arm, feet = table(2, 6), (6, 12)
    frames = [f'[[frame]]\nname = "foot{k}"\njoint = {k}\n' for k in feet]
    contacts = [f'[[contact]]\nframe = "foot{k}"\nkind = "surface"\n' for k in feet]
    body = Legged(arm, 3, [Foot(k) for k in feet])
    return Case(body, parsed(text_of(arm, "\n".join([*frames, *contacts]))))


def strode(seed: int, lifts: tuple[bool, bool]) -> symgen.Log:
    """A log of the strider, whose feet are hidden."""
    motion, flat = stride(seed, 12.0, lifts)
    tau, _ = strider().body.supported(motion, flat, 6)
    imu, touches = imu_of(motion, seed), flat.astype(float)
    return log_of(motion, tau[:, 6:], seed, imu=imu, touches=touches)


@pytest.mark.slow
def test_hidden_wrenches_at_surfaces_have_no_part_in_the_estimate() -> None:
    train, held = (strode(seed, (True, True)) for seed in (1, 7))
    robot = strider().robot
    estimate = symgen.identify(robot, train, validation=held, method="wls", cutoff=14)
    off = strider().off(estimate)
    assert np.abs(off).max() < 4
    assert np.mean(np.abs(off) < 1.96) > 0.88
    found = np.array([p.value for p in estimate.parameters])
    ours, true = torque_errors(robot, held, [found, strider().X], estimate.band)
    assert ours < 1.3 * true < 0.004
    masses = [p.value for p in estimate.parameters if p.name in ("M0R", "M3R", "M9R")]
    assert sum(masses) == pytest.approx(sum(strider().body.links[:, 9]), rel=0.005)


@pytest.mark.slow
def test_a_surface_that_never_lifts_hides_its_link_and_is_named() -> None:
    estimate = symgen.identify(
        strider().robot, strode(1, (False, True)), method="wls", cutoff=14
    )  # fmt: skip
    unknown = [p.name for p in estimate.parameters if np.isnan(p.std)]
    assert unknown == not_visible(*stride(1, 12.0, (False, True)))
    of_link = [p.name for p in estimate.parameters if p.name.strip("R").endswith("Z6")]
    assert of_link == ["XZ6", "YZ6", "ZZ6"]
    assert {*of_link, "MX6", "MY6"} < {*unknown}
    (reason,) = (r for r in estimate.uses.parameters.reasons if r.kind == "not_determined")
    assert "(foot6 never lifts: log a motion in which it does)" in reason.text
    off = [x for p, x in zip(estimate.parameters, strider().off(estimate), strict=True)
           if p.name not in unknown]  # fmt: skip
    assert np.abs(off).max() < 4


def not_visible(motion: Motion, flat: np.ndarray) -> list[str]:
    """Names of inertial parameters of the strider that the null space of its columns contains."""
    model = symgen.derive(strider().robot, ("torque_regressor",))
    call, body, out = symgen.load(model, backend="casadi"), strider().body, []
    for k in range(0, len(motion.t), 10):
        q, qd, qdd = motion.q[:, k]
        f, w, wd = (x[k] for x in motion.base)
        feet = [foot for foot, rests in zip(body.feet, flat[k], strict=True) if rests]
        J = np.vstack([body.jacobian(q, foot) for foot in feet])
        W = call.torque_regressor(q, qd, qdd, f, w, wd)[:, : model.inertial]
        out.append(W - np.linalg.pinv(J) @ (J @ W))
    _, sizes, directions = np.linalg.svd(np.vstack(out))
    null = directions[sizes < 1e-8 * sizes[0]]
    large = np.abs(null).max(axis=0) > 1e-4
    return [name for name, x in zip(model.base.names, large, strict=False) if x]


def test_the_page_says_which_equations_show_the_parameters(walks, crawls, tmp_path) -> None:
    base, joints, both = walks[2].identifiable.logged
    assert (base.rank, base.unknown, both.rank, both.unknown) == (38, (), 38, ())
    assert (joints.equations, joints.rank) == ("torques of the joints", 28)
    assert joints.unknown == tuple(p.name for p in walks[2].parameters[:10])
    walk, stand = (estimate.identifiable for estimate in crawls)
    *sets, together = walk.logged
    assert sum(part.share for part in sets) == pytest.approx(1)
    assert {part.rank for part in sets} == {78, 79}
    assert (together.rank, walk.lifted) == (walk.count, ()) == (82, ())
    assert stand.unknown == ("M3", "M6", "M9", "M12")
    first, *_, last = stand.lifted
    assert (first.rank, first.unknown) == (79, ("M6", "M9", "M12"))
    assert (last.equations, last.rank) == ("if each of them lifts once", 82)
    symgen.write(crawls[1], tmp_path / "id")
    assert load_result(tmp_path / "id").identifiable == stand
    page = Page((tmp_path / "id" / "report.html").read_text(encoding="utf-8"))
    assert "if foot3 lifts too79 of 82also M3 (1)" in page.text.replace("\n", "")
    printed = symgen.report.store.content(crawls[0]).sections
    assert [s.printed for s in printed if s.heading == "Identifiable parameters"] == [None]


@pytest.fixture(scope="module")
def alone(walks, tmp_path_factory) -> Path:
    """The walker without a load."""
    folder = tmp_path_factory.mktemp("alone") / "id"
    symgen.write(walks[2], folder)
    return folder


def carrying(case: Case, link: int) -> symgen.Robot:
    """The robot with [payload]."""
    return parsed(f"{symgen.robot_toml(case.robot)}\n[payload]\njoint = {link}\n")


@pytest.mark.parametrize("load", [BACKPACK, CUFF], ids=["base", "leg"])
def test_a_load_on_a_link_is_found(alone, load: Load, tmp_path: Path) -> None:
    robot = carrying(walker(), load.link)
    found = symgen.payload(robot, walk(7, load), parameters=alone)
    assert found.mass.value == pytest.approx(load.mass, rel=0.02)
    off = load.off(found)
    assert len(off) >= 7
    assert np.abs(off).max() < 4
    before, after = found.residual.floating
    assert after.base_force < 0.1 * before.base_force
    symgen.write(found, tmp_path / "load")
    again = load_result(tmp_path / "load")
    assert again.to_json() == found.to_json()
    assert again.traces[0].measured.shape[1] == 10
    page = Page((tmp_path / "load" / "report.html").read_text(encoding="utf-8"))
    assert len(page.figures[0]) == 10
    assert ("carries on its base" in page.text) == (load.link == 0)


def test_a_load_on_another_link_is_named(alone) -> None:
    with pytest.raises(symgen.SymgenError, match=r"base \(0\).+accepted: joint = 0 in \[payload\]"):
        symgen.payload(walker().robot, walk(7, BACKPACK), parameters=alone)


def test_logs_with_and_without_a_load_are_solved_together() -> None:
    found = symgen.payload(carrying(walker(), 0), walk(7, BACKPACK), without=walk(1))
    assert np.abs(BACKPACK.off(found)).max() < 4


def test_a_sensor_of_a_floating_base_is_refused(walks) -> None:
    with pytest.raises(symgen.SymgenError, match=r"payload --sensor.+symgen payload without it"):
        symgen.payload(walker().robot, walks[0], sensor=True)


def test_a_load_on_link_0_needs_a_floating_base() -> None:
    text = text_of(walker().body.arm, "[payload]\njoint = 0\n", base="imu")
    with pytest.raises(symgen.SymgenError, match=r"there is no joint 0; accepted: 1 to 4"):
        parsed(text)


@pytest.mark.slow
def test_a_load_is_found_where_the_forces_are_hidden(crawls, tmp_path: Path) -> None:
    """Also by a robot that stands on four feet; but not on a link whose foot never lifts."""
    symgen.write(crawls[0], tmp_path / "id")
    for load, lifts in ((BACKPACK, True), (BACKPACK, False), (CUFF, True)):
        log = crawled(7, lifts=lifts, load=load)
        found = symgen.payload(carrying(crawler(), load.link), log, parameters=tmp_path / "id")
        assert np.abs(load.off(found)).max() < 4
    shin = replace(CUFF, link=3)
    log = crawled(7, lifts=False, load=shin)
    with pytest.raises(symgen.SymgenError, match=r"hide some of a load.+joint 3; .+: foot3, foot6"):
        symgen.payload(carrying(crawler(), 3), log, parameters=tmp_path / "id")


@pytest.mark.slow
@pytest.mark.parametrize("load", [BACKPACK, CUFF], ids=["base", "leg"])
def test_intervals_of_a_load_contain_it(alone, load: Load) -> None:
    robot, off = carrying(walker(), load.link), []
    for seed in range(100, 120):
        found = symgen.payload(robot, walk(seed, load), parameters=alone)
        off += load.off(found)[:4].tolist()
    assert np.mean(np.abs(off) < 1.96) >= 0.88


HULL = '[[frame]]\nname = "hull"\njoint = 0\n'
DRONE = parsed(f'[robot]\nname = "drone"\nbase = "floating"\n{HULL}')


def of_drone(folder: Path, t: np.ndarray, imu: np.ndarray, wrench: np.ndarray) -> Path:
    """Write the log of a robot without joints."""
    heads = ["t", "fx", "fy", "fz", "wx", "wy", "wz", *(f"hull.{end}" for end in ENDS)]
    rows = np.column_stack([t, imu, wrench])
    np.savetxt(folder / "a.csv", rows, "%.17g", ",", header=",".join(heads), comments="")
    return folder / "a.csv"


def drifting() -> tuple[Motion, np.ndarray, list[float]]:
    """The motion of a drone, the wrench on it, with noise, and its true parameters."""
    t = times(16.0)
    motion = Motion(t, *base_waves(t, 3), np.zeros((3, len(t), 0)))
    f, w, wd = motion.base
    mass, ms = 1.3, np.array([0.026, -0.013, 0.065])
    inertia = np.array([[0.02, 0.001, 0], [0.001, 0.03, 0.002], [0, 0.002, 0.04]])
    force = mass * f + np.cross(wd, ms) + np.cross(w, np.cross(w, ms))
    moment = np.cross(ms, f) + wd @ inertia + np.cross(w, w @ inertia)
    wrench = noisy(2, np.hstack([force, moment]), np.repeat([0.05, 0.005], 3))
    return motion, wrench, [*inertia[np.triu_indices(3)], *ms, mass]


def test_a_drone_has_no_joints(tmp_path: Path) -> None:
    motion, wrench, true = drifting()
    log = of_drone(tmp_path, motion.t, imu_of(motion, 1), wrench)
    estimate = symgen.identify(DRONE, log)
    assert estimate.verdict == "trusted"
    off = [(p.value - x) / p.std for p, x in zip(estimate.parameters, true, strict=True)]
    assert np.abs(off).max() < 4
    symgen.write(estimate, tmp_path / "id")
    found = symgen.predict(DRONE, log, tmp_path / "id")
    assert found.error.base_moment < 0.02


def test_a_wrong_wrench_makes_the_estimate_doubtful(walks) -> None:
    log = walks[0]
    forces = log.forces * np.repeat([1.0, -1.0], 6)  # the sensor of one foot is upside down
    estimate = symgen.identify(walker().robot, replace(log, forces=forces))
    assert estimate.verdict == "doubtful"
    assert "other forces act" in estimate.reasons[-1].text
