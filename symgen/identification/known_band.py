"""Open logs for a comparison with known parameters: repair them and filter them in one band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from symgen.data.raw import Reading
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Source
from symgen.estimation.torque_error import fit
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.repair import join_bands, open_logs
from symgen.faults.undo import with_known_shifts
from symgen.identification.model_choice import OpenLogs
from symgen.identification.parameters import values_of_file
from symgen.identification.torque_scale import in_torque_scale
from symgen.parallel import Say, silent
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class LogsInBand:
    """Logs in a band.

    Attributes:
        logs: the logs.
        band: the filters.
        repairs: repairs of the logs.
        notes: texts about the logs and the band.
    """

    logs: tuple[FilteredLog, ...]
    band: Band
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...]


def error_of(evaluator: Evaluator, X: FloatArray) -> Callable[[FilteredLog], float]:
    """Return the torque error in motion of parameters X (p,), as a function of the log."""
    return lambda log: fit(evaluator, [log], X).in_motion.residual.relative


def open_in_band(
    evaluator: Evaluator,
    file: Any,
    sources: Sequence[Source],
    reading: Reading | None,
    *,
    band: Band | None,
    shifts: Sequence[Fault],
    error: Callable[[FilteredLog], float],
    cutoff: float | None = None,
    progress: Say = silent,
) -> LogsInBand:
    """Open logs, repair them, and filter them in one band.

    Args:
        evaluator: the compiled model.
        file: path of the robot file, for its masses.
        sources: paths or logs.
        reading: options of reading and masking.
        band: filters of the run that estimated the parameters; by default, symgen chooses them.
        shifts: shifts of the torques in that run. A log is shifted only if this lowers its torque
            error, because another recorder may not be late.
        error: the torque error of a log, see `error_of`.
        cutoff: cutoff of the filter of positions and speeds, Hz; by default that of the band.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot.
    """
    (train,), repairs = open_logs((sources,), evaluator.model.robot, reading, progress)
    file_values = values_of_file(file, evaluator.model)
    opened = in_torque_scale(OpenLogs(evaluator, train), file_values, evaluator, reading)
    samples, _, more = join_bands(opened.train, (), None if band is None else band.comparison_hz)
    chosen = band or choose_band(evaluator, samples, cutoff)
    if cutoff is not None:
        chosen = replace(chosen, cutoff_hz=cutoff)
    progress(f"band: {chosen.in_words()}")
    repairs += more
    logs = []
    for s in samples:
        log = filter_log(s, chosen)
        if shifts:
            shifted, done = with_known_shifts(s, shifts)
            other = filter_log(shifted, chosen)
            if error(other) < error(log):
                log = other
                repairs += done
        logs.append(log)
    notes = (*(note for s in samples for note in s.notes), f"band: {chosen.in_words()}")
    return LogsInBand(tuple(logs), chosen, tuple(repairs), notes)
