"""The Staubli TX40 with its wrist coupling, train and test joined, beside published values.

The published friction of joints 5 and 6 is that of a model in which the coupling acts on the speed
of the other joint alone (tau5 = FV5 qd5 + fvm6 qd6, tau6 = FV6 qd6 + fvm6 qd5): there FV5 and FV6
hold fvm6 too.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from support import data_folder

import symgen
from symgen.data.log import Log

FV = (8.05, 5.53, 1.97, 1.11, 1.86, 0.65)
FS = (7.14, 8.26, 6.34, 2.48, 3.03)
COUPLING = {"IAM6": 0.00964, "FVM6": 0.616, "FSM6": 1.95}

pytestmark = pytest.mark.slow


def _joined() -> tuple[symgen.Robot, Log]:
    import numpy as np

    folder = data_folder() / "tx40"
    text = (folder / "robot.toml").read_text() + "\n[[coupling]]\njoints = [5, 6]\n"
    logs = [symgen.read_log(folder / f"{name}.csv") for name in ("train", "test")]
    t, q, tau = (np.concatenate([getattr(log, key) for log in logs]) for key in ("t", "q", "tau"))
    kept = (t >= 0.3) & (t <= 7.4) & np.append(True, np.diff(t) > 0)
    return symgen.parse_robot(text), symgen.make_log("joined", t[kept], q[kept], tau[kept])


@pytest.mark.parametrize(
    ("model", "method", "options"),
    [
        ("momentum", "wls", {"window": 0.05}),
        pytest.param(
            "torque",
            "wls",
            {},
            marks=pytest.mark.xfail(
                strict=True, reason="FV3 is 2.3 % below the published one at the chosen cutoff"
            ),
        ),
    ],
)
def test_friction_and_coupling_are_the_published_ones(
    model: str, method: str, options: dict[str, float]
) -> None:
    robot, log = _joined()
    every = symgen.make_log("every second sample", log.t[::2], log.q[::2], log.tau[::2])
    # All of it is trained on: the validation log is there for the interface alone.
    estimate = symgen.identify(robot, log, validation=every, model=model, method=method, **options)
    value = {p.name: p.value for p in estimate.parameters}
    value["FV5"] += value["FVM6"]
    value["FV6"] += value["FVM6"]
    apart = {
        name: 100 * (value[name] / published - 1)
        for name, published in (
            *((f"FV{j}", v) for j, v in enumerate(FV, 1)),
            *((f"FS{j}", v) for j, v in enumerate(FS, 1)),
            *COUPLING.items(),
        )
    }
    print(model, method, {name: f"{v:+.1f} %" for name, v in apart.items()})
    assert all(abs(v) < 2 for name, v in apart.items() if name.startswith("FV") and len(name) == 3)
    assert all(abs(v) < 5 for name, v in apart.items() if name.startswith("FS") and len(name) == 3)
    assert all(abs(apart[name]) < 6 for name in COUPLING)


def test_friction_that_is_not_declared_is_no_torque_in_another_unit() -> None:
    """Other joints share parameters with joint 4, whose own torque that unit explains worse."""
    folder = data_folder() / "tx40"
    robot = symgen.read_robot(folder / "robot.toml")
    joints = list(robot.joints)
    joints[3] = replace(joints[3], friction=tuple(k for k in joints[3].friction if k != "coulomb"))
    estimate = symgen.identify(
        replace(robot, joints=tuple(joints)), folder / "train.csv", validation=folder / "test.csv"
    )
    assert "fault" not in {reason.kind for reason in estimate.reasons}
