"""Comparison of the torques of an imported robot with those of MuJoCo.

The torques of the robot come from virtual power in floats, which shares nothing with the derivation
of the model. What the file has and the robot has not is named, with its share
of the torque. Any other difference is an error.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from symgen import names
from symgen.errors import RobotError, first_of
from symgen.robot import dh
from symgen.robot.body import FloatArray
from symgen.robot.exact_numbers import TOLERANCE
from symgen.robot.imported import Imported
from symgen.robot.types import Joint, Robot

_STATES, _SEED = 20, 1
#: Twists of a revolute, a prismatic and a fixed joint about the z axis of its frame.
_TWISTS = np.zeros((3, 4, 4))
_TWISTS[names.REVOLUTE, 0, 1], _TWISTS[names.REVOLUTE, 1, 0] = -1.0, 1.0
_TWISTS[names.PRISMATIC, 2, 3] = 1.0
#: Largest speed and acceleration of the states, rad/s, m/s and the same per s.
_FASTEST = 2.0
#: Range of a joint without limits, rad or m.
_RANGE = 1.0
#: Largest difference, relative to the largest torque. Rounded angles of the file that symgen reads
#: as fractions of pi, each within `TOLERANCE`, have a larger one.
_SAME, _ROUNDED = 1e-9, 10 * TOLERANCE
_JOINT, _TENDON = 1, 3  # types of transmissions: up to 1 on joints
#: Flags of MuJoCo that switch off the forces of constraints.
_CONSTRAINTS = ("CONTACT", "EQUALITY", "LIMIT")


def unread(
    found: Imported, model: Any, tendons: Sequence[int], *, rounded: bool = False
) -> list[str]:
    """Name the content of a file that causes torques and is not read.

    Args:
        found: the robot and the parameters that were read.
        model: model of MuJoCo.
        tendons: indices of the tendons that are read.
        rounded: whether angles of the file were read as fractions of pi.

    Raises:
        RobotError: the torques differ for another reason.
    """
    import mujoco

    robot, values = found.robot.with_values(), dict(found.parameters)
    if not values:
        return []
    bare = copy.deepcopy(model)
    _switch_off_constraints(bare)
    states = _states(robot)
    mujoco.set_mju_user_warning(lambda _: None)  # MuJoCo would print, and write MUJOCO_LOG.TXT
    try:
        whole = _mujoco_torques(robot, bare, *states)
        notes = _remove_unread(bare, tendons)
        theirs = _mujoco_torques(robot, bare, *states)
    finally:
        mujoco.set_mju_user_warning(None)
    size = float(np.abs(theirs).max()) or 1.0
    error = np.abs(torques(robot, values, *states) - theirs).max(axis=0) / size
    worst = int(error.argmax())
    if not error[worst] <= (_ROUNDED if rounded else _SAME):
        raise RobotError(
            f"MuJoCo's torque of {robot.listed([worst])} differs by {100 * error[worst]:.2g} % of "
            "the largest torque from that of what symgen reads; accepted: rigid bodies, joints "
            "with dampers and springs, and motors on joints"
        )
    if notes:
        moved = float(np.abs(whole - theirs).max()) / size
        notes.append(f"what is not read changes the torques by up to {100 * moved:.2g} %")
    return notes


def _switch_off_constraints(model: Any) -> None:
    """Switch off contacts, equalities and limits, and set Coulomb friction to zero."""
    import mujoco

    for key in _CONSTRAINTS:
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{key}"))
    model.dof_frictionloss[:] = 0
    model.tendon_frictionloss[:] = 0


def _remove_unread(model: Any, tendons: Sequence[int]) -> list[str]:
    """Remove what symgen does not read from a model, and name it."""
    notes = []
    if model.body_gravcomp.any():
        notes.append("the gravity compensation of bodies (gravcomp) is not read")
        model.body_gravcomp[:] = 0
    if model.opt.density or model.opt.viscosity:
        notes.append("the density and the viscosity of the medium are not read")
        model.opt.density = model.opt.viscosity = 0.0
    yields = [
        model.joint(k).name
        for k in range(model.njnt)
        if np.any(getattr(model, "jnt_springyield", np.zeros(model.njnt))[k])
    ]
    if yields:
        notes.append(f"springyield of joint {first_of(yields)} is not read")
    others = np.setdiff1d(np.arange(model.ntendon), np.asarray(tendons, dtype=int))
    if len(others):
        notes.append(
            f"{len(others)} tendons of the file are not read: they are no drives of two joints"
        )
    _clear(model, "tendon", others)
    drives = model.actuator_trntype > _JOINT
    drives &= ~((model.actuator_trntype == _TENDON) & np.isin(model.actuator_trnid[:, 0], tendons))
    if _clear(model, "actuator", np.flatnonzero(drives)):
        notes.append("armature and damping of actuators that drive no joint are not read")
    return notes


def _clear(model: Any, kind: str, places: NDArray[np.intp]) -> bool:
    """Set losses and springs of tendons or actuators to zero; return whether there were any."""
    found = False
    for key in ("stiffness", "stiffnesspoly", "damping", "dampingpoly", "armature"):
        array = getattr(model, f"{kind}_{key}", None)
        if array is not None:
            found |= bool(np.any(array[places]))
            array[places] = 0
    return found


def _states(robot: Robot) -> FloatArray:
    """Return positions within the limits, speeds and accelerations, (3, K, n)."""
    draw = np.random.default_rng(_SEED)
    limits = None if robot.limits is None else robot.limits.position
    low, high = np.transpose(limits or [(-_RANGE, _RANGE)] * robot.n)
    shares, *motion = draw.random((3, _STATES, robot.n))
    qd, qdd = (_FASTEST * (2 * x - 1) for x in motion)
    return np.array([low + (high - low) * shares, qd, qdd])


def _mujoco_torques(
    robot: Robot, model: Any, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the torques of the movable joints by mj_inverse, with those of their followers."""
    import mujoco

    data = mujoco.MjData(model)
    ids = {model.joint(k).name or f"joint{k + 1}": k for k in range(model.njnt)}
    moving = [joint for joint in robot.moving if joint.name in ids]
    places = [ids[joint.name] for joint in moving]
    q_at, v_at = model.jnt_qposadr[places], model.jnt_dofadr[places]
    ratio, offset = _ratios(robot, moving), [float(joint.offset) for joint in moving]
    out = np.zeros_like(q)
    for tau, position, speed, rate in zip(out, q, qd, qdd, strict=True):
        data.qpos[q_at] = ratio @ position + offset
        data.qvel[v_at] = ratio @ speed
        data.qacc[v_at] = ratio @ rate
        mujoco.mj_inverse(model, data)
        tau[:] = ratio.T @ data.qfrc_inverse[v_at]
    return out


