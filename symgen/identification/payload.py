"""payload: identify mass, centre of mass and inertia of a load from logs with the load.

There are two ways. With known parameters X of the unloaded robot, symgen identifies the load and
friction from the logs with the load. With logs without the load, symgen fits robot and load in one
system. Friction and model errors then cancel if both motions are alike (Khalil, Gautier, Lemoine
2007).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.raw import Reading
from symgen.errors import IdentificationError, ParameterError, RobotError, shortened
from symgen.estimation.equation_model import JUDGING, EquationModel
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import noise_fit
from symgen.estimation.opening import Source, listed_logs, require_logs, require_other_data
from symgen.estimation.torque_error import fit, percent
from symgen.estimation.values import FloatArray, Trace
from symgen.identification.campaign import Filtering
from symgen.identification.contacts import hides_load, never_lifted
from symgen.identification.estimate import joints_of
from symgen.identification.judgement import require_scale
from symgen.identification.known_band import open_in_known_band
from symgen.identification.load_problem import LoadProblem, load_problem
from symgen.identification.load_result import (
    WITH,
    WITHOUT,
    LoadErrors,
    Payload,
    payload_of,
    require_mass,
)
from symgen.identification.parameters import KnownParameters, read_known
from symgen.identification.solving import settle_load
from symgen.identification.wrist import payload_by_wrench
from symgen.parallel import Say, silent
from symgen.policy import SHOWN
from symgen.robot.tables import Frame
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_base
from symgen.runtime.evaluator import Evaluator, load


def payload(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    parameters: str | Path | None = None,
    without: Sequence[Source] | Source = (),
    frame: str = "",
    mass: float | None = None,
    gain: float | None = None,
    cutoff: float | None = None,
    sensor: bool = False,
    reading: Reading | None = None,
    progress: Say = silent,
) -> Payload:
    """Identify the load on a link of a robot.

    The link is that of [payload] in the robot file, or else the last moving link.

    Args:
        robot: a robot, a path or a library name.
        logs: logs that were recorded with the load.
        parameters: parameters of the robot without the load: the folder that `identify` or
            `diagnose` wrote, its estimate.json, or TOML with [parameters].
        without: logs without the load, preferably of the same motions; X then comes from them.
        frame: name of the frame of the result, one of `Robot.frames` on the link; "" for the frame
            of the joint.
        mass: known mass of the load, kg; None if unknown.
        gain: standard deviation of the gains of the drives, in percent, which scales masses and
            inertias; by default that of [drive].
        cutoff: cutoff of the filter of positions and speeds, Hz; by default that of the file of
            parameters, or else the one that suits the logs best.
        sensor: whether to identify the load from the wrench of the sensor in [sensor], in its
            frame, without `frame`, `mass` and `cutoff`. With parameters or logs without the load,
            the load from the joint torques is in `Payload.sensor`.
        reading: options of reading and masking.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot.
        ParameterError: the parameters are of another robot, or a number is invalid.
        RobotError: the robot has no such frame on the link of the load.
        IdentificationError: the logs do not show a load, or there are neither parameters nor logs
            without the load.
    """
    loaded, bare = listed_logs(logs), listed_logs(without)
    require_logs(loaded)
    if sensor and (frame or mass is not None or cutoff is not None):
        raise ParameterError(
            "--frame, --mass, --cutoff: --sensor finds the mass, in the frame of [sensor]; "
            "accepted: none of them"
        )
    if sensor:
        require_base(read_robot(robot), "payload --sensor", "symgen payload without it")
        found = payload_by_wrench(read_robot(robot), loaded, reading, progress)
        if parameters is None and not bare:
            return found
        other = payload(
            robot,
            loaded,
            parameters=parameters,
            without=bare,
            frame=found.frame_label,
            gain=gain,
            reading=reading,
            progress=progress,
        )
        assert found.sensor is not None
        torques = tuple(q for _, q, _ in other.rows())
        return replace(found, sensor=replace(found.sensor, torques=torques))
    if parameters is None and not bare:
        raise IdentificationError(
            "the parameters of the robot without the load are unknown; accepted: --parameters with "
            "the folder that symgen identify wrote, or --without with logs of the robot alone"
        )
    for name, value in (("--mass", mass), ("--gain", gain)):
        if value is not None and not 0 < value < math.inf:
            raise ParameterError(f"{name} {value:g}; accepted: a number above 0")
    source = read_robot(robot)
    link = source.load_link
    in_frame = _frame_on(source, frame, link)
    if gain is None and source.drive is not None:
        gain = source.drive.gain_uncertainty_percent
    progress("deriving and compiling the model")
    model = derive(source, JUDGING)
    in_file = None if parameters is None else read_known(parameters, model)
    if in_file is not None and in_file.estimate is not None:
        require_scale(in_file.estimate, f"{in_file.file}: a load has no mass in kg")
    evaluator = load(model)

    def error(log: FilteredLog) -> float:
        assert in_file is not None  # it has the shifts
        alone = load_problem(evaluator, ([log], []), in_file.X, link, mass, model.inertial)
        return alone.error(in_file.X)

    filtering = Filtering(cutoff, known=None if in_file is None else in_file.band)
    shifts = () if in_file is None else in_file.shifts
    drives = None if in_file is None else in_file.drives
    campaign = open_in_known_band(
        evaluator, robot, [*loaded, *bare], reading, filtering, shifts, error, progress, drives
    )
    require_other_data([log.samples for log in campaign.train], [])
    groups = campaign.train[: len(loaded)], campaign.train[len(loaded) :]
    if source.floating:
        for some in groups:
            _require_lifts(model, link, some)
    progress("solving")
    known = None if bare else in_file  # with logs without the load, X comes from them
    X = _without_load(evaluator, groups[1]) if known is None else known.X
    problem = load_problem(evaluator, groups, X, link, mass, 0 if known is None else model.inertial)
    solved = problem.solve(X)
    covariance, notes = solved.solution.covariance, campaign.notes
    how = "logs with and without the load, solved together"
    if known is not None:
        how = "logs with the load and given parameters, with the friction fitted again"
        spread, doubts = _known_covariance(known, model)
        notes += doubts
        if spread is not None:
            shift = solved.derivative_by_known()[:, : model.inertial]
            covariance = covariance + shift @ spread[: model.inertial, : model.inertial] @ shift.T
    unloaded = solved.X if known is None else X
    errors, traces = _load_errors(evaluator, groups[0], unloaded, solved.with_load)
    body = solved.load(covariance)
    if in_frame is not None:
        body = body.in_frame(in_frame)
    _require_link(replace(problem, rows=solved.problem.rows), X, link, errors.after)
    if mass is None:
        require_mass(body, source.label(link))
    return payload_of(
        body,
        mass,
        gain,
        notes,
        robot=source.name,
        frame=frame or link,
        residual=errors,
        method=f"weighted least squares of torque: {how}",
        band=campaign.band,
        repairs=campaign.repairs,
        joints=joints_of(source),
        joint=link,
        traces=traces,
    )


def _without_load(evaluator: Evaluator, logs: Sequence[FilteredLog]) -> FloatArray:
    """Return a start X (p,) for the solution, which load-dependent effects need to be good."""
    if not evaluator.model.robot.loaded:
        return np.zeros(len(evaluator.model.base.parameters))
    return np.array(settle_load(evaluator, logs, EquationModel("torque", 0.0)).at)


def _load_errors(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray, with_load: FloatArray
) -> tuple[LoadErrors, tuple[Trace, ...]]:
    """Return the torque errors and traces of the model without the load and with it.

    Args:
        evaluator: the compiled model.
        logs: the logs with the load.
        X: (p,) parameters without the load.
        with_load: (p,) parameters with the load.
    """
    first, second = (fit(evaluator, logs, x, "train") for x in (X, with_load))
    before, after = first.in_motion.residual, second.in_motion.residual
    noise = noise_fit(evaluator, logs, with_load).residual
    errors = LoadErrors(
        before.relative,
        after.relative,
        noise.relative,
        before.per_joint or (),
        after.per_joint or (),
        None if before.base_force is None else (before, after),
    )
    traces = []
    for quantity, torques in ((WITHOUT, first), (WITH, second)):
        traces += [replace(trace, quantity=quantity, raw=None) for trace in torques.traces]
    return errors, tuple(traces)


def _require_lifts(model: Model, link: int, logs: Sequence[FilteredLog]) -> None:
    """Raise IdentificationError if unknown forces at contacts hide some of a load on a link."""
    if logs and hides_load(model, link, logs):
        robot = model.robot
        still = ", ".join(contact.frame for contact in never_lifted(robot, logs))
        raise IdentificationError(
            f"{logs[0].name}: unknown forces at contacts hide some of a load on the link of "
            f"{robot.label(link)}; accepted: logs in which these lift at times: {still or 'all'}"
        )


def _known_covariance(
    known: KnownParameters, model: Model
) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Return the covariance of known parameters, None if there is none, and notes on it."""
    estimate = known.estimate
    if estimate is None:
        return None, ("std does not include the errors of the parameters: their file has no std",)
    doubt = () if estimate.verdict == "trusted" else (f"{known.file}: a doubtful estimate",)
    if len(estimate.correlation) != len(model.base.names):
        return None, doubt
    if not np.isfinite(estimate.covariance).all():
        raise ParameterError(
            f"{known.file}: it does not determine all parameters; accepted: an estimate that does"
        )
    return estimate.covariance, doubt


