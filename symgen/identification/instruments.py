"""Instruments for measured logs: the regressor along a motion without the noise of W.

Instruments need a motion whose errors are independent of those in W and y. There are two:

- The commanded motion is independent of all sensor noise, also in closed loop. It is the best
  choice.
- The encoders are instruments for measured speeds. W uses the measured q and qd. Z uses q after a
  zero-phase low-pass in the band of the motion, and its derivative. This is valid for tachometer
  noise of any spectrum. Encoder noise within the band is in both W and Z, but it enters W only
  through q, not through its derivative.

Speeds that are derived from the encoders are no second sensor: in the band, W and any smoothed Z
have the same noise. Without a commanded motion, symgen refuses this case.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from symgen.data.log import make_log
from symgen.data.signals import Samples, interpolated, prepare
from symgen.data.tables import read_columns
from symgen.errors import IdentificationError, LogError
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.filtered_log import filter_log
from symgen.estimation.opening import Source, open_log
from symgen.estimation.values import FloatArray
from symgen.identification.solving import EquatedLog
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator


def instrumented(
    evaluator: Evaluator, part: EquatedLog, model: EquationModel, commanded: Source | None
) -> EquatedLog:
    """Return a log whose equations have instruments Z: the rows along another motion.

    Args:
        evaluator: the compiled model.
        part: a training log with its equations.
        model: model of the equations.
        commanded: commanded motion of the log; None to use the encoders.

    Raises:
        IdentificationError: there is neither a commanded motion nor a measured speed.
        LogError: the commanded motion does not span the log.
    """
    log = part.log
    if commanded is not None:
        motion = _commanded(commanded, evaluator.model.robot, log.samples)
        q, qd = _onto(motion, log.samples)
        free = replace(log, q=q, qd=qd)
    elif log.samples.velocity_derived:
        raise IdentificationError(
            f"{log.name}: method iv needs instruments, and speeds derived from q have the noise of "
            "q; accepted: measured speeds qd, or the commanded motion"
        )
    else:
        free = filter_log(log.samples, replace(log.band, velocity="derived"))
    rows = model.equations(evaluator, free)
    return replace(part, equations=replace(part.equations, Z=rows.W))


def _commanded(source: Source, robot: Robot, samples: Samples) -> Samples:
    """Read a commanded motion from a log, or from a table of t, q1.. and qd1.. as `excite` writes.

    Raises:
        LogError: it is the log itself, which has the same noise.
    """
    if isinstance(source, (str, Path)) and Path(source).suffix.lower() == ".csv":
        t, columns = read_columns(source, ("q",), ("qd", "tau"), "t, q1.., optional qd1..")
        if "tau" not in columns:  # a log needs torques, but nothing uses these
            ones = np.ones_like(columns["q"])
            name = Path(source).name
            return prepare(make_log(name, t, columns["q"], ones, columns.get("qd"), n=robot.n))
    motion = prepare(open_log(source, robot))
    if np.array_equal(motion.q, samples.q):
        raise LogError(
            f"{motion.name}: the commanded motion is the measured one of {samples.name}, with its "
            "noise; accepted: the motion that the controller was to follow"
        )
    return motion


def _onto(motion: Samples, samples: Samples) -> tuple[FloatArray, FloatArray]:
    """Return the positions and speeds of a motion at the times of a log."""
    slack = 1.5 * max(motion.step, samples.step)
    if motion.t[0] > samples.t[0] + slack or motion.t[-1] < samples.t[-1] - slack:
        raise LogError(
            f"{motion.name}: the commanded motion spans {motion.t[0]:g} to {motion.t[-1]:g} s, the "
            f"log {samples.name} {samples.t[0]:g} to {samples.t[-1]:g} s; accepted: one as long"
        )
    q, qd = (interpolated(motion.t, x)(samples.t) for x in (motion.q, motion.qd))
    return q, qd
