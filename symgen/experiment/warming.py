"""Robots that warm up as they move: temperatures in the logs, and torques that depend on them.

    T(t) = b + (a - b) exp(-t/T0)

The controller feeds forward what effects on samples ask of the motors: the motion is the same, and
the torques in the logs have it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from symgen.data.raw import read_only
from symgen.errors import ParameterError
from symgen.estimation.beside_model import torque_beside
from symgen.experiment.instruments import Instruments
from symgen.experiment.simulation import Simulation
from symgen.robot.types import Robot


def warmed(
    done: Simulation,
    robot: Robot,
    temperature: tuple[float, float, float],
    instruments: Instruments,
    runs: range,
    seed: int,
) -> Simulation:
    """Return a simulation with temperatures, and with the torques that depend on them.

    Args:
        done: the motions.
        robot: with its effects on samples.
        temperature: at the start and in the end, deg C, and the time constant, s.
        instruments: what the logs show of torques.
        runs: numbers of the runs.
        seed: of all noise.

    Raises:
        ParameterError: the temperature has no meaning.
    """
    start, end, constant = temperature
    if not all(map(math.isfinite, temperature)) or constant <= 0:
        listed = ",".join(f"{x:g}" for x in temperature)
        raise ParameterError(
            f"simulate: temperature {listed}; accepted: START,END in deg C and a time above 0 s"
        )
    t = done.t - done.t[0]
    course = end + (start - end) * np.exp(-t / constant)
    temp = np.repeat(course[:, None], len(done.sigma), axis=1)
    more = np.stack(
        [
            torque_beside(robot, q, qd, temp, done.robot)
            for q, qd in zip(done.q, done.qd, strict=True)
        ]
    )
    tau = read_only(done.tau + more)
    shown = instruments.torque(tau, runs, seed)
    return replace(done, tau=tau, tau_log=read_only(shown), temp=read_only(temp))
