"""The page and the files of a diagnosis say what it says, let no name act, open offline."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, HOSTILE, Page, clipped, visit
from support_diagnose import whole_gap

import symgen
from symgen.diagnosis.diagnosis import (
    MARKER,
    Alike,
    Curves,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gaps,
    Place,
    Rejected,
    read_diagnosis,
)
from symgen.faults.mended import MendedChannel, largest_repairs, mended_channels
from symgen.faults.repair import open_samples
from symgen.files import write_folder
from symgen.report.html import page as html_page
from symgen.report.plots import diagnosis as diagnosis_plots
from symgen.report.store import content, result_files


def synthetic(name: str = "test.csv", robot: str = "planar2r") -> Diagnosis:
    """Two joints, two logs, a spring on joint 2 that a cable resembles, and a ripple on joint 1."""
    rng = np.random.default_rng(5)
    curves = []
    for log in (name, "again.csv"):
        t = np.arange(0, 8, 0.01)
        q = np.stack([np.sin(t), np.cos(1.3 * t)], axis=1)
        qd = np.gradient(q, t, axis=0)
        before = 4 * q + qd
        after = before + np.stack([0 * t, 0.8 * q[:, 1]], axis=1)
        measured = after + 0.02 * rng.normal(size=q.shape)
        residuals = measured - before, measured - after
        qdd = np.gradient(qd, t, axis=0)
        curves.append(Curves(log, t, q, qd, qdd, measured, before, after, residuals))
    spring = FoundEffect(
        "gravity_spring",
        (2,),
        (FoundParameter("K2", 0.81234, 0.0123, "N m/rad"),),
        "-K2*q2",
        1e-12,
        0.9321,
        (Alike("cable_torque", (2,)), Alike("torque_ripple", (1,))),
        "motion over the whole range of the joint",
    )
    ripple = FoundEffect(
        "torque_ripple",
        (1,),
        (
            FoundParameter("RS1", -0.051, 0.004, "N m"),
            FoundParameter("RC1", 0.02, 0.004, "N m"),
            FoundParameter("k1", 12.0, float("nan"), ""),
        ),
        "RS1*sin(k1*q1) + RC1*cos(k1*q1)",
        float("nan"),
        0.05,
        declared=False,
    )
    return Diagnosis(
        robot=robot,
        verdict="partly-explained",
        cutoff_hz=8.25,
        before=whole_gap((0.031, 0.212)),
        after=whole_gap((0.0299, 0.0131)),
        floor=whole_gap((0.009, float("nan"))),
        moving=Gaps(
            whole_gap((0.029, 0.198)),
            whole_gap((0.0281, 0.0122)),
            whole_gap((0.009, float("nan"))),
        ),
        where=(Place(2, 0.97, "position"), Place(1, 0.03, "spectrum")),
        effects=(spring, ripple),
        rejected=(Rejected("time_delay", (), "it explains too little"),),
        advice=("look at the portraits",),
        notes=("test.csv: resampled to 500 Hz",),
        extended=symgen.read_robot("planar2r"),
        joints=(1, 2),
        curves=tuple(curves),
        tried=321,
        parameters=(FoundParameter("ZZ1R", 3.5, 0.02, "kg m2"),),
    )


def diagnosis_page(diagnosis: Diagnosis) -> str:
    return html_page(content(diagnosis))


@pytest.fixture(scope="module")
def html() -> str:
    return diagnosis_page(synthetic())


def channel(log: str, number: int, size: float) -> MendedChannel:
    """A channel with a spike at 1 s that was taken out."""
    t = np.arange(0.5, 1.5, 0.01)
    spike = np.where(np.abs(t - 1) < 0.005, 2.0, np.sin(t))
    both = np.stack([t, spike]), np.stack([t, np.sin(t)])
    return MendedChannel(log, f"q{number}", "a spike: taken out", "rad", *both, size)


def test_a_repair_is_drawn_once_as_recorded_and_as_repaired_each_at_its_scale() -> None:
    channels = channel("a.csv", 1, 1.0), channel("a.csv", 2, 0.5), channel("b.csv", 1, 0.2)
    figure = diagnosis_plots.repaired(replace(synthetic(), mended=channels))
    assert figure is not None
    assert [panel.title for panel in figure.panels] == [
        *("q1 of a.csv, rad: a spike: taken out", "q1 of a.csv, rad: repaired"),
        *("q1 of b.csv, rad: a spike: taken out", "q1 of b.csv, rad: repaired"),
    ]
    recorded, repaired = (next(iter(p.series.values())) for p in figure.panels[:2])
    assert recorded[1].max() == 2.0
    assert repaired[1].max() < 1.0


def spoiled_log(seed: int, **fault: bool) -> symgen.Log:
    """The paper's arm, of which q2 wraps and tau1 jumps for single samples."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 6, 0.005)
    q = np.stack([np.sin(2 * t), 2.5 + np.cos(1.7 * t)], axis=1)
    tau = np.stack([5 * np.cos(2 * t), 3 * np.sin(1.7 * t)], axis=1)
    tau += 0.01 * rng.normal(size=q.shape)
    if fault.get("spikes"):
        tau[[300, 700], 0] += [90.0, -120.0]
    if fault.get("turns"):
        q[:, 1] = np.mod(q[:, 1] + np.pi, 2 * np.pi) - np.pi
    return symgen.make_log(f"log {seed}", t, q, tau)


