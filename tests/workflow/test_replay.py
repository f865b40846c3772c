"""The motion of a model under measured torques: against closed forms, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from browser import Page
from oracles.planar2r import torque_regressor
from scipy.integrate import solve_ivp
from support_diagnose import whole_gap

import symgen
from symgen.codegen.model import derive
from symgen.diagnosis import replay
from symgen.diagnosis.diagnosis import Curves, Diagnosis, FoundEffect, FoundParameter
from symgen.diagnosis.replay import driven, replayed, worst
from symgen.errors import SymgenError
from symgen.report.store import result_files
from symgen.robot.types import Robot
from symgen.runtime.evaluator import load
from symgen.runtime.plant import KERNELS

W = 2 * np.pi  # of the feedback, rad/s
SLIDER = """
[robot]
name = "slider"
gravity = [0.0, -9.81, 0.0]
[[joint]]
sigma = 1
friction = [{friction}]
rotor_inertia = false
"""


def slider(friction: str = "") -> Robot:
    return symgen.parse_robot(SLIDER.format(friction=friction))


def curves(t: np.ndarray, q: np.ndarray, qd: np.ndarray, tau: np.ndarray, gap=0.0) -> Curves:
    """Measured motion and torque of a log named "v" whose model before misses `gap`."""
    return Curves("v", t, q, qd, tau, tau - gap, tau)


def pushed(d: float, mass: float, end: float = 3.0) -> Diagnosis:
    """A slider that a constant torque d pushes, which the model before does not know of."""
    t = np.arange(0, end, 0.025)
    q, qd, qdd = (0.2 * W**k * np.sin(W * t + k * np.pi / 2)[:, None] for k in (0, 1, 2))
    # d is on the joint; its motor has to work against it.
    seen = curves(t, q, qd, mass * qdd - d, np.full_like(q, -d))
    effect = FoundEffect("torque_offset", (1,), (), "", 0.0, 1.0)
    parameters = (FoundParameter("M1", mass, 0.1, "kg"), FoundParameter("OF1", -d, 0.1, "N"))
    return Diagnosis(
        robot="slider", verdict="explained", cutoff_hz=10.0, before=whole_gap((0.1,)),
        after=whole_gap((0.0,)), floor=whole_gap((0.0,)), where=(), effects=(effect,), rejected=(),
        tried=1, advice=(), notes=(),
        parameters=parameters, extended=slider('"offset"'), joints=(1,), curves=(seen,),
        declared=slider(), values=(mass,),
    )  # fmt: skip


def test_a_missed_constant_force_moves_as_the_linear_equation_says() -> None:
    d, mass = 1.5, 4.0
    found = pushed(d, mass)
    moved = replayed(found)
    t = moved.t - moved.t[0]
    step = -d / (mass * W**2) * (1 - (1 + W * t) * np.exp(-W * t))
    assert moved.units == ("m",)
    assert moved.before[:, 0] == pytest.approx(step, abs=1e-5)
    assert moved.after[:, 0] == pytest.approx(0 * t, abs=1e-5)
    content = moved.to_json()
    assert content["before"] == [pytest.approx(np.sqrt(np.mean(step**2)), rel=1e-3)]
    assert (content["log"], content["start"], content["unit"]) == ("v", 0.0, ["m"])


def test_two_coupled_joints_move_as_a_plain_integration_of_the_closed_form() -> None:
    X, believed, length = np.array([1.7, 0.15, 0.3, 0.02]), np.array([1.9, 0.2, 0.2, -0.05]), 0.5
    a, w, phase = np.array([0.7, 0.9]), np.array([3.0, 4.0]), np.array([0.0, 1.0])

    def aim(t, k):
        return a * w**k * np.sin(np.multiply.outer(t, w) + phase + k * np.pi / 2)

    def torque(t):
        return torque_regressor(aim(t, 0), aim(t, 1), aim(t, 2), length) @ X

    def slope(t, x):
        q, qd = x[:2], x[2:]
        rest = np.zeros(2)
        M = np.stack([torque_regressor(q, rest, e, length) @ believed for e in np.eye(2)], axis=1)
        h = torque_regressor(q, qd, rest, length) @ believed
        pull = W**2 * (aim(t, 0) - q) + 2 * W * (aim(t, 1) - qd)
        return np.concatenate([qd, np.linalg.solve(M, torque(t) - h) + pull])

    t = np.arange(0, 3, 0.02)
    start = np.concatenate([aim(0.0, 0), aim(0.0, 1)])
    oracle = solve_ivp(slope, (t[0], t[-1]), start, t_eval=t, rtol=1e-10, atol=1e-10)
    model = derive(symgen.read_robot("planar2r"), KERNELS)
    seen = curves(t, aim(t, 0), aim(t, 1), torque(t))
    q = driven(load(model, backend="casadi"), believed, seen, t)
    assert np.abs(oracle.y[:2].T - seen.q).max() > 0.05
    assert q == pytest.approx(oracle.y[:2].T, abs=1e-4)


def test_friction_that_is_not_missed_leaves_a_joint_at_rest() -> None:
    t = np.arange(0, 2, 0.025)
    still = np.zeros((len(t), 1))
    seen = curves(t, still + 0.3, still, still + 0.9)
    model = derive(slider('"coulomb"'), KERNELS)
    q = driven(load(model, backend="casadi"), np.array([2.0, 1.0]), seen, t)
    assert (q == 0.3).all()


def test_the_window_is_where_the_gap_in_units_of_each_torque_is_largest() -> None:
    t = np.arange(0, 20, 0.025)
    tau = np.stack([100 * np.sin(t), np.sin(t)], axis=1)

    def log(name: str, joint: int, height: float, at: float) -> Curves:
        gap = np.zeros_like(tau)
        gap[:, joint] = height * (np.abs(t - at) < 1)
        return Curves(name, t, tau, tau, tau, tau - gap, tau)

    # 5 N m of joint 1 are 7 % of its torque, 0.3 N m of joint 2 are 42 %.
    seen, window = worst([log("a", 0, 5.0, 4.0), log("b", 1, 0.3, 12.0), log("c", 1, 0.2, 8.0)])
    assert seen.name == "b"
    inside = t[window]
    assert inside[-1] - inside[0] == pytest.approx(3.0)
    assert inside[0] <= 11.03
    assert inside[-1] >= 12.97
    free = np.ones(tau.shape, dtype=bool)
    free[430:530, 1] = False  # all that is wrong in b
    masked = replace(seen, free=free)
    assert worst([masked, log("c", 1, 0.2, 8.0)])[0].name == "c"
    alone = worst([masked])[1]
    assert free[alone].all()
    assert alone.stop - alone.start == 121
    with pytest.raises(SymgenError, match="no validation log"):
        worst([replace(seen, free=np.zeros(tau.shape, dtype=bool))])
    short = replace(seen, t=t[:60], measured=tau[:60], before=0.5 * tau[:60])
    assert worst([short])[1] == slice(0, 60)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"verdict": "bad-measurement"}, "the measurement is wrong"),
        ({"declared": None}, "declared robot"),
        ({"curves": ()}, "no validation log"),
        ({"curves": pushed(1, 1, end=0.5).curves}, "1 s of motion"),
        ({"values": ()}, "the model before: its parameters"),
        ({"values": (float("nan"),)}, "the model before: its parameters"),
        ({"values": (-1.0,)}, "the model before: t = 0 s: the mass matrix is not positive"),
        ({"values": (0.0,)}, "the model before: t = 0 s: the mass matrix is not positive"),
        ({"effects": (FoundEffect("thermal_drift", (1,), (), "", 0, 1, declared=False),)},
         "without thermal_drift"),
    ],
)  # fmt: skip
def test_what_cannot_be_shown_is_refused_in_one_line(changes, words) -> None:
    found = replace(pushed(1.5, 4.0), **changes)
    with pytest.raises(SymgenError, match=words) as caught:
        replayed(found)
    assert "\n" not in str(caught.value)


def test_friction_that_drives_and_a_motion_too_stiff_are_refused(monkeypatch) -> None:
    found = pushed(1.5, 4.0)
    driving = replace(found, declared=slider('"coulomb"'), values=(4.0, -1.0))
    with pytest.raises(SymgenError, match="the model before: FS1 = -1"):
        replayed(driving)
    monkeypatch.setattr(replay, "_MOST", 100)
    with pytest.raises(SymgenError, match="the model before: it is too stiff"):
        replayed(found)


def test_files_without_a_motion_are_whole_and_a_note_says_why() -> None:
    whole, bare = pushed(1.5, 4.0), replace(pushed(1.5, 4.0), values=(-1.0,))
    with_motion, without = result_files(whole), result_files(bare)
    assert set(with_motion) == set(without)
    contents = [json.loads(f["diagnosis.json"]) for f in (with_motion, without)]
    assert contents[0]["replay"]["after"] < contents[0]["replay"]["before"]
    assert contents[0]["notes"] == []
    assert contents[1]["replay"] is None
    assert len(contents[1]["notes"]) == 1
    pages = [Page(f["report.html"].decode()) for f in (with_motion, without)]
    assert len(pages[0].figures) == len(pages[1].figures) + 1
    assert "no motion under the measured torques: the model before" in pages[1].text
