"""The actuators of an exported MJCF, from identified drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn

from symgen.errors import ParameterError
from symgen.identification.estimate import Estimate
from symgen.robot.formats.mjcf_drives import JointDrive
from symgen.robot.types import Robot


def joint_drives(
    estimate: Estimate, robot: Robot, values: Mapping[str, float], kind: str | None
) -> dict[int, JointDrive]:
    """Return the drives of joints by their numbers; none for an estimate from torques.

        tau = a clip(u, -limit, limit) - FV qd

    A "position" has u = kp (ctrl - q) - kd qd, a "motor" u = ctrl, and a "dcmotor" u = ctrl/supply.
    FV, viscous friction and back-EMF together, is in the dcmotor, else in the joint.

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
    servo, about = robot.controller, robot.drive
    if not found:
        if kind is not None:
            _refuse(kind, "an estimate from logs of duty, or of volts with supply in [drive]")
        return {}
    if kind is None:
        kind = "motor" if servo is None or servo.unit != "duty" else "position"
    joints = [drive.joint for drive in found]
    torques = [drive.torque for drive in found]
    limits = (about and about.limit) or (1.0,) * robot.n
    if kind == "position":
        if servo is None or servo.unit != "duty":
            _refuse(kind, '[controller] with kp, kd and unit = "duty" in the robot file')
        made = map(_position, torques, limits, servo.kp, servo.kd)
    elif kind == "dcmotor":
        if about is None or about.supply is None:
            _refuse(kind, "supply in [drive] of the robot file, V")
        viscous = [values.get(f"FV{joint}", 0.0) for joint in joints]
        made = map(_dcmotor, torques, limits, about.supply, viscous)
    else:
        made = map(_motor, torques, limits)
    return dict(zip(joints, made, strict=True))


def _position(a: float, limit: float, kp: float, kd: float) -> JointDrive:
    gain, damping, force = a * kp, a * kd, a * limit
    gains = {"kp": repr(gain), "kv": repr(damping), "gear": "1"}
    limits = {"forcelimited": "true", "forcerange": f"{-force!r} {force!r}"}
    return JointDrive("position", gain, damping, {**gains, **limits})


def _motor(a: float, limit: float) -> JointDrive:
    attributes = {"gear": repr(a), "forcelimited": "false", **_control(limit)}
    return JointDrive("motor", a, 0.0, attributes, limit)


def _dcmotor(a: float, limit: float, supply: float, viscous: float) -> JointDrive:
    """Return K/R (ctrl - K qd), with K = V FV/a and R = K V/a."""
    if viscous <= 0:
        _refuse("dcmotor", "joints with viscous friction above 0")
    constant = supply * viscous / a
    resistance = constant * supply / a
    motor = {"motorconst": repr(constant), "resistance": repr(resistance), "gear": "1"}
    reach = supply * limit
    return JointDrive("dcmotor", a / supply, viscous, {**motor, **_control(reach)}, reach)


def _control(limit: float) -> dict[str, str]:
    """Return the attributes of the limits of a control."""
    return {"ctrllimited": "true", "ctrlrange": f"{-limit!r} {limit!r}"}


def _refuse(kind: str, accepted: str) -> NoReturn:
    raise ParameterError(f"--actuator {kind} is not possible; accepted: {accepted}")
