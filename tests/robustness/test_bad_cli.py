"""Commands on bad input: exit code 0, 1 or 2, one line on stderr, and nothing lost on disk."""

import contextlib
import json
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import sines
from support import sampled

import symgen


@pytest.fixture
def refused(run):
    def call(*arguments, words=()):
        code, _, lines = run(*arguments)
        assert code == 2, lines
        assert len(lines) == 1, lines
        assert lines[0].startswith("symgen: error: ")
        for word in words:
            assert word in lines[0], lines[0]

    return call


@pytest.fixture(scope="session")
def samples():
    """A clean log of planar2r: t, q, qd, tau."""
    t = np.arange(0, 4, 0.005)
    q, qd, qdd = sines(t, [[1.0, 0.8], [0.4, 0.3]], [[1.3, 1.7], [3.1, 4.3]])
    X = np.array([3.5, 0.06, 0.124, 0.006])
    tau = planar2r.inverse_dynamics(q, qd, qdd, X, 0.5)
    return {"t": t, "q": q, "qd": qd, "tau": tau}


@pytest.fixture
def log(samples, tmp_path):
    def write(name="log.npz", drop=(), **changed):
        kept = {k: v for k, v in (samples | changed).items() if k not in drop}
        np.savez(tmp_path / name, **kept)
        return tmp_path / name

    return write


# Kernels


@pytest.mark.parametrize("target", ["all", "c", "casadi", "mex"])
@pytest.mark.parametrize(
    "kernels", ["friction_torque", "friction_power", "jacobian,friction_torque"]
)
def test_kernels_of_friction_of_a_robot_without_it_are_refused(refused, tmp_path, kernels, target):
    into = tmp_path / "package"
    options = ["--kernels", kernels, "--target", target, "--into", into]
    words = [kernels.split(",")[-1], "no friction", "accepted", "torque_regressor"]
    refused("generate", "planar2r", *options, words=words)
    assert not into.exists()


def test_a_model_without_kernels_is_no_package():
    model = symgen.derive("planar2r", ("friction_torque",))
    with pytest.raises(symgen.PackageError, match="without kernels"):
        symgen.generate(model)
    with pytest.raises(symgen.PackageError, match="accepted: jacobian"):
        symgen.generate(symgen.derive("planar2r", ("jacobian",)), kernels=())


# Arguments


