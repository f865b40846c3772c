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
    the currents give tau, and a recorded tau is only compared with them. The notes of the log
    describe the conversion. A converted log is returned unchanged.

    Args:
        log: the recorded log.
        drive: gears and motors of the robot; None if both sides are the same.

    Raises:
        LogError: the number of joints differs, or there are currents without torque constants.
    """
    if drive is None or log.mapped:
        return log
    n = len(drive.ratio)
    if log.q.shape[1] != n:
        refuse(f"the log has {log.q.shape[1]} joints, the robot has {n}", "the same")
    N = np.array(drive.ratio)
    changed: dict[str, Any] = {}
    notes = []
    geared = not np.array_equal(N, np.eye(n))
    if geared and drive.position_side == "motor":
        for key in ("q", "qd", "qr", "qdr"):
            x = getattr(log, key)
            if x is not None:
                changed[key] = read_only(np.linalg.solve(N, x.T).T)
        spans = np.ptp(changed["q"], axis=0)
        travelled = ", ".join(f"q{j} {span:.3g}" for j, span in enumerate(spans, 1))
        notes.append(
            f"{'q' if log.qd is None else 'q and qd'} were mapped from the motor side to the joint "
            f"side by the ratios of [drive]; the joints travel {travelled}"
        )
    tau = log.tau
    if tau is not None and drive.torque_side == "motor":
        tau = tau @ N
    if log.current is not None and drive.torque_constant is not None:
        recorded, tau = tau, (log.current * drive.torque_constant) @ N
        unused = ""
        if recorded is not None:
            unused = f"; the recorded tau {_difference(recorded, tau)} and is not used"
        notes.append(
            "tau is that of the motor currents i1.. by the torque constants and ratios of "
            f"[drive]{unused}"
        )
    elif tau is None and log.qr is None:
        refuse("has currents alone", "torque_constant in [drive] of the robot file")
    elif tau is not None and geared and drive.torque_side == "motor":
        notes.append("tau was mapped from the motor side to the joint side")
    if tau is not None and drive.gain is not None:
        tau = tau * drive.gain
        notes.append("torques were multiplied by the gains of [drive]")
    if tau is not None:
        changed["tau"] = read_only(tau)
    missing = log.missing
    if missing is not None and not np.array_equal(N, np.diag(np.diag(N))):
        coupled = np.any([N, N.T, np.linalg.inv(N)], axis=0)
        missing = np.einsum("njk,ji->nik", missing, coupled) > 0
    lines = (f"{log.name}: {note}" for note in notes)
    mapped = replace(log, notes=(*log.notes, *lines), mapped=True, missing=missing)
    return replace(mapped, **changed)


def with_servo_torques(log: Log, servo: Servo | None) -> Log:
    """Add the torques of the controller to a log without torques.

        tau = kp (qr - q) + kd (qdr - qd)

    Missing speeds are the derivatives of the splines through the positions. A log with torques or
    currents, or without a reference, is returned unchanged.

    Args:
        log: the log on the joint side.
        servo: gains of the controller.

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
            "[controller] with kp and kd in the robot file; where only their "
            'ratios are known, with scale = "unknown"',
        )
    kp = np.array(servo.kp)
    kd = np.array(servo.kd)

    def speed(x: FloatArray, measured: FloatArray | None) -> FloatArray:
        from scipy.interpolate import CubicSpline

        return CubicSpline(log.t, x)(log.t, 1) if measured is None else measured

    command = kp * log.qr + kd * speed(log.qr, log.qdr)
    tau = command - kp * log.q - kd * speed(log.q, log.qd)
    note = f"{log.name}: tau is that of the gains of [controller], kp (qr - q) + kd (qdr - qd)"
    notes = (*log.notes, note)
    return replace(log, tau=read_only(tau), command=read_only(command), notes=notes)


def motor_side(log: Log, drive: Drive) -> Log:
    """Convert a log on the joint side to the log that the sensors would record.

    The inverse of `joint_side`. If the drive has torque constants, currents replace torques.

    Args:
        log: log on the joint side, with tau.
        drive: gears and motors of the robot.
    """
    N, tau = np.array(drive.ratio), log.tau
    if drive.position_side == "motor":
        qd = None if log.qd is None else read_only(log.qd @ N.T)
        log = replace(log, q=read_only(log.q @ N.T), qd=qd)
    if tau is not None and drive.gain is not None:
        tau = tau / drive.gain
    if tau is not None and (drive.torque_constant is not None or drive.torque_side == "motor"):
        tau = np.linalg.solve(N.T, tau.T).T
    if tau is not None and drive.torque_constant is not None:
        current = read_only(tau / drive.torque_constant)
        return replace(log, tau=None, current=current, mapped=False)
    tau = None if tau is None else read_only(tau)
    return replace(log, tau=tau, current=None, mapped=False)


def _difference(logged: FloatArray, tau: FloatArray) -> str:
    """Describe the RMS difference of two torques (N, n) on the joint with the largest one."""
    size = rms(tau)
    size = np.where(size > 0, size, np.inf)
    shares = 100 * rms(logged - tau) / size
    j = int(np.argmax(shares))
    text = f"{shares[j]:.3g}" if shares[j] < 100 else f"{shares[j]:.0f}"
    return f"differs from it by up to {text} % (joint {j + 1})"
