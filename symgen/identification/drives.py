"""Turn logs of the inputs of drives into logs of torques, by scales that the logs tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from symgen import names as names_of
from symgen.data.mask import rms
from symgen.data.raw import Reading, refuse
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source, require_other_data
from symgen.estimation.solve import Solution, weighted_least_squares
from symgen.estimation.system import join, torque_equations
from symgen.estimation.values import FloatArray
from symgen.identification.campaign import Campaign, Filtering
from symgen.identification.estimate import DriveEstimate, Estimate
from symgen.identification.known_band import open_in_known_band
from symgen.identification.scales import Carried, find_scales, with_torques

#: Part of the largest input of a drive above which it is at its limit.
_LIMITED = 0.999
#: Part of the usual speed above which a joint moves with an open winding.
_MOVES, _TINY = 0.05, 1e-300
_ROUNDS = 2  # the band of the logs follows their torques


def in_torques(
    campaign: Campaign,
    given: Any,
    carried: Sequence[Source] = (),
    body: Carried | None = None,
    reading: Reading | None = None,
    drives: FloatArray | None = None,
) -> Campaign:
    """Return the campaign with torques for logs of the inputs of drives; others are returned as is.

    Args:
        campaign: the logs.
        given: the robot, or the path of its file, for its masses.
        carried: logs in which the arm carries a known body.
        body: this body; None if there is none.
        reading: options of reading and masking.
        drives: (n,) known torque of each drive per unit of its input; None to find it.

    Raises:
        LogError: symgen cannot read a log, or a log is too long.
        RobotError: the robot file names no link for the body.
        IdentificationError: logs of torques need no known body.
    """
    unit = campaign.train[0].samples.drive_unit
    if not unit:
        if carried:
            raise IdentificationError(
                "--carried gives the scale of logs of duty, and these logs have torques; accepted: "
                "symgen payload for a load"
            )
        return campaign
    if drives is not None:
        return campaign.changed(partial(with_torques, drives))
    if campaign.long is not None:
        refuse("logs of duty are too long", "at most 2**18 samples together: --from, --until")
    robot = campaign.robot
    if body is not None and robot.payload is None:
        raise RobotError(
            f"{robot.name}: no link carries the body of --carried; accepted: [payload] with "
            f"joint = {robot.numbers[-1]}, or another one"
        )
    inputs, recorded = campaign, tuple[FilteredLog, ...]()
    if carried:
        known = Filtering(known=campaign.band)
        model = campaign.evaluator
        ones = np.ones(robot.n)  # the inputs themselves
        opened = open_in_known_band(model, given, carried, reading, known, drives=ones)
        recorded = opened.train
        require_other_data(*([x.samples for x in logs] for logs in (campaign.train, recorded)))
    for _ in range(_ROUNDS):
        campaign.progress("finding the scales of the drives")
        band = campaign.band
        carrying = [filter_log(log.samples, band) for log in recorded]
        masses = campaign.file_values
        scales = find_scales(inputs.evaluator, inputs.train, carrying, body, masses)
        campaign = replace(
            inputs.changed(partial(with_torques, scales.torque)), scales=scales
        ).in_new_band()
        if campaign.band == inputs.band:
            break
        inputs = inputs.in_band(campaign.band)
    return campaign


def with_back_emf(
    estimate: Estimate,
    campaign: Campaign,
    given: Any,
    logs: Sequence[Source],
    reading: Reading | None = None,
) -> Estimate:
    """Return an estimate with the back-EMF of its drives, from logs with open windings.

    An open winding has neither torque nor back-EMF, so that the torque of X is b qd too large:

        Y X = b qd

    Args:
        estimate: an estimate from logs of duty.
        campaign: these logs.
        given: the robot, or the path of its file.
        logs: logs of a motion with open windings, for example of an arm that falls.
        reading: options of reading and masking.

    Raises:
        LogError: symgen cannot read a log.
        IdentificationError: the estimate is not from logs of duty, or no joint moves.
    """
    if not estimate.drives:
        raise IdentificationError("--open separates the back-EMF of servos; accepted: logs of duty")
    model, X = campaign.evaluator, estimate.X
    robot = model.model.robot
    band = Filtering(known=campaign.band)
    off = open_in_known_band(
        model, given, logs, replace(reading or Reading(), open_windings=True), band
    )
    rows = join([torque_equations(model, log) for log in off.train])
    speeds = np.zeros(rows.y.shape)
    for j, number in enumerate(robot.numbers):  # the columns of viscous friction
        if f"FV{number}" in rows.names:
            speeds[:, j] = rows.W[:, j, rows.names.index(f"FV{number}")]
    usual = rms(np.concatenate([log.qd for log in campaign.train]))
    moved = np.flatnonzero(rms(speeds) > _MOVES * usual)
    if not len(moved):
        raise IdentificationError("--open: no joint with viscous friction moves in these logs")
    columns = np.einsum("kj,ji->kji", speeds, np.eye(robot.n))[:, :, moved]
    solution = weighted_least_squares(replace(rows.with_regressor(columns), y=rows.W @ X))
    responses = (
        np.einsum("kj,kjp->jp", speeds, rows.W)
        / np.maximum((speeds**2).sum(axis=0), _TINY)[:, None]
    )
    drives = list(estimate.drives)
    for k, j in enumerate(moved.tolist()):
        of_X = float(responses[j] @ estimate.covariance @ responses[j])
        std = math.sqrt(float(solution.covariance[k, k]) + of_X)
        drives[j] = replace(drives[j], back_emf=float(solution.X[k]), back_emf_std=std)
    return replace(estimate, drives=tuple(drives))


def drive_estimates(campaign: Campaign, solution: Solution) -> tuple[DriveEstimate, ...]:
    """Return the drives of the joints by their scales and the friction; none for torques.

        stall torque = a - FS,    no-load speed = (a - FS)/FV,    with b in FV

    Args:
        campaign: the logs.
        solution: the parameters, with the uncertainty of the scales.
    """
    scales, robot = campaign.scales, campaign.robot
    if scales is None:
        return ()
    drive = robot.drive
    limit = np.array((drive and drive.limit) or np.ones(robot.n))
    if scales.unit == "V":  # without a supply, the largest voltage is unknown
        limit = np.full(robot.n, np.nan)
    inputs = np.concatenate([log.tau for log in campaign.logs]) / scales.torque
    limited = np.mean(np.abs(inputs) >= _LIMITED * limit, axis=0)
    torque = scales.torque
    names = campaign.evaluator.model.base.names
    places = {name: k for k, name in enumerate(names)}
    rows = dict(zip(scales.names, scales.slopes, strict=True))
    X = np.append(solution.X, 0.0)  # the last one stands for no friction
    of_X = np.pad(solution.covariance, (0, 1))
    out = []
    for j, joint in enumerate(robot.movable):
        keys = f"FS{joint.number}", f"FV{joint.number}"
        at = [places.get(key, -1) for key in keys]
        coulomb, viscous = X[at].tolist()
        viscous = viscous if viscous > 0 else math.nan
        stall = limit[j] * torque[j] - coulomb
        speed = stall / viscous
        # Torque and friction of a joint have one scale, so that their errors have a common part.
        of_friction = [rows.get(key, 0 * torque) for key in keys]
        slopes = np.vstack([*of_friction, np.diag(torque)[j]])
        covariance = slopes @ scales.covariance @ slopes.T
        covariance[:2, :2] = of_X[np.ix_(at, at)]
        of_stall = np.array([-1.0, 0.0, limit[j]])
        of_speed = (of_stall - [0.0, speed, 0.0]) / viscous
        of_both = np.vstack([of_stall, of_speed])
        variances = np.diag(of_both @ covariance @ of_both.T)
        stds = np.sqrt(np.maximum(variances, 0.0)).tolist()
        unit = scales.unit_of(j, names_of.unit("FS", joint.sigma))
        if scales.reference[j] >= 0:
            unit = f"{unit} of joint {robot.numbers[scales.reference[j]]}"
        per = f"{unit} per {scales.unit}"
        of_torque = float(torque[j]), float(scales.std[j]), per
        at_limit = float(limited[j])
        out.append(
            DriveEstimate(joint.number, *of_torque, stall, stds[0], speed, stds[1], at_limit)
        )
    return tuple(out)
