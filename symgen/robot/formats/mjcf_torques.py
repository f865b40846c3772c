"""Comparison of the torques of an imported robot with those of MuJoCo.

The torques of the robot come from virtual power in floats, which shares nothing with the derivation
of the model. What the file has and the robot has not is named, with its share of the torque. Any
other difference is an error.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import RobotError, shortened
from symgen.robot import dh
from symgen.robot.body import FloatArray, pseudo_inertia
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
#: Largest opening of a loop that rounding of the file to six decimals explains, m.
_CLOSED = 1e-5
LINEAR = (
    "accepted: joints in proportion (polycoef of two numbers), connect of a parallelogram with as "
    'many actuators as free joints, or active="false" at the equality'
)
_TENDON = 3  # transmissions up to this type act on joints and tendons
#: Flags of MuJoCo that switch off contacts and limits.
_CONSTRAINTS = ("CONTACT", "LIMIT")


def unread(found: Imported, model: Any, tendons: int, *, rounded: bool = False) -> list[str]:
    """Name the content of a file that causes torques and is not read.

    Args:
        found: the robot and the parameters that were read.
        model: model of MuJoCo.
        tendons: number of the tendons that are read.
        rounded: whether angles of the file were read as fractions of pi.

    Raises:
        RobotError: the torques differ for another reason.
    """
    if not (found.parameters and found.robot.n):
        return []
    error = difference(found, model)
    worst = int(error.argmax())
    notes = list(_unread(model, tendons))
    if error[worst] <= (_ROUNDED if rounded else _SAME):
        return notes
    what = (
        f"MuJoCo's torque of {found.robot.listed([worst])} differs by {100 * error[worst]:.2g} % "
        "of the largest torque from that of what symgen reads"
    )
    if not notes:
        accepted = "rigid bodies, joints with dampers and springs, and motors on joints"
        raise RobotError(f"{what}; accepted: {accepted}")
    return [*notes, what]


def difference(found: Imported, model: Any) -> FloatArray:
    """Return the largest difference of the torques of each joint (n,), over the largest torque."""
    robot = found.robot.with_values()
    states = _states(robot)
    ours = torques(robot, dict(found.parameters), *states)
    theirs = _mujoco_torques(robot, model, *states)
    size = float(np.abs(theirs).max()) or 1.0
    return np.asarray(np.abs(ours - theirs).max(axis=0) / size)


def _unread(model: Any, tendons: int) -> Iterator[str]:
    """Yield a note for each kind of content that can cause torques and is not read."""
    if model.body_gravcomp.any():
        yield "the gravity compensation of bodies (gravcomp) is not read"
    if model.opt.density or model.opt.viscosity:
        yield "the density and the viscosity of the medium are not read"
    if np.any(getattr(model, "jnt_springyield", 0.0)):
        yield "springyield of joints is not read"
    if others := model.ntendon - tendons:
        yield f"{others} tendons of the file are not read: they are no drives of two joints"
    if (model.actuator_trntype > _TENDON).any():
        yield "armature and damping of actuators on sites and bodies are not read"


def _states(robot: Robot) -> FloatArray:
    """Return positions within the limits, speeds and accelerations, (3, K, n)."""
    draw = np.random.default_rng(_SEED)
    ranges = (robot.limits and robot.limits.position) or [(-_RANGE, _RANGE)] * robot.n
    low, high = np.transpose(ranges)
    shares, *motion = draw.random((3, _STATES, robot.n))
    qd, qdd = (_FASTEST * (2 * x - 1) for x in motion)
    return np.array([low + (high - low) * shares, qd, qdd])


def _mujoco_torques(
    robot: Robot, model: Any, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the torques of the movable joints by mj_inverse, with those of their followers.

    Raises:
        RobotError: an equality does not hold.
    """
    import mujoco

    bare = copy.copy(model)
    for key in _CONSTRAINTS:
        bare.opt.disableflags |= disabling(key)
    bare.dof_frictionloss[:] = bare.tendon_frictionloss[:] = 0
    ids = {bare.joint(k).name or f"joint{k + 1}": k for k in range(bare.njnt)}
    moving = [joint for joint in robot.moving if joint.name in ids]
    places = [ids[joint.name] for joint in moving]
    q_at, v_at = bare.jnt_qposadr[places], bare.jnt_dofadr[places]
    ratio, offset = _ratios(robot, moving), [float(joint.offset) for joint in moving]
    out, gaps = np.zeros_like(q), list[FloatArray]()
    with quiet():
        data = mujoco.MjData(bare)
        for tau, position, speed, rate in zip(out, q, qd, qdd, strict=True):
            data.qpos[q_at] = ratio @ position + offset
            data.qvel[v_at] = ratio @ speed
            data.qacc[v_at] = ratio @ rate
            mujoco.mj_inverse(bare, data)
            gaps.append(abs(data.efc_pos[: data.ne]))
            tau[:] = ratio.T @ (data.qfrc_inverse + data.qfrc_constraint)[v_at]
    opening = np.max(gaps, axis=0)
    if opening.max(initial=0.0) > _CLOSED:
        what = f"{equality(bare, data.efc_id[opening.argmax()])} is off by {opening.max():.2g}"
        raise RobotError(f"{what} (m or rad) as the joints move; {LINEAR}")
    return out


