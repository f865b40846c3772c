"""compare-sim: the position errors of simulated robots against a log, over several horizons.

MuJoCo moves the robot of a file along windows of a log (`symgen.estimation.playback`). Contacts
and limits are off. The torques of the log move the joints. A log of duty has none: the recorded
reference moves them by the actuators in the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from symgen.data.log import Log
from symgen.data.raw import Reading, csv_bytes
from symgen.data.signals import (
    OPEN,
    comparison_band,
    interpolated,
)
from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.estimation.filtered_log import filter_log
from symgen.estimation.playback import (
    HORIZONS,
    Horizon,
    Window,
    gains_of,
    play,
    position_errors,
    reference_law,
    require_same_times,
    torque_law,
    windows_of,
)
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray
from symgen.experiment.mujoco_robot import MujocoRobot
from symgen.faults.repair import open_samples
from symgen.identification.estimate import JointLabel, joints_of
from symgen.names import ROTOR
from symgen.parallel import Say, silent
from symgen.robot.toml_io import read_imported, read_robot
from symgen.robot.types import Robot
from symgen.schemas import BESIDE, OPTIONAL, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.simulation/1"
MARKER, WINDOW = "simulation.json", "window.csv"
_WINDOWS = 40  # maximum number of windows of a log
_SMOOTH = 5.0  # cutoff of the motion of a log, in comparison bands


@dataclass(frozen=True)
class Simulated:
    """Position errors of the robot of one file.

    Attributes:
        file: name of the file.
        horizons: errors by time.
        diverged: number of windows in which the simulation diverged.
    """

    file: str
    horizons: tuple[Horizon, ...]
    diverged: int


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulationComparison(Viewable):
    """Position errors of simulated robots against logs.

    Attributes:
        robot: name of the robot.
        joints: number and unit of each movable joint.
        logs: names of the logs.
        windows: number of simulated windows.
        feedback: whether feedback gains keep the robot close to the measured motion.
        driven_by: what moves the robot: "torque", or by the actuators "reference".
        files: results, file by file.
        notes: changes to the logs.
        measured: measured motion in a window with a median error of the first file: times (K,) s
            and positions (K, n) rad or m.
        courses: simulated positions (K, n) of each file in that window.
    """

    robot: str
    joints: tuple[JointLabel, ...]
    logs: tuple[str, ...]
    windows: int
    feedback: bool
    files: tuple[Simulated, ...]
    notes: tuple[str, ...]
    measured: Annotated[tuple[FloatArray, FloatArray] | None, BESIDE] = None
    courses: Annotated[tuple[FloatArray, ...], BESIDE] = ()
    driven_by: Annotated[str, OPTIONAL] = "torque"

    def __post_init__(self) -> None:
        require_same_times(*(file.horizons for file in self.files))

    def __repr__(self) -> str:
        """Return the files with their errors."""
        errors = ", ".join(f"{f.file} {percent(f.horizons[-1].position_error)}" for f in self.files)
        return f"<SimulationComparison after {self.files[0].horizons[-1].seconds:g} s: {errors}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of simulation.json."""
        return to_json(self, SCHEMA)

    def to_csv(self) -> bytes:
        """Return the drawn window as window.csv: t, measured q1.., and q1.. of each file.

        The columns of the first file are file1_q1.., those of the second file2_q1...
        """
        if self.measured is None:
            return b""
        t, q = self.measured
        numbers = range(1, q.shape[1] + 1)
        labels = [f"q{j}" for j in numbers]
        labels += [f"file{k}_q{j}" for k in range(1, len(self.courses) + 1) for j in numbers]
        return csv_bytes(["t", *labels], np.column_stack([t, q, *self.courses]))


