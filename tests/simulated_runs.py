"""What symgen says of a run of oracles/clean_runs.py, and what is true of it."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from oracles import clean_runs, engineer

import symgen

KERNELS = ("torque_regressor", "momentum_regressor")


@cache
def evaluator(robot_toml: str) -> Any:
    """The kernels of a robot."""
    return symgen.load(symgen.derive(symgen.parse_robot(robot_toml, "run"), KERNELS))


def identified(run: clean_runs.Run, **options: Any) -> dict[str, Any]:
    """The estimate that a user gets from the run's files, as JSON has it."""
    with tempfile.TemporaryDirectory() as folder:
        robot = Path(folder) / "robot.toml"
        robot.write_text(run.robot_toml, "utf-8")
        train = run.train.save(Path(folder) / "train.npz")
        validation = run.validation.save(Path(folder) / "validation.npz")
        return symgen.identify(robot, [train], validation=[validation], **options).to_json()


class Truth:
    """Errors on the clean motion, below a frequency in Hz."""

    def __init__(self, run: clean_runs.Run, comparison: float) -> None:
        kernel, motion, rate = evaluator(run.robot_toml), run.clean, clean_runs.CLEAN_RATE
        W = np.asarray(kernel["torque_regressor"](motion.q, motion.qd, motion.qdd))
        self.W = engineer.lowpass(W.reshape(len(W), -1), rate, comparison).reshape(W.shape)
        self.y = engineer.lowpass(run.torque, rate, comparison)

    def error(self, X: np.ndarray) -> float:
        """||tau - model|| / ||tau|| over all joints."""
        return engineer.residual(self.W, self.y, X)[1]
