"""Imported URDFs in numbers, beside Pinocchio, for several tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from oracles.urdf_arm import PinocchioUrdf

from symgen.robot.imported import Imported
from symgen.robot.types import Robot
from symgen.symbolic.parameters import standard_parameters
from symgen.symbolic.placement import frames_tape
from symgen.symbolic.regressor import torque_tape
from symgen.symbolic.tape import Numbers, Tape

FUNCTIONS = {"sin": np.sin, "cos": np.cos}


def rigid(robot: Robot, free: bool = True) -> Robot:
    """Return the robot without friction and rotors; `free` gives followers their own variable."""
    return replace(
        robot,
        joints=tuple(
            replace(j, friction=(), rotor_inertia=False, follows=None if free else j.follows)
            for j in robot.joints
        ),
    )


class Ours:
    """Torques and frames of an imported robot, from its table and the inertias of its file."""

    def __init__(self, imported: Imported, free: bool = True) -> None:
        self.robot = rigid(imported.robot, free)
        values = dict(imported.parameters)
        self.X = np.array([values.get(p.name, 0.0) for p in standard_parameters(self.robot)])
        self.tapes = torque_tape(self.robot, fixed=True), frames_tape(self.robot)
        self.names = [j.name for j in self.robot.movable]

    def states(self, samples: int, seed: int = 1) -> dict[str, np.ndarray]:
        rng = np.random.default_rng(seed)
        return {k: rng.uniform(-1.5, 1.5, (samples, self.robot.n)) for k in ("q", "qd", "qdd")}

    def torques(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        Y = self._run(self.tapes[0], len(q), q=q, qd=qd, qdd=qdd)
        return Y.reshape(len(q), self.robot.n, -1) @ self.X

    def frames(self, q: np.ndarray) -> np.ndarray:
        return self._run(self.tapes[1], len(q), q=q).reshape(len(q), -1, 4, 4)

    def _run(self, tape: Tape, samples: int, **inputs: np.ndarray) -> np.ndarray:
        columns = {k: list(v.T) for k, v in inputs.items()}
        out = tape.run(Numbers(self.robot.values(), FUNCTIONS), columns)
        return np.stack([np.broadcast_to(np.asarray(o, float), samples) for o in out], axis=1)


def torque_gap(ours: Ours, pinocchio: PinocchioUrdf, samples: int = 4) -> float:
    """Return the worst error of a joint's torque, relative to the largest on that joint."""
    states = ours.states(samples)
    tau = ours.torques(**states)
    want = np.array(
        [
            [torques[name] for name in ours.names]
            for torques in (
                pinocchio.torques(
                    *(dict(zip(ours.names, x[i], strict=True)) for x in states.values())
                )
                for i in range(samples)
            )
        ]
    )
    largest = np.abs(want).max(axis=0)
    scale = np.maximum(largest, 1e-6 * largest.max()) + 1e-300
    return float((np.abs(tau - want).max(axis=0) / scale).max())


def place_gap(ours: Ours, pinocchio: PinocchioUrdf, samples: int = 4) -> float:
    """Return how far frames are apart: fixed ones in full, others but for a constant placement.

    Of a moving joint the constant placement must leave the z axis where it is.
    """
    q = ours.states(samples)["q"]
    inside: dict[str, np.ndarray] = {}
    gap = 0.0
    for i, frames in enumerate(ours.frames(q)):
        theirs = pinocchio.places(dict(zip(ours.names, q[i], strict=True)))
        for joint, T in zip(ours.robot.joints, frames, strict=True):
            if joint.name not in theirs:  # a frame between nearly parallel axes
                continue
            found = np.linalg.inv(T) @ theirs[joint.name]
            want = np.eye(4) if joint.sigma == 2 else inside.setdefault(joint.name, found)
            gap = max(gap, np.abs(found - want).max())
            if joint.sigma != 2:  # the link's origin is on the axis
                gap = max(gap, np.hypot(*found[:2, 3]))
    return float(gap)