@pytest.mark.parametrize(
    "arguments",
    [["nonsense"], ["--nonsense"], ["generate"], ["identify"], ["robots", "extra"],
     ["identify", "planar2r"], ["identify", "planar2r", "log.csv"],
     ["generate", "planar2r", "--check", "nowhere"],
     ["study", "planar2r", "--runs", "0"], ["study", "planar2r", "--runs", "many"],
     ["generate", "planar2r", "emps"], ["generate", "nothing"],
     ["generate", ""], ["generate", "a" * 5000],
     ["generate", "planar2r", "--target", "fortran", "--into", "x"],
     ["generate", "planar2r", "--dtype", "half", "--into", "x"],
     ["generate", "planar2r", "--kernels", "nothing", "--into", "x"],
     ["generate", "planar2r", "--kernels", ",", "--into", "x"]],
)  # fmt: skip
def test_bad_arguments_are_one_line(refused, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    refused(*arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_not_a_robot(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long path would be shortened in the message
    os.mkfifo("pipe")

    def release():  # a reader that waits is given an end, so that the suite does not hang
        with contextlib.suppress(OSError):
            os.close(os.open(tmp_path / "pipe", os.O_WRONLY | os.O_NONBLOCK))

    timer = threading.Timer(3, release)
    timer.start()
    try:
        refused("generate", "./pipe", words=["pipe", "accepted"])
    finally:
        timer.cancel()


# --into


def test_into_a_file_leaves_it(refused, tmp_path):
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        refused("generate", "planar2r", "--into", folder)
    assert (tmp_path / "file").read_text() == "mine"


def test_into_a_name_too_long_is_refused(refused, tmp_path):
    refused("generate", "planar2r", "--into", tmp_path / ("a" * 300))
    assert not list(tmp_path.iterdir())


def test_into_a_link_is_refused(refused, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "dangling").symlink_to("nowhere")
    for name in ("link", "dangling"):
        refused("generate", "planar2r", "--into", tmp_path / name)


def test_into_a_folder_with_files_of_the_user_is_refused_with_their_names(refused, tmp_path):
    model = symgen.derive("planar2r", ("jacobian",))
    symgen.write_package(symgen.generate(model, target="c"), tmp_path / "package")
    (tmp_path / "package" / "notes.txt").write_text("mine")
    (tmp_path / "package" / "planar2r.h").write_text("changed")
    words = ["notes.txt", "planar2r.h"]
    refused("generate", "planar2r", "--into", tmp_path / "package", words=words)
    assert (tmp_path / "package" / "notes.txt").read_text() == "mine"
    assert (tmp_path / "package" / "planar2r.h").read_text() == "changed"


@pytest.mark.parametrize("name", ["mine.txt", "manifest.json", "estimate.json"])
def test_into_a_folder_of_someone_else_leaves_it(refused, tmp_path, name):
    # A web application has a manifest.json too.
    (tmp_path / name).write_text('{"name": "my web app"}')
    (tmp_path / "app.js").write_text("mine")
    refused("generate", "planar2r", "--into", tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([name, "app.js"])
    assert (tmp_path / "app.js").read_text() == "mine"


def test_into_the_current_folder_works_or_is_refused(run, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    code, _, lines = run("generate", "planar2r", "--into", ".")
    assert code == 0 or (code == 2 and len(lines) == 1)
    assert [p.name for p in tmp_path.iterdir()] == ["here"]  # no leftovers beside it


# identify


@pytest.mark.parametrize("window", ["0", "-1", "nan", "inf", "1e9", "1e-9", "abc", "", "3.9"])
def test_a_window_that_cannot_be_is_refused(refused, log, tmp_path, window):
    options = ("--model", "energy", "--window", window)
    refused("identify", "planar2r", log(), *options, "--into", tmp_path / "x")
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("window", ["1e9", "1e-9"])
def test_by_default_a_window_that_does_not_fit_is_a_line_of_the_table(run, log, tmp_path, window):
    code, out, _ = run("identify", "planar2r", log(), "--window", window, "--into", tmp_path / "x")
    assert code == 0
    found = json.loads((tmp_path / "x" / "estimate.json").read_text())
    assert found["model"] == "torque"
    lost = [m for m in found["models"] if not m["chosen"]]
    assert [m["held_out_folds"] for m in lost] == [None, None]
    assert all("window" in m["reason"] for m in lost)
    assert "window" in out


@pytest.mark.parametrize("cutoff", ["0", "-1", "nan", "inf", "1e9", "100", "abc", "", "1e-9"])
def test_a_cutoff_that_cannot_be_is_refused(refused, log, tmp_path, cutoff):
    path = log(drop=["qd"])
    refused("identify", "planar2r", path, "--cutoff", cutoff, "--into", tmp_path / "x")
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("robot", ["puma560", "emps"])
def test_the_log_of_another_robot_is_refused(refused, log, tmp_path, robot):
    refused("identify", robot, log(), "--into", tmp_path / "x", words=["log.npz", "2", "joints"])


def test_logs_that_are_none_are_refused(refused, log, tmp_path):
    for bad in (tmp_path, tmp_path / "nothing.csv", ""):
        refused("identify", "planar2r", bad, "--into", tmp_path / "x")
        refused("identify", "planar2r", log(), "--validation", bad, "--into", tmp_path / "x")


def test_unknown_models_and_methods_are_refused(refused, log, tmp_path):
    for option in ("--model", "--method"):
        refused("identify", "planar2r", log(), option, "x", "--into", tmp_path / "x")


@pytest.mark.parametrize("factor", [0, 1e300, 1e-300])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_torques_that_say_nothing_are_refused(refused, log, samples, tmp_path, factor):
    path = log(tau=samples["tau"] * factor)
    refused("identify", "planar2r", path, "--into", tmp_path / "x", words=["log.npz"])
    assert not (tmp_path / "x").exists()


def test_a_negative_inertia_is_not_trusted_silently(run, log, samples, tmp_path):
    # Torques with the sign of the other convention: ZZ1R comes out as -3.5.
    code, out, _ = run("identify", "planar2r", log(tau=-samples["tau"]), "--into", tmp_path / "x")
    # Without friction nothing else tells: torques are predicted, and no robot is that one.
    assert code in (0, 1)
    found = json.loads((tmp_path / "x" / "estimate.json").read_text())
    assert not found["uses"]["parameters"]["ok"]
    assert not found["uses"]["simulation"]["ok"]
    for words in ("not physically possible", "Not good for simulation: the mass matrix"):
        assert words in found["headline"]
        assert words in out


def test_a_log_that_validates_itself_is_said(run, log, tmp_path):
    path = log()
    code, out, lines = run(
        "identify", "planar2r", path, "--validation", path, "--into", tmp_path / "x"
    )
    assert code == 2 or "same" in out + " ".join(lines)


# Environment


@pytest.mark.parametrize(
    "compiler", sampled(["none", "false", "/no/such", " ", "echo"], 0, always=["/no/such"])
)
def test_without_a_compiler_casadi_serves_and_says_so_once(log, tmp_path, compiler):
    done = subprocess.run(
        [sys.executable, "-m", "symgen", "identify", "planar2r", log(), "--into", tmp_path / "x"],
        capture_output=True, text=True, timeout=120, env=os.environ | {"SYMGEN_CC": compiler},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    if compiler.strip():
        assert done.stderr.count("CasADi") == 1


@pytest.mark.skipif(os.name != "posix", reason="needs bash")
@pytest.mark.parametrize(
    ("redirect", "codes"), [("| true", {0}), ("> /dev/full", {2}), (">&-", {0, 2})]
)
def test_an_output_that_is_closed_or_full_gives_no_traceback(tmp_path, redirect, codes):
    start = f"{sys.executable} -c 'from symgen.cli import main; main()' robots"
    done = subprocess.run(
        ["bash", "-c", f"unset PYTHONUNBUFFERED; {start} {redirect}; echo ${{PIPESTATUS[0]}}"],
        capture_output=True, text=True, timeout=30, cwd=tmp_path,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    assert "Exception" not in done.stderr
    assert int(done.stdout.split()[-1]) in codes