def _frame_on(robot: Robot, name: str, link: int) -> Frame | None:
    """Return a frame on the link of the load; None without a name.

    Raises:
        RobotError: the robot has no such frame, or it is on another link.
    """
    if not name:
        return None
    chosen = robot.frame(name)
    if chosen.joint != link:
        listed = ", ".join(f.name for f in robot.frames if f.joint == link) or "none"
        raise RobotError(
            f"--frame {shortened(name)}: it is on the link of joint {chosen.joint}, and the load "
            f"on that of {robot.label(link)}; accepted: {listed}"
        )
    return chosen


def _require_link(problem: LoadProblem, X: FloatArray, link: int, after: float) -> None:
    """Refuse a result if a load on another link fits much better.

    Args:
        problem: the solved problem of a load on a link.
        X: (p,) start of its solution.
        link: joint number of the link.
        after: torque error of the result.

    Raises:
        IdentificationError: a load on another link has less than half of the error.
    """
    robot, errors = problem.evaluator.model.robot, {link: after}
    for number in (0, *robot.numbers) if robot.floating else robot.numbers:
        other = problem.on_link(number)
        if number != link and other.V.size:
            errors[number] = other.error(X)
    best = min(errors, key=lambda number: errors[number])
    if errors[best] < SHOWN * after:
        raise IdentificationError(
            f"a load on another link fits better: the torque error is {percent(errors[best])} "
            f"with a load on {robot.label(best)}, {percent(after)} with one on "
            f"{robot.label(link)}; accepted: joint = {best} in [payload] of the robot file"
        )
