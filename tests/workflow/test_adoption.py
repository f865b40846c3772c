"""What `diagnose` adopts holds in the estimate that identify gives of the written robot.

The arm is the closed form of oracles/arm.py, in a vertical plane, with an offset that its robot
file does not declare. Limits of size are off where they would decide first.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from oracles.arm import HANGING, IN_PLANE, Arm, Arrays, sines
from oracles.planar2r import robot_toml

import symgen

FRICTION = 'friction = ["coulomb", "viscous"]'
ARM = symgen.parse_robot(robot_toml("arm", gravity=IN_PLANE))
OFFSETS = symgen.parse_robot(
    robot_toml("arm", FRICTION.replace("]", ', "offset"]'), gravity=IN_PLANE)
)
G = 9.81


def moved(seed: int) -> tuple[np.random.Generator, np.ndarray, Arrays]:
    """Random numbers, and t, q, qd, qdd of 12 s at 100 Hz."""
    rng, t = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    phase = rng.uniform(0, 6, (2, 2))
    return rng, t, sines(t, [[0.8, 0.6], [0.3, 0.4]], [[1.1, 1.7], [2.9, 4.3]], phase)


def log_of(arm: Arm, name: str, seed: int, more: np.ndarray) -> symgen.Log:
    """A log of an arm with further torques (K, 2) or (2,)."""
    rng, t, motion = moved(seed)
    t, q, tau, qd = arm.recorded(t, motion, rng)
    return symgen.make_log(name, t, q, tau + more, qd)


def names(found: symgen.Diagnosis, adopted: bool) -> list[tuple[str, tuple[int, ...]]]:
    return [(e.name, e.joints) for e in found.effects if e.adopted is adopted]


def columns(motion: Arrays) -> np.ndarray:
    """Torques (K, 2, p) of an arm for each of its parameters alone."""
    none = Arm(np.zeros(4), g=G)
    arms = [replace(none, X=unit) for unit in np.eye(4)]
    arms += [replace(none, MX1R=1.0), replace(none, IA2=1.0)]
    arms += [replace(none, **{law: unit}) for law in ("FS", "FV") for unit in np.eye(2)]
    weight = -G * np.outer(np.sin(motion[0][:, 0]), [1.0, 0.0])  # of MY1
    return np.stack([*(arm.torque(*motion) for arm in arms), weight], axis=2)


def distances(W: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the parameters of ordinary least squares in deviations: |X|/std, (p,)."""
    size = y.std(axis=0)[:, None]  # the noise is a share of it
    rows, measured = (W / size).reshape(-1, W.shape[2]), (y / size[:, 0]).ravel()
    X = np.linalg.lstsq(rows, measured, rcond=None)[0]
    variance = np.mean((measured - rows @ X) ** 2) * np.diag(np.linalg.inv(rows.T @ rows))
    return np.abs(X) / np.sqrt(variance)


def test_an_effect_within_three_deviations_of_zero_is_not_adopted() -> None:
    """Only joint 2 has an offset; one of joint 1 is probable in the search, and is not known."""
    logs = [log_of(HANGING, name, seed, np.array([0.0, 0.03])) for seed, name in enumerate("ab", 1)]
    found = symgen.diagnose(
        ARM, logs[0], validation=logs[1], effects=["torque_offset"], least=1e-5, misfit=1e-5
    )
    assert names(found, adopted=True) == [("torque_offset", (2,))]
    assert names(found, adopted=False) == [("torque_offset", (1,))]
    assert [joint.friction[2:] for joint in found.extended.joints] == [(), ("offset",)]
    y, motion = logs[0].tau, moved(1)[2]
    offsets = np.broadcast_to(np.eye(2), (*y.shape, 2))
    first, second = distances(np.concatenate([columns(motion), offsets], axis=2), y)[-2:]
    assert first < 3 < second


def test_an_effect_that_raises_the_error_of_a_joint_by_a_quarter_is_not_adopted() -> None:
    """The offset of joint 2 in the training log; without it, parameters of link 2 absorb a part.

    In the validation log, the torque of joint 1 is that of these wrong parameters: it agrees with
    the model without the offset.
    """
    light = Arm(
        np.array([0.4, *HANGING.X[1:]]), g=G, FS=np.array([0.05, 0.08]), FV=np.array([0.02, 0.05])
    )
    offset = np.array([0.0, 0.03])
    train = log_of(light, "train", 1, offset)
    W, size = columns(moved(1)[2]), train.tau.std(axis=0)
    rows = (W / size[:, None]).reshape(-1, W.shape[2])
    y = np.broadcast_to(offset / size, train.tau.shape).ravel()
    absorbed = columns(moved(2)[2])[:, 0] @ np.linalg.lstsq(rows, y, rcond=None)[0]
    test = log_of(light, "test", 2, offset + np.outer(absorbed, [1.0, 0.0]))
    found = symgen.diagnose(ARM, train, validation=test, effects=["torque_offset"])
    assert names(found, adopted=True) == []
    assert (found.extended, found.after) == (ARM, found.before)
    with_offset = replace(ARM, joints=(ARM.joints[0], OFFSETS.joints[1]))
    after = symgen.identify(with_offset, train, validation=test).moving.per_joint
    before = found.gaps.before.per_joint
    rise, fall = after[0] - before[0], before[1] - after[1]
    assert 0.25 * fall < rise < 0.008 < fall
