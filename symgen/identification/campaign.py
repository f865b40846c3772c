"""The logs of a run: open -> repair -> split -> band, once for every command.

A long log is a sample of its pieces in memory, and the address of all of them on the disk.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from symgen.data.long_logs import is_long
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.equation_model import EquationModel, kernels_of
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.opening import Groups, Sources, hold_out, require_other_data
from symgen.estimation.torque_error import TorqueFit, fit
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.repair import open_logs, require_motion, with_mended_speeds
from symgen.hypotheses.ask import Answer
from symgen.identification.imu import ImuErrors
from symgen.identification.parameters import values_of_file
from symgen.identification.sampling import LongLogs, sample_logs
from symgen.identification.scales import Scales
from symgen.identification.torque_scale import in_torque_scale
from symgen.parallel import Say, silent
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load_model

_OFFSETS = "the offsets of the IMU in each log are estimated and removed"
_KEPT = "the offsets of the IMU are not estimated here: they have to be removed from the logs first"
_UNSEARCHED = "delays, contacts and missing effects are not searched for without forces or joints"


@dataclass(frozen=True)
class Filtering:
    """How symgen chooses the band of a run.

    Attributes:
        cutoff: cutoff of the filter of positions and speeds, Hz; None to choose it.
        own_speeds: whether to keep measured speeds in any case.
        known: the band of an earlier run; a cutoff replaces its own.
    """

    cutoff: float | None = None
    own_speeds: bool = False
    known: Band | None = None

    def band_of(
        self, evaluator: Evaluator, logs: Sequence[Samples], long: LongLogs | None, progress: Say
    ) -> Band:
        """Return the band for some training logs, or for a sample of long ones."""
        progress("choosing the band")
        if self.known is None:
            keep, threads = self.own_speeds, 1 if long is None else long.threads
            band = choose_band(evaluator, logs, self.cutoff, measured_speeds=keep, threads=threads)
        elif self.cutoff is None:
            band = self.known
        else:
            band = replace(self.known, cutoff_hz=self.cutoff)
        progress(f"band: {band.in_words()}")
        return band


@dataclass(frozen=True, eq=False)
class Campaign:
    """Repaired logs in their band, and the model of their robot.

    Attributes:
        evaluator: the compiled model.
        filtering: how the band was chosen.
        band: the filters.
        train, held: the training and the validation logs, or a sample of long ones.
        repairs: repairs of the logs.
        has_validation: whether there are validation logs from the user.
        file_values: (p,) parameters in the robot file; None if it has none.
        answer: what a search found; it is undone in the logs as far as possible.
        long: all of the logs, if they are long; else None.
        scales: scales of the drives that turned their inputs into torques; None for logs of
            torques.
        imu: errors of the IMU that were removed from the training logs; None if not searched.
        progress: called with a text about the current step.
    """

    evaluator: Evaluator
    filtering: Filtering
    band: Band
    train: tuple[FilteredLog, ...]
    held: tuple[FilteredLog, ...] = ()
    repairs: tuple[Fault, ...] = ()
    has_validation: bool = True
    file_values: FloatArray | None = None
    answer: Answer = field(default_factory=Answer)
    long: LongLogs | None = None
    scales: Scales | None = None
    imu: ImuErrors | None = None
    progress: Say = silent

    @property
    def robot(self) -> Robot:
        """The robot of the model."""
        return self.evaluator.model.robot

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """The training logs, then the validation logs."""
        return (*self.train, *self.held)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the logs and on their band."""
        noted = [note for log in self.logs for note in log.samples.notes]
        drives = () if self.scales is None else self.scales.in_words
        unsearched = (_UNSEARCHED,) * self.unsearched
        moves = any(log.samples.imu is not None for log in self.logs)
        offsets = (_KEPT,) * moves if self.imu is None else (_OFFSETS,) * self.imu.found
        return (*noted, *drives, *unsearched, *offsets, f"band: {self.band.in_words()}")

    @property
    def unsearched(self) -> bool:
        """Whether nothing can be searched for: a base floats in flight, or without joints."""
        samples = (log.samples for log in self.logs)
        flies = any(s.forces is None and s.touches is None for s in samples)
        return self.robot.floating and (flies or not self.robot.n)

    def torques(self, X: FloatArray) -> tuple[TorqueFit, TorqueFit]:
        """Compare the torques of the training and of the validation logs with those of X, (p,)."""
        train = fit(self.evaluator, self.train, X, "train")
        return train, fit(self.evaluator, self.held, X)

    def of_robot(self, robot: Robot, models: Sequence[EquationModel]) -> Campaign:
        """Return the logs with the model of another robot with the same drive."""
        kernels = kernels_of(models)
        evaluator = load_model(robot_toml(robot), kernels)
        long = self.long and replace(self.long, kernels=kernels)
        return replace(self, evaluator=evaluator, file_values=None, answer=Answer(), long=long)

    def changed(self, change: Callable[[FilteredLog], FilteredLog]) -> Campaign:
        """Return the campaign with every log changed."""
        train = tuple(map(change, self.train))
        held = tuple(map(change, self.held))
        return replace(self, train=train, held=held)

    def in_new_band(self) -> Campaign:
        """Return the same logs in a band that is chosen again."""
        train = [log.samples for log in self.train]
        band = self.filtering.band_of(self.evaluator, train, self.long, self.progress)
        return self.in_band(band)

    def in_band(self, band: Band) -> Campaign:
        """Return the same logs in another band."""
        return replace(self, band=band).changed(lambda log: filter_log(log.samples, band))


