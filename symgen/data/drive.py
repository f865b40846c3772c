"""Convert logs between the motor side and the joint side of gears.

With the gear ratios N, torque constants K and gains g of [drive]:

    q_motor = N q_joint        tau_joint = g N' tau_motor        tau_motor = K i

The gains g come from a calibration of the drives; the default is 1. For g = 1, both sides have the
same power: qd_motor' tau_motor = qd_joint' tau_joint (Siciliano et al., Robotics, 2009, sec. 5.1).
Friction and rotor inertia then act at the joint: IA = N^2 times the inertia of the rotor. Motor
positions are zero where the joint positions are zero.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from symgen.data.mask import rms
from symgen.data.raw import FloatArray, Log, read_only, refuse

if TYPE_CHECKING:
    from symgen.robot.tables import Drive, Servo


def joint_side(log: Log, drive: Drive | None) -> Log:
    """Convert a recorded log to the joint side.

    q and qd are converted if `drive.position_side` is "motor", tau if `drive.torque_side` is.
    Currents are always motor currents. If the log has currents and the drive has torque constants,
    the currents give tau, and a recorded tau is only compared with them. Duty gives tau in the unit
    `drive_unit`. The notes of the log describe the conversion. A converted log is returned
    unchanged.

    Args:
        log: the recorded log.
        drive: gears and motors of the robot; None if both sides are the same.

    Raises:
        LogError: the number of joints differs, or there is duty of motors that move several joints.
    """
    if log.mapped or (drive is None and log.duty is None):
        return log
    if drive is None:
        return replace(_of_duty(log, None), mapped=True)
    n = len(drive.ratio)
    if log.q.shape[1] != n:
        refuse(f"the log has {log.q.shape[1]} joints, the robot has {n}", "the same")
    N = np.array(drive.ratio)
    geared = not np.array_equal(N, np.eye(n))
    if geared and drive.position_side == "motor":
        log = _positions_of_joints(log, N)
    if log.duty is not None:
        log = _of_duty(log, drive)
    elif log.current is not None and drive.torque_constant is not None:
        log = _of_currents(log, drive)
    elif log.tau is not None and geared and drive.torque_side == "motor":
        note = "tau was mapped from the motor side to the joint side"
        log = _with_input(log, log.tau @ N, note)
    if log.tau is not None and drive.gain is not None:
        note = "torques were multiplied by the gains of [drive]"
        log = replace(_with_input(log, log.tau * drive.gain, note), drive_unit="")
    missing = log.missing
    if missing is not None and not _one_each(N):
        coupled = np.any([N, N.T, np.linalg.inv(N)], axis=0)
        missing = np.einsum("njk,ji->nik", missing, coupled) > 0
    return replace(log, mapped=True, missing=missing)


def _positions_of_joints(log: Log, N: FloatArray) -> Log:
    """Map the positions and speeds of motors to the joints."""
    changed: dict[str, Any] = {}
    for key in ("q", "qd", "qr", "qdr"):
        x = getattr(log, key)
        if x is not None:
            changed[key] = read_only(np.linalg.solve(N, x.T).T)
    spans = np.ptp(changed["q"], axis=0)
    travelled = ", ".join(f"q{j} {span:.3g}" for j, span in enumerate(spans, 1))
    note = (
        f"{log.name}: {'q' if log.qd is None else 'q and qd'} were mapped from the motor side to "
        f"the joint side by the ratios of [drive]; the joints travel {travelled}"
    )
    return replace(log, notes=(*log.notes, note), **changed)


def _one_each(N: FloatArray) -> bool:
    """Return whether each motor moves only its joint."""
    return np.array_equal(N, np.diag(np.diag(N)))


# The channels that give tau.


def _with_input(log: Log, tau: FloatArray, *notes: str) -> Log:
    lines = (f"{log.name}: {note}" for note in notes)
    return replace(log, tau=read_only(tau), notes=(*log.notes, *lines))


def _of_currents(log: Log, drive: Drive) -> Log:
    N = np.array(drive.ratio)
    tau = (log.current * np.array(drive.torque_constant)) @ N
    unused = ""
    if log.tau is not None:
        recorded = log.tau @ N if drive.torque_side == "motor" else log.tau
        unused = f"; the recorded tau {_difference(recorded, tau)} and is not used"
    note = "tau is that of the motor currents i1.. by the torque constants and ratios of [drive]"
    return _with_input(log, tau, f"{note}{unused}")


def _of_duty(log: Log, drive: Drive | None) -> Log:
    """Give a log with duty, or voltages of the drives, the input that acts on the joints as tau."""
    assert log.duty is not None
    u, notes = log.duty, list[str]()
    log = replace(log, drive_unit=log.drive_unit or "duty")
    if log.drive_unit == "V" and drive is not None and drive.supply is not None:
        u = u / np.array(drive.supply)
        log = replace(log, supply=None, drive_unit="duty")
        notes.append("u1.. in V was divided by the supply of [drive]")
    if log.drive_unit == "duty":
        u = _available(log, u, drive)
        if log.supply is not None:
            notes.append("u1.. was multiplied by the recorded supply over that of [drive]")
    if drive is not None and drive.torque_side == "motor":
        N = np.array(drive.ratio)
        if not _one_each(N):
            what = "has the duty of motors that move several joints"
            refuse(what, "tau1.. or i1..; or duty of the joints and torque_side = 'joint'")
        u = u * np.sign(np.diag(N))
    log = _with_input(log, held(log.t, u), *notes)
    return replace(log, duty=read_only(u))


def held(t: FloatArray, u: FloatArray) -> FloatArray:
    """Return the input that acts at the stamps if a drive holds each value until the next stamp.

        v[k] = u[k] + (u[k+1] - 2 u[k] + u[k-1]) / 24,  half a step later

    It is the mean of a smooth u over a step.

    Args:
        t: (N,) stamps, s.
        u: (N, n) values from their stamps on.
    """
    from scipy.interpolate import CubicSpline

    mean = u.copy()
    mean[1:-1] += np.diff(u, 2, axis=0) / 24
    earlier = t - 0.5 * np.median(np.diff(t))
    at = np.maximum(earlier, t[0])
    return np.asarray(CubicSpline(t, mean)(at))


def _available(log: Log, u: FloatArray, drive: Drive | None) -> FloatArray:
    """Return duty (N, n) within its limits, scaled by the recorded supply over the nominal one.

    Raises:
        LogError: the nominal supply is unknown.
    """
    limit = np.array((drive and drive.limit) or 1.0)
    u = np.clip(u, -limit, limit)
    if log.supply is None:
        return u
    if drive is None or drive.supply is None:
        refuse("has duty and the voltage of its supply", "supply in [drive], the nominal one, V")
    return u * log.supply / drive.supply


def torque_of_command(servo: Servo, drive: Drive | None) -> FloatArray:
    """Return the torque of a unit of the controller's command, (n,): N m/A for currents, else 1.

    Raises:
        LogError: currents without torque constants, or of motors that move several joints.
    """
    if servo.unit != "A":
        return np.ones(len(servo.kp))
    if drive is None or drive.torque_constant is None or not _one_each(np.array(drive.ratio)):
        what = "[controller] of the robot file commands currents, whose torque is unknown"
        refuse(what, "torque_constant in [drive], of motors that move one joint each")
    per_ampere = np.diag(drive.ratio) * np.array(drive.torque_constant)
    return np.asarray(per_ampere * np.array(drive.gain or 1.0))


def with_servo_torques(log: Log, servo: Servo | None, drive: Drive | None = None) -> Log:
    """Add the torques of the controller, or its duty, to a log without torques.

        tau = kp (qr - q) + kd (qdr - qd)

    Missing speeds are the derivatives of the splines through the positions. A log with torques or
    currents, or without a reference, is returned unchanged. A controller of duty holds the
    reference until the next sample, and its duty stays within the limits of the drives.

    Args:
        log: the log on the joint side.
        servo: gains of the controller.
        drive: gears and motors of the robot.

    Raises:
        LogError: the log has a reference, no torques, and the gains are unknown.
    """
    if log.tau is not None or log.current is not None or log.qr is None:
        return log
    if np.isnan(log.qr).any():
        refuse("the reference qr1.. is not that of all joints", "qr of each joint, or tau1..")
    if servo is None:
        refuse(
            "has a reference and no torques, and the gains of its controller are unknown. They "
            "scale all torques, and with them all parameters: no such log determines them",
            "[controller] with kp and kd in robot.toml, which symgen import writes from other "
            'files; unit = "duty" for servos; scale = "unknown" where only ratios are known',
        )
    factor = torque_of_command(servo, drive)
    kp = factor * servo.kp
    kd = factor * servo.kd

    def speed(x: FloatArray, measured: FloatArray | None) -> FloatArray:
        from scipy.interpolate import CubicSpline

        return CubicSpline(log.t, x)(log.t, 1) if measured is None else measured

    command = kp * log.qr + kd * speed(log.qr, log.qdr)
    feedback = kp * log.q + kd * speed(log.q, log.qd)
    note = f"tau is that of the gains of [controller] in {servo.unit}, kp (qr - q) + kd (qdr - qd)"
    if servo.unit == "duty":
        command = held(log.t, command)
        log = replace(log, drive_unit="duty")
        tau = _available(log, command - feedback, drive)
    else:
        tau = command - feedback
    return replace(_with_input(log, tau, note), command=read_only(command))


def motor_side(log: Log, drive: Drive) -> Log:
    """Convert a log on the joint side to the log that the sensors would record.

    The inverse of `joint_side`. If the drive has torque constants, currents replace torques.

    Args:
        log: log on the joint side, with tau.
        drive: gears and motors of the robot.
    """
    assert log.tau is not None
    N, tau = np.array(drive.ratio), log.tau
    if drive.position_side == "motor":
        qd = None if log.qd is None else read_only(log.qd @ N.T)
        log = replace(log, q=read_only(log.q @ N.T), qd=qd)
    if drive.gain is not None:
        tau = tau / drive.gain
    if drive.torque_constant is not None or drive.torque_side == "motor":
        tau = np.linalg.solve(N.T, tau.T).T
    if drive.torque_constant is not None:
        current = read_only(tau / drive.torque_constant)
        return replace(log, tau=None, current=current, mapped=False)
    return replace(log, tau=read_only(tau), current=None, mapped=False)


def _difference(logged: FloatArray, tau: FloatArray) -> str:
    """Describe the RMS difference of two torques (N, n) on the joint with the largest one."""
    size = rms(tau)
    size = np.where(size > 0, size, np.inf)
    shares = 100 * rms(logged - tau) / size
    j = int(np.argmax(shares))
    text = f"{shares[j]:.3g}" if shares[j] < 100 else f"{shares[j]:.0f}"
    return f"differs from it by up to {text} % (joint {j + 1})"
