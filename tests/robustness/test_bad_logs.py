"""A log that cannot be used is refused with one line: the file, what is wrong, what is accepted."""

from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.data.log import make_log, read_log
from symgen.data.raw import Reading
from symgen.errors import LogError

T = np.arange(12) * 0.01
Q = np.column_stack([np.sin(3 * T), np.cos(2 * T)])
GOOD = "t,q1,q2,tau1,tau2\n" + "".join(f"{k / 100},{k % 7},{k % 5},{k % 3},1\n" for k in range(12))
HEADER = GOOD.split("\n")[0]


def refused(path: Path, *words: str, **options: object) -> None:
    with pytest.raises(LogError) as caught:
        read_log(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    for word in (str(path), "accepted: ", *words):
        assert word in message, message


def line(k: int, cells: str) -> str:
    """Return the good log with its sample k replaced."""
    rows = GOOD.splitlines()
    rows[k + 1] = cells
    return "\n".join(rows) + "\n"


@pytest.fixture
def csv_of(tmp_path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "log.csv"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write


def test_the_log_that_the_cases_below_spoil_is_good(csv_of):
    assert read_log(csv_of(GOOD), 2).q.shape == (12, 2)


def test_a_missing_file_is_named(tmp_path):
    refused(tmp_path / "nothing.csv", "no such file")


@pytest.mark.parametrize("name", ["folder", "folder.csv", "folder.parquet", "folder.npz"])
def test_a_folder_is_not_a_log(tmp_path, name):
    (tmp_path / name).mkdir()
    refused(tmp_path / name, "is a folder")


@pytest.mark.parametrize("name", ["log.xyz", "log", "log.csv.gz"])
def test_an_unknown_extension_lists_the_known_ones(tmp_path, name):
    (tmp_path / name).write_text(GOOD)
    refused(tmp_path / name, "extension", ".csv", ".parquet", ".npz")


@pytest.mark.parametrize("name", ["log.csv", "log.parquet", "log.npz"])
def test_an_empty_file_is_said_to_be_empty(tmp_path, name):
    (tmp_path / name).touch()
    refused(tmp_path / name, "empty")


def test_a_name_that_no_file_can_have_is_refused():
    with pytest.raises(LogError, match="accepted"):
        read_log("a\0b.csv")
    with pytest.raises(LogError, match="accepted"):
        read_log("a" * 5000 + ".csv")


CSV_CASES = {
    "blank lines only": ("\n\n\n", ["no column t", "none"]),
    "header only": (HEADER + "\n", ["no samples"]),
    "header without newline": (HEADER, ["no samples"]),
    "nine samples": ("\n".join(GOOD.splitlines()[:10]), ["9 samples", "at least 10"]),
    "no header": (GOOD.split("\n", 1)[1].replace("0.0,0,0,0,1", "0,2,3,4,5", 1), ["--no-header"]),
    "no t": (GOOD.replace("t,", "clock,", 1), ["no column t", "clock, q1"]),
    "no q": (GOOD.replace("q", "p"), ["no column q1", "p1"]),
    "no tau": (GOOD.replace("tau", "moment"), ["no column tau1", "moment1"]),
    "currents": (GOOD.replace("tau", "i"), ["torque columns", "torque_constant", "[drive]"]),
    "gap in q": (GOOD.replace("q2", "q3"), ["q1, q3", "there are only"]),
    "gap in tau": (GOOD.replace("tau1", "tau3"), ["tau2, tau3", "there are only"]),
    "from minus one": (GOOD.replace("q2", "q-1"), ["of q: 1, of tau: 2"]),
    "twice": (GOOD.replace("q2", "q1"), ["column q1", "2 times"]),
    "twice, blanks": (GOOD.replace("q2", " q1 "), ["column q1", "2 times"]),
    "one tau": (GOOD.replace("tau2", "x"), ["of q: 2, of tau: 1"]),
    "two qd": (GOOD.replace("q2,tau1,tau2", "tau1,qd1,qd2"), ["of q: 1, of qd: 2"]),
    "text": (line(5, "0.05,1,abc,2,1"), ["column q2", "sample 5", "'abc'"]),
    "text first": (line(0, "zero,1,2,2,1"), ["column t", "sample 0", "'zero'"]),
    "date": (line(0, "2020-01-01 00:00:00,1,2,2,1"), ["column t", "sample 0"]),
    "boolean": (line(3, "0.03,true,2,2,1"), ["column q1", "sample 3", "'true'"]),
    "decimal comma": (line(3, "0,03,1,2,2,1"), ["sample 3", "6 values for 5 columns"]),
    "cut off": (GOOD[:-4], ["sample 11", "4 values for 5 columns"]),
    "short row": (line(4, "0.04,1"), ["sample 4", "2 values for 5 columns"]),
    "inf": (line(7, "0.07,1,2,2,-inf"), ["column tau2", "sample 7", "-inf"]),
    "overflow": (line(7, "0.07,1e999,2,2,1"), ["column q1", "sample 7", "inf"]),
    "nan in t": (line(7, "nan,1,2,2,1"), ["column t", "sample 7"]),
    "empty column": (GOOD.replace(",1\n", ",\n"), ["column tau2", "12 of 12 cells"]),
    "t repeats": (line(7, "0.06,1,2,2,1"), ["column t", "sample 7", "0.06 s", "increasing"]),
    "t goes back": (line(7, "0.01,1,2,2,1"), ["column t", "sample 7", "0.06 s"]),
    "quoted newline": (GOOD.replace("t,", '"a\nb",', 1), ["no column t"]),
    "not utf-8": (GOOD.replace("q2", "q\xb2").encode("latin-1"), ["utf-8"]),
    "binary": (bytes(range(256)) * 4, ["utf-8"]),
}


@pytest.mark.parametrize("case", CSV_CASES)
def test_a_spoiled_csv_is_refused_with_its_place(csv_of, case):
    text, words = CSV_CASES[case]
    refused(csv_of(text), *words)


def test_text_far_behind_the_first_block_of_a_csv_is_found(csv_of):
    rows = [f"{k},1.25,2.5,3.75,4.125" for k in range(100_000)]
    rows[99_990] = "99990,1,2,bad,4"
    refused(csv_of(HEADER + "\n" + "\n".join(rows)), "column tau1", "sample 99990", "'bad'")


@pytest.mark.parametrize(("log", "robot"), [(2, 6), (2, 1)])
def test_a_wrong_number_of_joints_says_both_numbers(csv_of, log, robot):
    words = f"the log has {log} joints, the robot has {robot}"
    refused(csv_of(GOOD), words, n=robot)
    refused(csv_of(GOOD), words, sigma=(0,) * robot)


# --- Units and separators ----------------------------------------------------


def moving(names: str = "t,q1,qd1,tau1", q: float = 1.0, qd: float = 1.0, t: float = 1.0) -> str:
    """Return a log of a joint that moves, in other units."""
    at = 0.01 * np.arange(60)
    columns = (t * at, q * np.sin(3 * at), 3 * qd * np.cos(3 * at), np.cos(2 * at))
    rows = (",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))
    return "\n".join([names, *rows]) + "\n"


DEG = 180 / np.pi
#: Text of a file, options, and what the one line names: the column of the file, and what to type.
UNSURE = {
    "decimal commas between commas": (
        moving().replace(".", ","), {}, ["sample 1", "8 values for 4 columns", "--separator ';'"],
    ),
    "two decimal marks": (
        moving().replace(",", ";").replace("0.14", "0,14"), {}, ["'0.01'", "--decimal"],
    ),
    "positions in degrees": (
        moving(q=DEG / 2, qd=0.5), {}, ["q1", "57.3", "--unit q=deg,qd=rad/s"],
    ),
    "speeds in degrees": (
        moving(qd=DEG), {}, ["qd1", "57.3", "--unit q=rad,qd=deg/s"],
    ),
    "degrees, and no speeds": (moving("t,q1,x,tau1", q=60.0), {}, ["column q1", "--unit deg"]),
    "headers against the slope": (
        moving("t,q1 [deg],qd1 [rad/s],tau1"), {}, ["q1 [deg]", "qd1 [rad/s]", "--unit q="],
    ),
    "an unknown unit": (moving("t,q1 [grad],qd1,tau1"), {}, ["'grad'", "deg", "--unit q=rad"]),
    "a unit of something else": (
        moving("t,q1,qd1,tau1 [deg]"), {}, ["'tau1 [deg]'", "torque", "--unit tau=Nm"],
    ),
    "time against its rate": (
        moving("time_ms,q1,qd1,tau1"), {}, ["'time_ms' (t)", "ms", "--time-unit s"],
    ),
    "a unit of no column": (moving(), {"unit": {"qs": "deg"}}, ["--unit qs", "q, qd, tau"]),
    "no such unit": (moving(), {"unit": {"q": "miles"}}, ["--unit q=miles", "rad, deg"]),
    "a unit that the option makes wrong": (
        moving(), {"unit": {"q": "deg", "qd": "rad/s"}}, ["looks like", "--unit q"],
    ),
    "no such separator": (
        moving(), {"separator": "|"}, ["no column t", "t,q1,qd1,tau1"],
    ),
    "a date of another form": (
        moving().replace("\n0,", "\n24.11.2026 13:00:00,"), {},
        ["column t", "'24.11.2026 13:00:00'", "seconds, or dates such as 2026-"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", UNSURE)
def test_what_a_file_leaves_open_is_refused_with_what_to_type(csv_of, case):
    text, options, words = UNSURE[case]
    refused(csv_of(text), *words, sigma=(0,), reading=Reading(**options))


@pytest.mark.parametrize(("factor", "unit"), [(1e2, "ms"), (1e5, "us"), (1e8, "ns")])
def test_a_rate_that_no_recorder_has_names_the_option(csv_of, factor, unit):
    robot = symgen.parse_robot('[robot]\nname = "p"\ngravity = [0.0, 0.0, -9.81]\n[[joint]]\n')
    path = csv_of(moving(t=10 * factor))
    with pytest.raises(LogError, match=rf"--time-unit {unit}"):
        symgen.identify(robot, path)
    assert read_log(path, reading=Reading(time_unit=unit)).t[1] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"unit": {"x": "deg"}}, "--unit x=deg"),
        ({"unit": {"": "mm"}}, "--unit mm"),
        ({"time_unit": "min"}, "--time-unit min"),
        ({"separator": "::"}, "--separator '::'"),
        ({"decimal": "'"}, "--decimal"),
        ({"decimal": ",", "separator": ","}, "--decimal ','"),
    ],
)
def test_an_option_that_means_nothing_is_refused(option, says):
    with pytest.raises(LogError, match=f"{says}.*accepted"):
        Reading(**option)


# --- Parquet -------------------------------------------------------------------------------------


def parquet(path: Path, **changes: object) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {"t": T, "q1": Q[:, 0], "tau1": Q[:, 1]} | changes
    pq.write_table(pa.table(columns), path)
    return path


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"q1": ["a"] * 12}, ["column q1", "string"]),
        ({"t": np.arange(12).astype("datetime64[D]")}, ["column t", "date32"]),
        ({"q1": [[1.0, 2.0]] * 12}, ["q1[*]", "--columns"]),
        ({"tau1": [None] * 3 + [1.0] * 9}, ["column tau1", "3 of 12 cells"]),
        ({" t": T}, ["column t", "2 times"]),
        ({"q3": T}, ["q1, q3"]),
    ],
)
def test_a_spoiled_parquet_table_is_refused_with_its_place(tmp_path, changes, words):
    refused(parquet(tmp_path / "log.parquet", **changes), *words)


