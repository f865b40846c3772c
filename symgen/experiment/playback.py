"""compare-sim: how far simulated robots are from a log, over horizons.

A window of a log begins in the measured state. MuJoCo moves the robot of a file by the measured
torques, in straight lines between the samples, and the position is compared with the measured one
after 0.2, 0.5 and 1 s. With feedback gains the torque is

    tau(t) + kp (q_m - q) + kd (qd_m - qd)

with q_m and qd_m the measured motion. Contacts, limits and controlled actuators of the file have no
say: what moves the robot is in the log.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from symgen.data.log import Log
from symgen.data.mask import spans
from symgen.data.raw import Reading
from symgen.data.signals import interpolated
from symgen.distributed import Say, silent
from symgen.errors import ParameterError
from symgen.estimation.band import OPEN, Band, comparison_band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.values import FloatArray
from symgen.experiment.mujoco_robot import MujocoRobot
from symgen.faults.logs import open_samples
from symgen.files import load_toml
from symgen.identification.estimate import Joint, joints_of
from symgen.robot.toml_io import read_imported, read_robot
from symgen.robot.types import Robot
from symgen.schemas import BESIDE, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.simulation/1"
MARKER, WINDOW = "simulation.json", "window.csv"
#: After which a position is compared, s.
HORIZONS = (0.2, 0.5, 1.0)
_WINDOWS = 40  # of a log, at most
_SMOOTH = 5.0  # of the comparison band: where the motion of a log is filtered
#: A position error above this multiple of the joint's range of motion counts as having run away,
#: and as this much.
_AWAY = 10.0


@dataclass(frozen=True)
class Horizon:
    """Position error of a simulated robot some time after the measured state.

    Attributes:
        seconds: after the start of a window.
        position_error: RMS over windows and joints of simulated minus measured position, over the
            RMS of the distance that the joints moved. An error counts as ten times the range of
            motion of its joint at most.
        spread: standard deviation of that over the windows.
        per_joint: (n,) RMS over windows, rad or m.
    """

    seconds: float
    position_error: float
    spread: float
    per_joint: tuple[float, ...]


@dataclass(frozen=True)
class Simulated:
    """How far the robot of one file is from the logs.

    Attributes:
        file: its name.
        horizons: by time.
        diverged: windows in which the simulation ran away or had no finite numbers.
    """

    file: str
    horizons: tuple[Horizon, ...]
    diverged: int


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulationComparison(Viewable):
    """How far simulated robots are from logs.

    Attributes:
        robot: its name.
        joints: number and unit of each movable joint.
        logs: their names.
        windows: number of windows that were simulated.
        feedback: whether gains hold the robot to the measured motion.
        files: file by file.
        notes: what was done to the logs.
        measured: of a window of median error of the first file: (K,) s and (K, n) rad or m.
        courses: of that window, simulated positions (K, n) of each file.
    """

    robot: str
    joints: tuple[Joint, ...]
    logs: tuple[str, ...]
    windows: int
    feedback: bool
    files: tuple[Simulated, ...]
    notes: tuple[str, ...]
    measured: Annotated[tuple[FloatArray, FloatArray] | None, BESIDE] = None
    courses: Annotated[tuple[FloatArray, ...], BESIDE] = ()

    def __repr__(self) -> str:
        """Return the files with their errors."""
        told = ", ".join(
            f"{f.file} {100 * f.horizons[-1].position_error:.3g} %" for f in self.files
        )
        return f"<SimulationComparison after {self.files[0].horizons[-1].seconds:g} s: {told}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of simulation.json."""
        return to_json(self, SCHEMA)

    def to_csv(self) -> bytes:
        """Return the window that is drawn, window.csv: t, then q1.. measured and of each file.

        The columns of the first file are file1_q1.., those of the second file2_q1...
        """
        if self.measured is None:
            return b""
        t, q = self.measured
        numbers = range(1, q.shape[1] + 1)
        labels = [f"q{j}" for j in numbers]
        labels += [f"file{k}_q{j}" for k in range(1, len(self.courses) + 1) for j in numbers]
        file, rows = io.StringIO(), np.column_stack([t, q, *self.courses])
        np.savetxt(file, rows, "%.9g", ",", header=",".join(["t", *labels]), comments="")
        return file.getvalue().encode()


