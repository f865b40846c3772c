"""Read logs from MCAP files and ROS 2 bags with messages sensor_msgs/msg/JointState.

The library rosbags reads both, and bags in SQLite; mcap reads MCAP files that also have channels of
another kind, such as JSON: `pip install 'symgen[ros]'`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any, NamedTuple

import numpy as np

from symgen.data.columns import joints_of_file
from symgen.data.raw import TORQUES, FloatArray, Raw, Reading, Wanted, refuse
from symgen.errors import LogError

_TYPE = "sensor_msgs/msg/JointState"
_TYPES = (_TYPE, "sensor_msgs/JointState")
_FIELDS = {"q": "position", "qd": "velocity", "tau": "effort"}
#: Fields of a message.
FIELDS = tuple(_FIELDS.values())
_ACCEPTED = f"an MCAP file or a ROS 2 bag with messages {_TYPE}"
_SUFFIXES = (".mcap", ".db3")
_TABLES = (".csv", ".parquet", ".npz")  # a folder of them is no bag


class _Message(NamedTuple):
    """One message: times in ns, and field -> values (m,) of the joints `names`."""

    stamp: int
    received: int
    names: list[str]
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray

    @classmethod
    def of(cls, m: Any, received: int) -> _Message:
        """Convert a message of rosbags."""
        time = m.header.stamp
        stamp = int(time.sec) * 10**9 + int(time.nanosec)
        return cls(stamp, received, list(m.name), m.position, m.velocity, m.effort)


def is_bag(path: Path) -> bool:
    """Return whether a path is an MCAP file, a bag file, or a folder of them without tables."""
    if not path.is_dir():
        return path.suffix.lower() in _SUFFIXES
    only_bags = bool(_files(path)) and not _files(path, _TABLES)
    return only_bags or (path / "metadata.yaml").is_file()


def _files(folder: Path, suffixes: Sequence[str] = _SUFFIXES) -> list[Path]:
    files = sorted(folder.iterdir())
    return [file for file in files if file.suffix.lower() in suffixes]


def _whole(path: Path) -> Path:
    """Return the path, or the only file of a folder without metadata.yaml.

    Raises:
        LogError: there are several.
    """
    if not path.is_dir() or (path / "metadata.yaml").is_file():
        return path
    file, *others = _files(path)
    if others:
        what = f"has no metadata.yaml for {file.name} to {others[-1].name}"
        refuse(what, f"ros2 bag reindex {path}, or one of the files")
    return file


def read_bag(path: Path, wanted: Wanted) -> Raw:
    """Read the joint states of an MCAP file or a ROS 2 bag.

    t is the stamp in the header, in s from the first message. Messages are sorted by stamp;
    repeated messages and messages of other joints are dropped. The notes of the log say so.

    Args:
        path: the file or folder.
        wanted: topic, names of the joints, and meaning of the fields ({"i": "effort"}).

    Raises:
        LogError: rosbags is missing, the bag is damaged, or its messages do not
            contain the joints of the robot.
    """
    fields = _fields(wanted.reading, wanted.currents)
    if find_spec("rosbags") is None:
        refuse("rosbags is not installed", "after pip install 'symgen[ros]'")
    whole = _whole(path)
    with _opened(whole, wanted.reading.topic) as (announced, messages):
        messages_read = list(messages)
    if not messages_read:
        refuse("has no message of joint states", _ACCEPTED)
    joints = joints_of_file(wanted, _joint_names(messages_read))
    complete = [m for m in messages_read if set(joints) <= set(m.names)]
    if not complete:
        refuse("no message has all joints of the robot", "all joints in one message")
    groups: dict[frozenset[str], list[_Message]] = {}  # by the fields that they have
    for m in complete:
        present = frozenset(f for f in fields.values() if len(getattr(m, f)))
        groups.setdefault(present, []).append(m)
    needed = {f for role, f in fields.items() if role != "qd"}
    content, used = max(groups.items(), key=lambda pair: (pair[0] >= needed, len(pair[1])))
    unstamped = all(m.stamp == 0 for m in used)
    if unstamped:
        used = [m._replace(stamp=m.received) for m in used]
    late = sum(b.stamp < a.stamp for a, b in pairwise(used))
    used.sort(key=lambda m: m.stamp)
    stamps = np.array([m.stamp for m in used], dtype=np.int64)
    arrays: dict[str, FloatArray] = {}
    for role, field in fields.items():
        if field in content:
            values = np.array([_row(m, field, joints) for m in used])
            # ros2_control writes NaN for quantities without a sensor.
            if not np.isnan(values).all():
                arrays[role] = values
    again = np.append(False, np.diff(stamps) == 0)  # a repetition of the previous message
    for k in np.flatnonzero(again):
        if not all(np.array_equal(x[k], x[k - 1], equal_nan=True) for x in arrays.values()):
            what = f"two messages of {stamps[k] * 1e-9:.6f} s differ"
            refuse(what, "one message a stamp; --topic, or a bag with one publisher")
    if "q" not in arrays:
        refuse("the messages have no position", "q in every message")
    if not arrays.keys() & TORQUES:
        refuse(f"the messages have no {fields.get('tau', 'effort')}", "torques, as effort")
    read, twice = len(messages_read), int(again.sum())
    other = read - len(used)
    notes = (
        (announced - read, f"{read} of the {announced} messages can be read"),
        (other, f"{other} messages of other joints, or with other fields, left out"),
        (whole != path, f"no metadata.yaml; {whole.name} is read"),
        (unstamped, "the stamps in the headers are 0; t is the time when a message was received"),
        (late, f"{late} messages came out of order and were sorted by stamp"),
        (twice, f"{twice} repeated messages left out"),
    )
    ignored = tuple(name for name in _joint_names(used) if name not in joints)
    lines = tuple(f"{path.name}: {note}" for count, note in notes if count > 0)
    arrays = {"t": (stamps - stamps[0]) * 1e-9, **arrays}
    kept = {role: x[~again] for role, x in arrays.items()}
    return Raw(kept, ignored, lines)


def _joint_names(messages: Sequence[_Message]) -> list[str]:
    """Return the names of all joints of some messages, in order."""
    return [*dict.fromkeys(name for m in messages for name in m.names)]


def _fields(reading: Reading, currents: bool) -> dict[str, str]:
    """Return array of the log -> field of the message."""
    for ours, theirs in reading.pairs.items():
        if ours not in ("q", "qd", *TORQUES) or theirs not in FIELDS:
            what = f"--columns {ours}={theirs}: a bag has fields for all joints"
            refuse(what, f"q, qd, tau, i or u = {', '.join(FIELDS)}; --joints for the joints")
    if "i" in reading.pairs and not currents:
        refuse("motor currents (--columns i)", "torque_constant in [drive] of the robot file")
    taken = reading.pairs.values()
    usual = {role: field for role, field in _FIELDS.items() if field not in taken}
    return usual | dict(reading.pairs)


@contextmanager
def _opened(path: Path, topic: str) -> Iterator[tuple[int, Iterator[_Message]]]:
    """Open a bag at a topic, by default the only one with joint states.

    Yields:
        The number of messages that the bag announces, and the messages.
    """
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    # JointState has the same definition in every ROS 2, so any store works.
    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        with ExitStack() as stack:
            bag: Any
            try:
                bag = stack.enter_context(Reader(path))
            except Exception:  # it has channels that are none of ROS 2
                if path.suffix != ".mcap" or find_spec("mcap") is None:
                    raise
                bag = _by_mcap(stack.enter_context(path.open("rb")))
            states = [c for c in bag.connections if c.msgtype in _TYPES]
            topics = sorted({c.topic for c in states})
            chosen = _topic(topic, topics, sorted({c.topic for c in bag.connections}))
            states = [c for c in states if c.topic == chosen]
            for c in states:
                encoding = getattr(c.ext, "serialization_format", "")
                if encoding != "cdr":
                    refuse(f"the messages are encoded as {encoding!r}", "cdr, as in ROS 2")
            announced = sum(c.msgcount for c in states)
            yield (
                announced,
                (
                    _Message.of(store.deserialize_cdr(data, _TYPE), received)
                    for _, received, data in bag.messages(states)
                ),
            )
    except LogError:
        raise
    except Exception as error:  # a damaged bag can raise any exception, MemoryError too
        what = str(error)[:200] or type(error).__name__
        refuse(f"cannot be read: {what}", _ACCEPTED)


def _by_mcap(file: IO[bytes]) -> SimpleNamespace:
    """Open an MCAP file as rosbags does; channels that are not of ROS 2 are left out."""
    from mcap.reader import make_reader

    reader = make_reader(file, validate_crcs=True)
    summary: Any = reader.get_summary()
    connections = [
        SimpleNamespace(
            topic=channel.topic,
            msgtype=summary.schemas[channel.schema_id].name,
            msgcount=summary.statistics.channel_message_counts.get(key, 0),
            ext=SimpleNamespace(serialization_format="cdr"),
        )
        for key, channel in summary.channels.items()
        if channel.message_encoding == "cdr"
    ]

    def messages(states: Sequence[SimpleNamespace]) -> Iterator[tuple[Any, int, bytes]]:
        for _, channel, message in reader.iter_messages({c.topic for c in states}):
            yield channel, message.log_time, message.data

    return SimpleNamespace(connections=connections, messages=messages)


def _topic(topic: str, topics: list[str], every: list[str]) -> str:
    """Return the topic to read."""
    listed = ", ".join(topics)
    if not topics:
        found = ", ".join(every[:12]) or "none"
        refuse(f"no topic has messages {_TYPE}; topics: {found}", _ACCEPTED)
    if topic and topic not in topics:
        refuse(f"--topic {topic}: no joint states there", listed)
    if not topic and len(topics) > 1:
        refuse(f"{len(topics)} topics have joint states", f"--topic, one of {listed}")
    return topic or topics[0]


def _row(m: _Message, field: str, joints: Sequence[str]) -> list[float]:
    """Return one field for the robot's joints, (n,)."""
    values: FloatArray = getattr(m, field)
    when = f"the message of {m.stamp * 1e-9:.6f} s"
    if len({*m.names}) < len(m.names):
        refuse(f"{when}: a joint is named twice", "every joint once in a message")
    if len(values) != len(m.names):
        what = f"{when}: {len(values)} values of {field} for {len(m.names)} names"
        refuse(what, "one value a name, or none")
    of_joint = dict(zip(m.names, values, strict=True))
    return [of_joint[joint] for joint in joints]
