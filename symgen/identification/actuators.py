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
    in_duty = servo is not None and servo.unit == "duty"
    chosen = kind or ("position" if in_duty else "motor")
    supply = None if about is None else about.supply
    if not found:
        if kind is not None:
            _refuse(kind, "an estimate from logs of duty, or of volts with supply in [drive]")
        return {}
    if chosen == "position" and not in_duty:
        _refuse(chosen, '[controller] with kp, kd and unit = "duty" in the robot file')
    if chosen == "dcmotor" and supply is None:
        _refuse(chosen, "supply in [drive] of the robot file, V")
    limits = (about and about.limit) or (1.0,) * robot.n
    out = {}
    for j, (drive, limit) in enumerate(zip(found, limits, strict=True)):
        a = drive.torque
        if chosen == "position" and servo is not None:
            out[drive.joint] = _position(a, limit, servo.kp[j], servo.kd[j])
        elif chosen == "dcmotor" and supply is not None:
            out[drive.joint] = _dcmotor(a, limit, supply[j], values.get(f"FV{drive.joint}", 0.0))
        else:
            attributes = {"gear": repr(a), "forcelimited": "false", **_control(limit)}
            out[drive.joint] = JointDrive("motor", a, 0.0, attributes, limit)
    return out


def _position(a: float, limit: float, kp: float, kd: float) -> JointDrive:
    gains = {"kp": repr(a * kp), "kv": repr(a * kd), "gear": "1"}
    force = {"forcelimited": "true", "forcerange": f"{-a * limit!r} {a * limit!r}"}
    return JointDrive("position", a * kp, a * kd, {**gains, **force})


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
