"""Files made to harm: one line or a valid result, bounded time and memory, nothing run or lost."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fuzz_seeds import ESTIMATE
from support import PROJECT, heeds_ctrl_c, messages

import symgen
from symgen.data.log import read_log
from symgen.errors import plain
from symgen.files import write_folder
from symgen.identification.parameters import read_parameters

ESCAPE = "\x1b]0;taken\x07\x1b[31m"


@pytest.fixture
def report(command, tmp_path):
    """Print an estimate of a given text; return (exit code, stdout, lines on stderr)."""

    def call(text: str):
        (tmp_path / "estimate.json").write_text(text, encoding="utf-8")
        code, out, err = command("report", tmp_path)
        return code, out, messages(err)

    return call


def one_line(code: int, lines: list[str], *words: str) -> None:
    assert code == 2, lines
    assert len(lines) == 1, lines
    assert lines[0].startswith("symgen: error: ")
    assert len(lines[0]) < 2100
    for word in words:
        assert word in lines[0]


# Numbers and texts of JSON and TOML.


@pytest.mark.parametrize("key", ["torque_error", "torque_error_in_motion", "noise_floor"])
@pytest.mark.parametrize("errors", [None, [], [0.1], [0.1, 0.2, 0.3]])
def test_errors_of_a_prediction_are_one_for_each_joint(command, tmp_path, errors, key):
    for file in (PROJECT / "tests" / "reference" / "schemas" / "prediction-2").glob("prediction.*"):
        shutil.copy(file, tmp_path)
    file = tmp_path / "prediction.json"
    assert command("report", tmp_path)[0] == 0
    content = json.loads(file.read_text("utf-8"))
    content[key]["per_joint"] = errors
    file.write_text(json.dumps(content), "utf-8")
    code, _, err = command("report", tmp_path)
    one_line(code, messages(err), "prediction.json")


def test_the_estimate_that_the_cases_below_spoil_is_good(report):
    code, out, lines = report(json.dumps(ESTIMATE))
    assert (code, lines) == (0, [])
    assert "verdict: trusted" in out


@pytest.mark.parametrize(
    "number", ["NaN", "Infinity", "-Infinity", "1e999", "9" * 400, "-" + "9" * 4400]
)
@pytest.mark.parametrize("key", ["value", "std", "condition_number", "window_s"])
def test_a_number_that_is_none_is_no_result(report, number, key):
    text = re.sub(rf'("{key}": )[0-9.]+', rf"\g<1>{number}", json.dumps(ESTIMATE))
    assert number in text
    code, _, lines = report(text)
    one_line(code, lines, "estimate.json")


@pytest.mark.parametrize("number", ["9" * 400, "inf", "nan", "1e400"])
def test_a_number_that_is_none_is_no_parameter(command, tmp_path, number):
    path = tmp_path / "parameters.toml"
    path.write_text(f"[parameters]\nZZ1R = {number}\nZZ2 = 1.0\nMX2 = 1.0\nMY2 = 1.0\n")
    arguments = ("--parameters", path, "--into", tmp_path / "log.csv", "--duration", "1")
    code, _, err = command("simulate", "planar2r", *arguments)
    one_line(code, messages(err), "a finite number")


#: An array in the file of curves: the header of its numbers, or a number that is none.
CURVES = {
    "a header that is no expression": lambda x: x.replace(b"(30, 1)", b"(30, 1 "),
    "a number too large for a size": lambda x: x.replace(b"(30, 1)", b"(30, " + b"9" * 30 + b")"),
    "not a number": lambda x: x[:-4] + np.float32(np.nan).tobytes(),
}


@pytest.mark.parametrize("fault", CURVES)
def test_damaged_curves_are_a_line(report, tmp_path, fault):
    with zipfile.ZipFile(tmp_path / "curves.npz", "w") as archive:
        for name, array in _traces(np.arange(30.0)).items():
            file = io.BytesIO()
            np.save(file, array)
            spoiled = CURVES[fault](file.getvalue()) if name == "trace0_predicted" else None
            assert spoiled != file.getvalue()
            archive.writestr(f"{name}.npy", spoiled or file.getvalue())
    code, _, lines = report(json.dumps(ESTIMATE))
    one_line(code, lines, "curves.npz: damaged")


def _traces(t):
    trace = {"log": "log.csv", "kind": "train", "quantity": "torque", "spacing": 1}
    index = json.dumps({"traces": [trace], "balances": []}).encode()
    values = t.astype(np.float32)[:, None]
    arrays = {"trace0_t": t, "trace0_measured": values, "trace0_predicted": values}
    return {"index": np.frombuffer(index, np.uint8), **arrays}


def test_lone_surrogates_in_json_are_shown_as_text(report):
    text = json.dumps({**ESTIMATE, "notes": ["PLACE"]})
    code, out, lines = report(text.replace("PLACE", r"\ud800 bad"))
    assert (code, lines) == (0, [])
    assert r"note: \ud800 bad" in out


@pytest.mark.parametrize("gap", ["before", "after", "noise_floor"])
@pytest.mark.parametrize("joints", [[0.1], [0.1] * 3])
def test_a_gap_of_another_number_of_joints_is_damage(command, tmp_path, gap, joints):
    written = PROJECT / "tests" / "reference" / "schemas" / "diagnosis-1-effect"
    shutil.copytree(written, tmp_path / "diagnosis")
    path = tmp_path / "diagnosis" / "diagnosis.json"
    content = json.loads(path.read_text())
    content["gap"][gap]["per_joint"] = joints
    path.write_text(json.dumps(content))
    code, _, err = command("report", tmp_path / "diagnosis")
    one_line(code, messages(err), "damaged")


@pytest.mark.parametrize("digit", ["²", "¹", "٣", "１", "9" * 5000])
@pytest.mark.parametrize("entry", ["sigma", "ant"])
def test_what_else_is_a_digit_to_unicode_is_no_number_of_a_par(tmp_path, digit, entry):
    values = {"sigma": "0", "ant": "0"} | {entry: digit}
    text = f"NJ = 1\nsigma = {{{values['sigma']}}}\nant = {{{values['ant']}}}\n"
    with pytest.raises(symgen.RobotError, match=r"robot\.par"):
        symgen.read_robot(_written(tmp_path / "robot.par", text + "theta = {th1}\n"))


def _written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


# Messages, names and what a terminal obeys.


KEYS = {
    "bare": lambda n: ".".join(["a"] * n) + " = 1\n",
    "of a table": lambda n: "[robot]\n[" + " . ".join(["a"] * n) + "]\nb = 1\n",
    "in quotes": lambda n: ".".join(['"a \\" b"', "'c d'"] * (n // 2)) + " = 1\n",
    "inside": lambda n: "[columns]\nx = {" + ".".join(["a"] * n) + " = 1}\n",
}


@pytest.mark.parametrize("kind", KEYS)
@pytest.mark.parametrize("reader", ["robot", "parameters"])
def test_a_key_of_100_000_parts_is_refused_at_once(tmp_path, kind, reader):
    """The time that such a key takes to be read grows with the square of its parts."""
    path = tmp_path / "a.toml"
    path.write_text(KEYS[kind](100_000))
    read = {
        "robot": symgen.read_robot,
        "parameters": lambda p: read_parameters(p, symgen.derive("planar2r")),
    }[reader]
    begun = time.process_time()
    with pytest.raises(symgen.SymgenError, match="a key of 200 parts or more"):
        read(path)
    assert time.process_time() - begun < 5


@pytest.mark.parametrize("piece", ["x", "\r\n", "é\u202e", "\u2028"])
def test_a_message_of_100_000_characters_is_cut(piece):
    text = f"robot.toml: {piece * 100_000}; accepted: less"
    shown, whole = str(symgen.RobotError(text)), plain(text)
    first, last = shown.split(" ... ")
    assert len(shown) < 2000
    assert whole.startswith(first)
    assert whole.endswith(last)
    assert min(len(first), len(last)) > 100


@pytest.mark.parametrize("form", ["csv", "parquet", "npz"])
@pytest.mark.parametrize("place", ["beside", "in place of q1"])
def test_escape_bytes_of_column_names_reach_no_terminal(tmp_path, form, place):
    k = np.arange(20.0)
    names = {"t": k / 100, "q1": np.sin(k), "tau1": np.cos(k), ESCAPE: k}
    if form == "npz":
        names = {"t": k / 100, "q": np.sin(k), "tau": np.cos(k), ESCAPE: k}
    if place != "beside":
        del names["q" if form == "npz" else "q1"]
    path = tmp_path / f"log.{form}"
    if form == "npz":
        np.savez(path, **names)
    elif form == "parquet":
        pq.write_table(pa.table(names), path)
    else:
        rows = zip(*names.values(), strict=True)
        text = "\n".join(",".join(map(str, row)) for row in rows)
        path.write_text(",".join(names) + "\n" + text)
    try:
        said = " ".join(read_log(path).ignored)
    except symgen.LogError as error:
        said = str(error)
    assert "taken" in said
    assert plain(said) == said


@pytest.mark.skipif(os.name == "nt", reason="names that POSIX allows")
def test_escape_bytes_of_files_and_folders_reach_no_terminal(tmp_path):
    """Of an archive of logs from elsewhere: their names stand in notes, tables and pages."""
    folder = tmp_path / "robot=\x1b]0;x\x07" / "day=\x1b[31m²"
    folder.mkdir(parents=True)
    path = folder / "a\x1b[31m.csv"
    rows = "\n".join(f"{0.01 * k},{k % 7},{k % 3}" for k in range(40))
    path.write_text(f"t,q1,tau1\n{rows}\n")
    text = read_log(path).name
    assert plain(text) == text


# Time and memory.


@pytest.mark.parametrize("fault", ["none", "twice", "cell"])
def test_a_header_of_60_000_columns_takes_seconds(tmp_path, fault):
    names = ["t", *(f"q{k}" for k in range(1, 60_000)), "tau1"]
    if fault == "twice":
        names[-2] = "q1"
    row = ["0"] * len(names)
    last = ["x"] * len(names) if fault == "cell" else row
    path = tmp_path / "log.csv"
    path.write_text("\n".join(",".join(r) for r in (names, row, row, last)))
    begun = time.process_time()
    with pytest.raises(symgen.LogError) as caught:
        read_log(path)
    assert time.process_time() - begun < 10
    assert len(str(caught.value)) < 2000


def _bomb(path: Path, claimed: int) -> Path:
    """Write an NPZ whose array of zeros unpacks to `claimed` bytes."""
    header = io.BytesIO()
    shape = (claimed // 8,)
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    block = bytes(1 << 20)
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("t.npy", "w", force_zip64=True) as file,
    ):
        file.write(header.getvalue())
        for _ in range(claimed >> 20):
            file.write(block)
    return path


# In a process of its own that may take 2 GB: a bomb that is unpacked ends it.
READ = """
import resource, sys
import symgen
from symgen.data.log import read_log
from symgen.identification.curves import read_traces
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    read_log(sys.argv[1]) if sys.argv[2] == "log" else read_traces(Path(sys.argv[1]))
except symgen.SymgenError as error:
    print(error)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - base)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is measured as Linux counts it")