def equality(model: Any, k: Any) -> str:
    """Return kind and name of an equality."""
    import mujoco

    kind = mujoco.mjtEq(model.eq_type[k]).name.removeprefix("mjEQ_").lower()
    return f"the {kind} equality {shortened(model.equality(k).name or f'number {k + 1}')!r}"


def disabling(part: str) -> int:
    """Return the flag that disables a part of the physics of MuJoCo: GRAVITY, SPRING, ...

    It is 0 if MuJoCo is older than the flag.
    """
    import mujoco

    return int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{part}", 0))


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress the warnings that MuJoCo would print, and write to MUJOCO_LOG.TXT."""
    import mujoco

    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)


def _ratios(robot: Robot, joints: Sequence[Joint]) -> FloatArray:
    """Return dq_j/dq_k of joints by the movable joints, (J, n)."""
    out = np.zeros((len(joints), robot.n))
    for row, joint in zip(out, joints, strict=True):
        for number, c in joint.shares:
            row[robot.numbers.index(number)] = float(c)
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
    ratio = _ratios(robot, robot.joints)
    bodies = [
        pseudo_inertia([values[f"{key}{joint.number}"] for key in names.LINK])
        for joint in robot.joints
    ]
    joints = zip(q, qd @ ratio.T, qdd @ ratio.T, strict=True)
    tau = np.array([_link_torques(robot, bodies, *state) for state in joints]) @ ratio
    # Speeds of the drives are C qd: of the motor of each joint, and of the couplings.
    C = np.eye(robot.n + len(robot.couplings), robot.n)
    losses = [(f"{names.ROTOR}{k}", f"FV{k}") for k in robot.numbers]
    for row, pair in zip(C[robot.n :], robot.couplings, strict=True):
        row[[*map(robot.numbers.index, pair.joints)]] = 1.0, float(pair.ratio)
        losses.append((f"IAM{pair.second}", f"FVM{pair.second}"))
    armature, damping = np.array([[values.get(key, 0.0) for key in pair] for pair in losses]).T
    tau += (qdd @ C.T * armature + qd @ C.T * damping) @ C
    tau += [values.get(f"OF{k}", 0.0) for k in robot.numbers]
    for effect in robot.effects:
        k = robot.numbers.index(effect.joint)
        linear = ((n, values[n]) for n, _ in effect.linear)
        known = {sp.Symbol(n, real=True): c for n, c in (*linear, *effect.nonlinear)}
        symbols = [sp.Symbol(f"{x}{effect.joint}", real=True) for x in ("q", "qd")]
        tau[:, k] -= sp.lambdify(symbols, effect.torque.subs(known), "numpy")(q[:, k], qd[:, k])
    return tau


def _link_torques(
    robot: Robot,
    bodies: Sequence[FloatArray],
    q: FloatArray,
    speeds: FloatArray,
    rates: FloatArray,
) -> FloatArray:
    """Return the torque of the links about each joint of the file in one state, (J,).

    In frame 0, with 4x4 matrices: a joint moves its links by the twist S, V is their velocity, and
    the points x of a link accelerate by (A + V V) x. P, the pseudo-inertia of a link, is the
    integral of x x' dm. The torque of the joint is the power of S against the forces of all links
    that it carries:

        tau = sum over links of trace(S' W),    W = (A + V V - G) P

    Args:
        robot: the robot, without named lengths.
        bodies: pseudo-inertia (4, 4) of the link of each joint, in the frame of the joint.
        q: positions of the movable joints, (n,).
        speeds, rates: speed and acceleration of each joint of the file, (J,).
    """
    frames = dh.frames(robot, dict(zip(robot.numbers, q.tolist(), strict=True)))
    gravity = np.zeros((4, 4))
    gravity[:3, 3] = [float(g) for g in robot.gravity]
    V, A, W, twists = np.zeros((4, len(frames), 4, 4))
    for joint, P, speed, rate in zip(robot.joints, bodies, speeds, rates, strict=True):
        j, i, T = joint.number, joint.antecedent, frames[joint.number]
        S = twists[j] = T @ _TWISTS[joint.sigma] @ np.linalg.inv(T)
        V[j] = V[i] + S * speed
        A[j] = A[i] + S * rate + (V[i] @ S - S @ V[i]) * speed
        W[j] = (A[j] + V[j] @ V[j] - gravity) @ (T @ P @ T.T)
    for joint in reversed(robot.joints):
        W[joint.antecedent] += W[joint.number]
    return np.asarray((twists * W).sum(axis=(1, 2))[1:])
