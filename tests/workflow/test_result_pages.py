"""Pages of predict, payload and excite: what they say, drawn offline, on two sheets of paper."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from browser import BROWSER, Page, clipped, sheets, visit

import symgen
from symgen.estimation.band import Band
from symgen.estimation.values import Residual, Trace
from symgen.identification.estimate import JointLabel
from symgen.identification.load_result import (
    WITH,
    WITHOUT,
    LoadErrors,
    Payload,
    Quantity,
    read_payload,
)
from symgen.identification.prediction import Prediction
from symgen.report.store import Value, result_page

NAMES = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "upper_arm_joint", "elbow_joint"),
    *("forearm_joint", "wrist_1_joint", "wrist_2_joint"),
)
JOINTS = tuple(JointLabel(k, "N m", name) for k, name in enumerate(NAMES, 1))
BAND = Band(250.0, 20.0, 4.0, "measured")


def torques(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return time and torque of seven joints, (N,) and (N, 7)."""
    t = np.arange(0, 20, 0.02)
    return t, 10 * np.sin(t[:, None] * np.arange(1, 8) / 2 + seed)


def prediction() -> Prediction:
    t, measured = torques(0)
    error = np.array([0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.5])
    trace = Trace("ptp.csv", "validation", "torque", t, measured, measured * (1 - error))
    return Prediction(
        robot="arm7",
        joints=JOINTS,
        log="ptp.csv",
        error=Residual(0.3, tuple(error.tolist())),
        moving=Residual(0.2, tuple(error.tolist())),
        noise=Residual(0.01, (0.01,) * 7),
        band=BAND,
        notes=("ptp.csv: resampled to 250 Hz",),
        torque=trace,
        kinetic=np.cos(t) ** 2,
        potential=np.sin(t),
    )


def load() -> Payload:
    """Without the load a fifth of the torque is missing, with it a hundredth."""
    t, measured = torques(1)
    known = [Quantity(2.0, 0.01), Quantity(0.1, 0.002), Quantity(None, None)]
    return Payload(
        robot="arm7",
        frame=7,
        mass=known[0],
        com=(known[1], known[2], known[1]),
        inertia=(known[1],) * 6,
        identifiable=("mass", "cx", "cz"),
        gain_uncertainty_percent=None,
        residual=LoadErrors(0.2, 0.01, 0.009, (0.2,) * 7, (0.01,) * 7),
        method="weighted least squares of torque",
        band=BAND,
        repairs=(),
        notes=("ptp.csv: resampled to 250 Hz",),
        joints=JOINTS,
        joint=7,
        traces=tuple(
            Trace(log, "train", quantity, t, measured, factor * measured)
            for log in ("carried.csv", "again.csv")
            for quantity, factor in ((WITHOUT, 0.8), (WITH, 0.99))
        ),
    )


@pytest.fixture(scope="module")
def plan() -> symgen.experiment.plan.Plan:
    robot = symgen.read_robot("planar2r")
    named = zip(robot.joints, ("shoulder", "elbow"), strict=True)
    robot = replace(robot, joints=tuple(replace(j, name=name) for j, name in named))
    limits = symgen.Limits(position=((-2, 2), (0, 1)), velocity=(2, 3), acceleration=(8, 8))
    return symgen.excite(
        robot,
        limits=limits,
        motion=symgen.Motion(runs=2, duration=5.0, rate=100.0),
        search=symgen.Search(searches=1, iterations=5),
    )


def test_a_prediction_says_the_error_of_each_joint_in_its_unit_and_in_percent() -> None:
    text = Page(result_page(prediction())).text
    assert "Torque error: 20.0 %" in text
    assert "Noise accounts for 1.00 %" in text
    assert "It is largest on wrist_2_joint (7): 50.0 %" in text
    _, measured = torques(0)
    rms = np.sqrt(np.mean(measured[:, 6] ** 2))
    assert f"wrist_2_joint (7){rms:#.3g} N m{0.5 * rms:#.3g} N m50.0 %" in text


