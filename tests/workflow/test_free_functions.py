"""Where no law of the library has the shape of a gap, diagnose says of what it is a function."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import planar2r

import symgen

L1, X = 0.5, np.array([3.7, 0.8, 1.2, 0.3])
ROBOT = planar2r.robot_toml("odd")


def log(seed: int, strength: float) -> symgen.Log:
    """A motion with a torque on joint 1 that both positions make."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += np.sign(qd) + 0.5 * qd + 0.02 * rng.normal(size=tau.shape)
    tau[:, 0] += strength * q[:, 0] * q[:, 1] ** 2
    return symgen.make_log(f"log {seed}", t, q, tau, qd)


@pytest.mark.parametrize("strength", [0.0, 6.0])
def test_the_variables_of_a_torque_without_a_law_are_told(strength: float) -> None:
    robot = symgen.parse_robot(ROBOT, "odd.toml")
    logs = [log(seed, strength) for seed in (2, 3, 4)]
    found = symgen.diagnose(robot, logs[:2], validation=logs[2])
    told = [line for line in found.advice if "a free function leaves" in line]
    if not strength:
        assert found.verdict == "consistent"
        assert not told
        return
    assert found.verdict in ("unexplained", "partly-explained")
    (line,) = told
    assert line.startswith(
        "the torque that joint 1 misses depends on the position of joint 1 and the position of "
        "joint 2:"
    )
