"""Forward simulation under a tracking controller, and its inverse along a known motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from oracles.hidden.engines import ENGINES, PinocchioEngine
from oracles.hidden.machines import Machine
from oracles.hidden.motion import STEP, Motion, reference

BANDWIDTH = 30.0  # rad/s, of the position loop


@dataclass(frozen=True, eq=False)
class Run:
    """What truly happened on the motors' side: the motion, and the torque (N, n) of the motors."""

    motion: Motion
    tau: np.ndarray


def inverse(machine: Machine, motion: Motion, engine: str = "pinocchio") -> np.ndarray:
    """Torques (N, n) of the motors along a motion of the motors.

    An elastic joint is taken to first order in 1/K: q = motor - torque of the link / K. A link with
    play falls behind by what it lacks; its flanks are stiff, and shocks above 10 Hz are left out.
    """
    body, rotors = ENGINES[engine](machine), 0.0
    q, qd, qdd = motion.q, motion.qd, motion.qdd
    if machine.elastic:
        j, K, _ = machine.elastic
        bend = np.zeros_like(q)
        load = body.torque(q, qd, qdd)[:, j]
        bend[:, j] = load / K
        if machine.play:
            inertia = np.array([PinocchioEngine(machine).inertia(row)[j] for row in q])
            step = float(motion.t[1] - motion.t[0])
            behind = _behind(load / inertia, step, machine.play)
            bend[:, j] = sosfiltfilt(butter(2, 10 * 2 * step, output="sos"), behind)
        rate = np.gradient(bend, motion.t, axis=0)
        rotors = machine.rotor * (np.arange(machine.n) == j) * qdd
        q, qd, qdd = q - bend, qd - rate, qdd - np.gradient(rate, motion.t, axis=0)
    torque = body.torque(q, qd, qdd)
    for c in machine.couplings:
        u = c.direction(machine.n)
        torque = torque + c.IAM * (qdd @ u)[:, None] * u
    torque = torque + machine.load * np.abs(torque) * machine.sign(motion.qd) + rotors
    torque = torque - machine.friction(motion.t, motion.qd)
    for extra in machine.extra:
        torque = torque - extra(motion.t, motion.q, motion.qd, motion.turn)
    return torque


def _behind(pull: np.ndarray, step: float, play: float) -> np.ndarray:
    """How far a link is behind its motor, (N,); pull is the torque it lacks over its inertia."""
    side = at = play / 2 * np.sign(pull[0])
    rate, out = 0.0, np.empty(len(pull))
    for i, a in enumerate(pull):
        if at == side and a * side >= 0:
            rate = 0.0
        else:
            rate += a * step
            at += rate * step
            if abs(at) >= play / 2:
                side = at = np.sign(at) * play / 2
                rate = 0.0
        out[i] = at
    return out


