"""Inverse and forward dynamics and their parts, in base parameters X.

Inverse dynamics by Newton and Euler in link frames (Luh, Walker and Paul 1980, in the base
parameters of Khalil and Kleinfinger 1987); the mass matrix by composite bodies (Walker and Orin
1982); Coriolis by a second, virtual velocity, with the factor of Christoffel symbols, which keeps
M' - 2 C skew-symmetric (Niemeyer and Slotine 1991, in body coordinates)

    f = M a_r + dw_r x m + w_r x (w x m)
    n = m x a_r + J dw_r + w x ((J - tr(J)/2) w_r).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symgen import names
from symgen.robot.types import Robot
from symgen.symbolic import friction
from symgen.symbolic.base_parameters import BaseParameters
from symgen.symbolic.bodies import Inertia, cross, named, plus, scaled
from symgen.symbolic.composite import composites
from symgen.symbolic.constraints import Rows, congruent, folded, spread
from symgen.symbolic.effects import effect_columns
from symgen.symbolic.energy import half_square, link_column
from symgen.symbolic.kinematics import (
    ZERO,
    Step,
    Turn,
    Vector,
    frames,
    gravity,
    steps,
    turned,
    variables,
)
from symgen.symbolic.motion import Screw, carried, handed_back, motions
from symgen.symbolic.tape import Tape, TapeBuilder

Wrenches = dict[int, Screw]


@dataclass(frozen=True)
class Plant:
    """A robot with symbols for its base parameters, and the way to its joints."""

    robot: Robot
    base: BaseParameters
    tape: TapeBuilder
    way: tuple[Step, ...]
    gravity: Vector
    X: tuple[sp.Symbol, ...]

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of the movable joints."""
        return tuple(j.number for j in self.robot.movable)

    def value(self, name: str) -> sp.Expr:
        """Return the symbol of the base parameter led by a standard one; 0 where there is none."""
        for symbol, p in zip(self.X, self.base.parameters, strict=True):
            if p.head == name:
                return symbol
        return sp.S.Zero

    def inertia(self, joint: int) -> Inertia:
        """Return the body of a link in base parameters."""
        return Inertia({prefix: self.value(f"{prefix}{joint}") for prefix in names.LINK})

    def still(self) -> Plant:
        """Return the same plant with all speeds zero."""
        return replace(self, way=tuple(s.still() for s in self.way))

    def close(
        self, inputs: Sequence[str], outputs: Sequence[sp.Expr], inertial: bool = False
    ) -> Tape:
        """Return the tape; X comes last, its inertial part alone where the rest is not read."""
        variable = variables(self.robot)
        X = self.X[: self.base.inertial] if inertial else self.X
        arrays = [(name, getattr(variable, name)) for name in inputs]
        return self.tape.tape([*arrays, ("X", X)], outputs)


def plant(robot: Robot, base: BaseParameters) -> Plant:
    """Begin a tape of a robot in its base parameters."""
    variable = variables(robot)
    X = tuple(sp.Symbol(f"X_{p.name}", real=True) for p in base.parameters)
    arrays = (variable.q, variable.qd, variable.qdd, variable.tau, variable.qdr, variable.qddr)
    symbols = (*(s for array in arrays for s in array), *variable.b, *X)
    tape = friction.builder(robot, symbols)
    return Plant(robot, base, tape, steps(robot, variable, tape), gravity(robot, tape), X)


def inverse_dynamics(p: Plant, *, accelerating: bool = True) -> dict[int, sp.Expr]:
    """Return the torque of every movable joint; without acceleration: C qd + g + friction.

    Effects of the load take the rigid body's torque, rotors included, as it is at this motion.
    """
    qdd = dict(zip(p.numbers, variables(p.robot).qdd, strict=True)) if accelerating else {}
    return in_all(p, rigid_torques(p, qdd))


