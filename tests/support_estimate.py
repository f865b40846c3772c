"""Results of identifications that found a given X."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import symgen
from symgen.estimation.values import Residual
from symgen.identification.estimate import Estimate, JointLabel, ParameterEstimate


def write_estimate(folder: Path, model: symgen.Model, X: np.ndarray, std: float = 0.01) -> Path:
    """Write robot.toml and the estimate.json that `identify` would write."""
    folder.mkdir()
    (folder / "robot.toml").write_text(symgen.robot_toml(model.robot))
    parameters = tuple(
        ParameterEstimate(p.name, p.expression, float(x), std * max(abs(float(x)), 0.01), p.unit)
        for p, x in zip(model.base.parameters, X, strict=True)
    )
    fit = Residual(0.02)
    joints = tuple(JointLabel(j.number, "N m") for j in model.robot.movable)
    estimate = Estimate(
        robot=model.robot.name, joints=joints, model="momentum", method="wls",
        parameters=parameters, condition_number=3.0, train=fit, validation=fit, cutoff_hz=8.0,
        window_s=0.2, verdict="trusted", reasons=(), correlation=np.eye(len(X)),
    )  # fmt: skip
    (folder / "estimate.json").write_text(json.dumps(estimate.to_json()))
    return folder