@pytest.mark.parametrize("reader", ["log", "curves"])
def test_an_npz_that_would_fill_the_memory_is_refused_before_it_is_unpacked(tmp_path, reader):
    path = _bomb(tmp_path / "log.npz", 448 << 20)
    assert path.stat().st_size < 6e6
    done = subprocess.run(
        [sys.executable, "-c", READ, path, reader], cwd=PROJECT, capture_output=True, text=True
    )
    *said, grown = done.stdout.splitlines()
    assert "accepted: " in said[0], done.stderr
    if reader == "log":
        assert "would unpack from" in said[0]
    assert int(grown) < 200_000  # kB


def test_a_parquet_that_would_fill_the_memory_is_refused(tmp_path):
    path = tmp_path / "log.parquet"
    zeros = pa.array(np.zeros(1 << 20))
    table = pa.table(dict.fromkeys(("t", "q1", "tau1"), zeros))
    with pq.ParquetWriter(path, table.schema, compression="zstd") as writer:
        for _ in range(20):
            writer.write_table(table)
    assert path.stat().st_size < 2e6
    with pytest.raises(symgen.LogError, match="would unpack from"):
        read_log(path)


# Interrupted and killed.


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_in_the_first_moments_is_a_line(tmp_path):
    # The first module that the command line asks for says so, and waits for the signal.
    (tmp_path / "click.py").write_text("import signal\nprint(flush=True)\nsignal.pause()\n")
    job = subprocess.Popen(
        [sys.executable, "-m", "symgen", "robots"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(PROJECT)])},
        preexec_fn=heeds_ctrl_c,
    )
    assert job.stdout.readline() == "\n"
    job.send_signal(signal.SIGINT)
    _, err = job.communicate()
    assert (job.returncode, err) == (130, "symgen: interrupted\n")


