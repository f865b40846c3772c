"""The sanity gate: faulty channels are named with how much is wrong, sound logs pass in silence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")

from oracles.hidden.cases import Spec
from oracles.hidden.machines import MACHINES
from support import sampled

from symgen import parse_robot
from symgen.data.log import Log, make_log, read_log
from symgen.diagnosis.diagnosis import Diagnosis
from symgen.diagnosis.workflow import diagnose
from symgen.errors import IdentificationError

ROBOTS = tuple(MACHINES)


def spec(robot: str, effect: str | None, size: str = "moderate") -> Spec:
    return Spec(robot, effect, size, seed=3000 + ROBOTS.index(robot))


def log_of(s: Spec, kind: str = "train", **changed: np.ndarray) -> Log:
    columns = {**getattr(s.run(), kind), **changed}
    return make_log(f"{kind}.csv", columns["t"], columns["q"], columns["tau"], columns["qd"])


def checked(s: Spec, log: Log, **more: Log) -> Diagnosis:
    """A diagnosis that looks at the measuring chain, and for next to no physics behind it."""
    return diagnose(parse_robot(s.run().robot_toml), log, effects=["cable_torque"], **more)


def told(d: Diagnosis) -> list[tuple[str, tuple[int, ...]]]:
    """What is wrong and on which joints, by its name."""
    chain = {"units", "sign", "stuck", "step", "exchange", "ratio", "time"}
    return [(r.name, r.joints) for r in d.rejected if r.name in chain]


@pytest.mark.parametrize("robot", sampled(ROBOTS, 1, always=["planar2r"]))
def test_sound_logs_pass(robot: str) -> None:
    s = spec(robot, None)
    d = checked(s, log_of(s))
    assert d.verdict == "consistent"
    assert (told(d), d.repairs) == ([], ())


@pytest.mark.parametrize("robot", sampled(ROBOTS, 1, always=["planar2r"]))
def test_errors_of_a_velocity_sensor_are_measured_and_mended(robot: str) -> None:
    s = spec(robot, "velocity_sensor_error")
    case = s.run()
    ((_, joints, true),) = case.truth
    d = diagnose(parse_robot(case.robot_toml), log_of(s), validation=log_of(s, "validation"))
    (mended,) = (r for r in d.repairs if r.log == "train.csv" and r.channel.startswith("qd"))
    assert mended.channel == f"qd{joints[0]}"
    expected = {"GV": true["gain"] - 1, "LV": true["lag"], "OV": true["offset"]}
    found = {name: value for name, value, _ in mended.values}
    for name, tolerance in (("GV", 1e-3), ("LV", 1e-4), ("OV", 1e-3)):
        assert found.get(name, 0.0) == pytest.approx(expected[name], abs=tolerance)
    assert all(0 < std < 1e-3 for *_, std in mended.values)
    # It is named where it matters: where mending it closes a part of the gap.
    if d.verdict == "consistent":
        assert d.effects == ()
    else:
        assert d.verdict == "bad-measurement"
        assert [(e.name, e.joints) for e in d.effects] == [("velocity_sensor_error", joints)]
        assert d.effects[0].gap_reduction > 0.1
    assert d.after.total <= d.before.total
    assert d.after.total < 0.005


@pytest.mark.parametrize("robot", sampled(ROBOTS, 0, always=["planar2r"]))
def test_saturation_is_measured(robot: str) -> None:
    s = spec(robot, "saturation")
    case = s.run()
    ((_, joints, true),) = case.truth
    d = diagnose(parse_robot(case.robot_toml), log_of(s), validation=log_of(s, "validation"))
    assert d.verdict == "bad-measurement"
    assert [(e.name, e.joints) for e in d.effects] == [("saturation", joints)]
    (limit,) = d.effects[0].parameters
    assert limit.value == pytest.approx(true["limit"], rel=0.01)
    assert limit.std < 0.01 * limit.value
    assert d.after.total < d.before.total
    # What is left is the noise that the simulator put in.
    assert d.after.total < 1.2 * np.sqrt(np.mean(case.floor**2))


def _swap(x: np.ndarray, j: int, k: int) -> np.ndarray:
    order = np.arange(x.shape[1])
    order[[j, k]] = k, j
    return x[:, order]


def _column(x: np.ndarray, j: int, values: np.ndarray) -> np.ndarray:
    out = x.copy()
    out[:, j] = values
    return out


def _late(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A channel that is held from 40 % to 60 % of the log."""
    return np.where((t > 0.4 * t[-1]) & (t < 0.6 * t[-1]), x[np.searchsorted(t, 0.4 * t[-1])], x)


#: What is wrong, and the repair that undoes it: the search goes on behind it.
MENDED = {
    "held torque": ("tau", "tau2", "masked", lambda t, x: _column(x, 1, _late(t, x[:, 1]))),
    "speed of other sign": ("qd", "qd2", "replaced by dq/dt", lambda _, x: _column(x, 1, -x[:, 1])),
    "speed in turns": ("qd", "qd2", "rescaled", lambda _, x: _column(x, 1, x[:, 1] * 30 / np.pi)),
    "speed steps": ("qd", "qd2", "moved", lambda t, x: _column(x, 1, x[:, 1] + 0.3 * (t > 5))),
}


@pytest.mark.parametrize("what", sampled(MENDED, 2))
def test_a_wrong_channel_is_mended(what: str) -> None:
    s = spec("arm3r", None)
    key, channel, done, change = MENDED[what]
    log = s.run().train
    d = checked(
        s, log_of(s, **{key: change(log["t"], log[key])}), validation=log_of(s, "validation")
    )
    assert [r.channel for r in d.repairs] == [channel]
    assert d.repairs[0].done.startswith(done)
    assert d.after.total < 0.004
    assert d.verdict == ("bad-measurement" if d.effects else "consistent")


