"""Hidden effects that change the machine itself, or only what is written down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from oracles.hidden.machines import Coupling, Machine, body
from scipy.interpolate import CubicSpline
from studies.hidden.effects import Channels, Hidden, Scene


def coupled_transmission(scene: Scene, j: int, size: float) -> Hidden:
    # Shares of the two joints' own terms, so that the coupled drive is of their kind.
    machine, k = scene.machine, j + 1
    ratio = float(scene.rng.choice([1.0, -1.0]))
    IAM, FVM, FSM = (
        size * float(min(getattr(machine, f)[j], getattr(machine, f)[k]))
        for f in ("rotor", "viscous", "coulomb")
    )
    coupling = Coupling(j, k, ratio, IAM, FVM, FSM)
    return Hidden(
        "coupled_transmission",
        (j + 1, k + 1),
        {"ratio": ratio, "IAM": IAM, "FVM": FVM, "FSM": FSM},
        machine=lambda believed: replace(believed, couplings=(*believed.couplings, coupling)),
    )


def joint_elasticity(scene: Scene, j: int, size: float) -> Hidden:
    # size 1: 20 Hz with the motor held, damped by 5 %.
    inertia = float(scene.machine.links[j:, [0, 3, 5]].max() + scene.machine.rotor[j])
    K = (2 * np.pi * 20) ** 2 * inertia / size
    D = 0.1 * np.sqrt(K * inertia)
    return Hidden(
        "joint_elasticity",
        (j + 1,),
        {"K": K, "D": D},
        machine=lambda machine: replace(machine, elastic=(j, K, D)),
    )


def backlash(scene: Scene, j: int, size: float) -> Hidden:
    # size 1: 0.1 rad, or as much of a rack on a pinion of 50 mm; flanks at 50 Hz of the rotor.
    machine = scene.machine
    play = 0.1 * size * (1.0 if machine.arm.sigma[j] == 0 else 0.05)
    K = (2 * np.pi * 50) ** 2 * float(machine.rotor[j])
    D = 2 * np.sqrt(K * float(machine.rotor[j]))
    return Hidden(
        "backlash",
        (j + 1,),
        {"BL": play},
        machine=lambda machine: replace(machine, elastic=(j, K, D), play=play),
    )


def payload(scene: Scene, _: int, size: float) -> Hidden:
    last = scene.machine.n - 1
    load = body(size, (0.04, -0.02, 0.06), (0.03, 0.03, 0.03))

    def change(machine: Machine) -> Machine:
        links = machine.links.copy()
        links[last] += load
        return replace(machine, links=links)

    names = ("XXL", "XYL", "XZL", "YYL", "YZL", "ZZL", "MXL", "MYL", "MZL", "ML")
    values = dict(zip(names, map(float, load), strict=True))
    return Hidden("payload", (last + 1,), values, machine=change, given=True)


def base_tilt(scene: Scene, _: int, size: float) -> Hidden:
    # Rot(x, beta_x) Rot(y, beta_y) of the base; where gravity lies in the plane, about z instead.
    upright = abs(scene.machine.arm.gravity[2]) > 1
    angle = scene.rng.uniform(0, 2 * np.pi)
    first, second = (size * np.cos(angle), size * np.sin(angle)) if upright else (0.0, size)
    g = np.array(scene.machine.arm.gravity, dtype=float)
    about = (0, 1) if upright else (0, 2)
    for axis, beta in zip(about, (first, second), strict=True):
        e = np.eye(3)[axis]
        # The base turns by beta, so that gravity turns by -beta in frame 0 (Rodrigues).
        g = g * np.cos(beta) - np.cross(e, g) * np.sin(beta) + e * (e @ g) * (1 - np.cos(beta))
    values = {f"beta_{'xyz'[axis]}": b for axis, b in zip(about, (first, second), strict=True)}
    return Hidden(
        "base_tilt", (), values, machine=lambda m: replace(m, arm=replace(m.arm, gravity=tuple(g)))
    )


def geometry_error(scene: Scene, j: int, size: float) -> Hidden:
    arm = scene.machine.arm
    key = "d" if arm.d[j] else "r"
    error = size if scene.rng.random() < 0.5 else -size
    lengths = list(getattr(arm, key))
    lengths[j] += error
    return Hidden(
        "geometry_error",
        (j + 1,),
        {f"delta_{key}": error},
        machine=lambda m: replace(m, arm=replace(m.arm, **{key: tuple(lengths)})),
    )


def thermal_drift(scene: Scene, _: int, size: float) -> Hidden:
    T = scene.rng.uniform(0.2, 0.4) * scene.machine.seconds
    return Hidden(
        "thermal_drift",
        (),
        {"a": size, "T": T},
        machine=lambda machine: replace(machine, drift=(size, T)),
    )


def saturation(scene: Scene, j: int, size: float) -> Hidden:
    # The torque channel is cut at a limit; size 1 cuts at 1/e of the reference's peak.
    peak = float(np.abs(scene.torque[:, j]).max())
    limit = peak * np.exp(-size)

    def cut(log: Channels) -> Channels:
        tau = log.tau.copy()
        tau[:, j] = np.clip(tau[:, j], -limit, limit)
        return replace(log, tau=tau)

    return Hidden("saturation", (j + 1,), {"limit": limit}, log=cut)


def drive_gain_error(scene: Scene, j: int, size: float) -> Hidden:
    gain = 1 + size if scene.rng.random() < 0.5 else 1 - size

    def scale(log: Channels) -> Channels:
        tau = log.tau.copy()
        tau[:, j] *= gain
        return replace(log, tau=tau)

    return Hidden("drive_gain_error", (j + 1,), {"gain": gain}, log=scale)


def time_delay(scene: Scene, _: int, size: float) -> Hidden:
    # Positive: the torque channel is late. size 1 is 10 ms.
    delta = 0.01 * size * (1 if scene.rng.random() < 0.5 else -1)

    def shift(log: Channels) -> Channels:
        late = np.clip(log.t - delta, log.t[0], log.t[-1])
        return replace(log, tau=CubicSpline(log.t, log.tau)(late))

    return Hidden("time_delay", (), {"delta": delta}, log=shift)


def velocity_sensor_error(scene: Scene, j: int, size: float) -> Hidden:
    # A factor, a lag or an offset of one tachometer; size 1 is 100 %, 0.1 s, the RMS speed.
    kind = scene.rng.choice(["gain", "lag", "offset"])
    values = {"gain": 1.0, "lag": 0.0, "offset": 0.0}
    values[kind] += size * {"gain": 1.0, "lag": 0.1, "offset": scene.speed(j)}[str(kind)]

    def falsify(log: Channels) -> Channels:
        qd = log.qd.copy()
        late = np.clip(log.t - values["lag"], log.t[0], log.t[-1])
        qd[:, j] = values["gain"] * CubicSpline(log.t, qd[:, j])(late) + values["offset"]
        return replace(log, qd=qd)

    return Hidden("velocity_sensor_error", (j + 1,), values, log=falsify, channel="qd")
