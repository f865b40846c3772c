"""Torques that depend on what a log has beside the motion: taken off what was measured.

    tau_model = tau - sum of columns(q, qd, temp) * coefficients

What is left is the torque of the robot's model, at the temperature T0 that an effect names.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symgen.data.raw import read_only
from symgen.data.signals import Samples, can_filter, lowpass
from symgen.errors import LogError
from symgen.estimation.values import FloatArray
from symgen.robot.effect import LogEffect
from symgen.robot.types import Robot
from symgen.symbolic.effects import definition_tape
from symgen.symbolic.independence import FUNCTIONS
from symgen.symbolic.tape import Numbers

_SLOW = 10.0  # Hz, of the speed whose sign tells the direction of friction


def torque_beside(
    robot: Robot, q: FloatArray, qd: FloatArray, temp: FloatArray | None, log: str
) -> FloatArray:
    """Return what the effects on samples add to the torques of the motors, (N, n).

    Args:
        robot: with its `on_logs`.
        q, qd: (N, n) motion.
        temp: (N, n) temperatures, deg C, NaN on joints without, or None.
        log: its name.

    Raises:
        LogError: a column is missing.
    """
    out = np.zeros(q.shape)
    numbers = [joint.number for joint in robot.movable]
    for effect in robot.on_logs:
        j = numbers.index(effect.joint)
        if temp is None or np.isnan(temp[:, j]).any():
            raise LogError(
                f"{log}: robot {robot.name} has {effect.name} on {robot.label(effect.joint)}, "
                "and the log "
                f"has no column temp{j + 1}; accepted: a log with it, or a robot file without the "
                "effect"
            )
        width = robot.movable[j].coulomb_width
        out[:, j] += _column(effect, q[:, j], qd[:, j], temp[:, j], width)
    return out


def _column(
    effect: LogEffect, q: FloatArray, qd: FloatArray, temp: FloatArray, width: float
) -> FloatArray:
    d, values = effect.definition, {name: float(value) for name, value in effect.values}
    sign = {"sign": lambda v: np.tanh(v / width)} if width else {}
    rest = np.zeros_like(q)
    inputs = {"q": [q], "qd": [qd], "qdd": [rest], "taur": [rest], "temp": [temp]}
    inputs["c"] = [np.array(values[name]) for name in d.nonlinear]
    columns = definition_tape(d).run(Numbers({}, {**FUNCTIONS, **sign}), inputs)
    return np.asarray(
        sum(values[name] * np.asarray(c) for name, c in zip(d.linear, columns, strict=True))
    )


def without_beside(samples: Samples, robot: Robot) -> Samples:
    """Take the torque of the effects on samples off a log.

    Raises:
        LogError: a column is missing.
    """
    if not robot.on_logs:
        return samples
    step = samples.step
    qd = lowpass(samples.qd, step, _SLOW) if can_filter(_SLOW, step) else samples.qd
    known = torque_beside(robot, samples.q, qd, samples.temp, samples.name)
    listed = ", ".join(f"{e.name} on {robot.label(e.joint)}" for e in robot.on_logs)
    note = f"{samples.name}: {listed}: taken off the measured torques"
    return replace(
        samples,
        tau=read_only(samples.tau - known),
        beside=read_only(known),
        notes=(*samples.notes, note),
    )