def test_a_parquet_table_without_rows_is_refused(tmp_path):
    none = np.zeros(0)
    refused(parquet(tmp_path / "log.parquet", t=none, q1=none, tau1=none), "no samples")


@pytest.mark.parametrize("damage", ["head", "tail", "middle", "text"])
def test_a_damaged_parquet_file_is_refused(tmp_path, damage):
    path = parquet(tmp_path / "log.parquet")
    whole = path.read_bytes()
    half = len(whole) // 2
    path.write_bytes(
        {
            "head": whole[:half],
            "tail": whole[half:],
            "middle": whole[: half - 40] + b"\xff" * 80 + whole[half + 40 :],
            "text": GOOD.encode(),
        }[damage]
    )
    refused(path)


# --- NPZ -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"t": None}, ["no array t"]),
        ({"tau": None}, ["no array tau"]),
        ({"tau": None, "i": Q}, ["torque_constant", "[drive]"]),
        ({"t": Q}, ["t has the shape (12, 2)", "t (N,)"]),
        ({"t": T[:0], "q": Q[:0], "tau": Q[:0]}, ["no samples"]),
        ({"t": T[:9], "q": Q[:9], "tau": Q[:9]}, ["9 samples"]),
        ({"q": Q.T}, ["q has the shape (2, 12)"]),
        ({"q": Q[:-1]}, ["q has the shape (11, 2)"]),
        ({"q": Q[:, :, None]}, ["q has the shape (12, 2, 1)"]),
        ({"q": Q[:, :0]}, ["q has the shape (12, 0)"]),
        ({"q": np.float64(1)}, ["q has the shape ()"]),
        ({"tau": Q[:, :1]}, ["of q: 2, of tau: 1"]),
        ({"qd": Q[:, :1]}, ["of q: 2, of qd: 1"]),
        ({"q": Q.astype(complex)}, ["q holds complex128"]),
        ({"q": Q > 0}, ["q holds bool"]),
        ({"tau": Q.astype(str)}, ["tau holds <U"]),
        ({"q": Q.astype(object)}, ["Python objects"]),
        ({"qd": np.where(Q[3, 1] == Q, np.inf, Q)}, ["column qd2", "sample 3", "0.03 s"]),
        ({"t": T[::-1]}, ["column t", "sample 1"]),
    ],
)
def test_a_spoiled_npz_archive_is_refused_with_its_place(tmp_path, changes, words):
    arrays = {"t": T, "q": Q, "tau": Q} | changes
    path = tmp_path / "log.npz"
    np.savez(path, **{key: array for key, array in arrays.items() if array is not None})
    refused(path, *words)


