"""Logs as recorders write them: other separators, units and dates, and cells that are empty.

The oracle is the same log in SI units, written with commas and decimal points.
"""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
import scipy.io
from support_streams import motion, parquet, robot

import symgen
from symgen.data.log import read_log
from symgen.data.raw import Reading
from symgen.errors import LogError
from symgen.estimation.opening import open_log
from symgen.robot.tables import LogForm

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


def csv_text(names=None, columns=SI, rows=300) -> str:
    """Return the text of a log with commas."""
    names = names or [*columns]
    table = [",".join(row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([",".join(names), *table[:rows]]) + "\n"


def timed(form) -> str:
    """Return the text of a log whose times are texts."""
    return csv_text(columns=SI | {"t": [form(float(t)) for t in SI["t"]]})


def apart(seconds: str, rest: str, ticks: int) -> str:
    """Return the text of a log with seconds and their rest in two columns."""
    stamps = [1650000000 * ticks + round(float(t) * ticks) for t in SI["t"]]
    both = {seconds: [str(x // ticks) for x in stamps], rest: [str(x % ticks) for x in stamps]}
    return csv_text(columns=both | {k: x for k, x in SI.items() if k != "t"})


WORDS = {"q": "position", "qd": "velocity", "tau": "effort"}
JOINTS = ("shoulder", "elbow")
UNITS = "s,rad,rad,rad/s,rad/s,Nm,Nm"
#: Recorders' texts of the same log, and what they say of it; options that they need.
TEXTS = {
    "a comment before the header": ("# " + csv_text(), "", {}),
    "blanks, and a comment": ("# " + csv_text().replace(",", " "), "blanks", {}),
    "columns of equal width": (csv_text().replace(",", "   "), "blanks", {}),
    "bars": (csv_text().replace(",", "|"), "'|'", {}),
    "a preamble": ("Recorder,V2.1\nRate [Hz],100\n\n" + csv_text(), "not read: 3", {}),
    "a preamble of 50 lines": ("a,1,b\n" * 49 + "\n" + csv_text(), "not read: 50", {}),
    "a preamble with as many cells": (
        "Channels,2\nSamples,1,1,1,1,1,1\nX,Time\n" + csv_text(), "not read: 3", {},
    ),
    "a preamble of a spreadsheet": ("Recorder,V2.1,,,,,\n" + csv_text(), "not read: 1", {}),
    "a preamble, semicolons": (
        "Recorder, V2, and more\n" + csv_text().replace(",", ";"), "semicolons", {},
    ),
    "a preamble and no header": (
        "Recorder,V2.1\n" + csv_text().split("\n", 1)[1], "not read: 1",
        {"header": False, "columns": "t=1,q1=2,q2=3,qd1=4,qd2=5,tau1=6,tau2=7"},
    ),
    "units": (csv_text().replace("\n", f"\n{UNITS}\n", 1), "has the units", {}),
    "units in brackets": (
        csv_text(["Zeit", *[*SI][1:]]).replace("\n", "\n[s],(rad),(rad),,,(Nm),(Nm)\n", 1),
        "has the units", {"columns": "t=Zeit"},
    ),
    "seconds with a unit": (timed(lambda t: f"{t:.3f} sec"), "durations", {}),
    "milliseconds with a unit": (timed(lambda t: f"{1e3 * t:.12g}ms"), "durations", {}),
    "a clock": (timed(lambda t: f"01:{t // 60:02.0f}:{t % 60:06.3f}"), "durations", {}),
    "a clock of minutes": (timed(lambda t: f"{t // 60:02.0f}:{t % 60:06.3f}"), "durations", {}),
    "days": (timed(lambda t: f"0 days 00:00:{t:09.6f}"), "durations", {}),
    "two columns": (apart("secs", "nsecs", 10**9), "t = secs+nsecs", {}),
    "two columns, us": (apart("stamp.sec", "stamp.usec", 10**6), "stamp.usec", {}),
    "two columns of an option": (apart("a", "b", 10**9), "", {"columns": "t=a+b"}),
    "a column twice": (csv_text([*SI, "x", "x"], SI | {"x": SI["t"], "y": SI["q1"]}), "", {}),
}  # fmt: skip


@pytest.mark.parametrize("case", TEXTS)
def test_a_text_of_a_recorder_is_the_log_in_si(tmp_path, case):
    text, says, options = TEXTS[case]
    path = tmp_path / "log.csv"
    path.write_text(text)
    found = read(path, **options)
    np.testing.assert_allclose(found.t - found.t[0], COLUMNS["t"][:300], atol=1e-7)
    for key in ("q", "qd", "tau"):
        values = np.column_stack([COLUMNS[f"{key}{j}"][:300] for j in (1, 2)])
        np.testing.assert_allclose(getattr(found, key), values, rtol=1e-11, atol=1e-11)
    assert says in "; ".join([*found.notes, *map(str, found.converted)])


#: Texts that could be read in two ways, and what the refusal says.
UNCLEAR = {
    "hours or minutes": (timed(lambda t: f"00:{t % 60:02.0f}"), ["column t, sample 0"]),
    "one duration is a word": (
        timed(lambda t: f"{t:.3f} sec").replace("\n0.050 sec", "\nlater"),
        ["column t, sample 0"],
    ),
    "us without a name": (apart("a", "b", 10**6), ["rest in 'b'", "usec"]),
    "a used column twice": (csv_text([*[*SI][:-1], "q1"]), ["q1 occurs 2 times", "--no-header"]),
    "units and words": (
        csv_text().replace("\n", "\ns,rad,axis,of,the,robot,Nm\n", 1),
        ["no column t among s, rad, axis"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", UNCLEAR)
def test_a_text_with_two_meanings_is_refused(tmp_path, case):
    text, says = UNCLEAR[case]
    path = tmp_path / "log.csv"
    path.write_text(text)
    options = {"columns": "t=a+b"} if case.startswith("us") else {}
    with pytest.raises(LogError) as refused:
        read(path, **options)
    for words in says:
        assert words in str(refused.value)


@pytest.mark.parametrize("form", ["['{}', '{}']", "[{}, {}]", "({}, {})"])
def test_a_list_of_joints_in_a_column_orders_the_others(tmp_path, form):
    names = {f"{key}{j}": f"{word}_{2 - j}" for key, word in WORDS.items() for j in (1, 2)}
    joints = [form.format(*reversed(JOINTS))] * 1500
    path = written(tmp_path / "log.csv", {"name": joints} | renamed(names))
    found = read_log(path, sigma=(0, 0), names=JOINTS)
    for key in WORDS:
        values = np.column_stack([COLUMNS[f"{key}{j}"] for j in (1, 2)])
        np.testing.assert_allclose(getattr(found, key), values, rtol=1e-11, atol=1e-11)
    joints[-1] = form.format(*JOINTS)
    path = written(tmp_path / "log.csv", {"name": joints} | renamed(names))
    with pytest.raises(LogError, match="joints in column name change"):
        read_log(path, sigma=(0, 0), names=JOINTS)


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
    told = [(f.channel, f.why, f.samples, f.done) for f in found.repairs]
    assert told == [
        ("q1, tau2", "empty cells", 4, "interpolated"),
        ("qd2", "empty cells in a row", 40, "masked, for all joints"),
        ("tau2", "empty cells in a row", 100, "masked"),
    ]
    std = np.array([p.std for p in full.parameters])
    assert (np.abs(found.X - full.X) < std).all()


def in_lists(columns, kind) -> dict[str, object]:
    """Return the columns of a log as LeRobot stores them, the joints in one column."""
    names = {"q": "observation.state", "qd": "observation.velocity", "tau": "observation.effort"}
    rows = {key: np.column_stack([columns[f"{key}{j}"] for j in (1, 2)]) for key in names}
    lists = {names[key]: pa.array(x.tolist(), kind) for key, x in rows.items()}
    return {"timestamp": columns["t"], "action": lists["observation.state"], **lists}


@pytest.mark.parametrize("kind", [pa.list_(pa.float64()), pa.list_(pa.float64(), 2)])
def test_joints_in_a_list_are_columns(tmp_path, kind):
    path = parquet(tmp_path / "log.parquet", in_lists(COLUMNS, kind))
    with pytest.raises(LogError, match=r"""--columns "q=observation.state\[\*\]"$"""):
        read_log(path, sigma=(0, 0))
    single = ",".join(f"q{j + 1}=observation.state[{j}]" for j in (0, 1))
    for columns in (single, "q=observation.state[*]"):
        log = read(path, columns=columns)
        np.testing.assert_array_equal(log.q[:, 1], COLUMNS["q2"])
        np.testing.assert_array_equal(log.tau[:, 0], COLUMNS["tau1"])


def test_a_list_with_more_than_the_joints_is_refused_with_the_option(tmp_path):
    """A gripper is often the last element."""
    lists = in_lists(COLUMNS, pa.list_(pa.float64()))
    longer = {k: pa.array([[*x.as_py(), 0.0] for x in lists[k]]) for k in lists if "obs" in k}
    path = parquet(tmp_path / "log.parquet", lists | longer)
    for columns, says in (
        ("", '"q=observation.state[*]"'),
        ("q=observation.state[*]", "--joints 0,1"),
    ):
        with pytest.raises(LogError) as refused:
            read(path, columns=columns)
        assert says in str(refused.value)
    q = "q1=observation.state[0],q2=observation.state[1]"
    log = read(path, columns=f"{q},tau1=observation.effort[0],tau2=observation.effort[1]")
    np.testing.assert_array_equal(log.q[:, 1], COLUMNS["q2"])
    assert log.qd is None
    log = read(path, columns="q=observation.state[*]", joints=("0", "1"))
    np.testing.assert_array_equal(log.tau[:, 1], COLUMNS["tau2"])


def test_lists_of_words_or_of_several_lengths_are_refused(tmp_path):
    names = {"t": COLUMNS["t"][:20], "tau1": COLUMNS["tau1"][:20]}
    for lists, says in (([["a"]] * 20, "holds string"), ([[1.0]] * 19 + [[]], "out of bounds")):
        path = parquet(tmp_path / "log.parquet", names | {"x": lists})
        with pytest.raises(LogError, match=says):
            read_log(path, sigma=(0,), reading=Reading(columns="q1=x[0]"))


def test_a_long_foreign_log_gives_the_estimate_of_the_log_in_si(tmp_path, monkeypatch):
    monkeypatch.setattr("symgen.data.long_logs.LIMIT", 2000)
    columns = motion(3000, 1)
    values = {k: x * DEG if k in DEGREES else x for k, x in columns.items()}
    values["t"] = NANOSECONDS[0] + 10_000_000 * np.arange(3000)
    for folder, table in (
        ("si", columns),
        ("log", {DEGREES.get(k, k): x for k, x in values.items()}),
        ("lists", in_lists(columns, pa.list_(pa.float64()))),
    ):
        (tmp_path / folder).mkdir()
        parquet(tmp_path / folder / "a.parquet", table)
    arm = replace(robot(), log=LogForm("q=observation.state[*],qd=observation.velocity[*]"))
    same, found, lists = (
        symgen.identify(arm, str(tmp_path / folder), model="momentum")
        for folder in ("si", "log", "lists")
    )
    np.testing.assert_array_equal(lists.X, same.X)
    assert pytest.approx(same.X, rel=1e-9) == found.X
    assert [*dict.fromkeys(f.channel for f in found.repairs)] == ["t", *CASES["degrees"][3]]


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
    form = LogForm(columns=columns) if columns else None
    mapped = symgen.parse_robot(symgen.robot_toml(replace(NAMED, log=form)))
    found = open_log(path, mapped, Reading(**options))
    same = read(written(tmp_path / "si.csv", SI))
    for key in ("t", "q", "qd", "tau"):
        np.testing.assert_array_equal(getattr(found, key), getattr(same, key))


DEGREES_2 = renamed({}, **times("q", DEG))
#: Text of a log, and [log] of the robot file, by which no option is necessary.
FORMS = {
    "semicolons, decimal commas and degrees": (
        csv_text(columns=DEGREES_2).translate(str.maketrans(",.", ";,")).replace("q1;q2", "w1;w2"),
        'columns = "q=w*"\nunit = "q=deg"\nseparator = ";"\ndecimal = ","',
    ),
    "no header, ms": (
        csv_text(columns=SI | {"t": [f"{1e3 * x:.12g}" for x in COLUMNS["t"]]}).split("\n", 1)[1],
        'columns = "t=1,q1=2,q2=3,qd1=4,qd2=5,tau1=6,tau2=7"\ntime_unit = "ms"\nheader = false',
    ),
    "other joints": (
        csv_text(["t", *(f"{j}_{w}" for w in WORDS.values() for j in ("x", "y"))]),
        'joints = ["x", "y"]',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", FORMS)
def test_the_robot_file_states_the_form_of_its_logs(tmp_path, case):
    text, form = FORMS[case]
    (tmp_path / "log.csv").write_text(text)
    stated = symgen.parse_robot(f"{symgen.robot_toml(NAMED)}\n[log]\n{form}\n")
    arm = symgen.parse_robot(symgen.robot_toml(stated))
    found = open_log(tmp_path / "log.csv", arm)
    own = open_log(written(tmp_path / "si.csv", SI), arm)  # as symgen writes them
    same = read(tmp_path / "si.csv")
    for key in ("t", "q", "qd", "tau"):
        np.testing.assert_array_equal(getattr(own, key), getattr(same, key))
        np.testing.assert_allclose(getattr(found, key), getattr(same, key)[:300], atol=1e-11)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_units_of_the_robot_file_need_columns_where_a_log_may_be_symgen_s(tmp_path, suffix):
    path = tmp_path / f"log.{suffix}"
    if suffix == "csv":
        written(path, SI)
    elif suffix == "parquet":
        parquet(path, COLUMNS)
    else:
        roles = {r: np.column_stack([COLUMNS[f"{r}{j}"] for j in (1, 2)]) for r in ("q", "tau")}
        np.savez(path, t=COLUMNS["t"], **roles)
    arm = replace(NAMED, log=LogForm(unit="q=deg,qd=deg/s"))
    with pytest.raises(LogError, match=r"columns in \[log\].*--unit rad"):
        open_log(path, arm)
    np.testing.assert_allclose(
        open_log(path, arm, Reading(unit={"": "rad"})).q[:, 0], COLUMNS["q1"]
    )
    if suffix != "npz":
        arm = replace(NAMED, log=LogForm(columns="q=q*,tau=tau*", unit="q=deg,qd=deg/s"))
        np.testing.assert_allclose(open_log(path, arm).q[:, 0] * DEG, COLUMNS["q1"])


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


@pytest.mark.parametrize("squeeze", [True, False])
@pytest.mark.parametrize("compressed", [True, False])
def test_the_arrays_of_a_mat_file_are_a_log(tmp_path, squeeze, compressed):
    roles = {r: np.column_stack([COLUMNS[f"{r}{j}"] for j in (1, 2)]) for r in ("q", "qd", "tau")}
    scipy.io.savemat(tmp_path / "log.mat", {"t": COLUMNS["t"]} | roles | {"note": "a"})
    found = scipy.io.loadmat(tmp_path / "log.mat", squeeze_me=squeeze)
    save = np.savez_compressed if compressed else np.savez
    save(tmp_path / "log.npz", **found)
    log = read(tmp_path / "log.npz")
    np.testing.assert_array_equal(log.t, COLUMNS["t"])
    np.testing.assert_array_equal(log.tau, roles["tau"])


@pytest.mark.parametrize("time_unit", ["s", "ms"])
def test_rows_that_are_poses_are_refused_with_what_to_record(tmp_path, time_unit):
    q = np.random.default_rng(0).uniform(-2, 2, (24, 6))
    columns = {"pose": np.arange(24)} | {f"q{j + 1}": q[:, j] for j in range(6)}
    columns |= {f"tau{j + 1}": np.sin(q[:, j]) for j in range(6)}
    path = written(tmp_path / "log.csv", {k: [f"{v:.9g}" for v in x] for k, x in columns.items()})
    arm = symgen.read_robot("puma560")
    with pytest.raises(LogError, match=r'no column t .*"t=pose", if it is a time; poses'):
        symgen.identify(arm, path)
    reading = Reading(columns="t=pose", time_unit=time_unit)
    with pytest.raises(LogError, match=r"rows are poses.*holds each pose for 2 s"):
        symgen.identify(arm, path, reading=reading)


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


def counts_of(bit: int) -> tuple[np.ndarray, np.ndarray]:
    """Return torques as counts, and as a servo sends them: the sign in a bit."""
    counts = np.round(0.9 * 2**bit * COLUMNS["tau1"] / np.abs(COLUMNS["tau1"]).max())
    return counts, np.where(counts < 0, 2**bit - counts, counts)


@pytest.mark.parametrize("bit", [7, 10, 15])
def test_a_sign_in_a_bit_is_refused_with_the_option_that_reads_it(tmp_path, bit):
    counts, sent = counts_of(bit)
    path = written(tmp_path / "log.csv", renamed({}, tau1=sent))
    with pytest.raises(LogError, match=f"column tau1 .*sign is in bit {bit}.*--unit tau=sign{bit}"):
        read(path)
    log = read(path, unit={"tau1": f"sign{bit}", "tau2": "Nm"})
    np.testing.assert_array_equal(log.tau[:, 0], counts)
    assert log.converted == (("tau1", f"in sign{bit} by --unit", "read so"),)
    with pytest.raises(LogError, match=rf"--unit sign{bit - 1}.*0 to {2**bit - 1}"):
        read(path, unit={"tau1": f"sign{bit - 1}", "tau2": "Nm"})


@pytest.mark.parametrize(
    "torques",
    [
        np.where(counts_of(10)[0] < 0, counts_of(10)[0] + 2**16, counts_of(10)[0]),  # unsigned
        np.where(counts_of(7)[0] < 0, counts_of(7)[0] + 2**8, counts_of(7)[0]),
        np.abs(counts_of(10)[0]),
        1000 + counts_of(9)[0],
        np.round(np.random.default_rng(0).uniform(0, 2000, 1500)),
    ],
)
def test_other_counts_have_no_sign_bit(tmp_path, torques):
    path = written(tmp_path / "log.csv", renamed({}, tau1=torques))
    np.testing.assert_array_equal(read(path).tau[:, 0], torques)


RATED = "\n[drive]\nrated = [20.0, 5.0]\nside = 'link'\n"


@pytest.mark.parametrize("header", [True, False])
def test_a_share_of_the_rated_torque_needs_the_rated_torque(tmp_path, header):
    names = {f"tau{j}": f"tau{j} [%]" if header else f"tau{j}" for j in (1, 2)}
    shares = {f"tau{j}": 100 * COLUMNS[f"tau{j}"] / r for j, r in ((1, 20.0), (2, 5.0))}
    path = written(tmp_path / "log.csv", renamed(names, **shares))
    options = {} if header else {"unit": {"tau": "%"}}
    with pytest.raises(LogError, match=r"of the rated torque, .*rated = \[\.\.\] in \[drive\]"):
        read(path, **options)
    drive = symgen.parse_robot(symgen.robot_toml(robot()) + RATED).drive
    log = read_log(path, sigma=(0, 0), drive=drive, reading=Reading(**options))
    tau = np.column_stack([COLUMNS["tau1"], COLUMNS["tau2"]])
    np.testing.assert_allclose(log.tau, tau, rtol=1e-12, atol=1e-12)
    assert "%" in log.converted[0][1]
