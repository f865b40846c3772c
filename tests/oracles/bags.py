"""Bags and MCAP files of joint states, by writers that share no code with what reads them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

JOINT_STATE = "sensor_msgs/msg/JointState"
#: The definition in the text that recorders put into a file.
DEFINITION = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


class State(NamedTuple):
    """One message: stamp in ns, and what stands in its fields."""

    stamp: int
    name: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]
    effort: Sequence[float]


def write_mcap(path: Path, topics: dict[str, Iterable[State]], beside: str | None = None) -> Path:
    """Write an MCAP file by the writer of the format's authors (mcap-ros2-support).

    `beside` is the encoding of the schema of one more channel.
    """
    from mcap_ros2.writer import Writer

    with path.open("wb") as file, Writer(file) as writer:
        schema = writer.register_msgdef(JOINT_STATE, DEFINITION)
        if beside is not None:
            raw = writer._writer
            other = raw.register_schema("other", beside, b"\xff\x00") if beside else 0
            channel = raw.register_channel("/other", "json", other)
            raw.add_message(channel, log_time=0, data=b"{}", publish_time=0)
        for topic, states in topics.items():
            for at, s in enumerate(states):
                sec, nanosec = divmod(s.stamp, 10**9)
                message: dict[str, Any] = {
                    "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""},
                    "name": list(s.name),
                    "position": list(s.position),
                    "velocity": list(s.velocity),
                    "effort": list(s.effort),
                }
                writer.write_message(topic, schema, message, log_time=at, publish_time=at)
    return path


def write_bag(folder: Path, topics: dict[str, Iterable[State]], storage: str) -> Path:
    """Write a ROS 2 bag, "sqlite3" or "mcap", by the writer of rosbags."""
    import numpy as np
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    state, header, time = (
        store.types[name]
        for name in (JOINT_STATE, "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    plugin = {"sqlite3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}[storage]
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        for topic, states in topics.items():
            connection = writer.add_connection(topic, JOINT_STATE, typestore=store)
            for at, s in enumerate(states):
                message = state(
                    header(time(*divmod(s.stamp, 10**9)), ""),
                    list(s.name),
                    *(np.array(x, dtype=float) for x in (s.position, s.velocity, s.effort)),
                )
                writer.write(connection, at + 1, store.serialize_cdr(message, JOINT_STATE))
    return folder