def compare_simulations(
    files: Sequence[str | Path],
    logs: Sequence[str | Path | Log],
    *,
    robot: Robot | str | Path | None = None,
    controller: str | Path | None = None,
    reading: Reading | None = None,
    progress: Say = silent,
) -> SimulationComparison:
    """Simulate windows of logs with the robots of some files, and compare the positions.

    Args:
        files: URDF or MJCF files of one robot, with the same names of joints.
        logs: of that robot.
        robot: which joints the logs have; by default the movable joints of the first file. Other
            joints of the files are held where they are at q = 0.
        controller: TOML with [controller] kp and kd, (n,) each: feedback to the measured motion.
        reading: how the logs are read.
        progress: is told what is being done.

    Raises:
        RobotError: MuJoCo is not installed or refuses a file, or a file has not the joints.
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: no log has a window of 0.2 s, or the gains are not those of the robot.
    """
    if not files or not logs:
        raise ParameterError("compare-sim: nothing to compare; accepted: files and logs")
    source = read_imported(files[0]).robot if robot is None else read_robot(robot)
    names = [joint.name for joint in source.movable]
    kp, kd = (np.zeros(source.n),) * 2 if controller is None else _gains(controller, source)
    machines = [MujocoRobot(Path(file), names) for file in files]
    seen, notes = [], list[str]()
    for log in logs:
        progress(f"reading {getattr(log, 'name', log)}")
        samples, repairs = open_samples(log, source, reading)
        rate, comparison = 1 / samples.step, comparison_band([samples])
        cutoff = min(_SMOOTH * comparison, OPEN * rate)
        seen.append(filter_log(samples, Band(rate, cutoff, comparison, "derived")))
        notes += [*samples.notes, *(r.in_words for r in repairs)]
    windows = [(log, k) for log in seen for k in _starts(log)]
    if not windows:
        raise ParameterError(
            f"compare-sim: no log has {HORIZONS[0]:g} s without a gap; accepted: longer logs"
        )
    found, courses = [], []
    for file, machine in zip(files, machines, strict=True):
        progress(f"simulating {file}")
        moved = [_simulated(machine, log, k, kp, kd) for log, k in windows]
        courses.append(moved)
        found.append(_judged(Path(file).name, windows, moved))
    shown = _typical(windows, courses)
    chosen, k = windows[shown]
    last = len(courses[0][shown])
    return SimulationComparison(
        robot=source.name,
        joints=joints_of(source),
        logs=tuple(log.name for log in seen),
        windows=len(windows),
        feedback=controller is not None,
        files=tuple(found),
        notes=tuple(dict.fromkeys(notes)),
        measured=(chosen.t[k : k + last] - chosen.t[k], chosen.q[k : k + last]),
        courses=tuple(moved[shown] for moved in courses),
    )


def read_comparison(path: str | Path) -> SimulationComparison:
    """Read a comparison again, without its curves.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    return read_result(SimulationComparison, file, SCHEMA, measured=None, courses=())


def _gains(path: str | Path, robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Return kp and kd of a TOML file, (n,) each."""
    accepted = f"accepted: [controller] with kp and kd, {robot.n} numbers of 0 or more each"
    try:
        table = load_toml(Path(path).read_text("utf-8-sig"))["controller"]
        kp, kd = (np.array(table[key], dtype=float) for key in ("kp", "kd"))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ParameterError(f"{path}: it holds no gains; {accepted}") from error
    for gain in (kp, kd):
        if gain.shape != (robot.n,) or not (np.isfinite(gain) & (gain >= 0)).all():
            raise ParameterError(f"{path}: the gains are not those of {robot.name}; {accepted}")
    return kp, kd


def _starts(log: FilteredLog) -> list[int]:
    """Return where windows begin: evenly over the log, clear of what is masked."""
    rows = round(HORIZONS[-1] / log.step)
    free = np.ones(len(log.t), dtype=bool) if log.mask is None else ~log.mask.robot
    whole = [(a, b) for a, b in spans(free) if b - a > rows]
    if not whole:
        return []
    every = np.concatenate([np.arange(a, b - rows) for a, b in whole])
    count = min(_WINDOWS, max(1, len(every) // rows))
    return [int(k) for k in every[np.linspace(0, len(every) - 1, count).astype(int)]]


def _simulated(
    machine: MujocoRobot, log: FilteredLog, k: int, kp: FloatArray, kd: FloatArray
) -> FloatArray:
    """Return the positions of a window at its samples, (K, n); NaN where it diverges."""
    rows = slice(k, k + round(HORIZONS[-1] / log.step) + 1)
    t = log.t[rows] - log.t[k]
    given = interpolated(t, np.concatenate([log.tau[rows], log.q[rows], log.qd[rows]], axis=1))
    n = log.q.shape[1]

    def torque(at: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        here = given(np.array([at]))[0]
        pull = kp * (here[n : 2 * n] - q) + kd * (here[2 * n :] - qd)
        return np.asarray(here[:n] + pull)

    return np.asarray(machine.moved(log.q[k], log.qd[k], torque, t))


def _judged(
    file: str, windows: Sequence[tuple[FilteredLog, int]], moved: Sequence[FloatArray]
) -> Simulated:
    """Return the errors of a file over all windows."""
    ranges = np.ptp(np.concatenate([log.q for log, _ in windows]), axis=0)
    far = _AWAY * np.maximum(ranges, 1e-9)
    out, diverged = [], 0
    for seconds in HORIZONS:
        errors, ways = [], []
        for (log, k), q in zip(windows, moved, strict=True):
            at = round(seconds / log.step)
            errors.append(q[at] - log.q[k + at])
            ways.append(log.q[k + at] - log.q[k])
        e, way = np.nan_to_num(np.array(errors), nan=np.inf), np.array(ways)
        diverged = max(diverged, int((np.abs(e) > far).any(axis=1).sum()))
        e = np.clip(e, -far, far)
        size = float(np.sqrt(np.mean(way**2))) or 1.0
        each = np.sqrt(np.mean(e**2, axis=1)) / size
        per_joint = tuple(float(x) for x in np.sqrt(np.mean(e**2, axis=0)))
        out.append(Horizon(seconds, float(np.sqrt(np.mean(each**2))), float(each.std()), per_joint))
    return Simulated(file, tuple(out), diverged)


def _typical(
    windows: Sequence[tuple[FilteredLog, int]], courses: Sequence[Sequence[FloatArray]]
) -> int:
    """Return the window with the median error of the first file."""
    ends = [
        float(np.linalg.norm(np.nan_to_num(q[-1] - log.q[k + len(q) - 1], nan=1e9)))
        for (log, k), q in zip(windows, courses[0], strict=True)
    ]
    return int(np.argsort(ends)[len(ends) // 2])