def test_pictures_are_of_the_place_and_at_most_eight() -> None:
    log = spoiled_log(1, spikes=True, turns=True)
    robot = symgen.read_robot("planar2r")
    samples, repairs = open_samples(log, robot)
    found = largest_repairs(mended_channels([(log, samples)], repairs, robot.sigma))
    assert {c.channel for c in found} == {"q2", "tau1"}
    by = {c.channel: c for c in found}
    t, x = by["tau1"].recorded
    assert t[0] <= 700 * 0.005 <= t[-1] < t[0] + 1.0
    assert np.min(x) < -80
    assert np.abs(by["tau1"].repaired[1]).max() < 6
    assert np.ptp(by["q2"].repaired[1]) < 3.0 < np.ptp(by["q2"].recorded[1])
    assert len(largest_repairs([channel("a.csv", k, 1.0) for k in range(12)])) == 8
    assert not [*mended_channels([(log, samples)], (), robot.sigma)]


def test_page_holds_verdict_gap_effects_and_what_was_rejected(html: str) -> None:
    text = Page(html).text
    for words in (
        *(
            "Diagnosis of planar2r",
            "Partly explained",
            "the torque error falls",
            "15.2 %",
            "19.8 %",
            "all samples",
            "15.2 %",
        ),
        *(
            "gravity_spring on joint 2",
            "0.812",
            "0.012",
            "N m/rad",
            "-K2*q2",
            "93.2 %",
            "probability",
        ),
        *("cable_torque, torque_ripple on joint 1", "motion over the whole range", "searched"),
        *("time_delay", "the whole arm", "it explains too little", "321", "8.250 Hz", "97 %"),
        *("C code cannot contain torque_ripple",),
        *("look at the portraits", "resampled to 500 Hz", "test.csv, again.csv", "ZZ1R", "3.50"),
    ):
        assert words.lower() in text.lower(), words


def test_only_adopted_effects_are_missing_from_the_robot_file() -> None:
    found = synthetic()
    spring, ripple = found.effects
    suspected = replace(found, effects=(spring, replace(ripple, adopted=False)))
    assert "cannot contain" not in Page(diagnosis_page(suspected)).text


def test_the_first_plot_is_the_residual_before_and_after_over_what_it_depends_on(html: str) -> None:
    assert re.findall(r"<h2>(.*?)</h2>", html)[:2] == ["Residual over what it depends on", "Torque"]
    assert Page(html).figures[0] == 2 * ["joint 2, N m"]  # two logs; 97 % of the gap is there
    first = html.split('class="curves"')[1]
    for words in ("residual before</span>", "residual after</span>", ">position, rad</p>"):
        assert words in first, words


#: Where the gap is, and what the first plot shows of it: joints, abscissae, arrays of the curves.
OVER = {
    "velocity": ("speed, rad/s", lambda c: c.qd[:, 1]),
    "reversal": ("position, rad", lambda c: c.q[:, 1]),
    "acceleration": ("acceleration, rad/s2", lambda c: c.qdd[:, 1]),
    "load": ("modelled torque, N m", lambda c: c.before[:, 1]),
    "other-joint": ("speed of joint 1, rad/s", lambda c: c.qd[:, 0]),
    "time": ("time, s", lambda c: c.t),
}


@pytest.mark.parametrize("pattern", OVER)
def test_the_abscissa_of_the_first_plot_is_that_of_the_pattern(pattern: str) -> None:
    found = synthetic()
    coupled = replace(found.effects[0], name="coupled_transmission", joints=(1, 2))
    found = replace(found, where=(Place(2, 1.0, pattern),), effects=(coupled,))
    figure, (label, x) = found.plot(), OVER[pattern]
    for panel, c in zip(figure.panels, found.curves, strict=True):
        assert panel.xlabel == label
        for name, residual in zip(("before", "after"), c.residuals, strict=True):
            drawn = panel.series[f"residual {name}"].T
            every = np.column_stack([x(c), residual[:, 1]])
            assert {*map(tuple, drawn.tolist())} <= {*map(tuple, every.tolist())}
            assert len(drawn) == 350  # 500 in two logs, and 100 in each


def test_the_first_plot_has_as_many_joints_as_most_of_the_gap_needs() -> None:
    found = replace(synthetic(), where=(Place(2, 0.6, "all"), Place(1, 0.4, "velocity")))
    labels = [(panel.title, panel.xlabel) for panel in found.plot().panels[:3]]
    assert labels == [
        ("joint 2, N m", "speed, rad/s"),
        ("joint 2, N m", "position, rad"),
        ("joint 1, N m", "speed, rad/s"),
    ]


