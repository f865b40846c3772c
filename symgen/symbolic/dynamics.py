"""Inverse and forward dynamics and their parts, in base parameters X.

Inverse dynamics by Newton and Euler in link frames (Luh, Walker and Paul 1980, in the base
parameters of Khalil and Kleinfinger 1987); the mass matrix by composite bodies (Walker and Orin
1982); Coriolis by a second, virtual velocity, with the factor of Christoffel symbols, which keeps
M' - 2 C skew-symmetric (Niemeyer and Slotine 1991, in body coordinates)

    f = M a_r + dw_r x m + w_r x (w x m)
    n = m x a_r + J dw_r + w x ((J - tr(J)/2) w_r)

forward dynamics by M = L D L^T without square roots.
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
    symbols = (*variable.q, *variable.qd, *variable.qdd, *variable.tau, *X)
    tape = friction.builder(robot, symbols)
    return Plant(robot, base, tape, steps(robot, variable, tape), gravity(robot, tape), X)


def inverse_dynamics(p: Plant, *, accelerating: bool = True) -> dict[int, sp.Expr]:
    """Return the torque of every movable joint; without acceleration: C qd + g + friction.

    Effects of the load take the rigid body's torque, rotors included, as it is at this motion.
    """
    torque = _rigid_torques(p, accelerating)
    if p.robot.loaded:
        load = {j: p.tape.name(f"taur{j}", value) for j, value in torque.items()}
        torque = dict(load)
        for name, column in effect_columns(p.robot, p.tape, load).items():
            for j, value in column.items():
                torque[j] += p.value(name) * value
    for j, value in _friction_torques(p).items():
        torque[j] += value
    return {j: p.tape.name(f"T{j}", value) for j, value in torque.items()}


def _rigid_torques(p: Plant, accelerating: bool) -> dict[int, sp.Expr]:
    """Return the torque of links and rotors, by joint that moves."""
    qdd = dict(zip(p.numbers, variables(p.robot).qdd, strict=True)) if accelerating else {}
    torque = _body_torques(p, spread(p.robot, qdd, p.tape) if accelerating else {})
    for j, coefficient in _rotors(p).items():
        for k, value in coefficient.items():
            torque[j] += value * qdd.get(k, sp.S.Zero)
    return torque


def _friction_torques(p: Plant) -> dict[int, sp.Expr]:
    """Return the torque of friction and effects with columns, by joint."""
    torque: dict[int, sp.Expr] = {}
    for parameter, column in friction.torque_columns(p.robot, variables(p.robot), p.tape):
        for j, value in column.items():
            torque[j] = torque.get(j, sp.S.Zero) + p.value(parameter.name) * value
    return torque


def gravity_torque(p: Plant) -> dict[int, sp.Expr]:
    """Return the torque that holds the arm at rest."""
    return _body_torques(p.still(), {})


def _body_torques(p: Plant, qdd: Mapping[int, sp.Expr]) -> dict[int, sp.Expr]:
    motion = motions(p.way, p.gravity, qdd, p.tape)
    wrench = {
        j.number: p.inertia(j.number).wrench(
            motion[j.number].w, motion[j.number].dw, motion[j.number].a, j.number, p.tape
        )
        for j in p.robot.joints
    }
    return folded(p.robot, _to_joints(p, wrench, ""), "Tf", p.tape)


def _to_joints(p: Plant, wrench: Wrenches, tag: str) -> dict[int, sp.Expr]:
    """Hand wrenches on links back towards the base; return what each movable joint carries."""
    total = dict(wrench)
    torque = {}
    for step in reversed(p.way):
        j, a = step.joint.number, step.joint.antecedent
        f, n = total.get(j, (ZERO, ZERO))
        if step.joint.sigma == names.REVOLUTE:
            torque[j] = n[2]
        elif step.joint.sigma == names.PRISMATIC:
            torque[j] = f[2]
        if a != 0:
            back = handed_back((f, n), step, f"b{tag}", p.tape)
            old = total.get(a, (ZERO, ZERO))
            total[a] = (
                named(plus(old[0], back[0]), f"F{tag}s{a}_{j}_", p.tape),
                named(plus(old[1], back[1]), f"N{tag}s{a}_{j}_", p.tape),
            )
    return torque


def _rotors(p: Plant) -> Rows:
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
    rows = _rotors(p)
    for step in p.way:
        j, body = step.joint.number, bodies[step.joint.number]
        if step.joint.sigma == names.FIXED:
            continue
        mx, my, _ = body.m
        if step.joint.sigma == names.REVOLUTE:  # momentum of a unit turn about z
            f, n = (-my, mx, sp.S.Zero), (body.J[0][2], body.J[1][2], body.J[2][2])
        else:
            f, n = (sp.S.Zero, sp.S.Zero, body.M), (my, -mx, sp.S.Zero)
        for k, value in _to_joints(p, {j: (f, n)}, f"m{j}").items():
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
            wrench[i] = _coriolis_wrench(
                p.inertia(i), real[i].w, w_r, dw_r, a_r, f"{i}v{j}", p.tape
            )
        for k, value in _to_joints(p, wrench, f"c{j}").items():
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


def _coriolis_wrench(
    body: Inertia, w: Vector, w_r: Vector, dw_r: Vector, a_r: Vector, tag: str, tape: TapeBuilder
) -> Screw:
    wm = named(cross(w, body.m), f"h{tag}_", tape)
    f = plus(plus(cross(dw_r, body.m), cross(w_r, wm)), scaled(body.M, a_r))
    k = named(body.less_half_trace(tag, tape).times(w_r), f"k{tag}_", tape)
    n = plus(plus(cross(body.m, a_r), body.times(dw_r)), cross(w, k))
    return named(f, f"F{tag}_", tape), named(n, f"N{tag}_", tape)


def _driving(p: Plant) -> tuple[dict[int, sp.Expr], list[sp.Expr]]:
    """Return M qdd of every movable joint, and what must be positive for it to be unique.

    Effects of the load are z (a taur + b |taur|), with a and b of the motion: from R = tau -
    friction = (1 + z a) taur + z b |taur| follows taur = R / (1 + z a + z b sign(R)) where this is
    positive for both signs.
    """
    tape, order, commanded = p.tape, p.numbers, variables(p.robot).tau
    if not p.robot.loaded:
        bias = inverse_dynamics(p, accelerating=False)
        pairs = zip(order, commanded, strict=True)
        return {j: tape.name(f"b{j}", tau - bias[j]) for j, tau in pairs}, []
    rigid, rubbing = _rigid_torques(p, False), _friction_torques(p)
    slopes = []  # of the effects by taur, for taur > 0 and for taur < 0
    for sign in (sp.S.One, sp.S.NegativeOne):
        slope: dict[int, sp.Expr] = {}
        for name, column in effect_columns(p.robot, tape, dict.fromkeys(order, sign)).items():
            for j, value in column.items():
                slope[j] = slope.get(j, sp.S.Zero) + sign * p.value(name) * value
        slopes.append({j: tape.name(f"e{j}", value) for j, value in slope.items()})
    right, positive = {}, []
    for j, tau in zip(order, commanded, strict=True):
        left = tape.name(f"R{j}", tau - rubbing.get(j, sp.S.Zero))
        if j in slopes[0] or j in slopes[1]:
            up, down = (s.get(j, sp.S.Zero) for s in slopes)
            half = sp.Rational(1, 2)
            mean, spread_ = (
                tape.name(f"{n}{j}", half * e) for n, e in (("a", up + down), ("B", up - down))
            )
            turned_ = tape.name(f"G{j}", sp.sign(left))
            share = tape.name(f"E{j}", 1 + mean + spread_ * turned_)
            positive += [tape.name(f"P{j}", 1 + e) for e in (up, down)]
            left = left * tape.name(f"I{j}", 1 / share)
        right[j] = tape.name(f"b{j}", left - rigid[j])
    return right, positive


def forward_dynamics(p: Plant) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Return (qdd, pivots): M is positive definite exactly when all pivots of L D L^T are.

    Beside the pivots stand what must be positive for effects of the load to be solvable.
    """
    M, tape = mass_matrix(p), p.tape
    order = p.numbers
    right, positive = _driving(p)
    low: dict[tuple[int, int], sp.Expr] = {}
    pivot: dict[int, sp.Expr] = {}
    inverse: dict[int, sp.Expr] = {}
    # Factor from the tips: then L keeps the zeros of separate branches (Featherstone 2005).
    for at, k in enumerate(reversed(order)):
        earlier = order[: len(order) - 1 - at]
        pivot[k] = M[k].get(k, sp.S.Zero)
        inverse[k] = tape.name(f"d{k}", 1 / pivot[k])
        for i in earlier:
            if M[k].get(i, sp.S.Zero) != 0:
                low[k, i] = tape.name(f"l{k}_{i}", M[k][i] * inverse[k])
        for i in earlier:
            if (k, i) not in low:
                continue
            for j in order[: order.index(i) + 1]:
                if (k, j) in low:
                    value = M[i].get(j, sp.S.Zero) - low[k, i] * M[k][j]
                    M[i][j] = M[j][i] = tape.name(f"m{k}_{i}_{j}", value)
    # M = L^T D L: solve L^T y = right from the tips, then D, then L from the base.
    y = dict(right)
    for k in reversed(order):
        for i in order:
            if (k, i) in low:
                y[i] = tape.name(f"y{k}_{i}", y[i] - low[k, i] * y[k])
    out: dict[int, sp.Expr] = {}
    for k in order:
        value = y[k] * inverse[k]
        for i in order:
            if (k, i) in low:
                value -= low[k, i] * out[i]
        out[k] = tape.name(f"o{k}", value)
    # Guards in the order of the elimination: what follows a bad pivot has no meaning.
    return [out[k] for k in order], [*positive, *(pivot[k] for k in reversed(order))]


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
