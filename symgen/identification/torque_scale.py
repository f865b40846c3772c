"""Compare the torques of logs with the weight and the torque limits in the robot file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symgen.data.mask import rms
from symgen.data.raw import Reading, refuse, roles_with_unit
from symgen.estimation.opening import Groups
from symgen.estimation.system import torque_at
from symgen.estimation.values import FloatArray
from symgen.policy import HEAVY, SCALE
from symgen.runtime.evaluator import Evaluator


def in_torque_scale(
    groups: Groups, X: FloatArray | None, evaluator: Evaluator, reading: Reading | None
) -> Groups:
    """Refuse logs whose torques are far above everything in the robot file; note others.

    The file states two sizes: the torque of its masses at rest in the poses of the logs, and its
    torque limits. Torques far above the first alone give a note. Revolute and prismatic joints are
    compared separately, by the RMS over all joints of a type. A log in which one joint alone makes
    this RMS large gives a note.

    Args:
        groups: the training and the validation logs.
        X: (p,) parameters in the robot file, None if it has none.
        evaluator: the compiled model.
        reading: units from the user, which are believed.

    Raises:
        LogError: the torques of a log are far above both.
    """
    robot = evaluator.model.robot
    if X is None or robot.imu:
        return groups
    logs = *groups[0], *groups[1]
    believed = roles_with_unit(reading or Reading()) & {"tau", "i"}
    limits = robot.limits and robot.limits.torque
    stated = np.array(limits or [np.inf] * robot.n)
    currents = robot.drive is not None and robot.drive.torque_constant is not None
    role, units = ("i", ("A", "A")) if currents else ("tau", ("Nm", "N"))
    poses = np.concatenate([s.q for s in logs])
    at_rest = rms(torque_at(evaluator, X, poses, 0 * poses, 0 * poses))
    out = []
    for s in logs:
        if s.drive_unit:
            out.append(s)
            continue
        torques = rms(s.tau)
        for kind, unit in enumerate(units):
            joints = np.flatnonzero(np.equal(robot.sigma, kind))
            torque, weight, limit = (_size(x[joints]) for x in (torques, at_rest, stated))
            if not torque > SCALE * weight > SCALE * HEAVY:
                continue
            what = f"{s.name}: the RMS torque of {robot.listed(joints)} is {torque / weight:.0f} "
            what += "times that of the masses in the robot file at rest"
            rest = [np.delete(joints, k) for k in range(len(joints))]
            others = ((_size(torques[k]), SCALE * _size(at_rest[k])) for k in rest)
            by_one = any(0 < other <= largest for other, largest in others)
            if torque > SCALE * limit and not (believed or by_one):
                columns = [f"{role}{j + 1}" for j in joints]
                if len(joints) == robot.n:
                    columns = [role]
                typed = ",".join(f"{column}=m{unit}" for column in columns)
                how = f"--unit {typed}; --unit {typed.replace('=m', '=')} if the file is wrong"
                refuse(f"{what}, and {torque / limit:.0f} times the torque limits", how)
            s = replace(s, notes=(*s.notes, f"{what}: check its unit (--unit) and the masses"))
        out.append(s)
    count = len(groups[0])
    return out[:count], out[count:]


def _size(x: FloatArray) -> float:
    return float(np.linalg.norm(x))
