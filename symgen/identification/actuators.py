"""The actuators of an exported MJCF, from identified drives."""

from __future__ import annotations

import math
from collections.abc import Mapping

from symgen.errors import ParameterError
from symgen.identification.estimate import Estimate
from symgen.robot.formats.mjcf_drives import JointDrive
from symgen.robot.types import Robot

_BOTH = "<!-- motorconst holds the viscous friction of the joint, too -->"
_NEEDS = {
    "position": '[controller] with kp, kd and unit = "duty" in the robot file',
    "motor": "an estimate from logs of duty, or of volts with supply in [drive]",
    "dcmotor": "supply in [drive] of the robot file, V, and joints with viscous friction above 0",
}


def joint_drives(
    estimate: Estimate, robot: Robot, values: Mapping[str, float], kind: str | None
) -> dict[int, JointDrive]:
    """Return the drives of joints by their numbers; none for an estimate from torques.

        tau = a clip(u, -limit, limit) - FV qd

    A "position" has u = kp (ctrl - q) - kd qd, a "motor" u = ctrl, and a "dcmotor" u = ctrl/supply
    with K/R (ctrl - K qd), K = V b/a and R = K V/a. Its back-EMF b is FV, viscous friction and
    back-EMF together, unless logs with open windings told them apart.

    Args:
        estimate: the estimate.
        robot: its robot, with [controller] and [drive].
        values: standard parameters by name.
        kind: kind of the actuators; by default "position" for a robot whose controller commands
            duty, else "motor".

    Raises:
        ParameterError: there are no drives, or what this kind of actuator needs is unknown.
    """
    found = [drive for drive in estimate.drives if drive.unit.endswith("per duty")]
    if not found and kind is not None:
        raise ParameterError(f"--actuator is not possible; accepted: {_NEEDS['motor']}")
    servo, about = robot.controller, robot.drive
    gains = servo if servo is not None and servo.unit == "duty" else None
    if kind is None:
        kind = "motor" if gains is None else "position"
    limits = (about and about.limit) or (1.0,) * robot.n
    supply = about and about.supply
    out = {}
    for j, drive in enumerate(found):
        a, limit = drive.torque, limits[j]
        viscous, held, comment = values.get(f"FV{drive.joint}", 0.0), 0.0, ""
        if kind == "motor":
            numbers = {"gear": a, "ctrlrange": limit}
        elif kind == "position" and gains:
            gain, damping = a * gains.kp[j], a * gains.kd[j]
            numbers = {"kp": gain, "kv": damping, "forcerange": a * limit}
        elif kind == "dcmotor" and supply and viscous > 0:
            separated = math.isfinite(drive.back_emf)
            held = drive.back_emf if separated else viscous
            comment = "" if separated else _BOTH
            constant = supply[j] * held / a
            resistance = constant * supply[j] / a
            reach = supply[j] * limit
            numbers = {"motorconst": constant, "resistance": resistance, "ctrlrange": reach}
        else:
            raise ParameterError(f"--actuator {kind} is not possible; accepted: {_NEEDS[kind]}")
        out[drive.joint] = JointDrive(kind, numbers, a * limit, held, comment)
    return out
