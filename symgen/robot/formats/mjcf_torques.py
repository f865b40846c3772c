"""Comparison of the torques of an imported robot with those of MuJoCo.

The torques of the robot come from the recursion of Newton and Euler in floats, which shares nothing
with the derivation of the model. What the file has and the robot has not is named, with its share
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
from symgen.robot.body import FloatArray, screw
from symgen.robot.exact_numbers import TOLERANCE
from symgen.robot.imported import Imported
from symgen.robot.types import Joint, Robot

_STATES, _SEED = 20, 1
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
    states = _states(robot)
    bare = copy.deepcopy(model)
    _switch_off_constraints(bare)
    mujoco.set_mju_user_warning(lambda _: None)  # MuJoCo would print, and write MUJOCO_LOG.TXT
    try:
        whole = _mujoco_torques(robot, bare, states)
        notes = _remove_unread(bare, tendons)
        theirs = _mujoco_torques(robot, bare, states)
    finally:
        mujoco.set_mju_user_warning(None)
    ours = [torques(robot, values, *state) for state in states]
    size = max(float(np.abs(tau).max()) for tau in theirs) or 1.0
    for when, a, b in zip(("at rest", "in motion", "when accelerating"), ours, theirs, strict=True):
        error = np.abs(a - b).max(axis=0) / size
        joint = int(error.argmax())
        if not error[joint] <= (_ROUNDED if rounded else _SAME):
            raise RobotError(
                f"MuJoCo's torque of {robot.listed([joint])} {when} differs by "
                f"{100 * error[joint]:.2g} % of the largest torque from that of what symgen reads; "
                "accepted: rigid bodies, joints with dampers and springs, and motors on joints"
            )
    if notes:
        moved = max(float(np.abs(a - b).max()) for a, b in zip(whole, theirs, strict=True))
        notes.append(f"what is not read changes the torques by up to {100 * moved / size:.2g} %")
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


def _states(robot: Robot) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Return q, qd, qdd, (K, n) each: at rest, in motion, and accelerating, within the limits."""
    draw = np.random.default_rng(_SEED)
    low, high = np.full(robot.n, -_RANGE), np.full(robot.n, _RANGE)
    if robot.limits is not None and robot.limits.position is not None:
        low, high = np.array(robot.limits.position, dtype=float).T
    shape = (_STATES, robot.n)
    q = low + (high - low) * draw.random(shape)
    qd, qdd = draw.uniform(-_FASTEST, _FASTEST, (2, *shape))
    rest = np.zeros(shape)
    return [(q, rest, rest), (q, qd, rest), (q, qd, qdd)]


