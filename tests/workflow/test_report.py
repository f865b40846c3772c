"""The report: says what the estimate says, lets no name act as code, opens without a network."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, HOSTILE, Page, below_first_screen, clipped, sheets, visit

import symgen
from symgen.estimation.band import Band
from symgen.estimation.playback import Horizon
from symgen.estimation.torque_error import percent
from symgen.estimation.values import (
    OtherEstimate,
    OtherValue,
    Reason,
    Residual,
    Trace,
)
from symgen.faults.fault import Fault
from symgen.identification.estimate import (
    Alternative,
    Estimate,
    JointLabel,
    ParameterEstimate,
)
from symgen.identification.uses import ParametersUse, PredictionUse, SimulationUse, Uses
from symgen.report.content.parts import horizon_table
from symgen.report.plots import curves as plots
from symgen.report.store import result_page
from symgen.robot import dh


def synthetic(robot: str = "arm2", log: str = "excite.csv", verdict: str = "doubtful") -> Estimate:
    """Two joints, six parameters of which FV2 is weak, three logs in energy and in torque."""
    rng = np.random.default_rng(3)
    values = [
        ("ZZ1R", "ZZ1 + IA1 + L1**2*M2", 1.7, 0.01, "kg m2"),
        ("ZZ2R", "ZZ2 + IA2", 0.2, 0.004, "kg m2"),
        ("MX2", "MX2", -0.31, 0.002, "kg m"),
        ("FS1", "FS1", 3.25, 0.05, "N m"),
        ("FV1", "FV1", 12345.678, 20.0, "N m s/rad"),
        ("FV2", "FV2", 0.02, 0.016, "N m s/rad"),
    ]
    traces = []
    for name, kind in ((log, "train"), ("more.csv", "train"), ("check.csv", "validation")):
        t = np.arange(0.0, 6.0, 0.002)
        for quantity, width in (("energy", 1), ("torque", 2)):
            measured = np.sin(t[:, None] * np.arange(1, width + 1)) * 5
            noise = 0.1 * rng.normal(size=measured.shape)
            traces.append(Trace(name, kind, quantity, t, measured, measured + noise))
    correlation = np.eye(6)
    correlation[0, 1] = correlation[1, 0] = -0.9731
    prior_std = {"ZZ1R": 0.3, "ZZ2R": 0.1, "FS1": 0.5, "FV1": 900.0}  # nothing of the others
    return Estimate(
        joints=tuple(JointLabel(j + 1, "N m") for j in range(7)),
        robot=robot,
        model="energy",
        method="wls",
        parameters=tuple(ParameterEstimate(*v) for v in values),
        condition_number=42.4242,
        train=Residual(0.01234),
        validation=Residual(0.02345),
        torque_train=Residual(0.03456, (0.031, 0.0418)),
        torque_validation=Residual(0.04567, (0.0459, 0.0527)),
        cutoff_hz=8.0,
        window_s=0.2,
        verdict=verdict,
        reasons=(Reason("error", text="10 % error"),) if verdict == "doubtful" else (),
        suspected=(Reason("hardly_moving", (2,), text="joint 2 hardly moves"),),
        notes=("excite.csv: resampled to 500 Hz",),
        correlation=correlation,
        traces=tuple(traces),
        provenance=(("seed", "17"), ("log", log)),
        prior=OtherEstimate(
            "prior",
            tuple(
                OtherValue(v[0], 1.1 * v[2], prior_std[v[0]]) for v in values if v[0] in prior_std
            ),
        ),
        comparison=(
            OtherEstimate(
                "iv", tuple(OtherValue(v[0], 0.99 * v[2], 0.02 * abs(v[2])) for v in values)
            ),
        ),
    )


@pytest.fixture(scope="module")
def html() -> str:
    return result_page(synthetic())


def test_page_holds_verdict_fit_parameters_and_origin(html: str) -> None:
    text = Page(html).text
    for words in (
        *("Identification of arm2", "Doubtful", "10 % error", "joint 2 hardly moves"),
        *("1.23 %", "2.34 %", "3.46 %", "4.57 %", "4.18 %", "5.27 %", "42.4"),
        *("ZZ1 + IA1 + L1**2*M2", "1.70", "-0.310", "12346", "N m s/rad"),
        *("5 of 6", "80.0 %", "excite.csv: resampled to 500 Hz", "seed", "17", "8.0000 Hz"),
        *("1 pair of parameters", "-0.9731"),
        *("Values from prior and other methods", "1.8700", "0.567", "by iv", "1.6830"),
    ):
        assert words in text, words


def test_the_error_in_units_is_the_first_error_of_its_joint() -> None:
    moving = Residual(0.09, (0.08, 0.1))
    text = Page(result_page(replace(synthetic(), moving=moving))).text
    assert "3.61 N m0.289 N m8.00 %" in text
    assert "3.60 N m0.360 N m10.0 %" in text


def test_a_position_error_without_digits_has_no_spread() -> None:
    horizons = Horizon(0.2, 0.5, 0.1, ()), Horizon(1.0, 12.0, 1e-14, ())
    (row,) = horizon_table("model", [("identified", horizons)]).rows
    assert row == ("identified", "50.0 % ± 10.0 %", "over 1000 %")


def test_weak_parameters_are_folded_and_known_ones_are_not(html: str) -> None:
    front, details = html.split('<h2 class="more">')
    known = front.split("Known parameters (5 of 6)")[1].split("</section>")[0]
    names = ["ZZ1R", "ZZ2R", "MX2", "FS1", "FV1"]
    assert re.findall(r'<td class="name">(\w+)</td>', known) == names
    weak = details.split("Weak parameters (1)")[1].split("</details>")[0]
    assert re.findall(r'<td class="name">(\w+)</td>', weak) == ["FV2"]


def test_the_page_says_uses_models_band_and_repairs() -> None:
    whole = Residual(0.0412, (0.03, 0.05))
    estimate = replace(
        synthetic(verdict="trusted"),
        headline="trusted for prediction; 5 of 6 parameters known",
        band=Band(500.0, 12.5, 3.5, "derived"),
        repairs=(Fault("excite.csv", "tau2", "clipped at 14", 37, "masked"),),
        uses=Uses(
            PredictionUse(grade="good"),
            ParametersUse((Reason("weak", text="1 of 6 are weak"),), ("ZZ1R",), 6),
            SimulationUse((Reason("negative_friction", (2,), -0.1, 0.0, "FV2 is negative"),)),
        ),
        alternatives=(
            Alternative("energy", 12.0, whole, whole, 0.04, True, "4 %"),
            Alternative("torque", 9.0, whole, whole, 0.06, False, "6 %"),
            Alternative("momentum", math.inf, None, None, math.inf, False, "no window fits"),
        ),
    )
    text = Page(result_page(estimate)).text
    for words in (
        estimate.headline,
        estimate.band.in_words(),
        "clipped at 14",
        "masked",
        "energy (chosen)",
        "no window fits",
    ):
        assert words in text, words


def test_page_is_self_contained_and_draws_every_log(html: str) -> None:
    page = Page(html)
    joints = ["joint 1, N m", "joint 2, N m"]
    spectra = [f"{joint}/√Hz" for joint in joints]
    assert page.figures == [3 * joints, 3 * ["energy, J"], 3 * ["energy, J/√Hz"], 3 * spectra]
    assert page.text.index("check.csv (validation)") < page.text.index("excite.csv (training)")
    for tag, attrs in page.tags:
        assert tag != "script"
        assert "src" not in attrs
        assert (attrs.get("href") or "#").startswith(("#", "data:"))


def test_same_estimate_gives_the_same_page(html: str) -> None:
    assert result_page(synthetic()) == html


def test_sparse_estimate_has_a_page() -> None:
    bare = synthetic()
    zero = replace(bare.parameters[0], value=0.0)
    unknown = replace(bare.parameters[1], std=float("nan"))
    bare = replace(
        bare, parameters=(zero, unknown), torque_train=None, torque_validation=None, traces=(),
        correlation=np.empty((0, 0)), notes=(), provenance=(), cutoff_hz=None,
        window_s=None, condition_number=float("inf"), prior=None, comparison=(),
    )  # fmt: skip
    page = Page(result_page(bare))
    assert "0 of 2" in page.text
    assert "∞" in page.text
    assert "unknown" in page.text
    assert page.figures == []


def test_spectrum_of_a_sine_has_its_power_at_its_frequency_joint_by_joint() -> None:
    t = np.arange(0.0, 40.0, 0.005)
    sines = np.stack([0.3 * np.sin(2 * np.pi * 7.0 * t), 2.0 * np.cos(2 * np.pi * 21.3 * t)], 1)
    trace = Trace("a", "train", "torque", t, sines + 5, np.full_like(sines, 5))
    figure = plots.residual_spectrum(replace(synthetic(), traces=(trace,)), "torque")
    assert figure is not None
    for k, (amplitude, frequency) in enumerate(((0.3, 7.0), (2.0, 21.3))):
        f, density = plots.amplitude_density(t, sines)
        # Parseval: the integral of the power density is the variance, half the square of a sine's
        power = np.sum(density[:, k] ** 2) * (f[1] - f[0])
        assert power == pytest.approx(amplitude**2 / 2, rel=0.01)
        drawn = figure.panels[k]
        assert drawn.title == f"joint {k + 1}, N m/√Hz"
        top = drawn.x[np.argmax(drawn.series["density of the residual"])]
        assert abs(top - frequency) < 2 * (f[1] - f[0])


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
def test_browser_shows_a_page_in_silence(tmp_path: Path) -> None:
    # names that would act, were they not harmless
    html = result_page(synthetic(robot=HOSTILE, log=HOSTILE))
    seen = visit(html.replace("<details", "<details open"), tmp_path)
    assert seen.console == ()
    assert seen.requests == ()
    assert "<img" not in seen.dom.split("<main>")[1].split("</main>")[0]


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
def test_the_first_screen_has_number_verdict_and_a_plot_of_every_joint(tmp_path: Path) -> None:
    t = np.arange(0.0, 6.0, 0.01)
    torque = 5 * np.sin(t[:, None] * np.arange(1, 8))
    headline = "0.97 % torque error on motion it has not seen (1.16 % over all samples); noise "
    trace = Trace("check.csv", "validation", "torque", t, torque, 0.9 * torque, torque)
    estimate = replace(
        synthetic(),
        traces=(trace,),
        torque_validation=Residual(0.0116, (0.0116,) * 7),
        headline=f"{headline}accounts for 0.18 %. | Good.",
    )
    html = result_page(estimate)
    assert html.index("0.97 %") < html.index("Doubtful") < html.index('class="area"')
    assert html.count('class="area"') == 14  # torques and spectra
    sizes = (1400, 900), (768, 1024), (390, 844)
    assert below_first_screen(html, tmp_path, sizes) == {size: [] for size in sizes}
    assert below_first_screen(html, tmp_path, [(390, 300)]) != {(390, 300): []}


def test_the_first_section_is_torque_and_the_robot_is_drawn() -> None:
    robot = symgen.read_robot("planar2r")
    html = result_page(synthetic(), robot)
    headings = re.findall(r"<h2>(.*?)</h2>", html)
    assert headings[:2] == ["Measured and modelled torque", "Torque error by joint"]
    assert headings.index("Known parameters (5 of 6)") < headings.index("The robot")
    picture = html.split('<svg class="robot"')[1].split("</svg>")[0]
    assert picture.count("<circle") == robot.n
    assert "L1" in html.split("<h2>The robot</h2>")[1].split("</details>")[0]


def test_frames_stand_where_an_independent_table_puts_them() -> None:
    robot = symgen.read_robot("panda")
    model = symgen.derive(robot, ("frames",))
    kernel = symgen.load(model)["frames"](np.zeros(robot.n))
    at_zero = dict.fromkeys((joint.number for joint in robot.movable), 0.0)
    assert np.allclose(dh.frames(robot.with_values(), at_zero)[1:], kernel, atol=1e-12)


@pytest.mark.parametrize(
    ("ratio", "text"),
    [(0.0097, "0.970 %"), (0.9994, "99.9 %"), (0.9996, "100 %"), (1.4, "140 %"), (-1.4, "-140 %"),
     (9.999, "1000 %"), (10.1, "over 1000 %"), (0.0, "0.00 %"), (math.nan, "unknown")],
)  # fmt: skip
def test_percentages_have_no_exponent(ratio: float, text: str) -> None:
    assert percent(ratio) == text


def test_the_page_of_long_logs_of_seven_joints_is_small() -> None:
    t = np.arange(0.0, 60.0, 0.001)
    torque = np.random.default_rng(1).normal(size=(len(t), 7))
    logs = [Trace(f"{k}.csv", "validation", "torque", t, torque, 0.9 * torque, torque) for k in
            range(12)]  # fmt: skip
    errors = Residual(0.1, (0.1,) * 7)
    for count in (1, 12):
        estimate = replace(synthetic(), traces=tuple(logs[:count]), torque_validation=errors)
        page = result_page(estimate)
        assert page.count('class="area"') == 14 * count
        assert len(page.encode()) <= 1_300_000


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
def test_nothing_is_clipped_on_a_wide_screen_a_narrow_one_and_a_phone(tmp_path: Path) -> None:
    estimate = replace(
        synthetic(verdict="trusted"),
        headline="1 of 6 are weak: FV2; " * 5,
        suspected=(),
        alternatives=(
            Alternative("energy", 12.0, Residual(0.04), Residual(0.04), 0.04, True, "4 % " * 9),
            Alternative("torque", 9.0, Residual(0.06), Residual(0.06), 0.06, False, "6 %"),
        ),
        repairs=(Fault("excite.csv", "tau2", "clipped at 14", 37, "masked"),),
    )
    html = result_page(estimate, symgen.read_robot("panda"))
    assert clipped(html, tmp_path) == {1400: [], 800: [], 390: []}
    assert sheets(html, tmp_path) <= 2


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
def test_browser_check_sees_a_request_and_an_error(tmp_path: Path) -> None:
    html = "<img src='http://a.invalid/x.png'><script>console.error('spoiled')</script>"
    seen = visit(html, tmp_path)
    assert seen.requests
    assert any("spoiled" in line for line in seen.console)