@pytest.mark.parametrize("start", ["import symgen", "import symgen.__main__"])
def test_what_is_imported_before_ctrl_c_is_a_line_is_little(start):
    """Beyond what the interpreter itself imports: symgen, and signal with its enumerations."""
    listed = "import sys; before = {*sys.modules}; START; print(*sorted({*sys.modules} - before))"
    done = subprocess.run(
        [sys.executable, "-c", listed.replace("START", start)],
        capture_output=True, text=True, cwd=PROJECT, check=True,
    )  # fmt: skip
    allowed = {"symgen", "symgen.__main__", "signal", "enum", "functools", "collections",
               "operator", "keyword", "reprlib", "itertools", "types"}  # fmt: skip
    assert {name for name in done.stdout.split() if not name.startswith("_")} <= allowed


def test_a_link_in_a_folder_of_results_is_refused_and_stays(tmp_path):
    """Of a folder from elsewhere: what its links lead to would be in what is passed on."""
    secret, folder = tmp_path / "secret", tmp_path / "results"
    secret.mkdir()
    (secret / "key").write_text("secret")
    content = {"estimate.json": b'{"schema": "symgen.x"}', "deep/a": b"1"}
    write_folder(folder, content, "estimate.json")
    places = {"file": secret / "key", "all": secret, "gone": tmp_path / "nowhere"}
    for place, target in (places | {"deep/all": secret}).items():
        (folder / place).symlink_to(target)
    with pytest.raises(symgen.PackageError, match="all, deep/all, file, gone"):
        write_folder(folder, content, "estimate.json")
    assert all((folder / place).is_symlink() for place in places)
    assert [p.name for p in secret.iterdir()] == ["key"]
