"""Results of `excite`: runs to execute on the robot, and their expected quality."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symgen.errors import ParameterError
from symgen.experiment.bounds import Bounds, LimitUse
from symgen.experiment.reference import as_csv
from symgen.experiment.trajectory import Trajectory
from symgen.files import rendered
from symgen.identification.assessment import CONDITION, WINDOWS
from symgen.identification.estimate import JointLabel
from symgen.names import REVOLUTE
from symgen.robot.types import Robot
from symgen.schemas import as_json
from symgen.views import Viewable

SCHEMA = "symgen.trajectory/1"
_GAIN = 0.95  # of the deviation at the start; a larger result is not optimised


@dataclass(frozen=True, eq=False)
class Plan(Viewable):
    """Runs within the limits, verified on a fine grid.

    Attributes:
        robot: name of the robot.
        model: model to identify with.
        window: length of the windows of energy and momentum, s.
        rate: sampling rate of the references and of the equations, Hz.
        runs: the trajectories.
        conditions: condition number of the scaled base regressor of all runs, by model.
        std: expected standard deviation of each parameter from one log of every run.
        scale: value of each parameter that `std` is compared with.
        start: `deviation` of the best random start of the search.
        uses: the largest use of every limit of every joint.
        parameters: number of base parameters.
        independent: number of independent equations, as `identify` counts them.
        searches: number of finished searches, and number of all searches.
        stopped: how the search ended: "done", "budget" or "interrupted".
        notes: further remarks.
        approach: time to reach the start from anywhere, at a tenth of the allowed speeds, s.
        joints: number, unit of the torque and name of each movable joint.
        bounds: the limits of the motion.
        source: the robot, for its drawing.
    """

    robot: str
    model: str
    window: float
    rate: float
    runs: tuple[Trajectory, ...]
    conditions: dict[str, float]
    std: dict[str, float]
    scale: dict[str, float]
    start: float
    uses: tuple[LimitUse, ...]
    parameters: int
    independent: float
    searches: tuple[int, int]
    stopped: str
    notes: tuple[str, ...] = ()
    approach: float = 10.0
    joints: tuple[JointLabel, ...] = ()
    bounds: Bounds | None = None
    source: Robot | None = None

    def __repr__(self) -> str:
        """Return the robot, the runs, and the expected standard deviation."""
        return (
            f"<Plan of {self.robot}: {len(self.runs)} runs for {self.model}, standard deviation "
            f"{100 * self.deviation:.3g} %>"
        )

    @property
    def condition(self) -> float:
        """Condition number for `model`."""
        return self.conditions[self.model]

    @property
    def relative_std(self) -> dict[str, float]:
        """Expected standard deviation of each parameter over its `scale`, the largest first."""
        shares = {name: std / self.scale[name] for name, std in self.std.items()}
        return dict(sorted(shares.items(), key=lambda item: -item[1]))

    @property
    def deviation(self) -> float:
        """Geometric mean of the relative standard deviations."""
        return geometric_mean(np.array(list(self.relative_std.values())))

    @property
    def optimised(self) -> bool:
        """Whether the search ended by itself, or improved on its best random motion."""
        return self.stopped == "done" or self.deviation < _GAIN * self.start

    @property
    def binding(self) -> tuple[LimitUse, ...]:
        """The limits that are used to 97 % or more: wider ones would help most."""
        return tuple(u for u in self.uses if u.binds)

    @property
    def good(self) -> bool:
        """Whether identify can trust an estimate from such runs."""
        return not self.warnings

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons why `identify` would find the runs insufficient, or a better search possible."""
        out = []
        if not self.optimised:
            out.append(
                "not optimised: the search ended before it gained over a random motion; use a "
                "longer --budget"
            )
        if self.condition > CONDITION:
            limits = binding_text(self.binding) or "no limit binds"
            out.append(
                f"the condition number is {self.condition:.3g}, above the limit of {CONDITION:g} "
                f"({limits}); longer or more runs, or more terms, would help"
            )
        needed = WINDOWS * self.parameters
        if self.independent < needed:
            total = sum(run.duration for run in self.runs) * needed / self.independent
            out.append(
                f"these runs hold {self.independent:.0f} independent equations, and identify "
                f"trusts an estimate from {needed:.0f}: record them several times, or ask for "
                f"{math.ceil(total)} s in all"
            )
        return tuple(out)

    @property
    def other_models(self) -> tuple[str, ...]:
        """A text that lists the other models for which these runs are not good."""
        return tuple(
            f"for the model of {name} these runs are "
            + ("singular" if not math.isfinite(c) else f"poor (condition number {c:.3g})")
            for name, c in self.conditions.items()
            if name != self.model and c > CONDITION
        )

    def to_files(self, into: Path) -> dict[Path, bytes]:
        """Return the sampled references, t, q1.., qd1.., qdd1.., and the plan as JSON."""
        *tables, summary = paths(into, len(self.runs))
        files = {}
        for path, run in zip(tables, self.runs, strict=True):
            t, *motion = _points(run, self.rate)
            files[path] = as_csv(t, dict(zip(("q", "qd", "qdd"), motion, strict=True)))
        content = {
            "schema": SCHEMA,
            "robot": self.robot,
            "model": self.model,
            "window_s": self.window,
            "rate_hz": self.rate,
            "condition_number": self.conditions,
            "expected_std": self.std,
            "scale": self.scale,
            "relative_std": self.deviation,
            "start_relative_std": self.start,
            "limits": [
                {key: getattr(u, key) for key in ("limit", "joint", "allowed", "extreme")}
                | {"margin": 1 - u.share, "binds": u.binds}
                for u in self.uses
            ],
            "independent_equations": self.independent,
            "approach_s": self.approach,
            "searches": self.searches,
            "stopped": self.stopped,
            "warnings": [*self.warnings, *self.other_models],
            "notes": self.notes,
            "files": [path.name for path in tables],
            "runs": [run.to_dict() for run in self.runs],
        }
        return files | {summary: (json.dumps(as_json(content), indent=1) + "\n").encode()}


