"""Long logs: their stretches without gaps, and a sample of them in memory."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.long_logs import Stretch, read_rows, stretches
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.errors import LogError, first_of
from symgen.estimation.opening import LATE, Groups, Sources, first_held_out
from symgen.faults.fault import Fault
from symgen.faults.repair import open_samples
from symgen.parallel import Say, thread_count
from symgen.robot.types import Robot

#: Samples of all training logs and of all validation logs that are read into memory, in so many
#: pieces.
SAMPLE, HELD_SAMPLE, PIECES = 80_000, 20_000, 4
KINDS = ("train", "validation")
#: Smallest length of a log, in windows and in samples.
_WINDOWS, _FEWEST = 2.0, 20


@dataclass(frozen=True, eq=False)
class LongLogs:
    """The address of long logs on the disk.

    Attributes:
        stretches: all logs.
        reading: options of reading rows.
        count: number of samples in memory.
        notes: notes on stretches that are not used.
        kernels: kernels of the model, for other processes.
        executor: executor of the work on segments; None for threads of this process.
    """

    stretches: Sequence[Stretch]
    reading: Reading
    count: int
    notes: tuple[str, ...]
    kernels: tuple[str, ...] = ()
    executor: Executor | None = None

    @property
    def threads(self) -> int:
        """Number of threads of this process to use."""
        return thread_count() if self.executor is None else 1

    def in_words(self, what: str) -> tuple[str, ...]:
        """Return the notes, with one on the use of the sample if it leaves out any samples.

        Args:
            what: text between the numbers of all samples and of those in the sample.
        """
        total = sum(s.count for s in self.stretches)
        if self.count == total:
            return self.notes
        return (*self.notes, f"{total:,} samples were {what} {self.count:,} of them")


def sample_logs(
    robot: Robot, logs: Sources, reading: Reading, window: float, progress: Say
) -> tuple[LongLogs, Groups, list[Fault]]:
    """Find the stretches of long logs without gaps, and open a sample of them.

    Args:
        robot: the robot of the logs.
        logs: files or URLs; without validation logs, the last fifth of every stretch is held out.
        reading: options of reading files.
        window: window of the equations, s.
        progress: called with a text about the current step.

    Returns:
        The long logs, the opened pieces of training and validation logs, and their repairs.

    Raises:
        LogError: symgen cannot read a file, a file stands twice in the lists, or the stretches are
            too short.
    """
    every = [str(source) for group in logs for source in group]
    twice = [name for name in every if every.count(name) > 1]
    if twice:
        raise LogError(f"{twice[0]}: is given twice; accepted: each file once")
    progress(f"finding the stretches of {len(every)} files")
    parts, notes = _stretches(robot, logs, reading, window)
    plain = replace(reading, start=None, until=None)
    repairs: list[Fault] = []

    def opened(kind: str, budget: int) -> list[Samples]:
        progress(f"looking at {kind} samples")
        group = []
        for s, rows in sampled_rows([s for s in parts if s.kind == kind], budget):
            name, clock = s.name, (s.times[0], s.step)
            if rows != s.rows:
                start, _ = s.between(*rows).times
                name += f" from {start:.0f} s"
            log = read_rows(s, rows, robot, plain, name)
            samples, done = open_samples(log, robot, plain, clock=clock)
            repairs.extend(done)
            group.append(replace(samples, piece=rows != s.rows))
        return group

    groups = opened(KINDS[0], SAMPLE), opened(KINDS[1], HELD_SAMPLE)
    count = sum(len(s.t) for group in groups for s in group)
    return LongLogs(parts, plain, count, notes), groups, repairs


def _stretches(
    robot: Robot, logs: Sources, reading: Reading, window: float
) -> tuple[list[Stretch], tuple[str, ...]]:
    """Return the stretches of long logs that are long enough, and a note on the others."""
    parts, short = list[Stretch](), list[str]()
    for kind, group in zip(KINDS, logs, strict=True):
        for s in (s for name in group for s in stretches(str(name), robot, reading)):
            new = [replace(s, kind=kind)] if logs[1] else _split(s)
            if all(x.count >= _FEWEST and x.times[1] - x.times[0] > _WINDOWS * window for x in new):
                parts += new
            else:
                short.append(s.name)
    listed = first_of(short, 3)
    for kind in KINDS:
        if not any(s.kind == kind for s in parts):
            raise LogError(f"{listed}: too short a {kind} log; accepted: longer ones, without gaps")
    note = f"{len(short)} stretches are too short and left out: {listed}"
    return parts, (note,) if short else ()


def _split(s: Stretch) -> list[Stretch]:
    """Hold out the last fifth of a stretch."""
    edge = s.rows[0] + first_held_out(s.count)
    late = s.between(edge, s.rows[1])
    late = replace(late, name=f"{s.name}{LATE}", kind=KINDS[1])
    return [s.between(s.rows[0], edge), late]


def sampled_rows(logs: Sequence[Stretch], budget: int) -> list[tuple[Stretch, tuple[int, int]]]:
    """Return the rows of logs to read into memory: all, or evenly spaced pieces."""
    if sum(s.count for s in logs) <= budget:
        return [(s, s.rows) for s in logs]
    pieces, length = [], budget // PIECES
    for s in logs:
        first, last = s.rows
        begins = range(first, max(last - length, first) + 1, length)
        pieces += [(s, (k, min(k + length, last))) for k in begins]
    count = min(PIECES, len(pieces))
    chosen = np.linspace(0, len(pieces) - 1, count).astype(int)
    return [pieces[k] for k in chosen]