@lru_cache(maxsize=8)  # errors of measurement share the run of a healthy machine
def simulate(
    machine: Machine, believed: Machine, kind: str, seed: int, engine: str = "pinocchio"
) -> Run:
    """Track a reference with feedforward and PD in continuous time; fixed-step RK4.

    tau = feedforward + Kp (q_r - q) + Kd (qd_r - qd), q and qd of the motors. The feedforward is
    that of the believed machine with masses 8 % too small, rotors 5 % too large and friction 20 %
    too small. An elastic joint has two masses.

    Args:
        machine: what moves.
        believed: what the controller knows, before its errors.
        kind: "train" or "validation"; seed: of the reference.
        engine: "pinocchio" or "mujoco".
    """
    aim = reference(believed, kind, seed, STEP / 2)
    imperfect = replace(
        believed,
        links=0.92 * believed.links,
        rotor=1.05 * believed.rotor,
        coulomb=0.8 * believed.coulomb,
        viscous=0.8 * believed.viscous,
    )
    feedforward = inverse(imperfect, aim)
    inertia = PinocchioEngine(believed).inertia(believed.home)
    Kp, Kd = BANDWIDTH**2 * inertia, 1.8 * BANDWIDTH * inertia
    # The whole law, but its feedback: tau = law - Kp q - Kd qd.
    law = feedforward + Kp * aim.q + Kd * aim.qd
    accelerate = _dynamics(machine, engine)
    n, steps = machine.n, len(aim.t) // 2
    out = np.empty((4, steps + 1, n))
    turns = np.full((steps + 1, n), 1e3)
    turn, heading = turns[0].copy(), np.zeros(n)
    j = machine.elastic[0] if machine.elastic else None
    x = np.concatenate((aim.q[0], aim.qd[0]))
    if machine.elastic:
        # The spring is bent at rest by what it carries.
        weight = PinocchioEngine(machine).torque(aim.q[:1], 0 * aim.q[:1], 0 * aim.q[:1])
        x = np.concatenate((x, [x[j], 0.0]))
        x[j] -= weight[0, j] / machine.elastic[1] + np.sign(weight[0, j]) * machine.play / 2

    def rates(i: int, x: np.ndarray) -> tuple[np.ndarray, ...]:
        """Derivative of the state at half step i, and motors' q, qd, qdd and torque."""
        q, qd = x[:n], x[n : 2 * n]
        if j is None:
            tau = law[i] - Kp * q - Kd * qd
            qdd, _ = accelerate(aim.t[i], q, qd, q, qd, tau, turn)
            return np.concatenate((qd, qdd)), q, qd, qdd, tau
        motor, speed = q.copy(), qd.copy()
        motor[j], speed[j] = x[2 * n :]
        tau = law[i] - Kp * motor - Kd * speed
        qdd, turned = accelerate(aim.t[i], q, qd, motor, speed, tau, turn)
        mixed = qdd.copy()
        mixed[j] = turned
        return np.concatenate((qd, qdd, speed[[j]], mixed[[j]])), motor, speed, mixed, tau

    for i in range(steps + 1):
        k1, *out[:, i] = rates(2 * i, x)
        turns[i] = turn
        if i == steps:
            break
        k2 = rates(2 * i + 1, x + STEP / 2 * k1)[0]
        k3 = rates(2 * i + 1, x + STEP / 2 * k2)[0]
        k4 = rates(2 * i + 2, x + STEP * k3)[0]
        x = x + STEP / 6 * (k1 + 2 * (k2 + k3) + k4)
        speed = out[1, i]
        turned = (speed * heading < 0) & (np.abs(speed) > 1e-3)
        turn = np.where(turned, out[0, i], turn)
        heading = np.where((np.abs(speed) > 1e-3) & (turned | (heading == 0)), speed, heading)
    q, qd, qdd, tau = out
    return Run(Motion(aim.t[::2], q, qd, qdd, turns), tau)


def _dynamics(machine: Machine, engine: str):
    """Accelerations from the torques of the motors, and that of an elastic joint's motor."""
    body = ENGINES[engine](machine)
    elastic, loaded = machine.elastic, bool(np.any(machine.load))
    coupled = [(c.IAM, c.direction(machine.n)) for c in machine.couplings if c.IAM]

    def accelerate(t, q, qd, motor, speed, tau, turn):
        torque = tau + machine.friction(t, speed)
        for extra in machine.extra:
            torque = torque + extra(t, motor, speed, turn)
        if loaded:
            # R + a |R| s = T, solved for R.
            torque = torque / (1.0 + machine.load * machine.sign(speed) * np.sign(torque))
        turned = 0.0
        if elastic:
            j, K, D = elastic
            spring = _spring(motor[j] - q[j], speed[j] - qd[j], K, D, machine.play)
            turned = (torque[j] - spring) / machine.rotor[j]
            torque[j] = spring
        qdd = body.acceleration(q, qd, torque)
        for IAM, u in coupled:
            # One drive's inertia adds IAM u u' to the mass matrix (Sherman and Morrison).
            column = body.acceleration(q, qd, torque + u) - qdd
            qdd = qdd - column * (IAM * (u @ qdd) / (1.0 + IAM * (u @ column)))
        return qdd, turned

    return accelerate


def _spring(bend: float, rate: float, K: float, D: float, play: float) -> float:
    """Torque of a spring; where it has play, of the flank that is met, which never pulls."""
    if not play:
        return K * bend + D * rate
    over = bend - min(max(bend, -play / 2), play / 2)
    side = np.sign(over)
    return side * max(side * (K * over + D * rate), 0.0)