def _ratios(robot: Robot, joints: Sequence[Joint]) -> FloatArray:
    """Return dq_j/dq_k of joints by the movable joints, (J, n)."""
    place = {number: k for k, number in enumerate(robot.numbers)}
    out = np.zeros((len(joints), robot.n))
    for row, joint in zip(out, joints, strict=True):
        for number, c in joint.shares:
            row[place[number]] = float(c)
    return out


def torques(
    robot: Robot,
    values: Mapping[str, float],
    q: FloatArray,
    qd: FloatArray,
    qdd: FloatArray,
) -> FloatArray:
    """Return the torques of a robot by virtual power, without Coulomb friction.

    Args:
        robot: the robot, without named lengths.
        values: standard parameters, friction and coefficients of effects by name.
        q, qd, qdd: positions, speeds and accelerations, (K, n).

    Returns:
        (K, n) torques in N m, forces in N.
    """
    states = zip(q, qd, qdd, strict=True)
    of_joints = np.array([_link_torques(robot, values, *state) for state in states])
    tau = of_joints @ _ratios(robot, robot.joints)
    for k, joint in enumerate(robot.movable):
        tau[:, k] += values.get(f"{names.ROTOR}{joint.number}", 0.0) * qdd[:, k]
        tau[:, k] += values.get(f"FV{joint.number}", 0.0) * qd[:, k]
        tau[:, k] += values.get(f"OF{joint.number}", 0.0)
    place = {number: k for k, number in enumerate(robot.numbers)}
    for pair in robot.couplings:
        one, two, c = place[pair.first], place[pair.second], float(pair.ratio)
        speed, rate = (x[:, one] + c * x[:, two] for x in (qd, qdd))
        force = values[f"IAM{pair.second}"] * rate + values[f"FVM{pair.second}"] * speed
        tau[:, one] += force
        tau[:, two] += c * force
    for effect in robot.effects:
        k = place[effect.joint]
        known = {sp.Symbol(n, real=True): values[n] for n, _ in effect.linear}
        known |= {sp.Symbol(n, real=True): c for n, c in effect.nonlinear}
        symbols = [sp.Symbol(f"{x}{effect.joint}", real=True) for x in ("q", "qd")]
        tau[:, k] -= sp.lambdify(symbols, effect.torque.subs(known), "numpy")(q[:, k], qd[:, k])
    return tau


def _link_torques(
    robot: Robot, values: Mapping[str, float], q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the torque of the links about each joint of the file in one state, (J,).

    In frame 0, with 4x4 matrices: a joint moves its links by the twist S, V is their velocity, and
    the points x of a link accelerate by (A + V V) x. P, the pseudo-inertia of a link, is the
    integral of x x' dm. The torque of the joint is the power of S against the forces of all links
    that it carries:

        tau = sum over links of trace(S' W),    W = (A + V V - G) P
    """
    frames = dh.frames(robot, dict(zip(robot.numbers, q.tolist(), strict=True)))
    ratio = _ratios(robot, robot.joints)
    gravity = np.zeros((4, 4))
    gravity[:3, 3] = [float(g) for g in robot.gravity]
    V, A, W = (np.zeros((len(frames), 4, 4)) for _ in range(3))
    twists = np.zeros((len(frames), 4, 4))
    for joint, speed, rate in zip(robot.joints, ratio @ qd, ratio @ qdd, strict=True):
        j, i, T = joint.number, joint.antecedent, frames[joint.number]
        S = twists[j] = T @ _TWISTS[joint.sigma] @ np.linalg.inv(T)
        V[j] = V[i] + S * speed
        A[j] = A[i] + S * rate + (V[i] @ S - S @ V[i]) * speed
        W[j] = (A[j] + V[j] @ V[j] - gravity) @ (T @ _pseudo_inertia(values, j) @ T.T)
    for joint in reversed(robot.joints):
        W[joint.antecedent] += W[joint.number]
    return np.asarray((twists * W).sum(axis=(1, 2))[1:])


def _pseudo_inertia(values: Mapping[str, float], number: int) -> FloatArray:
    """Return the pseudo-inertia (4, 4) of a link in the frame of its joint."""
    xx, xy, xz, yy, yz, zz, x, y, z, mass = (values[f"{key}{number}"] for key in names.LINK)
    half = (xx + yy + zz) / 2
    rows = [half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z]
    return np.array([*rows, [x, y, z, mass]])