def test_the_torques_have_the_model_before_and_after_and_the_page_the_command() -> None:
    figure = diagnosis_plots.torques(synthetic())
    assert figure is not None
    assert [*figure.looks] == ["measured", "before", "after"]
    command = "symgen identify why/robot.toml a.csv --into why-better"
    assert command in Page(diagnosis_page(replace(synthetic(), command=command))).text
    assert "LOG" not in Page(diagnosis_page(synthetic())).text


def test_the_residual_falls_by_the_effect_that_was_added() -> None:
    panels = synthetic().plot("Residual of every joint").panels[:6]
    over = [x for x in ("time, s", "speed, rad/s", "position, rad") for _ in range(2)]
    assert [p.xlabel for p in panels] == over
    # joint 2 over its position: the spring of the synthetic log, 0.8 q
    q, before = panels[-1].series["residual before"]
    np.testing.assert_allclose(before - panels[-1].series["residual after"][1], 0.8 * q, atol=1e-9)


def test_without_an_adopted_effect_there_is_nothing_after() -> None:
    found = synthetic()
    suspected = replace(found, effects=tuple(replace(e, adopted=False) for e in found.effects))
    assert [*suspected.plot().looks] == ["residual before"]


def test_hostile_names_add_no_element() -> None:
    found = synthetic(HOSTILE, HOSTILE)
    effect = replace(found.effects[0], name=HOSTILE, expression=HOSTILE, separate=HOSTILE)
    spoiled = replace(
        found, effects=(effect, *found.effects[1:]), advice=(HOSTILE,), notes=(f"{HOSTILE}!",),
        rejected=(Rejected(HOSTILE, (), HOSTILE),),
        mended=(replace(channel(HOSTILE, 1, 1.0), channel=HOSTILE, says=HOSTILE, unit=HOSTILE),),
    )  # fmt: skip
    page = Page(diagnosis_page(spoiled))
    harmless = replace(synthetic(), mended=(channel("a.csv", 1, 1.0),))
    plain = Page(diagnosis_page(harmless))
    assert [tag for tag, _ in page.tags] == [tag for tag, _ in plain.tags]
    assert not any(key.startswith("on") for _, attrs in page.tags for key in attrs)


#: What HTML and LaTeX read as more than a name.
NAMES = (
    "a \"quoted\" 'joint' <b>bold</b> & $x_1$ </script><img src=x onerror=alert(1)>",
    "$\\frac{1}{2}$ 肩_😀_שלום %{x} {y} %{meta[0]} " + "long_name_without_any_break_" * 5,
)


@pytest.mark.skipif(BROWSER is None, reason="neither chromium nor google-chrome on PATH")
def test_names_of_joints_and_logs_are_shown_as_they_are(tmp_path: Path) -> None:
    planar = symgen.read_robot("planar2r")
    joints = [replace(j, name=name) for j, name in zip(planar.joints, NAMES, strict=True)]
    found = replace(synthetic(NAMES[0]), extended=replace(planar, joints=tuple(joints)))
    html = diagnosis_page(found)
    assert clipped(html, tmp_path) == {1400: [], 800: [], 390: []}
    seen = visit(html, tmp_path)
    assert seen.console == ()
    assert seen.requests == ()
    for name in ("<b>bold</b> & $x_1$", "שלום %{x} {y}"):
        assert name in unescape(re.sub("<[^>]*>", "", seen.dom)), name


def test_sparse_diagnosis_has_a_page() -> None:
    bare = replace(
        synthetic(), verdict="consistent", effects=(), where=(), rejected=(), advice=(), notes=(),
        curves=(), parameters=(), cutoff_hz=None, before=whole_gap((0.0, 0.0)),
        after=whole_gap((0.0, 0.0)),
        floor=whole_gap((0.0, 0.0)),
    )  # fmt: skip
    assert Page(diagnosis_page(bare)).figures == []


def test_a_diagnosis_is_read_as_it_was_but_for_its_curves(tmp_path: Path) -> None:
    write_folder(tmp_path / "why", result_files(synthetic()), MARKER)
    again = read_diagnosis(tmp_path / "why")
    kept = replace(again, notes=again.notes[: len(synthetic().notes)], digests=None)
    known = synthetic().to_json()
    assert repr(kept.to_json()) == repr(known)
    assert again.extended == synthetic().extended
    assert Page(diagnosis_page(again)).figures == []
    file = tmp_path / "why" / MARKER
    content = json.loads(file.read_text())
    for spoil in (
        lambda c: c["effects"][0].pop("name"),
        lambda c: c.update(verdict="perfect"),
        lambda c: c["gap"]["before"].update(per_joint=[0.1]),
        lambda c: c.update(where=3),
    ):
        spoiled = json.loads(json.dumps(content))
        spoil(spoiled)
        file.write_text(json.dumps(spoiled))
        with pytest.raises(symgen.ParameterError, match=r"diagnosis\.json: damaged .*accepted: "):
            read_diagnosis(file)
