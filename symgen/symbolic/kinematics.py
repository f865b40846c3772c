"""Velocity, gravity and height of every link, by recursion in link frames.

The modified Denavit-Hartenberg transform is a product of six elementary motions along and about
z and x; the recursion applies them one by one to the state of a frame

    w  angular velocity of the frame, in the frame                       [rad/s]
    V  velocity of its origin, in the frame                              [m/s]
    g  acceleration of gravity, in the frame                             [m/s2]
    u  potential energy of a unit mass at the origin, -g . 0P            [J/kg]

so that jw_j = jA_a aw_a + sigmabar z qd and jV_j = jA_a (aV_a + aw_a x aP_j) + sigma z qd
(Khalil and Kleinfinger 1987; a is the antecedent of j). Zeros and signs of the geometry vanish
while the steps are written, and every step has a name.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symgen import names
from symgen.robot.types import Joint, Robot
from symgen.symbolic.tape import TapeBuilder

Vector = tuple[sp.Expr, sp.Expr, sp.Expr]
ZERO: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)


@dataclass(frozen=True)
class Frame:
    """State of one link frame, in that frame."""

    w: Vector
    V: Vector
    g: Vector
    u: sp.Expr


@dataclass(frozen=True)
class Variables:
    """The symbols of the joint variables, one for each movable joint, in file order."""

    q: tuple[sp.Symbol, ...]
    qd: tuple[sp.Symbol, ...]


def variables(robot: Robot) -> Variables:
    """Return q and qd as symbols that carry the file's joint numbers."""
    numbers = [joint.number for joint in robot.movable]
    return Variables(
        tuple(sp.Symbol(f"q{j}", real=True) for j in numbers),
        tuple(sp.Symbol(f"qd{j}", real=True) for j in numbers),
    )


def frames(robot: Robot, variable: Variables, tape: TapeBuilder) -> tuple[Frame, ...]:
    """Derive the state of every link frame, fixed links included, in file order.

    Args:
        robot: the mechanism.
        variable: the symbols of q and qd.
        tape: takes the named steps.
    """
    gx, gy, gz = (
        tape.constant(f"g{axis}", g) for axis, g in zip("xyz", robot.gravity, strict=True)
    )
    states = [Frame(ZERO, ZERO, (gx, gy, gz), sp.S.Zero)]
    index = {joint.number: i for i, joint in enumerate(robot.movable)}
    for joint in robot.joints:
        i = index.get(joint.number)
        q = sp.S.Zero if i is None else variable.q[i]
        qd = sp.S.Zero if i is None else variable.qd[i]
        states.append(_next(states[joint.antecedent], joint, q, qd, tape))
    return tuple(states[1:])


def _next(frame: Frame, joint: Joint, q: sp.Expr, qd: sp.Expr, tape: TapeBuilder) -> Frame:
    """Apply the six elementary motions of a joint, then its own velocity."""
    j = joint.number
    revolute, prismatic = joint.sigma == names.REVOLUTE, joint.sigma == names.PRISMATIC
    frame = _rotate(frame, 2, *_angle(joint.gamma, f"gamma{j}", tape), f"a{j}", tape)
    frame = _translate(frame, 2, tape.constant(f"b{j}", joint.b), f"b{j}", tape)
    frame = _rotate(frame, 0, *_angle(joint.alpha, f"alpha{j}", tape), f"c{j}", tape)
    frame = _translate(frame, 0, tape.constant(f"d{j}", joint.d), f"d{j}", tape)
    if revolute:
        c, s = _joint_angle(q, joint.theta, j, tape)
    else:
        c, s = _angle(joint.theta, f"theta{j}", tape)
    frame = _rotate(frame, 2, c, s, f"e{j}", tape)
    r = tape.constant(f"r{j}", joint.r)
    if prismatic:
        r = tape.name(f"R{j}", q + r)
    frame = _translate(frame, 2, r, f"r{j}", tape)
    w, V = frame.w, frame.V
    if revolute:
        w = (w[0], w[1], tape.name(f"W3{j}", w[2] + qd))
    if prismatic:
        V = (V[0], V[1], tape.name(f"V3{j}", V[2] + qd))
    return Frame(w, V, frame.g, frame.u)


def _angle(angle: sp.Expr, name: str, tape: TapeBuilder) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of a constant angle, as constants of the tape."""
    c, s = cosine_sine(angle)
    return tape.constant(f"C{name}", c), tape.constant(f"S{name}", s)


def cosine_sine(angle: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of a constant angle, in radicals only where these are plain.

    cos(pi/8) is kept as it is: as sqrt(2 + sqrt(2))/2 its sign would no longer belong to that of
    sin(pi/8) where radicals are taken modulo a prime.
    """
    both = sp.cos(angle), sp.sin(angle)
    if any(not p.base.is_Rational for e in both for p in e.atoms(sp.Pow) if not p.exp.is_Integer):
        return sp.cos(angle, evaluate=False), sp.sin(angle, evaluate=False)
    return both


def _joint_angle(q: sp.Expr, offset: sp.Expr, j: int, tape: TapeBuilder) -> tuple[sp.Expr, sp.Expr]:
    """Return cosine and sine of q + offset; quarter turns vanish into signs and swaps."""
    quarter = offset * 2 / sp.pi
    if quarter.is_Integer:
        c, s = tape.name(f"C{j}", sp.cos(q)), tape.name(f"S{j}", sp.sin(q))
        return ((c, s), (-s, c), (-c, -s), (s, -c))[int(quarter) % 4]
    angle = tape.name(f"t{j}", q + tape.constant(f"theta{j}", offset))
    return tape.name(f"C{j}", sp.cos(angle)), tape.name(f"S{j}", sp.sin(angle))


def _rotate(frame: Frame, axis: int, c: sp.Expr, s: sp.Expr, tag: str, tape: TapeBuilder) -> Frame:
    """Express a frame's state in axes turned by an angle about x (axis 0) or z (axis 2)."""
    if c == 1:
        return frame
    a, b = (axis + 1) % 3, (axis + 2) % 3

    def turned(vector: Vector, letter: str) -> Vector:
        out = list(vector)
        out[a] = tape.name(f"{letter}{a + 1}{tag}", c * vector[a] + s * vector[b])
        out[b] = tape.name(f"{letter}{b + 1}{tag}", c * vector[b] - s * vector[a])
        return (out[0], out[1], out[2])

    return Frame(turned(frame.w, "W"), turned(frame.V, "V"), turned(frame.g, "G"), frame.u)


def _translate(frame: Frame, axis: int, length: sp.Expr, tag: str, tape: TapeBuilder) -> Frame:
    """Move the origin along x (axis 0) or z (axis 2): V += w x P, u -= g . P."""
    if length == 0:
        return frame
    a, b = (axis + 1) % 3, (axis + 2) % 3
    V = list(frame.V)
    V[a] = tape.name(f"V{a + 1}{tag}", V[a] + frame.w[b] * length)
    V[b] = tape.name(f"V{b + 1}{tag}", V[b] - frame.w[a] * length)
    u = tape.name(f"U{tag}", frame.u - frame.g[axis] * length)
    return Frame(frame.w, (V[0], V[1], V[2]), frame.g, u)