def in_all(p: Plant, rigid: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    """Return the torque of the rigid body with that of friction and effects."""
    load = loads(p, rigid)
    torque = {j: load[j] + value for j, value in with_load(p, load).items()}
    return {j: p.tape.name(f"T{j}", value) for j, value in torque.items()}


def loads(p: Plant, rigid: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    """Return the torque of the rigid body, named where effects depend on it."""
    if not p.robot.loaded:
        return dict(rigid)
    return {j: p.tape.name(f"taur{j}", value) for j, value in rigid.items()}


def with_load(p: Plant, load: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    """Return the torque of effects under a load of the rigid body, and of friction, by joint."""
    torque = dict.fromkeys(load, sp.S.Zero)
    if p.robot.loaded:
        for name, column in effect_columns(p.robot, p.tape, load).items():
            for j, value in column.items():
                torque[j] += p.value(name) * value
    for j, value in friction_torques(p).items():
        torque[j] += value
    return torque


def rigid_torques(p: Plant, qdd: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    """Return the torque of links and rotors at accelerations of the movable joints; none: zero."""
    torque = _body_torques(p, spread(p.robot, qdd, p.tape) if qdd else {})
    for j, coefficient in rotors(p).items():
        for k, value in coefficient.items():
            torque[j] += value * qdd.get(k, sp.S.Zero)
    return torque


def friction_torques(p: Plant) -> dict[int, sp.Expr]:
    """Return the torque of friction and effects with columns, by joint."""
    torque: dict[int, sp.Expr] = {}
    for parameter, column in friction.torque_columns(p.robot, variables(p.robot), p.tape):
        for j, value in column.items():
            torque[j] = torque.get(j, sp.S.Zero) + p.value(parameter.name) * value
    return torque


def joint_friction(p: Plant) -> dict[int, sp.Expr]:
    """Return the torque of the friction that joints and couplings declare, by joint."""
    torque = dict.fromkeys(p.numbers, sp.S.Zero)
    for parameter, column in friction.torque_columns(p.robot, variables(p.robot), p.tape):
        if parameter.prefix:  # effects have none
            for j, value in column.items():
                torque[j] += p.value(parameter.name) * value
    return {j: p.tape.name(f"T{j}", value) for j, value in torque.items()}


def gravity_torque(p: Plant) -> dict[int, sp.Expr]:
    """Return the torque that holds the arm at rest."""
    return _body_torques(p.still(), {})


def wrenches(p: Plant, qdd: Mapping[int, sp.Expr]) -> Wrenches:
    """Return what moves each link, at accelerations of all joints that move."""
    motion = motions(p.way, p.gravity, qdd, p.tape)
    return {
        j.number: p.inertia(j.number).wrench(
            motion[j.number].w, motion[j.number].dw, motion[j.number].a, j.number, p.tape
        )
        for j in p.robot.joints
    }


def _body_torques(p: Plant, qdd: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    wrench = wrenches(p, qdd)
    return folded(p.robot, to_joints(p, wrench, ""), "Tf", p.tape)


def handed_down(p: Plant, wrench: Wrenches, tag: str) -> Wrenches:
    """Hand wrenches on links back towards the base: what each joint carries, in its frame."""
    total = dict(wrench)
    for step in reversed(p.way):
        j, a = step.joint.number, step.joint.antecedent
        if a != 0 and j in total:
            back = handed_back(total[j], step, f"b{tag}", p.tape)
            old = total.get(a, (ZERO, ZERO))
            total[a] = (
                named(plus(old[0], back[0]), f"F{tag}s{a}_{j}_", p.tape),
                named(plus(old[1], back[1]), f"N{tag}s{a}_{j}_", p.tape),
            )
    return total


def to_joints(p: Plant, wrench: Wrenches, tag: str) -> dict[int, sp.Expr]:
    """Return the force or torque that wrenches on links put on each joint that moves."""
    total = handed_down(p, wrench, tag)
    return {
        joint.number: along(joint.sigma, total.get(joint.number, (ZERO, ZERO)))
        for joint in p.robot.moving
    }


def along(sigma: int, wrench: Screw) -> sp.Expr:
    """Return the part of a wrench, in the frame of a joint, that the joint's drive sees."""
    f, n = wrench
    return n[2] if sigma == names.REVOLUTE else f[2]


def rotors(p: Plant) -> Rows:
    """Return what rotors add to the mass matrix."""
    rows: Rows = {j.number: {} for j in p.robot.moving}
    for j in p.numbers:
        rows[j][j] = p.value(f"{names.ROTOR}{j}")
    for c in p.robot.couplings:
        inertia = p.value(f"{names.COUPLING_INERTIA}{c.second}")
        ratio = p.tape.constant(f"ratio{c.second}", c.ratio)
        share = {c.first: sp.S.One, c.second: ratio}
        for j, x in share.items():
            for k, y in share.items():
                rows[j][k] = rows[j].get(k, sp.S.Zero) + inertia * x * y
    return rows


def mass_matrix(p: Plant) -> Rows:
    """Return M by rows and columns of joint numbers; entries of separate branches are absent."""
    bodies = composites(p.way, {j.number: p.inertia(j.number) for j in p.robot.joints}, p.tape)
    rows = rotors(p)
    for step in p.way:
        j, body = step.joint.number, bodies[step.joint.number]
        if step.joint.sigma == names.FIXED:
            continue
        mx, my, _ = body.m
        if step.joint.sigma == names.REVOLUTE:  # momentum of a unit turn about z
            f, n = (-my, mx, sp.S.Zero), (body.J[0][2], body.J[1][2], body.J[2][2])
        else:
            f, n = (sp.S.Zero, sp.S.Zero, body.M), (my, -mx, sp.S.Zero)
        for k, value in to_joints(p, {j: (f, n)}, f"m{j}").items():
            if value != 0:
                for a, b in {(j, k), (k, j)}:
                    rows[a][b] = rows[a].get(b, sp.S.Zero) + value
    rows = {
        j: {k: p.tape.name(f"M{min(j, k)}_{max(j, k)}", v) for k, v in row.items()}
        for j, row in rows.items()
    }
    return congruent(p.robot, rows, "M", p.tape)


def coriolis(p: Plant) -> Rows:
    """Return C by rows and columns of joint numbers: C qd are the torques, M' - 2 C is skew."""
    real = motions(p.way, ZERO, {}, p.tape)
    rows: Rows = {j.number: {} for j in p.robot.moving}
    for j in rows:
        wrench: Wrenches = {}
        for i, (w_r, dw_r, a_r) in _virtual(p, j).items():
            wrench[i] = virtual_wrench(p.inertia(i), real[i].w, w_r, dw_r, a_r, f"{i}v{j}", p.tape)
        for k, value in to_joints(p, wrench, f"c{j}").items():
            rows[k][j] = p.tape.name(f"C{k}_{j}", value)
    return congruent(p.robot, rows, "C", p.tape)


def _virtual(p: Plant, j: int) -> dict[int, tuple[Vector, Vector, Vector]]:
    """Return, for the links behind joint j, w_r, dw_r and a_r of a unit speed of j alone."""
    real = motions(p.way, ZERO, {}, p.tape)
    states: dict[int, tuple[Vector, Vector, Vector]] = {}
    for step in p.way:
        number, a = step.joint.number, step.joint.antecedent
        if number != j and a not in states:
            continue
        w = real[a].w
        w_r, dw_r, a_r = states.get(a, (ZERO, ZERO, ZERO))
        for motion in step.before:
            if isinstance(motion, Turn):
                w_r = turned(w_r, motion, f"E{j}_", p.tape)
                dw_r = turned(dw_r, motion, f"e{j}_", p.tape)
                a_r = turned(a_r, motion, f"l{j}_", p.tape)
                w = turned(w, motion, "W", p.tape)
            else:
                a_r = carried(a_r, w, dw_r, w_r, motion, p.tape, f"l{j}_")
        w = real[number].w
        turning = (w[1], -w[0], sp.S.Zero)  # w x z: how the axis itself turns
        if number == j and step.joint.sigma == names.REVOLUTE:
            w_r, dw_r = (sp.S.Zero, sp.S.Zero, sp.S.One), turning
        for shift in step.after:
            a_r = carried(a_r, w, dw_r, w_r, shift, p.tape, f"l{j}_")
        if step.joint.sigma == names.PRISMATIC:
            own = turning if number == j else ZERO
            passing = (w_r[1] * step.qd, -w_r[0] * step.qd, sp.S.Zero)
            a_r = named(plus(plus(a_r, own), passing), f"l{j}p{number}_", p.tape)
        states[number] = (w_r, dw_r, a_r)
    return states


def virtual_wrench(
    body: Inertia, w: Vector, w_r: Vector, dw_r: Vector, a_r: Vector, tag: str, tape: TapeBuilder
) -> Screw:
    """Return (f, n) of a body that moves with w, under the virtual motion (w_r, dw_r, a_r)."""
    wm = named(cross(w, body.m), f"h{tag}_", tape)
    f = plus(plus(cross(dw_r, body.m), cross(w_r, wm)), scaled(body.M, a_r))
    k = named(body.less_half_trace(tag, tape).times(w_r), f"k{tag}_", tape)
    n = plus(plus(cross(body.m, a_r), body.times(dw_r)), cross(w, k))
    return named(f, f"F{tag}_", tape), named(n, f"N{tag}_", tape)


def dense(rows: Rows, numbers: Sequence[int]) -> list[sp.Expr]:
    """Return a matrix over joint numbers, row-major."""
    return [rows[j].get(k, sp.S.Zero) for j in numbers for k in numbers]


def energies(p: Plant) -> list[sp.Expr]:
    """Return kinetic and potential energy of a robot in its base parameters, J."""
    variable, tape = variables(p.robot), p.tape
    still = tuple(step.still() for step in p.way)
    moving, resting = frames(p.way, ZERO, tape), frames(still, p.gravity, tape)
    speed = friction.speeds(p.robot, variable)
    drives = {c.second: friction.drive_speed(c, speed, tape) for c in p.robot.couplings}
    total = {"T": sp.S.Zero, "U": sp.S.Zero}
    for symbol, base in zip(p.X, p.base.parameters, strict=True):
        if not base.inertial:
            continue
        standard = p.base.standard[base.index]
        joint, prefix = standard.joint, standard.prefix
        if prefix in names.LINK:
            name = f"D{prefix}{joint}"
            total["T"] += symbol * link_column(prefix, moving[joint], name, tape)
            total["U"] += symbol * link_column(prefix, resting[joint], f"U{prefix}{joint}", tape)
        else:
            v = speed[joint] if prefix == names.ROTOR else drives[joint]
            total["T"] += symbol * half_square(v, standard.name, tape)
    return [tape.name(f"{letter}sum", value) for letter, value in total.items()]
