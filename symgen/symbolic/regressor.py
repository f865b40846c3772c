"""Regressors of torque, momentum and power: one column for each standard parameter.

With the screw (e, v) of joint j in the frame of link i, and the unit wrench (f, n) and momentum
(l, k) of a parameter of link i:

    torque on joint j       e . n + v . f
    momentum dT/dqd_j       e . k + v . l
    dL/dq_j                 k . dw + l . dV + dependence of gravity on q_j

where moving q_j alone turns the links behind it against the twist (w_a, V_a) that they inherit:
dw = -e x w_a, dV = -(e x V_a + v x w_a), which is a twist of joint j and handed on as its screw is.
Power is the wrench times the link's own twist.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.bodies import cross, dot, named, unit, unit_momentum, unit_wrench
from symgen.symbolic.constraints import folded, spread
from symgen.symbolic.kinematics import (
    ZERO,
    Frame,
    Step,
    Variables,
    Vector,
    frames,
    gravity,
    steps,
    variables,
)
from symgen.symbolic.motion import Motion, Screw, handed_on, motions, screws
from symgen.symbolic.parameters import Parameter, standard_parameters
from symgen.symbolic.passive import reference_unit_wrench, references
from symgen.symbolic.tape import Tape, TapeBuilder

Columns = list[dict[int, sp.Expr]]


@dataclass(frozen=True)
class _Scene:
    """What every regressor starts from; all joints that move, and links, by number."""

    robot: Robot
    variable: Variables
    tape: TapeBuilder
    way: tuple[Step, ...]
    qd: Mapping[int, sp.Expr]
    qdd: Mapping[int, sp.Expr]
    screw: Mapping[int, Mapping[int, Screw]]
    parameters: Sequence[Parameter]

    def close(self, inputs: Sequence[str], *matrices: Columns) -> Tape:
        """Return the tape of some matrices (n, columns), row-major, one after the other."""
        acting = [
            [folded(self.robot, c, f"G{k}_{i}", self.tape) for i, c in enumerate(columns)]
            for k, columns in enumerate(matrices)
        ]
        rows = [
            column.get(j.number, sp.S.Zero)
            for columns in acting
            for j in self.robot.movable
            for column in columns
        ]
        return self.tape.tape([(name, getattr(self.variable, name)) for name in inputs], rows)


def _scene(robot: Robot) -> tuple[_Scene, Mapping[int, Frame], Mapping[int, Motion]]:
    variable = variables(robot)
    symbols = (*variable.q, *variable.qd, *variable.qdd, *variable.qdr, *variable.qddr)
    tape = friction.builder(robot, symbols)
    way = steps(robot, variable, tape)
    numbers = [j.number for j in robot.movable]
    qd = {step.joint.number: step.qd for step in way}
    qdd = spread(robot, dict(zip(numbers, variable.qdd, strict=True)), tape)
    base = gravity(robot, tape)
    screw, parameters = screws(way, tape), standard_parameters(robot)
    scene = _Scene(robot, variable, tape, way, qd, qdd, screw, parameters)
    return scene, frames(way, base, tape), motions(way, base, qdd, tape)


def torque_tape(robot: Robot) -> Tape:
    """Derive the torque regressor, friction included: (n, standard parameters) of q, qd, qdd."""
    scene, _, motion = _scene(robot)
    columns: Columns = []
    for p in scene.parameters:
        if not p.inertial:
            continue
        if p.prefix in names.LINK:
            m = motion[p.joint]
            f, n = unit_wrench(p.prefix, m.w, m.dw, m.a, p.joint, scene.tape)
            columns.append(_projected(scene, p, f, n, "T"))
        else:
            columns.append(_rotor(scene, p, scene.qdd))
    columns += [c for _, c in friction.torque_columns(robot, scene.variable, scene.tape)]
    return scene.close(("q", "qd", "qdd"), columns)


def slotine_li_tape(robot: Robot) -> Tape:
    """Derive the columns of M qddr + C(q, qd) qdr + g + friction(qd): (n, standard parameters)."""
    scene, _, _ = _scene(robot)
    variable, tape = scene.variable, scene.tape
    numbers = [j.number for j in robot.movable]
    qdr, qddr = (
        spread(robot, dict(zip(numbers, symbols, strict=True)), tape)
        for symbols in (variable.qdr, variable.qddr)
    )
    found = references(scene.way, gravity(robot, tape), qdr, qddr, tape)
    columns: Columns = []
    for p in scene.parameters:
        if not p.inertial:
            continue
        if p.prefix in names.LINK:
            f, n = reference_unit_wrench(p.prefix, found[p.joint])
            f, n = (named(v, f"{k}{p.name}_", tape) for v, k in ((f, "f"), (n, "n")))
            columns.append(_projected(scene, p, f, n, "T"))
        else:
            columns.append(_rotor(scene, p, qddr))
    columns += [c for _, c in friction.torque_columns(robot, variable, tape)]
    return scene.close(("q", "qd", "qdr", "qddr"), columns)


def momentum_tape(robot: Robot) -> Tape:
    """Derive the columns of dT/dqd, then those of dL/dq: (n, inertial standard parameters) each."""
    scene, frame, _ = _scene(robot)
    change = _changes(scene, frame)
    momentum: Columns = []
    slope: Columns = []
    for p in scene.parameters:
        if not p.inertial:
            continue
        if p.prefix not in names.LINK:
            momentum.append(_rotor(scene, p, scene.qd))
            slope.append({})
            continue
        here = frame[p.joint]
        lin, ang = unit_momentum(p.prefix, here.w, here.V)
        momentum.append(_projected(scene, p, lin, ang, "Q"))
        slope.append(
            {
                j: scene.tape.name(
                    f"S{p.name}_{j}", _slope(p, here, (lin, ang), s, change[p.joint][j])
                )
                for j, s in scene.screw[p.joint].items()
            }
        )
    return scene.close(("q", "qd"), momentum, slope)


def _slope(p: Parameter, here: Frame, momentum: Screw, screw: Screw, change: Screw) -> sp.Expr:
    """Return dL/dq_j of one unit parameter."""
    (lin, ang), (e, v), (dw, dV) = momentum, screw, change
    total = dot(ang, dw) + dot(lin, dV)
    if p.prefix in names.MOMENT:
        total += dot(unit(names.MOMENT.index(p.prefix)), cross(here.g, e))
    if p.prefix == names.MASS:
        total += dot(here.g, v)
    return total


def _changes(scene: _Scene, frame: Mapping[int, Frame]) -> Mapping[int, Mapping[int, Screw]]:
    """Return (dw, dV) of link i with q_j, by i and j; in frame j they are crosses with z.

    There the joint's own speed makes no difference: it is along z, through the origin.
    """
    own: dict[int, Screw] = {}
    for joint in scene.robot.moving:
        w, V = frame[joint.number].w, frame[joint.number].V
        dw, dV = ((w[1], -w[0], sp.S.Zero), (V[1], -V[0], sp.S.Zero))
        own[joint.number] = (dw, dV) if joint.sigma == names.REVOLUTE else (ZERO, dw)
    return handed_on(scene.way, own, ("I", "J"), scene.tape)


def power_tape(robot: Robot) -> Tape:
    """Derive d/dt of the energy columns, then friction power: (1, standard parameters)."""
    scene, frame, motion = _scene(robot)
    tape = scene.tape
    outputs: list[sp.Expr] = []
    drives = {c.second: friction.drive_speed(c, scene.qd, tape) for c in robot.couplings}
    for p in scene.parameters:
        if not p.inertial:
            continue
        if p.prefix in names.LINK:
            m, V = motion[p.joint], frame[p.joint].V
            f, n = unit_wrench(p.prefix, m.w, m.dw, m.a, p.joint, tape)
            outputs.append(tape.name(f"R{p.name}", dot(f, V) + dot(n, m.w)))
        elif p.prefix == names.ROTOR:
            outputs.append(tape.name(f"R{p.name}", scene.qd[p.joint] * scene.qdd[p.joint]))
        else:
            rate = sum((v * scene.qdd[j] for j, v in _shares(scene, p).items()), sp.S.Zero)
            outputs.append(tape.name(f"R{p.name}", drives[p.joint] * tape.name(f"u{p.name}", rate)))
    outputs += friction.power_columns(robot, scene.variable, tape)
    inputs = [(name, getattr(scene.variable, name)) for name in ("q", "qd", "qdd")]
    return tape.tape(inputs, outputs)


def _projected(scene: _Scene, p: Parameter, f: Vector, n: Vector, tag: str) -> dict[int, sp.Expr]:
    """Project a wrench (or momentum) on the screws of the joints that move the link.

    Parallel axes have one e: then e . n has a name of its own.
    """
    out = {}
    axes = [e for e, _ in scene.screw[p.joint].values()]
    for j, (e, v) in scene.screw[p.joint].items():
        turning = dot(e, n)
        if axes.count(e) > 1:
            turning = scene.tape.name(f"{tag}{p.name}_{j}e", turning)
        out[j] = scene.tape.name(f"{tag}{p.name}_{j}", turning + dot(v, f))
    return out


def _shares(scene: _Scene, p: Parameter) -> dict[int, sp.Expr]:
    """Return du/dqd of the joints that turn the rotor of IA or IAM."""
    if p.prefix == names.ROTOR:
        return {p.joint: sp.S.One}
    coupling = next(c for c in scene.robot.couplings if c.second == p.joint)
    ratio = scene.tape.constant(f"ratio{p.joint}", coupling.ratio)
    return {coupling.first: sp.S.One, p.joint: ratio}


def _rotor(scene: _Scene, p: Parameter, rate: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    """Return the column of a rotor: its share times u' (torque), or times u (momentum)."""
    shares = _shares(scene, p)
    name = f"V{p.name}{rate[p.joint].name.rstrip('0123456789')}"
    u = scene.tape.name(name, sum((s * rate[j] for j, s in shares.items()), sp.S.Zero))
    return {j: scene.tape.name(f"{name}_{j}", s * u) for j, s in shares.items()}
