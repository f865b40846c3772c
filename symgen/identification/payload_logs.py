"""What `payload` solves: torque equations of motions in one band, or of still poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from symgen.data.raw import Reading
from symgen.errors import IdentificationError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered import filtered
from symgen.estimation.logs import Source, require_other_data
from symgen.estimation.poses import open_poses, pose_equations
from symgen.estimation.system import Equations, torque_equations
from symgen.faults.fault import Fault
from symgen.faults.logs import in_one_band, open_logs
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class Seen:
    """What was read: torque equations log by log, and what is said of it."""

    equations: list[tuple[Equations, ...]]
    band: Band | None
    notes: tuple[str, ...]
    repairs: tuple[Fault, ...] = ()


def torques(
    evaluator: Evaluator,
    logs: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    band: Band | None,
    progress: Callable[[str], None],
) -> Seen:
    """Read logs of motions: in one band, that of the parameters where they have one."""
    (samples,), repairs = open_logs((logs,), evaluator.model.robot, reading, progress)
    require_other_data(samples, [])
    samples, _, mended = in_one_band(samples, [])
    band = band or choose_band(evaluator, samples, cutoff)
    if cutoff is not None:
        band = replace(band, cutoff_hz=cutoff)
    progress(f"band: {band.in_words()}")
    equations = [torque_equations(evaluator, filtered(s, band)) for s in samples]
    notes = (*(n for s in samples for n in s.notes), f"band: {band.in_words()}")
    return Seen(equations, band, notes, (*repairs, *mended))


def still_poses(
    evaluator: Evaluator,
    logs: Sequence[Source],
    reading: Reading | None,
    cutoff: float | None,
    _band: Band | None,
    progress: Callable[[str], None],
) -> Seen:
    """Read tables of still poses."""
    if cutoff is not None:
        raise IdentificationError("--cutoff: still poses pass no filter; accepted: none")
    progress(f"reading {', '.join(str(getattr(log, 'name', log)) for log in logs)}")
    poses = [open_poses(log, evaluator.model.robot, reading) for log in logs]
    require_other_data(poses, [])
    equations = [pose_equations(evaluator, s) for s in poses]
    return Seen(equations, None, tuple(n for s in poses for n in s.notes))