def compare_simulations(
    files: Sequence[str | Path],
    logs: Sequence[str | Path | Log],
    *,
    robot: Robot | str | Path | None = None,
    reading: Reading | None = None,
    progress: Say = silent,
) -> SimulationComparison:
    """Simulate windows of logs with the robots of some files, and compare the positions.

    Args:
        files: URDF or MJCF files of one robot, with the same joint names.
        logs: logs of that robot.
        robot: the joints of the logs and, for a robot with a controller, the gains of the feedback
            towards the measured motion. By default, the movable joints of the first file. Other
            joints of the files stay at q = 0.
        reading: how the logs are read.
        progress: called with a text about the current step.

    Raises:
        RobotError: MuJoCo is not installed or refuses a file, or a file lacks a joint, or for a
            log of duty an actuator that follows its reference.
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: no log has a window of 0.2 s, or a log of duty lacks the reference.
    """
    if not files or not logs:
        raise ParameterError("compare-sim: nothing to compare; accepted: files and logs")
    source = read_imported(files[0]).robot if robot is None else read_robot(robot)
    names = [joint.name for joint in source.movable]
    machines = [MujocoRobot(Path(file), names) for file in files]
    filtered, notes = [], [*_without_rotors(files), *(x for m in machines for x in m.notes)]
    for log in logs:
        progress(f"reading {getattr(log, 'name', log)}")
        samples, repairs = open_samples(log, source, reading)
        rate, comparison = 1 / samples.step, comparison_band([samples])
        cutoff = min(_SMOOTH * comparison, OPEN * rate)
        filtered.append(filter_log(samples, Band(rate, cutoff, comparison, "derived")))
        notes += [*samples.notes, *(r.in_words for r in repairs)]
    follows = any(log.samples.drive_unit for log in filtered)
    gains = None if follows else gains_of(source)
    law_of = reference_law if follows else partial(torque_law, gains=gains)
    for machine in machines if follows else ():
        machine.follow()
    windows = windows_of(filtered, _WINDOWS)
    if not windows:
        raise ParameterError(
            f"compare-sim: no log has {HORIZONS[0]:g} s without a gap; accepted: longer logs"
        )
    step = min(log.step for log in filtered)
    t = np.asarray(np.arange(round(windows[0].seconds / step) + 1) * step, dtype=np.float64)
    results, courses = [], []
    for file, machine in zip(files, machines, strict=True):
        progress(f"simulating {file}")
        courses.append(play(machine, windows, t, law_of))
        horizons, diverged = position_errors(windows, t, courses[-1])
        results.append(Simulated(Path(file).name, horizons, diverged))
    shown = _typical(windows, courses[0])
    chosen = windows[shown].log
    measured = interpolated(chosen.t, chosen.q)(chosen.t[windows[shown].start] + t)
    return SimulationComparison(
        robot=source.name,
        joints=joints_of(source),
        logs=tuple(log.name for log in filtered),
        windows=len(windows),
        feedback=gains is not None,
        files=tuple(results),
        notes=tuple(dict.fromkeys(notes)),
        measured=(t, measured),
        courses=tuple(moved[shown] for moved in courses),
        driven_by="reference" if follows else "torque",
    )


def _without_rotors(files: Sequence[str | Path]) -> Iterator[str]:
    """Yield a note for each URDF with rotor inertia."""
    for path in map(Path, files):
        values = read_imported(path).parameters if path.suffix.lower() == ".urdf" else ()
        if any(name.startswith(ROTOR) and value for name, value in values):
            yield f"MuJoCo ignores the rotor inertia of {path.name}: compare an MJCF instead"


def read_comparison(path: str | Path) -> SimulationComparison:
    """Read a comparison from its file, without its curves.

    Raises:
        ParameterError: there is no comparison, or it is damaged.
    """
    file = result_file(path, MARKER)
    return read_result(SimulationComparison, file, SCHEMA, measured=None, courses=())


def _typical(windows: Sequence[Window], moved: FloatArray) -> int:
    """Return the window with the median error at its end."""
    ends = np.array([w.log.q[w.rows][-1] for w in windows])
    errors = np.linalg.norm(np.nan_to_num(moved[:, -1] - ends, nan=1e9), axis=1)
    return int(np.argsort(errors)[len(errors) // 2])
