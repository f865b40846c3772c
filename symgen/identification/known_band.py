"""Open logs for a comparison with known parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from symgen.data.raw import Reading, refuse
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source
from symgen.estimation.torque_error import fit
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.repair import open_logs
from symgen.faults.undo import with_known_shifts
from symgen.identification.campaign import Campaign, Filtering, in_band
from symgen.identification.imu import has_imu, offsets_with_known
from symgen.identification.scales import with_torques
from symgen.parallel import Say, silent
from symgen.runtime.evaluator import Evaluator


def error_of(evaluator: Evaluator, X: FloatArray) -> Callable[[FilteredLog], float]:
    """Return the torque error in motion of parameters X (p,), as a function of the log."""
    return lambda log: fit(evaluator, [log], X).in_motion.residual.relative


def open_in_known_band(
    evaluator: Evaluator,
    file: Any,
    sources: Sequence[Source],
    reading: Reading | None,
    filtering: Filtering,
    shifts: Sequence[Fault] = (),
    error: Callable[[FilteredLog], float] = lambda _: 0.0,
    progress: Say = silent,
    drives: FloatArray | None = None,
) -> Campaign:
    """Open logs and repair them as the run that estimated the parameters.

    Args:
        evaluator: the compiled model.
        file: path of the robot file, for its masses.
        sources: paths or logs.
        reading: options of reading and masking.
        filtering: with the band of that run; without one, symgen chooses the band.
        shifts: shifts of the torques in that run. A log is shifted only if this lowers its torque
            error, because another recorder may not be late.
        error: the torque error of a log, see `error_of`.
        progress: called with a text about the current step.
        drives: (n,) torque of each drive per unit of its input, for logs of inputs.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot, or it has inputs of
            drives with unknown torques.
    """
    opened = open_logs((sources, ()), evaluator.model.robot, reading, progress)
    campaign = in_band(evaluator, file, opened, reading, filtering, progress)
    unit = campaign.train[0].samples.drive_unit
    if unit:
        if drives is None:
            what = f"{campaign.train[0].name}: the log has the {unit} of its drives, and the"
            refuse(
                f"{what} parameters were not identified from such logs",
                "an estimate of symgen identify from logs of the same kind",
            )
        campaign = campaign.changed(partial(with_torques, drives))
    if not shifts:
        return campaign
    logs, repairs = list[FilteredLog](), [*campaign.repairs]
    for log in campaign.train:
        samples, done = with_known_shifts(log.samples, shifts)
        shifted = filter_log(samples, campaign.band)
        if error(shifted) < error(log):
            log = shifted
            repairs += done
        logs.append(log)
    return replace(campaign, train=tuple(logs), repairs=tuple(repairs))


def without_offsets(campaign: Campaign, X: FloatArray) -> Campaign:
    """Remove the offsets of an IMU from logs whose model has known parameters X (p,)."""
    if not any(map(has_imu, campaign.train)):
        return campaign
    offsets = offsets_with_known(campaign.evaluator, campaign.train, X)
    repairs = (*campaign.repairs, *offsets.repairs)
    return replace(campaign, train=offsets.logs, repairs=repairs, imu=offsets)
