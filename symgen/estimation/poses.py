"""Still poses: the torque equations of standstill, and which parameters they show.

    tau = W(q, 0, 0) X + FS d + f,    |f| within the friction that holds the joint

with d in {-1, 0, 1} the direction in which a joint moved last, where the table tells it. Of X these
rows show what gravity, offsets, springs and the like depend on; no inertia, no viscous friction.
Poses are no series: the friction that is left in one says nothing of that in the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import Reading, read_only
from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.logs import Source, open_log
from symgen.estimation.solve import SINGULAR
from symgen.estimation.system import Equations, LinearSystem
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_SHARE = 1e-6  # of a parameter in what another one stands for


def open_poses(source: Source, robot: Robot, reading: Reading | None = None) -> Samples:
    """Open a table of still poses; t is the number of the pose, qd the direction of approach.

    Args:
        source: a path, or a log whose rows are poses.
        robot: whose poses they are.
        reading: how the table is read.

    Raises:
        LogError: it cannot be read, or is another robot's.
    """
    log = open_log(source, robot, replace(reading or Reading(), poses=True))
    assert log.tau is not None  # open_log has seen to it
    told = np.zeros_like(log.q) if log.qd is None else np.sign(log.qd)
    t = np.arange(1.0, len(log.q) + 1)
    q, qd, t = map(read_only, (log.q, told, t))
    return Samples(log.name, t, q, qd, log.tau, 1.0, None, log.notes)


def pose_columns(evaluator: Evaluator, q: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the torque regressor of standstill, (K, n, p).

    Args:
        evaluator: the compiled model, with torque_regressor.
        q: (K, n) poses.
        direction: (K, n) in which each joint moved last: -1, 0 (not known) or 1.
    """
    zero = np.zeros_like(q)
    W: FloatArray = evaluator["torque_regressor"](np.ascontiguousarray(q), zero, zero).copy()
    for j, column in coulomb_columns(evaluator).items():
        W[:, j, column] += direction[:, j]
    return W


def coulomb_columns(evaluator: Evaluator) -> dict[int, int]:
    """Return the place of FS in X, by the position of its joint."""
    place = {name: k for k, name in enumerate(evaluator.model.base.names)}
    movable = enumerate(evaluator.model.robot.movable)
    named = {j: place.get(f"FS{joint.number}") for j, joint in movable}
    return {j: k for j, k in named.items() if k is not None}


def pose_equations(evaluator: Evaluator, poses: Samples) -> tuple[Equations, ...]:
    """Build the torque equations of standstill of one table, joint by joint."""
    W = pose_columns(evaluator, poses.q, poses.qd)
    return tuple(
        Equations(
            f"{poses.name}, joint {j + 1}",
            np.ascontiguousarray(W[:, j]),
            poses.tau[:, j],
            poses.t,
            0,
            j,
        )
        for j in range(W.shape[1])
    )


@dataclass(frozen=True, eq=False)
class Shown:
    """Which parameters some equations show.

    Attributes:
        kept: places in X of columns that are independent of each other, those before going first.
        known: of `kept`, those with no part in a combination that the equations leave open.
    """

    kept: tuple[int, ...]
    known: tuple[int, ...]

    @staticmethod
    def by(equations: Sequence[Equations]) -> Shown:
        """Look at the columns of some equations.

        Raises:
            IdentificationError: they show nothing.
        """
        W = np.concatenate([e.W for e in equations])
        norms = np.linalg.norm(W, axis=0)
        seen = np.flatnonzero(norms > SINGULAR * max(float(norms.max()), 1e-300))
        if not len(seen):
            raise IdentificationError(
                "no parameter of the robot shows at standstill: no gravity acts on its joints"
            )
        basis = np.zeros((len(W), 0))
        kept: list[int] = []
        tied: set[int] = set()
        for k in seen:
            column = W[:, k] / norms[k]
            rest = column - basis @ (basis.T @ column)
            rest -= basis @ (basis.T @ rest)
            size = float(np.linalg.norm(rest))
            if size > SINGULAR:
                basis = np.column_stack([basis, rest / size])
                kept.append(int(k))
                continue
            share = np.linalg.lstsq(W[:, kept] / norms[kept], column, rcond=None)[0]
            tied |= {i for i, s in zip(kept, share, strict=True) if abs(s) > _SHARE}
        return Shown(tuple(kept), tuple(k for k in kept if k not in tied))

    def system(self, names: Sequence[str], equations: Sequence[Equations]) -> LinearSystem:
        """Return the equations of what is kept."""
        return LinearSystem(
            tuple(names[k] for k in self.kept), tuple(e.columns(self.kept) for e in equations)
        )
