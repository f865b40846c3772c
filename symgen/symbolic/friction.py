"""Friction, drives and effects: columns of torque and of power.

tau_j = FS sign(qd_j) + FV qd_j + OF. A declared width replaces |qd| by qd tanh(qd/width). A
coupling u = qd_j + ratio qd_k adds F = FVM u + FSM sign(u) to joint j and ratio F to joint k. Power
is the sum of qd_j times the column of joint j: FS |qd_j| + FV qd_j^2 + OF qd_j.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.robot.tables import Coupling
from symgen.robot.types import Robot
from symgen.symbolic.constraints import ByJoint, Rows
from symgen.symbolic.effects import effect_columns
from symgen.symbolic.kinematics import arrays, builder, variables
from symgen.symbolic.parameters import Parameter, standard_parameters
from symgen.symbolic.tape import Tape, TapeBuilder


@dataclass(frozen=True)
class _Drive:
    """The speed of a friction parameter, and the share of each joint in its force."""

    speed: sp.Expr
    share: ByJoint
    width: float


def drive_speed(coupling: Coupling, speed: ByJoint, tape: TapeBuilder) -> sp.Expr:
    """Return u = qd_j + ratio qd_k as a named step."""
    terms = (share * speed[j] for j, share in drive_shares(coupling, tape).items())
    return tape.name(f"u{coupling.second}", sp.Add(*terms))


def drive_shares(coupling: Coupling, tape: TapeBuilder) -> ByJoint:
    """Return du/dqd of the joints that a coupled drive moves."""
    ratio = tape.constant(f"ratio{coupling.second}", coupling.ratio)
    return {coupling.first: sp.S.One, coupling.second: ratio}


def friction_power_tape(robot: Robot) -> Tape:
    """Derive the power column of every friction parameter: the integrands of the energy theorem."""
    tape = builder(robot)
    return tape.tape(arrays(robot, "q", "qd"), power_columns(robot, tape))


def power_columns(robot: Robot, tape: TapeBuilder) -> list[sp.Expr]:
    """Return the power of every friction parameter."""
    outputs = []
    for p, drive in _drives(robot, tape):
        v, sharp = drive.speed, p.prefix in ("FS", "FSM") and not drive.width
        power = sp.Abs(v) if sharp else v * _force(p, drive, tape)[0]
        outputs.append(tape.name(f"D{p.name}", power))
    speed = variables(robot, "qd")
    for name, column in effect_columns(robot, tape).items():
        power = sum((speed[j] * c for j, c in column.items()), sp.S.Zero)
        outputs.append(tape.name(f"D{name}", power))
    return outputs


def friction_torque_tape(robot: Robot) -> Tape:
    """Derive the torque columns of every friction parameter: n rows, row-major."""
    tape = builder(robot)
    columns = [column for _, column in friction_torque_columns(robot, tape)]
    outputs = [c.get(j.number, sp.S.Zero) for j in robot.movable for c in columns]
    return tape.tape(arrays(robot, "q", "qd"), outputs)


def friction_torque_columns(robot: Robot, tape: TapeBuilder) -> list[tuple[Parameter, ByJoint]]:
    """Return the torque of every friction parameter on each of its joints."""
    out = []
    for p, drive in _drives(robot, tape):
        force, _ = _force(p, drive, tape)
        named = {j: tape.name(f"D{p.name}_{j}", c * force) for j, c in drive.share.items()}
        out.append((p, named))
    effects = effect_columns(robot, tape)
    known = {p.name: p for p in standard_parameters(robot)}
    return out + [(known[name], column) for name, column in effects.items()]


def friction_torque_slopes(robot: Robot, tape: TapeBuilder) -> list[tuple[Parameter, Rows]]:
    """Return d(torque on j)/dqd_k of friction parameters by j and k, if it is not zero."""
    out = []
    for p, drive in _drives(robot, tape):
        _, slope = _force(p, drive, tape)
        if slope == 0:
            continue
        slope = tape.name(f"z{p.name}", slope)
        rows: Rows = {j: {} for j in drive.share}
        for j, a in drive.share.items():
            for k, b in drive.share.items():
                rows[j][k] = tape.name(f"z{p.name}_{j}_{k}", a * b * slope)
        out.append((p, rows))
    return out


def _drives(robot: Robot, tape: TapeBuilder) -> list[tuple[Parameter, _Drive]]:
    speed = variables(robot, "qd")
    coupled = {
        c.second: _Drive(
            drive_speed(c, speed, tape),
            drive_shares(c, tape),
            robot.joint(c.second).coulomb_width,
        )
        for c in robot.couplings
    }
    out = []
    for p in standard_parameters(robot):
        if p.inertial or not p.prefix:
            continue
        if p.prefix in names.COUPLING_FRICTION:
            out.append((p, coupled[p.joint]))
        else:
            width = robot.joint(p.joint).coulomb_width
            out.append((p, _Drive(speed[p.joint], {p.joint: sp.S.One}, width)))
    return out


def _force(p: Parameter, drive: _Drive, tape: TapeBuilder) -> tuple[sp.Expr, sp.Expr]:
    """Return the force 1, v or sign(v), and its slope over v.

    A declared width gives tanh(v/width) instead of sign(v). sign(v) has the slope 0.
    """
    if p.prefix == "OF":
        return sp.S.One, sp.S.Zero
    if p.prefix in ("FV", "FVM"):
        return drive.speed, sp.S.One
    if not drive.width:
        return tape.name(f"s{p.name}", sp.sign(drive.speed)), sp.S.Zero
    inverse = tape.constant(f"k{p.name}", 1 / sp.Rational(repr(drive.width)))
    scaled = tape.name(f"x{p.name}", drive.speed * inverse)
    smooth = tape.name(f"s{p.name}", sp.tanh(scaled))
    return smooth, inverse * (1 - smooth * smooth)
