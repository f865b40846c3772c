"""Convert logs between the motor side and the joint side of gears.

With the gear ratios N, torque constants K and gains g of [drive]:

    q_motor = N q_joint        tau_joint = g N' tau_motor        tau_motor = K i

The gains g come from a calibration of the drives; the default is 1. For g = 1, both sides have the
same power: qd_motor' tau_motor = qd_joint' tau_joint (Siciliano et al., Robotics, 2009, sec. 5.1).
Friction and rotor inertia then act at the joint: IA = N^2 times the inertia of the rotor. Motor
positions are zero where the joint positions are zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from symgen.data.mask import rms
from symgen.data.raw import CHANNELS, TORQUES, FloatArray, Log, read_only, refuse

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
        LogError: the number of joints differs, there are currents without torque constants, or duty
            of motors that move several joints.
    """
    if log.mapped:
        return log
    if drive is None:
        return log if log.duty is None else _with_input(log, _of_duty(log, None))
    n = len(drive.ratio)
    if log.q.shape[1] != n:
        refuse(f"the log has {log.q.shape[1]} joints, the robot has {n}", "the same")
    N = np.array(drive.ratio)
    if drive.position_side == "motor" and not np.array_equal(N, np.eye(n)):
        log = _positions_of_joints(log, N)
    given = {role for role in TORQUES if getattr(log, CHANNELS[role].key) is not None}
    if drive.torque_constant is None:
        given -= {"i"}
    role = next((role for role in _INPUTS if role in given), None)
    if role is not None:
        log = _with_input(log, _INPUTS[role](log, drive))
        if drive.gain is not None:
            assert log.tau is not None
            note = "torques were multiplied by the gains of [drive]"
            log = _noted(replace(log, tau=read_only(log.tau * drive.gain)), note)
    elif log.qr is None:
        refuse("has currents alone", "torque_constant in [drive] of the robot file")
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
        f"{'q' if log.qd is None else 'q and qd'} were mapped from the motor side to the joint "
        f"side by the ratios of [drive]; the joints travel {travelled}"
    )
    return _noted(replace(log, **changed), note)


def _noted(log: Log, *notes: str) -> Log:
    lines = (f"{log.name}: {note}" for note in notes)
    return replace(log, notes=(*log.notes, *lines))


def _one_each(N: FloatArray) -> bool:
    """Return whether each motor moves only its joint."""
    return np.array_equal(N, np.diag(np.diag(N)))


# The channels that give tau: each with a function from the log and the drive.


class Input(NamedTuple):
    """Input of the joints by one channel: tau (N, n), its unit as `Log.drive_unit`, and notes."""

    tau: FloatArray
    unit: str
    notes: tuple[str, ...]


def _with_input(log: Log, given: Input) -> Log:
    return _noted(replace(log, tau=read_only(given.tau), drive_unit=given.unit), *given.notes)


def _of_torques(log: Log, drive: Drive) -> Input:
    assert log.tau is not None
    N = np.array(drive.ratio)
    if drive.torque_side != "motor" or np.array_equal(N, np.eye(len(N))):
        return Input(log.tau, "", ())
    return Input(log.tau @ N, "", ("tau was mapped from the motor side to the joint side",))


def _of_currents(log: Log, drive: Drive) -> Input:
    assert log.current is not None
    assert drive.torque_constant is not None
    tau = (log.current * drive.torque_constant) @ np.array(drive.ratio)
    unused = ""
    if log.tau is not None:
        recorded = _of_torques(log, drive).tau
        unused = f"; the recorded tau {_difference(recorded, tau)} and is not used"
    note = "tau is that of the motor currents i1.. by the torque constants and ratios of [drive]"
    return Input(tau, "", (f"{note}{unused}",))


def _of_duty(log: Log, drive: Drive | None) -> Input:
    """Return the input by the duty, or by the voltage, of the drives."""
    assert log.duty is not None
    u, unit, notes = log.duty, log.drive_unit, []
    actual = unit == "V"
    if actual and drive is not None and drive.supply is not None:
        u, unit = u / np.array(drive.supply), "duty"
        notes.append("u1.. in V was divided by the supply of [drive]")
    if unit == "duty":
        u, at_limit = clipped(u, drive)
        notes += at_limit
    tau = held(log.t, u)
    late = 500.0 * float(np.median(np.diff(log.t)))
    what = "voltage" if unit == "V" else "duty"
    notes.append(
        f"tau is the {what} u1.. of the drives, which hold a value until the next sample: it acts "
        f"{late:.3g} ms, half a step, after its stamp on average"
    )
    if not actual:
        tau, scaled = _by_supply(log, tau, drive)
        notes += scaled
    if drive is not None and drive.torque_side == "motor":
        N = np.array(drive.ratio)
        if not _one_each(N):
            what = "has the duty of motors that move several joints"
            refuse(what, 'tau1.. or i1.., or the duty of joints with torque_side = "joint"')
        tau = tau * np.sign(np.diag(N))
    return Input(tau, unit, tuple(notes))


