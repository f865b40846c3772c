"""Runs as the files that robots are driven with: ROS 2 JointTrajectory, and URScript.

Both begin with a slow approach: the first point is reached in `Plan.approach` seconds from wherever
the robot is, by the controller's own interpolation (ROS) or by movej (URScript).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from symgen.data.bags import trajectory_bag
from symgen.errors import ParameterError
from symgen.experiment.plan import Plan, paths
from symgen.experiment.trajectory import Trajectory
from symgen.names import REVOLUTE
from symgen.robot.types import Robot

FORMATS = ("csv", "ros", "urscript")
_UR_JOINTS = 6
_UR_STEP = 0.008  # s, of servoj
_UR_APPROACH = 0.1  # rad/s, the leading joint's


def exported(plan: Plan, robot: Robot, into: Path, to: str) -> dict[Path, bytes]:
    """Return the files of a plan in a format, beside its CSV and JSON.

    Args:
        plan: the runs.
        robot: that they are for.
        into: the CSV; the others take its name with another ending.
        to: one of FORMATS: "ros" adds NAME.yaml and NAME.mcap (trajectory_msgs/JointTrajectory),
            "urscript" NAME.script.

    Raises:
        ParameterError: there is no such format, or the robot is none that it drives.
    """
    if to not in FORMATS:
        raise ParameterError(f"--to {to}: accepted: {', '.join(FORMATS)}")
    files = plan.to_files(into)
    names = [joint.name or f"joint{joint.number}" for joint in robot.movable]
    for path, run in zip(paths(into, len(plan.runs))[:-1], plan.runs, strict=True):
        if to == "ros":
            points = _points(run, 1 / plan.rate)
            files[path.with_suffix(".yaml")] = _yaml(names, points, plan.approach)
            files[path.with_suffix(".mcap")] = trajectory_bag(names, points, plan.approach)
        if to == "urscript":
            files[path.with_suffix(".script")] = _urscript(robot, run)
    return files


def _points(run: Trajectory, step: float) -> tuple[np.ndarray, ...]:
    t = run.times(step)
    return (t, *(run.at(t, order) for order in range(3)))


def _yaml(names: Sequence[str], points: Sequence[np.ndarray], approach: float) -> bytes:
    """Return a trajectory_msgs/msg/JointTrajectory, as `ros2 topic pub` takes it."""
    t, *motion = points
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:"]
    lines += [f"- {_quoted(name)}" for name in names] + ["points:"]
    keys = ("positions", "velocities", "accelerations")
    for k, stamp in enumerate(t):
        rows = zip(keys, (x[k] for x in motion), strict=True)
        lines += [
            f"{'-' if i == 0 else ' '} {key}: [{', '.join(f'{v:.12g}' for v in row)}]"
            for i, (key, row) in enumerate(rows)
        ]
        sec, nanosec = divmod(round((stamp + approach) * 1e9), 10**9)
        lines.append(f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}")
    return ("\n".join(lines) + "\n").encode()


def _quoted(name: str) -> str:
    return "'" + name.replace("'", "''") + "'"


def _urscript(robot: Robot, run: Trajectory) -> bytes:
    """Return a program of Universal Robots: movej to the start, then servoj every 8 ms."""
    if robot.n != _UR_JOINTS or any(j.sigma != REVOLUTE for j in robot.movable):
        raise ParameterError(
            f"--to urscript: {robot.name} has {robot.n} movable joints; accepted: a robot with six "
            "revolute ones"
        )
    t = run.times(_UR_STEP)
    step, q = float(t[1] - t[0]), run.at(t)
    lines = [f"def {robot.name}_excite():", f"  movej({_list(q[0])}, a=0.5, v={_UR_APPROACH})"]
    lines.append("  sleep(1.0)")
    lines += [f"  servoj({_list(row)}, 0, 0, {step:.9g}, 0.1, 300)" for row in q]
    lines += ["  stopj(1.0)", "end"]
    return ("\n".join(lines) + "\n").encode()


def _list(row: np.ndarray) -> str:
    return "[" + ", ".join(f"{v:.9f}" for v in row) + "]"
