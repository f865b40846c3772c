"""Arms with voltage servos in MuJoCo, and their logs as the registers of a bus hold them.

The drive gives tau = a u - b qd at the joint. The controller u = gain (qr - q) runs at the rate of
the log, sees positions in ticks, and holds its duty until the next sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.log import make_log
from symgen.data.raw import Log

FloatArray = NDArray[np.float64]
TICK = 2 * np.pi / 4096
DUTY = 1e-3  # resolution of the duty
TIMESTEP = 5e-4


@dataclass(frozen=True)
class Arm:
    """An arm: one row a joint.

    Attributes:
        place: (n, 3) position of each joint in the frame of the link before, m.
        axis: (n, 3) axes of the joints.
        centre: (n, 3) centres of mass of the links, m.
        mass: (n,) masses, kg.
        inertia: (n, 3) principal inertias, kg m2.
        a, b: (n,) torque at full duty, N m, and back-EMF, N m s/rad.
        coulomb, viscous, rotor: (n,) N m, N m s/rad, kg m2.
        gain: gain of the controller, duty/rad.
    """

    place: FloatArray
    axis: FloatArray
    centre: FloatArray
    mass: FloatArray
    inertia: FloatArray
    a: FloatArray
    b: FloatArray
    coulomb: FloatArray
    viscous: FloatArray
    rotor: FloatArray
    gain: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.mass)


#: Places of the joints, axes, and directions and lengths of the links; the share of full size.
_ARMS = {
    "leg": (
        ((0, 0, 1), (0, 0.08, 0), (0, 0, -0.25)),
        "x y y",
        ((0, 0.08, 0), (0, 0, -0.25), (0, 0, -0.25)),
        1.0,
    ),
    "reach": (
        ((0, 0, 0.1), (0, 0, 0.08), (0, 0, 0.25), (0.2, 0, 0)),
        "z y y x",
        ((0, 0, 0.08), (0, 0, 0.25), (0.2, 0, 0), (0.1, 0, 0)),
        0.7,
    ),
    "desk": (
        ((0, 0, 0.05), (0, 0, 0.06), (0, 0, 0.12), (0.13, 0, 0), (0.06, 0, 0)),
        "z y y y x",
        ((0, 0, 0.06), (0, 0, 0.12), (0.13, 0, 0), (0.06, 0, 0), (0.08, 0, 0)),
        0.25,
    ),
}
ARMS = tuple(_ARMS)


def random_arm(kind: str, rng: np.random.Generator) -> Arm:
    """Return an arm of random masses and drives; `kind` is one of ARMS."""
    place, axes, links, size = _ARMS[kind]
    n, along = len(place), np.array(links, dtype=float)
    length = np.abs(along).sum(axis=1, keepdims=True)
    mass, a = size * rng.uniform(0.3, 0.8, n), size * rng.uniform(9.0, 13.0, n)
    slender = length**2 / 12 * (along == 0) + 2e-4 * (1 + (along != 0))
    return Arm(
        place=np.array(place, dtype=float),
        axis=np.array([np.eye(3)["xyz".index(axis)] for axis in axes.split()]),
        centre=0.45 * along,
        mass=mass,
        inertia=mass[:, None] * slender,
        a=a,
        b=a / rng.uniform(5.0, 7.0, n),
        coulomb=a * rng.uniform(0.02, 0.05, n),
        viscous=a * rng.uniform(0.002, 0.01, n),
        rotor=a * rng.uniform(0.003, 0.008, n),
        gain=15.0,
    )


def mjcf(arm: Arm, load: tuple[float, Sequence[float]] | None = None) -> str:
    """Return the arm as MJCF, with a point mass (kg, position in m) on the last link or without."""

    def words(x: Sequence[float] | FloatArray) -> str:
        return " ".join(map(repr, map(float, x)))

    bodies, ends = "", ""
    for j in range(arm.n):
        rotor, viscous, coulomb, mass = (
            repr(float(x[j])) for x in (arm.rotor, arm.viscous, arm.coulomb, arm.mass)
        )
        bodies += (
            f'<body name="link{j + 1}" pos="{words(arm.place[j])}">'
            f'<joint name="joint{j + 1}" axis="{words(arm.axis[j])}" armature="{rotor}" '
            f'damping="{viscous}" frictionloss="{coulomb}" range="-3 3"/>'
            f'<inertial pos="{words(arm.centre[j])}" mass="{mass}" '
            f'diaginertia="{words(arm.inertia[j])}"/>'
        )
        ends += "</body>"
    if load is not None:
        small = words([1e-4 * load[0]] * 3)
        bodies += (
            f'<body pos="{words(load[1])}"><inertial pos="0 0 0" mass="{load[0]!r}" '
            f'diaginertia="{small}"/></body>'
        )
    drives = "".join(
        f'<general joint="joint{j + 1}" gainprm="{float(arm.a[j])!r}" biastype="affine" '
        f'biasprm="0 0 {-float(arm.b[j])!r}" ctrlrange="-1 1"/>'
        for j in range(arm.n)
    )
    return (
        f'<mujoco model="servos"><compiler angle="radian"/><option timestep="{TIMESTEP}" '
        'integrator="implicitfast"/><default><joint solreffriction="0.001 1"/></default>'
        f"<worldbody>{bodies}{ends}</worldbody><actuator>{drives}</actuator></mujoco>"
    )


def recorded(
    arm: Arm,
    name: str,
    rng: np.random.Generator,
    seconds: float,
    rate: float = 200.0,
    load: tuple[float, Sequence[float]] | None = None,
    *,
    opened: bool = False,
) -> Log:
    """Return a log of the arm on a random motion: positions in ticks, reference, and duty.

    With open windings, the arm falls from the first reference; its duty is zero.
    """
    import mujoco

    if opened:
        arm = replace(arm, a=0 * arm.a, b=0 * arm.b)
    model = mujoco.MjModel.from_xml_string(mjcf(arm, load))
    data = mujoco.MjData(model)
    frequency, phase = rng.uniform(0.08, 0.45, (arm.n, 5)), rng.uniform(0, 2 * np.pi, (arm.n, 5))
    size = rng.uniform(0.2, 1, (arm.n, 5))
    size *= rng.uniform(0.8, 1.3, (arm.n, 1)) / size.sum(axis=1, keepdims=True)
    middle = rng.uniform(-0.3, 0.3, arm.n)

    def reference(t: float) -> FloatArray:
        waves = size * np.sin(2 * np.pi * frequency * t + phase)
        return np.asarray(middle + waves.sum(axis=1))

    t = np.arange(int(seconds * rate)) / rate
    wanted = np.array([reference(x) for x in t])
    data.qpos[:] = wanted[0]
    steps = round(1 / (rate * TIMESTEP))
    q, u = np.empty_like(wanted), np.empty_like(wanted)
    for k, target in enumerate(wanted):
        q[k] = np.round(data.qpos / TICK) * TICK
        duty = (not opened) * np.clip(arm.gain * (target - q[k]), -1, 1)
        u[k] = data.ctrl[:] = np.round(duty / DUTY) * DUTY
        mujoco.mj_step(model, data, steps)
    return make_log(name, t, q, None, duty=u, qr=wanted)
