"""symgen demo: an arm with a hidden spring, and the example of the paper, with no compiler too."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from documented import assert_quoted, blocks
from oracles import planar2r
from support import PROJECT
from support_commands import in_terminal

import symgen
from symgen.experiment import paper
from symgen.experiment.reference import SAMPLES, STEP, paper_motion
from symgen.report.content.demo import closed_form

EVALUATOR = paper.example()


PAPER = ("--paper", "--runs", "60")


def _demo(folder: Path, compiler: str, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "symgen", "demo", *options],
        cwd=folder, capture_output=True, text=True, env={**os.environ, "SYMGEN_CC": compiler},
    )  # fmt: skip


def test_the_demo_needs_no_compiler(tmp_path) -> None:
    done = _demo(tmp_path, "none", *PAPER)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "symgen-demo" / "demo.json").is_file()


@pytest.mark.skipif(sys.platform != "linux", reason="xdg-open opens pages on Linux alone")
def test_a_page_is_opened_in_a_terminal_alone(tmp_path) -> None:
    opened, opener = tmp_path / "opened", tmp_path / "xdg-open"
    opener.write_text(f'#!/bin/sh\necho "$1" >> {opened}\n')
    opener.chmod(0o755)
    path = {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    options = ["demo", "--paper", "--runs", "10", "--into"]
    piped = subprocess.run(
        [sys.executable, "-m", "symgen", *options, "piped"],
        cwd=tmp_path, capture_output=True, text=True, env=os.environ | path,
    )  # fmt: skip
    assert piped.returncode == 0, piped.stderr
    assert not opened.exists()
    in_terminal([*options, "shown"], folder=tmp_path, **path)
    for _ in range(100):  # the opener is not waited for
        if opened.exists():
            break
        time.sleep(0.1)
    assert opened.read_text().split() == [str(tmp_path / "shown" / "demo.html")]


def test_the_paper_is_reproduced(tmp_path) -> None:
    done = _demo(tmp_path, "", *PAPER)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    out = done.stdout
    assert "ZZ1R       ZZ1 + L1**2*M2" in out
    assert out.count("not determined: ZZ1R, ZZ2") == 2
    assert "proportional" in out
    page = (tmp_path / "symgen-demo" / "demo.html").read_text()
    assert "Set-up (a)" in page
    assert "Set-up (b)" in page
    assert "warning" not in done.stderr
    # Noise-free data return X.
    exact = re.search(r"returned to (\S+) \(spline.* and (\S+) \(on line\)", out)
    assert exact is not None
    assert float(exact.group(1)) < 1e-4
    assert float(exact.group(2)) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["", "none"])
def test_the_hidden_spring_is_found_and_the_gap_closes(tmp_path, compiler) -> None:
    done = _demo(tmp_path, compiler)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "symgen-demo"
    told = json.loads((folder / "diagnosis" / "diagnosis.json").read_text("utf-8"))
    (effect,) = told["effects"]
    assert (effect["name"], effect["joints"]) == ("gravity_spring", [2])
    assert abs(effect["parameters"][0]["value"] - 60) < 3 * effect["parameters"][0]["std"]
    assert told["gap"]["after"]["total"] < told["gap"]["before"]["total"] / 5
    shown = (b.code for b in blocks(PROJECT / "README.md") if b.kind == "output")
    assert_quoted(next(shown), done.stdout)
    assert ("compiled C" in done.stdout) == (compiler == "")
    for name in ("identified", "diagnosis", "better"):
        assert (folder / name / "report.html").is_file()


def test_closed_form_is_that_of_the_paper() -> None:
    draw = np.random.default_rng(2)
    q, qd = draw.uniform(-2, 2, (2, 20, 2))
    names = {"q2": q[:, 1], "qd1": qd[:, 0], "qd2": qd[:, 1], "L1": 0.5, "cos": np.cos,
             "sin": np.sin}  # fmt: skip
    columns = [
        eval(text, {"__builtins__": {}}, names) for text in closed_form(EVALUATOR.model.kernels[0])
    ]
    np.testing.assert_allclose(np.stack(columns, -1), planar2r.energy_regressor(q, qd, 0.5))


def test_the_dynamics_equal_lagrange_by_hand() -> None:
    draw = np.random.default_rng(4)
    for _ in range(10):
        q, qd, qdd = draw.uniform(-2, 2, (3, 2))
        tau = planar2r.inverse_dynamics(q, qd, qdd, paper.X_TRUE, 0.5)
        np.testing.assert_allclose(EVALUATOR.inverse_dynamics(q, qd, qdd, paper.X_TRUE), tau)
        np.testing.assert_allclose(EVALUATOR.forward_dynamics(q, qd, tau, paper.X_TRUE), qdd)


def test_the_motion_has_the_peak_speeds_of_the_paper_and_its_derivatives() -> None:
    t = np.linspace(0, SAMPLES * STEP, 2001)
    q, qd, qdd = paper_motion(t)
    np.testing.assert_allclose(np.abs(qd).max(axis=0), [1.0, 2.0], rtol=1e-5)
    np.testing.assert_allclose(np.gradient(q, t, axis=0)[2:-2], qd[2:-2], atol=1e-4)
    np.testing.assert_allclose(np.gradient(qd, t, axis=0)[2:-2], qdd[2:-2], atol=1e-4)
    np.testing.assert_allclose(qd[0], 0, atol=1e-12)


def test_setup_b_integrates_the_equations_of_motion() -> None:
    # Without noise and with the true parameters the robot follows the reference.
    true, noise = paper.WRONG, paper.TORQUE_NOISE
    paper.WRONG, paper.TORQUE_NOISE = 1.0, 0.0
    try:
        runs = paper.setup_b(EVALUATOR, 2, np.random.default_rng(0))
    finally:
        paper.WRONG, paper.TORQUE_NOISE = true, noise
    q, _, _ = paper_motion(runs.t)
    assert np.abs(runs.q - q).max() < 2 * np.pi / 14_400


def test_errors_fall_where_the_paper_has_them() -> None:
    # The paper gives one run; its errors lie inside the distribution of seeded runs.
    runs = paper.setup_a(EVALUATOR, 400, np.random.default_rng(5))
    errors = []
    for k in range(400):
        identifier = symgen.Identifier(EVALUATOR, mode="start")
        identifier.run(runs.t, runs.q[k], runs.qd[k], runs.tau[k])
        errors.append(np.abs(identifier.read()[0] / paper.X_TRUE - 1))
    share = np.mean(np.array(errors) < paper.PAPER_ERRORS, axis=0)
    print("share of runs with an error below the paper's:", share)
    assert np.all(share > 0.05)
    assert np.all(share < 0.95)