def test_a_pickle_in_an_npz_archive_is_never_run(tmp_path):
    ran = tmp_path / "ran"

    class Payload:
        def __reduce__(self):
            return Path.touch, (ran,)

    path = tmp_path / "log.npz"
    np.savez(path, t=T, q=np.array([Payload()] * 12, dtype=object), tau=Q)
    refused(path, "Python objects")
    assert not ran.exists()


# --- units ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["log.csv", "log.parquet", "log.npz"])
def test_random_damage_gives_a_log_or_one_line(tmp_path, name):
    path = tmp_path / name
    path.write_text(GOOD)
    if name == "log.npz":
        np.savez(path, t=T, q=Q, tau=Q)
    elif name == "log.parquet":
        parquet(path)
    whole = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    rng = np.random.default_rng(5)
    for _ in range(150):
        spoiled = whole.copy()
        spoiled[rng.integers(0, len(whole), size=3)] = rng.integers(0, 256, size=3)
        path.write_bytes(spoiled[: rng.integers(len(whole) // 2, 2 * len(whole))].tobytes())
        message = ""
        try:
            read_log(path)
        except LogError as error:
            message = str(error)
        assert "\n" not in message


def test_a_range_over_50_rad_is_taken_for_degrees():
    q = Q.copy()
    q[:, 1] = np.linspace(-25.1, 25.1, 12)
    with pytest.raises(LogError, match=r"column q2 spans 50\.2, over 50 rad.*degrees.*accepted"):
        make_log("wide", T, q, Q)
    make_log("narrow", T, q * 0.99, Q)


def test_limits_that_the_motion_leaves_are_named_and_not_the_unit_alone(tmp_path, command):
    """A joint that turns six times, in rad, with limits of one turn in its file."""
    robot, log = tmp_path / "robot.toml", tmp_path / "log.csv"
    limits = "[limits]\nposition = [[-6, 6]]\n"
    robot.write_text(f'[robot]\nname = "spins"\n[[joint]]\nname = "shoulder"\n{limits}')
    t = np.arange(200) * 0.01
    q, qd = 40 * np.sin(t) ** 2, 40 * np.sin(2 * t)
    np.savetxt(log, np.column_stack([t, q, qd, qd]), delimiter=",", header="t,q1,qd1,tau1",
               comments="")  # fmt: skip
    for more in ([], ["--unit", "q=rad,qd=rad/s"]):
        code, _, err = command("identify", robot, log, *more, "--into", tmp_path / "out")
        assert code == 2
        assert "wider limits" in err or "wider ones" in err
        assert "robot file" in err
    assert "shoulder (1)" in err


def test_speeds_far_beyond_their_limit_are_refused_until_an_option_says_their_unit(csv_of):
    robot = symgen.parse_robot(
        '[robot]\nname = "p"\n[[joint]]\nfriction = ["viscous"]\n[limits]\nvelocity = [3.0]\n'
    )
    degrees = csv_of(moving(q=DEG / 4, qd=DEG / 4))
    with pytest.raises(LogError, match=r"qd1 .* 3; accepted: .*--unit qd=deg/s.*--unit qd=rad/s"):
        symgen.identify(robot, degrees)
    for unit in ({"": "deg"}, {"qd": "rad/s"}):
        with pytest.raises(LogError, match=r"missing\.csv"):  # the next log: this one is read
            symgen.identify(robot, [degrees, "missing.csv"], reading=Reading(unit=unit))


@pytest.mark.parametrize("seed", range(4))
def test_a_log_of_a_second_is_refused_or_judged(seed):
    rng, t = np.random.default_rng(seed), np.arange(100) * 0.01
    w = rng.uniform(5, 30)
    tau = rng.normal(size=t.shape) + 3 * np.cos(2 * w * t)
    columns = (x[:, None] for x in (np.sin(w * t), w * np.cos(w * t), tau))
    try:
        symgen.identify("emps", [symgen.Log("short.csv", t, *columns)])
    except symgen.SymgenError as error:
        assert "short.csv" in str(error) or "too short" in str(error)