def geometric_mean(x: np.ndarray) -> float:
    """Return exp(mean(log x))."""
    return float(np.exp(np.mean(np.log(x))))


def paths(into: Path, runs: int) -> tuple[Path, ...]:
    """Return the paths of a plan's files: one CSV for each run, and the JSON."""
    stems = [into.stem] if runs == 1 else [f"{into.stem}_{k}" for k in range(1, runs + 1)]
    return (*(into.with_name(f"{stem}.csv") for stem in stems), into.with_suffix(".json"))


def binding_text(uses: tuple[LimitUse, ...]) -> str:
    """Return a text about the limits that bind: "velocity of joints 1, 2 binds"."""
    keys = dict.fromkeys(u.limit for u in uses)
    parts = []
    for key in keys:
        joints = [str(u.joint) for u in uses if u.limit == key]
        parts.append(f"{key} of joint{'s' if len(joints) > 1 else ''} {', '.join(joints)}")
    return f"{'; '.join(parts)} bind{'s' if len(uses) == 1 else ''}" if parts else ""


FORMATS = ("csv", "ros", "urscript")
_UR_JOINTS = 6
_UR_STEP = 0.008  # s, of servoj


def exported(plan: Plan, robot: Robot, into: Path, to: str) -> dict[Path, bytes]:
    """Return additional files of a plan, in another format than CSV and JSON.

    Args:
        plan: the runs.
        robot: robot of the runs.
        into: path of the CSV; the other files have this name with another ending.
        to: one of FORMATS: "ros" adds NAME.yaml (trajectory_msgs/JointTrajectory),
            "urscript" NAME.script.

    Raises:
        ParameterError: the format does not support the robot.
    """
    files = plan.to_files(into)
    names = [joint.name or f"joint{joint.number}" for joint in robot.movable]
    for path, run in zip(paths(into, len(plan.runs))[:-1], plan.runs, strict=True):
        if to == "ros":
            points = _points(run, plan.rate)
            files[path.with_suffix(".yaml")] = _yaml(names, points, plan.approach)
        if to == "urscript":
            files[path.with_suffix(".script")] = _urscript(robot, run)
    return files


def _points(run: Trajectory, rate: float) -> tuple[np.ndarray, ...]:
    t = run.times(1 / rate)
    return (t, *(run.at(t, order) for order in range(3)))


def _yaml(names: Sequence[str], points: Sequence[np.ndarray], approach: float) -> bytes:
    """Return a trajectory_msgs/msg/JointTrajectory for `ros2 topic pub`, as JSON, which is YAML."""
    t, *motion = points
    stamps = [round((stamp + approach) * 1e9) for stamp in t]
    rows = zip(stamps, *motion, strict=True)
    return rendered("text/trajectory.yaml", names=json.dumps(list(names)), points=rows).encode()


def _urscript(robot: Robot, run: Trajectory) -> bytes:
    """Return a program of Universal Robots: movej to the start, then servoj every 8 ms."""
    if robot.n != _UR_JOINTS or any(j.sigma != REVOLUTE for j in robot.movable):
        raise ParameterError(
            f"--to urscript: {robot.name} has {robot.n} movable joints; accepted: a robot with six "
            "revolute ones"
        )
    t = run.times(_UR_STEP)
    step, q = float(t[1] - t[0]), run.at(t)
    return rendered("text/urscript.txt", robot=robot.name, step=step, q=q).encode()