def test_a_payload_says_the_load_and_the_torque_with_and_without_it(tmp_path) -> None:
    text = Page(result_page(load())).text
    assert "the link of wrist_2_joint (7)" in text
    assert "Mass: 2.00 kg, standard deviation 0.0100 kg" in text
    _, measured = torques(1)
    rms = np.sqrt(np.mean(measured[:, 3] ** 2))
    shown = f"elbow_joint (4){0.2 * rms:#.3g} N m, 20.0 %{0.01 * rms:#.3g} N m, 1.00 %"
    assert shown in text
    assert Page(result_page(load())).figures == [[f"{j.label}, N m" for j in JOINTS] * 2]
    for panel, torque in zip(load().plot().panels, [*measured.T] * 2, strict=True):
        np.testing.assert_allclose(panel.series["without the load"], 0.2 * torque, atol=1e-9)
        np.testing.assert_allclose(panel.series["with the load"], 0.01 * torque, atol=1e-9)
    # The folder holds what the page is drawn from.
    symgen.write(load(), tmp_path / "load")
    again = read_payload(tmp_path / "load")
    assert [t.log for t in again.traces] == ["carried.csv"] * 2 + ["again.csv"] * 2
    assert Page(result_page(again)).text == Page(result_page(load())).text


def test_a_motion_is_drawn_within_its_limits(plan) -> None:
    page = Page(result_page(plan))
    assert f"{plan.condition:#.3g}" in page.text
    titles = [f"{name}, % of its limits" for name in ("shoulder (1)", "elbow (2)")]
    assert page.figures == [titles * len(plan.runs)]  # a plot for each joint
    drawn = [panel.series for panel in plan.plot().panels]
    for series in drawn:
        assert (series["upper limit"] == 100).all()
        assert (series["lower limit"] == -100).all()
    # the elbow has 0 to 1 rad and 3 rad/s
    t, run = plan.plot().panels[1].x, plan.runs[0]
    np.testing.assert_allclose(drawn[1]["position"], 200 * (run.at(t)[:, 1] - 0.5), atol=1e-9)
    np.testing.assert_allclose(drawn[1]["velocity"], run.at(t, 1)[:, 1] / 0.03, atol=1e-9)
    tops = [np.abs(series[name]).max() for series in drawn for name in
            ("position", "velocity", "acceleration")]  # fmt: skip
    # Each limit is kept; the largest share is the one of the table, between two samples at most.
    assert max(tops) <= 100.0
    assert max(tops) == pytest.approx(100 * max(u.share for u in plan.uses), rel=0.02)
    for use in plan.uses:
        assert f"{100 * use.share:#.3g}".removesuffix(".") + " %" in page.text


def test_the_arm_is_drawn_at_five_moments_of_the_motion(plan) -> None:
    html = result_page(plan)
    assert html.count('<svg class="robot') == 1
    poses = html.split('<svg class="robot')[1].split("</svg>")[0].split("<g>")[1:]
    assert "The arm after 10, 30, 50, 70 and 90 % of the first run" in html
    q = plan.runs[0].at(np.array([0.5, 1.5, 2.5, 3.5, 4.5]))[:, 0]
    circles = [re.findall(r'<circle cx="(\S+)" cy="(\S+)"', pose) for pose in poses]
    places = np.array(circles, dtype=float)  # moment, joint, coordinate
    assert places.shape == (5, 2, 2)
    assert np.ptp(places[:, 0], axis=0).tolist() == [0, 0]  # the shoulder stays
    # A parallel projection of the elbow, which is on a circle around the shoulder; 0.1 px.
    circle = np.stack([np.cos(q), np.sin(q)], axis=1)
    arms = places[:, 1] - places[:, 0]
    projection = np.linalg.lstsq(circle, arms, rcond=None)[0]
    np.testing.assert_allclose(circle @ projection, arms, atol=0.1)
    assert np.ptp(arms, axis=0).max() > 10


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
@pytest.mark.parametrize("kind", ["prediction", "payload", "plan"])
def test_a_page_opens_offline_fits_a_phone_and_prints_on_two_sheets(kind, plan, tmp_path) -> None:
    result: Value = {"prediction": prediction, "payload": load, "plan": lambda: plan}[kind]()
    html = result_page(result)
    seen = visit(html.replace("<details", "<details open"), tmp_path)
    assert (seen.console, seen.requests) == ((), ())
    assert clipped(html, tmp_path) == {1400: [], 800: [], 390: []}
    assert sheets(html, tmp_path) <= 2
