"""symgen report: results read and printed again, two estimates compared, pages in a browser."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from browser import Page
from oracles.arm import save_planar2r

import symgen
from symgen.estimation.values import Residual
from symgen.identification.estimate import Estimate, JointLabel, ParameterEstimate
from symgen.report.store import result_files, result_page


@pytest.fixture
def refused(run):
    def call(*arguments, words=()):
        code, out, lines = run(*arguments)
        assert (code, out, len(lines)) == (2, "", 1), lines
        for word in words:
            assert word in lines[0], lines[0]

    return call


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return [save_planar2r(folder / f"log{seed}.npz", seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def estimates(logs):
    return [
        symgen.identify("planar2r", log, validation=logs[2], model="energy") for log in logs[:2]
    ]


@pytest.fixture(scope="module")
def folders(estimates, tmp_path_factory):
    root = tmp_path_factory.mktemp("results")
    for name, estimate in zip(("a", "b"), estimates, strict=True):
        (root / name).mkdir()
        for file, content in result_files(estimate).items():
            (root / name / file).write_bytes(content)
    return root / "a", root / "b"


def test_a_folder_of_another_result_is_named(tmp_path) -> None:
    (tmp_path / "diagnosis.json").write_text("{}")
    with pytest.raises(symgen.ParameterError, match=r"has diagnosis\.json .* next:"):
        symgen.read_estimate(tmp_path)


def small(*parameters: tuple, robot: str = "arm", provenance: tuple = ()) -> Estimate:
    """An estimate of (name, expression, value, std) with nothing else in it."""
    return Estimate(
        robot=robot, joints=(JointLabel(1, "N m"),), model="energy", method="wls",
        parameters=tuple(
            ParameterEstimate(*p[:4], p[4] if len(p) > 4 else "kg m2") for p in parameters
        ),
        condition_number=12.5, train=Residual(0.01), validation=Residual(0.02), cutoff_hz=None,
        window_s=0.2, verdict="trusted", reasons=(), provenance=provenance,
    )  # fmt: skip


# Two estimates


def test_differences_are_those_computed_by_hand() -> None:
    a = small(("A", "A", 10.0, 0.3), ("B", "B", -2.0, 0.6), ("C", "C", 1.0, 0.0))
    b = small(("A", "A", 12.0, 0.4), ("B", "B", -1.0, 0.8), ("C", "C", 1.5, 0.0))
    found = symgen.compare(a, b)
    assert [p.std for p in found.parameters] == [pytest.approx(0.5), pytest.approx(1.0), 0.0]
    sigmas = [p.sigmas for p in found.parameters]
    assert sigmas[:2] == [pytest.approx(4.0), pytest.approx(1.0)]
    assert math.isnan(sigmas[2])
    assert [p.name for p in found.moved] == ["A"]
    assert found.verdict == "differ"
    # 2 judged ones, each beyond 3 std with probability 0.0027
    assert "1 of 2 parameters" in found.summary
    assert "would move 0.0054 of them" in found.summary
    content = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert content["parameters"][0]["difference"] == 2.0
    assert content["parameters"][2]["sigmas"] is None
    with pytest.raises(AttributeError):
        found.notes = ()


def test_verdicts() -> None:
    a = small(("A", "A", 10.0, 0.3))
    assert symgen.compare(a, small(("A", "A", 11.4, 0.4))).verdict == "agree"
    assert symgen.compare(a, small(("A", "A", 8.4, 0.4))).verdict == "differ"
    nothing = small(("A", "A", 10.0, math.nan))
    assert symgen.compare(a, nothing).verdict == "unknown"


def test_other_robots_and_nothing_in_common_are_refused() -> None:
    a = small(("A", "A", 1.0, 0.1))
    with pytest.raises(symgen.ParameterError, match="robots arm and leg; accepted"):
        symgen.compare(a, small(("A", "A", 1.0, 0.1), robot="leg"))
    with pytest.raises(symgen.ParameterError, match="no parameter has the same name"):
        symgen.compare(a, small(("B", "B", 1.0, 0.1)))


def test_two_estimates_from_one_log_never_agree(logs) -> None:
    """Judged by another log or by its own end: another part of it is taken, and another digest."""
    whole = symgen.identify("planar2r", logs[0], validation=logs[2], model="energy")
    part = symgen.identify("planar2r", logs[0], model="energy")
    for found in (symgen.compare(whole, part), symgen.compare(part, part)):
        assert not found.moved
        assert found.verdict == "unknown"
        assert "this shows no agreement" in found.summary


def test_estimates_of_independent_noise_agree(estimates) -> None:
    found = symgen.compare(*estimates)
    assert found.verdict == "agree"
    assert all(0 < abs(p.sigmas) < 3 for p in found.parameters)


# Reading again


def test_an_estimate_is_read_as_it_was(estimates, folders) -> None:
    for source in (folders[0], str(folders[0] / "estimate.json")):
        again = symgen.read_estimate(source)
        assert again.to_json() == estimates[0].to_json()
    assert np.array_equal(again.covariance, estimates[0].covariance)
    for ours, theirs in zip(estimates[0].traces, again.traces, strict=True):
        assert (ours.log, ours.kind) == (theirs.log, theirs.kind)
        assert np.allclose(ours.predicted, theirs.predicted, rtol=1e-6)
        assert np.array_equal(ours.t, theirs.t)
    pages = [Page(result_page(e)) for e in (estimates[0], again)]
    assert len(pages[0].figures) == len(pages[1].figures) == 4
    assert pages[0].text == pages[1].text


def test_a_result_is_written_as_its_command_does(estimates, tmp_path) -> None:
    paths = symgen.write(estimates[0], tmp_path / "written", more={"own.txt": b"mine"})
    assert {p.name: p.read_bytes() for p in paths} == result_files(estimates[0]) | {
        "own.txt": b"mine"
    }
    assert np.array_equal(symgen.read_estimate(tmp_path / "written").X, estimates[0].X)
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "notes.txt").write_text("not ours")
    with pytest.raises(symgen.PackageError, match=r"notes\.txt"):
        symgen.write(estimates[0], tmp_path / "theirs")


def test_an_estimate_without_curves_or_with_the_first_keys_only_is_read(folders, tmp_path) -> None:
    content = json.loads((folders[0] / "estimate.json").read_text())
    first = ("schema", "robot", "model", "method", "parameters", "condition_number", "residual",
             "torque_residual", "cutoff_hz", "window_s", "verdict", "reasons")  # fmt: skip
    kept = {key: content[key] for key in first} | {"schema": "symgen.estimate/1"}
    (tmp_path / "e.json").write_text(json.dumps(kept))
    old = symgen.read_estimate(tmp_path / "e.json")
    assert old.traces == ()
    assert (old.band, old.repairs, old.alternatives, old.uses) == (None, (), (), None)
    assert old.joints == (JointLabel(1, "N m or N"), JointLabel(2, "N m or N"))
    assert Page(result_page(old)).figures == []
    assert symgen.compare(old, folders[0]).verdict == "agree"


@pytest.mark.parametrize(
    "spoil",
    [
        lambda c: c.pop("robot"),
        lambda c: c.update(parameters=[]),
        lambda c: c["parameters"].append(c["parameters"][0]),
        lambda c: c["parameters"][0].update(value="1"),
        lambda c: c.update(parameters=3),
        lambda c: c.update(residual=None),
        lambda c: c.update(correlation=[[1.0]]),
        lambda c: c.update(correlation=[[1.0], 2]),
        lambda c: c.update(physical=[]),
        lambda c: c.update(schema="symgen.estimate/9"),
    ],
)
def test_a_damaged_estimate_is_refused_in_a_line(refused, folders, tmp_path, spoil) -> None:
    content = json.loads((folders[0] / "estimate.json").read_text())
    spoil(content)
    (tmp_path / "estimate.json").write_text(json.dumps(content))
    refused("report", tmp_path, words=("estimate.json", "accepted: ", "symgen.estimate/2"))


# The command


def test_the_estimate_is_printed_again(run, logs, tmp_path) -> None:
    into = tmp_path / "out"
    first = run("identify", "planar2r", logs[0], "--validation", logs[2], "--into", into)
    again = run("report", into)
    assert first[0] == again[0] == 0
    assert "\x1b" not in again[1]
    assert again[1] == "".join(
        line
        for line in first[1].splitlines(keepends=True)
        if not line.startswith(("written", "next"))
    )
    content = json.loads((into / "estimate.json").read_text())
    content.update(verdict="doubtful", reasons=[{"kind": "error", "text": "because"}], headline="")
    (into / "estimate.json").write_text(json.dumps(content))
    code, out, _ = run("report", into / "estimate.json")
    assert code == 1
    assert "\nverdict: doubtful\n  because\n" in out


def test_two_estimates_are_compared(run, folders, tmp_path) -> None:
    page = tmp_path / "new" / "ab.html"
    code, out, err = run("report", *folders, "--into", page)
    assert (code, err) == (0, [])
    assert "\x1b" not in out
    for words in (
        "verdict: agree\n  0 of 4 parameters",
        "ZZ1R",
        "distance, std",
        "independent data",
    ):
        assert words in out, words
    assert page.read_text("utf-8").startswith("<!DOCTYPE html>")
    assert [p.name for p in page.parent.iterdir()] == ["ab.html"]


def test_moved_parameters_give_exit_code_1_and_are_named(run, folders, tmp_path) -> None:
    content = json.loads((folders[1] / "estimate.json").read_text())
    p = content["parameters"][0]
    p["value"] += 10 * p["std"]
    (tmp_path / "estimate.json").write_text(json.dumps(content))
    code, out, _ = run("report", folders[0], tmp_path)
    assert code == 1
    assert "verdict: differ\n  1 of 4" in out
    assert "  - ZZ1R: " in out


def test_pages_are_not_written_over_anything(refused, folders, tmp_path) -> None:
    (tmp_path / "mine.html").write_text("mine")
    refused("report", folders[0], "--into", tmp_path / "mine.html", words=("exists", "accepted"))
    assert (tmp_path / "mine.html").read_text() == "mine"
    refused("report", folders[0], "--into", tmp_path / "page", words=("ends in .html",))
    assert [p.name for p in tmp_path.iterdir()] == ["mine.html"]


def test_wrong_folders_are_refused_in_a_line(refused, folders, tmp_path) -> None:
    accepted = "accepted: a folder that identify"
    refused("report", tmp_path / "nowhere", words=("it is not there", accepted))
    refused("report", tmp_path, words=("it holds no result", accepted))
    for name in ("estimate.json", "prediction.json"):
        (tmp_path / name).write_text("{}")
    refused("report", tmp_path, words=("estimate.json and prediction.json", accepted))
    refused("report", tmp_path / "estimate.json", words=("its schema is None",))
    (tmp_path / "robot.toml").write_text("")
    refused("report", tmp_path / "robot.toml", words=(accepted,))
    refused("report", folders[0], tmp_path / "nowhere", words=("nowhere", "accepted"))
    refused("report", folders[0], folders[1], folders[0])
    refused("report")


def test_a_prediction_is_printed_again(run, refused, folders, logs, tmp_path) -> None:
    into, page = tmp_path / "out", tmp_path / "page.html"
    first = run("predict", "planar2r", logs[1], "--parameters", folders[0] / "estimate.json",
                "--into", into)  # fmt: skip
    again = run("report", into, "--into", page)
    assert first[0] == again[0] == 0
    lines = [[x for x in out.splitlines() if not x.startswith("written")]
             for _, out, _ in (first, again)]  # fmt: skip
    assert lines[0] == lines[1]
    found = Page(page.read_text("utf-8"))
    assert len(found.figures) == 2
    assert "joint 2" in found.text
    (into / "prediction.csv").write_text("t\n1\n")
    refused("report", into, words=("damaged", "prediction.csv", "accepted"))


# What an estimate holds beside


def test_a_prior_stands_beside_the_estimate(logs, folders, tmp_path, run) -> None:
    into = tmp_path / "out"
    code, out, _ = run("identify", "planar2r", logs[1], "--validation", logs[2], "--prior",
                       folders[0] / "estimate.json", "--into", into)  # fmt: skip
    assert code == 0, out
    assert any(line.split()[:2] == ["name", "prior"] for line in out.splitlines())
    content = json.loads((into / "estimate.json").read_text())
    given = json.loads((folders[0] / "estimate.json").read_text())["parameters"]
    for p, q in zip(content["prior"]["parameters"], given, strict=True):
        assert (p["name"], p["value"], p["std"]) == (q["name"], q["value"], q["std"])
    assert "prior, sha256 of its means and std" in content["provenance"]


# Pages