def _mujoco_torques(
    robot: Robot, model: Any, states: Sequence[tuple[FloatArray, ...]]
) -> list[FloatArray]:
    """Return the torques of the movable joints by mj_inverse, with those of their followers."""
    import mujoco

    data = mujoco.MjData(model)
    ids = {model.joint(k).name or f"joint{k + 1}": k for k in range(model.njnt)}
    moving = [joint for joint in robot.moving if joint.name in ids]
    places = [ids[joint.name] for joint in moving]
    q_at, v_at = model.jnt_qposadr[places], model.jnt_dofadr[places]
    ratio = _ratios(robot, moving)
    offset = np.array([float(joint.offset) for joint in moving])
    out = []
    for q, qd, qdd in states:
        tau = np.zeros_like(q)
        for i in range(len(q)):
            mujoco.mj_resetData(model, data)
            data.qpos[q_at] = ratio @ q[i] + offset
            data.qvel[v_at] = ratio @ qd[i]
            data.qacc[v_at] = ratio @ qdd[i]
            mujoco.mj_inverse(model, data)
            tau[i] = ratio.T @ data.qfrc_inverse[v_at]
        out.append(tau)
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
    """Return the torques of a robot by the recursion of Newton and Euler, without Coulomb friction.

    Args:
        robot: the robot, without named lengths.
        values: standard parameters, friction and coefficients of effects by name.
        q, qd, qdd: positions, speeds and accelerations, (K, n).

    Returns:
        (K, n) torques in N m, forces in N.
    """
    ratio = _ratios(robot, robot.joints)
    tau = _link_torques(robot, values, q, qd, qdd) @ ratio
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
    """Return the torque of the links about each joint of the file, (K, J).

    Each link has, in the axes of its frame, the angular velocity w, its rate wd and the
    acceleration a of the origin without gravity. Its force is f = M a + wd x s + w x (w x s), and
    its moment n = J wd + w x (J w) + s x a, with s the first moments.
    """
    ratio = _ratios(robot, robot.joints)
    offset = np.array([float(joint.offset) for joint in robot.joints])
    at, speed, rate = q @ ratio.T + offset, qd @ ratio.T, qdd @ ratio.T
    count, z = len(q), np.array([0.0, 0.0, 1.0])
    base = np.zeros((count, 3)), np.zeros((count, 3)), np.tile(_up(robot), (count, 1))
    motion, frames, forces, moments = {0: base}, {}, {}, {}
    for k, joint in enumerate(robot.joints):
        R, p = frames[joint.number] = _transform(joint, at[:, k])
        w0, wd0, a0 = motion[joint.antecedent]
        a0 = a0 + np.cross(wd0, p) + np.cross(w0, np.cross(w0, p))
        w, wd, a = (np.einsum("kji,kj->ki", R, x) for x in (w0, wd0, a0))
        along, growth = speed[:, k, None] * z, rate[:, k, None] * z
        if joint.slides:
            a = a + 2 * np.cross(w, along) + growth
        else:
            wd = wd + np.cross(w, along) + growth
            w = w + along
        motion[joint.number] = w, wd, a
        mass, s, J = _link(values, joint.number)
        forces[joint.number] = mass * a + np.cross(wd, s) + np.cross(w, np.cross(w, s))
        moments[joint.number] = wd @ J + np.cross(w, w @ J) + np.cross(s, a)
    out = np.zeros((count, len(robot.joints)))
    for k, joint in reversed(list(enumerate(robot.joints))):
        f, n = forces[joint.number], moments[joint.number]
        out[:, k] = f[:, 2] if joint.slides else n[:, 2]
        if joint.antecedent:
            R, p = frames[joint.number]
            f, n = (np.einsum("kij,kj->ki", R, x) for x in (f, n))
            forces[joint.antecedent] = forces[joint.antecedent] + f
            moments[joint.antecedent] = moments[joint.antecedent] + n + np.cross(p, f)
    return out


def _up(robot: Robot) -> FloatArray:
    """Return the acceleration of the base that stands for gravity, -g."""
    return -np.array([float(g) for g in robot.gravity])


def _transform(joint: Joint, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rotation (K, 3, 3) and origin (K, 3) of a joint's frame in that of its antecedent."""
    rows = (2, joint.gamma, joint.b), (0, joint.alpha, joint.d)
    before = np.eye(4)
    for axis, angle, length in rows:
        before = before @ screw(axis, float(angle), float(length)).astype(float)
    theta = float(joint.theta) + (0.0 if joint.slides else at)
    r = float(joint.r) + (at if joint.slides else 0.0)
    turned = np.zeros((len(at), 3, 3))
    turned[:, 0, 0] = turned[:, 1, 1] = np.cos(theta)
    turned[:, 1, 0] = np.sin(theta)
    turned[:, 0, 1] = -np.sin(theta)
    turned[:, 2, 2] = 1.0
    origin = before[:3, 3] + np.multiply.outer(np.broadcast_to(r, len(at)), before[:3, 2])
    return before[:3, :3] @ turned, origin


def _link(values: Mapping[str, float], number: int) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, first moments (3,) and inertia (3, 3) about the origin of a link's frame."""
    xx, xy, xz, yy, yz, zz, *first, mass = (values[f"{key}{number}"] for key in names.LINK)
    return mass, np.array(first), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
