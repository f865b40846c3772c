"""`diagnose` names effects that begin within a log, and torques of a command.

The log is the sound one of tests/logs; the torques that are added are Pinocchio's, or written here.
The validation log does not have what begins in the training log.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oracles.hidden import machines
from stored_logs import Channels, made, stored

import symgen

START = 7.3  # s


def arm(*states: np.ndarray, load: float = 0.0) -> np.ndarray:
    """Rigid-body torque (N, 3) of the arm, with a load 0.2 m out on its last link, kg."""
    pytest.importorskip("pinocchio")
    from oracles.hidden.engines import PinocchioEngine

    machine = machines.MACHINES["arm3r"]
    links = machine.links.copy()
    links[-1] += np.array([0, 0, 0, 0.04, 0, 0.04, 0.2, 0, 0, 1]) * load
    bare = replace(machine, links=links, rotor=np.zeros(machine.n))
    return np.asarray(PinocchioEngine(bare).torque(*states))


def motion(log: Channels) -> list[np.ndarray]:
    """q, qd, qdd (N, 3) of a log, below 10 Hz."""
    from scipy.signal import butter, sosfiltfilt

    step = log["t"][1]
    q = sosfiltfilt(butter(4, 10.0, fs=1 / step, output="sos"), log["q"], axis=0)
    qd = np.gradient(q, step, axis=0)
    return [q, qd, np.gradient(qd, step, axis=0)]


def carries(log: Channels) -> np.ndarray:
    states = motion(log)
    return arm(*states, load=0.8) - arm(*states)


def drags(log: Channels) -> np.ndarray:
    return np.sign(motion(log)[1]) * [0, 3.0, 0]


def pulls(log: Channels) -> np.ndarray:
    return np.ones_like(log["q"]) * [0, 0, 1.5]


@pytest.mark.parametrize(
    ("torque", "name", "joints", "parameter", "value"),
    [
        pytest.param(carries, "payload", (3,), "ML", 0.8, marks=pytest.mark.slow),
        (drags, "coulomb_friction", (2,), "FS2", 3.0),
        (pulls, "torque_offset", (3,), "OF3", 1.5),
    ],
)
def test_what_begins_is_named_with_its_time(torque, name, joints, parameter, value) -> None:
    log = stored("sound")
    later = (log.train["t"] >= START)[:, None]
    train = log.train | {"tau": log.train["tau"] + later * torque(log.train)}
    logs = made("train", train), made("test", log.test)
    found = symgen.diagnose(log.robot, logs[0], validation=logs[1])
    assert [(e.name, e.joints) for e in found.effects] == [(name, joints)]
    values = {p.name: p.value for p in found.effects[0].parameters}
    assert values[f"start{joints[0]}"] == pytest.approx(START, abs=0.05)
    assert values[parameter] == pytest.approx(value, rel=0.1)
    assert found.after == found.before
    assert found.corrected is not None
    j = joints[0] - 1
    assert found.corrected.per_joint[j] < 0.5 * found.gaps.before.per_joint[j]
    assert symgen.robot_toml(found.extended) == symgen.robot_toml(log.robot)


@pytest.mark.slow
def test_torques_without_a_share_of_the_dynamics_are_a_command() -> None:
    log = stored("sound")

    def commanded(log: Channels) -> Channels:
        q, qd, qdd = motion(log)
        moves = arm(q, qd, qdd) - arm(q, 0 * q, 0 * q)
        return log | {"tau": log["tau"] - 0.6 * moves}

    logs = made("train", commanded(log.train)), made("test", commanded(log.test))
    found = symgen.diagnose(log.robot, logs[0], validation=logs[1])
    assert [(e.name, e.joints) for e in found.effects] == [("commanded_torque", ())]
    assert found.verdict == "bad-measurement"
