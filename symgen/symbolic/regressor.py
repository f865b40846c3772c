"""Regressors of torque, momentum and power: one column for each standard parameter.

With the screw (e, v) of joint j in the frame of link i, and the unit wrench (f, n) and momentum
(l, k) of a parameter of link i:

    torque on joint j       e . n + v . f
    momentum dT/dqd_j       e . k + v . l
    dL/dq_j                 k . dw + l . dV + dependence of gravity on q_j

Moving q_j alone rotates the links behind joint j against the twist (w_a, V_a) of its antecedent: dw
= -e x w_a, dV = -(e x V_a + v x w_a). This is a twist of joint j, and it propagates to the other
links like its screw. Power is the wrench times the twist of the link.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.bodies import Inertia, unit_wrench
from symgen.symbolic.constraints import ByJoint, spread, to_variables
from symgen.symbolic.energy import inertial_parameters
from symgen.symbolic.kinematics import Way, arrays, axes, builder, variables, way_of
from symgen.symbolic.motion import (
    LinkState,
    accelerations,
    base_acceleration,
    base_velocity,
    in_later_frames,
    references,
    screws,
    velocities,
)
from symgen.symbolic.parameters import Parameter
from symgen.symbolic.spatial import (
    Screw,
    Vector,
    acting,
    cross,
    dot,
    named,
    screw_rate,
    unit_vector,
)
from symgen.symbolic.tape import Tape, TapeBuilder

Columns = list[ByJoint]


@dataclass(frozen=True)
class _Scene:
    """The state that every regressor starts from; equations, and links, by number."""

    robot: Robot
    tape: TapeBuilder
    way: Way
    qd: ByJoint
    qdd: ByJoint
    screw: Mapping[int, Mapping[int, Screw]]
    parameters: Sequence[Parameter]

    def torques(
        self,
        wrench: Callable[[Parameter], Screw],
        acceleration: ByJoint,
        inputs: Sequence[str],
    ) -> Tape:
        """Return the tape of torques: wrenches of links, rotors at accelerations, and friction."""
        columns = [
            _projected(self, p, wrench(p), "T")
            if p.prefix in names.LINK
            else _rotor(self, p, acceleration)
            for p in self.parameters
        ]
        rubbing = friction.friction_torque_columns(self.robot, self.tape)
        return self.close(inputs, [*columns, *(column for _, column in rubbing)])

    def close(self, inputs: Sequence[str], *matrices: Columns) -> Tape:
        """Return the tape of some matrices (n, columns), row-major, one after the other."""
        acting = [
            [to_variables(self.robot, c, f"G{k}_{i}", self.tape) for i, c in enumerate(columns)]
            for k, columns in enumerate(matrices)
        ]
        rows = [
            column.get(j, sp.S.Zero)
            for columns in acting
            for j in self.robot.equations
            for column in columns
        ]
        return self.tape.tape(arrays(self.robot, *inputs), rows)


def _scene(
    robot: Robot, fixed: bool = False
) -> tuple[_Scene, Mapping[int, LinkState], Mapping[int, LinkState]]:
    tape = builder(robot)
    way = way_of(robot, tape)
    qd = {step.joint.number: step.qd for step in way}
    qdd = spread(robot, variables(robot, "qdd"), tape)
    twist, base = base_velocity(robot, tape), base_acceleration(robot, tape)
    screw, parameters = screws(robot, way, tape), inertial_parameters(robot)
    if not fixed:
        links = {j.number for j in robot.joints if j.fixed} - {robot.load_link}
        screw = {**screw, **{link: {} for link in links}}
    scene = _Scene(robot, tape, way, qd, qdd, screw, parameters)
    return scene, velocities(way, twist, tape), accelerations(way, base, qdd, tape)


def torque_tape(robot: Robot, *, fixed: bool = False) -> Tape:
    """Derive the torque regressor, friction included: (n, standard parameters) of q, qd, qdd.

    Args:
        robot: the mechanism.
        fixed: whether to derive the columns of links on fixed joints. Otherwise they are zero,
            because no base parameter leads with one of these links.
    """
    scene, _, motion = _scene(robot, fixed)

    def wrench(p: Parameter) -> Screw:
        return unit_wrench(p.prefix, motion[p.joint], p.joint, scene.tape)

    return scene.torques(wrench, scene.qdd, ("q", "qd", "qdd"))


#: The torque regressor of all links.
standard_torque_tape = partial(torque_tape, fixed=True)


def slotine_li_tape(robot: Robot) -> Tape:
    """Derive the columns of M qddr + C(q, qd) qdr + g + friction(qd): (n, standard parameters)."""
    scene, _, real = _scene(robot)
    tape = scene.tape
    qdr, qddr = (spread(robot, variables(robot, rate), tape) for rate in ("qdr", "qddr"))
    found = references(scene.way, real, base_acceleration(robot, tape), qdr, qddr, tape)

    def wrench(p: Parameter) -> Screw:
        def name(vector: Vector, letter: str) -> Vector:
            written = letter in "FN"
            return named(vector, f"{letter.lower()}{p.name}_", tape) if written else vector

        body = Inertia.of({p.prefix: sp.S.One})
        return body.virtual_wrench(found[p.joint], p.name, tape, name)

    return scene.torques(wrench, qddr, ("q", "qd", "qdr", "qddr"))


def momentum_tape(robot: Robot) -> Tape:
    """Derive the columns of dT/dqd, then those of dL/dq: (n, inertial standard parameters) each.

    Those of links on fixed joints are zero, except for a link with a load.
    """
    scene, frame, _ = _scene(robot)
    # (dw, dV) of link i with q_j, by i and j. In frame j the speed of the joint itself makes no
    # difference: it is along z, through the origin.
    rates = {j: screw_rate(screw, frame[link].twist) for j, (link, screw) in axes(robot).items()}
    change = in_later_frames(scene.way, rates, "IJ", scene.tape)
    momentum: Columns = []
    slope: Columns = []
    for p in scene.parameters:
        if p.prefix not in names.LINK:
            momentum.append(_rotor(scene, p, scene.qd))
            slope.append({})
            continue
        here = frame[p.joint]
        unit_momentum = Inertia.of({p.prefix: sp.S.One}).momentum(here.twist)
        momentum.append(_projected(scene, p, unit_momentum, "Q"))
        column = {}
        for j, screw in scene.screw[p.joint].items():
            value = acting(unit_momentum, change[p.joint][j]) + _weight(p, here, screw)
            column[j] = scene.tape.name(f"S{p.name}_{j}", value)
        slope.append(column)
    return scene.close(("q", "qd"), momentum, slope)


def _weight(p: Parameter, here: LinkState, screw: Screw) -> sp.Expr:
    """Return the contribution of gravity to dL/dq_j, for one unit parameter."""
    e, v = screw
    if p.prefix in names.MOMENT:
        return dot(unit_vector(names.MOMENT.index(p.prefix)), cross(here.g, e))
    return dot(here.g, v) if p.prefix == names.MASS else sp.S.Zero


def power_tape(robot: Robot) -> Tape:
    """Derive d/dt of the energy columns, then friction power: (1, standard parameters)."""
    scene, frame, motion = _scene(robot)
    tape = scene.tape
    outputs: list[sp.Expr] = []
    drives = {c.second: friction.drive_speed(c, scene.qd, tape) for c in robot.couplings}
    for p in scene.parameters:
        if p.prefix in names.LINK:
            wrench = unit_wrench(p.prefix, motion[p.joint], p.joint, tape)
            outputs.append(tape.name(f"R{p.name}", acting(wrench, frame[p.joint].twist)))
        else:
            driven = scene.qd if p.prefix == names.ROTOR else drives
            rate = sum((v * scene.qdd[j] for j, v in _shares(scene, p).items()), sp.S.Zero)
            outputs.append(tape.name(f"R{p.name}", driven[p.joint] * tape.name(f"u{p.name}", rate)))
    outputs += friction.power_columns(robot, tape)
    return tape.tape(arrays(robot, "q", "qd", "qdd"), outputs)


def _projected(scene: _Scene, p: Parameter, wrench: Screw, tag: str) -> ByJoint:
    """Project a wrench (or momentum) on the screws of the joints that move the link.

    Joints with parallel axes share e, so e . n is one named step.
    """
    out, (f, n) = {}, wrench
    axes = [e for e, _ in scene.screw[p.joint].values()]
    for j, (e, v) in scene.screw[p.joint].items():
        turning = dot(e, n)
        if axes.count(e) > 1:
            turning = scene.tape.name(f"{tag}{p.name}_{j}e", turning)
        out[j] = scene.tape.name(f"{tag}{p.name}_{j}", turning + dot(v, f))
    return out


def _shares(scene: _Scene, p: Parameter) -> ByJoint:
    """Return du/dqd of the joints that turn the rotor of IA or IAM."""
    if p.prefix == names.ROTOR:
        return {p.joint: sp.S.One}
    coupling = next(c for c in scene.robot.couplings if c.second == p.joint)
    return friction.drive_shares(coupling, scene.tape)


def _rotor(scene: _Scene, p: Parameter, rate: ByJoint) -> ByJoint:
    """Return the column of a rotor: its share times u' (torque), or times u (momentum)."""
    shares = _shares(scene, p)
    name = f"V{p.name}{rate[p.joint].name.rstrip('0123456789')}"
    u = scene.tape.name(name, sum((s * rate[j] for j, s in shares.items()), sp.S.Zero))
    return {j: scene.tape.name(f"{name}_{j}", s * u) for j, s in shares.items()}
