"""Logs as recorders write them: other separators, units and dates, and cells that are empty.

The oracle is the same log in SI units, written with commas and decimal points.
"""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support_streams import motion, parquet, robot

import symgen
from symgen.data.log import read_log
from symgen.data.raw import Reading
from symgen.errors import LogError

COLUMNS = motion(1500, 3)
DEG = 180 / np.pi
SI = {name: [f"{x:.12g}" for x in values] for name, values in COLUMNS.items()}
START = np.datetime64("2024-03-31T00:59:58.000000000")  # clocks change in Europe 2 s later
STAMPS = START + (np.arange(1500) * 10_000_000).astype("timedelta64[ns]")
NANOSECONDS = 1_711_846_798_000_000_123 + 10_000_000 * np.arange(1500)


def written(
    path: Path, columns: dict[str, list[str]], separator=",", comma=False, end="\n", trailing=False
) -> Path:
    """Write columns of texts as a recorder would."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, delimiter=separator, lineterminator=end)
    writer.writerow([*columns, *[""] * trailing])
    for row in zip(*columns.values(), strict=True):
        cells = [cell.replace(".", ",") if comma else cell for cell in row]
        writer.writerow([*cells, *[""] * trailing])
    path.write_bytes(text.getvalue().encode())
    return path


def renamed(names: dict[str, str], **values: object) -> dict[str, list[str]]:
    """Return the log with other headers, and other values under the old ones."""
    told = {
        name: x if isinstance(x, list) else [f"{v:.17g}" for v in x]
        for name, x in (SI | values).items()
    }
    return {names.get(name, name): told[name] for name in SI}


def times(name: str, factor: float) -> dict[str, object]:
    return {k: COLUMNS[k] * factor for k in SI if k.startswith(name) and k[len(name) :].isdigit()}


DEGREES = {"q1": "q1 [deg]", "q2": "q2_deg", "qd1": "qd1 (deg/s)", "qd2": "qd2_deg_s"}
INTEGERS = [str(k) for k in NANOSECONDS]
#: Headers and values, how the file is written, and channels that are in `repairs`.
CASES = {
    "semicolons and decimal commas": ({}, {}, {"separator": ";", "comma": True}, []),
    "tabs": ({}, {}, {"separator": "\t"}, []),
    "tabs, commas, Windows": ({}, {}, {"separator": "\t", "comma": True, "end": "\r\n"}, []),
    "quoted decimal commas": ({}, {}, {"comma": True}, []),
    "trailing separators": ({}, {}, {"separator": ";", "trailing": True}, []),
    "milliseconds": ({"t": "time (ms)"}, {"t": 1e3 * COLUMNS["t"]}, {}, ["time (ms)"]),
    "microseconds": ({"t": "t_us"}, {"t": np.round(1e6 * COLUMNS["t"])}, {}, ["t_us"]),
    "nanoseconds since 1970": ({"t": "stamp"}, {"t": INTEGERS}, {}, ["stamp"]),
    "dates": ({"t": "time"}, {"t": [str(s) for s in STAMPS]}, {}, ["time"]),
    "dates with a zone": (
        {"t": "time"}, {"t": [f"{s}+02:00" for s in STAMPS]}, {"separator": ";"}, ["time"],
    ),
    "degrees": (
        DEGREES, times("q", DEG) | times("qd", DEG), {},
        ["q1 [deg], q2_deg", "qd1 (deg/s), qd2_deg_s"],
    ),
    "degrees, and rad/s": (
        {"q1": "q1 [deg]", "q2": "q2 [deg]"}, times("q", DEG), {}, ["q1 [deg], q2 [deg]"],
    ),
    "one joint in degrees": (
        {"q2": "q2_deg"}, {"q2": COLUMNS["q2"] * DEG}, {}, ["q2_deg"],
    ),
    "speeds in rpm": (
        {"qd1": "qd1 [rpm]", "qd2": "qd2 [rpm]"}, times("qd", 30 / np.pi), {},
        ["qd1 [rpm], qd2 [rpm]"],
    ),
    "torques in mNm": (
        {"tau1": "tau1 [mNm]", "tau2": "tau2_mNm"}, times("tau", 1e3), {}, ["tau1 [mNm], tau2_mNm"],
    ),
}  # fmt: skip


def read(path: Path, **options: str) -> symgen.Log:
    return read_log(path, sigma=(0, 0), reading=Reading(**options))


@pytest.mark.parametrize("case", CASES)
def test_a_log_of_a_recorder_is_the_log_in_si(tmp_path, case):
    names, values, form, channels = CASES[case]
    found = read(written(tmp_path / "log.csv", renamed(names, **values), **form))
    same = read(written(tmp_path / "si.csv", SI))
    np.testing.assert_allclose(found.t - found.t[0], same.t, atol=1e-9)
    for key in ("q", "qd", "tau"):
        np.testing.assert_allclose(getattr(found, key), getattr(same, key), rtol=1e-11, atol=1e-11)
    assert [columns for columns, _, _ in found.converted] == channels
    assert same.converted == ()


def test_a_file_of_excel_is_read(tmp_path):
    path = written(tmp_path / "log.csv", SI, separator=";", comma=True, end="\r\n")
    path.write_bytes(b"\xef\xbb\xbfsep=;\r\n" + path.read_bytes())
    np.testing.assert_array_equal(read(path).q, read(written(tmp_path / "si.csv", SI)).q)


def test_a_time_with_another_name_keeps_the_unit_of_its_header(tmp_path):
    names = {"t": "Zeit [ms]", "q1": "pos 1 [deg]", "q2": "pos 2 [deg]"}
    values = {"t": 1e3 * COLUMNS["t"]} | times("q", DEG)
    path = written(tmp_path / "log.csv", renamed(names, **values))
    with pytest.raises(LogError) as refused:
        read(path)
    assert "no column t among Zeit [ms], pos 1 [deg], pos 2 [deg], qd1," in str(refused.value)
    assert str(refused.value).endswith('accepted: --columns "t=Zeit [ms]"')
    found = read(path, columns={"t": "Zeit [ms]"})
    np.testing.assert_allclose(found.t, COLUMNS["t"], atol=1e-9)
    np.testing.assert_allclose(found.q[:, 0], COLUMNS["q1"], rtol=1e-11)


@pytest.mark.parametrize(
    ("names", "values", "options"),
    [
        ({}, times("tau", 1e3), {"unit": {"tau": "mNm"}}),
        ({"tau1": "tau1 [Nm]"}, times("tau", 1e3), {"unit": {"tau": "mNm"}}),
        ({}, times("q", DEG) | times("qd", DEG), {"unit": {"": "deg"}}),
        ({}, times("qd", 30 / np.pi), {"unit": {"qd1": "rpm", "qd2": "rpm"}}),
        ({}, {"t": 1e3 * COLUMNS["t"]}, {"time_unit": "ms"}),
        ({"t": "t_ms"}, {}, {"time_unit": "s"}),
    ],
)
def test_an_option_says_the_unit_whatever_the_header_says(tmp_path, names, values, options):
    found = read(written(tmp_path / "log.csv", renamed(names, **values)), **options)
    same = read(written(tmp_path / "si.csv", SI))
    for key in ("t", "q", "qd", "tau"):
        np.testing.assert_allclose(getattr(found, key), getattr(same, key), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("separator", [";", "\t", ","])
def test_an_option_says_the_decimal_mark(tmp_path, separator):
    columns = {k: [str(round(float(x))) for x in v] for k, v in SI.items() if k != "t"}
    columns = {"t": SI["t"]} | columns | {"tau1": [*columns["tau1"][:-1], "0.5"]}
    path = written(tmp_path / "log.csv", columns, separator=separator, comma=True)
    found = read(path, decimal=",")
    np.testing.assert_array_equal(found.t, COLUMNS["t"].round(12))
    assert found.tau[-1, 0] == 0.5
    assert read(path).tau[-1, 0] == 0.5
    with pytest.raises(LogError, match=r"column t, sample 1: '0,01'.*--decimal ','"):
        read(path, decimal=".")


def test_a_joint_that_turns_far_is_read_with_the_option(tmp_path):
    turns = {"q1": 60.0 * COLUMNS["t"], "qd1": np.full(1500, 60.0)}
    path = written(tmp_path / "log.csv", renamed({}, **turns))
    accepted = r"column q1 .*--unit deg, or --unit q1=deg,qd1=deg/s, or --unit rad"
    with pytest.raises(LogError, match=accepted):
        read_log(path, sigma=(0, 0))
    log = read_log(path, sigma=(0, 0), reading=Reading(unit={"": "rad"}))
    assert np.ptp(log.q[:, 0]) == pytest.approx(60 * 14.99)


def test_a_slide_in_millimetres_is_in_metres(tmp_path):
    names = {"q2": "q2 [mm]", "qd2": "qd2 [mm/s]"}
    values = {"q2": COLUMNS["q2"] * 1e3, "qd2": COLUMNS["qd2"] * 1e3}
    found = read_log(written(tmp_path / "log.csv", renamed(names, **values)), sigma=(0, 1))
    np.testing.assert_allclose(found.q, np.column_stack([COLUMNS["q1"], COLUMNS["q2"]]), rtol=1e-11)
    assert [done for _, _, done in found.converted] == ["converted to m", "converted to m/s"]


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_stamps_keep_every_nanosecond(tmp_path, suffix):
    jitter = NANOSECONDS + np.random.default_rng(0).integers(-200, 200, 1500)
    path = tmp_path / f"log.{suffix}"
    if suffix == "csv":
        written(path, renamed({}, t=[str(k) for k in jitter]))
    elif suffix == "parquet":
        parquet(path, COLUMNS | {"t": jitter})
    else:
        pairs = {k: np.column_stack([COLUMNS[f"{k}1"], COLUMNS[f"{k}2"]]) for k in ("q", "tau")}
        np.savez(path, t=jitter, **pairs)
    np.testing.assert_allclose(read(path).t, (jitter - jitter[0]) * 1e-9, atol=1e-15)


def without(columns: dict[str, list[str]], cells: dict[str, list[int]]) -> dict[str, list[str]]:
    return {k: ["" if i in cells.get(k, ()) else x for i, x in enumerate(v)]
            for k, v in columns.items()}  # fmt: skip


EMPTY = {"q1": [100, 101, 700], "tau2": [300, *range(900, 1000)], "qd2": [*range(1200, 1240)]}


def test_cells_that_are_empty_are_interpolated_or_masked_and_counted(tmp_path):
    full = symgen.identify(robot(), written(tmp_path / "si.csv", SI), model="momentum")
    path = written(tmp_path / "log.csv", without(SI, EMPTY))
    found = symgen.identify(robot(), path, model="momentum")
    told = [(f.channel, f.fault, f.samples, f.done) for f in found.repairs]
    assert told == [
        ("q1, tau2", "empty cells", 4, "interpolated"),
        ("qd2", "empty cells in a row", 40, "masked, for all joints"),
        ("tau2", "empty cells in a row", 100, "masked"),
    ]
    std = np.array([p.std for p in full.parameters])
    assert (np.abs(found.X - full.X) < std).all()


def test_a_long_foreign_log_gives_the_estimate_of_the_log_in_si(tmp_path, monkeypatch):
    monkeypatch.setattr("symgen.data.long_logs.LIMIT", 4000)
    columns = motion(5000, 1)
    values = {k: x * DEG if k in DEGREES else x for k, x in columns.items()}
    values["t"] = NANOSECONDS[0] + 10_000_000 * np.arange(5000)
    for folder, table in (
        ("si", columns),
        ("log", {DEGREES.get(k, k): x for k, x in values.items()}),
    ):
        (tmp_path / folder).mkdir()
        parquet(tmp_path / folder / "a.parquet", table)
    same, found = (
        symgen.identify(robot(), str(tmp_path / folder), model="momentum")
        for folder in ("si", "log")
    )
    assert pytest.approx(same.X, rel=1e-9) == found.X
    assert [*dict.fromkeys(f.channel for f in found.repairs)] == ["t", *CASES["degrees"][3]]


JOINTS = ("shoulder", "elbow")
NAMED = symgen.parse_robot(
    '[robot]\nname = "p"\nconvention = "modified-dh"\ngravity = [0.0, 0.0, -9.81]\n'
    + "".join(
        f'[[joint]]\nname = "{name}"\nsigma = 0\nd = {d}\nfriction = ["viscous"]\n'
        for name, d in zip(JOINTS, (0.0, 0.5), strict=True)
    ),
    "p",
)
#: What the columns of joint j (from 1) are called, by role.
HEADERS = {
    "of a log": {"q": "q{j}", "qd": "qd{j}", "tau": "tau{j}"},
    "from zero": {"q": "q{o}", "qd": "qd{o}", "tau": "tau{o}"},
    "from zero, underscores": {"q": "q_{o}", "qd": "qd_{o}", "tau": "tau_{o}"},
    "an estimate": {"q": "joint{j}.q", "qd": "joint{j}.qd", "tau": "joint{j}.tauest [Nm]"},
    "German": {"t": "Zeit", "q": "{name} Winkel", "qd": "{name} Tempo", "tau": "{name} Moment"},
    "other names": {"q": "{letter}_pos", "qd": "{letter}_vel", "tau": "{letter}_torque"},
    # Messages list joints by the alphabet: the elbow comes first.
    "rostopic": {
        "q": "field.position{last}", "qd": "field.velocity{last}", "tau": "field.effort{last}",
    },
}  # fmt: skip
GERMAN = "t=Zeit,q=* Winkel,qd=* Tempo,tau=* Moment"
#: Header, columns that are added in front, ending, options, and [log] columns of the robot.
FOREIGN = {
    "from zero": ("from zero", {}, "csv", {}, ""),
    "from zero, with a pattern": ("from zero", {}, "csv", {"columns": "q=q*,qd=qd*,tau=tau*"}, ""),
    "from zero, underscores": ("from zero, underscores", {}, "csv", {}, ""),
    "rostopic": ("rostopic", {"field.name0": "elbow", "field.name1": "shoulder"}, "csv", {}, ""),
    "rostopic, other names": (
        "rostopic", {"field.name0": "e", "field.name1": "s"}, "csv", {"joints": ("s", "e")}, "",
    ),
    "other names": ("other names", {}, "csv", {"joints": ("a", "b")}, ""),
    "no header": (
        "of a log", {}, "csv",
        {"header": False, "columns": "t=1,q1=2,q2=3,qd1=4,qd2=5,tau1=6,tau2=7"}, "",
    ),
    "a pattern before a unit": ("an estimate", {}, "csv", {"columns": "tau=*.tauest"}, ""),
    "the pattern that the refusal suggests": (
        "an estimate", {}, "csv", {"columns": "tau=joint*.tauest"}, "",
    ),
    "a pattern with a unit": ("an estimate", {}, "csv", {"columns": "tau=*.tauest [Nm]"}, ""),
    "text": ("of a log", {}, "txt", {}, ""),
    "tabs": ("of a log", {}, "tsv", {}, ""),
    "columns of the robot file": ("German", {}, "csv", {}, GERMAN),
    "columns of the robot file, a log of symgen": ("of a log", {}, "csv", {}, GERMAN),
}  # fmt: skip


def foreign(path: Path, case: str, columns=SI, front=None, header=True) -> Path:
    """Write a log of two joints with other names of columns."""
    forms = HEADERS[case]
    named = {forms.get("t", "t"): columns["t"]}
    for role in ("q", "qd", "tau"):
        for j, name in enumerate(JOINTS, 1):
            column = forms[role].format(
                j=j, o=j - 1, last=len(JOINTS) - j, name=name, letter="xab"[j]
            )
            named[column] = columns[f"{role}{j}"]
    front = {name: [text] * len(columns["t"]) for name, text in (front or {}).items()}
    written(path, front | named, "\t" if path.suffix == ".tsv" else ",")
    if not header:
        path.write_text(path.read_text().split("\n", 1)[1])
    return path


@pytest.mark.parametrize("case", FOREIGN)
def test_columns_of_a_recorder_are_those_of_the_log(tmp_path, case):
    header, front, suffix, options, columns = FOREIGN[case]
    path = foreign(
        tmp_path / f"log.{suffix}", header, front=front, header=options.get("header", True)
    )
    mapped = symgen.parse_robot(symgen.robot_toml(replace(NAMED, log_columns=columns)))
    found = read_log(
        path, sigma=(0, 0), reading=Reading(**options), names=JOINTS, columns=mapped.log_columns
    )
    same = read(written(tmp_path / "si.csv", SI))
    for key in ("t", "q", "qd", "tau"):
        np.testing.assert_array_equal(getattr(found, key), getattr(same, key))


ONCE = {k: x[:400] for k, x in SI.items()}
BACK = [f"{0.01 * k - 0.5 * (k >= 200):.12g}" for k in range(400)]
#: Header, changed columns, columns in front, whether there is a header, and what the line says.
UNREADABLE = {
    "no header": ("of a log", {}, {}, False, ["--no-header", "--columns"]),
    "a name that is not the robot's": (
        "rostopic", {}, {"field.name0": "e", "field.name1": "s"}, True, ["'shoulder'", "--joints"],
    ),
    "torques by no word": (
        "an estimate", {}, {}, True, ["tau1", '--columns "tau=joint*.tauest"'],
    ),
    "all stamps are one": ("of a log", {"t": ["1.6e+09"] * 400}, {}, True, ["column t", "digits"]),
    "the clock is set back": (
        "of a log", {"t": BACK}, {}, True,
        ["column t", "sample 200", "1.5 s comes after 1.99 s", "--until 1.98", "--from 1.51"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", UNREADABLE)
def test_what_a_recorder_leaves_open_is_refused_with_what_to_type(tmp_path, case):
    names, changed, front, header, words = UNREADABLE[case]
    path = foreign(tmp_path / "log.csv", names, ONCE | changed, front, header)
    with pytest.raises(LogError) as refused:
        read_log(path, sigma=(0, 0), names=JOINTS)
    for word in words:
        assert word in str(refused.value)


def test_both_sides_of_a_clock_that_was_set_back_can_be_used(tmp_path):
    path = foreign(tmp_path / "log.csv", "of a log", ONCE | {"t": BACK})
    for span, kept in (({"until": 1.98}, slice(0, 199)), ({"start": 1.51}, slice(201, 400))):
        log = read(path, **span)
        np.testing.assert_array_equal(log.t, np.array(BACK[kept], dtype=float))
        np.testing.assert_array_equal(log.q[:, 0], np.array(ONCE["q1"][kept], dtype=float))


@pytest.mark.parametrize("digits", [1, 2])
def test_stamps_rounded_below_the_rate_are_a_uniform_clock(tmp_path, digits):
    t = np.round(0.004 * np.arange(1500) + 3e-4, digits)
    log = read(foreign(tmp_path / "log.csv", "of a log", SI | {"t": [f"{x}" for x in t]}))
    np.testing.assert_allclose(np.diff(log.t), 0.004, rtol=2e-3)
    ((column, _, done),) = log.converted
    assert column == "t"
    assert "4 ms" in done


@pytest.mark.parametrize("name", ["log.mat", "log.bag", "arm.xacro"])
def test_a_file_of_another_program_is_refused_with_its_conversion(tmp_path, name):
    path = tmp_path / name
    path.write_text('<robot xmlns:xacro="x"><xacro:property name="a" value="1"/></robot>')
    command = {".mat": "numpy.savez", ".bag": "rosbags-convert", ".xacro": "xacro FILE.xacro >"}
    with pytest.raises(symgen.SymgenError) as refused:
        symgen.read_robot(path) if path.suffix == ".xacro" else read(path)
    assert command[path.suffix] in str(refused.value)


@pytest.mark.parametrize(
    ("rate", "gap", "masked"), [(350, 0.034, True), (32, 0.315, True), (350, 8.0, True)]
)
def test_a_gap_is_judged_by_its_time_and_no_equation_crosses_it(rate, gap, masked):
    """Motions below 1 Hz: the estimate is that of the log without the gap."""
    step = 1 / rate
    columns = motion(int(40 * rate), 3, step=step)
    at = columns["t"]
    kept = (at < 15) | (at > 15 + gap)

    def found(rows):
        x = {k: np.column_stack([columns[f"{k}{j}"][rows] for j in (1, 2)]) for k in ("q", "tau")}
        return symgen.identify(
            robot(), symgen.make_log("log", at[rows], x["q"], x["tau"]), model="momentum"
        )

    whole, part = found(slice(None)), found(kept)
    assert any("gap" in note for note in part.notes) == masked
    std = np.array([p.std for p in whole.parameters])
    assert (np.abs(part.X - whole.X) < 3 * std).all()
