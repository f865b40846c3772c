"""Bags and MCAP files hold the same log as a table, whatever recorded them."""

import numpy as np
import pytest
from oracles.bags import State, write_bag, write_mcap
from support import data_folder

from symgen.data.log import read_log
from symgen.data.raw import Reading
from symgen.errors import LogError

pytest.importorskip("rosbags")
pytest.importorskip("mcap_ros2")

N, START = 40, 1_700_000_000 * 10**9 + 123_456_789
T = np.arange(N) * 0.01
Q = np.column_stack([np.sin(3 * T), np.cos(2 * T)])
QD = np.column_stack([3 * np.cos(3 * T), -2 * np.sin(2 * T)])
TAU = np.column_stack([5 * np.cos(T), T - 1.0])
NAMES = ("shoulder", "elbow")
BY_NAME = Reading(joints=NAMES)


def states(names=NAMES, order=(0, 1), qd=QD, tau=TAU):
    """The log as messages, the joints in another order in each second one."""
    out = []
    for k in range(N):
        at = list(order) if k % 2 else list(order)[::-1]
        rows = [[] if a is None else a[k, at] for a in (Q, qd, tau)]
        out.append(State(START + k * 10**7, [names[j] for j in at], *rows))
    return out


WRITERS = {
    "file.mcap": lambda path, topics: write_mcap(path, topics),
    "bag of mcap": lambda path, topics: write_bag(path, topics, "mcap"),
    "bag of sqlite3": lambda path, topics: write_bag(path, topics, "sqlite3"),
}


@pytest.fixture(params=WRITERS)
def write(request, tmp_path):
    def to(messages, **others):
        return WRITERS[request.param](
            tmp_path / request.param, {"/joint_states": messages, **others}
        )

    return to


@pytest.fixture
def written(tmp_path):
    def to(messages, **others):
        return write_mcap(tmp_path / "log.mcap", {"/joint_states": messages, **others})

    return to


def assert_holds(log, qd=QD):
    np.testing.assert_allclose(log.t, T, atol=1e-12)
    np.testing.assert_array_equal(log.q, Q)
    np.testing.assert_array_equal(log.tau, TAU)
    assert (log.qd is None) == (qd is None)
    if qd is not None:
        np.testing.assert_array_equal(log.qd, qd)


def test_every_recorder_gives_the_log_to_the_last_bit(write):
    path = write(states())
    log = read_log(path, 2, reading=BY_NAME)
    assert log.name == path.name
    assert_holds(log)
    assert log.notes == ()


def test_the_names_of_the_robot_are_used_where_the_messages_have_them(written):
    path = written(states())
    assert_holds(read_log(path, names=NAMES))
    with pytest.raises(LogError, match=r"'wrist' is not among .*elbow.*--joints"):
        read_log(path, names=("shoulder", "wrist"))
    with pytest.raises(LogError, match=r"not among elbow, shoulder.*--joints"):
        read_log(path)


@pytest.mark.parametrize("encoding", ["jsonschema", "protobuf", ""])
def test_channels_of_another_kind_are_left_out(tmp_path, encoding):
    path = tmp_path / "log.mcap"
    write_mcap(path, {"/joint_states": states()}, beside=encoding)
    assert_holds(read_log(path, 2, reading=BY_NAME))
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(LogError, match="cannot be read"):
        read_log(path, 2, reading=BY_NAME)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_without_metadata_is_its_file(tmp_path, storage):
    folder = write_bag(tmp_path / "run", {"/joint_states": states()}, storage)
    (folder / "metadata.yaml").unlink()
    log = read_log(folder, 2, reading=BY_NAME)
    assert_holds(log)
    assert "no metadata.yaml" in log.notes[0]
    (file,) = folder.iterdir()
    (folder / f"a{file.name}").write_bytes(file.read_bytes())
    with pytest.raises(LogError, match=f"{file.name}; accepted: ros2 bag reindex"):
        read_log(folder, 2, reading=BY_NAME)


def test_missing_speeds_are_none_and_so_are_those_that_are_nan_throughout(written):
    assert_holds(read_log(written(states(qd=None)), reading=BY_NAME), None)
    assert_holds(read_log(written(states(qd=np.full_like(QD, np.nan))), reading=BY_NAME), None)


def test_efforts_of_servos_are_their_duty(written) -> None:
    reading = Reading(joints=NAMES, columns={"u": "effort"}, unit={"u": "0.1%"})
    log = read_log(written(states()), reading=reading)
    np.testing.assert_allclose(log.duty, 1e-3 * TAU, rtol=1e-15, atol=0)
    assert log.drive_unit == "duty"


def test_units_of_efforts_are_converted(written) -> None:
    log = read_log(written(states()), reading=Reading(joints=NAMES, unit={"tau": "mNm"}))
    np.testing.assert_allclose(log.tau, 1e-3 * TAU, rtol=1e-15, atol=0)
    with pytest.raises(LogError, match="--unit of tau, i or u"):
        read_log(written(states()), reading=Reading(joints=NAMES, unit={"": "deg"}))