#: Role -> function; a log uses the first of its channels.
_INPUTS: dict[str, Callable[[Log, Drive], Input]] = {
    "u": _of_duty,
    "i": _of_currents,
    "tau": _of_torques,
}


def held(t: FloatArray, u: FloatArray) -> FloatArray:
    """Return the input that acts at the stamps if a drive holds each value until the next stamp.

        v[k] = u[k] + (u[k+1] - 2 u[k] + u[k-1]) / 24,  half a step later

    The first term is the mean of a smooth u over a step, the second one its curvature.

    Args:
        t: (N,) stamps, s.
        u: (N, n) values from their stamps on.
    """
    from scipy.interpolate import CubicSpline

    mean = u.copy()
    mean[1:-1] += np.diff(u, 2, axis=0) / 24
    before = t - 0.5 * np.median(np.diff(t))
    return np.asarray(CubicSpline(t, mean)(np.maximum(before, t[0])))


def clipped(u: FloatArray, drive: Drive | None) -> tuple[FloatArray, list[str]]:
    """Return duty (N, n) within the limits of the drives, and a note if it is at a limit."""
    limit = np.array(1.0 if drive is None or drive.limit is None else drive.limit)
    shares = 100 * np.mean(np.abs(u) >= limit, axis=0)
    texts = [f"u{j} {share:.3g} %" for j, share in enumerate(shares, 1) if share]
    notes = [f"samples at the limit of the duty: {', '.join(texts)}"] if texts else []
    return np.clip(u, -limit, limit), notes


def _by_supply(log: Log, u: FloatArray, drive: Drive | None) -> tuple[FloatArray, list[str]]:
    """Scale duty (N, n) by the recorded supply over its nominal voltage, or over its mean."""
    if log.supply is None:
        return u, []
    known = drive is not None and drive.supply is not None
    nominal = np.array(drive.supply) if drive and known else np.mean(log.supply, axis=0)
    factor = np.nan_to_num(log.supply / nominal, nan=1.0)
    source = "that of [drive]" if known else f"its mean, {listed_voltages(nominal)} V"
    return u * factor, [f"u1.. was multiplied by the recorded supply over {source}"]


def listed_voltages(volts: FloatArray) -> str:
    """Return different voltages as text, without NaN."""
    known = volts[np.isfinite(volts)]
    return ", ".join(dict.fromkeys(f"{x:.4g}" for x in known))


_COMMANDS = {"duty": "duty", "A": "currents"}


def torque_of_command(servo: Servo, drive: Drive | None) -> FloatArray:
    """Return the input of each joint by a unit of its controller's command, (n,).

    It is in N m/A for a controller of currents, otherwise 1.

    Raises:
        LogError: currents without torque constants, or of motors that move several joints.
    """
    if servo.unit != "A":
        return np.ones(len(servo.kp))
    if drive is None or drive.torque_constant is None or not _one_each(np.array(drive.ratio)):
        what = "[controller] of the robot file commands currents, and their torque is unknown"
        refuse(what, "torque_constant in [drive], of motors that move one joint each")
    constants = np.diag(drive.ratio) * np.array(drive.torque_constant)
    return np.asarray(constants * np.array(drive.gain or 1.0))


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
            "[controller] with kp and kd in the robot file; where only their "
            'ratios are known, with scale = "unknown"',
        )
    kp = np.array(servo.kp)
    kd = np.array(servo.kd)

    def speed(x: FloatArray, measured: FloatArray | None) -> FloatArray:
        from scipy.interpolate import CubicSpline

        return CubicSpline(log.t, x)(log.t, 1) if measured is None else measured

    factor = torque_of_command(servo, drive)
    command = factor * (kp * log.qr + kd * speed(log.qr, log.qdr))
    feedback = factor * (kp * log.q + kd * speed(log.q, log.qd))
    what = "tau" if servo.unit == "N m" else f"tau by the {_COMMANDS[servo.unit]}"
    notes = [f"{what} is that of the gains of [controller], kp (qr - q) + kd (qdr - qd)"]
    unit = ""
    if servo.unit == "duty":
        unit, command = "duty", held(log.t, command)
        tau, at_limit = clipped(command - feedback, drive)
        tau, scaled = _by_supply(log, tau, drive)
        notes += [*at_limit, *scaled]
    else:
        tau = command - feedback
    log = _with_input(log, Input(tau, unit, tuple(notes)))
    return replace(log, command=read_only(command))


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
