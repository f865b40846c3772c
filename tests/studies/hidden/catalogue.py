"""All effects by name, the joints each may sit on, and a torque outside any library."""

from __future__ import annotations

import numpy as np
from oracles.hidden.machines import Machine, Torque
from studies.hidden import effects, whole
from studies.hidden.effects import Builder, Scene, forgotten

EFFECTS: dict[str, Builder] = {
    "coulomb_friction": forgotten("coulomb_friction", "coulomb", "FS", "coulomb"),
    "viscous_friction": forgotten("viscous_friction", "viscous", "FV", "viscous"),
    "rotor_inertia": forgotten("rotor_inertia", "rotor", "IA", "rotor"),
    "torque_offset": effects.torque_offset,
    "asymmetric_coulomb_friction": effects.asymmetric_coulomb_friction,
    "asymmetric_viscous_friction": effects.asymmetric_viscous_friction,
    "stribeck_friction": effects.stribeck_friction,
    "nonlinear_viscous_friction": effects.nonlinear_viscous_friction,
    "load_dependent_friction": effects.load_dependent_friction,
    "position_dependent_friction": effects.position_dependent_friction,
    "gravity_spring": effects.gravity_spring,
    "torque_ripple": effects.torque_ripple,
    "coupled_transmission": whole.coupled_transmission,
    "cable_torque": effects.cable_torque,
    "payload": whole.payload,
    "base_tilt": whole.base_tilt,
    "geometry_error": whole.geometry_error,
    "joint_elasticity": whole.joint_elasticity,
    "saturation": whole.saturation,
    "drive_gain_error": whole.drive_gain_error,
    "time_delay": whole.time_delay,
    "velocity_sensor_error": whole.velocity_sensor_error,
    "thermal_drift": whole.thermal_drift,
    "backlash": whole.backlash,
    "external_contact": effects.external_contact,
    "unnamed_bump": effects.unnamed_bump,
    "unnamed_product": effects.unnamed_product,
}
# Concern the whole robot: the builder's joint says nothing.
GLOBAL = ("payload", "base_tilt", "time_delay", "thermal_drift")


def joints_of(name: str, machine: Machine) -> list[int]:
    """Joints (0-based) that an effect may be put on."""
    arm, n = machine.arm, machine.n
    if name in GLOBAL:
        return [0]
    if name == "geometry_error":
        return [j for j in range(n) if arm.d[j] or (arm.r[j] and j)]
    if name == "backlash":  # the weight on a slide holds one flank
        return [j for j in range(n) if arm.sigma[j] == 0]
    if name == "coupled_transmission":
        return [j for j in range(n - 1) if arm.sigma[j] == arm.sigma[j + 1] == 0]
    return list(range(n))


def misfit(scene: Scene, share: np.ndarray) -> Torque:
    """A smooth torque outside any library: sines of two joints' positions and speeds.

    Args:
        scene: where it is drawn from.
        share: (n,) its RMS on each joint along the scene's motion [N m or N].
    """
    rng, n = scene.rng, scene.machine.n
    other = [int(rng.choice([k for k in range(n) if k != j])) for j in range(n)]
    pick = np.column_stack([np.arange(n), other])
    # One unit of angle for each of q_j, q_k, qd_j, qd_k over its own spread.
    unit = np.array([[*map(scene.spread, pair), *map(scene.speed, pair)] for pair in pick])
    mix = rng.normal(size=(n, 8, 4)) / unit[:, None]
    phase = rng.uniform(0, 2 * np.pi, (n, 8))
    weight = rng.normal(size=(n, 8))

    def shape(q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        x = np.concatenate([q[..., pick], qd[..., pick]], axis=-1)
        angle = np.einsum("jmi,...ji->...jm", mix, x) + phase
        return np.einsum("jm,...jm->...j", weight, np.sin(angle))

    values = shape(scene.motion.q, scene.motion.qd)
    gain = share / np.sqrt(np.mean(values**2, axis=0))
    return lambda _t, q, qd, _turn: gain * shape(q, qd)