#: What is wrong, what it is called, and the joints.
RECORDED_AGAIN = {
    "dead torque": ("tau", "stuck", (2,), lambda t, x: _column(x, 1, 0 * t + 1.0)),
    "torque of other sign": ("tau", "sign", (2,), lambda _, x: _column(x, 1, -x[:, 1])),
    "position steps": ("q", "step", (2,), lambda t, x: _column(x, 1, x[:, 1] + 0.2 * (t > 5))),
    "time reversed": ("t", "time", (), None),
}


@pytest.mark.parametrize("what", sampled(RECORDED_AGAIN, 2))
def test_a_wrong_channel_is_named(what: str) -> None:
    s = spec("arm3r", None)
    key, name, joints, change = RECORDED_AGAIN[what]
    log = s.run().train
    if change is None:
        changed = {"q": log["q"][::-1], "qd": -log["qd"][::-1], "tau": log["tau"][::-1]}
    else:
        changed = {key: change(log["t"], log[key])}
    d = checked(s, log_of(s, **changed), validation=log_of(s, "validation"))
    assert (d.verdict, d.effects) == ("bad-measurement", ())
    # A joint without any torque leaves nothing to identify; the others are corrected.
    assert d.after == d.before if name == "stuck" else d.after.total < 0.004
    assert (name, joints) in told(d)
    assert any("train.csv" in line or key in line for line in d.advice)


def test_torques_in_each_others_channel_are_exchanged() -> None:
    s = spec("arm3r", None)
    wrong = {
        kind: log_of(s, kind, tau=_swap(getattr(s.run(), kind)["tau"], 0, 1))
        for kind in ("train", "validation")
    }
    d = checked(s, wrong["train"], validation=wrong["validation"])
    assert d.verdict == "bad-measurement"
    assert d.after.total < 0.004
    assert "tau1 and tau2 are exchanged" in d.advice


def test_all_torques_of_other_sign_are_named() -> None:
    s = spec("arm3r", None)
    d = checked(s, log_of(s, tau=-s.run().train["tau"]))
    assert d.verdict == "bad-measurement"
    assert told(d) == [("sign", (1,)), ("sign", (2,)), ("sign", (3,))]


def test_exchanged_speeds_are_replaced_and_named() -> None:
    s = spec("arm3r", None)
    log = s.run().train
    d = diagnose(parse_robot(s.run().robot_toml), log_of(s, qd=_swap(log["qd"], 0, 1)))
    assert d.verdict == "bad-measurement"
    assert {(e.name, e.joints) for e in d.effects} == {
        ("velocity_sensor_error", (1,)),
        ("velocity_sensor_error", (2,)),
    }
    assert {r.channel for r in d.repairs} == {"qd1", "qd2"}
    assert d.after.total < 0.3 * d.before.total


def test_what_cannot_be_corrected_leaves_the_gap_as_it_is() -> None:
    s = spec("arm3r", None)
    log = s.run().train
    robot, none = parse_robot(s.run().robot_toml), 0 * log["t"]
    d = diagnose(robot, log_of(s, tau=_column(log["tau"], 1, none)))
    assert (d.verdict, d.effects, d.after) == ("bad-measurement", (), d.before)
    assert [r.joints for r in d.rejected] == [(2,)]
    with pytest.raises(IdentificationError, match=r"^q2 of train.csv stays"):
        diagnose(robot, log_of(s, q=_column(log["q"], 1, none)))


def test_a_log_with_repairs_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    s = spec("planar2r", None)
    tau = s.run().train["tau"]
    limit = [1.0, 0.8] * np.abs(tau).max(axis=0)
    path, columns = tmp_path / "train.npz", dict(s.run().train)
    np.savez(path, **{**columns, "tau": np.clip(tau, -limit, limit)})
    read = []

    def counted(source: Path, **options: Any) -> Log:
        read.append(source)
        return read_log(source, **options)

    monkeypatch.setattr("symgen.estimation.logs.read_log", counted)
    d = diagnose(parse_robot(s.run().robot_toml), path, effects=["cable_torque"])
    assert {r.kind for r in d.repairs} == {"saturated"}
    assert d.mended
    assert read == [path]


def test_a_hard_stop_is_no_step_of_a_sensor() -> None:
    s = spec("planar2r", None)
    log = s.run().train
    t, q, qd = (log[key][log["t"] < 6] for key in ("t", "q", "qd"))
    at = int(np.argmax(np.abs(qd[:, 0])))
    still = t >= t[at]
    q = _column(q, 0, np.where(still, q[at, 0], q[:, 0]))
    stopped = _column(qd, 0, np.where(still, 0.0, qd[:, 0]))
    tau = log["tau"][: len(t)]
    d = checked(s, make_log("train.csv", t, q, tau, stopped))
    assert not any("qd1 of train.csv jumps" in line for line in d.advice)


def test_a_torque_that_steps_in_the_training_log_is_levelled_and_the_search_goes_on() -> None:
    s = spec("arm3r", None)
    log = s.run().train
    stepped = _column(log["tau"], 1, log["tau"][:, 1] + 30 * (log["t"] > 5))
    d = diagnose(
        parse_robot(s.run().robot_toml), log_of(s, tau=stepped), validation=log_of(s, "validation")
    )
    assert d.after.total < 0.1 * d.before.total
    assert any("tau2 of train.csv jumps" in line for line in d.advice)