@pytest.mark.parametrize("qd", [QD, np.full_like(QD, np.nan)], ids=["speeds", "speeds of NaN"])
def test_messages_out_of_order_are_sorted_and_repeated_ones_left_out(written, qd):
    messages = states(qd=qd)
    messages[7], messages[8] = messages[8], messages[7]
    messages.insert(20, messages[19])
    log = read_log(written(messages), reading=BY_NAME)
    assert_holds(log, QD if qd is QD else None)
    assert "1 messages came out of order" in log.notes[0]
    assert "1 repeated messages" in log.notes[1]


def test_messages_and_joints_of_others_are_left_out_and_said(written):
    gripper = State(START + 5, ["finger"], [0.1], [0.0], [0.0])
    messages = [gripper, *states(), gripper]
    log = read_log(written(messages), reading=BY_NAME)
    assert_holds(log)
    assert "2 messages of other joints" in log.notes[0]
    more = [State(s.stamp, [*s.name, "finger"], *([*row, 0.0] for row in s[2:])) for s in states()]
    log = read_log(written(more), reading=BY_NAME)
    assert_holds(log)
    assert log.ignored == ("finger",)


def test_of_several_topics_one_is_asked_for(write):
    path = write(states(), **{"/other": states(tau=2 * TAU)})
    with pytest.raises(LogError, match=r"2 topics.*--topic, one of /joint_states, /other"):
        read_log(path, reading=BY_NAME)
    with pytest.raises(LogError, match=r"--topic /x.*/joint_states, /other"):
        read_log(path, reading=Reading(joints=NAMES, topic="/x"))
    log = read_log(path, reading=Reading(joints=NAMES, topic="/other"))
    np.testing.assert_array_equal(log.tau, 2 * TAU)


def test_a_real_log_is_the_same_as_table_and_as_bag(tmp_path):
    table = read_log(data_folder() / "ur10e" / "test.csv")
    names = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint",
             "wrist_2_joint", "wrist_3_joint")  # fmt: skip
    rows = zip(table.t, table.q, table.qd, table.tau, strict=True)
    messages = [State(round(t * 1e9), names, *values) for t, *values in rows]
    path = write_bag(tmp_path / "ur10e", {"/joint_states": messages}, "sqlite3")
    log = read_log(path, 6, names=names)
    np.testing.assert_allclose(log.t, table.t, atol=1e-9)
    for one, other in ((log.q, table.q), (log.qd, table.qd), (log.tau, table.tau)):
        np.testing.assert_array_equal(one, other)


def spoiled(k, **changed):
    messages = states()
    messages[k] = messages[k]._replace(**changed)
    return messages


BAD = {
    "unknown joint": (states(names=("a", "b")), ["joint 'shoulder'", "a"]),
    "no effort": (states(tau=None), ["no effort"]),
    "effort of NaN": (states(tau=np.full_like(TAU, np.nan)), ["no effort"]),
    "a joint in no message": (states(names=("shoulder", "b")), ["joint 'elbow'"]),
    "no position": ([s._replace(position=[]) for s in states()], ["no position"]),
    "values and names": (spoiled(5, effort=[1.0]), ["1 values of effort for 2 names"]),
    "twice the joint": (spoiled(5, name=["elbow", "elbow"]), ["named twice"]),
    "two of one time": ([*states(), states(tau=TAU + 1)[3]], ["two messages of", "differ"]),
    "infinite": (spoiled(5, position=[np.inf, 1]), ["column q1, sample 5", "inf"]),
    "too few": (states()[:9], ["9 samples"]),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_messages_that_are_no_log_are_refused_with_their_place(written, case):
    messages, words = BAD[case]
    with pytest.raises(LogError) as caught:
        read_log(written(messages), reading=BY_NAME)
    for word in (*words, "accepted: "):
        assert word in str(caught.value), str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7, 0.99])
def test_a_bag_that_is_cut_off_is_one_line(write, share):
    path = write(states())
    for file in [path] if path.is_file() else sorted(path.iterdir()):
        if file.name != "metadata.yaml":
            whole = file.read_bytes()
            file.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(LogError) as caught:
        read_log(path, reading=BY_NAME)
    assert "accepted: " in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("seed", range(8))
def test_damaged_bytes_give_the_log_or_one_line(write, seed):
    rng = np.random.default_rng(seed)
    path = write(states())
    file = path if path.is_file() else sorted(path.iterdir())[seed % 2]
    data = bytearray(file.read_bytes())
    for at in rng.integers(0, len(data), 20):
        data[at] = int(rng.integers(256))
    file.write_bytes(data)
    try:
        log = read_log(path, reading=BY_NAME)
    except LogError as error:
        assert "\n" not in str(error)
    else:
        assert np.isfinite(log.q).all()


def test_messages_of_a_second_publisher_are_left_out_and_counted(written):
    """One lacks speeds and efforts, at the same stamps; the other has the joints of a gripper."""
    others = [
        State(s.stamp, NAMES, [0.0, 0.0], [], []) for s in states()[::4]
    ] + [State(s.stamp + 1, ["finger"], [0.1], [0.0], [0.0]) for s in states()[::5]]  # fmt: skip
    log = read_log(written([*others, *states()]), reading=BY_NAME)
    assert_holds(log)
    assert any("18 messages" in note for note in log.notes)
