"""symgen study beside a Monte-Carlo study of its own in NumPy and SciPy, and what it must keep."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, clipped
from oracles import planar2r
from oracles.arm import X, sines
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, sosfiltfilt

import symgen
from symgen.experiment.recording import Instruments
from symgen.experiment.reference import Reference, make_reference
from symgen.experiment.study import read_study

RATE, SECONDS, CUTOFF = 100.0, 8.0, 8.0
RUNS, DRAWN = 96, 600
NOISE = Instruments(position_noise=3e-3, velocity=False, torque_noise=0.3)


def _motion() -> tuple[np.ndarray, ...]:
    """t (N,) and q, qd, qdd (N, 2) of three harmonics a joint."""
    t = np.arange(round(SECONDS * RATE) + 1) / RATE
    w = 2 * np.pi / SECONDS * np.array([2, 4, 8])
    a, phase = np.array([[0.8, 0.4, 0.2], [0.6, 0.5, 0.25]]), np.array([[0, 1, 2], [2, 0.5, 4]])
    return t, *sines(t, a.T, w[:, None], phase.T)


def _reference() -> Reference:
    return make_reference("harmonics", *_motion())


@cache
def _found() -> symgen.Study:
    """Torques without tachometers: accelerations of noisy positions make least squares biased."""
    return symgen.study(
        "planar2r", X, trajectories=[_reference()], recording=symgen.Recording(NOISE),
        models=["torque"], methods=["ols"], cutoff=CUTOFF, runs=RUNS,
    )  # fmt: skip


def _oracle(comparison: float) -> np.ndarray:
    """Return estimates (DRAWN, 4) of the same experiment: zero-phase filters, slopes, lstsq."""
    t, q, qd, qdd = _motion()
    tau, draw = planar2r.inverse_dynamics(q, qd, qdd, X, 0.5), np.random.default_rng(7)
    first, second = (butter(4, hz, fs=RATE, output="sos") for hz in (CUTOFF, comparison))
    out = []
    for _ in range(DRAWN):
        seen = q + NOISE.position_noise * draw.normal(size=q.shape)
        push = tau + NOISE.torque_noise * draw.normal(size=q.shape)
        smooth = sosfiltfilt(first, seen, axis=0)
        spline = make_interp_spline(t, smooth, k=5)
        slope, bend = (spline.derivative(d)(t) for d in (1, 2))
        W = planar2r.torque_regressor(smooth, slope, bend, 0.5)
        kept = np.concatenate([W, push[..., None]], axis=2)[15:-15]  # slopes are wild at the ends
        low = sosfiltfilt(second, kept, axis=0).reshape(-1, 5)
        out.append(np.linalg.lstsq(low[:, :4], low[:, 4])[0])
    return np.array(out)


def test_bias_and_std_are_those_of_a_monte_carlo_study_in_numpy() -> None:
    (tried,) = _found().results
    drawn = _oracle(tried.band.comparison_hz)
    std, bias = drawn.std(axis=0, ddof=1), drawn.mean(axis=0) - X
    error = std / math.sqrt(DRAWN)
    assert np.max(np.abs(bias) / error) > 10, "the experiment is to be biased"
    for k, p in enumerate(tried.parameters):
        apart = abs(p.bias - bias[k]) / math.hypot(p.std / math.sqrt(RUNS), error[k])
        print(f"{p.name}: bias {p.bias:.3g} and {bias[k]:.3g}, std {p.std:.3g} and {std[k]:.3g}")
        assert apart < 4, p.name
        # 95 % interval of a ratio of std: 1/sqrt(2 RUNS) and 1/sqrt(2 DRAWN), three times
        assert abs(math.log(p.std / std[k])) < 0.25, p.name
        held = np.mean(np.abs(drawn[:, k] - X[k]) < 1.96 * p.stated_std)
        assert abs(p.coverage - held) < 0.2, p.name


@pytest.fixture
def files(tmp_path: Path) -> Path:
    t, q, qd, qdd = _motion()
    head = "t,q1,q2,qd1,qd2,qdd1,qdd2"
    rows = np.column_stack([t, q, qd, qdd])
    np.savetxt(tmp_path / "m.csv", rows, "%.12g", ",", header=head, comments="")
    lines = [f"{name} = {x}" for name, x in zip(planar2r.NAMES, X, strict=True)]
    (tmp_path / "P.toml").write_text("\n".join(["[parameters]", *lines]))
    return tmp_path


COMMAND = (
    "--position-noise", 1e-4, "--velocity-noise", 2e-3, "--torque-noise-percent", 5,
    "--method", "wls", "--method", "iv", "--runs", 16,
)  # fmt: skip


def test_the_command_writes_a_study_that_reads_back(files: Path, command: Callable) -> None:
    given = ("study", "planar2r", "--parameters", files / "P.toml", "--trajectory", files / "m.csv")
    code, out, _ = command(*given, *COMMAND, "--into", files / "a")
    assert code == 0
    assert "torque by iv" in out
    assert command(*given, *COMMAND, "--into", files / "b")[0] == 0
    for name in ("study.json", "report.html"):
        assert (files / "a" / name).read_bytes() == (files / "b" / name).read_bytes()
    content = json.loads((files / "a" / "study.json").read_text("utf-8"))
    assert content["schema"] == "symgen.study/1"
    assert [(r["model"], r["method"]) for r in content["results"]] == [
        (model, method) for model in ("energy", "momentum", "torque") for method in ("wls", "iv")
    ]
    read = read_study(files / "a")
    assert read.to_json() == content
    assert "<Study of planar2r: 16 runs" in repr(read)
    code, again, _ = command("report", files / "a", "--into", files / "again.html")
    assert code == 0
    assert again.splitlines()[:8] == out.splitlines()[:8]
    assert (files / "again.html").read_bytes() == (files / "a" / "report.html").read_bytes()
    if BROWSER is not None:
        html = (files / "a" / "report.html").read_text("utf-8")
        seen = clipped(html, files)
        assert not any(seen.values()), seen


def test_a_damaged_study_is_one_line(files: Path, command: Callable) -> None:
    content = _found().to_json()
    content["results"][0]["parameters"][1]["std"] = "wide"
    (files / "d").mkdir()
    (files / "d" / "study.json").write_text(json.dumps(content))
    code, _, err = command("report", files / "d")
    assert code == 2
    assert "results.0.parameters.1.std" in err


def test_what_cannot_be_studied_is_said(files: Path, command: Callable) -> None:
    given = ("study", "planar2r", "--parameters", files / "P.toml", "--into", files / "x")
    for more, what in (
        (("--runs", 2), "2 runs"),
        (("--method", "best"), "'best' is not one of"),
        (("--model", "static"), "'static' is not one of"),
    ):
        code, _, err = command(*given, *more)
        assert (code, what in err) == (2, True), err
        assert not (files / "x").exists()