def open_campaign(
    given: Robot | str | Path | Evaluator,
    robot: Robot,
    logs: Sources,
    models: Sequence[EquationModel],
    reading: Reading | None = None,
    filtering: Filtering = Filtering(),
    progress: Say = silent,
    executor: Executor | None = None,
    *,
    moving: bool = True,
) -> Campaign:
    """Open logs to fit models to them: read, repair and split them, and choose their band.

    Without validation logs, the end of each log is held out.

    Args:
        given: the robot, the path of its file, or a loaded evaluator.
        robot: the robot.
        logs: the training and the validation logs.
        models: models to fit.
        reading: options of reading and masking.
        filtering: how to choose the band.
        progress: called with a text about the current step.
        executor: executor of the work on segments of long logs; None for threads of this process.
        moving: whether every joint has to move in a training log.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot.
        IdentificationError: a joint does not move.
    """
    kernels, long = kernels_of(models), None
    if is_long([*logs[0], *logs[1]]):
        window = max(model.gap for model in models)
        rows = reading or Reading()
        long, groups, repairs = sample_logs(robot, logs, rows, window, progress)
        long = replace(long, kernels=kernels, executor=executor)
    else:
        (train, held), repairs = open_logs(logs, robot, reading, progress)
        held = require_other_data(train, held)
        groups = (train, held) if held else hold_out(train)
        if moving and robot.n:
            require_motion(groups[0], robot)
    progress("deriving and compiling the model")
    evaluator = given if isinstance(given, Evaluator) else None
    if evaluator is None or not all(model.runs_on(evaluator) for model in models):
        evaluator = load_model(robot_toml(robot), kernels)
    opened = groups, repairs
    campaign = in_band(evaluator, given, opened, reading, filtering, progress, long)
    return replace(campaign, has_validation=bool(logs[1]))


def in_band(
    evaluator: Evaluator,
    given: Any,
    opened: tuple[Groups, Sequence[Fault]],
    reading: Reading | None,
    filtering: Filtering,
    progress: Say,
    long: LongLogs | None = None,
) -> Campaign:
    """Check the torques of logs, repair their speeds, choose the band, and filter the logs in it.

    Args:
        evaluator: the compiled model.
        given: path of the robot file, for its masses.
        opened: the training and the validation logs, and their repairs.
        reading, filtering, progress, long: see `open_campaign` and `Campaign`.
    """
    groups, repairs = opened
    file_values = values_of_file(given, evaluator.model)
    groups = in_torque_scale(groups, file_values, evaluator, reading)
    known = filtering.known
    comparison = None if known is None else known.comparison_hz
    (train, held), more = with_mended_speeds(groups, comparison)
    band = filtering.band_of(evaluator, train, long, progress)
    return Campaign(
        evaluator,
        filtering,
        band,
        tuple(filter_log(samples, band) for samples in train),
        tuple(filter_log(samples, band) for samples in held),
        repairs=(*repairs, *more),
        file_values=file_values,
        long=long,
        progress=progress,
    )
