"""Check that the effects of a robot add a torque that the rest of its model cannot produce."""

from __future__ import annotations

import numpy as np

from symgen.errors import RobotError
from symgen.robot.types import Robot
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.regressor import torque_tape
from symgen.symbolic.sampling import columns_at, random_inputs

_NEW = 1e-9  # smallest residual of an independent column, relative to the column


def require_new_columns(robot: Robot, base: BaseParameters) -> None:
    """Refuse an effect whose torque is a combination of the other columns of the model.

    The columns are evaluated at random states in floating point. A column is a combination if the
    residual of its fit by the others is less than 1e-9 of it.

    Raises:
        RobotError: an effect is redundant, or its torque is not finite. The message names the
            effect and its coefficient.
    """
    count = 4 * len(base.parameters) + 20
    inputs = random_inputs(robot, count, len(base.parameters))
    for x in (x for name in ("q", "qd", "qdd") for x in inputs[name]):
        x[0] = 0.0  # the poles of logarithms and quotients are there
    # log(0) of a power at rest; other values that are not finite are refused
    with np.errstate(all="ignore"):
        W = columns_at(torque_tape(robot), robot.values(), inputs, count)
    total = sum(not p.load for p in base.standard)
    rows = W.reshape(count, len(robot.equations), total).transpose(1, 0, 2).reshape(-1, total)
    kept = [p.index for p in base.parameters[: base.linear]]
    largest = np.abs(rows).max(axis=0)
    declared = [(e, name) for e in robot.effects for name, _ in e.linear if not e.loads(name)]
    place = {p.name: p.index for p in base.parameters}
    for effect, name in declared:
        if not np.isfinite(largest[place[name]]):
            raise RobotError(
                f"effect {effect.name!r} of joint {effect.joint}: the torque of {name} is not "
                "a finite number everywhere; accepted: one that is, where joints are within half a "
                "turn or 1 m and move at up to 3 rad/s or 1 m/s"
            )
    rows = rows / np.where(largest > 0, largest, 1.0)
    for effect, name in declared:
        at = place[name]
        others = rows[:, [i for i in kept if i != at]]
        norms = np.linalg.norm(others, axis=0)
        others = others / np.where(norms > 0, norms, 1.0)
        column = rows[:, at]
        fit = np.linalg.lstsq(others, column, rcond=1e-12)[0]
        residual = float(np.linalg.norm(column - others @ fit))
        if residual <= _NEW * float(np.linalg.norm(column)):
            raise RobotError(
                f"effect {effect.name!r} of joint {effect.joint}: {name} is nothing new: "
                "its torque is a combination of the model's other columns; accepted: an effect "
                "that the declared friction and the rigid body do not contain"
            )
